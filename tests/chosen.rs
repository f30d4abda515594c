//! Methods under controllers, over systems each of which lacks a fact: rustc refuses every pair for which something
//! is missing, and all others are right against closed forms. So are the methods of the table of choices.

use lagrange_runtime::ensemble::{Ensemble, Moments, Random, Sobol, Table};
use lagrange_runtime::method::choice::{Offered, RecommendedMethods};
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SimplePendulum;
use lagrange_runtime::{
    BlanesMoan4, Controller, DoubleDouble, Nystrom12, method::compose::Yoshida6,
    method::projection::Projection,
};
use printed::{Cell, Table as Printed};
use std::marker::PhantomData;

#[path = "tables/table.rs"]
mod printed;

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
        ("PiController", "BlanesMoan4" | "Gauss4" | "MatrixExponential" | "Taylor") => true,
        ("TaylorController", method) if method != "Taylor" => true,
        (_, "Nystrom12" | "BlanesMoan4") => lacks.separable,
        (_, "Gauss4") => lacks.independent || lacks.quadratic,
        (_, "MatrixExponential") => lacks.linear || lacks.constant,
        (_, "Taylor") => lacks.series,
        _ => false,
    }
}

/// A method under a controller on a system. rustc takes what the type itself says if the bounds hold, and else what
/// the trait says.
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
        integrate(system, method, controller, start).until(end).final_state().ok()
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
        pairs!($then Dop853 DormandPrince5 Verner9 Nystrom12 BlanesMoan4 Gauss4 MatrixExponential Rodas5P Radau5 Taylor)
    };
    ($then:ident $($method:ident)*) => {$(
        $then!($method, FixedStep, FixedStep::new(0.005));
        $then!($method, PiController, PiController::tolerance(1e-10));
        $then!($method, TaylorController, TaylorController::tolerance(1e-10));
    )*};
}

/// Complaints about a system: pairs that rustc refuses although nothing is missing, or the other way round, and ends
/// of chosen runs.
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

/// Complaints about runs with each goal: ends of equal steps, which go over kinks and jumps of forces, are within
/// `bound` of the exact one, those of adaptive steps within 1e-7 or ten tolerances.
fn complaints<Sys: RecommendedMethods<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    exact: [f64; N],
    bound: f64,
) -> Vec<String> {
    let mut complaints = vec![];
    let mut check = |goal: &dyn std::fmt::Debug, tolerated: f64, end: Result<State<f64, N>, Failure>| {
        if !end.as_ref().is_ok_and(|at| (at.q - SVector::from(exact)).amax() < tolerated) {
            complaints.push(format!("{}, {goal:?}: {end:?}", Sys::FACTS.name));
        }
    };
    for tolerance in [1e-5, 1e-7, 1e-10, 1e-13] {
        let goal = goal::Accuracy(tolerance);
        let end = method_for(system, goal).integrate(start).until(END).final_state();
        check(&goal, f64::max(1e-7, 10.0 * tolerance), end.map_err(Failure::from));
    }
    for tolerance in [1e-7, 1e-9] {
        let goal = goal::Stiff(tolerance);
        let end = method_for(system, goal).integrate(start).until(END).final_state();
        check(&goal, f64::max(1e-7, 10.0 * tolerance), end.map_err(Failure::from));
    }
    let goal = goal::LongTime(0.005);
    check(
        &goal,
        bound,
        method_for(system, goal).integrate(start).until(END).final_state().map_err(Failure::from),
    );
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

/// 1 − t²/2 to the kink at √2, and the bound of its error: the velocity after a step h over the jump of 2 is off by
/// up to 2 h.
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
                let bound = if stringify!($control) == "FixedStep" { bound } else { 1e-7 };
                if !come.is_some_and(|end| (end.q[0] - exact).abs() < bound) {
                    complaints.push([stringify!($method), stringify!($control)]);
                }
            }
        };
    }
    pairs!(right);
    assert!(complaints.is_empty(), "{complaints:?}");
}

lagrangian! {
    /// Linear in the plane, with forces that have no potential.
    pub system Coupled {
        param p, g;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x.powi(2) + y.powi(2));
        Q[x] = p * y - g * dot(y);
        Q[y] = -p * x + g * dot(x);
    }
}

