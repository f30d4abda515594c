//! What is wanted of each trajectory in lanes.

use crate::state::State;
use crate::system::System;
use core::fmt;

/// What is made of a trajectory while it runs in a lane among others. Each has a memory of its own; the watch has to be a pure
/// function of what it is shown.
///
/// [`Last`] wants the last state, [`Sampled`] the states at given times, [`Fold`] the ends of all steps.
pub trait Watch<Sys: System<N, Scalar = f64>, const N: usize> {
    /// What is remembered of a trajectory.
    type Memory;
    /// What is made of it.
    type Output;

    /// Whether [`step`](Self::step) wants to be shown the steps.
    const STEPS: bool = false;

    /// The memory of a trajectory that begins at `start`.
    fn start(&self, system: &Sys, start: &State<f64, N>) -> Self::Memory;

    /// An accepted step.
    fn step(&self, memory: &mut Self::Memory, system: &Sys, from: &State<f64, N>, to: &State<f64, N>) {
        let _ = (memory, system, from, to);
    }

    /// The next time at which the state is wanted: the first of them, or the next one after that which was shown last.
    fn wanted(&self, memory: &Self::Memory) -> Option<f64> {
        let _ = memory;
        None
    }

    /// The state at the time that was wanted.
    fn sample(&self, memory: &mut Self::Memory, system: &Sys, at: &State<f64, N>) {
        let _ = (memory, system, at);
    }

    /// What is made of the whole.
    fn finish(&self, memory: Self::Memory, system: &Sys, end: &State<f64, N>) -> Self::Output;
}

/// A function of the system and the last state.
#[derive(Clone, Copy)]
pub struct Last<F>(pub F);

impl<Sys, O, F, const N: usize> Watch<Sys, N> for Last<F>
where
    Sys: System<N, Scalar = f64>,
    F: Fn(&Sys, &State<f64, N>) -> O,
{
    type Memory = ();
    type Output = O;

    fn start(&self, _: &Sys, _: &State<f64, N>) {}

    fn finish(&self, (): (), system: &Sys, end: &State<f64, N>) -> O {
        self.0(system, end)
    }
}

/// A function of the states at given times, which lie in the direction of the run, from its start to its end. States are
/// interpolated and do not influence the steps; the start, the end and the ends of steps are exact. At times that a run does not
/// come to there are none.
#[derive(Clone)]
pub struct Sampled<F> {
    times: Vec<f64>,
    function: F,
}

impl<F> Sampled<F> {
    /// A function of the states at these times.
    pub fn new(times: impl IntoIterator<Item = f64>, function: F) -> Self {
        Sampled { times: times.into_iter().collect(), function }
    }
}

impl<Sys, O, F, const N: usize> Watch<Sys, N> for Sampled<F>
where
    Sys: System<N, Scalar = f64>,
    F: Fn(&Sys, &[State<f64, N>]) -> O,
{
    type Memory = Vec<State<f64, N>>;
    type Output = O;

    fn start(&self, _: &Sys, _: &State<f64, N>) -> Self::Memory {
        Vec::with_capacity(self.times.len())
    }

    fn wanted(&self, states: &Self::Memory) -> Option<f64> {
        self.times.get(states.len()).copied()
    }

    fn sample(&self, states: &mut Self::Memory, _: &Sys, at: &State<f64, N>) {
        states.push(*at);
    }

    fn finish(&self, states: Self::Memory, system: &Sys, _: &State<f64, N>) -> O {
        (self.function)(system, &states)
    }
}

/// What is folded over the accepted steps: `start` makes the first value of the start, `step` changes it by the end of a step, and
/// `finish` makes the output of it. A maximum, say, or the time of the last turn.
#[derive(Clone, Copy)]
pub struct Fold<I, F, E> {
    /// The first value.
    pub start: I,
    /// Changes it by a step from one state to another.
    pub step: F,
    /// The output.
    pub finish: E,
}

impl<Sys, T, O, I, F, E, const N: usize> Watch<Sys, N> for Fold<I, F, E>
where
    Sys: System<N, Scalar = f64>,
    I: Fn(&Sys, &State<f64, N>) -> T,
    F: Fn(&mut T, &Sys, &State<f64, N>, &State<f64, N>),
    E: Fn(T, &Sys, &State<f64, N>) -> O,
{
    type Memory = T;
    type Output = O;
    const STEPS: bool = true;

    fn start(&self, system: &Sys, start: &State<f64, N>) -> T {
        (self.start)(system, start)
    }

    fn step(&self, value: &mut T, system: &Sys, from: &State<f64, N>, to: &State<f64, N>) {
        (self.step)(value, system, from, to);
    }

    fn finish(&self, value: T, system: &Sys, end: &State<f64, N>) -> O {
        (self.finish)(value, system, end)
    }
}

macro_rules! debug {
    ($($name:ident<$($parameter:ident),*>)*) => {$(
        impl<$($parameter),*> fmt::Debug for $name<$($parameter),*> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.debug_struct(stringify!($name)).finish_non_exhaustive()
            }
        }
    )*};
}

debug! { Last<F> Sampled<F> Fold<I, F, E> }
