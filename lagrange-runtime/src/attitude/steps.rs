//! Parameters with which steps begin, and which two states have in common.

use super::{BOUND, other, square};
#[cfg(feature = "analysis")]
use crate::scalar::Dual;
use crate::scalar::{DoubleDouble, Real, Scalar};
use crate::state::{State, Tangent};
#[cfg(feature = "analysis")]
use nalgebra::DVector;
use nalgebra::{SVector, Vector3};

/// The attitudes, by their first coordinates, whose |σ|² is beyond `bound`.
#[cfg(feature = "analysis")]
pub(crate) fn beyond<'a, S: Real, const N: usize>(
    attitudes: &'a [usize],
    bound: f64,
    at: &'a State<S, N>,
) -> impl Iterator<Item = usize> + Clone + 'a {
    attitudes.iter().copied().filter(move |first| square(&at.parameters(*first)).to_f64() > bound)
}

/// The attitudes whose other parameters are nearer to those of another state.
#[cfg(feature = "analysis")]
pub(crate) fn astray<'a, const N: usize>(
    attitudes: &'a [usize],
    at: &'a State<f64, N>,
    near: &'a State<f64, N>,
) -> impl Iterator<Item = usize> + Clone + 'a {
    attitudes.iter().copied().filter(move |first| {
        let [there, here] = [near, at].map(|at| at.parameters(*first));
        let size = square(&here).sqrt();
        size > 0.0 && square(&(here - there)) > square(&(here / (size * size) + there))
    })
}

/// The same deviation from a state by the other parameters of these attitudes.
#[cfg(feature = "analysis")]
pub(crate) fn turned_deviation<S: Scalar, const N: usize>(
    attitudes: impl Iterator<Item = usize>,
    at: &State<S, N>,
    deviation: &State<S, N>,
) -> State<S, N> {
    let with = |at: &SVector<S, N>, slope: &SVector<S, N>| {
        SVector::from_fn(|i, _| Dual { value: at[i], slope: slope[i] })
    };
    let moved =
        State { t: Dual::constant(at.t), q: with(&at.q, &deviation.q), qd: with(&at.qd, &deviation.qd) };
    State { t: at.t, ..moved.turned(attitudes).map(|x| x.slope) }
}

/// Roundings that `at` lacks, which is a state with the roundings `lost` by other parameters of some of its attitudes.
pub(crate) fn lost<S: Real, const N: usize>(
    attitudes: &[usize],
    from: &State<S, N>,
    lost: &Tangent<S, N>,
    at: &State<S, N>,
) -> Tangent<S, N> {
    let mut rest = *lost;
    for &first in attitudes {
        // (All digits of a number that has more.)
        let wide = |x: S| {
            let near = x.to_f64();
            DoubleDouble::from_f64(near) + DoubleDouble::from_f64((x - S::from_f64(near)).to_f64())
        };
        let whole = |x: &SVector<S, N>, rest: &SVector<S, N>| {
            Vector3::from([0, 1, 2].map(|i| wide(x[first + i]) + wide(rest[first + i])))
        };
        if from.parameters(first) == at.parameters(first) {
            continue;
        }
        let [sigma, rate] = other(&whole(&from.q, &lost.q), &whole(&from.qd, &lost.qd));
        let missing = |exact: DoubleDouble, x: S| S::from_f64((exact - wide(x)).to_f64());
        for i in 0..3 {
            rest.q[first + i] = missing(sigma[i], at.q[first + i]);
            rest.qd[first + i] = missing(rate[i], at.qd[first + i]);
        }
    }
    rest
}

/// The same place by the shorter parameters of attitudes with which a step would not begin, if there are any.
#[cfg(feature = "analysis")]
pub(crate) fn shortened_place(attitudes: &[usize], place: &DVector<f64>) -> Option<DVector<f64>> {
    let mut shorter = place.clone();
    for first in attitudes {
        let at = State { t: 0.0, q: place.fixed_rows::<3>(*first).into_owned(), qd: SVector::zeros() };
        if let Some(at) = shortened(&[0], &at, None) {
            shorter.fixed_rows_mut::<3>(*first).copy_from(&at.q);
        }
    }
    (shorter != *place).then_some(shorter)
}

/// |σ|² in the middle of an equal step, by the velocities alone, above which accelerations are looked at, too.
const LOOKED_AT: f64 = 0.5;

/// σ in the middle of a step of size h, by its rates and, if they are given, accelerations.
#[inline(always)]
fn middle<S: Scalar, const N: usize>(
    at: &State<S, N>,
    first: usize,
    h: S,
    accelerations: Option<&SVector<S, N>>,
) -> Vector3<S> {
    let half = h * S::from_f64(0.5);
    let rate = |i: usize| match accelerations {
        Some(accelerations) => at.qd[i] + accelerations[i] * half * S::from_f64(0.5),
        None => at.qd[i],
    };
    Vector3::from([0, 1, 2].map(|i| at.q[first + i] + rate(first + i) * half))
}

/// Returns whether the next step may begin with other parameters, see [`far`].
#[inline(always)]
pub(crate) fn may_change<S: Real, const N: usize>(
    attitudes: &[usize],
    at: &State<S, N>,
    equal: Option<S>,
) -> bool {
    attitudes.iter().any(|&first| match equal {
        None => square(&at.parameters(first)).to_f64() > BOUND,
        Some(h) => square(&middle(at, first, h, None)).to_f64() > LOOKED_AT,
    })
}

/// Attitudes whose other parameters the next step is to begin with. It is one of `equal` steps, whose size and
/// accelerations at its start are given, or has a size of its own.
///
/// In other parameters a symplectic method conserves another energy, by an error of its own, so that each change of
/// parameters adds to the energy. Where the middle of a step decides, parameters change where the motion backwards in
/// time changes them, and what the changes add cancels on the way; where its start decides, it grows with every turn.
#[inline(always)]
pub(crate) fn far<'a, S: Real, const N: usize>(
    attitudes: &'a [usize],
    at: &'a State<S, N>,
    equal: Option<(S, SVector<S, N>)>,
) -> impl Iterator<Item = usize> + Clone + 'a {
    attitudes.iter().copied().filter(move |&first| match &equal {
        None => square(&at.parameters(first)).to_f64() > BOUND,
        Some((h, accelerations)) => square(&middle(at, first, *h, Some(accelerations))).to_f64() > 1.0,
    })
}

/// The same state by the parameters with which the next step is to begin, if these are others, see [`far`].
#[inline(always)]
pub(crate) fn shortened<S: Real, const N: usize>(
    attitudes: &[usize],
    at: &State<S, N>,
    equal: Option<(S, SVector<S, N>)>,
) -> Option<State<S, N>> {
    let far = far(attitudes, at, equal);
    far.clone().next().map(|_| at.turned(far))
}
