//! Regular positions that look dependent: bodies of very different masses, gradients that become short, linkages that
//! miss their line, drives. Runs go through, right, and steps land on events there.

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::{Constrained, Prescribed, branches};
use nalgebra::SVector;

lagrangian! {
    /// A slider-crank, with a rod that may be light.
    system SliderCrank {
        param r = 0.3, l = 0.8, crank = 1, rod, slider = 1, g = 9.81;
        coord a: angle, b: angle, x: length;
        let gx = r * cos(a) + 0.5 * l * cos(b);
        let gy = r * sin(a) + 0.5 * l * sin(b);
        T = 0.5 * crank * dot(a).powi(2) + 0.5 * rod * (dot(gx).powi(2) + dot(gy).powi(2))
            + rod * l * l / 24 * dot(b).powi(2) + 0.5 * slider * dot(x).powi(2);
        V = rod * g * gy;
        constraint pin: [r * cos(a) + l * cos(b), r * sin(a) + l * sin(b)] == [x, 0];
    }
}

lagrangian! {
    /// The same by the angle of the crank.
    system Crank {
        param r = 0.3, l = 0.8, crank = 1, rod, slider = 1, g = 9.81;
        coord a: angle;
        let sine = r / l * sin(a);
        let b = asin(-sine);
        let x = r * cos(a) + l * sqrt(1 - sine * sine);
        let gx = r * cos(a) + 0.5 * l * sqrt(1 - sine * sine);
        let gy = 0.5 * r * sin(a);
        T = 0.5 * crank * dot(a).powi(2) + 0.5 * rod * (dot(gx).powi(2) + dot(gy).powi(2))
            + rod * l * l / 24 * dot(b).powi(2) + 0.5 * slider * dot(x).powi(2);
        V = rod * g * gy;
    }
}

lagrangian! {
    /// A double pendulum by the places of its bobs.
    system Bobs {
        param m1, m2 = 1, g = 9.81;
        coord x1, y1, x2, y2;
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = g * (m1 * y1 + m2 * y2);
        constraint upper: x1 * x1 + y1 * y1 == 1;
        constraint lower: (x2 - x1).powi(2) + (y2 - y1).powi(2) == 1;
    }
}

lagrangian! {
    /// The same by its angles.
    system Angles {
        param m1, m2 = 1, g = 9.81;
        coord a: angle, b: angle;
        let x1 = sin(a);
        let y1 = -cos(a);
        let x2 = x1 + sin(b);
        let y2 = y1 - cos(b);
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = g * (m1 * y1 + m2 * y2);
        observe places = [x1, y1, x2, y2];
    }
}

lagrangian! {
    /// A bead on a parabola, by its place.
    system Bead {
        param g = 9.81;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint track: y == x * x;
    }
}

lagrangian! {
    /// The same by x alone.
    system BeadByX {
        param g = 9.81;
        coord x;
        let y = x * x;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
    }
}

lagrangian! {
    /// A linkage that is a parallelogram if `l2` and `base` are 1.
    system FourBar {
        param l2 = 1, base = 1, g = 9.81;
        coord a: angle, c: angle, b: angle;
        let x = cos(a) + 0.5 * cos(b);
        let y = sin(a) + 0.5 * sin(b);
        T = (dot(a).powi(2) + dot(c).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * (sin(a) + sin(c)) + y);
        constraint end: [cos(a) + cos(b), sin(a) + sin(b)] == [l2 * cos(c) + base, l2 * sin(c)];
    }
}

lagrangian! {
    /// A parallelogram with a drive for its first crank, beside a spring of its own.
    system Driven {
        param w, k = 1;
        coord a: angle, c: angle, b: angle, z;
        T = (dot(a).powi(2) + dot(c).powi(2)) / 6 + dot(b).powi(2) / 24 + 0.5 * dot(z).powi(2);
        V = sin(a) + 0.5 * k * z * z;
        constraint drive: a == 1.3 - w * t + 0.1 * sin(w * t);
        constraint end: [cos(a) + cos(b), sin(a) + sin(b)] == [cos(c) + 1, sin(c)];
    }
}

