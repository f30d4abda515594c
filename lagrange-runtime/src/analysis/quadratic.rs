//! Roots and null vectors of the quadratic matrix polynomial `P(λ) = λ²M + λC + K`, in double-double arithmetic.

use super::eigen::eigenvalues;
use super::wide::{Lu, Wide, form, is_real, narrow, norm, wide};
use super::{AnalysisError, SmallMotion};
use crate::linear::Entry;
use crate::scalar::DoubleDouble as Double;
use nalgebra::{Complex, DMatrix, DVector, SVD};

/// Relative error that each entry of the matrices may have.
pub(super) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Relative error of double-double arithmetic, in which a double root is known to 16 digits, and a triple one to 11.
const WIDE_ROUNDING: f64 = 4.0 * f64::EPSILON * f64::EPSILON;

/// Relative distance of roots that may be one multiple root.
const NEAR: f64 = 1e-3;

/// Entries of the stiffness, in units of the largest root squared, that are left out.
const SMALLEST: f64 = 1e-200;

/// Iterations of the Ehrlich–Aberth method over all roots.
const MOST_SWEEPS: usize = 200;

type Shape = DVector<Complex<f64>>;

/// A root with its error and its shape.
pub(super) struct Root {
    pub value: Complex<f64>,
    /// Changes of the real and of the imaginary part that errors of the matrices by [`ROUNDING`] make.
    pub error: Complex<f64>,
    pub shape: Shape,
}

/// `P(λ) = λ²M + λC + K` in units of the coordinates and of time that are powers of two and in which M has a diagonal
/// near 1, and the largest root is near 1 (Fan, Lin and Van Dooren, *Normwise scaling of second order polynomial
/// matrices*, SIAM J. Matrix Anal. Appl. 26, 2004).
///
/// The roots are those of `det P(λ)` by the Ehrlich–Aberth method (Bini and Noferini, *Solving polynomial eigenvalue
/// problems by means of the Ehrlich–Aberth method*, Linear Algebra Appl. 439, 2013): no companion matrix is formed
/// whose blocks differ by many powers of ten, and each root has the accuracy that belongs to it. Zero roots are taken
/// out before (Hammarling, Munro and Tisseur, *An algorithm for the complete solution of quadratic eigenvalue
/// problems*, ACM Trans. Math. Softw. 39, 2013): their number is the nullity of block Toeplitz matrices of K, C and M
/// (Gohberg, Lancaster and Rodman, *Matrix Polynomials*, 1982, 1.4).
pub(super) struct Quadratic {
    /// K, C and M.
    terms: [DMatrix<Double>; 3],
    /// Errors of their entries, in roundings of [`ROUNDING`]: their absolute values and more.
    sizes: [DMatrix<f64>; 3],
    /// Units of the coordinates, and of the roots.
    units: DVector<f64>,
    rate: f64,
    /// Null vectors of K, those of which chains begin once more for each length.
    rigid: Vec<Shape>,
}

/// An approximation of a root.
struct Approximation {
    value: Wide,
    /// Its smallest step so far, and for how many there was none much smaller.
    error: f64,
    idle: u32,
    done: bool,
}

/// A root with its multiplicity, and a bound of its distance to the approximations that it is the mean of.
struct Multiple {
    value: Wide,
    error: f64,
    count: usize,
}

impl Multiple {
    /// Returns whether rounding of the arithmetic may have made these of one root.
    fn may_be_one(&self, other: &Self) -> bool {
        norm(self.value - other.value) <= 4.0 * (self.error + other.error)
    }

    fn is_real(&self) -> bool {
        is_real(self.value) || self.value.im.value().abs() <= 4.0 * self.error
    }

    /// The conjugate of a root that is not real.
    fn conjugate(&self, all: &[Self]) -> Option<usize> {
        let conjugate = Multiple { value: Wide { im: -self.value.im, ..self.value }, ..*self };
        all.iter().position(|other| other.count == self.count && conjugate.may_be_one(other))
    }

