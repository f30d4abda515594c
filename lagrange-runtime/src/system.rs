//! Traits of a mechanical system, which `lagrangian!` implements.
//!
//! Notation (Beatty, *Principles of Engineering Mechanics 2*, 2006, ch. 11; Goldstein, *Classical Mechanics*, ch. 1–2):
//! coordinates q, velocities q̇, `L = T − V`, momenta `p = ∂L/∂q̇`, inertia `M = ∂²L/∂q̇²`, and the equations of motion
//! `M q̈ + b = f` with `b = (∂p/∂q) q̇ + ∂p/∂t` and `f = ∂L/∂q − ∂D/∂q̇ + Q`.

use crate::attitude;
use crate::failure::Failure;
use crate::scalar::{Dual, Real, Scalar, SimdScalar};
use crate::state::{Begun, ConstraintTerms, Restored, State};
use nalgebra::{SMatrix, SVector};

pub use crate::facts::Facts;
use crate::facts::{CommonSymmetry, Symmetry};

/// Functions of (q, q̇, t) as functions of a state, for the body of the trait that has them.
macro_rules! at_states {
    ($($at:ident: $of:ident -> $result:ty;)*) => {$(
        #[doc = concat!("[`", stringify!($of), "`](Self::", stringify!($of), ") at a state.")]
        #[inline]
        fn $at(&self, at: &State<Self::Scalar, N>) -> $result {
            self.$of(&at.q, &at.qd, at.t)
        }
    )*};
}
pub(crate) use at_states;

/// A system that can be integrated: `q̈ = accel(q, q̇, t)`. All that an explicit method needs.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a mechanical system with {N} coordinates",
    note = "systems are made by `lagrangian! {{ … }}`, or by implementing `System<N>` for a type of your own"
)]
pub trait System<const N: usize> {
    /// The number type: `f64`, a pack of lanes, a dual.
    type Scalar: Scalar;

    /// The N generalized accelerations `q̈(q, q̇, t)`, each in the unit of its coordinate per s²: m/s² of a length and
    /// rad/s² of an angle. The last elements are the rates of [states of first order](crate::traits::States), each in
    /// the unit of its state per second.
    fn accel(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N>;

    at_states! {
        accel_at: accel -> SVector<Self::Scalar, N>;
    }

    /// The state near `at` that satisfies the constraints of the system; none where its coordinates are independent. A
    /// run goes there after each step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn restored(
        &self,
        at: &State<Self::Scalar, N>,
    ) -> Result<Option<Restored<Self::Scalar, N>>, Failure<Self::Scalar>>
    where
        Self::Scalar: SimdScalar,
    {
        let _ = at;
        Ok(None)
    }

    /// Number of constraints.
    #[doc(hidden)]
    const CONSTRAINTS: usize = 0;

    /// Distance of the constraints from being dependent at `at`: `sin² α` of the smallest angle between the gradient of
    /// one and the span of the others.
    #[doc(hidden)]
    #[cold]
    fn independence(&self, start: &State<Self::Scalar, N>, at: &State<Self::Scalar, N>) -> f64
    where
        Self::Scalar: Real,
    {
        let _ = (start, at);
        1.0
    }

    /// Fails near a position at which constraints are dependent if a motion from `start` that is at `at` meets two
    /// branches that touch there.
    ///
    /// # Errors
    /// [`Failure::Bifurcation`].
    #[doc(hidden)]
    #[cold]
    fn determined(
        &self,
        start: &State<Self::Scalar, N>,
        at: &State<Self::Scalar, N>,
    ) -> Result<(), Failure<Self::Scalar>>
    where
        Self::Scalar: Real,
    {
        let _ = (start, at);
        Ok(())
    }

    /// Fails if a step has gone through a position at which constraints are dependent, and slopes of numbers move one.
    ///
    /// # Errors
    /// [`Failure::NotDifferentiable`].
    #[doc(hidden)]
    #[cold]
    fn differentiable(
        &self,
        from: &State<Self::Scalar, N>,
        to: &State<Self::Scalar, N>,
    ) -> Result<(), Failure<Self::Scalar>>
    where
        Self::Scalar: Real,
    {
        let _ = (from, to);
        Ok(())
    }

