//! Iterations over several lanes, each of which converges on its own.
//!
//! A lane that has converged stays unchanged until all have. So it has the same bits as alone, and the iteration takes
//! as long as the slowest lane. Each lane fails on its own and becomes NaN; the iteration fails once all lanes have. A
//! run of one lane alone reports the cause.

use crate::scalar::{Scalar, SimdScalar};
use crate::state::State;
use nalgebra::SVector;

/// Progress of an iteration in one lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// It has not converged.
    On,
    /// It has.
    Done,
    /// It never will.
    Failed,
}

/// Masks of the lanes in which an iteration continues, and in which it has failed.
pub(crate) struct Iteration<S: SimdScalar> {
    on: S::PerLane<bool>,
    failed: S::PerLane<bool>,
}

impl<S: SimdScalar> Iteration<S> {
    /// An iteration that continues in all lanes.
    #[inline(always)]
    pub fn new() -> Self {
        Iteration { on: S::each(|_| true), failed: S::each(|_| false) }
    }

    /// Mask of the lanes in which it continues.
    #[inline(always)]
    pub fn on(&self) -> &S::PerLane<bool> {
        &self.on
    }

    /// Returns whether it continues in any lane.
    #[inline(always)]
    pub fn goes_on(&self) -> bool {
        self.on.as_ref().contains(&true)
    }

    /// Updates each lane in which it continues.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn decide(&mut self, mut progress: impl FnMut(usize) -> Progress) {
        let (on, failed) = (self.on.as_mut(), self.failed.as_mut());
        for i in 0..on.len() {
            if on[i] {
                let progress = progress(i);
                (on[i], failed[i]) = (progress == Progress::On, progress == Progress::Failed);
            }
        }
    }

    /// Ends the iteration: it has failed in the lanes in which it continued.
    #[inline(always)]
    pub fn give_up(&mut self) {
        self.decide(|_| Progress::Failed);
    }

    /// Has it failed in every lane?
    #[inline(always)]
    pub fn failed(&self) -> bool {
        !self.failed.as_ref().contains(&false)
    }

    /// `x`, NaN where the iteration has failed.
    #[inline(always)]
    pub fn result<const N: usize>(&self, x: &SVector<S, N>) -> SVector<S, N> {
        if self.failed.as_ref().contains(&true) { x.map(|x| S::chosen(&self.failed, nan(), x)) } else { *x }
    }
}

/// Not a number.
#[inline(always)]
pub(crate) fn nan<S: Scalar>() -> S {
    S::from_f64(f64::NAN)
}

/// The numbers of `yes` at those places, and of `no` at the others.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn chosen<S: SimdScalar, const N: usize>(
    places: &S::PerLane<bool>,
    yes: &SVector<S, N>,
    no: &SVector<S, N>,
) -> SVector<S, N> {
    let mut x = *no;
    for i in 0..N {
        x[i] = S::chosen(places, yes[i], no[i]);
    }
    x
}

/// Returns whether a state is finite: of lanes, in one of them at least.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn some_finite<S: SimdScalar, const N: usize>(state: &State<S, N>) -> bool {
    // As in `State::is_finite`.
    let mut total = S::zero();
    for i in 0..N {
        total += state.q[i] + state.qd[i];
    }
    let mut some = false;
    for total in total.apart().as_ref() {
        some |= *total * S::Element::zero() == S::Element::zero();
    }
    some
}
