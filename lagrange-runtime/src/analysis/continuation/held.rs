//! Curves of equilibria of systems with constraints on positions, z = (q, λ, μ).
//!
//! `b − f − Aᵀ λ = 0` and `f(q) = 0` have no more singular points than the equilibria have in coordinates of their
//! own: the matrix of their derivatives is regular where K is on admissible displacements.

use super::curve::{Curve, Equations, negative};
use super::{Branch, Family, Heading, Path, begun, sizes};
use crate::analysis::balance::smallest_solution;
use crate::analysis::constrained::{SINGULAR, conservative, far, nearly_dependent, with_rounding};
use crate::analysis::hypotheses::coordinate_names;
use crate::analysis::stability::least_is_negative;
use crate::analysis::switch::linearized;
use crate::analysis::tangent::{ACTS, Held, TangentSpace, classes, dynamic, stiffness_of_forces, units};
use crate::analysis::{AnalysisError, SmallMotion, Stability};
use crate::facts::{ConstraintKind, Facts};
use crate::scalar::Dual;
use crate::state::{ConstraintTerms, State};
use crate::system::{Lagrangian, Linearize};
use nalgebra::{DMatrix, DVector};

/// Refuses constraints on velocities, by which equilibria lie in surfaces, and those that follow from others.
pub(super) fn admissible<Sys: Lagrangian<N>, const N: usize>() -> Result<(), AnalysisError> {
    let all = Sys::FACTS.constraints;
    let on_velocities = all.iter().find(|c| c.kind != ConstraintKind::Holonomic);
    match on_velocities.or(all.first().filter(|_| Sys::FACTS.redundancy.is_some())) {
        Some(constraint) => Err(AnalysisError::DependentCoordinates { constraint: constraint.name }),
        None => Ok(()),
    }
}

/// The curve from a guess in (q, μ).
pub(super) fn follow<F: Fn(Dual<f64>) -> Sys, Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize>(
    family: Family<'_, F, Sys, N>,
    guess: &DVector<f64>,
    towards: &DVector<f64>,
    heading: &Heading,
    path: &Path,
) -> Result<Branch, AnalysisError> {
    let terms = family.terms(guess);
    let count = terms.len();
    if let Some(constraint) = Sys::FACTS.constraints.get(count) {
        return Err(AnalysisError::DependentCoordinates { constraint: constraint.name });
    }
    let (forces, stiffness) = family.look(guess);
    let row = terms.iter().flat_map(|held| &held.row).fold(0.0, |most: f64, a| most.max(a.value.abs()));
    let size = stiffness.columns(0, N).amax().max(forces.amax()) / row;
    let unit = if size > 0.0 && size.is_finite() { size.log2().round().exp2() } else { 1.0 };
    let multiplier =
        |j: usize| Some(terms[j].multiplier.value / unit).filter(|x| x.is_finite()).unwrap_or(0.0);
    let whole = |of: &DVector<f64>, multiplier: &dyn Fn(usize) -> f64| {
        DVector::from_fn(N + count + 1, |i, _| match i {
            _ if i < N => of[i],
            _ if i < N + count => multiplier(i - N),
            _ => of[N],
        })
    };
    let start = whole(guess, &multiplier);
    let direction = whole(towards, &|_| 0.0);
    let mut equations = HeldFamily { family, count, unit, units: DVector::repeat(N + count, 1.0) };
    equations.units = sizes(&equations, &start, &(&direction * path.step));
    let curve = Curve { equations: &equations };
    // Multipliers change with the coordinates along a given direction.
    let along = |z: &DVector<f64>| {
        let jacobian = equations.look(z).1;
        let forces = jacobian.columns(N, count).into_owned();
        let cut = N as f64 * f64::EPSILON * forces.norm();
        let rates = smallest_solution(forces, &-(&jacobian * &direction), cut)?;
        Ok(whole(towards, &|j| rates[j]).normalize())
    };
    let found = begun(&curve, start, &direction, heading, path, along)?;
    Ok(without_multipliers(found, N))
}