    /// Beginning of a motion near a position at which constraints are dependent, if its velocity determines the branch;
    /// `None` elsewhere.
    #[doc(hidden)]
    #[cold]
    fn begun_across(&self, at: &State<Self::Scalar, N>) -> Option<Begun<Self::Scalar, N>>
    where
        Self::Scalar: Real,
    {
        let _ = at;
        None
    }

    /// The end of a step of size `h` on the branch that it is beside, very near a position at which constraints are
    /// dependent; `None` elsewhere.
    #[doc(hidden)]
    #[cold]
    fn restored_across(
        &self,
        reference: &State<Self::Scalar, N>,
        at: &State<Self::Scalar, N>,
        h: Self::Scalar,
    ) -> Option<State<Self::Scalar, N>>
    where
        Self::Scalar: Real,
    {
        let _ = (reference, at, h);
        None
    }

    /// [`accel`](Self::accel) in steps of size `h` near states at which constraints are dependent; `roughly`, as
    /// Jacobians need them, where they are not smooth, too.
    #[doc(hidden)]
    #[cold]
    fn accel_across(
        &self,
        reference: &State<Self::Scalar, N>,
        at: &State<Self::Scalar, N>,
        h: Self::Scalar,
        roughly: bool,
    ) -> SVector<Self::Scalar, N>
    where
        Self::Scalar: Real,
    {
        let _ = (reference, h, roughly);
        self.accel(&at.q, &at.qd, at.t)
    }

    /// Calls `each` with the terms of each constraint at a state, in their order; never where the coordinates are
    /// independent.
    #[cold]
    fn constraint_terms(
        &self,
        at: &State<Self::Scalar, N>,
        each: impl FnMut(ConstraintTerms<Self::Scalar, N>),
    ) {
        let _ = (at, each);
    }

    /// `at` after one correction by Newton's method towards the constraints, however small the violation is:
    /// derivatives that its numbers carry become those of admissible states. `at` itself where the coordinates are
    /// independent.
    #[cold]
    fn toward_constraints(&self, at: &State<Self::Scalar, N>) -> State<Self::Scalar, N> {
        *at
    }

    /// True if time is proved not to appear in the equations of motion, as [`Facts::autonomous`].
    const AUTONOMOUS: bool = false;

    /// Number of [states of first order](crate::traits::States), whose time integrals are the last coordinates.
    const FIRST_ORDER: usize = 0;
    /// The first coordinates of the rotations among the coordinates, of three parameters each. A run begins each step
    /// from their shorter parameters.
    const ATTITUDES: &'static [usize] = &[];

    /// The same state by other parameters of its attitudes, if the next step is to begin from these: one of steps of
    /// the size `equal`, or one of a size of its own.
    #[inline(always)]
    fn shortened(
        &self,
        at: &State<Self::Scalar, N>,
        equal: Option<Self::Scalar>,
    ) -> Option<State<Self::Scalar, N>>
    where
        Self::Scalar: Real,
    {
        let equal = equal.map(|h| (h, self.accel(&at.q, &at.qd, at.t)));
        attitude::steps::shortened(Self::ATTITUDES, at, equal)
    }

    /// Number of [switching functions](Self::switches).
    const SWITCHES: usize = 0;

    /// True if the rate of a switching function depends on the accelerations, as with dry friction: such a switch may
    /// hold the motion ([`Failure::Sliding`]).
    const HOLDS: bool = false;

    /// Number of switching functions at which an impulse acts, the first of all: across them a momentum ∂L/∂q̇ jumps,
    /// or L does along a coordinate. Runs end there in [`Failure::UnknownImpulse`], where the function
    /// [decides](Self::decides).
    const IMPULSES: usize = 0;

