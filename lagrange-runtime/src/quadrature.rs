//! Integrals along a trajectory, `∫ f(q, q̇, t) dt`: work, action, angles that were reduced away.

use crate::controller::Controller;
use crate::failed::Failed;
use crate::failure::Failure;
use crate::integrate::{Drive, Number, Run, Statistics};
use crate::method::{Interpolant, Method};
use crate::scalar::{Functions, Real};
use crate::state::State;
use crate::system::System;

/// Nodes of the rule on each part of a step. With six, steps of one radian need no parts for the digits of `f64`.
const NODES: usize = 6;

/// Deviation of the polynomial through the nodes from the integrand at the ends of a part, in units of the
/// integrand's range there, up to which the integrand is smooth. A kink that is missed has an error of its square;
/// where the sums of smooth integrands agree, the deviation is below 1e-7.
const SMOOTH: f64 = 1e-5;

/// Rounding errors of the same, in ulps of the integrand.
const NOISE: f64 = 1024.0;

/// Bisections of a step, one inside the other. Where the integrand jumps, what is left is the rounding of time.
const MAX_DEPTH: u32 = 120;

/// Bisections up to which parts show how large an integrand is that has no pole.
const MAX_COARSE_DEPTH: u32 = 12;

/// Largest contribution of a part that is shorter than the rounding of time, in ulps of the integral, or of the
/// integrand times the time.
const MAX_ROUNDING: f64 = 1024.0;

/// Bisections of a step, all together: more would be no integral but a search.
const MAX_PARTS: u32 = 20_000;

/// A state of a run, and the integrals up to there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Total<S, const N: usize, const I: usize> {
    /// The state.
    pub state: State<S, N>,
    /// The integrals, in the order of the integrands, each in its unit times that of t.
    pub integrals: [S; I],
}

impl<Sys, M, C, const N: usize> Run<'_, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// Accumulates `∫ f dt` for `I` functions of the state at once, from the values `start` on: an iterator of the
    /// ends of accepted steps with the integrals up to there.
    ///
    /// Each step is integrated on its interpolant, by the Gauss–Legendre rule with six nodes on the step and on its
    /// halves. Their difference is the error of the first, and 2¹² times that of the second where the integrand is
    /// smooth; the halves are divided likewise until they agree to 2⁶ ulps of the integral. So the interpolant is
    /// integrated to rounding, in the digits of the scalar, also over long steps and of integrands that change much
    /// faster than the state, up to 20,000 parts of a step (some 10⁴ oscillations, or 300 kinks): the error of the
    /// integral is that of the interpolant. That of an orbit's angle is up to three times that of its radius with every
    /// adaptive method. A step takes 21 evaluations of integrand and interpolant, and 15 more for each part.
    ///
    /// # Hypotheses
    /// - The integrand is finite.
    /// - It shows at the 18 nodes of a step: a pulse between them that is 0 elsewhere is not seen.
    ///
    /// # Errors
    /// Those of the run; [`Failure::Quadrature`] at a step in which the integrand is not finite or too rough to be
    /// integrated.
    ///
    /// What friction and a drive do to a pendulum is the change of its energy, `ΔE = ∫ (Q − ∂D/∂q̇)·q̇ dt` (Beatty,
    /// *Principles of Engineering Mechanics 2*, 2006, (11.52)):
    ///
    /// ```
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Driven {
    ///         param m, l, c, torque, g = 9.81;
    ///         coord theta: angle;
    ///         T = 0.5 * m * (l * dot(theta)).powi(2);
    ///         V = -m * g * l * cos(theta);
    ///         D = 0.5 * c * dot(theta).powi(2);
    ///         Q[theta] = torque * cos(2 * t);
    ///     }
    /// }
    /// let system = Driven::new(1.0, 0.7, 0.1, 0.5);
    /// let energy = |s: &State<f64, 1>| system.energy(&s.q, &s.qd, s.t);
    /// let start = State::new(0.0, [1.0], [0.0]);
    /// let run = integrate(&system, Dop853, PiController::tolerance(1e-11), start).until(5.0);
    /// let end = run.integrals([0.0], |s| [system.power(&s.q, &s.qd, s.t)]).total()?;
    /// assert!((energy(&end.state) - energy(&start) - end.integrals[0]).abs() < 1e-9);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn integrals<F, const I: usize>(
        self,
        start: [Sys::Scalar; I],
        integrand: F,
    ) -> Integrals<Self, F, N, I>
    where
        F: FnMut(&State<Sys::Scalar, N>) -> [Sys::Scalar; I],
    {
        Integrals::new(self, start, integrand)
    }
}

