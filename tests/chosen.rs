//! Methods under controllers, over systems each of which lacks a fact: rustc refuses every pair for which something is missing, and all
//! others are right against closed forms. So are the methods of the table of choices.

use lagrange_runtime::choice::{Choices, Offered};
use lagrange_runtime::ensemble::{Ensemble, Moments, Random, Sobol, Table};
use lagrange_runtime::prelude::*;
use lagrange_runtime::reference::SimplePendulum;
use lagrange_runtime::{BlanesMoan4, Controller, Nystrom12};
use std::marker::PhantomData;

/// Facts that a system lacks by its formulas, independent of what the compiler found.
#[derive(Clone, Copy, Default)]
struct Lacks {
    separable: bool,
    independent: bool,
    quadratic: bool,
    linear: bool,
    /// Forces that do not change with time.
    constant: bool,
    series: bool,
}

/// Returns whether something is missing for a method under a controller.
fn refused(method: &str, controller: &str, lacks: Lacks) -> bool {
    match (controller, method) {
        ("Pi", "BlanesMoan4" | "Gauss4" | "Modal" | "Taylor") => true,
        ("Decay", method) if method != "Taylor" => true,
        (_, "Nystrom12" | "BlanesMoan4") => lacks.separable,
        (_, "Gauss4") => lacks.independent || lacks.quadratic,
        (_, "Modal") => lacks.linear || lacks.constant,
        (_, "Taylor") => lacks.series,
        _ => false,
    }
}

/// A method under a controller on a system. rustc takes what the type itself says if the bounds hold, and else what the trait says.
struct Pair<Sys, M, C, const N: usize>(PhantomData<(Sys, M, C)>);

impl<Sys, M, C, const N: usize> Pair<Sys, M, C, N>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    C: Controller<f64, N, M::Error>,
{
    const FITS: bool = true;

    fn end(
        self,
        (method, controller): (M, C),
        system: &Sys,
        start: State<f64, N>,
        end: f64,
    ) -> Option<State<f64, N>> {
        integrate(system, method, controller, start).until(end).finish().ok()
    }
}

trait Refused<Sys, M, C, const N: usize>: Sized {
    const FITS: bool = false;

    fn end(self, _: (M, C), _: &Sys, _: State<f64, N>, _: f64) -> Option<State<f64, N>> {
        unreachable!()
    }
}

impl<Sys, M, C, const N: usize> Refused<Sys, M, C, N> for Pair<Sys, M, C, N> {}

/// The same for all methods under all controllers.
macro_rules! pairs {
    ($then:ident) => {
        pairs!($then Dop853 DormandPrince5 Verner9 Nystrom12 BlanesMoan4 Gauss4 Modal Rodas5P Radau5 Taylor)
    };
    ($then:ident $($method:ident)*) => {$(
        $then!($method, Fixed, Fixed::new(0.005));
        $then!($method, Pi, Pi::tolerance(1e-10));
        $then!($method, Decay, Decay::tolerance(1e-10));
    )*};
}

/// Complaints about a system: pairs that rustc refuses although nothing is missing, or the other way round, and ends of chosen runs.
macro_rules! net {
    ($all:ident, $of:ty, $n:literal, $system:expr, $start:expr, $exact:expr, $bound:expr, $lacks:expr) => {
        let (system, start, exact, bound, lacks) = ($system, $start, $exact, $bound, $lacks);
        macro_rules! fits {
            ($method:ident, $control:ident, $controller:expr) => {
                let [method, control] = [stringify!($method), stringify!($control)];
                if Pair::<$of, $method, $control, $n>::FITS == refused(method, control, lacks) {
                    $all.push(format!("{method}, {control} on {}", stringify!($of)));
                }
            };
        }
        pairs!(fits);
        $all.extend(complaints(&system, start, exact, bound));
    };
}