    /// The first two that may be one.
    fn pair(all: &[Self]) -> Option<(usize, usize)> {
        let mut pairs = (0..all.len()).flat_map(|k| (0..k).map(move |j| (j, k)));
        pairs.find(|&(j, k)| all[j].may_be_one(&all[k]))
    }

    /// Makes one root of two.
    fn unite(all: &mut Vec<Self>, j: usize, k: usize) {
        let last = all.swap_remove(j.max(k));
        let first = &mut all[j.min(k)];
        let [one, other] = [first.count, last.count].map(|count| Double::from(count as f64));
        let mean = |a: Double, b: Double| (a * one + b * other) / (one + other);
        let distance = norm(first.value - last.value);
        *first = Multiple {
            value: Wide { re: mean(first.value.re, last.value.re), im: mean(first.value.im, last.value.im) },
            error: first.error.max(last.error).max(distance),
            count: first.count + last.count,
        };
    }
}

/// The chains of one length at a root, `P(λ) Σᵢ εⁱ xᵢ = O(εˡ)` at λ + ε: their vectors xᵢ by columns.
type Chains = Vec<DMatrix<Complex<f64>>>;

fn power_of_two(x: f64) -> f64 {
    x.log2().round().clamp(-1000.0, 1000.0).exp2()
}

impl Quadratic {
    pub fn new(small: &SmallMotion) -> Result<Self, AnalysisError> {
        let (m, c, k) = (small.inertia(), small.velocity_terms(), small.stiffness());
        let n = small.dimension();
        let units = DVector::from_fn(n, |i, _| power_of_two(1.0 / m[(i, i)].sqrt()));
        let largest = |a: &DMatrix<f64>, power: f64| {
            let size = |i: usize, j: usize| {
                a[(i, j)].abs().powf(power) * units[i].powf(power) * units[j].powf(power)
            };
            (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| size(i, j)).fold(0.0, f64::max)
        };
        let rate = power_of_two(largest(c, 1.0).max(largest(k, 0.5)).max(f64::MIN_POSITIVE));
        // Powers of two, one after the other, since their product may overflow.
        let scaled = |a: &DMatrix<f64>, [left, right]: [f64; 2]| {
            DMatrix::from_fn(n, n, |i, j| a[(i, j)] * (units[i] / left) * (units[j] / right))
        };
        let powers = [[rate, rate], [rate, 1.0], [1.0, 1.0]];
        let all = |[k, c, m]: [&DMatrix<f64>; 3]| {
            [scaled(k, powers[0]), scaled(c, powers[1]), scaled(m, powers[2])]
        };
        let mut terms = all([k, c, m]);
        let [blur_m, blur_c, blur_k] = small.blur();
        let blur = all([blur_k, blur_c, blur_m]);
        if terms.iter().any(|a| a.iter().any(|x| !x.is_finite())) {
            return Err(AnalysisError::NotFinite);
        }
        let mut sizes = [0, 1, 2].map(|i| terms[i].abs() + &blur[i] / ROUNDING);
        // Roots this much smaller than the largest are 0, and their errors what has been left out: double-double
        // numbers overflow.
        for (x, size) in terms[0].iter_mut().zip(&mut sizes[0]).filter(|(x, _)| x.abs() < SMALLEST) {
            *size += x.abs() / ROUNDING;
            *x = 0.0;
        }
        let mut all =
            Quadratic { terms: terms.map(|a| a.map(Double::from)), sizes, units, rate, rigid: Vec::new() };
        all.make_rigid()?;
        Ok(all)
    }

    fn dimension(&self) -> usize {
        self.units.len()
    }

