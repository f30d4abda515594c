//! Measuring what methods promise: order, symplecticity, conservation. For the tests of this crate and of its users.

use crate::controller::{Controller, FixedStep};
use crate::failed::Failed;
use crate::failure::Failure;
use crate::integrate::{Run, integrate};
use crate::linear::ldlt;
use crate::method::{Interpolant, Method};
use crate::scalar::{Dual, Functions, Real, Scalar};
use crate::state::State;
use crate::system::{Lagrangian, LegendreTransform, System};
use nalgebra::SVector;

pub mod reference;
#[cfg(feature = "std")]
pub mod work_precision;

#[cfg(test)]
#[path = "../tests/systems/bank.rs"]
pub(crate) mod bank;
#[cfg(test)]
#[path = "../tests/systems/emitted.rs"]
pub(crate) mod emitted;

/// The slope of log(error) over log(h) by least squares, of those points whose error is above `rounding`; NaN where
/// these are fewer than two.
pub fn slope(points: impl IntoIterator<Item = (f64, f64)>, rounding: f64) -> f64 {
    let (mut n, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (h, error) in points {
        if error > rounding {
            let (log_h, log_error) = (Functions::ln(h), Functions::ln(error));
            n += 1.0;
            x += log_h;
            y += log_error;
            xx += log_h * log_h;
            xy += log_h * log_error;
        }
    }
    if n < 2.0 { f64::NAN } else { (n * xy - x * y) / (n * xx - x * x) }
}

/// The largest difference of two states in any coordinate or velocity.
pub fn distance<S: Real, const N: usize>(a: &State<S, N>, b: &State<S, N>) -> f64 {
    let difference = a.minus(b);
    difference.q.iter().chain(difference.qd.iter()).fold(0.0, |most, x| {
        let x = x.to_f64().abs();
        // `f64::max` would pass over a NaN.
        if x > most || x.is_nan() { x } else { most }
    })
}

/// Errors below this are taken for rounding: a thousand ε of the largest component.
fn rounding<S: Real, const N: usize>(exact: &State<S, N>) -> f64 {
    let largest = exact.q.iter().chain(exact.qd.iter()).fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
    1e3 * S::EPSILON * largest
}

/// The measured order of a method: the slope of the error at the end over the step size, for runs from `start` to the
/// time of the `exact` state in the given numbers of equal steps. Errors at the level of rounding are left out.
pub fn order_of<Sys, M, const N: usize>(
    system: &Sys,
    method: &M,
    start: &State<Sys::Scalar, N>,
    exact: &State<Sys::Scalar, N>,
    steps: &[u32],
) -> Result<f64, Failed<Sys::Scalar, N>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N> + Clone,
{
    let mut failed = None;
    let measured = slope(
        steps.iter().filter_map(|&n| {
            let h = (exact.t - start.t) / Sys::Scalar::from_f64(f64::from(n));
            match integrate(system, method.clone(), FixedStep::new(h), *start).until(exact.t).final_state() {
                Ok(end) => Some((h.to_f64().abs(), distance(&end, exact))),
                Err(failure) => {
                    failed = Some(failure);
                    None
                }
            }
        }),
        rounding(exact),
    );
    failed.map_or(Ok(measured), Err)
}

/// The measured order of a method's interpolant: as [`order_of`], for the largest error at the quarters of all steps
/// up to `end`, where `exact` gives the true state at any time.
pub fn dense_order_of<Sys, M, const N: usize>(
    system: &Sys,
    method: &M,
    exact: impl Fn(Sys::Scalar) -> State<Sys::Scalar, N>,
    end: Sys::Scalar,
    steps: &[u32],
) -> Result<f64, Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N> + Clone,
{
    let start = exact(Sys::Scalar::zero());
    let mut failed = None;
    let worst = |n: u32| {
        let h = end / Sys::Scalar::from_f64(f64::from(n));
        let mut worst = 0.0f64;
        for step in integrate(system, method.clone(), FixedStep::new(h), start).until(end) {
            let step = step?;
            let dense = method.interpolant(system, &step);
            for quarter in [0.25, 0.5, 0.75] {
                let t = step.from.t + step.h * Sys::Scalar::from_f64(quarter);
                worst = worst.max(distance(&dense.at(t), &exact(t)));
            }
        }
        Ok((h.to_f64().abs(), worst))
    };
    let measured = slope(
        steps.iter().filter_map(|&n| worst(n).map_err(|failure| failed = Some(failure)).ok()),
        rounding(&start),
    );
    failed.map_or(Ok(measured), Err)
}

/// Distance of a step of size `h` from a symplectic map: the largest element of `DΦᵀ J DΦ − J`, where Φ maps (q, p) to
/// (q, p) and `J = (0, 1; −1, 0)`. The derivative is exact, by dual numbers, so the system has to compute with these:
/// `symplecticity_defect(&Pendulum { l: Dual::constant(1.0), … }, …)`. Symplectic methods give rounding.
pub fn symplecticity_defect<Sys, M, const N: usize>(
    system: &Sys,
    method: &M,
    at: &State<f64, N>,
    h: f64,
) -> Result<f64, Failure<Dual<f64>>>
where
    Sys: LegendreTransform<N, Scalar = Dual<f64>>,
    M: Method<Sys, N>,
{
    let t = Dual::constant(at.t);
    let [q, qd] = [at.q, at.qd].map(|x| SVector::from_fn(|i, _| Dual::constant(x[i])));
    let p = system.momenta(&q, &qd, t);
    // Derivatives of q₁ and p₁ by the component `i` of q₀ (`of_p` false) or of p₀ (true).
    let column = |of_p: bool, i: usize| -> Result<[SVector<f64, N>; 2], Failure<Dual<f64>>> {
        let (mut q, mut p) = (q, p);
        if of_p {
            p[i].slope = 1.0
        } else {
            q[i].slope = 1.0
        }
        let from = State { t, q, qd: system.velocities(&q, &p, t) };
        let memory = method.start(system, &from)?;
        let to = method.step(system, &memory, &from, Dual::constant(h))?.0.to;
        let p = system.momenta(&to.q, &to.qd, to.t);
        Ok([SVector::from_fn(|k, _| to.q[k].slope), SVector::from_fn(|k, _| p[k].slope)])
    };
    let mut defect = 0.0f64;
    for i in 0..2 * N {
        let [qi, pi] = column(i >= N, i % N)?;
        for j in 0..i {
            let [qj, pj] = column(j >= N, j % N)?;
            let expected = if i == j + N { 1.0 } else { 0.0 };
            defect = defect.max((qj.dot(&pi) - pj.dot(&qi) - expected).abs());
        }
    }
    Ok(defect)
}

/// The largest deviation of the energy function `h = p·q̇ − L` from its value at the start, over all steps of a run
/// with an end, in units of energy. For conservative systems it is an error of the method.
pub fn energy_drift<Sys, M, C, const N: usize>(
    system: &Sys,
    run: Run<'_, Sys, M, C, N>,
) -> Result<f64, Failure<Sys::Scalar>>
where
    Sys: Lagrangian<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    if run.end().is_none() {
        return Err(Failure::BadEnd { end: None });
    }
    let energy = |at: &State<Sys::Scalar, N>| system.energy_function(&at.q, &at.qd, at.t).to_f64();
    let start = energy(run.state());
    let mut drift = 0.0f64;
    for step in run {
        drift = drift.max((energy(&step?.to) - start).abs());
    }
    Ok(drift)
}

