//! The interpolant of every method that has none of its own: Hermite's, through what both ends know.
//!
//! With θ = (t − t₀)/h, the polynomial of degree 5 with the given q, q̇, q̈ at both ends has the error `O(h⁶)` in q
//! and, as its derivative, `O(h⁵)` in q̇ (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 1993,
//! II.6).

use super::Interpolant;
use crate::scalar::double_double::digits::exact_row;
use crate::scalar::{DoubleDouble, Scalar};
use crate::state::{State, constant};
use crate::system::System;
use nalgebra::SVector;

/// Quintic Hermite interpolant:
/// `q(θ) = q₀ + θ(r₁ + θ̄(r₂ + θ(r₃ + θ̄(r₄ + θ r₅))))` with `θ̄ = 1 − θ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hermite<S, const N: usize> {
    t: S,
    h: S,
    r: [SVector<S, N>; 6],
}

impl<S: Scalar, const N: usize> Hermite<S, N> {
    /// The interpolant from `from` to `to`, where the accelerations are `qdd_from` and `qdd_to`, a step `h` apart.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(
        from: &State<S, N>,
        to: &State<S, N>,
        h: S,
        qdd_from: &SVector<S, N>,
        qdd_to: &SVector<S, N>,
    ) -> Self {
        Self::by_increment(from, to.q - from.q, &to.qd, h, qdd_from, qdd_to)
    }

    /// The interpolant over a step that changes q by `increment` and leads to the velocity `qd_to`. The velocity
    /// within the step is a derivative by time: in a step of 1e-12 the rounding of q, as the difference of the
    /// coordinates at both ends has it, would be 1e-4 of it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn by_increment(
        from: &State<S, N>,
        increment: SVector<S, N>,
        qd_to: &SVector<S, N>,
        h: S,
        qdd_from: &SVector<S, N>,
        qdd_to: &SVector<S, N>,
    ) -> Self {
        let half_h2 = h * h * S::from_f64(0.5);
        let two = S::from_f64(2.0);
        // Each coefficient is what the condition named beside it leaves over of the terms before it.
        let r1 = increment; //                                         q at the end
        let r2 = from.qd * h - r1; //                                  q̇ at the start: r₁ + r₂
        let r3 = r1 - qd_to * h - r2; //                               q̇ at the end: r₁ − r₂ − r₃
        let r4 = qdd_from * half_h2 + r2 - r3; //                      q̈/2 at the start: −r₂ + r₃ + r₄
        let r5 = qdd_to * half_h2 + r2 + r3 * two - r4; //             q̈/2 at the end: −r₂ − 2r₃ + r₄ + r₅
        Hermite { t: from.t, h, r: [from.q, r1, r2, r3, r4, r5] }
    }
}

impl<S: Scalar, const N: usize> Hermite<S, N> {
    /// The value at θ and its first two derivatives by θ: Horner's scheme for the three together.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn jet(&self, theta: S) -> [SVector<S, N>; 3] {
        let factors = [theta, S::one() - theta];
        let slopes = [S::one(), -S::one()];
        let zero = self.r[5] * S::zero();
        let (mut value, mut slope, mut curvature) = (self.r[5], zero, zero);
        for j in (0..5).rev() {
            let (x, dx) = (factors[j % 2], slopes[j % 2]);
            curvature = curvature * x + slope * (dx + dx);
            slope = slope * x + value * dx;
            value = value * x + self.r[j];
        }
        [value, slope, curvature]
    }
}

impl<S: Scalar, const N: usize> Interpolant<S, N> for Hermite<S, N> {
    #[inline(always)]
    fn at(&self, t: S) -> State<S, N> {
        let [value, slope, _] = self.jet((t - self.t) / self.h);
        State { t, q: value, qd: slope / self.h }
    }
}

/// A polynomial through both ends of a step, as [`Hermite`], and also through accelerations in between
/// ("bootstrapping": Hairer, Nørsett, Wanner 1993, II.6, after Shampine 1985; interpolation of values and second
/// derivatives is Birkhoff's): `q(θ) = quintic(θ) + θ³ θ̄³ (c₀ + c₁ u + c₂ u² + …)` with `u = θ − ½` and up to
/// `TERMS` terms.
///
/// First the quintic gives states at θ = 0.2 and 0.8; with the accelerations there, degree 7 has the error `O(h⁸)` in
/// q and `O(h⁷)` in q̇, since a force that does not depend on q̇ takes over the error `O(h⁶)` of q, and h² goes with
/// it. Then degree 7 gives states at θ = 0.15, 0.35, 0.65, 0.85, and degree 9 has the errors `O(h¹⁰)` and `O(h⁹)`.
/// Where forces depend on q̇ they are one order less after the first pass, and two after the second. Stages of a
/// method may come in the place of the first passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Birkhoff<S, const N: usize, const TERMS: usize = 4> {
    quintic: Hermite<S, N>,
    c: [SVector<S, N>; TERMS],
    evaluations: u32,
}

