//! States of first order against closed forms and digits of mpmath: every method, events, samples, lanes,
//! derivatives, analysis.
#![allow(clippy::excessive_precision)]

use lagrange_runtime::Controller;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::InputJacobian;

lagrangian! {
    /// A motor on a pendulum, the current of its armature, and a controller that integrates its error.
    pub system Drive {
        param m, l, c, r, inductance, k, kp, ki, g = 9.81;
        input target = 0.8;
        coord theta: angle;
        /// The current.
        state i = 0.1, e;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
        D = 0.5 * c * dot(theta).powi(2);
        Q[theta] = k * i;
        let u = kp * (target - theta) + ki * e;
        rate(i) = (u - r * i - k * dot(theta)) / inductance;
        rate(e) = target - theta;
        observe voltage = u;
    }
}

lagrangian! {
    /// Coils that are charged beside a pendulum, which does not notice.
    system Coils {
        const N = 2;
        param r: [N], l: [N], u;
        coord x;
        state i: [N] = [0.25, 0];
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        rate(i[1]) = (u - r[1] * i[1]) / l[1];
        rate(i[0]) = (u - r[0] * i[0]) / l[0];
    }
}

lagrangian! {
    /// States in V and D, in a force at a place, and in each other's rates.
    system Mixed {
        param m, a;
        coord x, y;
        state z, w;
        let tip = x + 0.5 * y.sin();
        T = 0.5 * m * (dot(x).powi(2) + dot(tip).powi(2));
        V = 0.5 * (x - z).powi(2) + w * z * y;
        D = 0.5 * (1 + z.powi(2)) * dot(x).powi(2);
        force [a * w] at [tip];
        rate(z) = sin(x) - w * z + dot(y);
        rate(w) = z.powi(2) - w + 0.1 * t;
    }
}

fn drive() -> Drive {
    Drive::new(0.5, 0.4, 0.02, 1.3, 0.07, 0.35, 4.0, 3.0)
}

/// (θ, θ̇, i, e) at t = 0.5 and t = 2, from 40 digits of mpmath's Taylor series of the equations written out by hand.
const DIGITS: [[f64; 4]; 2] = [
    [0.395_758_618_491_782_35, 1.081_035_515_776_926_1, 1.756_354_551_848_079_3, 0.295_956_434_579_626_1],
    [0.534_265_954_583_407_3, -0.628_463_481_127_043_2, 2.675_750_031_396_201_6, 0.794_130_505_542_939_3],
];

fn start() -> State<f64, 3> {
    drive().start(0.0, [0.2], [-0.5])
}

/// Largest error at t = 2.
fn error(end: &State<f64, 3>) -> f64 {
    let found = [end.q[0], end.qd[0], end.qd[1], end.qd[2]];
    (0..4).map(|j| (found[j] - DIGITS[1][j]).abs()).fold(0.0, f64::max)
}

fn after<M, C>(method: M, controller: C) -> f64
where
    M: Method<Drive, 3>,
    C: Controller<f64, 3, M::Error>,
{
    error(&integrate(&drive(), method, controller, start()).until(2.0).final_state().unwrap())
}

#[test]
fn methods_agree_with_reference_digits() {
    let pi = PiController::tolerance(1e-11);
    for (name, error, bound) in [
        ("DormandPrince5", after(DormandPrince5, pi), 1e-9),
        ("Dop853", after(Dop853, pi), 1e-9),
        ("Verner9", after(Verner9, PiController::tolerance(1e-13)), 1e-12),
        ("Rk4", after(Rk4, FixedStep::new(1e-3)), 1e-9),
        ("Radau5", after(Radau5, pi), 1e-9),
        ("Rodas5P", after(Rodas5P, pi), 1e-8),
        ("Taylor", after(Taylor::of_order(20), TaylorController::tolerance(1e-15)), 4e-15),
    ] {
        assert!(error < bound, "{name}: {error:e}");
    }
    // Of fourth order.
    let [coarse, fine] = [0.02, 0.01].map(|h| after(Rk4, FixedStep::new(h)));
    assert!((coarse / fine).log2() > 3.7, "{coarse:e} {fine:e}");
}

#[test]
fn series_of_double_double_have_all_digits() {
    let wide = drive().map(DoubleDouble::from);
    let start = start().map(DoubleDouble::from);
    let run = integrate(&wide, Taylor::of_order(24), TaylorController::tolerance(1e-28), start);
    let end = run.until(DoubleDouble::from(2.0)).final_state().unwrap();
    // (θ to 24 digits; parameters are f64, which 0.07 of the reference is not to these.)
    assert!(error(&end.map(|x| x.to_f64())) < 4e-15);
}

