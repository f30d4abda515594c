//! Runge–Kutta–Nyström pairs for `q̈ = a(q, t)`: forces that do not depend on the velocities.
//!
//! `kᵢ = a(q₀ + cᵢ h q̇₀ + h² Σⱼ aᵢⱼ kⱼ, t₀ + cᵢ h)`, `q₁ = q₀ + h q̇₀ + h² Σᵢ bᵢ kᵢ`, `q̇₁ = q̇₀ + h Σᵢ b′ᵢ kᵢ` (Hairer, Nørsett,
//! Wanner, *Solving Ordinary Differential Equations I*, 1993, II.14, eq. 14.7). As stages need no velocities, there are
//! fewer conditions, and fewer evaluations for the same order: 5 for order 6, 8 for order 8, 17 for order 12. As with
//! [`explicit_rk`](super::explicit_rk), the last row of every tableau is b, so that the last stage is the first one of the
//! next step, and the stages are written out.
//!
//! A new method is a new row. It is tested for the order conditions of all Nyström trees up to its order.

use super::hermite::{Birkhoff, Hermite};
use super::{Dense, Method, Step};
use crate::failure::Failure;
use crate::method::newton::accelerations;
use crate::scalar::{Numbers, Scalar};
use crate::state::{State, Tangent, add_scaled, constant};
use crate::system::Separable;
use nalgebra::SVector;

