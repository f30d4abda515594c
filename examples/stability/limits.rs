//! The largest steps: theory from coefficients against the steps that methods make.

use crate::systems::{Damped, Oscillator};
use lagrange_runtime::method::compose::Coefficients;
use lagrange_runtime::method::explicit_rk::{Euler, Heun, Tsitouras5};
use lagrange_runtime::method::rosenbrock::Rodas4;
use lagrange_runtime::method::splitting::PositionVerlet;
use lagrange_runtime::method::variational::VariationalTrapezoid;
use lagrange_runtime::method::{explicit_rk, nystrom};
use lagrange_runtime::prelude::*;
use lagrange_runtime::{
    BlanesMoan4, BlanesMoan6, KahanLi8, Lagrangian, Nystrom12,
    method::compose::{KahanLi6, Suzuki4, SuzukiUmeno8, TripleJump, Yoshida6},
    method::explicit_rk::StabilityPolynomial,
    method::nystrom::{Nystrom6, Nystrom8},
};

/// The largest step of one method on one axis.
pub struct Limit {
    pub method: &'static str,
    /// `oscillator` (hω) or `overdamped` (h|λ|).
    pub axis: &'static str,
    /// From the coefficients: 0 if every step is too long, infinite if none is; `None` if they are not public.
    pub theory: Option<f64>,
    pub measured: Measured,
}

/// Measured limit of a method's steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Motions grow from this step on; 0: at the smallest step tried.
    Grows(f64),
    /// None up to the longest step tried.
    Never,
    /// The step fails from here on, and says why.
    Fails(f64, Failure),
}

impl Measured {
    /// In the unit of another rate.
    fn times(self, rate: f64) -> Self {
        match self {
            Measured::Grows(h) => Measured::Grows(h * rate),
            Measured::Fails(h, failure) => Measured::Fails(h * rate, failure),
            Measured::Never => Measured::Never,
        }
    }
}

impl Limit {
    /// Returns whether theory and measurement are the same within 1 %. A step that fails before it is unstable is in
    /// order.
    pub fn agrees(&self) -> bool {
        match (self.theory, self.measured) {
            (None, _) => true,
            (Some(theory), Measured::Grows(h)) => theory.is_finite() && (h - theory).abs() <= 0.01 * theory,
            (Some(theory), Measured::Never) => theory == f64::INFINITY,
            (Some(theory), Measured::Fails(h, _)) => h <= theory,
        }
    }
}

/// Searched in these steps from `FIRST` to `FAR`.
const SCAN: f64 = 1.0 / 64.0;
const FIRST: f64 = 0.3;
const FAR: f64 = 40.0;
/// More than this is growth and not rounding.
const ROUNDING: f64 = 1e-13;
/// Damping constant of the overdamped oscillator, and its faster rate.
const C: f64 = 40.0;
const FAST: f64 = 39.97498435543818;

/// A matrix of one step, by columns `(q, q̇)`.
type Matrix = [[f64; 2]; 2];

/// Excess of the largest eigenvalue over 1.
fn excess([[a, c], [b, d]]: Matrix) -> f64 {
    let (trace, det) = (a + d, a * d - b * c);
    let root = 0.25 * trace * trace - det;
    // A pair of complex eigenvalues has the size √det.
    if root < 0.0 { 0.5 * (det - 1.0) } else { 0.5 * trace.abs() + root.sqrt() - 1.0 }
}

/// The first h between `FIRST` and `FAR`, in units of 1/rate, at which `bad(h)`.
fn first(rate: f64, bad: impl Fn(f64) -> bool) -> Option<f64> {
    let (scan, mut h) = (SCAN / rate, FIRST / rate);
    if bad(h) {
        return Some(0.0);
    }
    while !bad(h + scan) {
        h += scan;
        if h * rate > FAR {
            return None;
        }
    }
    let (mut inside, mut outside) = (h, h + scan);
    for _ in 0..40 {
        let middle = 0.5 * (inside + outside);
        *(if bad(middle) { &mut outside } else { &mut inside }) = middle;
    }
    Some(inside)
}

/// From the steps that a method makes.
fn measure<Sys: Lagrangian<1, Scalar = f64>, M: Method<Sys, 1>>(
    system: &Sys,
    method: &M,
    rate: f64,
) -> Measured {
    let image = |q: f64, qd: f64, h: f64| -> Result<[f64; 2], Failure> {
        let from = State::new(0.0, [q], [qd]);
        let memory = method.start(system, &from)?;
        let (step, _) = method.step(system, &memory, &from, h)?;
        Ok([step.to.q[0], step.to.qd[0]])
    };
    let matrix = |h: f64| -> Result<Matrix, Failure> { Ok([image(1.0, 0.0, h)?, image(0.0, 1.0, h)?]) };
    let bad = |h: f64| matrix(h).map_or(true, |matrix| excess(matrix) > ROUNDING);
    match first(rate, bad) {
        None => Measured::Never,
        // The edge of failure is ragged: what lies just beyond decides whether steps grow or fail.
        Some(h) => (0..24)
            .find_map(|k| match matrix(h.max(FIRST / rate) * (1.0 + 1e-9 * f64::from(1u32 << k))) {
                Err(failure) => Some(Measured::Fails(h, failure).times(rate)),
                Ok(matrix) if excess(matrix) > ROUNDING => Some(Measured::Grows(h).times(rate)),
                Ok(_) => None,
            })
            .unwrap_or(Measured::Never),
    }
}

