//! Systems at the edge of what can be computed: the macro neither panics nor takes for ever.

use super::{compile, file, input, solved};
use crate::differential::LONG;
use crate::graph::Symbol;

/// Compiles the body of a system; true if it was accepted, and then what is emitted are items.
fn accepted(body: &str) -> bool {
    let tokens = compile::compile(input(&format!("lagrangian! {{ pub system Edge {{ {body} }} }}")));
    let errors = tokens.to_string().contains("compile_error");
    file(tokens);
    !errors
}

/// Products of large constants overflow only while the equations are solved.
#[test]
fn overflowing_constants_are_written() {
    assert!(accepted(
        "coord x, y;
         T = 1e200 * (dot(x).powi(2) + dot(y).powi(2) + dot(x) * dot(y) * cos(x));
         V = 0;"
    ));
}

/// Left-deep sums, with and without a factor in common.
#[test]
fn long_sums() {
    let long = if *LONG { 5000 } else { 400 };
    for (n, term) in
        [(long, "m * cos(i * x)"), (200, "m * k[i] * cos(i * x)"), (200, "x.powi(i % 7 + 1) * k[i]")]
    {
        assert!(accepted(&format!(
            "const N = {n}; param m, k: [N]; coord x;
             T = 0.5 * m * dot(x).powi(2);
             V = (0..N).map(|i| {term}).sum() + m * k[0];"
        )));
    }
}

/// Each binding uses the one before twice, each choice has the one before in both branches.
#[test]
fn what_is_shared_is_not_written_out() {
    assert!(accepted(
        "param m; coord x;
         let y: [40] = |i| if i == 0 { x } else { y[i - 1] * y[i - 1] + y[i - 1] };
         T = 0.5 * m * dot(x).powi(2);
         V = y[39];"
    ));
    assert!(accepted(
        "param m; coord x;
         fn fold(s) = if s < 0.0 { -s } else { s - 1 };
         fn four(s) = fold(fold(fold(fold(s))));
         T = 0.5 * m * dot(x).powi(2);
         V = four(four(four(four(four(four(four(four(x))))))));"
    ));
}

/// A condition with a name is the condition where it is used.
#[test]
fn conditions_may_have_names() {
    for (lets, condition) in [
        ("", "x > 0 && !(t < 1 || dot(x) > 2)"),
        ("let right = x > 0; let early = t < 1;", "right && !(early || dot(x) > 2)"),
        ("let c = [x > 0, t < 1]; let all = c[0] && !(c[1] || dot(x) > 2);", "all"),
        ("let c: [2] = |i| (if i == 0 { x } else { t - 1 }) > 0;", "c[0] && !(!c[1] || dot(x) > 2)"),
        ("let always = true;", "always && x > 0 && !(t < 1 || dot(x) > 2)"),
    ] {
        let e = solved(input(&format!(
            "lagrangian! {{ system Gate {{
                coord x; {lets} T = 0.5 * dot(x).powi(2); V = 0; Q[x] = if {condition} {{ 1 }} else {{ 0 }};
            }} }}"
        )));
        assert_eq!(e.equations.responses.switches.len(), 3, "{lets}");
        for place in 0..8 {
            let [x, v, t] = [0, 1, 2].map(|bit| place >> bit & 1 == 1);
            let at = |symbol| match symbol {
                Symbol::Coordinate(_) => {
                    if x {
                        0.5
                    } else {
                        -0.5
                    }
                }
                Symbol::Velocity(_) => {
                    if v {
                        2.5
                    } else {
                        1.5
                    }
                }
                _ => {
                    if t {
                        1.5
                    } else {
                        0.5
                    }
                }
            };
            let expected = if x && t && !v { 1.0 } else { 0.0 };
            assert_eq!(e.graph.evaluate(&e.equations.solved.accel, at), [expected], "{lets}");
        }
    }
}

/// `clamp` at both bounds, between them, and where its argument has no value.
#[test]
fn clamp_is_that_of_rust() {
    let e = solved(input(
        "lagrangian! { system Edge { coord x; T = 0.5 * dot(x).powi(2); V = 0; Q[x] = (2 * sqrt(x)).clamp(0.5, 1); } }",
    ));
    for x in [0.0, 0.0625, 0.1, 0.25, 4.0, -1.0] {
        let found = e.graph.evaluate(&e.equations.solved.accel, |_| x)[0];
        assert_eq!(found.to_bits(), (2.0 * f64::sqrt(x)).clamp(0.5, 1.0).to_bits(), "{x}");
    }
}

/// The inertia matrix of an axle whose centre of mass is off its middle by c is positive definite for c < 0.77.
#[test]
fn inertia_is_that_of_the_default_values() {
    let axle = |c: &str| {
        accepted(&format!(
            "param c = {c}; coord x, y, p;
             T = dot(x).powi(2) + dot(y).powi(2) + 0.15 * dot(p).powi(2) + c * dot(p) * (dot(y) * cos(p) - dot(x) * sin(p));
             V = 0;
             redundant constraint left: dot(x) * sin(p) == dot(y) * cos(p);
             redundant constraint right: dot(x) * sin(p) - dot(y) * cos(p) == 0;"
        ))
    };
    assert!(axle("0.1") && !axle("0.9"));
}