#[test]
fn a_state_is_read_and_set_by_its_name() {
    let drive = drive();
    let mut at = start();
    assert_eq!(Drive::<f64>::STATES, ["i", "e"]);
    assert_eq!(Coils::<f64>::STATES, ["i[0]", "i[1]"]);
    assert_eq!((at.q, at.qd), (SVector::from([0.2, 0.0, 0.0]), SVector::from([-0.5, 0.1, 0.0])));
    drive.set_states(&mut at, &SVector::from([3.0, 4.0]));
    assert_eq!((drive.i(&at.q, &at.qd, 0.0), drive.e(&at.q, &at.qd, 0.0)), (3.0, 4.0));
    assert_eq!(drive.precomputed().states(&at), SVector::from([3.0, 4.0]));
    let coils = Coils::new([1.0, 2.0], [0.5, 0.5], 1.0);
    let at = coils.start(1.0, [0.0], [0.0]);
    assert_eq!(coils.i(&at.q, &at.qd, at.t), SVector::from([0.25, 0.0]));
}

#[test]
fn facts_do_not_take_states_for_coordinates() {
    let facts = <Drive as Lagrangian<3>>::FACTS;
    assert_eq!(facts.coordinates, ["theta", "i", "e"]);
    assert_eq!((facts.degrees_of_freedom(), facts.states()), (1, 2));
    assert_eq!(facts.kinds[1..], [CoordinateKind::State; 2]);
    assert!(!(facts.conservative || facts.separable || facts.linear_damping || facts.quadratic_forces));
    assert!(facts.autonomous && facts.constant_inertia && !facts.linear && facts.ignorable.is_empty());
    let facts = <Coils as Lagrangian<3>>::FACTS;
    assert!(facts.linear && facts.analytic && !facts.conservative && !facts.separable);
    assert_eq!(facts.blocks, [&[0][..], &[1], &[2]]);
    let facts = <Mixed as Lagrangian<4>>::FACTS;
    assert_eq!((facts.autonomous, facts.states()), (false, 2));
}

/// Energies, momenta and power are those of the coordinates.
#[test]
fn energies_know_no_states() {
    let (drive, at) = (drive(), State::new(0.0, [0.7, 9.0, 9.0], [1.5, 2.0, -3.0]));
    let kinetic = 0.5 * 0.5 * (0.4 * 1.5f64).powi(2);
    let potential = -0.5 * 9.81 * 0.4 * 0.7f64.cos();
    assert!((drive.energy_at(&at) - kinetic - potential).abs() < 1e-15);
    assert!((drive.energy_function_at(&at) - kinetic - potential).abs() < 1e-15);
    assert!((drive.lagrangian(&at.q, &at.qd, 0.0) - kinetic + potential).abs() < 1e-15);
    assert!((drive.power(&at.q, &at.qd, 0.0) - (0.35 * 2.0 * 1.5 - 0.02 * 1.5 * 1.5)).abs() < 1e-15);
    let inertia = drive.inertia(&at.q, &at.qd, 0.0);
    assert_eq!(inertia, SMatrix::from_diagonal(&SVector::from([inertia[(0, 0)], 1.0, 1.0])));
    assert!((drive.momenta(&at.q, &at.qd, 0.0) - SVector::from([0.12, 2.0, -3.0])).amax() < 1e-15);
    // The potential of `Mixed` depends on states; h has it.
    let (mixed, at) = (Mixed::new(2.0, 0.3), State::new(0.0, [0.3, -0.4, 0.0, 0.0], [1.0, 0.5, 0.7, -0.2]));
    let tip = 1.0 + 0.25 * 0.4f64.cos();
    let h = 1.0 + tip * tip + 0.5 * 0.16 + 0.2 * 0.7 * 0.4;
    assert!((mixed.energy_function_at(&at) - h).abs() < 1e-15);
}

