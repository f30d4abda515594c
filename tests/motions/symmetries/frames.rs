//! The same of rigid bodies on frames, free and held by constraints on places and on velocities.

use super::*;

lagrangian! {
    /// A crane: a trolley on a jib that slews, and a load which hangs from it by a universal joint.
    pub system Crane {
        param M, m, l, I, g;
        coord phi: angle, s: length, theta: angle, psi: angle;
        let trolley = frame(frame(world, [0, 0, 0], rotation_z(phi)), [s, 0, 0]);
        let load = frame(trolley, [0, 0, 0], rotation_x(theta) * rotation_y(psi));
        let centre = frame(load, [0, 0.25 * l, -l]);
        T = body(M, [I, I, 3 * I], trolley) + body(m, [2 * I, I, I], centre);
        V = m * g * centre.origin()[2] + 0.5 * m * g / l * s.powi(2);
    }
}

lagrangian! {
    /// The same with its coordinates in another order.
    pub system Reordered {
        param M, m, l, I, g;
        coord psi: angle, phi: angle, theta: angle, s: length;
        let trolley = frame(frame(world, [0, 0, 0], rotation_z(phi)), [s, 0, 0]);
        let load = frame(trolley, [0, 0, 0], rotation_x(theta) * rotation_y(psi));
        let centre = frame(load, [0, 0.25 * l, -l]);
        T = body(M, [I, I, 3 * I], trolley) + body(m, [2 * I, I, I], centre);
        V = m * g * centre.origin()[2] + 0.5 * m * g / l * s.powi(2);
    }
}

lagrangian! {
    /// The same in coordinates y with (φ, s, θ, ψ) = C y; `c` are the rows of C.
    pub system Mixed {
        param M, m, l, I, g, c: [16];
        coord y: [4];
        let x: [4] = |i| (0..4).map(|j| c[4 * i + j] * y[j]).sum();
        let trolley = frame(frame(world, [0, 0, 0], rotation_z(x[0])), [x[1], 0, 0]);
        let load = frame(trolley, [0, 0, 0], rotation_x(x[2]) * rotation_y(x[3]));
        let centre = frame(load, [0, 0.25 * l, -l]);
        T = body(M, [I, I, 3 * I], trolley) + body(m, [2 * I, I, I], centre);
        V = m * g * centre.origin()[2] + 0.5 * m * g / l * x[1].powi(2);
    }
}

lagrangian! {
    /// The same with the load led at a height and the trolley kept from moving across.
    pub system Led {
        param M, m, l, I, g;
        coord phi: angle, s: length, theta: angle, psi: angle;
        let trolley = frame(frame(world, [0, 0, 0], rotation_z(phi)), [s, 0, 0]);
        let load = frame(trolley, [0, 0, 0], rotation_x(theta) * rotation_y(psi));
        let centre = frame(load, [0, 0.25 * l, -l]);
        T = body(M, [I, I, 3 * I], trolley) + body(m, [2 * I, I, I], centre);
        V = m * g * centre.origin()[2] + 0.5 * m * g / l * s.powi(2);
        constraint height: centre.origin()[2] == -0.5 * l;
        constraint wheels: velocity(trolley)[0] == l * angular_velocity(load)[2];
    }
}

/// Mass, length and time in units that are μ, λ and τ times smaller.
const UNITS: [f64; 3] = [1.7, 0.3, 2.9];

/// The parameters in other units, and the length of each coordinate.
fn scaled([big, m, l, i, g]: [Bounded; 5]) -> [Bounded; 5] {
    let [mu, lambda, tau] = UNITS.map(Bounded::exact);
    [mu * big, mu * m, lambda * l, mu * lambda * lambda * i, lambda * g / (tau * tau)]
}

fn crane([big, m, l, i, g]: [Bounded; 5]) -> Crane<Bounded> {
    Crane { M: big, m, l, I: i, g }
}

/// φ, s, θ and ψ by their lengths.
fn lengths(v: SVector<Bounded, 4>, by: Bounded) -> SVector<Bounded, 4> {
    let lambda = Bounded::exact(UNITS[1]);
    SVector::from([v[0] * by, lambda * v[1] * by, v[2] * by, v[3] * by])
}

/// Away from where θ = ±π/2 turns the axis of ψ into that of φ, with the load on the ground.
fn at(q: [f64; 4]) -> [f64; 4] {
    [q[1], q[2], 0.4 * q[0], 0.3 * q[3]]
}

#[test]
fn time_reversal() {
    at_random(|(parameters, q, qd)| {
        let (system, q, qd) = (crane(exact(parameters)), vector(exact(at(q))), vector(exact(qd)));
        agree(&system.accel(&q, &-qd, NOW), &system.accel(&q, &qd, NOW), "backward");
        agree(&-system.momenta(&q, &-qd, NOW), &system.momenta(&q, &qd, NOW), "momenta");
    });
}

