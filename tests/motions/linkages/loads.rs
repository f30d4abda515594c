//! Multipliers, reactions, derivatives and equilibria near positions in which constraints are dependent.

use lagrange_runtime::analysis::{
    BifurcationKind, Heading, Path, Sensitivity, SmallMotion, equilibria, equilibrium, follow, sensitivity,
};
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Prescribed;
use nalgebra::SVector;

lagrangian! {
    /// A parallelogram with cranks of length l, whose coupler carries a load at the part s of its length.
    system Loaded {
        param s = 0.5, l = 1, base = 1, k = 0, rest = 0, g = 9.81;
        coord a: angle, c: angle, b: angle;
        let x = l * cos(a) + s * cos(b);
        let y = l * sin(a) + s * sin(b);
        T = l * l * (dot(a).powi(2) + dot(c).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * l * (sin(a) + sin(c)) + y) + 0.25 * k * ((a - rest).powi(2) + (c - rest).powi(2));
        constraint end: [l * cos(a) + cos(b), l * sin(a) + sin(b)] == [l * cos(c) + base, l * sin(c)];
        observe pin = reaction(end);
        observe along = reaction(end)[0];
        event line: a;
        event pulls: reaction(end)[0] + 14, falling;
    }
}

lagrangian! {
    /// Its twin of one coordinate.
    system Crank {
        param l = 1, g = 9.81;
        coord a: angle;
        T = 5 * (l * dot(a)).powi(2) / 6;
        V = 2 * g * l * sin(a);
    }
}

lagrangian! {
    /// The parallelogram with a crank that turns evenly.
    system Turned {
        param s = 0.3, w = 2, g = 9.81;
        coord a = 1.3 - w * t;
        coord c: angle, b: angle;
        let x = cos(a) + s * cos(b);
        let y = sin(a) + s * sin(b);
        T = (dot(a).powi(2) + dot(c).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * (sin(a) + sin(c)) + y);
        constraint end: [cos(a) + cos(b), sin(a) + sin(b)] == [cos(c) + 1, sin(c)];
        observe torque = reaction(a);
    }
}

lagrangian! {
    /// Three cranks at 0, ½ and 1 of the base.
    system Three {
        param g = 9.81;
        coord a: [3], b: angle;
        let x = cos(a[0]) + 0.5 * cos(b);
        let y = sin(a[0]) + 0.5 * sin(b);
        T = (0..3).map(|i| dot(a[i]).powi(2)).sum() / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * (0..3).map(|i| sin(a[i])).sum() + y);
        redundant constraint end: [cos(a[0]) + cos(b), sin(a[0]) + sin(b)] == [cos(a[1]) + 1, sin(a[1])];
        redundant constraint middle: [cos(a[0]) + 0.5 * cos(b), sin(a[0]) + 0.5 * sin(b)] == [cos(a[2]) + 0.5, sin(a[2])];
        observe pins = [reaction(end)[0], reaction(end)[1], reaction(middle)[0], reaction(middle)[1]];
    }
}

lagrangian! {
    /// A rotor by its place.
    system Rotor {
        param l;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
    }
}

lagrangian! {
    /// A slider-crank whose rod has a part r of the mass of the slider.
    system LightRod {
        param r, g = 9.81;
        coord a: angle, b: angle, x;
        let gx = 0.3 * cos(a) + 0.4 * cos(b);
        let gy = 0.3 * sin(a) + 0.4 * sin(b);
        T = 0.5 * dot(a).powi(2) + 0.5 * r * (dot(gx).powi(2) + dot(gy).powi(2)) + r * dot(b).powi(2) / 24 + 0.5 * dot(x).powi(2);
        V = g * sin(a);
        constraint pin: [0.3 * cos(a) + 0.8 * cos(b), 0.3 * sin(a) + 0.8 * sin(b)] == [x, 0];
        observe force = reaction(pin);
    }
}

lagrangian! {
    /// A belt that runs.
    system Belt {
        param v;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        constraint belt: dot(x) == v;
    }
}

