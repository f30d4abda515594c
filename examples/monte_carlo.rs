//! Which double pendulums turn over, and when? Their release is uniform over all pairs of angles.
//!
//! Energy forbids it near the bottom: with equal rods and bobs no arm can reach the top where 2 cos a + cos b > 1. Outside
//! of that lens, what happens is a matter of chaos. The picture has a point for each sample that turns over; the share is
//! given with its error, from sixteen independent scramblings of a Sobol sequence.
//!
//! `cargo run --release --example monte_carlo`; stop it, start it again, and it goes on where it was.

#[path = "support/mod.rs"]
mod support;

use indicatif::{ProgressBar, ProgressStyle};
use lagrange_runtime::chart::{Axis, Chart, Series, Style};
use lagrange_runtime::ensemble::{Collect, Ensemble, Moments, Present, Quantiles, Sobol, Statistic, of};
use lagrange_runtime::prelude::*;
use std::cell::Cell;
use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::time::Duration;

lagrangian! {
    /// Two equal bobs on equal light rods; angles from the downward vertical.
    pub system DoublePendulum {
        param m, l, g = 9.81;
        coord a, b;
        let x1 = l * sin(a);
        let y1 = -l * cos(a);
        let x2 = x1 + l * sin(b);
        let y2 = y1 - l * cos(b);
        T = 0.5 * m * (dot(x1).powi(2) + dot(y1).powi(2) + dot(x2).powi(2) + dot(y2).powi(2));
        V = m * g * (y1 + y2);
    }
}

/// The angles of release, and the time at which an arm first passes through the top.
type Output = ([f64; 2], Option<f64>);

const END: f64 = 20.0;
const SEEDS: u64 = 16;
const SAMPLES: u64 = 2048;
const TIMES: Quantiles = Quantiles::to(0.01);

fn main() -> Result<(), Box<dyn Error>> {
    let folder = support::charts()?;
    let bar = ProgressBar::new(SEEDS * SAMPLES)
        .with_style(ProgressStyle::with_template("{bar:40} {percent} %, {msg}")?);
    let mut shares = Vec::new();
    let mut times = TIMES.empty();
    let mut outputs = Vec::new();
    let (computed, seconds) = (Cell::new(0), Cell::new(0.0));
    let mut checkpoints = Vec::new();
    for seed in 0..SEEDS {
        let (before, seconds_before) = (computed.get(), seconds.get());
        let checkpoint = folder.join(format!("monte-carlo-{seed}.checkpoint"));
        let study = Ensemble::new(Sobol::<2>::seed(seed), SAMPLES, |[u, v]| {
            (DoublePendulum::new(0.5, 1.0), State::new(0.0, [TAU * u - PI, TAU * v - PI], [0.0, 0.0]))
        })
        .integrate(Dop853, Pi::tolerance(1e-9), END)
        .named("turns over")
        .checkpoint(&checkpoint, Duration::from_secs(1))
        .progress(|progress| {
            computed.set(before + progress.done - progress.resumed);
            seconds.set(seconds_before + progress.elapsed.as_secs_f64());
            bar.set_position(seed * SAMPLES + progress.done);
            bar.set_message(format!("{:.0} samples/s", progress.rate().unwrap_or(0.0)));
        });
        let outcome = study.reduce(
            |_, run| {
                let release = [run.start().q[0], run.start().q[1]];
                let over =
                    |k: usize| Event::falling(move |s: &State<f64, 2>| (0.5 * s.q[k]).cos()).terminal();
                let first = run.events((over(0), over(1))).next().transpose()?;
                Ok((release, first.map(|first| first.state.t)))
            },
            (
                of(|output: &Output| f64::from(u8::from(output.1.is_some())), Moments),
                of(|output: &Output| output.1, Present(TIMES)),
                Collect,
            ),
        )?;
        for failed in &outcome.failures.kept {
            bar.println(format!("seed {seed}, {failed}"));
        }
        let (share, sketch, collected) = outcome.statistic;
        shares.push(share.mean());
        TIMES.merge(&mut times, sketch);
        outputs.extend(collected.rows.into_iter().map(|(_, output)| output));
        checkpoints.push(checkpoint);
    }
    bar.finish_and_clear();

    let mut share = Moments.empty();
    shares.iter().zip(0..).for_each(|(mean, seed)| Moments.add(&mut share, seed, mean));
    println!("{} samples, {:.0} samples/s", SEEDS * SAMPLES, computed.get() as f64 / seconds.get());
    println!(
        "{:.2} % ± {:.2} % turn over within {END} s; of independent samples the error would be {:.2} %",
        100.0 * share.mean(),
        100.0 * share.standard_error(),
        100.0 * (share.mean() * (1.0 - share.mean()) / (SEEDS * SAMPLES) as f64).sqrt(),
    );
    for (name, p) in [("a tenth", 0.1), ("half", 0.5), ("nine tenths", 0.9)] {
        if let Some(time) = times.quantile(p) {
            println!("{name} of these by {time:.2} s (to 1 %)");
        }
    }
    let forbidden = |[a, b]: [f64; 2]| 2.0 * a.cos() + b.cos() > 1.0;
    let against = outputs.iter().filter(|(release, time)| time.is_some() && forbidden(*release)).count();
    println!("{against} of them against the law of energy");

    chart(&outputs).write(&folder, "monte-carlo")?;
    println!("{}", folder.join("monte-carlo.png").display());
    // All is said: the next run begins anew.
    checkpoints.iter().try_for_each(std::fs::remove_file)?;
    Ok(())
}

/// A point for each release that turns over, by its time; and the border of what energy allows.
fn chart(outputs: &[Output]) -> Chart {
    let between = |low: f64, high: f64| {
        let points = outputs.iter().filter(|(_, time)| time.is_some_and(|time| low <= time && time < high));
        Series::markers(format!("{low} to {high} s"), points.map(|([a, b], _)| (*a, *b)))
    };
    // 2 cos a + cos b = 1, above and back below.
    let border = |sign: f64| {
        (-400..=400).map(move |k| {
            let a = sign * 0.5 * PI * f64::from(k) / 400.0;
            (a, sign * (1.0 - 2.0 * a.cos()).clamp(-1.0, 1.0).acos())
        })
    };
    let lens = Series { style: Style::Context, ..Series::new("", border(1.0).chain(border(-1.0))) };
    let chart = Chart::new(
        "Double pendulums that turn over",
        Axis::linear("first angle at release", "rad"),
        Axis::linear("second angle at release", "rad"),
    )
    .subtitle(format!(
        "by the time of it; {} Sobol points; inside the grey line energy forbids it",
        outputs.len()
    ))
    .equal_aspect()
    .with(lens);
    [(0.0, 1.0), (1.0, 2.0), (2.0, 5.0), (5.0, END)]
        .into_iter()
        .fold(chart, |chart, (low, high)| chart.with(between(low, high)))
}
