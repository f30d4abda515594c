//! Periodic orbits and their Floquet multipliers.

use super::AnalysisError;
use super::balance::smallest_solution;
use super::eigen::eigenvalues;
use super::variational::{TangentFlow, fundamental_matrix};
use crate::attitude;
use crate::state::{State, Tangent};
use nalgebra::{Complex, DMatrix, DVector, SVector};

/// Period of a periodic orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Period {
    /// The period of the forces, or a multiple of it, in units of t.
    Given(f64),
    /// Unknown, about this, in units of t.
    About(f64),
}

/// A motion that returns to where it began.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicOrbit<const N: usize> {
    /// A state of it.
    pub start: State<f64, N>,
    /// Its period, in units of t.
    pub period: f64,
    /// Largest difference of a coordinate or velocity after one period, in its own unit.
    pub residual: f64,
    /// Monodromy matrix: the derivative of the state (q, q̇) after one period by its start, `2N × 2N`.
    pub monodromy: DMatrix<f64>,
    /// Floquet multipliers, the eigenvalues of the monodromy matrix, by magnitude: as many as there are deviations
    /// that constraints admit, without those of the time integrals of [states of first order](crate::traits::States),
    /// which need not return to their start either. Where time does not appear one of them is 1, and where energy is
    /// conserved two are; conservative systems have them in pairs μ, 1/μ.
    pub multipliers: Vec<Complex<f64>>,
}

impl<const N: usize> PeriodicOrbit<N> {
    /// Returns whether no multiplier has a magnitude above 1 by more than `tolerance`: a double multiplier 1 is
    /// uncertain by the root of the integration error.
    pub fn is_stable(&self, tolerance: f64) -> bool {
        self.multipliers.iter().all(|mu| mu.norm() <= 1.0 + tolerance)
    }
}

