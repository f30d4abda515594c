//! Constraints that are dependent at a state: how far they are from it, and which of them follow from others.

use super::branches::undetermined;
use super::{Constrained, responses};
use crate::diagnosis::{BRINK, MAX_MATRIX_BYTES, away, beside};
use crate::failure::{Cause, Coordinate, Dependence, Failure};
use crate::linear::{dot, ldlt};
use crate::scalar::{Functions, Real, Scalar};
use crate::state::{State, constant};
use nalgebra::{SMatrix, SVector};

/// Square of the sine of the smallest angle between the gradient of a constraint and the span of the others, in the
/// metric of the inertia matrix, at `at`, relative to that at `start`: bodies whose masses differ much make all angles
/// small, and no constraint dependent. Gradients that were longer at `start` count as that long. Of constraints
/// that follow from others everywhere, as many are left out. (1 where matrices are too large to look at.) Emitted as
/// [`System::independence`](crate::System::independence).
#[cold]
#[inline(never)]
pub fn independence<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
) -> f64
where
    Sys::Scalar: Real,
{
    if size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return 1.0;
    }
    let (Some(before), Some(here)) = (products(system, start), products(system, at)) else { return 1.0 };
    let rank = usual_rank::<Sys, N, M>(Some(&before), squares(&before)).unwrap_or(M).min(N);
    (Elimination::new(&here, longest(&before, &here)).least_pivot(rank) / usual_sine(&before, rank)).min(1.0)
}

/// Square of the sine of the smallest angle between the gradient of a constraint and the span of the others, in the
/// metric of the inertia matrix, whether by the place or by masses that differ much: 1 where it is not known. Gradients
/// count as long as this part of what they are at a state far away, if they are shorter. Of constraints that follow
/// from others everywhere, as many are left out.
pub(super) fn least_sine<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    part: f64,
) -> f64
where
    Sys::Scalar: Real,
{
    if size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return 1.0;
    }
    let Some(here) = products(system, at) else { return 1.0 };
    let far = products(system, &far(at)).unwrap_or(here);
    let squares = longest(&(far * (part * part)), &here);
    let rank = usual_rank::<Sys, N, M>(Some(&far), squares).unwrap_or(M).min(N);
    Elimination::new(&here, squares).least_pivot(rank)
}

/// A state far away, off the constraints, at which gradients that vanish at this one are long: a coordinate that is 0
/// is moved beside the largest one, whatever the unit of length.
fn far<S: Real, const N: usize>(at: &State<S, N>) -> State<S, N> {
    away(at, FAR, at.q.iter().fold(1.0, |most, x| x.to_f64().abs().max(most)))
}

/// Its distance, relative to these coordinates.
const FAR: f64 = 0.2;

/// Returns whether the gradients of the constraints that are dependent at a state, up to the part `brink`, are those of
/// any other state, and apart by more than rounding: such constraints have no branches.
pub(super) fn is_linear<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    brink: f64,
) -> bool
where
    Sys::Scalar: Real,
{
    let Some(products) = products(system, at) else { return false };
    let mut elimination = Elimination::new(&products, squares(&products));
    let Some((_, pivot, _)) = elimination.up_to(brink).filter(|(_, pivot, _)| *pivot > ACCURATE) else {
        return false;
    };
    let least = least_part(pivot);
    let there = State { t: at.t + Scalar::one(), ..far(at) };
    let [here, there] = [at, &there].map(|at| system.constraint_jacobian(&at.q, at.t));
    (0..M).all(|j| !elimination.takes_part(j, least) || here.row(j) == there.row(j))
}

/// Square of a sine between gradients with which accelerations keep half of their digits.
const ACCURATE: f64 = 1e-8;

/// Constraints that do not follow from others at a state.
pub(super) fn chosen<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> [bool; M]
where
    Sys::Scalar: Real,
{
    if Sys::FACTS.redundancy.is_none() {
        return [true; M];
    }
    let Some(products) = products(system, at) else { return [true; M] };
    let squares = squares(&products);
    let rank = usual_rank::<Sys, N, M>(Some(&products), squares).unwrap_or(M);
    let mut elimination = Elimination::new(&products, squares);
    elimination.least_pivot(rank);
    elimination.chosen
}

