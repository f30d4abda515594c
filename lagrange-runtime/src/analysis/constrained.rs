//! Equilibria and small motions of systems with constraints, in minimal coordinates of what the constraints admit.
//!
//! With `M q̈ + b − f = Aᵀ λ` small deviations from a motion without accelerations obey
//! `M δq̈ + C δq̇ + (K − Σ λ ∂A/∂q) δq = Aᵀ δλ` and the linearized constraints, whose admissible deviations take δλ
//! away.

use super::balance::{Balance, balance, worst};
use super::hypotheses::{coordinate_names, next};
use super::stability::least_is_negative;
use super::switch::{linearized, smooth};
use super::tangent::{
    ACTS, Held, IDLE_CLASS, Matrices, STEADY, TangentSpace, classes, dynamic, fulfilled, stiffness_of_forces,
    units,
};
use super::{AnalysisError, DVector, SmallMotion, Stability};
use crate::controller::FixedStep;
use crate::diagnosis::away;
use crate::facts::{Constraint, ConstraintKind};
use crate::failure::Coordinate;
use crate::integrate::integrate;
use crate::method::explicit_rk::Rk4;
use crate::scalar::Real;
use crate::state::State;
use crate::system::{Facts, Jacobian, Lagrangian, Linearize};
use core::cell::RefCell;
use nalgebra::{DMatrix, SVD, SVector};

/// Accelerations, relative to what displacements by `1 + |q|` change, up to which a motion counts as steady.
const UNSTEADY: f64 = 1e-6;

/// Accelerations, relative to those of the other coordinates in units in which the diagonal of M is 1, that are
/// roundings.
const ROUNDING: f64 = 1e-12;

/// The hypothesis of an equilibrium.
const RESTING: &str = "constraints that admit rest, and one on velocities moves the system at every state: give a steady \
                       motion to `SmallMotion::steady`, or any one to `SmallMotion::about`";

/// Least singular value of gradients where Newton's method has ended without an equilibrium: a position in which
/// constraints are dependent is approached linearly.
pub(super) const SINGULAR: f64 = 1e-2;

/// Largest violation of a constraint at which Newton's method may end near such a position.
const BESIDE: f64 = 1e-6;

/// Distance of a state that shows how long gradients are elsewhere, relative to `1 + |q|`.
const FAR: f64 = 0.2;

/// Least singular value of gradients at a state with digits for small motions: such a state is beside its branch by
/// roundings of the constraints over this, which are a part of it that is its square.
const VANISHED: f64 = 1e-5;

/// Newton's iterations toward the constraints.
const MOST_CORRECTIONS: usize = 50;

/// Forces of constraints on velocities, relative to those of displacements by `1 + |q|`, that are rounding.
const IDLE: f64 = 1e-10;

/// The constraints at a state that is on them, and at which they are independent.
pub(super) fn held<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Result<Vec<Held>, AnalysisError> {
    let all = Held::all(system, at)?;
    fulfilled(&all, at.q.as_slice(), at.qd.as_slice())?;
    let units = units(&dynamic(&system.inertia(&at.q, &at.qd, at.t)));
    let space = TangentSpace::new(&all, &units, &[ACTS; N])?;
    let far = far(system, at)?;
    // More of them are independent than anywhere else: one has a gradient that is rounding, which is no direction.
    let spare = all.first().map_or(0, |held| held.spare);
    if spare < all.len() && space.rows.len() + spare > all.len() {
        let length = |j: usize| all[j].row.amax() / far[j].row.amax();
        let shortest = (0..all.len()).min_by(|i, j| length(*i).total_cmp(&length(*j))).unwrap_or(0);
        let (constraint, left) = (all[shortest].of.name, length(shortest));
        return Err(AnalysisError::DependentConstraints { constraint, left });
    }
    // A rank that numbers alone tell is that beside the state, on the constraints.
    if Sys::FACTS.redundancy.is_some_and(|redundancy| redundancy.rank.is_none()) {
        let beside = Held::all(system, &admitted(system, &away(at, FAR, 1.0)))?;
        let usual = TangentSpace::new(&beside, &units, &[ACTS; N]).map_or(0, |space| space.rows.len());
        if space.rows.len() < usual {
            let lost = (0..all.len()).find(|j| !space.rows.contains(j)).unwrap_or(0);
            return Err(AnalysisError::DependentConstraints { constraint: all[lost].of.name, left: 0.0 });
        }
    }
    match nearly_dependent(&all, &far, &units, VANISHED) {
        Some(error) => Err(error),
        None => Ok(all),
    }
}