/// M q̈ = f of `Mixed`, by hand.
#[test]
fn states_are_in_potentials_friction_and_forces() {
    let (m, a) = (2.0, 0.3);
    let mixed = Mixed::new(m, a);
    let (x, y, vx, vy, z, w, t) = (0.3f64, -0.4f64, 1.1, 0.5, 0.7, -0.2, 0.25);
    let at = State::new(t, [x, y, 5.0, 6.0], [vx, vy, z, w]);
    let (s, c) = (0.5 * y.sin(), 0.5 * y.cos());
    // ẋ_tip = ẋ + c ẏ, with the rate −s ẏ² of c ẏ.
    let inertia = [[2.0 * m, m * c], [m * c, m * c * c]];
    let friction = (1.0 + z * z) * vx;
    let right = [m * s * vy * vy - (x - z) - friction + a * w, m * s * vy * vy * c - w * z + a * w * c];
    let det = inertia[0][0] * inertia[1][1] - inertia[0][1] * inertia[1][0];
    let exact = [
        (right[0] * inertia[1][1] - inertia[0][1] * right[1]) / det,
        (inertia[0][0] * right[1] - inertia[1][0] * right[0]) / det,
        x.sin() - w * z + vy,
        z * z - w + 0.1 * t,
    ];
    let found = mixed.accel(&at.q, &at.qd, t);
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() < 1e-14 * exact.abs().max(1.0), "{found} {exact}");
    }
    let rate = mixed.momentum_rate(&at.q, &at.qd, t) - mixed.convective_momentum_rate(&at.q, &at.qd, t);
    assert!((mixed.inertia(&at.q, &at.qd, t) * found - rate).amax() < 1e-14);
    // The exact Jacobian against duals.
    let jacobian = mixed.jacobian(&at.q, &at.qd, t);
    let dual = lagrange_runtime::traits::dual_jacobian(&mixed.map(Dual::constant), &at.q, &at.qd, t);
    assert!(
        (jacobian.q - dual.q).amax() + (jacobian.qd - dual.qd).amax() + (jacobian.t - dual.t).amax() < 1e-14
    );
    // Series, and Runge and Kutta.
    let start = State { t: 0.0, ..at };
    let series = integrate(&mixed, Taylor::of_order(20), TaylorController::tolerance(1e-14), start);
    let series = series.until(1.5).final_state().unwrap();
    let verner =
        integrate(&mixed, Verner9, PiController::tolerance(1e-14), start).until(1.5).final_state().unwrap();
    assert!((series.q - verner.q).amax() < 1e-12 && (series.qd - verner.qd).amax() < 1e-12);
}

/// i = u/R + (i₀ − u/R) e^{−Rt/L}, at any step.
#[test]
fn linear_systems_are_propagated_exactly() {
    let coils = Coils::new([2.0, 500.0], [0.5, 0.25], 3.0);
    let start = coils.start(0.0, [1.0], [0.0]);
    let exact = |t: f64, r: f64, l: f64, i0: f64| 3.0 / r + (i0 - 3.0 / r) * (-r * t / l).exp();
    for t in [0.003, 0.7, 20.0] {
        let run = integrate(&coils, MatrixExponential, FixedStep::new(t), start);
        let end = run.until(t).final_state().unwrap();
        // The exponential of a matrix of norm 2000 t has rounding errors of that size, at worst.
        let rounding = 1e-15 + 5e-14 * t;
        assert!((end.q[0] - t.cos()).abs() < rounding && (end.qd[0] + t.sin()).abs() < rounding);
        assert!((end.qd[1] - exact(t, 2.0, 0.5, 0.25)).abs() < rounding);
        assert!((end.qd[2] - exact(t, 500.0, 0.25, 0.0)).abs() < rounding);
    }
    // A stiff one: time constants of 0.5 ms and 0.25 s.
    let stiff = integrate(&coils, Radau5, PiController::tolerance(1e-9), start).until(2.0);
    let mut run = stiff;
    run.run_to_end().unwrap();
    assert!((run.state().qd[1] - exact(2.0, 2.0, 0.5, 0.25)).abs() < 1e-8);
    assert!((run.state().qd[2] - 3.0 / 500.0).abs() < 1e-8);
    let implicit = run.statistics().accepted;
    let mut run = integrate(&coils, Dop853, PiController::tolerance(1e-9), start).until(2.0);
    run.run_to_end().unwrap();
    // Stability limits the explicit method to steps of some milliseconds, |hλ| < 7.
    assert!(run.statistics().accepted > 400 && implicit < 300, "{implicit}");
}

#[test]
fn events_and_samples_see_states() {
    let coils = Coils::new([2.0, 4.0], [0.5, 0.5], 3.0);
    let start = coils.start(0.0, [1.0], [0.0]);
    let half = Event::rising(|s: &State<f64, 3>| s.qd[2] - 0.375);
    let run = integrate(&coils, Dop853, PiController::tolerance(1e-12), start).until(1.0);
    let found: Vec<_> = run.events([half]).collect::<Result<_, _>>().unwrap();
    assert_eq!(found.len(), 1);
    assert!((found[0].state.t - 2f64.ln() / 8.0).abs() < 1e-12);
    let run = integrate(&coils, Dop853, PiController::tolerance(1e-12), start).until(1.0);
    for state in run.sample([0.1, 0.25, 0.9]) {
        let state = state.unwrap();
        assert!((state.qd[2] - 0.75 * (1.0 - (-8.0 * state.t).exp())).abs() < 1e-10);
    }
}

