//! Motions over kinks and jumps of their forces, by every adaptive method, against closed forms.

use crate::systems::any::Any;
use crate::systems::emitted::{Block, Wedge};
use core::f64::consts::PI;
use lagrange_runtime::State;
use lagrange_runtime::controller::{ErrorEstimate, PiController};
use lagrange_runtime::failure::Failure;
use lagrange_runtime::integrate::{Statistics, integrate};
use lagrange_runtime::method::Method;
use lagrange_runtime::method::explicit_rk::{Dop853, DormandPrince5, Tsitouras5, Verner9};
use lagrange_runtime::method::nystrom::{Nystrom6, Nystrom8, Nystrom12};
use lagrange_runtime::method::radau::Radau5;
use lagrange_runtime::method::rosenbrock::{Rodas4, Rodas5P};
use lagrange_runtime::prelude::*;

mod slopes;
#[path = "../../../lagrange-runtime/tests/systems/mod.rs"]
mod systems;

lagrangian! {
    /// A ball above a spring that pushes and does not pull.
    system Ball {
        param k, g = 9.81;
        coord z;
        T = 0.5 * dot(z).powi(2);
        V = g * z + if z < 0 { 0.5 * k * z * z } else { 0 };
    }
}

lagrangian! {
    /// The same, held by the spring.
    system Held {
        param k, g = 9.81;
        coord z;
        T = 0.5 * dot(z).powi(2);
        V = g * z + 0.5 * k * z * z;
    }
}

lagrangian! {
    /// A free particle under a force that is on from t = a on for a while, and up to it in a ramp.
    system Pushed {
        param a, on, ramp, f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = if t > a && t < a + on { f } else { 0 } - f * ((t - a) / ramp + 1).max(0).min(((a - t) / ramp).max(0));
    }
}

/// One coordinate with so many switches.
type Kinked<const SWITCHES: usize = 1> = Any<1, SWITCHES>;
/// The same, driven.
type Driven<const SWITCHES: usize = 1> = Any<1, SWITCHES, false>;

/// Runs a test by each adaptive method.
macro_rules! by_every_method {
    ($test:ident $(, $argument:expr)*) => {
        $test(DormandPrince5 $(, $argument)*);
        $test(Tsitouras5 $(, $argument)*);
        $test(Dop853 $(, $argument)*);
        $test(Verner9 $(, $argument)*);
        $test(Radau5 $(, $argument)*);
        $test(Rodas4 $(, $argument)*);
        $test(Rodas5P $(, $argument)*);
    };
}

/// The largest change of the energy along a run.
fn lost<Sys: Lagrangian<1, Scalar = f64>, M: Method<Sys, 1, Error: ErrorEstimate<f64, 1>>>(
    system: &Sys,
    method: M,
    tolerance: f64,
    start: State<f64, 1>,
    end: f64,
) -> (f64, Statistics) {
    let energy = system.energy_function_at(&start);
    let mut run = integrate(system, method, PiController::tolerance(tolerance), start).until(end);
    let mut most = 0.0f64;
    for step in &mut run {
        most = most.max((system.energy_function_at(&step.expect("a step").to) - energy).abs());
    }
    (most, run.statistics())
}

