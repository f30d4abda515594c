//! Gyrocompass on the turning Earth, with torsional damping: whole, without the terms of order Ω², and for small drift.
//! Section 11.12.3.
//!
//! The square of the frequency of small drift is defined in another chapter; p² = (I₂₂/I₁₁) Ω ω₀ cos λ follows from
//! (11.78b).

use super::harness::{Row, number, with_reference};
use lagrange_runtime::Lagrangian;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// θ, spin of the rotor; α, drift from north; lam, latitude. The damping is a generalized force.
    pub system Gyrocompass {
        param I11, I22, om, lam, nu;
        coord theta, alpha;
        let north = om * lam.cos();
        let spin = dot(theta) + north * alpha.cos();
        let drift = dot(alpha) + om * lam.sin();
        T = 0.5 * I11 * (north * alpha.sin()).powi(2) + 0.5 * I22 * spin.powi(2) + 0.5 * I11 * drift.powi(2);
        V = 0;
        Q[alpha] = -2 * I11 * nu * dot(alpha);
    }
}

golden!(Gyrocompass<2>, "sec-11.12.3-gyrocompass-full", |p| Gyrocompass {
    I11: p("I11"),
    I22: p("I22"),
    om: p("Om"),
    lam: p("lam"),
    nu: p("nu")
});

lagrangian! {
    /// Frames of the Earth, of the gimbal that drifts, and of the rotor: x to the north, z up.
    pub system CompassOfFrames {
        param I11, I22, om, lam, nu;
        coord theta, alpha;
        let earth = frame(world, [0, 0, 0], rotation_z(om * t));
        let place = frame(earth, [0, 0, 0], rotation_y(lam - f64::consts::FRAC_PI_2));
        let rotor = frame(place, [0, 0, 0], rotation_z(alpha) * rotation_x(theta));
        T = body(1, [I22, I11, I11], rotor);
        V = 0;
        Q[alpha] = -2 * I11 * nu * dot(alpha);
    }
}

golden!(CompassOfFrames<2>, "sec-11.12.3-gyrocompass-full", |p| CompassOfFrames {
    I11: p("I11"),
    I22: p("I22"),
    om: p("Om"),
    lam: p("lam"),
    nu: p("nu")
});

lagrangian! {
    /// Without the terms of order Ω², and damped by a Rayleigh function.
    pub system SlowEarth {
        param I11, I22, om, lam, nu;
        coord theta, alpha;
        T = 0.5 * I22 * (dot(theta).powi(2) + 2 * om * dot(theta) * lam.cos() * alpha.cos())
            + 0.5 * I11 * (dot(alpha).powi(2) + 2 * om * dot(alpha) * lam.sin());
        V = 0;
        D = I11 * nu * dot(alpha).powi(2);
    }
}

golden!(SlowEarth<2>, "sec-11.12.3-gyrocompass-truncated", |p| SlowEarth {
    I11: p("I11"),
    I22: p("I22"),
    om: p("Om"),
    lam: p("lam"),
    nu: p("nu")
});

lagrangian! {
    /// Small drift at the spin w0.
    pub system SmallDrift {
        param I11, I22, om, lam, nu, w0;
        coord alpha;
        T = 0.5 * I11 * dot(alpha).powi(2);
        V = 0.5 * I22 * om * w0 * lam.cos() * alpha.powi(2);
        D = I11 * nu * dot(alpha).powi(2);
    }
}

golden!(SmallDrift<1>, "sec-11.12.3-gyrocompass-small", |p| SmallDrift {
    I11: p("I11"),
    I22: p("I22"),
    om: p("Om"),
    lam: p("lam"),
    nu: p("nu"),
    w0: p("w0")
});

/// A rotor that spins seeks the north: in the whole system p² comes out less the square of Ω cos λ, which the
/// linearization leaves out.
pub fn rows() -> Vec<Row> {
    let full = Row::of::<Gyrocompass, 2>(
        "scleronomic, constant inertia, quadratic, ignorable theta",
        [-3.0..3.0, -3.0..3.0],
    )
    .also::<CompassOfFrames, 2>("constant inertia, quadratic, ignorable theta");
    let truncated = Row::of::<SlowEarth, 2>(
        "scleronomic, constant inertia, quadratic, ignorable theta",
        [-3.0..3.0, -3.0..3.0],
    );
    let small = Row::of::<SmallDrift, 1>("scleronomic, constant inertia, quadratic, linear", [-2.0..2.0]);

    let special = truncated.subject().reference.special("p2").clone();
    let spin = number(&special["omega0"]);
    let expected = number(&special);
    let (rest, spinning) = (SVector::from([0.0, 0.0]), SVector::from([spin, 0.0]));
    let compass = with_reference::<SlowEarth, 2>();
    let found = -compass.jacobian(&rest, &spinning, 0.0).q[(1, 1)];
    let truncated = truncated.special("p²", found, expected);

    let whole = with_reference::<Gyrocompass, 2>();
    let north = whole.om * whole.lam.cos();
    // The momentum of the rotor counts with its share of the turn of the Earth, I₂₂ (ω₀ + Ω cos λ).
    let stiffness = -whole.jacobian(&rest, &spinning, 0.0).q[(1, 1)];
    let share = (whole.I22 / whole.I11 - 1.0) * north * north;
    let full = full.number("p² + (I₂₂/I₁₁ − 1) Ω² cos² λ", stiffness, expected + share).show(
        "p²",
        stiffness,
        expected + share,
    );

    let damped = small.subject().reference.special("damped").clone();
    let [start, rate, t, end] = ["alpha(0)", "alphadot(0)", "t", "alpha"].map(|name| number(&damped[name]));
    let small = small.motion("damped drift", (&[start], &[rate]), t, &[(0, end)]);
    vec![full, truncated, small]
}