/// Square of the sine between gradients at a state at which they are independent: where it is less than 1/20, it is so
/// by masses, and not by the place.
fn usual_sine<const M: usize>(products: &SMatrix<f64, M, M>, rank: usize) -> f64 {
    (20.0 * Elimination::new(products, squares(products)).least_pivot(rank)).min(1.0)
}

/// Squares of the lengths of gradients.
fn squares<const M: usize>(products: &SMatrix<f64, M, M>) -> [f64; M] {
    core::array::from_fn(|j| products[(j, j)])
}

/// Squares of the lengths that gradients have at one of two states.
fn longest<const M: usize>(one: &SMatrix<f64, M, M>, other: &SMatrix<f64, M, M>) -> [f64; M] {
    core::array::from_fn(|j| one[(j, j)].max(other[(j, j)]))
}

/// The part of a velocity that coordinates of constraints have that are dependent at `at` up to the part `brink`, with
/// the smallest one of others, measured by the inertia matrix, that other constraints need. These may be so fast that
/// nothing is smooth over the distance in which constraints become independent.
pub(super) fn nearly_dependent_part<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    reference: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    velocity: &SVector<Sys::Scalar, N>,
    brink: f64,
) -> SVector<Sys::Scalar, N>
where
    Sys::Scalar: Real,
{
    let part = || {
        let elsewhere = products(system, reference)?;
        let rank = usual_rank::<Sys, N, M>(Some(&elsewhere), squares(&elsewhere))?.min(N);
        let involved = involved(&elsewhere, &products(system, at)?, brink, rank)?;
        // (A gradient may have no part along a wire wherever it is met.)
        let aside = far(at);
        let rows =
            [reference, at, &aside].map(|at| system.constraint_jacobian(&at.q, at.t).map(|x| x.to_f64()));
        let moved: [bool; N] = core::array::from_fn(|i| {
            rows.iter().any(|rows| (0..M).any(|j| involved[j] && rows[(j, i)] != 0.0))
        });
        let zero = Sys::Scalar::zero();
        let part = SVector::<_, N>::from_fn(|i, _| if moved[i] { velocity[i] } else { zero });
        let inertia = system.inertia(&at.q, &at.qd, at.t).map(|x| x.to_f64());
        let others = following(&inertia, &rows[1], &part.map(|x| x.to_f64()), &moved, &involved)?;
        Some(part + others.map(Sys::Scalar::from_f64))
    };
    part().unwrap_or(*velocity)
}

/// The smallest velocity x, measured by the inertia matrix, of coordinates that are not `moved`, with `A (v + x) = 0`
/// for the rows A that are not `involved`.
fn following<const N: usize, const M: usize>(
    inertia: &SMatrix<f64, N, N>,
    rows: &SMatrix<f64, M, N>,
    v: &SVector<f64, N>,
    moved: &[bool; N],
    involved: &[bool; M],
) -> Option<SVector<f64, N>> {
    let row = |j: usize| SVector::<_, N>::from_fn(|i, _| if moved[i] { 0.0 } else { rows[(j, i)] });
    let others: [bool; M] = core::array::from_fn(|j| !involved[j] && row(j).amax() > 0.0);
    let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    let is_other = |i: usize, j: usize| !moved[i] && !moved[j];
    let inertia = SMatrix::from_fn(|i, j| if is_other(i, j) { inertia[(i, j)] } else { unit(i, j) });
    let inertia = ldlt(&inertia).ok()?;
    let responses: [SVector<f64, N>; M] = core::array::from_fn(|j| inertia.solve(&row(j)));
    let product =
        |i: usize, j: usize| if others[i] && others[j] { dot(&row(i), &responses[j]) } else { unit(i, j) };
    let rate = |j: usize| (0..N).map(|i| rows[(j, i)] * v[i]).sum::<f64>();
    let rates = SVector::<f64, M>::from_fn(|j, _| if others[j] { -rate(j) } else { 0.0 });
    let impulses = ldlt(&SMatrix::from_fn(product)).ok()?.solve(&rates);
    Some((0..M).fold(SVector::zeros(), |sum, j| sum + responses[j] * impulses[j]))
}

