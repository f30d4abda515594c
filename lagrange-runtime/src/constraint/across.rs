//! Accelerations near states at which constraints are dependent, and the motion is smooth.
//!
//! At a distance δ from such a state, in radians between a gradient and the span of the others, a state that is e
//! beside the constraints has accelerations that are e/δ off, and rounding alone makes them ε/δ³ off. Stages of steps
//! are beside the constraints by much more than the error of a step, which then has no order. So stages are projected
//! first, and the nearest accelerations are interpolated.

use super::dependence::{is_linear, least_sine, nearly_dependent_part};
use super::{Constrained, independence, restore, transposed};
use crate::linear::{dot, factored, product};
use crate::scalar::{Comparison, Functions, Real, RealCase, Scalar};
use crate::state::{Begun, State, constant};
use nalgebra::{SMatrix, SVector};

/// Square of the sine below which accelerations are interpolated: at 0.02 rad they have lost half of their digits,
/// and the nodes on both sides are so near that polynomials of degree 11 have more.
pub const CLOSE: f64 = 5e-4;

/// Square of the sine below which steps are made across, and a state aside shows how long gradients are.
pub const NEARLY_DEPENDENT: f64 = 0.05;

/// Weights at 0 of the polynomial through ±1, …, ±6, for either side, and of that through ±1, …, ±5.
const WEIGHTS: [[f64; 6]; 2] = [
    [6.0 / 7.0, -15.0 / 28.0, 5.0 / 21.0, -1.0 / 14.0, 1.0 / 77.0, -1.0 / 924.0],
    [5.0 / 6.0, -10.0 / 21.0, 5.0 / 28.0, -5.0 / 126.0, 1.0 / 252.0, 0.0],
];

/// Largest difference of the two polynomials, relative to their values. Where the motion leaves the position slowly,
/// and other coordinates are fast, nodes are too far apart.
const SMOOTH: f64 = 1e-6;

/// Spacings of nodes, in units of the length of the motion, that lose no digits to speak of: of motions by angles, and
/// by places, whose series along a tangent converge up to a radian; and the difference of the polynomials up to which
/// they are taken.
const WIDE: [f64; 2] = [0.08, 0.04];
const SMOOTHER: f64 = 1e-9;

/// Square of the sine below which a state is nearer to the position than such nodes, and that of a state that is in it
/// but for rounding.
const BETWEEN: f64 = 1e-2;
const AT_POSITION: f64 = 1e-28;

/// Change of a velocity, relative to the fastest one, that is rounding.
const ROUNDED: f64 = 1e-11;

/// Accelerations on the motion that goes through states at which constraints are dependent, of a state near it: those
/// of the nearest admissible state, or, where gradients are nearly dependent, the polynomial of degree 11 through
/// those of states `(q + s b, q̇)` on both sides, at s = 0, where b is the part of q̇ that coordinates of constraints
/// have that are nearly dependent. All of these are under the force of the state itself, which may depend on its place
/// in whatever way: by jumps, or by a spring that is met between two nodes. Nodes are at least |h|/32 apart, where h is
/// the size of a step (where there is none yet, in units of the fastest coordinate), and far enough for the nearest
/// ones to be resolved. Not a number where there is no admissible state, or the polynomial of degree 9 through the
/// nearest nodes has other values. Emitted as [`System::accel_across`](crate::System::accel_across).
#[cold]
#[inline(never)]
pub fn accel_across<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    reference: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
    roughly: bool,
) -> SVector<Sys::Scalar, N>
where
    Sys::Scalar: Real,
{
    // (Not of the projected state, which may be anywhere where constraints are dependent.)
    let found = if independence::<Sys, N, M>(system, reference, at) >= CLOSE {
        projected(system, at, &at.qd, 0.0, 0.0).map(|at| system.accel(&at.q, &at.qd, at.t))
    } else {
        let force = system.momentum_rate(&at.q, &at.qd, at.t);
        let accel = |node: &State<_, N>| accelerated(system, node, &force);
        Nodes::about(system, reference, at, h, |nodes| {
            nodes.middle(accel, if roughly { f64::INFINITY } else { SMOOTH }, ROUNDED * nodes.pace)
        })
    };
    found.unwrap_or_else(|| constant(Sys::Scalar::from_f64(f64::NAN)))
}