/// The curve in (q, μ).
fn without_multipliers(mut branch: Branch, n: usize) -> Branch {
    for point in &mut branch.points {
        point.q = point.q.rows(0, n).into_owned();
    }
    let direction = |x: &DVector<f64>| {
        DVector::from_fn(n + 1, |i, _| if i < n { x[i] } else { x[x.len() - 1] }).normalize()
    };
    for found in &mut branch.bifurcations {
        found.q = found.q.rows(0, n).into_owned();
        found.direction = direction(&found.direction);
        let mut kernel: Vec<DVector<f64>> = Vec::new();
        for x in found.kernel.iter().map(direction) {
            let rest = kernel.iter().fold(x.clone(), |rest, known| rest - known * known.dot(&x));
            kernel.push(rest.normalize());
        }
        found.kernel = kernel;
    }
    branch
}

impl<F: Fn(Dual<f64>) -> Sys, Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize> Family<'_, F, Sys, N> {
    /// The terms of the constraints, with their slopes by the parameter.
    fn terms(&self, z: &DVector<f64>) -> Vec<ConstraintTerms<Dual<f64>, N>> {
        let (system, q) = self.at(z, |i| f64::from(i == N));
        let mut all = Vec::new();
        let still = q.map(|_| Dual::constant(0.0));
        system.constraint_terms(&State { t: Dual::constant(0.0), q, qd: still }, |terms| all.push(terms));
        all
    }
}

/// The systems of a family, as equations of a curve in (q, λ, μ).
struct HeldFamily<'a, F, Sys, const N: usize> {
    family: Family<'a, F, Sys, N>,
    /// Number of constraints.
    count: usize,
    /// Unit of the multipliers, in which their forces are of the size of others.
    unit: f64,
    /// Sizes of the generalized forces and of the constraints.
    units: DVector<f64>,
}

impl<F: Fn(Dual<f64>) -> Sys, Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize>
    HeldFamily<'_, F, Sys, N>
{
    /// Coordinates and parameter.
    fn plain(&self, z: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(N + 1, |i, _| if i < N { z[i] } else { z[N + self.count] })
    }

    /// M, C and K of all coordinates at z, and the constraints.
    fn matrices(&self, z: &DVector<f64>) -> Result<([DMatrix<f64>; 3], Vec<Held>), AnalysisError> {
        let (system, at) = self.family.at_rest(&self.plain(z));
        let mut all = Held::all(&system, &at)?;
        all.iter_mut().enumerate().for_each(|(j, held)| held.multiplier = z[N + j] * self.unit);
        let [_, m, c, k] = linearized(&system, &at);
        let k = k - stiffness_of_forces(&all, N);
        Ok(([m, c, k], all))
    }

    /// Small motions in minimal coordinates.
    fn direct(&self, z: &DVector<f64>) -> Result<SmallMotion, AnalysisError> {
        let ([m, c, k], all) = self.matrices(z)?;
        let units = units(&m);
        let space = TangentSpace::new(&all, &units, &classes(&all, &k, &units, &|_| false))?;
        space.small(&space.projected([&m, &c, &k]), &coordinate_names::<Sys, N>())
    }
}

