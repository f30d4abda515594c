//! Normal modes of `M δq̈ + K δq = 0`.

use super::quadratic::ROUNDING;
use super::{AnalysisError, SmallMotion, pencil};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::fmt;

/// Natural frequencies and mode shapes of a conservative system, in increasing order of ω² (Beatty 2006, section
/// 11.13.2, (11.89)–(11.91)).
///
/// Shapes are stored with `φₖᵀ M φₖ = 1` and their largest entry positive, so that `δq = Σ φₖ ξₖ` and `ξₖ = φₖᵀ M δq`
/// turn the equations of motion into `ξ̈ₖ + ωₖ² ξₖ = 0`. Shapes of equal frequencies are M-orthogonal, and chosen as
/// near to the axes of the coordinates as there are.
///
/// Methods that take the index k of a mode, or of a coordinate, panic, as slices do, where there is none.
///
/// The eigenvectors are nalgebra's; from these the frequencies are computed anew in double-double arithmetic, as
/// Rayleigh quotients after rotations of those pairs that are not yet separate. Small frequencies are as accurate
/// relative to themselves as large ones, which in the same units they may differ from by more than 1e16.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    omega2: Vec<f64>,
    /// Changes of ω² that errors of the matrices make.
    errors: Vec<f64>,
    shapes: DMatrix<f64>,
    /// `M φₖ`, by columns.
    weighted: DMatrix<f64>,
    names: Vec<String>,
}

/// Kind of motion of a normal coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeKind {
    /// ω² > 0: it oscillates.
    Vibration,
    /// ω² = 0 but for errors of the entries of M and K (8 units of 2⁻⁵², and their change by a rounding of the state):
    /// it drifts with constant velocity, as a rigid body does.
    Rigid,
    /// ω² < 0: it grows exponentially.
    Unstable,
}

pub(super) fn modes(small: &SmallMotion) -> Result<Modes, AnalysisError> {
    let n = small.dimension();
    let reduced = small.reduced(small.stiffness());
    let reduced = 0.5 * (&reduced + reduced.transpose());
    if reduced.iter().any(|x| !x.is_finite()) {
        return Err(AnalysisError::NotFinite);
    }
    let largest = reduced.amax();
    let eigen = SymmetricEigen::try_new(reduced, f64::EPSILON, 1000 * n)
        .ok_or(AnalysisError::NotConverged { what: "the eigenvalues of K against M", residual: largest })?;
    let shapes = DMatrix::from_columns(
        &eigen.eigenvectors.column_iter().map(|x| small.restored(&x.into_owned())).collect::<Vec<_>>(),
    );
    let (omega2, shapes) = pencil::diagonalized(small.stiffness(), small.inertia(), &shapes)?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| omega2[a].total_cmp(&omega2[b]));
    let mut omega2: Vec<f64> = order.iter().map(|&k| omega2[k]).collect();
    let mut shapes = shapes.select_columns(&order);
    let [inertia_blur, _, stiffness_blur] = small.blur();
    let known = |a: &DMatrix<f64>, blur: &DMatrix<f64>| a.abs() * ROUNDING + blur;
    let (stiffness, inertia) =
        (known(small.stiffness(), stiffness_blur), known(small.inertia(), inertia_blur));
    let error = |k: usize| {
        let x = shapes.column(k).abs();
        x.dot(&(&stiffness * &x)) + omega2[k].abs() * x.dot(&(&inertia * &x))
    };
    let errors: Vec<f64> = (0..n).map(error).collect();
    let mut first = 0;
    for k in 1..=n {
        if k == n || omega2[k] - omega2[k - 1] > 8.0 * (errors[k] + errors[k - 1]) {
            align(&mut shapes, small, first, k);
            first = k;
        }
    }
    for k in 0..n {
        let shape = shapes.column(k).into_owned();
        if shape[leading(&shape)] < 0.0 {
            shapes.set_column(k, &-shape);
        }
    }
    omega2.iter_mut().zip(&errors).filter(|(x, error)| x.abs() <= **error).for_each(|(x, _)| *x = 0.0);
    Ok(Modes { omega2, errors, weighted: small.inertia() * &shapes, shapes, names: small.names().to_vec() })
}

/// Turns the shapes `from..to` of one eigenvalue within the space that they span: each in turn becomes
/// the projection of the coordinate axis that lies nearest to the rest of the space.
fn align(shapes: &mut DMatrix<f64>, small: &SmallMotion, from: usize, to: usize) {
    if to - from < 2 {
        return;
    }
    let n = shapes.nrows();
    // In the coordinates Lᵀδq shapes are orthonormal, and axis i of the coordinates δq is column i of Lᵀ.
    let axes = small.lower().transpose();
    let space = &axes * shapes.columns(from, to - from);
    let mut left = &space * (space.transpose() * &axes);
    let size: Vec<f64> = (0..n).map(|i| axes.column(i).norm()).collect();
    let mut found = Vec::new();
    for k in from..to {
        let nearness = |i: usize| left.column(i).norm() / size[i];
        let best = (0..n).filter(|i| !found.contains(i)).fold(None, |best: Option<usize>, i| match best {
            Some(b) if nearness(i) <= nearness(b) * (1.0 + 1e-9) => Some(b),
            _ => Some(i),
        });
        let Some(best) = best else { return };
        found.push(best);
        let axis = left.column(best).normalize();
        // What is left of the space is orthogonal to it.
        let along = axis.transpose() * &left;
        left -= &axis * along;
        shapes.set_column(k, &small.restored(&axis));
    }
}

