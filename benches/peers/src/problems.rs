//! The systems, with their true states.

use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::{KeplerOrbit, SeriesMotion, SimplePendulum};
use lagrange_runtime::testing::distance;
use lagrange_runtime::DoubleDouble;
use lagrange_runtime::traits::{Analytic, LegendreTransform};

#[path = "../../support/systems.rs"]
mod systems;

pub use systems::{DoublePendulum, Kepler, Pendulum};

lagrangian! {
    /// The heavy symmetric top by Euler's angles.
    pub system Top {
        param a, c, mgl;
        coord theta, phi, psi;
        T = 0.5 * a * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2))
            + 0.5 * c * (dot(psi) + dot(phi) * cos(theta)).powi(2);
        V = mgl * cos(theta);
    }
}

lagrangian! {
    /// A free body by a rotation; without its place.
    pub system FreeBody {
        param a, b, c;
        coord R: rotation;
        T = body(0, [a, b, c], frame(world, [0, 0, 0], R));
        V = 0;
    }
}

pub fn pendulum() -> (Pendulum, impl Fn(f64) -> State<f64, 1>) {
    let exact = SimplePendulum::new(9.81, 0.85, 2.0, 0.0);
    let at = move |t| {
        let (theta, thetad) = exact.state(t);
        State::new(t, [theta], [thetad])
    };
    (Pendulum::new(1.3, 0.85, 9.81), at)
}

/// From the pericentre of an ellipse of semi-major axis 1 about μ = 1.
pub fn kepler() -> (Kepler, impl Fn(f64) -> State<f64, 2>) {
    let (position, velocity) = ([0.4, 0.0], [0.0, 5.0]);
    let exact = KeplerOrbit::new(1.0, position, velocity).expect("an ellipse");
    let at = move |t| {
        let (q, qd) = exact.state(t);
        State::new(t, q, qd)
    };
    (Kepler::new(1.0, 1.0), at)
}

/// The true states of a motion without a closed form, by Taylor series in double-double. Those are the recurrences of
/// our own Taylor series, too: so a method that shares nothing with them has to come to the same states, as far as
/// its rounding lets it.
fn reference<Sys, const N: usize>(
    (system, over_double_double): (Sys, impl Analytic<N, Scalar = DoubleDouble>),
    start: State<f64, N>,
) -> impl Fn(f64) -> State<f64, N>
where
    Sys: LegendreTransform<N, Scalar = f64>,
{
    let motion = SeriesMotion::new(over_double_double, start);
    move |t| {
        let exact = motion.state(t).expect("a regular motion");
        if t > start.t {
            let run = integrate(&system, Gauss6, FixedStep::new(5e-4), start).until(t);
            let end = run.final_state().expect("a regular motion");
            // The shorter ones of the two parameters of each attitude.
            let [end, exact] = [end, exact].map(|at| {
                Sys::ATTITUDES.iter().fold(at, |at, first| {
                    at.with_attitude(*first, &at.attitude(*first), &at.angular_velocity(*first))
                })
            });
            let apart = distance(&end, &exact);
            assert!(apart < 1e-11, "Gauss 6 is {apart:e} from the reference at t = {t}");
        }
        exact
    }
}

pub fn double_pendulum() -> (DoublePendulum, impl Fn(f64) -> State<f64, 2>) {
    let system = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let start = State::new(0.0, [1.2, -0.4], [0.0, 0.5]);
    (system, reference((system, system.map(DoubleDouble::from)), start))
}

pub fn top() -> (Top, impl Fn(f64) -> State<f64, 3>) {
    let system = Top::new(1.0, 0.7, 1.3);
    let start = State::new(0.0, [0.6, 0.0, 0.0], [0.1, 0.4, 3.0]);
    (system, reference((system, system.map(DoubleDouble::from)), start))
}

/// About its intermediate axis: it turns over every 13 units of time.
pub fn free_body() -> (FreeBody, impl Fn(f64) -> State<f64, 3>) {
    let system = FreeBody::new(1.0, 2.0, 3.0);
    let start = State::new(0.0, [0.0; 3], [0.0; 3]).with_attitude(
        0,
        &UnitQuaternion::identity(),
        &Vector3::new(0.0, 1.0, 0.05),
    );
    (system, reference((system, system.map(DoubleDouble::from)), start))
}
