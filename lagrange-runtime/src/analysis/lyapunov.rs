//! Lyapunov exponents: the mean rates at which neighbouring motions part.

use super::AnalysisError;
use super::variational::{Variational, taken_apart, with_all_deviations};
use crate::controller::Pi;
use crate::integrate::integrate;
use crate::method::explicit_rk::Dop853;
use crate::state::{State, Tangent};
use crate::system::{Lagrangian, System};
use nalgebra::SVector;

/// A mean rate and its statistical error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponent {
    /// The mean.
    pub value: f64,
    /// Standard error of the mean, from the scatter of the means over 20 equal parts of the run. It holds where these parts
    /// are longer than the memory of the motion.
    pub error: f64,
}

/// How a Lyapunov exponent is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Time that is run before, until the motion has forgotten its start and the deviations their directions.
    pub transient: f64,
    /// Time between two normalisations of the deviations.
    pub interval: f64,
    /// How many intervals count; rounded up to a multiple of 20.
    pub intervals: u32,
    /// Tolerance of DOP853.
    pub tolerance: f64,
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

/// All 2N Lyapunov exponents, the largest first: deviations obey the variational equations and are made orthonormal anew after
/// each interval (Benettin, Galgani, Giorgilli and Strelcyn, *Meccanica* 15, 1980; Shimada and Nagashima 1979). `T = N (1 +
/// 2N)`. A conservative system has them in pairs ±λ, two of which are 0.
///
/// # Errors
/// [`AnalysisError::Run`]; [`AnalysisError::NotApplicable`] for a measurement without intervals.
pub fn lyapunov_spectrum<const T: usize, Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: &State<f64, N>,
    how: &Measurement,
) -> Result<Vec<Exponent>, AnalysisError> {
    let (before, count) = how.counts()?;
    let variational = Variational::<_, N>::new(system);
    let mut all = with_all_deviations::<N, T>(start);
    let mut growth = vec![Vec::with_capacity(count); 2 * N];
    for k in 0..before as usize + count {
        let run = integrate(&variational, Dop853, Pi::tolerance(how.tolerance), all);
        all = run.until(all.t + how.interval).finish().map_err(|failed| failed.failure)?;
        let (_, matrix) = taken_apart::<N, T>(&all);
        let factors = matrix.qr();
        let (directions, lengths) = (factors.q(), factors.r());
        for d in 0..2 * N {
            // The sign of a direction does not matter, its length does.
            if k >= before as usize {
                growth[d].push(lengths[(d, d)].abs().ln());
            }
            for i in 0..N {
                all.q[N * (1 + d) + i] = directions[(i, d)];
                all.qd[N * (1 + d) + i] = directions[(N + i, d)];
            }
        }
    }
    Ok(growth.iter().map(|growth| Exponent::of(growth, how.interval)).collect())
}

/// The largest Lyapunov exponent from two trajectories, the second brought back to the distance `separation` from the first
/// after each interval (Benettin, Galgani and Strelcyn, *Phys. Rev. A* 14, 1976). It needs the accelerations alone.
///
/// # Errors
/// Those of [`lyapunov_spectrum`].
pub fn lyapunov_by_two_trajectories<Sys: System<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: &State<f64, N>,
    separation: f64,
    how: &Measurement,
) -> Result<Exponent, AnalysisError> {
    let (before, count) = how.counts()?;
    if !(separation > 0.0 && separation.is_finite()) {
        return Err(AnalysisError::NotApplicable { needs: "a positive distance between the trajectories" });
    }
    let length = |d: &Tangent<f64, N>| (d.q.norm_squared() + d.qd.norm_squared()).sqrt();
    let even = separation / (2.0 * N as f64).sqrt();
    let all = SVector::<f64, N>::from_element(1.0);
    let (mut first, mut second) = (*start, start.moved(start.t, even, &Tangent { q: all, qd: all }));
    let mut growth = Vec::with_capacity(count);
    for k in 0..before as usize + count {
        let further = |from: State<f64, N>| {
            let run = integrate(system, Dop853, Pi::tolerance(how.tolerance), from);
            run.until(from.t + how.interval).finish().map_err(|failed| failed.failure)
        };
        (first, second) = (further(first)?, further(second)?);
        let apart = second.minus(&first);
        let ratio = length(&apart) / separation;
        if k >= before as usize {
            growth.push(ratio.ln());
        }
        second = first.moved(first.t, 1.0 / ratio, &apart);
    }
    Ok(Exponent::of(&growth, how.interval))
}