/// Accelerations of a node under another force than its own.
fn accelerated<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    node: &State<Sys::Scalar, N>,
    force: &SVector<Sys::Scalar, N>,
) -> SVector<Sys::Scalar, N> {
    let State { t, q, qd } = node;
    system.accel(q, qd, *t) + response(system, node, &(*force - system.momentum_rate(q, qd, *t))).0
}

/// Accelerations and multipliers that a force adds to those of a state: both are linear in it.
fn response<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    force: &SVector<Sys::Scalar, N>,
) -> (SVector<Sys::Scalar, N>, SVector<Sys::Scalar, M>) {
    system.response(&at.q, &at.qd, at.t, force, &constant(Scalar::zero()))
}

/// 1 where the change of velocities by a force (`changed` has both) is on the constraints, to the part [`KEPT`] of
/// the change without them; else not a number. Where numbers alone tell the rank, a constraint may count as one that
/// follows from others, and does not.
fn kept<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    changed: impl FnOnce() -> [SVector<Sys::Scalar, N>; 2],
) -> Sys::Scalar {
    let one = Scalar::one();
    if Sys::FACTS.redundancy.is_none_or(|redundancy| redundancy.rank.is_some()) {
        return one;
    }
    let [force, change] = changed();
    let inertia = factored(&system.inertia(&at.q, &at.qd, at.t));
    let gradients = system.constraint_jacobian(&at.q, at.t);
    let size = |x: &SVector<Sys::Scalar, N>| {
        let half = inertia.half(x);
        dot(&half, &half)
    };
    let free = size(&force) * Scalar::from_f64(KEPT * KEPT);
    (0..M).fold(one, |kept, j| {
        let gradient = SVector::from_fn(|i, _| gradients[(j, i)]);
        let (rate, most) = (dot(&gradient, &change), free * size(&gradient));
        Scalar::select(Comparison::LessEqual, rate * rate, most, kept, Scalar::from_f64(f64::NAN))
    })
}

/// A state may be beside the constraints by so much of its coordinates.
const KEPT: f64 = 1e-6;

/// 1 if constraints move in time at a state, so that states beside it are those of other times; else 0.
fn clock<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> f64
where
    Sys::Scalar: Real,
{
    let still = system.constraint_rates(&at.q, &constant(Scalar::zero()), at.t);
    if largest(&still) > 0.0 { 1.0 } else { 0.0 }
}

/// The state `(q + s b, q̇, t + s clock)` of a state, projected onto the constraints.
fn projected<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    along: &SVector<Sys::Scalar, N>,
    s: f64,
    clock: f64,
) -> Option<State<Sys::Scalar, N>>
where
    Sys::Scalar: Real,
{
    let q = SVector::from_fn(|i, _| at.q[i] + along[i] * Sys::Scalar::from_f64(s));
    let t = at.t + Sys::Scalar::from_f64(s * clock);
    let restored = restore(system, &State { q, t, ..*at }).ok()?;
    Some(polished::<Sys, N, M>(system, &restored.state))
}

/// Admissible states on both sides of a state, at 1, …, 6 times a spacing.
struct Nodes<S, const N: usize> {
    pairs: [[State<S, N>; 2]; WEIGHTS[0].len()],
    /// An acceleration that changes the fastest velocity by itself while the motion passes them.
    pace: f64,
}

