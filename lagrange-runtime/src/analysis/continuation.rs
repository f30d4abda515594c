//! Continuation of equilibria, which move, meet and branch when a parameter changes.
//!
//! Solutions z = (q, μ) of `F(q, μ) = b − f = 0` form curves, which are followed by pseudo-arclength: a step along
//! the tangent, then Newton's method in the plane across it (Keller 1977; Govaerts, *Numerical Methods for
//! Bifurcations of Dynamical Equilibria*, 2000, ch. 4). A curve may turn back (fold), or others may cross it (branch
//! points); both are located to rounding.

mod bifurcation;
mod branch;
mod curve;
mod held;
mod path;

use super::hypotheses::{autonomous, coordinate_names, second_order};
use super::switch::{linearized, smooth, switching};
use super::{AnalysisError, SmallMotion, Stability};
use crate::attitude::{self, steps};
use crate::scalar::Dual;
use crate::state::State;
use crate::system::Linearize;
use core::marker::PhantomData;
use curve::{Curve, Equations, flat, negative};
use nalgebra::{DMatrix, DVector, SVector};
use path::followed;

pub use branch::{Bifurcation, BifurcationKind, Branch, BranchPoint, Heading, Path};

/// The curve of equilibria through the one near `q` at `parameter`. `family` makes the system from its parameter,
/// over duals, so that the derivatives by the parameter are exact.
///
/// ```
/// use lagrange_runtime::analysis::{BifurcationKind, Heading, Path, follow};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A bead in a tube bent to a circle that spins about its vertical diameter.
///     system Bead {
///         param a, omega, g = 9.81;
///         coord theta;
///         T = 0.5 * a.powi(2) * (dot(theta).powi(2) + (omega * sin(theta)).powi(2));
///         V = -g * a * cos(theta);
///     }
/// }
/// let bead = |omega: Dual<f64>| Bead { omega, ..Bead::new(0.5, 0.0).map(Dual::constant) };
/// let path = Path { range: (0.0, 8.0), step: 0.1, steps: 1000 };
/// let bottom = follow(&bead, &[0.0], 1.0, &Heading::Up, &path)?;
/// let pitchfork = &bottom.bifurcations[0];
/// assert_eq!(pitchfork.kind, BifurcationKind::Pitchfork);
/// assert!((pitchfork.parameter - (9.81f64 / 0.5).sqrt()).abs() < 1e-12, "ω² = g/a");
/// let aside = Heading::Along(pitchfork.direction.clone());
/// let up = follow(&bead, &[0.0], pitchfork.parameter, &aside, &path)?;
/// assert!(up.points.iter().skip(1).all(|p| p.negative == 0), "the bead rides stably aside");
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
///
/// Steps are halved until the curve bends little in each, until what its signs say at both ends and in the middle (the
/// parameter's part of the tangent, the determinant, the negative eigenvalues of K) is explained by one bifurcation,
/// and until that fulfils its own equations to rounding. Near an imperfect pitchfork they thus become short enough to
/// distinguish its curves. A bifurcation within 1e-8 (1 + |z|) of the start, and within a millionth of [`Path::step`],
/// is taken for the one that the curve starts at, and is not listed. Coordinates and μ are compared with `1 + |q|` and
/// with [`Path::step`]: give them in units in which they are of order 1. Two bifurcations of opposite effect that are
/// both within a thousandth of [`Path::step`] may be missed.
///
/// # Hypotheses
/// - Constraints are on positions and independent of each other: otherwise
///   [`AnalysisError::DependentCoordinates`]. A curve goes over a position in which they are dependent and lists it, as
///   [`BifurcationKind::DependentConstraints`], or ends there in [`AnalysisError::DependentConstraints`]; where a
///   multiplier grows without bound before it, in ever shorter steps, by [`Path::steps`].
///   Lengths are those in (q, λ, μ) then, with multipliers in units in which their forces are of the size of others.
/// - The equations are autonomous, by [`Facts::autonomous`](crate::Facts::autonomous).
/// - There is an equilibrium near `q` at `parameter`, and F is finite along the curve.
/// - M is positive definite along the curve.
/// - No point of the curve is on a switch of the forces at which their derivatives jump.
/// - Flutter that begins and ends within one step is not seen.
/// - What curves do exceeds rounding: imperfections above some 1e-13 of the forces, and quadratic terms above 1e-12
///   of the cubic ones, by which a transcritical branch point differs from a pitchfork. A curve that is lost to
///   rounding ends in [`AnalysisError::Unresolved`].
///
/// Steps begin with the shorter parameters of an attitude, as those of a run do: from one point to the next they may
/// jump, while the attitude does not.
///
/// K need not be symmetric and damping may have either sign: see [`BranchPoint::stability`] and
/// [`BifurcationKind::Flutter`]. Equilibria may lie in a surface because of a symmetry: the curve is followed across
/// the other directions.
///
/// # Errors
/// [`AnalysisError::DependentCoordinates`]; [`AnalysisError::TimeDependent`]; [`AnalysisError::NotConverged`] where
/// there is no equilibrium near the start; [`AnalysisError::Unbalanced`] where a force is left there that no
/// displacement changes; [`AnalysisError::Unresolved`] where the curve is lost; [`AnalysisError::NotFinite`];
/// [`AnalysisError::Inertia`]; [`AnalysisError::Switch`], [`AnalysisError::Kink`]. [`AnalysisError::NotApplicable`] for
/// a path without length, [`AnalysisError::Dimension`] for a direction of another length.
pub fn follow<Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize>(
    family: &impl Fn(Dual<f64>) -> Sys,
    q: &[f64; N],
    parameter: f64,
    heading: &Heading,
    path: &Path,
) -> Result<Branch, AnalysisError> {
    second_order::<Sys, N>()?;
    held::admissible::<Sys, N>()?;
    autonomous::<Sys, N>()?;
    if !(path.step > 0.0 && path.step.is_finite() && path.range.0 < path.range.1) {
        return Err(AnalysisError::NotApplicable {
            needs: "a positive and finite step and an increasing range",
        });
    }
    if !(path.range.0..=path.range.1).contains(&parameter) {
        return Err(AnalysisError::NotApplicable { needs: "a start within the range" });
    }
    let upward = DVector::from_fn(N + 1, |i, _| f64::from(i == N));
    let towards = match heading {
        Heading::Along(direction) if direction.len() != N + 1 => {
            return Err(AnalysisError::Dimension { expected: N + 1, found: direction.len() });
        }
        Heading::Along(direction) if !(direction.norm() > 0.0 && direction.norm().is_finite()) => {
            return Err(AnalysisError::NotApplicable { needs: "a heading that is finite and not 0" });
        }
        Heading::Along(direction) => direction.normalize(),
        _ => upward,
    };
    let guess = DVector::from_fn(N + 1, |i, _| if i < N { q[i] } else { parameter });
    let mut family = Family::<_, Sys, N> { member: family, units: DVector::repeat(N, 1.0), of: PhantomData };
    if !Sys::FACTS.constraints.is_empty() {
        return held::follow(family, &guess, &towards, heading, path);
    }
    family.units = sizes(&family, &guess, &(&towards * path.step));
    let curve = Curve { equations: &family };
    begun(&curve, guess, &towards, heading, path, |_| Ok(towards.clone()))
}

