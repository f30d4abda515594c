//! Motions against reference digits, and what a motion conserves.
//!
//! What is allowed is computed, not chosen. Each step of [`Dop853`] may err by the tolerance, which its controller
//! keeps in the root mean square over all coordinates and velocities, so that a single one may err by `√2N` times
//! that. An error δ made in step k has become `Φ(t, tₖ) δ` at time t, where Φ is the derivative of the flow, here by
//! dual numbers. The errors of different steps are taken for independent, so their squares add up (Henrici, *Discrete
//! Variable Methods in Ordinary Differential Equations*, 1962). What is conserved, `C(x)`, needs no Φ: the error δ
//! changes it by `∇C·δ` for good.

use super::row::{Finding, Kind};
use super::subject::{Golden, Quantity, position};
use super::{ROOM, State, Subject};
use lagrange_runtime::__private::series::Smooth;
use lagrange_runtime::{
    Controller, Dop853, Dual, Method, PiController, Real, Scalar, System, Taylor, TaylorController,
    integrate,
    traits::{Analytic, TaylorSeries},
};
use nalgebra::{DMatrix, DVector, SVector};

/// Absolute and relative, of every step.
const TOLERANCE: f64 = 1e-13;

/// A state at the end of a step, q and q̇ in one vector.
pub struct At<S> {
    t: S,
    x: Vec<S>,
}

/// The steps of a system with the given parameters from a start `q, q̇` at `times[0]` through the other times.
pub type Motion<S> =
    fn(names: &[String], parameters: &[S], start: &[S], times: &[f64]) -> Result<Vec<At<S>>, String>;

/// The accelerations of a system without its type, so that each method is compiled once for each number of coordinates.
struct Accelerations<'a, S, const N: usize>(&'a Law<'a, S, N>);

type Law<'a, S, const N: usize> = dyn Fn(&SVector<S, N>, &SVector<S, N>, S) -> SVector<S, N> + 'a;

impl<S: Scalar, const N: usize> System<N> for Accelerations<'_, S, N> {
    type Scalar = S;

    fn accel(&self, q: &SVector<S, N>, qd: &SVector<S, N>, t: S) -> SVector<S, N> {
        (self.0)(q, qd, t)
    }
}

/// The [`Motion`] of a system.
pub fn motion<G: Golden<N>, const N: usize, S: Real>(
    names: &[String],
    parameters: &[S],
    start: &[S],
    times: &[f64],
) -> Result<Vec<At<S>>, String> {
    let system = G::with(|name| parameters[position(names, name)]);
    steps::<S, N>(Accelerations(&|q, qd, t| system.accel(q, qd, t)), start, times)
}

/// Taylor series of a system without its type.
struct Recurrences<'a, const N: usize> {
    accelerations: Accelerations<'a, f64, N>,
    series: &'a dyn Fn(&lagrange_runtime::State<f64, N>, usize) -> TaylorSeries<f64, N, ROOM>,
}

impl<const N: usize> System<N> for Recurrences<'_, N> {
    type Scalar = f64;

    fn accel(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>, t: f64) -> SVector<f64, N> {
        self.accelerations.accel(q, qd, t)
    }
}

impl<const N: usize> Analytic<N> for Recurrences<'_, N> {
    type Sides = Smooth;

    fn switching(&self, _: &lagrange_runtime::State<f64, N>, _: &Smooth) -> Smooth {
        Smooth
    }

    fn series_within<const K: usize>(
        &self,
        at: &lagrange_runtime::State<f64, N>,
        order: usize,
        _: &Smooth,
        motion: &mut TaylorSeries<f64, N, K>,
    ) -> [Smooth; K] {
        let all = (self.series)(at, order);
        *motion = TaylorSeries { q: std::array::from_fn(|k| all.q[k]) };
        [Smooth; K]
    }
}

/// The [`Motion`] of a system by its Taylor series; nothing where it has none.
pub fn by_series<G: Golden<N>, const N: usize>(
    names: &[String],
    parameters: &[f64],
    start: &[f64],
    times: &[f64],
) -> Result<Vec<At<f64>>, String> {
    let system = G::with(|name| parameters[position(names, name)]);
    let zero = lagrange_runtime::State::new(0.0, [1.0; N], [0.0; N]);
    if G::series(&system, &zero, 0).is_none() {
        return Ok(Vec::new());
    }
    let accelerations = Accelerations(&|q, qd, t| system.accel(q, qd, t));
    let series = |at: &lagrange_runtime::State<f64, N>, order| {
        G::series(&system, at, order).unwrap_or_else(|| {
            let mut motion = TaylorSeries::zero();
            motion.begin(at);
            motion
        })
    };
    let recurrences = Recurrences { accelerations, series: &series };
    steps_of(&recurrences, Taylor, TaylorController::tolerance(1e-15), start, times)
}