/// Energy is lost by the method alone, not by the switch: as much as while the spring holds the ball as long as it
/// touches it.
fn bounces<M>(method: M)
where
    M: Method<Kinked, 1, Error: ErrorEstimate<f64, 1>> + Method<Kinked<0>, 1, Error: ErrorEstimate<f64, 1>>,
    M: Copy + core::fmt::Debug,
{
    let (k, g) = (1000.0, 9.81f64);
    let fall = (2.0 / g).sqrt();
    // The ball leaves the spring at the phase at which it has met it.
    let touch = 2.0 * (PI - ((2.0 * g * k).sqrt() / g).atan()) / k.sqrt();
    let spring: Kinked<0> = Any::new(Held::new(k));
    let (held, _) = lost(&spring, method, 1e-10, State::new(0.0, [0.0], [-(2.0 * g).sqrt()]), 20.0 * touch);
    let end = 20.0 * (2.0 * fall + touch);
    let system: Kinked = Any::new(Ball::new(k));
    let (ball, _) = lost(&system, method, 1e-10, State::new(0.0, [1.0], [0.0]), end);
    assert!(ball < 1.5 * held + 1e-10 && ball < 1e-8 * g, "{method:?}: {ball:e}, without a switch {held:e}");
    let top = integrate(&system, method, PiController::tolerance(1e-10), State::new(0.0, [1.0], [0.0]))
        .until(end)
        .final_state()
        .expect("a bounce");
    assert!((top.q[0] - 1.0).abs() < 1e-7 && top.qd[0].abs() < 1e-5, "{method:?}: {top:?}");
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_spring_on_one_side_costs_no_energy() {
    by_every_method!(bounces);
}

/// Each half swing loses 2 μ/k, until the body stays where it stops.
fn stops<M>(method: M)
where
    M: Method<Kinked, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    let block = Any::new(Block::new(1.0, 0.1));
    let start = State::new(0.0, [1.05], [0.0]);
    for tolerance in [1e-6, 1e-10] {
        let mut run = integrate(&block, method, PiController::tolerance(tolerance), start).until(20.0);
        let failure = run.find_map(Result::err);
        let x = run.state().q[0];
        assert!(
            matches!(failure, Some(Failure::Sliding { t }) if (t - 5.0 * PI).abs() < 1e3 * tolerance),
            "{method:?}: {failure:?}"
        );
        assert!((x + 0.05).abs() < 100.0 * tolerance, "{method:?}: {x}");
        assert!(run.statistics().accepted + run.statistics().rejected < 4000);
        let before = integrate(&block, method, PiController::tolerance(tolerance), start)
            .until(4.5 * PI)
            .final_state();
        let before = before.expect("it has not stopped");
        // From 0.25 to −0.05 about 0.1.
        assert!(
            (before.q[0] - 0.1).abs() < 100.0 * tolerance && (before.qd[0] + 0.15).abs() < 100.0 * tolerance
        );
    }
}

#[test]
fn friction_that_holds_is_named() {
    by_every_method!(stops);
}

/// A long way at rest, a short push: none is overlooked.
fn pushes<M>(method: M)
where
    M: Method<Pushed, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    for (a, on, ramp) in [(5.0, 0.01, 0.5), (50.0, 1e-6, 1e-3), (3.0, 2.0, 0.1), (99.0, 0.5, 1e-9)] {
        let pushed = Pushed::new(a, on, ramp, 3.0);
        let end = integrate(&pushed, method, PiController::tolerance(1e-10), State::new(0.0, [0.0], [0.0]))
            .until(100.0)
            .final_state()
            .expect("an end");
        // The momentum of each push, at the time of its middle: a triangle of half the height in front of a rectangle.
        let (rectangle, triangle) = (3.0 * on, -3.0 * 0.25 * ramp);
        let x = rectangle * (100.0 - a - 0.5 * on) + triangle * (100.0 - a + 0.5 * ramp);
        assert!((end.qd[0] - rectangle - triangle).abs() < 1e-9, "{method:?}, {a}: {}", end.qd[0]);
        assert!((end.q[0] - x).abs() < 1e-7, "{method:?}, {a}: {} {x}", end.q[0]);
    }
}

#[test]
fn no_push_is_overlooked() {
    by_every_method!(pushes);
    pushes(Nystrom8);
    pushes(Nystrom12);
}

/// There and back, and from a start on the switch.
fn returns<M>(method: M)
where
    M: Method<Kinked, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    let wedge: Kinked = Any::new(Wedge::new(1.3));
    for start in
        [State::new(0.0, [0.7], [0.0]), State::new(2.0, [0.0], [1.0]), State::new(0.0, [0.0], [-1.0])]
    {
        let there = integrate(&wedge, method, PiController::tolerance(1e-11), start)
            .until(30.0)
            .final_state()
            .expect("an end");
        let back = integrate(&wedge, method, PiController::tolerance(1e-11), there)
            .until(start.t)
            .final_state()
            .expect("a start");
        let off = lagrange_runtime::testing::distance(&back, &start);
        // Some thirty crossings, each with an error of velocity within the tolerance, over thirty units of time.
        assert!(off < 1e-8, "{method:?}: {off:e}");
        assert!(
            (wedge.energy_function_at(&there) - wedge.energy_function_at(&start)).abs() < 1e-10,
            "{method:?}"
        );
    }
}

#[test]
fn a_motion_over_jumps_can_be_reversed() {
    by_every_method!(returns);
}

lagrangian! {
    /// A force that is on for a while.
    system Pulse {
        param a, b, f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = if t > a && t < b { f } else { 0 };
    }
}

lagrangian! {
    /// A force that changes its sign with a clock.
    system Square {
        param w;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = signum(sin(w * t));
    }
}

