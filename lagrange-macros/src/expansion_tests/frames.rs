//! Cost of frames: exact counts of operations of chains of hinges in space.

use super::arithmetic::agreed;
use super::{defined, input, solved};
use crate::diagnostics::Errors;
use crate::differential::LONG;
use crate::equations::assemble::{Form, flatten, pulled_back, unreduced};
use crate::equations::augmented::{ORDERS, factors};
use crate::equations::check::sample;
use crate::equations::solve::entry;
use crate::graph::{Symbol, Value};
use crate::model::model;
use proc_macro2::TokenStream;

/// n links of unit point masses off their axes, with hinges about y and x in turn (the chain of
/// docs/lab/performance.md).
pub(super) fn hinges(n: usize) -> TokenStream {
    input(&format!(
        "lagrangian! {{
            pub system Hinges {{
                const N = {n};
                coord theta: [N];
                let link: [N] = |i| frame(
                    if i == 0 {{ world }} else {{ link[i - 1] }},
                    if i == 0 {{ [0, 0, 0] }} else {{ [0.3, 0.2, -1] }},
                    if i % 2 == 0 {{ rotation_y(theta[i]) }} else {{ rotation_x(theta[i]) }}
                );
                let tip: [N] = |i| frame(link[i], [0.3, 0.2, -1]);
                T = (0..N).map(|i| particle(1, tip[i])).sum();
                V = (0..N).map(|i| 9.81 * tip[i].origin()[2]).sum();
            }}
        }}"
    ))
}

/// Operations of `accel` for each number of hinges. Pinocchio's articulated-body algorithm, generated for the same
/// chain, takes 1832 for 6 hinges and 425 for each further one.
const KNOWN: [(usize, usize); 14] = [
    (1, 4),
    (2, 69),
    (3, 249),
    (4, 472),
    (5, 755),
    (6, 1100),
    (7, 1509),
    (8, 1984),
    (9, 2309),
    (10, 2630),
    (11, 2941),
    (12, 3262),
    (16, 4526),
    (20, 5790),
];

#[test]
fn hinges_cost_as_much_as_is_known() {
    // The longest only where there is time.
    for (n, known) in KNOWN.into_iter().filter(|(n, _)| *LONG || *n <= 8) {
        let system = solved(hinges(n));
        // The count in the tokens is a second opinion, of systems that are emitted quickly.
        let operations =
            if n <= 6 { agreed("hinges", &system).0 } else { system.equations.solved.operations };
        println!("{n} hinges: {} {operations:?}", operations.arithmetic());
        let found = [operations.arithmetic(), operations.sin_cos, operations.functions];
        assert_eq!(found, [known, n, 0], "{n} hinges");
    }
}

/// M and the right-hand side as they are formed at the frames, against those of the same L, D and Q in q, q̇ and t:
/// the largest difference at some states. Nothing of the one derivation is used in the other. The accelerations of
/// each order of elimination have to satisfy these equations, too.
pub(super) fn difference(input: TokenStream) -> f64 {
    let (mut g, model) =
        model(&defined(input.clone()), &mut Errors::default()).expect("a system without errors");
    let form = Form::of(&model);
    let n = form.coordinates;
    let flat = flatten(&mut g, &form.bindings);
    let at = unreduced(&mut g, &form, &flat);
    let (inertia, right) = pulled_back(&mut g, &at);
    let mut formed: Vec<Value> = inertia.iter().flatten().chain(&right).copied().collect();
    let mut orders = 0;
    // The accelerations by every order of elimination, as right-hand sides once more.
    for order in ORDERS {
        let Some(factors) = factors(&mut g, &at, order) else { continue };
        let motion = factors.motion(&mut g, &at);
        orders += 1;
        for i in 0..n {
            formed.push((0..n).fold(Value::ZERO, |sum, j| {
                let product = g.mul(entry(&inertia, i, j), motion[j]);
                g.add(sum, product)
            }));
        }
    }
    assert!(orders >= 2, "leaves first and by degree");

    let mut e = solved(input);
    let velocities: Vec<Symbol> = (0..n).map(Symbol::Velocity).collect();
    let mut expected = Vec::new();
    let quantities = &e.equations.quantities;
    for (i, p) in quantities.momenta.iter().enumerate() {
        expected.extend(e.graph.gradient(*p, &velocities[..=i]));
    }
    for _ in 0..=orders {
        for (force, bias) in quantities.force.iter().zip(&quantities.bias) {
            expected.push(e.graph.sub(*force, *bias));
        }
    }
    let mut worst: f64 = 0.0;
    for trial in 0..4 {
        let at = |s| sample(s, trial, 17);
        let (formed, expected) = (g.evaluate(&formed, at), e.graph.evaluate(&expected, at));
        let scale = expected.iter().fold(0.0, |scale: f64, x| scale.max(x.abs()));
        let differences = formed.iter().zip(&expected).map(|(a, b)| (a - b).abs() / scale);
        worst = differences.fold(worst, f64::max);
    }
    worst
}