impl<S: Scalar, const N: usize, const TERMS: usize> Birkhoff<S, N, TERMS> {
    /// The quintic alone.
    #[inline(always)]
    pub(crate) fn of(quintic: Hermite<S, N>) -> Self {
        Birkhoff { quintic, c: [constant(S::zero()); TERMS], evaluations: 0 }
    }

    /// Evaluations of the equations of motion that it took.
    pub(crate) fn evaluations(&self) -> u32 {
        self.evaluations
    }

    /// Adds the terms of the accelerations of a stage at θ, which are its weights times what the second derivative of
    /// the quintic misses there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn add(&mut self, theta: DoubleDouble, qdd: &SVector<S, N>, weights: &[DoubleDouble]) {
        let h = self.quintic.h;
        let missing = qdd * (h * h) - self.quintic.jet(theta.to())[2];
        for (c, weight) in self.c.iter_mut().zip(weights) {
            *c += missing * weight.to();
        }
    }

    /// Residual of the second derivative of the quintic in the accelerations at θ.
    #[inline(always)]
    fn lacks<Sys: System<N, Scalar = S>>(&self, system: &Sys, theta: S) -> SVector<S, N> {
        let Hermite { t, h, .. } = self.quintic;
        let State { t, q, qd } = self.at(t + h * theta);
        system.accel(&q, &qd, t) * (h * h) - self.quintic.jet(theta)[2]
    }

    /// The terms anew, by the accelerations at `θ = ½ ∓ uⱼ`: even ones by the sums of what is missing at both, odd
    /// ones by the differences.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn pass<Sys: System<N, Scalar = S>, const M: usize>(
        &mut self,
        system: &Sys,
        nodes: [DoubleDouble; M],
        weights: &[[DoubleDouble; M]],
    ) {
        let half = S::from_f64(0.5);
        let mut missing = [[constant(S::zero()); M]; 2];
        for (j, u) in nodes.into_iter().enumerate() {
            let (a, b) = (self.lacks(system, half - u.to()), self.lacks(system, half + u.to()));
            (missing[0][j], missing[1][j]) = (a + b, a - b);
        }
        for (k, (c, row)) in self.c.iter_mut().zip(weights).enumerate() {
            *c = missing[k % 2][0] * row[0].to();
            for j in 1..M {
                *c += missing[k % 2][j] * row[j].to();
            }
        }
        self.evaluations += 2 * M as u32;
    }

    /// The interpolant of degree 5, 7 or 9 after 0, 1 or 2 passes, which take 0, 2 or 6 evaluations.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn new<Sys: System<N, Scalar = S>>(system: &Sys, quintic: Hermite<S, N>, passes: u32) -> Self {
        let mut dense = Birkhoff::of(quintic);
        if passes > 0 {
            dense.pass(system, exact_row![0.3], &BY_TWO);
        }
        if passes > 1 {
            dense.pass(system, exact_row![0.35, 0.15], &BY_FOUR);
        }
        dense
    }
}

impl<S: Scalar, const N: usize> Birkhoff<S, N, 8> {
    /// Makes it one of degree 13 by eight evaluations, which gains two orders up to the fourteenth.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn improve<Sys: System<N, Scalar = S>>(&mut self, system: &Sys) {
        self.pass(system, exact_row![0.46, 0.39, 0.3, 0.06], &BY_EIGHT);
    }
}

/// c₀, c₁ by the missing second derivatives at `u = ∓0.3`: the inverse of the matrix of `(θ³ θ̄³ uᵏ)″` there.
const BY_TWO: [[DoubleDouble; 1]; 2] = [exact_row![125.0 / 48.0], exact_row![3125.0 / 216.0]];

/// c₀ … c₃ by those at `u = ∓0.35` and `∓0.15`.
const BY_FOUR: [[DoubleDouble; 2]; 4] = [
    exact_row![151600.0 / 147951.0, -101200.0 / 87997.0],
    exact_row![14360000.0 / 7562331.0, 26440000.0 / 5782959.0],
    exact_row![-1100000.0 / 49317.0, -2900000.0 / 87997.0],
    exact_row![158000000.0 / 2520777.0, 14.87127956466577 => 86000000.0 / 5782959.0],
];

