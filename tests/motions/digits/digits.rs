//! Methods over `DoubleDouble`: their coefficients have all its digits.

use lagrange_runtime::controller::{ErrorEstimate, PiController};
use lagrange_runtime::integrate::integrate;
use lagrange_runtime::method::compose::{
    HairerLubichWanner10, KahanLi6, Suzuki4, SuzukiUmeno8, TripleJump, Yoshida6,
};
use lagrange_runtime::method::explicit_rk::{Euler, Heun, Tsitouras5};
use lagrange_runtime::method::nystrom::{Nystrom6, Nystrom8};
use lagrange_runtime::method::rosenbrock::Rodas4;
use lagrange_runtime::method::splitting::PositionVerlet;
use lagrange_runtime::method::taylor::LongTaylor;
use lagrange_runtime::method::variational::VariationalTrapezoid;
use lagrange_runtime::method::{Interpolant, Method};
use lagrange_runtime::scalar::DoubleDouble;
use lagrange_runtime::*;

type Double = DoubleDouble;

lagrangian! {
    /// Kepler's problem in the plane, with μ = 1.
    pub(super) system Kepler {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -1 / (x * x + y * y).sqrt();
    }
}

lagrangian! {
    /// Damped, with an exponential as its solution.
    system Damped {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x * x + 2 * y * y + x * y);
        D = 0.05 * (dot(x).powi(2) + 3 * dot(y).powi(2));
    }
}

fn kepler() -> Kepler<Double> {
    Kepler::new().map(Double::from)
}

fn start() -> State<Double, 2> {
    State::new(0.0, [0.9, 0.2], [-0.3, 1.1]).map(Double::from)
}

/// The motion after a time, by Taylor series at 1e-31.
fn exact(time: Double) -> State<Double, 2> {
    let system = kepler();
    let run = integrate(&system, LongTaylor, TaylorController::tolerance(1e-31), start());
    run.until(time).final_state().unwrap()
}

fn distance(a: &State<Double, 2>, b: &State<Double, 2>) -> [f64; 2] {
    let of = |a: &SVector<Double, 2>, b: &SVector<Double, 2>| {
        (a - b).iter().map(|x| x.value().abs()).fold(0.0, f64::max)
    };
    [of(&a.q, &b.q), of(&a.qd, &b.qd)]
}

/// In a step so short that the error of order p is below 1e-28, and a coefficient of 17 digits would show as 1e-17 h,
/// nothing is wrong beyond that error; and nothing within the step, where the interpolant is of the orders `inside`
/// in q and q̇.
fn has_all_digits<M: Method<Kepler<Double>, 2>>(name: &str, method: M, inside: [u32; 2]) {
    let order = f64::from(method.order());
    let local = |order: f64| 10f64.powf(-28.0 / (order + 1.0));
    let (system, from) = (kepler(), start());
    let memory = method.start(&system, &from).unwrap();
    let step = |h: Double| method.step(&system, &memory, &from, h).unwrap().0;
    let h = Double::from(local(order));
    let error = distance(&step(h).to, &exact(h));
    assert!(error.iter().all(|&error| error < 2e-28), "{name}: {error:?} after a step of {h:?}");
    for (part, order) in inside.into_iter().enumerate() {
        let h = Double::from(local(f64::from(order)));
        let (step, within) = (step(h), h * 0.37);
        let error = distance(&method.interpolant(&system, &step).at(within), &exact(within))[part];
        // Methods whose step is of a lower order than the interpolant err by that.
        let most = 1e-26f64.max(h.value().powf(f64::from(method.order()) + 1.0 - part as f64));
        assert!(error < most, "{name}: {error:e} of part {part} within a step of {h:?}");
    }
}

