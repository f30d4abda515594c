//! Integrals along a trajectory, `∫ f(q, q̇, t) dt`: work, action, angles that were reduced away.

use crate::controller::Controller;
use crate::failure::Failure;
use crate::integrate::{Run, Statistics};
use crate::method::{Dense, Method};
use crate::sample::Failed;
use crate::scalar::{Functions, Real, Scalar};
use crate::state::State;
use crate::system::System;

/// Nodes of the longest rule.
const MOST: usize = 8;

/// A state of a run, and the integrals up to there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Total<S, const N: usize, const I: usize> {
    /// The state.
    pub state: State<S, N>,
    /// The integrals.
    pub integrals: [S; I],
}

impl<'a, Sys, M, C, const N: usize> Run<'a, Sys, M, C, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    /// Accumulates `∫ f dt` for `I` functions of the state at once, from the values `start` on: an iterator of the ends of
    /// accepted steps with the integrals up to there.
    ///
    /// Each step is integrated by the Gauss–Legendre rule with `p/2 + 1` nodes (at most 8) on the interpolant of the step,
    /// p being the order of the method. The rule is exact to degree `p + 1` or `p`, so that its error is of higher order
    /// than that of the state, and the integral is as accurate as the interpolant: it converges with the order of the
    /// method (as its tests measure), except that `Verner9` is sure of 8 and `Nystrom12` of 10. It takes the evaluations
    /// that the interpolant takes. An adaptive controller watches the state alone: a function that changes faster than the
    /// state needs a finer tolerance.
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
    /// let run = integrate(&system, Dop853, Pi::tolerance(1e-11), start).until(5.0);
    /// let end = run.integrals([0.0], |s| [system.power(&s.q, &s.qd, s.t)]).finish()?;
    /// assert!((energy(&end.state) - energy(&start) - end.integrals[0]).abs() < 1e-9);
    /// # Ok::<(), Failure>(())
    /// ```
    pub fn integrals<F, const I: usize>(
        self,
        start: [Sys::Scalar; I],
        integrand: F,
    ) -> Integrals<'a, Sys, M, C, F, N, I>
    where
        F: FnMut(&State<Sys::Scalar, N>) -> [Sys::Scalar; I],
    {
        let rule = GaussLegendre::of_order(self.method().order());
        Integrals { run: self, integrand, rule, integrals: start }
    }
}

/// A run with integrals, made by [`Run::integrals`]. After a failure it yields the failure once and ends.
pub struct Integrals<'a, Sys: System<N>, M: Method<Sys, N>, C, F, const N: usize, const I: usize> {
    run: Run<'a, Sys, M, C, N>,
    integrand: F,
    rule: GaussLegendre,
    integrals: [Sys::Scalar; I],
}

impl<Sys, M, C, F, const N: usize, const I: usize> Integrals<'_, Sys, M, C, F, N, I>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
    F: FnMut(&State<Sys::Scalar, N>) -> [Sys::Scalar; I],
{
    /// Runs to the end, which [`Run::until`] must have set, and gives the integrals of the whole run.
    pub fn finish(mut self) -> Result<Total<Sys::Scalar, N, I>, Failed<Sys::Scalar, N>> {
        if self.run.end().is_some() {
            self.by_ref().for_each(drop);
        }
        self.run.outcome()?;
        Ok(self.total())
    }

    /// The cost so far.
    pub fn statistics(&self) -> Statistics {
        self.run.statistics()
    }

    fn total(&self) -> Total<Sys::Scalar, N, I> {
        Total { state: *self.run.state(), integrals: self.integrals }
    }
}

impl<Sys, M, C, F, const N: usize, const I: usize> Iterator for Integrals<'_, Sys, M, C, F, N, I>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
    F: FnMut(&State<Sys::Scalar, N>) -> [Sys::Scalar; I],
{
    type Item = Result<Total<Sys::Scalar, N, I>, Failure<Sys::Scalar>>;

    fn next(&mut self) -> Option<Self::Item> {
        let step = match self.run.next()? {
            Ok(step) => step,
            Err(failure) => return Some(Err(failure)),
        };
        let dense = self.run.dense(&step);
        for &(node, weight) in self.rule.nodes() {
            let at = dense.at(step.h.mul_add(Sys::Scalar::from_f64(node), step.from.t));
            let weight = step.h * Sys::Scalar::from_f64(weight);
            for (integral, value) in self.integrals.iter_mut().zip((self.integrand)(&at)) {
                *integral = weight.mul_add(value, *integral);
            }
        }
        Some(Ok(self.total()))
    }
}

/// Nodes and weights on [0, 1].
#[derive(Clone, Copy, Debug)]
struct GaussLegendre {
    nodes: [(f64, f64); MOST],
    count: usize,
}

impl GaussLegendre {
    /// The rule for methods of order p: `n = p/2 + 1` nodes, exact to degree `2n − 1`.
    fn of_order(p: u32) -> Self {
        Self::of_nodes((p / 2).saturating_add(1).min(MOST as u32) as usize)
    }

    /// The zeros of the Legendre polynomial `Pₙ` by Newton's iteration, and `2/((1 − x²) Pₙ′(x)²)` (Abramowitz and Stegun
    /// 1964, 25.4.29), brought from [−1, 1] to [0, 1].
    fn of_nodes(n: usize) -> Self {
        let mut nodes = [(0.0, 0.0); MOST];
        for (i, place) in nodes.iter_mut().enumerate().take(n) {
            let mut x = -Functions::cos(core::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5));
            // The start is within 10⁻² of the zero (22.16.6 there), and each pass squares that.
            for _ in 0..5 {
                let (value, slope) = legendre(n, x);
                x -= value / slope;
            }
            let slope = legendre(n, x).1;
            *place = (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope));
        }
        GaussLegendre { nodes, count: n }
    }

    fn nodes(&self) -> &[(f64, f64)] {
        &self.nodes[..self.count]
    }
}

/// `Pₙ(x)` and `Pₙ′(x)` for |x| < 1 by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests;
