//! Simplified systems against those that a person would have written, and against the whole ones, which they approach.

use lagrange_runtime::prelude::*;

/// Reproducible numbers in [−1, 1) (SplitMix64: Steele, Lea and Flood 2014).
fn random<const N: usize>(seed: u64) -> [f64; N] {
    let mut state = seed;
    std::array::from_fn(|_| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        2.0 * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    })
}

/// The accelerations, and the energy function but for a constant, of two systems at random states.
#[track_caller]
fn agree<const N: usize>(
    found: &impl Lagrangian<N, Scalar = f64>,
    by_hand: &impl Lagrangian<N, Scalar = f64>,
) {
    let at = |seed| State::new(0.3, random(seed), random(seed + 1000));
    let energies = |s: &State<f64, N>| {
        [found.energy_function(&s.q, &s.qd, s.t), by_hand.energy_function(&s.q, &s.qd, s.t)]
    };
    let [constant, other] = energies(&at(0));
    for seed in 0..30 {
        let s = at(seed);
        let (a, b) = (found.accel(&s.q, &s.qd, s.t), by_hand.accel(&s.q, &s.qd, s.t));
        assert!((a - b).amax() < 1e-12 * b.amax().max(1.0), "{a} against {b}");
        let [e, f] = energies(&s);
        assert!((e - constant - f + other).abs() < 1e-12 * f.abs().max(1.0), "{e} against {f}");
    }
}

/// Operations of the accelerations, each weighted by its time as the compiler does: a sine and cosine count as forty
/// products.
fn cost(facts: &lagrange_runtime::Facts) -> usize {
    let o = facts.operations;
    o.additions + o.multiplications + 4 * o.divisions + 40 * o.sin_cos + 30 * o.functions
}

/// The order of the error of the accelerations in the size of a motion about `centre`.
fn order<Small, const N: usize, const HELD: usize>(whole: &Small::Whole, centre: [f64; N]) -> f64
where
    Small: Restricted<N, HELD, N, Scalar = f64>,
{
    let small = Small::of(whole);
    let error = |size: f64| {
        let (q, qd) = (random::<N>(3), random::<N>(4));
        let s = State::new(0.2, std::array::from_fn(|i| centre[i] + size * q[i]), qd.map(|x| size * x));
        let lifted = small.lift(&s);
        assert_eq!(Small::restrict(whole, &lifted).expect("nothing is held").1, s);
        (small.accel(&s.q, &s.qd, s.t) - whole.accel(&s.q, &s.qd, s.t)).amax()
    };
    (error(0.02) / error(0.01)).log2()
}

lagrangian! {
    /// Two masses on rods in a plane, with friction and a push.
    pub system Double {
        param m1, m2, l1, l2, c, f, g = 9.81, a = 0.4;
        coord theta1: angle, theta2: angle;
        let x1 = l1 * theta1.sin();
        let z1 = -l1 * theta1.cos();
        let x2 = x1 + l2 * theta2.sin();
        let z2 = z1 - l2 * theta2.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(z1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(z2).powi(2));
        V = m1 * g * z1 + m2 * g * z2;
        D = 0.5 * c * (dot(theta2) - dot(theta1)).powi(2) * (1 + theta1 * theta1);
        Q[theta1] = f * (theta1 - theta2).sin();
        observe tip = [x2, z2];
        /// Small oscillations.
        pub simplified Small: expand [theta1, theta2] to 2 about 0;
        pub simplified Fourth: expand [theta1, theta2] to 4 about [0, 0];
        pub simplified Upright: expand [theta1, theta2] to 2 about [PI, 0];
        pub simplified Bent: expand [theta1, theta2] to 3 about [a, -a];
        pub simplified Light: neglect m2, lock theta2 = 0;
        pub simplified Free: neglect dissipation, neglect f;
    }
}

lagrangian! {
    /// The same for small angles, with all terms of T, V and D to order 2, and of Q to order 1.
    pub system Linear {
        param m1, m2, l1, l2, c, f, g = 9.81;
        coord a, b;
        T = 0.5 * (m1 + m2) * (l1 * dot(a)).powi(2) + m2 * l1 * l2 * dot(a) * dot(b) + 0.5 * m2 * (l2 * dot(b)).powi(2);
        V = 0.5 * g * ((m1 + m2) * l1 * a * a + m2 * l2 * b * b);
        D = 0.5 * c * (dot(b) - dot(a)).powi(2);
        Q[a] = f * (a - b);
    }
}

