//! The radial motion under an inverse-square central force, reduced by the Routhian of the compiler. Section 11.10.1.

use crate::golden;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_trajectory, number,
    random_states,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// A particle attracted by a fixed centre with the force μm/r², by its position in the plane: that φ is ignorable has
    /// to be found.
    pub system Orbit {
        param m, mu;
        coord r: length, phi: angle;
        let x = r * cos(phi);
        let y = r * sin(phi);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = -mu * m / r;
        observe position = [x, y];
        observe speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
        pub routhian Radial;
    }
}

golden!(Radial<1>, "sec-11.10.1-central-force-reduced", |p| Radial {
    m: p("m"),
    mu: p("mu"),
    p_phi: p("m") * p("gamma")
});

#[test]
fn reference() {
    check::<Radial, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<Radial, 1>();
}

/// (11.42b): r̈ + μ/r² − γ²/r³ = 0, and φ̇ = γ/r².
#[test]
fn equations_of_motion() {
    let (m, mu, gamma) = (0.9, 1.7, 1.28);
    let radial = Radial::new(m, mu, m * gamma);
    for State { q, qd, t } in random_states([0.4..3.0]) {
        let r = q[0];
        let a = radial.accel(&q, &qd, t)[0];
        assert_balance("(11.42b)", &[a, mu / (r * r), -gamma * gamma / (r * r * r)]);
        assert_number("(11.42a)", radial.ignorable_velocities(&q, &qd, t)[0], gamma / (r * r));
        let apparent = [-mu * m / r, 0.5 * m * gamma * gamma / (r * r)];
        assert_balance("V_eff", &[radial.potential(&q, t), -apparent[0], -apparent[1]]);
        // The velocity of the ignorable coordinate is part of the speed.
        let whole = radial.expand(&lagrange_runtime::State { t, q, qd }, &SVector::from([0.3]));
        let orbit = Orbit::new(m, mu);
        assert_number("speed", radial.speed(&q, &qd, t), orbit.speed(&whole.q, &whole.qd, t));
        assert_number("p_φ", orbit.momenta(&whole.q, &whole.qd, t)[1], m * gamma);
    }
}

/// The minimum of the apparent potential is the circle, its curvature the radial frequency.
#[test]
fn circular_orbit() {
    let reference = Reference::read("sec-11.10.1-central-force-reduced");
    let (m, gamma) = (reference.parameter("m"), reference.parameter("gamma"));
    let radial = Radial::new(m, reference.parameter("mu"), m * gamma);
    let (q, rest) = (SVector::from([number(reference.special("circular_radius"))]), SVector::from([0.0]));
    let attraction = radial.mu / (q[0] * q[0]);
    assert_balance("equilibrium", &[radial.accel(&q, &rest, 0.0)[0] + attraction, -attraction]);
    let frequency = number(reference.special("radial_frequency"));
    assert_number("frequency", -radial.jacobian(&q, &rest, 0.0).q[(0, 0)], frequency * frequency);
}

/// The whole motion, recovered by quadrature, is that of the whole system.
#[test]
fn recovered_orbit() {
    let reference = Reference::read("ex-11.3-central-force");
    let motion = reference.trajectory::<2>();
    let start = lagrange_runtime::State { t: motion[0].t, q: motion[0].q, qd: motion[0].qd };
    let orbit = Orbit::new(reference.parameter("m"), reference.parameter("mu"));
    let (radial, state) = orbit.reduce(&start);
    for expected in &motion[1..] {
        let run = integrate(&radial, Dop853, Pi::tolerance(1e-14), state).until(expected.t);
        let end = run.recover([start.q[1]]).last().expect("steps").expect("no failure");
        for k in 0..2 {
            assert!((end.q[k] - expected.q[k]).abs() < 1e-11, "q[{k}] at {}: {end:?}", expected.t);
            assert!((end.qd[k] - expected.qd[k]).abs() < 1e-11, "q̇[{k}] at {}: {end:?}", expected.t);
        }
    }
}

#[test]
fn facts_of_the_radial_motion() {
    let holding = ["scleronomic", "conservative", "separable", "constant inertia", "quadratic"];
    assert_facts::<Radial, 1>(&holding, &[], &[&[0]]);
    assert_eq!(<Orbit as Lagrangian<2>>::FACTS.kinds, [Kind::Length, Kind::Angle]);
    assert_eq!(<Radial as Lagrangian<1>>::FACTS.kinds, [Kind::Length]);
}
