//! Rigid bodies on springs, and one on water, near rest. Problems 11.15, 11.17, 11.27, 11.30, 11.32, 11.33 and 11.36:
//! that of Problem 11.30 is reconstructed (the hinge lies between the spring and the mass, which its question about the
//! masses supports), the others are stand-ins, since the problems refer to other chapters.

use super::harness::{Row, State, Subject, number};
use lagrange_runtime::prelude::lagrangian;

lagrangian! {
    /// A hanging rod with a horizontal spring at the distance b from its hinge. Problem 11.15.
    pub system RodAndSpring {
        param m, l, b, k, g = 9.81;
        coord theta;
        T = 0.5 * (m * l.powi(2) / 3) * dot(theta).powi(2);
        V = 0.5 * m * g * l * (1 - theta.cos()) + 0.5 * k * (b * theta.sin()).powi(2);
    }
}

golden!(RodAndSpring<1>, "prob-11.15-rod-and-spring", |p| RodAndSpring {
    m: p("m"),
    l: p("l"),
    b: p("b"),
    k: p("k"),
    g: p("g")
});

lagrangian! {
    /// A log of water-plane area A: heave y and roll θ, with metacentric height h. Problem 11.17.
    pub system FloatingLog {
        param m, A, rho, J, h, g = 9.81;
        coord y, theta;
        T = 0.5 * m * dot(y).powi(2) + 0.5 * J * dot(theta).powi(2);
        V = 0.5 * rho * g * A * y.powi(2) + m * g * h * (1 - theta.cos());
    }
}

golden!(FloatingLog<2>, "prob-11.17-floating-log", |p| FloatingLog {
    m: p("m"),
    A: p("A"),
    rho: p("rho"),
    J: p("J"),
    h: p("h"),
    g: p("g")
});

lagrangian! {
    /// Two masses m at ±l on a light rod, carried by springs at ±b. Problem 11.27.
    pub system DumbbellOnSprings {
        param m, l, b, k;
        coord y, theta;
        let x1 = l * theta.cos();
        let y1 = y + l * theta.sin();
        let x2 = -l * theta.cos();
        let y2 = y - l * theta.sin();
        T = 0.5 * m * (dot(x1).powi(2) + dot(y1).powi(2) + dot(x2).powi(2) + dot(y2).powi(2));
        V = 0.5 * k * ((y + b * theta.sin()).powi(2) + (y - b * theta.sin()).powi(2));
    }
}

golden!(DumbbellOnSprings<2>, "prob-11.27-dumbbell-on-springs", |p| DumbbellOnSprings {
    m: p("m"),
    l: p("l"),
    b: p("b"),
    k: p("k")
});

lagrangian! {
    /// A rod of mass M on a hinge, with a spring at its end a and a mass m at its end b, turned a little. Problem
    /// 11.30.
    pub system RodMassSpring {
        param m, M, a, b, k;
        coord theta;
        T = 0.5 * (m * b.powi(2) + M * (a.powi(2) - a * b + b.powi(2)) / 3) * dot(theta).powi(2);
        V = 0.5 * k * (a * theta).powi(2);
    }
}

golden!(RodMassSpring<1>, "prob-11.30-rod-mass-spring", |p| RodMassSpring {
    m: p("m"),
    M: p("M"),
    a: p("a"),
    b: p("b"),
    k: p("k")
});

lagrangian! {
    /// The same with the hinge free to rise by y, to find its force.
    pub system RodOnFreeHinge {
        param m, M, a, b, k;
        coord theta, y;
        T = 0.5 * m * (dot(y) + b * dot(theta)).powi(2)
            + 0.5 * M * (dot(y) + 0.5 * (b - a) * dot(theta)).powi(2)
            + 0.5 * (M * (a + b).powi(2) / 12) * dot(theta).powi(2);
        V = 0.5 * k * (y - a * theta).powi(2);
    }
}

golden!(RodOnFreeHinge<2>, "prob-11.30-rod-mass-spring", |p| RodOnFreeHinge {
    m: p("m"),
    M: p("M"),
    a: p("a"),
    b: p("b"),
    k: p("k")
});

lagrangian! {
    /// A bar on two springs at −l1 and l2 from its centre: bounce and pitch. Problem 11.32.
    pub system BounceAndPitch {
        param m, IC, k1, k2, l1, l2;
        coord y, theta;
        T = 0.5 * m * dot(y).powi(2) + 0.5 * IC * dot(theta).powi(2);
        V = 0.5 * k1 * (y - l1 * theta).powi(2) + 0.5 * k2 * (y + l2 * theta).powi(2);
    }
}