lagrangian! {
    /// An oscillator that a gust meets at t = 50.
    pub system Gusty {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = exp(-(t - 50).powi(2));
    }
}

lagrangian! {
    /// A particle in polar coordinates, bound to the origin, where φ has no inertia.
    pub system Polar {
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = 0.5 * r.powi(2);
    }
}

/// A motion and the coordinates at its end.
type Motion<S, const N: usize> = (State<S, N>, S, [f64; N]);

/// The end of a run: right within the bound, or the name of its failure.
fn seen<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    control: C,
    motion: Motion<Sys::Scalar, N>,
    bound: f64,
) -> Cell
where
    Sys: Lagrangian<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    let (start, end, exact) = motion;
    match integrate(system, method, control, start).until(end).final_state() {
        Ok(at) => {
            let off = (0..N).map(|i| (at.q[i].to_f64() - exact[i]).abs()).fold(0.0, f64::max);
            Cell::Seen(if off <= bound { "right".into() } else { format!("wrong by {off:e}") })
        }
        Err(failed) => Cell::Seen(format!("`{}`", failed.failure.name())),
    }
}

/// A cell of two cases, in which a common outcome stands once.
fn both(a: Cell, b: Cell) -> Cell {
    match (a, b) {
        (Cell::Seen(a), Cell::Seen(b)) => Cell::Seen(if a == b { a } else { format!("{a}, {b}") }),
        _ => panic!("no case"),
    }
}

const AS_THEY_ARE: Cell =
    Cell::None("equations are solved as they are: neither symmetry nor what breaks it is used");
const TOO_LONG: Cell = Cell::None(
    "a step of one size that is too long promises nothing: the bound of stability is in the method's documentation",
);