lagrangian! {
    /// A slider-crank and a hanging mass in space of the size l, by places.
    system Small {
        param l, g = 9.81;
        coord x, y, s, u, v;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(s).powi(2) + dot(u).powi(2) + dot(v).powi(2));
        V = g * (y + v);
        constraint crank: x.powi(2) + y.powi(2) == (0.3 * l).powi(2);
        constraint rod: (x - s).powi(2) + y.powi(2) == (0.8 * l).powi(2);
        constraint rope: (u - s).powi(2) + v.powi(2) == l.powi(2);
        observe loads = [reaction(crank), reaction(rod), reaction(rope)];
    }
}

lagrangian! {
    /// A truss of two bars that hold a node, on a support that could move.
    system Truss {
        param h = 1, load = 3, w = 0;
        coord x, y;
        coord p = w * t;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = load * y;
        constraint left: (x - p + 1).powi(2) + (y - h).powi(2) == 1 + h.powi(2);
        constraint right: (x - p - 1).powi(2) + (y - h).powi(2) == 1 + h.powi(2);
        observe bars = [reaction(left), reaction(right)];
    }
}

const START: [f64; 3] = [1.2, 1.2, 0.0];

/// Acceleration and multipliers of a state on the parallelogram, by hand: the load's moment about the first pin gives
/// λ_y, and the second crank's equation λ_x, of which a part grows as 1/sin a unless the load is in the middle.
fn by_hand(s: f64, a: f64, v: f64) -> (f64, [f64; 2]) {
    let (sin, cos) = a.sin_cos();
    let rate = -1.2 * 9.81 * cos;
    let y = rate * cos - v * v * sin + 9.81;
    let odd = if s == 0.5 { 0.0 } else { (s - 0.5) * y * cos / sin };
    (rate, [odd - 0.5 * (rate * sin + v * v * cos), s * y])
}

fn worst(found: &[f64], exact: &[f64]) -> f64 {
    found.iter().zip(exact).map(|(x, y)| if x.is_nan() { 1e300 } else { (x - y).abs() }).fold(0.0, f64::max)
}

#[test]
fn loads_in_the_line_are_right() {
    let linkage = Loaded::new();
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let run = || {
            integrate(&linkage, Dop853, PiController::tolerance(tolerance), State::new(0.0, START, [0.0; 3]))
        };
        let t = run()
            .until(2.0)
            .events(Event::falling(|at: &State<f64, 3>| at.q[0]))
            .next()
            .unwrap()
            .unwrap()
            .state
            .t;
        for delta in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 0.0] {
            let times = (-20..=20).map(|k| t + f64::from(k) * 0.05 * delta / 5.3);
            let times = times.take(if delta == 0.0 { 1 } else { 41 });
            let mut off = 0.0f64;
            for at in run().until(2.0).sample(times) {
                let at = at.unwrap();
                // (Where constraints are dependent, cranks differ by what a projection makes of rounding.)
                let crank = |x: &SVector<f64, 3>| 0.5 * (x[0] + x[1]);
                let (rate, exact) = by_hand(0.5, crank(&at.q), crank(&at.qd));
                for found in [linkage.multipliers_at(&at), linkage.pin_at(&at)] {
                    off = off.max(worst(found.as_slice(), &exact));
                }
                off = off.max((linkage.along_at(&at) - exact[0]).abs());
                off = off.max(worst(linkage.accel_at(&at).as_slice(), &[rate, rate, 0.0]));
            }
            println!("{tolerance:e}, δ = {delta:e}: {off:.1e}");
            assert!(off < 1e-5 + 20.0 * tolerance, "{tolerance:e}, δ = {delta:e}: {off:e}");
        }
    }
}

