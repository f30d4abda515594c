//! The quadratic eigenproblem `(λ²M + λC + K) x = 0` of damped and gyroscopic small motions.

use super::eigen::eigenvalues;
use super::{AnalysisError, ModeKind, Modes, SmallMotion};
use nalgebra::{Complex, DMatrix, DVector};

/// Eigenvalues λ and shapes x of the motions `δq = Re(x e^{λt})` (Tisseur and Meerbergen, *The quadratic eigenvalue
/// problem*, SIAM Review 43, 2001, section 3.4), by natural frequency |Im λ|, of each conjugate pair the one with Im λ < 0
/// first. Methods that take the index k of an eigenvalue panic, as slices do, where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// The 2n eigenvalues.
    pub eigenvalues: Vec<Complex<f64>>,
    /// Their shapes, the largest entry 1.
    pub shapes: Vec<DVector<Complex<f64>>>,
}

/// Relative real part from which small motions count as growing. Where two frequencies of a gyroscopic system meet, the
/// eigenvalue is double, and a rounding error ε of the matrices moves it by about √ε.
pub(super) const GROWTH: f64 = 1e-7;

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

    /// Whether no small motion grows exponentially, i.e. no real part is above 1e-7 of the largest eigenvalue. That is
    /// necessary for stability, and sufficient for damped motions; for undamped ones higher orders may decide.
    pub fn is_stable(&self) -> bool {
        let largest = self.eigenvalues.iter().map(|e| e.norm()).fold(0.0, f64::max);
        self.growth() <= GROWTH * largest
    }
}

/// `λ = ± i ω` of a system without damping, or ± the rates of growth.
pub(super) fn undamped(modes: &Modes) -> Spectrum {
    let mut spectrum = Spectrum { eigenvalues: Vec::new(), shapes: Vec::new() };
    for k in 0..modes.len() {
        let rate = modes.squares()[k].abs().sqrt();
        let values = match modes.kind(k) {
            ModeKind::Unstable => [Complex::new(-rate, 0.0), Complex::new(rate, 0.0)],
            _ => [Complex::new(0.0, -rate), Complex::new(0.0, rate)],
        };
        for value in values {
            spectrum.eigenvalues.push(value);
            spectrum.shapes.push(modes.shape(k).map(|x| Complex::new(x, 0.0)));
        }
    }
    spectrum
}

pub(super) fn spectrum(small: &SmallMotion) -> Result<Spectrum, AnalysisError> {
    let n = small.dimension();
    let [c, k] = [small.reduced(small.velocity_terms()), small.reduced(small.stiffness())];
    // In the variables (x, ẋ/ω₀) the blocks of the companion matrix are of one size.
    let scale = k.amax().sqrt().max(c.amax()).max(f64::MIN_POSITIVE);
    let mut companion = DMatrix::zeros(2 * n, 2 * n);
    companion.view_mut((0, n), (n, n)).fill_diagonal(1.0);
    companion.view_mut((n, 0), (n, n)).copy_from(&(-&k / (scale * scale)));
    companion.view_mut((n, n), (n, n)).copy_from(&(-&c / scale));
    let all = eigenvalues(companion, "the spectrum")?;
    let mut upper: Vec<Complex<f64>> = all.iter().map(|e| e * scale).filter(|e| e.im >= 0.0).collect();
    upper.sort_by(|a, b| (a.im, a.re).partial_cmp(&(b.im, b.re)).unwrap_or(std::cmp::Ordering::Equal));
    // A rigid motion is a double zero, which rounding moves by its square root.
    let stiffest = k.amax();
    let softest = k.clone().singular_values().min();
    let rigid = softest <= n as f64 * f64::EPSILON * stiffest;
    let problem = Problem { c: c.map(|x| Complex::new(x, 0.0)), k: k.map(|x| Complex::new(x, 0.0)) };
    let mut spectrum = Spectrum { eigenvalues: Vec::new(), shapes: Vec::new() };
    for (place, &value) in upper.iter().enumerate() {
        let same = |other: &&Complex<f64>| (**other - value).norm() <= 1e-10 * scale;
        let multiple = upper[..place].iter().filter(same).count();
        let paired = value.im > 0.0;
        let value = if rigid && value.norm() < GROWTH * scale { Complex::new(0.0, 0.0) } else { value };
        let (value, shape) = problem.refined(value, multiple);
        let mut shape = small.restored(&shape);
        let largest = shape[shape.icamax()];
        shape /= largest;
        if paired {
            spectrum.eigenvalues.push(value.conj());
            spectrum.shapes.push(shape.map(|x| x.conj()));
        }
        spectrum.eigenvalues.push(value);
        spectrum.shapes.push(shape);
    }
    Ok(spectrum)
}

/// `λ² + λC + K`, the inertia matrix being 1.
struct Problem {
    c: DMatrix<Complex<f64>>,
    k: DMatrix<Complex<f64>>,
}

impl Problem {
    /// The eigenvalue after two steps of Newton's method along its right and left shapes (Tisseur and Meerbergen 2001,
    /// 4.3), and its shape; of a semisimple multiple eigenvalue that numbered `multiple`.
    fn refined(&self, mut value: Complex<f64>, multiple: usize) -> (Complex<f64>, DVector<Complex<f64>>) {
        let n = self.c.nrows();
        let mut shape = DVector::zeros(n);
        for _ in 0..3 {
            let unit = DMatrix::<Complex<f64>>::identity(n, n);
            let matrix = &unit * (value * value) + &self.c * value + &self.k;
            let size = matrix.iter().map(|x| x.norm()).fold(0.0, f64::max);
            let svd = matrix.clone().svd(true, true);
            let (Some(u), Some(v)) = (&svd.u, &svd.v_t) else { break };
            let place = n - 1 - multiple.min(n - 1);
            shape = v.row(place).adjoint();
            let left = u.column(place).into_owned();
            let slope = &unit * (value * 2.0) + &self.c;
            let slope = left.dotc(&(slope * &shape));
            let rest = left.dotc(&(matrix * &shape));
            // Near a defective eigenvalue the slope vanishes, and a step would lead away.
            let real = value.im == 0.0;
            if value.norm() == 0.0 || slope.norm() * value.norm() <= 1e-4 * size {
                break;
            }
            let step = rest / slope;
            if step.norm() > 1e-8 * value.norm() {
                break;
            }
            value -= step;
            if real {
                value.im = 0.0;
            }
        }
        (value, shape)
    }
}
