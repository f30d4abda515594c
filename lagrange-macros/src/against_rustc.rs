//! The language against rustc. An expression of the language is one of Rust, but for the documented [`EXTENSIONS`]:
//! so random expressions and mutations of them are put into a system, and over `f64` variables into a function. The
//! macro refuses what rustc refuses, and what both accept has one value. An expression that only the macro accepts
//! has to use an extension, and to have the value of its translation.
//!
//! `cargo test` tries [`few`]; more, or others, by
//!
//! ```text
//! LAGRANGE_EXPRESSIONS=100000 cargo test -p lagrange-macros --lib -- --ignored --nocapture many_expressions
//! LAGRANGE_SEED=17 cargo test -p lagrange-macros --lib -- --nocapture expressions_mean
//! ```

mod extensions;
mod generate;

use crate::diagnostics::Errors;
use crate::differential::generate::Random;
use crate::differential::{LONG, variable};
use crate::graph::Symbol;
use crate::model::Layout;
use crate::program::lower::program;
use crate::{model, syntax};
use extensions::{EXTENSIONS, Extension, translated};
use generate::expression;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// Expressions tried by `cargo test`, and with [`LONG`].
fn few() -> u64 {
    if *LONG { 400 } else { 200 }
}
/// One in so many of the expressions that the language refuses is shown to rustc.
const SAMPLED: usize = 8;
/// Functions per call of rustc.
const BATCH: usize = 4000;
/// Values of x, y, z and the elements of a.
const POINTS: [[f64; 6]; 3] =
    [[0.7, 1.3, -0.4, 0.9, -1.1, 2.3], [-1.6, 0.2, 2.1, -0.3, 0.8, 1.7], [2.9, -0.6, -1.2, 1.4, 3.1, -0.5]];
/// Relative changes of the variables that show how much rounding is amplified.
const NOISE: [f64; 5] = [0.0, 1.0, -2.0, 3.0, -5.0];
/// Permitted difference, in terms of the changes under [`NOISE`].
const SAFETY: f64 = 256.0;

/// Definitions that the functions share. The language has all of them.
const PRELUDE: &str = "\
#![allow(warnings)]
use std::f64; use std::f64::consts;
const N: usize = 3;
fn f(s: f64) -> f64 { s.powf(s) + 1.0 }
";

/// Functions that translations call.
const LIBRARY: &str = "\
thread_local! { static FINITE: std::cell::Cell<bool> = const { std::cell::Cell::new(true) }; }
thread_local! { static NOISE: std::cell::Cell<(f64, u32)> = const { std::cell::Cell::new((0.0, 0)) }; }
fn seen(x: f64) -> f64 {
    FINITE.set(FINITE.get() && x.is_finite());
    let (noise, k) = NOISE.get();
    NOISE.set((noise, k.wrapping_mul(5).wrapping_add(1)));
    // Zero has no sign.
    0.0 + x * (1.0 + noise * (f64::from(k % 7) * 0.3 - 1.0) * f64::EPSILON)
}
fn leaked<T>(list: Vec<T>) -> Vec<&'static T> { list.into_iter().map(|v| &*Box::leak(Box::new(v))).collect() }
trait Numbers { fn numbers(self) -> Vec<f64>; }
impl Numbers for Vec<f64> { fn numbers(self) -> Vec<f64> { self } }
impl Numbers for Vec<&f64> { fn numbers(self) -> Vec<f64> { self.into_iter().copied().collect() } }
impl Numbers for &Vec<f64> { fn numbers(self) -> Vec<f64> { self.clone() } }
impl Numbers for Vec<i64> { fn numbers(self) -> Vec<f64> { self.into_iter().map(|n| n as f64).collect() } }
fn kept<T>(value: T) -> &'static T { Box::leak(Box::new(value)) }
fn pairs(a: impl Numbers, b: impl Numbers) -> Vec<(f64, f64)> {
    let (a, b) = (a.numbers(), b.numbers()); assert_eq!(a.len(), b.len()); a.into_iter().zip(b).collect()
}
fn added(a: impl Numbers, b: impl Numbers) -> Vec<f64> { pairs(a, b).into_iter().map(|(a, b)| a + b).collect() }
fn subtracted(a: impl Numbers, b: impl Numbers) -> Vec<f64> { pairs(a, b).into_iter().map(|(a, b)| a - b).collect() }
fn scaled(a: impl Numbers, k: f64) -> Vec<f64> { a.numbers().into_iter().map(|x| x * k).collect() }
fn divided(a: impl Numbers, k: f64) -> Vec<f64> { a.numbers().into_iter().map(|x| x / k).collect() }
fn dot(a: impl Numbers, b: impl Numbers) -> f64 { pairs(a, b).into_iter().map(|(a, b)| a * b).sum() }
fn cross(a: impl Numbers, b: impl Numbers) -> Vec<f64> {
    let (a, b) = (a.numbers(), b.numbers()); assert_eq!((a.len(), b.len()), (3, 3));
    (0..3).map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]).collect()
}
fn norm_squared(a: impl Numbers) -> f64 { a.numbers().into_iter().map(|x| x * x).sum() }
fn norm(a: impl Numbers) -> f64 { norm_squared(a).sqrt() }
";

