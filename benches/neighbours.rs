//! Variational equations against gradients: time to the same error of the fundamental matrix over one period, and of
//! an interval of a Lyapunov spectrum: `cargo bench --bench neighbours`.
//!
//! Errors are those of the largest entry in parts of the largest of the matrix, against closed forms (pendulum,
//! Kepler's ellipse) and a run of gradients of double-doubles at 1e-30 (double pendulum); beside them, how far the
//! matrix is from symplectic.
//!
//! With arguments, `-- pendulum 2 1e-12 100`, the numbered contestant computes the matrix a hundred times and ends,
//! for counting instructions: the difference of two counts is free of everything else.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::analysis::*;
use lagrange_runtime::lanes::Rescale;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::work_precision::{MeasuredRun, Reading, ranking};
use lagrange_runtime::{
    DoubleDouble, Gradient,
    method::taylor::LongTaylor,
    traits::{Analytic, LegendreTransform},
};
use std::f64::consts::PI;
use std::time::Instant;
use support::systems::{DoublePendulum, Kepler, Pendulum};
use support::{consume, shortest, times_to};

/// Names of the contestants; the first is what the others are compared with.
const NAMES: [&str; 4] =
    ["variational, DOP853", "variational, Verner 9(8)", "gradients, DOP853", "gradients, Taylor"];

/// A motion over one period, and the exact fundamental matrix there.
struct Problem<Sys, Over, const N: usize> {
    name: &'static str,
    system: Sys,
    over_gradients: Over,
    start: State<f64, N>,
    period: f64,
    exact: DMatrix<f64>,
}

impl<Sys, Over, const N: usize> Problem<Sys, Over, N> {
    /// A contestant's end and matrix. `T = N (1 + 2N)`, D = 2N.
    fn matrix<const T: usize, const D: usize>(
        &self,
        contestant: usize,
        tolerance: f64,
    ) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError>
    where
        Sys: Lagrangian<N, Scalar = f64> + Rescale<N>,
        Over: Analytic<N, Scalar = Gradient<f64, D>> + Copy,
    {
        let (start, period, control) = (&self.start, self.period, PiController::tolerance(tolerance));
        let system = &self.system;
        match contestant {
            0 => fundamental_matrix(&ByVariationalEquations::<_, T>::new(system, tolerance), start, period),
            1 => {
                let flow = ByVariationalEquations::<_, T, _, _>::with(system, Verner9, control);
                fundamental_matrix(&flow, start, period)
            }
            2 => fundamental_matrix(&ByGradients::with(self.over_gradients, Dop853, control), start, period),
            _ => fundamental_matrix(&ByGradients::new(self.over_gradients, tolerance), start, period),
        }
    }

    fn measure<const T: usize, const D: usize>(&self)
    where
        Sys: LegendreTransform<N, Scalar = f64> + Rescale<N>,
        Over: LegendreTransform<N, Scalar = Gradient<f64, D>> + Analytic<N, Scalar = Gradient<f64, D>> + Copy,
    {
        let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
        if let [name, contestant, tolerance, count] = &words[..] {
            if name == self.name {
                let number = |word: &str| word.parse::<f64>().expect("a number");
                for _ in 0..number(count) as u32 {
                    consume(self.matrix::<T, D>(number(contestant) as usize, number(tolerance)));
                }
            }
            return;
        }
        let form = |at: &State<f64, N>| self.form::<D>(at);
        let size = self.exact.amax();
        let (mut runs, mut best) = (Vec::new(), [[f64::INFINITY; 2]; NAMES.len()]);
        for tolerance in (6..=32).map(|k| 10f64.powf(-0.5 * f64::from(k))) {
            for (contestant, name) in NAMES.into_iter().enumerate() {
                // Tolerances at the limit of rounding are not for every method.
                let Ok((end, matrix)) = self.matrix::<T, D>(contestant, tolerance) else { continue };
                let error = (&matrix - &self.exact).amax() / size;
                let kept = matrix.transpose() * form(&end) * &matrix;
                let defect = (kept - form(&self.start)).amax() / (size * form(&self.start).amax());
                best[contestant] = [best[contestant][0].min(error), best[contestant][1].min(defect)];
                let seconds = shortest(|| consume(self.matrix::<T, D>(contestant, tolerance)));
                runs.push(MeasuredRun { method: name.into(), error, seconds, evaluations: 0 });
            }
        }
        let table = ranking(&runs, Reading::Interpolated);
        for (name, [error, defect]) in NAMES.into_iter().zip(best) {
            let times = times_to(&table, &[4, 6, 8, 10, 12, 13, 14], name, NAMES[0]);
            println!("| {} | {name} | {} | {error:.0e} | {defect:.0e} |", self.name, times);
        }
    }