/// Disagreement of the functions of a Lagrangian system with each other at a state: the largest of
/// `M q̈ + b − f`, `p − M q̇` (where L is quadratic and homogeneous enough for it) and `velocities(p) − q̇`.
pub fn inconsistency<Sys, const N: usize>(system: &Sys, at: &State<Sys::Scalar, N>) -> f64
where
    Sys: LegendreTransform<N>,
    Sys::Scalar: Real,
{
    let State { t, q, qd } = at;
    let right = system.momentum_rate(q, qd, *t) - system.convective_momentum_rate(q, qd, *t);
    let Ok(inertia) = ldlt(&system.inertia(q, qd, *t)) else { return f64::NAN };
    let acceleration = system.accel(q, qd, *t) - inertia.solve(&right);
    let velocity = system.velocities(q, &system.momenta(q, qd, *t), *t) - qd;
    let [a, v] =
        [acceleration, velocity].map(|x| x.iter().fold(0.0f64, |most, x| most.max(x.to_f64().abs())));
    a.max(v)
}

#[cfg(test)]
mod tests {
    use super::bank::*;
    use super::*;
    use crate::controller::PiController;
    use crate::method::explicit_rk::{Dop853, Euler, Rk4};
    use crate::method::splitting::Verlet;

    #[test]
    fn slope_leaves_out_the_plateau() {
        let points = [(1.0, 1.0), (0.5, 0.0625), (0.25, 0.00390625), (0.125, 1e-15)];
        assert!((slope(points, 1e-12) - 4.0).abs() < 1e-12);
        assert!(slope([(1.0, 1.0)], 0.0).is_nan());
    }

    #[test]
    fn distance_keeps_what_is_not_a_number() {
        let good = State::new(0.0, [1.0, 2.0], [3.0, 4.0]);
        let bad = State::new(0.0, [f64::NAN, 2.0], [3.0, 9.0]);
        assert!(distance(&good, &bad).is_nan());
        assert_eq!(distance(&good, &State::new(0.0, [1.0, 0.0], [3.0, 4.5])), 2.0);
    }

    #[test]
    fn the_systems_of_the_bank_are_consistent() {
        let pendulum: Pendulum = Pendulum::default();
        assert!(inconsistency(&pendulum, &State::new(0.0, [1.1], [0.4])) < 1e-14);
        assert!(inconsistency(&Polar::<f64>::default(), &State::new(0.0, [1.1, 0.4], [0.3, 0.8])) < 1e-14);
        assert!(
            inconsistency(&DoublePendulum::<f64>::default(), &State::new(0.0, [1.1, 0.4], [0.3, 0.8]))
                < 1e-14
        );
        for step in
            integrate(&DoublePendulum::<f64>::default(), Dop853, PiController::tolerance(1e-12), DOUBLE)
                .until(10.0)
        {
            // The energy function is conserved only if accelerations and Lagrangian belong together.
            let to = step.unwrap().to;
            let energy =
                |at: &State<f64, 2>| DoublePendulum::<f64>::default().energy_function(&at.q, &at.qd, at.t);
            assert!((energy(&to) - energy(&DOUBLE)).abs() < 1e-9);
        }
    }

    #[test]
    fn euler_is_not_symplectic_and_verlet_is() {
        let system = Pendulum::<Dual<f64>>::default();
        let at = State::new(0.0, [1.0], [0.5]);
        assert!(symplecticity_defect(&system, &Euler, &at, 0.1).unwrap() > 1e-3);
        assert!(symplecticity_defect(&system, &Rk4, &at, 0.1).unwrap() > 1e-9);
        assert!(symplecticity_defect(&system, &Verlet, &at, 0.1).unwrap() < 1e-15);
    }

    #[test]
    fn energy_drift_wants_an_end() {
        let system = Plane::default();
        let run = integrate(&system, Verlet, FixedStep::new(0.1), ELLIPSE);
        assert_eq!(energy_drift(&system, run), Err(Failure::BadEnd { end: None }));
    }
}
