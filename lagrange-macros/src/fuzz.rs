//! No input makes the compiler panic or hang: hostile definitions by hand, random ones, and mutations of good ones.

use crate::compile::{compile, compile_with};
use crate::diagnostics::Errors;
use crate::differential::LONG;
use crate::differential::generate::Random;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use proptest::prelude::*;
use std::time::{Duration, Instant};

/// Shorter than anybody waits for a compiler; without optimisation and beside other tests, several times that.
const MAX_DURATION: Duration = Duration::from_secs(if cfg!(debug_assertions) { 20 } else { 5 });

fn tokens(definition: &str) -> TokenStream {
    format!("@crate [::lagrange_runtime] {definition}").parse().expect("tokens of Rust")
}

/// Compiles in bounded time; the messages, if it was refused.
fn messages(definition: &str) -> Vec<String> {
    let mut errors = Errors::default();
    compiles_to(tokens(definition), &mut errors);
    errors.messages()
}

/// The output parses as items of Rust, whatever went in.
fn compiles_to_items(input: TokenStream) {
    compiles_to(input, &mut Errors::default());
}

fn compiles_to(input: TokenStream, errors: &mut Errors) {
    let start = Instant::now();
    let text = input.to_string();
    let output = compile_with(input, errors);
    assert!(start.elapsed() < MAX_DURATION, "{:?} for {text}", start.elapsed());
    if let Err(error) = syn::parse2::<syn::File>(output.clone()) {
        panic!("{error}: {text}\n→ {output}");
    }
}

/// An oscillator with these statements besides its own.
fn oscillator(statements: &str) -> String {
    format!(
        "pub system Oscillator {{ param m, k; coord x; {statements} T = m * dot(x).powi(2); V = k * x * x; }}"
    )
}

/// The one message of a mistake.
#[track_caller]
fn refused(definition: &str, part: &str) {
    let messages = messages(definition);
    assert!(messages.len() == 1 && messages[0].contains(part), "{definition}: {messages:#?}");
}

#[track_caller]
fn accepted(definition: &str) {
    let messages = messages(definition);
    assert!(messages.is_empty(), "{definition}: {messages:#?}");
}

#[test]
fn headers() {
    refused("", "expected `system Name");
    refused("pub", "expected `system Name");
    refused("pub system", "expected the name");
    refused("pub system 3 {}", "expected the name");
    refused("pub sytem Name { coord x; T = dot(x) * dot(x); V = 0; }", "expected `system Name");
    refused("pub system Name", "expected `{ … }`");
    refused("pub system S { coord x; T = dot(x).powi(2); V = 0; }", "cannot be called `S`");
    refused("pub system r#type { coord x; L = dot(x).powi(2); }", "keyword");
    refused("pub system Name {}", "empty");
    let deep = format!(
        "#[doc = {}x{}] system A {{ coord x; L = dot(x).powi(2); }}",
        "(".repeat(900),
        ")".repeat(900)
    );
    refused(&deep, "nested too deeply");
    refused("pub system Name { coord x; T = dot(x) * dot(x); V = 0; } garbage", "one system");
    refused("system A<T> { coord x; T = dot(x) * dot(x); V = 0; }", "no generics");
    accepted("system A { coord x; T = dot(x) * dot(x); V = 0; }");
    accepted("pub(in crate::a) system A { coord x; L = dot(x) * dot(x); }");
}

#[test]
fn statements() {
    for empty in [";", ";;;", "#;", "=;", "{}", "();", "\"text\";", "3;"] {
        let messages = messages(&format!("system A {{ {empty} }}"));
        assert!(!messages.is_empty(), "{empty}");
    }
    refused(&oscillator("param;"), "expected a name");
    refused(&oscillator("param fn;"), "keyword");
    refused(&oscillator("coord;"), "expected a name");
    refused(&oscillator("let y;"), "needs its value");
    refused(&oscillator("let y = ;"), "the value is missing");
    refused(&oscillator("const N;"), "needs its value");
    refused(&oscillator("const N: [2] = 3;"), "one integer");
    refused(&oscillator("observe y: [2] = [x, x];"), "length");
    refused(&oscillator("observe y = [[x, 1], [x]];"), "elements of a list are of one kind");
    refused(&oscillator("observe y = [x, [x, 1]];"), "elements of a list are of one kind");
    refused(&oscillator("observe y = [[[x]]];"), "expected a number, found an array");
    refused(&oscillator("observe r#type = x;"), "keyword");
    refused(&oscillator("param k;"), "defined twice");
    refused(&oscillator("coord k;"), "defined twice");
    refused(&oscillator("fn sin(s) = s;"), "elementary");
    refused(&oscillator("fn dot(s) = s;"), "time derivative");
    refused(&oscillator("fn f(s, s) = s;"), "two arguments");
    refused(&oscillator("fn f(s) { s }"), "`=`");
    refused(&oscillator("extern mu(t);"), "`fn`");
    refused(&oscillator("#[inline] let y = x;"), "no effect");
    refused(&oscillator("observe accel = x;"), "already");
    refused(&oscillator("observe y = x; observe y = x;"), "duplicate output");
    refused(&oscillator("Q[x] += 3;"), "nothing is added");
    refused(&oscillator("Q = 3;"), "Q[x]");
    refused(&oscillator("state i; rates(i) = x;"), "did you mean `rate`?");
    refused(&oscillator("observe y = [x, 2.0].y;"), "`[x, 2.0][1]`");
    refused(&oscillator("coord R: [rotation; 2]; observe y = R.x;"), "`R` is an array of rotations");
    for visibility in ["", "pub(crate) "] {
        let system = "system A { coord x, y; L = dot(x).powi(2) + dot(y).powi(2) - x * y * y; pub restriction B: y = 0; }";
        refused(&format!("{visibility}{system}"), "`B` is public");
    }
}

