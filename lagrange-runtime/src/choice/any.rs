//! A method and a controller that are chosen while the program runs: enums over those of this crate, without a box.
//!
//! The type system lets [`BlanesMoan4`] have separable systems only, and the Gauss methods those with
//! velocities from momenta. Here the facts that the compiler proved stand in for the traits: a method starts only on a system that has
//! those it needs, and fails with [`Failure::Unsuitable`] on others. Whoever names a method keeps the check by the compiler, and gets
//! velocities as emitted code, where these enums solve with the inertia matrix.

use crate::controller::{
    Controller, ErrorEstimate, FirstStep, Fixed, NoEstimate, Pi, SquareNorm, TwoEstimates, Verdict,
};
use crate::failure::{Failure, Requirement};
use crate::linear::factored;
use crate::method::explicit_rk::{Dop853, DormandPrince5, Verner9};
use crate::method::gauss::Gauss4;
use crate::method::modal::Modal;
use crate::method::nystrom::Nystrom12;
use crate::method::radau::{Radau5, RadauEstimate};
use crate::method::rosenbrock::Rodas5P;
use crate::method::splitting::BlanesMoan4;
use crate::method::taylor::{self, Decay, Polynomial, Remainder, USUAL_ROOM};
use crate::method::{Dense, Method, Step};
use crate::scalar::{Real, Scalar};
use crate::series::{Analytic, Series, Smooth};
use crate::state::{State, Tangent};
use crate::system::{
    Autonomous, Facts, Independent, Jacobian, Lagrangian, Legendre, Linear, Separable, System,
    lagrangian_functions, pass_on, pass_on_run, pass_on_series,
};
use core::marker::PhantomData;
use nalgebra::{SMatrix, SVector};

/// A Lagrangian system whose facts meet the requirements of the method that it is given to, see [`AnyMethod::missing`].
struct Proven<'a, Sys>(&'a Sys);

/// A system of which only the numbers are known: it names the types of a method that depend on nothing else.
#[derive(Clone, Debug)]
pub struct Shape<S, const N: usize>(Never, PhantomData<S>);

#[derive(Clone, Debug)]
enum Never {}

/// Functions of (q, q̇, t) of a system that there never is.
macro_rules! never {
    ($($name:ident -> $result:ty;)*) => {$(
        fn $name(&self, _: &SVector<S, N>, _: &SVector<S, N>, _: S) -> $result {
            match self.0 {}
        }
    )*};
}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> System<N> for Proven<'_, Sys> {
    type Scalar = S;
    pass_on! { 0: accel -> SVector<S, N>; }

    pass_on_run! { 0: Sys }
}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> Lagrangian<N> for Proven<'_, Sys> {
    const FACTS: Facts = Sys::FACTS;
    lagrangian_functions! { pass_on! { 0: } }

    pass_on_series! { 0 }
}

/// [`crate::Taylor`] of order 20, of a system that may or may not have series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taylor;

const SERIES: crate::Taylor = crate::Taylor::LONGEST_USUAL;

/// A system that was seen to have series.
struct Expanded<'a, Sys>(&'a Sys);

impl<S: Scalar, Sys: System<N, Scalar = S>, const N: usize> System<N> for Expanded<'_, Sys> {
    type Scalar = S;
    pass_on! { 0: accel -> SVector<S, N>; }
}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> Analytic<N> for Expanded<'_, Sys> {
    type Sides = Smooth;
    const ROOTS: bool = <Sys as Lagrangian<N>>::ROOTS;

    fn switching(&self, _: &State<S, N>, _: &Smooth) -> Smooth {
        Smooth
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn series_within<const K: usize>(
        &self,
        at: &State<S, N>,
        order: usize,
        _: &Smooth,
        motion: &mut Series<S, N, K>,
    ) -> [Smooth; K] {
        if !self.0.motion_series(at, order, motion) {
            // Facts that somebody wrote by hand, and that are not so.
            motion.q = [[S::from_f64(f64::NAN); N]; K];
        }
        [Smooth; K]
    }
}

impl<S: Real, Sys: Lagrangian<N, Scalar = S>, const N: usize> Method<Sys, N> for Taylor {
    type Memory = taylor::Memory<S, N, USUAL_ROOM>;
    type Stages = Series<S, N, USUAL_ROOM>;
    type Error = Remainder<S, N>;
    type Dense = Polynomial<S, N, USUAL_ROOM>;

