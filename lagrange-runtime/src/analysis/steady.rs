//! Steady motions of systems with ignorable coordinates: the ignorable ones turn at constant rates, the others rest.
//!
//! With the conserved momenta p of the ignorable coordinates given, the others move in the effective potential
//! `V_eff(q) = −R(q, q̇ = 0) = p·q̇ − L`, q̇ being the rates of the ignorable coordinates that belong to p (Routh
//! 1877; Beatty 2006, (11.79l); Goldstein, Poole and Safko, *Classical Mechanics*, 2002, 8.3).

use super::balance::balance;
use super::constrained::{self, Place, admitted, balanced, doubted};
use super::hypotheses::{autonomous, coordinate_names, next, second_order, unconstrained};
use super::switch::{linearized, smooth};
use super::tangent::{Held, TangentSpace, classes, fulfilled, stiffness_of_forces, units};
use super::{AnalysisError, SmallMotion};
use crate::event::first_zero;
use crate::failure::Coordinate;
use crate::linear::lu_solve;
use crate::state::State;
use crate::system::{Lagrangian, Linearize};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// A system with the momenta of its ignorable coordinates held at given values.
///
/// ```
/// use lagrange_runtime::analysis::Reduced;
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// Kepler's problem.
///     system Kepler {
///         param mu;
///         coord r, phi;
///         T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
///         V = -mu / r;
///     }
/// }
/// let kepler = Kepler::new(4.0);
/// let reduced = Reduced::new(&kepler, &[2.0])?; // the angular momentum
/// assert_eq!(reduced.potential(&[0.8, 0.0])?, 0.5 * (2.0f64 / 0.8).powi(2) - 4.0 / 0.8);
/// let circle = reduced.steady(&[0.8, 0.0])?;
/// assert!((circle.at.q[0] - 2.0f64.powi(2) / 4.0).abs() < 1e-15, "r = p²/μ");
/// assert!((circle.small.modes()?.frequency(0) - circle.at.qd[1]).abs() < 1e-14, "the ellipses close");
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Reduced<'a, Sys, const N: usize> {
    system: &'a Sys,
    momenta: Vec<f64>,
    /// Ignorable coordinates, and the others.
    ignorable: &'static [usize],
    kept: Vec<usize>,
}

/// A steady motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Steady<const N: usize> {
    /// A state of it: the rates of the ignorable coordinates are constant, the other velocities 0.
    pub at: State<f64, N>,
    /// Small motions of the coordinates that are not ignorable, the momenta of the others being as they are. Its energy
    /// criterion is that of the effective potential.
    pub small: SmallMotion,
}