/// Index of the largest entry; of those that are equal but for rounding, the first.
fn leading(x: &DVector<f64>) -> usize {
    let largest = x.amax();
    x.iter().position(|x| x.abs() >= largest * (1.0 - 1e-9)).unwrap_or(0)
}

impl Modes {
    /// The number of modes, which is the number of coordinates.
    pub fn len(&self) -> usize {
        self.omega2.len()
    }

    /// Returns whether there is none.
    pub fn is_empty(&self) -> bool {
        self.omega2.is_empty()
    }

    /// Squares ωₖ² of the natural frequencies, in (rad/s)² and increasing order; negative where the equilibrium is
    /// unstable.
    pub fn squares(&self) -> &[f64] {
        &self.omega2
    }

    /// Natural angular frequency ωₖ, in rad/s: 0 of a rigid mode, NaN of an unstable one.
    pub fn frequency(&self, k: usize) -> f64 {
        self.omega2[k].sqrt()
    }

    /// Kind of motion of mode k.
    pub fn kind(&self, k: usize) -> ModeKind {
        match self.omega2[k] {
            x if x > 0.0 => ModeKind::Vibration,
            x if x < 0.0 => ModeKind::Unstable,
            _ => ModeKind::Rigid,
        }
    }

    /// Change of ωₖ, or of the rate of growth, that errors of the matrices make.
    pub(super) fn error(&self, k: usize) -> f64 {
        let (size, error) = (self.omega2[k].abs(), self.errors[k]);
        if size == 0.0 { error.sqrt() } else { error / (size.sqrt() + (size + error).sqrt()) }
    }

    /// φₖ, mass-normalised (`φₖᵀ M φₖ = 1`), with an entry for each coordinate.
    pub fn normalized(&self, k: usize) -> DVector<f64> {
        self.shapes.column(k).into_owned()
    }

    /// φₖ with 1 as its largest entry, in the units of the coordinates.
    pub fn shape(&self, k: usize) -> DVector<f64> {
        let shape = self.normalized(k);
        let largest = shape[leading(&shape)];
        shape / largest
    }

    /// `φ[i] / φ[j]` of the coordinates i and j in mode k, in the unit of qᵢ over the unit of qⱼ.
    pub fn amplitude_ratio(&self, k: usize, i: usize, j: usize) -> f64 {
        self.shapes[(i, k)] / self.shapes[(j, k)]
    }

    /// Normal coordinates `ξₖ = φₖᵀ M δq` of a deviation, one for each mode; the same of velocities. ξ has the unit of
    /// q times the root of that of M (m kg^½).
    ///
    /// # Errors
    /// [`AnalysisError::Dimension`].
    pub fn normal(&self, deviation: &DVector<f64>) -> Result<DVector<f64>, AnalysisError> {
        self.fits(deviation)?;
        Ok(self.weighted.tr_mul(deviation))
    }

    /// The deviation `δq = Σ φₖ ξₖ` with these normal coordinates, one for each mode: a component for each coordinate,
    /// in its unit.
    ///
    /// # Errors
    /// [`AnalysisError::Dimension`].
    pub fn deviation(&self, normal: &DVector<f64>) -> Result<DVector<f64>, AnalysisError> {
        self.fits(normal)?;
        Ok(&self.shapes * normal)
    }

    /// The free motion: δq at the time t after the deviation δq₀ with the velocity δq̇₀, all three with an entry for
    /// each coordinate. Each mode is in closed form. For methods, events and samples integrate a
    /// [`LinearModel`](super::LinearModel) with [`MatrixExponential`](crate::MatrixExponential), which needs no modes.
    ///
    /// # Errors
    /// [`AnalysisError::Dimension`].
    pub fn free_motion(
        &self,
        deviation: &DVector<f64>,
        velocity: &DVector<f64>,
        t: f64,
    ) -> Result<DVector<f64>, AnalysisError> {
        let (x, v) = (self.normal(deviation)?, self.normal(velocity)?);
        let normal = DVector::from_fn(self.len(), |k, _| {
            let rate = self.omega2[k].abs().sqrt();
            match self.kind(k) {
                ModeKind::Vibration => x[k] * (rate * t).cos() + v[k] / rate * (rate * t).sin(),
                ModeKind::Rigid => x[k] + v[k] * t,
                ModeKind::Unstable => x[k] * (rate * t).cosh() + v[k] / rate * (rate * t).sinh(),
            }
        });
        self.deviation(&normal)
    }

    fn fits(&self, x: &DVector<f64>) -> Result<(), AnalysisError> {
        match x.len() == self.len() {
            true => Ok(()),
            false => Err(AnalysisError::Dimension { expected: self.len(), found: x.len() }),
        }
    }
}

/// A table: frequency, kind, and the shape by the names of the coordinates.
impl fmt::Display for Modes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for k in 0..self.len() {
            match self.kind(k) {
                ModeKind::Vibration => write!(f, "ω = {:<12.6}", self.frequency(k))?,
                ModeKind::Rigid => write!(f, "rigid           ")?,
                ModeKind::Unstable => write!(f, "grows, {:<9.6}", (-self.omega2[k]).sqrt())?,
            }
            for (name, x) in self.names.iter().zip(self.shape(k).iter()) {
                write!(f, "  {name}: {x:+.6}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
