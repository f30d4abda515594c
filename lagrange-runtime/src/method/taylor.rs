//! Taylor series of high order: the method for the last digits.
//!
//! The compiler emits recurrences that give the Taylor coefficients of the motion one order after the other
//! ([`Analytic`]). A step is the sum of the series: of order p it costs about p²/2 operations for each product in the
//! equations, and may be as long as the series converges quickly, whatever the tolerance (Moore 1966; Corliss and Chang
//! 1982; Jorba and Zou, *Exper. Math.* 14 (2005) 99; Biscani and Izzo, *MNRAS* 504 (2021) 2614).
//!
//! The order belongs to the tolerance ([`Taylor`](const@Taylor)). The step follows from the decay of the coefficients.
//! The published rule uses the last two of them, and fails for motions whose symmetry makes coefficients vanish
//! alternately, such as a pendulum released from rest at 90°. Here the last `WINDOW` have a say, and each step is
//! checked: by the difference between the accelerations of the polynomial at its end and those of the system, which are
//! known anyway, since the next series begins there.
//!
//! Where the argument of a root vanishes at the start of a step, as that of |q̇| does at rest, there is no series.
//! The polynomial of that step is found by collocation (`taylor/collocation.rs`).
//!
//! Where the equations have choices (`if`, `abs`, …), a step ends at the first switch on its way: where the switching
//! function vanishes on the polynomials, to rounding. The next one begins on the other side. If the equations lead
//! back to the switch from both sides, as dry friction that holds, the run ends in [`Failure::Sliding`].

use super::{Across, Interpolant, Method, Step};
use crate::attitude;
use crate::failure::Failure;
use crate::iteration::{chosen, nan};
use crate::lanes::Work;
use crate::scalar::{Comparison, Real, Scalar, SimdScalar};
use crate::series::{Analytic, Met, Smooth, Switches, TaylorSeries, WINDOW};
use crate::state::{State, Tangent};
use crate::system::System;
use nalgebra::SVector;

/// Room for the coefficients of [`const@Taylor`]: orders up to 22.
pub(crate) const USUAL_ROOM: usize = 24;

/// Room for the coefficients of [`const@LongTaylor`]: orders up to 62.
const LONG_ROOM: usize = 64;

/// The first of them. The very last coefficient of a series is not asked: all of the next step waits for its size,
/// which is found while that one is being computed.
const fn first_asked(p: usize) -> usize {
    p - WINDOW
}

/// Taylor series of a given order, with [`TaylorController`] for its controller.
///
/// A series represents a force of time by its derivatives at the start of the step: see [the module](crate::method) on
/// forces that set in later, and [`TaylorController::max_step`].
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Pendulum {
///         param l, g = 9.81;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -g * l * cos(theta);
///     }
/// }
/// let (pendulum, start) = (Pendulum::new(1.0), State::new(0.0, [2.0], [0.0]));
/// let tolerance = 1e-15;
/// let run = integrate(&pendulum, Taylor, TaylorController::tolerance(tolerance), start);
/// let end = run.until(100.0).final_state()?;
/// let energy = |at: &State<f64, 1>| pendulum.energy(&at.q, &at.qd, at.t);
/// assert!((energy(&end) - energy(&start)).abs() < 1e-13);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// # Hypotheses
/// - The system has series ([`Facts::analytic`](crate::Facts::analytic)): there is no `extern fn`, and no power with
///   an exponent that moves. rustc rejects others.
/// - Between switches accelerations are analytic. Steps end at switches, steps of one size too.
/// - Forces act for a step at least, see [forces that set in later](crate::method#forces-that-set-in-later).
/// - M is regular along the motion: otherwise [`Failure::SingularInertia`].
/// - Constraints stay independent: otherwise [`Failure::DependentConstraints`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Taylor<const ROOM: usize = USUAL_ROOM> {
    /// 0 where the tolerance is to choose it.
    order: usize,
}

/// Taylor series of the order that suits the tolerance of the controller, 7 − ½ ln ε, rounded up, and at most 20: on
/// processors without long vectors the last two orders of larger systems take as long as the ten before. It is 20 where
/// the controller has no relative tolerance.
///
/// Where an order costs what all orders before it do, the order with the least work is `1 − ½ ln ε` (Jorba and Zou,
/// 3.2). A step has costs of its own, and higher orders cost little more than lower ones. (At 1e-9 a pendulum would
/// gain a hundredth by two orders more, lanes 4 % by two less.)
#[allow(non_upper_case_globals)]
pub const Taylor: Taylor = Taylor { order: 0 };