/// A run, or a stretch of a stepper's way, with integrals, made by [`Run::integrals`]. After a failure it yields the
/// failure once and ends.
#[must_use = "it makes no step unless it is iterated over, or run to its end"]
pub struct Integrals<D: Drive<N>, F, const N: usize, const I: usize> {
    run: D,
    integrand: F,
    /// Nodes and weights on [0, 1].
    rule: [[Number<D, N>; 3]; NODES],
    integrals: [Number<D, N>; I],
}

impl<D, F, const N: usize, const I: usize> Integrals<D, F, N, I>
where
    D: Drive<N>,
    F: FnMut(&State<Number<D, N>, N>) -> [Number<D, N>; I],
{
    pub(crate) fn new(run: D, start: [Number<D, N>; I], integrand: F) -> Self {
        Integrals { run, integrand, rule: gauss_legendre(), integrals: start }
    }

    /// Runs to the end, which [`Run::until`] must have set, and gives the integrals of the whole run.
    pub fn total(mut self) -> Result<Total<Number<D, N>, N, I>, Failed<Number<D, N>, N>> {
        if self.run.end().is_some() {
            self.by_ref().for_each(drop);
        }
        self.run.outcome()?;
        Ok(self.so_far())
    }

    /// The cost so far.
    pub fn statistics(&self) -> Statistics {
        self.run.statistics()
    }

    fn so_far(&self) -> Total<Number<D, N>, N, I> {
        Total { state: *self.run.state(), integrals: self.integrals }
    }
}

impl<D, F, const N: usize, const I: usize> Iterator for Integrals<D, F, N, I>
where
    D: Drive<N>,
    F: FnMut(&State<Number<D, N>, N>) -> [Number<D, N>; I],
{
    type Item = Result<Total<Number<D, N>, N, I>, Failure<Number<D, N>>>;

    fn next(&mut self) -> Option<Self::Item> {
        let step = match self.run.advance()? {
            Ok(step) => step,
            Err(failure) => return Some(Err(failure)),
        };
        let dense = self.run.interpolant(&step);
        let [t, h] = [step.from.t, step.h];
        let Integrals { integrand, rule, integrals, .. } = self;
        let mut quadrature = Quadrature {
            integrand: |t| integrand(&dense.at(t)),
            rule,
            scale: integrals.map(Real::magnitude),
            peak: [0.0; I],
            parts: 0,
        };
        let whole = quadrature.panel(t, h, 0);
        for (scale, size) in quadrature.scale.iter_mut().zip(whole.sizes) {
            *scale = scale.max(size);
        }
        match quadrature.refined(t, h, &whole, 0) {
            Some(sums) => {
                integrals.iter_mut().zip(sums).for_each(|(integral, sum)| *integral += sum);
                Some(Ok(self.so_far()))
            }
            None => Some(Err(self.run.fail(Failure::Quadrature { t, h }))),
        }
    }
}

/// Integral over a part of a step.
struct Panel<S, const I: usize> {
    sums: [S; I],
    /// ∫|f|
    sizes: [f64; I],
    /// Values at both ends of the polynomial through the nodes.
    ends: [[S; I]; 2],
    /// The least and the largest value at the nodes.
    range: [[f64; 2]; I],
}