lagrangian! {
    pub system LinearUpright {
        param m1, m2, l1, l2, c, f, g = 9.81;
        coord p, b;
        let a = p - PI;
        T = 0.5 * (m1 + m2) * (l1 * dot(a)).powi(2) - m2 * l1 * l2 * dot(a) * dot(b) + 0.5 * m2 * (l2 * dot(b)).powi(2);
        V = 0.5 * g * (-(m1 + m2) * l1 * a * a + m2 * l2 * b * b);
        D = 0.5 * c * (dot(b) - dot(a)).powi(2) * (1 + PI * PI);
        Q[p] = -f * (a - b);
    }
}

lagrangian! {
    /// To order 4, those of the forces to order 3.
    pub system Quartic {
        param m1, m2, l1, l2, c, f, g = 9.81;
        coord a, b;
        T = 0.5 * (m1 + m2) * (l1 * dot(a)).powi(2) + m2 * l1 * l2 * dot(a) * dot(b) * (1 - 0.5 * (a - b).powi(2)) + 0.5 * m2 * (l2 * dot(b)).powi(2);
        V = g * ((m1 + m2) * l1 * (a.powi(2) / 2 - a.powi(4) / 24) + m2 * l2 * (b.powi(2) / 2 - b.powi(4) / 24));
        D = 0.5 * c * (dot(b) - dot(a)).powi(2) * (1 + a * a);
        Q[a] = f * ((a - b) - (a - b).powi(3) / 6);
    }
}

lagrangian! {
    pub system Single {
        param m, l, c, f, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * theta.cos();
        D = 0.5 * c * dot(theta).powi(2) * (1 + theta * theta);
        Q[theta] = f * theta.sin();
    }
}

#[test]
fn expansions_of_a_double_pendulum() {
    let double = Double::new(1.2, 0.8, 0.7, 0.5, 0.3, 0.9);
    agree(&Small::of(&double), &Linear::new(1.2, 0.8, 0.7, 0.5, 0.3, 0.9));
    agree(&Upright::of(&double), &LinearUpright::new(1.2, 0.8, 0.7, 0.5, 0.3, 0.9));
    agree(&Fourth::of(&double), &Quartic::new(1.2, 0.8, 0.7, 0.5, 0.3, 0.9));
    const {
        assert!(
            Small::<f64>::FACTS.linear
                && Small::<f64>::FACTS.constant_inertia
                && !Fourth::<f64>::FACTS.linear
        );
    };
    // Energies to order N make equations with errors of order N, or N + 1 where L is even. Where the pendulum does
    // not rest, accelerations are not small, and M, of which N − 2 orders are left, has errors of order N − 1.
    for (found, expected) in [
        (order::<Small, 2, 0>(&double, [0.0; 2]), 3.0),
        (order::<Fourth, 2, 0>(&double, [0.0; 2]), 5.0),
        (order::<Bent, 2, 0>(&double, [0.4, -0.4]), 2.0),
    ] {
        assert!((found - expected).abs() < 0.1, "{found} instead of {expected}");
    }
    for facts in [
        &Small::<f64>::FACTS,
        &Fourth::<f64>::FACTS,
        &Upright::<f64>::FACTS,
        &Bent::<f64>::FACTS,
        &Light::<f64>::FACTS,
        &Free::<f64>::FACTS,
    ] {
        assert!(cost(facts) <= cost(&Double::<f64>::FACTS), "{}", facts.name);
    }
}

#[test]
fn terms_that_are_neglected() {
    let double = Double::new(1.2, 0.8, 0.7, 0.5, 0.3, 0.9);
    // Without m2 nothing depends on theta2 but friction, and it is held; the parameter is gone.
    let light = Light { m1: 1.2, l1: 0.7, l2: 0.5, c: 0.3, f: 0.9, g: 9.81, a: 0.4 };
    assert_eq!(light, Light::of(&double));
    agree(&light, &Single::new(1.2, 0.7, 0.3, 0.9));
    let free = Free::of(&double);
    agree(&free, &Double { c: 0.0, f: 0.0, ..double });
    const { assert!(Free::<f64>::FACTS.conservative && !Double::<f64>::FACTS.conservative) };
    let s = State::new(0.0, [0.3, 0.2], [0.1, -0.4]);
    assert_eq!(free.tip(&s.q, &s.qd, 0.0), double.tip(&s.q, &s.qd, 0.0));
}

