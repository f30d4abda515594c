//! Branches of the motion at positions in which constraints are dependent.
//!
//! Where a combination ν of the gradients vanishes, `νᵀ A = 0`, the constraints admit more displacements to first
//! order, those with `A b = 0`, and restrict them to second order: `νᵀ (dA/ds) b = 0`, A being taken at `q + s b`. Of
//! a mechanism with one freedom these are the zeros of a quadratic form in two unknowns: two directions, the tangents
//! of two branches that cross there; one, where they touch; or none (the tangent cone: Lerbet, *ZAMM* 78, 1998).

use super::Constrained;
use crate::diagnosis::{MAX_MATRIX_BYTES, beside};
use crate::facts::ConstraintKind;
use crate::failure::{Coordinate, Failure};
use crate::scalar::{Functions, Real, Scalar};
use crate::state::{State, constant};
use nalgebra::{SMatrix, SVector};

/// Branches that go through a position in which the constraints of a mechanism with one freedom are dependent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branches<S, const N: usize> {
    /// The position.
    pub q: SVector<S, N>,
    /// Their tangents, whose largest component is 1. They are the same where the branches touch.
    pub directions: [SVector<S, N>; 2],
}

/// Square of the sine of the angle below which tangents, or a velocity and a tangent, count as the same.
const SAME: f64 = 1e-10;

/// Part of the kinetic energy with which a motion that arrives has stopped.
const STOPPED: f64 = 1e-6;

/// Pivot of a gradient beside which it depends on those before it, too: of two loops in one line both do, and there are
/// more branches than two.
const INDEPENDENT: f64 = 1e-4;

/// Distance, relative to `1 + |q|`, at which a state is at the position.
const THERE: f64 = 1e-7;

/// Largest value of a constraint, in units of its gradient, in a position of the mechanism: others are near positions
/// of another one.
const ADMITTED: f64 = 1e-9;

/// Largest distance at which the position is looked for, relative to `1 + |q|`.
const NEAR: f64 = 0.5;

/// Step of differences in units of `1 + |q|`, of fourth order.
const DIFFERENCE: f64 = 1e-3;

/// Near a position in which branches touch a correction is a third of the distance.
const MOST_CORRECTIONS: u32 = 100;

/// The branches through the position nearest to `at` in which the constraints are dependent, found by Newton's
/// method.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::traits::branches;
///
/// lagrangian! {
///     /// A bead on two wires that cross.
///     system Cross {
///         param g = 9.81;
///         coord x, y;
///         T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
///         V = g * y;
///         constraint wires: x * (x - y) == 0;
///     }
/// }
/// let found = branches(&Cross::new(), &State::new(0.0, [0.1, 0.2], [0.0, 0.0])).unwrap();
/// assert!(found.q.norm() < 1e-12);
/// let slopes = found.directions.map(|along| along[0] / along[1]);
/// assert!(slopes.iter().any(|x| x.abs() < 1e-9) && slopes.iter().any(|x| (x - 1.0).abs() < 1e-9));
/// ```
///
/// # Hypotheses
/// - N = M + 1, and the constraints are on positions, do not depend on time and do not follow from others everywhere;
///   exactly one combination of their gradients vanishes. `None` otherwise, where the constraints admit no motion at
///   all, and where the form vanishes.
/// - Directions have some ten digits.
#[cold]
pub fn branches<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Option<Branches<Sys::Scalar, N>>
where
    Sys::Scalar: Real,
{
    let found = crossing::<Sys, N, M>(system, at)?;
    let number = |x: &SVector<f64, N>| x.map(Sys::Scalar::from_f64);
    Some(Branches { q: number(&found.q), directions: found.directions.each_ref().map(number) })
}

/// Fails near a position in which branches touch, so that velocities fit both. Emitted as
/// [`System::determined`](crate::System::determined).
///
/// # Errors
/// [`Failure::Bifurcation`].
#[cold]
#[inline(never)]
pub fn determined<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    undetermined::<Sys, N, M>(system, start, at, false).map_or(Ok(()), Err)
}

