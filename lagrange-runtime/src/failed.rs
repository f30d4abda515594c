//! Cost of a run, and a run that did not reach its end.

use crate::failure::Failure;
use crate::state::State;
use core::fmt;

/// Cost of a run so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Statistics {
    /// Accepted steps.
    pub accepted: u64,
    /// Rejected or failed steps.
    pub rejected: u64,
    /// Evaluations of the equations of motion, those of interpolants included.
    pub evaluations: u64,
}

/// A run that did not reach its end: why, and how far it came.
#[derive(Clone, Copy, PartialEq)]
pub struct Failed<S, const N: usize> {
    /// Cause of the failure.
    pub failure: Failure<S>,
    /// The state at which the run began.
    pub start: State<S, N>,
    /// The last good state.
    pub last: State<S, N>,
    /// The cost so far.
    pub statistics: Statistics,
}

impl<S: fmt::Debug, const N: usize> fmt::Display for Failed<S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (the last good state is at t = {:?})", self.failure, self.last.t)
    }
}

/// Text that is printed if `main` returns the error.
impl<S: fmt::Debug, const N: usize> fmt::Debug for Failed<S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {self}", self.failure.name())
    }
}

impl<S: fmt::Debug, const N: usize> core::error::Error for Failed<S, N> {}

impl<S, const N: usize> From<Failed<S, N>> for Failure<S> {
    fn from(failed: Failed<S, N>) -> Self {
        failed.failure
    }
}