    /// The name of a function with data that has kinks, and on whose slope a momentum ∂L/∂q̇ depends. Runs of such a
    /// system fail.
    #[inline(always)]
    fn kinked(&self) -> Option<&'static str> {
        None
    }

    /// Calls `each` with the index of each switching function g(q, q̇, t) of the accelerations, its value and its
    /// rate dg/dt at a state with these accelerations. The accelerations are smooth where no g vanishes: a choice
    /// `a < b` has g = a − b, `x.abs()` and `x.signum()` have g = x. Adaptive runs end their steps where a g changes
    /// its sign.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn switches(
        &self,
        at: &State<Self::Scalar, N>,
        accelerations: &SVector<Self::Scalar, N>,
        each: impl FnMut(usize, [Self::Scalar; 2]),
    ) {
        let _ = (at, accelerations, each);
    }

    /// Does the switching function with this index decide anything where it vanishes at this state? That of
    /// `atan2(y, x)` is y, and the function jumps only where x is negative. Each one does everywhere by default.
    #[inline(always)]
    fn decides(&self, switch: usize, at: &State<Self::Scalar, N>) -> bool
    where
        Self::Scalar: Real,
    {
        let _ = (switch, at);
        true
    }

    /// The velocities at `to`, the end of a step from `from` across a switch that was so short that it changes them
    /// by next to nothing, if those of neighbouring motions differ: these cross the switch at other times.
    ///
    /// A neighbour, x + δ, is at the switch by `τ = −δg/ġ` later. Until then it moves with the accelerations a⁻
    /// before the switch and not with a⁺, so that afterwards `δq̇⁺ = δq̇⁻ + (a⁻ − a⁺) τ` (saltation; Aizerman and
    /// Gantmakher, *Quart. J. Mech. Appl. Math.* 11, 1958; Leine and Nijmeijer, *Dynamics and Bifurcations of
    /// Non-Smooth Mechanical Systems*, 2004, ch. 7). Deviations are the slopes of numbers here.
    #[cold]
    fn saltated(
        &self,
        switch: usize,
        from: &State<Self::Scalar, N>,
        to: &State<Self::Scalar, N>,
    ) -> Option<SVector<Self::Scalar, N>>
    where
        Self::Scalar: Real,
    {
        let [before, after] = [from, to].map(|at| self.accel(&at.q, &at.qd, at.t));
        let mut later = Self::Scalar::zero();
        self.switches(to, &before, |index, [g, rate]| {
            let deviation = g.infinitesimal();
            if index == switch && deviation.magnitude() > 0.0 {
                later = -deviation / rate;
            }
        });
        (later.magnitude() != 0.0).then(|| to.qd + (before - after) * later)
    }

    /// The cause of a failure of a run from `start` that ended at `last`, as far as the system knows it, see
    /// [`diagnose`](crate::diagnose).
    #[cold]
    fn explained(
        &self,
        start: &State<Self::Scalar, N>,
        last: &State<Self::Scalar, N>,
        failure: Failure<Self::Scalar>,
    ) -> Failure<Self::Scalar>
    where
        Self::Scalar: Real,
    {
        let _ = (start, last);
        failure
    }

    /// Fails if rounding at `at` changes the motion of a run from `start`: velocities cancel, see
    /// [`resolved`](crate::diagnosis::resolved), constraints are nearly dependent, or a coordinate starts without
    /// inertia. A run calls this at its start, and where its steps become tiny; a system of which only the
    /// accelerations are known cannot tell.
    ///
    /// # Errors
    /// [`Failure::Cancellation`], [`Failure::DependentConstraints`], [`Failure::SingularInertia`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn resolved(
        &self,
        start: &State<Self::Scalar, N>,
        at: &State<Self::Scalar, N>,
    ) -> Result<(), Failure<Self::Scalar>>
    where
        Self::Scalar: Real,
    {
        let _ = (start, at);
        Ok(())
    }
}

