//! The motion within a step.

use crate::scalar::Real;
use crate::state::State;

/// The motion within a step, as a search for events sees it.
pub trait Within<S: Real, const N: usize> {
    /// Equal parts of the step at whose ends events are looked at.
    fn parts(&self) -> u32;
    /// States at its start and its end.
    fn ends(&self) -> [State<S, N>; 2];
    /// Its size in time.
    fn size(&self) -> S;
    /// The state of the interpolant at the fraction `x` of the step.
    fn between(&self, x: f64) -> State<S, N>;

    /// The state at the fraction `x` of the step. The ends are exact.
    fn at(&self, x: f64) -> State<S, N> {
        let [from, to] = self.ends();
        if x == 0.0 {
            from
        } else if x == 1.0 {
            to
        } else {
            self.between(x)
        }
    }

    /// The time at the fraction `x` of the step.
    fn time(&self, x: f64) -> S {
        self.size().mul_add(S::from_f64(x), self.ends()[0].t)
    }

    /// The rounding error of time, as a fraction of the step.
    fn resolution(&self) -> f64 {
        let [from, to] = self.ends();
        let (from, to, h) = (from.t.to_f64().abs(), to.t.to_f64().abs(), self.size().to_f64().abs());
        (from.max(to).max(h) / h * S::EPSILON).min(0.01)
    }
}

/// The part of a step over which the interpolant is differentiated at the place `x`, to which flights may be short.
pub(crate) fn apart(x: f64) -> f64 {
    const D: f64 = 1.0 / 4096.0;
    if x > 0.0 { D.min(0.25 * x) } else { D }
}

/// `dg/dx` along the interpolant.
pub(crate) fn slope<S: Real, const N: usize>(
    step: &(impl Within<S, N> + ?Sized),
    x: f64,
    g: impl Fn(&State<S, N>) -> S,
) -> f64 {
    let value = |x: f64| g(&step.at(x)).to_f64();
    let d = apart(x);
    (value(x + d) - value(x - d)) / (2.0 * d)
}