/// The periodic orbit near `guess`, by shooting: Newton's method on `Φ_τ(x) = x` with the monodromy matrix, the period
/// unknown or given. Where orbits form a family (of energies, of phases) the one nearest to the guess, in each step by
/// the smallest correction, is taken; what conserved quantities make singular is left out of the correction (Seydel,
/// *Practical Bifurcation and Stability Analysis*, 2010, 7.1–7.3). An orbit may miss its start by `tolerance` times
/// `1 +` the largest coordinate or velocity: give a tolerance not below that of the flow.
///
/// ```
/// use lagrange_runtime::analysis::{ByVariationalEquations, Period, periodic_orbit};
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::testing::reference::SimplePendulum;
///
/// lagrangian! {
///     system Pendulum {
///         param l, g = 9.81;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// let pendulum = Pendulum::new(0.5);
/// let guess = State::new(0.0, [1.0], [0.0]);
/// let flow = ByVariationalEquations::<_, 3>::new(&pendulum, 1e-13);
/// let orbit = periodic_orbit(&flow, &guess, Period::About(1.5), 1e-10)?;
/// let exact = SimplePendulum::new(9.81, 0.5, orbit.start.q[0], orbit.start.qd[0]).period();
/// assert!((orbit.period - exact).abs() < 1e-13 && (orbit.start.q[0] - 1.0).abs() < 0.01);
/// assert!(orbit.multipliers.iter().all(|mu| (mu.norm() - 1.0).abs() < 1e-5), "both are 1");
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
///
/// # Hypotheses
/// - The period is positive and finite: otherwise [`AnalysisError::NotApplicable`].
/// - With [`Period::About`] time does not appear in the equations of motion ([`TangentFlow::AUTONOMOUS`]): otherwise
///   [`AnalysisError::TimeDependent`].
/// - Where time does appear, [`Period::Given`] is a period of the forces, or a multiple of one. The motion through a
///   second period is compared with the first, state and monodromy matrix; where they differ,
///   [`AnalysisError::NotApplicable`]. Forces that change after two periods are not seen.
/// - Forces have derivatives along the orbit, or its flow has the saltation of their jumps, see [`TangentFlow`].
///
/// An equilibrium has every period: with [`Period::Given`] it is an orbit, whose multipliers are those of its small
/// motions.
///
/// # Errors
/// [`AnalysisError::NotConverged`] where none is found; [`AnalysisError::AtRest`] where, with [`Period::About`], only
/// an equilibrium is; [`AnalysisError::Run`].
pub fn periodic_orbit<Flow: TangentFlow<N>, const N: usize>(
    flow: &Flow,
    guess: &State<f64, N>,
    period: Period,
    tolerance: f64,
) -> Result<PeriodicOrbit<N>, AnalysisError> {
    let (duration, free) = match period {
        Period::Given(duration) => (duration, false),
        Period::About(duration) => (duration, true),
    };
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(AnalysisError::NotApplicable { needs: "a positive and finite period" });
    }
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(AnalysisError::NotApplicable { needs: "a positive and finite tolerance" });
    }
    if free && !Flow::AUTONOMOUS {
        return Err(AnalysisError::TimeDependent);
    }
    let shoot = |start: State<f64, N>, duration: f64| Shot::new(flow, start, duration);
    let speed = |at: &State<f64, N>| rate(flow, at).norm();
    let moving = speed(guess);
    let mut shot = shoot(*guess, duration)?;
    for _ in 0..50 {
        let mut better: Option<Shot<N>> = None;
        // Along a family of orbits the matrix is singular, but for what is still missed, and for integration errors.
        for cut in [shot.residual.min(0.1), 1e-7] {
            let (step, longer) = shot.step(flow, free, cut)?;
            let mut start = shot.start;
            start.q += SVector::<f64, N>::from_fn(|i, _| step[i]);
            start.qd += SVector::<f64, N>::from_fn(|i, _| step[N + i]);
            let duration = shot.duration + longer;
            if !(start.is_finite() && duration > 0.0 && duration.is_finite()) {
                continue;
            }
            // A trial that leaves the domain of the system is a bad one, and no failure.
            let Ok(next) = shoot(start, duration) else { continue };
            if better.as_ref().is_none_or(|best| next.residual < best.residual) {
                better = Some(next);
            }
            if better.as_ref().is_some_and(|best| best.residual < 0.5 * shot.residual) {
                break;
            }
        }
        match better {
            Some(next) if next.residual < shot.residual => shot = next,
            _ => break,
        }
    }
    // Rest repeats itself with any period, and is none.
    if free && speed(&shot.start) <= 1e-6 * moving {
        return Err(AnalysisError::AtRest);
    }
    if shot.residual > tolerance * shot.size() {
        return Err(AnalysisError::NotConverged { what: "a periodic orbit", residual: shot.residual });
    }
    if !Flow::AUTONOMOUS && !shot.repeats(flow, tolerance)? {
        return Err(AnalysisError::NotApplicable { needs: "a period of the forces, or a multiple of one" });
    }
    let multipliers = multipliers(shot.admitted(&shot.monodromy))?;
    let Shot { start, duration, residual, monodromy, .. } = shot;
    Ok(PeriodicOrbit { start, period: duration, residual, monodromy, multipliers })
}

/// `(q̇, q̈)`
fn rate<Flow: TangentFlow<N>, const N: usize>(flow: &Flow, at: &State<f64, N>) -> DVector<f64> {
    let a = flow.accel(at);
    DVector::from_fn(2 * N, |i, _| if i < N { at.qd[i] } else { a[i - N] })
}

/// A motion that should return to its start.
struct Shot<const N: usize> {
    start: State<f64, N>,
    duration: f64,
    end: State<f64, N>,
    monodromy: DMatrix<f64>,
    /// Basis of the deviations of the start that constraints admit, without integrals of states; none where these are
    /// all.
    basis: Option<DMatrix<f64>>,
    /// Distance between end and start.
    residual: f64,
}

