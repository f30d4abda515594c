//! Systems with coordinates held against the whole ones that they came from and against those that a person would
//! have written, at reproducible random states and along motions.

use lagrange_runtime::prelude::*;

/// Difference of two accelerations, in parts of the largest one.
const TOLERANCE: f64 = 1e-13;

/// Reproducible numbers in [lo, hi) (SplitMix64: Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self, lo: f64, hi: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        lo + (hi - lo) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A restricted system at random states: the whole one accelerates as it does, and not at all where it is held.
fn check<Small, const N: usize, const HELD: usize, const WHOLE: usize>(whole: &Small::Whole)
where
    Small: Restricted<N, HELD, WHOLE, Scalar = f64>,
{
    let mut random = Random(5);
    let small = Small::of(whole);
    for _ in 0..40 {
        let state: State<f64, N> = State::new(
            random.next(-2.0, 2.0),
            std::array::from_fn(|_| random.next(-1.4, 1.4)),
            std::array::from_fn(|_| random.next(-1.5, 1.5)),
        );
        let lifted = small.lift(&state);
        let (again, back) = Small::restrict(whole, &lifted).expect("it is where it is held");
        assert_eq!(back, state);
        assert_eq!(again.accel(&state.q, &state.qd, state.t), small.accel(&state.q, &state.qd, state.t));
        let found = small.accel(&state.q, &state.qd, state.t);
        let expected = whole.accel(&lifted.q, &lifted.qd, lifted.t);
        let size = expected.amax().max(1.0);
        for (k, &i) in Small::KEPT.iter().enumerate() {
            assert!(
                (found[k] - expected[i]).abs() <= TOLERANCE * size,
                "{} against {}",
                found[k],
                expected[i]
            );
        }
        for &i in &Small::REMOVED {
            assert!(expected[i].abs() <= TOLERANCE * size, "{} of {size}", expected[i]);
        }
        let energies = [
            (
                small.energy_function(&state.q, &state.qd, state.t),
                whole.energy_function(&lifted.q, &lifted.qd, lifted.t),
            ),
            (small.power(&state.q, &state.qd, state.t), whole.power(&lifted.q, &lifted.qd, lifted.t)),
        ];
        for (a, b) in energies {
            assert!((a - b).abs() <= 1e-13 * b.abs().max(1.0), "{a} against {b}");
        }
        for (moved, from) in [(1e-9, 0), (0.5, 1)] {
            let mut off = lifted;
            let at = Small::REMOVED[from.min(HELD - 1)];
            off.qd[at] += moved;
            let error = Small::restrict(whole, &off).map(|_| ()).expect_err("it moves");
            assert!(error.moves && error.found == off.qd[at] && error.held == lifted.qd[at]);
            off = lifted;
            off.q[at] += moved;
            let error = Small::restrict(whole, &off).map(|_| ()).expect_err("it is elsewhere");
            assert!(
                !error.moves
                    && error.coordinate == <Small::Whole as Lagrangian<WHOLE>>::FACTS.coordinates[at]
            );
        }
    }
}

/// Operations of an evaluation.
fn operations(facts: &lagrange_runtime::Facts) -> usize {
    let o = facts.operations;
    o.additions + o.multiplications + o.divisions + o.sin_cos + o.functions
}

lagrangian! {
    /// Two masses on rods in space; in a plane where the angles φ vanish, or at 180°.
    pub system Spatial {
        param m1, m2, l1, l2, g = 9.81;
        coord theta1: angle, phi1: angle, theta2: angle, phi2: angle;
        let x1 = l1 * theta1.sin() * phi1.cos();
        let y1 = l1 * phi1.sin();
        let z1 = -l1 * theta1.cos() * phi1.cos();
        let x2 = x1 + l2 * theta2.sin() * phi2.cos();
        let y2 = y1 + l2 * phi2.sin();
        let z2 = z1 - l2 * theta2.cos() * phi2.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2) + dot(z1).powi(2))
            + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2) + dot(z2).powi(2));
        V = m1 * g * z1 + m2 * g * z2;
        observe tip = [x2, y2, z2];
        event low: z2 + l1, falling;
        event across: y2;
        pub restriction Planar: phi1 = 0, phi2 = 0;
        pub restriction Turned: phi1 = PI, phi2 = PI;
        pub restriction Sideways: theta1 = 0, theta2 = 0;
        pub restriction Upside: theta1 = 0, theta2 = PI;
    }
}

lagrangian! {
    pub system DoublePendulum {
        param m1, m2, l1, l2, g = 9.81;
        coord theta1: angle, theta2: angle;
        let x1 = l1 * theta1.sin();
        let z1 = -l1 * theta1.cos();
        let x2 = x1 + l2 * theta2.sin();
        let z2 = z1 - l2 * theta2.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(z1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(z2).powi(2));
        V = m1 * g * z1 + m2 * g * z2;
    }
}

