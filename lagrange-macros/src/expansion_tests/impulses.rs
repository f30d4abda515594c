//! Conditions on which impulses act, however they are written.

use super::{input, solved};

/// Numbers of switches with impulses of a system with these statements.
fn impulses(statements: &str) -> usize {
    let text = format!(
        "lagrangian! {{ system Any {{ param e = 1, big = 30, k = 1e3; coord x, y; {statements} }} }}"
    );
    solved(input(&text)).equations.impulses.switches.len()
}

const T: &str = "T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));";

#[test]
fn potentials_that_jump_are_found() {
    for (condition, count) in [
        // Beside other conditions.
        ("x > e && y > 5", 2),
        ("x > e && y < -1", 2),
        ("big > 10 && x > e", 1),
        ("x > 10 && x < 11 && y > 10 && y < 11", 4),
        ("abs(x - 10) < 0.5 && abs(y - 10) < 0.5", 2),
        // In places of any size.
        ("hypot(x - 3, y - 2) < 0.1", 1),
        ("(x - 3).powi(2) + (y - 2).powi(2) < 0.01", 1),
        ("hypot(x - 30, y - 20) < 5", 1),
        ("min(x, y) > 1", 1),
        ("x > 1e9", 1),
        ("x > 1e-3", 1),
        // Behind functions.
        ("x * x > 1e4", 1),
        ("x.powi(3) > 1e6", 1),
        ("exp(x) > 100", 1),
        ("exp(-x) < 0.01", 1),
        ("cosh(x) > 1e5", 1),
        ("ln(x) > 5", 1),
        ("sqrt(x) > 30", 1),
        ("tanh(x - 5) > 0.9", 1),
        ("1 / (1 + x * x) < 0.001", 1),
        ("atan2(x, 1) > 1.5", 1),
    ] {
        for size in [-0.1, 1e-7] {
            let found = impulses(&format!("{T} V = if {condition} {{ {size} }} else {{ 0 }};"));
            assert_eq!(found, count, "{condition}, {size}");
        }
    }
    // An instant of time alone is none.
    assert_eq!(impulses(&format!("{T} V = if x > e && t > 2 {{ 1 }} else {{ 0 }};")), 1);
    assert_eq!(impulses(&format!("{T} V = if x > 1 {{ max(y - 3, 0) }} else {{ 0 }};")), 1);
    assert_eq!(impulses(&format!("{T} V = if x * (x - 1) > 0 {{ x }} else {{ 0 }};")), 1);
    let light = "T = 0.5e-9 * (dot(x).powi(2) + dot(y).powi(2)); V = if x > 1 { 1e-10 } else { 0 };";
    assert_eq!(impulses(light), 1);
}

#[test]
fn momenta_and_positions_that_jump_are_found() {
    for statements in [
        "T = 0.5 * dot(x).powi(2) * if exp(x) > 1e4 { 2 } else { 1 } + dot(y).powi(2); V = 0;",
        "coord p = max(t * t - 2500, 0); T = 0.5 * (dot(x) + dot(p)).powi(2) + dot(y).powi(2); V = 0;",
        "coord p = max(exp(0.1 * t) - 100, 0); T = 0.5 * (dot(x) + dot(p)).powi(2) + dot(y).powi(2); V = 0;",
        "coord p = 1e-6 * max(t - 1, 0); T = 0.5 * (dot(x) + dot(p)).powi(2) + dot(y).powi(2); V = 0;",
        "coord p = if t > 70 { 0.1 } else { 0 }; T = 0.5 * (dot(x) + dot(p)).powi(2) + dot(y).powi(2); V = 0;",
    ] {
        assert_eq!(impulses(statements), 1, "{statements}");
    }
}

#[test]
fn forces_that_jump_have_none() {
    for potential in [
        "9.81 * x + 50 * max(-x, 0).powi(2) + if x > 2 { 100 * (x - 2) } else { 0 }",
        "if hypot(x - 3, y - 2) < 0.1 { k * (0.1 - hypot(x - 3, y - 2)).powi(2) } else { 0 }",
        "if x < -1 { 0.5 } else if x > 1 { 0.5 } else { 0.5 * x * x }",
        "clamp(x, -3, 3) * 1e5 + sin(1000 * max(x - 7, 0))",
        "if x > 0.3 { 0.09 + 0.6 * (x - 0.3) } else { x * x }",
        "if y > 2 && x > 1 { (x - 1) * (y - 2) } else { 0 }",
        "abs(x - e) * k + min(x, y)",
    ] {
        assert_eq!(impulses(&format!("{T} V = {potential};")), 0, "{potential}");
    }
}

/// Cuts of an angle at which the potential jumps, or a prescribed position, and those at which nothing does.
#[test]
fn cuts_are_found() {
    for (statements, count) in [
        // The angle of a torsional spring, however it is written.
        ("V = hypot(x, y) + k * (atan2(y, x) - 1).powi(2);", 1),
        ("let phi = atan2(y, x); V = hypot(x, y) + k * (phi - 1).powi(2);", 1),
        ("V = k * (atan(y / x) - 1).powi(2);", 1),
        ("V = k * atan2(y, cos(x)).powi(3);", 1),
        ("V = k * tanh(y / (x - 3));", 1),
        ("V = atan2(x, -2);", 1),
        ("V = k * x / abs(x);", 1),
        ("V = k * x * y / sqrt(x * x);", 1),
        ("V = atan2(x, 0) * k;", 1),
        ("V = k / (1 + exp(1 / x));", 1),
        ("V = k * atan(1 / x + 3) + k * tanh(sin(x) + 2 / x);", 1),
        // Narrow, in the middle of nowhere and at a quarter turn.
        ("V = if (x - 2).powi(2) + (y - 3).powi(2) < 1e-4 { -e } else { 0 };", 1),
        ("V = if sin(x).powi(2) > 0.999999 { k } else { 0 };", 1),
        // A rail that is moved as a saw.
        (
            "coord p = e * atan2(sin(3 * t), cos(3 * t)); T = (dot(x) + dot(p)).powi(2) + dot(y).powi(2); V = x * x;",
            1,
        ),
        // Equal energies on both sides, whole turns, and angles that stay away from the cut.
        ("V = k * atan2(y, x).powi(2);", 0),
        ("let phi = atan2(y, x); V = x * cos(phi) - y * sin(2 * phi);", 0),
        ("V = k * atan2(y, 1).powi(2) + k * atan2(x, exp(y)).powi(2) + k * atan2(x, 2 + y * y).powi(2);", 0),
        ("V = k * atan(y / (1 + x * x)).powi(2) + k * asin(sin(x)) + k * tanh(y / e);", 0),
        ("V = k * atan2(abs(y), x).powi(2);", 0),
        ("V = k * exp(-x * x / (2 + y * y)) + k * x * x / abs(x);", 0),
    ] {
        let kinetic = if statements.contains("T =") { "" } else { T };
        assert_eq!(impulses(&format!("{kinetic} {statements}")), count, "{statements}");
    }
    // The velocity of an angle goes on.
    let angle =
        "let phi = atan2(y, x); T = dot(x).powi(2) + dot(y).powi(2) + dot(phi).powi(2); V = hypot(x, y);";
    assert_eq!(impulses(angle), 0);
    // A momentum that depends on the angle does not.
    let momentum = "T = dot(x).powi(2) + (2 + atan2(y, x)) * dot(y).powi(2); V = 0;";
    assert_eq!(impulses(momentum), 1);
}