/// c₀ … c₇ by those at `u = ∓0.46`, `∓0.39`, `∓0.3` and `∓0.06`.
#[allow(clippy::excessive_precision)]
const BY_EIGHT: [[DoubleDouble; 4]; 8] = [
    exact_row![
        0.536183074863096006121944740457528401,
        0.504049644967387678521542808312724496,
        0.386093292070490985134065206900623049,
        -0.509941791679276694401637064499073579
    ],
    exact_row![
        -3.14925357288290196526606008089821966,
        -2.91136005315975130192569591569400129,
        -2.43910422315175410577034603135556171,
        2.02748992136255460636900006529784407
    ],
    exact_row![
        9.74108595592262079581930812480988954,
        7.96715561437110243619923699650604077,
        11.893288145464229586379316995621473,
        18.9103425143395223235527219120773207
    ],
    exact_row![
        -50.7974739068337832692326601718911629,
        -46.9131225635385042313041854877320132,
        -46.498429368890586432975810177156635,
        -88.8392992699324674371978055834686195
    ],
    exact_row![
        -79.1839127263478008894719793147271573,
        -20.2621142359449843374709983227155626,
        -252.112323731052366934241084172308091,
        -201.821897190490666627407921845795378
    ],
    exact_row![
        732.02447010872647088649209115418018,
        661.146546415240003947785774355513317,
        1147.8190922975971508484301098667401,
        1006.71296917536011348027641663371962
    ],
    exact_row![
        610.074365651847295236854784919763265,
        -289.376662165280748217943314167743098,
        1062.49091091563600355193330503120053,
        672.899339355513454818976826392310294
    ],
    exact_row![
        -3568.10461951472288691010068910132794,
        -1755.0928109191996946687229344267234,
        -5108.90805082398622251225846397829088,
        -3522.62202559525706481553349446403464
    ],
];

impl<S: Scalar, const N: usize, const TERMS: usize> Interpolant<S, N> for Birkhoff<S, N, TERMS> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let Birkhoff { quintic, c, .. } = self;
        let theta = (t - quintic.t) / quintic.h;
        let [value, slope, _] = quintic.jet(theta);
        let u = theta - S::from_f64(0.5);
        let bar = theta * (S::one() - theta);
        let (weight, weight_slope) = (bar * bar * bar, bar * bar * u * S::from_f64(-6.0));
        let (mut polynomial, mut polynomial_slope) = (c[TERMS - 1], c[TERMS - 1] * S::zero());
        for c in c[..TERMS - 1].iter().rev() {
            polynomial_slope = polynomial_slope * u + polynomial;
            polynomial = polynomial * u + c;
        }
        State {
            t,
            q: value + polynomial * weight,
            qd: (slope + polynomial * weight_slope + polynomial_slope * weight) / quintic.h,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_degree_five_are_reproduced() {
        let q = |t: f64| 1.0 - t + 2.0 * t.powi(3) - 0.5 * t.powi(5);
        let qd = |t: f64| -1.0 + 6.0 * t.powi(2) - 2.5 * t.powi(4);
        let qdd = |t: f64| SVector::from([12.0 * t - 10.0 * t.powi(3)]);
        let state = |t: f64| State::new(t, [q(t)], [qd(t)]);
        let (a, b) = (0.3, 1.7);
        let dense = Hermite::new(&state(a), &state(b), b - a, &qdd(a), &qdd(b));
        for t in [a, 0.5, 1.1, b] {
            let difference = dense.at(t).minus(&state(t));
            assert!(difference.q[0].abs() < 1e-14 && difference.qd[0].abs() < 1e-13, "{difference:?}");
        }
    }

    /// With exact accelerations: those of a force of time alone.
    #[test]
    fn polynomials_are_reproduced_by_accelerations_in_between() {
        struct Force(i32);
        impl System<1> for Force {
            type Scalar = f64;
            fn accel(&self, _: &SVector<f64, 1>, _: &SVector<f64, 1>, t: f64) -> SVector<f64, 1> {
                [f64::from(self.0 * (self.0 - 1)) * t.powi(self.0 - 2)].into()
            }
        }
        let (a, b) = (0.3, 1.7);
        for (degree, passes) in [(5, 0), (6, 1), (7, 1), (8, 2), (9, 2), (12, 3), (13, 3)] {
            let system = Force(degree);
            let state = |t: f64| State::new(t, [t.powi(degree)], [f64::from(degree) * t.powi(degree - 1)]);
            let accel = |t: f64| system.accel(&state(t).q, &state(t).qd, t);
            let quintic = Hermite::new(&state(a), &state(b), b - a, &accel(a), &accel(b));
            let mut dense = Birkhoff::<_, 1, 8>::new(&system, quintic, passes);
            if passes > 2 {
                dense.improve(&system);
            }
            for t in [a, 0.5, 1.1, 1.5, b] {
                let difference = dense.at(t).minus(&state(t));
                let size = b.powi(degree);
                assert!(difference.q[0].abs() < 1e-14 * size, "{degree} {difference:?}");
                assert!(difference.qd[0].abs() < 2e-13 * size, "{degree} {difference:?}");
            }
        }
    }
}
