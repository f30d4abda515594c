//! Steps through states at which constraints are dependent.

use crate::scalar::Real;
use crate::state::{State, constant};
use crate::system::{Jacobian, Lagrangian, System, lagrangian_functions, pass_on, pass_on_run};
use nalgebra::{SMatrix, SVector};

/// A system with constraints near states at which they are dependent, as a method sees it in a step: its
/// accelerations are those of [`System::accel_across`], and its Jacobian is that of these, by differences.
#[derive(Clone, Copy, Debug)]
pub struct Across<'a, Sys: System<N>, const N: usize> {
    pub(crate) system: &'a Sys,
    /// State that shows how long the gradients of constraints are elsewhere: that with which the run began.
    pub(crate) reference: State<Sys::Scalar, N>,
    /// Size of the step.
    pub(crate) h: Sys::Scalar,
    /// The motion is left after the step, so that what rounding makes of accelerations there has no effect on it.
    pub(crate) last: bool,
}

impl<Sys: System<N, Scalar: Real>, const N: usize> System<N> for Across<'_, Sys, N> {
    type Scalar = Sys::Scalar;

    pass_on_run! { system: Sys }

    fn accel(
        &self,
        q: &SVector<Sys::Scalar, N>,
        qd: &SVector<Sys::Scalar, N>,
        t: Sys::Scalar,
    ) -> SVector<Sys::Scalar, N> {
        self.system.accel_across(&self.reference, &State { t, q: *q, qd: *qd }, self.h, false)
    }
}

/// Steps of differences, relative to 1 and to the size of a coordinate: of fourth order, and short beside the
/// distances at which constraints are resolved.
const DIFFERENCE: f64 = 1e-4;

impl<S: Real, Sys: Lagrangian<N, Scalar = S>, const N: usize> Lagrangian<N> for Across<'_, Sys, N> {
    const FACTS: crate::facts::Facts = Sys::FACTS;

    lagrangian_functions! { pass_on! { system: } }

    fn jacobian(&self, q: &SVector<S, N>, qd: &SVector<S, N>, t: S) -> Jacobian<S, N> {
        let at = State { t, q: *q, qd: *qd };
        let slope = |step: f64, moved: &dyn Fn(S) -> State<S, N>| {
            let mut sum: SVector<S, N> = constant(S::zero());
            for (places, weight) in [(1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)] {
                for side in [-1.0, 1.0] {
                    let at = moved(S::from_f64(side * places * step));
                    let accel = self.system.accel_across(&self.reference, &at, self.h, true);
                    sum += accel * S::from_f64(side * weight / step);
                }
            }
            sum
        };
        let size = |x: S| DIFFERENCE * (1.0 + x.to_f64().abs());
        // (A direction that turns by more leads to another branch.)
        let turn = DIFFERENCE * qd.iter().map(|v| v.to_f64().abs()).fold(0.0, f64::max);
        let unit = |i: usize, x: S| SVector::<S, N>::from_fn(|j, _| if i == j { x } else { S::zero() });
        let mut jacobian = Jacobian {
            q: SMatrix::from_fn(|_, _| S::zero()),
            qd: SMatrix::from_fn(|_, _| S::zero()),
            t: slope(DIFFERENCE, &|dt| State { t: t + dt, ..at }),
        };
        for i in 0..N {
            let by_q = slope(size(q[i]), &|x| State { q: at.q + unit(i, x), ..at });
            let by_qd = slope(turn, &|x| State { qd: at.qd + unit(i, x), ..at });
            jacobian.q.set_column(i, &by_q);
            jacobian.qd.set_column(i, &by_qd);
        }
        jacobian
    }
}

/// [`Method::start_across`](super::Method::start_across) and the functions beside it, by the method's own over
/// [`Across`].
macro_rules! steps_across {
    () => {
        fn start_across(
            &self,
            across: &$crate::method::Across<'_, Sys, N>,
            at: &$crate::State<Sys::Scalar, N>,
        ) -> Result<Self::MethodState, $crate::Failure<Sys::Scalar>>
        where
            Sys::Scalar: $crate::Real,
        {
            $crate::method::Method::start(self, across, at)
        }

        fn step_across(
            &self,
            across: &$crate::method::Across<'_, Sys, N>,
            memory: &Self::MethodState,
            from: &$crate::State<Sys::Scalar, N>,
            h: Sys::Scalar,
            next: &mut Self::MethodState,
        ) -> Result<$crate::method::Step<Sys, Self, N>, $crate::Failure<Sys::Scalar>>
        where
            Sys::Scalar: $crate::Real,
        {
            let step = $crate::method::Method::step_into(self, across, memory, from, h, next)?;
            let $crate::method::Step { from, to, h, error, stages, evaluations } = step;
            Ok($crate::method::Step { from, to, h, error, stages, evaluations })
        }

        fn interpolant_across(
            &self,
            across: &$crate::method::Across<'_, Sys, N>,
            step: &$crate::method::Step<Sys, Self, N>,
        ) -> Self::Interpolant
        where
            Sys::Scalar: $crate::Real,
        {
            let $crate::method::Step { from, to, h, error, stages, evaluations } = step.clone();
            let step = $crate::method::Step { from, to, h, error, stages, evaluations };
            $crate::method::Method::interpolant(self, across, &step)
        }
    };
}

pub(crate) use steps_across;