/// ∂i/∂R and ∂i/∂L of the charging coil in closed form, through a whole trajectory.
#[test]
fn gradients_by_resistance_and_inductance() {
    let mut coils = Coils::new([2.0, 4.0], [0.5, 0.5], 3.0).map(Dual::constant);
    let (r, l, t) = (4.0f64, 0.5, 0.3f64);
    let decay = (-r * t / l).exp();
    for (by_r, exact) in [
        (true, 3.0 * (-(1.0 - decay) / (r * r) + decay * t / (l * r))),
        (false, -3.0 / r * decay * r * t / (l * l)),
    ] {
        let which = if by_r { &mut coils.r[1] } else { &mut coils.l[1] };
        which.slope = 1.0;
        let start = coils.start(Dual::constant(0.0), [Dual::constant(1.0)], [Dual::constant(0.0)]);
        let run = integrate(&coils, Verner9, PiController::tolerance(1e-13), start);
        let end = run.until(Dual::constant(t)).final_state().unwrap();
        assert!((end.qd[2].slope - exact).abs() < 1e-12, "{} {exact}", end.qd[2].slope);
        let which = if by_r { &mut coils.r[1] } else { &mut coils.l[1] };
        which.slope = 0.0;
    }
}

/// A stepper drives the input, is saved in the middle, and goes on bit for bit.
#[test]
fn steppers_change_inputs_between_steps() {
    let mut stepper = Stepper::new(drive(), Dop853, PiController::tolerance(1e-11), start());
    stepper.advance_to(2.0).unwrap();
    assert!(error(stepper.state()) < 1e-9);
    let mut other = stepper.clone();
    for stepper in [&mut stepper, &mut other] {
        stepper.set_inputs([-0.3]).unwrap();
        stepper.advance_to(150.0).unwrap();
    }
    assert_eq!(stepper.state(), other.state());
    // The integrator takes all of the error away.
    let drive = stepper.system();
    let held = 0.5 * 9.81 * 0.4 * (-0.3f64).sin() / 0.35;
    assert!(
        (stepper.state().q[0] + 0.3).abs() < 1e-9 && (drive.states(stepper.state())[0] - held).abs() < 1e-8
    );
    {
        let text = serde_json::to_string(&stepper).unwrap();
        let mut again: Stepper<Drive, Dop853, PiController, 3> = serde_json::from_str(&text).unwrap();
        again.advance_to(151.0).unwrap();
        stepper.advance_to(151.0).unwrap();
        assert_eq!(again.state(), stepper.state());
    }
}

#[test]
fn derivatives_by_inputs_have_rows_of_states() {
    let (drive, at) = (drive(), start());
    let by = drive.input_jacobian(&at.q, &at.qd, 0.0);
    assert!((by - SMatrix::from([[0.0, 4.0 / 0.07, 1.0]])).amax() < 1e-13);
    assert_eq!(drive.inputs()[0], 0.8);
}

/// A body loses by friction what its brake gains as heat, and the heat makes the brake weaker.
#[test]
fn heat_of_friction_balances_energy() {
    lagrangian! {
        system Brake {
            param m, c, capacity, loss;
            coord x;
            state warmth;
            let factor = 1 / (1 + 0.1 * warmth);
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            D = 0.5 * c * factor * dot(x).powi(2);
            rate(warmth) = (c * factor * dot(x).powi(2) - loss * warmth) / capacity;
        }
    }
    let brake = Brake::new(2.0, 0.5, 3.0, 0.0);
    let start = brake.start(0.0, [0.0], [5.0]);
    let run = integrate(&brake, Dop853, PiController::tolerance(1e-12), start).until(30.0);
    for state in run.sample_evenly(30) {
        let state = state.unwrap();
        let energy = brake.energy_at(&state) + 3.0 * brake.states(&state)[0];
        assert!((energy - 25.0).abs() < 1e-9, "{energy}");
    }
}

/// A hand-written border: a bead on a rod, held by a constraint, pushed by a filtered force.
#[test]
fn states_stand_beside_constraints() {
    lagrangian! {
        system Bead {
            param m, tau;
            coord x, y;
            state f;
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
            V = 0;
            Q[x] = f;
            constraint rod: y == x;
            rate(f) = (1 - f) / tau;
        }
    }
    let bead = Bead::new(2.0, 0.25);
    let start = bead.start(0.0, [0.0; 2], [0.0; 2]);
    for t in [0.5f64, 2.0] {
        let run = integrate(&bead, Dop853, PiController::tolerance(1e-12), start);
        let end = run.until(t).final_state().unwrap();
        // 2 m ẍ = f = 1 − e^{−t/τ}.
        let decay = (-t / 0.25f64).exp();
        let speed = (t - 0.25 * (1.0 - decay)) / 4.0;
        assert!((end.qd - SVector::from([speed, speed, 1.0 - decay])).amax() < 1e-11);
        let pull = bead.multipliers(&end.q, &end.qd, t)[0];
        assert!((pull.abs() - 0.5 * (1.0 - decay)).abs() < 1e-11);
    }
}