    fn order(&self) -> u32 {
        Method::<Expanded<'_, Sys>, N>::order(&SERIES)
    }

    fn start(&self, system: &Sys, at: &State<S, N>) -> Result<Self::Memory, Failure<S>> {
        SERIES.start(&Expanded(system), at)
    }

    fn step(
        &self,
        system: &Sys,
        memory: &Self::Memory,
        from: &State<S, N>,
        h: S,
        next: &mut Self::Memory,
    ) -> Result<Step<Sys, Self, N>, Failure<S>> {
        let Step { from, to, h, error, stages, evaluations } =
            SERIES.step(&Expanded(system), memory, from, h, next)?;
        Ok(Step { from, to, h, error, stages, evaluations })
    }

    fn dense(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
        SERIES.polynomial(step.stages, step.from)
    }

    fn parts(&self, memory: &Self::Memory, h: S) -> u32 {
        Method::<Expanded<'_, Sys>, N>::parts(&SERIES, memory, h)
    }

    fn start_evaluations(&self) -> u32 {
        Method::<Expanded<'_, Sys>, N>::start_evaluations(&SERIES)
    }
}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> Separable<N> for Proven<'_, Sys> {}
impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> Linear<N> for Proven<'_, Sys> {}
impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> Autonomous<N> for Proven<'_, Sys> {}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> Independent<N> for Proven<'_, Sys> {}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S>, const N: usize> Legendre<N> for Proven<'_, Sys> {
    /// `p = M q̇ + p(q̇ = 0)` where L is quadratic in q̇.
    fn velocities(&self, q: &SVector<S, N>, p: &SVector<S, N>, t: S) -> SVector<S, N> {
        let rest = SVector::from_fn(|_, _| S::zero());
        let right = p - self.0.momenta(q, &rest, t);
        // A singular matrix shows as velocities that are not numbers, for which methods look anyway.
        factored(&self.0.inertia(q, &rest, t)).solve(&right)
    }
}

impl<S: Scalar, const N: usize> System<N> for Shape<S, N> {
    type Scalar = S;
    never! { accel -> SVector<S, N>; }
}

impl<S: Scalar, const N: usize> Lagrangian<N> for Shape<S, N> {
    const FACTS: Facts = Facts::UNKNOWN;
    lagrangian_functions! { never! {} }
}

#[diagnostic::do_not_recommend]
impl<S: Scalar, const N: usize> Separable<N> for Shape<S, N> {}
#[diagnostic::do_not_recommend]
impl<S: Scalar, const N: usize> Linear<N> for Shape<S, N> {}
#[diagnostic::do_not_recommend]
impl<S: Scalar, const N: usize> Autonomous<N> for Shape<S, N> {}

#[diagnostic::do_not_recommend]
impl<S: Scalar, const N: usize> Independent<N> for Shape<S, N> {}

#[diagnostic::do_not_recommend]
impl<S: Scalar, const N: usize> Legendre<N> for Shape<S, N> {
    fn velocities(&self, _: &SVector<S, N>, _: &SVector<S, N>, _: S) -> SVector<S, N> {
        match self.0 {}
    }
}

/// What an estimate of the error is to [`AnyMethod`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AnyError<S, const N: usize> {
    /// There is none.
    None(NoEstimate),
    /// One.
    One(Tangent<S, N>),
    /// Two.
    Two(TwoEstimates<S, N>),
    /// That of Radau5.
    Radau(RadauEstimate<S, N>),
    /// That of Taylor series.
    Series(Remainder<S, N>),
}

impl<S, const N: usize> From<Remainder<S, N>> for AnyError<S, N> {
    fn from(remainder: Remainder<S, N>) -> Self {
        AnyError::Series(remainder)
    }
}

impl<S, const N: usize> From<NoEstimate> for AnyError<S, N> {
    fn from(none: NoEstimate) -> Self {
        AnyError::None(none)
    }
}

impl<S, const N: usize> From<Tangent<S, N>> for AnyError<S, N> {
    fn from(one: Tangent<S, N>) -> Self {
        AnyError::One(one)
    }
}

