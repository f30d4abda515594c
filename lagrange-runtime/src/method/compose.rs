//! Compositions: a symmetric method of order 2, made into one of order 4, 6, 8 or 10.
//!
//! `Ψ_h = Φ_{γₛh} ∘ … ∘ Φ_{γ₁h}` with `γₛ₊₁₋ᵢ = γᵢ` is symmetric again, and symplectic where Φ is. As
//! `Φ_h = exp(h A + h³ B + h⁵ C + …)`, order 4 takes `Σγᵢ = 1` and `Σγᵢ³ = 0`, order 6 also `Σγᵢ⁵ = 0` and one
//! condition more, and so on (Yoshida 1990; Hairer, Lubich, Wanner, *Geometric Numerical Integration*, 2006, II.4,
//! III.3.3, V.3.2). From order 3 on some γ are negative: the motion has to be one that can be followed backward for a
//! while.
//!
//! A new composition is a new row, tested for its order, for symplecticity and for symmetry without further ado. For
//! separable systems, [`splitting`](super::splitting) has methods with smaller errors. Coefficients are the roots of
//! the order conditions to 36 digits, found by Newton's method from the published ones.

#![allow(clippy::excessive_precision)]

use super::hermite::{Birkhoff, Hermite};
use super::{Method, Step};
use crate::controller::NoEstimate;
use crate::failure::Failure;
use crate::scalar::DoubleDouble;
use crate::scalar::double_double::digits::{exact, exact_row};
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
impl<const M: usize> Symmetric for super::variational::ConstrainedMidpoint<M> {}

/// The coefficients of a composition.
pub trait Coefficients {
    /// Name and source.
    const NAME: &'static str;
    /// Order of convergence.
    const ORDER: u32;
    /// γᵢ, with all digits; the same from the front as from the back.
    const GAMMA: &'static [DoubleDouble];
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
/// let end = integrate(&system, method, FixedStep::new(0.2), start).until(1000.0).final_state()?;
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
/// let run = integrate(&Oscillator, Compose(Rk4, KahanLi8), FixedStep::new(0.1), start);
/// ```
///
/// States inside of a step are interpolated through its ends and, from order 6 on, through accelerations in between
/// ([`Birkhoff`]; eight evaluations): with the order 9 in q and 8 in q̇ where forces do not depend on q̇, else 7 and 6.
///
/// # Hypotheses
/// - Those of the method that is composed.
/// - That method is time-symmetric: rustc rejects others.
/// - Steps are of one size: rustc rejects [`PiController`](crate::PiController), since there is no estimate of the
///   error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Compose<Base, Row>(pub Base, pub Row);

impl<Sys, Base, Row, const N: usize> Method<Sys, N> for Compose<Base, Row>
where
    Sys: System<N>,
    Base: Method<Sys, N, Error = NoEstimate> + Symmetric,
    Row: Coefficients,
{
    /// Memory of the first step of the base method.
    type MethodState = Base::MethodState;
    type InterpolantData = ();
    type Error = NoEstimate;
    type Interpolant = Birkhoff<Sys::Scalar, N>;

    fn order(&self) -> u32 {
        Row::ORDER
    }

    fn implicit(&self) -> bool {
        self.0.implicit()
    }

    fn start(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
        self.0.start(system, at)
    }

    fn start_evaluations(&self) -> u32 {
        self.0.start_evaluations()
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
        let (mut to, mut memory, mut evaluations) = (*from, memory.clone(), 0);
        for &gamma in Row::GAMMA {
            let step = self.0.step_into(system, &memory, &to, h * gamma.to(), next)?;
            (to, memory) = (step.to, next.clone());
            evaluations += step.evaluations;
        }
        // What the parts of h add up to is h but for rounding.
        to.t = from.t + h;
        Ok(Step { from: *from, to, h, error: NoEstimate, stages: (), evaluations })
    }

    #[inline(always)]
    fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
        let [from, to] = [&step.from, &step.to].map(|end| system.accel(&end.q, &end.qd, end.t));
        let quintic = Hermite::new(&step.from, &step.to, step.h, &from, &to);
        Birkhoff::new(system, quintic, passes(Row::ORDER))
    }

    fn interpolant_evaluations(&self, dense: &Self::Interpolant) -> u32 {
        2 + dense.evaluations()
    }
}

