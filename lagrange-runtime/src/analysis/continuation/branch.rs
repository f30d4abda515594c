//! A curve of equilibria: what is asked for, and what is found.

use crate::analysis::Stability;
use nalgebra::DVector;

/// Range and step size of a curve that is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// The parameter's range, in which the curve is followed, in the unit of the parameter μ.
    pub range: (f64, f64),
    /// Longest step, as a length in (q, μ) together: scale μ so that the features of the curve are of order 1 in it
    /// as in q.
    pub step: f64,
    /// Most steps.
    pub steps: usize,
}

/// A point of a curve: a system with the parameter μ at rest in an equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchPoint {
    /// The parameter.
    pub parameter: f64,
    /// The N coordinates.
    pub q: DVector<f64>,
    /// Number of directions of falling energy, the negative eigenvalues of K; of an unsymmetric K, those with a
    /// negative real part.
    pub negative: usize,
    /// Stability, as of an [`Equilibrium`](crate::analysis::Equilibrium).
    pub stability: Stability,
}

/// Special point of a curve of equilibria.
#[derive(Clone, Debug, PartialEq)]
pub struct Bifurcation {
    /// Its kind.
    pub kind: BifurcationKind,
    /// The parameter.
    pub parameter: f64,
    /// The N coordinates.
    pub q: DVector<f64>,
    /// Direction in (q, μ), N + 1 elements: that of the curve at a fold, the onset of flutter or dependent constraints,
    /// or of the one that crosses it; of a multiple branch point, one of [`kernel`](Self::kernel).
    pub direction: DVector<f64>,
    /// Orthonormal directions in (q, μ) across the curve in which `F` does not change in first order: their number is
    /// the multiplicity of a branch point. Empty at folds, the onset of flutter and dependent constraints.
    pub kernel: Vec<DVector<f64>>,
}

/// Behaviour of a curve of equilibria at a special point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BifurcationKind {
    /// It turns back: two equilibria meet and vanish (saddle-node).
    Fold,
    /// Another curve crosses it, and one of both lies on one side of the critical parameter: of a symmetric system.
    Pitchfork,
    /// Another curve crosses it from one side to the other.
    Transcritical,
    /// Several eigenvalues of K vanish together, as symmetries make them: several curves, or a surface, cross it.
    Multiple,
    /// Another curve crosses it along which the parameter does not change, to rounding, as the buckling of linear
    /// systems; or the curves cannot be distinguished.
    Degenerate,
    /// A pair of complex eigenvalues of the small motions crosses the imaginary axis: oscillations begin to grow, or
    /// cease to (Hopf; flutter of circulatory systems).
    Flutter,
    /// Constraints are dependent, and the mechanism can leave on another branch: other equilibria may begin there. The
    /// curve continues along its own branch.
    DependentConstraints,
}

/// A curve of equilibria.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Its points.
    pub points: Vec<BranchPoint>,
    /// Folds, branch points, onsets of flutter and positions with dependent constraints within the range, in the order
    /// of the steps.
    pub bifurcations: Vec<Bifurcation>,
    /// It ends beyond the border of the range, which the last point may have passed, and not by [`Path::steps`].
    pub complete: bool,
}

/// A direction at the start of a curve.
#[derive(Clone, Debug, PartialEq)]
pub enum Heading {
    /// The parameter grows at first.
    Up,
    /// The parameter falls at first.
    Down,
    /// Along this direction in (q, μ), N + 1 elements of any length: [`Bifurcation::direction`] leads to the other
    /// curve, its negative to the other half.
    Along(DVector<f64>),
}