/// Taylor series of orders up to 62, for scalars of more digits than `f64` and tolerances down to 1e-31. It is not
/// made for speed in `f64`: all its coefficients have room for 62 orders.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::{DoubleDouble, method::taylor::LongTaylor};
///
/// lagrangian! {
///     system Oscillator {
///         param k;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * k * x * x;
///     }
/// }
/// let one = DoubleDouble::from(1.0);
/// let oscillator = Oscillator { k: one };
/// let start = State::new(DoubleDouble::from(0.0), [one], [DoubleDouble::from(0.0)]);
/// let run = integrate(&oscillator, LongTaylor, TaylorController::tolerance(1e-30), start);
/// let end = run.until(DoubleDouble::from(10.0)).final_state()?;
/// let error = end.q[0] - DoubleDouble::from(10.0).cos();
/// assert!(error.to_f64().abs() < 1e-28);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub type LongTaylor = Taylor<LONG_ROOM>;

/// [`const@LongTaylor`] of the order that suits the tolerance of the controller, as that of [`const@Taylor`], at most
/// 62.
#[allow(non_upper_case_globals)]
pub const LongTaylor: LongTaylor = Taylor { order: 0 };

impl Taylor {
    /// Series to order p, kept within 8 and 22: shorter ones do not show how they decay.
    pub fn of_order(p: usize) -> Self {
        Taylor::within(p)
    }

    /// Series of the highest order that a tolerance chooses.
    pub(crate) const LONGEST_USUAL: Taylor = Taylor { order: LONGEST };
}

impl LongTaylor {
    /// Series to order p, kept within 8 and 62.
    pub fn with_order(p: usize) -> Self {
        Taylor::within(p)
    }
}

impl<const ROOM: usize> Taylor<ROOM> {
    fn within(p: usize) -> Self {
        Taylor { order: p.clamp(8, ROOM - 2) }
    }

    /// The order of its series.
    #[inline(always)]
    fn terms(&self) -> usize {
        if self.order > 0 { self.order } else { LONGEST }
    }
}

/// The highest order that a tolerance chooses for numbers of the digits of `f64`.
const LONGEST: usize = 20;

fn order_for(tolerance: f64) -> usize {
    let p = 7.0 - 0.5 * libm::log(tolerance);
    let below = p as usize;
    if p > below as f64 { below + 1 } else { below }
}

/// Estimates of a step of [`const@Taylor`]: its error, and the size of the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remainder<S, const N: usize> {
    /// The estimated error of the step.
    error: Tangent<S, N>,
    /// The last coefficients of the series at its end, by orders up to `order`.
    last: [Tangent<S, N>; WINDOW],
    order: usize,
}

impl<S: Scalar, const N: usize> Remainder<S, N> {
    /// The estimated error of the step.
    pub fn error(&self) -> &Tangent<S, N> {
        &self.error
    }
}

/// The coordinates' series at the state reached, and what was lost in rounding it; on which sides of the switches of
/// the system it is, how these move, and at which of them it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize, W: serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>, W: Copy + serde::Deserialize<'de>"
    ))
)]
pub struct MethodState<S, const N: usize, const ROOM: usize, W = Smooth> {
    series: TaylorSeries<S, N, ROOM>,
    lost: Tangent<S, N>,
    sides: W,
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::array"))]
    switching: [W; ROOM],
    begins_at: W,
}