/// A load beside the middle makes λ_x grow as 1/δ: right, or not a number, and this only near the line.
#[test]
fn loads_without_bound_are_no_numbers() {
    let linkage = Loaded { s: 0.3, ..Loaded::new() };
    let start = State::new(0.0, START, [0.0; 3]);
    let mut unknown = 0;
    for at in
        integrate(&linkage, Dop853, PiController::tolerance(1e-12), start).until(0.7).sample_evenly(7000)
    {
        let at = at.unwrap();
        let exact = by_hand(0.3, at.q[0], at.qd[0]).1;
        let found = linkage.pin_at(&at);
        if found.iter().any(|x| x.is_nan()) {
            unknown += 1;
            assert!(at.q[0].abs() < 0.03, "{}", at.q[0]);
        } else {
            let size = exact[0].abs() + exact[1].abs();
            assert!(worst(found.as_slice(), &exact) < 1e-6 * size, "{}: {found} {exact:?}", at.q[0]);
        }
    }
    println!("{unknown} of 7000 states in 0.7 s have no number");
    assert!((1..200).contains(&unknown), "{unknown}");
}

lagrangian! {
    /// A bead on two wires that cross.
    system Crossed {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 9.81 * y;
        constraint wires: x * (x - y) == 0;
    }
}

/// On the wire y = x the multiplier is −4.905/x, since the gradient vanishes where the wires cross: no number near
/// there, and none at it.
#[test]
fn loads_where_a_gradient_vanishes_are_no_numbers() {
    for x in [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.3, -1e-12, -0.3] {
        let at = State::new(0.0, [x, x], [2.0, 2.0]);
        let found = Crossed::new().multipliers_at(&at)[0];
        let is_right = (found * x + 4.905).abs() < 1e-12;
        assert!(is_right || x.abs() < 0.1 && found.is_nan(), "{x:e}: {found:e}");
    }
}

lagrangian! {
    /// A bead on three wires that cross.
    system Wires {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.7 * x + 0.4 * y;
        constraint wires: x * y * (x - y) == 0;
    }
}

lagrangian! {
    /// A bead in a plane, or on a cylinder.
    system Sheets {
        coord x, y, z;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = 0.2 * x + 0.9 * y + 0.3 * z;
        constraint sheets: (x.powi(2) + y.powi(2) - 1) * z == 0;
    }
}

/// Gradients that have no part along the wire say nothing of the motion along it.
#[test]
fn beads_pass_crossings_of_wires_and_of_sheets() {
    let (wires, sheets) = (Wires::new(), Sheets::new());
    for k in 0..72 {
        let d = 10f64.powf(-12.0 + f64::from(k) / 6.0);
        let at = State::new(0.0, [d, 0.0], [2.0, 0.0]);
        let after = wires.jump(&at, &[0.3, -0.7].into()).after.qd;
        assert!(worst(wires.accel_at(&at).as_slice(), &[-0.7, 0.0]) < 1e-8, "{d:e}");
        assert!(worst(after.as_slice(), &[2.3, 0.0]) < 1e-8, "{d:e}");
        let at = State::new(0.0, [1.0 - d, 0.0, 0.0], [2.0, 0.5, 0.0]);
        let after = sheets.jump(&at, &[0.3, -0.7, 0.4].into()).after.qd;
        assert!(worst(sheets.accel_at(&at).as_slice(), &[-0.2, -0.9, 0.0]) < 1e-8, "{d:e}");
        assert!(worst(after.as_slice(), &[2.3, -0.2, 0.0]) < 1e-8, "{d:e}");
    }
}

/// A load all but in the middle: the pole is told where it is 1e-10 of the load at the nearest of the nodes, which are
/// 0.1 rad apart. A weaker one is left out.
#[test]
fn loads_that_are_nearly_bounded_are_no_numbers() {
    let mut unknown = [0; 6];
    for (beside, unknown) in [1e-2, 1e-4, 1e-6, 1e-8, 1e-9, 1e-11].into_iter().zip(&mut unknown) {
        let linkage = Loaded { s: 0.5 + beside, ..Loaded::new() };
        let start = State::new(0.0, START, [0.0; 3]);
        let run = || integrate(&linkage, Dop853, PiController::tolerance(1e-12), start).until(1.0);
        let t = run().events(Event::falling(|at: &State<f64, 3>| at.q[0])).next().unwrap().unwrap().state.t;
        for delta in [1e-2, 1e-4, 1e-6, 1e-8] {
            for at in run().sample([t - delta / 5.3, t + delta / 5.3]) {
                let at = at.unwrap();
                let found = linkage.pin_at(&at);
                let exact = by_hand(0.5 + beside, at.q[0], at.qd[0]).1;
                let left_out = 1e-11 / at.q[0].abs();
                let off = worst(found.as_slice(), &exact);
                let told = || std::format!("{beside:e}, {delta:e}: {found} {exact:?}");
                *unknown += i32::from(found[0].is_nan());
                assert!(found[0].is_nan() || off < (1e-6 + left_out) * exact[0].abs(), "{}", told());
            }
        }
    }
    assert_eq!(unknown, [6, 6, 6, 6, 6, 0]);
}

