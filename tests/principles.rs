//! The principles of mechanics as integrals along trajectories: energy and work, and Hamilton's.

use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::slope;

lagrangian! {
    /// Two pendulums on a cart, all of it damped, the cart driven and the first bob blown at.
    pub system Cart {
        param M, m, l, k, c, b, f, omega, g = 9.81;
        coord x: length, theta: [angle; 2];
        let px: [2] = |i| x + l * (0..i + 1).map(|j| theta[j].sin()).sum();
        let py: [2] = |i| -l * (0..i + 1).map(|j| theta[j].cos()).sum();
        T = 0.5 * M * dot(x).powi(2) + (0..2).map(|i| 0.5 * m * (dot(px[i]).powi(2) + dot(py[i]).powi(2))).sum();
        V = 0.5 * k * x.powi(2) + m * g * (py[0] + py[1]);
        D = 0.5 * c * dot(x).powi(2) + 0.5 * b * (dot(theta[0]) - dot(theta[1])).powi(2);
        Q[x] = f * cos(omega * t);
        force [-b * dot(px[0]).abs() * dot(px[0]), 0] at [px[0], py[0]];
    }
}

lagrangian! {
    /// The same left to itself.
    pub system FreeCart {
        param M, m, l, k, g = 9.81;
        coord x: length, theta: [angle; 2];
        let px: [2] = |i| x + l * (0..i + 1).map(|j| theta[j].sin()).sum();
        let py: [2] = |i| -l * (0..i + 1).map(|j| theta[j].cos()).sum();
        T = 0.5 * M * dot(x).powi(2) + (0..2).map(|i| 0.5 * m * (dot(px[i]).powi(2) + dot(py[i]).powi(2))).sum();
        V = 0.5 * k * x.powi(2) + m * g * (py[0] + py[1]);
    }
}

lagrangian! {
    /// A pendulum whose pivot is shaken, with friction: T depends on time, so the energy function is not the energy.
    pub system Shaken {
        param m, l, a, omega, c, g = 9.81;
        coord theta: angle;
        coord lift = a * sin(omega * t);
        let x = l * sin(theta);
        let y = lift - l * cos(theta);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        D = 0.5 * c * dot(theta).powi(2);
    }
}

const CART: Cart =
    Cart { c: 0.4, b: 0.05, f: 2.0, omega: 1.7, ..Cart::new(1.2, 0.5, 0.6, 12.0, 0.0, 0.0, 0.0, 0.0) };
const END: f64 = 4.0;

fn start() -> State<f64, 3> {
    State::new(0.0, [0.1, 1.1, 0.4], [0.0, -0.5, 2.0])
}

/// (11.52): ΔE = W_N, the work of friction, drive and wind, to the tolerance asked for.
#[test]
fn energy_changes_by_the_work_of_nonconservative_forces() {
    let energy = |s: &State<f64, 3>| CART.energy(&s.q, &s.qd, s.t);
    let mut errors = Vec::new();
    for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
        let run = integrate(&CART, Dop853, PiController::tolerance(tolerance), start()).until(END);
        let mut worst: f64 = 0.0;
        let mut done: f64 = 0.0;
        for total in run.integrals([0.0], |s| [CART.power(&s.q, &s.qd, s.t)]) {
            let total = total.expect("no failure");
            let [work] = total.integrals;
            worst = worst.max((energy(&total.state) - energy(&start()) - work).abs());
            done = done.max(work.abs());
        }
        assert!(done > 1.0, "the forces work: {done}");
        assert!(worst < 100.0 * tolerance, "{worst:e} at tolerance {tolerance:e}");
        errors.push((tolerance, worst));
    }
    let order = slope(errors.iter().copied(), 0.0);
    assert!((0.7..1.3).contains(&order), "errors follow the tolerance: {errors:?}");
}

/// With time in T, `dh/dt = power − ∂L/∂t` (11.53) takes the place of the energy.
#[test]
fn energy_function_changes_by_work_and_by_the_prescribed_motion() {
    let system = Shaken::new(0.7, 0.4, 0.05, 9.0, 0.02);
    let slope_of_l = |s: &State<f64, 1>| {
        let dual = system.map(Dual::constant);
        dual.lagrangian(&s.q.map(Dual::constant), &s.qd.map(Dual::constant), Dual::variable(s.t)).slope
    };
    let h = |s: &State<f64, 1>| system.energy_function(&s.q, &s.qd, s.t);
    let start = State::new(0.0, [2.0], [0.0]);
    let run = integrate(&system, Dop853, PiController::tolerance(1e-12), start).until(END);
    let total = run
        .integrals([0.0; 2], |s| [system.power(&s.q, &s.qd, s.t), slope_of_l(s)])
        .total()
        .expect("no failure");
    let [work, explicit] = total.integrals;
    assert!(work < -1e-2 && explicit.abs() > 1e-2, "both count: {work}, {explicit}");
    assert!((h(&total.state) - h(&start) - work + explicit).abs() < 1e-10);
}