/// The constraints at a state that shows how long gradients are elsewhere.
pub(super) fn far<Sys: Lagrangian<N, Scalar: Real>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Result<Vec<Held>, AnalysisError> {
    Held::all(system, &away(at, FAR, 1.0))
}

/// Small motions about a state without accelerations, but for those of coordinates that do not matter.
pub(super) fn steady<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Result<SmallMotion, AnalysisError> {
    let all = held(system, at)?;
    smooth(system, at, 0.0, linearized)?;
    let accelerations = system.accel(&at.q, &at.qd, at.t);
    let Jacobian { q: by_q, qd: by_qd, .. } = system.jacobian(&at.q, &at.qd, at.t);
    if !accelerations.iter().chain(&by_q).chain(&by_qd).all(|x| x.is_finite()) {
        return Err(AnalysisError::NotFinite);
    }
    let units = units(&dynamic(&system.inertia(&at.q, &at.qd, at.t)));
    let change = |i: usize| {
        let change = |j: usize| by_q[(i, j)].abs() * (1.0 + at.q[j].abs()) + (by_qd[(i, j)] * at.qd[j]).abs();
        (0..N).map(change).sum::<f64>()
    };
    // Forces that cancel leave roundings of the largest ones.
    let rounding = ROUNDING * (0..N).map(|i| change(i) / units[i]).fold(0.0, f64::max);
    let accelerates = |i: usize| accelerations[i].abs() > (UNSTEADY * change(i)).max(rounding * units[i]);
    // The acceleration may vanish for an instant, and change along the motion.
    let rates = |i: usize| (0..N).map(move |j| [by_q[(i, j)] * at.qd[j], by_qd[(i, j)] * accelerations[j]]);
    let size = |i: usize| rates(i).flatten().map(f64::abs).sum::<f64>();
    let largest = (0..N).map(|i| size(i) / units[i]).fold(0.0, f64::max);
    let alters = |i: usize| {
        rates(i).flatten().sum::<f64>().abs() > (UNSTEADY * size(i)).max(ROUNDING * largest * units[i])
    };
    let ahead = ahead(system, at);
    if !(0..N).any(accelerates) {
        let (space, matrices) = direct(system, at)?;
        let stays =
            |ahead: &State<f64, N>| direct(system, ahead).is_ok_and(|(other, _)| space.is_like(&other));
        if ahead.as_ref().is_none_or(stays) {
            space.steady(&matrices, at.qd.as_slice())?;
            return known(system, at, &space, &matrices);
        }
    }
    let first = accelerated(system, at, &all, &|i| accelerates(i) || alters(i))?;
    if let Some(&coordinate) = first.0.velocities.iter().find(|i| accelerates(**i)) {
        let inertia = system.inertia(&at.q, &at.qd, at.t);
        let residual = (inertia * accelerations).amax();
        let coordinate = Coordinate::of::<Sys, N>(coordinate);
        return Err(AnalysisError::NotEquilibrium { residual, coordinate, nearest: None });
    }
    let (space, matrices) = constant(system, [at, &ahead.unwrap_or(*at)], &all, first, &accelerates)?;
    space.steady(&matrices, at.qd.as_slice())?;
    space.small(&matrices, &coordinate_names::<Sys, N>())
}

/// A state of the same motion, after a tenth of the unit of the fastest coordinate; none of a state at rest.
fn ahead<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Option<State<f64, N>> {
    const STEPS: f64 = 32.0;
    let time = 0.1 / at.qd.amax();
    let run =
        || integrate(system, Rk4, FixedStep::new(time / STEPS), *at).until(at.t + time).final_state().ok();
    if time.is_finite() { run() } else { None }
}

/// Coordinates of which some are chosen to follow from others.
const MOST_IDLE: usize = 8;

/// Changes of coefficients along a motion, relative to the largest, that are errors of [`ahead`].
const CHANGED: f64 = 1e-6;