impl<'a, Sys: Linearize<N, Scalar = f64>, const N: usize> Reduced<'a, Sys, N> {
    /// The system with these momenta `∂L/∂q̇` of its ignorable coordinates, in the order of
    /// [`Facts::ignorable`](crate::Facts::ignorable): in kg m²/s of an angle, in kg m/s of a length.
    ///
    /// # Hypotheses
    /// - L is quadratic in the velocities ([`Facts::quadratic`](crate::Facts::quadratic)), some coordinates are
    ///   ignorable and others are not: otherwise [`AnalysisError::NotApplicable`].
    /// - There is a momentum for each ignorable coordinate: otherwise [`AnalysisError::Dimension`].
    pub fn new(system: &'a Sys, momenta: &[f64]) -> Result<Self, AnalysisError> {
        second_order::<Sys, N>()?;
        let ignorable = Sys::FACTS.ignorable;
        if !Sys::FACTS.quadratic {
            return Err(AnalysisError::NotApplicable {
                needs: "a Lagrangian that is quadratic in the velocities",
            });
        }
        if ignorable.is_empty() || ignorable.len() == N {
            return Err(AnalysisError::NotApplicable { needs: "ignorable coordinates besides others" });
        }
        if momenta.len() != ignorable.len() {
            return Err(AnalysisError::Dimension { expected: ignorable.len(), found: momenta.len() });
        }
        if momenta.iter().any(|p| !p.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        let kept = (0..N).filter(|i| !ignorable.contains(i)).collect();
        Ok(Reduced { system, momenta: momenta.to_vec(), ignorable, kept })
    }

    /// The state at `q`, all N coordinates (of which ignorable ones do not matter), in which the others rest, at t = 0.
    ///
    /// # Errors
    /// [`AnalysisError::Inertia`] where the ignorable coordinates have none.
    pub fn state(&self, q: &[f64; N]) -> Result<State<f64, N>, AnalysisError> {
        let qd = self.rates(q, |place, rest| self.momenta[place] - rest)?;
        Ok(State { t: 0.0, q: SVector::from(*q), qd })
    }

    /// The velocities, those of coordinates that are not ignorable 0, that belong to a change of the ignorable
    /// momenta: of each of them, by its place and its value at rest.
    fn rates(
        &self,
        q: &[f64; N],
        change: impl Fn(usize, f64) -> f64,
    ) -> Result<SVector<f64, N>, AnalysisError> {
        let (q, still) = (SVector::from(*q), SVector::zeros());
        let m = self.system.inertia(&q, &still, 0.0);
        // The other velocities are held at 0 by rows of their own.
        let held =
            SMatrix::<f64, N, N>::from_fn(|i, j| match self.kept.contains(&i) || self.kept.contains(&j) {
                true => f64::from(i == j),
                false => m[(i, j)],
            });
        let rest = self.system.momenta(&q, &still, 0.0);
        let mut right = SVector::<f64, N>::zeros();
        for (place, &i) in self.ignorable.iter().enumerate() {
            right[i] = change(place, rest[i]);
        }
        lu_solve(&held, &right).map_err(|singular| AnalysisError::Inertia {
            eigenvalue: 0.0,
            coordinate: Coordinate::of::<Sys, N>(singular.pivot),
        })
    }

    /// Effective potential `V_eff(q) = p·q̇ − L` at all N coordinates, in J.
    ///
    /// # Hypotheses
    /// - Energy is conserved ([`Facts::conservative`](crate::Facts::conservative)): there is neither dissipation nor
    ///   a force without a potential, and time does not appear in L. Otherwise [`AnalysisError::NotApplicable`].
    ///
    /// # Errors
    /// Those of [`Reduced::state`].
    pub fn potential(&self, q: &[f64; N]) -> Result<f64, AnalysisError> {
        conservative::<Sys, N>()?;
        let at = self.state(q)?;
        Ok(self.system.energy_function(&at.q, &at.qd, at.t))
    }

    /// Slope `∂V_eff/∂q` by the coordinates that are not ignorable, in their order, in N for lengths and N m for
    /// angles: `−∂L/∂q` at the rates that belong to the momenta.
    ///
    /// # Hypotheses
    /// - That of [`Reduced::potential`].
    /// - Coordinates are independent: otherwise [`AnalysisError::DependentCoordinates`].
    ///
    /// # Errors
    /// Those of [`Reduced::state`].
    pub fn slope(&self, q: &[f64; N]) -> Result<DVector<f64>, AnalysisError> {
        unconstrained::<Sys, N>()?;
        conservative::<Sys, N>()?;
        Ok(self.rest(&self.state(q)?))
    }

    /// The steady motion that Newton's method reaches from `guess`, on the constraints if there are any, in which no
    /// ignorable coordinate appears. Its small motions are in minimal coordinates of what these admit. Dissipation
    /// and forces without a potential may act.
    ///
    /// # Hypotheses
    /// - Time does not appear in the equations of motion ([`Facts::autonomous`](crate::Facts::autonomous)): otherwise
    ///   [`AnalysisError::TimeDependent`].
    ///
    /// # Errors
    /// [`AnalysisError::NotConverged`], [`AnalysisError::Unbalanced`], [`AnalysisError::DependentConstraints`], those
    /// of [`Reduced::state`].
    pub fn steady(&self, guess: &[f64; N]) -> Result<Steady<N>, AnalysisError> {
        autonomous::<Sys, N>()?;
        let place = |kept: &DVector<f64>| {
            let mut q = *guess;
            self.kept.iter().zip(kept).for_each(|(&i, x)| q[i] = *x);
            self.state(&q)
        };
        let start = DVector::from_iterator(self.kept.len(), self.kept.iter().map(|&i| guess[i]));
        if !Sys::FACTS.constraints.is_empty() {
            return self.held_steady(start, &place);
        }
        let forces = |kept: &DVector<f64>| Ok(self.rest(&place(kept)?));
        let stiffness = |kept: &DVector<f64>| Ok(self.matrices(&place(kept)?).2);
        let found = balance("a steady motion", start, &forces, &stiffness, &self.attitudes())?;
        let Steady { at, small } = self.about(place(&found.q)?)?;
        Ok(Steady { at, small: small.doubted(&found.stiffness_aside) })
    }

    /// The first coordinates of attitudes among those that are not ignorable.
    fn attitudes(&self) -> Vec<usize> {
        Sys::ATTITUDES.iter().filter_map(|first| self.kept.iter().position(|i| i == first)).collect()
    }

    /// The same with constraints on the coordinates that are not ignorable.
    fn held_steady(
        &self,
        start: DVector<f64>,
        place: &dyn Fn(&DVector<f64>) -> Result<State<f64, N>, AnalysisError>,
    ) -> Result<Steady<N>, AnalysisError> {
        let held = |at: &State<f64, N>| -> Result<Vec<Held>, AnalysisError> {
            let all = Held::all(self.system, at)?;
            Ok(all.iter().map(|held| held.kept(&self.kept)).collect())
        };
        let look = |kept: &DVector<f64>| {
            let at = place(kept)?;
            Ok(Place { forces: self.rest(&at), stiffness: self.matrices(&at).2, held: held(&at)? })
        };
        let weights = units(&self.matrices(&place(&start)?).0);
        let near = admitted(self.system, &place(&start)?).q;
        let start = DVector::from_iterator(self.kept.len(), self.kept.iter().map(|&i| near[i]));
        let found = balanced("a steady motion", start, &weights, &look, &self.attitudes())?;
        let at = place(&found.q)?;
        fulfilled(&held(&at)?, found.q.as_slice(), &vec![0.0; self.kept.len()])?;
        smooth(self.system, &at, found.last, linearized)?;
        let mut all = held(&at)?;
        all.iter_mut().zip(&found.multipliers).for_each(|(held, x)| held.multiplier = *x);
        let (m, c, k) = self.matrices(&at);
        let k = k - stiffness_of_forces(&all, self.kept.len());
        let units = units(&m);
        let space = TangentSpace::new(&all, &units, &classes(&all, &k, &units, &|_| false))?;
        let names = coordinate_names::<Sys, N>();
        let names: Vec<String> = self.kept.iter().map(|&i| names[i].clone()).collect();
        let small = space.small(&space.projected([&m, &c, &k]), &names)?;
        let small = small.conservative(constrained::conservative::<Sys, N>());
        Ok(Steady { at, small: doubted(small, &space, &found.stiffness_aside) })
    }

    /// Small motions about a state that moves steadily.
    fn about(&self, at: State<f64, N>) -> Result<Steady<N>, AnalysisError> {
        smooth(self.system, &at, 0.0, linearized)?;
        let (m, c, k) = self.matrices(&at);
        let names = coordinate_names::<Sys, N>();
        let names = self.kept.iter().map(|&i| names[i].clone()).collect();
        let small = SmallMotion::named(m, c, k, names)?.blurred(self.matrices(&next(&at)).into());
        Ok(Steady { at, small: small.conservative(Sys::FACTS.conservative) })
    }

    /// `b − f` of the coordinates that are not ignorable.
    fn rest(&self, at: &State<f64, N>) -> DVector<f64> {
        let rest = self.system.convective_momentum_rate(&at.q, &at.qd, at.t)
            - self.system.momentum_rate(&at.q, &at.qd, at.t);
        DVector::from_iterator(self.kept.len(), self.kept.iter().map(|&i| rest[i]))
    }

    /// M, C and K of the coordinates that are not ignorable, from those of all: the conservation of momentum
    /// `M_ii δq̇_i + M_ir δq̇_r + B δq_r = 0`, `B = ∂p_i/∂q_r`, eliminates the others (Merkin 1997, 7.2).
    fn matrices(&self, at: &State<f64, N>) -> (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) {
        let m = self.system.inertia(&at.q, &at.qd, at.t);
        let linear = self.system.linearize(&at.q, &at.qd, at.t);
        let part = |a: &SMatrix<f64, N, N>, rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| a[(rows[i], columns[j])])
        };
        let (i, r) = (self.ignorable, &self.kept[..]);
        let inverse =
            part(&m, i, i).try_inverse().unwrap_or_else(|| DMatrix::from_element(i.len(), i.len(), f64::NAN));
        let (coupling, b) = (part(&m, i, r), part(&linear.damping, i, r));
        let returned = part(&linear.damping, r, i);
        let inertia = part(&m, r, r) - coupling.transpose() * &inverse * &coupling;
        let damping = part(&linear.damping, r, r)
            - coupling.transpose() * &inverse * &b
            - &returned * &inverse * &coupling;
        let stiffness = part(&linear.stiffness, r, r) - &returned * &inverse * &b;
        (inertia, damping, stiffness)
    }

    /// Turning points of the coordinate that is not ignorable at the energy `h`, in the unit of the coordinate, as are
    /// `low` and `high`: the roots of `V_eff = h` between these, found by their signs at 1001 points at equal
    /// distances, in increasing order.
    ///
    /// # Hypotheses
    /// - That of [`Reduced::potential`].
    /// - Coordinates are independent: otherwise [`AnalysisError::DependentCoordinates`].
    /// - Exactly one coordinate is not ignorable, energy and ends are finite, and `low ≤ high`: otherwise
    ///   [`AnalysisError::NotApplicable`].
    /// - No pole of the coordinates is among the points: otherwise [`AnalysisError::Inertia`].
    /// - Two turning points between two of the points are not seen.
    pub fn turning_points(&self, h: f64, low: f64, high: f64) -> Result<Vec<f64>, AnalysisError> {
        let only = self.only()?;
        if ![h, low, high].iter().all(|x| x.is_finite()) || low > high {
            return Err(AnalysisError::NotApplicable {
                needs: "a finite energy and finite ends with low ≤ high",
            });
        }
        let excess = |x: f64| {
            let mut q = [0.0; N];
            q[only] = x;
            match self.potential(&q)? - h {
                excess if excess.is_nan() => Err(AnalysisError::NotFinite),
                excess => Ok(excess),
            }
        };
        const PARTS: u32 = 1000;
        let at = |k: u32| low + (high - low) * f64::from(k) / f64::from(PARTS);
        let mut roots = Vec::new();
        let mut from = (low, excess(low)?);
        for k in 1..=PARTS {
            let to = (at(k), excess(at(k))?);
            if from.1 == 0.0 {
                roots.push(from.0);
            } else if (from.1 < 0.0) != (to.1 < 0.0) && to.1 != 0.0 {
                let error = f64::EPSILON * from.0.abs().max(to.0.abs());
                roots.push(first_zero(&mut |x| excess(x).unwrap_or(f64::NAN), from, to, error));
            }
            from = to;
        }
        if from.1 == 0.0 {
            roots.push(high);
        }
        Ok(roots)
    }

    /// The index of the one coordinate that is not ignorable.
    fn only(&self) -> Result<usize, AnalysisError> {
        unconstrained::<Sys, N>()?;
        match self.kept[..] {
            [only] => Ok(only),
            _ => Err(AnalysisError::NotApplicable { needs: "exactly one coordinate that is not ignorable" }),
        }
    }

    /// All steady motions in which the one coordinate that is not ignorable stays at `q`, the momentum of the ignorable
    /// coordinate with the index `rate` in q being whatever it takes, and those of the other ignorable ones as given:
    /// of a top, the two steady precessions at an inclination and a spin (Beatty 2006, (11.79t)). By the rate, the
    /// slowest first.
    ///
    /// # Hypotheses
    /// - Coordinates are independent: otherwise [`AnalysisError::DependentCoordinates`].
    /// - Time does not appear in the equations of motion ([`Facts::autonomous`](crate::Facts::autonomous)): otherwise
    ///   [`AnalysisError::TimeDependent`].
    /// - Forces are polynomials of degree 2 at most in the velocities
    ///   ([`Facts::quadratic_forces`](crate::Facts::quadratic_forces)), and exactly one coordinate is not ignorable:
    ///   otherwise [`AnalysisError::NotApplicable`].
    ///
    /// # Errors
    /// [`AnalysisError::NoSteadyMotion`] below the threshold, see [`Reduced::thresholds`]; those of [`Reduced::state`].
    pub fn steady_rates(&self, q: &[f64; N], rate: usize) -> Result<Vec<Steady<N>>, AnalysisError> {
        let family = self.family(q, rate)?;
        let mut rates = family.parabola(&family.base).roots()?;
        rates.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let state = |s: f64| State { t: 0.0, q: SVector::from(*q), qd: family.base + family.along * s };
        rates.into_iter().map(|s| self.about(state(s))).collect()
    }

    /// The momenta of the ignorable coordinate with the index `spin` in q, in the units of [`Reduced::new`], at which
    /// the two rates of [`Reduced::steady_rates`] at `q` are equal, in increasing order: with less than that (in
    /// magnitude) there is no steady motion at `q`. None where there is always one.
    ///
    /// # Hypotheses
    /// Those of [`Reduced::steady_rates`], and `spin` is another coordinate than `rate`: otherwise
    /// [`AnalysisError::NotApplicable`].
    ///
    /// # Errors
    /// Those of [`Reduced::state`].
    pub fn thresholds(&self, q: &[f64; N], rate: usize, spin: usize) -> Result<Vec<f64>, AnalysisError> {
        let family = self.family(q, rate)?;
        if spin == rate {
            return Err(AnalysisError::NotApplicable { needs: "a spin other than the rate that is sought" });
        }
        let spin = self.place(spin)?;
        // With p = 0, and what one unit of it adds: the discriminant b² − 4ac is a polynomial of degree 2 in p, as b
        // and c are polynomials.
        let without =
            |place: usize, rest: f64| if place == spin { -rest } else { self.momenta[place] - rest };
        let base = family.steadied(self.rates(q, without)?);
        let unit = family.steadied(self.rates(q, |place, _| f64::from(u8::from(place == spin)))?);
        let Parabola { a, b, c } = family.parabola(&base);
        let slope = family.forces.curvature * unit;
        let (b1, c1, c2) = (
            slope.dot(&family.along),
            family.forces.slope.dot(&unit) + slope.dot(&base),
            0.5 * slope.dot(&unit),
        );
        let discriminant =
            Parabola { a: b1 * b1 - 4.0 * a * c2, b: 2.0 * b * b1 - 4.0 * a * c1, c: b * b - 4.0 * a * c };
        let mut roots = discriminant.roots().unwrap_or_default();
        roots.sort_by(f64::total_cmp);
        Ok(roots)
    }

    /// Position of a coordinate among the ignorable ones.
    fn place(&self, coordinate: usize) -> Result<usize, AnalysisError> {
        let needs = "the index of an ignorable coordinate";
        self.ignorable.iter().position(|&i| i == coordinate).ok_or(AnalysisError::NotApplicable { needs })
    }

    /// The states at `q` with all momenta but that of `rate` given.
    fn family(&self, q: &[f64; N], rate: usize) -> Result<Family<N>, AnalysisError> {
        autonomous::<Sys, N>()?;
        if !Sys::FACTS.quadratic_forces {
            let needs =
                "forces that are polynomials of degree 2 in the velocities (`Facts::quadratic_forces`)";
            return Err(AnalysisError::NotApplicable { needs });
        }
        let (only, place) = (self.only()?, self.place(rate)?);
        let along = self.rates(q, |other, _| f64::from(u8::from(other == place)))?;
        let free = |other: usize, rest: f64| if other == place { -rest } else { self.momenta[other] - rest };
        let at = State { t: 0.0, q: SVector::from(*q), qd: SVector::zeros() };
        let row = |qd: &SVector<f64, N>| self.system.linearize(&at.q, qd, at.t).damping.row(only).transpose();
        let slope = row(&at.qd);
        let axis = |j: usize| SVector::from_fn(|i, _| f64::from(u8::from(i == j)));
        let columns: [SVector<f64, N>; N] = core::array::from_fn(|j| row(&axis(j)) - slope);
        let forces = Forces { rest: self.rest(&at)[0], slope, curvature: SMatrix::from_columns(&columns) };
        let mut family = Family { rate, base: SVector::zeros(), along: along / along[rate], forces };
        family.base = family.steadied(self.rates(q, free)?);
        Ok(family)
    }
}