#[test]
fn coefficients_have_all_digits() {
    has_all_digits("Euler", Euler, [1, 1]);
    has_all_digits("Heun", Heun, [2, 2]);
    has_all_digits("Rk4", Rk4, [4, 4]);
    has_all_digits("DormandPrince5", DormandPrince5, [4, 4]);
    has_all_digits("Tsitouras5", Tsitouras5, [4, 4]);
    has_all_digits("Dop853", Dop853, [7, 7]);
    has_all_digits("Verner9", Verner9, [8, 8]);
    has_all_digits("Nystrom6", Nystrom6, [6, 5]);
    has_all_digits("Nystrom8", Nystrom8, [8, 7]);
    has_all_digits("Nystrom12", Nystrom12, [12, 11]);
    has_all_digits("Verlet", Verlet, [2, 2]);
    has_all_digits("PositionVerlet", PositionVerlet, [2, 2]);
    has_all_digits("BlanesMoan4", BlanesMoan4, [4, 4]);
    has_all_digits("BlanesMoan6", BlanesMoan6, [6, 6]);
    has_all_digits("TripleJump", Compose(Verlet, TripleJump), [4, 4]);
    has_all_digits("Suzuki4", Compose(Verlet, Suzuki4), [4, 4]);
    has_all_digits("Yoshida6", Compose(Verlet, Yoshida6), [6, 6]);
    has_all_digits("KahanLi6", Compose(Verlet, KahanLi6), [6, 6]);
    has_all_digits("SuzukiUmeno8", Compose(Verlet, SuzukiUmeno8), [8, 8]);
    has_all_digits("KahanLi8", Compose(Verlet, KahanLi8), [8, 8]);
    has_all_digits("HairerLubichWanner10", Compose(Verlet, HairerLubichWanner10), [9, 8]);
    has_all_digits("ImplicitMidpoint", ImplicitMidpoint, [2, 2]);
    has_all_digits("Gauss4", Gauss4, [4, 4]);
    has_all_digits("Gauss6", Gauss6, [5, 4]);
    has_all_digits("VariationalMidpoint", VariationalMidpoint, [2, 2]);
    has_all_digits("VariationalTrapezoid", VariationalTrapezoid, [2, 2]);
    has_all_digits("Radau5", Radau5, [5, 5]);
    has_all_digits("Rodas4", Rodas4, [3, 3]);
    has_all_digits("Rodas5P", Rodas5P, [4, 4]);
}

/// A quarter of a circle.
#[test]
fn runs_reach_tolerances_beyond_those_of_f64() {
    fn reaches<M>(name: &str, method: M, within: f64)
    where
        M: Method<Kepler<Double>, 2>,
        M::Error: ErrorEstimate<Double, 2>,
    {
        let start = State::new(0.0, [1.0, 0.0], [0.0, 1.0]).map(Double::from);
        let system = kepler();
        let run = integrate(&system, method, PiController::tolerance(1e-24), start).until(Double::PI * 0.5);
        let end = run.final_state().unwrap_or_else(|failed| panic!("{name}: {failed}"));
        let error = distance(&end, &State::new(0.0, [0.0, 1.0], [-1.0, 0.0]).map(Double::from));
        assert!(error.iter().all(|&error| error < within), "{name}: {error:?}");
    }
    reaches("Dop853", Dop853, 1e-23);
    reaches("Verner9", Verner9, 1e-23);
    reaches("Nystrom8", Nystrom8, 1e-23);
    reaches("Nystrom12", Nystrom12, 1e-23);
}

/// Ten units of time in one step, against short steps of Taylor series.
#[test]
fn linear_systems_are_propagated_with_all_digits() {
    let (system, time) = (Damped::new().map(Double::from), Double::from(10.0));
    let start = State::new(0.0, [0.9, 0.2], [-0.3, 1.1]).map(Double::from);
    let end =
        integrate(&system, MatrixExponential, FixedStep::new(time), start).until(time).final_state().unwrap();
    let series = integrate(&system, LongTaylor, TaylorController::tolerance(1e-31), start);
    let error = distance(&end, &series.until(time).final_state().unwrap());
    assert!(error.iter().all(|&error| error < 1e-29), "{error:?}");
}
