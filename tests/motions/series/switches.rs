//! Motions with choices in their equations, against the closed forms of their pieces.

use super::*;
use crate::systems::emitted::{Block, Wedge};
use core::f64::consts::PI;

lagrangian! {
    /// Two of [`Wedge`], which do not know of each other.
    system Wedges {
        param g;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * (x.abs() + y.abs());
    }
}

lagrangian! {
    /// Springs of different stiffness on the two sides.
    system Uneven {
        param left, right;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = if x < 0 { 0.5 * left * x * x } else { 0.5 * right * x * x };
    }
}

lagrangian! {
    /// Against a wall that moves: a force where they touch.
    system Moved {
        param k, v;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * (v * t - x).max(0).powi(2);
    }
}

lagrangian! {
    /// Twice as heavy below 0: by a condition whose two sides are equal above.
    system Heavier {
        param g;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = if x.abs() <= x { g * x } else { 2 * g * x };
    }
}

lagrangian! {
    /// A force of time alone, in windows: it jumps, and its slope.
    system Windows {
        param jump, ramp, c;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        Q[x] = if cos(t - 1) > c { jump } else { 0 };
        Q[y] = ramp * max(0, cos(t - 1) - c);
    }
}

/// Place and velocity of a particle that falls towards 0 from x at rest, with a force of size g on both sides.
fn wedge(g: f64, x: f64, t: f64) -> (f64, f64) {
    let fall = (2.0 * x / g).sqrt();
    let phase = (t / fall).rem_euclid(4.0);
    // From one turning point to the other: down for one unit, up for one.
    let (sign, phase) = if phase <= 2.0 { (1.0, phase) } else { (-1.0, phase - 2.0) };
    if phase <= 1.0 {
        (sign * x * (1.0 - phase * phase), -sign * g * fall * phase)
    } else {
        let rest = 2.0 - phase;
        (-sign * x * (1.0 - rest * rest), -sign * g * fall * rest)
    }
}

#[test]
fn a_force_that_jumps_is_followed_to_rounding() {
    let system = Wedge::new(1.3);
    for tolerance in [1e-6, 1e-15] {
        let start = State::new(0.0, [0.7], [0.0]);
        for t in [0.5, 1.0, 1.7, 3.3, 9.1, 40.0] {
            let end = end(&system, start, tolerance, t);
            let (x, v) = wedge(1.3, 0.7, t);
            // Pieces are polynomials: only rounding is left, and as many crossings as there were.
            assert!((end.q[0] - x).abs() < 1e-13 && (end.qd[0] - v).abs() < 1e-13, "{t}: {end:?} {x} {v}");
        }
        let there = end(&system, start, tolerance, 7.0);
        let back = integrate(&system, Taylor, TaylorController::tolerance(tolerance), there);
        let back = back.until(0.0).final_state().unwrap();
        assert!((back.q[0] - 0.7).abs() < 1e-13 && back.qd[0].abs() < 1e-13, "{back:?}");
    }
}

/// Powers of a step of 1e13 overflow where the coefficients beside them vanish: the search for the switch used not to
/// end.
#[test]
fn a_switch_is_found_in_a_long_step() {
    let (g, x, t) = (1e-36, 1e-12, 5.7e13);
    for tolerance in [1e-9, 1e-15] {
        let end = end(&Wedge::new(g), State::new(0.0, [x], [0.0]), tolerance, t);
        let (exact, v) = wedge(g, x, t);
        assert!(
            (end.q[0] / exact - 1.0).abs() < 1e-12 && (end.qd[0] / v - 1.0).abs() < 1e-12,
            "{end:?} {exact:e} {v:e}"
        );
    }
}

/// Every half period takes 2 μ/k of the amplitude, and the block stays where the spring is too weak.
#[test]
fn dry_friction_by_pieces_of_sinusoids_until_it_holds() {
    let (k, mu, x) = (4.0, 0.3, 1.0);
    let system = Block::new(k, mu);
    let half = PI / 2.0;
    let start = State::new(0.0, [x], [0.0]);
    let mut run = integrate(&system, Taylor, TaylorController::tolerance(1e-15), start);
    let exact = |t: f64| {
        let n = (t / half) as i32;
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        // Friction against the motion moves the middle towards where the block comes from.
        let (middle, amplitude) = (sign * mu / k, x - f64::from(2 * n + 1) * mu / k);
        middle + sign * amplitude * (2.0 * (t - f64::from(n) * half)).cos()
    };
    let failure = loop {
        match run.next().unwrap() {
            Ok(step) => {
                let x = exact(step.to.t - 1e-12);
                assert!((step.to.q[0] - x).abs() < 1e-11, "{:?} {x}", step.to);
            }
            Err(failure) => break failure,
        }
    };
    // 1, −0.85, 0.7, … , 0.1, and from there half way around μ/k = 0.075 to 0.05, where it is held.
    let Failure::Sliding { t } = failure else { panic!("{failure}") };
    assert!((t - 7.0 * half).abs() < 1e-13, "{t}");
    assert!((run.state().q[0] - 0.05).abs() < 1e-13, "{:?}", run.state());
    assert!(failure.to_string().contains("switches"), "{failure}");
}