golden!(BounceAndPitch<2>, "prob-11.32-bounce-pitch", |p| BounceAndPitch {
    m: p("m"),
    IC: p("IC"),
    k1: p("k1"),
    k2: p("k2"),
    l1: p("l1"),
    l2: p("l2")
});

lagrangian! {
    /// A rod that hangs from a slider on a spring. Problem 11.33.
    pub system SliderSpringRod {
        param M, m, l, k, g = 9.81;
        coord x, theta;
        let u = x + 0.5 * l * theta.sin();
        let v = -0.5 * l * theta.cos();
        T = 0.5 * M * dot(x).powi(2)
            + 0.5 * m * (dot(u).powi(2) + dot(v).powi(2))
            + 0.5 * (m * l.powi(2) / 12) * dot(theta).powi(2);
        V = 0.5 * k * x.powi(2) + m * g * (v + 0.5 * l);
    }
}

golden!(SliderSpringRod<2>, "prob-11.33-slider-spring-rod", |p| SliderSpringRod {
    M: p("M"),
    m: p("m"),
    l: p("l"),
    k: p("k"),
    g: p("g")
});

lagrangian! {
    /// A light rod with a mass below and one above its hinge, and a horizontal spring at the lower one. Problem 11.36.
    pub system Metronome {
        param m1, m2, l1, l2, k, g = 9.81;
        coord theta;
        let x1 = l1 * theta.sin();
        let y1 = -l1 * theta.cos();
        let x2 = -l2 * theta.sin();
        let y2 = l2 * theta.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2 + 0.5 * k * x1.powi(2);
    }
}

golden!(Metronome<1>, "prob-11.36-metronome", |p| Metronome {
    m1: p("m1"),
    m2: p("m2"),
    l1: p("l1"),
    l2: p("l2"),
    k: p("k"),
    g: p("g")
});

pub fn rows() -> Vec<Row> {
    vec![
        with_frequency(
            Row::of::<RodAndSpring, 1>(
                "scleronomic, conservative, separable, constant inertia, quadratic",
                [-3.0..3.0],
            ),
            "frequency",
        ),
        with_frequency(
            Row::of::<FloatingLog, 2>(
                "scleronomic, conservative, separable, constant inertia, quadratic, blocks y | theta",
                [-2.0..2.0, -3.0..3.0],
            ),
            "roll_frequency",
        ),
        with_frequency(
            Row::of::<DumbbellOnSprings, 2>(
                "scleronomic, conservative, separable, constant inertia, quadratic, blocks y | theta",
                [-2.0..2.0, -3.0..3.0],
            ),
            "rotational",
        ),
        rod_mass_spring(),
        Row::of::<BounceAndPitch, 2>(
            "scleronomic, conservative, separable, constant inertia, quadratic, linear",
            [-2.0..2.0, -2.0..2.0],
        ),
        Row::of::<SliderSpringRod, 2>("scleronomic, conservative, quadratic", [-2.0..2.0, -3.0..3.0]),
        Row::of::<Metronome, 1>(
            "scleronomic, conservative, separable, constant inertia, quadratic",
            [-3.0..3.0],
        ),
    ]
}

/// The lowest frequency, in closed form.
fn with_frequency(row: Row, name: &str) -> Row {
    let found = row.special.as_ref().expect("a frequency").value;
    let expected = number(row.subject().reference.special(name));
    row.special("ω₁", found, expected)
}

/// With b = 2a the reaction of the hinge is −(3/2) k a θ, whatever the masses.
fn rod_mass_spring() -> Row {
    let mut row = with_frequency(
        Row::of::<RodMassSpring, 1>(
            "scleronomic, conservative, separable, constant inertia, quadratic, linear",
            [-2.0..2.0],
        ),
        "frequency",
    );
    let case = row.subject().reference.special("case_b_equal_2a").clone();
    let expected = number(&case["reaction_per_theta"]);
    for (m, rod) in [
        (row.subject().reference.parameter("m"), row.subject().reference.parameter("M")),
        (0.1, 3.0),
        (2.0, 0.2),
    ] {
        let masses = [("m", m), ("M", rod)];
        let hinged = row.subject().clone().with(&masses);
        let free = Subject::of::<RodOnFreeHinge, 2>().with(&masses);
        let bend = hinged.accelerations(&State::new(&[1.0], &[0.0], 0.0))[0];
        let state = State::new(&[1.0, 0.0], &[0.0, 0.0], 0.0);
        row = row.reaction("reaction of the hinge", &free, (&state, &[bend, 0.0]), 1, expected);
    }
    row
}
