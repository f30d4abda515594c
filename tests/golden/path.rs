//! Particle on a smooth space curve, by the length of its path: under a given tangential force, and on a cycloid under
//! its weight, an example of our own. Problem 11.2. The history of the force is a choice.

use super::harness::{Row, State, number};
use lagrange_runtime::Scalar;
use lagrange_runtime::prelude::lagrangian;

/// Component of the force along the path.
fn along<S: Scalar>(t: S, f0: S, om: S) -> S {
    f0 * (om * t).cos()
}

lagrangian! {
    /// Only the tangential force works.
    pub system ParticleOnPath {
        param m, F0, om;
        coord s;
        extern fn along(t, f0, om);
        T = 0.5 * m * dot(s).powi(2);
        V = 0;
        Q[s] = along(t, F0, om);
    }
}

golden!(ParticleOnPath<1>, "prob-11.2-intrinsic", |p| ParticleOnPath { m: p("m"), F0: p("F0"), om: p("Om") }, with an extern fn);

lagrangian! {
    /// On a cycloid that a circle of radius a makes, s from its lowest point: the height is s²/8a.
    pub system Tautochrone {
        param m, a, g = 9.81;
        coord s;
        T = 0.5 * m * dot(s).powi(2);
        V = m * g * s.powi(2) / (8 * a);
    }
}

golden!(Tautochrone<1>, "prob-11.2-cycloid", |p| Tautochrone { m: p("m"), a: p("a"), g: p("g") });

lagrangian! {
    /// The same by the angle of the circle.
    pub system BeadOnCycloid {
        param m, a, g = 9.81;
        coord phi;
        let x = a * (phi + phi.sin());
        let y = a * (1 - phi.cos());
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
    }
}

golden!(BeadOnCycloid<1>, "prob-11.2-cycloid", |p| BeadOnCycloid { m: p("m"), a: p("a"), g: p("g") });

pub fn rows() -> Vec<Row> {
    vec![given_force(), tautochrone()]
}

fn given_force() -> Row {
    let row = Row::of::<ParticleOnPath, 1>(
        "scleronomic, separable, constant inertia, quadratic, linear",
        [-2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let [t, s] = ["t", "s"].map(|name| number(&reference.special("closed_form")[name]));
    let start = reference.trajectory().remove(0);
    let [m, f0, om] = ["m", "F0", "Om"].map(|name| reference.parameter(name));
    let found = start.q[0] + start.qd[0] * t + f0 / (m * om * om) * (1.0 - (om * t).cos());
    row.number("closed form", found, s).motion("s at the end", (&start.q, &start.qd), t, &[(0, s)])
}

/// The period is 4π √(a/g) from every height. With s = 4a sin(φ/2) the bead by its angle has the same acceleration.
fn tautochrone() -> Row {
    let row = Row::of::<Tautochrone, 1>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear",
        [-1.1..1.1],
    );
    let reference = row.subject().reference.clone();
    let period = number(reference.special("period"));
    let [a, g] = ["a", "g"].map(|name| reference.parameter(name));
    let angle = super::harness::Subject::of::<BeadOnCycloid, 1>();
    let row = row.number("4π √(a/g)", period, 4.0 * std::f64::consts::PI * (a / g).sqrt()).balances(
        "by the angle",
        |at| {
            let phi = 2.0 * (at.q[0] / (4.0 * a)).asin();
            let slope = 2.0 * a * (0.5 * phi).cos();
            let rate = at.qd[0] / slope;
            let bend = angle.accelerations(&State::new(&[phi], &[rate], 0.0))[0];
            vec![slope * bend, -a * (0.5 * phi).sin() * rate * rate, g / (4.0 * a) * at.q[0]]
        },
    );
    [0.01, 0.3, 1.1].iter().fold(row, |row, &s| row.period("period", &[s], 0, period))
}