/// Everything that follows from a Lagrangian besides the accelerations. Emitted for every `lagrangian!` system.
///
/// Vectors have an element for each coordinate, and matrices a row and a column. Units are those of the SI, unless the
/// definition is written in others. A generalized force is in J per unit of its coordinate: in N where that is a length
/// and in N m where it is an angle. A momentum is in J s per unit of its coordinate: in N s of a length and in N m s of
/// an angle.
#[diagnostic::on_unimplemented(
    message = "this needs the Lagrangian of `{Self}` (momenta, inertia, forces), not its accelerations alone",
    note = "systems made by `lagrangian! {{ … }}` have it"
)]
pub trait Lagrangian<const N: usize>: System<N> {
    /// Facts that the compiler found out about the system.
    const FACTS: Facts;

    /// Constant angular momenta of rotations that are coordinates.
    const SYMMETRIES: &'static [Symmetry] = &[];

    /// Constant angular momenta of rotations, directions and positions that turn together.
    const COMMON_SYMMETRIES: &'static [CommonSymmetry] = &[];

    /// The Lagrangian `L(q, q̇, t)`, in J; `T − V` where these were given.
    fn lagrangian(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Self::Scalar;

    /// The N generalized momenta `p = ∂L/∂q̇`, in N s of a length and N m s of an angle.
    fn momenta(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N>;

    /// Energy function (Jacobi integral) `h = p·q̇ − L`, in J.
    fn energy_function(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Self::Scalar;

    /// Inertia matrix `M = ∂²L/∂q̇²`, symmetric, `N × N`, in kg of lengths, kg m² of angles and kg m between the two.
    /// It depends on `q̇` only where L is not quadratic in it.
    fn inertia(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SMatrix<Self::Scalar, N, N>;

    /// Convective rate of the N momenta, `b = (∂p/∂q) q̇ + ∂p/∂t`: their rate at zero acceleration, so that
    /// `M q̈ + b = f`, in N of a length and N m of an angle. It has no gravity and no other force: the bias force of
    /// robotics is `b − f`.
    fn convective_momentum_rate(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N>;

    /// Rate of the N momenta by forces, `f = ∂L/∂q − ∂D/∂q̇ + Q`, in N of a length and N m of an angle: it is `dp/dt`
    /// where no constraint acts.
    fn momentum_rate(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N>;

    /// Rayleigh dissipation function `D(q, q̇, t)`, in W; 0 where none was given.
    fn dissipation(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Self::Scalar;

    /// Power `(Q − ∂D/∂q̇)·q̇` of the nonconservative forces and of dissipation, in W.
    fn power(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Self::Scalar;

    /// Exact derivatives of [`System::accel`] by coordinates, velocities and time.
    fn jacobian(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Jacobian<Self::Scalar, N>;

    at_states! {
        lagrangian_at: lagrangian -> Self::Scalar;
        momenta_at: momenta -> SVector<Self::Scalar, N>;
        energy_function_at: energy_function -> Self::Scalar;
        inertia_at: inertia -> SMatrix<Self::Scalar, N, N>;
        convective_momentum_rate_at: convective_momentum_rate -> SVector<Self::Scalar, N>;
        momentum_rate_at: momentum_rate -> SVector<Self::Scalar, N>;
        dissipation_at: dissipation -> Self::Scalar;
        power_at: power -> Self::Scalar;
        jacobian_at: jacobian -> Jacobian<Self::Scalar, N>;
    }
}

/// Kinetic and potential energy in J, where the system was written as `T` and `V` (and not as a whole `L`).
#[diagnostic::on_unimplemented(
    message = "`{Self}` was given as a whole `L`, which has no unique kinetic and potential energy, or with a `V` that depends on states of first order",
    note = "write `T = …; V = …;` instead of `L = …;`, or use the energy function `energy_function`"
)]
pub trait Energies<const N: usize>: Lagrangian<N> {
    /// Kinetic energy `T(q, q̇, t)`, in J.
    fn kinetic(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Self::Scalar;

    /// Potential energy `V(q, t)`, in J.
    fn potential(&self, q: &SVector<Self::Scalar, N>, t: Self::Scalar) -> Self::Scalar;

    /// Total energy `E = T + V`, in J.
    #[inline]
    fn energy(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Self::Scalar {
        self.kinetic(q, qd, t) + self.potential(q, t)
    }

    /// [`energy`](Self::energy) at a state, such as [`Run::final_state`](crate::integrate::Run::final_state) gives.
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     system Oscillator {
    ///         param omega;
    ///         coord x;
    ///         T = 0.5 * dot(x).powi(2);
    ///         V = 0.5 * (omega * x).powi(2);
    ///     }
    /// }
    /// let (system, start) = (Oscillator::new(2.0), State::new(0.0, [1.0], [0.0]));
    /// let end = integrate(&system, Gauss4, FixedStep::new(0.1), start).until(100.0).final_state()?;
    /// assert!((system.energy_at(&end) - 2.0).abs() < 1e-14);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    #[inline]
    fn energy_at(&self, at: &State<Self::Scalar, N>) -> Self::Scalar {
        self.energy(&at.q, &at.qd, at.t)
    }

    at_states! {
        kinetic_at: kinetic -> Self::Scalar;
    }

    /// [`potential`](Self::potential) at a state.
    #[inline]
    fn potential_at(&self, at: &State<Self::Scalar, N>) -> Self::Scalar {
        self.potential(&at.q, at.t)
    }
}

/// Velocities from momenta (inverse Legendre transformation), where L is quadratic in the velocities.
#[diagnostic::on_unimplemented(
    message = "methods on (q, p) need independent coordinates, no states of first order, and a Lagrangian that is quadratic in the velocities, which those of `{Self}` are not",
    note = "use a method on (q, q̇), such as `Dop853`, or `method::variational::ConstrainedMidpoint` for constraints on positions"
)]
pub trait LegendreTransform<const N: usize>: Independent<N> {
    /// The N velocities `q̇` with `∂L/∂q̇ = p`, each in the unit of its coordinate per second. The N momenta are in the
    /// order of the coordinates, in N s of a length and N m s of an angle.
    fn velocities(
        &self,
        q: &SVector<Self::Scalar, N>,
        p: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N>;
}

/// Marker: the coordinates are independent, there are neither constraints between them nor [states of first
/// order](crate::traits::States).
#[diagnostic::on_unimplemented(
    message = "the coordinates of `{Self}` are not independent: it has constraints, which this method would not keep, or states of first order, which it does not know",
    note = "`Dop853` and the other methods on (q, q̇) keep them, and `method::variational::ConstrainedMidpoint` is symplectic on constraints on positions"
)]
pub trait Independent<const N: usize>: Lagrangian<N> {}

/// Marker: constant inertia and forces that do not depend on the velocities, so `q̈ = a(q, t)`; in Hamilton's
/// variables `H = T(p) + V(q, t)` up to a force of time. Splitting methods need it.
#[diagnostic::on_unimplemented(
    message = "splitting methods need a separable system, T(q̇) + V(q), and `{Self}` is not separable",
    label = "the inertia matrix of this system depends on q, or a force depends on q̇",
    note = "use a method for general systems: `ImplicitMidpoint` keeps the structure, `Dop853` is fast"
)]
pub trait Separable<const N: usize>: Lagrangian<N> {}

/// Marker: the inertia matrix is constant.
#[diagnostic::on_unimplemented(message = "the inertia matrix of `{Self}` is not constant")]
pub trait ConstantInertia<const N: usize>: Lagrangian<N> {}

/// Marker: `h = p·q̇ − L` is conserved (time does not appear, and neither D nor Q does), and the coordinates are
/// independent.
#[diagnostic::on_unimplemented(
    message = "the energy function h = p·q̇ − L of `{Self}` is not conserved, or its coordinates are not independent",
    note = "time appears in its equations, or it has a dissipation function or nonconservative forces; of a system with constraints it may be conserved, but a projection onto it would leave them: every run goes back to constraints after each step, `Projection` is not needed for that"
)]
pub trait Conservative<const N: usize>: Lagrangian<N> {}

/// Marker: time does not appear in the equations of motion ([`Facts::autonomous`]).
#[diagnostic::on_unimplemented(
    message = "the equations of motion of `{Self}` are not autonomous: time appears in them",
    note = "forces of time, prescribed coordinates and constraints that move make a system nonautonomous"
)]
pub trait Autonomous<const N: usize>: Lagrangian<N> {}

/// Marker: the equations of motion are linear in q, q̇ with constant coefficients, `M q̈ + C q̇ + K q = f(t)`.
#[diagnostic::on_unimplemented(
    message = "the equations of motion of `{Self}` are not linear with constant coefficients"
)]
pub trait Linear<const N: usize>: Lagrangian<N> {}

