//! The stability function of a method: how large a step may be.
//!
//! On `ẏ = λ y` every Runge–Kutta method multiplies y by `R(hλ)` in each step, with
//! `R(z) = 1 + z bᵀ(1 − zA)⁻¹ 1 = 1 + Σₖ (bᵀ Aᵏ⁻¹ 1) zᵏ`, a polynomial for explicit ones (Hairer and Wanner, *Solving
//! Ordinary Differential Equations II*, 1996, IV.2, eq. 2.11). A motion with the eigenvalue λ stays bounded as long as
//! `|R(hλ)| ≤ 1`; for an undamped vibration of angular frequency ω that is `λ = iω`, for a strongly damped one λ < 0.

use super::ButcherTableau;
use crate::scalar::Functions;

/// The stability function R of a method with `K` stages, the last of which is at the end of the step and has no part
/// in it.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// let rk4 = Rk4::stability();
/// assert!((rk4.real_limit() - 2.785293563405282).abs() < 1e-12);
/// assert!((rk4.imaginary_limit() - 8f64.sqrt()).abs() < 1e-12);
/// // The largest step for vibrations of 50 Hz.
/// let h = rk4.imaginary_limit() / (50.0 * std::f64::consts::TAU);
/// assert!((h - 0.009).abs() < 1e-5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityPolynomial<const K: usize> {
    order: u32,
    /// Coefficients of zᵏ.
    coefficients: [f64; K],
}

/// Twice the number of stages that any method has.
const MOST: usize = 64;

/// Rays are searched up to this |z| for the first point that is not stable, in steps of `SCAN`.
const FAR: f64 = 100.0;
const SCAN: f64 = 1.0 / 1024.0;

impl<const K: usize> StabilityPolynomial<K> {
    /// The stability function of a tableau.
    pub fn of<T: ButcherTableau<K>>() -> Self {
        const { assert!(2 * K <= MOST) };
        let mut coefficients = [0.0; K];
        coefficients[0] = 1.0;
        // bᵀ is the last row, so the last component of Aᵏ 1.
        let mut power = [1.0; K];
        for k in 1..K {
            power = core::array::from_fn(|i| (0..K).map(|j| T::A[i][j] * power[j]).sum());
            coefficients[k] = power[K - 1];
        }
        StabilityPolynomial { order: T::ORDER, coefficients }
    }

    /// The coefficients of `R(z) = Σₖ rₖ zᵏ`; `rₖ = 1/k!` up to the order of the method.
    pub fn coefficients(&self) -> &[f64; K] {
        &self.coefficients
    }