#[test]
fn held() {
    let two = |statements: &str| {
        format!(
            "system Two {{ param m; coord x, y; T = m * (dot(x).powi(2) + dot(y).powi(2)); V = 0; {statements} }}"
        )
    };
    for constraint in
        ["x == y", "dot(x) == y * dot(y)", "x * dot(x) == t", "x.sin() == t", "1e300 * x == 1e300 * y"]
    {
        accepted(&two(&format!("constraint c: {constraint};")));
    }
    refused(&two("constraint;"), "expected the name");
    refused(&two("constraint c;"), "`:`");
    refused(&two("constraint c: x;"), "an equation");
    refused(&two("constraint c: x == true;"), "expected a number");
    refused(&two("constraint c: [] == [];"), "no elements");
    refused(&two("constraint c: [[x]] == [[y]];"), "expected a number");
    refused(&two("constraint c: dot(x) == dot(x) + t;"), "does not depend on any coordinate");
    refused(&two("constraint c: dot(x) * dot(y) == 1;"), "not linear");
    refused(&two("constraint x: x == y;"), "defined twice");
    refused(&two("constraint c: x == y; constraint d: y == x;"), "redundant");
    refused(&two("constraint c: x == y; Q[c] = 1;"), "not a coordinate");
    refused(&two("observe r = reaction();"), "argument");
    refused(&two("observe r = reaction(x, y);"), "argument");
    refused(&two("observe r = reaction(3);"), "neither");
    refused(&two("constraint c: x == y; observe r = reaction(c[0]);"), "no elements");
    refused(&two("constraint c: [x] == [y]; observe r = reaction(c[1]);"), "out of range");
    refused(&two("coord s: [2] = |i| i * t + t; observe r = reaction(s[2]);"), "out of range");
    refused(&two("impulse;"), "expected the name");
    refused(&two("impulse blow at dot(x);"), "velocities");
    refused(&two("impulse accel at x;"), "already");
    refused(&two("impulse blow at x; observe blow = x;"), "duplicate output");
    refused(&two("impulse blow at [];"), "does not move");
}

/// Constraints that restrict what others restrict already follow from them, or contradict them.
#[test]
fn dependent_constraints() {
    let three = |statements: &str| {
        format!(
            "system Three {{ param l = 1, k = 2; coord x, y, z; T = dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2); V = l * k * x; {statements} }}"
        )
    };
    for (constraints, part) in [
        (
            "constraint a: x + y == 1; constraint b: x + y == 2;",
            "`b` contradicts `a`: they restrict the same motion, and cannot hold together\n",
        ),
        (
            "constraint a: x + y == l; constraint b: x + y == k;",
            "`b` contradicts `a`: they restrict the same motion, and cannot hold together, but for special",
        ),
        (
            "constraint a: x + y == 1; constraint b: 2 * x + 2 * y == 2;",
            "`b` is redundant: it follows from `a`",
        ),
        (
            "constraint a: x * x + y * y == 1; constraint b: (x * x + y * y).sqrt() == 1;",
            "`b` is redundant: it follows from `a`",
        ),
        (
            "constraint a: x * x + y * y == 1; constraint b: (x * x + y * y).sqrt() == 2;",
            "`b` contradicts `a`",
        ),
        ("constraint a: x == t; constraint b: x == 2 * t;", "`b` contradicts `a`"),
        ("constraint a: dot(x) == 1; constraint b: dot(x) == 2;", "`b` contradicts `a`"),
        (
            "constraint a: dot(x) == y; constraint b: 3 * dot(x) == 3 * y;",
            "`b` is redundant: it follows from `a`",
        ),
        ("constraint a: x == y; constraint b: dot(x) == dot(y);", "`b` is redundant: it follows from `a`"),
        ("constraint a: x == y; constraint b: dot(x) == dot(y) + 1;", "`b` contradicts `a`"),
        (
            "constraint a: [x + y, x - y] == [1, 2]; constraint b: x == 1.5;",
            "`b` is redundant: it follows from `a[0]`, `a[1]`",
        ),
        ("constraint a: [x + y, x - y] == [1, 2]; constraint b: x == 1;", "`b` contradicts `a[0]`, `a[1]`"),
        ("constraint a: [x, x] == [1, 2];", "`a[1]` contradicts `a[0]`"),
        ("constraint a: [x, y, z] == [1, 2, 3];", "3 constraints on 3 coordinates"),
    ] {
        refused(&three(constraints), part);
    }
    accepted(&three("constraint a: x + y == 1; constraint b: x - y == 1;"));
    // On their own circle each of these holds, but not as equations.
    accepted(&three("constraint a: x * x + y * y == 1; constraint b: x * x + z * z == 1;"));
}

/// Signs that no kinetic energy and no friction have; where signs are not known, nothing is said.
#[test]
fn signs() {
    for energies in [
        "T = -0.5 * m * dot(x).powi(2); V = k;",
        "T = 0.5 * m * dot(x).powi(2) - m * (k * dot(x)).powi(2) - 0.5 * m * dot(x).powi(2); V = 0;",
        "T = -m * (x.cos() * dot(x)).powi(2) - k * (x.sin() * dot(x)).powi(2); V = 0;",
        "L = k * x - 0.5 * m * dot(x).powi(2);",
    ] {
        refused(
            &format!("system A {{ param m = 1, k = 1; coord x; {energies} }}"),
            "kinetic energy of `x` is negative",
        );
    }
    refused(
        "system A { param m, k; coord x, y; T = m * dot(x).powi(2) - k * dot(y).powi(2); V = 0; }",
        "kinetic energy of `y` is negative",
    );
    refused(&oscillator("D = -k * dot(x).powi(2);"), "would drive `x`");
    accepted("system A { param m, k; coord x; T = (m - k) * dot(x).powi(2); V = 0; }");
    accepted("system A { param m; coord x; T = m * (1 - x * x) * dot(x).powi(2); V = 0; }");
    // A metric of no definite sign has a Lagrangian, and so have the proper times of relativity.
    accepted("system A { coord x, y; L = dot(x).powi(2) - dot(y).powi(2); }");
    accepted("system A { param m, c; coord x; L = -m * c * (c * c - dot(x).powi(2)).sqrt(); }");
    accepted(&oscillator("D = k * (x * x - 1) * dot(x).powi(2);"));
}