lagrangian! {
    /// A parallelogram whose crank turns at a speed.
    system Turning {
        param w;
        coord a: angle, c: angle, b: angle;
        T = (dot(a).powi(2) + dot(c).powi(2)) / 6 + dot(b).powi(2) / 24;
        V = sin(a);
        constraint speed: dot(a) == -w;
        constraint end: [cos(a) + cos(b), sin(a) + sin(b)] == [cos(c) + 1, sin(c)];
    }
}

lagrangian! {
    /// A slider-crank whose crank turns as it is given: no freedom is left, and the drive and the pins have their
    /// loads.
    system Machine {
        param r = 0.3, l = 0.8, w = 5, rod = 0.7, slider = 1, g = 9.81;
        coord a = w * t;
        coord b: angle, x: length;
        let gx = r * cos(a) + 0.5 * l * cos(b);
        let gy = r * sin(a) + 0.5 * l * sin(b);
        T = 0.5 * rod * (dot(gx).powi(2) + dot(gy).powi(2)) + rod * l * l / 24 * dot(b).powi(2) + 0.5 * slider * dot(x).powi(2);
        V = rod * g * gy;
        constraint pin: [r * cos(a) + l * cos(b), r * sin(a) + l * sin(b)] == [x, 0];
    }
}

lagrangian! {
    /// The parallelogram by one angle.
    system Crank4 {
        param g = 9.81;
        coord a: angle;
        T = 5.0 / 6.0 * dot(a).powi(2);
        V = 2 * g * sin(a);
    }
}

lagrangian! {
    /// A carriage on two axles that are steered against each other.
    system Carriage {
        param m = 2, j = 0.5, steering = 0.1, d = 0.4;
        coord x, y, phi: angle, s: angle;
        let fx = x + d * cos(phi);
        let fy = y + d * sin(phi);
        let rx = x - d * cos(phi);
        let ry = y - d * sin(phi);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * j * dot(phi).powi(2) + 0.5 * steering * dot(s).powi(2);
        V = 0;
        constraint front: -sin(phi + s) * dot(fx) + cos(phi + s) * dot(fy) == 0;
        constraint rear: -sin(phi - s) * dot(rx) + cos(phi - s) * dot(ry) == 0;
    }
}

lagrangian! {
    /// A pendulum by its place.
    system Pendulum {
        param l = 1, g = 9.81;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * y;
        constraint rod: x * x + y * y == l * l;
    }
}

/// Ends of runs by five methods at one tolerance.
macro_rules! ends {
    ($system:expr, $start:expr, $end:expr, $tolerance:expr) => {{
        let pi = PiController::tolerance($tolerance);
        macro_rules! end {
            ($method:ident) => {
                integrate(&$system, $method, pi, $start)
                    .until($end)
                    .final_state()
                    .map_err(|failed| format!("{}: {failed}", failed.failure.name()))
            };
        }
        [end!(DormandPrince5), end!(Dop853), end!(Verner9), end!(Rodas5P), end!(Radau5)]
    }};
}

const TOLERANCES: [f64; 4] = [1e-5, 1e-7, 1e-9, 1e-11];

/// The end of a run of independent coordinates.
macro_rules! precisely {
    ($system:expr, $start:expr, $end:expr) => {
        integrate(&$system, Verner9, PiController::tolerance(1e-14), $start)
            .until($end)
            .final_state()
            .unwrap()
    };
}

#[test]
fn a_light_rod_is_no_dependence() {
    for rod in [0.7, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8] {
        let (linkage, crank) = (SliderCrank::new(rod), Crank::new(rod));
        let a = 0.5f64;
        let guess = State::new(0.0, [a, -(0.375 * a.sin()).asin(), 1.04], [8.0, 0.0, 0.0]);
        let start = consistent(&linkage, &guess).unwrap();
        let by_angle = State::new(0.0, [start.q[0]], [start.qd[0]]);
        let exact = precisely!(crank, by_angle, 2.0).q[0];
        for tolerance in TOLERANCES {
            for end in ends!(linkage, start, 2.0, tolerance) {
                let error = (end.unwrap().q[0] - exact).abs();
                assert!(error < 30.0 * tolerance + 3e-11, "{rod:e} {tolerance:e}: {error:e}");
            }
        }
    }
}