/// The quintic interpolant is good enough for order 4.
fn passes(order: u32) -> u32 {
    if order > 4 { 2 } else { 0 }
}

macro_rules! compositions {
    ($(
        $(#[$doc:meta])*
        $name:ident(order $order:literal, $source:literal) {
            $($gamma:expr $(=> $digits:expr)?),*; $middle:expr $(=> $all:expr)?
        }
    )*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
            #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct $name;

            impl Coefficients for $name {
                const NAME: &'static str = concat!(stringify!($name), ", ", $source);
                const ORDER: u32 = $order;
                const GAMMA: &'static [DoubleDouble] = &mirrored::<{ 2 * [$($gamma),*].len() + 1 }>(
                    &exact_row![$($gamma $(=> $digits)?),*],
                    exact!($middle $(=> $all)?),
                );
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
const fn mirrored<const S: usize>(first: &[DoubleDouble], middle: DoubleDouble) -> [DoubleDouble; S] {
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
    TripleJump(order 4, "Yoshida 1990") {
        1.3512071919596578 => 1.35120719195965763404768780897146083;
        -1.70241438391931526809537561794292165
    }

    /// Order 4 in five steps, `γ₁ = γ₂ = 1/(4 − ∛4)` (Suzuki 1990).
    Suzuki4(order 4, "Suzuki 1990") {
        0.414490771794375737142354062860761496, 0.414490771794375737142354062860761496;
        -0.6579630871775028 => -0.657963087177502948569416251443045983
    }

    /// Order 6 in seven steps (Yoshida 1990, solution A). [`KahanLi6`] is better at equal cost.
    Yoshida6(order 6, "Yoshida 1990") {
        0.784513610477557263819497633866349876, 0.235573213359358133684793182978534602,
        -1.17767998417887100694641568096431573;
        1.31518632068391121888424972823886251
    }

    /// Order 6 in nine steps (Kahan and Li 1997, s9odr6a).
    KahanLi6(order 6, "Kahan and Li 1997") {
        0.392161444007314127846751522747635602, 0.332599136789359452984032209414777976,
        -0.706246172557639359430021790561840616, 0.082213596293550796899762881874946925;
        0.798543990934829963398950353048960226
    }

    /// Order 8 in fifteen steps (Suzuki and Umeno 1993; McLachlan 1995). [`KahanLi8`] is better at equal cost.
    SuzukiUmeno8(order 8, "Suzuki and Umeno 1993") {
        0.741670364350612953448227801783806316, -0.409100825800031593997300095893563417,
        0.190754710296238379953876256450371663, -0.573862471116082266656387726635535742,
        0.299064181303655923844463540688602988, 0.334624918245298183784957979882182289,
        0.315293092396766596632056663811002431;
        -0.796887939352916354019788840173733053
    }

    /// Order 8 in seventeen steps (Kahan and Li 1997, s17odr8b).
    KahanLi8(order 8, "Kahan and Li 1997") {
        0.130202483088890079407616866354607418, 0.561162981775108384549228694059917497,
        -0.389474962644847282764928783645776432, 0.158841906555155601577206593322283789,
        -0.395903894133237580225861336845271524, 0.184539640978315708376395346202232581,
        0.258374387686322048487166700228989213, 0.295011723609310296442636459990376824;
        -0.605508533830034511698921079334718733
    }

    /// Order 10 in thirty-three steps (Hairer, Lubich and Wanner 2002, and their code `gni_comp`), for steps whose
    /// error shall be rounding.
    HairerLubichWanner10(order 10, "Hairer, Lubich and Wanner 2002") {
        0.0904061936860727849100661138554793123, 0.535918159530301202055767863645461989,
        0.351232575474939781888775679907041569, -0.311168020978158354254566853039569703,
        -0.525563141942635104224320570251250827, 0.144479094102252476510401770740273496,
        0.0298358860974823596854539954315849818, 0.177861799237398052083656357497995551,
        0.09826906939341638 => 0.0982690693934163744330338371585731058,
        0.461799862104118608768016140993104465, -0.333778455998818513214516831805262715,
        0.0709568483652479360439757162635003463, 0.236669600701268687921390378461715347,
        -0.497259779506609854427009258973258725, -0.303996166172372573596745061811853969,
        0.0524695718810006957015185360264839153;
        0.443733808050190879430204371799963723
    }
}

#[cfg(test)]
mod tests;