/// The curve from a guess. `along`: the tangent at the start, where it is given.
fn begun(
    curve: &Curve,
    guess: DVector<f64>,
    towards: &DVector<f64>,
    heading: &Heading,
    path: &Path,
    along: impl Fn(&DVector<f64>) -> Result<DVector<f64>, AnalysisError>,
) -> Result<Branch, AnalysisError> {
    let free = DMatrix::zeros(guess.len(), 0);
    let mut start = curve.place(curve.corrected(guess, towards, &free)?, towards)?;
    curve.balanced(&start.z).or_else(|error| {
        curve.equations.smooth(&start.z)?;
        Err(error)
    })?;
    match heading {
        // At a branch point this direction is one of several tangents.
        Heading::Along(_) => start.tangent = along(&start.z)?,
        _ if matches!(heading, Heading::Down) == (start.turn() >= 0.0) => {
            start = curve.place(start.z, &-start.tangent)?;
        }
        _ => {}
    }
    followed(curve, start, path)
}

/// Largest derivatives of each component of F at z and beside it: at a branch point they may all vanish.
fn sizes(equations: &dyn Equations, z: &DVector<f64>, beside: &DVector<f64>) -> DVector<f64> {
    let n = z.len() - 1;
    let mut sizes = DVector::<f64>::zeros(n);
    for z in [z.clone(), z + beside, z - beside] {
        let rows = equations.look(&z).1;
        let size = |i: usize| Some(rows.row(i).amax()).filter(|x| x.is_finite()).unwrap_or(0.0);
        sizes = DVector::from_fn(n, |i, _| sizes[i].max(size(i)));
    }
    let largest = if sizes.amax() > 0.0 { sizes.amax() } else { 1.0 };
    // Rows that vanish but for rounding, as those of ignorable coordinates, have no size of their own.
    sizes.map(|size| if size > flat(n + 1) * largest { size } else { largest })
}

/// The systems of a family, as equations of a curve.
struct Family<'a, F, Sys, const N: usize> {
    member: &'a F,
    /// Sizes of the generalized forces, so that stiff coordinates do not hide soft ones.
    units: DVector<f64>,
    of: PhantomData<fn() -> Sys>,
}