lagrangian! {
    /// Foucault's pendulum by its place in the plane, with a coupling that has a name, and a spring in place of the
    /// rod.
    pub system Foucault {
        param m, l, omega, k, g = 9.81;
        coord x, y, r;
        let coupling = 0.3 * k * x.powi(2) * y;
        let across: [2] = |i| if i == 0 { x } else { y } * dot(r);
        T = 0.5 * m * ((dot(x) - omega * y).powi(2) + (dot(y) + omega * x).powi(2)) + 0.5 * m * (1 + x * x) * dot(r).powi(2)
            + 0.2 * m * (across[0] + across[1]) * dot(y);
        V = 0.5 * m * g / l * (x * x + y * y) + coupling + 0.5 * k * (r - l).powi(2);
        pub simplified Straight: lock r = l, neglect coupling, neglect gyroscopic;
        pub simplified Round: lock r = l, neglect coupling;
        pub simplified Uncoupled: neglect across, neglect coupling;
        pub simplified Frozen: inertia at x = 0, neglect across, neglect coupling;
    }
}

lagrangian! {
    pub system Plane {
        param m, l, omega, gyroscopic, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * m * omega.powi(2) * (x * x + y * y) + gyroscopic * m * omega * (x * dot(y) - y * dot(x));
        V = 0.5 * m * g / l * (x * x + y * y);
    }
}

lagrangian! {
    pub system Third {
        param m, l, omega, k, even, g = 9.81;
        coord x, y, r;
        T = 0.5 * m * ((dot(x) - omega * y).powi(2) + (dot(y) + omega * x).powi(2)) + 0.5 * m * (1 + even * x * x) * dot(r).powi(2);
        V = 0.5 * m * g / l * (x * x + y * y) + 0.5 * k * (r - l).powi(2);
    }
}

#[test]
fn kinds_of_terms() {
    let foucault = Foucault::new(1.3, 2.0, 0.4, 5.0);
    agree(&Straight::of(&foucault), &Plane::new(1.3, 2.0, 0.4, 0.0));
    agree(&Round::of(&foucault), &Plane::new(1.3, 2.0, 0.4, 1.0));
    agree(&Uncoupled::of(&foucault), &Third::new(1.3, 2.0, 0.4, 5.0, 1.0));
    agree(&Frozen::of(&foucault), &Third::new(1.3, 2.0, 0.4, 5.0, 0.0));
    let start = State::new(0.0, [0.1, 0.0, 2.0], [0.0; 3]);
    assert_eq!(
        Straight::restrict(&foucault, &start).expect("at its length").1,
        State::new(0.0, [0.1, 0.0], [0.0; 2])
    );
    let long = State::new(0.0, [0.1, 0.0, 2.1], [0.0; 3]);
    assert_eq!(Straight::restrict(&foucault, &long).expect_err("too long").coordinate, "r");
}

lagrangian! {
    /// A quarter of a car on a road, its wheel on a tyre that is driven and pushed; and a pendulum on a spring.
    pub system Car {
        param body, wheel, k, c, tyre, push, speed, m, l, stiff, g = 9.81;
        coord x, w, r, theta;
        coord road = 0.05 * (speed * t).sin();
        let spring = r - l;
        T = 0.5 * body * dot(x).powi(2) + 0.5 * wheel * dot(w).powi(2) + 0.5 * m * (dot(r).powi(2) + (r * dot(theta)).powi(2));
        V = 0.5 * k * (x - w).powi(2) + 0.5 * tyre * (w - road).powi(2) + 0.5 * stiff * spring.powi(2) - m * g * r * theta.cos();
        D = 0.5 * c * (dot(x) - dot(w)).powi(2);
        Q[w] = push * x;
        Q[r] = 0.1 * m;
        observe grip = w - road;
        observe pull = reaction(road);
        pub simplified Condensed: quasistatic w, quasistatic r;
        /// Without the motion of the road there is no reaction to it, and no output of it.
        pub simplified Parked: neglect speed;
    }
}

lagrangian! {
    pub system ByHand {
        param body, wheel, k, c, tyre, push, speed, m, l, stiff, g = 9.81;
        coord x, theta;
        let road = 0.05 * (speed * t).sin();
        let w = (k * x + tyre * road + push * x) / (k + tyre);
        let r = l + m * (g * theta.cos() + 0.1) / stiff;
        T = 0.5 * body * dot(x).powi(2) + 0.5 * wheel * dot(w).powi(2) + 0.5 * m * (dot(r).powi(2) + (r * dot(theta)).powi(2));
        V = 0.5 * k * (x - w).powi(2) + 0.5 * tyre * (w - road).powi(2) + 0.5 * stiff * (r - l).powi(2) - m * g * r * theta.cos();
        force c * (dot(w) - dot(x)) at x - w;
        force push * x at w;
        force 0.1 * m at r;
    }
}

