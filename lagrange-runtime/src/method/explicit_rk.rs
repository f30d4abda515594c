//! Explicit Runge–Kutta methods: rows of coefficients, and the one step that all of them share.
//!
//! With y = (q, q̇) and f = (q̇, q̈): `kᵢ = f(y₀ + h Σⱼ aᵢⱼ kⱼ, t₀ + cᵢ h)`. The last row of every tableau is b, so that
//! the last "stage" is the derivative at the end of the step: it is the first stage of the next step, whether or not the
//! method's error estimate has a use for it ("first same as last"), and lets every method be interpolated.
//!
//! A new method is a new row. It is tested for the order conditions of all rooted trees up to order 5 without further ado.

use super::hermite::Hermite;
use super::{Dense, Method, Step};
use crate::controller::{NoEstimate, TwoEstimates};
use crate::failure::Failure;
use crate::scalar::Scalar;
use crate::state::{State, Tangent};
use crate::system::System;
use nalgebra::SVector;

/// The coefficients of an explicit Runge–Kutta method with `K` stages, the last of which is at the end of the step.
pub trait Tableau<const K: usize> {
    /// Name and source.
    const NAME: &'static str;
    /// Order of convergence.
    const ORDER: u32;
    /// `aᵢⱼ`, the last row being b.
    const A: [[f64; K]; K];
    /// `cᵢ`, the last one being 1.
    const C: [f64; K];
}

/// `Σⱼ aⱼ kⱼ` written out, so that zero coefficients vanish and the others become immediate operands.
macro_rules! sum {
    ($k:expr; $($a:expr),*) => {{
        let (mut total, mut j) = (None::<Tangent<_, _>>, 0);
        $(
            if $a != 0.0 {
                let a = Scalar::from_f64($a);
                total = Some(total.map_or_else(|| $k[j].scaled(a), |sum| sum.plus_scaled(a, &$k[j])));
            }
            j += 1;
        )*
        let _ = j;
        total.unwrap_or_else(Tangent::zero)
    }};
}

/// `y₀ + Σⱼ (h aⱼ) kⱼ`, the newest stage last: all the rest of the sum is made while that stage is still computed.
macro_rules! add {
    ($from:expr, $h:expr, $k:expr; $($a:expr),*) => {{
        let (mut total, mut j) = (Tangent { q: $from.q, qd: $from.qd }, 0);
        $(
            if $a != 0.0 {
                total = total.plus_scaled($h * Scalar::from_f64($a), &$k[j]);
            }
            j += 1;
        )*
        let _ = j;
        total
    }};
}

/// A row of coefficients filled up with zeros.
const fn fill<const K: usize>(row: &[f64]) -> [f64; K] {
    let mut full = [0.0; K];
    let mut j = 0;
    while j < row.len() {
        full[j] = row[j];
        j += 1;
    }
    full
}

