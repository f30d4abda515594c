//! A free asymmetric body that is spun about its middle axis: it turns over and over, as Jacobi's functions say. Its
//! attitude is a coordinate without singular attitudes, `coord R: rotation;`.
//!
//! `cargo run --release --example tumbling`

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::{elliptic_k, jacobi_elliptic};
use std::error::Error;
use std::f64::consts::TAU;

lagrangian! {
    /// A body about its mass centre, and its moments of inertia.
    pub system Body {
        param A, B, C;
        coord R: rotation;
        let hull = frame(world, [0, 0, 0], R);
        T = body(0, [A, B, C], hull);
        V = 0;
        observe momentum = hull.vector([A * dot(R)[0], B * dot(R)[1], C * dot(R)[2]]);
        observe middle = R * [0, 1, 0];
    }
}

/// The motion in closed form from ω = (0, ω₂, ω₃), where L is along z (Landau and Lifshitz, *Mechanics*, §37;
/// Whittaker, *Analytical Dynamics*, §69).
struct Exact {
    body: Body,
    /// 2T and L²
    energy: f64,
    square: f64,
    amplitudes: [f64; 3],
    rate: f64,
    modulus: f64,
    /// Half a period of ω, in which the body turns over once.
    half: f64,
    /// The rate of precession as a cosine series.
    harmonics: Vec<f64>,
}

/// Nodes of the trapezoidal rule, which is exact to rounding for a function of this period.
const NODES: usize = 128;

impl Exact {
    fn new(body: Body, second: f64, third: f64) -> Exact {
        let Body { A: a, B: b, C: c } = body;
        let (energy, square) =
            (b * second.powi(2) + c * third.powi(2), (b * second).powi(2) + (c * third).powi(2));
        let [above, below] = [energy * c - square, square - energy * a];
        let amplitudes = [above / (a * (c - a)), above / (b * (c - b)), below / (c * (c - a))].map(f64::sqrt);
        let rate = ((c - b) * below / (a * b * c)).sqrt();
        let modulus = ((b - a) * above / ((c - b) * below)).sqrt();
        let half = 2.0 * elliptic_k(modulus) / rate;
        let mut exact = Exact { body, energy, square, amplitudes, rate, modulus, half, harmonics: vec![] };
        let rates: Vec<f64> = (0..NODES).map(|j| exact.precession(half * j as f64 / NODES as f64)).collect();
        exact.harmonics = (0..NODES / 2)
            .map(|k| {
                let wave = |j: usize| (TAU * (j * k % NODES) as f64 / NODES as f64).cos();
                let sum: f64 = (0..NODES).map(|j| rates[j] * wave(j)).sum();
                if k == 0 { sum / NODES as f64 } else { 2.0 * sum / NODES as f64 }
            })
            .collect();
        exact
    }

    fn omega(&self, t: f64) -> Vector3<f64> {
        let (sn, cn, dn) = jacobi_elliptic((t + 0.5 * self.half) * self.rate, self.modulus);
        Vector3::new(self.amplitudes[0] * cn, self.amplitudes[1] * sn, self.amplitudes[2] * dn)
    }

    /// Rate of the precession about L.
    fn precession(&self, t: f64) -> f64 {
        let third = self.body.C * self.omega(t).z.powi(2);
        self.square.sqrt() * (self.energy - third) / (self.square - self.body.C * third)
    }

    fn attitude(&self, t: f64) -> UnitQuaternion<f64> {
        let turns = t / self.half;
        let waves = self.harmonics.iter().enumerate().skip(1).map(|(k, a)| {
            let k = TAU * k as f64;
            a * self.half / k * (k * turns.fract()).sin()
        });
        let phi = self.harmonics[0] * t + waves.sum::<f64>();
        let (omega, l) = (self.omega(t), self.square.sqrt());
        let theta = (self.body.C * omega.z / l).acos();
        let psi = (self.body.A * omega.x).atan2(self.body.B * omega.y);
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        about(Vector3::z_axis(), phi) * about(Vector3::x_axis(), theta) * about(Vector3::z_axis(), psi)
    }
}

