//! Every failure, provoked once as a user would meet it, with its text. The texts are here to be read.

use super::*;
use crate::diagnosis::*;
use crate::integrate::Failed;
use crate::method::explicit_rk::Euler;
use crate::method::rosenbrock::Rodas4;
use crate::method::variational::VariationalTrapezoid;
use crate::prelude::*;
use crate::testing::bank::{Law, Pendulum, Polar, coordinate, polar};
use crate::testing::emitted::{Bob, Kepler, Top};

lagrangian! {
    /// A unit mass on a stiff spring of length 1, in polar coordinates.
    system Spring {
        param k;
        coord r, phi;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = 0.5 * k * (r - 1).powi(2) - r * cos(phi);
    }
}

lagrangian! {
    /// A force that has the sign of x, and a jump there that a large slope leads to.
    system Relay {
        param f;
        coord x;
        T = 0.5 * dot(x).powi(2);
        Q[x] = if x > 0 { -f } else { f * (1 + 1e9 * x) };
        V = 0;
    }
}

const START: State<f64, 1> =
    State { t: 0.0, q: nalgebra::Vector1::new(1.0), qd: nalgebra::Vector1::new(1.0) };

const DEPENDENCE: Dependence =
    Dependence { constraint: "a", on: Some("b"), others: 1, left: 1e-12, rank: 2, of: 3 };

/// The text, the digits of its numbers left out.
fn told(failure: impl fmt::Display) -> String {
    let mut text = String::new();
    for c in failure.to_string().chars() {
        let number = c.is_ascii_digit() || (text.ends_with('#') && ".e-".contains(c));
        if number && !text.ends_with('#') {
            text.push('#');
        } else if !number {
            text.push(c);
        }
    }
    text
}

#[test]
fn step_size_underflow() {
    // q = 1/(1 − t).
    let pole = Law(&|q: f64, _, _| 2.0 * q * q * q);
    let failed = integrate(&pole, DormandPrince5, PiController::tolerance(1e-10), START)
        .until(2.0)
        .final_state()
        .unwrap_err();
    assert_eq!(
        told(failed),
        "at t = # the step size fell to #, and the estimated error is still too large: the solution is singular or \
         discontinuous there, or the tolerance is below rounding (where the absolute one is #, a coordinate or velocity \
         that is # has none), or so coarse that the run left the solution; try to end the run before it, \
         a larger tolerance, or a smaller one if it is coarse (the last good state is at t = #)"
    );
}

/// A step that cannot be made however short it is: why is told too.
#[test]
fn step_size_underflow_knows_its_cause() {
    let edge = Law(&|q: f64, _, _| (1.5 - q).sqrt());
    let failed =
        integrate(&edge, Dop853, PiController::tolerance(1e-9), START).until(2.0).final_state().unwrap_err();
    assert!(matches!(failed.failure, Failure::StepSizeUnderflow { cause: Some(Cause::NonFinite), .. }));
    assert_eq!(
        told(failed.failure),
        "at t = # the step size fell to #, and a step still meets a state or acceleration that is not finite: the \
         solution is singular there, a root or a logarithm leaves its domain, an argument leaves its table with \
         `Beyond::Refused`, or the tolerance is so coarse that the run left the solution; try to end the run before it, or \
         a smaller tolerance if it is coarse"
    );
    // Newton's iteration sees a force that jumps to and fro.
    let system = Relay::new(1.0);
    let start = State::new(0.0, [1.0], [0.0]);
    let failed = integrate(&system, Radau5, PiController::tolerance(1e-6), start)
        .until(9.0)
        .final_state()
        .unwrap_err();
    assert!(matches!(failed.failure, Failure::StepSizeUnderflow { cause: Some(Cause::NotConverged(_)), .. }));
    assert!(told(failed.failure).contains("and a step still does not converge in # iterations: "));
}

#[test]
fn non_finite() {
    let pole = Law(&|q: f64, _, _| 2.0 * q * q * q);
    let failed = integrate(&pole, Rk4, FixedStep::new(0.01), START).until(2.0).final_state().unwrap_err();
    assert_eq!(
        told(failed),
        "the step of size # from t = # met a state or acceleration that is not finite: it is too long, or the \
         equations are singular there (of size #: the state has no finite \
         acceleration, as a parameter is not finite, or # where it divides); try a smaller step or an adaptive controller (the last good state is at t = #)"
    );
}