macro_rules! tableaux {
    ($(
        $(#[$doc:meta])*
        $name:ident($stages:literal stages, order $order:literal, $source:literal) {
            $($i:literal, $c:expr => [$($a:expr),*];)*
            error $error:ident $([$($e:expr),* $(,)?])*;
            dense $dense:ident $($coefficients:tt)*
        }
    )*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name;

        impl Tableau<$stages> for $name {
            const NAME: &'static str = concat!(stringify!($name), ", ", $source);
            const ORDER: u32 = $order;
            const A: [[f64; $stages]; $stages] = [fill(&[]), $(fill(&[$($a),*])),*];
            const C: [f64; $stages] = [0.0, $($c),*];
        }

        impl<Sys: System<N>, const N: usize> Method<Sys, N> for $name {
            type Memory = SVector<Sys::Scalar, N>;
            type Stages = [Tangent<Sys::Scalar, N>; $stages];
            type Error = tableaux!(@error_type $error);
            type Dense = tableaux!(@dense_type $dense $($coefficients)*);

            fn order(&self) -> u32 {
                $order
            }

            #[inline]
            fn start(
                &self,
                system: &Sys,
                at: &State<Sys::Scalar, N>,
            ) -> Result<Self::Memory, Failure<Sys::Scalar>> {
                Ok(system.accel(&at.q, &at.qd, at.t))
            }

            #[inline]
            #[allow(unused_assignments)]
            fn step(
                &self,
                system: &Sys,
                memory: &Self::Memory,
                from: &State<Sys::Scalar, N>,
                h: Sys::Scalar,
            ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
                let mut k = [Tangent { q: from.qd, qd: *memory }; $stages];
                let mut to = *from;
                $((to, k[$i]) = stage(system, from.t, h, $c, add!(from, h, k; $($a),*));)*
                let error = tableaux!(@error $error k, h; $([$($e),*])*);
                let memory = k[$stages - 1].qd;
                Ok(Step { from: *from, to, h, error, memory, stages: k, evaluations: $stages - 1 })
            }

            #[allow(unused_assignments, unused_variables, unused_mut)]
            fn dense(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
                tableaux!(@dense $dense $stages system, step; $($coefficients)*)
            }

            fn dense_evaluations(&self) -> u32 {
                tableaux!(@dense_evaluations $dense $stages $($coefficients)*)
            }
        }
    )*

        /// `check!(method)` for every tableau.
        #[cfg(test)]
        macro_rules! for_each_tableau {
            ($check:ident) => { $( $check::<$name, $stages>(); )* };
        }
    };

    (@error_type none) => { NoEstimate };
    (@error_type embedded) => { Tangent<Sys::Scalar, N> };
    (@error_type two) => { TwoEstimates<Sys::Scalar, N> };

    (@error none $k:ident, $h:ident;) => { NoEstimate };
    (@error embedded $k:ident, $h:ident; [$($e:expr),*]) => { sum!($k; $($e),*).scaled($h) };
    (@error two $k:ident, $h:ident; [$($fifth:expr),*] [$($third:expr),*]) => {
        TwoEstimates { fifth: sum!($k; $($fifth),*).scaled($h), third: sum!($k; $($third),*).scaled($h) }
    };

    (@dense_type hermite) => { Hermite<Sys::Scalar, N> };
    (@dense_type nested $terms:literal $($rest:tt)*) => { Nested<Sys::Scalar, N, $terms> };

    (@dense hermite $stages:literal $system:ident, $step:ident;) => {
        Hermite::new(&$step.from, &$step.to, $step.h, &$step.stages[0].qd, &$step.memory)
    };
    (@dense nested $stages:literal $system:ident, $step:ident; $terms:literal terms
        { $($c:expr => [$($a:expr),* $(,)?];)* } { $([$($d:expr),* $(,)?];)* }
    ) => {{
        const EXTRA: usize = tableaux!(@count $($c),*);
        let mut k = [$step.stages[0]; $stages + EXTRA];
        k[..$stages].copy_from_slice(&$step.stages);
        let mut i = $stages;
        $(
            k[i] = stage($system, $step.from.t, $step.h, $c, add!(&$step.from, $step.h, k; $($a),*)).1;
            i += 1;
        )*
        let _ = i;
        Nested::new($step.from, &$step.to, $step.h, &k[0], &k[$stages - 1], &[$(sum!(k; $($d),*).scaled($step.h)),*])
    }};

    (@dense_evaluations hermite $stages:literal) => { 0 };
    (@dense_evaluations nested $stages:literal $terms:literal terms
        { $($c:expr => [$($a:expr),* $(,)?];)* } { $($rows:tt)* }
    ) => { tableaux!(@count $($c),*) };

    (@count) => { 0 };
    (@count $head:expr $(, $tail:expr)*) => { 1 + tableaux!(@count $($tail),*) };
}

/// The state (q, q̇) at `t₀ + c h`, and its derivative.
///
/// The stages of a step are written out and not looped over: measured, this takes 2 to 3 ns off every evaluation of
/// short accelerations (benches/overhead.rs), since the sums then need no table and the stages no memory; and it costs
/// nothing where accelerations are long, since the compiler then calls them instead of copying them into every stage.
#[inline(always)]
fn stage<Sys: System<N>, const N: usize>(
    system: &Sys,
    t: Sys::Scalar,
    h: Sys::Scalar,
    c: f64,
    at: Tangent<Sys::Scalar, N>,
) -> (State<Sys::Scalar, N>, Tangent<Sys::Scalar, N>) {
    let Tangent { q, qd } = at;
    let t = h.mul_add(Sys::Scalar::from_f64(c), t);
    (State { t, q, qd }, Tangent { q: qd, qd: system.accel(&q, &qd, t) })
}