#[test]
fn the_table_of_methods() {
    let at = |q: f64, qd: f64| State::new(0.0, [q], [qd]);
    let (t, root) = (2.0f64, |c: f64| (1.0 - c * c).sqrt());
    let driven = 4.0 / 3.0 * t.cos() - (2.0 * t).cos() / 3.0;
    let decay = |c: f64| (-c * t).exp() * ((root(c) * t).cos() + c / root(c) * (root(c) * t).sin());
    let uneven = -0.5 * (2.0 * (t - core::f64::consts::FRAC_PI_2)).sin();
    let rest = t - 2f64.sqrt();
    let wedge = -2f64.sqrt() * rest + 0.5 * rest * rest;
    let (angle, _) = SimplePendulum::new(1.0, 1.0, 1.0, 0.0).state(t);
    let hangs = State::new(0.0, [1f64.sin(), -1f64.cos()], [0.0, 0.0]);
    // z = x + i y obeys z̈ + z = −i p z + i g ż: z = e^{λt} with λ² − i g λ + 1 + i p = 0. For p = 0 e^{iωt} with ω²
    // − g ω − 1 = 0.
    let turning = |g: f64| 0.5 * (g + (g * g + 4.0).sqrt());
    let around = |g: f64| {
        let w = turning(g);
        (State::new(0.0, [1.0, 0.0], [0.0, w]), t, [(w * t).cos(), (w * t).sin()])
    };
    // For g = 0, λ = a + i b with 2ab = −p and a² − b² = −1.
    let circulatory = |p: f64| {
        let a = (0.5 * ((1.0 + p * p).sqrt() - 1.0)).sqrt();
        let b = -0.5 * p / a;
        let grown = (a * t).exp();
        (State::new(0.0, [1.0, 0.0], [a, b]), t, [grown * (b * t).cos(), grown * (b * t).sin()])
    };
    let gust = core::f64::consts::PI.sqrt() * (-0.25f64).exp() * 10f64.sin();
    let from_the_pole = (State::new(0.0, [0.0, 0.3], [1.0, 0.0]), t, [f64::NAN; 2]);
    let stiff = (at(1.0, 0.0), 2e-5, [20f64.cos()]);
    let narrow = |x: State<f64, 1>| x.map(|x| x as f32);
    let double = |x: State<f64, 1>| x.map(DoubleDouble::from);
    let of_f32 = || (narrow(at(1.0, 0.0)), t as f32, [(1.5 * t).cos()]);
    let of_double = || (double(at(1.0, 0.0)), DoubleDouble::from(0.5), [0.75f64.cos()]);
    let wide = || Oscillator::new(1.5).map(DoubleDouble::from);
    let mut table = Printed::new();
    // Of every system, by a tolerance.
    macro_rules! general {
        ($($method:ident)*) => {$(
            let pi = || PiController::tolerance(1e-10);
            table.row(
                concat!("`", stringify!($method), "`"),
                [
                    seen(&Foreign::new(), $method, pi(), (at(1.0, 0.0), t, [driven]), 1e-7),
                    seen(&Damped::new(-0.3), $method, pi(), (at(1.0, 0.0), t, [decay(-0.3)]), 1e-7),
                    seen(&Coupled::new(0.7, 0.0), $method, pi(), circulatory(0.7), 1e-7),
                    seen(&Coupled::new(0.0, 1.5), $method, pi(), around(1.5), 1e-7),
                    both(
                        seen(&Uneven::new(), $method, pi(), (at(1.0, 0.0), t, [uneven]), 1e-7),
                        seen(&Wedge::new(), $method, pi(), (at(1.0, 0.0), t, [wedge]), 1e-7),
                    ),
                    seen(&Bob::new(), $method, pi(), (hangs, t, [angle.sin(), -angle.cos()]), 1e-7),
                    seen(&Polar::new(), $method, pi(), from_the_pole, 0.0),
                    seen(&Fast::new(), $method, pi(), (at(0.0, 0.0), t, [(1.0 + t * t).sqrt() - 1.0]), 1e-7),
                    seen(&Driven::new(), $method, pi(), (at(1.0, 0.0), t, [driven]), 1e-7),
                    seen(&Coupled::new(0.0, 0.0), $method, pi(), around(0.0), 1e-7),
                    AS_THEY_ARE,
                    seen(&Oscillator::new(1e6), $method, pi(), stiff, 1e-7),
                    seen(&Oscillator::new(1.5), $method, PiController::tolerance(1e-11), (at(1.0, 0.0), 200.0, [300f64.cos()]), 1e-7),
                    seen(&Gusty::new(), $method, pi(), (at(0.0, 0.0), 60.0, [gust]), 1e-7),
                    seen(&Oscillator::new(1.5).map(|x| x as f32), $method, PiController::tolerance(1e-5), of_f32(), 1e-4),
                    seen(&wide(), $method, PiController::tolerance(1e-16), of_double(), 1e-15),
                ],
            );
        )*};
    }
    general!(Dop853 DormandPrince5 Verner9 Rodas5P Radau5);
    let series = || Cell::None("rustc rejects an `extern fn`: `Analytic`");
    let taylor = Taylor;
    let decaying = || TaylorController::tolerance(1e-10);
    table.row(
        "`Taylor`",
        [
            series(),
            seen(&Damped::new(-0.3), taylor, decaying(), (at(1.0, 0.0), t, [decay(-0.3)]), 1e-7),
            seen(&Coupled::new(0.7, 0.0), taylor, decaying(), circulatory(0.7), 1e-7),
            seen(&Coupled::new(0.0, 1.5), taylor, decaying(), around(1.5), 1e-7),
            both(
                seen(&Uneven::new(), taylor, decaying(), (at(1.0, 0.0), t, [uneven]), 1e-7),
                seen(&Wedge::new(), taylor, decaying(), (at(1.0, 0.0), t, [wedge]), 1e-7),
            ),
            seen(&Bob::new(), taylor, decaying(), (hangs, t, [angle.sin(), -angle.cos()]), 1e-7),
            seen(&Polar::new(), taylor, decaying(), from_the_pole, 0.0),
            seen(&Fast::new(), taylor, decaying(), (at(0.0, 0.0), t, [(1.0 + t * t).sqrt() - 1.0]), 1e-7),
            seen(&Driven::new(), taylor, decaying(), (at(1.0, 0.0), t, [driven]), 1e-7),
            seen(&Coupled::new(0.0, 0.0), taylor, decaying(), around(0.0), 1e-7),
            AS_THEY_ARE,
            seen(&Oscillator::new(1e6), taylor, decaying(), stiff, 1e-7),
            seen(&Oscillator::new(1.5), taylor, decaying(), (at(1.0, 0.0), 200.0, [300f64.cos()]), 1e-7),
            seen(&Gusty::new(), taylor, decaying(), (at(0.0, 0.0), 60.0, [gust]), 1e-7),
            seen(
                &Oscillator::new(1.5).map(|x| x as f32),
                taylor,
                TaylorController::tolerance(1e-5),
                of_f32(),
                1e-4,
            ),
            seen(&wide(), Taylor, TaylorController::tolerance(1e-16), of_double(), 1e-15),
        ],
    );
    let velocity = || {
        Cell::None(
            "rustc rejects forces that depend on velocities, and an M that is not constant: `Separable`",
        )
    };
    let bound = || Cell::None("rustc rejects constraints: `Independent`");
    let plane = || Cell::None("as in one coordinate: it takes each alone");
    let h = || FixedStep::new(0.005);
    macro_rules! separable {
        ($($method:ident, $control:expr, $narrow:expr, $wide:expr, $bounds:expr, $long:expr;)*) => {$(
            table.row(
                concat!("`", stringify!($method), "`"),
                [
                    seen(&Foreign::new(), $method, $control, (at(1.0, 0.0), t, [driven]), 1e-7),
                    velocity(),
                    velocity(),
                    velocity(),
                    both(
                        seen(&Uneven::new(), $method, $control, (at(1.0, 0.0), t, [uneven]), $bounds[0]),
                        seen(&Wedge::new(), $method, $control, (at(1.0, 0.0), t, [wedge]), $bounds[1]),
                    ),
                    bound(),
                    velocity(),
                    velocity(),
                    seen(&Driven::new(), $method, $control, (at(1.0, 0.0), t, [driven]), 1e-7),
                    plane(),
                    AS_THEY_ARE,
                    seen(&Oscillator::new(1e6), $method, $control, (at(1.0, 0.0), $bounds[2], [(1e6 * $bounds[2]).cos()]), 1e-7),
                    $long,
                    seen(&Gusty::new(), $method, $control, (at(0.0, 0.0), 60.0, [gust]), 1e-7),
                    seen(&Oscillator::new(1.5).map(|x| x as f32), $method, $narrow, of_f32(), 1e-4),
                    seen(&wide(), $method, $wide, of_double(), 1e-9),
                ],
            );
        )*};
    }
    separable! {
        Nystrom12, PiController::tolerance(1e-10), PiController::tolerance(1e-5), PiController::tolerance(1e-16), [1e-7, 1e-7, 2e-5],
            seen(&Oscillator::new(1.5), Nystrom12, PiController::tolerance(1e-11), (at(1.0, 0.0), 200.0, [300f64.cos()]), 1e-7);
        BlanesMoan4, h(), FixedStep::new(0.005f32), FixedStep::new(DoubleDouble::from(0.005)), [1e-4, 1e-2, 0.0], TOO_LONG;
    }
    let quadratic =
        || Cell::None("rustc rejects an L that is not quadratic in q̇, and constraints: `LegendreTransform`");
    table.row(
        "`Gauss4`",
        [
            seen(&Foreign::new(), Gauss4, h(), (at(1.0, 0.0), t, [driven]), 1e-7),
            seen(&Damped::new(-0.3), Gauss4, h(), (at(1.0, 0.0), t, [decay(-0.3)]), 1e-7),
            seen(&Coupled::new(0.7, 0.0), Gauss4, h(), circulatory(0.7), 1e-7),
            seen(&Coupled::new(0.0, 1.5), Gauss4, h(), around(1.5), 1e-7),
            both(
                seen(&Uneven::new(), Gauss4, h(), (at(1.0, 0.0), t, [uneven]), 1e-4),
                seen(&Wedge::new(), Gauss4, h(), (at(1.0, 0.0), t, [wedge]), 1e-2),
            ),
            quadratic(),
            seen(&Polar::new(), Gauss4, h(), from_the_pole, 0.0),
            quadratic(),
            seen(&Driven::new(), Gauss4, h(), (at(1.0, 0.0), t, [driven]), 1e-7),
            seen(&Coupled::new(0.0, 0.0), Gauss4, h(), around(0.0), 1e-7),
            AS_THEY_ARE,
            seen(&Oscillator::new(1e6), Gauss4, FixedStep::new(5e-8), stiff, 1e-4),
            seen(&Oscillator::new(1.5), Gauss4, FixedStep::new(20.0), (at(1.0, 0.0), 20.0, [0.0]), 0.0),
            seen(&Gusty::new(), Gauss4, FixedStep::new(0.05), (at(0.0, 0.0), 60.0, [gust]), 1e-4),
            seen(&Oscillator::new(1.5).map(|x| x as f32), Gauss4, FixedStep::new(0.005f32), of_f32(), 1e-4),
            seen(&wide(), Gauss4, FixedStep::new(DoubleDouble::from(0.005)), of_double(), 1e-9),
        ],
    );
    let linear = || {
        Cell::None(
            "rustc rejects equations that are not linear, and those in which time appears: `Linear`, `Autonomous`",
        )
    };
    let day = || FixedStep::new(1.0);
    table.row(
        "`MatrixExponential`",
        [
            linear(),
            seen(&Damped::new(-0.3), MatrixExponential, day(), (at(1.0, 0.0), t, [decay(-0.3)]), 1e-13),
            seen(&Coupled::new(0.7, 0.0), MatrixExponential, day(), circulatory(0.7), 1e-13),
            seen(&Coupled::new(0.0, 1.5), MatrixExponential, day(), around(1.5), 1e-13),
            linear(),
            linear(),
            linear(),
            linear(),
            linear(),
            seen(&Coupled::new(0.0, 0.0), MatrixExponential, day(), around(0.0), 1e-13),
            AS_THEY_ARE,
            seen(&Oscillator::new(1e6), MatrixExponential, day(), stiff, 1e-12),
            seen(
                &Oscillator::new(1.5),
                MatrixExponential,
                FixedStep::new(200.0),
                (at(1.0, 0.0), 200.0, [300f64.cos()]),
                1e-12,
            ),
            linear(),
            seen(
                &Oscillator::new(1.5).map(|x| x as f32),
                MatrixExponential,
                FixedStep::new(1f32),
                of_f32(),
                1e-5,
            ),
            seen(&wide(), MatrixExponential, FixedStep::new(DoubleDouble::ONE), of_double(), 1e-15),
        ],
    );
    let found = |end: Result<f64, Failure>, exact: f64| match end {
        Ok(at) => Cell::Seen(if (at - exact).abs() < 1e-6 {
            "right".into()
        } else {
            format!("wrong: {at} for {exact}")
        }),
        Err(failure) => Cell::Seen(format!("`{}`", failure.name())),
    };
    macro_rules! simulated {
        ($system:expr, $motion:expr) => {{
            let (start, end, exact) = $motion;
            let end = simulate(&$system, start, end, 1e-9).map(|at| at.q[0].to_f64());
            found(end.map_err(|failed| failed.failure.map(|x| x.to_f64())), exact[0])
        }};
    }
    table.row(
        "`method_for`, `simulate`",
        [
            simulated!(Foreign::new(), (at(1.0, 0.0), t, [driven])),
            simulated!(Damped::new(-0.3), (at(1.0, 0.0), t, [decay(-0.3)])),
            simulated!(Coupled::new(0.7, 0.0), circulatory(0.7)),
            simulated!(Coupled::new(0.0, 1.5), around(1.5)),
            both(
                simulated!(Uneven::new(), (at(1.0, 0.0), t, [uneven])),
                simulated!(Wedge::new(), (at(1.0, 0.0), t, [wedge])),
            ),
            simulated!(Bob::new(), (hangs, t, [angle.sin()])),
            simulated!(Polar::new(), from_the_pole),
            simulated!(Fast::new(), (at(0.0, 0.0), t, [(1.0 + t * t).sqrt() - 1.0])),
            simulated!(Driven::new(), (at(1.0, 0.0), t, [driven])),
            simulated!(Coupled::new(0.0, 0.0), around(0.0)),
            AS_THEY_ARE,
            simulated!(Oscillator::new(1e6), stiff),
            simulated!(Oscillator::new(1.5), (at(1.0, 0.0), 200.0, [300f64.cos()])),
            simulated!(Gusty::new(), (at(0.0, 0.0), 60.0, [gust])),
            simulated!(Oscillator::new(1.5).map(|x| x as f32), (at(1.0, 0.0).map(|x| x as f32), 0.0, [1.0])),
            simulated!(
                Oscillator::new(1.5).map(DoubleDouble::from),
                (at(1.0, 0.0).map(DoubleDouble::from), DoubleDouble::from(2.0), [3f64.cos()])
            ),
        ],
    );
    families(&mut table);
    table.check("methods");
}