/// Backward through a pulse, whose ends are switches that steps begin at.
fn back_through_a_pulse<M>(method: M)
where
    M: Method<Driven<2>, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    for width in [1.0, 0.1, 0.01, 1e-4] {
        let pulse = Any::new(Pulse::new(1.0, 1.0 + width, 1.0 / width));
        let run = integrate(&pulse, method, PiController::tolerance(1e-9), State::new(3.0, [0.0], [0.0]))
            .until(0.0);
        let (mut t, mut end) = (3.0, *run.start());
        for step in run {
            end = step.expect("a step").to;
            assert!(end.t < t, "{method:?}: {} after {t}", end.t);
            t = end.t;
        }
        let x = 1.0 + 0.5 * width;
        assert!(
            (end.qd[0] + 1.0).abs() < 1e-6 && (end.q[0] - x).abs() < 1e-6,
            "{method:?}, {width}: {end:?}"
        );
    }
}

#[test]
fn runs_backward_stay_backward() {
    by_every_method!(back_through_a_pulse);
    back_through_a_pulse(Nystrom12);
}

/// States at and beside the ends of a pulse, also within the steps across them, in which coordinates change by few
/// roundings.
fn beside_a_pulse<M>(method: M)
where
    M: Method<Driven<2>, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    let (a, b) = (10.0, 11.0);
    let beside = [1e-9, 1e-11, 1e-12, 1e-13, 2e-14, 1e-14, 4e-15, 2e-15, 0.0];
    let offsets = beside.into_iter().map(|d| -d).chain(beside.into_iter().rev().skip(1));
    let times: Vec<f64> = [a, b].into_iter().flat_map(|t| offsets.clone().map(move |d| t + d)).collect();
    for tolerance in [1e-6, 1e-10, 1e-13] {
        let pulse = Any::new(Pulse::new(a, b, 1.0));
        let run =
            integrate(&pulse, method, PiController::tolerance(tolerance), State::new(0.0, [0.0], [1.0]));
        for at in run.sample(times.iter().copied()) {
            let at = at.expect("a sample");
            let pushed = (at.t.min(b) - a).max(0.0);
            let x = at.t + 0.5 * pushed * pushed + pushed * (at.t - b).max(0.0);
            let [q, qd] = [at.q[0] - x, at.qd[0] - 1.0 - pushed];
            let error = tolerance + 1e-12;
            assert!(
                q.abs() < error && qd.abs() < error,
                "{method:?}, {tolerance:e}: {q:e}, {qd:e} at {}",
                at.t
            );
        }
    }
}

#[test]
fn samples_beside_switches_are_right() {
    by_every_method!(beside_a_pulse);
    beside_a_pulse(Nystrom6);
    beside_a_pulse(Nystrom8);
    beside_a_pulse(Nystrom12);
}

/// Switches that follow each other in every step are no sliding.
fn clockwork<M>(method: M)
where
    M: Method<Driven, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    let square = Any::new(Square::new(100.0 * PI));
    let end = integrate(&square, method, PiController::tolerance(1e-6), State::new(0.0, [0.0], [0.0]))
        .until(2.0)
        .final_state();
    let end = end.expect("an end");
    // The velocity is a sawtooth up to 1/100 of mean 1/200.
    assert!((end.q[0] - 0.01).abs() < 1e-4 && end.qd[0].abs() < 1e-4, "{method:?}: {end:?}");
}

#[test]
fn a_clock_does_not_slide() {
    by_every_method!(clockwork);
    clockwork(Nystrom12);
}

/// Steps of a run end at switches and events alike: what events see is continuous.
#[test]
fn steps_hang_together() {
    let ball: Kinked = Any::new(Ball::new(1e4));
    let run =
        integrate(&ball, Dop853, PiController::tolerance(1e-9), State::new(0.0, [1.0], [0.0])).until(10.0);
    let mut last = *run.start();
    for step in run {
        let step = step.expect("a step");
        assert_eq!(step.from, last);
        last = step.to;
    }
    assert_eq!(last.t, 10.0);
    let run =
        integrate(&ball, Dop853, PiController::tolerance(1e-9), State::new(0.0, [1.0], [0.0])).until(10.0);
    let touches: Vec<_> = run.events(Event::falling(|s| s.q[0])).collect::<Result<_, _>>().expect("touches");
    let period = touches[1].state.t - touches[0].state.t;
    for (i, touch) in touches.iter().enumerate() {
        assert!((touch.state.t - touches[0].state.t - i as f64 * period).abs() < 1e-7, "{i}");
        assert!(touch.state.q[0].abs() < 1e-14);
    }
}