/// The interpolant of Hairer's codes: `y(θ) = r₀ + θ(r₁ + θ̄(r₂ + θ(r₃ + θ̄(r₄ + …))))`, `θ = (t − t₀)/h`, `θ̄ = 1 − θ`,
/// whose first four terms are the cubic Hermite polynomial and whose others come from the stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nested<S, const N: usize, const TERMS: usize> {
    t: S,
    h: S,
    r: [Tangent<S, N>; TERMS],
}

impl<S: Scalar, const N: usize, const TERMS: usize> Nested<S, N, TERMS> {
    fn new(
        from: State<S, N>,
        to: &State<S, N>,
        h: S,
        first: &Tangent<S, N>,
        last: &Tangent<S, N>,
        rest: &[Tangent<S, N>],
    ) -> Self {
        let minus = -S::one();
        let r1 = to.minus(&from);
        let r2 = first.scaled(h).plus_scaled(minus, &r1);
        let r3 = r1.plus_scaled(-h, last).plus_scaled(minus, &r2);
        let mut r = [Tangent { q: from.q, qd: from.qd }; TERMS];
        for (slot, term) in r[1..].iter_mut().zip([r1, r2, r3].iter().chain(rest)) {
            *slot = *term;
        }
        Nested { t: from.t, h, r }
    }
}

impl<S: Scalar, const N: usize, const TERMS: usize> Dense<S, N> for Nested<S, N, TERMS> {
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.t) / self.h;
        let factors = [theta, S::one() - theta];
        let mut y = self.r[TERMS - 1];
        for j in (0..TERMS - 1).rev() {
            y = self.r[j].plus_scaled(factors[j % 2], &y);
        }
        State { t, q: y.q, qd: y.qd }
    }
}

