//! Heavy symmetric top about a fixed point, in Euler angles. Section 11.12.4.
//!
//! Erratum of the source: the frequency of the elliptic solution for the nutation, in footnote (C), is printed with I₃
//! under the root; p² = m g l (x₃ − x₁)/(2 I₁) is right.

use super::harness::{Row, list, number, recovered, with_reference};
use lagrange_runtime::prelude::{SVector, lagrangian};
use lagrange_runtime::testing::reference::elliptic_k;
use lagrange_runtime::{Energies, Lagrangian, System, traits::LegendreTransform};
use nalgebra::{Complex, SMatrix};

lagrangian! {
    /// φ precession, θ inclination from the upward vertical, ψ spin.
    pub system SymmetricTop {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
        pub routhian Nodding;
    }
}

golden!(SymmetricTop<3>, "sec-11.12.4-symmetric-top", |p| SymmetricTop {
    m: p("m"),
    l: p("l"),
    I1: p("I1"),
    I3: p("I3"),
    g: p("g")
});

lagrangian! {
    /// The top as a rigid body, by its frame.
    pub system TopOfFrames {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        let top = frame(world, [0, 0, 0], rotation_z(phi) * rotation_x(theta) * rotation_z(psi));
        let centre = frame(top, [0, 0, l]);
        T = body(m, [I1 - m * l * l, I1 - m * l * l, I3], centre);
        V = m * g * centre.origin()[2];
        pub routhian NoddingOfFrames;
    }
}

golden!(TopOfFrames<3>, "sec-11.12.4-symmetric-top", |p| TopOfFrames {
    m: p("m"),
    l: p("l"),
    I1: p("I1"),
    I3: p("I3"),
    g: p("g")
});

golden!(NoddingOfFrames<1>, "sec-11.12.4-top-reduced", |p| NoddingOfFrames {
    m: p("m"),
    l: p("l"),
    I1: p("I1"),
    I3: S::from_f64(1e300),
    g: p("g"),
    p_phi: p("be"),
    p_psi: p("al")
});

lagrangian! {
    /// With precession and spin eliminated: nutation in the apparent potential (11.79m); al and be are the momenta.
    pub system Nutation {
        param m, l, I1, al, be, g = 9.81;
        coord theta;
        T = 0.5 * I1 * dot(theta).powi(2);
        V = (be - al * theta.cos()).powi(2) / (2 * I1 * theta.sin().powi(2)) + m * g * l * theta.cos();
    }
}

golden!(Nutation<1>, "sec-11.12.4-top-reduced", |p| Nutation {
    m: p("m"),
    l: p("l"),
    I1: p("I1"),
    al: p("al"),
    be: p("be"),
    g: p("g")
});

// The compiler's reduction. The reference leaves out the constant energy of the spin, α²/2I₃, and I₃ appears nowhere
// else in the Routhian: there it is as good as infinite.
golden!(Nodding<1>, "sec-11.12.4-top-reduced", |p| Nodding {
    m: p("m"),
    l: p("l"),
    I1: p("I1"),
    I3: S::from_f64(1e300),
    g: p("g"),
    p_phi: p("be"),
    p_psi: p("al")
});

lagrangian! {
    /// With the spin alone eliminated, and the place x, y of a point of the axis above O instead of Euler's angles,
    /// which fail where the axis is upright. In place of φ̇ cos θ stands −φ̇ (1 − cos θ), which differs by the
    /// derivative of φ.
    pub system UprightTop {
        param m, l, I1, al, g = 9.81;
        coord x, y;
        let z = (1 - x.powi(2) - y.powi(2)).sqrt();
        L = 0.5 * I1 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2))
            - al * (x * dot(y) - y * dot(x)) / (1 + z)
            - m * g * l * z;
    }
}

pub fn rows() -> Vec<Row> {
    vec![top(), reduced(), nutation(), steady_precession(), sleeping_top(), hanging_gyroscope()]
}

/// (11.79h), and the momenta α and β of (11.79e,f), which are conserved.
fn top() -> Row {
    let facts = "scleronomic, conservative, quadratic, ignorable phi psi";
    Row::of::<SymmetricTop, 3>(facts, [-3.0..3.0, 0.3..2.8, -3.0..3.0]).also::<TopOfFrames, 3>(facts)
}

