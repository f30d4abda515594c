//! Lyapunov exponents: the mean rates at which neighbouring motions part.

use super::AnalysisError;
use super::variational::TangentFlow;
use crate::attitude;
use crate::controller::Controller;
use crate::integrate::integrate;
use crate::method::Method;
use crate::state::{State, Tangent};
use crate::system::System;
use nalgebra::{DMatrix, SVector};

/// A mean rate and its statistical error, in 1/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponent {
    /// The mean.
    pub value: f64,
    /// Standard error of the mean, from the scatter of the means over 20 equal parts of the run. It holds where these
    /// parts are longer than the memory of the motion.
    pub error: f64,
}

/// Durations for the measurement of a Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Time that is run before, in units of t and whole intervals, rounded up, until the motion has forgotten its start
    /// and the deviations their directions.
    pub transient: f64,
    /// Time between two normalisations of the deviations, in units of t.
    pub interval: f64,
    /// Number of intervals that count; rounded up to a multiple of 20.
    pub intervals: u32,
}

/// Parts of a run whose means are compared.
const PARTS: usize = 20;

impl Exponent {
    /// From the growth `ln(|δ|/|δ₀|)` in each of many equal intervals.
    fn of(growth: &[f64], interval: f64) -> Self {
        let length = growth.len() / PARTS;
        let mean = |part: &[f64]| part.iter().sum::<f64>() / (part.len() as f64 * interval);
        let means: Vec<f64> = growth.chunks_exact(length.max(1)).map(mean).collect();
        let value = mean(growth);
        let scatter = means.iter().map(|m| (m - value).powi(2)).sum::<f64>();
        let parts = means.len() as f64;
        Exponent { value, error: (scatter / (parts * (parts - 1.0))).sqrt() }
    }
}

impl Measurement {
    /// Intervals before those that count, and these.
    fn counts(&self) -> Result<(u32, usize), AnalysisError> {
        let sensible =
            self.interval > 0.0 && self.interval.is_finite() && self.transient >= 0.0 && self.intervals > 0;
        let before = self.transient / self.interval;
        if !sensible || before > f64::from(u32::MAX) {
            return Err(AnalysisError::NotApplicable {
                needs: "a positive interval, a number of them, and no negative time",
            });
        }
        Ok((before.ceil() as u32, (self.intervals as usize).div_ceil(PARTS) * PARTS))
    }
}

/// Smallest change of deviations in an interval, relative to them, of which half of the digits are known.
const RESOLVED: f64 = 1e-8;

/// The Lyapunov exponents `λ = lim ln(|δ(t)|/|δ(0)|)/t` of a flow, the largest first, as many as it has deviations,
/// so all 2N for 2N, and with constraints no more than deviations that these admit: deviations obey the variational
/// equations and are made orthonormal anew after each interval (Benettin, Galgani, Giorgilli and
/// Strelcyn, *Meccanica* 15, 1980; Shimada and Nagashima 1979). A conservative system has them in pairs ±λ, two of
/// which are 0. With K [states of first order](crate::traits::States) there are 2N − K.
///
/// # Hypotheses
/// - The measurement has intervals of positive length, and no negative times: otherwise
///   [`AnalysisError::NotApplicable`].
/// - An interval is short enough for deviations to remain independent, to half the digits, and long enough for them
///   to change by 1e-8: otherwise [`AnalysisError::NotApplicable`].
/// - The motion is bounded and forgets its start within a twentieth of the run, for the standard error to hold. That
///   is not checked.
///
/// # Errors
/// [`AnalysisError::Run`].
pub fn lyapunov_spectrum<Flow: TangentFlow<N>, const N: usize>(
    flow: &Flow,
    start: &State<f64, N>,
    how: &Measurement,
) -> Result<Vec<Exponent>, AnalysisError> {
    const {
        let some = Flow::DEVIATIONS > 0 && Flow::DEVIATIONS <= 2 * N - Flow::FIRST_ORDER;
        assert!(
            some,
            "between one and 2N deviations are independent, less one for each state of first order"
        );
    }
    let (before, count) = how.counts()?;
    let (mut at, basis) = flow.admissible(start)?;
    // The time integrals of states act on nothing, and deviations that constraints do not admit stay 0.
    let integrals = N - Flow::FIRST_ORDER..N;
    let many = Flow::DEVIATIONS.min(basis.ncols());
    let carried = |some: DMatrix<f64>| some.resize_horizontally(Flow::DEVIATIONS, 0.0);
    // Fewer deviations than all are in no special directions: these may belong to a block of coordinates, in which
    // deviations stay.
    let mixed = DMatrix::from_fn(basis.ncols(), basis.ncols(), |i, j| {
        (1.618 * (i + 1) as f64 * (j + 1) as f64).sin() + f64::from(u8::from(i == j))
    });
    let basis = if many < basis.ncols() { (&basis * mixed).qr().q() } else { basis };
    let mut deviations = carried(basis.columns(0, many).into_owned());
    let mut growth = vec![Vec::with_capacity(count); many];
    for k in 0..before as usize + count {
        let (to, mut grown) = flow.follow(&at, &deviations, how.interval)?;
        integrals.clone().for_each(|i| grown.row_mut(i).fill(0.0));
        if (&grown - &deviations).norm() < RESOLVED * grown.norm() {
            let needs = "longer intervals: deviations change within one by little more than rounding";
            return Err(AnalysisError::NotApplicable { needs });
        }
        let grown = grown.columns(0, many).into_owned();
        let lengths: Vec<f64> = grown.column_iter().map(|x| x.norm()).collect();
        let factors = grown.qr();
        let independent = |d: usize| factors.r()[(d, d)].abs() > f64::EPSILON.sqrt() * lengths[d];
        if !(0..many).all(independent) {
            let needs = "shorter intervals: the deviations have become parallel within one, and the smaller exponents are rounding";
            return Err(AnalysisError::NotApplicable { needs });
        }
        (at, deviations) = (to, carried(factors.q()));
        if k >= before as usize {
            let lengths = factors.r();
            for (d, growth) in growth.iter_mut().enumerate() {
                // The sign of a direction does not matter, its length does.
                growth.push(lengths[(d, d)].abs().ln());
            }
        }
    }
    let mut all: Vec<Exponent> = growth.iter().map(|growth| Exponent::of(growth, how.interval)).collect();
    all.sort_by(|a, b| b.value.total_cmp(&a.value));
    Ok(all)
}

