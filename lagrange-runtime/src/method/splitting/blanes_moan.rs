//! Symmetric splittings with optimised coefficients: `b₀` kick, `a₁` drift, `b₁` kick, …, `aₛ` drift, `bₛ` kick.
//!
//! As kicks depend on q alone and T is quadratic, `[V, [V, [V, T]]] = 0`; so fewer conditions have to be met than for
//! any other splitting, and the freedom left makes errors small (Blanes and Moan, "Practical symplectic partitioned
//! Runge–Kutta and Runge–Kutta–Nyström methods", *Journal of Computational and Applied Mathematics* 142, 2002, table
//! 3). Behind the published digits stand those of the root of the order conditions next to them.

#![allow(clippy::excessive_precision)]

use crate::controller::NoEstimate;
use crate::failure::Failure;
use crate::method::hermite::{Birkhoff, Hermite};
use crate::method::newton::accelerations;
use crate::method::{Method, Step};
use crate::scalar::double_double::digits::exact_row;
use crate::scalar::{DoubleDouble, SimdScalar};
use crate::state::{State, add_scaled};
use crate::system::Separable;
use nalgebra::SVector;

macro_rules! splittings {
    ($(
        $(#[$doc:meta])*
        $name:ident(order $order:literal, $evaluations:literal evaluations) {
            drift [$($drift:expr $(=> $a:expr)?),*];
            kick [$($kick:expr $(=> $b:expr)?),*];
        }
    )*) => {$(
        $(#[$doc])*
        ///
        /// # Hypotheses
        /// - T(q̇) + V(q, t) splits ([`Facts::separable`](crate::Facts::separable)): rustc rejects other systems.
        /// - Steps are of one size: rustc rejects [`PiController`](crate::PiController), since there is no estimate
        ///   of the error.
        /// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows;
        ///   steps of one size go over them, with an error of order h where forces jump and h² where they have a
        ///   kink.
        /// - h times the highest frequency is below the bound of stability: beyond it motions grow without a word.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name;

        impl $name {
            const DRIFT: [DoubleDouble; $evaluations] = exact_row![$($drift $(=> $a)?),*];
            const KICK: [DoubleDouble; $evaluations + 1] = exact_row![$($kick $(=> $b)?),*];
        }

        impl<Sys: Separable<N>, const N: usize> Method<Sys, N> for $name
        where
            Sys::Scalar: SimdScalar,
        {
            /// The accelerations where the step begins.
            type MethodState = SVector<Sys::Scalar, N>;
            /// The accelerations at both ends.
            type InterpolantData = [SVector<Sys::Scalar, N>; 2];
            type Error = NoEstimate;
            type Interpolant = Birkhoff<Sys::Scalar, N>;

            fn order(&self) -> u32 {
                $order
            }

            fn start(
                &self,
                system: &Sys,
                at: &State<Sys::Scalar, N>,
            ) -> Result<Self::MethodState, Failure<Sys::Scalar>> {
                accelerations(system, at)
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
                let part = |x: DoubleDouble| h * x.to();
                let (mut to, mut qdd) = (*from, *memory);
                to.qd = add_scaled(&to.qd, part(Self::KICK[0]), &qdd);
                for i in 0..$evaluations {
                    to.q = add_scaled(&to.q, part(Self::DRIFT[i]), &to.qd);
                    to.t += part(Self::DRIFT[i]);
                    qdd = system.accel(&to.q, &to.qd, to.t);
                    to.qd = add_scaled(&to.qd, part(Self::KICK[i + 1]), &qdd);
                }
                to.t = from.t + h;
                *next = qdd;
                let (error, evaluations) = (NoEstimate, $evaluations);
                Ok(Step { from: *from, to, h, error, stages: [*memory, qdd], evaluations })
            }

            #[inline(always)]
            fn interpolant(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
                let quintic = Hermite::new(&step.from, &step.to, step.h, &step.stages[0], &step.stages[1]);
                Birkhoff::new(system, quintic, if $order > 4 { 1 } else { 0 })
            }

            fn interpolant_evaluations(&self, dense: &Self::Interpolant) -> u32 {
                dense.evaluations()
            }
        }
    )*};
}

splittings! {
    /// Order 4 with six evaluations per step, `SRKN₆ᵇ` of Blanes and Moan (2002): symplectic, time-symmetric, and far
    /// more accurate than other splittings of order 4 at equal cost.
    BlanesMoan4(order 4, 6 evaluations) {
        drift [
            0.245298957184271 => 0.245298957184271123448654456278339537,
            0.60487266571108 => 0.604872665711079923626184329892574009,
            -0.350171622895351 => -0.350171622895351047074838786170913546,
            -0.350171622895351 => -0.350171622895351047074838786170913546,
            0.60487266571108 => 0.604872665711079923626184329892574009,
            0.245298957184271 => 0.245298957184271123448654456278339537
        ];
        kick [
            0.0829844064174052 => 0.0829844064174049823348985673132206823,
            0.396309801498368 => 0.396309801498368061853954643707040707,
            -0.0390563049223486 => -0.0390563049223484373343056534292002732,
            0.1195241940131508 => 0.119524194013150786290904884817877768,
            -0.0390563049223486 => -0.0390563049223484373343056534292002732,
            0.396309801498368 => 0.396309801498368061853954643707040707,
            0.0829844064174052 => 0.0829844064174049823348985673132206823
        ];
    }

    /// Order 6 with eleven evaluations per step, `SRKN₁₁ᵇ` of Blanes and Moan (2002): symplectic and time-symmetric.
    /// Its interpolant ([`Birkhoff`]) takes two evaluations and is of order 7 in q and 6 in q̇.
    BlanesMoan6(order 6, 11 evaluations) {
        drift [
            0.123229775946271 => 0.123229775946271150160107599065871561,
            0.290553797799558 => 0.290553797799558291152409937071794928,
            -0.127049212625416997256887809146396643,
            -0.246331761062075 => -0.246331761062075435712706454932311042,
            0.357208872795928 => 0.357208872795927863335770075247403627,
            0.20477705429147 => 0.204777054291470256642613305387275138,
            0.357208872795928 => 0.357208872795927863335770075247403627,
            -0.246331761062075 => -0.246331761062075435712706454932311042,
            -0.127049212625416997256887809146396643,
            0.290553797799558 => 0.290553797799558291152409937071794928,
            0.123229775946271 => 0.123229775946271150160107599065871561
        ];
        kick [
            0.0414649985182624 => 0.0414649985182628422825448269215629117,
            0.198128671918067 => 0.198128671918066525889007158161785511,
            -0.0400061921041533 => -0.0400061921041526927808993025538909353,
            0.0752539843015807 => 0.0752539843015803094497521237182370284,
            -0.0115113874206879 => -0.0115113874206877560438088500209763826,
            0.2366699247869311 => 0.236669924786930771203404043773281866,
            0.2366699247869311 => 0.236669924786930771203404043773281866,
            -0.0115113874206879 => -0.0115113874206877560438088500209763826,
            0.0752539843015807 => 0.0752539843015803094497521237182370284,
            -0.0400061921041533 => -0.0400061921041526927808993025538909353,
            0.198128671918067 => 0.198128671918066525889007158161785511,
            0.0414649985182624 => 0.0414649985182628422825448269215629117
        ];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controller::FixedStep;
    use crate::integrate::integrate;
    use crate::method::compose::{Compose, KahanLi6, Suzuki4};
    use crate::method::splitting::Verlet;
    use crate::scalar::Dual;
    use crate::testing::bank::*;
    use crate::testing::{dense_order_of, distance, order_of, symplecticity_defect};

    #[test]
    fn coefficients_sum_to_one_and_are_symmetric() {
        macro_rules! check {
            ($($name:ident)*) => {$(
                for row in [&$name::DRIFT[..], &$name::KICK[..]] {
                    let sum = row.iter().fold(DoubleDouble::ZERO, |sum, &x| sum + x);
                    assert!((sum - DoubleDouble::ONE).value().abs() < 1e-31, "{sum:?}");
                    assert!((row.iter().map(|x| x.hi).sum::<f64>() - 1.0).abs() < 2e-15);
                    assert!(row.iter().eq(row.iter().rev()));
                }
            )*};
        }
        check! { BlanesMoan4 BlanesMoan6 }
    }

    #[test]
    fn orders_are_four_and_six() {
        let (system, start) = (Plane::default(), ellipse(0.0));
        let four = order_of(&system, &BlanesMoan4, &start, &ellipse(2.0), &[100, 150, 200]).unwrap();
        let six = order_of(&system, &BlanesMoan6, &start, &ellipse(5.0), &[60, 75, 90]).unwrap();
        assert!((four - 4.0).abs() < 0.1 && (six - 6.0).abs() < 0.1, "{four} {six}");
        let four = dense_order_of(&system, &BlanesMoan4, ellipse, 5.0, &[200, 300, 400]).unwrap();
        let six = dense_order_of(&system, &BlanesMoan6, ellipse, 5.0, &[60, 75, 90]).unwrap();
        assert!(four > 3.9 && six > 5.9, "{four} {six}");
    }

    #[test]
    fn both_are_symplectic_and_symmetric() {
        let dual = HenonHeiles::<Dual<f64>>::default();
        let start = State::new(0.0, [0.3, -0.1], [0.2, 0.4]);
        macro_rules! check {
            ($($name:ident)*) => {$(
                assert!(symplecticity_defect(&dual, &$name, &start, 0.4).unwrap() < 1e-14);
                let system = HenonHeiles::default();
                let there = integrate(&system, $name, FixedStep::new(0.2), start).until(10.0).final_state().unwrap();
                let back = integrate(&system, $name, FixedStep::new(-0.2), there).until(0.0).final_state().unwrap();
                assert!(distance(&start, &back) < 1e-13, "{back:?}");
            )*};
        }
        check! { BlanesMoan4 BlanesMoan6 }
    }

    /// At equal numbers of evaluations, over ten turns of an ellipse.
    #[test]
    fn both_beat_the_compositions_of_their_order() {
        let error = |method: &dyn Fn(f64) -> State<f64, 2>, cost: f64| {
            let end = 20.0 * core::f64::consts::PI;
            distance(&method(end * cost / 20_000.0), &ellipse(end))
        };
        macro_rules! run {
            ($method:expr) => {
                &|h| {
                    let end = 20.0 * core::f64::consts::PI;
                    integrate(&Plane::default(), $method, FixedStep::new(h), ELLIPSE)
                        .until(end)
                        .final_state()
                        .unwrap()
                }
            };
        }
        let four = [error(run!(BlanesMoan4), 6.0), error(run!(Compose(Verlet, Suzuki4)), 5.0)];
        let six = [error(run!(BlanesMoan6), 11.0), error(run!(Compose(Verlet, KahanLi6)), 9.0)];
        assert!(four[0] < 0.1 * four[1] && six[0] < 0.5 * six[1], "{four:?} {six:?}");
    }
}