/// Complaints about runs with each aim: ends of equal steps, which go over kinks and jumps of forces, are within `bound` of the exact one,
/// those of adaptive steps within 1e-7 or ten tolerances.
fn complaints<Sys: Choices<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    exact: [f64; N],
    bound: f64,
) -> Vec<String> {
    let mut complaints = vec![];
    let mut check = |aim: &dyn std::fmt::Debug, tolerated: f64, end: Result<State<f64, N>, Failure>| {
        if !end.as_ref().is_ok_and(|at| (at.q - SVector::from(exact)).amax() < tolerated) {
            complaints.push(format!("{}, {aim:?}: {end:?}", Sys::FACTS.name));
        }
    };
    for tolerance in [1e-5, 1e-7, 1e-10, 1e-13] {
        let aim = aim::Accuracy(tolerance);
        let end = method_for(system, aim).integrate(start).until(END).finish();
        check(&aim, f64::max(1e-7, 10.0 * tolerance), end.map_err(Failure::from));
    }
    for tolerance in [1e-7, 1e-9] {
        let aim = aim::Stiff(tolerance);
        let end = method_for(system, aim).integrate(start).until(END).finish();
        check(&aim, f64::max(1e-7, 10.0 * tolerance), end.map_err(Failure::from));
    }
    let aim = aim::LongTime(0.005);
    check(&aim, bound, method_for(system, aim).integrate(start).until(END).finish().map_err(Failure::from));
    complaints
}

/// The end of all runs.
const END: f64 = 2.0;

lagrangian! {
    pub system Oscillator {
        param omega;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (omega * x).powi(2);
    }
}

lagrangian! {
    /// An oscillator with a force of time.
    pub system Driven {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2) - x * cos(2 * t);
    }
}

fn drive<S: Scalar>(t: S) -> S {
    (t + t).cos()
}

lagrangian! {
    /// The driven oscillator, whose force is a function of Rust.
    pub system Foreign {
        coord x;
        extern fn drive(t);
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = drive(t);
    }
}

lagrangian! {
    pub system Damped {
        param delta;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        D = delta * dot(x).powi(2);
    }
}

lagrangian! {
    pub system Swing {
        coord theta;
        T = 0.5 * dot(theta).powi(2);
        V = -cos(theta);
    }
}

lagrangian! {
    /// The same pendulum by its horizontal position, whose inertia changes.
    pub system Sideways {
        coord x;
        let y = -sqrt(1 - x.powi(2));
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = y;
    }
}

lagrangian! {
    /// The same pendulum with a rod.
    pub system Bob {
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = y;
        constraint rod: x * x + y * y == 1;
    }
}

lagrangian! {
    /// A blade on ice, which goes round a circle.
    pub system Skate {
        coord x, y, phi;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(phi).powi(2));
        V = 0;
        constraint blade: dot(x) * sin(phi) == dot(y) * cos(phi);
    }
}

lagrangian! {
    /// A particle near the speed of light, under a constant force.
    pub system Fast {
        coord x;
        L = -sqrt(1 - dot(x).powi(2)) + x;
    }
}

lagrangian! {
    /// A spring that is stiffer on one side.
    pub system Uneven {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = if x > 0 { 0.5 * x.powi(2) } else { 2 * x.powi(2) };
    }
}

lagrangian! {
    /// A force of constant size towards 0.
    pub system Wedge {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = x.abs();
    }
}

fn at(q: f64, qd: f64) -> State<f64, 1> {
    State::new(0.0, [q], [qd])
}

/// 1 − t²/2 to the kink at √2, and the bound of its error: the velocity after a step h over the jump of 2 is off by up to 2 h.
fn across_the_jump() -> ([f64; 1], f64) {
    let rest = END - 2f64.sqrt();
    ([-2f64.sqrt() * rest + 0.5 * rest * rest], 2.0 * 0.005 * rest)
}

