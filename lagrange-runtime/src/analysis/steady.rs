//! Steady motions of systems with ignorable coordinates: the ignorable ones turn at constant rates, the others rest.
//!
//! With the conserved momenta p of the ignorable coordinates given, the others move in the effective potential
//! `V_eff(q) = −R(q, q̇ = 0) = p·q̇ − L`, q̇ being the rates of the ignorable coordinates that belong to p (Routh 1877; Beatty
//! 2006, (11.79l); Goldstein, Poole and Safko, *Classical Mechanics*, 2002, 8.3).

use super::equilibrium::{autonomous, smallest_solution};
use super::small::{coordinate_names, unconstrained};
use super::{AnalysisError, SmallMotion};
use crate::event::first_zero;
use crate::linear::lu_solve;
use crate::state::State;
use crate::system::Linearize;
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
    /// The system with these momenta of its ignorable coordinates, in their order.
    ///
    /// # Errors
    /// [`AnalysisError::NotApplicable`] unless L is quadratic in the velocities, some coordinates are ignorable and others
    /// are not; [`AnalysisError::Dimension`], [`AnalysisError::DependentCoordinates`].
    pub fn new(system: &'a Sys, momenta: &[f64]) -> Result<Self, AnalysisError> {
        unconstrained::<Sys, N>()?;
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
        let kept = (0..N).filter(|i| !ignorable.contains(i)).collect();
        Ok(Reduced { system, momenta: momenta.to_vec(), ignorable, kept })
    }

    /// The state at `q` (whose ignorable coordinates do not matter) in which the others rest.
    ///
    /// # Errors
    /// [`AnalysisError::Inertia`] where the ignorable coordinates have none.
    pub fn state(&self, q: &[f64; N]) -> Result<State<f64, N>, AnalysisError> {
        let q = SVector::from(*q);
        let m = self.system.inertia(&q, &SVector::zeros(), 0.0);
        // The other velocities are held at 0 by rows of their own.
        let held =
            SMatrix::<f64, N, N>::from_fn(|i, j| match self.kept.contains(&i) || self.kept.contains(&j) {
                true => f64::from(i == j),
                false => m[(i, j)],
            });
        let rest = self.system.momenta(&q, &SVector::zeros(), 0.0);
        let mut right = SVector::<f64, N>::zeros();
        for (&i, p) in self.ignorable.iter().zip(&self.momenta) {
            right[i] = p - rest[i];
        }
        let qd = lu_solve(&held, &right)
            .map_err(|singular| AnalysisError::Inertia { eigenvalue: 0.0, coordinate: singular.pivot })?;
        Ok(State { t: 0.0, q, qd })
    }

    /// Effective potential `V_eff(q) = p·q̇ − L`.
    ///
    /// # Errors
    /// Those of [`Reduced::state`].
    pub fn potential(&self, q: &[f64; N]) -> Result<f64, AnalysisError> {
        let at = self.state(q)?;
        Ok(self.system.jacobi(&at.q, &at.qd, at.t))
    }

    /// Slope `∂V_eff/∂q` by the coordinates that are not ignorable, in their order: `−∂L/∂q` at the rates that belong to the
    /// momenta.
    ///
    /// # Errors
    /// Those of [`Reduced::state`].
    pub fn slope(&self, q: &[f64; N]) -> Result<DVector<f64>, AnalysisError> {
        Ok(self.rest(&self.state(q)?))
    }

    /// The steady motion that Newton's method reaches from `guess`.
    ///
    /// # Errors
    /// [`AnalysisError::NotConverged`], [`AnalysisError::TimeDependent`], those of [`Reduced::state`].
    pub fn steady(&self, guess: &[f64; N]) -> Result<Steady<N>, AnalysisError> {
        let mut q = *guess;
        let mut rest = self.slope(&q)?;
        for _ in 0..100 {
            let stiffness = self.matrices(&self.state(&q)?).2;
            let step = smallest_solution(-&stiffness, &rest, N as f64 * f64::EPSILON * stiffness.amax())?;
            let mut part = 1.0;
            let better = loop {
                let mut moved = q;
                self.kept.iter().zip(&step).for_each(|(&i, x)| moved[i] += part * x);
                match self.slope(&moved) {
                    Ok(there) if there.norm() < rest.norm() => break Some((moved, there)),
                    _ if part < 1e-4 => break None,
                    _ => part *= 0.5,
                }
            };
            match better {
                Some((moved, there)) => (q, rest) = (moved, there),
                None if step.amax() <= 1e-8 && step.amax() > 0.0 || rest.amax() == 0.0 => {
                    return self.about(self.state(&q)?);
                }
                None => break,
            }
        }
        Err(AnalysisError::NotConverged { what: "a steady motion", residual: rest.amax() })
    }

    /// Small motions about a state that moves steadily.
    fn about(&self, at: State<f64, N>) -> Result<Steady<N>, AnalysisError> {
        autonomous::<Sys, N>()?;
        let (m, c, k) = self.matrices(&at);
        let names = coordinate_names::<Sys, N>();
        let names = self.kept.iter().map(|&i| names[i].clone()).collect();
        Ok(Steady { at, small: SmallMotion::named(m, c, k, names)? })
    }

    /// `bias − force` of the coordinates that are not ignorable.
    fn rest(&self, at: &State<f64, N>) -> DVector<f64> {
        let rest = self.system.bias(&at.q, &at.qd, at.t) - self.system.force(&at.q, &at.qd, at.t);
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

    /// Where the coordinate that is not ignorable turns back at the energy `h`: the roots of `V_eff = h` between `low` and
    /// `high`, found by their signs at 1000 points between.
    ///
    /// # Errors
    /// [`AnalysisError::NotApplicable`] unless exactly one coordinate is not ignorable; those of [`Reduced::state`].
    pub fn turning_points(&self, h: f64, low: f64, high: f64) -> Result<Vec<f64>, AnalysisError> {
        let only = self.only()?;
        let excess = |x: f64| {
            let mut q = [0.0; N];
            q[only] = x;
            self.potential(&q).map_or(f64::INFINITY, |v| v - h)
        };
        const PARTS: u32 = 1000;
        let at = |k: u32| low + (high - low) * f64::from(k) / f64::from(PARTS);
        let mut roots = Vec::new();
        for k in 0..PARTS {
            let (a, b) = (at(k), at(k + 1));
            let (fa, fb) = (excess(a), excess(b));
            if fa == 0.0 {
                roots.push(a);
            } else if (fa < 0.0) != (fb < 0.0) && fb != 0.0 {
                roots.push(first_zero(excess, (a, fa), (b, fb), f64::EPSILON * a.abs().max(b.abs())));
            }
        }
        if excess(high) == 0.0 {
            roots.push(high);
        }
        Ok(roots)
    }

    /// The index of the one coordinate that is not ignorable.
    fn only(&self) -> Result<usize, AnalysisError> {
        match self.kept[..] {
            [only] => Ok(only),
            _ => Err(AnalysisError::NotApplicable { needs: "exactly one coordinate that is not ignorable" }),
        }
    }

    /// All steady motions in which the one coordinate that is not ignorable stays at `q`, the momentum of the ignorable
    /// coordinate `rate` being whatever it takes, and those of the other ignorable ones as given: of a top, the two steady
    /// precessions at an inclination and a spin (Beatty 2006, (11.79t)). By the rate, the slowest first.
    ///
    /// # Errors
    /// [`AnalysisError::NoSteadyMotion`] below the threshold, see [`Reduced::thresholds`]; [`AnalysisError::NotApplicable`].
    pub fn steady_rates(&self, q: &[f64; N], rate: usize) -> Result<Vec<Steady<N>>, AnalysisError> {
        let family = self.family(q, rate, &self.momenta)?;
        let mut rates = family.roots()?;
        rates.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        rates.into_iter().map(|s| self.about(family.state(s))).collect()
    }

    /// The momenta of the ignorable coordinate `spin` at which the two rates of [`Reduced::steady_rates`] at `q` are equal, in
    /// increasing order: with less than that (in magnitude) there is no steady motion at `q`. None where there is always one.
    ///
    /// # Errors
    /// [`AnalysisError::NotApplicable`]; those of [`Reduced::state`].
    pub fn thresholds(&self, q: &[f64; N], rate: usize, spin: usize) -> Result<Vec<f64>, AnalysisError> {
        let place = self.place(spin)?;
        if spin == rate {
            return Err(AnalysisError::NotApplicable { needs: "a spin other than the rate that is sought" });
        }
        // The discriminant is a polynomial of degree 2 in the momentum.
        let scale = self.momenta[place].abs().max(f64::MIN_POSITIVE);
        let scale = if scale < 1e-100 { 1.0 } else { scale };
        let mut value = [0.0; 3];
        for (value, p) in value.iter_mut().zip([-scale, 0.0, scale]) {
            let mut momenta = self.momenta.clone();
            momenta[place] = p;
            let Rates { parabola: Parabola { a, b, c }, scale, .. } = self.family(q, rate, &momenta)?;
            *value = (b / scale).powi(2) - 4.0 * (a / scale) * (c / scale);
        }
        let mut roots = Parabola::through(value).roots().unwrap_or_default();
        roots.iter_mut().for_each(|p| *p *= scale);
        roots.sort_by(f64::total_cmp);
        Ok(roots)
    }

    /// Position of a coordinate among the ignorable ones.
    fn place(&self, coordinate: usize) -> Result<usize, AnalysisError> {
        let needs = "the index of an ignorable coordinate";
        self.ignorable.iter().position(|&i| i == coordinate).ok_or(AnalysisError::NotApplicable { needs })
    }

    /// The states at `q` with all momenta but that of `rate` given.
    fn family(&self, q: &[f64; N], rate: usize, momenta: &[f64]) -> Result<Rates<N>, AnalysisError> {
        self.only()?;
        let place = self.place(rate)?;
        let with = |p: f64| {
            let mut momenta = momenta.to_vec();
            momenta[place] = p;
            Reduced { momenta, system: self.system, ignorable: self.ignorable, kept: self.kept.clone() }
                .state(q)
        };
        // q̇ = at + s along, with the rate itself as s.
        let (zero, one) = (with(0.0)?, with(1.0)?);
        let along = one.qd - zero.qd;
        let along = along / along[rate];
        let at = State { qd: zero.qd - along * zero.qd[rate], ..zero };
        let scale = zero.qd.amax().max(1.0);
        let force = |s: f64| self.rest(&State { qd: at.qd + along * s, ..at })[0];
        let parabola = Parabola::through([-scale, 0.0, scale].map(force));
        Ok(Rates { at, along, scale, parabola })
    }
}