/// Constraints that take part in the nearest dependence, by the products of gradients elsewhere and here: those whose
/// square of the sine is no more than `brink`, and those that they depend on.
fn involved<const M: usize>(
    elsewhere: &SMatrix<f64, M, M>,
    here: &SMatrix<f64, M, M>,
    brink: f64,
    rank: usize,
) -> Option<[bool; M]> {
    let mut elimination = Elimination::new(here, longest(elsewhere, here));
    let (_, pivot, _) = elimination.up_to(brink * usual_sine(elsewhere, rank))?;
    let least = least_part(pivot);
    Some(core::array::from_fn(|j| elimination.takes_part(j, least)))
}

/// The constraints of `system` that depend on each other at `at` up to the part `brink`, if any do.
///
/// The gradients `aᵢ` are compared in the metric of the inertia matrix, in which units do not matter: the pivots of
/// the matrix of `aᵢ M⁻¹ aⱼ`, scaled to a unit diagonal, are squares of sines of angles between a gradient and the
/// span of others (pivoted Cholesky factorization; Higham, *Accuracy and Stability of Numerical Algorithms*, 2002,
/// 10.3). A gradient vanishes if its square has fallen to that part of what it is at `start`, or `elsewhere`.
#[cold]
#[inline(never)]
fn dependence<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    elsewhere: &State<Sys::Scalar, N>,
    brink: f64,
) -> Option<Dependence>
where
    Sys::Scalar: Real,
{
    let name = |j: usize| Sys::FACTS.constraints.get(j).map_or("", |constraint| constraint.name);
    if size_of::<SMatrix<Sys::Scalar, N, N>>() > MAX_MATRIX_BYTES {
        return None;
    }
    let here = products(system, at)?;
    let elsewhere = [products(system, start), products(system, elsewhere)];
    let before: [f64; M] =
        core::array::from_fn(|j| elsewhere.iter().flatten().fold(0.0, |most: f64, c| most.max(c[(j, j)])));
    if Sys::FACTS.redundancy.is_none() {
        // (Bodies of very different masses have small angles everywhere.)
        let brink = brink * elsewhere.iter().flatten().map(|c| usual_sine(c, M)).fold(0.0, f64::max);
        let vanished = (0..M).find(|&j| here[(j, j)] <= brink * before[j]);
        if let Some(j) = vanished {
            let left = here[(j, j)] / before[j];
            return Some(Dependence {
                constraint: name(j),
                on: None,
                others: 0,
                left,
                rank: M as u16 - 1,
                of: M as u16,
            });
        }
        let squares = core::array::from_fn(|j| here[(j, j)]);
        return Elimination::new(&here, squares).dependent(brink).map(|found| found.named(name, M));
    }
    // Constraints that follow from others are dependent everywhere: more of them than at other states are not.
    let usual = usual_rank::<Sys, N, M>(elsewhere[0].as_ref(), before)?;
    Elimination::new(&here, before)
        .dependent(brink)
        .filter(|found| found.rank < usual)
        .map(|found| found.named(name, M))
}

/// `aᵢ M⁻¹ aⱼ` of the gradients, if the inertia matrix is regular, and positive along their forces: it is no metric
/// otherwise.
fn products<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Option<SMatrix<f64, M, M>>
where
    Sys::Scalar: Real,
{
    let inertia = system.inertia(&at.q, &at.qd, at.t).map(|x| x.to_f64());
    let gradients = system.constraint_jacobian(&at.q, at.t).map(|x| x.to_f64());
    let products = responses(&inertia, &gradients)?.1;
    let metric = (0..M).all(|j| products[(j, j)] >= -BRINK * products.amax());
    (metric && products.iter().all(|x| x.is_finite())).then_some(products)
}

/// Number of constraints that do not follow from others: what the compiler knows, or more by their products at the
/// start of a run, scaled by these squares, as other assemblies of a mechanism may have.
fn usual_rank<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    start: Option<&SMatrix<f64, M, M>>,
    squares: [f64; M],
) -> Option<usize>
where
    Sys::Scalar: Real,
{
    let Some(redundancy) = Sys::FACTS.redundancy else { return Some(M) };
    let by_numbers =
        || Some(Elimination::new(start?, squares).dependent(BRINK).map_or(M, |found| found.rank));
    redundancy.rank.max(by_numbers())
}

/// A row that depends on those that were chosen before it.
struct Dependent {
    row: usize,
    /// The one that it depends on most, and the number of others.
    on: Option<usize>,
    others: usize,
    /// The part of it that does not depend on them.
    left: f64,
    rank: usize,
}

