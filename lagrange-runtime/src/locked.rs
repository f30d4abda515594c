//! Coordinates that are held by degrees: a weight between a coordinate that is free and one that is locked.

use crate::failure::debug_is_text;
use crate::linear::lu;
use crate::scalar::{Real, Scalar, SimdScalar};
use crate::state::{State, constant};
use crate::system::{Independent, System};
use core::fmt;
use nalgebra::{SMatrix, SVector};

/// Coordinates of a system of `N` that may be locked, by name, and where they are then: what
/// `simplified Small: lock phi = 0;` writes into the definition, as a value, so that a study may try it.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::traits::Locks;
///
/// lagrangian! {
///     /// A pendulum on a spring.
///     pub system Elastic {
///         param k, g = 9.81;
///         coord theta: angle, r: length;
///         T = 0.5 * (dot(r).powi(2) + (r * dot(theta)).powi(2));
///         V = 0.5 * k * (r - 1).powi(2) - g * r * theta.cos();
///         pub simplified Rod: lock r = 1;
///     }
/// }
/// let (elastic, start) = (Elastic::new(1e3), State::new(0.0, [1.0, 1.02], [0.0; 2]));
/// let locks = Locks::new::<Elastic>([("r", 1.0)])?;
/// let locked = locks.of(elastic, [0.0]);
/// let end = integrate(&locked, Dop853, PiController::tolerance(1e-10), start).until(1.0).final_state()?;
/// let seen = locked.seen(&end);
/// let (rod, start) = (Rod::of(&elastic), State::new(0.0, [1.0], [0.0]));
/// let exact = integrate(&rod, Dop853, PiController::tolerance(1e-10), start).until(1.0).final_state()?;
/// assert!((seen.q[0] - exact.q[0]).abs() < 1e-9 && seen.q[1] == 1.0);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Locks<const N: usize, const K: usize> {
    /// Coordinates of the system that the names are of.
    of: &'static [&'static str],
    indices: [usize; K],
    held: [(&'static str, f64); K],
}

impl<const N: usize, const K: usize> Locks<N, K> {
    /// Names of coordinates, and the places where they are locked, in their units.
    ///
    /// # Errors
    /// [`NotLockable`], unless each is a coordinate of the system, given once, and its place a finite number.
    /// Parameters of a rotation are none: its state may go over to others.
    pub fn new<Sys: Independent<N>>(held: [(&'static str, f64); K]) -> Result<Self, NotLockable> {
        let mut indices = [0; K];
        for (k, (name, place)) in held.iter().enumerate() {
            let refused = |cause| Err(NotLockable { coordinate: name, cause });
            let Some(index) = Sys::FACTS.coordinates.iter().position(|known| known == name) else {
                return refused(Cause::Unknown(Sys::FACTS.coordinates));
            };
            if indices[..k].contains(&index) {
                return refused(Cause::Twice);
            }
            if !place.is_finite() {
                return refused(Cause::NotFinite);
            }
            if Sys::ATTITUDES.iter().any(|first| (*first..first + 3).contains(&index)) {
                return refused(Cause::Rotation);
            }
            indices[k] = index;
        }
        Ok(Locks { of: Sys::FACTS.coordinates, indices, held })
    }

    /// The names and places.
    pub fn held(&self) -> [(&'static str, f64); K] {
        self.held
    }

    /// The system in which each of these coordinates has a weight: 1 where it is free, 0 where it is locked.
    ///
    /// # Panics
    /// If its coordinates are not those of the system that the locks are of.
    pub fn of<Sys: Independent<N>>(&self, system: Sys, weights: [Sys::Scalar; K]) -> Locked<Sys, N, K> {
        let own = Sys::FACTS.coordinates;
        assert!(own == self.of, "locks of the coordinates {:?} are none of {own:?}", self.of);
        let places = self.held.map(|(_, place)| Sys::Scalar::from_f64(place));
        Locked { system, indices: self.indices, places, weights }
    }
}

/// A coordinate that cannot be locked.
#[derive(Clone, Copy, PartialEq)]
pub struct NotLockable {
    /// Its name, as given.
    pub coordinate: &'static str,
    cause: Cause,
}

#[derive(Clone, Copy, PartialEq)]
enum Cause {
    Unknown(&'static [&'static str]),
    Twice,
    NotFinite,
    Rotation,
}

impl fmt::Display for NotLockable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NotLockable { coordinate, cause } = self;
        match cause {
            Cause::Unknown(known) => {
                write!(
                    f,
                    "`{coordinate}` is no coordinate of the system; help: its coordinates are {known:?}"
                )
            }
            Cause::Twice => write!(f, "`{coordinate}` is locked twice; help: leave one of them out"),
            Cause::NotFinite => {
                write!(f, "`{coordinate}` is locked at no finite place; help: give one, in its units")
            }
            Cause::Rotation => write!(
                f,
                "`{coordinate}` is a parameter of a rotation, which has others where it turns far; help: write the joint by angles"
            ),
        }
    }
}

debug_is_text! { [] NotLockable }

impl core::error::Error for NotLockable {}

/// A system of which `K` coordinates have weights w, made by [`Locks::of`]: with w = 1 it is the system, with w = 0 the
/// coordinate is locked, and derivatives by w at 1 say to first order what locking it changes. So one run over
/// [`Gradient`](crate::Gradient)s ranks coordinates beside terms.
///
/// All but coordinate i itself see a part w of its deviation from the place c where it is locked,
/// `qᵢ → c + w (qᵢ − c)`, and of its velocity and acceleration; in its own equation of motion it sees the whole of it.
/// With `x` the state as the others see it and `x⁽ⁱ⁾` the same with the whole of qᵢ, the accelerations α solve
///
/// `Σⱼ Mᵢⱼ(x) wⱼ αⱼ = fᵢ(x)` for a coordinate without a weight, and
/// `Mᵢᵢ(x⁽ⁱ⁾) αᵢ + Σⱼ≠ᵢ Mᵢⱼ(x⁽ⁱ⁾) wⱼ αⱼ = fᵢ(x⁽ⁱ⁾)` for one with a weight, or αᵢ = 0 where that is 0,
///
/// in which f = M q̈ are the forces less the velocity terms, and wⱼ = 1 without a weight. Weights of 0 and 1 are exact
/// in any mixture, to the rounding of f: ε times the condition of M (5e-6 with masses of 1 and 1e-12 in a row). A
/// constraint force that is scaled would slow the coordinate down instead of leaving it out: a coordinate that follows
/// as in statics would have no effect at first order, and a fast one the effect of its phase.
///
/// States of runs have the coordinates themselves; [`seen`](Self::seen) says where the others see them, and observers
/// should look there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Locked<Sys: System<N>, const N: usize, const K: usize> {
    system: Sys,
    indices: [usize; K],
    places: [Sys::Scalar; K],
    weights: [Sys::Scalar; K],
}