#[test]
fn a_light_elbow_is_no_dependence() {
    for m1 in [1e-2, 1e-3, 4e-4, 1e-4] {
        let (bobs, angles) = (Bobs::new(m1), Angles::new(m1));
        let by_angles = State::new(0.0, [1.0, 0.6], [0.0; 2]);
        let start = State::new(0.0, angles.places_at(&by_angles).data.0[0], [0.0; 4]);
        let exact = angles.places_at(&precisely!(angles, by_angles, 0.5));
        for tolerance in TOLERANCES {
            for end in ends!(bobs, start, 0.5, tolerance) {
                let error = (end.unwrap().q - exact).amax();
                assert!(error < 200.0 * tolerance, "{m1:e} {tolerance:e}: {error:e}");
            }
        }
    }
}

/// The gradient at the bottom is 1, and 60 at the start.
#[test]
fn a_gradient_that_becomes_short_does_not_vanish() {
    let (bead, by_x) = (Bead::new(), BeadByX::new());
    for x in [5.0, 30.0] {
        let start = State::new(0.0, [x, x * x], [0.0; 2]);
        let time = 1.4 * (2.0 * x * x / 9.81f64).sqrt();
        let exact = precisely!(by_x, State::new(0.0, [x], [0.0]), time).q[0];
        for tolerance in TOLERANCES {
            for end in ends!(bead, start, time, tolerance) {
                let error = (end.unwrap().q[0] - exact).abs();
                assert!(error < 1e3 * tolerance + 1e-9, "{x} {tolerance:e}: {error:e}");
            }
        }
    }
}

/// Ends after 1.5 s from rest, by the length along the curve that the linkage can take (SciPy's DOP853 at 1e-12).
#[test]
fn linkages_that_miss_their_line_keep_their_assembly() {
    #[rustfmt::skip]
    let known = [
        (1.001, 1.0, [1.1998055401157626, 1.2001947427175208, 0.0010731403694238463], [2.0081550258606518, 3.1420590220408364, 5.148644177229651]),
        (0.999, 1.0, [1.2001943197270195, 1.1998059634335714, -0.0010726928257861978], [2.8903179536730574, -3.1455563676659586, -0.24718870910401344]),
        (1.0, 1.001, [1.199743192445299, 1.2008160732410418, 0.00038848702834038247], [-2.999010880291082, 3.1489403641483826, 0.1351626865201127]),
        (1.0, 0.999, [1.200256885366334, 1.1991839334737642, -0.0003890720142412783], [-3.674103339356045, -3.676066928930662, -6.281494584848349]),
        (1.0001, 1.0, [1.1999805603207263, 1.2000194425090795, 0.00010729387570801979], [1.9133410054294473, 3.1416283040707538, 5.054827493658166]),
        (1.0, 0.9999, [1.200025685035362, 1.19991839304214, -3.8880881818557153e-05], [-3.646471639298551, -3.6466783059028542, -6.283004436074401]),
        (1.00001, 1.0, [1.1999980560951453, 1.2000019439331544, 1.072918615457318e-05], [1.8830254961993955, 3.1415958813695615, 5.024607641760564]),
    ];
    for (l2, base, start, end) in known {
        let linkage = FourBar { l2, base, ..FourBar::new() };
        let start = consistent(&linkage, &State::new(0.0, start, [0.0; 3])).unwrap();
        for tolerance in [1e-5, 1e-7, 1e-9] {
            for found in ends!(linkage, start, 1.5, tolerance) {
                let error = (found.unwrap().q - SVector::from(end)).amax();
                assert!(error < 100.0 * tolerance, "{l2} {base} {tolerance:e}: {error:e}");
            }
        }
        assert_eq!(branches(&linkage, &State::new(0.0, [0.0; 3], [0.0; 3])), None, "{l2} {base}");
    }
}

