//! Systems whose parameters are settled: what follows from these alone is computed once, and not at each evaluation.

use crate::choice::RecommendedMethods;
use crate::constraint::{Constrained, Prescribed};
use crate::controller::{Controller, ErrorEstimate};
use crate::event::CompiledEvents;
use crate::facts::{CommonSymmetry, Symmetry};
use crate::input::{InputJacobian, Inputs};
use crate::method::Method;
use crate::routhian::Routhian;
use crate::scalar::Scalar;
use crate::series::{Analytic, TaylorSeries};
use crate::state::State;
use crate::states::States;
use crate::system::{
    Autonomous, Conservative, ConstantInertia, Energies, Facts, Independent, Jacobian, Lagrangian,
    LegendreTransform, Linear, Linearization, Linearize, Separable, System, lagrangian_functions, pass_on,
    pass_on_run,
};
use core::fmt::Debug;
use core::ops::Deref;
use nalgebra::{SMatrix, SVector};

/// A system whose accelerations use numbers that follow from its parameters alone (`1/m`, `l²`, …). Emitted for every
/// `lagrangian!` system.
#[diagnostic::on_unimplemented(
    message = "nothing of `{Self}` can be computed beforehand",
    note = "systems made by `lagrangian! {{ … }}` tell what follows from their parameters alone"
)]
pub trait Precompute<const N: usize>: System<N> + Sized {
    /// The numbers that follow from the parameters alone.
    type Constants: Copy + Debug + PartialEq;

    /// The numbers that follow from the parameters as they are now.
    fn constants(&self) -> Self::Constants;

    /// [`accel`](System::accel) by constants that were computed before, in the same units. With constants of other
    /// parameters the result is wrong; [`precomputed`](Self::precomputed) sees to it that they belong together.
    fn accel_with(
        &self,
        constants: &Self::Constants,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N>;

    /// [`accel_with`](Self::accel_with), compiled into its caller: emitted systems have their equations here.
    #[doc(hidden)]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn accel_inlined(
        &self,
        constants: &Self::Constants,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N> {
        self.accel_with(constants, q, qd, t)
    }

    /// The system with these numbers beside it, for many evaluations: the same results, bit for bit, from less work.
    /// Its parameters can be read, and no longer be changed.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     system Pendulum {
    ///         param m, l, g = 9.81;
    ///         coord theta: angle;
    ///         T = 0.5 * m * (l * dot(theta)).powi(2);
    ///         V = -m * g * l * cos(theta);
    ///     }
    /// }
    /// let pendulum = Pendulum::new(2.0, 0.5).precomputed(); // g/l, once
    /// let start = State::new(0.0, [1.0], [0.0]);
    /// let end = integrate(&pendulum, Dop853, PiController::tolerance(1e-10), start).until(10.0).final_state()?;
    /// assert!((pendulum.energy_at(&end) - pendulum.energy_at(&start)).abs() < 1e-8);
    /// assert_eq!(pendulum.l, 0.5);
    /// # Ok::<(), Failure>(())
    /// ```
    ///
    /// ```compile_fail,E0594
    /// # use lagrange_runtime::prelude::*;
    /// # lagrangian! {
    /// #     system Pendulum {
    /// #         param l;
    /// #         coord theta: angle;
    /// #         T = 0.5 * (l * dot(theta)).powi(2);
    /// #         V = -9.81 * l * cos(theta);
    /// #     }
    /// # }
    /// let mut pendulum = Pendulum::new(0.5).precomputed();
    /// pendulum.l = 0.7;
    /// ```
    #[inline]
    fn precomputed(self) -> Precomputed<Self, N> {
        Precomputed { constants: self.constants(), system: self }
    }
}

/// A system and what follows from its parameters, see [`Precompute::precomputed`]. It is the system in every other
/// respect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precomputed<Sys: Precompute<N>, const N: usize> {
    system: Sys,
    constants: Sys::Constants,
}

impl<Sys: Precompute<N>, const N: usize> Precomputed<Sys, N> {
    /// The system alone, whose parameters can be changed.
    #[inline]
    pub fn into_inner(self) -> Sys {
        self.system
    }

    /// Changes the system, and computes what follows from its parameters anew.
    pub fn update<R>(&mut self, change: impl FnOnce(&mut Sys) -> R) -> R {
        let result = change(&mut self.system);
        self.constants = self.system.constants();
        result
    }
}

impl<Sys: Precompute<N>, const N: usize> Deref for Precomputed<Sys, N> {
    type Target = Sys;

    #[inline]
    fn deref(&self) -> &Sys {
        &self.system
    }
}

