//! Rod that hangs from the rim of a disk in a vertical plane: with the disk turned at constant speed, and with the disk
//! free under a torque. Problem 11.31. The torque is a choice.

use super::harness::{Row, State, Subject, required, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// θ from the downward vertical, as is the radius of the hinge, ωt.
    pub system RodOnTurningDisk {
        param m, l, R, om, g = 9.81;
        coord theta;
        coord phi = om * t;
        let x = R * phi.sin() + 0.5 * l * theta.sin();
        let y = -R * phi.cos() - 0.5 * l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * (m * l.powi(2) / 12) * dot(theta).powi(2);
        V = m * g * y;
        observe centre = [x, y];
        observe torque = reaction(phi);
    }
}

golden!(RodOnTurningDisk<1>, "prob-11.31-rod-on-turning-disk", |p| RodOnTurningDisk {
    m: p("m"),
    l: p("l"),
    R: p("R"),
    om: p("om"),
    g: p("g")
});

lagrangian! {
    /// Uniform disk of mass M.
    pub system RodOnDrivenDisk {
        param m, M, l, R, mu0, g = 9.81;
        coord phi, theta;
        let x = R * phi.sin() + 0.5 * l * theta.sin();
        let y = -R * phi.cos() - 0.5 * l * theta.cos();
        T = 0.5 * (0.5 * M * R.powi(2)) * dot(phi).powi(2)
            + 0.5 * m * (dot(x).powi(2) + dot(y).powi(2))
            + 0.5 * (m * l.powi(2) / 12) * dot(theta).powi(2);
        V = m * g * y;
        Q[phi] = mu0;
    }
}

golden!(RodOnDrivenDisk<2>, "prob-11.31-rod-on-disk-relaxed", |p| RodOnDrivenDisk {
    m: p("m"),
    M: p("M"),
    l: p("l"),
    R: p("R"),
    mu0: p("mu0"),
    g: p("g")
});

pub fn rows() -> Vec<Row> {
    let turning = Row::of::<RodOnTurningDisk, 1>("separable, constant inertia, quadratic", [-3.0..3.0]);
    let driven = driven(&turning);
    vec![turning, driven]
}

/// The torque for constant speed, put back into the equations, keeps the speed and moves the rod as the turning disk
/// does; the mass of the disk has no part in it.
fn driven(turning: &Row) -> Row {
    let mut row = Row::of::<RodOnDrivenDisk, 2>("scleronomic, quadratic", [-3.0..3.0, -3.0..3.0]);
    let om = turning.subject().reference.parameter("om");
    let idle = row.subject().clone().with(&[("mu0", 0.0)]);
    for (theta, rate, t) in [(0.4, 1.1, 0.3), (-1.2, 0.6, 1.7), (2.5, -2.0, 4.1)] {
        let bend = turning.subject().accelerations(&State::new(&[theta], &[rate], t))[0];
        let state = State::new(&[om * t, theta], &[om, rate], 0.0);
        let (torque, allowed) = required(&idle, &state, &[0.0, bend])[0];
        let emitted = with_reference::<RodOnTurningDisk, 1>().torque(
            &SVector::from([theta]),
            &SVector::from([rate]),
            t,
        );
        row = row.within("emitted torque", emitted, torque, allowed);
        let found = row.subject().clone().with(&[("mu0", torque)]).accelerations(&state);
        let heavier: Subject = idle.clone().with(&[("M", 7.0)]);
        let size = bend.abs()
            + om * om
            + rate * rate
            + idle.reference.parameter("g") / idle.reference.parameter("R");
        row = row
            .reaction("nothing on the rod", &idle, (&state, &[0.0, bend]), 1, 0.0)
            .within("torque without the mass", required(&heavier, &state, &[0.0, bend])[0].0, torque, allowed)
            .within("φ̈", found[0], 0.0, 1e-12 * size)
            .within("θ̈", found[1], bend, 1e-12 * size)
            .show("θ̈ under the torque", found[1], bend);
    }
    row
}