/// The coefficients of a Runge–Kutta–Nyström pair with `K` stages, the last of which is at the end of the step.
pub trait Tableau<const K: usize> {
    /// Name and source.
    const NAME: &'static str;
    /// Order of convergence.
    const ORDER: u32;
    /// `aᵢⱼ`, the last row being b.
    const A: [[f64; K]; K];
    /// `cᵢ`, the last one being 1.
    const C: [f64; K];
    /// `b′ᵢ`.
    const VELOCITY: [f64; K];
    /// `bᵢ` and `b′ᵢ` less those of the embedded formula.
    const ERROR: [[f64; K]; 2];
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

/// `start + Σⱼ (factor aⱼ) kⱼ` written out, so that zero coefficients vanish and the others become immediate operands.
macro_rules! add {
    ($start:expr, $factor:expr, $k:expr; $($a:expr),*) => {{
        let (mut total, mut j) = ($start, 0);
        $(
            if $a != 0.0 {
                total = add_scaled(&total, $factor * Scalar::from_f64($a), &$k[j]);
            }
            j += 1;
        )*
        let _ = j;
        total
    }};
}

macro_rules! tableaux {
    ($(
        $(#[$doc:meta])*
        $name:ident($stages:literal stages, order $order:literal, $source:literal) {
            $($i:literal, $c:expr => [$($a:expr),*];)*
            velocity [$($v:expr),*];
            error q [$($eq:expr),*];
            error qd [$($eqd:expr),*];
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
            const VELOCITY: [f64; $stages] = fill(&[$($v),*]);
            const ERROR: [[f64; $stages]; 2] = [fill(&[$($eq),*]), fill(&[$($eqd),*])];
        }

        impl<Sys: Separable<N>, const N: usize> Method<Sys, N> for $name
        where
            Sys::Scalar: Numbers,
        {
            /// The accelerations where the step begins.
            type Memory = SVector<Sys::Scalar, N>;
            /// The accelerations at the stages.
            type Stages = [SVector<Sys::Scalar, N>; $stages];
            type Error = Tangent<Sys::Scalar, N>;
            type Dense = tableaux!(@dense_type $dense $($coefficients)*);

            fn order(&self) -> u32 {
                $order
            }

            fn start(
                &self,
                system: &Sys,
                at: &State<Sys::Scalar, N>,
            ) -> Result<Self::Memory, Failure<Sys::Scalar>> {
                accelerations(system, at)
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            #[allow(unused_assignments)]
            fn step(
                &self,
                system: &Sys,
                memory: &Self::Memory,
                from: &State<Sys::Scalar, N>,
                h: Sys::Scalar,
                next: &mut Self::Memory,
            ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
                let (mut k, mut q) = ([*memory; $stages], from.q);
                let h2 = h * h;
                $(
                    let time = h * Sys::Scalar::from_f64($c);
                    q = add!(add_scaled(&from.q, time, &from.qd), h2, k; $($a),*);
                    // The velocity plays no part in the accelerations of a separable system.
                    k[$i] = system.accel(&q, &from.qd, from.t + time);
                )*
                let to = State { t: from.t + h, q, qd: add!(from.qd, h, k; $($v),*) };
                let zero = constant(Sys::Scalar::zero());
                let error = Tangent { q: add!(zero, h2, k; $($eq),*), qd: add!(zero, h, k; $($eqd),*) };
                *next = k[$stages - 1];
                Ok(Step { from: *from, to, h, error, stages: k, evaluations: $stages - 1 })
            }

            #[inline(always)]
            fn dense(&self, system: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
                tableaux!(@dense $dense system, step; $($coefficients)*)
            }

            fn dense_evaluations(&self) -> u32 {
                tableaux!(@dense_evaluations $dense $($coefficients)*)
            }
        }
    )*

        /// `check!(method)` for every tableau.
        #[cfg(test)]
        macro_rules! for_each_nystrom {
            ($check:ident) => { $( $check::<$name, $stages>(); )* };
        }
    };

    (@dense_type birkhoff $passes:literal) => { Birkhoff<Sys::Scalar, N> };
    (@dense_type power { $([$($d:expr),*];)* }) => { Power<Sys::Scalar, N> };

    (@dense birkhoff $system:ident, $step:ident; $passes:literal) => {{
        let (Step { from, to, h, stages, .. }, [.., b]) = ($step, &Self::A);
        let [first, .., last] = stages;
        let increment = stages.iter().zip(b).fold(from.qd * *h, |sum, (k, b)| {
            add_scaled(&sum, *h * *h * Scalar::from_f64(*b), k)
        });
        let quintic = Hermite::by_increment(from, increment, &to.qd, *h, first, last);
        Birkhoff::new($system, quintic, $passes)
    }};
    (@dense power $system:ident, $step:ident; { $([$($d:expr),*];)* }) => {{
        let _ = $system;
        let zero = constant(Sys::Scalar::zero());
        let h2 = $step.h * $step.h;
        Power { from: $step.from, h: $step.h, p: [$(add!(zero, h2, $step.stages; $($d),*)),*] }
    }};

    (@dense_evaluations birkhoff 1) => { 2 };
    (@dense_evaluations birkhoff 2) => { 6 };
    (@dense_evaluations power $coefficients:tt) => { 0 };
}

/// `q(θ) = q₀ + θ h q̇₀ + θ² (p₀ + p₁ θ + … + p₄ θ⁴)` with `θ = (t − t₀)/h`, and its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power<S, const N: usize> {
    from: State<S, N>,
    h: S,
    p: [SVector<S, N>; 5],
}

impl<S: Scalar, const N: usize> Dense<S, N> for Power<S, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.from.t) / self.h;
        let (mut value, mut slope) = (constant(S::zero()), constant(S::zero()));
        for (k, p) in self.p.iter().enumerate().rev() {
            value = value * theta + p;
            slope = slope * theta + p * S::from_f64((k + 2) as f64);
        }
        State {
            t,
            q: self.from.q + (self.from.qd * self.h + value * theta) * theta,
            qd: self.from.qd + slope * (theta / self.h),
        }
    }
}