    /// `dq ∧ dp` in coordinates and velocities.
    fn form<const D: usize>(&self, at: &State<f64, N>) -> DMatrix<f64>
    where
        Over: Lagrangian<N, Scalar = Gradient<f64, D>>,
    {
        let all = Gradient::variables(std::array::from_fn(|i| if i < N { at.q[i] } else { at.qd[i - N] }));
        let [q, qd] = [0, N].map(|first| nalgebra::SVector::from_fn(|i, _| all[first + i]));
        let p = self.over_gradients.momenta(&q, &qd, Gradient::constant(at.t));
        let unit = |k: usize, i: usize| f64::from(u8::from(k == i));
        DMatrix::from_fn(D, D, |i, j| {
            (0..N).map(|k| unit(k, i) * p[k].slopes[j] - unit(k, j) * p[k].slopes[i]).sum::<f64>()
        })
    }
}

/// From rest at 2 rad: a neighbour's period differs, `T = 2π √(l/g)/agm(1, cos(θ₀/2))` (Gauss), and a neighbour's
/// velocity shifts time.
fn pendulum() -> Problem<Pendulum, Pendulum<Gradient<f64, 2>>, 1> {
    let (system, angle) = (Pendulum::new(1.3, 0.85, 9.81), 2.0);
    let constant = |x: f64| Gradient::<_, 1>::constant(DoubleDouble::from(x));
    let [theta] = Gradient::variables([DoubleDouble::from(angle)]);
    let (mut a, mut b) = (constant(1.0), (theta * constant(0.5)).cos());
    for _ in 0..8 {
        (a, b) = ((a + b) * constant(0.5), (a * b).sqrt());
    }
    let root = (DoubleDouble::from(system.l) / system.g).sqrt();
    let period = Gradient::constant(DoubleDouble::PI * 2.0 * root) / a;
    let slope = system.g / system.l * angle.sin() * period.slopes[0].value();
    Problem {
        name: "pendulum",
        system,
        over_gradients: system.map(Gradient::constant),
        start: State::new(0.0, [angle], [0.0]),
        period: period.value.value(),
        exact: DMatrix::from_row_slice(2, 2, &[1.0, 0.0, slope, 1.0]),
    }
}

/// From the pericentre of an ellipse of a = 1, e = 0.6, about μ = 1: `DΦ = 1 − ẋ ∂T/∂x`, `T = 2π a^(3/2)`,
/// `1/a = 2/r − v²`.
fn kepler() -> Problem<Kepler, Kepler<Gradient<f64, 4>>, 2> {
    let system = Kepler::new(1.0, 1.0);
    let (r, rate) = (0.4, 5.0);
    let motion = [0.0, rate, r * rate * rate - 1.0 / (r * r), 0.0];
    let period = [3.0 * PI * (2.0 / (r * r) + 2.0 * r * rate * rate), 0.0, 0.0, 6.0 * PI * r * r * rate];
    Problem {
        name: "Kepler",
        system,
        over_gradients: system.map(Gradient::constant),
        start: State::new(0.0, [r, 0.0], [0.0, rate]),
        period: 2.0 * PI,
        exact: DMatrix::from_fn(4, 4, |i, j| f64::from(u8::from(i == j)) - motion[i] * period[j]),
    }
}

