//! Rotations that are coordinates: their equations against those of the same L, D and Q in the parameters, and their
//! operations against those of the same bodies by Euler's angles.

use super::arithmetic::agreed;
use super::frames::difference;
use super::{input, solved};
use crate::differential::LONG;

#[test]
fn attitudes_obey_lagranges_equations() {
    for (name, system) in [("free", FREE), ("jointed", JOINTED), ("composed", COMPOSED)] {
        let difference = difference(input(system));
        println!("{name}: {difference:.1e}");
        assert!(difference < 1e-13, "{name}: {difference:e}");
    }
}

/// A body in space under forces, couples and moments.
const FREE: &str = "lagrangian! { pub system Free {
    param m, a, b, c, g, d, k;
    coord x: [3], R: rotation;
    let hull = frame(world, x, R);
    let keel = frame(hull, [a, 0, b]);
    T = body(m, [[5 * a, 0.3 * a, 0.2 * b], [0.3 * a, 7 * b, 0.1], [0.2 * b, 0.1, 6 * c]], keel);
    V = m * g * keel.origin()[2] + k * (R * [1, 2, 3])[0] * x[1];
    D = 0.5 * d * dot(R).norm_squared() + 0.5 * d * dot(hull.point([0, b, a])).norm_squared();
    Q[R] = [k, k * t, dot(x[0])];
    force [a, b, c] at hull.point([b, 0, a]);
    couple [k, k * t, c] on keel;
} }";

/// Bodies on ball joints, of which one hangs on a hinge, one turned by numbers as well.
const JOINTED: &str = "lagrangian! { pub system Jointed {
    param m, a, b, c, g, d;
    coord R: [rotation; 2], q, P: rotation;
    let one = frame(world, [a, 0.1 * t, 0], R[0]);
    let two = frame(one, [0, b, -1], R[1] * rotation_x(0.3));
    let three = frame(two, [a, 0, c], rotation_z(q));
    let four = frame(three, [q, a, 0.2], rotation_y(0.7) * P);
    T = body(m, [a, 2 * a, 2.5 * a], one) + body(m, [b, 2 * b, 2.5 * b], frame(two, [0, 0, -1]))
        + body(m, [1, 2, 2.5], three) + body(2 * m, [c, 2 * c, 2.2 * c], four);
    V = m * g * (one.origin()[2] + two.point([0, 0, -1])[2] + three.origin()[2] + 2 * four.origin()[2])
        + 0.5 * a * (four.origin() - [1, 2, 3]).norm_squared();
    D = 0.5 * d * (dot(R[1]).norm_squared() + dot(P).norm_squared());
    Q[R] = [[a, b, c], [b, c, t]];
} }";

/// Relative velocities in T, reversed rotations, products of free ones, and axes of one body in another.
const COMPOSED: &str = "lagrangian! { pub system Composed {
    param m, a, b, w;
    coord R: rotation, P: rotation, s;
    let platform = frame(world, [0, 0, s], rotation_z(w * t));
    let one = frame(platform, [a, 0, 0], R);
    let two = frame(platform, [0, a, b], P.inverse() * rotation_z(s));
    let both = frame(world, [s, 0, 0], R * P);
    T = body(m, [a, 2 * a, 2.5 * a], one) + body(m, [b, 2 * b, 2.5 * b], two) + body(m, [1, 2, 2.5], both)
        + 0.5 * a * dot(R).norm_squared() + 0.5 * b * (dot(P) + dot(R * P)).norm_squared() + 0.5 * m * dot(s).powi(2);
    let n = R * [1, 2, a];
    V = (P * [0, 1, b]).dot(n) + m * one.vector([1, 0, 0])[2];
} }";

/// `accel` of a body by a rotation and by Euler's angles: operations, and their cost with a sine for 40 of them.
#[test]
fn attitudes_cost_less_than_angles() {
    let system = |name: &str, coordinates: &str, rotation: &str, rest: &str| {
        let text = format!(
            "lagrangian! {{ pub system Body {{
                param m, A, B, C, l, g;
                coord {coordinates};
                let body0 = frame(world, [0, 0, 0], {rotation});
                {rest}
            }} }}"
        );
        let (operations, _) = agreed(name, &solved(input(&text)));
        operations
    };
    let free = "T = body(m, [A, B, C], body0); V = 0;";
    let heavy =
        "T = body(m, [A, B, C], frame(body0, [0, 0, l])); V = m * g * l * body0.vector([0, 0, 1])[2];";
    let angles = ["a, b, c", "rotation_z(a) * rotation_x(b) * rotation_z(c)"];
    for (name, rest, known) in [("free", free, [122, 63]), ("heavy", heavy, [136, 69])] {
        let [by_rotation, by_angles] = [["R: rotation", "R"], angles]
            .map(|[coordinates, rotation]| system(name, coordinates, rotation, rest));
        println!("{name}: {by_rotation:?}, by angles {by_angles:?}");
        assert_eq!([by_rotation.divisions, by_rotation.sin_cos, by_rotation.functions], [1, 0, 0], "{name}");
        assert!(
            by_rotation.cost() <= by_angles.cost(),
            "{name}: {} {}",
            by_rotation.cost(),
            by_angles.cost()
        );
        assert_eq!([by_rotation.arithmetic(), by_angles.arithmetic()], known, "{name}");
    }
}