/// An impulse changes the rate of the cranks by the impulses on both over 5/3, at any distance from the line, also at a
/// state that an event found there. At rest in the line no branch is given.
#[test]
fn impulses_in_the_line_are_right() {
    let linkage = Loaded::new();
    let start = State::new(0.0, START, [0.0; 3]);
    let ends = [1e-6, 1e-9, 1e-12].map(|tolerance| {
        let run = integrate(&linkage, Dop853, PiController::tolerance(tolerance), start).until(1.0);
        let event = run.events(Loaded::LINE.terminal()).last().unwrap().unwrap();
        assert!(event.state.q.amax() < 1e-5, "{event:?}");
        (event.state, 1e-6 + 10.0 * tolerance)
    });
    let angles = [0.5, 1e-2, 1e-4, 1e-6, 1e-8, 1e-12, 1e-19, 0.0, -1e-9];
    let states = angles.map(|a| (State::new(0.0, [a, a, 0.0], [2.0, 2.0, 0.0]), 1e-8));
    for (at, error) in states.into_iter().chain(ends) {
        for impulse in [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.3, -0.8, 0.7], [0.0, 0.0, 1.0]] {
            let jump = linkage.jump(&at, &impulse.into());
            let (before, change) = (0.5 * (at.qd[0] + at.qd[1]), (impulse[0] + impulse[1]) / (5.0 / 3.0));
            let exact = [before + change, before + change, 0.0];
            let told = || std::format!("{at:?} {impulse:?}: {jump:?}");
            assert!(worst(jump.after.qd.as_slice(), &exact) < error, "{}", told());
            let gained = 5.0 / 3.0 * change * (before + 0.5 * change);
            assert!((jump.energy - gained).abs() < 10.0 * error, "{gained} {}", told());
            // M Δq̇ = P + reaction, of which the last row is ½ cos a Δȧ.
            let reaction = 0.5 * at.q[0].cos() * change - impulse[2];
            assert!((jump.reaction[2] - reaction).abs() < error, "{}", told());
        }
    }
    let rest = State::new(0.0, [0.0; 3], [0.0; 3]);
    assert!(linkage.jump(&rest, &[0.3, -0.8, 0.7].into()).after.qd[0].is_nan());
}