/// Refuses a system of which the compiler did not prove that energy is conserved.
fn conservative<Sys: Lagrangian<N>, const N: usize>() -> Result<(), AnalysisError> {
    match Sys::FACTS.conservative {
        true => Ok(()),
        false => Err(AnalysisError::NotApplicable { needs: "conserved energy (`Facts::conservative`)" }),
    }
}

/// Residual force on the one coordinate that is not ignorable, `rest + slope·q̇ + ½ q̇ᵀ curvature q̇` exactly.
struct Forces<const N: usize> {
    rest: f64,
    slope: SVector<f64, N>,
    curvature: SMatrix<f64, N, N>,
}

/// `q̇ = base + s along`, s being the rate of the coordinate `rate`.
struct Family<const N: usize> {
    rate: usize,
    base: SVector<f64, N>,
    along: SVector<f64, N>,
    forces: Forces<N>,
}

impl<const N: usize> Family<N> {
    /// Without the rate itself.
    fn steadied(&self, qd: SVector<f64, N>) -> SVector<f64, N> {
        let mut qd = qd - self.along * qd[self.rate];
        qd[self.rate] = 0.0;
        qd
    }

    /// The force that is left over, by s.
    fn parabola(&self, base: &SVector<f64, N>) -> Parabola {
        let Forces { rest, slope, curvature } = &self.forces;
        let (bent, along) = (curvature * base, &self.along);
        let mut parabola = Parabola {
            a: 0.5 * along.dot(&(curvature * along)),
            b: slope.dot(along) + bent.dot(along),
            c: rest + slope.dot(base) + 0.5 * bent.dot(base),
        };
        // A square that is rounding at the rate of the linear equation, and at those that belong to the momenta,
        // would make a second rate.
        let Parabola { a, b, c } = parabola;
        let scale = base.amax().max(if b == 0.0 { 0.0 } else { (c / b).abs() });
        if a.abs() * scale * scale <= 8.0 * f64::EPSILON * (b * scale).abs().max(c.abs()) && b != 0.0 {
            parabola.a = 0.0;
        }
        parabola
    }
}