impl<Sys: Precompute<N>, const N: usize> System<N> for Precomputed<Sys, N> {
    type Scalar = Sys::Scalar;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn accel(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N> {
        self.system.accel_with(&self.constants, q, qd, t)
    }

    pass_on_run! { system: Sys }
}

/// Traits of a system behind `system`: functions of (q, q̇, t), and others as they are given.
macro_rules! delegated {
    ($($trait:ident<N $(, $size:ident)*> { $($name:ident -> $result:ty;)* $(= $($item:item)*)? })*) => {$(
        #[diagnostic::do_not_recommend]
        impl<S: Scalar, Sys, const N: usize $(, const $size: usize)*> $trait<N $(, $size)*> for Precomputed<Sys, N>
        where
            Sys: Precompute<N, Scalar = S> + $trait<N $(, $size)*>,
        {
            pass_on! { system: $($name -> $result;)* }
            $($($item)*)?
        }
    )*};
}

delegated! {
    Lagrangian<N> {
        = lagrangian_functions! { pass_on! { system: jacobian -> Jacobian<S, N>; } }
        const FACTS: Facts = Sys::FACTS;
        const SYMMETRIES: &'static [Symmetry] = Sys::SYMMETRIES;
        const COMMON_SYMMETRIES: &'static [CommonSymmetry] = Sys::COMMON_SYMMETRIES;
    }
    Energies<N> {
        kinetic -> S;
        = #[inline(always)]
        fn potential(&self, q: &SVector<S, N>, t: S) -> S {
            self.system.potential(q, t)
        }
    }
    LegendreTransform<N> { velocities -> SVector<S, N>; }
    Independent<N> {}
    Separable<N> {}
    ConstantInertia<N> {}
    Conservative<N> {}
    Linear<N> {}
    Autonomous<N> {}
    Linearize<N> { linearize -> Linearization<S, N>; }
    Inputs<N, K> {
        = const INPUTS: [&'static str; K] = Sys::INPUTS;
        fn inputs(&self) -> SVector<S, K> {
            self.system.inputs()
        }
        fn set_inputs(&mut self, inputs: &SVector<S, K>) {
            self.system.set_inputs(inputs);
        }
    }
    States<N, M, K> {
        = const STATES: [&'static str; K] = Sys::STATES;
        fn initial_states(&self) -> SVector<S, K> {
            self.system.initial_states()
        }
    }
    InputJacobian<N, K> { input_jacobian -> SMatrix<S, N, K>; }
    Analytic<N> {
        = type Sides = Sys::Sides;
        const ROOTS: bool = <Sys as Analytic<N>>::ROOTS;
        const LONG: bool = <Sys as Analytic<N>>::LONG;
        #[inline(always)]
        fn switching(&self, at: &State<S, N>, sides: &Sys::Sides) -> Sys::Sides {
            self.system.switching(at, sides)
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn series_within<const K: usize>(
            &self,
            at: &State<S, N>,
            order: usize,
            sides: &Sys::Sides,
            motion: &mut TaylorSeries<S, N, K>,
        ) -> [Sys::Sides; K] {
            self.system.series_within(at, order, sides, motion)
        }
    }
    Constrained<N, M> {
        constraint_rates -> SVector<S, M>;
        multipliers -> SVector<S, M>;
        = #[inline(always)]
        fn constraints(&self, q: &SVector<S, N>, t: S) -> SVector<S, M> {
            self.system.constraints(q, t)
        }
        #[inline(always)]
        fn constraint_jacobian(&self, q: &SVector<S, N>, t: S) -> SMatrix<S, M, N> {
            self.system.constraint_jacobian(q, t)
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn response(
            &self,
            q: &SVector<S, N>,
            qd: &SVector<S, N>,
            t: S,
            impulse: &SVector<S, N>,
            rates: &SVector<S, M>,
        ) -> (SVector<S, N>, SVector<S, M>) {
            self.system.response(q, qd, t, impulse, rates)
        }
    }
    CompiledEvents<N> {
        = type Of = Sys::Of;
        #[inline(always)]
        fn event_value(&self, event: usize, at: &State<S, N>) -> S {
            self.system.event_value(event, at)
        }
        #[inline(always)]
        fn event_rates(
            &self,
            event: usize,
            at: &State<S, N>,
            accelerations: &SVector<S, N>,
        ) -> [Option<S>; 2] {
            self.system.event_rates(event, at, accelerations)
        }
    }
    Prescribed<N, P> { reactions -> SVector<S, P>; }
    Routhian<N, I, WHOLE> {
        ignorable_velocities -> SVector<S, I>;
        = #[inline(always)]
        fn expand(&self, state: &State<S, N>, ignorable: &SVector<S, I>) -> State<S, WHOLE> {
            self.system.expand(state, ignorable)
        }
    }
}

/// Methods for the system, of which rustc checks that they fit the prepared one.
#[diagnostic::do_not_recommend]
impl<Sys: Precompute<N> + RecommendedMethods<N>, const N: usize> RecommendedMethods<N> for Precomputed<Sys, N>
where
    Sys::Accurate: Method<Self, N, Error: ErrorEstimate<Sys::Scalar, N>>,
    Sys::Fine: Method<Self, N>,
    Sys::FineControl: Controller<Sys::Scalar, N, <Sys::Fine as Method<Self, N>>::Error>,
    Sys::Geometric: Method<Self, N>,
{
    type Accurate = Sys::Accurate;
    type Fine = Sys::Fine;
    type FineControl = Sys::FineControl;
    type Geometric = Sys::Geometric;
}

#[cfg(feature = "serde")]
impl<Sys: Precompute<N> + serde::Serialize, const N: usize> serde::Serialize for Precomputed<Sys, N> {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(to)
    }
}

#[cfg(feature = "serde")]
impl<'de, Sys: Precompute<N> + serde::Deserialize<'de>, const N: usize> serde::Deserialize<'de>
    for Precomputed<Sys, N>
{
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Sys::deserialize(from).map(Precompute::precomputed)
    }
}