/// Values at [`POINTS`], each with the error that rounding may make.
type Values = [(f64, f64); POINTS.len()];

/// Values of an expression in the language; none if it is refused.
fn of_the_language(text: &str) -> Option<Values> {
    let system = format!(
        "@crate [::lagrange_runtime] system A {{ const N = 3; coord x, y, z, a: [N]; fn f(s) = s.powf(s) + 1.0; \
         T = dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(a).norm_squared(); V = 0; observe value = {text}; }}"
    );
    let mut errors = Errors::default();
    let definition = syntax::parse(system.parse().ok()?, &mut errors)?;
    let (graph, model) = model::model(&definition, &mut errors)?;
    let value = *model
        .observed
        .first()
        .filter(|o| o.layout == Layout::Scalar && model.observed.len() == 1)?
        .values
        .first()?;
    Some(POINTS.map(|point| {
        let at = |noise: f64| {
            let symbol = |symbol| match symbol {
                Symbol::Coordinate(i) => point[i] * (1.0 + noise * f64::EPSILON),
                _ => f64::NAN,
            };
            let rounded = std::cell::Cell::new(0u32);
            let noisy = |x: f64| {
                rounded.set(rounded.get().wrapping_mul(5).wrapping_add(1));
                // Zero has no sign.
                0.0 + x * (1.0 + noise * f64::from(rounded.get() % 7).mul_add(0.3, -1.0) * f64::EPSILON)
            };
            program(&graph, &[value]).evaluate(&[], symbol, noisy)[0]
        };
        spread(NOISE.map(at))
    }))
}

/// The first value, and how far the others are from it: without a bound if one of them is none.
fn spread(values: [f64; NOISE.len()]) -> (f64, f64) {
    let furthest = values.iter().map(|v| (v - values[0]).abs()).fold(0.0, f64::max);
    (values[0], if values.iter().any(|v| v.is_nan()) { f64::INFINITY } else { furthest })
}

