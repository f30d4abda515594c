//! Length and friction of a pendulum from measured angles, by Gauss–Newton with exact derivatives.
//!
//! `cargo run --release --example identification`
//!
//! The measurement is made here: known values, and normal noise. Its standard deviation, the number of angles and the
//! derivatives give the standard errors of the fit, σ² (JᵀJ)⁻¹.

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::ensemble::rand_distr::{Distribution, Normal};
use lagrange_runtime::ensemble::{Random, Source};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// A pendulum of unit mass with friction in its hinge, from the downward vertical.
    pub system Pendulum {
        param l, c, g = 9.81;
        coord theta: angle;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -g * l * cos(theta);
        D = 0.5 * c * dot(theta).powi(2);
    }
}

/// Angles measured in six seconds.
const SAMPLES: u32 = 200;
const END: f64 = 6.0;

/// Angles at equal times, with their derivatives by the length and the friction.
fn predicted([l, c]: [f64; 2]) -> Result<Vec<Gradient<f64, 2>>, Failure<Gradient<f64, 2>>> {
    let [l, c] = Gradient::variables([l, c]);
    let pendulum = Pendulum { l, c, ..Pendulum::new(1.0, 0.0).map(Gradient::constant) };
    let start = State::new(0.0, [1.5], [0.0]).map(Gradient::constant);
    let run =
        integrate(&pendulum, Dop853, PiController::tolerance(1e-10), start).until(Gradient::constant(END));
    run.sample_evenly(SAMPLES).map(|at| Ok(at?.q[0])).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let (truth, sigma) = ([0.8, 0.05], 0.05);
    let (mut random, noise) = (Random::seed(7).draw(0), Normal::new(0.0, sigma)?);
    let measured: Vec<f64> =
        predicted(truth)?.iter().map(|angle| angle.value + noise.sample(&mut random)).collect();

    let squares = |fit| -> Result<f64, Failure<Gradient<f64, 2>>> {
        Ok(predicted(fit)?.iter().zip(&measured).map(|(angle, m)| (angle.value - m).powi(2)).sum())
    };
    let guess = [0.9, 0.1];
    let (mut fit, mut covariance, mut converged) = (guess, SMatrix::<f64, 2, 2>::zeros(), false);
    for iteration in 0..30 {
        // Normal equations JᵀJ δ = −Jᵀ r.
        let (mut normal, mut right) = (SMatrix::<f64, 2, 2>::zeros(), SVector::<f64, 2>::zeros());
        for (angle, measured) in predicted(fit)?.iter().zip(&measured) {
            let slopes = SVector::from(angle.slopes);
            normal += slopes * slopes.transpose();
            right -= slopes * (angle.value - measured);
        }
        let inverse = normal.try_inverse().ok_or("the angles do not depend on a parameter")?;
        covariance = inverse * sigma * sigma;
        // A step is halved until it lowers the sum of squares.
        let (mut change, before) = (inverse * right, squares(fit)?);
        converged = change.amax() < 1e-9;
        while !converged && squares([fit[0] + change[0], fit[1] + change[1]])? >= before {
            change *= 0.5;
        }
        fit = [fit[0] + change[0], fit[1] + change[1]];
        println!("{iteration:2}  l = {:.6} m  c = {:.6} N m s", fit[0], fit[1]);
        if converged {
            break;
        }
    }

    let errors = [0, 1].map(|i| covariance[(i, i)].sqrt());
    let mut checks = Checks::default();
    checks.holds("the fit has converged", converged);
    for (i, name) in ["length", "friction"].into_iter().enumerate() {
        println!("{name}: {:.5} ± {:.5}, truth {}", fit[i], errors[i], truth[i]);
        checks.at_most(
            format!("error of the {name} in standard errors"),
            (fit[i] - truth[i]).abs() / errors[i],
            3.0,
        );
    }
    // χ² of 199 degrees of freedom has a standard deviation of 20.
    checks.at_most("χ² beside its mean", (squares(fit)? / (sigma * sigma) - 199.0).abs(), 60.0);

    let time = |k: usize| END * k as f64 / f64::from(SAMPLES);
    let curve = |parameters| {
        let angles = predicted(parameters)?;
        Ok::<_, Failure<Gradient<f64, 2>>>(
            angles.into_iter().enumerate().map(|(k, a)| (time(k), a.value)).collect::<Vec<_>>(),
        )
    };
    let folder = support::charts()?;
    let title = "Length and friction of a pendulum from its motion";
    let [length, friction] = [0, 1].map(|i| format!("{:.4} ± {:.4}", fit[i], errors[i]));
    Chart::new(title, Axis::linear("time", "s"), Axis::linear("angle", "rad"))
        .subtitle(format!(
            "l = {length} m, c = {friction} N m s from {} angles with noise of {sigma} rad",
            measured.len()
        ))
        .with(Series::line("fit", curve(fit)?))
        .with(Series::line("first guess", curve(guess)?))
        .with(Series::markers("measured", measured.iter().enumerate().map(|(k, &angle)| (time(k), angle))))
        .write(&folder, "identification")?;
    println!("{}", folder.join("identification.svg").display());
    Ok(checks.report()?)
}