fn steps<S: Real, const N: usize>(
    system: Accelerations<'_, S, N>,
    start: &[S],
    times: &[f64],
) -> Result<Vec<At<S>>, String> {
    steps_of(&system, Dop853, PiController::tolerance(TOLERANCE), start, times)
}

fn steps_of<S: Real, Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: &[S],
    times: &[f64],
) -> Result<Vec<At<S>>, String>
where
    Sys: System<N, Scalar = S>,
    M: Method<Sys, N>,
    C: Controller<S, N, M::Error>,
{
    let q = std::array::from_fn(|k| start[k]);
    let qd = std::array::from_fn(|k| start[N + k]);
    let start = lagrange_runtime::State::new(S::from_f64(times[0]), q, qd);
    let mut run = integrate(system, method, controller, start);
    let mut steps = Vec::new();
    for &time in &times[1..] {
        run = run.until(S::from_f64(time));
        for step in run.by_ref() {
            let to = step.map_err(|failure| failure.to_string())?.to;
            steps.push(At { t: to.t, x: to.q.iter().chain(&to.qd).copied().collect() });
        }
    }
    Ok(steps)
}

/// A motion with what is allowed at its ends.
pub struct Flight {
    steps: Vec<At<f64>>,
    propagators: Vec<DMatrix<f64>>,
}

/// A number, and how far it may be off.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    pub value: f64,
    pub allowed: f64,
}

impl Flight {
    /// From a state through some later times.
    pub fn new(subject: &Subject, start: &State, times: &[f64]) -> Result<Self, String> {
        let reference = &subject.reference;
        let times: Vec<f64> = std::iter::once(start.t).chain(times.iter().copied()).collect();
        let x: Vec<f64> = start.q.iter().chain(&start.qd).copied().collect();
        let steps = (subject.motion)(&reference.names, &reference.values, &x, &times)?;

        let parameters: Vec<_> = reference.values.iter().map(|&value| Dual::constant(value)).collect();
        let mut columns = Vec::new();
        for j in 0..x.len() {
            let mut start: Vec<_> = x.iter().map(|&value| Dual::constant(value)).collect();
            start[j] = Dual::variable(x[j]);
            columns.push((subject.tangent)(&reference.names, &parameters, &start, &times)?);
        }
        if columns.iter().any(|column| column.len() != steps.len()) {
            return Err("duals change the steps".to_owned());
        }
        let propagator = |k: usize| DMatrix::from_fn(x.len(), x.len(), |i, j| columns[j][k].x[i].slope);
        let propagators = (0..steps.len()).map(propagator).collect();
        Ok(Flight { steps, propagators })
    }

    /// Coordinates and velocities at one of the times.
    pub fn at(&self, time: f64) -> Result<Vec<Measured>, String> {
        let last = self.steps.iter().position(|step| step.t == time);
        let last = last.ok_or_else(|| format!("no step to t = {time}"))?;
        let mut allowed = DVector::zeros(self.steps[last].x.len());
        for (step, propagator) in self.steps.iter().zip(&self.propagators).take(last + 1) {
            let back = propagator.clone().try_inverse().ok_or("the flow cannot be reversed")?;
            let error = (&self.propagators[last] * back).abs() * tolerated(step);
            allowed += error.component_mul(&error);
        }
        let pairs = self.steps[last].x.iter().zip(&allowed);
        Ok(pairs.map(|(&value, allowed)| Measured { value, allowed: allowed.sqrt() }).collect())
    }
}

/// The states of a motion at given times.
pub fn states(subject: &Subject, start: &State, times: &[f64]) -> Result<Vec<State>, String> {
    let reference = &subject.reference;
    let x: Vec<f64> = start.q.iter().chain(&start.qd).copied().collect();
    let all: Vec<f64> = std::iter::once(start.t).chain(times.iter().copied()).collect();
    let steps = (subject.motion)(&reference.names, &reference.values, &x, &all)?;
    let at = |time: &f64| {
        let step =
            steps.iter().find(|step| step.t == *time).ok_or_else(|| format!("no step to t = {time}"))?;
        let (q, qd) = step.x.split_at(subject.n);
        Ok(State::new(q, qd, step.t))
    };
    times.iter().map(at).collect()
}

/// The last coordinate at the end of the motion in the file: its name, what was found, and the digits.
pub fn end(subject: &Subject) -> Option<(String, f64, f64)> {
    let motion = subject.reference.trajectory();
    let last = motion.last()?;
    let reached = states(subject, &motion[0], &[last.t]).ok()?;
    let k = subject.n - 1;
    let name = format!("{} at t = {}", subject.facts.coordinates[k], last.t);
    Some((name, reached[0].q[k], last.q[k]))
}