/// `a x² + b x + c`
#[derive(Clone, Copy, Debug)]
struct Parabola {
    a: f64,
    b: f64,
    c: f64,
}

impl Parabola {
    /// Without cancellation: the larger root from the sum of equal signs, the other from the product.
    fn roots(&self) -> Result<Vec<f64>, AnalysisError> {
        let Parabola { a, b, c } = *self;
        if a == 0.0 {
            return match b == 0.0 {
                true => Err(AnalysisError::NoSteadyMotion { discriminant: 0.0 }),
                false => Ok(vec![-c / b]),
            };
        }
        let discriminant = b * b - 4.0 * a * c;
        if discriminant < 0.0 {
            return Err(AnalysisError::NoSteadyMotion { discriminant });
        }
        let sum = -0.5 * (b + discriminant.sqrt().copysign(b));
        Ok(if sum == 0.0 { vec![0.0] } else { vec![sum / a, c / sum] })
    }
}

/// The parameter, in its unit, between `low` and `high` at which small motions begin or cease to grow, where they grow
/// at one of the two and not at the other: by bisection to rounding, growth being what exceeds the error of its
/// eigenvalue ([`Spectrum::is_stable`](super::Spectrum::is_stable)). Of a sleeping top, the spin that keeps it upright.
///
/// # Hypotheses
/// - Ends are finite, and small motions grow at one of them only: otherwise [`AnalysisError::NotApplicable`]. Of
///   several such parameters one is found.
///
/// # Errors
/// Those of `small` and of [`SmallMotion::spectrum`].
pub fn stability_threshold(
    small: impl Fn(f64) -> Result<SmallMotion, AnalysisError>,
    mut low: f64,
    mut high: f64,
) -> Result<f64, AnalysisError> {
    if !(low.is_finite() && high.is_finite()) {
        return Err(AnalysisError::NotApplicable { needs: "a parameter range with finite ends" });
    }
    let stable = |x: f64| small(x)?.spectrum().map(|spectrum| spectrum.is_stable());
    let at_low = stable(low)?;
    if at_low == stable(high)? {
        return Err(AnalysisError::NotApplicable {
            needs: "a parameter range with stability at one end only",
        });
    }
    loop {
        let middle = 0.5 * low + 0.5 * high;
        if middle <= low.min(high) || middle >= low.max(high) {
            return Ok(middle);
        }
        match stable(middle)? == at_low {
            true => low = middle,
            false => high = middle,
        }
    }
}
