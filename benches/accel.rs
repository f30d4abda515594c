//! Emitted `accel` against what an expert writes by hand: ratios of times in one run.
//!
//! `cargo bench --bench accel`
//!
//! Both sides get the same states and the same parameters, use the standard library's sine and cosine, and are inlined
//! into the same loop. Last come bodies whose attitude is a rotation, against the same bodies by Euler's angles, both
//! emitted, in attitudes far from the angles' poles.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::rotation::EulerAngles;
use nalgebra::SVector;
use std::hint::black_box;
use support::systems::{DoublePendulum, Kepler, Pendulum};
use support::{Random, consume, ratio};

lagrangian! {
    pub system Top {
        param m, l, g, I1, I3;
        coord phi, theta, psi;
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2))
            + 0.5 * I3 * (dot(psi) + dot(phi) * theta.cos()).powi(2);
        V = m * g * l * theta.cos();
    }
}

lagrangian! {
    pub system Chain {
        const N = 6;
        param g;
        coord th: [N];
        let x: [N] = |i| if i == 0 { th[0].sin() } else { x[i - 1] + th[i].sin() };
        let y: [N] = |i| if i == 0 { -th[0].cos() } else { y[i - 1] - th[i].cos() };
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| g * y[i]).sum();
    }
}

lagrangian! {
    /// A heavy body about a point.
    pub system Turned {
        param mgl = 2.0;
        coord R: rotation;
        let hull = frame(world, [0, 0, 0], R);
        T = body(0, [1.0, 1.5, 0.8], hull);
        V = mgl * hull.vector([0, 0, 1])[2];
    }
}