/// A variation that vanishes at both ends, and its rate.
fn variation<const N: usize>(t: f64) -> [SVector<f64, N>; 2] {
    let of = |k: usize| (k as f64 + 1.0) * std::f64::consts::PI / END;
    [SVector::from_fn(|k, _| (of(k) * t).sin()), SVector::from_fn(|k, _| of(k) * (of(k) * t).cos())]
}

/// The integral over the run of CART or its like of `f(q + ε η, q̇ + ε η̇, t)`.
fn along<Sys, const N: usize>(system: &Sys, start: State<f64, N>, f: impl Fn(&State<f64, N>) -> f64) -> f64
where
    Sys: System<N, Scalar = f64>,
{
    let run = integrate(system, Dop853, PiController::tolerance(1e-13), start).until(END);
    run.integrals([0.0], |s| [f(s)]).total().expect("no failure").integrals[0]
}

const STEPS: [f64; 4] = [2e-3, 1e-3, 5e-4, 2.5e-4];

/// The action `S[q + ε η]` less `S[q]` for steps of ε.
fn changes<Sys, const N: usize>(system: &Sys, start: State<f64, N>) -> Vec<(f64, f64)>
where
    Sys: Lagrangian<N, Scalar = f64>,
{
    let action = |epsilon: f64| {
        along(system, start, |s| {
            let [eta, rate] = variation::<N>(s.t);
            system.lagrangian(&(s.q + eta * epsilon), &(s.qd + rate * epsilon), s.t)
        })
    };
    let true_action = action(0.0);
    STEPS.iter().map(|&epsilon| (epsilon, action(epsilon) - true_action)).collect()
}

fn order(changes: &[(f64, f64)]) -> f64 {
    slope(changes.iter().map(|&(epsilon, change)| (epsilon, change.abs())), 0.0)
}

/// Hamilton's principle: `δS = 0`, so S changes by O(ε²) along the true motion, and by O(ε) along another one.
#[test]
fn the_action_is_stationary_along_the_true_motion() {
    let system = FreeCart::new(1.2, 0.5, 0.6, 12.0);
    let changes = changes(&system, start());
    assert!((order(&changes) - 2.0).abs() < 0.1, "{changes:?}");

    // The motion under other forces, measured by the same action.
    let action = |epsilon: f64| {
        along(&CART, start(), |s| {
            let [eta, rate] = variation::<3>(s.t);
            system.lagrangian(&(s.q + eta * epsilon), &(s.qd + rate * epsilon), s.t)
        })
    };
    let false_action = action(0.0);
    let other: Vec<_> = STEPS.iter().map(|&epsilon| (epsilon, action(epsilon) - false_action)).collect();
    assert!((order(&other) - 1.0).abs() < 0.1, "{other:?}");
}

/// Hamilton's principle with work (11.75): `δS + ∫ (Q − ∂D/∂q̇)·η dt = 0`. Neither term vanishes alone.
#[test]
fn action_and_virtual_work_balance() {
    // Q − ∂D/∂q̇ is what force has beside ∂L/∂q.
    let slopes_of_l = |s: &State<f64, 3>| {
        let dual = CART.map(Dual::constant);
        let at = |k: usize| {
            let mut q = s.q.map(Dual::constant);
            q[k].slope = 1.0;
            dual.lagrangian(&q, &s.qd.map(Dual::constant), Dual::constant(s.t)).slope
        };
        SVector::from([at(0), at(1), at(2)])
    };
    let work = along(&CART, start(), |s| {
        let nonconservative = CART.momentum_rate(&s.q, &s.qd, s.t) - slopes_of_l(s);
        nonconservative.dot(&variation(s.t)[0])
    });
    let changes = changes(&CART, start());
    assert!(work.abs() > 0.1, "the forces work: {work}");
    assert!((order(&changes) - 1.0).abs() < 0.1, "S alone is not stationary: {changes:?}");
    let balance: Vec<_> =
        changes.iter().map(|&(epsilon, change)| (epsilon, change + epsilon * work)).collect();
    assert!((order(&balance) - 2.0).abs() < 0.1, "{balance:?}");
}

/// The reduced top obeys the principle with its Routhian in the place of L: the momenta are held, not the angles.
#[test]
fn the_routhian_action_is_stationary() {
    lagrangian! {
        system Top {
            param m, l, I1, I3, g = 9.81;
            coord phi: angle, theta: angle, psi: angle;
            T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2))
                + 0.5 * I3 * (dot(psi) + dot(phi) * cos(theta)).powi(2);
            V = m * g * l * cos(theta);
            routhian Nutation;
        }
    }
    let top = Top::new(0.5, 0.12, 0.05, 0.01);
    let (nutation, state) = top.reduce(&State::new(0.0, [0.0, 1.0, 0.0], [0.5, 0.0, 30.0]));
    let changes = changes(&nutation, state);
    assert!((order(&changes) - 2.0).abs() < 0.1, "{changes:?}");
}