/// (11.79p): θ moves as that of the whole top.
fn reduced() -> Row {
    let facts = "scleronomic, conservative, separable, constant inertia, quadratic";
    let row =
        Row::of::<Nutation, 1>(facts, [0.4..2.7]).also::<Nodding, 1>(facts).also::<NoddingOfFrames, 1>(facts);
    let row = recovered(row, &with_reference::<SymmetricTop, 3>(), SymmetricTop::reduce);
    let (top, nutation) = (with_reference::<SymmetricTop, 3>(), with_reference::<Nutation, 1>());
    row.balances("θ̈ of the whole top", |at| {
        let q = SVector::from([0.0, at.q[0], 0.0]);
        let qd = top.velocities(&q, &SVector::from([nutation.be, top.I1 * at.qd[0], nutation.al]), 0.0);
        let whole = top.accel(&q, &qd, 0.0)[1];
        let alone = nutation.accel(&SVector::from([at.q[0]]), &SVector::from([at.qd[0]]), 0.0)[0];
        // Moments about the line of nodes, per I₁.
        let spin =
            [qd[0] * qd[0] * at.q[0].cos(), nutation.al / top.I1 * qd[0], top.m * top.g * top.l / top.I1];
        let size: f64 = spin.iter().map(|moment| moment.abs()).sum();
        vec![whole, -alone, size, -size]
    })
}

/// From one turning point to the other and back, with the same α, β and E₀ = E − α²/2I₃; the turning points are zeros
/// of the cubic of footnote (B).
fn nutation() -> Row {
    let mut row = Row::about::<SymmetricTop, 3>("sec-11.12.4.3-nutation");
    let top = with_reference::<SymmetricTop, 3>();
    let weight = top.m * top.g * top.l;
    for case in list(&row.subject().reference.special("nutation").clone()) {
        let [alpha, beta, energy, period] =
            ["alpha", "beta", "E0", "nutation_period"].map(|name| number(&case[name]));
        let turning: Vec<f64> = list(&case["turning_points"]).iter().map(number).collect();
        for &theta in &turning {
            let q = SVector::from([0.0, theta, 0.0]);
            let qd = top.velocities(&q, &SVector::from([beta, 0.0, alpha]), 0.0);
            let spin = 0.5 * alpha * alpha / top.I3;
            row = row
                .number("θ̇ at a turning point", qd[1], 0.0)
                .balance("E₀ at a turning point", &[top.energy(&q, &qd, 0.0), -spin, -energy]);
        }
        let [x1, _, x3] = [0, 1, 2].map(|k| number(&list(&case["cubic_roots"])[k]));
        let [theta, phid, psid] = ["theta0", "phidot0", "psidot0"].map(|name| number(&case[name]));
        let other = turning[0] + turning[1] - theta;
        let start = (&[0.0, theta, 0.0][..], &[phid, 0.0, psid][..]);
        let [k, found] = ["modulus_k", "period_with_p_using_I1"].map(|name| number(&case[name]));
        let p = (weight * (x3 - x1) / (2.0 * top.I1)).sqrt();
        row = row
            .motion("nutation", start, 0.5 * period, &[(1, other), (4, 0.0)])
            .motion("nutation", start, period, &[(1, theta), (4, 0.0)])
            .number("2K(k)/p with I₁, erratum", 2.0 * elliptic_k(k) / p, found)
            .number(
                "the same with I₃",
                found * (top.I3 / top.I1).sqrt(),
                number(&case["period_with_printed_I3"]),
            )
            .passage("nutation period", start, 0.5 * period, (4, 0.0), 2.0);
    }
    row
}