impl<S: Real, const N: usize> Nodes<S, N> {
    /// The value `of` those along the velocity, as far apart as a step suggests or, where it is not smooth there, as
    /// near as they are resolved, or of those along the way that the forces take a state that rests.
    fn about<Sys: Constrained<N, M, Scalar = S>, const M: usize, T>(
        system: &Sys,
        reference: &State<S, N>,
        at: &State<S, N>,
        h: S,
        of: impl Fn(Self) -> Option<T>,
    ) -> Option<T> {
        let clock = clock(system, at);
        let along = |way: &SVector<S, N>, clock, spacing| {
            Nodes::along(system, reference, at, (way, clock), spacing).and_then(&of)
        };
        let turning = || {
            let force = system.momentum_rate(&at.q, &constant(S::zero()), at.t);
            along(&response(system, at, &force).0, 0.0, 0.0)
        };
        let near = || along(&at.qd, clock, 0.0);
        along(&at.qd, clock, h.to_f64().abs() / 32.0).or_else(near).or_else(turning)
    }

    /// Nodes `(q + s b, q̇, t + s clock)` of a spacing of s, or of the next larger one with which the nearest of them
    /// are resolved.
    fn along<Sys: Constrained<N, M, Scalar = S>, const M: usize>(
        system: &Sys,
        reference: &State<S, N>,
        at: &State<S, N>,
        (b, clock): (&SVector<S, N>, f64),
        mut spacing: f64,
    ) -> Option<Self> {
        let whole = largest(b);
        let b = &nearly_dependent_part::<Sys, N, M>(system, reference, at, b, CLOSE);
        let both = |s: f64| Some([projected(system, at, b, -s, clock)?, projected(system, at, b, s, clock)?]);
        let fastest = largest(b);
        // (Rounding is no way.)
        if fastest <= ROUNDED * whole {
            return None;
        }
        // (Too near the position, a projection leads far away.)
        let beside = |node: &State<S, N>, s: f64| {
            let off = (0..N).map(|i| (node.q[i] - at.q[i] - b[i] * S::from_f64(s)).to_f64().abs());
            off.fold(0.0, f64::max) <= BESIDE * s.abs() * fastest
        };
        let apart = |at: &State<S, N>| independence::<Sys, N, M>(system, reference, at) >= CLOSE;
        if spacing == 0.0 {
            // (Of small places it is smaller.)
            let distance = largest(&(reference.q - at.q));
            spacing = if distance > 0.0 { FIRST_SPACING.min(FIRST_PART * distance) } else { FIRST_SPACING };
            spacing /= fastest;
        }
        for _ in 0..MOST_SPACINGS {
            let nearest = both(spacing).filter(|[before, after]| {
                apart(before) && apart(after) && beside(before, -spacing) && beside(after, spacing)
            });
            if let Some(nearest) = nearest {
                let mut pairs = [nearest; WEIGHTS[0].len()];
                for (j, pair) in pairs.iter_mut().enumerate().skip(1) {
                    *pair = both(spacing * (j + 1) as f64)?;
                }
                let passing = spacing * pairs.len() as f64;
                return Some(Nodes { pairs, pace: largest(&at.qd) / passing });
            }
            spacing *= 1.5;
        }
        None
    }

    /// The state in their middle.
    fn state(&self, t: S) -> Option<State<S, N>> {
        let middle = |of: fn(&State<S, N>) -> SVector<S, N>| self.middle(of, SMOOTH, ROUNDED * self.pace);
        Some(State { t, q: middle(|at| at.q)?, qd: middle(|at| at.qd)? })
    }

    /// The value in their middle of a function of states, if the two polynomials differ by no more than this part of
    /// the values, or by `rounding`.
    fn middle<const K: usize>(
        &self,
        of: impl Fn(&State<S, N>) -> SVector<S, K>,
        smooth: f64,
        rounding: f64,
    ) -> Option<SVector<S, K>> {
        let mut sums: [SVector<S, K>; 2] = [constant(S::zero()); 2];
        let mut size = 0.0f64;
        for (j, pair) in self.pairs.iter().enumerate() {
            for node in pair {
                let value = of(node);
                size = size.max(largest(&value));
                for (sum, weights) in sums.iter_mut().zip(&WEIGHTS) {
                    *sum += value * S::from_f64(weights[j]);
                }
            }
        }
        (largest(&(sums[0] - sums[1])) <= (smooth * size).max(rounding)).then_some(sums[0])
    }