/// The largest Lyapunov exponent from two trajectories, the second brought back to the distance `separation`,
/// `√(|δq|² + |δq̇|²)` in the units of the system, from the first after each interval (Benettin, Galgani and Strelcyn,
/// *Phys. Rev. A* 14, 1976). It needs the accelerations alone; its method and controller are those of [`integrate`].
///
/// # Hypotheses
/// - Those of [`lyapunov_spectrum`] on the measurement.
/// - The distance is positive, and coordinates and velocities are not so large beside it that rounding changes it by
///   1e-4: otherwise [`AnalysisError::NotApplicable`].
/// - The distance remains small beside the motion through an interval, and large beside the error of integration.
///   That is not checked.
///
/// # Errors
/// [`AnalysisError::Run`].
pub fn lyapunov_by_two_trajectories<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    controller: C,
    start: &State<f64, N>,
    separation: f64,
    how: &Measurement,
) -> Result<Exponent, AnalysisError>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N> + Clone,
    C: Controller<f64, N, M::Error> + Clone,
{
    let (before, count) = how.counts()?;
    if !(separation > 0.0 && separation.is_finite()) {
        return Err(AnalysisError::NotApplicable { needs: "a positive distance between the trajectories" });
    }
    let length = |d: &Tangent<f64, N>| (d.q.norm_squared() + d.qd.norm_squared()).sqrt();
    let even = separation / (2.0 * N as f64).sqrt();
    let all = SVector::<f64, N>::from_element(1.0);
    // The trajectory beside the other one is on the constraints, too.
    let beside = |at: State<f64, N>| -> Result<_, AnalysisError> {
        Ok(system.restored(&at)?.map_or(at, |restored| restored.state))
    };
    let moved = start.moved(start.t, even, &Tangent { q: all, qd: all });
    let (mut first, mut second) = (*start, beside(moved)?);
    let mut growth = Vec::with_capacity(count);
    for k in 0..before as usize + count {
        let further = |from: State<f64, N>| {
            let run = integrate(system, method.clone(), controller.clone(), from);
            run.until(from.t + how.interval).final_state().map_err(|failed| failed.failure)
        };
        (first, second) = (further(first)?, further(second)?);
        second = second.turned(attitude::steps::astray(Sys::ATTITUDES, &second, &first));
        let mut apart = second.minus(&first);
        (N - Sys::FIRST_ORDER..N).for_each(|i| apart.q[i] = 0.0);
        let rounding = f64::EPSILON * first.q.amax().max(first.qd.amax());
        if !(rounding <= 1e-4 * separation && length(&apart) > 0.0) {
            let needs = "a distance between the trajectories that rounding does not change";
            return Err(AnalysisError::NotApplicable { needs });
        }
        let ratio = length(&apart) / separation;
        if k >= before as usize {
            growth.push(ratio.ln());
        }
        second = beside(first.moved(first.t, 1.0 / ratio, &apart))?;
    }
    Ok(Exponent::of(&growth, how.interval))
}