/// Switches of states end steps: a thermostat, and a diode.
#[test]
fn choices_of_states_switch() {
    lagrangian! {
        system Diode {
            param r, l;
            coord x;
            state i;
            T = 0.5 * dot(x).powi(2);
            V = 0.5 * x.powi(2);
            rate(i) = if i > 0.5 { -r * (i - 0.5) } else { 1.0 / l };
        }
    }
    let diode = Diode::new(3.0, 2.0);
    let start = diode.start(0.0, [1.0], [0.0]);
    let end =
        integrate(&diode, Dop853, PiController::tolerance(1e-11), start).until(0.9).final_state().unwrap();
    assert!((end.qd[1] - 0.45).abs() < 1e-12);
    lagrangian! {
        system Kink {
            coord x;
            state z = 1.0;
            T = 0.5 * dot(x).powi(2);
            V = 0.5 * x.powi(2);
            rate(z) = -2 - z.abs();
        }
    }
    // z = 3 e^{−t} − 2 down to 0 at ln 3/2, then z = 2 − 2 e^{t − ln 3/2}.
    let kink = Kink::new();
    let start = kink.start(0.0, [1.0], [0.0]);
    let end = integrate(&kink, Taylor::of_order(18), TaylorController::tolerance(1e-14), start);
    let end = end.until(1.0).final_state().unwrap();
    let exact = 2.0 - 2.0 * (1.0 - 1.5f64.ln()).exp();
    assert!((end.qd[1] - exact).abs() < 1e-13, "{} {exact}", end.qd[1]);
}

/// Lanes have the bits of runs alone, with voltages that switch a choice at other times.
#[test]
fn lanes_are_runs_alone() {
    use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
    use lagrange_runtime::lanes::{FinalState, Fused, SingleLane};
    lagrangian! {
        system Limited {
            param r, l, u;
            coord theta;
            state i;
            T = 0.5 * dot(theta).powi(2);
            V = -9.81 * cos(theta);
            Q[theta] = 3 * i;
            rate(i) = (if theta < 0.3 { u } else { 0.1 * u } - r * i - dot(theta)) / l;
        }
    }
    let draw = |[number]: [u64; 1]| {
        let limited = Limited::new(0.5, 0.1 + 0.01 * number as f64, 2.0 + 0.1 * number as f64);
        (limited, limited.start(0.0, [0.01 * number as f64], [0.0]))
    };
    const SAMPLES: u64 = 21;
    let bits = |end: &State<f64, 2>| [end.t, end.q[0], end.q[1], end.qd[0], end.qd[1]].map(f64::to_bits);
    let samples = Table::new((0..SAMPLES).map(|number| [number]));
    macro_rules! same {
        ($method:expr, $controller:expr) => {
            let lanes = || {
                let study = Ensemble::new(samples.clone(), SAMPLES, draw);
                study.integrate($method, $controller, 2.0).threads(1).in_lanes(Fused)
            };
            let watch = FinalState(|_: &_, end: &State<f64, 2>| bits(end));
            let outcome = lanes().observe(&watch, Collect).expect("a sound study");
            assert_eq!(outcome.failures.count, 0);
            for (index, found) in &outcome.statistic.rows {
                let alone = lanes().replay(*index).expect("a sample").run().final_state().unwrap();
                assert_eq!(*found, bits(&alone.map(|x| SingleLane::value(x))), "{index}");
            }
        };
    }
    same!(Dop853, PiController::tolerance(1e-9));
    same!(Radau5, PiController::tolerance(1e-7));
    same!(Taylor::of_order(16), TaylorController::tolerance(1e-12));
}

/// The time integrals of states are under error control. In units of time that are a thousand times too short for the
/// motion they shorten its steps by a quarter at most.
#[test]
fn integrals_hardly_shorten_steps() {
    lagrangian! {
        system Warm {
            param tau, a;
            coord x;
            state z = 1.0, y;
            T = 0.5 * dot(x).powi(2);
            V = 0.5 * (x / tau).powi(2);
            rate(z) = (a * sin(3 * t / tau) - z) / tau;
            rate(y) = (z.powi(2) - y) / tau;
        }
    }
    for (tolerance, a) in [(1e-5, 1e-3), (1e-5, 1.0), (1e-8, 1.0), (1e-8, 1e3), (1e-11, 1e-3), (1e-11, 1.0)] {
        let steps = [1e-3, 1e3].map(|tau| {
            let warm = Warm::new(tau, a);
            let start = warm.start(0.0, [0.0], [0.0]);
            let mut run =
                integrate(&warm, Dop853, PiController::tolerance(tolerance), start).until(20.0 * tau);
            run.run_to_end().unwrap();
            run.statistics().accepted as f64
        });
        assert!(steps[1] < 1.25 * steps[0], "{tolerance:e} {a}: {steps:?}");
    }
}