    /// Returns whether all of them fulfil a condition.
    fn all(&self, is: impl FnMut(&State<S, N>) -> bool) -> bool {
        self.pairs.iter().flatten().all(is)
    }

    /// [`middle`](Self::middle) of a function that stays bounded: values on both sides of a pole of odd order cancel
    /// there. Times the distance, they do not: their odd part, which is even then, is the pole in the middle. Parts of
    /// `size` are rounding.
    fn bounded<const K: usize>(
        &self,
        of: impl Fn(&State<S, N>) -> SVector<S, K>,
        smooth: f64,
        mut size: f64,
    ) -> Option<SVector<S, K>> {
        let rounding = smooth * size;
        let mut pole: SVector<S, K> = constant(S::zero());
        for (j, (pair, weight)) in self.pairs.iter().zip(WEIGHTS[0]).enumerate() {
            let [before, after] = pair.each_ref().map(&of);
            size = size.max(largest(&before)).max(largest(&after));
            pole += (after - before) * S::from_f64(weight * (j + 1) as f64);
        }
        if largest(&pole) <= POLE * size { self.middle(of, smooth, rounding) } else { None }
    }
}

/// Largest part of values of nodes that may be a pole, at the distance of the nearest one: what rounding and the
/// polynomial leave of 1.
const POLE: f64 = 1e-10;

/// Relative change of a force by a distance, in units of that of the motion, that tells nothing of its place: a state
/// may be so far beside its branch.
const STEEP: f64 = 10.0;

/// Distance between a state and those beside it that show how long gradients are elsewhere.
const ASIDE: f64 = 0.25;

/// The smallest spacing of nodes without a step, in units of the fastest coordinate, and as a part of the distance of
/// the reference.
const FIRST_SPACING: f64 = 1e-6;
const FIRST_PART: f64 = 1e-3;

/// Distance between a node and its projection, in units of that of the node.
const BESIDE: f64 = 0.5;

/// Largest correction of a start, relative to its coordinates, and square of that of its velocity.
const SAME_PLACE: f64 = 1e-6;
const SAME_DIRECTION: f64 = 1e-10;

/// Largest ratio of squares of sines at twice the distance: it is 4 on a branch that others cross, and 16 on one that
/// another one touches.
const CROSSED: f64 = 8.0;

/// The state of the branch that is nearest to one near it, where gradients are nearly dependent: the polynomial through
/// states on both sides. A projection, which divides what a state is beside the constraints by δ, leads anywhere
/// there. `None` elsewhere. Emitted as [`System::restored_across`](crate::System::restored_across).
#[cold]
#[inline(never)]
pub fn restored_across<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    reference: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Option<State<Sys::Scalar, N>>
where
    Sys::Scalar: Real,
{
    if independence::<Sys, N, M>(system, reference, at) >= CLOSE {
        return None;
    }
    Nodes::about(system, reference, at, h, |nodes| nodes.state(at.t))
}

/// Beginning of a motion near a state at which constraints are dependent. Its velocity tells on which
/// branch: states on both sides, `(q + s q̇, q̇)`, have velocities that lead to this one if it is along a branch.
/// `None` for a start at which the constraints are independent. Emitted as
/// [`System::begun_across`](crate::System::begun_across).
#[cold]
#[inline(never)]
pub fn begun_across<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> Option<Begun<Sys::Scalar, N>>
where
    Sys::Scalar: Real,
{
    let clock = clock(system, at);
    let found = elsewhere(system, at, &at.qd, clock).map(|(state, _)| state);
    let reference = found.or_else(|| aside(system, at, &at.qd, clock))?;
    let independent = independence::<Sys, N, M>(system, &reference, at);
    let on_branch = || on_branch::<Sys, N, M>(system, &reference, at);
    let state = (independent < CLOSE).then(on_branch).flatten();
    (independent < NEARLY_DEPENDENT).then_some(Begun { state, reference })
}