/// [`Failure::Bifurcation`] if nothing tells which branch a motion takes that began at `start` and is at `at`: it
/// reaches the position with no velocity (if it has `failed`), or with one along both branches or neither.
#[cold]
pub(super) fn undetermined<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    failed: bool,
) -> Option<Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    let Branches { q, directions } = crossing::<Sys, N, M>(system, at)?;
    let there = State { q: q.map(Sys::Scalar::from_f64), qd: constant(Scalar::zero()), t: at.t };
    let mass = |at: &State<Sys::Scalar, N>| system.inertia(&at.q, &at.qd, at.t).map(|x| x.to_f64());
    let inertia = mass(&there);
    let product = |a: &SVector<f64, N>, b: &SVector<f64, N>| a.dot(&(inertia * b));
    let velocity = |at: &State<Sys::Scalar, N>| at.qd.map(|x| x.to_f64());
    let energy = |at: &State<Sys::Scalar, N>| velocity(at).dot(&(mass(at) * velocity(at)));
    let v = velocity(at);
    let sine_squared = |a: &SVector<f64, N>, b: &SVector<f64, N>| {
        let mixed = product(a, b);
        1.0 - mixed * mixed / (product(a, a) * product(b, b))
    };
    let along = |b: &SVector<f64, N>| sine_squared(&v, b) <= SAME;
    let apart = sine_squared(&directions[0], &directions[1]);
    // What is left of the kinetic energy there.
    let force = system.momentum_rate(&there.q, &there.qd, there.t).map(|x| x.to_f64());
    let way = q - at.q.map(|x| x.to_f64());
    let most = energy(start).max(energy(at));
    let stopped = failed && (energy(at) + 2.0 * force.dot(&way)).abs() <= STOPPED * most;
    let arrived = (0..N).all(|i| way[i].abs() <= THERE * (1.0 + q[i].abs()));
    let follows = apart > SAME && if arrived { directions.iter().any(along) } else { !stopped };
    if follows {
        return None;
    }
    let pair = (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j)));
    let minor = |&(i, j): &(usize, usize)| {
        let [a, b] = &directions;
        (a[i] * b[j] - a[j] * b[i]).abs()
    };
    let (i, j) = pair.max_by(|a, b| minor(a).total_cmp(&minor(b)))?;
    let coordinates = [i, j].map(Coordinate::of::<Sys, N>);
    Some(Failure::Bifurcation { t: at.t, coordinates })
}

/// Constraints near such a position, after elimination of as many coordinates as there are constraints but one.
struct Reduced<const N: usize, const M: usize> {
    /// Combination of the gradients that is nearly 0, and its components by the two coordinates that are left.
    nu: SVector<f64, M>,
    slope: [f64; 2],
    /// Displacements by these coordinates that all other constraints admit.
    basis: [SVector<f64, N>; 2],
    /// The displacement that takes the others back.
    back: SVector<f64, N>,
}

/// [`Branches`] in double precision.
fn crossing<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Option<Branches<f64, N>>
where
    Sys::Scalar: Real,
{
    let facts = Sys::FACTS;
    let on_velocities = facts.constraints.iter().any(|c| c.kind != ConstraintKind::Holonomic);
    let number = Sys::Scalar::from_f64;
    let still = constant(Scalar::zero());
    let driven = system.constraint_rates(&at.q, &still, at.t).iter().any(|x| *x != Scalar::zero());
    let large = size_of::<SMatrix<f64, N, N>>() > MAX_MATRIX_BYTES;
    if N != M + 1 || on_velocities || facts.redundancy.is_some() || driven || large {
        return None;
    }
    let jacobian = |q: &SVector<f64, N>| system.constraint_jacobian(&q.map(number), at.t).map(|x| x.to_f64());
    let values = |q: &SVector<f64, N>| system.constraints(&q.map(number), at.t).map(|x| x.to_f64());
    let first = at.q.map(|x| x.to_f64());
    let aside = jacobian(&beside(at, 1.0).q.map(|x| x.to_f64()));
    let here = jacobian(&first);
    let size =
        |j: usize| (0..N).fold(0.0f64, |most, i| most.max(here[(j, i)].abs()).max(aside[(j, i)].abs()));
    let sizes = SVector::<f64, M>::from_fn(|j, _| size(j));
    let unit = |i: usize| 1.0 + first[i].abs();
    let form = |q: &SVector<f64, N>, reduced: &Reduced<N, M>| {
        SMatrix::<f64, 2, 2>::from_fn(|k, l| {
            let b = &reduced.basis[k];
            let h = DIFFERENCE / (0..N).fold(1e-300, |most: f64, i| most.max(b[i].abs() / unit(i)));
            let change = |s: f64| jacobian(&(q + b * s)) - jacobian(&(q - b * s));
            let slope = (change(h) * 8.0 - change(2.0 * h)) / (12.0 * h);
            (reduced.nu.transpose() * slope * reduced.basis[l])[0]
        })
    };
    let distance = |step: &SVector<f64, N>| (0..N).fold(0.0f64, |most, i| most.max(step[i].abs() / unit(i)));
    let mut q = first;
    let mut last = f64::INFINITY;
    for _ in 0..MOST_CORRECTIONS {
        let reduced = reduced(&jacobian(&q), &values(&q), &sizes)?;
        let Reduced { slope, basis, back, .. } = &reduced;
        let form = form(&q, &reduced);
        let step = match form.try_inverse() {
            // The saddle of the combination.
            Some(inverse) if slope.iter().any(|x| *x != 0.0) => {
                let x = inverse * SVector::from([-slope[0], -slope[1]]);
                basis[0] * x[0] + basis[1] * x[1] + back
            }
            _ => *back,
        };
        // (Not a number is far away.)
        let is_near = distance(&(q + step - first)) <= NEAR;
        if !is_near {
            return None;
        }
        let size = distance(&step);
        if size >= last && last < SAME {
            break;
        }
        (q, last) = (q + step, size);
        if size == 0.0 {
            break;
        }
    }
    let reduced = reduced(&jacobian(&q), &values(&q), &sizes)?;
    let vanishes = reduced.slope.iter().all(|x| x.abs() <= 1e-7);
    let left = values(&q);
    let is_there = (0..M).all(|j| left[j].abs() <= ADMITTED * sizes[j]);
    let directions = zeros(&form(&q, &reduced))?;
    let directions = directions.map(|[x, y]| {
        let b = reduced.basis[0] * x + reduced.basis[1] * y;
        let largest = (0..N).max_by(|&i, &j| b[i].abs().total_cmp(&b[j].abs())).map_or(1.0, |i| b[i]);
        b.map(|x| x / largest)
    });
    (last < SAME && vanishes && is_there).then_some(Branches { q, directions })
}

