//! Motions from and through states at which the argument of a root vanishes, against closed forms and series of time.

use super::*;
use crate::systems::emitted::Ball;
use lagrange_runtime::method::choice::{RecommendedMethods, goal, method_for};
use lagrange_runtime::traits::Analytic;

/// Balls in air with other drags than that of [`Ball`], or with its drag in other words.
macro_rules! balls {
    ($($name:ident { $($drag:tt)* })*) => {$(
        lagrangian! {
            system $name {
                param c, g = 9.81;
                coord x, y;
                let v = [dot(x), dot(y)];
                T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
                V = g * y;
                $($drag)*
            }
        }
    )*};
}

balls! {
    BallByRoot { force [-c * (v[0] * v[0] + v[1] * v[1]).sqrt() * v[0], -c * sqrt(v[0] * v[0] + v[1] * v[1]) * v[1]] at [x, y]; }
    BallByHypot { force [-c * hypot(v[0], v[1]) * v[0], -c * v[1].hypot(v[0]) * v[1]] at [x, y]; }
    // The power 5/2 of the speed.
    Steeper { force -c * v.norm_squared().powf(0.75) * v at [x, y]; }
}

lagrangian! {
    /// The force is a length of fixed direction, which has no derivative at rest.
    system Fan {
        param c;
        coord x, y;
        let v = [dot(x), dot(y)];
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = -y;
        Q[x] = c * v.norm();
    }
}

lagrangian! {
    /// A ball on a Hertz contact, and one beside it that is not pressed.
    system Contact {
        param k, g;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = k * max(-x, 0).powf(2.5) + k * max(0, -y).powf(2.5) + g * x;
    }
}

lagrangian! {
    /// Beside the contact there is a root whose argument always vanishes: no step has a series.
    system Fanned {
        param k, g;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = k * max(-x, 0).powf(2.5) + g * x;
        Q[y] = (y * y + dot(y) * dot(y)).powf(0.75);
    }
}

lagrangian! {
    /// The same pressed from the other side: one contact, written in either order.
    system Pressed {
        param k, g;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = k * max(0, x).powf(2.5) - g * x;
    }
}

/// Durations of a contact after a fall from 1, of stiffnesses 1e3 and 1e5.
const CONTACT: [f64; 2] = [0.107_455_192_811_715_18, 0.016_640_261_214_036_88];

const C: f64 = 0.25;
const G: f64 = 9.81;

/// Height and velocity of a ball after a fall from rest: `v = −w tanh(g t/w)` with `w² = g/c`.
fn fallen(t: f64) -> [f64; 2] {
    let w = (G / C).sqrt();
    [-w * w / G * (G * t / w).cosh().ln(), -w * (G * t / w).tanh()]
}

fn assert_fallen(what: &str, end: &State<f64, 2>, tolerance: f64) {
    let [y, v] = fallen(end.t);
    let error = (end.q[1] - y).abs().max((end.qd[1] - v).abs());
    assert!(error < tolerance && end.q[0] == 0.0 && end.qd[0] == 0.0, "{what}: {error:e} {end:?}");
}

const REST: State<f64, 2> =
    State { t: 0.0, q: nalgebra::Vector2::new(0.0, 0.0), qd: nalgebra::Vector2::new(0.0, 0.0) };

/// Every way of writing, by series and by methods that need derivatives.
#[test]
fn quadratic_drag_from_rest() {
    fn falls<Sys: Analytic<2, Scalar = f64> + RecommendedMethods<2, Scalar = f64>>(system: &Sys) {
        let name = Sys::FACTS.name;
        for tolerance in [1e-6, 1e-9, 1e-12, 1e-14] {
            assert_fallen(name, &end(system, REST, tolerance, 2.0), 30.0 * tolerance + 1e-14);
        }
        for tolerance in [1e-6, 1e-9, 1e-11] {
            let pi = PiController::tolerance(tolerance);
            let radau = integrate(system, Radau5, pi, REST).until(2.0).final_state().unwrap();
            assert_fallen(name, &radau, 100.0 * tolerance);
            if tolerance > 1e-8 {
                let rodas = integrate(system, Rodas5P, pi, REST).until(2.0).final_state().unwrap();
                assert_fallen(name, &rodas, 100.0 * tolerance);
            }
        }
        for tolerance in [1e-11, 1e-13] {
            let end = method_for(system, goal::Accuracy(tolerance))
                .integrate(REST)
                .until(2.0)
                .final_state()
                .unwrap();
            assert_fallen(name, &end, 100.0 * tolerance);
        }
        for tolerance in [1e-6, 1e-11] {
            let end =
                method_for(system, goal::Stiff(tolerance)).integrate(REST).until(2.0).final_state().unwrap();
            assert_fallen(name, &end, 100.0 * tolerance);
        }
        let verner = integrate(system, Verner9, PiController::tolerance(1e-13), REST)
            .until(2.0)
            .final_state()
            .unwrap();
        assert_fallen(name, &verner, 1e-11);
    }
    falls(&Ball::new(C));
    falls(&BallByRoot::new(C));
    falls(&BallByHypot::new(C));
}

