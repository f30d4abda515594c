//! Runs that are to be made in lanes, and what lanes are of.

use crate::failed::{Failed, Statistics};
use crate::lanes::{Lanes, Rescale, SingleLane};
use crate::method::Method;
use crate::state::State;

/// Lanes of a pack. Measured: with 16 values do not stay in registers, and with 4 half of a long register is idle.
pub const LANES: usize = 8;

/// A run that is to be made.
pub struct Job<Sys, const N: usize> {
    /// Index that tells it from others.
    pub index: u64,
    /// The system.
    pub system: Sys,
    /// State at which it begins.
    pub start: State<f64, N>,
}

/// End of runs, and the number of attempted steps in which each has to reach it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The time at which runs end.
    pub end: f64,
    /// Limit on the number of steps, see [`Run::max_steps`](crate::Run::max_steps).
    pub max_steps: Option<u64>,
}

/// Source of runs, and sink of their outputs.
pub trait Jobs<Sys, O, const N: usize> {
    /// The next run.
    fn next(&mut self) -> Option<Job<Sys, N>>;

    /// Receives the output of one, and its cost.
    fn done(&mut self, index: u64, cost: Statistics, output: Result<O, Failed<f64, N>>);
}

/// The system over lanes, and over one of them.
pub type Packed<Sys, P, A, const N: usize> = <Sys as Rescale<N>>::Over<Lanes<LANES, P, A>>;
pub type Alone<Sys, P, A, const N: usize> = <Sys as Rescale<N>>::Over<SingleLane<P, A>>;

/// Method state and error estimate of a method over lanes.
pub type MemoryOf<M, Sys, P, A, const N: usize> = <M as Method<Packed<Sys, P, A, N>, N>>::MethodState;
pub type ErrorOf<M, Sys, P, A, const N: usize> = <M as Method<Packed<Sys, P, A, N>, N>>::Error;