/// rustc's verdicts on functions: of those that it accepts, their values, `None` where they panic.
fn of_rustc(folder: &Path, bodies: &BTreeMap<usize, &str>) -> BTreeMap<usize, Option<Values>> {
    let mut accepted: Vec<usize> = bodies.keys().copied().collect();
    let first_line = 1 + (PRELUDE.lines().count() + LIBRARY.lines().count());
    let source = folder.join("expressions.rs");
    let rustc = |accepted: &[usize], emit: &str| -> BTreeSet<usize> {
        let mut text = format!("{PRELUDE}{LIBRARY}");
        for case in accepted {
            let _ = writeln!(
                text,
                "fn case_{case}(x: f64, y: f64, z: f64, a: [f64; 3]) -> f64 {{ let value: f64 = {}; value }}",
                bodies[case]
            );
        }
        text += "fn main() {\n std::panic::set_hook(Box::new(|_| {}));\n let cases: &[(usize, fn(f64, f64, f64, [f64; 3]) -> f64)] = &[";
        for case in accepted {
            let _ = write!(text, "({case}, case_{case}),");
        }
        let _ = write!(
            text,
            "];\n for (case, f) in cases {{\n  let values = std::panic::catch_unwind(|| {{ let mut all = vec![];\n\
             for p in {POINTS:?} {{ for noise in {NOISE:?} {{ let p = p.map(|x: f64| x * (1.0 + noise * f64::EPSILON));\n\
             FINITE.set(true); NOISE.set((noise, 0)); let value = f(p[0], p[1], p[2], [p[3], p[4], p[5]]);\n\
             all.push(if FINITE.get() {{ value }} else {{ f64::NAN }}.to_bits().to_string()); }} }} all.join(\" \") }});\n\
             println!(\"{{case}} {{}}\", values.unwrap_or_default());\n }}\n}}\n"
        );
        std::fs::write(&source, text).expect("written");
        let output = Command::new(std::env::var("RUSTC").unwrap_or("rustc".into()))
            .args([
                "--edition=2024",
                "--error-format=short",
                "-Cdebuginfo=0",
                "-Coverflow-checks=on",
                emit,
                "-o",
            ])
            .arg(folder.join(if emit == "--emit=link" { "expressions" } else { "expressions.rmeta" }))
            .arg(&source)
            .output()
            .expect("rustc runs");
        let messages = String::from_utf8_lossy(&output.stderr);
        let refused: BTreeSet<usize> = messages
            .lines()
            .filter_map(|line| line.split_once("expressions.rs:")?.1.split(':').next()?.parse::<usize>().ok())
            .filter_map(|line| accepted.get(line.checked_sub(first_line)?).copied())
            .collect();
        assert!(output.status.success() || !refused.is_empty(), "{messages}");
        refused
    };
    for emit in ["--emit=metadata", "--emit=link"] {
        loop {
            let refused = rustc(&accepted, emit);
            if refused.is_empty() {
                break;
            }
            accepted.retain(|case| !refused.contains(case));
        }
    }
    let output = Command::new(folder.join("expressions")).output().expect("the expressions run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let values = |line: &str| {
        let mut words = line.split_whitespace();
        let case = words.next()?.parse().ok()?;
        let bits: Vec<u64> = words.map(|word| word.parse().expect("bits")).collect();
        let mut values =
            bits.chunks(NOISE.len()).map(|c| spread(std::array::from_fn(|i| f64::from_bits(c[i]))));
        let all =
            (!bits.is_empty()).then(|| std::array::from_fn(|_| values.next().expect("one for each point")));
        Some((case, all))
    };
    String::from_utf8_lossy(&output.stdout).lines().filter_map(values).collect()
}

/// The reason why two values differ by more than rounding, if they do.
fn difference(language: &Values, rust: &Option<Values>) -> Option<String> {
    let Some(rust) = rust else { return Some("rustc's panics".into()) };
    language.iter().zip(rust).find_map(|((found, noise), (expected, amplified))| {
        let granted = SAFETY * (noise + amplified + f64::EPSILON * expected.abs().max(f64::MIN_POSITIVE));
        let within = (found - expected).abs() <= granted;
        (expected.is_finite() && granted.is_finite() && !within)
            .then(|| format!("{found} is {expected} in Rust, ± {granted:e}"))
    })
}

#[derive(Default)]
struct Count {
    accepted: usize,
    refused: usize,
    /// Refused by the language, and not shown to rustc.
    unasked: usize,
    stricter: usize,
    extended: BTreeMap<Extension, usize>,
    without_value: usize,
    /// Accepted by both, with values that differ because a part is not finite or rounding is amplified, which only the
    /// translation shows.
    amplified: usize,
    disagreements: Vec<String>,
}

/// Expressions that were once compiled to something else than in Rust, or accepted without a reason.
const FOUND: [&str; 24] = [
    "0.5 * x * *2.0",
    "3x",
    "2m",
    "1f32 as f64",
    "{ let s: u8 = 300; x }",
    "[(), z + 3.0][1]",
    "(x, y)[0]",
    "[x, y].0",
    "bool::sin(x)",
    "<f64 as unknown>::sin(x)",
    "#[unknown] x",
    "{ let s = x else { 1.0 }; s }",
    "(9223372036854775807 as f64) * y",
    "((2147483648..N).map(|i| f32 as f64 * x).product::<f64>(), z).1",
    "-N as f64",
    "(y * 0.0).atan2(-1.0)",
    "([3.0, x] * &y).norm()",
    "if 1 > 2 { unknown } else { x }",
    "-2.0_f64.powi(2) + (7 % 3) as f64 - (-7 % 3) as f64",
    "{ let self = z; z }",
    "{ let N: f64 = y; x } + -y",
    "[z, x].into_iter().map(|v| v * [a[0]]).sum()[0]",
    "(0.0_f64).atan2(0.0) * x",
    "[x, y].map(|self| self * 2.0)[0]",
];

