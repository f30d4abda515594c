//! Motions through other positions with dependent constraints, and starts in them, against twins of independent
//! coordinates.

use crate::systems::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;
use std::f64::consts::{FRAC_PI_2, PI};

lagrangian! {
    /// A slider-crank whose rod is as long as its crank, and lies on it: the slider moves twice as far as the pin.
    system Folded {
        param r = 0.5, crank = 1, rod = 0.5, slider = 0.7, g = 9.81;
        coord phi: angle;
        let x = 1.5 * r * cos(phi);
        let y = 0.5 * r * sin(phi);
        T = crank * r * r / 6 * dot(phi).powi(2) + 2 * slider * (r * dot(phi) * sin(phi)).powi(2)
            + 0.5 * rod * (dot(x).powi(2) + dot(y).powi(2) + r * r / 12 * dot(phi).powi(2));
        V = g * (0.5 * crank * r * sin(phi) + rod * y);
    }
}

lagrangian! {
    /// The same with the rod back to the pivot, where the slider rests.
    system Resting {
        param r = 0.5, crank = 1, rod = 0.5, g = 9.81;
        coord phi: angle;
        T = (crank / 6 + rod / 6) * (r * dot(phi)).powi(2);
        V = 0.5 * g * (crank + rod) * r * sin(phi);
    }
}

