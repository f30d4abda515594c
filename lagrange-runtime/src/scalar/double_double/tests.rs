//! Arithmetic and elementary functions over their whole range.

#![allow(clippy::excessive_precision)]

use super::*;
use astro_float_num::{BigFloat, Consts, Radix, RoundingMode};

/// `|found − exact|` and `|exact|`, of 60 digits.
fn missed(found: Double, exact: &str, constants: &mut Consts) -> (f64, f64) {
    const BITS: usize = 1400;
    let rounding = RoundingMode::ToEven;
    let exact = BigFloat::parse(exact, Radix::Dec, BITS, rounding, constants);
    // BigFloat misreads subnormal numbers.
    let shift = BigFloat::from_f64(Double::ONE.scaled(200).hi, BITS);
    let [hi, lo] = [found.hi, found.lo].map(|x| match x.abs() < 1e-200 {
        true => BigFloat::from_f64(Double::from(x).scaled(200).hi, BITS).div(&shift, BITS, rounding),
        false => BigFloat::from_f64(x, BITS),
    });
    let missed = hi.add(&lo, BITS, rounding).sub(&exact, BITS, rounding);
    (size(&missed), size(&exact))
}

/// `|x|` but for an error of 2⁻⁶³.
fn size(x: &BigFloat) -> f64 {
    match x.as_raw_parts() {
        Some((words, _, _, exponent, _)) if !x.is_zero() => {
            let top = *words.last().expect("a number has words") as f64;
            Double::from(top).scaled((exponent - 64).max(-2000)).hi
        }
        _ => 0.0,
    }
}

