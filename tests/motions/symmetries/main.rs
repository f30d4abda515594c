//! Invariance of the equations of motion: under the direction of time, the origin of an ignorable coordinate, units,
//! the choice and the order of coordinates. Every comparison carries its own bound of the rounding on both sides.

#[path = "../properties/bounded.rs"]
mod bounded;
mod frames;

use bounded::Bounded;
use lagrange_runtime::prelude::*;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

lagrangian! {
    /// A bob on a spring that hangs from a block which slides; everything may turn with φ, which is ignorable.
    pub system Sling {
        param M, m, l, k, g;
        coord x: length, theta: angle, r: length, phi: angle;
        let u = x + r * theta.sin();
        let v = -r * theta.cos();
        T = 0.5 * M * dot(x).powi(2) + 0.5 * m * (dot(u).powi(2) + dot(v).powi(2)) + 0.5 * m * (l * l + u * u) * dot(phi).powi(2);
        V = m * g * v + 0.5 * k * (r - l).powi(2);
    }
}

lagrangian! {
    /// The same, its coordinates declared in another order.
    pub system Permuted {
        param M, m, l, k, g;
        coord phi: angle, r: length, x: length, theta: angle;
        let u = x + r * theta.sin();
        let v = -r * theta.cos();
        T = 0.5 * M * dot(x).powi(2) + 0.5 * m * (dot(u).powi(2) + dot(v).powi(2)) + 0.5 * m * (l * l + u * u) * dot(phi).powi(2);
        V = m * g * v + 0.5 * k * (r - l).powi(2);
    }
}

lagrangian! {
    /// The same in coordinates y with (x, θ, r, φ) = C y; `c` are the rows of C.
    pub system Changed {
        param M, m, l, k, g, c: [16];
        coord y: [4];
        let x = (0..4).map(|j| c[j] * y[j]).sum();
        let theta = (0..4).map(|j| c[4 + j] * y[j]).sum();
        let r = (0..4).map(|j| c[8 + j] * y[j]).sum();
        let phi = (0..4).map(|j| c[12 + j] * y[j]).sum();
        let u = x + r * theta.sin();
        let v = -r * theta.cos();
        T = 0.5 * M * dot(x).powi(2) + 0.5 * m * (dot(u).powi(2) + dot(v).powi(2)) + 0.5 * m * (l * l + u * u) * dot(phi).powi(2);
        V = m * g * v + 0.5 * k * (r - l).powi(2);
    }
}

lagrangian! {
    /// The bob on a rod in Cartesian coordinates, in a wind across it.
    pub system Held {
        param m, l, g, w;
        coord x, y, z;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * y - w * z;
        constraint rod: x * x + y * y == l * l;
    }
}

/// M, m, l, k and g; q; q̇.
type Drawn = ([f64; 5], [f64; 4], [f64; 4]);

fn vector<const N: usize>(numbers: [Bounded; N]) -> SVector<Bounded, N> {
    numbers.into()
}

fn exact<const N: usize>(numbers: [f64; N]) -> [Bounded; N] {
    numbers.map(Bounded::exact)
}

fn sling([big, m, l, k, g]: [Bounded; 5]) -> Sling<Bounded> {
    Sling { M: big, m, l, k, g }
}

const NOW: Bounded = Bounded { value: 0.0, error: 0.0 };

/// Runs a check at random parameters and states, the same ones each time.
fn at_random(check: impl Fn(Drawn)) {
    let config = ProptestConfig {
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::with_cases(1000)
    };
    // Away from r = 0, where the coordinates are singular.
    let states = (
        prop::array::uniform5(0.5..2.0f64),
        (-2.0..2.0f64, -3.0..3.0f64, 0.5..2.0f64, -3.0..3.0f64).prop_map(<[f64; 4]>::from),
        prop::array::uniform4(-2.0..2.0f64),
    );
    if let Err(error) = TestRunner::new(config).run(&states, |drawn| {
        check(drawn);
        Ok(())
    }) {
        panic!("{error}");
    }
}

fn agree<const N: usize>(found: &SVector<Bounded, N>, expected: &SVector<Bounded, N>, what: &str) {
    for i in 0..N {
        found[i].assert_agrees(expected[i], || format!("{what}, q̈[{i}]"));
    }
}

/// Without friction and time, the motion run backward is a motion.
#[test]
fn time_reversal() {
    at_random(|(parameters, q, qd)| {
        let system = sling(exact(parameters));
        let (q, qd) = (vector(exact(q)), vector(exact(qd)));
        agree(&system.accel(&q, &-qd, NOW), &system.accel(&q, &qd, NOW), "backward");
        let p = (system.momenta(&q, &qd, NOW), system.momenta(&q, &-qd, NOW));
        agree(&-p.1, &p.0, "momenta");
    });
}

#[test]
fn origin_of_an_ignorable_coordinate() {
    assert_eq!(Sling::<f64>::FACTS.ignorable, [3]);
    at_random(|(parameters, q, qd)| {
        let system = sling(exact(parameters));
        let moved = [q[0], q[1], q[2], q[3] + 1234.5];
        let [here, there] = [q, moved].map(|q| system.accel(&vector(exact(q)), &vector(exact(qd)), NOW));
        // Not a bound: φ does not appear at all.
        assert_eq!(here, there);
    });
}