impl<F: Fn(Dual<f64>) -> Sys, Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize> Equations
    for HeldFamily<'_, F, Sys, N>
{
    fn look(&self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let (plain, last) = (self.plain(z), N + self.count);
        let (forces, stiffness) = self.family.look(&plain);
        let mut rest = DVector::zeros(last);
        let mut jacobian = DMatrix::zeros(last, last + 1);
        rest.rows_mut(0, N).copy_from(&forces);
        jacobian.view_mut((0, 0), (N, N)).copy_from(&stiffness.columns(0, N));
        jacobian.view_mut((0, last), (N, 1)).copy_from(&stiffness.columns(N, 1));
        for (j, held) in self.family.terms(&plain).iter().enumerate() {
            let (place, multiplier) = (N + j, z[N + j] * self.unit);
            rest[place] = held.value.value;
            jacobian[(place, last)] = held.value.slope;
            for i in 0..N {
                rest[i] -= multiplier * held.row[i].value;
                jacobian[(i, last)] -= multiplier * held.row[i].slope;
                jacobian[(i, place)] = -self.unit * held.row[i].value;
                jacobian[(place, i)] = held.row[i].value;
                for k in 0..N {
                    jacobian[(i, k)] -= multiplier * held.row_by_coordinates[(i, k)].value;
                }
            }
        }
        for i in 0..last {
            rest[i] /= self.units[i];
            jacobian.row_mut(i).unscale_mut(self.units[i]);
        }
        (rest, jacobian)
    }

    /// Differences of fourth order, with which Newton's method converges.
    fn curvature(&self, z: &DVector<f64>, psi: &DVector<f64>) -> DMatrix<f64> {
        let n = z.len();
        let column = |k: usize| {
            let h = 1e-3 * (1.0 + z[k].abs());
            let at = |s: f64| {
                let mut z = z.clone();
                z[k] += s * h;
                self.look(&z).1.transpose() * psi
            };
            ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h)
        };
        let columns: Vec<DVector<f64>> = (0..n).map(column).collect();
        let curvature = DMatrix::from_columns(&columns);
        0.5 * (&curvature + curvature.transpose())
    }

    fn small(&self, z: &DVector<f64>) -> Result<SmallMotion, AnalysisError> {
        let rounded =
            DVector::from_fn(z.len(), |i, _| if i < N { z[i] * (1.0 + 4.0 * f64::EPSILON) } else { z[i] });
        let small = with_rounding(self.direct(z)?, self.direct(&rounded).ok());
        Ok(small.conservative(conservative::<Sys, N>()))
    }

    fn negative(&self, z: &DVector<f64>, _: &DMatrix<f64>) -> Result<usize, AnalysisError> {
        let ([m, c, k], all) = self.matrices(z)?;
        let units = units(&m);
        let space = TangentSpace::new(&all, &units, &[ACTS; N])?;
        let [m, _, k] = space.projected([&m, &c, &k]).terms;
        let roots = m.diagonal().map(f64::sqrt);
        negative(&DMatrix::from_fn(k.nrows(), k.nrows(), |i, j| k[(i, j)] / (roots[i] * roots[j])))
    }

    fn stability(&self, z: &DVector<f64>, small: &SmallMotion) -> Result<Stability, AnalysisError> {
        // Damping of all motions, admissible here or not: it is that of admissible ones elsewhere.
        let ([_, c, _], _) = self.matrices(z)?;
        let linear_damping = Sys::FACTS.linear_damping && !least_is_negative(&c)?;
        small.stability(&Facts { linear_damping, linear: false, ..Sys::FACTS })
    }

    fn nearly_dependent(&self, z: &DVector<f64>) -> Option<AnalysisError> {
        let (system, at) = self.family.at_rest(&self.plain(z));
        let (here, far) = (Held::all(&system, &at).ok()?, far(&system, &at).ok()?);
        let units = units(&dynamic(&system.inertia(&at.q, &at.qd, at.t).map(|x| x.value)));
        nearly_dependent(&here, &far, &units, SINGULAR)
    }

    fn oriented_alike(&self, one: &DVector<f64>, other: &DVector<f64>) -> bool {
        let rows = |z: &DVector<f64>| {
            let terms = self.family.terms(&self.plain(z));
            DMatrix::from_fn(self.count, N, |j, i| terms[j].row[i].value)
        };
        (rows(one) * rows(other).transpose()).determinant() >= 0.0
    }

    fn switching(&self, z: &DVector<f64>) -> Vec<f64> {
        self.family.switching(&self.plain(z))
    }

    fn turned(&self, z: &DVector<f64>, direction: &DVector<f64>) -> Option<[DVector<f64>; 2]> {
        self.family.turned(z, direction)
    }

    fn smooth(&self, z: &DVector<f64>) -> Result<(), AnalysisError> {
        self.family.smooth(&self.plain(z))
    }
}
