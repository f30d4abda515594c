//! The quadratic eigenproblem `(λ²M + λC + K) x = 0` of damped and gyroscopic small motions.

use super::quadratic::{Quadratic, ROUNDING, Root};
use super::{AnalysisError, ModeKind, Modes, SmallMotion};
use core::fmt;
use nalgebra::{Complex, DMatrix, DVector};

/// Eigenvalues λ and shapes x of the motions `δq = Re(x e^{λt})`, `(λ²M + λC + K) x = 0` (Tisseur and Meerbergen, *The
/// quadratic eigenvalue problem*, SIAM Review 43, 2001, section 3.4), by damped frequency |Im λ|, of each conjugate
/// pair the one with Im λ < 0 first. Real parts of λ are in 1/s, imaginary ones in rad/s. Methods that take the index k
/// of an eigenvalue panic, as slices do, where there is none.
///
/// Each eigenvalue is that of the given matrices but for a rounding of its own, slow ones beside fast ones too, and
/// has a bound of what errors of the matrices make of it. Without damping they are those of [`Modes`]; otherwise
/// roots of `det(λ²M + λC + K)` by the Ehrlich–Aberth method in double-double arithmetic (Bini and Noferini, *Linear
/// Algebra Appl.* 439, 2013), zero roots being taken out before (Hammarling, Munro and Tisseur, *ACM Trans. Math.
/// Softw.* 39, 2013).
///
/// An eigenvalue that has fewer shapes than its multiplicity is defective: critical damping, a rigid motion without
/// friction, two frequencies that meet. Its shapes are repeated, and the motion that belongs to a repetition grows by
/// a power of t beside `e^{λt}`.
///
/// # Hypotheses
/// - M is symmetric and positive definite, which [`SmallMotion`] is made with.
/// - Entries of M, C and K are known to 8 units of 2⁻⁵², and those of a system to what four such units of its state
///   make of them. K is singular where it is within these errors: the eigenvalues are 0 then, and their bounds say
///   how far from it they may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The 2n eigenvalues of n coordinates.
    pub eigenvalues: Vec<Complex<f64>>,
    /// Bounds of the errors of their real and imaginary parts that errors of the matrices make, in the same units.
    pub errors: Vec<Complex<f64>>,
    /// Their shapes, each of n entries in the units of the coordinates, the largest one 1.
    pub shapes: Vec<DVector<Complex<f64>>>,
}

impl Spectrum {
    /// Angular frequency `|Im λ|` with damping, in rad/s.
    pub fn damped_frequency(&self, k: usize) -> f64 {
        self.eigenvalues[k].im.abs()
    }

    /// Undamped angular frequency `|λ|`, in rad/s.
    pub fn natural_frequency(&self, k: usize) -> f64 {
        self.eigenvalues[k].norm()
    }

    /// Damping ratio `ζ = −Re λ / |λ|`, dimensionless: 1 is critical or more. 0 where λ = 0.
    pub fn damping_ratio(&self, k: usize) -> f64 {
        let size = self.eigenvalues[k].norm();
        if size == 0.0 { 0.0 } else { -self.eigenvalues[k].re / size }
    }

    /// The positive angular frequencies with damping in increasing order, one for each oscillating pair, in rad/s.
    pub fn frequencies(&self) -> Vec<f64> {
        self.eigenvalues.iter().filter(|e| e.im > 0.0).map(|e| e.im).collect()
    }

    /// Largest real part: the rate at which the worst small motion grows, in 1/s.
    pub fn growth(&self) -> f64 {
        self.eigenvalues.iter().map(|e| e.re).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns whether no small motion grows exponentially, i.e. no real part is above the bound of its error. That is
    /// necessary for stability, and sufficient for damped motions; for undamped ones higher orders may decide.
    pub fn is_stable(&self) -> bool {
        self.eigenvalues.iter().zip(&self.errors).all(|(value, error)| value.re <= error.re)
    }
}

/// A table: each eigenvalue, or pair of conjugate ones, with the bounds of its error, and the damping ratio of pairs.
impl fmt::Display for Spectrum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, (value, error)) in self.eigenvalues.iter().zip(&self.errors).enumerate() {
            let bound = error.re.max(error.im);
            if value.im == 0.0 {
                writeln!(f, "λ = {:+.6e}{:18}error ≤ {bound:.1e}", value.re, "")?;
            } else if value.im > 0.0 {
                // (Without −0.)
                let (re, im, ratio) = (value.re, value.im, self.damping_ratio(k) + 0.0);
                writeln!(f, "λ = {re:+.6e} ± {im:.6e} i  error ≤ {bound:.1e}  ζ = {ratio:+.6}")?;
            }
        }
        Ok(())
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
    if !small.drifting.is_empty() {
        return drifting(small);
    }
    let roots = Quadratic::new(small)?.roots()?;
    let mut spectrum = Spectrum { eigenvalues: Vec::new(), errors: Vec::new(), shapes: Vec::new() };
    for Root { value, error, shape } in roots {
        spectrum.eigenvalues.push(value);
        spectrum.errors.push(error);
        spectrum.shapes.push(shape);
    }
    Ok(spectrum)
}

