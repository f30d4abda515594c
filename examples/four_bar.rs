//! A four-bar linkage, driven by a motor: a crank that turns, a rocker that swings, and between them a coupler, each
//! point of which draws a curve of sixth order.
//!
//! The bars are written as three that turn freely, and the pin between coupler and rocker as a constraint, whose
//! multipliers are the force in it. That the crank can turn is Grashof's condition (1883): shortest and longest bar
//! together are no longer than the other two. Where the bars are for each angle of the crank, a triangle tells
//! (Shigley and Uicker, *Theory of Machines and Mechanisms*, 1995, ch. 2), and the run is held against it.
//!
//! `cargo run --release --example four_bar` draws the coupler curve, the motion and the force in the pin.

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::{Checks, table};
use lagrange_runtime::chart::{Animation, Axis, Chart, Panels, Part, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;
use std::f64::consts::{PI, TAU};

lagrangian! {
    /// Uniform bars; the crank turns about the origin, the rocker about (d, 0). φ, ψ, χ: crank, coupler and rocker
    /// against the x-axis; y is up.
    pub system FourBar {
        /// Lengths of crank, coupler, rocker, and of the frame between the pivots.
        param a, b, c, d;
        /// Masses of crank, coupler and rocker; a flywheel on the crank.
        param ma, mb, mc, flywheel;
        /// Torque of the motor at rest, and its speed without load.
        param torque, no_load;
        /// Point of the coupler: along it from the crank, and beside it.
        param along, beside;
        param g = 9.81;
        coord phi: angle, psi: angle, chi: angle;
        let x = a * phi.cos() + 0.5 * b * psi.cos();
        let y = a * phi.sin() + 0.5 * b * psi.sin();
        T = 0.5 * (flywheel + ma * a.powi(2) / 3) * dot(phi).powi(2)
            + 0.5 * mb * (dot(x).powi(2) + dot(y).powi(2) + b.powi(2) / 12 * dot(psi).powi(2))
            + 0.5 * (mc * c.powi(2) / 3) * dot(chi).powi(2);
        V = g * (0.5 * ma * a * phi.sin() + mb * y + 0.5 * mc * c * chi.sin());
        Q[phi] = torque * (1 - dot(phi) / no_load);
        constraint pin: [a * phi.cos() + b * psi.cos(), a * phi.sin() + b * psi.sin()]
            == [d + c * chi.cos(), c * chi.sin()];
        observe crank = [a * phi.cos(), a * phi.sin()];
        observe rocker = [d + c * chi.cos(), c * chi.sin()];
        observe point = [
            a * phi.cos() + along * psi.cos() - beside * psi.sin(),
            a * phi.sin() + along * psi.sin() + beside * psi.cos(),
        ];
        /// Force of the rocker on the coupler.
        observe pin_force = reaction(pin);
    }
}

/// Coupler and rocker for an angle of the crank: the triangle of crank pin, rocker pin and pivot of the rocker.
fn closed(bars: &FourBar, phi: f64) -> [f64; 2] {
    let (x, y) = (bars.d - bars.a * phi.cos(), -bars.a * phi.sin());
    let f = x.hypot(y);
    let psi = y.atan2(x) + ((bars.b.powi(2) + f * f - bars.c.powi(2)) / (2.0 * bars.b * f)).acos();
    [psi, (bars.b * psi.sin() - y).atan2(bars.b * psi.cos() - x)]
}

/// Residual of the balance of moments: of the coupler about the crank pin, of the rocker about its pivot.
fn moments(bars: &FourBar, at: &State<f64, 3>) -> [f64; 2] {
    let cross = |u: [f64; 2], v: [f64; 2]| u[0] * v[1] - u[1] * v[0];
    let along = |length: f64, angle: f64| [length * angle.cos(), length * angle.sin()];
    let force: [f64; 2] = bars.pin_force_at(at).into();
    let [phi, psi, chi]: [f64; 3] = at.q.into();
    let acceleration = bars.accel_at(at);
    let (inward, forward) = (-bars.a * at.qd[0].powi(2), bars.a * acceleration[0]);
    let crank_pin = [inward * phi.cos() - forward * phi.sin(), inward * phi.sin() + forward * phi.cos()];
    let coupler = bars.mb * bars.b.powi(2) / 3.0 * acceleration[1]
        + bars.mb * cross(along(0.5 * bars.b, psi), [crank_pin[0], crank_pin[1] + bars.g])
        - cross(along(bars.b, psi), force);
    let rocker = bars.mc * bars.c.powi(2) / 3.0 * acceleration[2]
        + bars.mc * cross(along(0.5 * bars.c, chi), [0.0, bars.g])
        + cross(along(bars.c, chi), force);
    [coupler, rocker]
}

/// The run up to the state in which the crank has this angle.
fn turned(bars: &FourBar, from: State<f64, 3>, phi: f64) -> Result<State<f64, 3>, Box<dyn Error>> {
    let run = integrate(bars, Dop853, PiController::tolerance(1e-12), from).until(from.t + 10.0);
    let end = run.events(Event::rising(|at: &State<f64, 3>| at.q[0] - phi).terminal()).next();
    Ok(end.ok_or("the motor does not turn the crank")??.state)
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let bars = FourBar::new(0.12, 0.32, 0.25, 0.3, 0.4, 0.9, 0.7, 0.01, 6.0, 14.0, 0.2, 0.18);
    let mut checks = Checks::default();
    let mut lengths = [bars.a, bars.b, bars.c, bars.d];
    lengths.sort_by(f64::total_cmp);
    let [shortest, s, l, longest] = lengths;
    println!("shortest and longest bar {:.2} m, the other two {:.2} m", shortest + longest, s + l);
    checks.holds("Grashof: the crank turns", shortest + longest < s + l && shortest == bars.a);
    let operations = FourBar::<f64>::FACTS.operations;
    println!(
        "{} operations and {} sine-cosine pairs, {:.1} operations a link",
        operations.arithmetic(),
        operations.sin_cos,
        operations.arithmetic() as f64 / 3.0
    );

    // From rest, over five turns.
    let [psi, chi] = closed(&bars, 0.0);
    let start = State::new(0.0, [0.0, psi, chi], [0.0; 3]);
    let end = turned(&bars, start, 5.0 * TAU)?;
    let mut run = integrate(&bars, Dop853, PiController::tolerance(1e-12), start)
        .until(end.t)
        .integrals([0.0], |at| [bars.power_at(at)]);
    let [mut loose, mut apart, mut work, mut moment] = [0.0_f64; 4];
    for total in &mut run {
        let total = total?;
        let State { t, q, qd } = total.state;
        loose = loose.max(bars.constraints(&q, t).amax()).max(bars.constraint_rates(&q, &qd, t).amax());
        for (angle, exact) in [q[1], q[2]].into_iter().zip(closed(&bars, q[0])) {
            apart = apart.max((angle - exact).abs());
        }
        let gained = bars.energy(&q, &qd, t) - bars.energy_at(&start);
        work = work.max((gained - total.integrals[0]).abs());
        moment = moments(&bars, &total.state).into_iter().fold(moment, |most, m| most.max(m.abs()));
    }
    checks.at_most("constraint and its rate (m, m/s)", loose, 1e-12);
    checks.at_most("angles against the triangle (rad)", apart, 1e-11);
    checks.at_most("energy against the work of the motor (J)", work, 1e-9);
    checks.at_most("balances of moments with the force in the pin (N m)", moment, 1e-10);

    // The rocker turns back where crank and coupler lie in one line.
    let run = integrate(&bars, Dop853, PiController::tolerance(1e-12), end).until(end.t + 1.0);
    let turns = run.events(Event::either(|at: &State<f64, 3>| at.qd[2])).collect::<Result<Vec<_>, _>>()?;
    let limit = |reach: f64| {
        PI - ((bars.d.powi(2) + bars.c.powi(2) - reach.powi(2)) / (2.0 * bars.d * bars.c)).acos()
    };
    let limits = [limit(bars.b - bars.a), limit(bars.b + bars.a)];
    let off = |chi: f64| limits.map(|limit| (chi - limit).abs()).into_iter().fold(f64::INFINITY, f64::min);
    let ends: Vec<f64> = turns.iter().map(|turn| turn.state.q[2]).collect();
    checks.holds("the rocker turns back again and again", ends.len() >= 3);
    checks.at_most("where it turns back (rad)", ends.into_iter().map(off).fold(0.0, f64::max), 1e-10);

    // The sixth turn, drawn.
    let last = turned(&bars, end, 6.0 * TAU)?;
    let run = integrate(&bars, Dop853, PiController::tolerance(1e-11), end).until(last.t);
    let states = run.sample_evenly(120).collect::<Result<Vec<_>, _>>()?;
    let crank_angle = |at: &State<f64, 3>| (at.q[0] - 5.0 * TAU).to_degrees();
    let force = |at: &State<f64, 3>| bars.pin_force_at(at).norm();
    println!(
        "{}",
        table(
            ["crank (°)", "coupler (°)", "rocker (°)", "speed of the crank (rad/s)", "force in the pin (N)"],
            states.iter().step_by(20).map(|at| [
                format!("{:.2}", crank_angle(at)),
                format!("{:.3}", at.q[1].to_degrees()),
                format!("{:.3}", at.q[2].to_degrees()),
                format!("{:.3}", at.qd[0]),
                format!("{:.2}", force(at)),
            ])
        )
    );

    let place =
        |at: &State<f64, 3>,
         what: fn(&FourBar, &SVector<f64, 3>, &SVector<f64, 3>, f64) -> SVector<f64, 2>| {
            let [x, y]: [f64; 2] = what(&bars, &at.q, &at.qd, at.t).into();
            (x, y)
        };
    let (crank, rocker, point) = (
        |at: &State<f64, 3>| place(at, FourBar::crank),
        |at: &State<f64, 3>| place(at, FourBar::rocker),
        |at: &State<f64, 3>| place(at, FourBar::point),
    );
    let (origin, pivot) = ((0.0, 0.0), (bars.d, 0.0));
    let outline =
        |at: &State<f64, 3>| vec![origin, crank(at), point(at), rocker(at), crank(at), rocker(at), pivot];
    let folder = support::charts()?;
    let mut curve =
        Chart::new("Coupler curve", Axis::linear("x", "m"), Axis::linear("y", "m")).equal_aspect();
    for at in states.iter().step_by(30).take(4) {
        curve = curve.with(Series::context(outline(at)));
    }
    let curve = curve.with(Series::line("", states.iter().map(point)));
    let against = |value: &dyn Fn(&State<f64, 3>) -> f64| -> Vec<(f64, f64)> {
        states.iter().map(|at| (crank_angle(at), value(at))).collect()
    };
    let angle = || Axis::linear("angle of the crank", "°");
    let exact = (0..=24).map(|k| 15.0 * f64::from(k));
    let exact = exact.map(|phi: f64| (phi, closed(&bars, phi.to_radians())[1].to_degrees()));
    Panels::new(
        "A four-bar linkage",
        [
            curve,
            Chart::new("Rocker", angle(), Axis::linear("angle of the rocker", "°"))
                .with(Series::line("run", against(&|at| at.q[2].to_degrees())))
                .with(Series::markers("triangle", exact)),
            Chart::new("Crank", angle(), Axis::linear("speed", "rad/s"))
                .with(Series::line("", against(&|at| at.qd[0]))),
            Chart::new("Pin between coupler and rocker", angle(), Axis::linear("force", "N"))
                .with(Series::line("", against(&force))),
        ],
    )
    .subtitle("crank 12, coupler 32, rocker 25, frame 30 cm, driven by a motor; its sixth turn from rest")
    .write(&folder, "four-bar-turn")?;

    let triangle = states.iter().map(|at| vec![crank(at), rocker(at), point(at)]);
    let pins = states.iter().map(|at| vec![crank(at), rocker(at), point(at)]);
    Animation::new("A four-bar linkage", last.t - end.t)
        .subtitle("a motor drives the crank, on the left; a point of the coupler draws the curve; an eighth of its speed")
        .speed(0.125)
        .with(Part::path("frame", [origin, pivot]).width(5.0))
        .with(Part::path("coupler curve", states.iter().map(point)).width(2.5).colour(6))
        .with(Part::body("coupler", triangle).width(5.0).colour(2))
        .with(Part::bars("rocker", states.iter().map(|at| vec![pivot, rocker(at)])).width(9.0))
        .with(Part::bars("crank", states.iter().map(|at| vec![origin, crank(at)])).width(9.0).colour(1))
        .with(Part::joints("pins", pins).width(10.0).colour(4))
        .with(Part::joints("pivots", [vec![origin, pivot]]).width(18.0).colour(7))
        .write(&folder, "four-bar")?;
    for name in ["four-bar.svg", "four-bar-turn.svg"] {
        println!("{}", folder.join(name).display());
    }
    Ok(checks.report()?)
}