#[test]
fn periods_of_uneven_springs() {
    let system = Uneven::new(9.0, 4.0);
    let period = PI / 3.0 + PI / 2.0;
    for tolerance in [1e-9, 1e-14] {
        let end = end(&system, State::new(0.0, [0.5], [0.0]), tolerance, 10.0 * period);
        assert!((end.q[0] - 0.5).abs() < 1e3 * tolerance && end.qd[0].abs() < 1e3 * tolerance, "{end:?}");
    }
    // Equal steps end at switches, and go on to where they would have ended.
    let run = integrate(&system, Taylor::of_order(16), FixedStep::new(0.1), State::new(0.0, [0.5], [0.0]));
    let (mut whole, mut all) = (0, 0);
    for step in run.until(2.0) {
        let t = step.unwrap().to.t * 10.0;
        whole += u32::from((t - t.round()).abs() < 1e-12);
        all += 1;
    }
    // It crosses 0 after a quarter of the longer period, and after half of the shorter one more.
    assert_eq!((whole, all), (20, 22));
}

#[test]
fn switches_at_the_same_time() {
    let system = Wedges::new(0.8);
    let start = State::new(0.0, [1.0, 1.0], [0.0, 0.0]);
    let (x, v) = wedge(0.8, 1.0, 11.0);
    let both = end(&system, start, 1e-12, 11.0);
    for i in 0..2 {
        assert!((both.q[i] - x).abs() < 1e-13 && (both.qd[i] - v).abs() < 1e-13, "{both:?}");
    }
    // One that crosses thousands of times while the other one does thrice; it begins at its switch.
    let start = State::new(0.0, [1.0, 0.0], [0.0, 1e-3]);
    let fast = end(&system, start, 1e-12, 11.0);
    let (y, _) = wedge(0.8, 1e-6 / 1.6, 11.0 + 1e-3 / 0.8 * 3.0);
    assert!((fast.q[0] - x).abs() < 1e-12, "{fast:?} {x}");
    assert!((fast.q[1] - y).abs() < 1e-11, "{fast:?} {y}");
}

#[test]
fn choices_of_time() {
    // The wall meets the particle at rest at t = 0; y = v t − x obeys ÿ = −k y until they part, half a period later.
    let (k, v) = (4.0, 0.6);
    let at = end(&Moved::new(k, v), State::new(-1.0, [0.0], [0.0]), 1e-14, 3.0);
    let parted = PI / 2.0;
    assert!((at.qd[0] - 2.0 * v).abs() < 1e-13, "{at:?}");
    assert!((at.q[0] - (v * parted + 2.0 * v * (3.0 - parted))).abs() < 1e-13, "{at:?}");
}

/// Accelerations that are constant, or have another series than the switching function, let steps grow far beyond the
/// next switch.
#[test]
fn no_switch_of_time_is_stepped_over() {
    for (jump, ramp) in [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        for c in [0.5f64, 0.9, 0.9999, -0.5] {
            for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
                let system = Windows::new(jump, ramp, c);
                // Half of each window, about 1, 1 + 2π, …; the first one is open at 0 if its half is longer than 1.
                let half = c.acos();
                let first = if half > 1.0 { 1.0 } else { half };
                let windows = 40.0;
                let last = 1.0 + 2.0 * PI * (windows - 0.5);
                let at = end(&system, State::new(0.0, [0.0; 2], [0.0; 2]), tolerance, last);
                let speed = jump * (first + (2.0 * windows - 1.0) * half);
                assert!(
                    (at.qd[0] - speed).abs() < 1e-3 * tolerance + 1e-11,
                    "{c} {tolerance}: {at:?}, {speed}"
                );
                let gain = |half: f64| half.sin() - c * half;
                let speed = ramp * (gain(first) + (2.0 * windows - 1.0) * gain(half));
                assert!((at.qd[1] - speed).abs() < 10.0 * tolerance, "{c} {tolerance}: {at:?}, {speed}");
            }
        }
    }
}

/// Derivatives know that the time of a crossing moves.
#[test]
fn gradients_across_switches() {
    let [x, g] = Gradient::variables([0.7, 1.3]);
    let start = State::new(Gradient::constant(0.0), [x], [Gradient::constant(0.0)]);
    let system = Wedge { g };
    let run = integrate(&system, Taylor, TaylorController::tolerance(1e-15), start);
    let end = run.until(Gradient::constant(9.1)).final_state().unwrap();
    let d = 1e-5;
    let slope = |a: (f64, f64), b: (f64, f64)| [(a.0 - b.0) / (2.0 * d), (a.1 - b.1) / (2.0 * d)];
    let by = [
        slope(wedge(1.3, 0.7 + d, 9.1), wedge(1.3, 0.7 - d, 9.1)),
        slope(wedge(1.3 + d, 0.7, 9.1), wedge(1.3 - d, 0.7, 9.1)),
    ];
    for (i, [q, qd]) in by.into_iter().enumerate() {
        assert!((end.q[0].slopes[i] - q).abs() < 1e-7, "{i}: {:?} {q}", end.q[0]);
        assert!((end.qd[0].slopes[i] - qd).abs() < 1e-7, "{i}: {:?} {qd}", end.qd[0]);
    }
}