#[test]
fn names() {
    for name in
        ["T", "V", "L", "D", "Q", "param", "coord", "observe", "system", "at", "q", "qd", "p", "w0", "PI"]
    {
        let one = format!("system A {{ param {name}; coord x; T = {name} * dot(x).powi(2); V = 0; }}");
        accepted(&one);
        accepted(&format!(
            "system A {{ coord {name}; T = dot({name}).powi(2); V = {name}; observe {name}; }}"
        ));
    }
    accepted("system Größe { param µ; coord φ; T = µ * dot(φ).powi(2); V = µ * φ.cos(); }");
    refused("system A { param r#type; coord x; T = dot(x) * dot(x); V = r#type * x; }", "keyword");
}

#[test]
fn numbers() {
    refused(&oscillator("let y = 1e400 * x;"), "overflows");
    refused(&oscillator("let y = 1e308 * 1e308 * x;"), "overflows");
    refused(&oscillator("let y = 0.0 / 0.0;"), "division by zero");
    refused(&oscillator("let y = x / 0;"), "division by zero");
    refused(&oscillator("let y = 9223372036854775807 + 1;"), "overflows");
    refused(&oscillator("let y = (-9223372036854775807 - 1) / -1;"), "");
    refused(&oscillator("let y = x.powi(1000000);"), "exponent");
    refused(&oscillator("let y = 0.powi(-1);"), "division by zero");
    refused(&oscillator("let y = (-1.0).sqrt() * x;"), "");
    refused(&oscillator("param a = (-1.0).ln();"), "NaN");
    refused(&oscillator("param a = 1e3.exp();"), "");
    refused(&oscillator("param a = b;"), "unknown name");
    refused(&oscillator("param a = m;"), "a default is a constant");
    refused(&oscillator("param a: [3] = [1, 2];"), "array of 2");
    refused(&oscillator("param a = |x| x;"), "closure");
    accepted(&oscillator("let y = x.powi(1000) + 0xff * x;"));
}

/// `x**2` is `x * (*2)` to Rust, and was 2 x.
#[test]
fn powers() {
    refused(&oscillator("let y = 0.5 * k * x**2;"), "`x.powi(2)`");
    refused(&oscillator("let y = (x + 1)**2.5;"), "`(x + 1).powf(2.5)`");
    refused(&oscillator("let y = dot(x)**2;"), "`x.powi(2)`");
    refused(&oscillator("let y = [x].iter().map(|v| 2.0**v).sum();"), "`**` is no operator of Rust");
    refused(&oscillator("fn unused(s) = s**2;"), "`s.powi(2)`");
    refused(&oscillator("const N = 2**3;"), "`**`");
    refused(&oscillator("let y = x * *x;"), "follows a reference");
    refused(&oscillator("let y = *x;"), "follows a reference");
    refused(&oscillator("let y = -*2;"), "follows a reference");
    refused(&oscillator("let y = &*x;"), "follows a reference");
}

/// `&` and `*` stand where Rust has references.
#[test]
fn references() {
    for expression in [
        "*&x",
        "&x + x",
        "x * &x",
        "-&x",
        "(&x).sin()",
        "if &x < &0.0 { 1.0 } else { 2.0 }",
        "[x, 2.0].iter().map(|v| *v * 2.0).sum()",
        "[x, 2.0].iter().map(|v| v * v + v.sin() + dot(x)).sum()",
        "[x, 2.0].iter().map(|&v| v.powf(v)).sum()",
        "[x, 2.0].iter().copied().map(|v| v.powf(v)).sum()",
        "(&[x, 2.0]).into_iter().map(|v| *v).sum()",
        "[x, 2.0].iter().zip(&[1.0, x]).map(|(a, b)| a * *b).sum()",
        "[(x, 2.0)].iter().map(|(a, b)| a * *b).sum()",
        "[x, 2.0].iter().sum()",
        "(&[x, 2.0])[0]",
        "{ let f = |s| *s * 2.0; f(&x) }",
        "[[x, x], [1.0, x]].iter().map(|row| row[0]).sum()",
    ] {
        accepted(&oscillator(&format!("let y = {expression};")));
    }
    for (expression, part) in [
        ("&x", "a reference"),
        ("&&x * x", "a reference"),
        ("&mut x", "`mut`"),
        ("x.powf(&x)", "a reference"),
        ("x.max(&x)", "a reference"),
        ("if &x < 0.0 { 1.0 } else { 2.0 }", "a reference"),
        ("if x < 0.0 { &x } else { x }", "a reference"),
        ("[x].iter().map(|v| v.powf(v)).sum()", "a reference"),
        ("[x].into_iter().map(|v| *v).sum()", "follows a reference"),
        ("[x].map(|&v| v).sum()", "does not fit"),
        ("[x].into_iter().copied().sum()", "remove it"),
        ("(0..3).map(|i| *i * x).sum()", "follows a reference"),
        ("&x as f64", "a reference"),
        ("&2", "a reference"),
    ] {
        refused(&oscillator(&format!("let y = {expression};")), part);
    }
}