#[test]
fn frames_obey_lagranges_equations() {
    let systems = [
        ("hinges", hinges(7)),
        ("top", input(TOP)),
        ("two bodies", input(TWO_BODIES)),
        ("turntable", input(TURNTABLE)),
        ("arm", input(ARM)),
        ("plane", input(PLANE)),
        ("oddities", input(ODDITIES)),
        ("world axes", input(WORLD_AXES)),
    ];
    for (name, system) in systems {
        let difference = difference(system);
        println!("{name}: {difference:.1e}");
        assert!(difference < 1e-13, "{name}: {difference:e}");
    }
}

/// A heavy top by Euler's angles z-x-z, with its mass centre on the axis, drag at a point and a couple.
const TOP: &str = "lagrangian! { pub system Top {
    param A, C, m, l, g, k, mu;
    coord psi, theta, phi;
    let top = frame(world, [0, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
    let center = frame(top, [0, 0, l]);
    T = body(m, [A, A, C], center);
    V = m * g * center.origin()[2];
    force top.vector([k, 2 * k, t * k]) at top.point([l, 0, l]);
    couple [mu, dot(theta) * mu, mu * t] on top;
} }";

/// Two rigid bodies with full inertia tensors, a spring between points, a slide, and forces in body axes.
const TWO_BODIES: &str = "lagrangian! { pub system Two {
    param m, M, a, b, c, d, k, f;
    coord x, y, z, al, be, ga, s, de;
    let base = frame(world, [x, y, z], rotation_z(al) * rotation_y(be) * rotation_x(ga));
    let slide = frame(base, [a, s, -b], rotation_x(0.3) * rotation([1, 2, 2], de));
    let foot = frame(slide, [b, -c, 2 * a]);
    T = body(M, [[5 * a, 0.3 * a, 0.2 * b], [0.3 * a, 7 * b, 0.1], [0.2 * b, 0.1, 6 * c]], base)
        + body(m, [a, b, c], foot) + 0.5 * m * foot.velocity().dot([a, b, c]).powi(2)
        + 0.5 * k * angular_velocity(slide).dot(base.velocity());
    let p = base.point([b, 0, a]);
    let r = slide.point([0, d, a]) - [1, 2, 3];
    V = 0.5 * k * r.dot(r) + k * p[2] + m * 9.81 * foot.origin()[2] + M * 9.81 * z + k * base.vector([0, 1, a])[0];
    D = 0.5 * d * dot(p).norm_squared() + 0.5 * d * (angular_velocity(slide) - [0, 0, dot(de)]).norm_squared();
    force [f, 2 * f, dot(s)] at foot;
    couple [f, 0, f * t] on base;
    force [0, 0, f] at slide.point([a, a, a]);
} }";

/// A body on an arm on a turntable that turns at a given rate and rides on a given path.
const TURNTABLE: &str = "lagrangian! { pub system Turntable {
    param m, w, a, b, i;
    coord phi = w * t + 0.1 * t * t;
    coord th, ps;
    let table = frame(world, [a * (b * t).sin(), 0, 0.2 * t * t], rotation_z(phi));
    let arm = frame(table, [a + 0.1 * t, 0, b], rotation_y(th));
    let rotor = frame(arm, [0, a, b], rotation([a, b, 1], ps + w * t));
    T = body(m, [i, 2 * i, 2.5 * i], arm) + body(m, [i, i, 2 * i], rotor);
    V = m * 9.81 * (arm.origin()[2] + rotor.origin()[2]);
    observe moment = reaction(phi);
} }";