impl<Sys: Analytic<N>, const N: usize, const ROOM: usize> Method<Sys, N> for Taylor<ROOM>
where
    Sys::Scalar: SimdScalar,
{
    type MethodState = MethodState<Sys::Scalar, N, ROOM, Sys::Sides>;
    /// The polynomials of the step.
    type InterpolantData = TaylorSeries<Sys::Scalar, N, ROOM>;
    type Error = Remainder<Sys::Scalar, N>;
    type Interpolant = Polynomial<Sys::Scalar, N, ROOM>;

    fn order(&self) -> u32 {
        self.terms() as u32
    }

    fn for_tolerance(self, relative: Option<f64>) -> Self {
        let longest = if ROOM > USUAL_ROOM { ROOM } else { LONGEST };
        match relative {
            Some(tolerance) if self.order == 0 => Self::within(order_for(tolerance).min(longest)),
            _ => self,
        }
    }

    fn start(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
        let sides = system.sides(at);
        let begins_at = system.switching(at, &sides).vanishing();
        Ok(begin(system, at, self.terms(), sides, begins_at, Tangent::zero()))
    }

    fn turned(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>>
    where
        Sys::Scalar: Real,
    {
        let sides = system.sides(at);
        let begins_at = system.switching(at, &sides).vanishing();
        let lost = attitude::steps::lost(Sys::ATTITUDES, from, &memory.lost, at);
        Ok(begin(system, at, self.terms(), sides, begins_at, lost))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_into(
        &self,
        system: &Sys,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        // (Constants: what follows those that are false is not compiled.)
        if const { Sys::Sides::COUNT == 0 } {
            if Sys::ROOTS && self.begins_at_root::<Sys, N>(memory) {
                return self.step_from_root(system, memory, from, h, next);
            }
            Ok(self.smooth_step(system, memory, from, h, next))
        } else if const { Sys::Scalar::COUNT == 1 } {
            self.step_to_switch(system, memory, from, h, next)
        } else {
            Ok(self.step_between_switches(system, memory, from, h, next))
        }
    }

    /// The step is found by collocation: coefficients of a series lose their digits to rounding, `ε/δᵏ⁺³` at order k
    /// and the distance δ.
    fn step_across(
        &self,
        across: &Across<'_, Sys, N>,
        memory: &Self::MethodState,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::MethodState,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>>
    where
        Sys::Scalar: Real,
    {
        let noise = if across.last { INTERPOLATED } else { ROUNDED };
        let mut step = self.collocated_step(across.system, (across, noise), memory, from, h, next)?;
        let accelerations = across.accel(&step.to.q, &step.to.qd, step.to.t);
        let changes = changes(&step.stages, self.terms(), step.h);
        step.error = remainder(self.terms(), step.h, &changes, |i| accelerations[i]);
        Ok(step)
    }

    #[inline(always)]
    fn interpolant(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
        self.polynomial(step.stages, step.from)
    }

    fn ends_at_switches(&self) -> bool {
        true
    }

    /// Steps are long, and looking at their polynomials is cheap.
    #[inline(always)]
    fn parts(&self, _: &Self::MethodState, _: Sys::Scalar) -> u32 {
        2 * self.terms() as u32
    }

    fn start_evaluations(&self) -> u32 {
        self.terms() as u32
    }
}

impl<const ROOM: usize> Taylor<ROOM> {
    /// The interpolant of a step.
    pub(crate) fn polynomial<S: Scalar, const N: usize>(
        &self,
        series: TaylorSeries<S, N, ROOM>,
        from: State<S, N>,
    ) -> Polynomial<S, N, ROOM> {
        Polynomial { series, order: self.terms(), from }
    }

    /// A step on one side of all switches.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn smooth_step<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> Step<Sys, Self, N>
    where
        Sys::Scalar: SimdScalar,
    {
        // The step that the rounded time makes.
        let t = from.t + h;
        let h = t - from.t;
        let p = self.terms();
        let MethodState { series, lost, sides, .. } = memory;
        let mut to = State { t, ..*from };
        let mut carried = Tangent::zero();
        let changes = changes(series, p, h);
        for i in 0..N {
            (to.q[i], carried.q[i]) = added(from.q[i], changes.q[i] + lost.q[i]);
            (to.qd[i], carried.qd[i]) = added(from.qd[i], changes.qd[i] + lost.qd[i]);
        }
        (next.sides, next.begins_at, next.lost) = (*sides, Sys::Sides::zero(), carried);
        develop(system, &to, p, next);
        let error = next.remainder(p, h, &changes);
        Step { from: *from, to, h, error, stages: *series, evaluations: p as u32 }
    }

    /// Does the series not exist where the step begins? Lanes find out one by one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begins_at_root<Sys: Analytic<N>, const N: usize>(
        &self,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> bool
    where
        Sys::Scalar: SimdScalar,
    {
        Sys::Scalar::COUNT == 1 && !collocation::exists(&memory.series, self.terms())
    }

    /// A step by collocation, on one side of each switch.
    fn step_from_root<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>>
    where
        Sys::Scalar: SimdScalar,
    {
        self.collocated_step(system, (system, ROUNDED), memory, from, h, next)
    }

    /// A step by collocation of the accelerations of `field`, which are known to a multiple of rounding, on one side of
    /// each switch.
    #[inline(never)]
    fn collocated_step<Sys: Analytic<N>, Field: System<N, Scalar = Sys::Scalar>, const N: usize>(
        &self,
        system: &Sys,
        (field, noise): (&Field, f64),
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>>
    where
        Sys::Scalar: SimdScalar,
    {
        let h = (from.t + h) - from.t;
        let polynomial = collocation::collocated(field, from, h, self.terms(), noise)?;
        let at = |i: u32| {
            system.sides(&polynomial.at(from.t + h * Sys::Scalar::from_f64(f64::from(i) / f64::from(LOOKS))))
        };
        let sides = at(LOOKS);
        if memory.sides.left_for(&memory.begins_at, &sides) || (1..LOOKS).any(|i| at(i) != sides) {
            // A switch is crossed within the step: not by much, where it cannot be shorter.
            if size(h).abs() > ROUNDINGS * rounding(from.t, h) {
                return Err(Failure::NonFinite { t: from.t, h });
            }
        }
        let memory = MethodState { series: polynomial.series, sides, ..*memory };
        let mut step = self.smooth_step(system, &memory, from, h, next);
        if const { Sys::Sides::COUNT > 0 } {
            let begins_at = system.switching(&step.to, &sides).vanishing();
            self.goes_on(system, &mut step, sides, begins_at, next);
        }
        if !collocation::exists(&next.series, self.terms()) {
            // It says nothing about the next step, which is tried long.
            step.error.last = [Tangent::zero(); WINDOW];
        }
        Ok(step)
    }

    /// A step that ends where the first switch is crossed, if one is, and is on its other side then.
    fn step_to_switch<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>>
    where
        Sys::Scalar: SimdScalar,
    {
        let p = self.terms();
        let mut memory = *memory;
        // What begins at a switch may have to leave it for one side, and then for the other; every one once.
        for _ in 0..=3 * Sys::Sides::COUNT {
            if Sys::ROOTS && self.begins_at_root::<Sys, N>(&memory) {
                return self.step_from_root(system, &memory, from, h, next);
            }
            let MethodState { sides, switching, begins_at, lost, .. } = &memory;
            let (switch, sides) = match sides.met(switching, begins_at, h, p, 0) {
                None => return Ok(self.step_on_sides(system, &memory, from, h, next)),
                Some(Met::Unknown { share }) => {
                    let short = h * Sys::Scalar::from_f64(share);
                    if Sys::ROOTS && size(short).abs() <= ROUNDINGS * rounding(from.t, short) {
                        // The argument of a root vanishes within rounding.
                        return self.step_from_root(system, &memory, from, h, next);
                    }
                    return Ok(self.step_on_sides(system, &memory, from, short, next));
                }
                Some(Met::Left { switch, sides }) => (switch, sides),
                Some(Met::Crossed { switch, share }) => {
                    let x = h * Sys::Scalar::from_f64(share);
                    let x = self.located(system, &memory, from, [x, h], switch);
                    if from.t + x != from.t {
                        let mut step = self.step_onto_switch(system, &memory, from, x, next);
                        let begins_at = Sys::Sides::zero().marked(switch);
                        self.goes_on(system, &mut step, sides.crossed(switch), begins_at, next);
                        return Ok(step);
                    }
                    let begins_at = begins_at.marked(switch);
                    let beyond = begin(system, from, p, sides.crossed(switch), begins_at, *lost);
                    let x = Sys::Scalar::from_f64((ROUNDINGS * rounding(from.t, h)).copysign(size(h)));
                    if beyond.sides.go_on(&beyond.switching, switch, x, 0) {
                        // It came back to the switch by rounding alone, and the accelerations lead it across.
                        let mut step = self.smooth_step(system, &beyond, from, x, next);
                        self.goes_on(system, &mut step, beyond.sides, begins_at, next);
                        return Ok(step);
                    }
                    memory = beyond;
                    continue;
                }
            };
            memory = begin(system, from, p, sides, begins_at.marked(switch), *lost);
        }
        Err(Failure::Sliding { t: from.t })
    }

    /// A step of size h that meets no switch, by the series of the switching functions. These say nothing beyond
    /// where they converge, as that of
    /// |q| does up to q = 0: a step that ends on another side all the same is made half as long.
    fn step_on_sides<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        mut h: Sys::Scalar,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> Step<Sys, Self, N>
    where
        Sys::Scalar: SimdScalar,
    {
        let MethodState { sides, switching, .. } = memory;
        loop {
            let mut step = self.smooth_step(system, memory, from, h, next);
            if !sides.are_left(switching, &system.switching(&step.to, sides), h, 0) {
                return step;
            }
            if size(h).abs() <= ROUNDINGS * rounding(from.t, h) {
                // The function jumps, as atan2 does: the next step begins on the other side.
                let sides = system.sides(&step.to);
                let begins_at = system.switching(&step.to, &sides).vanishing();
                self.goes_on(system, &mut step, sides, begins_at, next);
                return step;
            }
            h *= Sys::Scalar::from_f64(0.5);
        }
    }

    /// The step after this one begins on these sides, at the switches that are marked.
    fn goes_on<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        step: &mut Step<Sys, Self, N>,
        sides: Sys::Sides,
        begins_at: Sys::Sides,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) where
        Sys::Scalar: SimdScalar,
    {
        *next = begin(system, &step.to, self.terms(), sides, begins_at, next.lost);
        step.error.last = next.last(self.terms());
        step.evaluations += self.terms() as u32;
    }

    /// A step of size h that ends at a switch, within rounding.
    fn step_onto_switch<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        mut h: Sys::Scalar,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> Step<Sys, Self, N>
    where
        Sys::Scalar: SimdScalar,
    {
        let mut step = self.smooth_step(system, memory, from, h, next);
        if Sys::ROOTS {
            // Beyond the switch a root of this side may have no value, and the error of the step would be unknown: it
            // ends just before.
            let mut back = rounding(from.t, h).copysign(size(h));
            while next.series.q[2].iter().any(|x| !size(*x).is_finite()) && back.abs() < size(h).abs() {
                h -= Sys::Scalar::from_f64(back);
                step = self.smooth_step(system, memory, from, h, next);
                back *= 2.0;
            }
        }
        step
    }

    /// A step of lanes. A lane that meets a switch has no end here: it makes its step alone.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_between_switches<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
    ) -> Step<Sys, Self, N>
    where
        Sys::Scalar: SimdScalar,
    {
        let MethodState { sides, switching, begins_at, .. } = memory;
        let mut step = self.smooth_step(system, memory, from, h, next);
        let there = system.switching(&step.to, sides);
        let alone = Sys::Scalar::each(|i| {
            sides.met(switching, begins_at, h, self.terms(), i).is_some()
                || sides.are_left(switching, &there, h, i)
        });
        let nowhere = SVector::from([nan(); N]);
        step.to.q = chosen(&alone, &nowhere, &step.to.q);
        step
    }

    /// The root x of a switching function's series, moved to where the function vanishes on the polynomials of the
    /// step, within its time h. It is not moved by more than half: the function is rounding alone there, as shortly
    /// after a switch that the step begins at.
    fn located<Sys: Analytic<N>, const N: usize>(
        &self,
        system: &Sys,
        memory: &MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
        from: &State<Sys::Scalar, N>,
        [root, h]: [Sys::Scalar; 2],
        switch: usize,
    ) -> Sys::Scalar {
        let half = Sys::Scalar::from_f64(0.5) * root;
        let MethodState { series, sides, switching, .. } = memory;
        let polynomial = self.polynomial(*series, *from);
        let mut x = root;
        for _ in 0..3 {
            let value = system.switching(&polynomial.at(from.t + x), sides).of(switch);
            let mut slope = Sys::Scalar::zero();
            for k in (1..ROOM).rev() {
                slope = slope.mul_add(x, Sys::Scalar::from_f64(k as f64) * switching[k].of(switch));
            }
            let moved = x - value / slope;
            // (At a touch there is no slope to go by, and the difference is NaN.)
            let apart = moved - root;
            x = Sys::Scalar::select(Comparison::LessEqual, apart * apart, half * half, moved, root);
        }
        Sys::Scalar::select(Comparison::Less, h * h, x * h, h, x)
    }
}

mod collocation;
mod control;
mod lanes;

pub use control::TaylorController;

impl<S: Scalar, const N: usize, const ROOM: usize, W> MethodState<S, N, ROOM, W> {
    /// Before the series is known: its coefficients are 0.
    #[inline(always)]
    fn without_series(sides: W, begins_at: W, lost: Tangent<S, N>) -> Self
    where
        W: Switches<S>,
    {
        MethodState { series: TaylorSeries::zero(), lost, sides, switching: [W::zero(); ROOM], begins_at }
    }

    /// Error estimate of the step of size h that led here.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn remainder(&self, p: usize, h: S, changes: &Changes<S, N>) -> Remainder<S, N> {
        let accelerations = self.series.velocities(1);
        Remainder { last: self.last(p), ..remainder(p, h, changes, |i| accelerations[i]) }
    }

    /// The coefficients that tell the size of the next step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn last(&self, p: usize) -> [Tangent<S, N>; WINDOW] {
        let mut last = [Tangent::zero(); WINDOW];
        for w in 0..WINDOW {
            let k = first_asked(p) + w;
            last[w] = Tangent { q: self.series.q[k].into(), qd: self.series.velocities(k).into() };
        }
        last
    }
}