mod analysis {
    use super::*;
    use lagrange_runtime::analysis::*;

    /// Poles of the whole loop: eigenvalues of the 4 × 4 matrix by 40 digits of mpmath. No integral of a state is
    /// among them.
    #[test]
    fn poles_of_the_whole_loop() {
        let drive = drive();
        let point = operating_point(&drive, &start()).unwrap();
        let state = point.state;
        assert!((state.q[0] - 0.8).abs() < 1e-15 && state.qd[0] == 0.0);
        let states = SVector::from([4.021_293_286_699_610_5, 1.742_560_424_236_497_9]);
        assert!((drive.states(&state) - states).amax() < 1e-14);
        let exact = [
            (-18.111_799_126_462_694, 0.0),
            (-0.338_022_010_410_691_96, 0.0),
            (-0.185_803_717_277_592_66, -5.530_984_425_460_364),
            (-0.185_803_717_277_592_66, 5.530_984_425_460_364),
        ];
        assert_eq!(point.poles.len(), 4);
        for (found, (re, im)) in point.poles.iter().zip(exact) {
            assert!((found.re - re).abs() + (found.im - im).abs() < 1e-13, "{found} {re} {im}");
        }
        let model = StateSpace::about(&drive, &state)
            .unwrap()
            .observed(&drive, &state, |drive, s| [drive.voltage(&s.q, &s.qd, s.t)])
            .unwrap();
        assert_eq!((model.a.shape(), model.b.shape(), model.c.shape()), ((4, 4), (4, 1), (1, 4)));
        let c = DMatrix::from_row_slice(1, 4, &[-4.0, 0.0, 0.0, 3.0]);
        assert!((model.c - c).amax() < 1e-15 && model.d[(0, 0)] == 4.0);
        let b = DMatrix::from_column_slice(4, 1, &[0.0, 0.0, 4.0 / 0.07, 1.0]);
        assert!((model.b - b).amax() < 1e-13);
        // From the step response: a small deviation goes as the matrix exponential says.
        // The model has no state for the charge.
        let of_charge = StateSpace::about(&drive, &state).unwrap().observed(&drive, &state, |_, s| [s.q[1]]);
        assert!(matches!(of_charge, Err(lagrange_runtime::analysis::AnalysisError::NotApplicable { .. })));
        let sampled = StateSpace::about(&drive, &state).unwrap().sampled(0.3).unwrap();
        let mut moved = state;
        moved.q[0] += 1e-6;
        let end = integrate(&drive, Verner9, PiController::tolerance(1e-14), moved)
            .until(0.3)
            .final_state()
            .unwrap();
        let found = [end.q[0] - state.q[0], end.qd[0], end.qd[1] - state.qd[1], end.qd[2] - state.qd[2]];
        for (i, found) in found.iter().enumerate() {
            assert!((found / 1e-6 - sampled.a[(i, 0)]).abs() < 1e-5, "{i}");
        }
    }

    #[test]
    fn analyses_by_inertia_and_stiffness_refuse_states() {
        let drive = drive();
        let refused = |error| matches!(error, AnalysisError::NotApplicable { needs } if needs.contains("operating_point"));
        assert!(refused(equilibrium(&drive, &[0.8, 0.0, 0.0]).unwrap_err()));
        assert!(refused(small_vibrations(&drive, &[0.8, 0.0, 0.0]).unwrap_err()));
        assert!(refused(SmallMotion::about(&drive, &start()).unwrap_err()));
        let driven = Mixed::new(1.0, 1.0);
        let guess = driven.start(0.0, [0.0; 2], [0.0; 2]);
        assert!(matches!(operating_point(&driven, &guess).unwrap_err(), AnalysisError::TimeDependent));
        lagrangian! {
            system Pushed {
                coord x;
                state i;
                T = 0.5 * dot(x).powi(2);
                V = 0;
                Q[x] = 1;
                rate(i) = 1 - i;
            }
        }
        let pushed = Pushed::new();
        let guess = pushed.start(0.0, [0.0], [0.0]);
        assert!(matches!(operating_point(&pushed, &guess).unwrap_err(), AnalysisError::Unbalanced { .. }));
        // At rest the integrator of a controller of the velocity goes on.
        lagrangian! {
            system Integrator {
                param command = 30;
                coord x, y;
                state i, e;
                T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
                V = 0.5 * (x - y).powi(2);
                Q[x] = i;
                rate(i) = e - i;
                rate(e) = command - dot(y);
            }
        }
        let integrator = Integrator::default();
        let error = operating_point(&integrator, &integrator.start(0.0, [0.0; 2], [0.0; 2])).unwrap_err();
        assert_eq!(error, AnalysisError::Running { state: "e", rate: 30.0 });
        assert!(error.to_string().contains("the state `e` has the rate 3e1"), "{error}");
    }

