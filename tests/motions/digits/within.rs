//! The errors of interpolants beside those of the steps: the table of the module `method`.

use super::digits::Kepler;
use lagrange_runtime::controller::{Controller, PiController};
use lagrange_runtime::integrate::integrate;
use lagrange_runtime::method::explicit_rk::Tsitouras5;
use lagrange_runtime::method::nystrom::{Nystrom6, Nystrom8};
use lagrange_runtime::method::rosenbrock::Rodas4;
use lagrange_runtime::method::{Interpolant, Method};
use lagrange_runtime::testing::reference::KeplerOrbit;
use lagrange_runtime::*;

lagrangian! {
    system Oscillator {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x * x + y * y);
    }
}

const ECCENTRICITY: f64 = 0.3;

/// Tolerances of the table; that of its last column is the third.
const TOLERANCES: [f64; 4] = [1e-6, 1e-8, 1e-10, 1e-12];

/// Kepler's ellipse in closed form.
fn orbit() -> impl Fn(f64) -> State<f64, 2> {
    let speed = ((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY)).sqrt();
    let orbit = KeplerOrbit::from_cartesian(1.0, [1.0 - ECCENTRICITY, 0.0], [0.0, speed]).unwrap();
    move |t| {
        let (q, qd) = orbit.cartesian(t);
        State::new(t, q, qd)
    }
}

fn ellipse(t: f64) -> State<f64, 2> {
    let (sin, cos) = t.sin_cos();
    State::new(t, [cos, 0.5 * sin], [-sin, 0.5 * cos])
}

/// The largest error within steps over that at their ends: of a run of 10 units of time, and of its steps, each begun
/// on the motion itself.
fn ratios<Sys, M, C>(system: &Sys, exact: impl Fn(f64) -> State<f64, 2>, method: M, controller: C) -> [f64; 2]
where
    Sys: System<2, Scalar = f64>,
    M: Method<Sys, 2> + Copy,
    C: Controller<f64, 2, M::Error>,
{
    let apart = |state: &State<f64, 2>, exact: &State<f64, 2>| {
        let difference = state.minus(exact);
        difference.q.norm().max(difference.qd.norm())
    };
    let run = integrate(system, method, controller, exact(0.0)).until(10.0);
    // Of the run and of its steps alone: errors within steps, and at their ends.
    let mut errors = [[0.0f64; 2]; 2];
    for step in run {
        let step = step.unwrap();
        let from = exact(step.from.t);
        let memory = method.start(system, &from).unwrap();
        let (alone, _) = method.step(system, &memory, &from, step.h).unwrap();
        // Both are looked at where the motion was computed once.
        let within: [State<f64, 2>; 15] =
            core::array::from_fn(|k| exact(step.from.t + step.h * (k + 1) as f64 / 16.0));
        for ([inside, end], step) in errors.iter_mut().zip([&step, &alone]) {
            let dense = method.interpolant(system, step);
            for exact in &within {
                *inside = inside.max(apart(&dense.at(exact.t), exact));
            }
            *end = end.max(apart(&step.to, &exact(step.to.t)));
        }
    }
    errors.map(|[inside, end]| inside / end)
}

/// Samples, events and integrals are as good as the ends of steps, but for a factor that is nowhere 10.
#[test]
fn errors_within_steps_are_those_of_the_table() {
    let mut wrong = Vec::new();
    let mut check = |name: &str, found: [[[f64; 2]; 4]; 2], table: [f64; 2]| {
        let worst = found.iter().flatten().map(|ratios| ratios[0]).fold(0.0, f64::max);
        let found = [worst, found[0][2][1]];
        println!("| `{name}` | {:.1} | {:.1} |", found[0], found[1]);
        if worst > 10.0 || (0..2).any(|i| !(0.8..1.25).contains(&(found[i] / table[i]))) {
            wrong.push(format!("{name}: {found:?} for {table:?}"));
        }
    };
    let (kepler, oscillator) = (Kepler::new(), Oscillator::new());
    macro_rules! check {
        ($($method:ident => $table:expr;)*) => {$(
            check!(stringify!($method), $method, PiController, $table);
        )*};
        ($name:expr, $method:expr, $controller:ident, $table:expr) => {{
            let of_orbit = TOLERANCES.map(|tolerance| {
                ratios(&kepler, orbit(), $method, $controller::tolerance(tolerance))
            });
            let of_ellipse = TOLERANCES.map(|tolerance| {
                ratios(&oscillator, ellipse, $method, $controller::tolerance(tolerance))
            });
            check($name, [of_orbit, of_ellipse], $table);
        }};
    }
    check! {
        DormandPrince5 => [1.0, 35.0];
        Tsitouras5 => [1.1, 27.0];
        Dop853 => [3.2, 17.0];
        Verner9 => [2.0, 6.9];
        Nystrom6 => [2.4, 150.0];
        Nystrom8 => [1.1, 8.9];
        Nystrom12 => [1.5, 4.1];
        Radau5 => [1.0, 230.0];
        Rodas4 => [1.6, 150.0];
        Rodas5P => [7.7, 27.0];
    }
    check!("Taylor", Taylor, TaylorController, [1.1, 0.31]);
    assert!(wrong.is_empty(), "{wrong:#?}");
}