#[test]
fn what_follows_as_in_statics() {
    let car = Car::new(300.0, 40.0, 2e3, 150.0, 2e4, 30.0, 7.0, 0.4, 0.8, 90.0);
    let by_hand = ByHand::new(300.0, 40.0, 2e3, 150.0, 2e4, 30.0, 7.0, 0.4, 0.8, 90.0);
    let condensed = Condensed::of(&car);
    agree(&condensed, &by_hand);
    agree(&Parked::of(&car), &Car { speed: 0.0, ..car });
    // What follows is where statics has it, at its rate.
    let s = State::new(0.2, [0.03, 0.5], [0.1, -0.7]);
    let lifted = condensed.lift(&s);
    let road = |t: f64| 0.05 * (7.0 * t).sin();
    let w = |t: f64, x: f64| (2e3 * x + 2e4 * road(t) + 30.0 * x) / 22e3;
    let r = |theta: f64| 0.8 + 0.4 * (9.81 * theta.cos() + 0.1) / 90.0;
    assert!((lifted.q - SVector::from([0.03, w(0.2, 0.03), r(0.5), 0.5])).amax() < 1e-15);
    let rate = |f: &dyn Fn(f64) -> f64| (f(1e-5) - f(-1e-5)) / 2e-5;
    let rates = [0.1, rate(&|h| w(0.2 + h, 0.03 + 0.1 * h)), rate(&|h| r(0.5 - 0.7 * h)), -0.7];
    assert!((lifted.qd - SVector::from(rates)).amax() < 1e-9);
    // A start is not asked for them.
    let start = State::new(0.2, [0.03, 9.0, 9.0, 0.5], [0.1, 9.0, 9.0, -0.7]);
    assert_eq!(Condensed::restrict(&car, &start).expect("nothing is held").1, s);
    assert!((condensed.grip(&s.q, &s.qd, 0.2) - (w(0.2, 0.03) - road(0.2))).abs() < 1e-15);
}

lagrangian! {
    /// A bob on a rod, a mass on a spring that it pulls, and a direction beside them.
    pub system Pulling {
        param m, l, k, c, g = 9.81;
        coord x, y, s;
        coord n: direction;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.1 * dot(s).powi(2) + 0.5 * dot(n).norm_squared();
        V = m * g * y + 0.5 * k * (s - x * y).powi(2) + s + 0.3 * n[2] * x;
        D = 0.5 * c * dot(s).powi(2);
        constraint rod: x * x + y * y == l * l;
        pub simplified Followed: quasistatic s;
    }
}

lagrangian! {
    pub system FollowedByHand {
        param m, l, k, c, g = 9.81;
        coord x, y;
        coord n: direction;
        let s = x * y - 1 / k;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.1 * dot(s).powi(2) + 0.5 * dot(n).norm_squared();
        V = m * g * y + 0.5 * k * (s - x * y).powi(2) + s + 0.3 * n[2] * x;
        D = 0.5 * c * dot(s).powi(2);
        constraint rod: x * x + y * y == l * l;
    }
}

/// Multipliers have no part in the statics of a coordinate that is in no constraint.
#[test]
fn what_follows_beside_constraints() {
    let whole = Pulling::new(2.0, 1.3, 40.0, 0.7);
    let by_hand = FollowedByHand::new(2.0, 1.3, 40.0, 0.7);
    agree(&Followed::of(&whole), &by_hand);
}

lagrangian! {
    /// A pendulum whose pivot is shaken along an ellipse, from the lowest point, in the axes of the world and in
    /// those of the pivot.
    pub system Shaken {
        param m, l, c, a, b, omega, g = 9.81;
        coord theta: angle;
        coord x = b * (omega * t).sin();
        coord y = a * (omega * t).cos();
        let px = x + l * theta.sin();
        let py = y - l * theta.cos();
        T = 0.5 * m * (dot(px).powi(2) + dot(py).powi(2));
        V = m * g * py;
        D = 0.5 * c * dot(theta).powi(2);
        pub simplified Mean: average omega * t;
    }
}

lagrangian! {
    pub system Accelerated {
        param m, l, c, a, b, omega, g = 9.81;
        coord theta: angle;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * (g - a * omega.powi(2) * (omega * t).cos()) * l * theta.cos() - m * b * omega.powi(2) * (omega * t).sin() * l * theta.sin();
        D = 0.5 * c * dot(theta).powi(2);
        pub simplified MeanThere: average omega * t;
    }
}

