//! Particle on smooth surfaces of revolution: with drag on a paraboloid, and without on a general one. Problems 11.5
//! and 11.11; the profile of the latter is a choice.

use super::harness::{Quantity, Row, State, list, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// On r² = a z, in a Stokes medium.
    pub system ParaboloidWithDrag {
        param m, a, c, g = 9.81;
        coord r, theta;
        let x = r * theta.cos();
        let y = r * theta.sin();
        let z = r.powi(2) / a;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        D = 0.5 * c * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    }
}

golden!(ParaboloidWithDrag<2>, "prob-11.5-paraboloid-drag", |p| ParaboloidWithDrag {
    m: p("m"),
    a: p("a"),
    c: p("c"),
    g: p("g")
});

lagrangian! {
    /// The same with the drag as a force at the particle.
    pub system ParaboloidUnderForce {
        param m, a, c, g = 9.81;
        coord r, theta;
        let x = r * theta.cos();
        let y = r * theta.sin();
        let z = r.powi(2) / a;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        force [-c * dot(x), -c * dot(y), -c * dot(z)] at [x, y, z];
    }
}

lagrangian! {
    /// On a surface r(z), in cylindrical coordinates.
    pub system SurfaceOfRevolution {
        param m, a, b, g = 9.81;
        coord z, theta;
        fn profile(s) = (a * s + b * s.powi(2)).sqrt();
        let r = profile(z);
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(theta)).powi(2) + dot(z).powi(2));
        V = m * g * z;
    }
}

golden!(SurfaceOfRevolution<2>, "prob-11.11-surface-of-revolution", |p| SurfaceOfRevolution {
    m: p("m"),
    a: p("a"),
    b: p("b"),
    g: p("g")
});

pub fn rows() -> Vec<Row> {
    vec![paraboloid(), surface()]
}

/// The moment of momentum about the axis falls by e^{−(c/m)t}; the generalized forces by virtual work, by D and by hand
/// agree; without drag every circle is run through at the same rate.
fn paraboloid() -> Row {
    let mut row = Row::of::<ParaboloidWithDrag, 2>("scleronomic, quadratic", [0.4..2.0, -3.0..3.0]);
    let reference = row.subject().reference.clone();
    let [m, a, c, g] = ["m", "a", "c", "g"].map(|name| reference.parameter(name));
    let by_force = ParaboloidUnderForce::new(m, a, c);
    for (k, what) in ["Q_r", "Q_θ"].into_iter().enumerate() {
        let subject = row.subject().clone();
        row = row.balances(what, |at| {
            let (q, qd) = (at.q.clone().into_iter(), at.qd.clone().into_iter());
            let (q, qd) = (nalgebra::SVector::from_iterator(q), nalgebra::SVector::from_iterator(qd));
            let virtual_work = lagrange_runtime::Lagrangian::momentum_rate(&by_force, &q, &qd, 0.0)[k];
            vec![virtual_work, -subject.at("", at).value(Quantity::Force)[k]]
        });
    }
    let free = row.subject().clone().with(&[("c", 0.0)]);
    let rate = (2.0 * g / a).sqrt();
    for r in [0.3, 1.0, 2.5] {
        let centripetal = r * rate * rate / (1.0 + 4.0 * r * r / (a * a));
        let found = free.accelerations(&State::new(&[r, 0.0], &[0.0, rate], 0.0))[0];
        row = row.within("circle", found, 0.0, 1e-13 * centripetal);
    }
    let motion = reference.trajectory();
    let [first, last] = [&motion[0], &motion[motion.len() - 1]]
        .map(|at| row.subject().at("", at).value(Quantity::Momenta)[1]);
    let expected = number(reference.special("ratio_at_t_end"));
    row.number("e^{−(c/m)t}", (-c / m * motion[motion.len() - 1].t).exp(), expected).special(
        "p_θ/p_θ₀",
        last / first,
        expected,
    )
}

/// The circle at height z needs θ̇² = g/(r r′).
fn surface() -> Row {
    let mut row = Row::of::<SurfaceOfRevolution, 2>(
        "scleronomic, conservative, quadratic, ignorable theta",
        [0.3..2.0, -3.0..3.0],
    );
    let g = row.subject().reference.parameter("g");
    for case in list(&row.subject().reference.special("horizontal_circle").clone()) {
        let [z, square] = ["z", "thetadot2"].map(|name| number(&case[name]));
        // z̈ is linear in θ̇².
        let fall = |rate: f64| row.subject().accelerations(&State::new(&[z, 0.0], &[0.0, rate], 0.0))[0];
        let found = -fall(0.0) / (fall(1.0) - fall(0.0));
        let allowed = 1e-13 * square * (1.0 + 2.0 * g / (fall(1.0) - fall(0.0)).abs());
        row = row.within("horizontal circle", found, square, allowed).show("θ̇² of the circle", found, square);
    }
    row
}
