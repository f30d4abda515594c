//! Roots of `det(λ²M + λC + K)` in 600 digits: the characteristic polynomial of the companion matrix (Faddeev and Le
//! Verrier; Gantmacher, *The Theory of Matrices*, 1959, IV.5) and its roots (Aberth, *Math. Comp.* 27, 1973).

use astro_float_num::{BigFloat, RoundingMode, Sign};
use lagrange_runtime::analysis::{Complex, DMatrix};
use std::ops::{Add, Div, Mul, Sub};

const BITS: usize = 2048;
const MODE: RoundingMode = RoundingMode::None;

/// A real number of 600 digits.
#[derive(Clone, Debug, PartialEq)]
struct Big(BigFloat);

fn big(x: f64) -> Big {
    Big(BigFloat::from_f64(x, BITS))
}

impl Big {
    /// The nearest `f64`, but for its last bit; 0 for what is below 1e-290.
    fn value(&self) -> f64 {
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else { return f64::NAN };
        if self.0.is_zero() || exponent < -960 {
            return 0.0;
        }
        let magnitude =
            *words.last().expect("a number has words") as f64 * 2f64.powi(-64) * 2f64.powi(exponent);
        if sign == Sign::Neg { -magnitude } else { magnitude }
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident)*) => {$(
        impl $trait for &Big {
            type Output = Big;
            fn $method(self, o: &Big) -> Big {
                Big(self.0.$method(&o.0, BITS, MODE))
            }
        }
    )*};
}

operators! { Add add  Sub sub  Mul mul  Div div }

/// A complex number of 600 digits.
#[derive(Clone, Debug)]
pub struct Digits {
    re: Big,
    im: Big,
}

impl Digits {
    fn of(z: Complex<f64>) -> Self {
        Digits { re: big(z.re), im: big(z.im) }
    }

    fn plus(&self, o: &Digits) -> Digits {
        Digits { re: &self.re + &o.re, im: &self.im + &o.im }
    }

    fn minus(&self, o: &Digits) -> Digits {
        Digits { re: &self.re - &o.re, im: &self.im - &o.im }
    }

    fn times(&self, o: &Digits) -> Digits {
        let re = &(&self.re * &o.re) - &(&self.im * &o.im);
        let im = &(&self.re * &o.im) + &(&self.im * &o.re);
        Digits { re, im }
    }

    fn over(&self, o: &Digits) -> Digits {
        let norm = &(&o.re * &o.re) + &(&o.im * &o.im);
        let conjugate = Digits { re: o.re.clone(), im: &big(0.0) - &o.im };
        let product = self.times(&conjugate);
        Digits { re: &product.re / &norm, im: &product.im / &norm }
    }

    pub fn value(&self) -> Complex<f64> {
        Complex::new(self.re.value(), self.im.value())
    }

    pub fn norm(&self) -> f64 {
        self.value().norm()
    }

    /// The difference to a number in double precision.
    pub fn off(&self, z: Complex<f64>) -> Complex<f64> {
        self.minus(&Digits::of(z)).value()
    }
}

