//! Values of compiled code for a system, by the names that the reference has. Part of the crate that
//! `random_systems_through_rustc` writes; no module of this one.

use lagrange_runtime::__private::*;
use lagrange_runtime::prelude::*;

/// Everything by name.
pub type Named = Vec<(String, f64)>;

pub fn add(named: &mut Named, name: &str, values: &[f64]) {
    named.extend(values.iter().enumerate().map(|(i, x)| (format!("{name}[{i}]"), *x)));
}

/// The numbers of a function's result, matrices by columns.
pub trait Flat {
    fn flat(&self) -> Vec<f64>;
}

impl Flat for f64 {
    fn flat(&self) -> Vec<f64> {
        vec![*self]
    }
}

impl<const R: usize, const C: usize> Flat for SMatrix<f64, R, C> {
    fn flat(&self) -> Vec<f64> {
        self.as_slice().to_vec()
    }
}

impl<A: Flat, B: Flat> Flat for (A, B) {
    fn flat(&self) -> Vec<f64> {
        [self.0.flat(), self.1.flat()].concat()
    }
}

impl<const N: usize> Flat for Jacobian<f64, N> {
    fn flat(&self) -> Vec<f64> {
        [self.q.flat(), self.qd.flat(), self.t.flat()].concat()
    }
}

impl<const N: usize> Flat for Linearization<f64, N> {
    fn flat(&self) -> Vec<f64> {
        [self.stiffness.flat(), self.damping.flat()].concat()
    }
}

pub fn analytic<Sys: Analytic<N, Scalar = f64>, const N: usize>(
    named: &mut Named,
    system: &Sys,
    at: &State<f64, N>,
) {
    let series: TaylorSeries<f64, N, 6> = system.series(at, 4);
    for k in 1..4 {
        let order: Vec<f64> = (0..N).map(|i| ((k + 1) * (k + 2)) as f64 * series.q[k + 2][i]).collect();
        add(named, &format!("series {k}"), &order);
    }
}

/// The reduced system, by the coordinates of the whole one that it keeps.
pub fn reduced(named: &mut Named, of_reduced: Named, kept: &[usize]) {
    for (name, value) in of_reduced {
        let Some((what, i)) = name.strip_suffix(']').and_then(|name| name.split_once('[')) else { continue };
        let i: usize = i.parse().expect("an index");
        match what {
            "lagrangian" | "energy_function" => named.push((format!("reduced {name}"), value)),
            "accel" | "momenta" | "velocities" | "series 1" | "series 2" | "series 3" => {
                named.push((format!("reduced {what}[{}]", kept[i]), value));
            }
            _ => {}
        }
    }
}

/// Along a run of a smooth system: dh/dt = power − ∂L/∂t + λ·A q̇, and the way back leads to the start. What may be
/// missing is what a run at a thousandth of the tolerance changes, and rounding. Systems that run away say nothing.
pub fn balanced<Sys, Slope, const N: usize>(
    seed: u64,
    system: &Sys,
    dual: &Slope,
    start: State<f64, N>,
    held: impl Fn(&State<f64, N>) -> f64,
) where
    Sys: Lagrangian<N, Scalar = f64>,
    Slope: Lagrangian<N, Scalar = Dual<f64>>,
{
    const END: f64 = 0.5;
    let h = |s: &State<f64, N>| system.energy_function(&s.q, &s.qd, s.t);
    let rate = |s: &State<f64, N>| {
        let [q, qd] = [s.q, s.qd].map(|v| v.map(Dual::constant));
        system.power(&s.q, &s.qd, s.t) - dual.lagrangian(&q, &qd, Dual::variable(s.t)).slope + held(s)
    };
    let run = |tolerance: f64| {
        let run = integrate(system, Dop853, PiController::tolerance(tolerance), start)
            .max_steps(20_000)
            .until(start.t + END);
        let total = run.integrals([0.0; 2], |s| [rate(s), rate(s).abs()]).total().ok()?;
        let back =
            integrate(system, Dop853, PiController::tolerance(tolerance), total.state).max_steps(20_000);
        let back = back.until(start.t).final_state().ok()?;
        let size = |s: &State<f64, N>| s.q.norm() + s.qd.norm();
        let missed = ((back.q - start.q).norm() + (back.qd - start.qd).norm())
            / (1.0 + size(&start) + size(&total.state));
        Some((h(&total.state), total.integrals, missed))
    };
    let (Some(rough), Some(fine)) = (run(1e-9), run(1e-12)) else {
        println!("runs of system {seed}: none");
        return;
    };
    let ((h_rough, [work_rough, _], missed_rough), (h_fine, [work, exchanged], missed)) = (rough, fine);
    let scale = h(&start).abs() + h_fine.abs() + exchanged;
    let moved = (h_fine - h_rough).abs() + (work - work_rough).abs();
    let wrong = (h_fine - h(&start) - work).abs();
    if !(moved <= 1e-3 * scale) {
        println!("runs of system {seed}: uncertain");
        return;
    }
    println!("runs of system {seed}: balanced to {:.1e}, back to {missed:.1e}", wrong / scale);
    assert!(
        wrong <= moved + 1e-11 * scale,
        "LAGRANGE_SEED={seed}: energy {wrong:e} is missing, of {scale:e}; a coarser run changed {moved:e}"
    );
    // Friction that dies out forward grows backward.
    assert!(
        missed <= 0.1 * missed_rough + 1e-10 || missed_rough > 1e-3,
        "LAGRANGE_SEED={seed}: the way back misses the start by {missed:e}, a coarser one by {missed_rough:e}"
    );
}

/// Fails at all values that are farther from what should be than is granted; what is too uncertain is granted
/// everything.
pub fn compare(seed: u64, found: &Named, expected: &[(&str, f64, f64)]) {
    let mut wrong = Vec::new();
    for (name, value) in found {
        let Some((_, right, granted)) = expected.iter().find(|(other, ..)| other == name) else {
            wrong.push(format!("{name} is not in the reference"));
            continue;
        };
        let error = (value - right).abs();
        if !(error <= *granted || granted.is_infinite()) {
            wrong.push(format!(
                "{name} is {value:e}, should be {right:e}: off by {error:.1e}, granted {granted:.1e}"
            ));
        }
    }
    println!("values of system {seed}: {}", found.len());
    assert!(wrong.is_empty(), "LAGRANGE_SEED={seed}\n{}", wrong.join("\n"));
}