/// A suffix that is no type of Rust's is refused wherever it stands, also where nothing is evaluated.
#[test]
fn suffixes() {
    for (literal, part) in [
        ("3x", "`3 * x`"),
        ("2m", "a literal has no unit"),
        ("5kg", "a product is `5 * kg`"),
        ("10cm", "write `10`"),
        ("1e3V", "write `1e3`"),
        ("2.5_x", "no suffix"),
        ("0xfg", "write `0xf`"),
        ("0.5f32", "write `0.5`"),
        ("1f32", "write `1`"),
        ("1.5u8", "a type of integers"),
        ("0b1f64", "as f64"),
    ] {
        for statement in [
            "let y = {};",
            "param a = {};",
            "const N = {};",
            "coord z: [{}];",
            "param a: [{}];",
            "let y = [x][{}];",
            "let y = x.powi({});",
            "let y = if x < {} { 1 } else { 2 };",
            "let y = if true { x } else { {} };",
            "fn unused(s) = s * {};",
            "observe y = x - {};",
            "constraint c: x == {};",
            "force {} at x;",
            "Q[x] = {};",
            "let y: [2] = |i| {};",
            "impulse blow at [x, {}];",
        ] {
            refused(&oscillator(&statement.replace("{}", literal)), part);
        }
    }
    for statement in [
        "let y = 3f64 * x + 2.5_f64 * x + 3_f64;",
        "let y = x.powi(2i32) + [x, x][1usize];",
        "let y = 3u8 as f64 * x + (7u8 / 2u8) as f64;",
        "let y = (0u8..3u8).map(|i| i as f64 * x).sum();",
        "const N = 3usize; coord z: [2usize]; T = dot(z[0]).powi(2) + dot(z[1]).powi(2) + dot(x).powi(2);",
    ] {
        let rest = if statement.contains("T =") { "V = 0;" } else { "T = dot(x).powi(2); V = x;" };
        accepted(&format!("system A {{ coord x; {statement} {rest} }}"));
    }
    for (expression, part) in [
        ("3u8 * x", "`u8`"),
        ("x.powi(2u8)", "integer"),
        ("[x, x][1i32]", "an index is"),
        ("300u8 as f64", "overflows"),
        ("(200u8 + 100u8) as f64", "overflows"),
        ("(2u8 - 3u8) as f64", "overflows"),
        ("(2u8 - 3) as f64", "overflows"),
        ("(-3u8) as f64", "overflows"),
        ("(3u8 + 4i32) as f64", "does not mix"),
        ("2.7 as i32", "not an integer"),
        ("x as usize", "not an integer"),
        ("x as f32", "`f64`"),
        ("300 as u8 as f64", "does not hold"),
        ("(9223372036854775807 + 1) as f64", "overflows"),
        ("7 % 0", "division by zero"),
        ("(-9223372036854775807 - 1) % -1", "overflows"),
        ("1 << 3", "operators are"),
    ] {
        refused(&oscillator(&format!("let y = {expression};")), part);
    }
}

#[test]
fn arrays() {
    for (length, part) in
        [("-1", "no length"), ("0", "no elements"), ("1000000", "no length"), ("m", "integer")]
    {
        refused(&oscillator(&format!("coord z: [{length}];")), part);
    }
    refused(&oscillator("let z = [x, x]; let y = z[-1];"), "out of range");
    refused(&oscillator("let z = [x, x]; let y = z[2];"), "out of range");
    refused(&oscillator("let z = []; let y = z[0];"), "no elements");
    refused(&oscillator("let y = (0..1000000000).map(|i| i * x).sum();"), "more than");
    refused(&oscillator("let y = [[[[0; 100000]; 100000]; 100000]; 100000];"), "");
    refused(&oscillator("let y = (0..100000).map(|i| (0..100000).map(|j| i)).sum();"), "");
    refused(&oscillator("let y = (0..100000).map(|i| (0..100000)).sum();"), "");
    refused(&oscillator("let y: [3] = |i| y[i];"), "not known here");
    refused(&oscillator("let y: [3] = x;"), "expected an array of 3");
    refused(&oscillator("let y = |s| s;"), "a binding is a number");
    refused(&oscillator("let near = x < 1; observe y = near;"), "expected a number, found a condition");
    refused(&oscillator("let near = x < 1; let y = 2 * near;"), "expected a number, found a condition");
    refused(&oscillator("let near = x < 1; coord y = near;"), "a prescribed coordinate is a number");
    refused(
        &oscillator("let near = x < 1; constraint c: near == 0;"),
        "expected a number, found a condition",
    );
    refused(&oscillator("let near = x < 1; force near at x;"), "expected a number, found a condition");
    refused(&oscillator("let near = x < 1; let y = dot(near);"), "expected a number, found a condition");
    refused(&oscillator("coord y = |s| s;"), "a prescribed coordinate is a number");
    refused(&oscillator("let y = (|f| f(f))(|f| f(f));"), "too deeply");
}

/// Sizes at which a definition must still end, refused or not.
#[test]
fn sizes() {
    let deep = |open: &str, close: &str, n: usize| format!("let y = {}x{};", open.repeat(n), close.repeat(n));
    for (open, close) in
        [("(", ")"), ("[", "]"), ("-", ""), ("|a| ", ""), ("sin(", ")"), ("{ let z = ", "; z }"), ("!", "")]
    {
        for &n in if *LONG { &[10, 30, 60, 64, 500][..] } else { &[10, 64, 500] } {
            messages(&oscillator(&deep(open, close, n)));
        }
    }
    for link in [" + x", " * x", ".sin()", "[0]", " as f64", "(x)", " < x", " ^ x"] {
        for &n in if *LONG { &[50, 500, 5000][..] } else { &[50, 500] } {
            messages(&oscillator(&format!("let y = x{};", link.repeat(n))));
        }
    }
    let doubling: String = (1..60).map(|i| format!("fn f{i}(s) = f{0}(s) + f{0}(s + {i});", i - 1)).collect();
    messages(&oscillator(&format!("fn f0(s) = s.sin(); {doubling} let y = f59(x);")));
    let doubling: String = (1..60).map(|i| format!("let y{i} = y{0} * (y{0} + 1).sin();", i - 1)).collect();
    messages(&oscillator(&format!("let y0 = x; {doubling}")));
    messages("system A { coord x: [100]; T = x.map(|x| dot(x).powi(2)).sum(); V = 0; }");
    messages(
        "system A { coord x: [16]; T = x.map(|x| dot(x)).sum().powi(2) + x.map(|x| dot(x).powi(2)).sum(); V = 0; }",
    );
}