impl<Sys: System<N>, const N: usize, const K: usize> Locked<Sys, N, K> {
    /// The system.
    pub fn system(&self) -> &Sys {
        &self.system
    }

    /// The state as others see it: qᵢ = c + w (qᵢ − c), and w q̇ᵢ.
    pub fn seen(&self, state: &State<Sys::Scalar, N>) -> State<Sys::Scalar, N> {
        self.seen_by(None, state)
    }

    /// The state as the coordinate with this weight sees it.
    fn seen_by(&self, own: Option<usize>, state: &State<Sys::Scalar, N>) -> State<Sys::Scalar, N> {
        let mut seen = *state;
        for k in (0..K).filter(|k| Some(*k) != own && self.weights[*k] != Sys::Scalar::one()) {
            let (i, place, w) = (self.indices[k], self.places[k], self.weights[k]);
            (seen.q[i], seen.qd[i]) = (place + w * (state.q[i] - place), w * state.qd[i]);
        }
        seen
    }
}

impl<Sys: Independent<N>, const N: usize, const K: usize> Locked<Sys, N, K>
where
    Sys::Scalar: SimdScalar,
{
    /// M and f at a state.
    fn terms(&self, at: &State<Sys::Scalar, N>) -> (SMatrix<Sys::Scalar, N, N>, SVector<Sys::Scalar, N>) {
        let inertia = self.system.inertia_at(at);
        (inertia, crate::linear::product(&inertia, &self.system.accel_at(at)))
    }
}

impl<Sys: Independent<N>, const N: usize, const K: usize> System<N> for Locked<Sys, N, K>
where
    Sys::Scalar: SimdScalar,
{
    type Scalar = Sys::Scalar;
    const AUTONOMOUS: bool = Sys::AUTONOMOUS;
    const ATTITUDES: &'static [usize] = Sys::ATTITUDES;
    const SWITCHES: usize = Sys::SWITCHES;
    const IMPULSES: usize = Sys::IMPULSES;
    const HOLDS: bool = Sys::HOLDS;

    fn accel(
        &self,
        q: &SVector<Self::Scalar, N>,
        qd: &SVector<Self::Scalar, N>,
        t: Self::Scalar,
    ) -> SVector<Self::Scalar, N> {
        let (zero, one) = (Self::Scalar::zero(), Self::Scalar::one());
        let state = State { t, q: *q, qd: *qd };
        if self.weights.iter().all(|w| *w == one) {
            return self.system.accel_at(&state);
        }
        let mut weight: [Self::Scalar; N] = [one; N];
        (0..K).for_each(|k| weight[self.indices[k]] = self.weights[k]);
        let (mut a, mut b) = self.terms(&self.seen(&state));
        for mut row in a.row_iter_mut() {
            (0..N).for_each(|j| row[j] *= weight[j]);
        }
        for k in (0..K).filter(|k| self.weights[*k] != one) {
            let i = self.indices[k];
            if self.weights[k] == zero {
                (0..N).for_each(|j| a[(i, j)] = if i == j { one } else { zero });
                b[i] = zero;
                continue;
            }
            let (inertia, force) = self.terms(&self.seen_by(Some(k), &state));
            (0..N)
                .for_each(|j| a[(i, j)] = if i == j { inertia[(i, j)] } else { inertia[(i, j)] * weight[j] });
            b[i] = force[i];
        }
        lu::<_, Self::Scalar, N>(&a).map_or(constant(crate::iteration::nan()), |factors| factors.solve(&b))
    }

    fn switches(
        &self,
        at: &State<Self::Scalar, N>,
        accelerations: &SVector<Self::Scalar, N>,
        each: impl FnMut(usize, [Self::Scalar; 2]),
    ) {
        let mut seen = *accelerations;
        (0..K).for_each(|k| seen[self.indices[k]] *= self.weights[k]);
        self.system.switches(&self.seen(at), &seen, each);
    }

    fn decides(&self, switch: usize, at: &State<Self::Scalar, N>) -> bool
    where
        Self::Scalar: Real,
    {
        self.system.decides(switch, &self.seen(at))
    }
}