/// The derivatives at rest are their limits, 0, and do not exist where there is no limit.
#[test]
fn jacobians_at_rest() {
    let zero = SVector::from([0.0; 2]);
    let ball = Ball::new(C);
    let jacobian = ball.jacobian(&zero, &zero, 0.0);
    assert!(jacobian.q.iter().chain(jacobian.qd.iter()).all(|x| *x == 0.0), "{jacobian:?}");
    let jacobian = Steeper::new(C).jacobian(&zero, &zero, 0.0);
    assert!(jacobian.qd.iter().all(|x| *x == 0.0), "{jacobian:?}");
    let qd = SVector::from([3.0, -4.0]);
    let jacobian = ball.jacobian(&zero, &qd, 0.0).qd;
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let exact = -C * (if i == j { 5.0 } else { 0.0 } + qd[i] * qd[j] / 5.0);
        assert!((jacobian[(i, j)] - exact).abs() < 1e-15, "{jacobian}");
    }
    assert!(Fan::new(1.0).jacobian(&zero, &zero, 0.0).qd.iter().any(|x| !x.is_finite()));
}

/// A method that needs a derivative where there is none names the coordinate, and series are not needed to go on.
#[test]
fn a_length_alone_has_no_derivative() {
    let fan = Fan::new(0.5);
    for goal in [goal::Stiff(1e-9), goal::Stiff(1e-6)] {
        let failed = method_for(&fan, goal).integrate(REST).until(1.0).final_state().unwrap_err();
        let Failure::NoDerivative { t, coordinate } = failed.failure else { panic!("{}", failed.failure) };
        assert!(t == 0.0 && coordinate.name == "x" && failed.failure.to_string().contains("`Dop853`"));
    }
    // ẋ = r sinh, … has no short closed form: against order 9.
    let exact =
        integrate(&fan, Verner9, PiController::tolerance(1e-14), REST).until(1.0).final_state().unwrap();
    let series = end(&fan, REST, 1e-13, 1.0);
    let error = lagrange_runtime::testing::distance(&series, &exact);
    assert!(error < 1e-12, "{error:e}");
}

/// Thrown straight up, a ball is at rest at the top.
#[test]
fn a_throw_through_rest() {
    let (w, v) = ((G / C).sqrt(), 7.0f64);
    let up = w / G * (v / w).atan();
    let height = 0.5 * w * w / G * (1.0 + v * v / (w * w)).ln();
    let start = State::new(0.0, [0.0, 0.0], [0.0, v]);
    let ball = Ball::new(C);
    for t in [up, up + 1.0] {
        let [fall, speed] = fallen(t - up);
        let check = |what: &str, end: State<f64, 2>, tolerance: f64| {
            let error = (end.q[1] - height - fall).abs().max((end.qd[1] - speed).abs());
            assert!(error < tolerance, "{what} to {t}: {error:e}");
        };
        for tolerance in [1e-9, 1e-12] {
            check("series", end(&ball, start, tolerance, t), 100.0 * tolerance);
            let pi = PiController::tolerance(tolerance);
            check(
                "Radau5",
                integrate(&ball, Radau5, pi, start).until(t).final_state().unwrap(),
                1e3 * tolerance,
            );
        }
    }
    // Held at the top and let go: what remains is a fall from rest.
    let top = State::new(up, [0.0, height], [0.0, 0.0]);
    let end = end(&ball, top, 1e-13, up + 1.0);
    let [fall, speed] = fallen(1.0);
    assert!((end.q[1] - height - fall).abs() < 1e-12 && (end.qd[1] - speed).abs() < 1e-12);
}