tableaux! {
    /// RKN 6(4) of Dormand and Prince ("Runge–Kutta–Nyström triples", *Computers & Mathematics with Applications* 13, 1987):
    /// five evaluations per step, and an interpolant of order 6 in q and 5 in q̇ for nothing.
    Nystrom6(6 stages, order 6, "Dormand and Prince 1987") {
        1, 0.12929590313670442 => [0.008358715283968025];
        2, 0.25859180627340883 => [0.011144953711957367, 0.022289907423914734];
        3, 0.67029708261548 => [0.1454747428010918, -0.22986064052264749, 0.3090349872029675];
        4, 0.9 => [-0.20766826295078997, 0.6863667842925143, -0.19954927787234925, 0.12585075653062489];
        5, 1.0 => [0.07811016144349478, 0.0, 0.2882917411897668, 0.12242553717457041, 0.011172560192168035];
        velocity [0.07811016144349478, 0.0, 0.3888434787059826, 0.3713207579288423, 0.11172560192168035, 0.05];
        error q [
            -0.9807490989269235, 2.406751371924452, -1.559600370364267, 0.12242553717457041, 0.011172560192168035
        ];
        error qd [0.023504273504273504, 0.0, -0.07242330719764424, 0.17543989844952962, -0.2765208647561589, 0.15];
        dense power {
            [0.5];
            [
                -1.245014245014245, 0.0, 1.9859371988705032, -1.8559358276926614, 2.178649237472767,
                -1.0636363636363637
            ];
            [1.5161443494776827, 0.0, -3.577652872294921, 5.547586751052329, -6.926987319144182, 3.440909090909091];
            [
                -0.9066951566951567, 0.0, 2.5384011164109506, -5.164133553908094, 7.273336685101391,
                -3.7409090909090907
            ];
            [
                0.21367521367521367, 0.0, -0.6583937017967658, 1.5949081677229964, -2.513826043237808,
                1.3636363636363635
            ];
        }
    }

    /// RKN 8(6) of Dormand, El-Mikkawy and Prince ("High-order embedded Runge–Kutta–Nyström formulae", *IMA Journal of
    /// Numerical Analysis* 7, 1987): eight evaluations per step. Its interpolant ([`Birkhoff`]) takes two evaluations and is
    /// of order 7 in q and 6 in q̇.
    Nystrom8(9 stages, order 8, "Dormand, El-Mikkawy and Prince 1987") {
        1, 0.05 => [0.00125];
        2, 0.1 => [0.0016666666666666668, 0.0033333333333333335];
        3, 0.3 => [0.045, -0.09, 0.09];
        4, 0.5 => [-0.3379798532571243, 0.8611516478170984, -0.48613644655235316, 0.0879646519923791];
        5, 0.7 => [
            0.7461462641043086, -1.804347430246737, 1.2761518285888953, -0.031220932716737166, 0.05827027027027027
        ];
        6, 0.9 => [
            -1.2551623461807584, 3.257463187064823, -2.068866619575089, 0.4206478455603251, -0.018382978723404254,
            0.06930091185410335
        ];
        7, 1.0 => [
            3.772901830095941, -9.669613121677195, 6.7991544547851674, -0.8490343907823893, 0.4671734865470852,
            -0.04939742152466368, 0.028815162556053812
        ];
        8, 1.0 => [
            0.028092718568909044, 0.0, 0.1457093253968254, 0.1529431216931217, 0.09151785714285714,
            0.06554705215419501, 0.01618992504409171
        ];
        velocity [
            0.028092718568909044, 0.0, 0.1618992504409171, 0.2184901738473167, 0.18303571428571427,
            0.2184901738473167, 0.1618992504409171, 0.028092718568909044
        ];
        error q [
            -0.044557986852984274, 0.0, 0.10965442077101599, -0.14620589436135464, 0.1315853049252192,
            -0.06265966901200913, 0.012183824530112887
        ];
        error qd [
            -0.044557986852984274, 0.0, 0.12183824530112887, -0.2088655633733638, 0.2631706098504384,
            -0.2088655633733638, 0.12183824530112887, 0.10544201314701572, -0.15
        ];
        dense birkhoff 1
    }

    /// RKN 12(10) of Dormand, El-Mikkawy and Prince (ibid.): seventeen evaluations per step, for errors at rounding. Its
    /// interpolant ([`Birkhoff`]) takes six evaluations and is of order 9 in q and 8 in q̇.
    Nystrom12(18 stages, order 12, "Dormand, El-Mikkawy and Prince 1987") {
        1, 0.02 => [0.0002];
        2, 0.04 => [0.0002666666666666667, 0.0005333333333333334];
        3, 0.1 => [0.002916666666666667, -0.004166666666666667, 0.00625];
        4, 0.13333333333333333 => [0.0016460905349794238, 0.0, 0.0054869684499314125, 0.0017558299039780521];
        5, 0.16 => [0.0019456, 0.0, 0.007151746031746032, 0.0029127111111111113, 0.0007899428571428571];
        6, 0.05 => [
            0.00056640625, 0.0, 0.0008809730489417989, -0.0004369212962962963, 0.00033900669642857143,
            -0.00009946469907407407
        ];
        7, 0.2 => [
            0.0030833333333333333, 0.0, 0.0, 0.0017777777777777779, 0.0027, 0.0015782828282828283, 0.01086060606060606
        ];
        8, 0.25 => [
            0.00365183937480113, 0.0, 0.003965171714072343, 0.0031972582629306284, 0.008221467306855435,
            -0.0013130926959572379, 0.009771586968064868, 0.003755769069232834
        ];
        9, 0.3333333333333333 => [
            0.003707241068718501, 0.0, 0.005082045854555286, 0.001174708002175412, -0.021147629915126993,
            0.06010463698107881, 0.02010573476850619, -0.02835075012293358, 0.014879568918581932
        ];
        10, 0.5 => [
            0.03512537656073344, 0.0, -0.008615749195138479, -0.005791448051007917, 1.945554823782616,
            -3.4351238674565137, -0.10930701107475221, 2.3496383118995166, -0.7560094086870229, 0.10952897222156927
        ];
        11, 0.5555555555555556 => [
            0.020527792537482496, 0.0, -0.00728644676448018, -0.0021153556079618403, 0.9275807968723522,
            -1.6522824844257367, -0.02107956300568657, 1.2065364326207872, -0.4137144770010661, 0.09079873982809654,
            0.005355552600533985
        ];
        12, 0.75 => [
            -0.14324078875545515, 0.0, 0.012528703773091817, 0.006826019163969827, -4.799555395574387,
            5.6986250439519415, 0.7553430369523645, -0.12755487858281084, -1.9605926051117384, 0.9185609056635262,
            -0.23880085505284432, 0.15911081357234216
        ];
        13, 0.8571428571428571 => [
            0.8045019205520489, 0.0, -0.016658527067011247, -0.021415834042629735, 16.827235928962466,
            -11.172835357176098, -3.377159297226324, -15.243326655360846, 17.179835738215417, -5.437719239823995,
            1.3878671618364655, -0.5925827732652812, 0.029603873171297354
        ];
        14, 0.9452162222720143 => [
            -0.913296766697358, 0.0, 0.0024112725757805178, 0.01765812269386174, -14.851649779720384,
            2.1589708670045757, 3.99791558311788, 28.434151800232232, -25.2593643549416, 7.733878542362238,
            -1.8913028948478674, 1.0014845070224718, 0.004641199599109052, 0.011218755022148957
        ];
        15, 1.0 => [
            -0.27519629720559396, 0.0, 0.03661188877915492, 0.009789519688231562, -12.293062345886211,
            14.207226453937903, 1.5866476906789537, 2.4577735327595946, -8.935193694403273, 4.373672731613407,
            -1.8347181765449492, 1.1592085289061491, -0.017290253165383924, 0.019325977904460768, 0.005204442937554993
        ];
        16, 1.0 => [
            1.3076391847404059, 0.0, 0.017364109189745843, -0.018544456454265796, 14.811522032867726,
            9.38317630848247, -5.2284261999445425, -48.95128052584765, 38.297096034337926, -10.58738133697598,
            2.4332304376226275, -1.0453406042575444, 0.0717732095086726, 0.0021622109708082783, 0.007009595759602514
        ];
        17, 1.0 => [
            0.012127868517185414, 0.0, 0.0, 0.0, 0.0, 0.0, 0.08629746251568875, 0.2525469581187147,
            -0.1974186799326823, 0.2031869190789726, -0.020775808077714918, 0.10967804874502014, 0.038065132526466504,
            0.01163406880432423, 0.0046580297040248785
        ];
        velocity [
            0.012127868517185414, 0.0, 0.0, 0.0, 0.0, 0.0, 0.09083943422704079, 0.3156836976483934,
            -0.2632249065769097, 0.3047803786184589, -0.041551616155429835, 0.2467756096762953, 0.15226053010586602,
            0.08143848163026961, 0.08502571193890811, -0.009155189630077963, 0.025
        ];
        error q [
            -0.004880833389821577, 0.0, 0.0, 0.0, 0.0, 0.0, 0.014038126584857338, -0.11947921920803832,
            0.20440246507662121, -0.1322681492223791, 0.11053069299761689, -0.07975385787102851, 0.011224330486437457,
            -0.004671596801593694, 0.0008580413473282841
        ];
        error qd [
            -0.004880833389821577, 0.0, 0.0, 0.0, 0.0, 0.0, 0.014776975352481408, -0.1493490240100479,
            0.2725366201021616, -0.19840222383356862, 0.22106138599523378, -0.17944618020981415, 0.04489732194574983,
            -0.03270117761115586, 0.015662325288859434, -0.029155189630077964, 0.025
        ];
        dense birkhoff 2
    }
}

#[cfg(test)]
mod tests;