/// Other families. What is missing is rejected by rustc.
fn families(table: &mut Printed) {
    let velocity = || Cell::None("rustc rejects forces that depend on velocities: `Separable`");
    let bound = || Cell::None("rustc rejects constraints: `Independent`");
    let of_energy = || Cell::None("rustc rejects systems whose energy is not conserved: `Conservative`");
    let at = |q: f64, qd: f64| State::new(0.0, [q], [qd]);
    let (t, h) = (2.0f64, || FixedStep::new(0.005));
    let driven = (at(1.0, 0.0), t, [4.0 / 3.0 * t.cos() - (2.0 * t).cos() / 3.0]);
    let c = -0.3f64;
    let w = (1.0 - c * c).sqrt();
    let grown = (at(1.0, 0.0), t, [(-c * t).exp() * ((w * t).cos() + c / w * (w * t).sin())]);
    let circle = (State::new(0.0, [1.0, 0.0], [0.0, 1.0]), t, [t.cos(), t.sin()]);
    let uneven = (at(1.0, 0.0), t, [-0.5 * (2.0 * (t - core::f64::consts::FRAC_PI_2)).sin()]);
    let rest = t - 2f64.sqrt();
    let wedge = (at(1.0, 0.0), t, [-2f64.sqrt() * rest + 0.5 * rest * rest]);
    let fast = (at(0.0, 0.0), t, [(1.0 + t * t).sqrt() - 1.0]);
    let from_the_pole = (State::new(0.0, [0.0, 0.3], [1.0, 0.0]), t, [f64::NAN; 2]);
    let slow = (at(1.0, 0.0), 2e-6, [2f64.cos()]);
    let gust = (at(0.0, 0.0), 60.0, [core::f64::consts::PI.sqrt() * (-0.25f64).exp() * 10f64.sin()]);
    let short = (at(1.0, 0.0).map(|x| x as f32), t as f32, [3f64.cos()]);
    let long = (at(1.0, 0.0).map(DoubleDouble::from), DoubleDouble::from(0.5), [0.75f64.cos()]);
    let short_step = || FixedStep::new(0.005f32);
    let long_step = || FixedStep::new(DoubleDouble::from(0.005));
    let w = 0.5 * (1.5 + (1.5f64 * 1.5 + 4.0).sqrt());
    let around = (State::new(0.0, [1.0, 0.0], [0.0, w]), t, [(w * t).cos(), (w * t).sin()]);
    let a = (0.5 * ((1.0f64 + 0.49).sqrt() - 1.0)).sqrt();
    let b = -0.35 / a;
    let e = (a * t).exp();
    let circulatory = (State::new(0.0, [1.0, 0.0], [a, b]), t, [e * (b * t).cos(), e * (b * t).sin()]);
    table.row(
        "`VariationalMidpoint`",
        [
            seen(&Foreign::new(), VariationalMidpoint, h(), driven, 1e-4),
            seen(&Damped::new(c), VariationalMidpoint, h(), grown, 1e-4),
            seen(&Coupled::new(0.7, 0.0), VariationalMidpoint, h(), circulatory, 1e-4),
            seen(&Coupled::new(0.0, 1.5), VariationalMidpoint, h(), around, 1e-4),
            both(
                seen(&Uneven::new(), VariationalMidpoint, h(), uneven, 1e-3),
                seen(&Wedge::new(), VariationalMidpoint, h(), wedge, 1e-2),
            ),
            bound(),
            seen(&Polar::new(), VariationalMidpoint, h(), from_the_pole, 0.0),
            seen(&Fast::new(), VariationalMidpoint, h(), fast, 1e-4),
            seen(&Driven::new(), VariationalMidpoint, h(), driven, 1e-4),
            seen(&Coupled::new(0.0, 0.0), VariationalMidpoint, h(), circle, 1e-4),
            AS_THEY_ARE,
            seen(&Oscillator::new(1e6), VariationalMidpoint, FixedStep::new(1e-8), slow, 1e-3),
            TOO_LONG,
            seen(&Gusty::new(), VariationalMidpoint, h(), gust, 1e-3),
            seen(&Oscillator::new(1.5).map(|x| x as f32), VariationalMidpoint, short_step(), short, 1e-3),
            seen(&Oscillator::new(1.5).map(DoubleDouble::from), VariationalMidpoint, long_step(), long, 1e-4),
        ],
    );
    let composed = || Compose(Verlet, Yoshida6);
    table.row(
        "`Verlet`, `Compose`",
        [
            seen(&Foreign::new(), composed(), h(), driven, 1e-9),
            velocity(),
            Cell::None("as `BlanesMoan4`, which is composed as well"),
            velocity(),
            both(
                seen(&Uneven::new(), composed(), h(), uneven, 1e-3),
                seen(&Wedge::new(), composed(), h(), wedge, 1e-2),
            ),
            bound(),
            velocity(),
            velocity(),
            seen(&Driven::new(), composed(), h(), driven, 1e-9),
            Cell::None("as `BlanesMoan4`, which is composed as well"),
            AS_THEY_ARE,
            seen(&Oscillator::new(1e6), composed(), FixedStep::new(1e-8), slow, 1e-6),
            TOO_LONG,
            seen(&Gusty::new(), composed(), h(), gust, 1e-9),
            seen(&Oscillator::new(1.5).map(|x| x as f32), composed(), short_step(), short, 1e-3),
            seen(&Oscillator::new(1.5).map(DoubleDouble::from), composed(), long_step(), long, 1e-12),
        ],
    );
    let projected = || Projection(Dop853);
    let pi = || PiController::tolerance(1e-10);
    table.row(
        "`Projection(Dop853)`",
        [
            of_energy(),
            of_energy(),
            of_energy(),
            of_energy(),
            both(
                seen(&Uneven::new(), projected(), pi(), uneven, 1e-7),
                seen(&Wedge::new(), projected(), pi(), wedge, 1e-7),
            ),
            Cell::None("as `Dop853`: constraints are kept after the energy is"),
            seen(&Polar::new(), projected(), pi(), from_the_pole, 0.0),
            seen(&Fast::new(), projected(), pi(), fast, 1e-7),
            of_energy(),
            Cell::None("as `Dop853`: what it projects onto has one energy"),
            AS_THEY_ARE,
            seen(&Oscillator::new(1e6), projected(), pi(), slow, 1e-7),
            Cell::None("a tolerance chooses the steps"),
            of_energy(),
            seen(
                &Oscillator::new(1.5).map(|x| x as f32),
                projected(),
                PiController::tolerance(1e-5),
                short,
                1e-4,
            ),
            seen(
                &Oscillator::new(1.5).map(DoubleDouble::from),
                projected(),
                PiController::tolerance(1e-16),
                long,
                1e-15,
            ),
        ],
    );
}

/// Samples of every source that do not begin are failures of their studies, and no statistic takes part of them.
#[test]
fn every_source_tells_a_refusal() {
    let refused = Failure::BadTolerance { absolute: -1.0, relative: -1.0 };
    let made = |x: f64| (Sideways::new(), State::new(0.0, [0.1 + 0.5 * x], [0.0]));
    macro_rules! study {
        ($source:expr, $draw:expr) => {{
            let study =
                Ensemble::new($source, 40, $draw).integrate(Verner9, PiController::tolerance(-1.0), 1.0);
            let outcome = study.reduce(|_, run| Ok(run.final_state()?.q[0]), Moments).expect("a sound study");
            assert_eq!((outcome.statistic.count(), outcome.failures.count), (0, 40));
            assert!(outcome.failures.kept.iter().all(|failed| failed.failure == refused));
        }};
    }
    study!(Table::new((0..40).map(|k| [f64::from(k) / 40.0])), |[x]: [f64; 1]| made(x));
    study!(Sobol::<1>::seed(3), |[x]: [f64; 1]| made(x));
    study!(Random::seed(3), |_| made(0.5));
}
