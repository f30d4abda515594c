//! Errors of kernels in units of the last place, against arithmetic of 160 bits (`astro-float-num`, tested by its
//! authors against MPFR).

use super::kernels;
use super::pack::Pack;
use super::policy::{Fused, Plain, Policy};
use super::trigonometric;
use astro_float_num::{BigFloat, Consts, RoundingMode};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const BITS: usize = 160;

/// Arguments of each range: `LAGRANGE_SAMPLES`, of which `.ci/full` takes many.
fn samples() -> usize {
    std::env::var("LAGRANGE_SAMPLES")
        .map_or(if crate::long() { 1500 } else { 100 }, |count| count.parse().expect("a number"))
}
const ROUNDING: RoundingMode = RoundingMode::ToEven;

/// Exact values, and the numbers at which they are asked for.
struct Exact {
    constants: Consts,
    random: ChaCha8Rng,
}

impl Exact {
    fn new() -> Self {
        Exact { constants: Consts::new().expect("constants"), random: ChaCha8Rng::seed_from_u64(1) }
    }

    /// Uniform in [0, 1).
    fn uniform(&mut self) -> f64 {
        (self.random.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    /// A random number of either sign, with any power of 2 between 2^low and 2^high.
    fn spread(&mut self, low: f64, high: f64) -> f64 {
        let magnitude = (low + (high - low) * self.uniform()).exp2();
        if self.random.next_u64() & 1 == 0 { magnitude } else { -magnitude }
    }
}

/// A number of many digits.
fn big(x: f64) -> BigFloat {
    BigFloat::from_f64(x, BITS)
}

/// The nearest double but for an error of 2⁻⁶³, for differences.
fn small(x: &BigFloat) -> f64 {
    let Some((words, _, sign, exponent, _)) = x.as_raw_parts() else { return f64::NAN };
    if x.is_zero() {
        return 0.0;
    }
    let top = *words.last().expect("a number has words") as f64 * 2f64.powi(-64);
    let magnitude = top * 2f64.powi(exponent);
    if sign == astro_float_num::Sign::Neg { -magnitude } else { magnitude }
}

/// The distance from |x| to the next larger double.
fn last_place(x: f64) -> f64 {
    f64::from_bits(x.abs().to_bits() + 1) - x.abs()
}

/// Error of `found` in units of its last place.
fn error(found: f64, exact: &BigFloat) -> f64 {
    let difference = big(found).sub(exact, BITS, ROUNDING);
    (small(&difference) / last_place(found)).abs()
}

/// The largest errors of sine and cosine at `x`.
fn worst<P: Policy>(exact: &mut Exact, x: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut worst = [0f64; 2];
    for x in x {
        let (sin, cos) = trigonometric::sin_cos_of_lane::<P>(x);
        let argument = big(x);
        // Near a zero many leading bits cancel.
        let sine = argument.sin(2 * BITS, ROUNDING, &mut exact.constants);
        let cosine = argument.cos(2 * BITS, ROUNDING, &mut exact.constants);
        worst = [worst[0].max(error(sin, &sine)), worst[1].max(error(cos, &cosine))];
    }
    worst
}

/// Numbers of every size up to `limit`, and those next to multiples of π/2.
fn angles(exact: &mut Exact, limit: f64, count: usize) -> Vec<f64> {
    let mut angles = vec![0.0, limit, -limit, 1e-300];
    for _ in 0..count {
        angles.push(exact.spread(-30.0, limit.log2()));
        angles.push(limit * (2.0 * exact.uniform() - 1.0));
        angles.push(8.0 * (exact.uniform() - 0.5));
        let quarters = (exact.uniform() * limit * core::f64::consts::FRAC_2_PI).floor();
        let zero = quarters * core::f64::consts::FRAC_PI_2;
        angles.extend([zero.next_down(), zero, zero.next_up()].map(|x| x.clamp(-limit, limit)));
    }
    angles
}

fn sines_are_within<P: Policy>(limit: f64, bound: f64) {
    let exact = &mut Exact::new();
    let angles = angles(exact, limit, 2 * samples());
    let worst = worst::<P>(exact, angles.into_iter());
    println!(
        "{} to {limit:e}: sin {:.3} ULP, cos {:.3} ULP",
        core::any::type_name::<P>(),
        worst[0],
        worst[1]
    );
    assert!(worst[0] < bound && worst[1] < bound, "{worst:?}");
}

#[test]
fn sines_and_cosines_have_all_their_digits() {
    sines_are_within::<Fused>(1e6, 1.6);
    sines_are_within::<Fused>(trigonometric::limit::<Fused>(), 1.6);
    sines_are_within::<Plain>(trigonometric::limit::<Plain>(), 1.6);
}

/// The doubles nearest to a multiple of π/2 that there are below the limits, by their continued fractions: what
/// remains of these after reduction is smallest.
#[test]
fn sines_next_to_their_zeros() {
    let exact = &mut Exact::new();
    let mut nearest: Vec<(f64, f64)> = vec![];
    for quarters in 1..600_000u32 {
        let x = f64::from(quarters) * core::f64::consts::FRAC_PI_2;
        let (r, _) = trigonometric::reduced::<Fused, f64>(x);
        nearest.push((r.abs() / x, x));
    }
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let hardest: Vec<f64> = nearest[..2000].iter().map(|&(_, x)| x).collect();
    assert!(nearest[0].0 * nearest[0].1 < 1e-15);
    for worst in
        [worst::<Fused>(exact, hardest.iter().copied()), worst::<Plain>(exact, hardest.iter().copied())]
    {
        assert!(worst[0] < 1.6 && worst[1] < 1.6, "{worst:?}");
    }
}

#[test]
fn packs_fall_back_beyond_the_limit() {
    let exact = &mut Exact::new();
    for x in [1e6, 1.1e6, 1e9, 1.1e9, 1e15, 1e22, 1e300, f64::MAX] {
        let (sin, cos) = Pack([x, -x, 1.0, 2.0]).sin_cos::<Plain>();
        let precision = BITS + 1100;
        let argument = BigFloat::from_f64(x, precision);
        let sine = argument.sin(precision, ROUNDING, &mut exact.constants);
        let cosine = argument.cos(precision, ROUNDING, &mut exact.constants);
        assert!(error(sin.0[0], &sine) < 1.0 && error(cos.0[0], &cosine) < 1.0, "{x}");
        assert_eq!((sin.0[1], cos.0[1]), (-sin.0[0], cos.0[0]));
        assert_eq!(sin.0[2], trigonometric::sin_cos_of_lane::<Plain>(1.0).0);
    }
}

/// A value of many digits of a function of up to two arguments.
type Function = fn(&BigFloat, &BigFloat, &mut Consts) -> BigFloat;

/// Distribution of arguments.
#[derive(Clone, Copy)]
enum Range {
    /// Any size between 2^low and 2^high, of either sign.
    Sizes(f64, f64),
    /// The same, positive.
    Positive(f64, f64),
    /// Uniform.
    Uniform(f64, f64),
}

impl Range {
    fn sample(self, exact: &mut Exact) -> f64 {
        match self {
            Range::Sizes(low, high) => exact.spread(low, high),
            Range::Positive(low, high) => exact.spread(low, high).abs(),
            Range::Uniform(low, high) => low + (high - low) * exact.uniform(),
        }
    }
}

/// The largest errors of a kernel, fused and rounded, over all ranges, each a range of both arguments.
fn kernel(
    name: &str,
    kernels: [fn(f64, f64) -> (f64, bool); 2],
    function: Function,
    ranges: &[[Range; 2]],
    bound: f64,
) {
    let exact = &mut Exact::new();
    let mut worst = [(0f64, 0.0, 0.0); 2];
    let samples = samples();
    for range in ranges {
        let mut found = 0;
        for _ in 0..samples {
            let [x, y] = range.map(|range| range.sample(exact));
            let values = kernels.map(|kernel| kernel(x, y));
            if !values.iter().all(|(_, good)| *good) {
                continue;
            }
            found += 1;
            let value = function(&big(x), &big(y), &mut exact.constants);
            for (worst, (found, _)) in worst.iter_mut().zip(values) {
                let error = error(found, &value);
                assert!(error.is_finite(), "{name}({x:e}, {y:e}) = {found:e}");
                if error > worst.0 {
                    *worst = (error, x, y);
                }
            }
        }
        assert!(2 * found > samples - samples / 10, "{name}: the kernel holds for {found} of {samples} only");
    }
    let [fused, rounded] = worst;
    println!(
        "| {name} | {:.2} | {:.2} | at {:e}, {:e}; {:e}, {:e}",
        fused.0, rounded.0, fused.1, fused.2, rounded.1, rounded.2
    );
    assert!(fused.0 <= bound && rounded.0 <= bound, "{name}: {worst:?}");
}

/// Precision for values that cancel: of e^x − 1 for x from 2⁻⁶⁰ on.
const MORE: usize = 2 * BITS;

macro_rules! of_one {
    ($name:ident) => {
        [|x, _| kernels::$name::<Fused>(x), |x, _| kernels::$name::<Plain>(x)]
    };
}
macro_rules! of_two {
    ($name:ident) => {
        [|x, y| kernels::$name::<Fused>(x, y), |x, y| kernels::$name::<Plain>(x, y)]
    };
}

#[test]
fn kernels_have_nearly_all_their_digits() {
    use Range::{Positive, Sizes, Uniform};
    const NONE: Range = Uniform(0.0, 0.0);
    fn one() -> BigFloat {
        big(1.0)
    }
    println!("| function | fused | rounded |");
    kernel(
        "exp",
        of_one!(exp),
        |x, _, c| x.exp(BITS, ROUNDING, c),
        &[[Uniform(-708.0, 708.0), NONE], [Uniform(-2.0, 2.0), NONE], [Sizes(-60.0, 9.4), NONE]],
        1.0,
    );
    kernel(
        "exp2",
        of_one!(exp2),
        |x, _, c| big(2.0).pow(x, BITS, ROUNDING, c),
        &[[Uniform(-1021.0, 1021.0), NONE], [Uniform(-2.0, 2.0), NONE], [Sizes(-60.0, 9.9), NONE]],
        1.1,
    );
    kernel(
        "exp_m1",
        of_one!(exp_m1),
        |x, _, c| x.exp(MORE, ROUNDING, c).sub(&one(), MORE, ROUNDING),
        &[[Uniform(-40.0, 708.0), NONE], [Uniform(-2.0, 2.0), NONE], [Sizes(-60.0, 9.4), NONE]],
        2.1,
    );
    kernel(
        "ln",
        of_one!(ln),
        |x, _, c| x.ln(MORE, ROUNDING, c),
        &[[Positive(-1022.0, 1023.0), NONE], [Uniform(0.5, 2.0), NONE], [Uniform(0.99, 1.01), NONE]],
        0.8,
    );
    kernel(
        "ln_1p",
        of_one!(ln_1p),
        |x, _, c| one().add(x, MORE, ROUNDING).ln(MORE, ROUNDING, c),
        &[[Positive(-60.0, 996.0), NONE], [Uniform(-1.0, 2.0), NONE], [Sizes(-60.0, -0.01), NONE]],
        0.8,
    );
    kernel(
        "log2",
        of_one!(log2),
        |x, _, c| x.log2(MORE, ROUNDING, c),
        &[[Positive(-1022.0, 1023.0), NONE], [Uniform(0.5, 2.0), NONE], [Uniform(0.99, 1.01), NONE]],
        0.8,
    );
    kernel(
        "log10",
        of_one!(log10),
        |x, _, c| x.log10(MORE, ROUNDING, c),
        &[[Positive(-1022.0, 1023.0), NONE], [Uniform(0.5, 2.0), NONE], [Uniform(0.99, 1.01), NONE]],
        0.8,
    );
    kernel(
        "cbrt",
        of_one!(cbrt),
        |x, _, _| x.cbrt(BITS, ROUNDING),
        &[[Sizes(-1022.0, 1023.0), NONE], [Uniform(-8.0, 8.0), NONE]],
        0.7,
    );
    kernel(
        "hypot",
        of_two!(hypot),
        |x, y, _| {
            let squares = x.mul(x, MORE, ROUNDING).add(&y.mul(y, MORE, ROUNDING), MORE, ROUNDING);
            squares.sqrt(MORE, ROUNDING)
        },
        &[[Sizes(-400.0, 400.0), Sizes(-400.0, 400.0)], [Uniform(-1.0, 1.0), Uniform(-1.0, 1.0)]],
        1.3,
    );
    kernel(
        "tan",
        of_one!(tan),
        |x, _, c| x.tan(MORE, ROUNDING, c),
        &[[Uniform(-10.0, 10.0), NONE], [Uniform(-1e6, 1e6), NONE], [Sizes(-60.0, 19.9), NONE]],
        3.2,
    );
    kernel(
        "asin",
        of_one!(asin),
        |x, _, c| x.asin(MORE, ROUNDING, c),
        &[[Uniform(-1.0, 1.0), NONE], [Sizes(-60.0, 0.0), NONE]],
        1.6,
    );
    kernel(
        "acos",
        of_one!(acos),
        |x, _, c| x.acos(MORE, ROUNDING, c),
        &[[Uniform(-1.0, 1.0), NONE], [Uniform(0.999, 1.0), NONE], [Sizes(-60.0, 0.0), NONE]],
        1.05,
    );
    kernel(
        "atan",
        of_one!(atan),
        |x, _, c| x.atan(MORE, ROUNDING, c),
        &[[Uniform(-4.0, 4.0), NONE], [Sizes(-60.0, 60.0), NONE]],
        0.8,
    );
    kernel(
        "atan2",
        of_two!(atan2),
        |y, x, c| {
            let angle = y.div(x, MORE, ROUNDING).atan(MORE, ROUNDING, c);
            let half = c.pi(MORE, ROUNDING);
            match (x.is_negative(), y.is_negative()) {
                (false, _) => angle,
                (true, false) => angle.add(&half, MORE, ROUNDING),
                (true, true) => angle.sub(&half, MORE, ROUNDING),
            }
        },
        &[[Uniform(-1.0, 1.0), Uniform(-1.0, 1.0)], [Sizes(-20.0, 20.0), Sizes(-20.0, 20.0)]],
        1.4,
    );
    kernel(
        "sinh",
        of_one!(sinh),
        |x, _, c| x.sinh(MORE, ROUNDING, c),
        &[[Uniform(-708.0, 708.0), NONE], [Uniform(-2.0, 2.0), NONE], [Sizes(-60.0, 9.4), NONE]],
        2.3,
    );
    kernel(
        "cosh",
        of_one!(cosh),
        |x, _, c| x.cosh(MORE, ROUNDING, c),
        &[[Uniform(-708.0, 708.0), NONE], [Uniform(-2.0, 2.0), NONE]],
        1.4,
    );
    kernel(
        "tanh",
        of_one!(tanh),
        |x, _, c| x.tanh(MORE, ROUNDING, c),
        &[[Uniform(-21.0, 21.0), NONE], [Uniform(-1.0, 1.0), NONE], [Sizes(-60.0, 4.0), NONE]],
        2.7,
    );
    kernel(
        "asinh",
        of_one!(asinh),
        |x, _, c| x.asinh(MORE, ROUNDING, c),
        &[[Uniform(-4.0, 4.0), NONE], [Sizes(-60.0, 400.0), NONE]],
        1.7,
    );
    kernel(
        "acosh",
        of_one!(acosh),
        |x, _, c| x.acosh(MORE, ROUNDING, c),
        &[[Uniform(1.0, 4.0), NONE], [Positive(0.0, 400.0), NONE], [Uniform(1.0, 1.001), NONE]],
        2.2,
    );
    kernel(
        "atanh",
        of_one!(atanh),
        |x, _, c| x.atanh(MORE, ROUNDING, c),
        &[[Uniform(-1.0, 1.0), NONE], [Sizes(-60.0, 0.0), NONE]],
        1.9,
    );
    kernel(
        "powf",
        of_two!(powf),
        |x, y, c| x.pow(y, MORE, ROUNDING, c),
        &[
            [Positive(-10.0, 10.0), Uniform(-60.0, 60.0)],
            [Uniform(0.5, 2.0), Uniform(-1000.0, 1000.0)],
            [Positive(-1000.0, 1000.0), Uniform(-1.0, 1.0)],
        ],
        0.85,
    );
}
