//! Derivatives of motions over switches, and of events that lie on one, against closed forms.

use lagrange_runtime::Gradient;
use lagrange_runtime::prelude::*;

type Number = Gradient<f64, 2>;

lagrangian! {
    /// A ball that enters a draught from below at y = half.
    system Falling {
        param g, u, half = 0.5;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y;
        Q[y] = if y > half { 0 } else { u };
        event enters: y - half;
        event lands: y - half, falling, terminal;
        event passes: y - 0.25;
    }
}

lagrangian! {
    /// A ball above a spring that pushes and does not pull: a force with a kink.
    system OnSpring {
        param g, k;
        coord y;
        T = 0.5 * dot(y).powi(2);
        V = g * y + 0.5 * k * (-y).max(0).powi(2);
        event touches: y;
        event touches_last: y, falling, terminal;
    }
}

/// Largest error of the derivatives by the height h and by g. (Numbers differ by their slopes as well.)
fn off(found: Number, exact: Number) -> f64 {
    let of = |d: usize| (found.slopes[d] - exact.slopes[d]).abs();
    of(0).max(of(1)).max((found.value - exact.value).abs())
}

fn released(h: Number) -> State<Number, 1> {
    let zero = Gradient::constant(0.0);
    State::new(zero, [h], [zero])
}

/// `½ g t² = h − ½`, and `½ a τ² + v τ = ¼` under `a = g − u`.
#[test]
fn an_event_on_a_jump() {
    let [h, g] = Gradient::variables([1.0, 9.81]);
    let number = Gradient::constant;
    let (system, start, end) = (Falling { g, u: number(2.0), half: number(0.5) }, released(h), number(0.44));
    let enters = ((h - number(0.5)) * number(2.0) / g).sqrt();
    let (v, a) = (g * enters, g - number(2.0));
    let passes = enters + ((v * v + a * number(0.5)).sqrt() - v) / a;
    macro_rules! by {
        ($method:expr, $controller:expr, $tolerance:expr) => {
            let run = || integrate(&system, $method, $controller, start).until(end);
            let name = format!("{:?}", $method);
            let all = run().events((Falling::ENTERS, Falling::PASSES));
            let all: Vec<_> = all.map(|event| event.unwrap().state).collect();
            let last = run().events(Falling::LANDS).next().unwrap().unwrap().state;
            assert_eq!(all.len(), 2, "{name}");
            for at in [all[0], last] {
                assert!(off(at.t, enters) < $tolerance, "{name}: {:?} for {enters:?}", at.t);
                assert!(off(at.q[0], number(0.5)) < $tolerance, "{name}: {:?}", at.q[0]);
                assert!(off(at.qd[0], -v) < $tolerance, "{name}: {:?} for {v:?}", at.qd[0]);
            }
            assert!(off(all[1].t, passes) < $tolerance, "{name}: {:?} for {passes:?}", all[1].t);
        };
    }
    by!(Dop853, PiController::tolerance(1e-12), 1e-11);
    by!(DormandPrince5, PiController::tolerance(1e-9), 1e-7);
    by!(Radau5, PiController::tolerance(1e-10), 1e-9);
    by!(Rodas5P, PiController::tolerance(1e-9), 1e-7);
    by!(Taylor, TaylorController::tolerance(1e-15), 1e-13);
}

/// With `ω² = k` the ball is at `y = (g/k)(cos ωτ − 1) − (v/ω) sin ωτ` after the touch.
#[test]
fn a_kink_of_the_force() {
    let [h, g] = Gradient::variables([1.0, 9.81]);
    let number = Gradient::constant;
    let (k, end) = (number(100.0), number(0.5));
    let (system, start) = (OnSpring { g, k }, released(h));
    let touches = (h * number(2.0) / g).sqrt();
    let (v, omega) = (g * touches, k.sqrt());
    let (sine, cosine) = (omega * (end - touches)).sin_cos();
    let y = g / k * (cosine - number(1.0)) - v / omega * sine;
    macro_rules! by {
        ($method:expr, $controller:expr, $tolerance:expr) => {
            let run = || integrate(&system, $method, $controller, start).until(end);
            let name = format!("{:?}", $method);
            let found = run().final_state().unwrap().q[0];
            assert!(off(found, y) < $tolerance, "{name}: {found:?} for {y:?}");
            let first = run().events(OnSpring::TOUCHES).next().unwrap().unwrap().state;
            let last = run().events(OnSpring::TOUCHES_LAST).next().unwrap().unwrap().state;
            for at in [first, last] {
                assert!(off(at.t, touches) < $tolerance, "{name}: {:?} for {touches:?}", at.t);
                assert!(off(at.qd[0], -v) < $tolerance, "{name}: {:?} for {v:?}", at.qd[0]);
            }
        };
    }
    by!(Dop853, PiController::tolerance(1e-12), 1e-10);
    by!(DormandPrince5, PiController::tolerance(1e-9), 1e-7);
    by!(Radau5, PiController::tolerance(1e-10), 1e-9);
    by!(Rodas5P, PiController::tolerance(1e-9), 1e-7);
    by!(Taylor, TaylorController::tolerance(1e-15), 1e-13);
}
