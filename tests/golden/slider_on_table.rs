//! Slider on smooth rods that turn: fixed to a table at an offset from its axis, with and without springs, with the
//! table driven by a torque; and inclined to a vertical shaft. Problems 11.6 to 11.9 and 11.26. The offsets of the rods
//! are reconstructed, and the inclined rod of Problem 11.8 is a stand-in, since the problems refer to another chapter.

use super::harness::{Row, State, Subject, list, number, required, with_reference};
use lagrange_runtime::Scalar;
use lagrange_runtime::prelude::{SVector, lagrangian};

lagrangian! {
    /// r along a rod whose origin lies at a along it and b across it from the axis. Problem 11.6.
    pub system SliderOnTable {
        param m, om, a, b;
        coord r;
        coord theta = om * t;
        let u = a + r;
        let x = u * theta.cos() - b * theta.sin();
        let y = u * theta.sin() + b * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
    }
}

golden!(SliderOnTable<1>, "prob-11.6-slider-on-spinning-table", |p| SliderOnTable {
    m: p("m"),
    om: p("om"),
    a: p("a"),
    b: p("b")
});

lagrangian! {
    /// With the table free to turn, to find the force of the rod.
    pub system SliderOnFreeTable {
        param m, a, b;
        coord r, theta;
        let u = a + r;
        let x = u * theta.cos() - b * theta.sin();
        let y = u * theta.sin() + b * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
    }
}

golden!(SliderOnFreeTable<2>, "prob-11.6-slider-on-spinning-table", |p| SliderOnFreeTable {
    m: p("m"),
    a: p("a"),
    b: p("b")
});

lagrangian! {
    /// Held by a spring that is slack at the origin. Problem 11.7.
    pub system SliderWithSpring {
        param m, om, a, b, k;
        coord r;
        coord theta = om * t;
        let u = a + r;
        let x = u * theta.cos() - b * theta.sin();
        let y = u * theta.sin() + b * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * r.powi(2);
    }
}

golden!(SliderWithSpring<1>, "prob-11.7-slider-with-spring", |p| SliderWithSpring {
    m: p("m"),
    om: p("om"),
    a: p("a"),
    b: p("b"),
    k: p("k")
});

lagrangian! {
    /// On a rod inclined at al to a vertical shaft. Problem 11.8, stand-in.
    pub system SliderOnInclinedRod {
        param m, om, al, g = 9.81;
        coord s;
        coord phi = om * t;
        let rho = s * al.sin();
        let x = rho * phi.cos();
        let y = rho * phi.sin();
        let z = s * al.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
    }
}

golden!(SliderOnInclinedRod<1>, "prob-11.8-slider-inclined-rod", |p| SliderOnInclinedRod {
    m: p("m"),
    om: p("om"),
    al: p("al"),
    g: p("g")
});

lagrangian! {
    /// Between two springs. Problem 11.9.
    pub system SliderBetweenSprings {
        param m, k, om, b;
        coord x;
        coord theta = om * t;
        let u = x * theta.cos() - b * theta.sin();
        let v = x * theta.sin() + b * theta.cos();
        T = 0.5 * m * (dot(u).powi(2) + dot(v).powi(2));
        V = k * x.powi(2);
        observe torque = reaction(theta);
    }
}

golden!(SliderBetweenSprings<1>, "prob-11.9-slider-two-springs", |p| SliderBetweenSprings {
    m: p("m"),
    k: p("k"),
    om: p("om"),
    b: p("b")
});

lagrangian! {
    /// On a radial rod, with the table free under a given force across the rod. Problem 11.9(b).
    pub system SliderRelaxed {
        param m, k, R0;
        coord x, theta;
        let u = x * theta.cos();
        let v = x * theta.sin();
        T = 0.5 * m * (dot(u).powi(2) + dot(v).powi(2));
        V = k * x.powi(2);
        force [-R0 * theta.sin(), R0 * theta.cos()] at [u, v];
    }
}

golden!(SliderRelaxed<2>, "prob-11.9b-slider-relaxed", |p| SliderRelaxed {
    m: p("m"),
    k: p("k"),
    R0: p("R0")
});

