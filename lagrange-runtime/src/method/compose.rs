//! Compositions: a symmetric method of order 2, made into one of order 4, 6, 8 or 10.
//!
//! `Ψ_h = Φ_{γₛh} ∘ … ∘ Φ_{γ₁h}` with `γₛ₊₁₋ᵢ = γᵢ` is symmetric again, and symplectic where Φ is. As
//! `Φ_h = exp(h A + h³ B + h⁵ C + …)`, order 4 takes `Σγᵢ = 1` and `Σγᵢ³ = 0`, order 6 also `Σγᵢ⁵ = 0` and one condition
//! more, and so on (Yoshida 1990; Hairer, Lubich, Wanner, *Geometric Numerical Integration*, 2006, II.4, III.3.3, V.3.2).
//! From order 3 on some γ are negative: the motion has to be one that can be followed backward for a while.
//!
//! A new composition is a new row, tested for its order, for symplecticity and for symmetry without further ado. For
//! separable systems, [`splitting`](super::splitting) has methods with smaller errors.

use super::hermite::{Birkhoff, Hermite};
use super::{Method, Step};
use crate::controller::NoEstimate;
use crate::failure::Failure;
use crate::scalar::Scalar;
use crate::state::State;
use crate::system::System;

/// Marker: a method of order 2 that is its own inverse with the step reversed, `Φ₋ₕ ∘ Φₕ = 1`. Compositions need it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a symmetric method of order 2, and cannot be composed",
    note = "compose `Verlet`, `PositionVerlet` or `ImplicitMidpoint`"
)]
pub trait Symmetric {}

impl Symmetric for super::splitting::Verlet {}
impl Symmetric for super::splitting::PositionVerlet {}
impl Symmetric for super::gauss::ImplicitMidpoint {}
impl Symmetric for super::variational::VariationalMidpoint {}
impl Symmetric for super::variational::VariationalTrapezoid {}

/// The coefficients of a composition.
pub trait Coefficients {
    /// Name and source.
    const NAME: &'static str;
    /// Order of convergence.
    const ORDER: u32;
    /// γᵢ, which are as many from the front as from the back.
    const GAMMA: &'static [f64];
}

/// A symmetric method of order 2, composed with the given coefficients.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::{Compose, KahanLi8};
/// lagrangian! {
///     system Pendulum {
///         coord theta;
///         T = 0.5 * dot(theta).powi(2);
///         V = -cos(theta);
///     }
/// }
/// let (system, start) = (Pendulum::new(), State::new(0.0, [0.0], [1.0]));
/// let method = Compose(Verlet, KahanLi8);
/// let end = integrate(&system, method, Fixed::new(0.2), start).until(1000.0).finish()?;
/// let energy = |at: &State<f64, 1>| system.energy(&at.q, &at.qd, at.t);
/// assert!((energy(&end) - energy(&start)).abs() < 1e-10);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// A method that is not symmetric does not compile:
///
/// ```compile_fail,E0277
/// # use lagrange_runtime::{Compose, KahanLi8, prelude::*};
/// # struct Oscillator;
/// # impl System<1> for Oscillator {
/// #     type Scalar = f64;
/// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
/// #         -q
/// #     }
/// # }
/// # let start = State::new(0.0, [1.0], [0.0]);
/// let run = integrate(&Oscillator, Compose(Rk4, KahanLi8), Fixed::new(0.1), start);
/// ```
///
/// States inside of a step are interpolated through its ends and, from order 6 on, through accelerations in between
/// ([`Birkhoff`]; eight evaluations): with the order 9 in q and 8 in q̇ where forces do not depend on q̇, else 7 and 6.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compose<Base, Row>(pub Base, pub Row);