/// Admitted error of a single step that ends here, in each coordinate and velocity.
fn tolerated(step: &At<f64>) -> DVector<f64> {
    let single = TOLERANCE * (step.x.len() as f64).sqrt();
    DVector::from_iterator(step.x.len(), step.x.iter().map(|x| single * (1.0 + x.abs())))
}

/// The motion in the file, at quarters of its time and at its end, and its conserved quantities at every step.
pub fn check_trajectory(subject: &Subject) -> Vec<Finding> {
    let expected = subject.reference.trajectory();
    let times: Vec<f64> = expected[1..].iter().map(|state| state.t).collect();
    let flight = match Flight::new(subject, &expected[0], &times) {
        Ok(flight) => flight,
        Err(reason) => return vec![Finding::failed("trajectory", &reason)],
    };
    let mut findings = Vec::new();
    for state in &expected[1..] {
        let place = format!("trajectory at t = {}", state.t);
        match flight.at(state.t) {
            Err(reason) => findings.push(Finding::failed(place, &reason)),
            Ok(found) => {
                let expected: Vec<f64> = state.q.iter().chain(&state.qd).copied().collect();
                let size = super::largest(&expected);
                findings.extend(found.iter().zip(&expected).enumerate().map(|(k, (found, expected))| {
                    Finding {
                        kind: Kind::Motion,
                        what: format!("{place}, x[{k}]"),
                        error: (found.value - expected).abs(),
                        allowed: found.allowed,
                        size,
                    }
                }));
            }
        }
    }
    findings.extend(check_conserved(subject, &expected[0], &flight.steps));
    findings.extend(check_series(subject, &expected, &flight));
    findings
}

/// The same motion by Taylor series at a tolerance of 1e-15, within what is allowed for a tolerance a hundred times
/// as large.
fn check_series(subject: &Subject, expected: &[State], flight: &Flight) -> Vec<Finding> {
    let start: Vec<f64> = expected[0].q.iter().chain(&expected[0].qd).copied().collect();
    let times: Vec<f64> = expected.iter().map(|state| state.t).collect();
    let reference = &subject.reference;
    let steps = match (subject.series)(&reference.names, &reference.values, &start, &times) {
        Ok(steps) if steps.is_empty() => return Vec::new(),
        Ok(steps) => steps,
        Err(reason) => return vec![Finding::failed("series", &reason)],
    };
    let mut findings = Vec::new();
    for state in &expected[1..] {
        let place = format!("series at t = {}", state.t);
        let (Some(found), Ok(allowed)) = (steps.iter().find(|step| step.t == state.t), flight.at(state.t))
        else {
            findings.push(Finding::failed(place, "no step to there"));
            continue;
        };
        let expected: Vec<f64> = state.q.iter().chain(&state.qd).copied().collect();
        let size = super::largest(&expected);
        for (k, ((found, expected), allowed)) in found.x.iter().zip(&expected).zip(allowed).enumerate() {
            findings.push(Finding {
                kind: Kind::Motion,
                what: format!("{place}, x[{k}]"),
                error: (found - expected).abs(),
                allowed: allowed.allowed,
                size,
            });
        }
    }
    findings
}

/// The energy function and the momenta of ignorable coordinates: the largest drift of each in proportion to what is
/// allowed.
fn check_conserved(subject: &Subject, start: &State, steps: &[At<f64>]) -> Vec<Finding> {
    let n = subject.n;
    let energy = subject.facts.conservative.then_some((Quantity::Jacobi, 0));
    let momenta = subject.facts.ignorable.iter().map(|&k| (Quantity::Momenta, k));
    let drift = |(quantity, k): (Quantity, usize)| {
        let conserved = subject.at("", start).value(quantity)[k];
        let mut allowed = 0.0;
        let drifts = steps.iter().map(|step| {
            let state = State { q: step.x[..n].to_vec(), qd: step.x[n..].to_vec(), t: step.t };
            let point = subject.at("", &state);
            let errors = tolerated(step);
            let change: f64 = (0..2 * n).map(|i| (point.partial(quantity, i)[k] * errors[i]).abs()).sum();
            allowed = f64::hypot(allowed, change);
            Finding {
                kind: Kind::Conserved,
                what: format!("drift of {quantity:?}[{k}] at t = {}", step.t),
                error: (point.value(quantity)[k] - conserved).abs(),
                allowed: allowed + point.bound(quantity, conserved.abs()),
                size: conserved.abs(),
            }
        });
        drifts.max_by(|a, b| a.share().total_cmp(&b.share()))
    };
    energy.into_iter().chain(momenta).filter_map(drift).collect()
}