/// [`accelerated`] in coordinates in which the coefficients are the same at both states of a motion: as in `first`, or
/// as many that do not act follow from others as there are constraints on velocities, none of which accelerates.
fn constant<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    [at, ahead]: [&State<f64, N>; 2],
    all: &[Held],
    first: (TangentSpace, Matrices),
    accelerates: &dyn Fn(usize) -> bool,
) -> Result<(TangentSpace, Matrices), AnalysisError> {
    let there = Held::all(system, ahead)?;
    let stays = |(space, matrices): &(TangentSpace, Matrices)| {
        let follows = |i: usize| !space.velocities.contains(&i);
        accelerated(system, ahead, &there, &follows).is_ok_and(|(other, terms)| {
            let same = |(a, b): (&DMatrix<f64>, &DMatrix<f64>)| (a - b).amax() <= CHANGED * a.amax();
            other.positions == space.positions
                && other.velocities == space.velocities
                && matrices.terms.iter().zip(&terms.terms).all(same)
        })
    };
    if stays(&first) {
        return Ok(first);
    }
    let m = dynamic(&system.inertia(&at.q, &at.qd, at.t));
    let by_q = dynamic(&system.jacobian(&at.q, &at.qd, at.t).q);
    let classes = classes(all, &(&m * by_q), &units(&m), &|_| false);
    let count = all.iter().filter(|held| !held.on_positions()).count();
    let idle: Vec<usize> = (0..N).filter(|i| classes[*i] <= IDLE_CLASS).take(MOST_IDLE).collect();
    for choice in (0..1u32 << idle.len()).filter(|choice| choice.count_ones() as usize == count) {
        let follows = |i: usize| idle.iter().position(|k| *k == i).is_some_and(|k| choice >> k & 1 == 1);
        if let Ok(found) = accelerated(system, at, all, &follows)
            && !found.0.velocities.iter().any(|i| accelerates(*i))
            && stays(&found)
        {
            return Ok(found);
        }
    }
    Err(AnalysisError::NotApplicable { needs: STEADY })
}

/// The motion of admissible deviations about a state without accelerations.
fn direct<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Result<(TangentSpace, Matrices), AnalysisError> {
    let all = Held::all(system, at)?;
    let [_, m, c, k] = linearized(system, at);
    let k = k - stiffness_of_forces(&all, N);
    let units = units(&m);
    let space = TangentSpace::new(&all, &units, &classes(&all, &k, &units, &|_| false))?;
    let matrices = space.projected([&m, &c, &k]);
    Ok((space, matrices))
}

/// With what a rounding of the state makes of the matrices.
fn known<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
    space: &TangentSpace,
    matrices: &Matrices,
) -> Result<SmallMotion, AnalysisError> {
    let names = coordinate_names::<Sys, N>();
    let small = space.small(matrices, &names)?;
    let beside = direct(system, &next(at)).ok().filter(|(other, _)| other.velocities == space.velocities);
    let beside = beside.and_then(|(other, matrices)| other.small(&matrices, &names).ok());
    let rests = at.qd.iter().all(|rate| *rate == 0.0);
    Ok(with_rounding(small, beside).conservative(rests && conservative::<Sys, N>()))
}

/// Returns whether h is conserved, and constraints are holonomic: small motions about an equilibrium have a Lagrangian
/// of their own.
pub(super) fn conservative<Sys: Lagrangian<N>, const N: usize>() -> bool {
    let holonomic = |constraint: &Constraint| constraint.kind != ConstraintKind::Nonholonomic;
    Sys::FACTS.conservative && Sys::FACTS.constraints.iter().all(holonomic)
}

/// Small motions with what they are where the state is rounded.
pub(super) fn with_rounding(small: SmallMotion, beside: Option<SmallMotion>) -> SmallMotion {
    match beside.filter(|beside| beside.names() == small.names()) {
        Some(beside) => {
            let SmallMotion { blur, m, c, k, .. } = beside;
            let own = small.blur().clone();
            let mut small = small.blurred([m, c, k]);
            for (sum, (own, other)) in small.blur.iter_mut().zip(own.iter().zip(&blur)) {
                *sum += own.zip_map(other, f64::max);
            }
            small
        }
        None => small,
    }
}

/// The motion of admissible deviations from any motion, as they begin. Where there is a choice, coordinates with
/// unsteady velocities follow from others.
fn accelerated<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
    all: &[Held],
    unsteady: &dyn Fn(usize) -> bool,
) -> Result<(TangentSpace, Matrices), AnalysisError> {
    let Jacobian { q, qd, .. } = system.jacobian(&at.q, &at.qd, at.t);
    let [m, by_q, by_qd] = [system.inertia(&at.q, &at.qd, at.t), q, qd].map(|a| dynamic(&a));
    let units = units(&m);
    let space = TangentSpace::new(all, &units, &classes(all, &(&m * &by_q), &units, unsteady))?;
    let matrices = space.accelerated(&m, [&by_q, &by_qd]);
    Ok((space, matrices))
}

