//! Systems in lanes.

use super::processor::Work;
use crate::prepared::Precompute;
use crate::scalar::Scalar;
use crate::system::System;
use nalgebra::SVector;

/// A system that can be had over any other scalar: over [`Lanes`](super::Lanes), one for each sample of an ensemble.
/// Those made by `lagrangian!` can.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is a system over one kind of number only, and lanes need it over another",
    note = "systems made by `lagrangian! {{ … }}` can be had over any scalar; or implement `lanes::Rescale` for `{Self}`"
)]
pub trait Rescale<const N: usize>: System<N> {
    /// The system over `R`.
    type Over<R: Scalar>: System<N, Scalar = R>;

    /// The system with each parameter through `f`, always in the same order.
    fn over<R: Scalar>(&self, f: impl FnMut(Self::Scalar) -> R) -> Self::Over<R>;

    /// Gives a lane of `packed` the data of functions that this system has, see
    /// [`ExternFunction`](crate::traits::ExternFunction).
    fn set_lane<R: Scalar>(&self, packed: &mut Self::Over<R>, lane: usize) {
        let _ = (packed, lane);
    }
}

/// One evaluation of the accelerations of a system.
#[derive(Debug)]
pub struct Accelerations<'a, Sys: Precompute<N>, const N: usize> {
    /// The system.
    pub system: &'a Sys,
    /// The constants that follow from its parameters alone.
    pub constants: &'a Sys::Constants,
    /// Coordinates.
    pub q: &'a SVector<Sys::Scalar, N>,
    /// Velocities.
    pub qd: &'a SVector<Sys::Scalar, N>,
    /// Time.
    pub t: Sys::Scalar,
}

impl<Sys: Precompute<N>, const N: usize> Work for Accelerations<'_, Sys, N> {
    type Output = SVector<Sys::Scalar, N>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.system.accel_inlined(self.constants, self.q, self.qd, self.t)
    }
}