/// No system without choices pays for what others need.
#[test]
fn systems_say_how_many_switches_they_have() {
    assert_eq!(
        [
            <Ball as System<1>>::SWITCHES,
            <Held as System<1>>::SWITCHES,
            <Precomputed<Block, 1> as System<1>>::SWITCHES
        ],
        [1, 0, 1]
    );
    let mut found = vec![];
    let at = State::new(0.0, [0.3], [-2.0]);
    Block::new(1.0, 0.1).switches(&at, &[0.7].into(), |i, both| found.push((i, both)));
    assert_eq!(found, [(0, [-2.0, 0.7])]);
}

lagrangian! {
    /// Two discs of diameter 1 that push each other away where they overlap.
    system Discs {
        param k;
        coord x, y, u, v;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(u).powi(2) + dot(v).powi(2));
        V = 0.5 * k * max(1 - hypot(x - u, y - v), 0).powi(2);
    }
}

/// Steps of free motion grow longer than the contact. Where an interpolant has stages of its own, one of these may
/// fall into it alone. Hard discs exchange the velocities along the line between their centres; soft ones differ by
/// as much as they overlap.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn no_contact_after_free_motion_is_stepped_over() {
    let k = 1e6;
    let system = Discs::new(k);
    for place in 0..25 {
        let (d, offset) = (2.0 + 0.8 * f64::from(place), 0.1 + 0.03 * f64::from(place));
        let start = State::new(0.0, [-0.5 * d, offset, 0.5 * d, 0.0], [1.0, 0.0, -1.0, 0.0]);
        let end = 0.5 * d + 2.0;
        let along = (1.0 - offset * offset).sqrt();
        let exact = [2.0 * offset * offset - 1.0, 2.0 * offset * along];
        for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
            let run = PiController::tolerance(tolerance);
            for (method, end) in [
                ("Dop853", integrate(&system, Dop853, run, start).until(end).final_state()),
                ("Verner9", integrate(&system, Verner9, run, start).until(end).final_state()),
                ("Nystrom8", integrate(&system, Nystrom8, run, start).until(end).final_state()),
                ("Nystrom12", integrate(&system, Nystrom12, run, start).until(end).final_state()),
            ] {
                let end = end.expect("an end");
                let error = (end.qd[0] - exact[0]).hypot(end.qd[1] - exact[1]);
                // They touch for π/√(2k), in which the line between them turns by so much times the velocity across it.
                let soft = 2.0 * PI / (2.0 * k).sqrt();
                assert!(error < soft + 100.0 * tolerance, "{method}, {tolerance}, {d}: {error:e}");
            }
        }
    }
}

/// A ball that is pulled up, thrown down from 1, dips into the spring at its lowest place.
fn touches<M>(method: M)
where
    M: Method<Kinked, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    for (k, tolerance) in [1e2, 1e4, 1e6, 1e8].into_iter().flat_map(|k| [1e-6, 1e-9, 1e-12].map(|e| (k, e))) {
        let ball = Any::new(Ball { g: -9.81, ..Ball::new(k) });
        for depth in (0..12).map(|i| 0.37 * 0.1f64.powi(i)).take_while(|depth| *depth > 100.0 * tolerance) {
            let down = (2.0 * 9.81 * (1.0 + depth)).sqrt();
            // The velocity at the spring, the time to it, and the time at it.
            let met = (2.0 * 9.81 * depth).sqrt();
            let (fall, touch) = ((down - met) / 9.81, 2.0 * (met * k.sqrt() / 9.81).atan() / k.sqrt());
            let end = 2.0 * fall + touch;
            let start = State::new(0.0, [1.0], [-down]);
            let end =
                integrate(&ball, method, PiController::tolerance(tolerance), start).until(end).final_state();
            let end =
                end.unwrap_or_else(|lost| panic!("{method:?}, {k:e}, {tolerance:e}, {depth:e}: {lost}"));
            // An error of z where it meets the spring changes its velocity there by g/met times as much.
            let error = (end.q[0] - 1.0).abs().max((end.qd[0] - down).abs());
            assert!(
                error < 100.0 * tolerance * (1.0 + 9.81 / met),
                "{method:?}, {k:e}, {tolerance:e}, {depth:e}: {error:e}"
            );
        }
    }
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn light_touches_are_met() {
    by_every_method!(touches);
}

