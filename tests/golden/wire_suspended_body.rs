//! Rigid body hung on a light wire, a double physical pendulum: finite motion, small vibrations, and the disk for which
//! the ratios of the amplitudes are those of the golden section. Example 11.12.

use super::harness::{Quantity, Row, State, list, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// θ, angle of the wire of length a; φ, angle of the body, whose centre is at the distance l from the wire.
    pub system WireSuspendedBody {
        param M, a, l, IG, g = 9.81;
        coord phi, theta;
        let x = a * theta.sin() + l * phi.sin();
        let y = -a * theta.cos() - l * phi.cos();
        T = 0.5 * M * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * IG * dot(phi).powi(2);
        V = M * g * (y + a + l);
        observe centre = [x, y];
    }
}

golden!(WireSuspendedBody<2>, "ex-11.12i-wire-suspended-body", |p| WireSuspendedBody {
    M: p("M"),
    a: p("a"),
    l: p("l"),
    IG: p("IG"),
    g: p("g")
});

lagrangian! {
    /// The wire and the body as frames in the plane.
    pub system BodyOfFrames {
        param M, a, l, IG, g = 9.81;
        coord phi, theta;
        let wire = frame(world, [0, 0], theta);
        let body_axes = frame(wire, [0, -a], phi - theta);
        let centre = frame(body_axes, [0, -l]);
        T = body(M, IG, centre);
        V = M * g * (centre.origin()[1] + a + l);
    }
}

golden!(BodyOfFrames<2>, "ex-11.12i-wire-suspended-body", |p| BodyOfFrames {
    M: p("M"),
    a: p("a"),
    l: p("l"),
    IG: p("IG"),
    g: p("g")
});

lagrangian! {
    /// A disk of radius √2 l on a wire of length a = l, for which I_G = M l².
    pub system DiskOnWire {
        param M, a, l, IG, g = 9.81;
        coord phi, theta;
        let x = a * theta.sin() + l * phi.sin();
        let y = -a * theta.cos() - l * phi.cos();
        T = 0.5 * M * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * IG * dot(phi).powi(2);
        V = M * g * (y + a + l);
    }
}

golden!(DiskOnWire<2>, "ex-11.12ii-disk-on-wire", |p| DiskOnWire {
    M: p("M"),
    a: p("a"),
    l: p("l"),
    IG: p("IG"),
    g: p("g")
});

lagrangian! {
    /// (11.92e): quadratic T and V; IH is the moment of inertia about the point where the wire is fixed.
    pub system SmallVibrations {
        param M, a, l, IH, g = 9.81;
        coord phi, theta;
        T = 0.5 * IH * dot(phi).powi(2)
            + 0.5 * M * (2 * l * a * dot(phi) * dot(theta) + a.powi(2) * dot(theta).powi(2));
        V = 0.5 * M * g * (l * phi.powi(2) + a * theta.powi(2));
    }
}

golden!(SmallVibrations<2>, "ex-11.12-small", |p| SmallVibrations {
    M: p("M"),
    a: p("a"),
    l: p("l"),
    IH: p("IH"),
    g: p("g")
});

pub fn rows() -> Vec<Row> {
    let facts = "scleronomic, conservative, quadratic";
    let finite =
        Row::of::<WireSuspendedBody, 2>(facts, [-3.0..3.0, -3.0..3.0]).also::<BodyOfFrames, 2>(facts);
    vec![small(&finite), finite, disk()]
}

/// M and K are those of the finite motion at rest, with I_H = I_G + M l².
fn small(finite: &Row) -> Row {
    let mut row = Row::of::<SmallVibrations, 2>(
        "scleronomic, conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0, -2.0..2.0],
    );
    let rest = State::new(&[0.0, 0.0], &[0.0, 0.0], 0.0);
    for quantity in [Quantity::Inertia, Quantity::JacobianQ] {
        let [mine, others] =
            [row.subject(), finite.subject()].map(|subject| subject.at("", &rest).value(quantity));
        let largest = mine.iter().fold(0.0f64, |largest, entry| largest.max(entry.abs()));
        for (mine, other) in mine.iter().zip(&others) {
            row = row.within("at rest", *mine, *other, 1e-13 * largest);
        }
    }
    row
}

/// The normal coordinates (11.92o) are linear combinations of φ and θ that oscillate on their own: the rows of the
/// inverse of the matrix of modes.
fn disk() -> Row {
    let mut row = Row::of::<DiskOnWire, 2>("scleronomic, conservative, quadratic", [-3.0..3.0, -3.0..3.0]);
    let reference = row.subject().reference.clone();
    let ratios = reference.special("amplitude_ratios_11_92l");
    let modes = reference.small()[0].lists("modes");
    let [first, second] = [number(&ratios["C21/C11"]), number(&ratios["C12/C22"])];
    let golden_section = 0.5 * (1.0 + 5.0f64.sqrt());
    let mut ratios: Vec<f64> = modes.iter().map(|mode| mode[1] / mode[0]).collect();
    ratios.sort_by(f64::total_cmp);
    row = row.number("|C₂₁/C₁₁|", first.abs(), golden_section).number(
        "|C₁₂/C₂₂|",
        second.abs(),
        golden_section,
    );
    let frequencies = list(reference.special("frequencies_11_92i"));
    let [fast, slow] = [0, 1].map(|k| number(&frequencies[k]));
    let p0 = (reference.parameter("g") / reference.parameter("l")).sqrt();
    let lowest = row.special.as_ref().map_or(f64::NAN, |shown| shown.value);

    // (11.92o): ξ₁ and ξ₂ are rows of the inverse of (1, τ; −τ, 1), the modes as columns, and each oscillates alone.
    let normal = reference.special("normal_coordinates_11_92o");
    let [phi, theta, xi1, xi2] = ["phi", "theta", "xi1", "xi2"].map(|name| number(&normal[name]));
    let scale = 1.0 + golden_section * golden_section;
    let rest = row.subject().at("rest", &State::new(&[0.0, 0.0], &[0.0, 0.0], 0.0));
    let pull = rest.matrix(Quantity::JacobianQ);
    for (coefficients, xi, square) in [
        ([1.0, -golden_section], xi1, fast.max(slow).powi(2)),
        ([golden_section, 1.0], xi2, fast.min(slow).powi(2)),
    ] {
        row = row.balance("ξ", &[coefficients[0] * phi, coefficients[1] * theta, -scale * xi]);
        for k in 0..2 {
            let terms =
                [coefficients[0] * pull[(0, k)], coefficients[1] * pull[(1, k)], square * coefficients[k]];
            row = row.balance("ξ̈ + p²ξ = 0", &terms);
        }
    }
    row.number("p₁² + p₂² = 3 p₀²", fast * fast + slow * slow, 3.0 * p0 * p0)
        .number("p₁ p₂ = p₀²", fast * slow, p0 * p0)
        .special("p₁/p₀", lowest / p0, 1.0 / golden_section)
}