impl<S: Real, const I: usize> Panel<S, I> {
    /// Returns whether the polynomial is the integrand at an end: a jump or kink between an end and the node beside
    /// it shows there alone. `negligible` is the deviation that does not matter.
    fn meets(&self, end: usize, values: &[S; I], negligible: impl Fn(usize) -> f64) -> bool {
        (0..I).all(|i| {
            let (value, [least, largest]) = (values[i].to_f64(), self.range[i]);
            let (least, largest) = (least.min(value), largest.max(value));
            let rounding = NOISE * S::EPSILON * least.abs().max(largest.abs());
            let tolerated = (SMOOTH * (largest - least) + rounding).max(negligible(i));
            (self.ends[end][i] - values[i]).magnitude() <= tolerated
        })
    }
}

/// Adaptive quadrature by bisection over one step.
struct Quadrature<'a, F, S, const I: usize> {
    integrand: F,
    rule: &'a [[S; 3]; NODES],
    /// Magnitudes to which errors are relative.
    scale: [f64; I],
    /// Largest |f| that was found in parts that are not short.
    peak: [f64; I],
    parts: u32,
}

impl<F: FnMut(S) -> [S; I], S: Real, const I: usize> Quadrature<'_, F, S, I> {
    /// Values of the integrand, in a part of this depth.
    fn values(&mut self, t: S, depth: u32) -> [S; I] {
        let values = (self.integrand)(t);
        if depth <= MAX_COARSE_DEPTH {
            for (peak, value) in self.peak.iter_mut().zip(values) {
                *peak = peak.max(value.magnitude());
            }
        }
        values
    }

    /// The rule from `t` to `t + h`.
    fn panel(&mut self, t: S, h: S, depth: u32) -> Panel<S, I> {
        let mut panel = Panel {
            sums: [S::zero(); I],
            sizes: [0.0; I],
            ends: [[S::zero(); I]; 2],
            range: [[f64::INFINITY, f64::NEG_INFINITY]; I],
        };
        for (k, &[node, weight, at_start]) in self.rule.iter().enumerate() {
            let weight = h * weight;
            // The nodes lie evenly about the middle.
            let at_ends = [at_start, self.rule[NODES - 1 - k][2]];
            let values = self.values(h.mul_add(node, t), depth);
            for (i, value) in values.into_iter().enumerate() {
                panel.sums[i] = weight.mul_add(value, panel.sums[i]);
                panel.sizes[i] += (weight * value).magnitude();
                for (end, factor) in panel.ends.iter_mut().zip(at_ends) {
                    end[i] = factor.mul_add(value, end[i]);
                }
                let [least, largest] = &mut panel.range[i];
                (*least, *largest) = (least.min(value.to_f64()), largest.max(value.to_f64()));
            }
        }
        panel
    }

    /// The integral over a part, of which `whole` is the rule, by halves until they agree; `None` where they do not.
    fn refined(&mut self, t: S, h: S, whole: &Panel<S, I>, depth: u32) -> Option<[S; I]> {
        self.parts += 1;
        let half = h * S::from_f64(0.5);
        let middle = t + half;
        let [first, second] = [t, middle].map(|t| self.panel(t, half, depth + 1));
        let sums: [S; I] = core::array::from_fn(|i| first.sums[i] + second.sums[i]);
        // Where the integrand sets in late in a step, the whole does not show how large the integral is.
        for (i, scale) in self.scale.iter_mut().enumerate() {
            *scale = scale.max(first.sizes[i] + second.sizes[i]);
        }
        // Below this size weighted values lose digits to underflow.
        let smallest = if S::EPSILON > 1e-10 { f64::from(f32::MIN_POSITIVE) } else { f64::MIN_POSITIVE };
        let least = smallest / (S::EPSILON * S::EPSILON);
        // Not a number is no agreement.
        let agree = (0..I).all(|i| {
            let tolerated = (1 << NODES) as f64 * S::EPSILON * self.scale[i].max(least);
            // (Sums of an integrand that is odd about the middle agree even at a pole there, and its magnitude tells.)
            let size = first.sizes[i] + second.sizes[i];
            let alike = (size - whole.sizes[i]).abs() <= 0.1 * size || size <= tolerated;
            alike && (sums[i] - whole.sums[i]).magnitude() <= tolerated
        });
        let agree = agree && {
            let [at_start, at_middle, at_end] = [t, middle, t + h].map(|t| self.values(t, depth));
            let negligible =
                |i: usize| (1 << NODES) as f64 * S::EPSILON * self.scale[i].max(least) / h.magnitude();
            first.meets(0, &at_start, negligible)
                && first.meets(1, &at_middle, negligible)
                && second.meets(0, &at_middle, negligible)
                && second.meets(1, &at_end, negligible)
        };
        // Within a part that is shorter than the rounding of time there is a jump at most; a pole still counts there.
        let negligible = |i: usize| {
            let instant = self.scale[i] + self.peak[i] * (t.magnitude() + h.magnitude());
            first.sizes[i] + second.sizes[i] <= MAX_ROUNDING * S::EPSILON * instant
        };
        let instant = middle + half * S::from_f64(0.5) == middle;
        if agree || instant && (0..I).all(negligible) {
            return Some(sums);
        }
        if instant
            || depth >= MAX_DEPTH
            || self.parts > MAX_PARTS
            || sums.iter().any(|x| !x.magnitude().is_finite())
        {
            return None;
        }
        let first = self.refined(t, half, &first, depth + 1)?;
        let second = self.refined(middle, half, &second, depth + 1)?;
        Some(core::array::from_fn(|i| first[i] + second[i]))
    }
}

