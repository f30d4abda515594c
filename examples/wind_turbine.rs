//! A wind turbine in a measured wind: the wind is a curve, and the power coefficient of its rotor a map of tip-speed
//! ratio and pitch. Both are fields of the system.
//!
//! The generator takes the torque K ω², which leads to the tip-speed ratio of greatest power (Burton and others,
//! *Wind Energy Handbook*, 2011, section 8.3). The map is that of Heier (*Grid Integration of Wind Energy*, 1998) at
//! 31 × 9 places, so that the motion by the table is compared with that by the formula.
//!
//! `cargo run --release --example wind_turbine`

#[path = "support/mod.rs"]
mod support;

use lagrange_runtime::analysis::StateSpace;
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::PI;

lagrangian! {
    /// The rotor of a turbine of 5 MW.
    pub system Turbine {
        param J = 4e7, R = 63.0, rho = 1.225;
        /// Torque of the generator over ω².
        param K;
        /// Pitch of the blades, in degrees.
        input pitch;
        coord phi: angle;
        /// Speed of the wind, in m/s.
        extern wind: Curve(t);
        /// Power of the rotor over that of the wind.
        extern power_coefficient: Surface(ratio, pitch);
        let v = wind(t);
        let ratio = R * dot(phi) / v;
        let taken = 0.5 * rho * PI * R.powi(2) * power_coefficient(ratio, pitch) * v.powi(3);
        T = 0.5 * J * dot(phi).powi(2);
        V = 0;
        Q[phi] = taken / dot(phi) - K * dot(phi).powi(2);
        observe ratio;
        observe taken;
        observe generated = K * dot(phi).powi(3);
    }
}

lagrangian! {
    /// The same by Heier's formula.
    pub system Formula {
        param J = 4e7, R = 63.0, rho = 1.225, K;
        input pitch;
        coord phi: angle;
        extern wind: Curve(t);
        let v = wind(t);
        let ratio = R * dot(phi) / v;
        let s = 1 / (ratio + 0.08 * pitch) - 0.035 / (pitch.powi(3) + 1);
        let coefficient = 0.5176 * (116 * s - 0.4 * pitch - 5) * exp(-21 * s) + 0.0068 * ratio;
        T = 0.5 * J * dot(phi).powi(2);
        V = 0;
        Q[phi] = 0.5 * rho * PI * R.powi(2) * coefficient * v.powi(3) / dot(phi) - K * dot(phi).powi(2);
    }
}

/// Heier's power coefficient.
fn heier(ratio: f64, pitch: f64) -> f64 {
    let s = 1.0 / (ratio + 0.08 * pitch) - 0.035 / (pitch.powi(3) + 1.0);
    0.5176 * (116.0 * s - 0.4 * pitch - 5.0) * (-21.0 * s).exp() + 0.0068 * ratio
}

/// Wind of five minutes, by its means of ten seconds.
const WIND: [f64; 31] = [
    8.1, 8.4, 7.9, 8.8, 9.6, 9.1, 8.5, 7.7, 7.2, 7.4, 8.0, 9.3, 10.2, 10.6, 10.1, 9.0, 8.2, 8.6, 9.4, 9.9,
    9.2, 8.3, 7.5, 7.1, 7.8, 8.9, 9.7, 10.0, 9.5, 8.7, 8.2,
];

