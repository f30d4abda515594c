//! Long and deep systems: every kind of statement in many coordinates, and expressions nested beyond what is allowed.

use super::{messages, oscillator};
use crate::differential::LONG;

/// Many of everything that the newer statements are made of, and each of them nested deeply.
#[test]
fn sizes_of_statements() {
    many_statements(&[3, 30]);
}

/// Systems of many coordinates with each kind of statement.
fn many_statements(sizes: &[usize]) {
    let many = |n: usize, statements: &str| {
        format!(
            "system A {{ const N = {n}; coord x: [N]; T = x.map(|x| dot(x).powi(2)).sum(); V = 0; {statements} }}"
        )
    };
    for &n in sizes {
        messages(&many(n, ""));
        messages(&many(n, "constraint c: x.sum() == t; observe f = reaction(c); impulse blow at x;"));
        messages(&many(n, "constraint c: (1..N).map(|i| x[i] - x[i - 1]).collect() == [0; N - 1];"));
        messages(&many(
            n,
            "constraint c: (0..N / 2).map(|i| x[i] * dot(x[N - 1 - i])).collect() == [t; N / 2];",
        ));
        messages(&many(
            n,
            "constraint c: [x.map(|x| x * x).sum(), x.map(|x| x.sin()).sum()] == [1, 0]; observe f = reaction(c);",
        ));
        messages(&many(
            n,
            "coord s: [N] = |i| (i * t).sin(); observe f = (0..N).map(|i| reaction(s[i])).collect();",
        ));
        messages(&many(n, "pub routhian Reduced;"));
        messages(&many(n, "coord y: angle; Q[y] = y; pub routhian Reduced;"));
        let separate: String = (0..n).map(|i| format!("constraint c{i}: x[{i}] == dot(x[0]);")).collect();
        messages(&many(n, &separate));
        let separate: String =
            (0..n).map(|i| format!("coord y{i}: angle; impulse b{i} at [x[{i}], t];")).collect();
        messages(&many(n, &separate));
    }
}

#[test]
fn depths_of_statements() {
    for n in [10, 60, 500] {
        for (open, close) in
            [("(", ")"), ("[", "]"), ("-", ""), ("sin(", ")"), ("{ let z = ", "; z }"), ("dot(", ")")]
        {
            let deep = format!("{}x{}", open.repeat(n), close.repeat(n));
            for statement in [
                format!("constraint c: {deep} == 0;"),
                format!("impulse blow at {deep};"),
                format!("observe r = reaction({deep});"),
                format!("force {deep} at {deep};"),
                format!("Q[{deep}] = {deep};"),
                format!("coord s = {deep};"),
                format!("coord y: {deep};"),
            ] {
                messages(&oscillator(&statement));
            }
        }
    }
}

#[test]
fn sizes_of_frames() {
    long_chains(&[2, 8]);
}

#[test]
#[ignore = "a minute"]
fn large_systems() {
    many_statements(&[100, 200]);
    long_chains(&[24]);
}

/// Long chains of frames, rotations and bodies.
fn long_chains(sizes: &[usize]) {
    for &n in sizes {
        let chain = |rest: &str| {
            format!(
                "system A {{ const N = {n}; coord a: [N]; let f: [N] = |i| frame(if i == 0 {{ world }} else {{ f[i - 1] }}, \
                 [0, 0, 1], if i % 2 == 0 {{ rotation_x(a[i]) }} else {{ rotation_y(a[i]) }}); \
                 T = (0..N).map(|i| body(1, [1, 2, 3], f[i])).sum(); V = 0; {rest} }}"
            )
        };
        messages(&chain(""));
        messages(&chain(
            "force [1, 2, 3] at f[N - 1]; couple [t, 2, 3] on f[N - 1]; impulse blow at f[N - 1].origin();",
        ));
        messages(&chain("constraint c: f[N - 1].point([1, 1, 1])[0] == 1; observe r = reaction(c);"));
        messages(&chain("D = (0..N).map(|i| f[i].velocity().norm_squared()).sum();"));
        if n <= 8 {
            messages(&chain(
                "coord z: angle; routhian Reduced; let g = frame(f[0], [z, 0, 0]); D = dot(a[0]).powi(2);",
            ));
        }
    }
}

/// Each word of frames nested deeply, or given the other's arguments.
#[test]
fn depths_of_frames() {
    let one = |statements: &str| {
        format!("system A {{ coord x, y; {statements} T = dot(x).powi(2) + dot(y).powi(2); V = 0; }}")
    };
    for &n in if *LONG { &[2, 63, 500][..] } else { &[2, 63] } {
        let turns = vec!["rotation_x(x)"; n].join(" * ");
        messages(&one(&format!("let f = frame(world, [0, 0, 0], {turns});")));
        messages(&one(&format!("let f = frame(world, [0, 0, 0], {turns}); let w = angular_velocity(f);")));
        for (open, close) in [
            ("frame(", ", [0, 0, 1], rotation_y(x))"),
            ("frame(", ", [x, 0])"),
            ("rotation_x(", ")"),
            ("(rotation_x(x) * ", ").inverse()"),
            ("velocity(", ")"),
            ("body(", ", [1, 1, 1], world)"),
            ("(rotation_z(y) * ", ")"),
        ] {
            let few = n > 2 && !*LONG;
            for inside in
                ["world", "x", "rotation_y(x)", "[x, y, 1]"].into_iter().skip(if few { 2 } else { 0 })
            {
                let deep = format!("{}{inside}{}", open.repeat(n), close.repeat(n));
                messages(&one(&format!("let f = {deep};")));
                messages(&one(&format!("force [1, 0, 0] at {deep}; couple {deep} on {deep};")));
            }
        }
    }
    let values = [
        "world",
        "x",
        "dot(x)",
        "[x, y, 0]",
        "[x, y]",
        "rotation_x(x)",
        "frame(world, [x, 0])",
        "frame(world, [x, 0, y])",
        "true",
        "|i| i",
    ];
    let pairs = values.iter().flat_map(|a| values.iter().map(move |b| (a, b)));
    // Every seventh pair, unless there is time: 7 does not divide the number of values, so that each is in some.
    for (a, b) in pairs.step_by(if *LONG { 1 } else { 7 }) {
        for word in ["frame", "body", "particle", "velocity", "rotation", "rotation_y", "dot"] {
            messages(&one(&format!(
                "let f = {word}({a}, {b}); let g = {word}({a}); let h = {word}({b}, {a}, {b});"
            )));
        }
        for method in ["point", "vector", "origin", "velocity", "inverse", "dot", "cross"] {
            messages(&one(&format!("let f = ({a}).{method}({b});")));
        }
        for sign in ["*", "+", "/", "<", "=="] {
            messages(&one(&format!("let f = ({a}) {sign} ({b});")));
        }
        messages(&one(&format!("force {a} at {b};")));
        messages(&one(&format!("couple {a} on {b};")));
        messages(&one(&format!("impulse p at {a}; observe o = {b}; constraint c: {a} == {b};")));
        messages(&one(&format!("coord s = {a}; param p = {b};")));
    }
}