#[test]
fn the_planes_of_a_spatial_double_pendulum() {
    let spatial = Spatial::new(1.3, 0.7, 0.9, 0.6);
    check::<Planar, 2, 2, 4>(&spatial);
    check::<Turned, 2, 2, 4>(&spatial);
    check::<Sideways, 2, 2, 4>(&spatial);
    check::<Upside, 2, 2, 4>(&spatial);
    let written = operations(&DoublePendulum::<f64>::FACTS);
    assert_eq!(operations(&Planar::<f64>::FACTS), written);
    assert!(operations(&Turned::<f64>::FACTS) <= written);
    assert!(operations(&Spatial::<f64>::FACTS) > 4 * written, "or else there is nothing to gain");
    let by_hand = DoublePendulum::new(1.3, 0.7, 0.9, 0.6);
    let start = State::new(0.0, [2.0, 0.0, 1.0, 0.0], [0.3, 0.0, -0.4, 0.0]);
    let (planar, left) = Planar::restrict(&spatial, &start).expect("it starts in the plane");
    assert_eq!(planar.accel(&left.q, &left.qd, 0.0), by_hand.accel(&left.q, &left.qd, 0.0));
    assert_eq!(Planar::<f64>::FACTS.coordinates, ["theta1", "theta2"]);
    assert_eq!(Planar::<f64>::FACTS.kinds, [CoordinateKind::Angle; 2]);
    assert!((planar.tip(&left.q, &left.qd, 0.0) - spatial.tip(&start.q, &start.qd, 0.0)).amax() < 1e-15);
    // Events are those of the whole system, but for one whose function vanishes in the plane.
    let run = integrate(&planar, Dop853, PiController::tolerance(1e-10), left).until(5.0);
    let met: Result<Vec<_>, _> = run.events(Planar::LOW).collect();
    assert!(met.expect("it runs").len() > 1);
    // A whole motion is that of the part.
    let fine = PiController::tolerance(1e-12);
    let part = integrate(&planar, Dop853, fine, left).until(1.0).final_state().expect("it runs");
    let whole = integrate(&spatial, Dop853, fine, start).until(1.0).final_state().expect("it runs");
    let lifted = planar.lift(&part);
    assert!((lifted.q - whole.q).amax() < 1e-9 && (lifted.qd - whole.qd).amax() < 1e-8);
}

lagrangian! {
    /// A chain in space, on a cart that is driven: arrays of coordinates, an element of one, inputs, states, forces,
    /// dissipation, a constraint.
    pub system Chain {
        const N = 3;
        param m, l, c, a, r, g = 9.81;
        input u;
        coord s, theta: [N], phi: [angle; N], w;
        state i = 0.1;
        rate(i) = u - r * i - dot(s);
        coord lift_off = 0.1 * (3.0 * t).sin();
        let x: [N] = |i| if i == 0 { s } else { x[i - 1] } + l * theta[i].sin() * phi[i].cos();
        let y: [N] = |i| if i == 0 { 0 } else { y[i - 1] } + l * phi[i].sin();
        let z: [N] = |i| if i == 0 { lift_off } else { z[i - 1] } - l * theta[i].cos() * phi[i].cos();
        T = 0.5 * m * dot(s).powi(2) + 0.5 * m * dot(w).powi(2)
            + (0..N).map(|i| 0.5 * m * (dot(x[i]).powi(2) + dot(y[i]).powi(2) + dot(z[i]).powi(2))).sum();
        V = (0..N).map(|i| m * g * z[i]).sum() + 0.5 * (w - a).powi(2) + (y[2] * (w - a)).powi(2);
        D = 0.5 * c * (dot(s).powi(2) + dot(phi).norm_squared());
        Q[s] = i + u;
        Q[phi] = (0..N).map(|i| -0.1 * phi[i] * dot(s)).collect();
        Q[w] = phi[2];
        force [-0.2 * dot(x[2]), -0.3 * dot(y[2]) * dot(x[2]).abs(), 0] at [x[2], y[2], z[2]];
        constraint rail: s + w == a + 0.2 * x[0];
        observe far = [x[2], y[2], z[2]];
        observe pull = reaction(lift_off);
        impulse sideways at y[2];
        event taut: y[2] - 1;
        event high: z[2], rising;
        pub restriction Flat: phi = 0;
    }
}