impl Dependent {
    fn named(self, name: impl Fn(usize) -> &'static str, of: usize) -> Dependence {
        let Dependent { row, on, others, left, rank } = self;
        let [others, rank, of] = [others, rank, of].map(|count| count as u16);
        Dependence { constraint: name(row), on: on.map(name), others, left, rank, of }
    }
}

/// Smallest coefficient, of gradients scaled to the length 1, of a row that another one depends on; so many times the
/// sine are none of its dependence.
const LEAST_PART: f64 = 1e-3;
const MARGIN: f64 = 5.0;

fn least_part(pivot: f64) -> f64 {
    LEAST_PART + MARGIN * Functions::sqrt(pivot.max(0.0))
}

/// Elimination of a matrix of products, scaled by squares of lengths, in the order of its largest pivots. These are
/// squares of sines of the angles between a gradient and the span of those before it.
struct Elimination<const M: usize> {
    rest: SMatrix<f64, M, M>,
    /// Each gradient that was not chosen as a combination of those that were, up to its remainder.
    combination: SMatrix<f64, M, M>,
    chosen: [bool; M],
}

impl<const M: usize> Elimination<M> {
    fn new(products: &SMatrix<f64, M, M>, squares: [f64; M]) -> Self {
        let scale = squares.map(|square| 1.0 / Functions::sqrt(square));
        let rest = SMatrix::from_fn(|i, j| products[(i, j)] * (scale[i] * scale[j]));
        Elimination { rest, combination: SMatrix::zeros(), chosen: [false; M] }
    }

    /// The row that depends least on those that were chosen, and its pivot.
    fn pivot(&self) -> Option<(usize, f64)> {
        let pivots = (0..M).filter(|&j| !self.chosen[j]).map(|j| (j, self.rest[(j, j)]));
        pivots.max_by(|(_, one), (_, other)| one.total_cmp(other))
    }

    fn eliminate(&mut self, row: usize) {
        self.chosen[row] = true;
        for i in (0..M).filter(|&i| !self.chosen[i]) {
            let factor = self.rest[(i, row)] / self.rest[(row, row)];
            for j in 0..M {
                self.rest[(i, j)] -= factor * self.rest[(row, j)];
                self.combination[(i, j)] -= factor * self.combination[(row, j)];
            }
            self.combination[(i, row)] = factor;
        }
    }

    /// A row takes part that was not chosen, or that one of those depends on by at least so much.
    fn takes_part(&self, row: usize, least: f64) -> bool {
        let rest = || (0..M).filter(|&i| !self.chosen[i]);
        !self.chosen[row] || rest().any(|i| self.combination[(i, row)].abs() > least)
    }

    /// Eliminates rows up to the first one whose pivot is no more than `brink`: it, its pivot and the number before it.
    fn up_to(&mut self, brink: f64) -> Option<(usize, f64, usize)> {
        for rank in 0..M {
            let (row, pivot) = self.pivot()?;
            if pivot <= brink {
                return Some((row, pivot, rank));
            }
            self.eliminate(row);
        }
        None
    }

    /// Eliminates the first `rank` rows, up to one that depends on those before it: the least of their pivots, or 0.
    fn least_pivot(&mut self, rank: usize) -> f64 {
        let mut least: f64 = 1.0;
        for _ in 0..rank {
            let Some((row, pivot)) = self.pivot() else { break };
            least = least.min(pivot.max(0.0));
            if pivot <= 0.0 {
                break;
            }
            self.eliminate(row);
        }
        least
    }

    /// The first row whose pivot is no more than `brink`.
    fn dependent(mut self, brink: f64) -> Option<Dependent> {
        let (row, pivot, rank) = self.up_to(brink)?;
        let part = |j: usize| self.combination[(row, j)].abs();
        let chosen = || (0..M).filter(|&j| self.chosen[j]);
        let on = chosen().max_by(|&i, &j| part(i).total_cmp(&part(j)));
        let others = on.map_or(0, |on| chosen().filter(|&j| j != on && part(j) > 1e-3 * part(on)).count());
        Some(Dependent { row, on, others, left: pivot.max(0.0), rank })
    }
}