/// A state beside `at`, along a velocity, that shows how long gradients are elsewhere.
fn aside<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    along: &SVector<Sys::Scalar, N>,
    clock: f64,
) -> Option<State<Sys::Scalar, N>>
where
    Sys::Scalar: Real,
{
    let s = ASIDE / largest(along);
    [-s, s].into_iter().find_map(|s| projected(system, at, along, s, clock))
}

/// [`aside`] as far as the nearest state on the constraints follows, in whatever units. Where coordinates are large
/// numbers, gradients at that distance are as dependent as here: how little the way there curves tells how far
/// elsewhere is. And a unit of length: the radius of the way, or 1 where it is straight, as by angles.
fn elsewhere<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    along: &SVector<Sys::Scalar, N>,
    clock: f64,
) -> Option<(State<Sys::Scalar, N>, f64)>
where
    Sys::Scalar: Real,
{
    let fastest = largest(along);
    // The nearest state, its distance, and how far it is beside the tangent, relative to that.
    let beside = |s: f64| {
        let state = projected(system, at, along, s, clock)?;
        let off = state.q - at.q - along * Sys::Scalar::from_f64(s);
        let distance = s.abs() * fastest;
        let is_there = |off: f64| off <= BESIDE && distance >= RESOLVED * largest(&at.q);
        Some((state, distance, largest(&off) / distance)).filter(|(_, _, off)| is_there(*off))
    };
    let up_to = |distance: f64| {
        (0..SCALES).find_map(|k| {
            let s = distance / fastest / f64::from(1u32 << (2 * k));
            [-s, s].into_iter().find_map(beside)
        })
    };
    let near = up_to(ASIDE)?;
    let apart = sine(system, &near.0);
    let mut far = near;
    // (More than once, since rounding curves the way too.)
    for _ in 0..MOST_FARTHER {
        let curved = apart < APART && (STRAIGHT..CURVED).contains(&far.2);
        let Some(farther) = curved.then(|| up_to(far.1 * 3.0 * CURVED / far.2)).flatten() else { break };
        far = farther;
    }
    let is_farther = apart < APART && far.2 >= CURVED && sine(system, &far.0) > apart;
    let (state, distance, off) = if is_farther { far } else { near };
    Some((state, distance / ASIDE.max(2.0 * off / (1.0 - off))))
}

/// Distance, relative to the coordinates, at which rounding still tells a branch.
const RESOLVED: f64 = 1e-8;

/// Distance beside the tangent, relative to that along it, of states that are elsewhere, and one that is rounding; and
/// how often farther ones are looked for.
const CURVED: f64 = 0.05;
const STRAIGHT: f64 = 1e-9;
const MOST_FARTHER: u32 = 4;

/// Sine between gradients above which they are those of elsewhere.
const APART: f64 = 0.2;

/// [`least_sine`] by the gradients of the state alone.
fn sine<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> f64
where
    Sys::Scalar: Real,
{
    Functions::sqrt(least_sine(system, at, 0.0))
}

/// Distances of a state aside that are tried, each a quarter of the one before: down to 1e-10.
const SCALES: u32 = 16;

/// Length of a gradient, relative to that far away, that is no rounding.
const VANISHED: f64 = 1e-6;