/// A normal mode, grown to a finite amplitude.
fn double_pendulum() -> Problem<DoublePendulum, DoublePendulum<Gradient<f64, 4>>, 2> {
    let system = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let over_gradients = system.map(Gradient::constant);
    let modes = small_vibrations(&system, &[0.0; 2]).expect("an equilibrium").modes().expect("modes");
    let shape = modes.shape(0) * 0.9;
    let guess = State::new(0.0, [shape[0], shape[1]], [0.0; 2]);
    let about = Period::About(1.1 * 2.0 * PI / modes.frequency(0));
    let flow = ByGradients::new(over_gradients, 1e-15);
    let orbit = periodic_orbit(&flow, &guess, about, 1e-12).expect("an orbit");
    let start = orbit.start;
    let fine = system.map(|x| Gradient::<_, 4>::constant(DoubleDouble::from(x)));
    let mut from = start.map(|x| Gradient::constant(DoubleDouble::from(x)));
    for i in 0..2 {
        from.q[i].slopes[i] = DoubleDouble::ONE;
        from.qd[i].slopes[2 + i] = DoubleDouble::ONE;
    }
    let run = integrate(&fine, LongTaylor, TaylorController::tolerance(1e-30), from);
    let end =
        run.until(Gradient::constant(DoubleDouble::from(orbit.period))).final_state().expect("a motion");
    let exact = DMatrix::from_fn(4, 4, |i, j| {
        let row = if i < 2 { end.q[i] } else { end.qd[i - 2] };
        row.slopes[j].value()
    });
    Problem { name: "double", system, over_gradients, start, period: orbit.period, exact }
}

/// Time of an interval of the spectrum of the chaotic double pendulum, and what comes out.
fn spectrum() {
    let system = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [2.0, 2.4], [0.0; 2]);
    let how = Measurement { transient: 20.0, interval: 0.5, intervals: 2000 };
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let timed = |name: &str, run: &dyn Fn() -> Result<Vec<Exponent>, AnalysisError>| {
            let mut shortest = f64::INFINITY;
            let mut all = Vec::new();
            for _ in 0..3 {
                let clock = Instant::now();
                all = run().expect("a regular motion");
                shortest = shortest.min(clock.elapsed().as_secs_f64());
            }
            let sum: f64 = all.iter().map(|exponent| exponent.value).sum();
            println!(
                "| {tolerance:.0e} | {name} | {:.1} µs | {:.3} ± {:.3} | {sum:.0e} |",
                1e6 * shortest / (f64::from(how.intervals) + how.transient / how.interval),
                all[0].value,
                all[0].error
            );
        };
        let equations = ByVariationalEquations::<_, 10>::new(&system, tolerance);
        timed("variational, DOP853", &|| lyapunov_spectrum(&equations, &start, &how));
        let gradients = ByGradients::new(system.map(Gradient::<f64, 4>::constant), tolerance);
        timed("gradients, Taylor", &|| lyapunov_spectrum(&gradients, &start, &how));
        let one = ByVariationalEquations::<_, 4>::new(&system, tolerance);
        timed("variational, DOP853, largest alone", &|| lyapunov_spectrum(&one, &start, &how));
        let one = ByGradients::new(system.map(Gradient::<f64, 1>::constant), tolerance);
        timed("gradients, Taylor, largest alone", &|| lyapunov_spectrum(&one, &start, &how));
    }
}

fn main() {
    println!(
        "| motion | way | 1e-4 | 1e-6 | 1e-8 | 1e-10 | 1e-12 | 1e-13 | 1e-14 | least error | symplectic to |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    pendulum().measure::<3, 2>();
    kepler().measure::<10, 4>();
    double_pendulum().measure::<10, 4>();
    if std::env::args().skip(1).all(|word| word == "--bench") {
        println!(
            "\n| tolerance | way | an interval | largest exponent | sum of all |\n|---|---|---|---|---|"
        );
        spectrum();
    }
}