    /// A cart stays anywhere, its pole upright or down: the rest of the weight is rounding, and not a force on the
    /// cart.
    #[test]
    fn rest_beside_an_ignorable_coordinate() {
        lagrangian! {
            system CartPole {
                param cart = 1, m = 0.1, l = 0.5, g = 9.81;
                input u;
                coord x, theta: angle;
                let px = x + l * sin(theta);
                let py = l * cos(theta);
                T = 0.5 * cart * dot(x).powi(2) + 0.5 * m * (dot(px).powi(2) + dot(py).powi(2));
                V = m * g * py;
                Q[x] = u;
            }
        }
        let cart = CartPole::default();
        for (guess, upright) in [(0.01, true), (-0.1, true), (0.4, true), (3.0, false), (1e-9, true)] {
            let point = operating_point(&cart, &State::new(0.0, [0.7, guess], [0.0; 2])).unwrap();
            let theta = if upright { 0.0 } else { std::f64::consts::PI };
            assert!(
                (point.state.q - SVector::from([0.7, theta])).amax() < 1e-6,
                "{guess}: {}",
                point.state.q
            );
            // λ² = ± (1 + m/M) g/l, and two poles of the cart.
            let fast = point.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
            assert!((fast - (1.1 * 9.81 / 0.5f64).sqrt()).abs() < 1e-6, "{guess}: {:?}", point.poles);
        }
        let pushed = CartPole { u: 1e-20, ..cart };
        let error = operating_point(&pushed, &State::new(0.0, [0.0, 0.01], [0.0; 2])).unwrap_err();
        assert!(matches!(error, AnalysisError::Unbalanced { .. }), "{error}");
    }

    /// Poles need derivatives: a spring that is stiffer on one side has none at rest, a quadratic drag has.
    #[test]
    fn points_on_switches_have_no_poles() {
        lagrangian! {
            system Stop {
                param a, b;
                coord x;
                state f;
                T = 0.5 * dot(x).powi(2);
                V = 0.5 * x.powi(2);
                D = 0.5 * dot(x).powi(2);
                Q[x] = f - a * max(0, x) - b * abs(dot(x)) * dot(x);
                rate(f) = -2 * f;
            }
        }
        let point = |a, b| {
            let stop = Stop::new(a, b);
            operating_point(&stop, &stop.start(0.0, [0.1], [0.0]))
        };
        assert!(matches!(point(3.0, 0.0).unwrap_err(), AnalysisError::Switch { .. }));
        let poles = point(0.0, 0.7).unwrap().poles;
        assert!((poles[0].re + 2.0).abs() < 1e-14 && (poles[1].im + 0.75f64.sqrt()).abs() < 1e-14);
    }

    /// A circuit that a limit cycle drives: the integral of the rectified current grows for ever, and the orbit
    /// closes all the same.
    #[test]
    fn periodic_orbits_and_exponents_leave_integrals_out() {
        lagrangian! {
            system Filtered {
                coord x;
                state y;
                T = 0.5 * dot(x).powi(2);
                V = 0.5 * x.powi(2);
                Q[x] = (1 - x.powi(2)) * dot(x);
                rate(y) = 2 * (x.powi(2) - y);
            }
        }
        let filtered = Filtered::new();
        let guess = State::new(0.0, [2.0, 0.0], [0.0, 2.0]);
        let flow = ByVariationalEquations::<_, 10>::new(&filtered, 1e-12);
        let orbit = periodic_orbit(&flow, &guess, Period::About(6.6), 1e-9).unwrap();
        // Van der Pol's period for μ = 1.
        assert!((orbit.period - 6.663_286_859_323_13).abs() < 1e-9, "{}", orbit.period);
        assert_eq!(orbit.multipliers.len(), 3);
        assert!((orbit.multipliers[2].re - 1.0).abs() < 1e-8);
        let filter = (-2.0 * orbit.period).exp();
        assert!(
            orbit.multipliers.iter().any(|mu| (mu.re / filter - 1.0).abs() < 1e-3),
            "{:?}",
            orbit.multipliers
        );
        let flow = ByVariationalEquations::<_, 8>::new(&filtered, 1e-10);
        let how = Measurement { transient: 20.0, intervals: 400, interval: 0.5 };
        let exponents = lyapunov_spectrum(&flow, &orbit.start, &how).unwrap();
        let exact =
            [0.0, orbit.multipliers.iter().map(|mu| mu.norm().ln() / orbit.period).sum::<f64>() + 2.0, -2.0];
        for (found, exact) in exponents.iter().zip(exact) {
            assert!((found.value - exact).abs() < 0.02, "{} {exact}", found.value);
        }
    }
}