#[test]
fn singular_inertia() {
    let system = Polar::<f64>::default();
    let origin = State::new(0.0, [0.0, 0.0], [1.0, 0.0]);
    let failed =
        integrate(&system, Gauss4, FixedStep::new(0.1), origin).until(1.0).final_state().unwrap_err();
    assert_eq!(
        failed.failure,
        Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, ""), with: None }
    );
    assert_eq!(
        told(failed.failure),
        "at t = # the inertia matrix is singular in coordinate #; give that coordinate mass, or choose coordinates \
         without a singularity there"
    );
    let failed = integrate(&Kepler::new(1.0), Gauss4, FixedStep::new(0.1), origin)
        .until(1.0)
        .final_state()
        .unwrap_err();
    assert_eq!(
        failed.failure,
        Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, "phi"), with: None }
    );
    assert!(failed.to_string().contains("singular in coordinate `phi`; "), "{failed}");
}

#[test]
fn explicit_methods_learn_of_singular_inertia_afterwards() {
    let system = Polar::<f64>::default();
    let origin = State::new(0.0, [0.0, 0.0], [1.0, 0.3]);
    let failed = integrate(&system, Rk4, FixedStep::new(0.1), origin).until(1.0).final_state().unwrap_err();
    assert!(matches!(failed.failure, Failure::NonFinite { .. }));
    assert_eq!(
        diagnose(&system, &failed),
        Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, ""), with: None }
    );
    // A fall into the centre: the step size underflows next to it.
    let fall = State::new(0.0, [1.0, 0.0], [0.0, 0.0]);
    let failed =
        integrate(&system, Dop853, PiController::tolerance(1e-9), fall).until(2.0).final_state().unwrap_err();
    assert!(
        matches!(diagnose(&system, &failed), Failure::SingularInertia { coordinate, .. } if coordinate.index == 1),
        "{failed:?}"
    );
    // The same fall in units in which r is small at first: it is not what the inertia of φ is at rest that counts.
    let small = State::new(0.0, [1e-6, 0.0], [0.0, 1e8]);
    let failed = integrate(&system, Dop853, PiController::tolerance(1e-9), small)
        .until(1.0)
        .max_steps(10)
        .final_state();
    assert!(matches!(diagnose(&system, &failed.unwrap_err()), Failure::BudgetUsedUp { .. }));
    // Other failures stay what they are.
    let tired = integrate(&system, Rk4, FixedStep::new(0.1), polar(0.0))
        .until(1.0)
        .max_steps(3)
        .final_state()
        .unwrap_err();
    assert_eq!(diagnose(&system, &tired), tired.failure);
    let wrong = State::new(0.0, [f64::NAN, 0.0], [0.0, 0.0]);
    let failed = integrate(&system, Rk4, FixedStep::new(0.1), wrong).until(1.0).final_state().unwrap_err();
    let part = Part::Coordinate(coordinate(0, ""));
    assert!(
        matches!(diagnose(&system, &failed), Failure::StateNotFinite { part: found, .. } if found == part)
    );
}

#[test]
fn not_converged() {
    let start = State::new(0.0, [1.0], [0.0]);
    let system = Pendulum::<f64> { g: 1e4, ..Pendulum::default() };
    let failed = integrate(&system, ImplicitMidpoint, FixedStep::new(0.5), start)
        .until(2.0)
        .final_state()
        .unwrap_err();
    assert!(matches!(failed.failure, Failure::NotConverged { .. }));
    assert_eq!(
        told(failed.failure),
        "the implicit step of size # from t = # did not converge in # iterations; try a smaller step, or \
         `VariationalMidpoint`, `Rodas#P` or `Radau#` if fast motion is what makes it too long"
    );
}

