//! The quadratic eigenproblem `(λ²M + λC + K) x = 0` of damped and gyroscopic small motions.

use super::quadratic::{Quadratic, Root};
use super::{AnalysisError, ModeKind, Modes, SmallMotion};
use nalgebra::{Complex, DVector};

/// Eigenvalues λ and shapes x of the motions `δq = Re(x e^{λt})`, `(λ²M + λC + K) x = 0` (Tisseur and Meerbergen, *The quadratic eigenvalue
/// problem*, SIAM Review 43, 2001, section 3.4), by natural frequency |Im λ|, of each conjugate pair the one with Im λ < 0
/// first. Methods that take the index k of an eigenvalue panic, as slices do, where there is none.
///
/// Each eigenvalue is that of the given matrices but for a rounding of its own, slow ones beside fast ones too, and has a bound of what errors of
/// the matrices make of it. Without damping they are those of [`Modes`]; otherwise roots of `det(λ²M + λC + K)` by the Ehrlich–Aberth method in
/// double-double arithmetic (Bini and Noferini, *Linear Algebra Appl.* 439, 2013), zero roots being taken out before (Hammarling, Munro and
/// Tisseur, *ACM Trans. Math. Softw.* 39, 2013).
///
/// An eigenvalue that has fewer shapes than its multiplicity is defective: critical damping, a rigid motion without friction, two
/// frequencies that meet. Its shapes are repeated, and the motion that belongs to a repetition grows by a power of t beside `e^{λt}`.
///
/// # Hypotheses
/// - M is symmetric and positive definite, which [`SmallMotion`] is made with.
/// - Entries of M, C and K are known to 8 units of 2⁻⁵², and those of a system to what four such units of its state make of them. K is singular
///   where it is within these errors: the eigenvalues are 0 then, and their bounds say how far from it they may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The 2n eigenvalues.
    pub eigenvalues: Vec<Complex<f64>>,
    /// Bounds of the errors of their real and imaginary parts that errors of the matrices make.
    pub errors: Vec<Complex<f64>>,
    /// Their shapes, the largest entry 1.
    pub shapes: Vec<DVector<Complex<f64>>>,
}

impl Spectrum {
    /// Angular frequency `|Im λ|` with damping.
    pub fn damped_frequency(&self, k: usize) -> f64 {
        self.eigenvalues[k].im.abs()
    }

    /// Undamped angular frequency `|λ|`.
    pub fn natural_frequency(&self, k: usize) -> f64 {
        self.eigenvalues[k].norm()
    }

    /// Damping ratio `ζ = −Re λ / |λ|`: 1 is critical or more. 0 where λ = 0.
    pub fn damping_ratio(&self, k: usize) -> f64 {
        let size = self.eigenvalues[k].norm();
        if size == 0.0 { 0.0 } else { -self.eigenvalues[k].re / size }
    }

    /// The positive angular frequencies in increasing order, one for each oscillating pair.
    pub fn frequencies(&self) -> Vec<f64> {
        self.eigenvalues.iter().filter(|e| e.im > 0.0).map(|e| e.im).collect()
    }

    /// Largest real part: the rate at which the worst small motion grows.
    pub fn growth(&self) -> f64 {
        self.eigenvalues.iter().map(|e| e.re).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns whether no small motion grows exponentially, i.e. no real part is above the bound of its error. That is
    /// necessary for stability, and sufficient for damped motions; for undamped ones higher orders may decide.
    pub fn is_stable(&self) -> bool {
        self.eigenvalues.iter().zip(&self.errors).all(|(value, error)| value.re <= error.re)
    }
}

/// `λ = ± i ω` of a system without damping, or ± the rates of growth.
pub(super) fn undamped(modes: &Modes) -> Spectrum {
    let mut spectrum = Spectrum { eigenvalues: Vec::new(), errors: Vec::new(), shapes: Vec::new() };
    for k in 0..modes.len() {
        let (rate, error) = (modes.squares()[k].abs().sqrt(), modes.error(k));
        let complex = |re: f64, im: f64| Complex::new(re, im);
        let (values, error) = match modes.kind(k) {
            ModeKind::Unstable => ([complex(-rate, 0.0), complex(rate, 0.0)], complex(error, 0.0)),
            ModeKind::Vibration => ([complex(0.0, -rate), complex(0.0, rate)], complex(0.0, error)),
            ModeKind::Rigid => ([complex(0.0, 0.0); 2], complex(error, error)),
        };
        for value in values {
            spectrum.eigenvalues.push(value);
            spectrum.errors.push(error);
            spectrum.shapes.push(modes.shape(k).map(|x| complex(x, 0.0)));
        }
    }
    spectrum
}

pub(super) fn spectrum(small: &SmallMotion) -> Result<Spectrum, AnalysisError> {
    let roots = Quadratic::new(small)?.roots()?;
    let mut spectrum = Spectrum { eigenvalues: Vec::new(), errors: Vec::new(), shapes: Vec::new() };
    for Root { value, error, shape } in roots {
        spectrum.eigenvalues.push(value);
        spectrum.errors.push(error);
        spectrum.shapes.push(shape);
    }
    Ok(spectrum)
}