fn pair<T, const K: usize>(method: T, name: &'static str, limits: &mut Vec<Limit>)
where
    T: explicit_rk::ButcherTableau<K> + Method<Oscillator, 1> + Method<Damped, 1>,
{
    let stability = StabilityPolynomial::<K>::of::<T>();
    both(method, name, [stability.imaginary_limit(), stability.real_limit()], limits);
}

/// A method for every Lagrangian.
fn both<M: Method<Oscillator, 1> + Method<Damped, 1>>(
    method: M,
    name: &'static str,
    [imaginary, real]: [f64; 2],
    limits: &mut Vec<Limit>,
) {
    separable(&method, name, Some(imaginary), limits);
    let measured = measure(&Damped::new(C, 1.0), &method, FAST);
    limits.push(Limit { method: name, axis: "overdamped", theory: Some(real), measured });
}

fn separable<M: Method<Oscillator, 1>>(
    method: &M,
    name: &'static str,
    theory: Option<f64>,
    limits: &mut Vec<Limit>,
) {
    let measured = measure(&Oscillator::new(1.0), method, 1.0);
    limits.push(Limit { method: name, axis: "oscillator", theory, measured });
}

/// Kick, drift, kick with the steps γᵢ h, as matrices.
fn composed<Row: Coefficients>(_: Row, name: &'static str, limits: &mut Vec<Limit>)
where
    Compose<Verlet, Row>: Method<Oscillator, 1> + Default,
{
    let matrix = |h: f64| {
        [[1.0, 0.0], [0.0, 1.0]].map(|[mut q, mut qd]: [f64; 2]| {
            for gamma in Row::GAMMA.iter().map(|gamma| gamma.hi) {
                qd -= 0.5 * gamma * h * q;
                q += gamma * h * qd;
                qd -= 0.5 * gamma * h * q;
            }
            [q, qd]
        })
    };
    let theory = first(1.0, |h| excess(matrix(h)) > ROUNDING);
    separable(&Compose::<Verlet, Row>::default(), name, theory, limits);
}

/// `kᵢ = −(q + cᵢ h q̇ + h² Σⱼ aᵢⱼ kⱼ)`.
fn nystrom<T, const K: usize>(method: T, name: &'static str, limits: &mut Vec<Limit>)
where
    T: nystrom::NystromTableau<K> + Method<Oscillator, 1>,
{
    let matrix = |h: f64| {
        [[1.0, 0.0], [0.0, 1.0]].map(|[q, qd]: [f64; 2]| {
            let mut k = [0.0; K];
            for i in 0..K {
                let sum: f64 = (0..i).map(|j| T::A[i][j] * k[j]).sum();
                k[i] = -(q + T::C[i] * h * qd + h * h * sum);
            }
            let [b, velocity]: [f64; 2] =
                [&T::A[K - 1], &T::VELOCITY].map(|row| row.iter().zip(&k).map(|(b, k)| b * k).sum());
            [q + h * qd + h * h * b, qd + h * velocity]
        })
    };
    separable(&method, name, first(1.0, |h| excess(matrix(h)) > ROUNDING), limits);
}

/// All methods.
pub fn limits() -> Vec<Limit> {
    const NONE: f64 = f64::INFINITY;
    let mut limits = Vec::new();
    let all = &mut limits;
    pair(Euler, "Euler", all);
    pair(Heun, "Heun", all);
    pair(Rk4, "Rk4", all);
    pair(Tsitouras5, "Tsitouras5", all);
    pair(DormandPrince5, "DormandPrince5", all);
    pair(Dop853, "Dop853", all);
    pair(Verner9, "Verner9", all);
    separable(&Verlet, "Verlet", Some(2.0), all);
    separable(&PositionVerlet, "PositionVerlet", Some(2.0), all);
    composed(TripleJump, "Verlet, TripleJump", all);
    composed(Suzuki4, "Verlet, Suzuki4", all);
    composed(Yoshida6, "Verlet, Yoshida6", all);
    composed(KahanLi6, "Verlet, KahanLi6", all);
    composed(KahanLi8, "Verlet, KahanLi8", all);
    composed(SuzukiUmeno8, "Verlet, SuzukiUmeno8", all);
    separable(&BlanesMoan4, "BlanesMoan4", None, all);
    separable(&BlanesMoan6, "BlanesMoan6", None, all);
    nystrom(Nystrom6, "Nystrom6", all);
    nystrom(Nystrom8, "Nystrom8", all);
    nystrom(Nystrom12, "Nystrom12", all);
    both(ImplicitMidpoint, "ImplicitMidpoint", [NONE; 2], all);
    both(Gauss4, "Gauss4", [NONE; 2], all);
    both(Gauss6, "Gauss6", [NONE; 2], all);
    both(VariationalMidpoint, "VariationalMidpoint", [NONE; 2], all);
    both(VariationalTrapezoid, "VariationalTrapezoid", [2.0, NONE], all);
    both(Rodas4, "Rodas4", [NONE; 2], all);
    both(Rodas5P, "Rodas5P", [NONE; 2], all);
    both(Radau5, "Radau5", [NONE; 2], all);
    limits
}