lagrangian! {
    /// A ridge far from the origin of its coordinate.
    system Edge {
        param c;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = abs(x - c);
    }
}

/// Steps across a switch are as long as the rounding of a coordinate there: shorter ones would not move it.
fn far<M>(method: M)
where
    M: Method<Kinked, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    for (c, tolerance) in [(1.0, 1e-12), (100.0, 1e-8), (100.0, 1e-12), (1e4, 1e-10), (1e6, 1e-10)] {
        let start = State::new(0.0, [c + 0.7], [0.0]);
        let end = 20.0 * 1.4f64.sqrt();
        let edge = Any::new(Edge::new(c));
        let run = integrate(&edge, method, PiController::tolerance(tolerance), start).max_steps(1000);
        let end = run
            .until(end)
            .final_state()
            .unwrap_or_else(|lost| panic!("{method:?}, {c}, {tolerance:e}: {lost}"));
        let error = lagrange_runtime::testing::distance(&end, &start);
        assert!(error < 100.0 * tolerance * c, "{method:?}, {c}, {tolerance:e}: {error:e}");
    }
}

#[test]
fn switches_far_from_the_origin_are_crossed() {
    far(DormandPrince5);
    far(Dop853);
    far(Verner9);
}

lagrangian! {
    /// A ball on a spring whose free end is at c.
    system Above {
        param k, c, g = 9.81;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y + 0.5 * k * max(c - y, 0).powi(2);
    }
}

/// A ball that is let go at rest where the spring begins comes back to that place without velocity: y = c − g/k (1 −
/// cos ωt).
#[test]
fn a_switch_that_is_only_come_to_holds_no_run_up() {
    for (k, c) in [(15848.93192461114f64, 10.0f64), (91.20108393559097, 1000.0)] {
        let (above, start, w): (Kinked, _, _) =
            (Any::new(Above::new(k, c)), State::new(0.0, [c], [0.0]), k.sqrt());
        let exact = [c - 9.81 / k * (1.0 - w.cos()), -9.81 / w * w.sin()];
        let pi = PiController::tolerance(1e-9);
        for (method, end) in [
            ("Dop853", integrate(&above, Dop853, pi, start).max_steps(2000).until(1.0).final_state()),
            ("Nystrom8", integrate(&above, Nystrom8, pi, start).max_steps(2000).until(1.0).final_state()),
            ("Nystrom12", integrate(&above, Nystrom12, pi, start).max_steps(2000).until(1.0).final_state()),
        ] {
            let end = end.unwrap_or_else(|lost| panic!("{method}, {c}: {lost}"));
            let error = (end.q[0] - exact[0]).abs().max((end.qd[0] - exact[1]).abs());
            assert!(error < 1e-8 * c, "{method}, {c}: {error:e}");
        }
    }
}

/// The same for the series, whose first terms are rounding there, and for starts that are apart from the switch by
/// rounding alone.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn a_switch_without_velocity_is_no_sliding() {
    for k in [11.220184543019636f64, 12.302687708123818, 398.1071705534973] {
        let (above, w) = (Above::new(k, 0.0), k.sqrt());
        let by_address: Kinked = Any::new(above);
        for (t, y, v) in [(0.0, 0.0, 0.0), (0.0, 0.0, 1e-300), (1.0, 1e-15, 0.0), (100.0, -1e-17, 0.0)] {
            let (start, end) = (State::new(t, [y], [v]), t + 20.0 / w);
            let exact = -9.81 / k * (1.0 - (20.0f64).cos());
            for tolerance in [1e-3, 1e-10, 1e-12] {
                let (pi, decay) =
                    (PiController::tolerance(tolerance), TaylorController::tolerance(tolerance));
                for (method, end) in [
                    ("Taylor", integrate(&above, Taylor, decay, start).until(end).final_state()),
                    ("Dop853", integrate(&by_address, Dop853, pi, start).until(end).final_state()),
                    ("Radau5", integrate(&by_address, Radau5, pi, start).until(end).final_state()),
                ] {
                    let end = end.unwrap_or_else(|lost| panic!("{method}, {k}, {start:?}: {lost}"));
                    let error = (end.q[0] - exact).abs();
                    assert!(error < 100.0 * tolerance, "{method}, {k}, {start:?}, {tolerance:e}: {error:e}");
                }
            }
        }
    }
}

lagrangian! {
    /// A free particle, and a force that is on beyond k.
    system Beyond {
        param k, f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = if x > k { -f } else { 0 };
    }
}