/// Draws the wind and the rotor that follows it.
pub fn main() -> Result<(), Box<dyn Error>> {
    let times: Vec<f64> = (0..WIND.len()).map(|i| 10.0 * i as f64).collect();
    let wind = Curve::cubic(&times, &WIND, Beyond::Refused)?;
    let ratios: Vec<f64> = (0..31).map(|i| 3.0 + 0.4 * f64::from(i)).collect();
    let pitches: Vec<f64> = (0..9).map(|i| 0.25 * f64::from(i)).collect();
    let map: Vec<f64> = ratios.iter().flat_map(|r| pitches.iter().map(|p| heier(*r, *p))).collect();
    let coefficient = Surface::cubic(&ratios, &pitches, &map, Beyond::Refused)?;

    // The place of the greatest power coefficient without pitch, where the spline has no slope.
    let slope =
        |r: f64| coefficient.at(Dual::variable(Dual::variable(r)), Dual::constant(Dual::constant(0.0)));
    let best = (0..20).fold(8.0, |r: f64, _| r - slope(r).slope.value / slope(r).slope.slope);
    let greatest = coefficient.at(best, 0.0);
    println!("the greatest power coefficient is {greatest:.4}, at a tip-speed ratio of {best:.3}");
    assert!((best - 8.1).abs() < 0.02 && (greatest - 0.48).abs() < 1e-3);

    let torque = 0.5 * 1.225 * PI * 63f64.powi(5) * greatest / best.powi(3);
    let turbine = Turbine::new(torque, wind.clone(), coefficient);
    let start = State::new(0.0, [0.0], [best * WIND[0] / turbine.R]);
    let run = || integrate(&turbine, Dop853, PiController::tolerance(1e-9), start).until(300.0);
    let states = run().sample_evenly(600).collect::<Result<Vec<_>, _>>()?;
    let end = states.last().ok_or("no samples")?;
    let at = |s: &State<f64, 1>| [turbine.taken_at(s), turbine.generated_at(s)];

    // What the generator takes is what the wind gives, less the change of the kinetic energy.
    let work = run().integrals([0.0; 2], at).total()?.integrals;
    let balance = work[0] - work[1] - (turbine.energy_at(end) - turbine.energy_at(&start));
    let available = run().integrals([0.0], |s| {
        [0.5 * turbine.rho * PI * turbine.R.powi(2) * greatest * turbine.wind.at(s.t).powi(3)]
    });
    let share = work[0] / available.total()?.integrals[0];
    println!("generated {:.1} kWh; the rotor takes {:.2} % of the best", work[1] / 3.6e6, 100.0 * share);
    assert!(balance.abs() < 1e-6 * work[0] && share > 0.97 && share < 1.0);

    // The table against the formula.
    let formula = Formula::new(torque, wind);
    let reference =
        integrate(&formula, Dop853, PiController::tolerance(1e-11), start).until(300.0).final_state()?;
    println!(
        "the table and the formula differ by {:.1e} of the speed",
        (end.qd[0] / reference.qd[0] - 1.0).abs()
    );
    assert!((end.qd[0] / reference.qd[0] - 1.0).abs() < 1e-4);

    // A rotor that is faster than it should be becomes slower, and pitch takes power.
    let model = StateSpace::about(&turbine, end)?;
    println!("dω̇/dω = {:.4}/s, dω̇/dpitch = {:.2e} rad/s² per degree", model.a[(1, 1)], model.b[(1, 0)]);
    assert!(model.a[(1, 1)] < 0.0 && model.b[(1, 0)] < 0.0);

    let ideal = states.iter().map(|s| (s.t, best * turbine.wind.at(s.t) / turbine.R * 60.0 / (2.0 * PI)));
    let chart = Chart::new(
        "A wind turbine follows a measured wind",
        Axis::linear("time t", "s"),
        Axis::linear("speed of the wind (m/s), of the rotor (1/min)", ""),
    )
    .subtitle("a cubic spline through means of ten seconds, and a map of the power coefficient")
    .with(Series::line("wind", states.iter().map(|s| (s.t, turbine.wind.at(s.t)))))
    .with(Series::line("rotor", states.iter().map(|s| (s.t, s.qd[0] * 60.0 / (2.0 * PI)))))
    .with(Series::line("rotor of the greatest power", ideal));
    let folder = support::charts()?;
    chart.write(&folder, "wind-turbine")?;
    println!("{}", folder.join("wind-turbine.png").display());
    Ok(())
}