/// A start on the branch that its velocity is along, if there is one and no other one touches it.
fn on_branch<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    reference: &State<Sys::Scalar, N>,
    at: &State<Sys::Scalar, N>,
) -> Option<State<Sys::Scalar, N>>
where
    Sys::Scalar: Real,
{
    let nodes = Nodes::along(system, reference, at, (&at.qd, clock(system, at)), 0.0)?;
    let state = nodes.state(at.t)?;
    let moved = state.minus(at);
    let is_near = (0..N).all(|i| moved.q[i].to_f64().abs() <= SAME_PLACE * (1.0 + at.q[i].to_f64().abs()));
    let inertia = system.inertia(&at.q, &at.qd, at.t).map(|x| x.to_f64());
    let energy = |v: &SVector<Sys::Scalar, N>| {
        let v = v.map(|x| x.to_f64());
        v.dot(&(inertia * v))
    };
    let is_along = energy(&moved.qd) <= SAME_DIRECTION * energy(&at.qd);
    let crossed = (0..2).all(|side| {
        let [near, far] = [0, 1].map(|j| independence::<Sys, N, M>(system, reference, &nodes.pairs[j][side]));
        far <= CROSSED * near
    });
    (is_near && is_along && crossed).then_some(state)
}

/// Size of the largest component.
fn largest<S: Real, const R: usize, const C: usize>(b: &SMatrix<S, R, C>) -> f64 {
    b.iter().map(|v| v.to_f64().abs()).fold(0.0, f64::max)
}

/// `at`, on the constraints to rounding, by a correction that is made however small it is: [`restore`] leaves what is
/// no more than rounding of the terms of a constraint, which, divided by δ, is more than that of its value.
fn polished<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> State<Sys::Scalar, N>
where
    Sys::Scalar: Real,
{
    let State { t, mut q, mut qd } = *at;
    let none = constant(Scalar::zero());
    q += system.response(&q, &qd, t, &none, &-system.constraints(&q, t)).0;
    qd += system.response(&q, &qd, t, &none, &-system.constraint_rates(&q, &qd, t)).0;
    State { t, q, qd }
}

/// 1.5⁷⁰ is 2e12.
const MOST_SPACINGS: u32 = 70;

/// K quantities `of` a state, its accelerations, if `A` asks for them, and its multipliers, likewise `L`. Near one at
/// which constraints are dependent they are those on the branch that it is on, by polynomials through states on both
/// sides. Multipliers that grow without bound there are not a number, and quantities by them neither, unless they
/// stay bounded themselves; nor are those of a state on no branch. Lanes have those of the state alone.
#[inline]
pub fn motion<
    Sys: Constrained<N, M>,
    const A: bool,
    const L: bool,
    const N: usize,
    const M: usize,
    const K: usize,
>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    of: impl Fn(
        &State<Sys::Scalar, N>,
        &SVector<Sys::Scalar, N>,
        &SVector<Sys::Scalar, M>,
    ) -> SVector<Sys::Scalar, K>,
) -> SVector<Sys::Scalar, K> {
    Scalar::by_case(Motion::<_, _, A, L, N, M, K> { system, at, of })
}

/// [`motion`], to be computed.
struct Motion<
    'a,
    Sys: Constrained<N, M>,
    F,
    const A: bool,
    const L: bool,
    const N: usize,
    const M: usize,
    const K: usize,
> {
    system: &'a Sys,
    at: &'a State<Sys::Scalar, N>,
    of: F,
}

impl<Sys, F, const A: bool, const L: bool, const N: usize, const M: usize, const K: usize>
    RealCase<Sys::Scalar> for Motion<'_, Sys, F, A, L, N, M, K>
where
    Sys: Constrained<N, M>,
    F: Fn(
        &State<Sys::Scalar, N>,
        &SVector<Sys::Scalar, N>,
        &SVector<Sys::Scalar, M>,
    ) -> SVector<Sys::Scalar, K>,
{
    type Output = SVector<Sys::Scalar, K>;

    #[inline]
    fn real(self) -> Self::Output
    where
        Sys::Scalar: Real,
    {
        let near = least_sine(self.system, self.at, 1.0) < BETWEEN;
        let unknown = || constant(Sys::Scalar::from_f64(f64::NAN));
        if near { self.across().unwrap_or_else(unknown) } else { self.any() }
    }

    #[inline]
    fn any(self) -> Self::Output {
        self.alone(self.at)
    }
}