/// On both branches of (11.79s) the inclination stays and the rates are steady; disturbances oscillate with (11.79x,y).
/// θ̈ at rest is a quadratic function of φ̇ whose linear term is proportional to the spin: from the spin (11.79u) on it
/// has zeros.
fn steady_precession() -> Row {
    let mut row = Row::about::<SymmetricTop, 3>("sec-11.12.4.4-steady-precession");
    let top = with_reference::<SymmetricTop, 3>();
    let reference = row.subject().reference.clone();
    let steady = reference.special("steady_precession");
    let half_pi = reference.special("theta_half_pi");
    let hanging = reference.special("gyroscopic_pendulum_precession");

    let theta = number(&steady["theta0"]);
    let rates = |case: &serde_json::Value, rate: &str| [number(&case["omega3"]), number(&case[rate])];
    let mut motions = vec![(std::f64::consts::FRAC_PI_2, rates(half_pi, "phidot0"))];
    motions.extend(
        ["phidot_plus", "phidot_minus"].map(|rate| (number(&hanging["theta0"]), rates(hanging, rate))),
    );
    motions.extend(list(&steady["cases"]).iter().map(|case| (theta, rates(case, "phidot0"))));
    for (theta, [spin, phid]) in motions {
        let (sin, cos) = theta.sin_cos();
        let (q, qd) = (SVector::from([0.4, theta, -0.2]), SVector::from([phid, 0.0, spin - phid * cos]));
        let a = top.accel(&q, &qd, 0.0);
        // Each moment about the line of nodes, as an angular acceleration.
        let moments = [
            top.m * top.g * top.l / top.I1 * sin,
            phid * phid * sin * cos,
            -top.I3 / top.I1 * spin * phid * sin,
        ];
        let size: f64 = moments.iter().map(|moment| moment.abs()).sum();
        row = row
            .balance("(11.79s)", &moments)
            .balance("θ̈", &[a[1], size, -size])
            .holds("φ̈ = ψ̈ = 0", a[0] == 0.0 && a[2] == 0.0);
    }
    for case in list(&steady["cases"]) {
        let [spin, phid, beta] = ["omega3", "phidot0", "beta"].map(|name| number(&case[name]));
        let (q, qd) =
            (SVector::from([0.0, theta, 0.0]), SVector::from([phid, 0.0, spin - phid * theta.cos()]));
        let alpha = top.I3 * spin;
        let reduced = Nutation { al: alpha, be: beta, ..with_reference::<Nutation, 1>() };
        let slope = reduced.jacobian(&SVector::from([theta]), &SVector::from([0.0]), 0.0).q[0];
        let [curvature, frequency] =
            ["d2V_11_79y", "nutation_frequency_11_79x"].map(|name| number(&case[name]));
        let (fast, slow) = (alpha / (top.I1 * theta.cos()), top.m * top.g * top.l / alpha);
        let limit = if case["branch"] == "fast" { fast - slow } else { slow };
        row = row.number("(11.79w)", limit, number(&case["approx_11_79w"]));
        // β − α cos θ is a difference.
        let condition = alpha / (beta - alpha * theta.cos()).abs();
        row = row
            .number("β", top.momenta(&q, &qd, 0.0)[0], beta)
            .within("(11.79y)", -top.I1 * slope, curvature, 1e-13 * curvature * condition)
            .within("(11.79x)", (-slope).sqrt(), frequency, 1e-13 * frequency * condition);
    }

    let tilt = |phid: f64| {
        let qd = SVector::from([phid, 0.0, 1.0 - phid * theta.cos()]);
        top.accel(&SVector::from([0.0, theta, 0.0]), &qd, 0.0)[1]
    };
    let (constant, sum, difference) =
        (tilt(0.0), 0.5 * (tilt(1.0) + tilt(-1.0)), 0.5 * (tilt(1.0) - tilt(-1.0)));
    let critical = 2.0 * ((sum - constant) * constant).sqrt() / difference.abs();
    let [twice, half] =
        ["I3 w3c/(2 I1 cos)", "2 mgl/(I3 w3c)"].map(|name| number(&steady["phidot_critical_11_79v"][name]));
    row.number("(11.79v)", twice, half).special("critical ω₃", critical, number(&steady["omega3_critical"]))
}

impl UprightTop {
    /// The top of the file, with its axis upright or hanging, and a spin.
    fn spinning(upright: bool, spin: f64) -> Self {
        let top = with_reference::<SymmetricTop, 3>();
        // A hanging top is an upright one whose weight pulls upwards, seen from below.
        let sign = if upright { 1.0 } else { -1.0 };
        UprightTop { m: top.m, l: sign * top.l, I1: top.I1, al: sign * top.I3 * spin, g: top.g }
    }

    /// `[k, γ]` of small tilts, δẍ = kδx − γδẏ, δÿ = kδy + γδẋ.
    fn tilts(&self) -> [f64; 2] {
        let rest = SVector::from([0.0, 0.0]);
        let jacobian = self.jacobian(&rest, &rest, 0.0);
        [jacobian.q[(0, 0)], jacobian.qd[(1, 0)]]
    }