type Named = (&'static str, fn(Double) -> Double);

/// Functions of one argument.
const FUNCTIONS: [Named; 21] = [
    ("sin", Functions::sin),
    ("cos", Functions::cos),
    ("tan", Functions::tan),
    ("asin", Functions::asin),
    ("acos", Functions::acos),
    ("atan", Functions::atan),
    ("sinh", Functions::sinh),
    ("cosh", Functions::cosh),
    ("tanh", Functions::tanh),
    ("asinh", Functions::asinh),
    ("acosh", Functions::acosh),
    ("atanh", Functions::atanh),
    ("exp", Functions::exp),
    ("exp_m1", Functions::exp_m1),
    ("exp2", Functions::exp2),
    ("ln", Functions::ln),
    ("ln_1p", Functions::ln_1p),
    ("log2", Functions::log2),
    ("log10", Functions::log10),
    ("sqrt", Functions::sqrt),
    ("cbrt", Functions::cbrt),
];

/// The relative error is at most 1e-30 times the condition, beside the rounding of numbers below the smallest normal
/// one.
#[test]
fn every_function_has_thirty_digits_over_its_whole_range() {
    let mut constants = Consts::new().expect("constants");
    let mut wrong = Vec::new();
    let mut worst = std::collections::BTreeMap::new();
    for line in include_str!("digits.txt").lines().filter(|line| !line.starts_with('#')) {
        let [call, exact, condition] = line.split(" | ").collect::<Vec<_>>()[..] else { panic!("{line}") };
        let mut words = call.split(' ');
        let name = words.next().unwrap();
        let numbers: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        let arguments: Vec<_> = numbers.chunks(2).map(|pair| Double { hi: pair[0], lo: pair[1] }).collect();
        let found = match (name, &arguments[..]) {
            ("atan2", &[y, x]) => Functions::atan2(y, x),
            ("hypot", &[x, y]) => Functions::hypot(x, y),
            ("powf", &[x, y]) => Functions::powf(x, y),
            (_, &[x]) => FUNCTIONS.iter().find(|row| row.0 == name).expect("a function").1(x),
            _ => panic!("{line}"),
        };
        let (error, exact) = missed(found, exact, &mut constants);
        let condition: f64 = condition.parse().unwrap();
        let allowed = 1e-30 * condition * exact + 1e-323;
        if error <= allowed {
            let part = worst.entry(name).or_insert(0.0f64);
            *part = part.max((error - 1e-323) / (condition * exact));
        } else {
            wrong.push(format!("{line}: {found:?}, wrong by {error:e}, which is {:e} of it", error / exact));
        }
    }
    println!("largest error over condition: {worst:?}");
    assert!(wrong.is_empty(), "{} lines:\n{}", wrong.len(), wrong.join("\n"));
    assert_eq!(worst.len(), FUNCTIONS.len() + 3);
}

/// Arguments beyond a domain, infinities and what is not a number are answered as by `f64`.
#[test]
fn outside_of_their_domains_functions_are_those_of_f64() {
    const AT: [f64; 11] =
        [f64::NEG_INFINITY, -1e300, -2.0, -1.0, -0.0, 0.0, 1.0, 2.0, 1e300, f64::INFINITY, f64::NAN];
    macro_rules! same {
        ($($name:ident)*) => {$(
            for x in AT {
                let (found, of_f64) = (Functions::$name(Double::from(x)), Functions::$name(x));
                let close = (found.value() - of_f64).abs() <= 1e-15 * of_f64.abs();
                let same = found.value().to_bits() == of_f64.to_bits() || found.value().is_nan() && of_f64.is_nan();
                assert!(close || same, "{} {x:e}: {found:?} for {of_f64}", stringify!($name));
            }
        )*};
    }
    same! {
        sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp exp_m1 exp2 ln ln_1p log2 log10 sqrt cbrt abs signum
    }
    macro_rules! same_of_two {
        ($($name:ident)*) => {$(
            for x in AT {
                for y in AT {
                    let (found, of_f64) = (Functions::$name(Double::from(x), Double::from(y)), Functions::$name(x, y));
                    let close = (found.value() - of_f64).abs() <= 1e-15 * of_f64.abs();
                    let same = found.value() == of_f64 || found.value().is_nan() && of_f64.is_nan();
                    assert!(close || same, "{} {x:e} {y:e}: {found:?} for {of_f64}", stringify!($name));
                }
            }
        )*};
    }
    same_of_two! { atan2 hypot powf }
    // One beside 1 has a power without limit.
    let above = Double { hi: 1.0, lo: 1e-20 };
    assert_eq!(Functions::powf(above, Double::from(f64::INFINITY)).hi, f64::INFINITY);
    assert!(Functions::acosh(Double { hi: 1.0, lo: -1e-20 }).hi.is_nan());
}

/// The four operations, with operands of every size.
#[test]
fn arithmetic_reaches_the_ends_of_the_range() {
    let infinite = Double::from(f64::INFINITY);
    let large = Double { hi: 1e308, lo: 1e291 };
    assert_eq!((large * 4.0).value(), f64::INFINITY);
    assert_eq!((large + large).value(), f64::INFINITY);
    assert_eq!((infinite * 2.0 + Double::ONE).value(), f64::INFINITY);
    assert_eq!((Double::ONE / infinite).value(), 0.0);
    assert_eq!((Double::ONE / Double::ZERO).value(), f64::INFINITY);
    assert!((infinite - infinite).hi.is_nan() && (Double::ZERO / Double::ZERO).hi.is_nan());
    let third = Double::ONE / 3.0;
    // Powers of 2 change no digit, from the smallest number whose third has 32 digits to the largest.
    for k in [-960, -500, 500, 1020] {
        let power = Double::ONE.scaled(k);
        assert_eq!(third * power, third.scaled(k));
        assert_eq!(power / (power * 3.0), third);
        assert_eq!(third.scaled(k) / power, third);
        assert_eq!(third.scaled(k) / third, power);
    }
    // The operands are as small as any, and the quotient is not.
    assert_eq!(Double::from(5e-324) / Double::from(15e-324), third);
}

/// Decimal numbers and quotients as the compiler reads them.
#[test]
fn constants_have_the_digits_that_are_written() {
    use super::digits::exact;
    assert_eq!(exact!(0.25), Double::from(0.25));
    assert_eq!(exact!(1.0 / 3.0), Double::ONE / 3.0);
    assert_eq!(exact!(-0.1), -(Double::ONE / 10.0));
    assert_eq!(exact!(-17253.0 / 339200.0), Double::from(-17253.0) / 339200.0);
    let root = exact!(2.64575131106459059050161575363926042571);
    assert!(close(root.square(), Double::from(7.0), 7.0));
    let difference = exact!(0.311164366957819894408916062369764384 - 12675.0 / 17272.0);
    assert_eq!(difference.hi, 0.311164366957819894408916062369764384 - 12675.0 / 17272.0);
    assert!(close(
        difference,
        Double::from(12675.0) / -17272.0 + exact!(0.311164366957819894408916062369764384),
        1.0
    ));
    // What is an f64 only is not the number that is written.
    assert!(std::panic::catch_unwind(|| super::digits::of(0.1, "0.2")).is_err());
    assert!(std::panic::catch_unwind(|| super::digits::of(0.1, "0.1 * x")).is_err());
}

/// Inverse pairs and addition theorems, at points that have no special place.
#[test]
fn functions_have_thirty_digits() {
    let one = Double::ONE;
    for i in 1..40_i32 {
        let x = one * f64::from(i) / 7.0;
        let small = x / 41.0;
        let relative = |what: &str, a: Double, b: Double| {
            assert!(((a - b) / b).value().abs() < 3e-30, "{what} {i}: {a:?} {b:?}");
        };
        relative("exp", Functions::exp(x) * Functions::exp(-x), one);
        relative("exp of a sum", Functions::exp(x + small), Functions::exp(x) * Functions::exp(small));
        relative("ln", Functions::ln(Functions::exp(x)), x);
        relative("ln_1p", Functions::ln_1p(Functions::exp_m1(small)), small);
        relative("log2", Functions::log2(Functions::exp2(x)), x);
        relative("log10", Functions::log10(Functions::powf(one * 10.0, x)), x);
        relative("asinh", Functions::asinh(Functions::sinh(x)), x);
        relative(
            "sinh of a half",
            Functions::sinh(x),
            Functions::sinh(x / 2.0) * Functions::cosh(x / 2.0) * 2.0,
        );
        relative("cosh", Functions::cosh(x).square(), one + Functions::sinh(x).square());
        relative("tanh", Functions::tanh(x) * Functions::cosh(x), Functions::sinh(x));
        relative("acosh", Functions::cosh(Functions::acosh(one + x)), one + x);
        relative("atanh", Functions::atanh(Functions::tanh(small)), small);
        relative("asin", Functions::asin(Functions::sin(small)), small);
        relative("acos", Functions::cos(Functions::acos(small)), small);
        relative("atan", Functions::tan(Functions::atan(x)), x);
        relative("cbrt", Functions::cbrt(x) * Functions::cbrt(x).square(), x);
        relative("hypot", Functions::hypot(x * 3.0, x * 4.0), x * 5.0);
        relative("powf", Functions::powf(x, one * 3.0), x * x.square());
        relative("powf of negative numbers", Functions::powf(-x, one * 3.0), -(x * x.square()));
    }
    // e = 2.71828182845904523536028747135266249775…, in two parts.
    let e = Double { hi: core::f64::consts::E, lo: 1.4456468917292502e-16 };
    assert!((Functions::exp(one) - e).value().abs() < 1e-31);
}

#[test]
fn limits_are_those_of_f64() {
    let of = Double::from;
    assert_eq!(Functions::exp(of(-1e4)).value(), 0.0);
    assert_eq!(Functions::exp(of(1e4)).value(), f64::INFINITY);
    assert_eq!(Functions::ln(of(0.0)).value(), f64::NEG_INFINITY);
    assert!(Functions::ln(of(-1.0)).value().is_nan() && Functions::sqrt(of(-1.0)).value().is_nan());
    assert_eq!(Functions::powf(of(0.0), of(2.0)).value(), 0.0);
    assert_eq!(Functions::tanh(of(100.0)).value(), 1.0);
    assert!(of(1.0) < Double { hi: 1.0, lo: 1e-20 } && of(-1.0) < of(1.0));
}

fn close(a: Double, b: Double, scale: f64) -> bool {
    ((a - b).hi / scale).abs() < 1e-30
}

#[test]
fn arithmetic_has_thirty_digits() {
    let third = Double::ONE / 3.0;
    assert!(close(third * 3.0, Double::ONE, 1.0));
    assert!(close(Double::from(2.0).sqrt().square(), Double::from(2.0), 2.0));
}

#[test]
fn circular_functions_have_thirty_digits_in_every_quadrant() {
    // sin 1 = 0.8414709848078965066525023216302989996…, in two parts
    let (sin, cos) = Double::ONE.sin_cos();
    let expected = Double { hi: 0.841_470_984_807_896_5, lo: 1.776845092935536e-18 };
    assert!(close(sin, expected, 1.0), "{sin:?}");
    assert!(close(sin.square() + cos.square(), Double::ONE, 1.0));
    for i in -12_i32..=12 {
        let angle = PI / 12.0 * f64::from(i);
        let (sin, cos) = angle.sin_cos();
        assert!(i.abs() == 12 || close(sin.atan2(cos), angle, 1.0), "{i}");
        let (sin_3, _) = (angle * 3.0).sin_cos();
        assert!(close(sin_3, sin * 3.0 - sin * sin.square() * 4.0, 1.0), "{i}");
    }
}