#[test]
fn budget_used_up() {
    // Stiff: an explicit method makes steps of 1e-3 along a solution that does not move.
    let stiff = Law(&|q: f64, qd, _| -1e6 * qd - q);
    let run =
        integrate(&stiff, DormandPrince5, PiController::tolerance(1e-6), START).until(1e3).max_steps(10_000);
    let failed = run.final_state().unwrap_err();
    assert!(matches!(failed.failure, Failure::BudgetUsedUp { .. }) && failed.last.t > 0.0);
    assert_eq!(
        told(failed.failure),
        "the budget of # attempted steps was used up at t = #, where the step size was # (a run without `until` has no end before that); raise `max_steps`, or, if \
         the steps are far shorter than the motion, use a method of higher order where the tolerance makes them so, and a method for stiff \
         systems where stability does"
    );
    // An implicit method needs no such advice.
    let kepler = Kepler::new(1.0);
    let run = integrate(&kepler, Radau5, PiController::tolerance(1e-9), polar(0.0)).until(1e3).max_steps(50);
    assert_eq!(
        told(run.final_state().unwrap_err().failure),
        "the budget of # attempted steps was used up at t = #, where the step size was # (a run without `until` has no end before that); raise `max_steps`, or a \
         tolerance or step as large as the motion admits: the method is implicit, so it is not stability that makes \
         its steps short"
    );
}

/// A spring pendulum in polar coordinates at steps too long for its spring: r runs away, and φ's inertia with it, so
/// that r's looks small beside it. There is nothing singular in that.
#[test]
fn a_numerical_blow_up_is_not_blamed_on_the_coordinates() {
    let (system, start) = (Spring::new(1e6), State::new(0.0, [1.01, 1.0], [0.0, 0.0]));
    fn end(
        system: &Spring,
        start: State<f64, 2>,
        method: impl Method<Spring, 2>,
    ) -> (Failed<f64, 2>, Failure) {
        let failed =
            integrate(system, method, FixedStep::new(0.01), start).until(10.0).final_state().unwrap_err();
        (failed, diagnose(system, &failed))
    }
    for (failed, diagnosis) in
        [end(&system, start, Euler), end(&system, start, Rk4), end(&system, start, VariationalTrapezoid)]
    {
        assert!(failed.last.t > 0.0, "{failed}");
        assert_eq!(diagnosis, failed.failure);
        assert!(matches!(diagnosis, Failure::NonFinite { .. } | Failure::NotConverged { .. }), "{diagnosis}");
    }
}

#[test]
fn tolerances_steps_and_ends_that_make_no_sense() {
    let free = Law(&|_, _, _| 0.0);
    let adaptive =
        |pi: PiController| integrate(&free, Dop853, pi, START).until(1.0).final_state().unwrap_err().failure;
    assert_eq!(
        adaptive(PiController::tolerance(0.0).atol(-1e-6)).to_string(),
        "tolerances must be finite, not negative and not both zero, but the absolute one is -1e-6 and the relative one \
         0.0; try 1e-9 for both"
    );
    assert_eq!(
        adaptive(PiController::tolerance(1e-6).first_step(0.0)).to_string(),
        "a step size must be finite and not zero, but it is 0.0; give its size in units of t"
    );
    let fixed = |end| {
        integrate(&free, Euler, FixedStep::new(0.1), START).until(end).final_state().unwrap_err().failure
    };
    assert_eq!(
        fixed(-1.0).to_string(),
        "steps of 0.1 from t = 0.0 lead away from the end at t = -1.0; change the sign of the step"
    );
    assert_eq!(
        fixed(f64::NAN).to_string(),
        "the time to go to must be finite, but it is NaN; give a finite one"
    );
    let endless = integrate(&free, Euler, FixedStep::new(0.1), START).final_state().unwrap_err();
    assert_eq!(endless.failure.to_string(), "this run has no end; give a time to `until`");
}

#[test]
fn samples_out_of_order_or_reach() {
    let free = Law(&|_, _, _| 0.0);
    let sample = |times: &[f64]| {
        let run = integrate(&free, Rk4, FixedStep::new(0.1), START).until(1.0);
        run.sample(times.iter().copied()).last().unwrap().unwrap_err().to_string()
    };
    assert_eq!(
        sample(&[0.5, 0.4]),
        "the sample time 0.4 does not lie after 0.5 in the direction of the run; sort the times"
    );
    assert_eq!(
        sample(&[0.5, 1.5]),
        "the sample time 1.5 lies beyond the end of the run at t = 1.0; give a later time to `until`"
    );
}

