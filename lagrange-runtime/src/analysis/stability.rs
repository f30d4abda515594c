//! Stability of equilibria and steady motions: which theorem decides, and where none does.

use super::motion::symmetric;
use super::quadratic::ROUNDING;
use super::{AnalysisError, ModeKind, SmallMotion, Spectrum};
use crate::system::Facts;
use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

/// Behaviour of an equilibrium or a steady motion after a disturbance.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Stability {
    /// It stays near.
    Stable,
    /// A displacement along `direction` meets no force of first order, and no small motion grows exponentially: higher
    /// orders decide.
    Neutral {
        /// Shape of that displacement in the coordinates of the small motions, its largest entry 1.
        direction: DVector<f64>,
    },
    /// It leaves along `direction`: without oscillation (divergence) or, where gyroscopic forces and damping act, in
    /// spirals that grow.
    Unstable {
        /// Shape of the displacement whose energy falls fastest, or which grows fastest, in the coordinates of the
        /// small motions, its largest entry 1.
        direction: DVector<f64>,
    },
    /// It leaves in oscillations of growing amplitude, driven by circulatory forces or negative damping, or, in a
    /// conservative system whose gyroscopic forces do not suffice to stabilize a maximum of the energy, by that
    /// energy.
    Flutter {
        /// Eigenvalue with the largest real part: rate of growth in 1/s and angular frequency in rad/s.
        root: Complex<f64>,
        /// Its shape, the largest entry 1.
        shape: DVector<Complex<f64>>,
    },
    /// No theorem on the linearized equations decides.
    Undecided {
        /// Missing hypothesis.
        needs: &'static str,
    },
}

impl Stability {
    /// Returns whether it is [`Stability::Stable`], which is proved; neutral and undecided are not.
    pub fn is_stable(&self) -> bool {
        matches!(self, Stability::Stable)
    }

    /// Returns whether instability is proved.
    pub fn is_unstable(&self) -> bool {
        matches!(self, Stability::Unstable { .. } | Stability::Flutter { .. })
    }
}

/// Least eigenvalue of a symmetric matrix, as a class.
#[derive(Clone, Copy, PartialEq)]
enum Least {
    Positive,
    Zero,
    Negative,
}

impl SmallMotion {
    /// The energy criterion for the equations of small motions, `M δq̈ + (D + G) δq̇ + K δq = 0`, whose energy
    /// `½ δq̇ᵀM δq̇ + ½ δqᵀK δq` falls at the rate `δq̇ᵀD δq̇`.
    ///
    /// | K | D, G | verdict | theorem |
    /// |---|---|---|---|
    /// | positive definite | D ≥ 0, any G | stable | Lagrange and Dirichlet; Thomson and Tait |
    /// | positive semidefinite | D ≥ 0, any G | neutral | the energy bounds growth to powers of t |
    /// | a negative eigenvalue | G = 0 | unstable | Kelvin: `λ²M + λD + K` is singular at some λ > 0 |
    /// | a negative eigenvalue, none zero | D > 0, any G | unstable | Thomson, Tait and Chetaev |
    /// | a negative eigenvalue | otherwise | undecided | gyroscopic forces may stabilize |
    ///
    /// Sources: Chetaev, *The Stability of Motion*, 1961, ch. 5; Merkin, *Introduction to the Theory of Stability*,
    /// 1997, ch. 6; Beatty 2006, section 11.13.2. The verdict on the whole motion is
    /// [`Equilibrium::stability`](super::Equilibrium).
    ///
    /// # Hypotheses
    /// - K is symmetric: forces have a potential to first order.
    /// - The damping matrix D, the symmetric part of C, is positive semidefinite.
    ///
    /// # Errors
    /// [`AnalysisError::Circulatory`] and [`AnalysisError::NegativeDamping`], where the energy need not fall;
    /// [`AnalysisError::NotConverged`].
    pub fn energy_criterion(&self) -> Result<Stability, AnalysisError> {
        let modes = self.modes_of_potential()?;
        let (least, eigenvalue) = least(&self.damping())?;
        if least == Least::Negative {
            return Err(AnalysisError::NegativeDamping { eigenvalue });
        }
        let singular = (0..modes.len()).any(|k| modes.kind(k) == ModeKind::Rigid);
        let direction = modes.shape(0);
        Ok(match modes.kind(0) {
            ModeKind::Vibration => Stability::Stable,
            ModeKind::Rigid => Stability::Neutral { direction },
            ModeKind::Unstable if self.gyroscopic().amax() == 0.0 => Stability::Unstable { direction },
            ModeKind::Unstable if least == Least::Positive && !singular => Stability::Unstable { direction },
            ModeKind::Unstable => Stability::Undecided {
                needs: "damping of every motion, or no gyroscopic forces: these may stabilize a maximum of the energy",
            },
        })
    }