/// Literals that no number can hold, and names of other alphabets.
#[test]
fn literals_and_names() {
    let digits = "9".repeat(1000);
    for literal in [
        &digits,
        &format!("0.{digits}"),
        &format!("{digits}.{digits}e-{digits}"),
        &format!("1e-{digits}"),
        "1e308",
        "5e-324",
        "1e-400",
        "340282366920938463463374607431768211456",
        "0x_ffff_ffff_ffff_ffff_ffff",
        "1_000u8",
        "1f32",
        "1e5_usize",
        "b'x'",
        "c\"x\"",
        "0b2",
    ] {
        for statement in [
            format!("let y = {literal} * x;"),
            format!("param a = {literal};"),
            format!("const N = {literal}; coord y: [N];"),
            format!("let y = x.powi({literal});"),
            format!("let y = x.powf({literal});"),
            format!("coord y: [{literal}];"),
            format!("constraint c: x == {literal};"),
            format!("coord s = {literal} * t;"),
        ] {
            // Not all of them are tokens.
            if let Ok(tokens) = format!("@crate [::lagrange_runtime] {}", oscillator(&statement)).parse() {
                compiles_to_items(tokens);
            }
        }
    }
    for name in ["θ̈", "ℓ", "名", "ßß", "İ", "ａ", "Å", "e\u{301}", "_", "__", "ᾳ", "𝑥", "Q̇"]
    {
        let definition = format!(
            "system A {{ param {name}1; coord {name}: angle, z; T = {name}1 * (dot({name}).powi(2) + dot(z).powi(2)); V = {name}; \
             constraint {name}2: {name} == z; observe {name}3 = reaction({name}2); impulse {name}4 at {name}; }}"
        );
        if let Ok(tokens) = format!("@crate [::lagrange_runtime] {definition}").parse() {
            compiles_to_items(tokens);
        }
    }
}

/// Found by `fuzz/`, and kept: each file is a definition that once did what none may do.
#[test]
fn found_before() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzzed");
    for file in folder.read_dir().expect("the folder of definitions") {
        let text = std::fs::read_to_string(file.expect("a file").path()).expect("text");
        if let Ok(tokens) = format!("@crate [::lagrange_runtime] {text}").parse() {
            compiles_to_items(tokens);
        }
    }
}