impl<S, const N: usize> From<TwoEstimates<S, N>> for AnyError<S, N> {
    fn from(two: TwoEstimates<S, N>) -> Self {
        AnyError::Two(two)
    }
}

impl<S, const N: usize> From<RadauEstimate<S, N>> for AnyError<S, N> {
    fn from(estimate: RadauEstimate<S, N>) -> Self {
        AnyError::Radau(estimate)
    }
}

macro_rules! back {
    ($($variant:ident $error:ty, $otherwise:expr;)*) => {$(
        impl<S: Scalar, const N: usize> From<AnyError<S, N>> for $error {
            fn from(error: AnyError<S, N>) -> Self {
                if let AnyError::$variant(error) = error { error } else { $otherwise }
            }
        }
    )*};
}

// Back to what they were; no other is ever asked for.
back! {
    None NoEstimate, NoEstimate;
    One Tangent<S, N>, Tangent::zero();
    Two TwoEstimates<S, N>, TwoEstimates { fifth: Tangent::zero(), third: Tangent::zero() };
    Radau RadauEstimate<S, N>, RadauEstimate { difference: Tangent::zero() };
    Series Remainder<S, N>, Remainder::none();
}

impl<S: Real, const N: usize> ErrorEstimate<S, N> for AnyError<S, N> {
    fn square<R: Scalar>(&self, norm: &impl SquareNorm<S, R, N>) -> R {
        match self {
            // Never good enough: a table that pairs such a method with adaptive steps is wrong, and is to be noticed.
            AnyError::None(_) => R::from_f64(f64::INFINITY),
            AnyError::One(one) => one.square(norm),
            AnyError::Two(two) => two.square(norm),
            AnyError::Radau(estimate) => estimate.square(norm),
            AnyError::Series(remainder) => remainder.error().square(norm),
        }
    }
}