#[test]
fn events_that_are_no_numbers_or_only_seem_to_happen() {
    let free = Law(&|_, _, _| 0.0);
    let run = integrate(&free, Rk4, FixedStep::new(0.1), START).until(2.0);
    let failed = run.events(Event::rising(|s| (1.5 - s.q[0]).sqrt() - 2.0)).final_state().unwrap_err();
    assert_eq!(
        told(failed.failure),
        "the function of event # is infinite or not a number at or soon after t = #; give one that is defined on both \
         sides of its root"
    );
    let braked = Law(&|_, _, _| -1.0);
    let run = integrate(&braked, Euler, FixedStep::new(1.0), START).until(1.0);
    let failed = run.events(Event::rising(|s| s.q[0] - 1.05 - s.t).terminal()).final_state().unwrap_err();
    assert_eq!(
        told(failed.failure),
        "event # happens on the interpolant of the step of size # from t = #, but not on the trajectory, which misses \
         it by less than the error of the step; try a smaller tolerance or step"
    );
}

/// A top with `p_φ = p_ψ`, so that it goes through the vertical, where only the sum of φ̇ and ψ̇ has inertia.
#[test]
fn cancellation() {
    let (theta, p) = (0.5f64, 10f64.sqrt());
    let phid = p / (1.0 + theta.cos());
    let start = State::new(0.0, [0.0, theta, 0.0], [phid, 0.0, p - phid * theta.cos()]);
    let run = integrate(&Top { mgl: 1.0, I1: 1.0, I3: 1.0 }, Rodas4, PiController::tolerance(1e-9), start);
    let failed = run.until(5.0).final_state().unwrap_err();
    assert!(matches!(failed.failure, Failure::Cancellation { condition, .. } if condition < 1e9));
    assert_eq!(
        told(failed),
        "at t = # velocities cancel to one part in # of what coordinate `phi` adds to the kinetic energy, and rounding them would \
         change the motion: the coordinates are nearly singular there; give coordinates that are singular elsewhere, or end \
         the run before it (the last good state is at t = #)"
    );
}

/// At the pole of Euler's angles precession and spin are about one axis. `sin π` is not 0 in floating-point numbers:
/// runs from there ended with success, each method in another state, or in `BudgetUsedUp`.
#[test]
fn a_start_at_a_pole_names_its_coordinates() {
    let top = Top { mgl: 1.0, I1: 1.0, I3: 0.5 };
    for pole in [0.0, core::f64::consts::PI] {
        let start = State::new(0.0, [0.3, pole, 0.2], [0.1, 0.2, 3.0]);
        let pi = PiController::tolerance(1e-9);
        let taylor = Taylor;
        let failures = [
            integrate(&top, DormandPrince5, pi, start).until(1.0).final_state(),
            integrate(&top, Verner9, pi, start).until(1.0).final_state(),
            integrate(&top, Rodas5P, pi, start).until(1.0).final_state(),
            integrate(&top, Radau5, pi, start).until(1.0).final_state(),
            integrate(&top, taylor, TaylorController::tolerance(1e-9), start).until(1.0).final_state(),
            integrate(&top, Projection(Dop853), pi, start).until(1.0).final_state(),
            integrate(&top, Rk4, FixedStep::new(0.01), start).until(1.0).final_state(),
            integrate(&top, Gauss4, FixedStep::new(0.01), start).until(1.0).final_state(),
            integrate(&top, VariationalMidpoint, FixedStep::new(0.01), start).until(1.0).final_state(),
        ];
        let [phi, psi] = [coordinate(0, "phi"), coordinate(2, "psi")];
        for failed in failures.map(Result::unwrap_err) {
            let Failure::SingularInertia { t: 0.0, coordinate, with: Some(with) } = failed.failure else {
                panic!("{failed}")
            };
            assert!([(phi, psi), (psi, phi)].contains(&(coordinate, with)), "{failed}");
            assert!(
                failed.to_string().contains("move alike there, and cannot be told apart; give "),
                "{failed}"
            );
        }
        // Beside the pole, also where that is near, there is a motion.
        let beside = State::new(0.0, [0.3, pole + 1e-3, 0.2], [0.1, 0.2, 3.0]);
        assert!(integrate(&top, Verner9, pi, beside).until(1e-3).final_state().is_ok());
    }
}

/// Steps far too long for a pendulum in Cartesian coordinates: the projection would make the motion.
#[test]
fn constraint_drift() {
    let bob = Bob::new();
    let start = State::new(0.0, [0.6, -0.8], [0.0, 0.0]);
    let failed = integrate(&bob, Euler, FixedStep::new(0.5), start).until(5.0).final_state().unwrap_err();
    assert_eq!(
        told(failed),
        "the step of size # from t = # left the constraint `rod` so far that the projection back onto it would move the state by more \
         than a tenth of what the step did: the step is too long, or constraints depend on each other near there; try a smaller step, or an \
         adaptive controller, which finds out which (the last good state is at t = #)"
    );
}