    /// Distance of `λ = growth + i·frequency` from being an eigenvalue of small tilts, in proportion to its terms.
    fn misses(&self, growth: f64, frequency: f64) -> f64 {
        let rest = SVector::from([0.0, 0.0]);
        let jacobian = self.jacobian(&rest, &rest, 0.0);
        let value = Complex::new(growth, frequency);
        let matrix = SMatrix::<_, 2, 2>::identity() * (value * value)
            - jacobian.qd.map(Complex::from) * value
            - jacobian.q.map(Complex::from);
        let size = value.norm_sqr() + jacobian.qd.amax() * value.norm() + jacobian.q.amax();
        matrix.determinant().norm() / (size * size)
    }
}

/// (11.79z): 4 I₁² δ̈ + (I₃²ω₃² − 4 I₁ m g l) δ = 0 in a frame that turns at I₃ω₃/2I₁; upright in steady precession the
/// top moves in circles, too.
fn sleeping_top() -> Row {
    let mut row = Row::about::<SymmetricTop, 3>("sec-11.12.4.4-sleeping-top");
    let reference = row.subject().reference.clone();
    let steady = reference.special("steady_precession");
    let theta = number(&steady["theta0"]);
    for case in list(&steady["cases"]) {
        let rate = number(&case["phidot0"]);
        let top = UprightTop::spinning(true, number(&case["omega3"]));
        let (q, qd) = (SVector::from([theta.sin(), 0.0]), SVector::from([0.0, rate * theta.sin()]));
        let size = top.al / top.I1 * rate.abs() + rate * rate;
        row = row.within("steady circle", top.accel(&q, &qd, 0.0)[0], -rate * rate * q[0], 1e-13 * size);
    }
    let sleeping = reference.special("sleeping_top_11_79z");
    for case in list(&sleeping["cases"]) {
        let top = UprightTop::spinning(true, number(&case["omega3"]));
        let turn = number(&case["phidot0"]);
        let [k, gyroscopic] = top.tilts();
        let coefficient = 0.25 * gyroscopic * gyroscopic - k;
        let weight = top.m * top.g * top.l / top.I1;
        row = row
            .number("I₃ω₃/2I₁", 0.5 * gyroscopic, turn)
            .balance("(11.79z)", &[coefficient - number(&case["coefficient"]), weight, -weight])
            .holds("stability", (coefficient > 0.0) == (case["stable"] == true));
        let pairs = match (case["growth_rate"].as_f64(), case["frequency"].as_f64()) {
            (Some(growth), None) => [(growth, turn), (-growth, turn)],
            (None, Some(frequency)) => [(0.0, turn + frequency), (0.0, turn - frequency)],
            _ => panic!("either grows or oscillates: {case}"),
        };
        for (growth, frequency) in pairs {
            row = row.within("eigenvalue", top.misses(growth, frequency), 0.0, 1e-13);
        }
    }
    let [k, gyroscopic] = UprightTop::spinning(true, 1.0).tilts();
    row.special("least ω₃", 2.0 * k.sqrt() / gyroscopic, number(&sleeping["omega3_sleeping_limit"]))
}

/// Exercise 11.10: 4 I₁² δ̈ + (I₃²ω₃² + 4 I₁ m g l) δ = 0, which is stable at any spin.
fn hanging_gyroscope() -> Row {
    let row = Row::about::<SymmetricTop, 3>("exer-11.10-sleeping-gyroscopic-pendulum");
    let hanging = row.subject().reference.special("sleeping_gyroscopic_pendulum_exercise_11_10").clone();
    let top = UprightTop::spinning(false, number(&hanging["omega3"]));
    let [k, gyroscopic] = top.tilts();
    let coefficient = 0.25 * gyroscopic * gyroscopic - k;
    let frequency = coefficient.sqrt();
    let turn = number(&hanging["phidot0"]);
    row.number("−I₃ω₃/2I₁", 0.5 * gyroscopic, turn)
        .within("eigenvalue", top.misses(0.0, turn + frequency), 0.0, 1e-13)
        .within("eigenvalue", top.misses(0.0, turn - frequency), 0.0, 1e-13)
        .holds("stable without spin", UprightTop::spinning(false, 0.0).tilts()[0] < 0.0)
        .special("ω², I₃²ω₃²/4I₁² + mgl/I₁", coefficient, number(&hanging["coefficient"]))
}
