//! Iterations over several numbers at once, each of which converges in its own time.
//!
//! A number that is done waits, unchanged, for the others. So it has the same bits as alone, and lanes are as fast as
//! the slowest of them. What fails does so for each number apart: an iteration has failed once it has for all of
//! them, and where it has not, numbers for which it has become NaN. (Of a single number that says: it fails.) Why it
//! has, a run of that number alone tells.

use crate::scalar::{Scalar, SimdScalar};
use crate::state::State;
use nalgebra::SVector;

/// Progress of an iteration for one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// It has not converged.
    On,
    /// It has.
    Done,
    /// It never will.
    Failed,
}

/// Masks of the numbers for which an iteration goes on, and for which it has failed.
pub(crate) struct Iteration<S: SimdScalar> {
    on: S::PerLane<bool>,
    failed: S::PerLane<bool>,
}

impl<S: SimdScalar> Iteration<S> {
    /// It goes on for all.
    #[inline(always)]
    pub fn new() -> Self {
        Iteration { on: S::each(|_| true), failed: S::each(|_| false) }
    }

    /// Mask of the numbers for which it goes on.
    #[inline(always)]
    pub fn on(&self) -> &S::PerLane<bool> {
        &self.on
    }

    /// Returns whether it goes on for any number.
    #[inline(always)]
    pub fn goes_on(&self) -> bool {
        self.on.as_ref().contains(&true)
    }

    /// Decides for each number for which it goes on.
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

    /// Ends it: where it goes on it has failed.
    #[inline(always)]
    pub fn give_up(&mut self) {
        self.decide(|_| Progress::Failed);
    }

    /// Has it failed for every number?
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