/// ω and the quaternion w, x, y, z from the same formulas in 40 digits (benches/references/bodies.py), after 98 turns.
const AFTER: (f64, [f64; 3], [f64; 4]) = (
    1300.0,
    [-0.033_611_570_160_214_744, 0.999_434_971_547_106_2, 0.053_633_750_719_222_31],
    [0.733_218_877_623_027_8, 0.677_257_436_146_104_5, -0.034_780_896_794_817_744, -0.050_027_311_542_604_92],
);

/// The angle between two attitudes.
fn apart(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    2.0 * (a.inverse() * b).imag().norm().min(1.0).asin()
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let body = Body::new(1.0, 2.0, 3.0);
    let exact = Exact::new(body, 1.0, 0.05);
    println!("it turns over every {:.6} s, k = {:.6}", exact.half, exact.modulus);
    let start =
        body.with_attitude_R(State::new(0.0, [0.0; 3], [0.0; 3]), &exact.attitude(0.0), &exact.omega(0.0));
    let run = |end: f64| integrate(&body, Taylor, TaylorController::tolerance(1e-15), start).until(end);
    let mut checks = Checks::default();

    // Four turns, sampled, against the closed form; energy and angular momentum over all of them.
    let momentum = |at: &State<f64, 3>| body.momentum_at(at);
    let end = 4.0 * exact.half;
    let frames =
        run(end).sample((0..=300).map(|k| end * f64::from(k) / 300.0)).collect::<Result<Vec<_>, _>>()?;
    let worst = |missed: &dyn Fn(&State<f64, 3>) -> f64| frames.iter().map(missed).fold(0.0, f64::max);
    let attitude = |at: &State<f64, 3>| apart(&body.attitude_R(at), &exact.attitude(at.t));
    checks.at_most("attitude over 4 turns", worst(&attitude), 1e-12);
    checks.at_most(
        "angular velocity",
        worst(&|at| (body.angular_velocity_R(at) - exact.omega(at.t)).norm()),
        1e-12,
    );
    let turned_over = frames.windows(2).filter(|w| {
        let [a, b] = [&w[0], &w[1]].map(|at| body.middle_at(at)[2]);
        (a > 0.0) != (b > 0.0)
    });
    checks.holds("the middle axis turns over 4 times", turned_over.count() == 4);

    // The same after 98 turns.
    let (time, omega, [w, x, y, z]) = AFTER;
    let last = run(time).final_state()?;
    let known = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    checks.at_most("attitude after 98 turns", apart(&body.attitude_R(&last), &known), 1e-10);
    checks.at_most(
        "angular velocity after 98 turns",
        (body.angular_velocity_R(&last) - Vector3::from(omega)).norm(),
        1e-10,
    );
    checks.at_most("energy", (body.energy_at(&last) - body.energy_at(&start)).abs(), 1e-13);
    checks.at_most("angular momentum in space", (momentum(&last) - momentum(&start)).norm(), 1e-13);
    checks.at_most("length of the quaternion", (body.attitude_R(&last).norm() - 1.0).abs(), 1e-15);

    let folder = support::charts()?;
    let components = frames.iter().map(|at| (at.t, body.angular_velocity_R(at)));
    let component = |k: usize| components.clone().map(move |(t, omega)| (t, omega[k]));
    Chart::new(
        "A body that turns over",
        Axis::linear("time", "s"),
        Axis::linear("angular velocity (rad/s), height of the middle axis", ""),
    )
    .subtitle("moments of inertia 1, 2 and 3, spun at 1 rad/s about the middle axis, and 0.05 aside")
    .with(Series::line("first", component(0)))
    .with(Series::line("middle", component(1)))
    .with(Series::line("third", component(2)))
    .with(Series::line("height of the middle axis", frames.iter().map(|at| (at.t, body.middle_at(at)[2]))))
    .write(&folder, "tumbling")?;
    println!("{}", folder.join("tumbling.svg").display());
    checks.report()?;
    Ok(())
}