/// The remainder of a step at whose end the accelerations are these. It says nothing about the next step, which is
/// tried long.
#[cfg_attr(not(debug_assertions), inline(always))]
fn remainder<S: Scalar, const N: usize>(
    p: usize,
    h: S,
    changes: &Changes<S, N>,
    accelerations: impl Fn(usize) -> S,
) -> Remainder<S, N> {
    let (weight, weight_next) = (S::from_f64(1.0 / (p + 1) as f64), h / S::from_f64((p + 2) as f64));
    let mut error = Tangent::zero();
    for i in 0..N {
        error.qd[i] = (changes.kick[i] - h * accelerations(i)) * weight;
        error.q[i] = error.qd[i] * weight_next;
    }
    Remainder { error, last: [Tangent::zero(); WINDOW], order: p }
}

/// Places of a step from a root at which switching functions are looked at.
const LOOKS: u32 = 32;

/// Roundings of time within which a step cannot resolve how a root begins.
const ROUNDINGS: f64 = 64.0;

/// Multiples of rounding to which accelerations are known: those of a system, and those that are interpolated across
/// states at which constraints are dependent.
const ROUNDED: f64 = 64.0;
const INTERPOLATED: f64 = 1e5;

/// The value of a scalar that has one number.
fn size<S: SimdScalar>(x: S) -> f64 {
    x.number(0).to_f64()
}

