//! Mass on a spring and a viscous damper under a harmonic force. Exercise 11.7; reconstructed, since its figure
//! belongs to another chapter.

use crate::golden;
use crate::harness::with_reference;
use crate::harness::{
    Reference, State, assert_balance, assert_facts, assert_number, check, check_trajectory, number,
    random_states,
};
use lagrange_runtime::prelude::*;
use nalgebra::SVector;

lagrangian! {
    /// Displacement from rest.
    pub system ForcedVibration {
        param m, c, k, F0, om;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        D = 0.5 * c * dot(x).powi(2);
        Q[x] = F0 * sin(om * t);
    }
}

golden!(ForcedVibration<1>, "exer-11.7-forced-vibration", |p| ForcedVibration {
    m: p("m"),
    c: p("c"),
    k: p("k"),
    F0: p("F0"),
    om: p("Om")
});

#[test]
fn reference() {
    check::<ForcedVibration, 1>();
}

#[test]
fn trajectory() {
    check_trajectory::<ForcedVibration, 1>();
}

/// m ẍ + c ẋ + k x = F₀ sin Ωt; the energy changes at the rate F ẋ − c ẋ².
#[test]
fn equation_of_motion() {
    let (m, c, k, f0, om) = (1.1, 0.5, 7.0, 1.4, 1.9);
    let system = ForcedVibration::new(m, c, k, f0, om);
    for State { q, qd, t } in random_states([-2.0..2.0]) {
        let drive = f0 * (om * t).sin();
        assert_balance("x", &[m * system.accel(&q, &qd, t)[0], c * qd[0], k * q[0], -drive]);
        assert_balance("dE/dt", &[system.power(&q, &qd, t), -drive * qd[0], c * qd[0] * qd[0]]);
    }
}

/// x = A sin(Ωt − δ) solves the equation at all times.
#[test]
fn steady_state() {
    let reference = Reference::read("exer-11.7-forced-vibration");
    let system = with_reference::<ForcedVibration, 1>();
    let steady = reference.special("steady_state");
    let (amplitude, delta) = (number(&steady["A"]), number(&steady["delta"]));
    for t in (0..20).map(|step| 0.37 * f64::from(step)) {
        let (sin, cos) = (system.om * t - delta).sin_cos();
        let q = SVector::from([amplitude * sin]);
        let qd = SVector::from([amplitude * system.om * cos]);
        let inertia = -amplitude * system.om * system.om * sin;
        let forces = [system.k * q[0], system.c * qd[0], system.F0 * (system.om * t).sin()];
        let size: f64 = forces.iter().map(|force| force.abs() / system.m).sum();
        assert_balance("ẍ", &[system.accel(&q, &qd, t)[0], -inertia, size, -size]);
    }
}

/// −∂ẍ/∂ẋ = c/m is twice the rate of decay.
#[test]
fn decay_rate() {
    let reference = Reference::read("exer-11.7-forced-vibration");
    let system = with_reference::<ForcedVibration, 1>();
    let origin = SVector::from([0.0]);
    let jacobian = system.jacobian(&origin, &origin, 0.0);
    assert_number("c/2m", -0.5 * jacobian.qd[0], number(reference.special("decay_rate")));
    let frequency = number(reference.special("undamped_frequency"));
    assert_number("k/m", -jacobian.q[0], frequency * frequency);
}

/// Linear with constant coefficients: a force of time alone does not change that.
#[test]
fn facts_of_the_vibration() {
    let holding = ["scleronomic", "constant inertia", "quadratic", "linear"];
    assert_facts::<ForcedVibration, 1>(&holding, &[], &[&[0]]);
}