/// Steps, and the states within them, from rest under a force that turns.
#[test]
fn the_polynomial_of_a_step_from_rest_is_its_interpolant() {
    let ball = Steeper::new(C);
    let exact: Vec<_> = {
        let times = (1..=50).map(|k| 0.02 * f64::from(k));
        integrate(&ball, Verner9, PiController::tolerance(1e-14), REST)
            .until(1.0)
            .sample(times)
            .map(Result::unwrap)
            .collect()
    };
    let times = (1..=50).map(|k| 0.02 * f64::from(k));
    let run = integrate(&ball, Taylor, TaylorController::tolerance(1e-12), REST).until(1.0);
    for (seen, exact) in run.sample(times).map(Result::unwrap).zip(&exact) {
        let error = lagrange_runtime::testing::distance(&seen, exact);
        assert!(error < 1e-11, "{} {error:e}", seen.t);
    }
    // In equilibrium it stays.
    let still = end(&Ball { c: C, g: 0.0 }, REST, 1e-12, 10.0);
    assert_eq!((still.q, still.qd), (REST.q, REST.qd));
}

/// Bodies that touch and are at rest stay so where nothing presses them, and follow the contact's force where
/// something does.
#[test]
fn bodies_that_touch_exactly_at_rest() {
    let still = end(&Contact::new(100.0, 0.0), REST, 1e-12, 3.0);
    assert_eq!((still.q, still.qd), (REST.q, REST.qd));
    // ẋ²/2 = g x − k x^(5/2), down and up again.
    let (k, g) = (100.0, 2.0);
    for tolerance in [1e-9, 1e-12] {
        let method = Taylor;
        let pressed = |t: f64| {
            let system = Contact::new(k, g);
            integrate(&system, method, TaylorController::tolerance(tolerance), REST)
                .until(t)
                .final_state()
                .unwrap()
        };
        for t in [0.01, 0.1, 0.2, 0.3] {
            let end = pressed(t);
            let energy = 0.5 * end.qd[0] * end.qd[0] + k * (-end.q[0]).max(0.0).powf(2.5) + g * end.q[0];
            assert!(energy.abs() < 100.0 * tolerance, "{t} {energy:e}");
            let system = Contact::new(k, g);
            let exact = integrate(&system, Verner9, PiController::tolerance(1e-13), REST)
                .until(t)
                .final_state()
                .unwrap();
            let error = lagrange_runtime::testing::distance(&end, &exact);
            assert!(error < 1e3 * tolerance, "{t} {error:e}");
            assert_eq!((end.q[1], end.qd[1]), (0.0, 0.0));
            let other = end_of_pressed(k, g, tolerance, t);
            assert!((other.q[0] + end.q[0]).abs() < 1e3 * tolerance, "{other:?} {end:?}");
        }
    }
}

/// From a height of 1 onto the contact and up again, eight times. The duration of a contact is
/// `2 ∫ dδ/√(2 (g + g δ − k δ^(5/2)))` up to the root of the radicand, by quadrature with 60 digits.
#[test]
fn bounces_on_a_contact() {
    let g = 9.81;
    for (k, contact) in [(1e3, CONTACT[0]), (1e5, CONTACT[1])] {
        let period = 2.0 * f64::sqrt(2.0 / g) + contact;
        for tolerance in [1e-6, 1e-8, 1e-10, 1e-12, 1e-14] {
            let start = State::new(0.0, [1.0, 0.0], [0.0, 0.0]);
            let most = 300.0 * tolerance + 1e-12;
            for end in [
                end(&Contact::new(k, g), start, tolerance, 8.0 * period),
                end(&Fanned::new(k, g), start, tolerance, 8.0 * period),
            ] {
                assert!((end.q[0] - 1.0).abs() < most, "{k} {tolerance}: {end:?}");
                assert!(end.qd[0].abs() < 20.0 * most, "{k} {tolerance}: {end:?}");
                assert_eq!((end.q[1], end.qd[1]), (0.0, 0.0));
            }
        }
    }
}

fn end_of_pressed(k: f64, g: f64, tolerance: f64, t: f64) -> State<f64, 1> {
    end(&Pressed::new(k, g), State::new(0.0, [0.0], [0.0]), tolerance, t)
}
