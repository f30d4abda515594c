//! Rest of systems with states of first order.

use super::balance::{balanced, smallest_solution};
use super::hypotheses::autonomous;
use super::state_space::accelerations;
use super::switch::smooth;
use super::{AnalysisError, StateSpace};
use crate::failure::Coordinate;
use crate::state::State;
use crate::system::Lagrangian;
use nalgebra::{Complex, DMatrix, DVector};

/// A state at which a system with [states of first order](crate::traits::States) stays: coordinates at rest, and
/// states whose rates are 0.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint<const N: usize> {
    /// The state, at t = 0: its states of first order are the last elements of `qd`, whose others are 0.
    pub state: State<f64, N>,
    /// Largest acceleration, or rate of a state, that is left by rounding, in its own unit.
    pub residual: f64,
    /// Poles of the small motions about it, in 1/s, see [`StateSpace::poles`]. All small motions decay if every real
    /// part is negative, and the point is then stable (Lyapunov's first approximation); it is unstable if one is
    /// positive.
    pub poles: Vec<Complex<f64>>,
}

/// Newton's method ends at corrections of this size, relative to `1 + |x|`, which are rounding errors.
const CONVERGED: f64 = 1e-13;
const ROUNDING: f64 = 1e-8;
const MOST_ITERATIONS: usize = 100;
const MOST_HALVINGS: usize = 30;

/// The operating point that Newton's method with the exact Jacobian reaches from `guess`: coordinates at rest and
/// states of first order, with the inputs as they are. Of the guess, coordinates and states count, and neither
/// velocities nor the integrals of states.
///
/// Corrections are halved until the residual falls; where the Jacobian is singular the smallest correction is taken.
/// A system without states has its [`equilibrium`](super::equilibrium) in this way too, without M, C and K.
///
/// ```
/// use lagrange_runtime::analysis::operating_point;
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     /// A weight that hangs on an electromagnet, whose current an amplifier with a time constant makes.
///     system Magnet {
///         param m, c, lag, g = 9.81;
///         input command = 2.0;
///         coord gap: length;
///         state i;
///         T = 0.5 * m * dot(gap).powi(2);
///         V = -m * g * gap - c * i.powi(2) / gap;
///         rate(i) = (command - i) / lag;
///     }
/// }
/// let magnet = Magnet::new(0.5, 1e-3, 0.01);
/// let guess = magnet.start(0.0, [0.02], [0.0]);
/// let point = operating_point(&magnet, &guess)?;
/// // The pull c i²/x² balances the weight, and the point is unstable: λ² = 2 g/x.
/// let gap = 2.0 * (1e-3 / (0.5 * 9.81f64)).sqrt();
/// assert!((point.state.q[0] - gap).abs() < 1e-15 && (magnet.states(&point.state)[0] - 2.0).abs() < 1e-15);
/// let fast = (2.0 * 9.81 / gap).sqrt();
/// assert!((point.poles[2].re - fast).abs() < 1e-10 && (point.poles[0].re + 100.0).abs() < 1e-10);
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
///
/// # Hypotheses
/// - Time does not appear in the equations of motion ([`Facts::autonomous`](crate::Facts::autonomous)), and there are
///   no constraints.
/// - The point is not on a switch of the forces or rates, or a kink of a function with data, at which these or their
///   derivatives jump.
///
/// # Errors
/// [`AnalysisError::TimeDependent`], [`AnalysisError::DependentCoordinates`], [`AnalysisError::NotConverged`],
/// [`AnalysisError::NotFinite`]; [`AnalysisError::Switch`], [`AnalysisError::Kink`]; [`AnalysisError::Unbalanced`],
/// with an acceleration for the force, where nothing holds the system, and [`AnalysisError::Running`] of a state.
pub fn operating_point<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    guess: &State<f64, N>,
) -> Result<OperatingPoint<N>, AnalysisError> {
    autonomous::<Sys, N>()?;
    if let Some(constraint) = Sys::FACTS.constraints.first() {
        return Err(AnalysisError::DependentCoordinates { constraint: constraint.name });
    }
    let mechanical = N - Sys::FIRST_ORDER;
    let state = |x: &DVector<f64>| {
        let mut at = State::new(0.0, [0.0; N], [0.0; N]);
        (0..mechanical).for_each(|i| at.q[i] = x[i]);
        (mechanical..N).for_each(|i| at.qd[i] = x[i]);
        at
    };
    let derivatives = |at: &State<f64, N>| {
        let by = system.jacobian(&at.q, &at.qd, at.t);
        DMatrix::from_fn(N, N, |i, j| if j < mechanical { by.q[(i, j)] } else { by.qd[(i, j)] })
    };
    let rates = |x: &DVector<f64>| {
        let at = state(x);
        DVector::from_column_slice(system.accel(&at.q, &at.qd, at.t).as_slice())
    };
    let mut x = DVector::from_fn(N, |i, _| if i < mechanical { guess.q[i] } else { guess.qd[i] });
    let mut left = rates(&x);
    for _ in 0..MOST_ITERATIONS {
        let at = state(&x);
        let correction = smallest_solution(derivatives(&at), &-&left, 0.0)?;
        let mut part = 1.0;
        let mut next = (&x + &correction, rates(&(&x + &correction)));
        // (Not less than NaN either.)
        for _ in 0..MOST_HALVINGS {
            if next.1.norm() < left.norm() {
                break;
            }
            part *= 0.5;
            let shorter = &x + &correction * part;
            next = (shorter.clone(), rates(&shorter));
        }
        let size = (0..N).map(|i| correction[i].abs() / (1.0 + x[i].abs())).fold(0.0, f64::max);
        let better = next.1.norm() < left.norm();
        if better {
            (x, left) = next;
        }
        // Where the residual falls no more, a small correction is rounding.
        if size <= if better { CONVERGED } else { ROUNDING } || left.amax() == 0.0 {
            let state = state(&x);
            smooth(system, &state, size, accelerations)?;
            balanced(&left, &derivatives(&state), &x, &|x| Ok(rates(x))).map_err(|error| match error {
                AnalysisError::Unbalanced { force, coordinate: Coordinate { index, .. } } => {
                    let coordinate = Coordinate::of::<Sys, N>(index);
                    match index < mechanical {
                        true => AnalysisError::Unbalanced { force, coordinate },
                        false => AnalysisError::Running { state: coordinate.name, rate: force },
                    }
                }
                other => other,
            })?;
            let poles = StateSpace::regular(system, &state)?.poles()?;
            return Ok(OperatingPoint { state, residual: left.amax(), poles });
        }
        if !better {
            break;
        }
    }
    Err(AnalysisError::NotConverged { what: "an operating point", residual: left.amax() })
}