/// A start on a jump has accelerations of the wrong side, also where x is rounded more than time is.
fn begins_on_a_jump<M>(method: M)
where
    M: Method<Kinked, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    for (k, f, v) in [(1.0, 1.0, 5.0), (8652.435068012943, 1.0673538622291991, 0.35841034442047925)] {
        for tolerance in [1e-6, 1e-9] {
            let (beyond, start) = (Any::new(Beyond::new(k, f)), State::new(0.0, [k], [v]));
            let run = integrate(&beyond, method, PiController::tolerance(tolerance), start);
            let end = run.until(v / f).final_state().expect("up to the top");
            let error = (end.q[0] - k - 0.5 * v * v / f).abs().max(end.qd[0].abs());
            assert!(error < tolerance, "{method:?}, {k}, {tolerance:e}: {error:e}");
        }
    }
}

#[test]
fn a_start_on_a_jump_is_of_the_side_it_goes_to() {
    by_every_method!(begins_on_a_jump);
}

/// The time from which friction holds a block on a spring, and where: half swings about ∓μ/k, one after the other.
fn held([k, mu]: [f64; 2], [x, v]: [f64; 2]) -> (f64, f64) {
    let (w, mut side) = (k.sqrt(), v.signum());
    let reach = (x + side * mu / k).hypot(v / w);
    let phase = (v * side / w).atan2((x + side * mu / k) * side);
    let (mut t, mut x) = (phase / w, side * (reach - mu / k));
    while (k * x).abs() > mu {
        (side, t) = (-side, t + PI / w);
        x = side * ((x.abs() - mu / k) - mu / k);
    }
    (t, x)
}

lagrangian! {
    /// A block on a spring whose friction is complete from a velocity on.
    system Saturated {
        param k, mu, slip;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x * x;
        Q[x] = -mu * clamp(dot(x) / slip, -1, 1);
    }
}

/// Equal steps creep through friction that holds, and are told so.
#[test]
fn friction_that_holds_is_named_in_equal_steps() {
    macro_rules! holds {
        ($method:expr, $h:expr) => {
            for number in 0..if cfg!(feature = "long") { 40 } else { 12 } {
                let name = stringify!($method);
                let part = |times: f64| (f64::from(number) * times).fract();
                let (k, mu) = (1.0 + 15.0 * part(0.618), 0.5 + 2.5 * part(0.414));
                let from = State::new(0.0, [part(0.732) - 0.5], [1.0 + 3.0 * part(0.236)]);
                let (t, x) = held([k, mu], [from.q[0], from.qd[0]]);
                if (k * x).abs() > 0.9 * mu {
                    continue;
                }
                let block = Block::new(k, mu);
                let run = integrate(&block, $method, FixedStep::new($h), from).until(t + 10.0);
                let failed = run.final_state().expect_err("it holds");
                let Failure::Sliding { t: end } = failed.failure else { panic!("{name}, {number}: {failed}") };
                assert!((end - t).abs() < 80.0 * $h, "{name}, {number}: {end} for {t}");
                assert!((failed.last.q[0] - x).abs() < 80.0 * $h, "{name}, {number}");
                let before = integrate(&block, $method, FixedStep::new($h), from).until(0.9 * t).final_state();
                assert!(before.is_ok(), "{name}, {number}");
                // The same force without a jump, however coarse the steps are for it.
                let smooth = Saturated::new(k, mu, 1e-3);
                let run = integrate(&smooth, $method, FixedStep::new($h), from).until(0.9 * t).final_state();
                assert!(!matches!(&run, Err(failed) if matches!(failed.failure, Failure::Sliding { .. })), "{name}");
            }
        };
    }
    holds!(Rk4, 0.01);
    holds!(Rk4, 0.001);
    holds!(Tsitouras5, 0.01);
    holds!(DormandPrince5, 0.01);
    // At rest, under a force that friction withstands.
    let block = Block::new(2.0, 1.0);
    let failed = integrate(&block, Rk4, FixedStep::new(0.01), State::new(0.0, [0.2], [0.0])).until(5.0);
    let failed = failed.final_state().expect_err("it holds");
    assert!(matches!(failed.failure, Failure::Sliding { t } if t < 0.2), "{failed}");
    assert!((failed.last.q[0] - 0.2).abs() < 1e-3);
}

lagrangian! {
    /// A block whose friction has three values.
    system Three {
        param mu = 2.943;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = -mu * if dot(x) > 0 { 1 } else if dot(x) < 0 { -1 } else { 0 };
    }
}