/// A square matrix by rows.
type Matrix = Vec<Vec<Big>>;

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let n = a.len();
    let zero = big(0.0);
    let entry = |i: usize, j: usize| {
        (0..n).filter(|k| a[i][*k] != zero).fold(zero.clone(), |sum, k| &sum + &(&a[i][k] * &b[k][j]))
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

/// `A⁻¹ (B, C)` by elimination, A being symmetric and positive definite.
fn solved(a: &DMatrix<f64>, right: [&DMatrix<f64>; 2]) -> [Matrix; 2] {
    let n = a.nrows();
    let mut rows: Matrix = (0..n)
        .map(|i| [a, right[0], right[1]].iter().flat_map(|m| (0..n).map(move |j| big(m[(i, j)]))).collect())
        .collect();
    for j in 0..n {
        let pivot = rows[j].clone();
        for (i, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != j) {
            let factor = &row[j] / &pivot[j];
            debug_assert!(i != j);
            row.iter_mut().zip(&pivot).for_each(|(x, p)| *x = &*x - &(&factor * p));
        }
    }
    [1, 2].map(|part| {
        rows.iter()
            .enumerate()
            .map(|(i, row)| row[part * n..][..n].iter().map(|x| x / &row[i]).collect())
            .collect()
    })
}

/// Coefficients of the characteristic polynomial, that of 1 first and the last one 1.
fn characteristic(m: &DMatrix<f64>, c: &DMatrix<f64>, k: &DMatrix<f64>) -> Vec<Big> {
    let n = m.nrows();
    let [k, c] = solved(m, [k, c]);
    let zero = big(0.0);
    let companion: Matrix = (0..2 * n)
        .map(|i| match i.checked_sub(n) {
            None => (0..2 * n).map(|j| big(f64::from(u8::from(j == i + n)))).collect(),
            Some(i) => k[i].iter().chain(&c[i]).map(|x| &zero - x).collect(),
        })
        .collect();
    let mut coefficients = vec![big(1.0)];
    let mut power: Matrix = (0..2 * n).map(|_| vec![zero.clone(); 2 * n]).collect();
    for step in 1..=2 * n {
        // Mₖ = A Mₖ₋₁ + cₖ₋₁ 1, cₖ = −tr(A Mₖ)/k.
        let before = coefficients.last().expect("the first is 1");
        power.iter_mut().enumerate().for_each(|(i, row)| row[i] = &row[i] + before);
        power = product(&companion, &power);
        let trace = (0..2 * n).fold(zero.clone(), |sum, i| &sum + &power[i][i]);
        coefficients.push(&(&zero - &trace) / &big(step as f64));
    }
    coefficients.reverse();
    coefficients
}

/// All roots with their multiplicities, found from approximations whose number alone matters.
pub fn roots(m: &DMatrix<f64>, c: &DMatrix<f64>, k: &DMatrix<f64>, near: &[Complex<f64>]) -> Vec<Digits> {
    let coefficients = characteristic(m, c, k);
    let one = Digits::of(Complex::new(1.0, 0.0));
    let largest = near.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let away = |(k, z): (usize, &Complex<f64>)| {
        Digits::of(z + Complex::from_polar(1e-3 * z.norm().max(1e-20 * largest), 2.4 * k as f64 + 1.0))
    };
    let mut all: Vec<Digits> = near.iter().enumerate().map(away).collect();
    let mut done = vec![false; all.len()];
    for _ in 0..2000 {
        for k in 0..all.len() {
            if done[k] {
                continue;
            }
            let z = all[k].clone();
            let (mut value, mut slope) =
                (Digits::of(Complex::new(0.0, 0.0)), Digits::of(Complex::new(0.0, 0.0)));
            for a in coefficients.iter().rev() {
                slope = slope.times(&z).plus(&value);
                value = value.times(&z);
                value.re = &value.re + a;
            }
            if value.re.0.is_zero() && value.im.0.is_zero() {
                done[k] = true;
                continue;
            }
            let mut inverse = slope.over(&value);
            for (j, other) in all.iter().enumerate() {
                if j != k {
                    inverse = inverse.minus(&one.over(&z.minus(other)));
                }
            }
            let step = one.over(&inverse);
            all[k] = z.minus(&step);
            done[k] = step.norm() <= 1e-40 * all[k].norm() || all[k].norm() <= 1e-60 * largest;
        }
        if done.iter().all(|done| *done) {
            break;
        }
    }
    assert!(done.iter().all(|done| *done), "the roots were not found");
    // None is lost, and none found twice: Π (λ − λⱼ) has the coefficients again.
    let mut again = vec![one.clone()];
    for root in &all {
        let shifted = [Digits::of(Complex::new(0.0, 0.0))].into_iter().chain(again.iter().cloned());
        let scaled = again.iter().map(|a| a.times(root)).chain([Digits::of(Complex::new(0.0, 0.0))]);
        again = shifted.zip(scaled).map(|(a, b)| a.minus(&b)).collect();
    }
    let mut power = 1.0;
    for (a, b) in again.iter().zip(&coefficients).rev() {
        let off = a.minus(&Digits { re: b.clone(), im: big(0.0) }).norm();
        assert!(off <= 1e-15 * b.value().abs() + 1e-30 * power, "coefficient {b:?} is off by {off:e}");
        power *= largest;
    }
    all
}