/// The equations of small motions. Emitted for every `lagrangian!` system.
#[diagnostic::on_unimplemented(
    message = "this needs the linearized forces of `{Self}`, not its accelerations alone",
    note = "systems made by `lagrangian! {{ … }}` have them"
)]
pub trait Linearize<const N: usize>: Lagrangian<N> {
    /// Exact derivatives of `b − f`, two `N × N` matrices. About a state without accelerations (an equilibrium, a
    /// steady motion) small deviations obey `M δq̈ + damping δq̇ + stiffness δq = 0`.
    fn linearize(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> Linearization<Self::Scalar, N>;

    at_states! {
        linearize_at: linearize -> Linearization<Self::Scalar, N>;
    }
}

/// Derivatives of `b − f`, each column belonging to one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearization<S, const N: usize> {
    /// `∂(b − f)/∂q`, `N × N`, in N/m of lengths and N m/rad of angles: where forces have a potential, its second
    /// derivatives.
    pub stiffness: SMatrix<S, N, N>,
    /// `∂(b − f)/∂q̇`, `N × N`, in N s/m of lengths and N m s/rad of angles: its symmetric part is damping, the
    /// antisymmetric one gyroscopic.
    pub damping: SMatrix<S, N, N>,
}

/// Derivatives of the accelerations, each column belonging to one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jacobian<S, const N: usize> {
    /// `∂q̈/∂q`, `N × N`, in 1/s² between coordinates of one unit.
    pub q: SMatrix<S, N, N>,
    /// `∂q̈/∂q̇`, `N × N`, in 1/s between coordinates of one unit.
    pub qd: SMatrix<S, N, N>,
    /// `∂q̈/∂t`, at fixed q and q̇, N elements, each in the unit of its coordinate per s³.
    pub t: SVector<S, N>,
}