lagrangian! {
    /// Two blocks that rub.
    system Two {
        param mu = 2.943;
        coord x, y;
        let friction = mu * signum(dot(x) - dot(y));
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        Q[x] = -friction;
        Q[y] = friction;
    }
}

lagrangian! {
    /// A block on a spring, on a belt.
    system OnABelt {
        param k = 100.0, v = 0.2, mu = 2.943;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * x.powi(2);
        Q[x] = -mu * signum(dot(x) - v);
    }
}

/// Friction that holds exactly at velocity 0, of several values and between bodies, in equal steps; and a block that is
/// always slower than its belt.
#[test]
fn friction_at_rest_and_friction_that_is_not_reached() {
    fn slides<const N: usize>(
        end: Result<State<f64, N>, lagrange_runtime::integrate::Failed<f64, N>>,
    ) -> f64 {
        let failed = end.expect_err("it holds");
        let Failure::Sliding { t } = failed.failure else { panic!("{failed}") };
        t
    }
    macro_rules! holds {
        ($method:expr, $h:expr) => {
            let at_rest = State::new(0.0, [0.0], [0.0]);
            let (block, two, three) = (Block::new(0.0, 2.943), Two::default(), Three::default());
            assert!(
                slides(integrate(&block, $method, FixedStep::new($h), at_rest).until(100.0).final_state())
                    < 20.0 * $h
            );
            let together = State::new(0.0, [0.0, 0.0], [1.0, 1.0]);
            let end = integrate(&two, $method, FixedStep::new($h), together).until(100.0);
            assert!(slides(end.final_state()) < 20.0 * $h);
            for v in [0.5, 1.0, 1.2113, 2.0] {
                let start = State::new(0.0, [0.0], [v]);
                let end = integrate(&three, $method, FixedStep::new($h), start).until(100.0);
                let t = slides(end.final_state());
                assert!((t - v / 2.943).abs() < 40.0 * $h, "{}: {t}", stringify!($method));
            }
        };
    }
    holds!(Rk4, 0.001);
    holds!(Rk4, 0.003);
    holds!(Rk4, 0.01);
    holds!(DormandPrince5, 0.01);
    holds!(lagrange_runtime::method::explicit_rk::Heun, 0.003);
    // x = F/k + (v₀/ω) sin ωt below the velocity of the belt.
    for (h, v0) in [(0.05, 0.1), (0.05, 0.19), (0.02, 0.199), (0.01, 0.1999), (0.005, 0.19999)] {
        let start = State::new(0.0, [2.943 / 100.0], [v0]);
        let end = integrate(&OnABelt::default(), Dop853, FixedStep::new(h), start).until(20.0).final_state();
        assert!((end.unwrap().qd[0] - v0 * 200.0_f64.cos()).abs() < 1e-4, "{h}");
        if h < 0.05 {
            let end = integrate(&OnABelt::default(), Rk4, FixedStep::new(h), start).until(20.0).final_state();
            assert!((end.unwrap().qd[0] - v0 * 200.0_f64.cos()).abs() < 0.1, "{h}");
        }
    }
}