    /// Makes the null vectors of K that there are but for rounding exact ones, and those of the chains that begin
    /// with them.
    fn make_rigid(&mut self) -> Result<(), AnalysisError> {
        for chain in self.chains(Wide::real(Double::ZERO))? {
            // A chain (x₀, x₁, …) of length l has Σ Aₗ₋₁₋ᵢ xᵢ = 0 with A = (K, C, M). What is left of the sum is
            // taken off the action of Aₗ₋₁ on x₀, by a change of its entries that rounding covers.
            let (length, n) = (chain.len(), self.dimension());
            let chain: Vec<DMatrix<f64>> = chain.iter().map(|x| x.map(|x| x.re)).collect();
            let first = &chain[0];
            if length <= 3 {
                let inverse = self.left_inverse(first)?;
                let rest = |a: usize, b: usize| {
                    let terms = chain.iter().enumerate().map(|(i, x)| (&self.terms[length - 1 - i], x));
                    let all = terms.flat_map(|(term, x)| (0..n).map(move |j| term[(a, j)] * x[(j, b)]));
                    all.fold(Double::ZERO, |sum, x| sum + x)
                };
                let rest = DMatrix::from_fn(n, first.ncols(), rest);
                let change = |i: usize, j: usize| {
                    (0..rest.ncols()).fold(Double::ZERO, |sum, b| sum + rest[(i, b)] * inverse[(b, j)])
                };
                let change = DMatrix::from_fn(n, n, change);
                self.sizes[length - 1] += change.map(|x| x.value().abs() / ROUNDING);
                self.terms[length - 1] -= change;
            }
            self.rigid.extend(first.column_iter().map(|x| x.map(|x| Complex::new(x, 0.0))));
        }
        Ok(())
    }