/// Hands the functions of (q, q̇, t) of [`Lagrangian`] to a macro, each with its result, but for the Jacobian: for
/// types that are a system in another way.
macro_rules! lagrangian_functions {
    ($then:ident! { $($before:tt)* }) => {
        $then! {
            $($before)*
            lagrangian -> S;
            momenta -> SVector<S, N>;
            energy_function -> S;
            inertia -> SMatrix<S, N, N>;
            convective_momentum_rate -> SVector<S, N>;
            momentum_rate -> SVector<S, N>;
            dissipation -> S;
            power -> S;
        }
    };
}

/// Functions of (q, q̇, t), passed on to the system in a field.
macro_rules! pass_on {
    ($field:tt: $($name:ident -> $result:ty;)*) => {$(
        #[inline(always)]
        fn $name(&self, q: &SVector<S, N>, qd: &SVector<S, N>, t: S) -> $result {
            self.$field.$name(q, qd, t)
        }
    )*};
}

/// Passes what a run asks of its states on to the system in a field.
macro_rules! pass_on_run {
    ($field:tt: $system:ty) => {
        const AUTONOMOUS: bool = <$system as $crate::System<N>>::AUTONOMOUS;
        const FIRST_ORDER: usize = <$system as $crate::System<N>>::FIRST_ORDER;
        const ATTITUDES: &'static [usize] = <$system as $crate::System<N>>::ATTITUDES;

        #[inline(always)]
        fn shortened(
            &self,
            at: &$crate::State<Self::Scalar, N>,
            equal: Option<Self::Scalar>,
        ) -> Option<$crate::State<Self::Scalar, N>>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.shortened(at, equal)
        }
        const SWITCHES: usize = <$system as $crate::System<N>>::SWITCHES;
        const IMPULSES: usize = <$system as $crate::System<N>>::IMPULSES;
        const HOLDS: bool = <$system as $crate::System<N>>::HOLDS;

        #[inline(always)]
        fn kinked(&self) -> Option<&'static str> {
            self.$field.kinked()
        }

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn switches(
            &self,
            at: &$crate::State<Self::Scalar, N>,
            accelerations: &::nalgebra::SVector<Self::Scalar, N>,
            each: impl FnMut(usize, [Self::Scalar; 2]),
        ) {
            self.$field.switches(at, accelerations, each);
        }

        #[inline(always)]
        fn decides(&self, switch: usize, at: &$crate::State<Self::Scalar, N>) -> bool
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.decides(switch, at)
        }

        fn saltated(
            &self,
            switch: usize,
            from: &$crate::State<Self::Scalar, N>,
            to: &$crate::State<Self::Scalar, N>,
        ) -> Option<::nalgebra::SVector<Self::Scalar, N>>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.saltated(switch, from, to)
        }

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn restored(
            &self,
            at: &$crate::State<Self::Scalar, N>,
        ) -> Result<Option<$crate::traits::Restored<Self::Scalar, N>>, $crate::Failure<Self::Scalar>>
        where
            Self::Scalar: $crate::scalar::SimdScalar,
        {
            self.$field.restored(at)
        }

        const CONSTRAINTS: usize = <$system as $crate::System<N>>::CONSTRAINTS;

        fn independence(
            &self,
            start: &$crate::State<Self::Scalar, N>,
            at: &$crate::State<Self::Scalar, N>,
        ) -> f64
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.independence(start, at)
        }

        fn determined(
            &self,
            start: &$crate::State<Self::Scalar, N>,
            at: &$crate::State<Self::Scalar, N>,
        ) -> Result<(), $crate::Failure<Self::Scalar>>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.determined(start, at)
        }

        fn differentiable(
            &self,
            from: &$crate::State<Self::Scalar, N>,
            to: &$crate::State<Self::Scalar, N>,
        ) -> Result<(), $crate::Failure<Self::Scalar>>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.differentiable(from, to)
        }

        fn begun_across(
            &self,
            at: &$crate::State<Self::Scalar, N>,
        ) -> Option<$crate::traits::Begun<Self::Scalar, N>>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.begun_across(at)
        }

        fn restored_across(
            &self,
            reference: &$crate::State<Self::Scalar, N>,
            at: &$crate::State<Self::Scalar, N>,
            h: Self::Scalar,
        ) -> Option<$crate::State<Self::Scalar, N>>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.restored_across(reference, at, h)
        }

        fn accel_across(
            &self,
            reference: &$crate::State<Self::Scalar, N>,
            at: &$crate::State<Self::Scalar, N>,
            h: Self::Scalar,
            roughly: bool,
        ) -> ::nalgebra::SVector<Self::Scalar, N>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.accel_across(reference, at, h, roughly)
        }

        fn constraint_terms(
            &self,
            at: &$crate::State<Self::Scalar, N>,
            each: impl FnMut($crate::traits::ConstraintTerms<Self::Scalar, N>),
        ) {
            self.$field.constraint_terms(at, each);
        }

        fn toward_constraints(&self, at: &$crate::State<Self::Scalar, N>) -> $crate::State<Self::Scalar, N> {
            self.$field.toward_constraints(at)
        }

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn resolved(
            &self,
            start: &$crate::State<Self::Scalar, N>,
            at: &$crate::State<Self::Scalar, N>,
        ) -> Result<(), $crate::Failure<Self::Scalar>>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.resolved(start, at)
        }

        fn explained(
            &self,
            start: &$crate::State<Self::Scalar, N>,
            last: &$crate::State<Self::Scalar, N>,
            failure: $crate::Failure<Self::Scalar>,
        ) -> $crate::Failure<Self::Scalar>
        where
            Self::Scalar: $crate::Real,
        {
            self.$field.explained(start, last, failure)
        }
    };
}