#[test]
fn extremes_and_integrals_of_loads_pass_the_line() {
    let (linkage, start) = (Loaded::new(), State::new(0.0, START, [0.0; 3]));
    for tolerance in [1e-6, 1e-8, 1e-10] {
        let run = || integrate(&linkage, Dop853, PiController::tolerance(tolerance), start).until(1.0);
        let total = run().integrals([0.0], |at: &State<f64, 3>| [linkage.along_at(at)]).total().unwrap();
        // By Simpson's rule over the twin.
        let (crank, n) = (Crank::new(), 4000);
        let pi = PiController::tolerance(1e-13);
        let twin = integrate(&crank, Dop853, pi, State::new(0.0, [1.2], [0.0])).until(1.0);
        let mut exact = 0.0;
        for (k, at) in twin.sample((0..=n).map(|k| f64::from(k) / f64::from(n))).enumerate() {
            let at = at.unwrap();
            let weight = if k == 0 || k == n as usize { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
            exact += weight * by_hand(0.5, at.q[0], at.qd[0]).1[0] / (3.0 * f64::from(n));
        }
        let error = (total.integrals[0] - exact).abs();
        assert!(error < 1e3 * tolerance + 1e-6, "{tolerance:e}: {error:e}");
        // The pull is largest, 17.8, in the line, and passes 14 before and after it.
        let events: Vec<_> = run().events(Loaded::PULLS).map(|found| found.unwrap().state).collect();
        assert_eq!(events.len(), 1, "{tolerance:e}");
        let found = by_hand(0.5, events[0].q[0], events[0].qd[0]).1[0] + 14.0;
        assert!(found.abs() < 1e3 * tolerance + 1e-6, "{found:e}");
    }
}

#[test]
fn the_torque_of_a_drive_passes_the_line() {
    let linkage = Turned::new();
    let start = consistent(&linkage, &State::new(0.0, [1.3, 0.0], [-2.0, 0.0])).unwrap();
    for tolerance in [1e-7, 1e-10] {
        let run = integrate(&linkage, Dop853, PiController::tolerance(tolerance), start).until(2.0);
        let mut times: Vec<f64> = (0..=40).map(|k| 0.05 * f64::from(k)).collect();
        times.extend([0.65 - 1e-3, 0.65 - 1e-5, 0.65, 0.65 + 1e-7, 0.65 + 1e-4]);
        times.sort_by(f64::total_cmp);
        times.dedup_by(|x, y| (*x - *y).abs() < 1e-12);
        for at in run.sample(times) {
            let at = at.unwrap();
            let exact = 2.0 * 9.81 * (1.3 - 2.0 * at.t).cos();
            let off =
                (linkage.torque_at(&at) - exact).abs().max((linkage.reactions_at(&at)[0] - exact).abs());
            // (Forces in the pins grow without bound, of whatever load: the torque is that of their work.)
            assert!(off < 1e-5, "{tolerance:e} {}: {off:e}", at.t);
        }
    }
    let even = Turned { s: 0.5, ..linkage };
    let mut worst = 0.0f64;
    for at in integrate(&even, Dop853, PiController::tolerance(1e-10), start).until(0.8).sample_evenly(8000) {
        let at = at.unwrap();
        let off = (even.torque_at(&at) - 2.0 * 9.81 * (1.3 - 2.0 * at.t).cos()).abs();
        worst = if off.is_nan() { 1e300 } else { worst.max(off) };
    }
    assert!(worst < 1e-5, "{worst:e}");
}

/// Multipliers of least norm through the line, against a parabola through those farther away, where they have digits.
#[test]
fn loads_of_redundant_cranks_pass_the_line() {
    let linkage = Three::new();
    let start = State::new(0.0, [1.2, 1.2, 1.2, 0.0], [0.0; 4]);
    let run = || integrate(&linkage, Dop853, PiController::tolerance(1e-11), start).until(1.0);
    let t = run().events(Event::falling(|at: &State<f64, 4>| at.q[0])).next().unwrap().unwrap().state.t;
    let at = |s: f64| run().sample([t + s]).next().unwrap().unwrap();
    let h = 0.02;
    // Weights at 0 of the polynomial through ±1, ±2, ±3.
    let weights = [0.75, -0.3, 0.05];
    let mut middle = SVector::<f64, 4>::zeros();
    for (k, weight) in weights.iter().enumerate() {
        let s = h * (k + 1) as f64;
        middle += (linkage.pins_at(&at(s)) + linkage.pins_at(&at(-s))) * *weight;
    }
    for s in [0.0, 1e-6, -1e-5, 1e-4] {
        let found = linkage.pins_at(&at(s));
        let near = (linkage.pins_at(&at(h)) - linkage.pins_at(&at(-h))) * (s / (2.0 * h));
        let off = (found - middle - near).amax();
        assert!(off < 1e-3, "{s:e}: {off:e} of {}", middle.amax());
    }
}

/// At rest, and with a rod that is light as such, multipliers are those of the state alone.
#[test]
fn loads_of_light_rods_at_rest() {
    for r in [1e-2, 1e-4, 1e-8] {
        let linkage = LightRod::new(r);
        for a in [0.3, 1.5, 0.0] {
            let at = consistent(&linkage, &State::new(0.0, [a, -(0.375 * a.sin()).asin(), 1.0], [0.0; 3]))
                .unwrap();
            let (found, alone) = (linkage.force_at(&at), linkage.force(&at.q, &at.qd, 0.0));
            assert!((found - alone).amax() < 1e-6 * alone.amax(), "{r:e} {a}: {found} {alone}");
        }
    }
}

#[test]
fn derivatives_by_a_length_end_in_the_line() {
    let start = State::new(0.0, START, [0.0; 3]);
    let given = |base, l, g| Loaded { base, l, g, ..Loaded::new().map(Gradient::<f64, 1>::constant) };
    let constant = Gradient::<f64, 1>::constant;
    let slope = |by: usize, duration: f64, start: &State<f64, 3>, tolerance: f64| {
        let family = |[p]: [Gradient<f64, 1>; 1]| match by {
            0 => given(p, constant(1.0), constant(9.81)),
            1 => given(constant(1.0), p, constant(9.81)),
            _ => given(constant(1.0), constant(1.0), p),
        };
        let value = [1.0, 1.0, 9.81][by];
        sensitivity(family, [value], Dop853, PiController::tolerance(tolerance), start, duration)
    };
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        for duration in [0.7, 1.0, 2.0] {
            let failure = slope(0, duration, &start, tolerance).unwrap_err();
            assert_eq!(failure.name(), "NotDifferentiable", "{tolerance:e} {duration}: {failure}");
            let text = failure.to_string();
            assert!(text.contains("`end") && text.contains("no derivative"), "{text}");
        }
        // Before the line there are some.
        slope(0, 0.5, &start, tolerance).unwrap();
        // Those by a length that all cranks have, and by g, are those of the twin.
        for by in [1, 2] {
            let Sensitivity { slopes: [slope], .. } = slope(by, 1.0, &start, tolerance).unwrap();
            let twin = |[p]: [Gradient<f64, 1>; 1]| match by {
                1 => Crank { l: p, g: constant(9.81) },
                _ => Crank { l: constant(1.0), g: p },
            };
            let value = [1.0, 1.0, 9.81][by];
            let begin = State::new(0.0, [1.2], [0.0]);
            let exact =
                sensitivity(twin, [value], Dop853, PiController::tolerance(1e-12), &begin, 1.0).unwrap();
            let off = (slope.q[0] - exact.slopes[0].q[0]).abs();
            assert!(off < 1e4 * tolerance, "{by} {tolerance:e}: {off:e}");
        }
    }
}

