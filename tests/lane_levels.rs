//! Runs in lanes have the same bits whatever instructions they are compiled for, and those of a run alone. In a
//! release build this holds every kind of processor that runs are compiled for; other builds compile them for the
//! least one.

use lagrange_runtime::ensemble::{Collect, Ensemble, Table};
use lagrange_runtime::lanes::{FinalState, Fused, Level, Plain, SingleLane};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// Falls through 0, below which there is no potential.
    system Particle {
        param k;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * (x - 1).powi(2) + 0.01 * x.sqrt();
        Q[x] = -0.1 * (3 * t).sin();
    }
}

const SAMPLES: u64 = 37;

/// Every fifth one falls.
fn draw([number]: [u64; 1]) -> (Particle, State<f64, 1>) {
    let (x, v) = (1.0 + 0.01 * number as f64, if number % 5 == 2 { -3.0 } else { 0.3 });
    (Particle::new(1.0 + 0.1 * number as f64), State::new(0.0, [x], [v]))
}

lagrangian! {
    /// A bounded motion on which every elementary function with a kernel acts.
    system Menagerie {
        param k;
        coord x;
        let y = x + 3;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2)
            + 0.01 * (x.tan() + (0.3 * x).asin() + (0.3 * x).acos() + x.atan() + x.atan2(y) + x.sinh() + x.cosh() + x.tanh()
                + x.asinh() + y.acosh() + (0.3 * x).atanh() + x.exp() + x.exp_m1() + x.exp2() + y.ln() + y.ln_1p() + y.log2()
                + y.log10() + y.cbrt() + y.sqrt() + x.hypot(y) + y.powf(1.7) + abs(y));
        Q[x] = -0.1 * (3 * t).sin() * x.cos();
    }
}

fn draw_menagerie([number]: [u64; 1]) -> (Menagerie, State<f64, 1>) {
    (Menagerie::new(4.0 + 0.1 * number as f64), State::new(0.0, [0.3 + 0.01 * number as f64], [0.4]))
}

macro_rules! same_on_all {
    ($draw:ident, $failures:pat => $($policy:ident $method:expr, $controller:expr;)*) => {$({
        let samples = Table::new((0..SAMPLES).map(|number| [number]));
        let lanes = || Ensemble::new(samples.clone(), SAMPLES, $draw).integrate($method, $controller, 3.0).threads(1).in_lanes($policy);
        let watch = FinalState(|_: &_, end: &State<f64, 1>| [end.t, end.q[0], end.qd[0]].map(f64::to_bits));
        for level in Level::compiled() {
            let outcome = lanes().level(level).observe(&watch, Collect).expect("a sound study");
            let (mut good, mut failed) = (outcome.statistic.rows.iter(), outcome.failures.kept.iter());
            for index in 0..SAMPLES {
                match lanes().replay(index).expect("a sample").run().final_state() {
                    Ok(end) => {
                        let end = [end.t, end.q[0], end.qd[0]].map(|x| SingleLane::value(x).to_bits());
                        assert_eq!(good.next(), Some(&(index, end)), "{level:?}, {:?}", $method);
                    }
                    Err(end) => {
                        let found = failed.next().expect("a failure");
                        let last = found.last.expect("known").q[0].to_bits();
                        assert_eq!((found.index, last), (index, end.last.q[0].value().to_bits()));
                    }
                }
            }
            assert!(good.next().is_none() && failed.next().is_none());
            assert!(matches!(outcome.failures.count, $failures), "{}", outcome.failures.count);
        }
    })*};
}

#[test]
fn runs_have_the_same_bits_on_all_processors() {
    same_on_all! {
        draw, 6..=8 =>
        Fused Dop853, PiController::tolerance(1e-9);
        Plain Dop853, PiController::tolerance(1e-9);
        Fused Rk4, FixedStep::new(0.01);
        Fused Taylor, TaylorController::tolerance(1e-12);
        Fused Radau5, PiController::tolerance(1e-6);
        Fused Gauss4, FixedStep::new(0.02);
    }
}

/// Kernels and series, compiled for each kind of processor, and against the standard library's functions.
#[test]
fn functions_and_series_have_the_same_bits_on_all_processors() {
    same_on_all! {
        draw_menagerie, 0 =>
        Fused Dop853, PiController::tolerance(1e-12);
        Plain Dop853, PiController::tolerance(1e-12);
        Fused Taylor, TaylorController::tolerance(1e-12);
    }
    let samples = Table::new((0..SAMPLES).map(|number| [number]));
    let lanes = Ensemble::new(samples, SAMPLES, draw_menagerie)
        .integrate(Taylor, TaylorController::tolerance(1e-13), 3.0)
        .in_lanes(Fused)
        .observe(&FinalState(|_: &Menagerie, end: &State<f64, 1>| [end.q[0], end.qd[0]]), Collect)
        .expect("a sound study");
    for (index, found) in lanes.statistic.rows {
        let (system, start) = draw_menagerie([index]);
        let end = integrate(&system, Verner9, PiController::tolerance(1e-13), start)
            .until(3.0)
            .final_state()
            .expect("an end");
        let error = (found[0] - end.q[0]).abs().max((found[1] - end.qd[0]).abs());
        assert!(error < 1e-10, "{index}: {error:e}");
    }
}