/// Nodes beside the line are those of other times.
#[test]
fn drives_go_through_the_line() {
    let (mut right, mut named) = (0, Vec::new());
    for (w, k) in [(2.0, 1.0), (-0.7, 1.0), (30.0, 1.0), (2.0, 1e4)] {
        let driven = Driven { k, ..Driven::new(w) };
        let along = |t: f64| [1.3 - w * t + 0.1 * (w * t).sin(), w * (-1.0 + 0.1 * (w * t).cos())];
        let ([a, v], time) = (along(0.0), 4.0 / w.abs());
        let start = State::new(0.0, [a, a, 0.0, 1e-3], [v, v, 0.0, 0.0]);
        for tolerance in (0..24).map(|k| 10f64.powf(-5.0 - 0.25 * f64::from(k))) {
            for end in ends!(driven, start, time, tolerance) {
                match end {
                    Ok(end) => {
                        let [a, _] = along(time);
                        let error = (end.q[0] - a).abs().max((end.q[1] - a).abs()).max(end.q[2].abs());
                        assert!(error < 1e-6, "{w} {k} {tolerance:e}: {error:e}");
                        right += 1;
                    }
                    Err(failed) => named.push(failed),
                }
            }
        }
    }
    println!("{right} right, {} named", named.len());
    assert!(right >= 49 * named.len(), "{right} right: {named:#?}");
}

/// Drives by speed leave no freedom, and a motion.
#[test]
fn a_drive_by_speed_goes_through_the_line() {
    for w in [0.5, 2.0, 30.0] {
        let (turning, start) = (Turning::new(w), State::new(0.0, [1.3, 1.3, 0.0], [-w, -w, 0.0]));
        for tolerance in [1e-6, 1e-9, 1e-11] {
            for end in ends!(turning, start, 4.0 / w, tolerance) {
                let end = end.unwrap();
                let error = (end.q[0] + 2.7).abs().max((end.q[1] + 2.7).abs()).max(end.q[2].abs());
                assert!(error < 1e-9, "{w} {tolerance:e}: {error:e}");
            }
        }
    }
}

/// Motions that are not promised to get through: each is right, or names its constraints.
#[test]
fn slow_starts_and_steered_axles_are_right_or_named() {
    let linkage = FourBar::new();
    let exact = precisely!(Crank4::new(), State::new(0.0, [0.01], [0.0]), 3.0).q[0];
    let (mut right, mut named) = ([0, 0], [0, 0]);
    let tolerances = || (0..16).map(|k| 10f64.powf(-5.0 - 0.4 * f64::from(k)));
    let is_named = |failed: &str| {
        ["DependentConstraints", "Bifurcation", "Underflow"].iter().any(|n| failed.contains(n))
    };
    for tolerance in tolerances() {
        for end in ends!(linkage, State::new(0.0, [0.01, 0.01, 0.0], [0.0; 3]), 3.0, tolerance) {
            match end {
                Ok(end) => {
                    let error = (end.q - SVector::from([exact, exact, 0.0])).amax();
                    assert!(error < 1e4 * tolerance + 1e-9, "{tolerance:e}: {error:e}");
                    right[0] += 1;
                }
                Err(failed) => {
                    assert!(is_named(&failed), "{failed}");
                    named[0] += 1;
                }
            }
        }
    }
    // ½ (j + m d² cot² s) φ̇² is constant, and s grows by 1 in a second.
    let share = |s: f64| 0.5 + 2.0 * (0.4 / s.tan()).powi(2);
    let carriage = Carriage::new();
    let start = State::new(0.0, [0.0, 0.0, 0.0, 0.5], [0.4 / 0.5f64.tan(), 0.0, 1.0, 1.0]);
    let exact = (share(0.5) / share(2.5)).sqrt();
    for tolerance in tolerances() {
        for end in ends!(carriage, start, 2.0, tolerance) {
            match end {
                Ok(end) => {
                    let error = (end.qd[2] - exact).abs();
                    assert!(error < 100.0 * tolerance, "{tolerance:e}: {error:e}");
                    right[1] += 1;
                }
                Err(failed) => {
                    assert!(is_named(&failed), "{failed}");
                    named[1] += 1;
                }
            }
        }
    }
    println!(
        "slow starts: {} right, {} named; axles: {} right, {} named",
        right[0], named[0], right[1], named[1]
    );
    assert!(right.iter().zip(&named).all(|(right, named)| right > named), "{right:?} {named:?}");
}