#[test]
fn what_stays_on_a_switch_says_so() {
    let system = Wedge::new(1.0);
    let start = State::new(0.0, [0.0], [0.0]);
    let run = integrate(&system, Taylor, TaylorController::tolerance(1e-9), start);
    assert_eq!(run.until(1.0).final_state().unwrap_err().failure, Failure::Sliding { t: 0.0 });
}

/// A switching function that vanishes for as long as a series holds, |x| − x, and not only where it changes its sign.
#[test]
fn a_condition_may_be_on_its_border_for_long() {
    let system = Heavier::new(1.0);
    for tolerance in [1e-6, 1e-15] {
        let run = |end: f64| {
            let start = State::new(0.0, [1.0], [0.0]);
            let run = integrate(&system, Taylor, TaylorController::tolerance(tolerance), start);
            run.until(end).final_state().expect("two parabolas")
        };
        let above = run(1.0);
        assert!((above.q[0] - 0.5).abs() < 1e-14 && (above.qd[0] + 1.0).abs() < 1e-14, "{above:?}");
        // Through 0 at √2, with the velocity −√2.
        let below = run(2.0);
        let rest = 2.0 - 2f64.sqrt();
        let expected = -rest * (2f64.sqrt() + rest);
        assert!((below.q[0] - expected).abs() < 1e-14, "{below:?}, should be at {expected}");
    }
    // From below, up to 0 and beyond.
    let start = State::new(0.0, [-1.0], [3.0]);
    let run = integrate(&system, Taylor, TaylorController::tolerance(1e-12), start);
    let end = run.until(1.0).final_state().expect("two parabolas");
    // −1 + 3 t − t² = 0.
    let through = 0.5 * (3.0 - 5f64.sqrt());
    let (v, rest) = (3.0 - 2.0 * through, 1.0 - through);
    assert!((end.q[0] - (v * rest - 0.5 * rest * rest)).abs() < 1e-13, "{end:?}");
}

lagrangian! {
    /// A force within a disc, the distance from whose centre has no series there.
    system Disc {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        Q[x] = if hypot(x, y) < 0.5 { 1 } else { 0 };
    }
}

lagrangian! {
    /// A round elastic wall.
    system Wall {
        param k;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * max(hypot(x, y) - 1, 0).powi(2);
    }
}

lagrangian! {
    /// A force that changes on the x axis, where the condition's function vanishes on one side and jumps on the other.
    system Cut {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x * x + y * y);
        Q[x] = if atan2(y, x) > 0 { 0.1 } else { -0.1 };
    }
}

/// Series of switching functions that converge less far than the motion's, or not at all where it passes.
#[test]
fn a_switching_function_need_not_be_smooth() {
    for tolerance in [1e-3, 1e-6, 1e-9, 1e-14] {
        for y in [0.0, 1e-9, 1e-4, 0.1] {
            // The work of the force along the chord.
            let end = end(&Disc::new(), State::new(0.0, [-5.0, y], [1.0, 0.0]), tolerance, 15.0);
            let v = (1.0 + 4.0 * f64::sqrt(0.25 - y * y)).sqrt();
            assert!((end.qd[0] - v).abs() < tolerance + 1e-14, "{tolerance} {y}: {end:?} {v}");
        }
        for beside in [0.0, 1e-3] {
            for direction in 0..20 {
                let (sin, cos) = (0.31 * f64::from(direction) + 0.01).sin_cos();
                let start = State::new(0.0, [-beside * sin, beside * cos], [cos, sin]);
                let (system, t) = (Wall::new(1e4), 10.0);
                let end = end(&system, start, tolerance, t);
                let energy = system.energy(&end.q, &end.qd, t);
                assert!((energy - 0.5).abs() < 0.1 * tolerance + 1e-12, "{tolerance} {direction}: {energy}");
                if beside == 0.0 {
                    // From one wall to the other in 2, and half a period of the spring at each of them.
                    let whole = 2.0 + core::f64::consts::PI / 100.0;
                    let turns = (t + 1.0) / whole;
                    let side = if turns.floor() % 2.0 == 0.0 { 1.0 } else { -1.0 };
                    let place = side * (turns.fract() * whole - 1.0);
                    assert!(
                        (end.q[0] * cos + end.q[1] * sin - place).abs() < tolerance + 1e-11,
                        "{end:?} {place}"
                    );
                }
            }
        }
        let start = State::new(0.0, [1.0, 0.1], [0.0, 1.0]);
        let system = Cut::new();
        let exact = integrate(
            &system,
            lagrange_runtime::Verner9,
            lagrange_runtime::PiController::tolerance(1e-13),
            start,
        )
        .until(20.0);
        let error = lagrange_runtime::testing::distance(
            &end(&system, start, tolerance, 20.0),
            &exact.final_state().unwrap(),
        );
        assert!(error < tolerance + 1e-11, "{tolerance} {error:e}");
    }
}