pub(crate) use {lagrangian_functions, pass_on, pass_on_run};

/// Derivatives of the accelerations by dual numbers, one evaluation for each column. `system` is the system over
/// duals, with constant parameters. Emitted for systems whose symbolic Jacobian would be longer than this is slow.
pub fn dual_jacobian<S: Scalar, Sys: System<N, Scalar = Dual<S>>, const N: usize>(
    system: &Sys,
    q: &SVector<S, N>,
    qd: &SVector<S, N>,
    t: S,
) -> Jacobian<S, N> {
    let (q, qd, t) = (q.map(Dual::constant), qd.map(Dual::constant), Dual::constant(t));
    let slopes = |a: SVector<Dual<S>, N>| a.map(|a| a.slope);
    let mut jacobian =
        Jacobian { q: zeros(), qd: zeros(), t: slopes(system.accel(&q, &qd, Dual::variable(t.value))) };
    for i in 0..N {
        let (mut moved, mut driven) = (q, qd);
        moved[i].slope = S::one();
        driven[i].slope = S::one();
        jacobian.q.set_column(i, &slopes(system.accel(&moved, &qd, t)));
        jacobian.qd.set_column(i, &slopes(system.accel(&q, &driven, t)));
    }
    jacobian
}

/// The inertia matrix `∂p/∂q̇`, `N × N`, by dual numbers, one evaluation of the momenta for each column. `system` is
/// the system over duals, with constant parameters. Emitted for systems of many coordinates, whose matrix would be
/// longer than all the rest.
pub fn dual_inertia<S: Scalar, Sys: Lagrangian<N, Scalar = Dual<S>>, const N: usize>(
    system: &Sys,
    q: &SVector<S, N>,
    qd: &SVector<S, N>,
    t: S,
) -> SMatrix<S, N, N> {
    let (q, qd, t) = (q.map(Dual::constant), qd.map(Dual::constant), Dual::constant(t));
    let mut inertia: SMatrix<S, N, N> = zeros();
    for i in 0..N {
        let mut driven = qd;
        driven[i].slope = S::one();
        inertia.set_column(i, &system.momenta(&q, &driven, t).map(|p| p.slope));
    }
    inertia
}