/// The rounding of the time after a step of size h from t.
fn rounding<S: SimdScalar>(t: S, h: S) -> f64 {
    S::Element::EPSILON * size(t).abs().max(size(h).abs())
}

/// Memory with which a step begins.
#[cfg_attr(not(debug_assertions), inline(always))]
fn begin<Sys: Analytic<N>, const N: usize, const ROOM: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    order: usize,
    sides: Sys::Sides,
    begins_at: Sys::Sides,
    lost: Tangent<Sys::Scalar, N>,
) -> MethodState<Sys::Scalar, N, ROOM, Sys::Sides> {
    let mut memory = MethodState::without_series(sides, begins_at, lost);
    develop(system, at, order, &mut memory);
    memory
}

/// Finds the series of a memory. Not inlined: they would be compiled at each place where steps begin.
#[inline(never)]
fn develop<Sys: Analytic<N>, const N: usize, const ROOM: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    order: usize,
    memory: &mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
) {
    let recurrences = Recurrences { system, at, order, memory };
    if Sys::LONG { Sys::Scalar::evaluate(recurrences) } else { Sys::Scalar::evaluate_long(recurrences) }
}

/// The series of a motion, as [`Work`] that is done in its place.
struct Recurrences<'a, Sys: Analytic<N>, const N: usize, const ROOM: usize> {
    system: &'a Sys,
    at: &'a State<Sys::Scalar, N>,
    order: usize,
    memory: &'a mut MethodState<Sys::Scalar, N, ROOM, Sys::Sides>,
}