impl<Sys, F, const A: bool, const L: bool, const N: usize, const M: usize, const K: usize>
    Motion<'_, Sys, F, A, L, N, M, K>
where
    Sys: Constrained<N, M>,
    F: Fn(
        &State<Sys::Scalar, N>,
        &SVector<Sys::Scalar, N>,
        &SVector<Sys::Scalar, M>,
    ) -> SVector<Sys::Scalar, K>,
{
    /// The quantities of a state alone.
    #[inline]
    fn alone(&self, at: &State<Sys::Scalar, N>) -> SVector<Sys::Scalar, K> {
        let (system, State { t, q, qd }) = (self.system, at);
        let kept = kept(system, at, || {
            let force = system.momentum_rate(q, qd, *t);
            [force, response(system, at, &force).0]
        });
        let accelerations = if A { system.accel(q, qd, *t) * kept } else { constant(Scalar::zero()) };
        let multipliers = if L { system.multipliers(q, qd, *t) * kept } else { constant(Scalar::zero()) };
        (self.of)(at, &accelerations, &multipliers)
    }

    /// The quantities of a state at which gradients are nearly dependent, by the place or by masses that differ much.
    #[cold]
    #[inline(never)]
    fn across(&self) -> Option<SVector<Sys::Scalar, K>>
    where
        Sys::Scalar: Real,
    {
        let (system, at) = (self.system, self.at);
        let static_force = system.momentum_rate(&at.q, &constant(Scalar::zero()), at.t);
        let force = |node: &State<_, N>| system.momentum_rate(&node.q, &node.qd, node.t);
        let multipliers = |node: &State<_, N>| system.multipliers(&node.q, &node.qd, node.t);
        let of = |nodes: Nodes<Sys::Scalar, N>, unit: f64, smooth: f64| {
            let own = force(at);
            let accel = |node: &State<_, N>| accelerated(system, node, &own);
            let accelerations = nodes.middle(accel, smooth, smooth * nodes.pace)?;
            if !L {
                return Some((self.of)(at, &accelerations, &constant(Scalar::zero())));
            }
            let inertial = product(&system.inertia(&at.q, &at.qd, at.t), &accelerations);
            // (Of nodes: the one at the state itself may vanish.)
            let gradient = |node: &State<_, N>| largest(&system.constraint_jacobian(&node.q, node.t));
            let gradients = nodes.pairs.iter().flatten().map(gradient).fold(0.0, f64::max);
            let size = (largest(&static_force) + largest(&inertial)) / gradients;
            // (Under the force of the state alone multipliers are without bound in the line.)
            // A state beside its branch has a force beside that of the branch.
            let unseen = own - nodes.middle(force, f64::INFINITY, 0.0)?;
            let beside = largest(&(at.q - nodes.middle(|node| node.q, f64::INFINITY, 0.0)?));
            let least = (STEEP * beside / unit).clamp(SMOOTHER, SMOOTH);
            let is_seen = nodes.all(|node| {
                let error = largest(&response(system, node, &unseen).1);
                error <= least * largest(&multipliers(node)).max(size)
            });
            if !is_seen {
                return None;
            }
            match nodes.bounded(multipliers, smooth, size) {
                Some(multipliers) => Some((self.of)(at, &accelerations, &multipliers)),
                None => nodes.bounded(|node| self.alone(node), smooth, 0.0),
            }
        };
        on_both_sides(system, at, &static_force, |at| self.alone(at), of)
    }
}