#[test]
fn every_choice_is_refused_or_right() {
    let (t, none) = (END, Lacks::default());
    let mut all = vec![];
    net!(all, Oscillator, 1, Oscillator::new(1.5), at(1.0, 0.0), [(1.5 * t).cos()], 1e-7, none);
    let driven = [4.0 / 3.0 * t.cos() - (2.0 * t).cos() / 3.0];
    let constant = Lacks { constant: true, ..none };
    net!(all, Driven, 1, Driven::new(), at(1.0, 0.0), driven, 1e-7, constant);
    let foreign = Lacks { series: true, ..constant };
    net!(all, Foreign, 1, Foreign::new(), at(1.0, 0.0), driven, 1e-7, foreign);
    let (delta, nu) = (0.3f64, (1.0 - 0.09f64).sqrt());
    let damped = (-delta * t).exp() * ((nu * t).cos() + delta / nu * (nu * t).sin());
    let with_velocities = Lacks { separable: true, ..none };
    net!(all, Damped, 1, Damped::new(delta), at(1.0, 0.0), [damped], 1e-7, with_velocities);
    let (angle, _) = SimplePendulum::new(1.0, 1.0, 1.0, 0.0).state(t);
    let linear = Lacks { linear: true, ..none };
    net!(all, Swing, 1, Swing::new(), at(1.0, 0.0), [angle], 1e-7, linear);
    let general = Lacks { separable: true, ..linear };
    net!(all, Sideways, 1, Sideways::new(), at(1f64.sin(), 0.0), [angle.sin()], 1e-7, general);
    let held = Lacks { independent: true, ..general };
    let hangs = State::new(0.0, [1f64.sin(), -1f64.cos()], [0.0, 0.0]);
    net!(all, Bob, 2, Bob::new(), hangs, [angle.sin(), -angle.cos()], 1e-7, held);
    let glides = State::new(0.0, [0.0; 3], [1.0, 0.0, 0.5]);
    let circle = [2.0 * (0.5 * t).sin(), 2.0 - 2.0 * (0.5 * t).cos(), 0.5 * t];
    net!(all, Skate, 3, Skate::new(), glides, circle, 1e-7, held);
    let fast = [(1.0 + t * t).sqrt() - 1.0];
    net!(all, Fast, 1, Fast::new(), at(0.0, 0.0), fast, 1e-7, Lacks { quadratic: true, ..general });
    // The motion takes a quarter of a period, 2π/4, from 1 to the kink, and has twice the rate on the other side.
    let uneven = [-0.5 * (2.0 * (t - core::f64::consts::FRAC_PI_2)).sin()];
    net!(all, Uneven, 1, Uneven::new(), at(1.0, 0.0), uneven, 1e-4, linear);
    let (wedge, bound) = across_the_jump();
    net!(all, Wedge, 1, Wedge::new(), at(1.0, 0.0), wedge, bound, linear);
    assert!(all.is_empty(), "{}\n{} in all", all.join("\n"), all.len());
}

/// Every pair that fits is right where forces jump.
#[test]
fn every_method_crosses_a_jump() {
    let (system, ([exact], bound)) = (Wedge::new(), across_the_jump());
    let mut complaints = vec![];
    macro_rules! right {
        ($method:ident, $control:ident, $controller:expr) => {
            if Pair::<Wedge, $method, $control, 1>::FITS {
                let pair = Pair::<Wedge, $method, $control, 1>(PhantomData);
                let come = pair.end(($method::METHOD, $controller), &system, at(1.0, 0.0), END);
                let bound = if stringify!($control) == "Fixed" { bound } else { 1e-7 };
                if !come.is_some_and(|end| (end.q[0] - exact).abs() < bound) {
                    complaints.push([stringify!($method), stringify!($control)]);
                }
            }
        };
    }
    pairs!(right);
    assert!(complaints.is_empty(), "{complaints:?}");
}

/// Samples of every source that do not begin are failures of their studies, and no statistic takes part of them.
#[test]
fn every_source_tells_a_refusal() {
    let refused = Failure::BadTolerance { absolute: -1.0, relative: -1.0 };
    let made = |x: f64| (Sideways::new(), State::new(0.0, [0.1 + 0.5 * x], [0.0]));
    macro_rules! study {
        ($source:expr, $draw:expr) => {{
            let study = Ensemble::new($source, 40, $draw).integrate(Verner9, Pi::tolerance(-1.0), 1.0);
            let outcome = study.reduce(|_, run| Ok(run.finish()?.q[0]), Moments).expect("a sound study");
            assert_eq!((outcome.statistic.count(), outcome.failures.count), (0, 40));
            assert!(outcome.failures.kept.iter().all(|failed| failed.failure == refused));
        }};
    }
    study!(Table::new((0..40).map(|k| [f64::from(k) / 40.0])), |[x]: [f64; 1]| made(x));
    study!(Sobol::<1>::seed(3), |[x]: [f64; 1]| made(x));
    study!(Random::seed(3), |_| made(0.5));
}