/// An arm with twisted links, a point mass at its end, and gravity along an oblique direction in which not all is
/// known.
const ARM: &str = "lagrangian! { pub system Arm {
    param m: [3], g, h;
    coord q: [4];
    let one = frame(world, [0, 0, 0.3], rotation_z(q[0]) * rotation_x(f64::consts::FRAC_PI_2));
    let two = frame(one, [0, 0.1, 0], rotation_z(q[1]) * rotation_x(-f64::consts::FRAC_PI_2));
    let three = frame(two, [0, -0.4, 0.1], rotation([[0, 0, 1], [1, 0, 0], [0, 1, 0]]) * rotation_z(q[2]));
    let four = frame(three, [0.2, 0, q[3]], rotation_y(0.4).inverse());
    T = body(m[0], [0.1, 0.2, 0.3], frame(one, [0.01, 0.02, 0.03])) + body(m[1], [0.3, 0.2, 0.1], frame(two, [0, 0.1, 0]))
        + body(m[2], [0.2, 0.3, 0.2], frame(three, [0, 0.1, 0.2])) + particle(0.7, four);
    V = m[0] * (g * one.point([0.01, 0.02, 0.03])[2] + h * one.point([0.01, 0.02, 0.03])[0])
        + m[1] * (g * two.point([0, 0.1, 0])[2] + h * two.point([0, 0.1, 0])[0])
        + m[2] * g * three.point([0, 0.1, 0.2])[2];
} }";

/// Frames in the plane: a carriage, a link on it, and a couple between them.
const PLANE: &str = "lagrangian! { pub system Plane {
    param m, i, l, c;
    coord x, a, b;
    let cart = frame(world, [x, 0.1 * x * x], a);
    let link = frame(cart, [l, 0.2], b);
    let bob = frame(link, [l, -0.1]);
    T = body(m, i, cart) + body(2 * m, 3 * i, bob) + particle(m, frame(link, [0, l]));
    V = m * 9.81 * (cart.origin()[1] + 2 * bob.origin()[1]) + link.vector([1, 2])[0];
    force [c, c * t] at bob;
    couple c on link;
    couple -c on cart;
} }";

/// Frames that never turn, that turn about one axis alone, and that are tilted for good.
const ODDITIES: &str = "lagrangian! { pub system Odd {
    param m, al, w;
    coord x, q, u;
    let tilted = frame(world, [x, 0, 0], rotation_y(al) * rotation_x(0.2));
    let fixed = frame(world, [1, 2, 3], rotation_x(al));
    let wheel = frame(fixed, [0, 0, 0], rotation_z(q));
    let rim = frame(wheel, [al, 0, u]);
    let spun = frame(rim, [0, 0, 0], rotation_x(w * t) * rotation_z(0.5) * rotation_z(u));
    T = body(m, [1, 2, 3], frame(tilted, [q, u, 1])) + body(m, [1, 2, 2.5], rim) + body(m, [1, 2, 3], spun);
    V = m * fixed.point([u, 1, x])[2] + m * rim.origin()[1] + m * spun.vector([1, 0, 0])[1];
} }";

/// Kinetic energy by velocities in the axes of the world, beside bodies that fall with it, one placed by another.
const WORLD_AXES: &str = "lagrangian! { pub system World {
    param m, a, g;
    coord x, y, z, al, be, s;
    let one = frame(world, [x, y, z], rotation_z(al) * rotation_x(be));
    let p = one.point([a, s, 1]);
    let two = frame(world, [p[1], p[0] + a, x * y], rotation_y(s));
    let q = two.point([s, a, a]);
    T = 0.5 * m * dot(p).norm_squared() + body(m, [1, 2, 3], one) + body(3 * m, [a, a, 1], two)
        + m * dot(q).dot(dot(p)) + 5 * m * dot(one.vector([a, 1, 0])).norm_squared() + m * dot(q).norm_squared();
    V = m * g * (z + p[2] + 3 * two.origin()[2] + q[2]);
} }";