impl<Sys: Analytic<N>, const N: usize, const ROOM: usize> Work for Recurrences<'_, Sys, N, ROOM> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let MethodState { series, sides, switching, .. } = self.memory;
        *switching = self.system.series_within(self.at, self.order, sides, series);
    }
}

/// The sum of two numbers and what it lacks (Knuth, *The Art of Computer Programming* 2, 4.2.2, theorem B).
#[inline(always)]
fn added<S: Scalar>(a: S, b: S) -> (S, S) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Values that depend on h.
struct Changes<S, const N: usize> {
    q: [S; N],
    qd: [S; N],
    /// h q̈ at the end.
    kick: [S; N],
}

/// Factors of x_k hᵏ⁻¹ in the change of ẋ and in h ẍ: k and k (k − 1).
const WEIGHTS: [[f64; 2]; LONG_ROOM] = {
    let mut weights = [[0.0; 2]; LONG_ROOM];
    let mut k = 0;
    while k < LONG_ROOM {
        weights[k] = [k as f64, (k * k) as f64 - k as f64];
        k += 1;
    }
    weights
};

/// First order whose terms are summed beside those of lower ones.
const LATE: usize = 10;

/// The changes of q and q̇ after h, and h q̈ there, for `q = Σ q_k hᵏ` with k up to p + 1. From lower orders to
/// higher ones, and not by Horner's rule: what was found last is added last, since the next step waits for it. The
/// terms to the third, whose rounding counts, are added to the sum of all others; of these every second one is summed
/// beside the others. Terms of [`LATE`] orders have sums of their own: beside those of the fourth the last ones are
/// less than half a unit in the last place, and would be left out every time, with the sign that they have there.
#[cfg_attr(not(debug_assertions), inline(always))]
fn changes<S: Scalar, const N: usize, const ROOM: usize>(
    series: &TaylorSeries<S, N, ROOM>,
    p: usize,
    h: S,
) -> Changes<S, N> {
    let square = h * h;
    let end = (p + 2).min(ROOM).min(LONG_ROOM).div_ceil(2);
    let mut powers = [square * h, square * square];
    let mut early = [[[S::zero(); N]; 3]; 2];
    let mut late = early;
    let mut m = 2;
    while m < LATE / 2 {
        add(&mut early, series, m, &mut powers, square);
        m += 1;
    }
    while m < end {
        add(&mut late, series, m, &mut powers, square);
        m += 1;
    }
    let mut changes = Changes { q: [S::zero(); N], qd: [S::zero(); N], kick: [S::zero(); N] };
    let [two, three, six] = [2.0, 3.0, 6.0].map(S::from_f64);
    for i in 0..N {
        let mut rest = [S::zero(); 3];
        for of in 0..3 {
            rest[of] = (early[0][of][i] + early[1][of][i]) + (late[0][of][i] + late[1][of][i]);
        }
        let (second, third) = (series.q[2][i] * h, series.q[3][i] * square);
        changes.q[i] = (series.q[1][i] + (second + third + rest[0])) * h;
        changes.qd[i] = three.mul_add(third, two * second) + rest[1];
        changes.kick[i] = six.mul_add(third, two * second) + rest[2];
    }
    changes
}

