//! Samples that failed.

use crate::failed::{Failed, Statistics};
use crate::failure::{Failure, debug_is_text};
use crate::state::State;
use std::fmt;

/// Reason why a sample has no output: what a function that watches a run returns. A [`Failed`] and a [`Failure`]
/// become one by `?`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lost<S, const N: usize> {
    /// The failure.
    pub failure: Failure<S>,
    /// The last good state, where it is known.
    pub last: Option<State<S, N>>,
    /// The cost of the run, where it is known.
    pub statistics: Option<Statistics>,
}

impl<S, const N: usize> From<Failed<S, N>> for Lost<S, N> {
    fn from(failed: Failed<S, N>) -> Self {
        Lost { failure: failed.failure, last: Some(failed.last), statistics: Some(failed.statistics) }
    }
}

impl<S, const N: usize> From<Failure<S>> for Lost<S, N> {
    fn from(failure: Failure<S>) -> Self {
        Lost { failure, last: None, statistics: None }
    }
}

/// A sample that failed.
#[derive(Clone, Copy, PartialEq)]
pub struct FailedSample<S, const N: usize> {
    /// Its index, by which it can be replayed.
    pub index: u64,
    /// The state at which it began.
    pub start: State<S, N>,
    /// The last good state, where it is known.
    pub last: Option<State<S, N>>,
    /// The cost of the run, where it is known.
    pub statistics: Option<Statistics>,
    /// The failure.
    pub failure: Failure<S>,
}

impl<S: fmt::Debug, const N: usize> fmt::Display for FailedSample<S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sample {}: {}", self.index, self.failure)
    }
}

debug_is_text! { [S: fmt::Debug, const N: usize] FailedSample<S, N> }

impl<S: fmt::Debug, const N: usize> std::error::Error for FailedSample<S, N> {}

/// The samples of a study that failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Failures<S, const N: usize> {
    /// Number of failed samples.
    pub count: u64,
    /// The failed samples with the lowest indices, as many as the study keeps.
    pub kept: Vec<FailedSample<S, N>>,
}