lagrangian! {
    /// The same body by Euler's angles.
    pub system Angles {
        param mgl = 2.0;
        coord psi, theta, phi;
        let hull = frame(world, [0, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
        T = body(0, [1.0, 1.5, 0.8], hull);
        V = mgl * hull.vector([0, 0, 1])[2];
    }
}

lagrangian! {
    /// Two bodies on ball joints.
    pub system TwoTurned {
        param g = 9.81;
        coord R: [rotation; 2];
        let upper = frame(world, [0, 0, 0], R[0]);
        let lower = frame(frame(upper, [0, 0, -1]), [0, 0, 0], R[1]);
        let one = frame(upper, [0, 0.1, -0.5]);
        let two = frame(lower, [0, 0.1, -0.5]);
        T = body(1, [0.1, 0.15, 0.08], one) + body(1, [0.1, 0.15, 0.08], two);
        V = g * (one.origin()[2] + two.origin()[2]);
    }
}

lagrangian! {
    /// The same bodies by Euler's angles.
    pub system TwoAngles {
        param g = 9.81;
        coord a: [3], b: [3];
        let upper = frame(world, [0, 0, 0], rotation_z(a[0]) * rotation_x(a[1]) * rotation_z(a[2]));
        let lower = frame(frame(upper, [0, 0, -1]), [0, 0, 0], rotation_z(b[0]) * rotation_x(b[1]) * rotation_z(b[2]));
        let one = frame(upper, [0, 0.1, -0.5]);
        let two = frame(lower, [0, 0.1, -0.5]);
        T = body(1, [0.1, 0.15, 0.08], one) + body(1, [0.1, 0.15, 0.08], two);
        V = g * (one.origin()[2] + two.origin()[2]);
    }
}

type Vector<const N: usize> = SVector<f64, N>;

#[inline]
fn pendulum(s: &Pendulum, q: &Vector<1>, _: &Vector<1>) -> Vector<1> {
    [-(s.g / s.l) * q[0].sin()].into()
}

#[inline]
fn kepler(s: &Kepler, q: &Vector<2>, v: &Vector<2>) -> Vector<2> {
    let inverse = 1.0 / q[0];
    [q[0] * v[1] * v[1] - s.mu * inverse * inverse, -2.0 * v[0] * v[1] * inverse].into()
}

/// The two equations solved by hand, the sine and cosine of the difference from those of the angles.
#[inline]
fn double_pendulum(p: &DoublePendulum, q: &Vector<2>, v: &Vector<2>) -> Vector<2> {
    let ((s1, c1), (s2, c2)) = (q[0].sin_cos(), q[1].sin_cos());
    let (s, c) = (s1 * c2 - c1 * s2, c1 * c2 + s1 * s2);
    let m = p.m1 + p.m2;
    let d = m - p.m2 * c * c;
    let (w1, w2) = (p.l1 * v[0] * v[0] * s, p.l2 * v[1] * v[1] * s);
    let (g1, g2) = (p.g * s1, p.g * s2);
    [
        (p.m2 * (c * (g2 - w1) - w2) - m * g1) / (p.l1 * d),
        (m * (c * g1 + w1 - g2) + p.m2 * c * w2) / (p.l2 * d),
    ]
    .into()
}

#[inline]
fn top(p: &Top, q: &Vector<3>, v: &Vector<3>) -> Vector<3> {
    let (s, c) = q[1].sin_cos();
    let spin = p.I3 * (v[2] + v[0] * c);
    let phi = (spin - 2.0 * p.I1 * v[0] * c) * v[1] / (p.I1 * s);
    let theta = s * (v[0] * (p.I1 * v[0] * c - spin) + p.m * p.g * p.l) / p.I1;
    [phi, theta, v[0] * v[1] * s - phi * c].into()
}

/// The dense equations, M and its LDLᵀ in loops of constant length.
#[inline]
fn chain_dense(p: &Chain, q: &Vector<6>, v: &Vector<6>) -> Vector<6> {
    const N: usize = 6;
    let (mut s, mut c) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        (s[i], c[i]) = q[i].sin_cos();
    }
    let (mut m, mut f) = ([[0.0; N]; N], [0.0; N]);
    for i in 0..N {
        f[i] = -((N - i) as f64) * p.g * s[i];
        for j in 0..N {
            let bodies = (N - i.max(j)) as f64;
            if j <= i {
                m[i][j] = bodies * (c[i] * c[j] + s[i] * s[j]);
            }
            f[i] -= bodies * (s[i] * c[j] - c[i] * s[j]) * v[j] * v[j];
        }
    }
    for j in 0..N {
        let inverse = 1.0 / m[j][j];
        for i in j + 1..N {
            let l = m[i][j] * inverse;
            for k in j + 1..=i {
                m[i][k] -= l * m[k][j];
            }
            f[i] -= l * f[j];
        }
        for i in j + 1..N {
            m[i][j] *= inverse;
        }
        m[j][j] = inverse;
    }
    for i in (0..N).rev() {
        f[i] *= m[i][i];
        for k in i + 1..N {
            f[i] -= m[k][i] * f[k];
        }
    }
    f.into()
}

/// Linear in the number of links: a tridiagonal system for the tensions of the massless rods of unit length, then one
/// equation for each link along its own direction of motion.
#[inline]
fn chain_tensions(p: &Chain, q: &Vector<6>, v: &Vector<6>) -> Vector<6> {
    const N: usize = 6;
    let (mut s, mut c) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        (s[i], c[i]) = q[i].sin_cos();
    }
    // Rod i pulls bob i towards bob i − 1 with tension t[i]; the acceleration of bob i relative to bob i − 1 along the
    // rod is −θ̇²:  t[i-1] cos(i-1, i) − 2 t[i] + t[i+1] cos(i, i+1) = −θ̇[i]²  with one t and gravity for i = 0.
    let (mut diagonal, mut off, mut t) = ([2.0; N], [0.0; N], [0.0; N]);
    diagonal[0] = 1.0;
    for i in 0..N {
        t[i] = v[i] * v[i];
        if i > 0 {
            off[i] = -(c[i] * c[i - 1] + s[i] * s[i - 1]);
        }
    }
    t[0] += p.g * c[0];
    for i in (1..N).rev() {
        let l = off[i] / diagonal[i];
        diagonal[i - 1] -= l * off[i];
        t[i - 1] -= l * t[i];
    }
    t[0] /= diagonal[0];
    for i in 1..N {
        t[i] = (t[i] - off[i] * t[i - 1]) / diagonal[i];
    }
    let mut a = [0.0; N];
    for i in 0..N {
        let mut across = if i == 0 { -p.g * s[0] } else { -t[i - 1] * (s[i] * c[i - 1] - c[i] * s[i - 1]) };
        if i + 1 < N {
            across += t[i + 1] * (s[i + 1] * c[i] - c[i + 1] * s[i]);
        }
        a[i] = across;
    }
    a.into()
}