impl<F: Fn(Dual<f64>) -> Sys, Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize> Family<'_, F, Sys, N> {
    /// The system at z, coordinates and parameter with the slopes `along`.
    fn at(&self, z: &DVector<f64>, along: impl Fn(usize) -> f64) -> (Sys, SVector<Dual<f64>, N>) {
        let dual = |i: usize| Dual { value: z[i], slope: along(i) };
        ((self.member)(dual(N)), SVector::from_fn(|i, _| dual(i)))
    }

    /// The system at z, and its state.
    fn at_rest(&self, z: &DVector<f64>) -> (Sys, State<Dual<f64>, N>) {
        let (system, q) = self.at(z, |_| 0.0);
        let zero = Dual::constant(0.0);
        (system, State { t: zero, q, qd: SVector::from([zero; N]) })
    }
}

impl<F: Fn(Dual<f64>) -> Sys, Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize> Equations
    for Family<'_, F, Sys, N>
{
    fn look(&self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let (system, q) = self.at(z, |i| f64::from(i == N));
        let (still, t) = (q.map(|_| Dual::constant(0.0)), Dual::constant(0.0));
        let rest = system.convective_momentum_rate(&q, &still, t) - system.momentum_rate(&q, &still, t);
        let stiffness = system.linearize(&q, &still, t).stiffness;
        let entry = |i, j| if j < N { stiffness[(i, j)].value } else { rest[i].slope };
        let jacobian = DMatrix::from_fn(N, N + 1, |i, j| entry(i, j) / self.units[i]);
        (DVector::from_fn(N, |i, _| rest[i].value / self.units[i]), jacobian)
    }

    fn curvature(&self, z: &DVector<f64>, psi: &DVector<f64>) -> DMatrix<f64> {
        let mut curvature = DMatrix::zeros(N + 1, N + 1);
        for k in 0..=N {
            let (system, q) = self.at(z, |i| f64::from(i == k));
            let (still, t) = (q.map(|_| Dual::constant(0.0)), Dual::constant(0.0));
            let stiffness = system.linearize(&q, &still, t).stiffness;
            for j in 0..N {
                curvature[(j, k)] = (0..N).map(|i| stiffness[(i, j)].slope / self.units[i] * psi[i]).sum();
            }
        }
        for j in 0..N {
            curvature[(N, j)] = curvature[(j, N)];
        }
        // Of the parameter there are first derivatives alone; Newton's method converges with a difference of these.
        let h = 1e-5 * (1.0 + z[N].abs());
        let [above, below] = [h, -h].map(|h| {
            let mut z = z.clone();
            z[N] += h;
            self.look(&z).1.column(N).dot(psi)
        });
        let difference = (above - below) / (2.0 * h);
        curvature[(N, N)] = if difference.is_finite() { difference } else { 0.0 };
        curvature
    }

    fn small(&self, z: &DVector<f64>) -> Result<SmallMotion, AnalysisError> {
        let matrices = |z: &DVector<f64>| {
            let (system, at) = self.at_rest(z);
            let [_, m, c, k] = linearized(&system, &at);
            [m, c, k]
        };
        // As `next` does it for a state.
        let rounded =
            DVector::from_fn(N + 1, |i, _| if i < N { z[i] * (1.0 + 4.0 * f64::EPSILON) } else { z[i] });
        let [m, c, k] = matrices(z);
        let small = SmallMotion::named(m, c, k, coordinate_names::<Sys, N>())?.blurred(matrices(&rounded));
        Ok(small.conservative(Sys::FACTS.conservative))
    }

    fn negative(&self, _: &DVector<f64>, jacobian: &DMatrix<f64>) -> Result<usize, AnalysisError> {
        // Similar to K in these units, and symmetric with K.
        let roots = self.units.map(f64::sqrt);
        negative(&DMatrix::from_fn(N, N, |i, j| jacobian[(i, j)] * roots[i] / roots[j]))
    }

    fn stability(&self, _: &DVector<f64>, small: &SmallMotion) -> Result<Stability, AnalysisError> {
        small.stability(&Sys::FACTS)
    }

    fn switching(&self, z: &DVector<f64>) -> Vec<f64> {
        let (system, at) = self.at_rest(z);
        switching(&system, &at.q)
    }

    fn turned(&self, z: &DVector<f64>, direction: &DVector<f64>) -> Option<[DVector<f64>; 2]> {
        let [q, qd] = [z, direction].map(|x| SVector::from_fn(|i: usize, _| x[i]));
        let at = State::<f64, N> { t: 0.0, q, qd };
        let far: Vec<usize> = steps::beyond(Sys::ATTITUDES, attitude::BOUND, &at).collect();
        let turned = at.turned(far.iter().copied());
        let with = |x: &DVector<f64>, q: &SVector<f64, N>| {
            DVector::from_fn(x.len(), |i, _| if i < N { q[i] } else { x[i] })
        };
        (!far.is_empty()).then(|| [with(z, &turned.q), with(direction, &turned.qd)])
    }

    fn smooth(&self, z: &DVector<f64>) -> Result<(), AnalysisError> {
        let (system, at) = self.at_rest(z);
        smooth(&system, &at, 0.0, linearized)
    }
}