impl<Sys, Base, Row, const N: usize> Method<Sys, N> for Compose<Base, Row>
where
    Sys: System<N>,
    Base: Method<Sys, N, Error = NoEstimate> + Symmetric,
    Row: Coefficients,
{
    /// What the first step of the base method needs.
    type Memory = Base::Memory;
    type Stages = ();
    type Error = NoEstimate;
    type Dense = Birkhoff<Sys::Scalar, N>;

    fn order(&self) -> u32 {
        Row::ORDER
    }

    fn implicit(&self) -> bool {
        self.0.implicit()
    }

    fn start(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Result<Self::Memory, Failure<Sys::Scalar>> {
        self.0.start(system, at)
    }

    fn start_evaluations(&self) -> u32 {
        self.0.start_evaluations()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(
        &self,
        system: &Sys,
        memory: &Self::Memory,
        from: &State<Sys::Scalar, N>,
        h: Sys::Scalar,
        next: &mut Self::Memory,
    ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
        let (mut to, mut memory, mut evaluations) = (*from, memory.clone(), 0);
        for &gamma in Row::GAMMA {
            let step = self.0.step(system, &memory, &to, h * Sys::Scalar::from_f64(gamma), next)?;
            (to, memory) = (step.to, next.clone());
            evaluations += step.evaluations;
        }
        // What the parts of h add up to is h but for rounding.
        to.t = from.t + h;
        Ok(Step { from: *from, to, h, error: NoEstimate, stages: (), evaluations })
    }

    #[inline(always)]
    fn dense(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
        let [from, to] = [&step.from, &step.to].map(|end| system.accel(&end.q, &end.qd, end.t));
        let quintic = Hermite::new(&step.from, &step.to, step.h, &from, &to);
        Birkhoff::new(system, quintic, passes(Row::ORDER))
    }

    fn dense_evaluations(&self) -> u32 {
        if passes(Row::ORDER) == 0 { 2 } else { 8 }
    }
}

/// The quintic interpolant is good enough for order 4.
fn passes(order: u32) -> u32 {
    if order > 4 { 2 } else { 0 }
}

macro_rules! compositions {
    ($(
        $(#[$doc:meta])*
        $name:ident(order $order:literal, $source:literal) { $($gamma:expr),* ; $middle:expr }
    )*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
            pub struct $name;

            impl Coefficients for $name {
                const NAME: &'static str = concat!(stringify!($name), ", ", $source);
                const ORDER: u32 = $order;
                const GAMMA: &'static [f64] = &mirrored::<{ 2 * [$($gamma),*].len() + 1 }>(&[$($gamma),*], $middle);
            }
        )*

        /// `check!(row)` for every composition.
        #[cfg(test)]
        macro_rules! for_each_composition {
            ($check:ident) => { $( $check!($name); )* };
        }
    };
}

/// `γ₁ … γₖ`, the middle one, `γₖ … γ₁`.
const fn mirrored<const S: usize>(first: &[f64], middle: f64) -> [f64; S] {
    let mut all = [middle; S];
    let mut i = 0;
    while i < first.len() {
        all[i] = first[i];
        all[S - 1 - i] = first[i];
        i += 1;
    }
    all
}

compositions! {
    /// Order 4 in three steps, `γ₁ = 1/(2 − ∛2)` (Creutz and Gocksch 1989; Forest 1989; Suzuki 1990; Yoshida 1990): the
    /// cheapest step, and the largest error. [`Suzuki4`] is better at equal cost.
    TripleJump(order 4, "Yoshida 1990") { 1.3512071919596578; -1.7024143839193153 }

    /// Order 4 in five steps, `γ₁ = γ₂ = 1/(4 − ∛4)` (Suzuki 1990).
    Suzuki4(order 4, "Suzuki 1990") { 0.4144907717943757, 0.4144907717943757; -0.6579630871775028 }

    /// Order 6 in seven steps (Yoshida 1990, solution A). [`KahanLi6`] is better at equal cost.
    Yoshida6(order 6, "Yoshida 1990") {
        0.7845136104775573, 0.23557321335935813, -1.177679984178871; 1.3151863206839112
    }

    /// Order 6 in nine steps (Kahan and Li 1997, s9odr6a).
    KahanLi6(order 6, "Kahan and Li 1997") {
        0.3921614440073141, 0.33259913678935943, -0.7062461725576393, 0.0822135962935508;
        0.79854399093483
    }

    /// Order 8 in fifteen steps (Suzuki and Umeno 1993; McLachlan 1995). [`KahanLi8`] is better at equal cost.
    SuzukiUmeno8(order 8, "Suzuki and Umeno 1993") {
        0.741670364350613, -0.4091008258000316, 0.1907547102962384, -0.5738624711160822,
        0.2990641813036559, 0.33462491824529816, 0.3152930923967666; -0.7968879393529164
    }

    /// Order 8 in seventeen steps (Kahan and Li 1997, s17odr8b).
    KahanLi8(order 8, "Kahan and Li 1997") {
        0.13020248308889007, 0.5611629817751084, -0.38947496264484727, 0.1588419065551556,
        -0.39590389413323757, 0.1845396409783157, 0.25837438768632204, 0.2950117236093103;
        -0.6055085338300346
    }

    /// Order 10 in thirty-three steps (Hairer, Lubich and Wanner 2002, and their code `gni_comp`), for steps whose error shall be rounding.
    HairerLubichWanner10(order 10, "Hairer, Lubich and Wanner 2002") {
        0.09040619368607279, 0.5359181595303012, 0.3512325754749398, -0.3111680209781584,
        -0.5255631419426351, 0.1444790941022525, 0.029835886097482358, 0.17786179923739806,
        0.09826906939341638, 0.4617998621041186, -0.3337784559988185, 0.07095684836524793,
        0.2366696007012687, -0.4972597795066099, -0.3039961661723726, 0.052469571881000696;
        0.44373380805019086
    }
}

#[cfg(test)]
mod tests;