/// A quantity at a state at which gradients are nearly dependent: that of the state alone if they are so everywhere, by
/// masses that differ much, else that `of` nodes, a unit of length and the part of it to which it is known. `push` is a
/// force that may move a state at rest.
fn on_both_sides<Sys: Constrained<N, M>, const N: usize, const M: usize, T>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    push: &SVector<Sys::Scalar, N>,
    alone: impl Fn(&State<Sys::Scalar, N>) -> T,
    of: impl Fn(Nodes<Sys::Scalar, N>, f64, f64) -> Option<T>,
) -> Option<T>
where
    Sys::Scalar: Real,
{
    let moving = || elsewhere(system, at, &at.qd, clock(system, at));
    // (At rest in such a position, to rounding, a force leads to any of the branches.)
    let pushed = || {
        let aside = elsewhere(system, at, &response(system, at, push).0, 0.0)?;
        (independence::<Sys, N, M>(system, &aside.0, at) > AT_POSITION).then_some(aside)
    };
    let Some((reference, unit)) = moving().or_else(pushed) else {
        // Gradients alone tell of a system that does not move.
        let is_apart = is_linear(system, at, CLOSE) || least_sine(system, at, VANISHED) >= CLOSE;
        return is_apart.then(|| alone(at));
    };
    let independence = independence::<Sys, N, M>(system, &reference, at);
    if independence >= BETWEEN {
        return Some(alone(at));
    }
    let found = |h: f64, smooth: f64| {
        Nodes::about(system, &reference, at, Sys::Scalar::from_f64(h), |nodes| of(nodes, unit, smooth))
    };
    let on_branch = || Some(alone(&projected(system, at, &at.qd, 0.0, 0.0)?));
    let near = || if independence >= CLOSE { on_branch() } else { found(0.0, SMOOTH) };
    // Nodes farther apart lose fewer digits, if all is smooth there.
    let wide = |spacing: f64| 32.0 * spacing * unit / largest(&at.qd);
    WIDE.into_iter().find_map(|spacing| found(wide(spacing), SMOOTHER)).or_else(near)
}

/// Change of the velocities by an impulse, and the impulse `Aᵀ Λ` of the constraints: near a state at which constraints
/// are dependent those on the branch that it is on, as of [`motion`].
#[inline]
pub fn struck<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    impulse: &SVector<Sys::Scalar, N>,
) -> [SVector<Sys::Scalar, N>; 2] {
    Scalar::by_case(Struck::<_, N, M> { system, at, impulse })
}

/// [`struck`], to be computed.
struct Struck<'a, Sys: Constrained<N, M>, const N: usize, const M: usize> {
    system: &'a Sys,
    at: &'a State<Sys::Scalar, N>,
    impulse: &'a SVector<Sys::Scalar, N>,
}

impl<Sys: Constrained<N, M>, const N: usize, const M: usize> RealCase<Sys::Scalar> for Struck<'_, Sys, N, M> {
    type Output = [SVector<Sys::Scalar, N>; 2];

    #[inline]
    fn real(self) -> Self::Output
    where
        Sys::Scalar: Real,
    {
        let Struck { system, at, impulse } = self;
        if least_sine(system, at, 1.0) >= BETWEEN {
            return self.any();
        }
        let of = |nodes: Nodes<Sys::Scalar, N>, _: f64, smooth: f64| {
            // Roundings are those of the change that there would be without constraints.
            let inertia = system.inertia(&at.q, &at.qd, at.t);
            let free = (0..N).map(|i| (impulse[i] / inertia[(i, i)]).to_f64().abs());
            let rounding = smooth * free.filter(|x| x.is_finite()).fold(0.0, f64::max);
            let change = nodes.middle(|node| response(system, node, impulse).0, smooth, rounding)?;
            // (Their sum stays bounded, whatever the impulses of single constraints do.)
            Some([change, product(&inertia, &change) - impulse])
        };
        let alone = |at: &State<_, N>| Struck::<_, N, M> { system, at, impulse }.any();
        on_both_sides(system, at, impulse, alone, of)
            .unwrap_or_else(|| [constant(Sys::Scalar::from_f64(f64::NAN)); 2])
    }

    #[inline]
    fn any(self) -> Self::Output {
        let Struck { system, at, impulse } = self;
        let (change, impulses) = response(system, at, impulse);
        let change = change * kept(system, at, || [*impulse, change]);
        [change, transposed(&system.constraint_jacobian(&at.q, at.t), &impulses)]
    }
}