lagrangian! {
    /// Two bodies of unequal masses, of which one is hung from the other, and the current of a motor that turns
    /// neither.
    system Hit {
        param m = 2, l = 0.5;
        coord x, theta: angle;
        state i = 0.25;
        T = 0.5 * dot(x).powi(2) + 0.5 * m * ((dot(x) + l * cos(theta) * dot(theta)).powi(2) + (l * sin(theta) * dot(theta)).powi(2));
        V = -m * 9.81 * l * cos(theta);
        rate(i) = -i + dot(x);
        impulse blow at [x + l * sin(theta), -l * cos(theta)];
    }
}

/// A blow changes velocities, and no state.
#[test]
fn blows_leave_states_as_they_are() {
    let hit = Hit::new();
    let at = hit.start(0.0, [0.1, 0.3], [0.4, -2.0]);
    let normal = hit.blow(&at.q, 0.0, &[1.0, 0.0].into());
    let jump = hit.jump(&at, &(normal * 3.0));
    // M Δq̇ = P by Cramer's rule.
    let (a, b, c) = (3.0, 2.0 * 0.5 * 0.3f64.cos(), 2.0 * 0.25);
    let (p, q) = (3.0, 1.5 * 0.3f64.cos());
    let exact = [(p * c - b * q) / (a * c - b * b), (a * q - b * p) / (a * c - b * b), 0.0];
    for (i, exact) in exact.into_iter().enumerate() {
        assert!((jump.after.qd[i] - at.qd[i] - exact).abs() < 1e-14, "{i}: {jump:?}");
    }
    assert_eq!(jump.after.qd[2], 0.25);
    let rate = |at: &State<f64, 3>| normal.dot(&at.qd);
    let after = hit.rebound(&at, &normal, 0.8).after;
    assert!((rate(&after) + 0.8 * rate(&at)).abs() < 1e-14 && after.qd[2] == 0.25, "{after:?}");
}

lagrangian! {
    /// Bodies of any mass.
    system Heavy {
        param m;
        coord y, z;
        T = 0.5 * m * (dot(y).powi(2) + dot(z).powi(2));
        V = 9.81 * m * y;
        impulse blow at [z, y];
    }
}

lagrangian! {
    /// The same on a wedge.
    system OnAWedge {
        param m;
        coord y, z;
        T = 0.5 * m * (dot(y).powi(2) + dot(z).powi(2));
        V = 9.81 * m * y;
        constraint wedge: y == z;
        impulse blow at [z, y];
    }
}

/// A rebound has the digits of the velocities, whatever the mass.
#[test]
fn rebounds_of_any_mass() {
    for exponent in -15..=18 {
        let m = 10f64.powi(exponent);
        let at = State::new(0.0, [0.0, 0.0], [-2.0, -2.0]);
        let up = SVector::from([0.0, 1.0]);
        let free = Heavy::new(m);
        let jump = free.rebound(&at, &free.blow(&at.q, 0.0, &up), 0.5);
        assert!((jump.after.qd - SVector::from([1.0, -2.0])).amax() < 1e-14, "{m:e}: {jump:?}");
        assert!((jump.energy / m + 1.5).abs() < 1e-14, "{m:e}: {jump:?}");
        let bound = OnAWedge::new(m);
        let jump = bound.rebound(&at, &bound.blow(&at.q, 0.0, &up), 0.5);
        assert!((jump.after.qd - SVector::from([1.0, 1.0])).amax() < 1e-14, "{m:e}: {jump:?}");
        let single = free.map(|x| x as f32);
        let at = State::new(0f32, [0.0, 0.0], [-2.0, -2.0]);
        let jump = single.rebound(&at, &SVector::from([1.0, 0.0]), 0.5);
        assert!((jump.after.qd - SVector::from([1.0, -2.0])).amax() < 1e-6, "{m:e}: {jump:?}");
        // At rest there is nothing to reverse.
        let rest = State::new(0.0, [0.0, 0.0], [0.0, 0.0]);
        assert_eq!(free.rebound(&rest, &SVector::from([1.0, 0.0]), 0.5).after, rest);
    }
}