lagrangian! {
    /// A parallelogram with a pendulum on the end of its first crank: two freedoms.
    system Hung {
        param g = 9.81;
        coord a: [2], b, c;
        let x = cos(a[0]) + 0.5 * cos(b);
        let y = sin(a[0]) + 0.5 * sin(b);
        let u = cos(a[0]) + 0.4 * sin(c);
        let v = sin(a[0]) - 0.4 * cos(c);
        T = (dot(a[0]).powi(2) + dot(a[1]).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24
            + 0.15 * (dot(u).powi(2) + dot(v).powi(2));
        V = g * (0.5 * sin(a[0]) + 0.5 * sin(a[1]) + y + 0.3 * v);
        constraint horizontal: cos(a[0]) + cos(b) == cos(a[1]) + 1;
        constraint vertical: sin(a[0]) + sin(b) == sin(a[1]);
    }
}

lagrangian! {
    /// The same with the bob by its place.
    system HungByPlace {
        param g = 9.81;
        coord a: [2], b, u, v;
        let x = cos(a[0]) + 0.5 * cos(b);
        let y = sin(a[0]) + 0.5 * sin(b);
        T = (dot(a[0]).powi(2) + dot(a[1]).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24
            + 0.15 * (dot(u).powi(2) + dot(v).powi(2));
        V = g * (0.5 * sin(a[0]) + 0.5 * sin(a[1]) + y + 0.3 * v);
        constraint horizontal: cos(a[0]) + cos(b) == cos(a[1]) + 1;
        constraint vertical: sin(a[0]) + sin(b) == sin(a[1]);
        constraint rod: (u - cos(a[0])).powi(2) + (v - sin(a[0])).powi(2) == 0.16;
    }
}

lagrangian! {
    /// Its twin: `(5/6) ȧ²` and 2 g sin a of the parallelogram.
    system Twin {
        param g = 9.81;
        coord a, c;
        let u = cos(a) + 0.4 * sin(c);
        let v = sin(a) - 0.4 * cos(c);
        T = 5 * dot(a).powi(2) / 6 + 0.15 * (dot(u).powi(2) + dot(v).powi(2));
        V = g * (2 * sin(a) + 0.3 * v);
    }
}

/// The state of a twin at the end.
fn reference<Sys: System<N, Scalar = f64>, const N: usize>(
    twin: &Sys,
    start: State<f64, N>,
    end: f64,
) -> State<f64, N> {
    integrate(twin, Verner9, PiController::tolerance(1e-13), start).until(end).final_state().unwrap()
}

/// Errors of the coordinates at the end, of runs at this tolerance.
macro_rules! errors {
    ($system:expr, $start:expr, $end:expr, $exact:expr, $tolerance:expr) => {{
        let (system, start, exact, tolerance) = (&$system, $start, SVector::from($exact), $tolerance);
        let pi = PiController::tolerance(tolerance);

        let off = |end: State<f64, _>| (end.q - exact).amax();
        [
            integrate(system, DormandPrince5, pi, start).until($end).final_state().map(off),
            integrate(system, Dop853, pi, start).until($end).final_state().map(off),
            integrate(system, Verner9, pi, start).until($end).final_state().map(off),
            integrate(system, Radau5, pi, start).until($end).final_state().map(off),
            integrate(system, Taylor, TaylorController::tolerance(tolerance), start)
                .until($end)
                .final_state()
                .map(off),
        ]
        .map(|found| found.map_err(|failed| failed.to_string()))
    }};
}

/// Crank and rod of one length, over both of the positions in which the rod can fold back: from elsewhere, and from
/// there.
#[test]
fn a_folded_crank_keeps_its_branch() {
    let system = SliderCrank { r: 0.5, l: 0.5, ..SliderCrank::new() };
    for (at, rate) in [(0.3, 9.0), (FRAC_PI_2, 6.0), (-FRAC_PI_2, -14.0), (FRAC_PI_2 - 1e-6, 5.0)] {
        let end = 2.0;
        let folded = reference(&Folded::new(), State::new(0.0, [at], [rate]), end).q[0];
        let resting = reference(&Resting::new(), State::new(0.0, [at], [rate]), end).q[0];
        for tolerance in [1e-6, 1e-9, 1e-11] {
            for (start, exact) in [
                (State::new(0.0, [at, at], [rate, rate]), [folded, folded]),
                (State::new(0.0, [at, PI - at], [rate, -rate]), [resting, PI - resting]),
            ] {
                let errors = errors!(system, start, end, exact, tolerance);
                for error in &errors {
                    let error = *error.as_ref().unwrap_or(&f64::NAN);
                    assert!(error < 1000.0 * tolerance, "{at} {rate} {tolerance:e} {exact:?}: {errors:?}");
                }
            }
        }
    }
}

/// A second freedom, which may be fast where the linkage is slow. Errors are compared with those of the twin by the
/// same method, as motions of two freedoms lose digits on their own. Where the bob is led by a constraint, runs that do
/// not get through are named.
#[test]
fn a_pendulum_on_the_linkage_does_not_matter() {
    let mut named = 0;
    for (at, rates) in [(FRAC_PI_2, [-1.0, 2.0]), (0.0, [-0.8, 3.0]), (0.0, [2.0, 0.0]), (1e-7, [-1.0, -9.0])]
    {
        let end = 3.0;
        let start = State::new(0.0, [at, 0.4], rates);
        let exact = reference(&Twin::new(), start, end);
        let by_angle = |[a, c]: [f64; 2]| [a, a, 0.0, c];
        let by_place = |[a, c]: [f64; 2]| [a, a, 0.0, a.cos() + 0.4 * c.sin(), a.sin() - 0.4 * c.cos()];
        let [a, c] = rates;
        let rates_by_place =
            [a, a, 0.0, -a * at.sin() + 0.4 * c * 0.4f64.cos(), a * at.cos() + 0.4 * c * 0.4f64.sin()];
        let angle = State::new(0.0, by_angle([at, 0.4]), by_angle(rates));
        let place = State::new(0.0, by_place([at, 0.4]), rates_by_place);
        for tolerance in [1e-6, 1e-9, 1e-11] {
            let twin = errors!(Twin::new(), start, end, exact.q, tolerance).map(Result::unwrap);
            let found = errors!(Hung::new(), angle, end, by_angle(exact.q.into()), tolerance);
            let led = errors!(HungByPlace::new(), place, end, by_place(exact.q.into()), tolerance);
            println!("{at} {rates:?} {tolerance:e}\n  twin {twin:?}\n  hung {found:?}\n  led {led:?}");
            for (k, twin) in twin.into_iter().enumerate() {
                let bound = 300.0 * twin.max(tolerance);
                let case = || std::format!("{k} {at} {rates:?} {tolerance:e}: {twin:e} {found:?} {led:?}");
                assert!(*found[k].as_ref().unwrap_or(&f64::NAN) < bound, "{}", case());
                match &led[k] {
                    Ok(error) => assert!(*error < bound, "{}", case()),
                    Err(failed) => {
                        assert!(failed.contains("`horizontal`"), "{}", case());
                        named += 1;
                    }
                }
            }
        }
    }
    assert!(named < 15, "{named}");
}

/// Redundant cranks begin in the line, too.
#[test]
fn redundant_cranks_begin_in_the_line() {
    let system = ThreeCranks::new();
    for at in [0.0, PI, 1e-6] {
        let end = 2.0;
        let exact = SimplePendulum::new(1.25 * 9.81, 1.0, FRAC_PI_2 + at, 1.3).state(end).0 - FRAC_PI_2;
        let start = State::new(0.0, [at, at, at, 0.0], [1.3, 1.3, 1.3, 0.0]);
        for tolerance in [1e-6f64, 1e-9, 1e-11] {
            let pi = PiController::tolerance(tolerance);
            for end in [
                integrate(&system, Dop853, pi, start).until(end).final_state(),
                integrate(&system, Verner9, pi, start).until(end).final_state(),
            ] {
                let error = (end.unwrap().q - SVector::from([exact, exact, exact, 0.0])).amax();
                assert!(error < 10.0 * tolerance, "{at} {tolerance:e}: {error:e}");
            }
        }
    }
}

/// Derivatives by the velocity with which a motion begins in the line.
#[test]
fn derivatives_of_starts_in_the_line() {
    let angle = |rate: f64| SimplePendulum::new(1.2 * 9.81, 1.0, FRAC_PI_2, rate).state(2.0).0;
    let exact = (angle(1.0 + 1e-5) - angle(1.0 - 1e-5)) / 2e-5;
    let (zero, one) = (Dual::constant(0.0), Dual { value: 1.0, slope: 1.0 });
    let start = State { t: zero, q: SVector::from([zero; 3]), qd: SVector::from([one, one, zero]) };
    let system = Rhombus::new().map(Dual::constant);
    let end = integrate(&system, Verner9, PiController::tolerance(1e-10), start)
        .until(Dual::constant(2.0))
        .final_state()
        .unwrap();
    for (i, exact) in [exact, exact, 0.0].into_iter().enumerate() {
        assert!((end.q[i].slope - exact).abs() < 1e-8, "{:?} {exact}", end.q);
    }
}
