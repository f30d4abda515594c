//! Rosenbrock methods for stiff systems: linearly implicit, no iteration, L-stable, with the emitted Jacobian.
//!
//! In the variables that need no product with the Jacobian (Hairer, Wanner, *Solving Ordinary Differential Equations
//! II*, 1996, IV.7, eq. 7.25), for y = (q, q̇), `f = (q̇, q̈)` and `J = ∂f/∂y`,
//!
//! `(1/(γh) − J) uᵢ = f(t₀ + αᵢh, y₀ + Σⱼ aᵢⱼ uⱼ) + Σⱼ (cᵢⱼ/h) uⱼ + h γᵢ ∂f/∂t`, `y₁ = y₀ + Σᵢ mᵢ uᵢ`.
//!
//! Both pairs here are stiffly accurate: the last stage is the step's end, `y₁ = y₀ + Σⱼ aₛⱼ uⱼ + uₛ`, and its
//! increment uₛ is the error estimate. One real N × N factorization serves all stages.
//!
//! The coefficients were published with the digits of `f64`. Behind `=>` stand those of the root next to them of the
//! order conditions of the step, the estimate and the interpolant, by Newton's method with 60 digits.

#![allow(clippy::excessive_precision)]

use super::newton::{Linearized, Resolvent, accelerations, unsolvable};
use super::{Interpolant, Method, Step};
use crate::failure::Failure;
use crate::scalar::double_double::digits::{exact, exact_row};
use crate::scalar::{DoubleDouble, Scalar, SimdScalar};
use crate::state::{State, Tangent};
use crate::system::Lagrangian;

/// Coefficients of a method with `K` stages and an interpolant of `D` terms.
trait RosenbrockTableau<const K: usize, const D: usize> {
    const GAMMA: DoubleDouble;
    /// `aᵢⱼ`, i > j. The last three rows are equal but for ones.
    const A: [[DoubleDouble; K]; K];
    /// `cᵢⱼ`, i > j.
    const C: [[DoubleDouble; K]; K];
    /// `αᵢ`.
    const ALPHA: [DoubleDouble; K];
    /// `γᵢ`.
    const D: [DoubleDouble; K];
    /// Coefficients of the interpolant.
    const DENSE: [[DoubleDouble; K]; D];
}