/// Compares expressions.
fn compare(texts: Vec<String>, folder: &Path, count: &mut Count) {
    let language: Vec<Option<Values>> = texts.iter().map(|text| of_the_language(text)).collect();
    // A sample of the refused expressions shows how much stricter than rustc the language is.
    let asked = |i: &usize| language[*i].is_some() || i.is_multiple_of(SAMPLED);
    let bodies = (0..texts.len()).filter(asked).map(|i| (i, texts[i].as_str()));
    let rust = of_rustc(folder, &bodies.collect());
    // Expressions whose translation decides: accepted by the language alone, or with another value.
    let mut questions = BTreeMap::new();
    for (i, text) in texts.iter().enumerate() {
        let why = match (&language[i], rust.get(&i)) {
            (Some(language), Some(rust)) => {
                count.accepted += 1;
                count.without_value +=
                    usize::from(rust.is_none_or(|r| r.iter().all(|(v, _)| !v.is_finite())));
                difference(language, rust)
            }
            (Some(_), None) => Some("rustc refuses it".into()),
            (None, Some(_)) => {
                count.stricter += 1;
                None
            }
            (None, None) => {
                count.refused += usize::from(asked(&i));
                count.unasked += usize::from(!asked(&i));
                None
            }
        };
        let Some(why) = why else { continue };
        match translated(text, |text| of_the_language(text).is_some()) {
            Some((translation, used)) if rust.contains_key(&i) || !used.is_empty() => {
                questions.insert(i, (why, translation, used));
            }
            _ => count.disagreements.push(format!("{text}: {why}")),
        }
    }
    let translations = questions.iter().map(|(i, (_, translation, _))| (*i, translation.as_str()));
    let by_translation = of_rustc(folder, &translations.collect());
    for (i, (first, translation, used)) in questions {
        let why = match (&language[i], by_translation.get(&i)) {
            (Some(language), Some(rust)) => difference(language, rust),
            _ => Some("rustc refuses the translation".into()),
        };
        match why {
            Some(why) => {
                count.disagreements.push(format!("{}: {first}, {why}\n    as {translation}", texts[i]));
            }
            None if rust.contains_key(&i) => count.amplified += 1,
            None => used.into_iter().for_each(|kind| *count.extended.entry(kind).or_default() += 1),
        }
    }
}

fn agree(expressions: u64) {
    let first = variable("LAGRANGE_SEED").unwrap_or(0);
    let seeds: Vec<u64> = (first..first + expressions).collect();
    let folder = std::env::temp_dir().join(format!("lagrange-expressions-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for them");
    let mut count = Count::default();
    for seeds in seeds.chunks(BATCH) {
        let known = count.disagreements.len();
        let random = seeds.iter().map(|seed| expression(&mut Random::new(*seed), seed % 3 != 0));
        let found = FOUND.map(String::from).into_iter().filter(|_| seeds[0] == first);
        compare(random.filter(|text| !text.is_empty()).chain(found).collect(), &folder, &mut count);
        count.disagreements[known..].iter().for_each(|text| println!("{text}"));
    }
    std::fs::remove_dir_all(&folder).expect("removed");
    println!(
        "accepted by both {} ({} without a value, {} told apart by the translation), refused by both {}, \
         refused by the language alone {}, refused by the language and not shown to rustc {}, extensions {:?}",
        count.accepted,
        count.without_value,
        count.amplified,
        count.refused,
        count.stricter,
        count.unasked,
        count.extended
    );
    assert!(
        count.disagreements.is_empty(),
        "{} disagreements:\n{}",
        count.disagreements.len(),
        count.disagreements.join("\n")
    );
    assert!(count.accepted > seeds.len() / 10 && count.refused > seeds.len() / 20);
}

#[test]
fn expressions_mean_what_they_mean_in_rust() {
    agree(few());
}

#[test]
#[ignore = "minutes: rustc reads all of them"]
fn many_expressions() {
    agree(variable("LAGRANGE_EXPRESSIONS").unwrap_or(100_000));
}

/// The documentation of the language names the extensions.
#[test]
fn extensions_are_documented() {
    let documentation = include_str!("../../lagrange-runtime/src/language.rs");
    let text = documentation.replace("\n///", "");
    for (extension, sentence) in EXTENSIONS {
        assert!(text.contains(sentence), "{extension:?}: {sentence}");
    }
}