/// Runs one comparison and prints its row.
fn compare<Sys, const N: usize>(
    name: &str,
    system: Sys,
    hand: impl Fn(&Sys, &Vector<N>, &Vector<N>) -> Vector<N>,
) where
    Sys: Lagrangian<N, Scalar = f64>,
{
    const STATES: usize = 256;
    let mut random = Random(11);
    let states: Vec<(Vector<N>, Vector<N>)> = (0..STATES)
        .map(|_| {
            (Vector::from_fn(|_, _| 1.6 + 1.4 * random.next()), Vector::from_fn(|_, _| 2.0 * random.next()))
        })
        .collect();
    let mut worst = 0.0f64;
    for (q, v) in &states {
        let (ours, theirs) = (system.accel(q, v, 0.0), hand(&system, q, v));
        worst = worst.max((ours - theirs).amax() / theirs.amax());
    }
    assert!(worst < 1e-10, "{name}: the two sides differ by {worst:e}");
    let r = ratio(
        STATES,
        || {
            let system = black_box(&system);
            for (q, v) in black_box(&states) {
                consume(system.accel(q, v, 0.0));
            }
        },
        || {
            let system = black_box(&system);
            for (q, v) in black_box(&states) {
                consume(hand(system, q, v));
            }
        },
    );
    let o = Sys::FACTS.operations;
    println!(
        "| {name} | {:.3} | {:.3} – {:.3} | {:.1} | {:.1} | {} + {} | {worst:.0e} |",
        r.median,
        r.quartiles[0],
        r.quartiles[1],
        r.nanoseconds[0],
        r.nanoseconds[1],
        o.arithmetic(),
        o.sin_cos
    );
}

/// `accel` of bodies by rotations and by Euler's angles, in the same states.
fn bodies<A, B, const N: usize>(name: &str, turned: A, angles: B)
where
    A: Energies<N, Scalar = f64>,
    B: Energies<N, Scalar = f64>,
{
    const STATES: usize = 256;
    let mut random = Random(11);
    let mut number = move || random.next();
    let mut worst = 0.0f64;
    let states: [Vec<State<f64, N>>; 2] = {
        let pairs = (0..STATES).map(|_| {
            let mut by_angles = State::new(0.0, [0.0; N], [0.0; N]);
            let mut by_rotations = by_angles;
            for first in (0..N).step_by(3) {
                let at = [3.0 * number(), 1.6 + number(), 3.0 * number()];
                let rates = [0, 1, 2].map(|_| 2.0 * number());
                for i in 0..3 {
                    (by_angles.q[first + i], by_angles.qd[first + i]) = (at[i], rates[i]);
                }
                let (attitude, omega) =
                    (EulerAngles::Zxz.rotation(at), EulerAngles::Zxz.angular_velocity(at, rates));
                by_rotations = by_rotations.with_attitude(first, &attitude, &omega);
            }
            let energies = [turned.energy_at(&by_rotations), angles.energy_at(&by_angles)];
            worst = worst.max((energies[0] - energies[1]).abs() / energies[0].abs().max(1.0));
            (by_rotations, by_angles)
        });
        let (a, b) = pairs.unzip();
        [a, b]
    };
    assert!(worst < 1e-12, "{name}: energies differ by {worst:e}");
    let r = ratio(
        STATES,
        || {
            let system = black_box(&turned);
            for at in black_box(&states[0]) {
                consume(system.accel(&at.q, &at.qd, 0.0));
            }
        },
        || {
            let system = black_box(&angles);
            for at in black_box(&states[1]) {
                consume(system.accel(&at.q, &at.qd, 0.0));
            }
        },
    );
    let [few, many] = [A::FACTS.operations, B::FACTS.operations];
    println!(
        "| {name} | {:.3} | {:.3} – {:.3} | {} + {} | {} + {} |",
        r.median,
        r.quartiles[0],
        r.quartiles[1],
        few.arithmetic(),
        few.sin_cos,
        many.arithmetic(),
        many.sin_cos
    );
}

fn main() {
    println!(
        "| system | emitted / hand | quartiles | ns emitted | ns hand | operations + sin/cos pairs | difference |"
    );
    println!("|---|---|---|---|---|---|---|");
    compare("pendulum", Pendulum::new(1.3, 0.85, 9.81), pendulum);
    compare("Kepler", Kepler::new(0.9, 1.7), kepler);
    compare("double pendulum", DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81), double_pendulum);
    compare("symmetric top", Top::new(0.5, 0.12, 9.81, 0.008, 0.0011), top);
    compare("6-link chain, dense by hand", Chain::new(9.81), chain_dense);
    compare("6-link chain, linear by hand", Chain::new(9.81), chain_tensions);
    println!();
    println!(
        "| bodies | rotation / Euler's angles | quartiles | operations + sin/cos pairs | of the angles |"
    );
    println!("|---|---|---|---|---|");
    bodies("a heavy body", Turned::default(), Angles::default());
    bodies("two bodies on ball joints", TwoTurned::default(), TwoAngles::default());
}