    /// The smallest X⁻ with `X⁻ X = 1`, coordinates being measured by their stiffness.
    fn left_inverse(&self, x: &DMatrix<f64>) -> Result<DMatrix<f64>, AnalysisError> {
        let weight = |i: usize| match self.sizes[0].row(i).amax() {
            0.0 => 1.0,
            size => size.sqrt(),
        };
        let weighted = DMatrix::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] * weight(i));
        let inverse = weighted.pseudo_inverse(f64::EPSILON).map_err(|_| AnalysisError::NotFinite)?;
        Ok(DMatrix::from_fn(x.ncols(), x.nrows(), |i, j| inverse[(i, j)] * weight(j)))
    }

    /// `P(z)`, `P'(z)` or `½P''(z)`.
    fn derivative(&self, order: usize, z: Wide) -> DMatrix<Wide> {
        let n = self.dimension();
        let [k, c, m] = &self.terms;
        let square = z * z;
        let times = |a: Wide, x: Double| Wide { re: a.re * x, im: a.im * x };
        let real = |x: Double| Wide { re: x, im: Double::ZERO };
        DMatrix::from_fn(n, n, |i, j| {
            let (k, c, m) = (k[(i, j)], c[(i, j)], m[(i, j)]);
            match order {
                0 => times(square, m) + times(z, c) + real(k),
                1 => times(z + z, m) + real(c),
                _ => real(m),
            }
        })
    }

    /// Sizes of the terms of which [`Quadratic::derivative`] is the sum.
    fn size(&self, order: usize, z: f64) -> DMatrix<f64> {
        let [k, c, m] = &self.sizes;
        match order {
            0 => m * (z * z) + c * z + k,
            1 => m * (2.0 * z) + c,
            _ => m.clone(),
        }
    }

    /// The chains at z, by their lengths: null spaces of `T₁ = (P)`, `T₂ = (P, 0; P', P)`,
    /// `T₃ = (P, 0, 0; P', P, 0; ½P'', P', P)`, …, whose ranks are those of their singular values once rows and
    /// columns are of one size.
    fn chains(&self, z: Wide) -> Result<Vec<Chains>, AnalysisError> {
        let n = self.dimension();
        let values = [0, 1, 2].map(|order| self.derivative(order, z).map(narrow));
        let sizes = [0, 1, 2].map(|order| self.size(order, norm(z)));
        let (mut all, mut before) = (Vec::new(), 0);
        for length in 1..=2 * n {
            let all_of = |blocks: &dyn Fn(usize, usize, usize) -> Complex<f64>| {
                DMatrix::from_fn(length * n, length * n, |i, j| match (i / n).checked_sub(j / n) {
                    Some(order @ 0..3) => blocks(order, i % n, j % n),
                    _ => Complex::new(0.0, 0.0),
                })
            };
            let size = all_of(&|order, i, j| Complex::new(sizes[order][(i, j)], 0.0));
            let (rows, columns) = equilibrated(size.map(|x| x.re));
            let scaled = all_of(&|order, i, j| values[order][(i, j)]);
            // One factor after the other: their product may overflow.
            let scaled =
                DMatrix::from_fn(length * n, length * n, |i, j| scaled[(i, j)] * rows[i] * columns[j]);
            let (singular, right) = right_vectors(scaled)?;
            // Sizes of terms have the largest entries 1.
            let rounding = ROUNDING * (length * n) as f64 * singular.amax().max(1.0);
            let null: Vec<usize> = (0..length * n).filter(|&i| singular[i] <= rounding).collect();
            let new = null.len().saturating_sub(before).min(n);
            if new == 0 {
                break;
            }
            before = null.len();
            let vectors =
                DMatrix::from_fn(length * n, null.len(), |i, j| right[(null[j], i)].conj() * columns[i]);
            // Combinations whose first vectors are orthonormal; those of shorter chains have none.
            let (singular, right) = right_vectors(vectors.rows(0, n).into_owned())?;
            let vectors =
                vectors * DMatrix::from_fn(null.len(), new, |i, j| right[(j, i)].conj() / singular[j]);
            if vectors.iter().any(|x| !(x.re.is_finite() && x.im.is_finite())) {
                return Err(AnalysisError::NotFinite);
            }
            all.push((0..length).map(|i| vectors.rows(i * n, n).into_owned()).collect());
        }
        Ok(all)
    }

    /// All 2n roots by Im λ and Re λ, of each conjugate pair the one with Im λ < 0 first.
    pub fn roots(&self) -> Result<Vec<Root>, AnalysisError> {
        let values = self.values()?;
        let mut roots: Vec<Root> = Vec::new();
        for (k, &(value, multiple)) in values.iter().enumerate() {
            // Roots with Im λ < 0 are conjugates.
            if value.im.value() < 0.0 {
                continue;
            }
            let others = values.iter().enumerate().filter(|(j, _)| *j != k);
            let distance = others.map(|(_, other)| norm(other.0 - value)).fold(f64::INFINITY, f64::min);
            let (value, error, shapes) = self.examined(value, multiple, distance)?;
            let [value, error] = [value, error].map(|x| x * self.rate);
            let known = [value, error].into_iter().chain(shapes.iter().flatten().copied());
            if !known.into_iter().all(|x| x.re.is_finite() && x.im.is_finite()) {
                return Err(AnalysisError::NotFinite);
            }
            for shape in shapes {
                let shape = DVector::from_fn(shape.len(), |i, _| shape[i] * self.units[i]);
                let shape = &shape / shape[shape.icamax()];
                if value.im > 0.0 {
                    roots.push(Root { value: value.conj(), error, shape: shape.map(|x| x.conj()) });
                }
                roots.push(Root { value, error, shape });
            }
        }
        if roots.len() != 2 * self.dimension() {
            return Err(AnalysisError::NotConverged { what: "the spectrum", residual: f64::NAN });
        }
        roots.sort_by(|a, b| {
            let key = |r: &Root| [r.value.im.abs(), r.value.re, r.value.im];
            key(a).partial_cmp(&key(b)).unwrap_or(core::cmp::Ordering::Equal)
        });
        Ok(roots)
    }

    /// The different roots, each with its multiplicity.
    fn values(&self) -> Result<Vec<(Wide, usize)>, AnalysisError> {
        let mut all = self.aberth(self.starts()?)?;
        // Roots that rounding of the arithmetic may have made of one are one.
        for k in 0..all.len() {
            let value = all[k].value;
            let near = |(j, other): (usize, &Approximation)| {
                j != k && norm(other.value - value) <= NEAR * norm(value)
            };
            if all.iter().enumerate().any(near) {
                all[k].error = all[k].error.max(self.spread(value, WIDE_ROUNDING));
            }
        }
        let mut roots: Vec<Multiple> = Vec::new();
        for Approximation { value, error, .. } in all {
            roots.push(Multiple { value, error, count: 1 });
            while let Some((j, k)) = Multiple::pair(&roots) {
                Multiple::unite(&mut roots, j, k);
            }
        }
        // A root of an iteration that ended early has no conjugate: it is one with the nearest.
        while let Some(k) =
            (0..roots.len()).find(|&k| !roots[k].is_real() && roots[k].conjugate(&roots).is_none())
        {
            let far = |j: &usize| norm(roots[*j].value - roots[k].value);
            let others = (0..roots.len()).filter(|&j| j != k);
            let Some(j) = others.min_by(|a, b| far(a).total_cmp(&far(b))) else { break };
            Multiple::unite(&mut roots, j, k);
        }
        let value = |root: &Multiple| if root.is_real() { Wide::real(root.value.re) } else { root.value };
        let mut values: Vec<(Wide, usize)> = roots.iter().map(|root| (value(root), root.count)).collect();
        if !self.rigid.is_empty() {
            values.push((wide(Complex::new(0.0, 0.0)), self.rigid.len()));
        }
        Ok(values)
    }

    /// Approximations of the roots other than 0, eigenvalues of the companion matrix.
    fn starts(&self) -> Result<Vec<Approximation>, AnalysisError> {
        let n = self.dimension();
        let [k, c, m] = self.terms.each_ref().map(|a| a.map(Double::value));
        let factors = m.lu();
        let (Some(k), Some(c)) = (factors.solve(&k), factors.solve(&c)) else {
            return Err(AnalysisError::NotFinite);
        };
        let mut companion = DMatrix::zeros(2 * n, 2 * n);
        companion.view_mut((0, n), (n, n)).fill_diagonal(1.0);
        companion.view_mut((n, 0), (n, n)).copy_from(&-k);
        companion.view_mut((n, n), (n, n)).copy_from(&-c);
        let mut all = eigenvalues(companion, "the spectrum")?;
        all.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        let away = |(k, z): (usize, &Complex<f64>)| {
            // Neither two alike nor on an axis of symmetry, which the iteration would not leave.
            let size = 1e-10 * z.norm().max(1e-20);
            let value = wide(z + Complex::from_polar(size, 2.4 * k as f64 + 1.0));
            Approximation { value, error: f64::INFINITY, idle: 0, done: false }
        };
        Ok(all.iter().enumerate().skip(self.rigid.len()).map(away).collect())
    }

    /// The roots of `det P(λ)` other than 0.
    fn aberth(&self, mut all: Vec<Approximation>) -> Result<Vec<Approximation>, AnalysisError> {
        for sweep in 0..MOST_SWEEPS {
            for k in 0..all.len() {
                if all[k].done {
                    continue;
                }
                let step = self.step(&all, k);
                let moved = all[k].value - step;
                let (size, scale) = (norm(step), norm(moved));
                if !(scale > 0.0 && scale.is_finite()) {
                    // Off a pole of the correction, and on from a step that has no digits left.
                    let (from, factor) = if scale == 0.0 { (step, 1e-30) } else { (all[k].value, 1.1) };
                    all[k].value = from * wide(Complex::from_polar(factor, 1.0 + sweep as f64));
                    continue;
                }
                let distances =
                    all.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, z)| norm(z.value - moved));
                let apart = distances.fold(scale, f64::min);
                all[k].value = moved;
                all[k].idle = if size < 0.5 * all[k].error { 0 } else { all[k].idle + 1 };
                all[k].error = all[k].error.min(size);
                // Steps towards a simple root square the error. Towards a multiple one it shrinks by a factor, until
                // rounding is left.
                all[k].done = size <= 1e-9 * apart
                    || size <= 0.01 * f64::EPSILON * scale
                    || all[k].idle >= 8 && all[k].error <= 1e-6 * scale;
                if all[k].done && !is_real(moved) {
                    let conjugate = Wide { im: -moved.im, ..moved };
                    let far = |z: &&mut Approximation| norm(z.value - conjugate);
                    let error = all[k].error;
                    let open = all.iter_mut().filter(|z| !z.done);
                    if let Some(pair) = open.min_by(|a, b| far(a).total_cmp(&far(b))) {
                        *pair = Approximation { value: conjugate, error, idle: 0, done: true };
                    }
                }
            }
            if all.iter().all(|z| z.done) {
                return Ok(all);
            }
        }
        let left = all.iter().filter(|z| !z.done).map(|z| z.error / norm(z.value)).fold(0.0, f64::max);
        Err(AnalysisError::NotConverged { what: "the spectrum", residual: left })
    }

    /// The correction of an approximation, with f divided by its distances to all others and by the zero roots.
    fn step(&self, all: &[Approximation], k: usize) -> Wide {
        let z = all[k].value;
        let one = Wide::real(Double::ONE);
        let zeros = Wide::real(Double::from(self.rigid.len() as f64));
        let others = all.iter().enumerate().filter(|(j, other)| *j != k && other.value != z);
        let slope = others
            .fold(self.logarithmic_slope(z) - zeros / z, |sum, (_, other)| sum - one / (z - other.value));
        one / slope
    }

    /// `f'/f` of `f(z) = det P(z)`, the trace of `P⁻¹P'`.
    fn logarithmic_slope(&self, z: Wide) -> Wide {
        let (factors, slope) = (Lu::of(self.derivative(0, z)), self.derivative(1, z));
        (0..self.dimension())
            .fold(wide(Complex::new(0.0, 0.0)), |sum, j| sum + factors.solve(slope.column(j).into_owned())[j])
    }

    /// A root with its error, and its shapes, as many as it is multiple. The next one is at this distance.
    fn examined(
        &self,
        mut value: Wide,
        multiple: usize,
        distance: f64,
    ) -> Result<(Complex<f64>, Complex<f64>, Vec<Shape>), AnalysisError> {
        if norm(value) == 0.0 {
            return Ok((narrow(value), self.spread_by_entries(value), self.rigid.clone()));
        }
        if multiple > 1 {
            let chains = self.chains(value)?;
            let firsts = chains.iter().flat_map(|chain| chain[0].column_iter().map(|x| x.into_owned()));
            let mut shapes: Vec<Shape> = firsts.take(multiple).collect();
            if shapes.is_empty() {
                shapes.push(Lu::of(self.derivative(0, value)).null_vectors()[1].map(narrow));
            }
            let first = shapes[0].clone();
            shapes.resize(multiple, first);
            return Ok((narrow(value), self.spread_by_entries(value), shapes));
        }
        let at = self.derivative(0, value);
        let [left, right] = Lu::of(at.clone()).null_vectors();
        let slope = form(&left, &self.derivative(1, value), &right);
        // The quotient of two-sided vectors has an error of second order (Tisseur and Meerbergen 2001, 4.3).
        let step = form(&left, &at, &right) / slope;
        if norm(step) <= 1e-3 * distance.min(norm(value)) {
            value = value - step;
            if is_real(value) {
                value = Wide::real(value.re);
            }
        }
        let (z, shape) = (narrow(value), right.map(narrow));
        let error = self.sensitivity(z, &left.map(narrow), &(&shape / narrow(slope)));
        // Perturbation theory of first order holds for roots that are well apart.
        let error = if error.norm() <= 0.01 * distance { error } else { self.spread_by_entries(value) };
        Ok((z, error, vec![shape]))
    }

    /// Changes of the real and of the imaginary part of a simple root that errors of the real matrices make, in first
    /// order: `δλ = −yᵀ (λ² δM + λ δC + δK) x` with `yᵀ P'(λ) x = 1` (Tisseur, *Backward error and condition of
    /// polynomial eigenvalue problems*, Linear Algebra Appl. 309, 2000).
    fn sensitivity(&self, z: Complex<f64>, left: &Shape, right: &Shape) -> Complex<f64> {
        let mut error = Complex::new(0.0, 0.0);
        for (power, sizes) in [Complex::new(1.0, 0.0), z, z * z].into_iter().zip(&self.sizes) {
            for (j, x) in right.iter().enumerate() {
                for (i, y) in left.iter().enumerate() {
                    let change = y * power * x * sizes[(i, j)];
                    error += Complex::new(change.re.abs(), change.im.abs());
                }
            }
        }
        // The part that vanishes for real matrices has rounding errors of its own.
        let own = 64.0 * f64::EPSILON * error.norm();
        (error + Complex::new(own, own)) * ROUNDING
    }

    /// Changes of a root that is not alone by errors of the matrices.
    fn spread_by_entries(&self, value: Wide) -> Complex<f64> {
        let r = self.spread(value, ROUNDING);
        Complex::new(r, r)
    }

    /// Change of a root that is not alone by relative errors δ of the terms: the distance r at which
    /// `δ tr(|P(λ + r)⁻¹| (r²|M| + r|C| + |K|)) = 1`, so that P(λ + r) may be singular.
    fn spread(&self, value: Wide, rounding: f64) -> f64 {
        let n = self.dimension();
        let mut r = norm(value).max(1e-20) * rounding.sqrt();
        for _ in 0..20 {
            let z = value + wide(Complex::from_polar(r, 1.0));
            let (factors, sizes) = (Lu::of(self.derivative(0, z)), self.size(0, norm(z)));
            let mut sum = 0.0;
            for j in 0..n {
                let unit = DVector::from_fn(n, |i, _| wide(Complex::new(f64::from(u8::from(i == j)), 0.0)));
                let column = factors.solve(unit);
                sum += (0..n).map(|i| norm(column[i]) * sizes[(j, i)]).sum::<f64>();
            }
            // The sum falls as a power −p of r, p = 1, 2, 3, …, so that the logarithm of the error is multiplied by 1
            // − p/3.
            r *= (rounding * sum).cbrt();
        }
        r
    }
}