macro_rules! any_method {
    ($($(#[$doc:meta])* $method:ident;)*) => {
        /// A method of this crate, chosen while the program runs.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum AnyMethod {
            $($(#[$doc])* $method,)*
        }

        impl AnyMethod {
            /// Name of the method.
            pub const fn name(self) -> &'static str {
                match self {
                    $(AnyMethod::$method => stringify!($method),)*
                }
            }
        }

        /// Memory of [`AnyMethod`].
        #[derive(Clone, Debug)]
        pub enum AnyMemory<S: Real, const N: usize> {
            $($(#[$doc])* $method(<$method as Method<Shape<S, N>, N>>::Memory),)*
        }

        /// Stages of [`AnyMethod`].
        #[derive(Clone, Debug)]
        pub enum AnyStages<S: Real, const N: usize> {
            $($(#[$doc])* $method(<$method as Method<Shape<S, N>, N>>::Stages),)*
        }

        /// Interpolant of [`AnyMethod`].
        #[derive(Clone, Debug)]
        pub enum AnyDense<S: Real, const N: usize> {
            $($(#[$doc])* $method(<$method as Method<Shape<S, N>, N>>::Dense),)*
        }

        impl<S: Real, const N: usize> Dense<S, N> for AnyDense<S, N> {
            fn at(&self, t: S) -> State<S, N> {
                match self {
                    $(AnyDense::$method(dense) => dense.at(t),)*
                }
            }
        }

        impl<S: Real, Sys: Lagrangian<N, Scalar = S>, const N: usize> Method<Sys, N> for AnyMethod {
            type Memory = AnyMemory<S, N>;
            type Stages = AnyStages<S, N>;
            type Error = AnyError<S, N>;
            type Dense = AnyDense<S, N>;

            fn order(&self) -> u32 {
                match self {
                    $(AnyMethod::$method => Method::<Shape<S, N>, N>::order(&$method),)*
                }
            }

            fn implicit(&self) -> bool {
                match self {
                    $(AnyMethod::$method => Method::<Shape<S, N>, N>::implicit(&$method),)*
                }
            }

            fn meets(&self, requirement: Requirement) -> Result<(), Failure<S>> {
                match (requirement, self) {
                    (Requirement::ErrorEstimate, AnyMethod::BlanesMoan4 | AnyMethod::Gauss4 | AnyMethod::Modal) => {
                        Err(Failure::Unsuitable { chosen: self.name(), requirement })
                    }
                    (Requirement::Series, AnyMethod::Taylor) => Ok(()),
                    (Requirement::Series, _) => Err(Failure::Unsuitable { chosen: "Decay", requirement }),
                    _ => Ok(()),
                }
            }

            fn start(&self, system: &Sys, at: &State<S, N>) -> Result<Self::Memory, Failure<S>> {
                if let Some(requirement) = self.missing(&Sys::FACTS) {
                    return Err(Failure::Unsuitable { chosen: self.name(), requirement });
                }
                match self {
                    $(AnyMethod::$method if const { AnyMethod::$method.serves(&Sys::FACTS) } => {
                        $method.start(&Proven(system), at).map(AnyMemory::$method)
                    })*
                    _ => Err(Failure::NoSeries { t: at.t }),
                }
            }

            fn step(
                &self,
                system: &Sys,
                memory: &Self::Memory,
                from: &State<S, N>,
                h: S,
                next: &mut Self::Memory,
            ) -> Result<Step<Sys, Self, N>, Failure<S>> {
                match (self, memory, &mut *next) {
                    $((AnyMethod::$method, AnyMemory::$method(memory), AnyMemory::$method(next))
                        if const { AnyMethod::$method.serves(&Sys::FACTS) } =>
                    {
                        let Step { from, to, h, error, stages, evaluations } =
                            $method.step(&Proven(system), memory, from, h, next)?;
                        let (error, stages) = (error.into(), AnyStages::$method(stages));
                        Ok(Step { from, to, h, error, stages, evaluations })
                    })*
                    // Memory of another method: whoever changes methods has to start anew.
                    _ => {
                        let memory = self.start(system, from)?;
                        *next = memory.clone();
                        self.step(system, &memory, from, h, next)
                    }
                }
            }

            fn dense(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
                let Step { from, to, h, evaluations, .. } = *step;
                match &step.stages {
                    $(AnyStages::$method(stages) => {
                        let (stages, error) = (stages.clone(), step.error.into());
                        let step = Step { from, to, h, error, stages, evaluations };
                        AnyDense::$method($method.dense(&Proven(system), &step))
                    })*
                }
            }

            fn dense_evaluations(&self) -> u32 {
                match self {
                    $(AnyMethod::$method => Method::<Shape<S, N>, N>::dense_evaluations(&$method),)*
                }
            }

            fn parts(&self, memory: &Self::Memory, h: S) -> u32 {
                match memory {
                    $(AnyMemory::$method(memory) => Method::<Shape<S, N>, N>::parts(&$method, memory, h),)*
                }
            }

            fn start_evaluations(&self) -> u32 {
                match self {
                    $(AnyMethod::$method => Method::<Shape<S, N>, N>::start_evaluations(&$method),)*
                }
            }
        }
    };
}

any_method! {
    /// [`crate::Dop853`]
    Dop853;
    /// [`crate::DormandPrince5`]
    DormandPrince5;
    /// [`crate::Verner9`]
    Verner9;
    /// [`crate::Nystrom12`]
    Nystrom12;
    /// [`crate::BlanesMoan4`]
    BlanesMoan4;
    /// [`crate::Gauss4`]
    Gauss4;
    /// [`crate::Modal`]
    Modal;
    /// [`crate::Rodas5P`]
    Rodas5P;
    /// [`crate::Radau5`]
    Radau5;
    /// [`crate::Taylor`] of order 20, of a system that has series and no switches; others end in [`Failure::NoSeries`].
    Taylor;
}

impl AnyMethod {
    /// The requirement of the method that a system with these facts does not meet: what the bounds of its `impl Method` say. Taylor
    /// series have a failure of their own, [`Failure::NoSeries`].
    const fn missing(self, facts: &Facts) -> Option<Requirement> {
        match self {
            AnyMethod::Nystrom12 | AnyMethod::BlanesMoan4 if !facts.separable => Some(Requirement::Separable),
            AnyMethod::Gauss4 if !facts.constraints.is_empty() => Some(Requirement::Independent),
            AnyMethod::Gauss4 if !facts.quadratic => Some(Requirement::Quadratic),
            AnyMethod::Modal if !facts.linear => Some(Requirement::Linear),
            AnyMethod::Modal if !facts.autonomous => Some(Requirement::Autonomous),
            _ => None,
        }
    }

    /// Whether the method starts on a system with these facts. Methods that do not are not compiled for it.
    const fn serves(self, facts: &Facts) -> bool {
        self.missing(facts).is_none() && (facts.analytic || !matches!(self, AnyMethod::Taylor))
    }
}

/// A controller of this crate, chosen while the program runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AnyController<S = f64> {
    /// [`crate::Fixed`]
    Fixed(Fixed<S>),
    /// [`crate::Pi`]
    Pi(Pi),
    /// [`crate::Decay`], of [`AnyMethod::Taylor`]
    Decay(Decay),
}

impl<S: Real, const N: usize> Controller<S, N, AnyError<S, N>> for AnyController<S> {
    #[inline]
    fn first_step(&self) -> FirstStep<S> {
        match self {
            AnyController::Fixed(fixed) => Controller::<S, N, AnyError<S, N>>::first_step(fixed),
            AnyController::Pi(pi) => Controller::<S, N, AnyError<S, N>>::first_step(pi),
            AnyController::Decay(decay) => Controller::<S, N, Remainder<S, N>>::first_step(decay),
        }
    }

    fn check(&self) -> Result<(), Failure<S>> {
        match self {
            AnyController::Fixed(fixed) => Controller::<S, N, AnyError<S, N>>::check(fixed),
            AnyController::Pi(pi) => Controller::<S, N, AnyError<S, N>>::check(pi),
            AnyController::Decay(decay) => Controller::<S, N, Remainder<S, N>>::check(decay),
        }
    }

    fn max_step(&self) -> f64 {
        match self {
            AnyController::Fixed(fixed) => Controller::<S, N, AnyError<S, N>>::max_step(fixed),
            AnyController::Pi(pi) => Controller::<S, N, AnyError<S, N>>::max_step(pi),
            AnyController::Decay(decay) => Controller::<S, N, Remainder<S, N>>::max_step(decay),
        }
    }

    fn requirement(&self) -> Option<Requirement> {
        match self {
            AnyController::Fixed(_) => None,
            AnyController::Pi(_) => Some(Requirement::ErrorEstimate),
            AnyController::Decay(_) => Some(Requirement::Series),
        }
    }

    fn norm(&self, difference: &Tangent<S, N>, a: &State<S, N>, b: &State<S, N>) -> f64 {
        match self {
            AnyController::Fixed(fixed) => Controller::<S, N, AnyError<S, N>>::norm(fixed, difference, a, b),
            AnyController::Pi(pi) => Controller::<S, N, AnyError<S, N>>::norm(pi, difference, a, b),
            AnyController::Decay(decay) => Controller::<S, N, Remainder<S, N>>::norm(decay, difference, a, b),
        }
    }

    fn tolerates(&self, correction: &Tangent<S, N>, from: &State<S, N>, to: &State<S, N>) -> bool {
        match self {
            AnyController::Fixed(fixed) => {
                Controller::<S, N, AnyError<S, N>>::tolerates(fixed, correction, from, to)
            }
            AnyController::Pi(pi) => Controller::<S, N, AnyError<S, N>>::tolerates(pi, correction, from, to),
            AnyController::Decay(decay) => {
                Controller::<S, N, Remainder<S, N>>::tolerates(decay, correction, from, to)
            }
        }
    }

    #[inline]
    fn judge(&mut self, from: &State<S, N>, to: &State<S, N>, error: &AnyError<S, N>, order: u32) -> Verdict {
        match (self, error) {
            (AnyController::Fixed(fixed), _) => fixed.judge(from, to, error, order),
            (AnyController::Pi(pi), _) => pi.judge(from, to, error, order),
            (AnyController::Decay(decay), AnyError::Series(remainder)) => {
                decay.judge(from, to, remainder, order)
            }
            // Of another method it knows nothing, and lets no step pass.
            (AnyController::Decay(_), _) => Verdict::Reject { factor: 0.1 },
        }
    }

    fn after_failure(&mut self) -> Option<f64> {
        match self {
            AnyController::Fixed(fixed) => Controller::<S, N, AnyError<S, N>>::after_failure(fixed),
            AnyController::Pi(pi) => Controller::<S, N, AnyError<S, N>>::after_failure(pi),
            AnyController::Decay(decay) => Controller::<S, N, Remainder<S, N>>::after_failure(decay),
        }
    }
}
