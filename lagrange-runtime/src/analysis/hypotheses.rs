//! Hypotheses that the compiler proves or refutes, and facts by which results are named.

use super::AnalysisError;
use crate::state::State;
use crate::system::Lagrangian;

/// The state that is some roundings away in all coordinates and velocities, as a state that an iteration finds may be.
pub(super) fn next<const N: usize>(at: &State<f64, N>) -> State<f64, N> {
    let factor = 1.0 + 4.0 * f64::EPSILON;
    State { q: at.q * factor, qd: at.qd * factor, ..*at }
}

/// Names of the coordinates of a system.
pub(super) fn coordinate_names<Sys: Lagrangian<N>, const N: usize>() -> Vec<String> {
    (0..N).map(|i| Sys::FACTS.coordinates.get(i).map_or(format!("q{i}"), |name| (*name).to_owned())).collect()
}

/// Refuses systems with states of first order, whose small motions have no M, C and K.
pub(super) fn second_order<Sys: Lagrangian<N>, const N: usize>() -> Result<(), AnalysisError> {
    match Sys::FIRST_ORDER > 0 {
        true => Err(AnalysisError::NotApplicable {
            needs: "a system without states of first order; `operating_point` and `StateSpace` know them",
        }),
        false => Ok(()),
    }
}

/// Refuses systems with constraints, and with states of first order.
pub(super) fn unconstrained<Sys: Lagrangian<N>, const N: usize>() -> Result<(), AnalysisError> {
    second_order::<Sys, N>()?;
    match Sys::FACTS.constraints.first() {
        Some(constraint) => Err(AnalysisError::DependentCoordinates { constraint: constraint.name }),
        None => Ok(()),
    }
}

/// Refuses a system of which the compiler did not prove that time does not appear in its equations of motion.
pub(super) const fn autonomous<Sys: Lagrangian<N>, const N: usize>() -> Result<(), AnalysisError> {
    match Sys::FACTS.autonomous {
        true => Ok(()),
        false => Err(AnalysisError::TimeDependent),
    }
}