#[test]
fn a_chain_with_all_that_a_system_can_have() {
    let chain = Chain { u: 0.7, ..Chain::new(1.1, 0.4, 0.3, 0.8, 0.9) };
    // The state of first order is the velocity of a last coordinate: 3 angles of 9 numbers leave.
    check::<Flat, 6, 3, 9>(&chain);
    let flat = Flat::of(&chain);
    assert_eq!((Flat::<f64>::INPUTS, Flat::<f64>::STATES), (["u"], ["i"]));
    let state = State::new(0.3, [0.1, 0.4, -0.3, 0.9, 0.2, 0.0], [0.2, 0.1, -0.6, 0.4, 0.3, 0.5]);
    let lifted = flat.lift(&state);
    let pulls = [flat.pull(&state.q, &state.qd, 0.3), chain.pull(&lifted.q, &lifted.qd, 0.3)];
    assert!((pulls[0] - pulls[1]).abs() < 1e-12 * pulls[1].abs(), "{pulls:?}");
    let multipliers =
        [flat.multipliers(&state.q, &state.qd, 0.3), chain.multipliers(&lifted.q, &lifted.qd, 0.3)];
    assert!((multipliers[0] - multipliers[1]).amax() < 1e-12);
    assert_eq!(flat.sideways(&state.q, 0.3, 1.0).amax(), 0.0);
}

lagrangian! {
    /// Bodies in space on a turntable that turns at a given rate: a pendulum about a horizontal axis that carries a
    /// wheel.
    pub system Turntable {
        param m, l, A, C, omega, g = 9.81;
        coord theta: angle, phi: angle, spin: angle, slide;
        let table = frame(world, [0, 0, 0], rotation_z(omega * t + slide));
        let arm = frame(table, [0, 0, 0], rotation_x(theta));
        let side = frame(arm, [0, 0, -l], rotation_y(phi));
        let wheel = frame(side, [0, 0, 0], rotation_z(spin));
        T = body(m, [A, A, C], wheel) + 0.5 * dot(slide).powi(2);
        V = m * g * wheel.origin()[2] + 0.5 * slide.powi(2);
        couple [0, 0, -0.1 * dot(spin)] on wheel;
        pub restriction Upright: phi = 0, theta = 0;
    }
}

#[test]
fn bodies_on_a_turntable() {
    check::<Upright, 2, 2, 4>(&Turntable::new(0.8, 0.5, 0.02, 0.03, 0.0));
    check::<Upright, 2, 2, 4>(&Turntable::new(0.8, 0.5, 0.02, 0.03, 1.7));
}

lagrangian! {
    /// Two equal oscillators, by the place of one and its distance from the other: what starts a apart stays so,
    /// though inertia couples the two numbers.
    pub system Apart {
        param m, k, a;
        coord x, d;
        T = 0.5 * m * dot(x).powi(2) + 0.5 * m * (dot(x) + dot(d)).powi(2);
        V = 0.5 * k * x.powi(2) + 0.5 * k * (x + d - a).powi(2);
        pub restriction Together: d = a;
    }
}

#[test]
fn the_accelerations_of_the_rest_are_enough() {
    check::<Together, 1, 1, 2>(&Apart::new(1.3, 2.0, 0.7));
    const { assert!(Together::<f64>::FACTS.linear) };
}

lagrangian! {
    /// A lag drives a mass, and that one another, whose spring pulls at a third one; nothing acts back on the first.
    pub system Servo {
        param k, c, tau;
        coord load, other, mass;
        state lag;
        rate(lag) = ((2 * t).sin() - lag) / tau;
        T = 0.5 * (dot(load).powi(2) + dot(other).powi(2) + dot(mass).powi(2));
        V = 0.5 * k * ((load - other).powi(2) + mass * mass);
        D = 0.5 * c * dot(mass).powi(2);
        Q[mass] = lag;
        Q[load] = k * (mass - load);
    }
}

lagrangian! {
    /// x is driven by a constraint in which y moves nothing.
    pub system Led {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * y * y;
        constraint led: dot(x) == y;
    }
}

#[test]
fn drivers_come_before_what_they_drive() {
    let facts = <Servo as Lagrangian<4>>::FACTS;
    assert_eq!(facts.coordinates, ["load", "other", "mass", "lag"]);
    assert_eq!(facts.cascade, [&[3][..], &[2], &[0, 1]]);
    assert_eq!(facts.blocks, [&[0, 1, 2, 3][..]]);
    let facts = <Led as Lagrangian<2>>::FACTS;
    assert_eq!((facts.cascade, facts.blocks), (&[&[1][..], &[0]][..], &[&[0, 1][..]][..]));
    // Coordinates that are all coupled are one group.
    assert_eq!(<Spatial as Lagrangian<4>>::FACTS.cascade, [&[0, 1, 2, 3][..]]);
}