/// Friction that clearly holds is named in time, whatever the tolerance: near the end velocities are below it, and
/// stages are thrown to and fro.
fn holds<M>(method: M)
where
    M: Method<Kinked, 1, Error: ErrorEstimate<f64, 1>> + Copy + core::fmt::Debug,
{
    for number in 0..40 {
        let part = |times: f64| (f64::from(number) * times).fract();
        let (k, mu) = (1.0 + 15.0 * part(0.618), 0.5 + 2.5 * part(0.414));
        let from = [part(0.732) - 0.5, 1.0 + 3.0 * part(0.236)];
        let (t, x) = held([k, mu], from);
        if (k * x).abs() > 0.9 * mu {
            continue;
        }
        for tolerance in [1e-4, 1e-6, 1e-9] {
            let (block, start) = (Any::new(Block::new(k, mu)), State::new(0.0, [from[0]], [from[1]]));
            let run = integrate(&block, method, PiController::tolerance(tolerance), start);
            let failed = run.max_steps(20_000).until(t + 10.0).final_state().expect_err("it holds");
            let Failure::Sliding { t: end } = failed.failure else {
                panic!("{method:?}, {number}: {failed}")
            };
            assert!((end - t).abs() < 1e3 * tolerance, "{method:?}, {number}: {end} for {t}");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn friction_that_clearly_holds_is_named_in_time() {
    by_every_method!(holds);
}

lagrangian! {
    /// Every kind of kink and jump: of position, velocity and time, alone and together.
    system Kinks {
        param a: [8], c: [8], w: [2];
        coord x, y;
        T = 0.5 * dot(x).powi(2) + 0.6 * dot(y).powi(2) + 0.2 * dot(x) * dot(y);
        V = 0.5 * x * x
            + 0.8 * y * y
            + a[0] * abs(x - c[0])
            + a[1] * max(c[1] - y, 0).powf(2.5)
            + a[2] * max(0, x - y - c[2]).powi(2);
        Q[x] = a[3] * (if cos(w[0] * t + c[3]) > 0.3 { 1 } else { 0 }) + a[4] * max(0, sin(w[1] * t) - c[4]);
        Q[y] = -a[5] * signum(dot(y) - c[5]) + a[6] * min(dot(x), c[6]) - a[7] * abs(dot(y)) * dot(y);
    }
}

/// Some of the terms, at rest or on a switch now and then.
fn random_kinks(seed: u64) -> (Kinks, State<f64, 2>) {
    const SIZES: [f64; 8] = [1.0, 50.0, 2.0, 1.0, 1.0, 0.2, 0.5, 0.3];
    let mut state = seed;
    // Knuth's congruential generator (MMIX), from 0 to 1.
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut rarely =
        |part: f64, otherwise: f64| if random() < part { otherwise } else { 2.0 * random() - 1.0 };
    let a = SIZES.map(|size| size * (0.7 + 0.5 * rarely(0.65, -1.4)));
    let c = [0.5; 8].map(|half| half * rarely(0.2, 0.0));
    let w = [2.5; 2].map(|middle| middle + 1.5 * rarely(0.0, 0.0));
    let q = [rarely(0.0, 0.0), rarely(0.2, 0.0)];
    (Kinks::new(a, c, w), State::new(0.0, q, [rarely(0.3, 0.0), rarely(0.3, 0.0)]))
}

/// Random systems with kinks, by methods of every family, against Verner's method and DOP853 to 1e-12 and finer.
/// Motions that both of these say are held are passed over.
fn kinks_are_followed(systems: u64) {
    let (mut followed, mut held) = (0, 0);
    for seed in 0..systems {
        let (system, start) = random_kinks(seed);
        let end = |run: Result<State<f64, 2>, lagrange_runtime::integrate::Failed<f64, 2>>| {
            run.map_err(|lost| lost.failure)
        };
        macro_rules! run {
            ($method:expr, $controller:expr) => {
                end(integrate(&system, $method, $controller, start)
                    .max_steps(1_000_000)
                    .until(6.0)
                    .final_state())
            };
        }
        let exact = match (
            run!(Verner9, PiController::tolerance(1e-13)),
            run!(Dop853, PiController::tolerance(1e-12)),
        ) {
            (Ok(a), Ok(b)) => {
                assert!(lagrange_runtime::testing::distance(&a, &b) < 1e-8, "{seed}: {a:?} {b:?}");
                a
            }
            // Steps become too short for one of them where a motion is nearly held.
            _ => {
                held += 1;
                continue;
            }
        };
        followed += 1;
        for tolerance in [1e-5, 1e-8, 1e-11] {
            let mut all = vec![
                ("Taylor", run!(Taylor, TaylorController::tolerance(tolerance))),
                ("Dop853", run!(Dop853, PiController::tolerance(tolerance))),
                ("DormandPrince5", run!(DormandPrince5, PiController::tolerance(tolerance))),
            ];
            if tolerance > 1e-9 {
                all.push(("Radau5", run!(Radau5, PiController::tolerance(tolerance))));
                all.push(("Rodas5P", run!(Rodas5P, PiController::tolerance(tolerance))));
            }
            for (method, end) in all {
                let end = end.unwrap_or_else(|failure| panic!("{seed}, {method}, {tolerance}: {failure}"));
                let error = lagrange_runtime::testing::distance(&end, &exact);
                assert!(error < 3e4 * tolerance, "{seed}, {method}, {tolerance}: {error:e}");
            }
        }
    }
    println!("{followed} systems followed, {held} held");
    assert!(10 * held < systems, "{held}");
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn random_systems_with_kinks() {
    kinks_are_followed(60);
}

/// (`cargo test --release -p lagrange-motions --test switches -- --ignored --nocapture many_random_systems_with_kinks`)
#[test]
#[ignore = "takes a minute in release"]
fn many_random_systems_with_kinks() {
    kinks_are_followed(10_000);
}