/// The gradient of a rotor's constraint turns by right angles within steps, and has its derivative.
#[test]
fn derivatives_of_a_rotor_by_its_length() {
    for (tolerance, h) in [(1e-3, 0.0), (1e-5, 0.0), (1e-9, 0.0), (0.0, 0.2), (0.0, 0.05)] {
        let start = State::new(0.0, [1.0, 0.0], [0.0, 10.0]);
        let family = |[l]: [Gradient<f64, 1>; 1]| Rotor { l };
        // The velocity is given, so that the angle is v t / l.
        let found = if h > 0.0 {
            sensitivity(family, [1.0], Rk4, FixedStep::new(Gradient::constant(h / 10.0)), &start, 1.0)
        } else {
            sensitivity(family, [1.0], Verner9, PiController::tolerance(tolerance), &start, 1.0)
        };
        let Sensitivity { end, slopes: [slope] } = found.unwrap();
        let exact = SVector::from([10f64.cos() + 10.0 * 10f64.sin(), 10f64.sin() - 10.0 * 10f64.cos()]);
        let off = (slope.q - exact).amax();
        assert!(off < 1e4 * tolerance + 10.0 * h, "{tolerance:e} {h}: {off:e} {end:?}");
    }
}

#[test]
fn curves_of_equilibria_tell_of_the_line() {
    // Springs hold the cranks: k (a − rest) + 2 g cos a = 0.
    let (k, g) = (50.0, 9.81);
    let family = |rest: Dual<f64>| Loaded { rest, k: Dual::constant(k), ..Loaded::new().map(Dual::constant) };
    let rest = |a: f64| a + 2.0 * g * a.cos() / k;
    for step in [0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.02] {
        let path = Path { range: (rest(-0.5), rest(0.55)), step, steps: 4000 };
        let found = match follow(&family, &[0.5, 0.5, 0.0], rest(0.5), &Heading::Down, &path) {
            Err(error) => {
                println!("{step}: {error}");
                assert_eq!(error.name(), "DependentConstraints", "{error}");
                continue;
            }
            Ok(found) => found,
        };
        println!("{step}: goes over");
        assert!(found.complete && found.bifurcations.len() == 1, "{step}: {:?}", found.bifurcations);
        let at = &found.bifurcations[0];
        assert_eq!(at.kind, BifurcationKind::DependentConstraints);
        assert!(at.q.amax() < 1e-7 && (at.parameter - rest(0.0)).abs() < 1e-7, "{at:?}");
        for point in &found.points {
            assert!(
                (rest(point.q[0]) - point.parameter).abs() < 1e-9 && point.q[2].abs() < 1e-9,
                "{point:?}"
            );
        }
    }
}