/// Nodes and weights of the Gauss–Legendre rule on [0, 1] in the digits of the scalar: zeros of the Legendre
/// polynomial `Pₙ` by Newton's iteration, and `2/((1 − x²) Pₙ′(x)²)` (Abramowitz and Stegun 1964, 25.4.29), brought
/// from [−1, 1] to [0, 1]; and the factor of each node's value in the value at 0 of the polynomial through all.
fn gauss_legendre<S: Real>() -> [[S; 3]; NODES] {
    let rule: [[S; 2]; NODES] = core::array::from_fn(|i| {
        let n = NODES as f64;
        let start = -Functions::cos(core::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5));
        let mut x = S::from_f64(start);
        // The start is within 10⁻² of the zero (22.16.6 there), and each pass squares that.
        for _ in 0..6 {
            let [value, slope] = legendre(x);
            x -= value / slope;
        }
        let [_, slope] = legendre(x);
        [(S::one() + x) * S::from_f64(0.5), S::one() / ((S::one() - x * x) * slope * slope)]
    });
    core::array::from_fn(|k| {
        let [node, weight] = rule[k];
        let others = (0..NODES).filter(|&j| j != k).map(|j| rule[j][0]);
        [node, weight, others.fold(S::one(), |product, other| product * other / (other - node))]
    })
}

/// `Pₙ(x)` and `Pₙ′(x)` for |x| < 1 by the three-term recurrence.
fn legendre<S: Real>(x: S) -> [S; 2] {
    let number = |k: usize| S::from_f64(k as f64);
    let (mut before, mut value) = (S::zero(), S::one());
    for k in 0..NODES {
        let next = (number(2 * k + 1) * x * value - number(k) * before) / number(k + 1);
        (before, value) = (value, next);
    }
    [value, number(NODES) * (x * value - before) / (x * x - S::one())]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::DoubleDouble;

    /// The rule is exact to degree 2n − 1 in the digits of the scalar, and no further.
    #[test]
    fn the_rule_is_exact_to_its_degree() {
        fn errors<S: Real>() -> [f64; 2 * NODES + 1] {
            let rule = gauss_legendre::<S>();
            core::array::from_fn(|degree| {
                let power = |x: S| (0..degree).fold(S::one(), |power, _| power * x);
                let sum = rule.iter().fold(S::zero(), |sum, [x, w, _]| sum + *w * power(*x));
                (sum - S::one() / S::from_f64(degree as f64 + 1.0)).magnitude()
            })
        }
        let check = |errors: [f64; 2 * NODES + 1], rounding: f64| {
            let (last, exact) = errors.split_last().unwrap();
            assert!(exact.iter().all(|error| *error < 4.0 * rounding), "{exact:?}");
            assert!(*last > 1e-8, "{last}");
        };
        check(errors::<f64>(), f64::EPSILON);
        check(errors::<DoubleDouble>(), DoubleDouble::EPSILON);
    }
}
