//! Methods and controllers chosen while a program runs, over systems each of which lacks a fact: every pair is refused by the name of what is
//! missing, or right against a closed form.

use lagrange_runtime::choice::any::{AnyController, AnyMethod};
use lagrange_runtime::ensemble::{Ensemble, Moments, Random, Sobol, Table};
use lagrange_runtime::failure::Requirement;
use lagrange_runtime::prelude::*;
use lagrange_runtime::reference::SimplePendulum;

const METHODS: [AnyMethod; 10] = [
    AnyMethod::Dop853,
    AnyMethod::DormandPrince5,
    AnyMethod::Verner9,
    AnyMethod::Nystrom12,
    AnyMethod::BlanesMoan4,
    AnyMethod::Gauss4,
    AnyMethod::Modal,
    AnyMethod::Rodas5P,
    AnyMethod::Radau5,
    AnyMethod::Taylor,
];

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

/// The failure that a choice has to end in.
fn refusal(method: AnyMethod, controller: &AnyController, lacks: Lacks) -> Option<Failure> {
    use AnyMethod::*;
    let unsuitable = |requirement| Some(Failure::Unsuitable { chosen: method.name(), requirement });
    match (controller, method) {
        (AnyController::Pi(_), BlanesMoan4 | Gauss4 | Modal) => unsuitable(Requirement::ErrorEstimate),
        (AnyController::Decay(_), Taylor) if lacks.series => Some(Failure::NoSeries { t: 0.0 }),
        (AnyController::Decay(_), Taylor) => None,
        (AnyController::Decay(_), _) => {
            Some(Failure::Unsuitable { chosen: "Decay", requirement: Requirement::Series })
        }
        (_, Nystrom12 | BlanesMoan4) if lacks.separable => unsuitable(Requirement::Separable),
        (_, Gauss4) if lacks.independent => unsuitable(Requirement::Independent),
        (_, Gauss4) if lacks.quadratic => unsuitable(Requirement::Quadratic),
        (_, Modal) if lacks.linear => unsuitable(Requirement::Linear),
        (_, Modal) if lacks.constant => unsuitable(Requirement::Autonomous),
        (_, Taylor) if lacks.series => Some(Failure::NoSeries { t: 0.0 }),
        _ => None,
    }
}

/// All methods under all controllers on a system, against the end of its motion: within `bound` by fixed steps, which go over kinks and jumps of
/// forces, and within 1e-7 by adaptive ones.
fn net<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    end: f64,
    exact: [f64; N],
    bound: f64,
    lacks: Lacks,
) -> Vec<String> {
    let controllers = [
        AnyController::Fixed(Fixed::new(0.005)),
        AnyController::Pi(Pi::tolerance(1e-10)),
        AnyController::Decay(Decay::tolerance(1e-10)),
    ];
    let mut complaints = vec![];
    for method in METHODS {
        for controller in controllers {
            let come = integrate(system, method, controller, start).until(end).finish();
            let met = match (&come, refusal(method, &controller, lacks)) {
                (Ok(at), None) => {
                    let fixed = matches!(controller, AnyController::Fixed(_));
                    (at.q - SVector::from(exact)).amax() < if fixed { bound } else { 1e-7 }
                }
                (Err(failed), Some(expected)) => failed.failure == expected,
                _ => false,
            };
            if !met {
                complaints.push(format!("{}, {method:?}, {controller:?}: {come:?}", Sys::FACTS.name));
            }
        }
    }
    complaints
}

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