/// Small deviations from the motion through any state, as they begin.
pub(super) fn about<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: &State<f64, N>,
) -> Result<SmallMotion, AnalysisError> {
    let (space, matrices) = accelerated(system, at, &held(system, at)?, &|_| false)?;
    space.small(&matrices, &coordinate_names::<Sys, N>())
}

/// Forces `b − f` at a place, their derivatives, and the constraints there.
pub(super) struct Place {
    pub forces: DVector<f64>,
    pub stiffness: DMatrix<f64>,
    pub held: Vec<Held>,
}

/// A place at which constraint forces balance the others.
pub(super) struct Balanced {
    pub q: DVector<f64>,
    pub multipliers: DVector<f64>,
    /// Last correction of Newton's method, and the stiffness aside, see [`Balance`].
    pub last: f64,
    pub stiffness_aside: DMatrix<f64>,
}

/// The place near a guess at which `b − f = Aᵀ λ` and the constraints hold, by Newton's method in q and λ.
/// Multipliers are in units in which their forces are of the size of others. Of constraints of which some follow from
/// others, those count from which the others follow at the guess, which is [`admitted`] therefore: beside them all
/// may be independent.
pub(super) fn balanced(
    what: &'static str,
    guess: DVector<f64>,
    weights: &[f64],
    whole: &dyn Fn(&DVector<f64>) -> Result<Place, AnalysisError>,
    attitudes: &[usize],
) -> Result<Balanced, AnalysisError> {
    let n = guess.len();
    let at_guess = whole(&guess)?.held;
    let (given, rows) = (at_guess.len(), TangentSpace::new(&at_guess, weights, &vec![ACTS; n])?.rows);
    let place = |q: &DVector<f64>| -> Result<Place, AnalysisError> {
        let Place { forces, stiffness, held } = whole(q)?;
        let chosen = held.into_iter().enumerate().filter(|(j, _)| rows.contains(j));
        Ok(Place { forces, stiffness, held: chosen.map(|(_, held)| held).collect() })
    };
    let start = place(&guess)?;
    let (all, count) = (&start.held, start.held.len());
    for held in all.iter().filter(|held| !held.on_positions()) {
        if held.rate != 0.0 && held.rate_by_coordinates.amax() == 0.0 {
            return Err(AnalysisError::NotApplicable { needs: RESTING });
        }
    }
    let row = all.iter().map(|held| held.row.amax()).fold(0.0, f64::max);
    let size = start.stiffness.amax().max(start.forces.amax()) / row;
    let unit = if size > 0.0 && size.is_finite() { size.log2().round().exp2() } else { 1.0 };
    let at = |x: &DVector<f64>| -> Result<Place, AnalysisError> {
        let mut found = place(&x.rows(0, n).into_owned())?;
        found.held.iter_mut().enumerate().for_each(|(j, held)| held.multiplier = x[n + j] * unit);
        Ok(found)
    };
    let forces = |x: &DVector<f64>| {
        let Place { forces, held, .. } = at(x)?;
        let mut all = forces.resize_vertically(n + count, 0.0);
        for (j, held) in held.iter().enumerate() {
            all.rows_mut(0, n).axpy(-held.multiplier, &held.row, 1.0);
            all[n + j] = unit * if held.on_positions() { held.value } else { held.rate };
        }
        Ok(all)
    };
    let reached = RefCell::new(guess.clone());
    let stiffness = |x: &DVector<f64>| {
        reached.replace(x.rows(0, n).into_owned());
        let Place { stiffness, held, .. } = at(x)?;
        let mut all = (stiffness - stiffness_of_forces(&held, n)).resize(n + count, n + count, 0.0);
        for (j, held) in held.iter().enumerate() {
            let across = if held.on_positions() { &held.row } else { &held.rate_by_coordinates };
            all.view_mut((0, n + j), (n, 1)).copy_from(&(&held.row * -unit));
            all.view_mut((n + j, 0), (1, n)).copy_from(&(across.transpose() * unit));
        }
        Ok(all)
    };
    let first = |i: usize| match i.checked_sub(n) {
        None => guess[i],
        Some(j) if all[j].multiplier.is_finite() => all[j].multiplier / unit,
        Some(_) => 0.0,
    };
    let found = balance(what, DVector::from_fn(n + count, |i, _| first(i)), &forces, &stiffness, attitudes);
    let Balance { q, last, stiffness_aside } = match found {
        Err(error @ (AnalysisError::NotConverged { .. } | AnalysisError::NotFinite)) => {
            let held = whole(&reached.into_inner())?.held;
            return Err(nearly_dependent(&held, &at_guess, weights, SINGULAR).unwrap_or(error));
        }
        // What is left is a violation of a constraint that no displacement changes, or, if gradients are nearly
        // dependent on the way, little more than rounding.
        Err(AnalysisError::Unbalanced { force, coordinate }) if coordinate.index >= n => {
            let (constraint, violation) = (all[coordinate.index - n].of.name, force / unit);
            if violation > BESIDE {
                return Err(AnalysisError::OffConstraints { constraint, violation });
            }
            let held = whole(&reached.into_inner())?.held;
            let ended = AnalysisError::NotConverged { what, residual: force };
            return Err(nearly_dependent(&held, &at_guess, weights, SINGULAR).unwrap_or(ended));
        }
        other => other?,
    };
    let mut multipliers = DVector::zeros(given);
    rows.iter().enumerate().for_each(|(k, &j)| multipliers[j] = q[n + k] * unit);
    let stiffness_aside = stiffness_aside.view((0, 0), (n, n)).into_owned();
    Ok(Balanced { q: q.rows(0, n).into_owned(), multipliers, last, stiffness_aside })
}

