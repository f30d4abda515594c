//! The symmetric top by its three angles against the same top reduced to its nutation: `cargo bench --bench routhian`.
//!
//! With arguments, `-- whole 1000` or `-- reduced 1000`, it makes that many steps of RK4 and ends, for counting
//! instructions: the difference of two counts is free of everything but steps.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::Controller;
use lagrange_runtime::prelude::*;
use support::{consume, ratio};

lagrangian! {
    pub system Top {
        param m, l, I1, I3, g = 9.81;
        coord phi: angle, theta: angle, psi: angle;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
        pub routhian Nutation;
    }
}

const STEPS: u32 = 1000;
const H: f64 = 1e-3;

/// The state after `count` equal steps.
fn steps<Sys, M, const N: usize>(system: &Sys, method: M, start: State<f64, N>, count: u32)
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    FixedStep<f64>: Controller<f64, N, M::Error>,
{
    consume(integrate(system, method, FixedStep::new(H), start).until(H * f64::from(count)).final_state());
}

fn main() {
    let top = Top::new(0.5, 0.12, 0.008, 0.0011);
    let start = State::new(0.0, [0.0, 0.6, 0.0], [0.4, 0.1, 180.0]);
    let (nutation, state) = top.reduce(&start);
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, which, count, ..] = arguments.as_slice()
        && let Ok(count) = count.parse()
    {
        return match which.as_str() {
            "whole" => steps(&top, Rk4, start, count),
            _ => steps(&nutation, Rk4, state, count),
        };
    }
    println!("whole / reduced, quartiles; ns a step whole, reduced");
    macro_rules! rows {
        ($($method:expr),*) => {$(
            let r = ratio(
                STEPS as usize,
                || steps(&top, $method, start, STEPS),
                || steps(&nutation, $method, state, STEPS),
            );
            let [low, high] = r.quartiles;
            let [whole, reduced] = r.nanoseconds;
            println!("{}: {:.2}, {low:.2} – {high:.2}; {whole:.1}, {reduced:.1}", stringify!($method), r.median);
        )*};
    }
    rows!(Rk4, Dop853, ImplicitMidpoint, Gauss4);

    // Symplectic and of order 2: what is separable needs no iteration.
    let r = ratio(
        STEPS as usize,
        || steps(&top, ImplicitMidpoint, start, STEPS),
        || steps(&nutation, Verlet, state, STEPS),
    );
    let [low, high] = r.quartiles;
    println!("ImplicitMidpoint whole / Verlet reduced: {:.2}, {low:.2} – {high:.2}", r.median);

    // What adaptive runs of a second take, the angles recovered in the reduced one.
    let tolerance = || PiController::tolerance(1e-9);
    let whole = || consume(integrate(&top, Dop853, tolerance(), start).until(1.0).final_state());
    let alone = || consume(integrate(&nutation, Dop853, tolerance(), state).until(1.0).final_state());
    let recovered =
        || consume(integrate(&nutation, Dop853, tolerance(), state).until(1.0).recover([0.0, 0.0]).last());
    for (what, reduced) in [("alone", &alone as &dyn Fn()), ("with the angles recovered", &recovered)] {
        let r = ratio(1, whole, reduced);
        println!("adaptive Dop853 to t = 1, {what}: {:.2}; {:.0?} ns", r.median, r.nanoseconds);
    }
}