#[test]
fn equilibria_in_singular_positions_are_told() {
    // Springs that balance in the line.
    let linkage = Loaded { k: 50.0, rest: 19.62 / 50.0, ..Loaded::new() };
    for guess in [[0.6, 0.6, 0.0], [0.1, 0.1, 0.0], [0.0; 3]] {
        let error = equilibrium(&linkage, &guess).unwrap_err();
        assert_eq!(error.name(), "DependentConstraints", "{guess:?}: {error}");
    }
    // From starts on no branch Newton's method ends beside both of them, by roundings of the constraints.
    for linkage in [linkage, Loaded { k: 5.0, g: 0.0, ..Loaded::new() }] {
        for starts in [30, 200] {
            let found = equilibria(&linkage, &[-1.0; 3], &[1.0; 3], starts).unwrap();
            assert!(found.is_empty(), "{found:?}");
        }
    }
    let belt = Belt::new(1.0);
    let error = equilibrium(&belt, &[0.0; 2]).unwrap_err().to_string();
    assert!(
        error.contains("constraints that admit rest") && error.contains("SmallMotion::steady"),
        "{error}"
    );
    assert!(SmallMotion::steady(&belt, &State::new(0.0, [0.0; 2], [1.0, 0.0])).is_ok());
}

/// Whatever the unit of length, loads of regular mechanisms are those of the state alone, in motion and at rest.
#[test]
fn loads_of_small_mechanisms() {
    for l in [1e-6, 1e-3, 1.0, 1e3] {
        let small = Small::new(l);
        for (angle, rate) in [(0.4, 3.0), (0.0, 3.0), (1.3, 0.0), (2.9, -0.01)] {
            let b = -(0.375 * f64::sin(angle)).asin();
            let (x, y) = (0.3 * l * angle.cos(), 0.3 * l * angle.sin());
            let s = x + 0.8 * l * b.cos();
            let guess =
                State::new(0.0, [x, y, s, s + 0.6 * l, -0.8 * l], [-rate * y, rate * x, 0.0, 0.0, 0.0]);
            let at = consistent(&small, &guess).unwrap();
            let (found, alone) = (small.loads_at(&at), small.loads(&at.q, &at.qd, 0.0));
            assert!((found - alone).amax() <= 1e-9 * alone.amax(), "{l:e} {angle} {rate}: {found} {alone}");
        }
    }
}

/// Nothing moves in a truss: bars in a right angle, and flat ones of which each carries much.
#[test]
fn loads_of_a_truss() {
    for h in [1.0, 0.1, 1e-2, 1e-3] {
        let truss = Truss { h, ..Truss::new() };
        let at = State::new(0.0, [0.0; 2], [0.0; 2]);
        // Each bar has −2 h λ of vertical force: half of the load.
        let (found, exact) = (truss.bars_at(&at), -0.5 * truss.load / (2.0 * h));
        let right = found.iter().all(|x| (x - exact).abs() < 1e-9 * exact.abs());
        println!("{h:e}: {} for {exact}", found[0]);
        assert!(right || h < 0.02 && found.iter().all(|x| x.is_nan()), "{h}: {found} {exact}");
    }
}