/// [`resolved`](crate::diagnosis::resolved) for a system with constraints. Near a state at which the constraints are
/// dependent, rounding loses the digits that tell one branch of the motion from another.
#[doc(hidden)]
pub fn resolved<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    is_definite: bool,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    crate::diagnosis::resolved(system, start, at, is_definite)?;
    if start == at
        && let Some(k) = weightless(system, at)
    {
        let coordinate = Coordinate::of::<Sys, N>(k);
        return Err(Failure::SingularInertia { t: at.t, coordinate, with: None });
    }
    match dependence(system, start, at, &beside(at, 0.0), BRINK) {
        Some(dependence) => Err(singular(system, start, at, dependence)),
        None => Ok(()),
    }
}

/// The coordinate whose inertia is lost to rounding beside that of others, if there is one: the response to given rates
/// of the constraints, which is found as accelerations are, has other rates. Inertia is compared with the gradients of
/// constraints, whatever the units.
fn weightless<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Option<usize>
where
    Sys::Scalar: Real,
{
    let State { t, q, qd } = at;
    let inertia = system.inertia(q, qd, *t);
    let gradients = system.constraint_jacobian(q, *t);
    let square = |x: f64| x * x;
    let steepness = |i: usize| (0..M).map(|j| square(gradients[(j, i)].to_f64())).sum::<f64>();
    // Velocities of all coordinates that the constraints hold, of one size by their rates.
    let velocities = SVector::<_, N>::from_fn(|i, _| match steepness(i) {
        0.0 => Scalar::zero(),
        steep => Scalar::from_f64((1.0 + 0.618 * (i % 7) as f64) / libm::sqrt(steep)),
    });
    let rates_of = |v: &SVector<Sys::Scalar, N>| {
        SVector::<_, M>::from_fn(|j, _| (0..N).fold(Scalar::zero(), |sum, i| sum + gradients[(j, i)] * v[i]))
    };
    let rates = rates_of(&velocities);
    let found = system.response(q, qd, *t, &constant(Scalar::zero()), &rates).0;
    let off = rates_of(&found) - rates;
    let is_off = |j: usize| {
        let terms = |i: usize| (gradients[(j, i)] * velocities[i]).to_f64().abs();
        off[j].to_f64().abs() > WEIGHTLESS * (0..N).map(terms).fold(0.0, f64::max)
    };
    let lightness = |i: usize| steepness(i) / inertia[(i, i)].to_f64().abs();
    let lightest = || (0..N).max_by(|&i, &k| lightness(i).total_cmp(&lightness(k)));
    (0..M).any(is_off).then(lightest).flatten()
}

/// Relative error of the rates of constraints at which accelerations mean nothing.
const WEIGHTLESS: f64 = 1e-6;

/// The brink of a dependence in a run whose steps drift from the constraints however short they are, or that did not
/// get across: rounding does that alone, in units of the last place over the angle between gradients.
const BRINK_OF_DRIFT: f64 = 0.25;

/// [`explained`](crate::diagnosis::explained) for a system with constraints: [`Failure::DependentConstraints`] if a
/// run that made ever shorter steps, or could not start, has met a state at which they are dependent.
#[doc(hidden)]
pub fn explained<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    last: &State<Sys::Scalar, N>,
    failure: Failure<Sys::Scalar>,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    let failure = crate::diagnosis::explained(system, start, last, failure);
    let brink = match failure {
        Failure::ConstraintDrift { .. }
        | Failure::StepSizeUnderflow { cause: Some(Cause::ConstraintDrift(_)), .. } => BRINK_OF_DRIFT,
        Failure::NonFinite { .. }
        | Failure::StepSizeUnderflow { .. }
        | Failure::NotConverged { .. }
        | Failure::SingularStep { .. } => BRINK,
        _ => return failure,
    };
    match dependence(system, start, last, &beside(last, 1.0), brink) {
        Some(dependence) => singular(system, start, last, dependence),
        None => failure,
    }
}

/// The failure of a run that has met a state at which constraints are dependent.
fn singular<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    dependence: Dependence,
) -> Failure<Sys::Scalar>
where
    Sys::Scalar: Real,
{
    let dependent = Failure::DependentConstraints { t: at.t, dependence };
    undetermined::<Sys, N, M>(system, start, at, true).unwrap_or(dependent)
}