#[test]
fn every_choice_is_refused_or_right() {
    let at = |q: f64, qd: f64| State::new(0.0, [q], [qd]);
    let (t, none) = (2.0f64, Lacks::default());
    let mut complaints = vec![];
    complaints.extend(net(&Oscillator::new(1.5), at(1.0, 0.0), t, [(1.5 * t).cos()], 1e-7, none));
    let driven = [4.0 / 3.0 * t.cos() - (2.0 * t).cos() / 3.0];
    let constant = Lacks { constant: true, ..none };
    complaints.extend(net(&Driven::new(), at(1.0, 0.0), t, driven, 1e-7, constant));
    complaints.extend(net(
        &Foreign::new(),
        at(1.0, 0.0),
        t,
        driven,
        1e-7,
        Lacks { series: true, ..constant },
    ));
    let (delta, nu) = (0.3f64, (1.0 - 0.09f64).sqrt());
    let damped = (-delta * t).exp() * ((nu * t).cos() + delta / nu * (nu * t).sin());
    complaints.extend(net(
        &Damped::new(delta),
        at(1.0, 0.0),
        t,
        [damped],
        1e-7,
        Lacks { separable: true, ..none },
    ));
    let (angle, _) = SimplePendulum::new(1.0, 1.0, 1.0, 0.0).state(t);
    let linear = Lacks { linear: true, ..none };
    complaints.extend(net(&Swing::new(), at(1.0, 0.0), t, [angle], 1e-7, linear));
    let general = Lacks { separable: true, ..linear };
    complaints.extend(net(&Sideways::new(), at(1f64.sin(), 0.0), t, [angle.sin()], 1e-7, general));
    let held = Lacks { independent: true, ..general };
    let hangs = State::new(0.0, [1f64.sin(), -1f64.cos()], [0.0, 0.0]);
    complaints.extend(net(&Bob::new(), hangs, t, [angle.sin(), -angle.cos()], 1e-7, held));
    let glides = State::new(0.0, [0.0; 3], [1.0, 0.0, 0.5]);
    let circle = [2.0 * (0.5 * t).sin(), 2.0 - 2.0 * (0.5 * t).cos(), 0.5 * t];
    complaints.extend(net(&Skate::new(), glides, t, circle, 1e-7, held));
    let fast = [(1.0 + t * t).sqrt() - 1.0];
    complaints.extend(net(&Fast::new(), at(0.0, 0.0), t, fast, 1e-7, Lacks { quadratic: true, ..general }));
    // The motion takes a quarter of a period, 2π/4, from 1 to the kink, and has twice the rate on the other side.
    let switched = Lacks { linear: true, series: true, ..none };
    let uneven = [-0.5 * (2.0 * (t - core::f64::consts::FRAC_PI_2)).sin()];
    complaints.extend(net(&Uneven::new(), at(1.0, 0.0), t, uneven, 1e-4, switched));
    // 1 − t²/2 to the kink at √2.
    let rest = t - 2f64.sqrt();
    let wedge = [-2f64.sqrt() * rest + 0.5 * rest * rest];
    // The velocity after the step over the jump of 2 is off by up to 2 h.
    complaints.extend(net(&Wedge::new(), at(1.0, 0.0), t, wedge, 2.0 * 0.005 * rest, switched));
    assert!(complaints.is_empty(), "{}\n{} in all", complaints.join("\n"), complaints.len());
}

/// Samples of every source that are refused are failures of their studies, and no statistic takes part of them.
#[test]
fn every_source_tells_a_refusal() {
    let (method, controller) = (AnyMethod::Nystrom12, AnyController::Pi(Pi::tolerance(1e-9)));
    let refused = Failure::Unsuitable { chosen: "Nystrom12", requirement: Requirement::Separable };
    let made = |x: f64| (Sideways::new(), State::new(0.0, [0.1 + 0.5 * x], [0.0]));
    macro_rules! study {
        ($source:expr, $draw:expr) => {{
            let study = Ensemble::new($source, 40, $draw).integrate(method, controller, 1.0);
            let outcome = study.reduce(|_, run| Ok(run.finish()?.q[0]), Moments).expect("a sound study");
            assert_eq!((outcome.statistic.count(), outcome.failures.count), (0, 40));
            assert!(outcome.failures.kept.iter().all(|failed| failed.failure == refused));
        }};
    }
    study!(Table::new((0..40).map(|k| [f64::from(k) / 40.0])), |[x]: [f64; 1]| made(x));
    study!(Sobol::<1>::seed(3), |[x]: [f64; 1]| made(x));
    study!(Random::seed(3), |_| made(0.5));
}