/// Torque on the table.
fn drive<S: Scalar>(t: S, mu0: S, om: S) -> S {
    mu0 * (om * t).cos()
}

lagrangian! {
    /// With the table driven; K is its radius of gyration. Problem 11.26; the torque is a choice.
    pub system DrivenTable {
        param m, k, M, K, b, mu0, om;
        coord x, theta;
        extern fn drive(t, mu0, om);
        let u = x * theta.cos() - b * theta.sin();
        let v = x * theta.sin() + b * theta.cos();
        T = 0.5 * M * (K * dot(theta)).powi(2) + 0.5 * m * (dot(u).powi(2) + dot(v).powi(2));
        V = k * x.powi(2);
        Q[theta] = drive(t, mu0, om);
    }
}

golden!(DrivenTable<2>, "prob-11.26-table-rod-slider-driven", |p| DrivenTable {
    m: p("m"),
    k: p("k"),
    M: p("M"),
    K: p("K"),
    b: p("b"),
    mu0: p("mu0"),
    om: p("Om")
}, with an extern fn);

pub fn rows() -> Vec<Row> {
    vec![free(), sprung(), inclined(), between_springs(), relaxed(), driven()]
}

/// (r + a) grows as cosh ωt; the force of the rod is across it and does no virtual work.
fn free() -> Row {
    let row = Row::of::<SliderOnTable, 1>(
        "conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let closed = reference.special("closed_form");
    let [start, rate, t, end, centred] =
        ["r(0)", "rdot(0)", "t", "r", "r_if_a_zero"].map(|name| number(&closed[name]));
    let [m, om, a, b] = ["m", "om", "a", "b"].map(|name| reference.parameter(name));
    let relaxed = Subject::of::<SliderOnFreeTable, 2>();
    let [speed, force] = ["rdot", "R"].map(|name| number(&reference.special("rod_force")[name]));
    let state = State::new(&[-a, 0.0], &[speed, om], 0.0);
    let bend = row.subject().accelerations(&State::new(&[-a], &[speed], 0.0))[0];
    // At r = −a the slider is at b across the axis: the moment of the forces is that of what the rod gives along
    // itself, which is nothing, and of R at the arm r + a = 0; so the moment is taken one unit further out.
    let outer = State::new(&[1.0 - a, 0.0], &[speed, om], 0.0);
    let outward = row.subject().accelerations(&State::new(&[1.0 - a], &[speed], 0.0))[0];
    row.motion("sinh", (&[start], &[rate]), t, &[(0, end)])
        .motion_with(&[("a", 0.0)], "sinh from the axis", (&[start], &[rate]), t, &[(0, centred)])
        .reaction("along the rod", &relaxed, (&state, &[bend, 0.0]), 0, 0.0)
        .reaction("R", &relaxed, (&outer, &[outward, 0.0]), 1, force)
        .balance("2 m ω ṙ − m ω² b", &[2.0 * m * om * speed, -m * om * om * b, -force])
        .number("sinh", rate / om * (om * t).sinh(), centred)
}

/// From rest at O: cos below the critical speed, t² at it, cosh above.
fn sprung() -> Row {
    let mut row = Row::of::<SliderWithSpring, 1>(
        "conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    for case in list(reference.special("released_from_rest_at_O")) {
        let [om, t, end] = ["omega", "t", "r"].map(|name| number(&case[name]));
        row = row.motion_with(&[("om", om)], "from rest", (&[0.0], &[0.0]), t, &[(0, end)]);
    }
    // The stiffness falls linearly with ω², to 0 at the critical speed.
    let fall = |om: f64, r: f64| {
        row.subject().clone().with(&[("om", om)]).accelerations(&State::new(&[r], &[0.0], 0.0))[0]
    };
    let stiffness = |om: f64| fall(om, 0.0) - fall(om, 1.0);
    let critical = (stiffness(0.0) / (stiffness(0.0) - stiffness(1.0))).sqrt();
    let expected = number(&list(reference.special("released_from_rest_at_O"))[1]["omega"]);
    row.special("critical ω", critical, expected)
}

/// The slider is pushed away, at the rate ω sin α, from where it could rest on the rod.
fn inclined() -> Row {
    let row = Row::of::<SliderOnInclinedRod, 1>(
        "conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0],
    );
    let place = row.subject().reference.special("relative_equilibrium").clone();
    let g = row.subject().reference.parameter("g");
    let [s, growth] = ["s", "growth_rate"].map(|name| number(&place[name]));
    let fall = |s: f64| row.subject().accelerations(&State::new(&[s], &[0.0], 0.0))[0];
    let (rest, slope) = (fall(s), fall(1.0) - fall(0.0));
    row.within("rest on the rod", rest, 0.0, 1e-13 * g)
        .within("growth", slope.sqrt(), growth, 1e-13 * g / growth)
        .show("growth rate", slope.sqrt(), growth)
}

/// R = m (2ω ẋ − ω² b), the force across the rod; the springs pull along it.
fn between_springs() -> Row {
    let mut row = Row::of::<SliderBetweenSprings, 1>(
        "conservative, separable, constant inertia, quadratic, linear",
        [-2.0..2.0],
    );
    let reference = row.subject().reference.clone();
    let [b, om, k] = ["b", "om", "k"].map(|name| reference.parameter(name));
    let relaxed = Subject::of::<DrivenTable, 2>().with(&[
        ("m", reference.parameter("m")),
        ("k", k),
        ("b", b),
        ("M", 0.0),
        ("mu0", 0.0),
    ]);
    for case in list(reference.special("reaction_R_of_x")) {
        let [x, rate, force] = ["x", "xdot", "R"].map(|name| number(&case[name]));
        let bend = row.subject().accelerations(&State::new(&[x], &[rate], 0.0))[0];
        let state = State::new(&[x, 0.0], &[rate, om], 0.0);
        let slider = with_reference::<SliderBetweenSprings, 1>();
        let emitted = slider.torque(&SVector::from([x]), &SVector::from([rate]), 0.0);
        // The springs, fixed to the table, turn it by their pull at the arm b, and R at the arm x.
        let terms = [force * x, 2.0 * k * x * b];
        let size = terms[0].abs() + terms[1].abs() + om * om * b * x.abs();
        row = row.within("emitted torque", emitted, terms[0] + terms[1], 1e-13 * size);
        row = row.reaction("R", &relaxed, (&state, &[bend, 0.0]), 1, force * x + 2.0 * k * x * b);
    }
    row
}

/// With R = 2 m ω ẋ the table keeps its speed.
fn relaxed() -> Row {
    let row = Row::of::<SliderRelaxed, 2>("scleronomic, quadratic", [0.2..2.0, -3.0..3.0]);
    let [x, rate, om] = [0.4, 0.7, 3.0];
    let force = 2.0 * row.subject().reference.parameter("m") * om * rate;
    let driven = row.subject().clone().with(&[("R0", force)]);
    let found = driven.accelerations(&State::new(&[x, 0.0], &[rate, om], 0.0))[1];
    row.within("θ̈ under R", found, 0.0, 1e-13 * 2.0 * om * rate / x)
}

/// The torque for constant speed, while the slider oscillates with p² = 2k/m − ω².
fn driven() -> Row {
    let mut row = Row::of::<DrivenTable, 2>("scleronomic, quadratic", [-2.0..2.0, -3.0..3.0]);
    let torque = row.subject().reference.special("torque_for_constant_speed").clone();
    let idle = row.subject().clone().with(&[("mu0", 0.0)]);
    let [om, square] = ["omega", "p2"].map(|name| number(&torque[name]));
    for case in list(&torque["cases"]) {
        let [x, rate, moment] = ["x", "xdot", "mu_F"].map(|name| number(&case[name]));
        let state = State::new(&[x, 0.0], &[rate, om], 0.0);
        row = row
            .reaction("nothing along the rod", &idle, (&state, &[-square * x, 0.0]), 0, 0.0)
            .reaction("μ_F", &idle, (&state, &[-square * x, 0.0]), 1, moment)
            .show("μ_F", required(&idle, &state, &[-square * x, 0.0])[1].0, moment);
    }
    row
}