/// `q̇ = at + s along`, and the force that is left over, a polynomial of degree 2 in `s / scale`.
struct Rates<const N: usize> {
    at: State<f64, N>,
    along: SVector<f64, N>,
    scale: f64,
    parabola: Parabola,
}

impl<const N: usize> Rates<N> {
    fn state(&self, s: f64) -> State<f64, N> {
        State { qd: self.at.qd + self.along * s, ..self.at }
    }

    fn roots(&self) -> Result<Vec<f64>, AnalysisError> {
        Ok(self.parabola.roots()?.into_iter().map(|x| x * self.scale).collect())
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
    /// Through the values at −1, 0 and 1. Coefficients that are rounding errors are 0.
    fn through([left, c, right]: [f64; 3]) -> Self {
        let size = left.abs().max(right.abs()).max(c.abs());
        let cleaned = |x: f64| if x.abs() <= 8.0 * f64::EPSILON * size { 0.0 } else { x };
        Parabola { a: cleaned(0.5 * (left + right) - c), b: cleaned(0.5 * (right - left)), c }
    }

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

/// The parameter between `low` and `high` at which small motions begin or cease to grow, where they grow at one of the two
/// and not at the other: by bisection to rounding. Of a sleeping top, the spin that keeps it upright.
///
/// # Errors
/// [`AnalysisError::NotApplicable`] where both ends are alike; those of `small`.
pub fn stability_threshold(
    small: impl Fn(f64) -> Result<SmallMotion, AnalysisError>,
    mut low: f64,
    mut high: f64,
) -> Result<f64, AnalysisError> {
    let stable = |x: f64| small(x)?.spectrum().map(|spectrum| spectrum.is_stable());
    let at_low = stable(low)?;
    if at_low == stable(high)? {
        return Err(AnalysisError::NotApplicable {
            needs: "a parameter range with stability at one end only",
        });
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low.min(high) || middle >= low.max(high) {
            return Ok(middle);
        }
        match stable(middle)? == at_low {
            true => low = middle,
            false => high = middle,
        }
    }
}