#[test]
fn origin_of_an_ignorable_coordinate() {
    assert_eq!(Crane::<f64>::FACTS.ignorable, [0]);
    at_random(|(parameters, q, qd)| {
        let system = crane(exact(parameters));
        let [_, s, theta, psi] = at(q);
        let [here, there] = [0.3, 1234.5]
            .map(|phi| system.accel(&vector(exact([phi, s, theta, psi])), &vector(exact(qd)), NOW));
        assert_eq!(here, there);
    });
}

#[test]
fn change_of_units() {
    at_random(|(parameters, q, qd)| {
        let [mu, lambda, tau] = UNITS.map(Bounded::exact);
        let (one, parameters) = (Bounded::exact(1.0), exact(parameters));
        let (q, qd) = (vector(exact(at(q))), vector(exact(qd)));
        let (here, other) = (crane(parameters), crane(scaled(parameters)));
        let (there, moving) = (lengths(q, one), lengths(qd, one / tau));
        let expected = lengths(here.accel(&q, &qd, NOW), one / (tau * tau));
        agree(&other.accel(&there, &moving, NOW), &expected, "other units");
        let h = mu * lambda * lambda / (tau * tau) * here.energy_function(&q, &qd, NOW);
        other.energy_function(&there, &moving, NOW).assert_agrees(h, || "h".into());
    });
}

#[test]
fn order_of_the_coordinates() {
    at_random(|(parameters, q, qd)| {
        let [big, m, l, i, g] = exact(parameters);
        let (q, qd) = (exact(at(q)), exact(qd));
        // ψ, φ, θ, s
        let ordered = |v: [Bounded; 4]| vector([3, 0, 2, 1].map(|i: usize| v[i]));
        let found = Reordered { M: big, m, l, I: i, g }.accel(&ordered(q), &ordered(qd), NOW);
        let accel = crane([big, m, l, i, g]).accel(&vector(q), &vector(qd), NOW);
        agree(&found, &ordered(accel.into()), "another order");
    });
}

#[test]
fn linear_change_of_coordinates() {
    const C: [f64; 16] =
        [1., 0.5, 0., -0.25, 0.25, 1.5, 0.5, 0., -0.125, 0.125, 0.5, 0., 0., -0.25, 0.125, 0.5];
    at_random(|(parameters, y, yd)| {
        let [big, m, l, i, g] = exact(parameters);
        let (y, yd) = (vector(exact(at(y))), vector(exact(yd)));
        let product = |v: &SVector<Bounded, 4>| {
            let row = |i: usize| {
                (0..4).map(|j| Bounded::exact(C[4 * i + j]) * v[j]).reduce(|a, b| a + b).expect("four")
            };
            SVector::<Bounded, 4>::from_fn(|i, _| row(i))
        };
        let mixed = Mixed { M: big, m, l, I: i, g, c: exact(C) };
        let (q, qd) = (product(&y), product(&yd));
        let here = crane([big, m, l, i, g]);
        agree(&product(&mixed.accel(&y, &yd, NOW)), &here.accel(&q, &qd, NOW), "other coordinates");
        mixed
            .energy_function(&y, &yd, NOW)
            .assert_agrees(here.energy_function(&q, &qd, NOW), || "h is a scalar".into());
    });
}

/// Held at a height and kept from moving across: backward, in other units, with what holds it.
#[test]
fn constrained_motion() {
    at_random(|(parameters, q, qd)| {
        let [mu, lambda, tau] = UNITS.map(Bounded::exact);
        let (one, parameters) = (Bounded::exact(1.0), exact(parameters));
        let led = |[big, m, l, i, g]: [Bounded; 5]| Led { M: big, m, l, I: i, g };
        let (here, other) = (led(parameters), led(scaled(parameters)));
        // The height is regular where the load hangs obliquely.
        let [phi, s, theta, psi] = at(q);
        let q = vector(exact([phi, s, 0.5 + 0.3 * theta.abs(), 0.25 + 0.5 * psi.abs()]));
        let qd = vector(exact(qd));
        agree(&here.accel(&q, &-qd, NOW), &here.accel(&q, &qd, NOW), "backward");
        let (there, moving) = (lengths(q, one), lengths(qd, one / tau));
        let expected = lengths(here.accel(&q, &qd, NOW), one / (tau * tau));
        agree(&other.accel(&there, &moving, NOW), &expected, "other units");
        // Both rows are lengths, by coordinates or by their rates: their multipliers are forces.
        let force = mu * lambda / (tau * tau);
        let (found, multipliers) = (other.multipliers(&there, &moving, NOW), here.multipliers(&q, &qd, NOW));
        for j in 0..2 {
            found[j].assert_agrees(force * multipliers[j], || format!("λ[{j}]"));
        }
    });
}