const GOOD: [&str; 23] = [
    "pub system Orbit { param mu; coord r: length, phi: angle, psi: [angle; 2]; T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2) + dot(psi[0]).powi(2) + dot(psi[1]).powi(2)); V = -mu / r + psi[1]; observe x = [r * phi.cos(), r]; /// Radial.\n pub routhian Radial; restriction Straight: psi[0] = PI; }",
    "system Two { param m, k, c, w; coord x, y, z; let soft = 0.1 * k * x * y; coord s = 0.1 * (w * t).sin(); T = 0.5 * m * (dot(x).powi(2) + dot(y + s).powi(2) + (1 + x * x) * dot(z).powi(2)); V = 0.5 * k * (x * x + y * y + z * z) + soft; D = c * dot(x).powi(2); simplified Small: neglect soft, neglect dissipation, expand [x, z] to 2 about 0; simplified Held: lock y = 0, neglect dissipation; simplified Slow: quasistatic y, inertia at x = 0; simplified Mean: neglect soft, average w * t; }",
    "pub system Pendulum { param m, l, g = 9.81; coord theta; T = 0.5 * m * (l * dot(theta)).powi(2); V = -m * g * l * theta.cos(); }",
    "/// Two.\npub system Two { param m: [2], l: [2], g = 9.81; coord a, b; let x = l[0] * a.sin(); let y = -l[0] * cos(a); let u = x + l[1] * b.sin(); let v = y - l[1] * b.cos(); T = 0.5 * (m[0] * (dot(x).powi(2) + dot(y).powi(2)) + m[1] * (dot(u).powi(2) + dot(v).powi(2))); V = g * (m[0] * y + m[1] * v); observe tip = [u, v]; }",
    "system Chain { const N = 3; param m, k; coord x: [N]; T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2)).sum(); V = 0.5 * k * (0..N - 1).map(|i| (x[i + 1] - x[i]).powi(2)).sum() + x[0].powi(2); }",
    "system Family { const N = 3; param l: [N]; coord a: [N]; let x: [N] = |i| if i == 0 { 0.0 } else { x[i - 1] } + l[i] * a[i].sin(); T = x.map(|x| dot(x).powi(2)).sum() + a.map(|a| dot(a).powi(2)).sum(); V = x.sum(); }",
    "system Driven { param m, k, c, f; coord x; coord s = 0.1 * (3 * t).sin(); T = 0.5 * m * (dot(x) + dot(s)).powi(2); V = 0.5 * k * x.powi(2); D = 0.5 * c * dot(x).powi(2); Q[x] = f * t.cos(); }",
    "system Charge { param m, b; coord x, y; L = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + b * (x * dot(y) - y * dot(x)); }",
    "system Forced { param m, l, f; coord a; fn gust(s, w) = f * (-s * s).exp() * w; T = 0.5 * m * (l * dot(a)).powi(2); V = 0; force [gust(t, a), 0] at [l * sin(a), -l * cos(a)]; }",
    "system External { coord x, y; extern fn mu(t); T = dot(x).powi(2) + dot(y).powi(2); V = mu(x - y); Q[y] = -dot(y) * mu(t); observe s = x - y; }",
    "system Stops { param k; coord x; T = dot(x).powi(2) / 2; V = if x > 1.0 && !(x > 2) { k * (x - 1.0).powi(2) } else { 0.0 }; }",
    "system Orbit { param mu; coord r, phi; T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2)); V = -mu / r; observe area = 0.5 * r.powi(2) * dot(phi); }",
    "system Top { param i, j, h; coord psi, theta, phi; T = 0.5 * i * (dot(theta).powi(2) + (dot(psi) * theta.sin()).powi(2)) + 0.5 * j * (dot(phi) + dot(psi) * theta.cos()).powi(2); V = h * theta.cos(); }",
    "system Rod { param m, l, g; coord x, y; coord s = 0.1 * t; T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)); V = m * g * y; constraint rod: (x - s).powi(2) + y * y == l * l; observe pull = [reaction(rod), reaction(s)]; impulse blow at [x, y]; }",
    "system Skate { param m, i; coord x, y, phi; T = m * (dot(x).powi(2) + dot(y).powi(2)) + i * dot(phi).powi(2); V = 0; constraint blade: dot(x) * phi.sin() == dot(y) * phi.cos(); impulse twist at phi; }",
    "system Loop { coord a: [4]; let tip = [a.map(|a| a.sin()).sum(), a.map(|a| a.cos()).sum()]; T = a.map(|a| dot(a).powi(2)).sum(); V = 0; constraint closed: tip == [1, 2]; observe f = reaction(closed); }",
    "system Top { param m, l, A, C, mu; coord psi, theta, phi; let top = frame(world, [0, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi)); let centre = frame(top, [0, 0, l]); T = body(m, [A, A, C], centre); V = m * 9.81 * centre.origin()[2] + mu * theta; observe w = angular_velocity(top); pub routhian Reduced; }",
    "system Arm { const N = 3; param m: [N], c: [3]; coord a: [N]; let link: [N] = |i| frame(if i == 0 { world } else { link[i - 1] }, if i == 0 { [0, 0, 0] } else { [0.3, 0.2, -1] }, if i % 2 == 0 { rotation_y(a[i]) } else { rotation([1, 2, 2], a[i]) }); T = (0..N).map(|i| body(m[i], [[2, 0.1, 0], [0.1, 1, 0], [0, 0, 1]], frame(link[i], c))).sum(); V = (0..N).map(|i| m[i] * link[i].point(c)[2]).sum(); constraint held: link[2].point([0, 1, 0])[1] == 0.5; impulse blow at link[2].origin(); }",
    "system Plane { param m, i, l; coord x, a, b; coord s = 0.1 * t.sin(); let cart = frame(world, [x, s], a); let link = frame(cart, [l, 0.2], b); T = body(m, i, cart) + body(2 * m, 3 * i, frame(link, [l, 0])) + particle(m, frame(link, [0, l])); V = m * 9.81 * link.origin()[1] + link.vector([1, 2])[0]; D = dot(link.point([l, l]) - [0, s]).norm_squared() * 0; force [l, l * t] at link; couple m on link; observe f = reaction(s); }",
    "system Skate { param m, I, alpha; coord x, y, phi; let skate = frame(world, [x, y, 0], rotation_z(phi)); T = body(m, [I, I, I], skate) + particle(m, frame(skate, [0, 0, 0.5])); V = -m * sin(alpha) * skate.point([0, 0, 0.5])[0]; constraint blade: velocity(skate)[1] == 0; D = 0.5 * skate.velocity().norm_squared(); }",
    "system Ball { param m, a, f; coord x, y, psi, theta, phi; let ball = frame(world, [x, y, a], rotation_z(psi) * rotation_x(theta) * rotation_z(phi)); let spin = ball.vector(ball.angular_velocity()); T = body(m, [0.4 * m * a * a, 0.4 * m * a * a, 0.4 * m * a * a], ball); V = 0; force [f, 0, 0] at ball.origin(); constraint rolling: [dot(x), dot(y)] == [a * spin[1], -a * spin[0]]; }",
    "system Turned { param m, w; coord q, u; let r = rotation_x(w * t) * (rotation_y(q) * rotation([[0, 0, 1], [1, 0, 0], [0, 1, 0]])).inverse(); let one = frame(world, r * [1, u, 0], r); let two = frame(one, [u, 0, 1]); L = body(m, [1, 2, 2.5], one) + body(m, [1, 1, 1], two) - m * two.origin()[2]; }",
    "system Vectors { param m; coord a, b; let p = [a, b, a * b]; let v = [dot(a), dot(b), dot(a * b)]; T = 0.5 * m * v.dot(v) + m * p.cross(v).norm_squared(); V = p.norm().hypot(1.0) + { let z = p[2].min(3.0); z.atan2(2.0) }; }",
];

#[test]
fn good_systems_are_accepted() {
    GOOD.into_iter().for_each(accepted);
}

/// One token of the kind that the language is made of.
fn word() -> impl Strategy<Value = String> {
    let words = "param coord const let fn extern force at observe constraint impulse reaction routhian restriction simplified lock neglect expand to about inertia quasistatic average dissipation pub angle length T V L D Q dot t x y m k N sin sqrt powi powf \
        atan2 map sum len zip if else as f64 mut true f i world frame body particle velocity angular_velocity point vector origin \
        rotation rotation_x rotation_z inverse couple on ( ( ( ) ) ) [ [ ] ] { } = = = + - * / ^ % , , ; ; ; ; : . . .. ! \
        | | & < > == # -> 0 1 2 3 0.5 9.81 1e300 100000 -1 'a \"s\" r#type φ _ PI |i|";
    proptest::sample::select(words.split_whitespace().map(String::from).collect::<Vec<_>>())
}

