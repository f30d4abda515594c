//! Mass on a spring and a viscous damper under a harmonic force. Exercise 11.7; reconstructed, since its figure
//! belongs to another chapter.

use super::harness::{Row, number, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::{Lagrangian, System};

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

/// Linear with constant coefficients: a force of time alone does not change that.
pub fn rows() -> Vec<Row> {
    let mut row =
        Row::of::<ForcedVibration, 1>("scleronomic, constant inertia, quadratic, linear", [-2.0..2.0]);
    let reference = row.subject().reference.clone();
    let system = with_reference::<ForcedVibration, 1>();

    // x = A sin(Ωt − δ) solves the equation at all times.
    let steady = reference.special("steady_state");
    let (amplitude, delta) = (number(&steady["A"]), number(&steady["delta"]));
    for t in (0..20).map(|step| 0.37 * f64::from(step)) {
        let (sin, cos) = (system.om * t - delta).sin_cos();
        let q = SVector::from([amplitude * sin]);
        let qd = SVector::from([amplitude * system.om * cos]);
        let inertia = -amplitude * system.om * system.om * sin;
        let forces = [system.k * q[0], system.c * qd[0], system.F0 * (system.om * t).sin()];
        let size: f64 = forces.iter().map(|force| force.abs() / system.m).sum();
        row = row.balance("steady state", &[system.accel(&q, &qd, t)[0], -inertia, size, -size]);
    }

    // −∂ẍ/∂ẋ = c/m is twice the rate of decay.
    let origin = SVector::from([0.0]);
    let jacobian = system.jacobian(&origin, &origin, 0.0);
    let frequency = number(reference.special("undamped_frequency"));
    let row = row.number("k/m", -jacobian.q[0], frequency * frequency);
    let damped = (-jacobian.q[0] - 0.25 * jacobian.qd[0].powi(2)).sqrt();
    let row = row.number("damped frequency", damped, number(reference.special("damped_frequency")));
    vec![row.special("decay rate", -0.5 * jacobian.qd[0], number(reference.special("decay_rate")))]
}