/// `accel` of a spherical pendulum by a direction, by angles with poles, and by the rotation of a body without a
/// moment about the rod.
#[test]
fn directions_need_no_sines() {
    let operations = |name: &str, body: &str| {
        let text = format!("lagrangian! {{ pub system Pendulum {{ param m, l, g, s; {body} }} }}");
        let (operations, _) = agreed(name, &solved(input(&text)));
        println!("{name}: {operations:?}");
        operations
    };
    let direction = operations(
        "direction",
        "coord n: direction; T = 0.5 * m * l * l * dot(n).norm_squared(); V = m * g * l * n[2];",
    );
    let angles = operations(
        "angles",
        "coord theta, phi; T = 0.5 * m * l * l * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2)); V = m * g * l * theta.cos();",
    );
    let rotation = operations(
        "rotation",
        "coord R: rotation; T = body(0, [m * l * l, m * l * l, s], frame(world, [0, 0, 0], R)); V = m * g * l * (R * [0, 0, 1])[2];",
    );
    assert_eq!([direction.sin_cos, direction.functions], [0, 0]);
    assert!(direction.cost() < angles.cost() && direction.cost() < rotation.cost());
}

/// Operations of `accel` of a chain of n bodies on ball joints: linear in n.
#[test]
fn chains_on_ball_joints_cost_a_constant_number_a_body() {
    let chain = |n: usize| {
        let text = format!(
            "lagrangian! {{ pub system Chain {{
                const N = {n};
                coord R: [rotation; N];
                let link: [N] = |i| frame(
                    if i == 0 {{ world }} else {{ link[i - 1] }},
                    if i == 0 {{ [0, 0, 0] }} else {{ [0, 0, -1] }},
                    R[i]
                );
                let bob: [N] = |i| frame(link[i], [0.01, 0.02, -0.5]);
                T = (0..N).map(|i| body(1, [0.1, 0.11, 0.01], bob[i])).sum();
                V = (0..N).map(|i| 9.81 * bob[i].origin()[2]).sum();
            }} }}"
        );
        solved(input(&text))
    };
    let count = |n: usize| chain(n).equations.solved.operations.arithmetic();
    let found: Vec<usize> = (1..=5).map(count).collect();
    assert_eq!(found, [165, 734, 1651, 2530, 3261]);
    // As many are emitted.
    assert_eq!(agreed("three", &chain(3)).0.arithmetic(), 1651);
    if *LONG {
        // 615 for each body.
        assert_eq!(agreed("eight", &chain(8)).0.arithmetic(), 5106);
        assert_eq!(count(16), 10026);
    }
}

/// Products of series, and operations, of an order of the series of bodies that turn.
#[test]
fn series_of_attitudes_have_few_products() {
    let chain = |n: usize| {
        format!(
            "const N = {n};
            coord R: [rotation; N];
            let link: [N] = |i| frame(
                if i == 0 {{ world }} else {{ link[i - 1] }},
                if i == 0 {{ [0, 0, 0] }} else {{ [0, 0, -1] }},
                R[i]
            );
            let bob: [N] = |i| frame(link[i], [0.01, 0.02, -0.5]);
            T = (0..N).map(|i| body(1, [0.1, 0.11, 0.01], bob[i])).sum();
            V = (0..N).map(|i| 9.81 * bob[i].origin()[2]).sum();"
        )
    };
    let (two, eight) = (chain(2), chain(8));
    let free = "param A, B, C; coord R: rotation; T = body(1, [A, B, C], frame(world, [0, 0, 0], R)); V = 0;";
    let heavy = "param m, A, B, C, l, g; coord R: rotation; let hull = frame(world, [0, 0, 0], R);
        T = body(m, [A, B, C], frame(hull, [0, 0, l])); V = m * g * l * hull.vector([0, 0, 1])[2];";
    let torque = "param m, A, B, C, l, g; coord R: rotation; T = body(1, [A, B, C], frame(world, [0, 0, 0], R)); V = 0;
        Q[R] = R.inverse() * [m, g * t, l];";
    let place = "param m, A, B, C, g; coord x: [3], R: rotation; T = body(m, [A, B, C], frame(world, x, R));
        V = m * g * x[2];";
    let systems = [
        ("free body", free, [18, 169]),
        ("heavy top", heavy, [24, 228]),
        ("torque by axes of the world", torque, [30, 292]),
        ("in space", place, [18, 172]),
        ("two on ball joints", &two, [101, 1020]),
        ("eight on ball joints", &eight, [527, 6218]),
    ];
    let mut wrong = Vec::new();
    // The longest only where there is time.
    let shown = if *LONG { systems.len() } else { systems.len() - 1 };
    for (name, body, known) in systems.into_iter().take(shown) {
        let system = solved(input(&format!("lagrangian! {{ pub system Body {{ {body} }} }}")));
        let series = system.equations.series.as_ref().expect("a series");
        let found = [series.recurrence.convolutions.len(), series.program.operations().arithmetic()];
        println!("{name}: {found:?}");
        for tried in &series.tried {
            println!("  {}: {}{}", tried.way, tried.cost, if tried.is_bound { " at least" } else { "" });
        }
        wrong.extend((found != known).then_some(name));
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