lagrangian! {
    /// With Kapitza's potential of both directions.
    pub system Effective {
        param m, l, c, a, b, omega, g = 9.81;
        coord theta: angle;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * theta.cos() + 0.25 * m * omega.powi(2) * ((a * theta.sin()).powi(2) + (b * theta.cos()).powi(2));
        D = 0.5 * c * dot(theta).powi(2);
    }
}

lagrangian! {
    /// Two rods, the upper one on a shaken pivot that moves at the start; the lower bob is pushed in turn.
    pub system ShakenTwo {
        param l, a, f, omega, g = 9.81;
        coord theta1: angle, theta2: angle;
        coord y = a * (omega * t).sin() + 0.3 * a * (2 * omega * t).cos();
        let x1 = l * theta1.sin();
        let y1 = y - l * theta1.cos();
        let x2 = x1 + l * theta2.sin();
        let y2 = y1 - l * theta2.cos();
        T = 0.5 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = g * (y1 + y2);
        Q[theta2] = f * theta1 - 0.1 * dot(theta1);
        pub simplified MeanTwo: average omega * t;
    }
}

#[test]
fn means_of_fast_motions() {
    let by_hand = Effective::new(0.7, 0.4, 0.02, 0.03, 0.02, 150.0);
    let shaken = Shaken::new(0.7, 0.4, 0.02, 0.03, 0.02, 150.0);
    agree(&Mean::of(&shaken), &by_hand);
    agree(&MeanThere::of(&Accelerated::new(0.7, 0.4, 0.02, 0.03, 0.02, 150.0)), &by_hand);
    const { assert!(Mean::<f64>::FACTS.autonomous && !Shaken::<f64>::FACTS.autonomous) };
    // Upside down, and stable, since a²ω² > 2 g l (Kapitza 1951).
    let upright = Mean::of(&Shaken { b: 0.0, omega: 150.0, ..shaken });
    let pull = |theta: f64| upright.accel(&[theta].into(), &[0.0].into(), 0.0)[0];
    assert!((0.03f64 * 150.0).powi(2) > 2.0 * 9.81 * 0.4 && pull(3.0) > 0.0 && pull(3.2) < 0.0);
    // The distance from the whole motion goes with 1/ω, also from a start at which the pivot moves.
    let distance = |omega: f64| {
        let whole = ShakenTwo::new(0.5, 2.5 / omega, 0.4, omega);
        let start = State::new(0.0, [0.6, -0.4], [0.3, 1.2]);
        let (mean, left) = MeanTwo::restrict(&whole, &start).expect("nothing is held");
        let back = mean.lift(&left);
        assert!((back.qd - start.qd).amax() < 1e-13 && (left.qd - start.qd).amax() > 0.1);
        let control = PiController::tolerance(1e-10);
        let end = integrate(&mean, Dop853, control, left).until(1.0).final_state().expect("it runs");
        let exact = integrate(&whole, Dop853, control, start).until(1.0).final_state().expect("it runs");
        (mean.lift(&end).q - exact.q).amax()
    };
    let [coarse, fine] = [400.0, 1600.0].map(distance);
    assert!(fine < 0.02 && coarse / fine > 2.8 && coarse / fine < 5.6, "{coarse} {fine}");
}

lagrangian! {
    /// A spherical pendulum by a direction, whose components are tied to each other, beside an oscillator.
    system Beside {
        param m, l, e, g = 9.81;
        coord n: direction, s;
        let bob = l * n;
        T = 0.5 * m * dot(bob).norm_squared() + 0.5 * m * dot(s).powi(2);
        V = m * g * bob[2] + 0.5 * s * s + e * s * s * n[0];
        simplified Apart: neglect e;
    }
}

#[test]
fn a_term_in_one_component_of_a_direction_is_neglected() {
    let beside = Beside::new(1.0, 0.5, 0.1);
    let apart = Apart::of(&beside);
    let at = beside.with_direction_n(
        State::new(0.0, [0.0; 4], [0.0; 4]),
        &nalgebra::Vector3::new(0.6, 0.0, 0.8),
        &nalgebra::Vector3::zeros(),
    );
    let found = apart.accel(&at.q, &at.qd, 0.0);
    // m l² n̈ = −m g l e_z + λ n, with λ = m g l n_z at rest.
    let expected = [9.81 / 0.5 * 0.8 * 0.6, 0.0, 9.81 / 0.5 * (0.8 * 0.8 - 1.0)];
    assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-13), "{found}");
}