/// The tokens with one change at the n-th of them, in groups as well.
fn mutated(tokens: TokenStream, n: &mut usize, kind: u8, other: &TokenTree) -> TokenStream {
    let all: Vec<TokenTree> = tokens.into_iter().collect();
    let mut result: Vec<TokenTree> = Vec::new();
    for token in all {
        let hit = *n == 0;
        *n = n.wrapping_sub(1);
        let token = match token {
            TokenTree::Group(group) if !(hit && kind == 0) => {
                let inside = mutated(group.stream(), n, kind, other);
                let delimiter = match (hit, kind, group.delimiter()) {
                    (true, 4, Delimiter::Parenthesis) => Delimiter::Bracket,
                    (true, 4, _) => Delimiter::Parenthesis,
                    (_, _, same) => same,
                };
                Group::new(delimiter, inside).into()
            }
            token => token,
        };
        match (hit, kind) {
            (false, _) | (true, 4) => result.push(token),
            (true, 0) => {}
            (true, 1) => result.extend([token.clone(), token]),
            (true, 2) => {
                let before = result.pop();
                result.push(token);
                result.extend(before);
            }
            (true, _) => result.push(other.clone()),
        }
    }
    result.into_iter().collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: if *LONG { 250 } else { 30 }, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn soup(words in proptest::collection::vec(word(), 0..60), body in any::<bool>()) {
        let soup = words.join(" ");
        let text = if body {
            format!("@crate [::lagrange_runtime] pub system A {{ {} }}", balanced(&soup))
        } else {
            format!("@crate [::lagrange_runtime] {}", balanced(&soup))
        };
        if let Ok(tokens) = text.parse() {
            compiles_to_items(tokens);
        }
    }

    #[test]
    fn soup_of_statements(words in proptest::collection::vec(word(), 0..25)) {
        let text = format!("@crate [::lagrange_runtime] {}", oscillator(&format!("let y = {};", balanced(&words.join(" ")))));
        if let Ok(tokens) = text.parse() {
            compiles_to_items(tokens);
        }
    }

    #[test]
    fn mutations(
        system in 0..GOOD.len(),
        changes in proptest::collection::vec((0usize..160, 0u8..5, word()), 1..4),
    ) {
        let mut definition: TokenStream = GOOD[system].parse().expect("tokens");
        for (place, kind, other) in changes {
            let Some(other) = other.parse::<TokenStream>().ok().and_then(|t| t.into_iter().next()) else { continue };
            definition = mutated(definition, &mut { place }, kind, &other);
        }
        let start: TokenStream = "@crate [::lagrange_runtime]".parse().expect("tokens");
        compiles_to_items(start.into_iter().chain(definition).collect());
    }
}

/// The words with brackets added or dropped so that they are tokens.
fn balanced(words: &str) -> String {
    let mut open = Vec::new();
    let mut result = String::new();
    for c in words.chars() {
        match c {
            '(' => open.push(')'),
            '[' => open.push(']'),
            '{' => open.push('}'),
            ')' | ']' | '}' => match open.pop() {
                Some(close) => {
                    result.push(close);
                    continue;
                }
                None => continue,
            },
            _ => {}
        }
        result.push(c);
    }
    result.extend(open.into_iter().rev());
    result
}

/// Tries mutations of every system of the repository for some minutes, and says how many, which took longest, and how
/// much memory was used:
///
/// ```text
/// LAGRANGE_MINUTES=20 cargo test --release -p lagrange-macros --lib -- --ignored --nocapture mutations_for_long
/// ```
///
/// An input that makes the compiler panic, take longer than [`MAX_DURATION`] or emit what is no Rust is written to
/// `tests/fuzzed`.
#[test]
#[ignore = "minutes"]
fn mutations_for_long() {
    // The compiler has the stack that rustc gives it; what is made here may be nested deeper than that.
    std::thread::Builder::new()
        .stack_size(1 << 28)
        .spawn(mutate)
        .expect("a thread")
        .join()
        .expect("no findings");
}

fn mutate() {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().expect("a number"));
    let minutes = number("LAGRANGE_MINUTES").unwrap_or(5);
    let random = &mut Random::new(number("LAGRANGE_SEED").unwrap_or(1));
    let stack = number("LAGRANGE_STACK").unwrap_or(8) as usize;
    let systems = repository();
    let words: Vec<TokenTree> = {
        let mut seen = std::collections::BTreeSet::new();
        let mut words = Vec::new();
        systems.iter().for_each(|system| leaves(system.clone(), &mut words));
        words.retain(|word| seen.insert(word.to_string()));
        words.extend(HOSTILE.iter().flat_map(|word| word.parse::<TokenStream>().expect("tokens")));
        words
    };
    println!("{} systems, {} words", systems.len(), words.len());
    let start = Instant::now();
    let (mut tried, mut accepted, mut found) = (0u64, 0u64, 0u64);
    let mut slowest = (Duration::ZERO, String::new());
    let mut next = Duration::from_secs(60);
    while start.elapsed() < Duration::from_secs(60 * minutes) {
        let mut definition = systems[random.below(systems.len())].clone();
        for _ in 0..1 + random.below(4) {
            let place = random.below(count(&definition).max(1));
            let word = words[random.below(words.len())].clone();
            definition = match random.below(10) {
                kind @ 0..8 => mutated(definition, &mut { place }, kind as u8 % 5, &word),
                8 => spliced(definition, systems[random.below(systems.len())].clone(), random),
                _ => mutated(definition, &mut { place }, 3, &nested(random, &words)),
            };
        }
        // What ends the whole process can be found there.
        let text = definition.to_string();
        std::fs::write(std::env::temp_dir().join("lagrange-last-input.txt"), &text).expect("written");
        let begin = Instant::now();
        let compiled = std::thread::Builder::new().stack_size(stack << 20).spawn(move || {
            let input: TokenStream = text.parse().expect("tokens");
            let header: TokenStream = "@crate [::lagrange_runtime]".parse().expect("tokens");
            let output = compile(header.into_iter().chain(input).collect()).to_string();
            let whole = !output.contains("compile_error");
            (output, whole)
        });
        let compiled = compiled.expect("a thread").join();
        let took = begin.elapsed();
        let sound = compiled.map(|(output, whole)| syn::parse_str::<syn::File>(&output).map(|_| whole));
        tried += 1;
        if took > slowest.0 {
            slowest = (took, definition.to_string());
        }
        match sound {
            Ok(Ok(whole)) if took < MAX_DURATION => accepted += u64::from(whole),
            wrong => {
                found += 1;
                let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzzed");
                let file = folder.join(format!("found-{}-{tried}.txt", number("LAGRANGE_SEED").unwrap_or(1)));
                std::fs::write(&file, definition.to_string()).expect("written");
                println!(
                    "{} after {took:?}: {:?}",
                    file.display(),
                    wrong.map(|r| r.map_err(|e| e.to_string())).err()
                );
            }
        }
        if start.elapsed() > next {
            next += Duration::from_secs(60);
            println!(
                "{tried} inputs, {accepted} of them systems, {found} findings, slowest {:?}, peak {}",
                slowest.0,
                peak()
            );
        }
    }
    println!("{tried} inputs, {accepted} of them systems, {found} findings, peak {}", peak());
    println!("slowest, {:?}: {}", slowest.0, slowest.1);
    assert!(found == 0, "findings are in tests/fuzzed");
}

