//! What the abstractions cost: `cargo bench -p lagrange-runtime --bench overhead`.
//!
//! 1. RK4 on Kepler's problem (polar) through `integrate` against a loop written by hand, as a ratio of the two within
//!    one process, the two taken in turns so that a change of clock speed meets both.
//! 2. The time per evaluation of each method on systems whose accelerations are nearly free: what remains is the
//!    method's own arithmetic, the controller, and the loop.

use lagrange_runtime::Pid;
use lagrange_runtime::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// Kepler's problem in polar coordinates, μ = 1.
struct Kepler;

#[inline(always)]
fn kepler(r: f64, rd: f64, phid: f64) -> [f64; 2] {
    let u = 1.0 / r;
    [r * phid * phid - u * u, -2.0 * rd * phid * u]
}

impl System<2> for Kepler {
    type Scalar = f64;
    #[inline]
    fn accel(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>, _: f64) -> SVector<f64, 2> {
        kepler(q[0], qd[0], qd[1]).into()
    }
}

/// N uncoupled oscillators: one multiplication per acceleration.
struct Oscillators<const N: usize>;

impl<const N: usize> System<N> for Oscillators<N> {
    type Scalar = f64;
    #[inline]
    fn accel(&self, q: &SVector<f64, N>, _: &SVector<f64, N>, _: f64) -> SVector<f64, N> {
        q * -1.0
    }
}

/// Two equal pendulums in a row: accelerations of a usual length.
struct DoublePendulum;

impl System<2> for DoublePendulum {
    type Scalar = f64;
    #[inline]
    fn accel(&self, q: &SVector<f64, 2>, qd: &SVector<f64, 2>, _: f64) -> SVector<f64, 2> {
        let (s, c) = (q[0] - q[1]).sin_cos();
        let f = -s * qd[1] * qd[1] - 2.0 * q[0].sin();
        let g = s * qd[0] * qd[0] - q[1].sin();
        let d = 1.0 / (2.0 - c * c);
        [(f - c * g) * d, (2.0 * g - c * f) * d].into()
    }
}

const START: [f64; 4] = [0.7, 0.0, 0.0, 1.3627702877384937 / 0.7];

fn by_hand(steps: u32, h: f64) -> [f64; 4] {
    let f = |y: [f64; 4]| {
        let [a, b] = kepler(y[0], y[2], y[3]);
        [y[2], y[3], a, b]
    };
    let add = |y: [f64; 4], c: f64, k: [f64; 4]| {
        [y[0] + c * k[0], y[1] + c * k[1], y[2] + c * k[2], y[3] + c * k[3]]
    };
    let mut y = START;
    for _ in 0..steps {
        let k1 = f(y);
        let k2 = f(add(y, 0.5 * h, k1));
        let k3 = f(add(y, 0.5 * h, k2));
        let k4 = f(add(y, h, k3));
        for i in 0..4 {
            y[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    y
}

fn by_iterator(steps: u32, h: f64) -> [f64; 4] {
    let start = State::new(0.0, [START[0], START[1]], [START[2], START[3]]);
    let mut last = start;
    for step in integrate(&Kepler, Rk4, Fixed::new(h), start).until(f64::from(steps) * h) {
        match step {
            Ok(step) => last = step.to,
            Err(failure) => panic!("{failure}"),
        }
    }
    [last.q[0], last.q[1], last.qd[0], last.qd[1]]
}

/// Nanoseconds that `work` takes per unit, of which it does `units`.
fn time<T>(units: f64, work: impl FnOnce() -> T) -> f64 {
    let clock = Instant::now();
    black_box(work());
    clock.elapsed().as_secs_f64() * 1e9 / units
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn ratio() {
    let (steps, h) = (1_000_000, 1e-3);
    let agreement = by_hand(1000, h).iter().zip(by_iterator(1000, h)).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(agreement, "the two loops compute different things");
    let (mut hand, mut iterator, mut ratios) = (vec![], vec![], vec![]);
    for _ in 0..15 {
        hand.push(time(f64::from(steps), || by_hand(black_box(steps), black_box(h))));
        iterator.push(time(f64::from(steps), || by_iterator(black_box(steps), black_box(h))));
        ratios.push(iterator[iterator.len() - 1] / hand[hand.len() - 1]);
    }
    let [hand, iterator, ratio] = [hand, iterator, ratios].map(median);
    println!("Rk4, Kepler: by hand {hand:.2} ns/step, iterator {iterator:.2} ns/step, ratio {ratio:.3}");
}

macro_rules! per_evaluation {
    ($($method:ident, $controller:expr, $system:expr, $n:literal;)*) => {$({
        let times = (0..7).map(|_| {
            let system = $system;
            let start = State::new(0.0, [1.0; $n], [0.0; $n]);
            let mut run = integrate(&system, $method, $controller, start).until(black_box(20_000.0));
            let clock = Instant::now();
            run.run_out().expect("these systems have no singularities");
            clock.elapsed().as_secs_f64() * 1e9 / run.statistics().evaluations as f64
        });
        let time = median(times.collect());
        println!("{:<60} {time:.2} ns per evaluation", stringify!($method, $controller, $system));
    })*};
}

fn main() {
    ratio();
    per_evaluation! {
        Rk4, Fixed::new(0.1), Oscillators::<1>, 1;
        Rk4, Fixed::new(0.1), Oscillators::<2>, 2;
        Rk4, Fixed::new(0.1), Oscillators::<4>, 4;
        Dop853, Fixed::new(0.5), Oscillators::<1>, 1;
        Dop853, Fixed::new(0.5), Oscillators::<2>, 2;
        Dop853, Fixed::new(0.5), Oscillators::<4>, 4;
        Dop853, Fixed::new(0.5), Oscillators::<8>, 8;
        Dop853, Pi::tolerance(1e-9), Oscillators::<1>, 1;
        Dop853, Pi::tolerance(1e-9), Oscillators::<2>, 2;
        Dop853, Pi::tolerance(1e-9), Oscillators::<4>, 4;
        Dop853, Pi::tolerance(1e-9), Oscillators::<8>, 8;
        Dop853, Fixed::new(0.5), DoublePendulum, 2;
        Dop853, Pi::tolerance(1e-9), DoublePendulum, 2;
        DormandPrince5, Pi::tolerance(1e-6), Oscillators::<2>, 2;
        Dop853, Pid::elementary(Pi::tolerance(1e-9)), Oscillators::<2>, 2;
        Tsitouras5, Pi::tolerance(1e-6), Oscillators::<2>, 2;
        Verner9, Fixed::new(0.5), Oscillators::<2>, 2;
        Verner9, Pi::tolerance(1e-9), Oscillators::<2>, 2;
    }
}
