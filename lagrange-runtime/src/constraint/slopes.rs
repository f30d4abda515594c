//! Derivatives of motions by parameters that move constraints.

use super::Constrained;
use super::dependence::chosen;
use crate::failure::Failure;
use crate::linear::lu;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use nalgebra::{SMatrix, SVector};

/// Slope of a constraint by a parameter, relative to its gradient, that is rounding.
const OWN: f64 = 1e-9;

/// Parts of a step in which gradients turn by less than a right angle.
const PARTS: usize = 16;

/// Fails if a step has gone through a position at which constraints are dependent, and the slopes that numbers carry
/// move a constraint: with another value of the parameter the motion would have stopped there, or taken another branch.
/// Emitted as [`System::differentiable`](crate::System::differentiable).
///
/// The gradients A of independent constraints are oriented: `det(A A'ᵀ)` is positive from one state to the next, and
/// becomes negative where a branch point is passed, as the determinant of curves of equilibria does (Keller 1977).
///
/// # Errors
/// [`Failure::NotDifferentiable`].
#[cold]
#[inline(never)]
pub fn differentiable<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    let Some(constraint) = moved(system, to) else { return Ok(()) };
    let gradients = |q: SVector<Sys::Scalar, N>, t| system.constraint_jacobian(&q, t).map(|x| x.to_f64());
    let chosen = chosen(system, from);
    let turns = |parts: usize| {
        let mut before = gradients(from.q, from.t);
        let mut turned = false;
        for k in 1..=parts {
            let (q, t) = between(from, to, k as f64 / parts as f64);
            let after = gradients(q, t);
            turned ^= are_opposite(&before, &after, &chosen);
            before = after;
        }
        turned
    };
    if turns(1) && turns(PARTS) {
        return Err(Failure::NotDifferentiable {
            t: to.t,
            constraint: Sys::FACTS.constraints[constraint].name,
        });
    }
    Ok(())
}

/// A constraint whose value changes with what the slopes are by, at the same coordinates.
fn moved<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Option<usize>
where
    Sys::Scalar: Real,
{
    let fixed = |x: &SVector<Sys::Scalar, N>| x.map(|x| Sys::Scalar::from_f64(x.to_f64()));
    let (q, qd, t) = (fixed(&at.q), fixed(&at.qd), Sys::Scalar::from_f64(at.t.to_f64()));
    let (values, rates) = (system.constraints(&q, t), system.constraint_rates(&q, &qd, t));
    let gradients = system.constraint_jacobian(&q, t);
    let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, f64::max);
    let fastest = largest(&mut qd.iter().map(|v| v.to_f64().abs()));
    (0..M).find(|&j| {
        let gradient = largest(&mut (0..N).map(|i| gradients[(j, i)].to_f64().abs()));
        values[j].infinitesimal().magnitude() > OWN * gradient
            || rates[j].infinitesimal().magnitude() > OWN * gradient * fastest
    })
}

/// The place at the part x of a step, by the cubic through its ends.
fn between<S: Real, const N: usize>(from: &State<S, N>, to: &State<S, N>, x: f64) -> (SVector<S, N>, S) {
    let (h, y) = (to.t - from.t, 1.0 - x);
    let part = S::from_f64;
    let q = SVector::from_fn(|i, _| {
        from.q[i] * part(y * y * (1.0 + 2.0 * x))
            + to.q[i] * part(x * x * (1.0 + 2.0 * y))
            + (from.qd[i] * part(x * y * y) - to.qd[i] * part(x * x * y)) * h
    });
    (q, from.t + h * part(x))
}

/// Is `det(A Bᵀ)` negative, of the rows that are chosen?
fn are_opposite<const N: usize, const M: usize>(
    a: &SMatrix<f64, M, N>,
    b: &SMatrix<f64, M, N>,
    chosen: &[bool; M],
) -> bool {
    let products = SMatrix::<f64, M, M>::from_fn(|i, j| match (i == j, chosen[i] && chosen[j]) {
        (_, true) => (0..N).map(|k| a[(i, k)] * b[(j, k)]).sum(),
        (same, false) => f64::from(u8::from(same)),
    });
    lu(&products).is_ok_and(|factors| factors.has_negative_determinant())
}