/// Zeros of a quadratic form, if it has some: the same one twice where its discriminant is rounding.
fn zeros(form: &SMatrix<f64, 2, 2>) -> Option<[[f64; 2]; 2]> {
    let [a, b, c] = [form[(0, 0)], 0.5 * (form[(0, 1)] + form[(1, 0)]), form[(1, 1)]];
    let size = a.abs().max(b.abs()).max(c.abs());
    // In units of the constraints.
    if size.is_nan() || size <= 1e-8 {
        return None;
    }
    let discriminant = (b * b - a * c) / (size * size);
    if discriminant < -SAME {
        return None;
    }
    let root = if discriminant > SAME { size * Functions::sqrt(discriminant) } else { 0.0 };
    let w = -(b + root.copysign(b));
    let (first, second) = ([w, a], [c, w]);
    let length = |x: &[f64; 2]| x[0].abs().max(x[1].abs());
    let or = |x: [f64; 2], other: [f64; 2]| if length(&x) > 1e-5 * size { x } else { other };
    Some([or(first, second), or(second, first)])
}

/// Elimination with complete pivots of all rows but the smallest remainder.
fn reduced<const N: usize, const M: usize>(
    jacobian: &SMatrix<f64, M, N>,
    values: &SVector<f64, M>,
    sizes: &SVector<f64, M>,
) -> Option<Reduced<N, M>> {
    let mut a = SMatrix::<f64, M, N>::from_fn(|j, i| jacobian[(j, i)] / sizes[j]);
    let mut f = SVector::<f64, M>::from_fn(|j, _| values[j] / sizes[j]);
    let mut operations = SMatrix::<f64, M, M>::from_fn(|i, j| if i == j { 1.0 / sizes[j] } else { 0.0 });
    let mut column = [None; M];
    for _ in 1..M {
        let free = |i: &usize| !column.contains(&Some(*i));
        let rows = (0..M).filter(|j| column[*j].is_none());
        let pairs = rows.flat_map(|j| (0..N).filter(free).map(move |i| (j, i)));
        let (row, pivot) = pairs.max_by(|x, y| a[*x].abs().total_cmp(&a[*y].abs()))?;
        let value = a[(row, pivot)];
        // (More than one combination vanishes; also not a number.)
        if !(value.abs() > INDEPENDENT && value.is_finite()) {
            return None;
        }
        for j in (0..M).filter(|&j| j != row) {
            let factor = a[(j, pivot)] / value;
            for i in 0..N {
                a[(j, i)] -= factor * a[(row, i)];
            }
            for i in 0..M {
                operations[(j, i)] -= factor * operations[(row, i)];
            }
            f[j] -= factor * f[row];
        }
        column[row] = Some(pivot);
    }
    let rest = column.iter().position(Option::is_none)?;
    let mut free = (0..N).filter(|i| !column.contains(&Some(*i)));
    let free = [free.next()?, free.next()?];
    let mut basis = free.map(|i| SVector::<f64, N>::from_fn(|k, _| f64::from(u8::from(k == i))));
    let mut back = SVector::<f64, N>::zeros();
    for (j, pivot) in column.iter().enumerate() {
        let Some(pivot) = *pivot else { continue };
        for (b, i) in basis.iter_mut().zip(free) {
            b[pivot] = -a[(j, i)] / a[(j, pivot)];
        }
        back[pivot] = -f[j] / a[(j, pivot)];
    }
    let nu = SVector::from_fn(|j, _| operations[(rest, j)]);
    Some(Reduced { nu, slope: free.map(|i| a[(rest, i)]), basis, back })
}
