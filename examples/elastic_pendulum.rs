//! A driven pendulum on a spring: the path of its mass, and a picture that moves. The first chapter of the guide.
//!
//! `cargo run --release --example elastic_pendulum`

use lagrange_runtime::chart::{Animation, Axis, Chart, Part, Series};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A mass on a spring that swings.
    pub system ElasticPendulum {
        param m, k, l, c, push, w, g = 9.81;
        coord r: length, theta: angle;
        let x = r * sin(theta);
        let y = -r * cos(theta);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y + 0.5 * k * (r - l).powi(2);
        D = 0.5 * c * dot(r).powi(2);
        Q[theta] = push * r * cos(w * t);
        observe place = [x, y];
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pendulum = ElasticPendulum { m: 1.0, k: 40.0, l: 0.5, c: 0.05, push: 0.4, w: 3.0, g: 9.81 };
    let start = State::new(0.0, [0.75, 0.4], [0.0, 0.0]);

    let run = integrate(&pendulum, Dop853, PiController::tolerance(1e-10), start).until(10.0);
    let states = run.sample_evenly(500).collect::<Result<Vec<_>, _>>()?;
    let place = |at: &State<f64, 2>| (pendulum.place_at(at)[0], pendulum.place_at(at)[1]);
    let path: Vec<(f64, f64)> = states.iter().map(place).collect();

    let folder = std::env::temp_dir();
    Chart::new("Elastic pendulum", Axis::linear("x", "m"), Axis::linear("y", "m"))
        .equal_aspect()
        .with(Series::line("", path.clone()))
        .write(&folder, "elastic-pendulum")?;
    Animation::new("Elastic pendulum", 10.0)
        .with(Part::bars("spring", path.iter().map(|&at| vec![(0.0, 0.0), at])))
        .with(Part::joints("mass", path.iter().map(|&at| vec![at])).width(18.0).colour(1)) // pixels
        .write(&folder, "elastic-pendulum-moving")?; // this picture moves in a browser
    println!("{}", folder.join("elastic-pendulum-moving.svg").display());
    Ok(())
}