/// In units of mass, length and time that are μ, λ and τ times smaller, numbers change by their dimensions.
#[test]
fn change_of_units() {
    at_random(|(parameters, q, qd)| {
        let [mu, lambda, tau] = [1.7, 0.3, 2.9].map(Bounded::exact);
        let one = Bounded::exact(1.0);
        let [big, m, l, k, g] = exact(parameters);
        let (q, qd) = (exact(q), exact(qd));
        // x, θ, r, φ
        let units = [lambda, one, lambda, one];
        let scaled =
            |numbers: [Bounded; 4], by: Bounded| vector(std::array::from_fn(|i| numbers[i] * units[i] * by));
        let other = sling([mu * big, mu * m, lambda * l, mu * k / (tau * tau), lambda * g / (tau * tau)]);
        let found = other.accel(&scaled(q, one), &scaled(qd, one / tau), NOW);
        let accel = sling([big, m, l, k, g]).accel(&vector(q), &vector(qd), NOW);
        agree(&found, &scaled(accel.into(), one / (tau * tau)), "other units");
        let energy = other.energy_function(&scaled(q, one), &scaled(qd, one / tau), NOW);
        let unit = mu * lambda * lambda / (tau * tau);
        energy.assert_agrees(
            unit * sling([big, m, l, k, g]).energy_function(&vector(q), &vector(qd), NOW),
            || "h".into(),
        );
    });
}

#[test]
fn order_of_the_coordinates() {
    at_random(|(parameters, q, qd)| {
        let [big, m, l, k, g] = exact(parameters);
        let (q, qd) = (exact(q), exact(qd));
        // φ, r, x, θ
        let ordered = |v: [Bounded; 4]| vector([3, 2, 0, 1].map(|i: usize| v[i]));
        let found = Permuted { M: big, m, l, k, g }.accel(&ordered(q), &ordered(qd), NOW);
        let accel = sling([big, m, l, k, g]).accel(&vector(q), &vector(qd), NOW);
        agree(&found, &ordered(accel.into()), "another order");
    });
}

#[test]
fn linear_change_of_coordinates() {
    // Rows with a large diagonal, so that C has an inverse of moderate size.
    const C: [f64; 16] = [2., 0.5, 0., -0.25, 0.25, 1.5, 0.5, 0., -0.5, 0.25, 2., 0.5, 0., -0.5, 0.25, 1.];
    let product = |v: &SVector<Bounded, 4>| {
        let row = |i: usize| {
            (0..4).map(|j| Bounded::exact(C[4 * i + j]) * v[j]).reduce(|a, b| a + b).expect("four")
        };
        SVector::<Bounded, 4>::from_fn(|i, _| row(i))
    };
    at_random(|(parameters, y, yd)| {
        let [big, m, l, k, g] = exact(parameters);
        // The third coordinate is 2 y₂ and more: away from r = 0 for |y₁|, |y₀| and |y₃| that are small.
        let (y, yd) = ([0.1 * y[0], 0.1 * y[1], y[2], 0.1 * y[3]], yd);
        let (y, yd) = (vector(exact(y)), vector(exact(yd)));
        let changed = Changed { M: big, m, l, k, g, c: exact(C) };
        let (q, qd) = (product(&y), product(&yd));
        let accel = sling([big, m, l, k, g]).accel(&q, &qd, NOW);
        agree(&product(&changed.accel(&y, &yd, NOW)), &accel, "other coordinates");
        let h = sling([big, m, l, k, g]).energy_function(&q, &qd, NOW);
        changed.energy_function(&y, &yd, NOW).assert_agrees(h, || "h is a scalar".into());
    });
}

/// The same of a system with a constraint: its accelerations and its multiplier.
#[test]
fn constrained_motion() {
    at_random(|([m, l, g, w, _], q, qd)| {
        let system = |[m, l, g, w]: [Bounded; 4]| Held { m, l, g, w };
        let numbers = exact([m, l, g, w]);
        // The equations hold wherever the constraint is regular, on it or not.
        let (q, qd) = (vector(exact([q[0], 0.5 + q[2], q[3]])), vector(exact([qd[0], qd[1], qd[2]])));
        let held = system(numbers);
        agree(&held.accel(&q, &-qd, NOW), &held.accel(&q, &qd, NOW), "backward");
        let [mu, lambda, tau] = [1.7, 0.3, 2.9].map(Bounded::exact);
        let [m, l, g, w] = numbers;
        let force = mu * lambda / (tau * tau);
        let other = system([mu * m, lambda * l, lambda * g / (tau * tau), force * w]);
        let (scaled, moving) = (q.map(|x| lambda * x), qd.map(|v| lambda * v / tau));
        let accel = held.accel(&q, &qd, NOW).map(|a| lambda * a / (tau * tau));
        agree(&other.accel(&scaled, &moving, NOW), &accel, "other units");
        // λ ∂f/∂q is a force, and ∂f/∂q a length.
        let multiplier = held.multipliers(&q, &qd, NOW)[0] * force / lambda;
        other.multipliers(&scaled, &moving, NOW)[0].assert_agrees(multiplier, || "λ".into());
        // The accelerations leave d²f/dt² = 0.
        let a = held.accel(&q, &qd, NOW);
        let rate = |v: &SVector<Bounded, 3>, a: &SVector<Bounded, 3>| {
            let two = Bounded::exact(2.0);
            two * (v[0] * v[0] + v[1] * v[1] + q[0] * a[0] + q[1] * a[1])
        };
        rate(&qd, &a).assert_agrees(NOW, || "d²f/dt²".into());
    });
}
