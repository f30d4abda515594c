//! Functions with data of their own, which are fields of a system.

use crate::scalar::{Comparison, Scalar};
use core::fmt::Debug;

/// A function of A arguments with data of its own: a `Curve`, a `Surface`, or a type of the program.
/// `extern wind: Curve(t);` makes a field `wind` of the system, which is given with the value of the system, and
/// `wind(t)` its value in formulas. Derivatives are taken by dual numbers, so the function is generic over the scalar;
/// it shall have continuous ones, of as many orders as a method needs.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::traits::ExternFunction;
///
/// /// Gusts a sin(ωᵢ t).
/// #[derive(Clone, Debug, PartialEq)]
/// pub struct Gusts {
///     pub speed: f64,
///     pub frequencies: Vec<f64>,
/// }
///
/// impl ExternFunction<1> for Gusts {
///     fn value<S: Scalar>(&self, [t]: [S; 1]) -> S {
///         let gust = |sum: S, w: &f64| sum + (t * S::from_f64(*w)).sin();
///         S::from_f64(self.speed) * self.frequencies.iter().fold(S::zero(), gust)
///     }
/// }
///
/// lagrangian! {
///     system Mast {
///         param m, k, c;
///         coord x;
///         /// The wind against it.
///         extern wind: Gusts(t);
///         T = 0.5 * m * dot(x).powi(2);
///         V = 0.5 * k * x.powi(2);
///         Q[x] = c * (wind(t) - dot(x));
///     }
/// }
/// let mast = Mast::new(2.0, 50.0, 0.3, Gusts { speed: 4.0, frequencies: vec![3.0, 7.0] });
/// let start = State::new(0.0, [0.0], [0.0]);
/// let end = integrate(&mast, Dop853, PiController::tolerance(1e-10), start).until(5.0).final_state()?;
/// assert!(end.q[0].abs() < 0.5);
/// # Ok::<(), Failure>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a function of {A} argument(s)",
    label = "`extern` needs a type that implements `ExternFunction<{A}>`",
    note = "`Curve` is a function of one argument and `Surface` of two; a type of your own implements `ExternFunction`, `Clone`, `Debug` and `PartialEq`"
)]
pub trait ExternFunction<const A: usize>: Clone + Debug + PartialEq {
    /// The value at x, in the unit that the equations of the system expect; x in the units of the arguments.
    fn value<S: Scalar>(&self, x: [S; A]) -> S;

    /// Does a slope jump somewhere, as that of chords does at their knots? A momentum that depends on the slope jumps
    /// there, too, and runs of the system are [`Unsuitable`](crate::Failure::Unsuitable): an impulse acts there, which
    /// the equations of motion do not have.
    fn has_kinks(&self) -> bool {
        false
    }

    /// The values, in the unit of the function, in lanes with a function each, `of_lane(0)` to `of_lane(count − 1)`. A
    /// type that looks up the data of each lane does so in one evaluation; without that it takes one for each lane.
    #[inline]
    fn side_by_side<'a, S: Scalar>(count: usize, of_lane: impl Fn(usize) -> &'a Self, x: [S; A]) -> S
    where
        Self: 'a,
    {
        let mut value = of_lane(0).value(x);
        for lane in 1..count {
            let [here] = S::lookup(x, |i, _| [if i == lane { 1.0 } else { 0.0 }]);
            value = S::select(Comparison::Equal, here, S::one(), of_lane(lane).value(x), value);
        }
        value
    }
}

/// The data of the functions of systems in lanes, in the order of these; nothing where a system is alone.
#[cfg(feature = "std")]
#[derive(Clone, Debug, PartialEq)]
pub struct DataInLanes<D>(Vec<D>);

/// Nothing: there are no lanes without the standard library.
#[cfg(not(feature = "std"))]
#[derive(Clone, Debug, PartialEq)]
pub struct DataInLanes<D>(core::marker::PhantomData<D>);

impl<D: Clone> DataInLanes<D> {
    /// Data of a system alone.
    #[cfg(feature = "std")]
    pub const NONE: Self = DataInLanes(Vec::new());
    /// Data of a system alone.
    #[cfg(not(feature = "std"))]
    pub const NONE: Self = DataInLanes(core::marker::PhantomData);

    /// Gives a lane its data.
    pub fn set(&mut self, lane: usize, data: D) {
        #[cfg(feature = "std")]
        {
            // Lanes that come later have these until they have their own.
            self.0.resize(self.0.len().max(lane + 1), data.clone());
            self.0[lane] = data;
        }
        #[cfg(not(feature = "std"))]
        let _ = (lane, data);
    }

    /// The value of the function of a single system, or the values of the functions of all lanes, in the unit of the
    /// function.
    #[inline]
    pub fn value<F: ExternFunction<A>, S: Scalar, const A: usize>(
        &self,
        alone: &F,
        of: impl Fn(&D) -> &F,
        x: [S; A],
    ) -> S {
        #[cfg(feature = "std")]
        if let Some(last) = self.0.len().checked_sub(1) {
            return F::side_by_side(last + 1, |lane| of(&self.0[lane.min(last)]), x);
        }
        let _ = of;
        alone.value(x)
    }
}
