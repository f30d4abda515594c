//! Numbers at the edge: every run ends with a right state or with a failure of a kind that says what is wrong, for
//! methods of every family.

use lagrange_runtime::prelude::*;
use lagrange_runtime::{BlanesMoan4, Nystrom12};
use std::f64::consts::TAU;

lagrangian! {
    pub system Pendulum {
        param m, l, g;
        coord theta: angle;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
}

lagrangian! {
    /// The same in Cartesian coordinates.
    pub system Bob {
        param m, l, g;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint rod: x * x + y * y == l * l;
    }
}

/// A run to be made: its start, its end, and a tolerance and a step for those that take one.
#[derive(Clone, Copy)]
struct Span<const N: usize> {
    start: State<f64, N>,
    end: f64,
    tolerance: f64,
    step: f64,
}

type Ends<const N: usize> = Vec<(&'static str, Result<State<f64, N>, Failure>)>;

/// Attempts after which a run may give up. No edge needs more. (1000 equal steps make the longest run that ends.)
const ENOUGH: u64 = if cfg!(feature = "long") { 20_000 } else { 2000 };

macro_rules! ends {
    ($system:expr, $span:expr, [$($adaptive:expr),*], [$($fixed:expr),*]) => {{
        let (system, Span { start, end, tolerance, step }) = ($system, $span);
        let step = if end < start.t { -step } else { step };
        let taylor = integrate(&system, Taylor, TaylorController::tolerance(tolerance), start);
        let mut ends = vec![("Taylor", taylor.until(end).max_steps(ENOUGH).final_state().map_err(|f| f.failure))];
        $(
            let run = integrate(&system, $adaptive, PiController::tolerance(tolerance), start).until(end);
            ends.push((stringify!($adaptive), run.max_steps(ENOUGH).final_state().map_err(|f| f.failure)));
        )*
        $(
            let run = integrate(&system, $fixed, FixedStep::new(step), start).until(end);
            ends.push((stringify!($fixed), run.max_steps(ENOUGH).final_state().map_err(|f| f.failure)));
        )*
        ends
    }};
}

fn swings(system: Pendulum, span: Span<1>) -> Ends<1> {
    ends!(
        system,
        span,
        [DormandPrince5, Dop853, Verner9, Nystrom12, Rodas5P, Radau5, Projection(Dop853)],
        [Rk4, Verlet, BlanesMoan4, ImplicitMidpoint, Gauss4, VariationalMidpoint]
    )
}

fn hangs(system: Bob, span: Span<2>) -> Ends<2> {
    ends!(system, span, [DormandPrince5, Dop853, Verner9, Rodas5P, Radau5], [Rk4])
}

const PENDULUM: Pendulum = Pendulum { m: 1.0, l: 1.0, g: 9.0 };
const BOB: Bob = Bob { m: 1.0, l: 1.0, g: 9.0 };

fn swing(theta: f64) -> Span<1> {
    Span { start: State::new(0.0, [theta], [0.0]), end: 1.0, tolerance: 1e-9, step: 1e-3 }
}

fn hang(angle: f64) -> Span<2> {
    let start = State::new(0.0, [angle.sin(), -angle.cos()], [0.0; 2]);
    Span { start, end: 1.0, tolerance: 1e-9, step: 1e-3 }
}

/// The angle after the motion from rest at `theta`, to rounding.
fn angle(theta: f64, time: f64) -> f64 {
    let run = integrate(&PENDULUM, Dop853, PiController::tolerance(1e-14), swing(theta).start);
    run.until(time).final_state().expect("an ordinary motion").q[0]
}

/// Fate of a run.
#[derive(Clone, Copy)]
enum Fate {
    /// It must fail.
    Fails,
    /// It must end there, within the distance.
    Ends(f64, f64),
    /// Either.
    EndsOrFails(f64, f64),
}
use Fate::*;

/// Kinds of failure that tell a user what is wrong with numbers.
fn tells(failure: &Failure) -> bool {
    matches!(
        failure,
        Failure::NonFinite { .. }
            | Failure::StateNotFinite { .. }
            | Failure::SingularInertia { .. }
            | Failure::NegativeInertia { .. }
            | Failure::SingularStep { .. }
            | Failure::StepSizeUnderflow { .. }
            | Failure::BadEnd { .. }
            | Failure::BadTolerance { .. }
            | Failure::BadStepSize { .. }
            | Failure::NotConverged { .. }
            | Failure::ConstraintViolated { .. }
            | Failure::ConstraintDrift { .. }
            | Failure::DependentConstraints { .. }
            | Failure::InvariantLost { .. }
            | Failure::BudgetUsedUp { .. }
    )
}

/// Complaints about what does not meet its fate.
fn judged<const N: usize>(
    case: &str,
    ends: Ends<N>,
    fate: Fate,
    shown: fn(&State<f64, N>) -> f64,
) -> Vec<String> {
    let complaint = |(method, end): (&str, Result<State<f64, N>, Failure>)| {
        let met = match (&end, fate) {
            (Err(failure), Fails | EndsOrFails(..)) => tells(failure) && !failure.to_string().is_empty(),
            (Ok(state), Ends(exact, within) | EndsOrFails(exact, within)) => {
                state.is_finite() && (shown(state) - exact).abs() <= within
            }
            _ => false,
        };
        (!met).then(|| format!("{case}, {method}: {end:?}"))
    };
    ends.into_iter().filter_map(complaint).collect()
}

/// The methods of low order keep their steps: Verlet and the midpoint rules at ω h = 3e-3 have phase errors of
/// (ω h)²/24 · ω t ≈ 1e-6.
const PHASE: f64 = 4e-6;

#[test]
fn pendulum() {
    let ordinary = swing(0.5);
    let (exact, nan, inf) = (angle(0.5, 1.0), f64::NAN, f64::INFINITY);
    let with = |f: fn(&mut Pendulum, f64), x: f64| {
        let mut system = PENDULUM;
        f(&mut system, x);
        system
    };
    let ulp_of_time = 1e12 * f64::EPSILON;
    let far = 1e9;
    // The angle that is the same, computed from its sine and cosine, which are right for any angle.
    let near = far.sin().atan2(far.cos());
    let turns = (far - near) / TAU;
    // Each of a thousand steps, and up to 16 stages, rounds the angle; nearby motions part by e^(ω t) at most.
    let rounded = 1e3 * 16.0 * far * f64::EPSILON * 3f64.exp();
    let cases: Vec<(&str, Pendulum, Span<1>, Fate)> = vec![
        ("ordinary", PENDULUM, ordinary, Ends(exact, PHASE)),
        ("NaN for g", with(|p, x| p.g = x, nan), ordinary, Fails),
        ("NaN for m", with(|p, x| p.m = x, nan), ordinary, EndsOrFails(exact, PHASE)),
        ("infinite g", with(|p, x| p.g = x, inf), ordinary, Fails),
        ("infinite l", with(|p, x| p.l = x, inf), ordinary, EndsOrFails(0.5, PHASE)),
        ("no length", with(|p, x| p.l = x, 0.0), ordinary, Fails),
        // The mass cancels.
        ("no mass", with(|p, x| p.m = x, 0.0), ordinary, EndsOrFails(exact, PHASE)),
        ("mass below normal numbers", with(|p, x| p.m = x, 1e-310), ordinary, EndsOrFails(exact, PHASE)),
        ("mass near overflow", with(|p, x| p.m = x, 1e307), ordinary, EndsOrFails(exact, PHASE)),
        ("length below normal numbers", with(|p, x| p.l = x, 1e-310), ordinary, Fails),
        ("NaN to start", PENDULUM, swing(nan), Fails),
        ("infinity to start", PENDULUM, swing(inf), Fails),
        ("NaN for time", PENDULUM, Span { start: State { t: nan, ..ordinary.start }, ..ordinary }, Fails),
        ("infinite time", PENDULUM, Span { start: State { t: inf, ..ordinary.start }, ..ordinary }, Fails),
        ("NaN for the end", PENDULUM, Span { end: nan, ..ordinary }, Fails),
        ("no end of time", PENDULUM, Span { end: inf, ..ordinary }, Fails),
        ("backward", PENDULUM, Span { end: -1.0, ..ordinary }, Ends(exact, PHASE)),
        ("empty", PENDULUM, Span { end: 0.0, ..ordinary }, Ends(0.5, 0.0)),
        ("an instant", PENDULUM, Span { end: 1e-300, ..ordinary }, EndsOrFails(0.5, 0.0)),
        (
            "an instant below normal numbers",
            PENDULUM,
            Span { end: 5e-324, ..ordinary },
            EndsOrFails(0.5, 0.0),
        ),
        (
            "tolerance below rounding",
            PENDULUM,
            Span { tolerance: 1e-18, ..ordinary },
            EndsOrFails(exact, PHASE),
        ),
        (
            "the smallest tolerance",
            PENDULUM,
            Span { tolerance: 5e-324, ..ordinary },
            EndsOrFails(exact, PHASE),
        ),
        (
            "at the end of time",
            PENDULUM,
            Span { start: State { t: 1e12, ..ordinary.start }, end: 1e12 + 1.0, ..ordinary },
            // Each of a thousand steps begins at a rounded time, where |θ̇| < 2; time itself does not matter.
            EndsOrFails(exact, PHASE + 1e3 * 2.0 * ulp_of_time),
        ),
        (
            "where time does not resolve a step",
            PENDULUM,
            Span { start: State { t: 1e17, ..ordinary.start }, end: 1e17 + 1e3, ..ordinary },
            Fails,
        ),
        ("a huge angle", PENDULUM, swing(far), EndsOrFails(angle(near, 1.0) + turns * TAU, PHASE + rounded)),
        // Far below the absolute tolerance an adaptive run owes no more than to stay there.
        ("an angle below normal numbers", PENDULUM, swing(1e-310), Ends(0.0, 1e-308)),
        ("the smallest angle", PENDULUM, swing(5e-324), Ends(0.0, 1e-308)),
        ("at rest", PENDULUM, swing(0.0), Ends(0.0, 0.0)),
        (
            "a huge velocity",
            PENDULUM,
            Span { start: State::new(0.0, [0.0], [1e300]), ..ordinary },
            EndsOrFails(1e300, 1e290),
        ),
    ];
    let complaints: Vec<String> = cases
        .into_iter()
        .flat_map(|(case, system, span, fate)| judged(case, swings(system, span), fate, |s| s.q[0]))
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn constrained() {
    let ordinary = hang(0.5);
    let (exact, nan, inf) = (angle(0.5, 1.0).sin(), f64::NAN, f64::INFINITY);
    let with = |f: fn(&mut Bob, f64), x: f64| {
        let mut system = BOB;
        f(&mut system, x);
        system
    };
    let scaled = |l: f64| {
        let mut span = ordinary;
        span.start.q *= l;
        (Bob { l, g: 9.0 * l, ..BOB }, span)
    };
    let [small, large, overflowing] = [1e-3, 1e100, 1e200].map(scaled);
    let at = |q: [f64; 2], qd: [f64; 2]| Span { start: State::new(0.0, q, qd), ..ordinary };
    let cases: Vec<(&str, Bob, Span<2>, Fate)> = vec![
        ("ordinary", BOB, ordinary, Ends(exact, PHASE)),
        ("NaN for l", with(|b, x| b.l = x, nan), ordinary, Fails),
        ("NaN for g", with(|b, x| b.g = x, nan), ordinary, Fails),
        // The motion does not depend on the mass, and its equations need not either.
        ("NaN for m", with(|b, x| b.m = x, nan), ordinary, EndsOrFails(exact, PHASE)),
        ("infinite l", with(|b, x| b.l = x, inf), ordinary, Fails),
        ("infinite g", with(|b, x| b.g = x, inf), ordinary, Fails),
        ("no length", with(|b, x| b.l = x, 0.0), ordinary, Fails),
        ("no length, at the pivot", with(|b, x| b.l = x, 0.0), at([0.0; 2], [0.0; 2]), Fails),
        ("no mass", with(|b, x| b.m = x, 0.0), ordinary, EndsOrFails(exact, PHASE)),
        ("mass below normal numbers", with(|b, x| b.m = x, 1e-310), ordinary, EndsOrFails(exact, PHASE)),
        ("off the rod", BOB, at([0.5, 0.5], [0.0; 2]), Fails),
        ("along the rod", BOB, at([0.0, -1.0], [0.0, 1.0]), Fails),
        ("at the pivot", BOB, at([0.0; 2], [0.0; 2]), Fails),
        ("NaN to start", BOB, at([nan, 0.0], [0.0; 2]), Fails),
        ("infinity to start", BOB, at([1.0, 0.0], [0.0, inf]), Fails),
        ("a short rod", small.0, small.1, Ends(1e-3 * exact, PHASE)),
        ("a rod of 1e100", large.0, large.1, EndsOrFails(1e100 * exact, 1e100 * PHASE)),
        ("a rod whose square overflows", overflowing.0, overflowing.1, Fails),
        ("backward", BOB, Span { end: -1.0, ..ordinary }, Ends(exact, PHASE)),
        ("empty", BOB, Span { end: 0.0, ..ordinary }, Ends(ordinary.start.q[0], f64::EPSILON)),
        ("no end of time", BOB, Span { end: inf, ..ordinary }, Fails),
        ("tolerance below rounding", BOB, Span { tolerance: 1e-18, ..ordinary }, EndsOrFails(exact, PHASE)),
        (
            "at the end of time",
            BOB,
            Span { start: State { t: 1e12, ..ordinary.start }, end: 1e12 + 1.0, ..ordinary },
            EndsOrFails(exact, PHASE + 1e3 * 2.0 * 1e12 * f64::EPSILON),
        ),
    ];
    let complaints: Vec<String> = cases
        .into_iter()
        .flat_map(|(case, system, span, fate)| judged(case, hangs(system, span), fate, |s| s.q[0]))
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// `consistent` finds a state on the constraints or says that there is none.
#[test]
fn consistent_starts() {
    for (q, qd, found) in [
        ([0.3, -0.4], [1.0, 1.0], true),
        ([1e-8, 0.0], [0.0, 0.0], true),
        ([1e6, 0.0], [1e6, 1e6], true),
        ([0.0, 0.0], [0.0, 0.0], false),
        ([f64::NAN, 0.0], [0.0, 0.0], false),
        ([f64::INFINITY, 0.0], [0.0, 0.0], false),
        ([1.0, 0.0], [f64::NAN, 0.0], false),
        ([1e200, 0.0], [0.0, 0.0], false),
    ] {
        match consistent(&BOB, &State::new(0.0, q, qd)) {
            Ok(state) => {
                assert!(
                    found && (state.q.norm() - 1.0).abs() <= 4.0 * f64::EPSILON,
                    "{q:?} {qd:?}: {state:?}"
                );
                let along = state.q.dot(&state.qd).abs();
                assert!(along <= 4.0 * f64::EPSILON * state.qd.norm().max(1.0), "{q:?} {qd:?}: {along:e}");
            }
            Err(failure) => assert!(!found && tells(&failure), "{q:?} {qd:?}: {failure}"),
        }
    }
}

lagrangian! {
    /// Two rods, one below the other.
    pub system Rods {
        param m, l, g;
        coord x: [2], y: [2];
        T = 0.5 * m * (0..2).map(|i| dot(x[i]).powi(2) + dot(y[i]).powi(2)).sum();
        V = m * g * y.sum();
        constraint upper: x[0] * x[0] + y[0] * y[0] == l * l;
        constraint lower: (x[1] - x[0]).powi(2) + (y[1] - y[0]).powi(2) == l * l;
    }
}

/// M q̈ = f − b + Aᵀ λ and A q̈ = −γ, to the rounding of their terms; ġ = A q̈ + γ by a dual number.
fn balanced<Sys, Moving, const N: usize, const M: usize>(
    system: &Sys,
    moving: &Moving,
    q: SVector<f64, N>,
    qd: SVector<f64, N>,
) where
    Sys: Constrained<N, M> + Lagrangian<N, Scalar = f64>,
    Moving: Constrained<N, M> + Lagrangian<N, Scalar = Dual<f64>>,
{
    let (a, multipliers) = (system.accel(&q, &qd, 0.0), system.multipliers(&q, &qd, 0.0));
    let held = system.constraint_jacobian(&q, 0.0).transpose() * multipliers;
    let inertial = system.inertia(&q, &qd, 0.0) * a;
    let left =
        inertial + system.convective_momentum_rate(&q, &qd, 0.0) - system.momentum_rate(&q, &qd, 0.0) - held;
    let size = inertial.amax() + held.amax() + system.momentum_rate(&q, &qd, 0.0).amax();
    assert!(left.amax() <= 64.0 * f64::EPSILON * size, "{q} {qd}: q̈ = {a}, λ = {multipliers}");
    let along = |v: SVector<f64, N>, slope: SVector<f64, N>| {
        SVector::<Dual<f64>, N>::from_fn(|i, _| Dual { value: v[i], slope: slope[i] })
    };
    let rates = moving.constraint_rates(&along(q, qd), &along(qd, a), Dual::variable(0.0));
    let size = a.amax() * q.amax() + qd.amax().powi(2);
    assert!(
        rates.iter().all(|r| r.slope.abs() <= 64.0 * f64::EPSILON * size),
        "{q} {qd}: q̈ = {a}, {rates:?}"
    );
}

/// Some entries of ∂f/∂q vanish, and the constraints are regular all the same: no order of elimination may
/// divide by them.
#[test]
fn constraints_along_the_axes() {
    let directions =
        [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1e-9, -1.0], [1.0, 1e-9], [0.6, 0.8]];
    let (rods, velocity) = (Rods { m: 1.0, l: 1.0, g: 9.0 }, [0.3, -0.7, 0.2, 1.1]);
    for [x, y] in directions {
        balanced(&BOB, &BOB.map(Dual::constant), [x, y].into(), [velocity[0] * y, -velocity[0] * x].into());
        for [u, v] in directions {
            balanced(&rods, &rods.map(Dual::constant), [x, x + u, y, y + v].into(), velocity.into());
        }
    }
}

lagrangian! {
    /// A wheel on an arm that swings about an axis n, and about which it spins.
    pub system Wheel {
        param m, l, A, C, g, n: [3];
        coord theta: angle, spin: angle;
        let arm = frame(world, [0, 0, 0], rotation(n, theta));
        let wheel = frame(arm, [0, 0, -l], rotation_z(spin));
        T = body(m, [A, A, C], wheel);
        V = m * g * wheel.origin()[2];
    }
}

/// (m l² + A) θ̈ = −m g l sin θ: the swing of PENDULUM.
const WHEEL: Wheel = Wheel { m: 1.0, l: 1.0, A: 0.5, C: 0.3, g: 13.5, n: [1.0, 0.0, 0.0] };

fn turns(system: Wheel, span: Span<2>) -> Ends<2> {
    ends!(
        system,
        span,
        [DormandPrince5, Dop853, Verner9, Rodas5P, Radau5],
        [Rk4, ImplicitMidpoint, Gauss4, VariationalMidpoint]
    )
}

#[test]
fn bodies_on_frames() {
    let start = State::new(0.0, [0.5, 0.2], [0.0, 2.0]);
    let ordinary = Span { start, end: 1.0, tolerance: 1e-9, step: 1e-3 };
    let (exact, nan, inf) = (angle(0.5, 1.0), f64::NAN, f64::INFINITY);
    let axis = |n: [f64; 3]| Wheel { n, ..WHEEL };
    let spinning = |rate: f64| Span { start: State::new(0.0, [0.5, 0.2], [0.0, rate]), ..ordinary };
    let cases: Vec<(&str, Wheel, Span<2>, Fate)> = vec![
        ("ordinary", WHEEL, ordinary, Ends(exact, PHASE)),
        ("no axis", axis([0.0; 3]), ordinary, Fails),
        ("NaN for the axis", axis([1.0, nan, 0.0]), ordinary, Fails),
        ("an infinite axis", axis([inf, 0.0, 0.0]), ordinary, EndsOrFails(exact, PHASE)),
        // Momenta may take its square.
        ("a long axis", axis([1e200, 0.0, 0.0]), ordinary, EndsOrFails(exact, PHASE)),
        ("a short axis", axis([1e-200, 0.0, 0.0]), ordinary, EndsOrFails(exact, PHASE)),
        ("an axis whose square loses digits", axis([3e-162, 0.0, 0.0]), ordinary, Ends(exact, PHASE)),
        ("an axis along the smallest number", axis([5e-324, 0.0, 0.0]), ordinary, EndsOrFails(exact, PHASE)),
        ("backward axis", axis([-2.0, 0.0, 0.0]), ordinary, Ends(exact, PHASE)),
        ("NaN for A", Wheel { A: nan, ..WHEEL }, ordinary, Fails),
        ("infinite A", Wheel { A: inf, ..WHEEL }, ordinary, EndsOrFails(0.5, PHASE)),
        // C cancels.
        ("nothing that spins", Wheel { C: 0.0, ..WHEEL }, ordinary, EndsOrFails(exact, PHASE)),
        ("nothing at all", Wheel { m: 0.0, A: 0.0, C: 0.0, ..WHEEL }, ordinary, Fails),
        ("negative C", Wheel { C: -0.3, ..WHEEL }, ordinary, Fails),
        ("no inertia in all", Wheel { A: -1.0, ..WHEEL }, ordinary, Fails),
        ("no mass", Wheel { m: 0.0, ..WHEEL }, ordinary, EndsOrFails(0.5, PHASE)),
        ("mass below normal numbers", Wheel { m: 1e-310, ..WHEEL }, ordinary, EndsOrFails(0.5, PHASE)),
        ("no length", Wheel { l: 0.0, ..WHEEL }, ordinary, Ends(0.5, PHASE)),
        ("infinite length", Wheel { l: inf, ..WHEEL }, ordinary, Fails),
        ("NaN for g", Wheel { g: nan, ..WHEEL }, ordinary, Fails),
        ("a huge spin", WHEEL, spinning(1e150), EndsOrFails(exact, PHASE)),
        ("a spin near overflow", WHEEL, spinning(1e300), EndsOrFails(exact, PHASE)),
        ("NaN for the spin", WHEEL, spinning(nan), Fails),
        ("backward", WHEEL, Span { end: -1.0, ..ordinary }, Ends(exact, PHASE)),
        ("empty", WHEEL, Span { end: 0.0, ..ordinary }, Ends(0.5, 0.0)),
    ];
    let complaints: Vec<String> = cases
        .into_iter()
        .flat_map(|(case, system, span, fate)| judged(case, turns(system, span), fate, |s| s.q[0]))
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

lagrangian! {
    /// A crank and a rod whose end slides along y = 0, in frames of the plane.
    pub system SliderCrank {
        param m, I, a, b, g;
        coord alpha: angle, beta: angle;
        let crank = frame(world, [0, 0], alpha);
        let rod = frame(world, crank.point([a, 0]), beta);
        T = body(m, I, crank) + body(m, I, frame(rod, [0.5 * b, 0]));
        V = m * g * rod.origin()[1];
        constraint rail: rod.point([b, 0])[1] == 0;
    }
}

#[test]
fn closed_loops_of_frames() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let crank = SliderCrank { m: 1.0, I: 0.2, a: 0.5, b: 1.5, g: 9.0 };
    let at = |alpha: f64, beta: f64, rate: f64| Span {
        start: State::new(0.0, [alpha, beta], [rate, 0.0]),
        end: 0.5,
        tolerance: 1e-9,
        step: 1e-3,
    };
    // Where the rod is along the rail; with it, what turns is the crank alone.
    let on = |alpha: f64| PI + (0.5 * alpha.sin() / 1.5).asin();
    let ordinary = at(0.7, on(0.7), 0.0);
    let run = integrate(&crank, Dop853, PiController::tolerance(1e-13), ordinary.start).until(0.5);
    let exact = run.final_state().expect("an ordinary motion").q[0];
    let cases: Vec<(&str, SliderCrank, Span<2>, Fate)> = vec![
        ("ordinary", crank, ordinary, Ends(exact, PHASE)),
        ("NaN for a", SliderCrank { a: nan, ..crank }, ordinary, Fails),
        ("infinite b", SliderCrank { b: inf, ..crank }, ordinary, Fails),
        ("off the rail", crank, at(0.7, 0.3, 0.0), Fails),
        ("a rate that leaves the rail", crank, at(0.7, on(0.7), 1.0), Fails),
        (
            "both upright, where the rail holds nothing",
            SliderCrank { b: 0.5, ..crank },
            at(FRAC_PI_2, -FRAC_PI_2, 1.0),
            Fails,
        ),
        ("no crank and no rod", SliderCrank { a: 0.0, b: 0.0, ..crank }, ordinary, Fails),
        ("no inertia", SliderCrank { m: 0.0, I: 0.0, ..crank }, ordinary, Fails),
    ];
    let complaints: Vec<String> = cases
        .into_iter()
        .flat_map(|(case, system, span, fate)| {
            let ends = ends!(system, span, [DormandPrince5, Dop853, Verner9, Rodas5P, Radau5], [Rk4]);
            judged(case, ends, fate, |s| s.q[0])
        })
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

lagrangian! {
    pub system Falling {
        param f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = f * x;
    }
}

/// Forces among subnormal numbers, whose roundings are no slow convergence: x = −f t²/2 by every family, to the
/// roundings of its steps.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn subnormal_forces() {
    for f in [1e-300, 1e-308, 1e-310, 1e-320, 5e-324] {
        for h in [0.1, 1e-3, 10.0] {
            let (system, start, end) = (Falling::new(f), State::new(0.0, [0.0], [0.0]), 10.0);
            macro_rules! check {
                ($($method:expr),*) => {$(
                    let run = integrate(&system, $method, FixedStep::new(h), start).until(end).final_state();
                    let x = run.unwrap_or_else(|failed| panic!("{f:e}, {h}, {}: {failed}", stringify!($method))).q[0];
                    // Each step rounds q, q̇ and stages, with coefficients up to 100 that cancel, to multiples of the
                    // smallest number, and errors of q̇ are carried to the end.
                    let steps = end / h;
                    let rounding = 256.0 * 5e-324 * steps * (1.0 + 0.5 * end) + steps.max(16.0) * f64::EPSILON * 50.0 * f;
                    assert!((x + 50.0 * f).abs() <= rounding, "{f:e}, {h}, {}: {x:e}", stringify!($method));
                )*};
            }
            check!(Gauss4, Gauss6, ImplicitMidpoint, VariationalMidpoint, Radau5, Rodas5P, Dop853, Verner9);
        }
    }
}

lagrangian! {
    /// `exp(x)` moves equally, but for a weak force.
    pub system Stretched {
        param w;
        coord x;
        T = 0.5 * (exp(x) * dot(x)).powi(2);
        V = w * x;
    }
}

/// The energy is not restored by a way on which such a force would do the work. To first order in the force w,
/// `exp(x) = 1 + t − w ((1 + t) ln(1 + t) − t)`.
#[test]
fn a_force_that_hardly_acts_is_no_way_to_restore_the_energy() {
    for w in [0.0, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-24] {
        let exact = 6f64.ln() - w * (6f64.ln() - 5.0 / 6.0);
        let (system, start) = (Stretched::new(w), State::new(0.0, [0.0], [1.0]));
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let controller = PiController::tolerance(tolerance);
            let run = integrate(&system, Projection(DormandPrince5), controller, start).until(5.0);
            let end = run.final_state().unwrap_or_else(|failed| panic!("{w:e}, {tolerance:e}: {failed}"));
            let error = (end.q[0] - exact).abs();
            println!("force {w:e}, tolerance {tolerance:e}: {error:.1e}");
            assert!(error < 10.0 * tolerance + 25.0 * w * w, "{w:e}, {tolerance:e}: {error:e}");
        }
    }
}