#[test]
fn every_text_ends_in_a_hint() {
    const GROUND: EventName = EventName { index: 0, name: "ground" };
    let all: &[Failure] = &[
        Failure::StepSizeUnderflow { t: 0.0, h: 0.0, cause: None },
        Failure::StepSizeUnderflow { t: 0.0, h: 0.0, cause: Some(Cause::InvariantLost) },
        Failure::StepSizeUnderflow { t: 0.0, h: 0.0, cause: Some(Cause::NonFinite) },
        Failure::NonFinite { t: 0.0, h: 0.0 },
        Failure::StateNotFinite { t: 0.0, part: Part::Time },
        Failure::StateNotFinite { t: 0.0, part: Part::Coordinate(coordinate(1, "x")) },
        Failure::StateNotFinite { t: 0.0, part: Part::Velocity(coordinate(1, "")) },
        Failure::StateNotFinite { t: 0.0, part: Part::Equation(coordinate(1, "x")) },
        Failure::SingularInertia { t: 0.0, coordinate: coordinate(1, ""), with: None },
        Failure::NegativeInertia { t: 0.0, coordinate: coordinate(1, "phi") },
        Failure::SingularInertia {
            t: 0.0,
            coordinate: coordinate(2, "psi"),
            with: Some(coordinate(0, "phi")),
        },
        Failure::ConstraintDrift { t: 0.0, h: 0.0, constraint: "rod" },
        Failure::DependentConstraints { t: 0.0, dependence: DEPENDENCE },
        Failure::Bifurcation { t: 0.0, coordinates: [coordinate(0, "a0"), coordinate(1, "b")] },
        Failure::StepSizeUnderflow { t: 0.0, h: 0.0, cause: Some(Cause::ConstraintDrift("rod")) },
        Failure::Cancellation { t: 0.0, coordinate: coordinate(1, "phi"), condition: 1e9 },
        Failure::NotConverged { t: 0.0, h: 0.0, iterations: 9 },
        Failure::Quadrature { t: 0.0, h: 0.0 },
        Failure::SingularStep { t: 0.0, h: 0.0, coordinate: coordinate(1, "x") },
        Failure::InvariantLost { t: 0.0, h: 0.0 },
        Failure::OutsideModel { t: 0.0, coordinate: coordinate(1, "phi"), bound: 0.5 },
        Failure::BudgetUsedUp { t: 0.0, h: 0.0, max_steps: 9, implicit: false },
        Failure::BudgetUsedUp { t: 0.0, h: 0.0, max_steps: 9, implicit: true },
        Failure::BadTolerance { absolute: 0.0, relative: 0.0 },
        Failure::BadStepSize { h: 0.0 },
        Failure::WrongDirection { t: 0.0, h: 0.0, end: 0.0 },
        Failure::BadEnd { end: Some(f64::NAN) },
        Failure::BadEnd { end: None },
        Failure::SampleOrder { t: 0.0, previous: 0.0 },
        Failure::SampleBeyondEnd { t: 0.0, end: 0.0 },
        Failure::EventNotFinite { t: 0.0, event: GROUND },
        Failure::EventNotBracketed { t: 0.0, h: 0.0, event: GROUND },
        Failure::EventsAccumulate { t: 0.0, event: GROUND },
        Failure::EventsUnresolved { t: 0.0, h: 0.0 },
        Failure::Unsuitable { chosen: "FixedStep", requirement: Requirement::Smooth },
        Failure::Unsuitable { chosen: "every", requirement: Requirement::Forward },
        Failure::Unsuitable { chosen: "profile", requirement: Requirement::ContinuousSlope },
        Failure::UnknownImpulse { t: 1.0 },
        Failure::BadPeriod { t: 0.0, period: 0.0 },
    ];
    for failure in all {
        let text = failure.to_string();
        let hint = text.rsplit_once("; ").unwrap_or_else(|| panic!("no hint in: {text}")).1;
        let verb = hint.split(' ').next().unwrap();
        assert!(["try", "give", "raise", "change", "sort"].contains(&verb), "{text}");
    }
}