/// The error of a place near a position in which constraints are dependent, by singular values of gradients. These
/// count as long as at another place, in units of the coordinates.
pub(super) fn nearly_dependent(
    held: &[Held],
    elsewhere: &[Held],
    units: &[f64],
    least: f64,
) -> Option<AnalysisError> {
    let size =
        |held: &Held| held.row.iter().zip(units).map(|(a, unit)| (a * unit).powi(2)).sum::<f64>().sqrt();
    let sizes: Vec<f64> =
        held.iter().zip(elsewhere).map(|(here, there)| size(here).max(size(there))).collect();
    let scaled = DMatrix::from_fn(held.len(), units.len(), |j, i| held[j].row[i] * units[i] / sizes[j]);
    let svd = SVD::try_new(scaled, true, false, f64::EPSILON, 10_000)?;
    // Those that vanish in all positions are the last ones.
    let k = held.len().checked_sub(1 + held.first()?.spare)?;
    let left = *svd.singular_values.as_slice().get(k)?;
    let row = svd.u?.column(k).iamax();
    (left < least).then(|| AnalysisError::DependentConstraints { constraint: held[row].of.name, left })
}

/// Small motions with K aside the place that Newton's method found.
pub(super) fn doubted(small: SmallMotion, space: &TangentSpace, aside: &DMatrix<f64>) -> SmallMotion {
    let none = DMatrix::zeros(aside.nrows(), aside.ncols());
    let [_, _, k] = space.projected([&none, &none, aside]).terms;
    small.doubted(&(k * space.v.select_rows(&space.positions)))
}

/// The state on the constraints near `start`, or this itself, where none of them follows from others.
pub(super) fn admitted<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: &State<f64, N>,
) -> State<f64, N> {
    let mut at = *start;
    if Sys::FACTS.redundancy.is_none() {
        return at;
    }
    for _ in 0..MOST_CORRECTIONS {
        let next = State { qd: start.qd, ..system.toward_constraints(&at) };
        if !next.is_finite() {
            return *start;
        }
        let still = (0..N).all(|i| (next.q[i] - at.q[i]).abs() <= 4.0 * f64::EPSILON * (1.0 + at.q[i].abs()));
        at = next;
        if still {
            break;
        }
    }
    at
}

fn at_rest<const N: usize>(q: SVector<f64, N>) -> State<f64, N> {
    State { t: 0.0, q, qd: SVector::zeros() }
}

/// Generalized forces `b − f − Aᵀ λ` that are left at rest at `q`, on which the constraints are, with those
/// multipliers that leave least.
pub(super) fn left<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    q: &SVector<f64, N>,
) -> Result<(usize, f64), AnalysisError> {
    let at = at_rest(*q);
    held(system, &at)?;
    // M q̈ = Aᵀ λ − (b − f)
    Ok(worst(&(system.inertia(q, &at.qd, 0.0) * system.accel(q, &at.qd, 0.0))))
}