/// Adds the terms of orders 2m and 2m + 1.
#[cfg_attr(not(debug_assertions), inline(always))]
fn add<S: Scalar, const N: usize, const ROOM: usize>(
    sums: &mut [[[S; N]; 3]; 2],
    series: &TaylorSeries<S, N, ROOM>,
    m: usize,
    powers: &mut [S; 2],
    square: S,
) {
    for rest in 0..2 {
        let k = 2 * m + rest;
        if ROOM.is_multiple_of(2) || k < ROOM {
            let [q, qd, kick] = &mut sums[rest];
            for i in 0..N {
                let term = series.q[k][i] * powers[rest];
                q[i] += term;
                qd[i] = S::from_f64(WEIGHTS[k][0]).mul_add(term, qd[i]);
                kick[i] = S::from_f64(WEIGHTS[k][1]).mul_add(term, kick[i]);
            }
        }
        powers[rest] *= square;
    }
}

/// The polynomials of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomial<S, const N: usize, const ROOM: usize> {
    series: TaylorSeries<S, N, ROOM>,
    order: usize,
    from: State<S, N>,
}

impl<S: Scalar, const N: usize, const ROOM: usize> Interpolant<S, N> for Polynomial<S, N, ROOM> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let h = t - self.from.t;
        let mut state = State { t, ..self.from };
        let changes = changes(&self.series, self.order, h);
        for i in 0..N {
            state.q[i] += changes.q[i];
            state.qd[i] += changes.qd[i];
        }
        state
    }
}

#[cfg(test)]
mod tests;