    /// `|R(x + iy)|`.
    pub fn magnitude(&self, x: f64, y: f64) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for r in self.coefficients.iter().rev() {
            (re, im) = (re * x - im * y + r, re * y + im * x);
        }
        Functions::sqrt(re * re + im * im)
    }

    /// The largest `h ω` of an undamped vibration: the y with `|R(iη)| ≤ 1` for all η from 0 to y. It is 0 where
    /// vibrations grow at any step, however slowly they do.
    pub fn imaginary_limit(&self) -> f64 {
        self.limit(0.0, 1.0)
    }

    /// The largest `h |λ|` of a decay: the x with `|R(−ξ)| ≤ 1` for all ξ from 0 to x.
    pub fn real_limit(&self) -> f64 {
        self.limit(-1.0, 0.0)
    }

    /// The largest step for the eigenvalue `λ = re + i im`, re ≤ 0: the h with `|R(sλ)| ≤ 1` for all s from 0 to h. A
    /// vibration with damping ratio ζ has `re = −ζω`, `im = ω √(1 − ζ²)`.
    pub fn limit(&self, re: f64, im: f64) -> f64 {
        let size = Functions::sqrt(re * re + im * im);
        let excess = self.excess(re / size, im / size);
        // The first term decides for small s. Divided by it, the sign survives rounding near 0.
        let Some(first) = excess.iter().position(|&c| c != 0.0) else { return f64::INFINITY };
        let unstable = |s: f64| excess[first..].iter().rev().fold(0.0, |sum, c| sum * s + c) > 0.0;
        if unstable(0.0) {
            return 0.0;
        }
        let mut inside = 0.0;
        while !unstable(inside + SCAN) {
            inside += SCAN;
            if inside > FAR {
                return f64::INFINITY;
            }
        }
        let mut outside = inside + SCAN;
        for _ in 0..45 {
            let middle = 0.5 * (inside + outside);
            if unstable(middle) {
                outside = middle;
            } else {
                inside = middle;
            }
        }
        inside / size
    }

    /// The coefficients of `|R(su)|² − 1` in powers of s, for u = x + iy of size 1.
    fn excess(&self, x: f64, y: f64) -> [f64; MOST] {
        let mut terms = [(0.0, 0.0); K];
        let mut power = (1.0, 0.0);
        for (term, r) in terms.iter_mut().zip(self.coefficients) {
            *term = (r * power.0, r * power.1);
            power = (power.0 * x - power.1 * y, power.0 * y + power.1 * x);
        }
        let (mut excess, mut sizes) = ([0.0; MOST], [0.0; MOST]);
        for (i, a) in terms.iter().enumerate() {
            for (j, b) in terms.iter().enumerate() {
                let product = a.0 * b.0 + a.1 * b.1;
                excess[i + j] += product;
                sizes[i + j] += product.abs();
            }
        }
        // Up to the order they are those of |exp(su)|² − 1, exactly; beyond it, what is rounding is nothing.
        let mut exact = 1.0;
        excess[0] = 0.0;
        for m in 1..2 * K {
            exact *= 2.0 * x / m as f64;
            if m <= self.order as usize {
                excess[m] = exact;
            } else if excess[m].abs() < 1e-13 * sizes[m] {
                excess[m] = 0.0;
            }
        }
        excess
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;
    use super::*;
    use crate::method::Method;
    use nalgebra::SVector;

    #[test]
    fn limits_are_those_of_the_books() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(Euler::stability().real_limit(), 2.0);
        close(Euler::stability().imaginary_limit(), 0.0);
        close(Heun::stability().real_limit(), 2.0);
        close(Heun::stability().imaginary_limit(), 0.0);
        close(Rk4::stability().real_limit(), 2.785293563405282);
        close(Rk4::stability().imaginary_limit(), 8f64.sqrt());
        // R = 1 + z/1! + … + z⁵/5! + z⁶/600 (Hairer and Wanner 1996, IV.2).
        close(DormandPrince5::stability().coefficients()[6], 1.0 / 600.0);
        close(Euler::stability().limit(-3.0, 4.0), 6.0 / 25.0);
    }

    fn coefficients_are_those_of_the_exponential<T: ButcherTableau<K>, const K: usize>() {
        let stability = StabilityPolynomial::<K>::of::<T>();
        let mut factorial = 1.0;
        for (k, r) in stability.coefficients().iter().enumerate().take(T::ORDER as usize + 1) {
            factorial *= if k == 0 { 1.0 } else { k as f64 };
            assert!((r * factorial - 1.0).abs() < 1e-9, "{}: z^{k}", T::NAME);
        }
        assert_eq!(stability.coefficients()[K - 1] == 0.0, T::A[K - 1][K - 2] == 0.0);
    }

    /// `q̈ = −q − 2ζ q̇`.
    struct Oscillator {
        zeta: f64,
    }

    impl System<1> for Oscillator {
        type Scalar = f64;
        fn accel(&self, q: &SVector<f64, 1>, qd: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
            -q - qd * (2.0 * self.zeta)
        }
    }

    /// Factor by which 200 steps of size h multiply the part of the motion that belongs to the eigenvalue λ, namely
    /// `w = q̇ − λ̃ q`, where λ̃ is the other eigenvalue (the real one, or the conjugate with `re` and `im`), since
    /// ẇ = λ w.
    fn growth<M: Method<Oscillator, 1> + Default>(zeta: f64, other: (f64, f64), h: f64) -> f64 {
        let system = Oscillator { zeta };
        let size = |state: &State<f64, 1>| {
            let (re, im) = (state.qd[0] - other.0 * state.q[0], other.1 * state.q[0]);
            Functions::sqrt(re * re + im * im)
        };
        let start = State::new(0.0, [1.0], [0.0]);
        let (method, mut state) = (M::default(), start);
        let mut memory = method.start(&system, &state).unwrap();
        for _ in 0..200 {
            let (step, next) = method.step(&system, &memory, &state, h).unwrap();
            (state, memory) = (step.to, next);
        }
        size(&state) / size(&start)
    }

    fn motions_grow_beyond_the_limit<T, const K: usize>()
    where
        T: ButcherTableau<K> + Method<Oscillator, 1> + Default,
    {
        let stability = StabilityPolynomial::<K>::of::<T>();
        for zeta in [0.0f64, 0.1, 0.5, 0.9, 2.0] {
            let root = (1.0 - zeta * zeta).abs().sqrt();
            // Above critical damping the faster eigenvalue limits the step.
            let (h, other) = if zeta < 1.0 {
                (stability.limit(-zeta, root), (-zeta, root))
            } else {
                (stability.limit(-zeta - root, 0.0), (root - zeta, 0.0))
            };
            if h == 0.0 {
                assert!(zeta == 0.0 && growth::<T>(zeta, other, 0.3) > 1.0, "{}", T::NAME);
                continue;
            }
            let [below, above] = [0.99, 1.01].map(|factor| growth::<T>(zeta, other, factor * h));
            assert!(below < 1.0 && above > 1.0, "{} {zeta} at {h}: {below} {above}", T::NAME);
        }
    }

    #[test]
    fn every_row_is_as_stable_as_its_function_says() {
        for_each_tableau!(coefficients_are_those_of_the_exponential);
        for_each_tableau!(motions_grow_beyond_the_limit);
    }
}