/// The largest force that is [`left`] at an equilibrium with these multipliers. More than rounding beside the others is
/// left where constraints count as some that follow from others, by the accelerations, and do not.
pub(super) fn balances<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    q: &SVector<f64, N>,
    multipliers: &DVector<f64>,
) -> Result<f64, AnalysisError> {
    let (index, force) = left(system, q)?;
    let at = at_rest(*q);
    let [forces, _, _, stiffness] = linearized(system, &at);
    let all = Held::all(system, &at)?;
    let of_constraints =
        all.iter().zip(multipliers).map(|(held, multiplier)| held.row.amax() * multiplier.abs());
    let of_changes =
        stiffness.row_iter().map(|row| row.iter().zip(q).map(|(k, x)| k.abs() * (1.0 + x.abs())).sum());
    let size = of_constraints.chain(of_changes).fold(forces.amax(), f64::max);
    if force <= LEFT * size {
        return Ok(force);
    }
    let units = units(&dynamic(&system.inertia(q, &at.qd, 0.0)));
    let unbalanced = AnalysisError::Unbalanced { force, coordinate: Coordinate::of::<Sys, N>(index) };
    Err(nearly_dependent(&all, &far(system, &at)?, &units, SINGULAR).unwrap_or(unbalanced))
}

/// Force that is left at an equilibrium, beside the others there.
const LEFT: f64 = 1e-6;

/// The equilibrium near `guess`: its coordinates, multipliers and small motions.
pub(super) fn equilibrium<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    guess: &[f64; N],
) -> Result<(SVector<f64, N>, DVector<f64>, SmallMotion), AnalysisError> {
    let start = at_rest(SVector::from(*guess));
    let place = |q: &DVector<f64>| {
        let at = at_rest(SVector::from_fn(|i, _| q[i]));
        let [forces, _, _, stiffness] = linearized(system, &at);
        Ok(Place { forces: forces.column(0).into_owned(), stiffness, held: Held::all(system, &at)? })
    };
    let weights = units(&dynamic(&system.inertia(&start.q, &start.qd, 0.0)));
    let guess = DVector::from_column_slice(admitted(system, &start).q.as_slice());
    let found = balanced("an equilibrium", guess, &weights, &place, Sys::ATTITUDES).or_else(|error| {
        smooth(system, &start, 0.0, linearized)?;
        Err(error)
    })?;
    let at = at_rest(SVector::from_fn(|i, _| found.q[i]));
    let all = held(system, &at)?;
    smooth(system, &at, found.last, linearized)?;
    let (space, matrices) = direct(system, &at)?;
    let small = known(system, &at, &space, &matrices)?;
    // Of constraints that follow from others they are those of least norm.
    let multipliers = all.iter().map(|held| held.multiplier).collect::<Vec<_>>().into();
    Ok((at.q, multipliers, doubted(small, &space, &found.stiffness_aside)))
}

/// Stability of an equilibrium with constraints, see [`Equilibrium`](super::Equilibrium).
pub(super) fn stability<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    q: &SVector<f64, N>,
    small: &SmallMotion,
) -> Result<Stability, AnalysisError> {
    let at = at_rest(*q);
    let [_, m, c, k] = linearized(system, &at);
    // Damping of all motions, admissible here or not: it is that of admissible ones elsewhere.
    let linear_damping = Sys::FACTS.linear_damping && !least_is_negative(&c)?;
    let facts = Facts { linear_damping, linear: false, ..Sys::FACTS };
    let nonholonomic = |kind| kind == ConstraintKind::Nonholonomic;
    if !Sys::FACTS.constraints.iter().any(|constraint| nonholonomic(constraint.kind)) {
        return small.stability(&facts);
    }
    // The energy is least among all positions, and not only among those that are reached by admissible displacements.
    let all = Held::all(system, &at)?;
    let idle = all.iter().filter(|held| nonholonomic(held.of.kind)).all(|held| {
        let force = (&held.row * held.multiplier).abs();
        (0..N).all(|i| {
            let change: f64 = (0..N).map(|j| k[(i, j)].abs() * (1.0 + q[j].abs())).sum();
            force[i] <= IDLE * change
        })
    });
    if idle && (facts.conservative || facts.linear_damping) {
        let others: Vec<Held> = all.into_iter().filter(|held| !nonholonomic(held.of.kind)).collect();
        let k = k - stiffness_of_forces(&others, N);
        let space = TangentSpace::new(&others, &units(&m), &[ACTS; N])?;
        let free = space.small(&space.projected([&m, &c, &k]), &coordinate_names::<Sys, N>())?;
        if let Ok(verdict @ Stability::Stable) = free.energy_criterion() {
            return Ok(verdict);
        }
    }
    small.stability(&Facts { conservative: false, linear_damping: false, ..facts })
}
