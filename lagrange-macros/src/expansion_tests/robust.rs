//! Systems at the edge of what can be computed: the macro neither panics nor takes for ever.

use super::{compile, file, input};

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
    for (n, term) in
        [(5000, "m * cos(i * x)"), (500, "m * k[i] * cos(i * x)"), (500, "x.powi(i % 7 + 1) * k[i]")]
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