/// Derivatives of `b − f` by dual numbers, one evaluation for each column, as [`dual_jacobian`].
pub fn dual_linearization<S: Scalar, Sys: Lagrangian<N, Scalar = Dual<S>>, const N: usize>(
    system: &Sys,
    q: &SVector<S, N>,
    qd: &SVector<S, N>,
    t: S,
) -> Linearization<S, N> {
    let (q, qd, t) = (q.map(Dual::constant), qd.map(Dual::constant), Dual::constant(t));
    let slopes = |q: &SVector<Dual<S>, N>, qd: &SVector<Dual<S>, N>| {
        (system.convective_momentum_rate(q, qd, t) - system.momentum_rate(q, qd, t)).map(|rest| rest.slope)
    };
    let mut linearization = Linearization::<S, N> { stiffness: zeros(), damping: zeros() };
    for i in 0..N {
        let (mut moved, mut driven) = (q, qd);
        moved[i].slope = S::one();
        driven[i].slope = S::one();
        linearization.stiffness.set_column(i, &slopes(&moved, &qd));
        linearization.damping.set_column(i, &slopes(&q, &driven));
    }
    linearization
}

fn zeros<S: Scalar, const N: usize>() -> SMatrix<S, N, N> {
    SMatrix::from([[S::zero(); N]; N])
}