/// Singular values and, by rows, the adjoint right vectors.
fn right_vectors(a: DMatrix<Complex<f64>>) -> Result<(DVector<f64>, DMatrix<Complex<f64>>), AnalysisError> {
    if a.iter().any(|x| !(x.re.is_finite() && x.im.is_finite())) {
        return Err(AnalysisError::NotFinite);
    }
    let svd = SVD::try_new(a, false, true, f64::EPSILON, 10_000).ok_or(AnalysisError::NotFinite)?;
    Ok((svd.singular_values, svd.v_t.ok_or(AnalysisError::NotFinite)?))
}

/// Factors of rows and columns with which all rows and columns have the largest entry 1 (Ruiz, *A scaling algorithm
/// to equilibrate both rows and columns norms in matrices*, RAL-TR-2001-034).
pub(super) fn equilibrated(mut sizes: DMatrix<f64>) -> (DVector<f64>, DVector<f64>) {
    let n = sizes.nrows();
    let (mut rows, mut columns) = (DVector::from_element(n, 1.0), DVector::from_element(n, 1.0));
    let factor = |largest: f64| if largest > SMALLEST { 1.0 / largest.sqrt() } else { 1.0 };
    for _ in 0..12 {
        let row: Vec<f64> = sizes.row_iter().map(|row| factor(row.amax())).collect();
        let column: Vec<f64> = sizes.column_iter().map(|column| factor(column.amax())).collect();
        for i in 0..n {
            rows[i] *= row[i];
            columns[i] *= column[i];
            for j in 0..n {
                sizes[(i, j)] *= row[i] * column[j];
            }
        }
    }
    (rows, columns)
}