#[test]
fn steps_land_in_the_line() {
    let (linkage, start) = (FourBar::new(), State::new(0.0, [1.2, 1.2, 0.0], [0.0; 3]));
    for place in [0.03, 1e-3, 1e-6, 0.0, -1e-3] {
        for tolerance in [1e-6, 1e-8, 1e-10] {
            let pi = PiController::tolerance(tolerance);
            let whole = integrate(&linkage, Dop853, pi, start).until(2.0).final_state().unwrap();
            let passes = move |at: &State<f64, 3>| at.q[0] - place;
            let mut events =
                integrate(&linkage, Dop853, pi, start).until(2.0).events(Event::either(passes).terminal());
            let landed = events.next().unwrap().unwrap().state;
            assert!((landed.q - SVector::from([place, place, 0.0])).amax() < 1e-9, "{place} {tolerance:e}");
            let end = integrate(&linkage, Dop853, pi, landed).until(2.0).final_state().unwrap();
            assert!((end.q - whole.q).amax() < 100.0 * tolerance, "{place} {tolerance:e}");
        }
    }
}

/// The power of the drive is the rate of the energy, which is known in closed form with the motion.
#[test]
fn a_machine_without_freedom_has_loads() {
    let machine = Machine::new();
    assert_eq!(Machine::<f64>::FACTS.degrees_of_freedom(), 0);
    let position = |t: f64| {
        let b = -(0.375 * (5.0 * t).sin()).asin();
        [b, 0.3 * (5.0 * t).cos() + 0.8 * b.cos()]
    };
    let state = |t: f64| {
        let h = 1e-3;
        let slope = |i: usize| {
            let at = |k: f64| position(t + k * h)[i];
            (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
        };
        State::new(t, position(t), [slope(0), slope(1)])
    };
    let start = consistent(&machine, &state(0.0)).unwrap();
    for tolerance in TOLERANCES {
        let run = integrate(&machine, Dop853, PiController::tolerance(tolerance), start).until(3.0);
        for at in run.sample((0..=12).map(|k| 0.25 * f64::from(k))) {
            let at = at.unwrap();
            assert!((at.q - SVector::from(position(at.t))).amax() < 1e-10, "{at:?}");
            let energy = |t: f64| machine.energy_at(&state(t));
            let h = 1e-3;
            let power = (8.0 * (energy(at.t + h) - energy(at.t - h))
                - (energy(at.t + 2.0 * h) - energy(at.t - 2.0 * h)))
                / (12.0 * h);
            let torque = machine.reactions_at(&at)[0];
            assert!((5.0 * torque - power).abs() < 1e-6, "{}: {torque} {power}", at.t);
        }
    }
}

/// A start is as near to the constraints as its run is precise, in whatever units.
#[test]
fn starts_beside_the_constraints_are_refused() {
    for (l, off, tolerance, refused) in [
        (1.0, 1e-6, 1e-9, true),
        (1.0, 1e-6, 1e-5, false),
        (1e-6, 0.5e-6, 1e-9, true),
        (1.0, 1e-12, 1e-9, false),
    ] {
        let start = State::new(0.0, [l + off, 0.0], [0.0; 2]);
        let pendulum = Pendulum { l, ..Pendulum::new() };
        let run = integrate(&pendulum, Dop853, PiController::tolerance(tolerance), start);
        let failed = run.until(1e-3).final_state().err().map(|failed| failed.failure.name());
        assert_eq!(failed == Some("ConstraintViolated"), refused, "{l} {off:e} {tolerance:e}: {failed:?}");
    }
}

/// Beside the line Newton's method goes hundreds of turns away.
#[test]
fn consistent_states_are_near_their_guess() {
    for (l2, base) in [(1.001, 1.0), (1.01, 1.0), (0.99, 1.0), (1.0, 1.003)] {
        let linkage = FourBar { l2, base, ..FourBar::new() };
        for guess in [[1e-6, 1e-6, 0.0], [0.01, 0.0, 0.0], [0.3, 0.3, 0.1], [1.0, 0.9, 0.2]] {
            let found = consistent(&linkage, &State::new(0.0, guess, [0.0; 3])).unwrap();
            assert!(linkage.constraints_at(&found).amax() < 1e-14);
            let far = (found.q - SVector::from(guess)).amax();
            assert!(far < 0.35, "{l2} {base} {guess:?}: {far}");
        }
    }
    // In the line the velocity tells the branch.
    let found = consistent(&FourBar::new(), &State::new(0.0, [0.0, 0.0, 1e-12], [3.0, 3.0, 0.0])).unwrap();
    assert!((found.qd - SVector::from([3.0, 3.0, 0.0])).amax() < 1e-9, "{found:?}");
}