impl<const N: usize> Shot<N> {
    fn new<Flow: TangentFlow<N>>(
        flow: &Flow,
        start: State<f64, N>,
        duration: f64,
    ) -> Result<Self, AnalysisError> {
        let (start, basis) = flow.admissible(&start)?;
        let basis = Some(basis).filter(|basis| basis.ncols() < 2 * N);
        let (mut end, mut monodromy) = fundamental_matrix(flow, &start, duration)?;
        // Both ends by the same of the parameters that an attitude has.
        let attitudes: Vec<usize> = attitude::steps::astray(Flow::ATTITUDES, &end, &start).collect();
        if !attitudes.is_empty() {
            for mut column in monodromy.column_iter_mut() {
                let deviation = State {
                    t: end.t,
                    q: SVector::from_fn(|i, _| column[i]),
                    qd: SVector::from_fn(|i, _| column[N + i]),
                };
                let turned = attitude::steps::turned_deviation(attitudes.iter().copied(), &end, &deviation);
                for i in 0..N {
                    (column[i], column[N + i]) = (turned.q[i], turned.qd[i]);
                }
            }
            end = end.turned(attitudes.into_iter());
        }
        let missed = missed::<Flow, N>(&end, &start);
        let residual = missed.q.amax().max(missed.qd.amax());
        Ok(Shot { start, duration, end, monodromy, basis, residual })
    }

    /// Is a second period like the first?
    fn repeats<Flow: TangentFlow<N>>(&self, flow: &Flow, tolerance: f64) -> Result<bool, AnalysisError> {
        let start = State { t: self.start.t + self.duration, ..self.start };
        let second = Shot::new(flow, start, self.duration)?;
        let apart = (&second.monodromy - &self.monodromy).amax();
        // The matrix is a derivative, and has fewer digits than the state.
        let alike = apart <= tolerance.sqrt() * self.monodromy.amax();
        Ok(alike && second.residual <= 2.0 * tolerance * self.size())
    }

    /// A linear map of deviations, in the basis of those that are admitted.
    fn admitted(&self, map: &DMatrix<f64>) -> DMatrix<f64> {
        self.basis.as_ref().map_or_else(|| map.clone(), |basis| basis.transpose() * map * basis)
    }

    fn size(&self) -> f64 {
        1.0 + self.start.q.amax().max(self.start.qd.amax())
    }

    /// `(M − 1) δx + ẋ(τ) δτ = −missed`, and for a free period δx orthogonal to the motion, which only shifts the
    /// phase: the smallest solution, singular values below `cut` of M left out.
    fn step<Flow: TangentFlow<N>>(
        &self,
        flow: &Flow,
        free: bool,
        cut: f64,
    ) -> Result<(DVector<f64>, f64), AnalysisError> {
        let across =
            |x: DVector<f64>| self.basis.as_ref().map_or_else(|| x.clone(), |basis| basis.tr_mul(&x));
        let missed = missed::<Flow, N>(&self.end, &self.start);
        let missed =
            across(DVector::from_fn(2 * N, |i, _| if i < N { missed.q[i] } else { missed.qd[i - N] }));
        let n = missed.len();
        let unknowns = n + usize::from(free);
        let mut matrix = DMatrix::zeros(unknowns, unknowns);
        let change = &self.monodromy - DMatrix::identity(2 * N, 2 * N);
        matrix.view_mut((0, 0), (n, n)).copy_from(&self.admitted(&change));
        let mut right = DVector::zeros(unknowns);
        right.rows_mut(0, n).copy_from(&-missed);
        if free {
            matrix.view_mut((0, n), (n, 1)).copy_from(&across(rate(flow, &self.end)));
            matrix.view_mut((n, 0), (1, n)).copy_from(&across(rate(flow, &self.start)).transpose());
        }
        let step = smallest_solution(matrix, &right, cut * self.monodromy.amax().max(1.0))?;
        let (shift, longer) = (step.rows(0, n).into_owned(), if free { step[n] } else { 0.0 });
        Ok((self.basis.as_ref().map_or_else(|| shift.clone(), |basis| basis * &shift), longer))
    }
}

/// Distance of an end from its start; the time integrals of states need not return.
fn missed<Flow: TangentFlow<N>, const N: usize>(
    end: &State<f64, N>,
    start: &State<f64, N>,
) -> Tangent<f64, N> {
    let mut missed = end.minus(start);
    (N - Flow::FIRST_ORDER..N).for_each(|i| missed.q[i] = 0.0);
    missed
}

fn multipliers(monodromy: DMatrix<f64>) -> Result<Vec<Complex<f64>>, AnalysisError> {
    let mut all = eigenvalues(monodromy, "the Floquet multipliers")?;
    all.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(a.im.total_cmp(&b.im)));
    Ok(all)
}
