//! The nutation of a heavy symmetric top, reduced by its two ignorable angles. Section 11.12.4.2.

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, check, check_trajectory, random_states,
};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// φ precession, θ inclination from the upward vertical, ψ spin.
    pub system Top {
        param m, l, I1, I3, g = 9.81;
        coord phi: angle, theta: angle, psi: angle;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
        pub routhian Nutation;
    }
}

// The reference leaves out the constant energy of the spin, α²/2I₃, and I₃ appears nowhere else in the Routhian: there it
// is as good as infinite.
golden!(Nutation<1>, "sec-11.12.4-top-reduced", |p| Nutation {
    m: p("m"),
    l: p("l"),
    I1: p("I1"),
    I3: S::from_f64(1e300),
    g: p("g"),
    p_phi: p("be"),
    p_psi: p("al")
});

#[test]
fn reference() {
    check::<Nutation, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<Nutation, 1>();
}

/// (11.79g): φ̇ = (β − α cos θ)/(I₁ sin² θ), ψ̇ = α/I₃ − φ̇ cos θ; and (11.79h) with these.
#[test]
fn equations_of_motion() {
    let (m, l, i1, i3, beta, alpha) = (0.5, 0.12, 0.008, 0.0011, 0.15, 0.198);
    let top = Nutation::new(m, l, i1, i3, beta, alpha);
    for State { q, qd, t } in random_states([0.3..2.8]) {
        let (sin, cos) = q[0].sin_cos();
        let u = top.ignorable_velocities(&q, &qd, t);
        let (phid, psid) = (u[0], u[1]);
        assert_balance("(11.79f)", &[i1 * phid * sin * sin, alpha * cos, -beta]);
        assert_balance("(11.79e)", &[i3 * psid, i3 * phid * cos, -alpha]);
        let a = top.accel(&q, &qd, t)[0];
        assert_balance(
            "(11.79h)",
            &[
                i1 * a,
                i3 * phid * phid * sin * cos,
                -i1 * phid * phid * sin * cos,
                i3 * psid * phid * sin,
                -m * top.g * l * sin,
            ],
        );
    }
}

/// Reduced and whole motions agree, angles recovered by quadrature included, and with the reference.
#[test]
fn recovered_motion() {
    let reference = Reference::read("sec-11.12.4-symmetric-top");
    let motion = reference.trajectory::<3>();
    let start = lagrange_runtime::State { t: motion[0].t, q: motion[0].q, qd: motion[0].qd };
    let [m, l, i1, i3, g] = ["m", "l", "I1", "I3", "g"].map(|name| reference.parameter(name));
    let top = Top { m, l, I1: i1, I3: i3, g };
    let (nutation, state) = top.reduce(&start);
    for expected in &motion[1..] {
        let end = expected.t;
        let whole =
            integrate(&top, Dop853, Pi::tolerance(1e-14), start).until(end).finish().expect("no failure");
        let run = integrate(&nutation, Dop853, Pi::tolerance(1e-14), state).until(end);
        let reduced = run.recover([start.q[0], start.q[2]]).last().expect("steps").expect("no failure");
        for k in 0..3 {
            for (what, other) in [("whole", whole.q[k]), ("reference", expected.q[k])] {
                let error = (reduced.q[k] - other).abs();
                assert!(error < 1e-11 * other.abs().max(1.0), "q[{k}] at {end}: {error:e} off the {what}");
            }
            let error = (reduced.qd[k] - expected.qd[k]).abs();
            assert!(error < 1e-11 * expected.qd[k].abs().max(1.0), "q̇[{k}] at {end}: {error:e} off");
        }
    }
}

/// What was (φ, ψ)-independent is left: one degree of freedom, and even a separable one.
#[test]
fn facts_of_the_nutation() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic"];
    assert_facts::<Nutation, 1>(&holding, &[], &[&[0]]);
}