macro_rules! rosenbrock {
    ($(
        $(#[$doc:meta])*
        $name:ident($stages:literal stages, order $order:literal, $terms:literal terms) {
            gamma $gamma:expr;
            a [$([$($a:expr $(=> $a_digits:expr)?),*]),*];
            c [$([$($c:expr $(=> $c_digits:expr)?),*]),*];
            alpha [$($alpha:expr $(=> $alpha_digits:expr)?),*];
            d [$($d:expr $(=> $d_digits:expr)?),*];
            dense [$([$($dense:expr $(=> $dense_digits:expr)?),*]),*];
        }
    )*) => {$(
        $(#[$doc])*
        ///
        /// The Jacobian counts as one evaluation. A step whose linear equations are singular fails with
        /// [`Failure::SingularStep`], and a controller then tries a shorter one.
        ///
        /// # Hypotheses
        /// - Accelerations are smooth within a step. Adaptive runs end steps at the switches that the compiler knows;
        ///   steps of one size go over them, with an error of order h where forces jump and h² where they have a
        ///   kink.
        /// - Forces act for a step at least, see [forces that set in later](crate::method#forces-that-set-in-later).
        /// - M is regular along the motion: otherwise [`Failure::SingularInertia`](crate::Failure::SingularInertia).
        /// - Constraints stay independent: otherwise
        ///   [`Failure::DependentConstraints`](crate::Failure::DependentConstraints).
        /// - Forces have derivatives: otherwise [`Failure::NoDerivative`](crate::Failure::NoDerivative).
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct $name;

        impl RosenbrockTableau<$stages, $terms> for $name {
            const GAMMA: DoubleDouble = exact!($gamma);
            const A: [[DoubleDouble; $stages]; $stages] = lower([$(&exact_row![$($a $(=> $a_digits)?),*]),*]);
            const C: [[DoubleDouble; $stages]; $stages] = lower([$(&exact_row![$($c $(=> $c_digits)?),*]),*]);
            const ALPHA: [DoubleDouble; $stages] = exact_row![$($alpha $(=> $alpha_digits)?),*];
            const D: [DoubleDouble; $stages] = exact_row![$($d $(=> $d_digits)?),*];
            const DENSE: [[DoubleDouble; $stages]; $terms] =
                [$(exact_row![$($dense $(=> $dense_digits)?),*]),*];
        }

        impl<Sys: Lagrangian<N>, const N: usize> Method<Sys, N> for $name
        where
            Sys::Scalar: SimdScalar,
        {
            type MethodState = ();
            /// The terms of the interpolant.
            type InterpolantData = [Tangent<Sys::Scalar, N>; $terms];
            type Error = Tangent<Sys::Scalar, N>;
            type Interpolant = RosenbrockInterpolant<Sys::Scalar, N, $terms>;

            fn order(&self) -> u32 {
                $order
            }

            fn implicit(&self) -> bool {
                true
            }

            fn start(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Result<(), Failure<Sys::Scalar>> {
                accelerations(system, at).map(|_| ())
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn step_into(
                &self,
                system: &Sys,
                _: &(),
                from: &State<Sys::Scalar, N>,
                h: Sys::Scalar,
                _: &mut (),
            ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
                let (to, error, stages) = step::<$name, Sys, $stages, $terms, N>(system, from, h)?;
                Ok(Step { from: *from, to, h, error, stages, evaluations: $stages + 1 })
            }

            $crate::method::steps_across! {}

            #[inline(always)]
            fn interpolant(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Interpolant {
                RosenbrockInterpolant { from: step.from, h: step.h, whole: step.to.minus(&step.from), terms: step.stages }
            }
        }
    )*};
}

/// A square array whose row i begins with the numbers of `rows[i]`, the rest zero.
const fn lower<const K: usize>(rows: [&[DoubleDouble]; K]) -> [[DoubleDouble; K]; K] {
    let mut square = [[DoubleDouble::ZERO; K]; K];
    let mut i = 0;
    while i < K {
        let mut j = 0;
        while j < rows[i].len() {
            square[i][j] = rows[i][j];
            j += 1;
        }
        i += 1;
    }
    square
}

rosenbrock! {
    /// Rodas4: order 4 with an embedded one of order 3, six stages, L-stable, γ = 1/4, and an interpolant of order 3
    /// (Hairer and Wanner 1996, IV.7, and the coefficients of their code `RODAS`).
    Rodas4(6 stages, order 4, 2 terms) {
        gamma 0.25;
        a [
            [],
            [1.544],
            [
                0.9466785280815826 => 0.946678528081582505961375343079441992,
                0.2557011698983284 => 0.255701169898328154269835434035095858
            ],
            [
                3.314825187068521 => 3.31482518706852051791199329258156779,
                2.896124015972201 => 2.89612401597220108807003368181513327,
                0.9986419139977817 => 0.998641913997782067707306182298806319
            ],
            [
                1.22122450922664097465252337974534564,
                6.019134481288629 => 6.01913448128862959584742549596840826,
                12.53708332932087 => 12.5370833293208732137689888512645971,
                -0.687886036105895040637757593058571097
            ],
            [
                1.22122450922664097465252337974534564,
                6.019134481288629 => 6.01913448128862959584742549596840826,
                12.53708332932087 => 12.5370833293208732137689888512645971,
                -0.687886036105895040637757593058571097, 1.0
            ]
        ];
        c [
            [],
            [-5.6688],
            [
                -2.430093356833875 => -2.43009335683387470621309061244596837,
                -0.2063599157091915 => -0.206359915709191529753333203370010466
            ],
            [
                -0.107352905815137501437626252823439868,
                -9.594562251023355 => -9.59456225102335667515934920151392268,
                -20.47028614809616 => -20.4702861480961544738186143938042342
            ],
            [
                7.496443313967647 => 7.49644331396764969693025043649722497,
                -10.24680431464352 => -10.2468043146435240216116475369403948,
                -33.9999035281990471979440188934528311,
                11.7089089320616 => 11.7089089320615974375003806834447726
            ],
            [
                8.083246795921522 => 8.0832467959215264677006170774463645,
                -7.981132988064893 => -7.98113298806489371875202850372499604,
                -31.52159432874371 => -31.5215943287437054756414737749039482,
                16.31930543123136 => 16.319305431231365895335103263398406,
                -6.0588182388340541127209581238059432
            ]
        ];
        alpha [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
        d [
            0.25, -0.1043, 0.1035, -0.03620000000000023 => -0.0362000000000000655451282578116740188, 0.0,
            0.0
        ];
        dense [
            [
                10.12623508344586 => 10.1262350834458636511897325709503859,
                -7.48799587761016782406168535561576851, -34.800918615557471702154564156362593,
                -7.992771707568823 => -7.99277170756882266405203748199731877,
                1.02513772329566200426595044538407887, 0.0
            ],
            [
                -0.676280339280125299385646920035325595,
                6.087714651680015 => 6.0877146516800138832388859806819646,
                16.43084320892478 => 16.4308432089247755099057026441698723,
                24.76722511418386 => 24.7672251141838637855266847127592993,
                -6.594389125716872 => -6.59438912571687369505285410843591667, 0.0
            ]
        ];
    }

    /// Rodas5P: order 5 with an embedded one of order 4, eight stages, L-stable, and an interpolant of order 4; made
    /// to keep its order on stiff problems with forces of time (Steinebach, *Construction of Rosenbrock–Wanner method
    /// Rodas5P and numerical benchmarks within the Julia Differential Equations package*, BIT 63, 2023).
    Rodas5P(8 stages, order 5, 3 terms) {
        gamma 0.21193756319429014;
        a [
            [],
            [3.0],
            [
                2.849394379747939 => 2.84939437974798810011137097086607716,
                0.45842242204463923 => 0.458422422044651583656536518385513459
            ],
            [
                -6.954028509809101 => -6.95402850980941594119601244996358653,
                2.489845061869568 => 2.48984506186956046795806264970807382,
                -10.358996098473584 => -10.3589960984735983826848307790750851
            ],
            [
                2.8029986275628964 => 2.80299862756285982043025974968928202,
                0.5072464736228206 => 0.507246473622825205869524623389597966,
                -0.3988312541770524 => -0.398831254177065353469059332084310441,
                -0.04721187230404641 => -0.0472118723040445528599411126356929543
            ],
            [
                -7.502846399306121 => -7.50284639930641916379578500345113819,
                2.561846144803919 => 2.56184614480390677118677658539454577,
                -11.627539656261098 => -11.6275396562610551971463867718162896,
                -0.18268767659942256 => -0.182687676599420018685351218958211319,
                0.030198172008377946 => 0.0301981720083779920606680030137673136
            ],
            [
                -7.502846399306121 => -7.50284639930641916379578500345113819,
                2.561846144803919 => 2.56184614480390677118677658539454577,
                -11.627539656261098 => -11.6275396562610551971463867718162896,
                -0.18268767659942256 => -0.182687676599420018685351218958211319,
                0.030198172008377946 => 0.0301981720083779920606680030137673136, 1.0
            ],
            [
                -7.502846399306121 => -7.50284639930641916379578500345113819,
                2.561846144803919 => 2.56184614480390677118677658539454577,
                -11.627539656261098 => -11.6275396562610551971463867718162896,
                -0.18268767659942256 => -0.182687676599420018685351218958211319,
                0.030198172008377946 => 0.0301981720083779920606680030137673136, 1.0, 1.0
            ]
        ];
        c [
            [],
            [-14.155112264123755 => -14.1551122641237474674874518479002196],
            [
                -17.97296035885952 => -17.9729603588597617715001590346394474,
                -2.859693295451294 => -2.85969329545135456146889644382434342
            ],
            [
                147.12150275711716 => 147.121502757118288024393309440560658,
                -1.41221402718213 => -1.41221402718209564672359007830343079,
                71.68940251302358 => 71.6894025130233240414478952625979083
            ],
            [
                165.43517024871676 => 165.43517024871392607356504795642528,
                -0.4592823456491126 => -0.459282345649110988499390668488702905,
                42.90938336958603 => 42.9093833695855880861430820289352646,
                -5.961986721573306 => -5.96198672157316138814265812442880317
            ],
            [
                24.854864614690072 => 24.8548646146910842529073848522640137,
                -3.0009227002832186 => -3.00092270028323494675731736471906738,
                47.4931110020768 => 47.4931110020761868809798176568945631,
                5.5814197821558125 => 5.58141978215576240800759474970409329,
                -0.6610691825249471 => -0.661069182524952752086043587087777407
            ],
            [
                30.91273214028599 => 30.9127321402864250673945657880224414,
                -3.1208243349937974 => -3.12082433499384323527526393642049768,
                77.79954646070892 => 77.7995464607077007925192260149043128,
                34.28646028294783 => 34.2864602829478823530391393635751131,
                -19.097331116725623 => -19.0973311167259852904578580880435945,
                -28.087943162872662 => -28.0879431628727693728873506374808897
            ],
            [
                37.80277123390563 => 37.8027712339051959424567546081413045,
                -3.2571969029072276 => -3.25719690290731651725798964857001403,
                112.26918849496327 => 112.269188494961594367497258791204502,
                66.9347231244047 => 66.9347231244054369500519589598094929,
                -40.06618937091002 => -40.0661893709111795789718462393958995,
                -54.66780262877968 => -54.667802628780337876843545114216939,
                -9.48861652309627 => -9.48861652309622516023033334771412913
            ]
        ];
        alpha [
            0.0, 0.63581268958287042, 0.4095798393397535 => 0.409579839339758787695099376445223831,
            0.9769306725060716 => 0.976930672506071298215025776154336148,
            0.4288403609558664 => 0.428840360955867917757550251756982887, 1.0, 1.0, 1.0
        ];
        d [
            0.21193756319429014, -0.42387512638858027 => -0.423875126388579879904063078155904039,
            -0.3384627126235924 => -0.338462712623597874119404579470989531,
            1.8046452872882734 => 1.80464528728825566961690297303442541,
            2.325825639765069 => 2.32582563976500103807179228958260491, 0.0, 0.0, 0.0
        ];
        dense [
            [
                25.948786856663858 => 25.9487868566642768387299977377641018,
                -2.5579724845846235 => -2.55797248458460357949164037987183033,
                10.433815404888879 => 10.4338154048889467056171766841520641,
                -2.3679251022685204 => -2.36792510226852593321949961123914588,
                0.524948541321073 => 0.524948541321074903947105564717084921,
                1.1241088310450404 => 1.12410883104505424676798585682652503,
                0.4272876194431874 => 0.427287619443170442923346663008512642,
                -0.172022210701554930000000000334705964
            ],
            [
                -9.91568850695171 => -9.91568850695268032760915772069114745,
                -0.9689944594115154 => -0.968994459411538679847932773176792352,
                3.0438037242978453 => 3.04380372429787316561055465842549653,
                -24.495224566215796 => -24.4952245662159189476933089752426123,
                20.176138334709044 => 20.1761383347095550100450894234193033,
                15.98066361424651 => 15.9806636142465388984748319978594715,
                -6.789040303419874 => -6.7890403034198446481150953651849378,
                -6.71023606992337199999999997945259221
            ],
            [
                11.419903575922262 => 11.419903575921561149094939532865961,
                2.8879645146136994 => 2.88796451461366943850393572541857574,
                72.92137995996029 => 72.9213799599575394134106478721746907,
                80.12511834622643 => 80.1251183462252994758091973351970045,
                -52.072871366152654 => -52.0728713661527897319528463497284408,
                -59.78993625266729 => -59.7899362526664535167142680118647318,
                -0.15582684282751913 => -0.155826842827519462327998004103731525,
                4.88308718571372200000000006988874888
            ]
        ];
    }
}

type Outcome<S, const D: usize, const N: usize> =
    Result<(State<S, N>, Tangent<S, N>, [Tangent<S, N>; D]), Failure<S>>;

#[cfg_attr(not(debug_assertions), inline(always))]
fn step<T: RosenbrockTableau<K, D>, Sys: Lagrangian<N>, const K: usize, const D: usize, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Outcome<Sys::Scalar, D, N>
where
    Sys::Scalar: SimdScalar,
{
    let jacobian = Sys::Scalar::evaluate(Linearized { system, at: from });
    let resolvent = Resolvent::new(Sys::Scalar::one() / (h * T::GAMMA.to()), &jacobian)
        .map_err(|singular| unsolvable(system, from, h, &jacobian, singular))?;
    let mut u = [Tangent::zero(); K];
    let mut at = *from;
    for i in 0..K {
        let (mut increment, mut right) = (Tangent::zero(), Tangent::zero());
        for j in 0..i {
            if T::A[i][j].hi != 0.0 {
                increment = increment.plus_scaled(T::A[i][j].to(), &u[j]);
            }
            right = right.plus_scaled(T::C[i][j].to::<Sys::Scalar>() / h, &u[j]);
        }
        at = from.moved(from.t + h * T::ALPHA[i].to(), Sys::Scalar::one(), &increment);
        right.q += at.qd;
        right.qd += system.accel(&at.q, &at.qd, at.t) + jacobian.t * (h * T::D[i].to());
        u[i] = resolvent.apply(&right);
    }
    let error = u[K - 1];
    let mut terms = [Tangent::zero(); D];
    for (term, row) in terms.iter_mut().zip(T::DENSE) {
        for j in 0..K {
            *term = term.plus_scaled(row[j].to(), &u[j]);
        }
    }
    Ok((at.moved(from.t + h, Sys::Scalar::one(), &error), error, terms))
}

/// `y₀ + θ(y₁ − y₀ + (1 − θ)(d₁ + θ(d₂ + …)))` with `θ = (t − t₀)/h` (Hairer and Wanner 1996, IV.7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RosenbrockInterpolant<S, const N: usize, const D: usize> {
    from: State<S, N>,
    h: S,
    whole: Tangent<S, N>,
    terms: [Tangent<S, N>; D],
}

impl<S: Scalar, const N: usize, const D: usize> Interpolant<S, N> for RosenbrockInterpolant<S, N, D> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.from.t) / self.h;
        let mut inner = Tangent::zero();
        for term in self.terms.iter().rev() {
            inner = term.plus_scaled(theta, &inner);
        }
        self.from.moved(t, theta, &self.whole.plus_scaled(S::one() - theta, &inner))
    }
}

#[cfg(test)]
mod tests;