tableaux! {
    /// Euler's method (1768), order 1: for teaching, and as the shortest row of this table.
    Euler(2 stages, order 1, "Euler 1768") {
        1, 1.0 => [1.0];
        error none;
        dense hermite
    }

    /// The classical Runge–Kutta method of order 4 (Kutta 1901): four evaluations per step, no error estimate.
    Rk4(5 stages, order 4, "Kutta 1901") {
        1, 0.5 => [0.5];
        2, 0.5 => [0.0, 0.5];
        3, 1.0 => [0.0, 0.0, 1.0];
        4, 1.0 => [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];
        error none;
        dense hermite
    }

    /// Dormand and Prince's pair of orders 5 and 4 (1980), the method of `dopri5` and MATLAB's `ode45`: six evaluations
    /// per step, for tolerances down to about 1e-6. Interpolant of order 4 (Hairer, Nørsett, Wanner, *Solving Ordinary
    /// Differential Equations I*, 1993, table II.5.2 and II.6).
    DormandPrince5(7 stages, order 5, "Dormand and Prince 1980") {
        1, 0.2 => [0.2];
        2, 0.3 => [3.0 / 40.0, 9.0 / 40.0];
        3, 0.8 => [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0];
        4, 8.0 / 9.0 => [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0];
        5, 1.0 => [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0];
        6, 1.0 => [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
        error embedded
            [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
        dense nested 5 terms {} {
            [
                -12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0,
                -10690763975.0 / 1880347072.0, 701980252875.0 / 199316789632.0,
                -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0
            ];
        }
    }

    /// Dormand and Prince's method of order 8 with error estimators of orders 5 and 3, in the version and with the
    /// interpolant of order 7 of `dop853` (Hairer, Nørsett, Wanner 1993, II.5, II.6, II.10): twelve evaluations per
    /// step, and three more where it is interpolated. For tolerances from 1e-6 to rounding.
    Dop853(13 stages, order 8, "Dormand and Prince 1980; Hairer, Nørsett, Wanner 1993") {
        1, 0.05260015195876773 => [0.05260015195876773];
        2, 0.0789002279381516 => [0.0197250569845379, 0.0591751709536137];
        3, 0.1183503419072274 => [0.02958758547680685, 0.0, 0.08876275643042054];
        4, 0.2816496580927726 => [0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792];
        5, 1.0 / 3.0 => [0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242];
        6, 0.25 => [0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125];
        7, 4.0 / 13.0 => [
            0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
            0.008273789163814023
        ];
        8, 127.0 / 195.0 => [
            0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
            20.154067550477894, -43.48988418106996
        ];
        9, 0.6 => [
            0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193,
            15.279233632882423, -33.28821096898486, -0.020331201708508627
        ];
        10, 6.0 / 7.0 => [
            -0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927,
            -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196
        ];
        11, 1.0 => [
            2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188,
            27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636
        ];
        12, 1.0 => [
            0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003,
            -5.801203960010585, 0.3111643669578199, -0.1521609496625161, 0.20136540080403034,
            0.04471061572777259
        ];
        error two
            [
                0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502,
                1.6643771824549864, -0.35032884874997366, 0.3341791187130175, 0.08192320648511571,
                -0.022355307863886294
            ]
            [
                0.054293734116568765 - 31.0 / 127.0, 0.0, 0.0, 0.0, 0.0, 4.450312892752409,
                1.8915178993145003, -5.801203960010585, 0.3111643669578199 - 12675.0 / 17272.0,
                -0.1521609496625161, 0.20136540080403034, 0.04471061572777259 - 3.0 / 136.0
            ];
        dense nested 8 terms {
            0.1 => [
                0.056167502283047954, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25350021021662483, -0.2462390374708025,
                -0.12419142326381637, 0.15329179827876568, 0.00820105229563469, 0.007567897660545699,
                -0.008298
            ];
            0.2 => [
                0.03183464816350214, 0.0, 0.0, 0.0, 0.0, 0.028300909672366776, 0.053541988307438566,
                -0.05492374857139099, 0.0, 0.0, -0.00010834732869724932, 0.0003825710908356584,
                -0.00034046500868740456, 0.1413124436746325
            ];
            7.0 / 9.0 => [
                -0.42889630158379194, 0.0, 0.0, 0.0, 0.0, -4.697621415361164, 7.683421196062599,
                4.06898981839711, 0.3567271874552811, 0.0, 0.0, 0.0, -0.0013990241651590145,
                2.9475147891527724, -9.15095847217987
            ];
        } {
            [
                -8.428938276109013, 0.0, 0.0, 0.0, 0.0, 0.5667149535193777, -3.0689499459498917,
                2.38466765651207, 2.117034582445028, -0.871391583777973, 2.2404374302607883,
                0.6315787787694688, -0.08899033645133331, 18.148505520854727, -9.194632392478356,
                -4.436036387594894
            ];
            [
                10.427508642579134, 0.0, 0.0, 0.0, 0.0, 242.28349177525817, 165.20045171727028,
                -374.5467547226902, -22.113666853125306, 7.733432668472264, -30.674084731089398,
                -9.332130526430229, 15.697238121770845, -31.139403219565178, -9.35292435884448,
                35.81684148639408
            ];
            [
                19.985053242002433, 0.0, 0.0, 0.0, 0.0, -387.0373087493518, -189.17813819516758,
                527.8081592054236, -11.57390253995963, 6.8812326946963, -1.0006050966910838,
                0.7777137798053443, -2.778205752353508, -60.19669523126412, 84.32040550667716,
                11.99229113618279
            ];
            [
                -25.69393346270375, 0.0, 0.0, 0.0, 0.0, -154.18974869023643, -231.5293791760455,
                357.6391179106141, 93.40532418362432, -37.45832313645163, 104.0996495089623, 29.8402934266605,
                -43.53345659001114, 96.32455395918828, -39.17726167561544, -149.72683625798564
            ];
        }
    }
}

#[cfg(test)]
mod tests;