    /// Lyapunov's first approximation: stable, asymptotically, if every eigenvalue has a negative real part; unstable
    /// if one has a positive real part, whatever the terms of higher order are (Lyapunov 1892; Merkin 1997, ch. 4).
    /// Real parts within the bounds of their errors, [`Spectrum::errors`], decide nothing, unless their sum,
    /// `−tr M⁻¹C`, is positive.
    ///
    /// # Hypotheses
    /// - No eigenvalue is on the imaginary axis, but beside one with a positive real part: the verdict is
    ///   [`Stability::Undecided`] otherwise.
    ///
    /// # Errors
    /// Those of [`SmallMotion::spectrum`].
    pub fn first_approximation(&self) -> Result<Stability, AnalysisError> {
        let Spectrum { eigenvalues, errors, shapes } = self.spectrum()?;
        let faster = |a: &usize, b: &usize| {
            let key = |k: usize| (eigenvalues[k].re, eigenvalues[k].im);
            key(*a).partial_cmp(&key(*b)).unwrap_or(std::cmp::Ordering::Equal)
        };
        let driven = self.expands();
        let growing = (0..errors.len()).filter(|&k| driven || eigenvalues[k].re > errors[k].re);
        Ok(match growing.max_by(faster) {
            Some(k) if eigenvalues[k].im == 0.0 => Stability::Unstable { direction: shapes[k].map(|x| x.re) },
            Some(k) => Stability::Flutter { root: eigenvalues[k], shape: shapes[k].clone() },
            None if eigenvalues.iter().zip(&errors).all(|(value, error)| value.re < -error.re) => {
                Stability::Stable
            }
            None => Stability::Undecided {
                needs: "eigenvalues off the imaginary axis, or a system whose energy is proved not to grow",
            },
        })
    }

    /// Returns whether `tr M⁻¹C = tr M⁻¹D` is negative, beyond what errors of the entries make of it: the sum of all
    /// eigenvalues is positive then.
    fn expands(&self) -> bool {
        let (inverse, damping, [m_blur, c_blur, _]) = (self.inverse(), self.damping(), self.blur());
        let size = inverse.abs();
        let c_error = self.velocity_terms().abs() * ROUNDING + c_blur;
        let m_error = self.inertia().abs() * ROUNDING + m_blur;
        let error = size.dot(&symmetric(&c_error)) + (&size * m_error * &size).dot(&damping.abs());
        inverse.dot(&damping) < -error
    }

    /// The root that oscillates and grows fastest, beyond the bounds of its errors; `None` where there is none, or
    /// where theorems say so.
    pub(super) fn growing_oscillation(&self) -> Result<Option<Complex<f64>>, AnalysisError> {
        if self.circulatory().amax() == 0.0 && least(&self.damping())?.0 != Least::Negative {
            let least_stiffness = || least(&self.reduced(self.stiffness()));
            if self.gyroscopic().amax() == 0.0 || least_stiffness()?.0 != Least::Negative {
                return Ok(None);
            }
        }
        let spectrum = self.spectrum()?;
        let roots = spectrum.eigenvalues.iter().zip(&spectrum.errors);
        let growing = roots.filter(|(root, error)| root.re > error.re && root.im > error.im);
        Ok(growing.map(|(root, _)| *root).max_by(|a, b| a.re.total_cmp(&b.re)))
    }

    /// Stability of the nonlinear motion, see [`Equilibrium`](super::Equilibrium).
    pub(super) fn stability(&self, facts: &Facts) -> Result<Stability, AnalysisError> {
        use AnalysisError::{Circulatory, NegativeDamping};
        let energy = match self.energy_criterion() {
            Err(Circulatory { .. } | NegativeDamping { .. }) => None,
            other => Some(other?),
        };
        match energy {
            Some(verdict @ (Stability::Unstable { .. } | Stability::Neutral { .. })) => Ok(verdict),
            // Of other systems the energy may grow by terms of higher order, which only damping of every motion
            // outweighs.
            Some(Stability::Stable)
                if facts.conservative
                    || facts.linear_damping
                    || facts.linear
                    || least(&self.damping())?.0 == Least::Positive =>
            {
                Ok(Stability::Stable)
            }
            _ => self.first_approximation(),
        }
    }
}

/// Returns whether the symmetric part of a matrix has a negative eigenvalue, beyond rounding.
pub(super) fn least_is_negative(a: &DMatrix<f64>) -> Result<bool, AnalysisError> {
    Ok(least(&symmetric(a))?.0 == Least::Negative)
}

/// Sign of the least eigenvalue of a symmetric matrix with the sign of its diagonal scaled to 1, so that the units of
/// coordinates do not matter, and that eigenvalue.
fn least(a: &DMatrix<f64>) -> Result<(Least, f64), AnalysisError> {
    let n = a.nrows();
    let size = |i: usize| match a[(i, i)].abs() {
        0.0 => a.row(i).amax(),
        diagonal => diagonal.sqrt(),
    };
    let scale = DVector::from_fn(n, |i, _| if size(i) > 0.0 { 1.0 / size(i) } else { 1.0 });
    let scaled = symmetric(&DMatrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]));
    let eigen =
        SymmetricEigen::try_new(scaled, f64::EPSILON, 1000 * n.max(1)).ok_or(AnalysisError::NotFinite)?;
    let eigenvalue = eigen.eigenvalues.min();
    let rounding = 64.0 * n as f64 * f64::EPSILON;
    let least = match eigenvalue {
        x if x > rounding => Least::Positive,
        x if x < -rounding => Least::Negative,
        _ => Least::Zero,
    };
    Ok((least, eigenvalue))
}