/// The spectrum with two zero roots of each coordinate whose momentum is constant, and those of the others (Routh;
/// Merkin 1997, 7.2): with `M_jj ż_j + M_jr ż_r + C_jr z_r` constant the others obey quadratic equations of their
/// own.
fn drifting(small: &SmallMotion) -> Result<Spectrum, AnalysisError> {
    let n = small.dimension();
    let drift = &small.drifting[..];
    let rest: Vec<usize> = (0..n).filter(|i| !drift.contains(i)).collect();
    let part =
        |a: &DMatrix<f64>, rows: &[usize], columns: &[usize]| a.select_rows(rows).select_columns(columns);
    let [m, c, k] = [small.inertia(), small.velocity_terms(), small.stiffness()];
    let inverse = part(m, drift, drift).try_inverse().ok_or(AnalysisError::NotFinite)?;
    let size = inverse.abs();
    let mut roots: Vec<(Complex<f64>, Complex<f64>, DVector<Complex<f64>>)> = Vec::new();
    let [_, c_blur, k_blur] = small.blur();
    for &j in drift {
        let (slope, stiffness) = (c_blur[(j, j)], k_blur.row(j).amax().max(k_blur.column(j).amax()));
        let error = slope / m[(j, j)] + (stiffness / m[(j, j)]).sqrt();
        let shape = DVector::from_fn(n, |i, _| Complex::new(f64::from(u8::from(i == j)), 0.0));
        let zero = Complex::new(0.0, 0.0);
        roots.extend([
            (zero, Complex::new(error, error), shape.clone()),
            (zero, Complex::new(error, error), shape),
        ]);
    }
    if !rest.is_empty() {
        // a − b M⁻¹ d, and the error of it.
        let coupling = [m, c].map(|a| (part(a, &rest, drift), part(a, drift, &rest)));
        let blurs = small.blur().each_ref().map(|a| (part(a, &rest, drift), part(a, drift, &rest)));
        let product = |i: usize, j: usize| {
            let (left, right) = (&coupling[i].0, &coupling[j].1);
            let (left_size, right_size) = (left.abs() * &size, &size * right.abs());
            let error = &blurs[i].0 * &right_size
                + &left_size * &blurs[j].1
                + &left_size * right.abs() * (8.0 * ROUNDING);
            (left * &inverse * right, error)
        };
        let own = |a: &DMatrix<f64>, blur: &DMatrix<f64>| (part(a, &rest, &rest), part(blur, &rest, &rest));
        let less = |(a, error): (DMatrix<f64>, DMatrix<f64>), (b, more): (DMatrix<f64>, DMatrix<f64>)| {
            (a - b, error + more)
        };
        let [m_blur, ..] = small.blur();
        let inertia = less(own(m, m_blur), product(0, 0));
        let damping = less(less(own(c, c_blur), product(0, 1)), product(1, 0));
        let stiffness = less(own(k, k_blur), product(1, 1));
        let names = rest.iter().map(|&i| small.names()[i].clone()).collect();
        let others = SmallMotion::named(inertia.0, damping.0, stiffness.0, names)?;
        let others = SmallMotion { blur: [inertia.1, damping.1, stiffness.1], ..others };
        let Spectrum { eigenvalues, errors, shapes } = others.spectrum()?;
        let complex = |a: &DMatrix<f64>| a.map(|x| Complex::new(x, 0.0));
        for ((value, error), shape) in eigenvalues.into_iter().zip(errors).zip(shapes) {
            let momentum = complex(&coupling[0].1) * &shape * value + complex(&coupling[1].1) * &shape;
            let led = complex(&inverse) * momentum * if value.norm() > 0.0 { -value.inv() } else { value };
            let mut whole = DVector::from_element(n, Complex::new(0.0, 0.0));
            rest.iter().zip(&shape).for_each(|(&i, x)| whole[i] = *x);
            drift.iter().zip(&led).for_each(|(&i, x)| whole[i] = *x);
            let largest = whole[whole.icamax()];
            roots.push((value, error, whole / largest));
        }
    }
    roots.sort_by(|a, b| {
        let key = |z: &Complex<f64>| [z.im.abs(), z.re, z.im];
        key(&a.0).partial_cmp(&key(&b.0)).unwrap_or(core::cmp::Ordering::Equal)
    });
    let mut spectrum = Spectrum { eigenvalues: Vec::new(), errors: Vec::new(), shapes: Vec::new() };
    for (value, error, shape) in roots {
        spectrum.eigenvalues.push(value);
        spectrum.errors.push(error);
        spectrum.shapes.push(shape);
    }
    Ok(spectrum)
}