/// Largest memory so far, where the system tells.
fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("unknown").trim().into()
}

/// The tokens between the braces of every `lagrangian! { … }` in the tests and examples, and [`GOOD`].
fn repository() -> Vec<TokenStream> {
    fn walk(folder: &std::path::Path, files: &mut Vec<std::path::PathBuf>) {
        for entry in folder.read_dir().expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                walk(&path, files);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    fn definitions(tokens: TokenStream, found: &mut Vec<TokenStream>) {
        let mut last: Vec<String> = Vec::new();
        for token in tokens {
            if let TokenTree::Group(group) = &token {
                if last.ends_with(&["lagrangian".into(), "!".into()]) {
                    found.push(group.stream());
                } else {
                    definitions(group.stream(), found);
                }
            }
            last = last.into_iter().rev().take(1).collect();
            last.push(if matches!(token, TokenTree::Group(_)) { String::new() } else { token.to_string() });
        }
    }
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let mut files = Vec::new();
    ["tests", "examples"].iter().for_each(|folder| walk(&root.join(folder), &mut files));
    files.sort();
    let mut found: Vec<TokenStream> = GOOD.iter().map(|text| text.parse().expect("tokens")).collect();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("text");
        // (Programs of `tests/ui` that are about characters are not Rust.)
        let Ok(tokens) = text.parse() else { continue };
        definitions(tokens, &mut found);
    }
    found
}

/// Numbers and names that nobody expects.
const HOSTILE: [&str; 16] = [
    "1e308",
    "5e-324",
    "1e-400",
    "0.1e999",
    "9007199254740993",
    "340282366920938463463374607431768211456",
    "0",
    "-1",
    "300",
    "1000000",
    "名",
    "θ̈",
    "r#fn",
    "dot",
    "L",
    "T",
];

fn leaves(tokens: TokenStream, into: &mut Vec<TokenTree>) {
    for token in tokens {
        match token {
            TokenTree::Group(group) => leaves(group.stream(), into),
            leaf => into.push(leaf),
        }
    }
}

/// The number of tokens, with those of groups.
pub fn count(tokens: &TokenStream) -> usize {
    let inside = |token: TokenTree| match token {
        TokenTree::Group(group) => 1 + count(&group.stream()),
        _ => 1,
    };
    tokens.clone().into_iter().map(inside).sum()
}

/// Statements between the braces of a definition.
fn statements_of(definition: &TokenStream) -> Vec<Vec<TokenTree>> {
    let body = definition.clone().into_iter().find_map(|token| match token {
        TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => Some(group.stream()),
        _ => None,
    });
    let mut statements = vec![Vec::new()];
    for token in body.into_iter().flatten() {
        let ends = matches!(&token, TokenTree::Punct(p) if p.as_char() == ';');
        statements.last_mut().expect("one").push(token);
        if ends {
            statements.push(Vec::new());
        }
    }
    statements
}

/// A definition with a statement of another one beside its own.
fn spliced(definition: TokenStream, other: TokenStream, random: &mut Random) -> TokenStream {
    let (mut own, others) = (statements_of(&definition), statements_of(&other));
    let place = random.below(own.len());
    own.insert(place, others[random.below(others.len())].clone());
    let body: TokenStream = own.into_iter().flatten().collect();
    let replaced = |token: TokenTree| match token {
        TokenTree::Group(g) if g.delimiter() == Delimiter::Brace => {
            TokenTree::from(Group::new(Delimiter::Brace, body.clone()))
        }
        token => token,
    };
    definition.into_iter().map(replaced).collect()
}

/// A word in many brackets, or under many functions.
fn nested(random: &mut Random, words: &[TokenTree]) -> TokenTree {
    let mut inside: TokenStream = words[random.below(words.len())].clone().into();
    let call: Option<TokenStream> =
        ["sin", "-", "dot", "!", "exp"].get(random.below(8)).map(|f| f.parse().expect("tokens"));
    for _ in 0..1 + random.below(200) {
        let delimiter = if random.below(20) == 0 { Delimiter::Bracket } else { Delimiter::Parenthesis };
        let group: TokenTree = Group::new(delimiter, inside).into();
        inside = call.clone().into_iter().flatten().chain([group]).collect();
    }
    Group::new(Delimiter::Parenthesis, inside).into()
}

mod sizes;
