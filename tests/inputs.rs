//! Inputs of the language: fields that are held within a step, and derivatives by them.

use lagrange_runtime::lanes::Rescale;
use lagrange_runtime::prelude::*;
use lagrange_runtime::{Inputs, Stepper, traits::InputJacobian};

lagrangian! {
    /// A double pendulum with motors in its joints, in a field and under a brake that are set from outside.
    pub system Arm {
        param m1, m2, l1, l2, g = 9.81;
        /// Torques.
        input u: [2];
        input field = 0.5, brake;
        coord a, b;
        let x1 = l1 * a.sin();
        let y1 = -l1 * a.cos();
        let x2 = x1 + l2 * b.sin();
        let y2 = y1 - l2 * b.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2 - field.powi(2) * x2;
        D = 0.5 * brake * dot(b).powi(2);
        Q[a] = u[0] - u[1] + u[1] * u[0] * sin(b);
        Q[b] = u[1];
        observe tip = [x2, y2];
        observe load = u[0] * dot(a) + field * x2;
    }
}

lagrangian! {
    /// Nothing but a potential depends on the input.
    system Tilted {
        param m, k;
        input tilt;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * k * x.powi(2) - m * tilt * x;
    }
}

lagrangian! {
    system Orbit {
        param mu;
        input thrust;
        coord r: length, phi: angle;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -mu / r;
        Q[r] = thrust;
        routhian Radial;
    }
}

const STATE: State<f64, 2> =
    State { t: 0.0, q: SVector::<f64, 2>::new(0.7, -1.2), qd: SVector::<f64, 2>::new(0.3, 2.0) };

fn arm() -> Arm {
    Arm { u: [0.7, -0.4], field: 1.3, brake: 0.2, ..Arm::new(1.0, 0.7, 1.1, 0.8) }
}

#[test]
fn inputs_are_fields_with_defaults() {
    let arm = Arm::new(1.0, 0.7, 1.1, 0.8);
    assert_eq!((arm.u, arm.field, arm.brake), ([0.0, 0.0], 0.5, 0.0));
    assert_eq!(<Arm as Inputs<2, 4>>::INPUTS, ["u[0]", "u[1]", "field", "brake"]);
    assert_eq!(<Arm as Lagrangian<2>>::FACTS.inputs, ["u[0]", "u[1]", "field", "brake"]);
    assert_eq!(<Tilted as Lagrangian<1>>::FACTS.inputs, ["tilt"]);
    let mut arm = arm;
    arm.set_inputs(&SVector::from([1.0, 2.0, 3.0, 4.0]));
    assert_eq!((arm.u, arm.field, arm.brake), ([1.0, 2.0], 3.0, 4.0));
    assert_eq!(arm.inputs(), SVector::from([1.0, 2.0, 3.0, 4.0]));
    assert_eq!(arm.map(|x| x as f32).inputs(), SVector::from([1.0f32, 2.0, 3.0, 4.0]));
    assert_eq!(Tilted::new(1.0, 2.0), Tilted { m: 1.0, k: 2.0, tilt: 0.0 });
}

/// `∂q̈/∂u` against dual numbers.
#[test]
fn derivatives_by_inputs() {
    let arm = arm();
    let emitted = arm.input_jacobian(&STATE.q, &STATE.qd, 0.0);
    for k in 0..4 {
        let mut dual = arm.map(Dual::constant);
        let mut inputs = dual.inputs();
        inputs[k].slope = 1.0;
        dual.set_inputs(&inputs);
        let at = STATE.map(Dual::constant);
        let column = dual.accel(&at.q, &at.qd, at.t).map(|a| a.slope);
        let scale = column.amax().max(1.0);
        assert!((emitted.column(k) - column).amax() < 1e-14 * scale, "{k}: {emitted} {column}");
    }
}

/// Constants that are computed once do not contain inputs.
#[test]
fn prepared_systems_follow_their_inputs() {
    let plain = arm();
    let mut prepared = Arm::new(1.0, 0.7, 1.1, 0.8).precomputed();
    let constants = prepared.constants();
    prepared.set_inputs(&plain.inputs());
    assert_eq!(prepared.constants(), constants);
    assert_eq!(prepared.accel(&STATE.q, &STATE.qd, 0.0), plain.accel(&STATE.q, &STATE.qd, 0.0));
    assert_eq!(
        prepared.input_jacobian(&STATE.q, &STATE.qd, 0.0),
        plain.input_jacobian(&STATE.q, &STATE.qd, 0.0)
    );
    let over = plain.over(|x| x);
    assert_eq!(over.accel(&STATE.q, &STATE.qd, 0.0), plain.accel(&STATE.q, &STATE.qd, 0.0));
    let mut stepper = Stepper::new(prepared, Dop853, PiController::tolerance(1e-10), STATE);
    stepper.advance_to(0.5).unwrap();
    stepper.set_inputs([0.0, 1.0, 0.0, 0.5]).unwrap();
    stepper.advance_to(1.0).unwrap();
    let mut other = Stepper::new(plain, Dop853, PiController::tolerance(1e-10), STATE);
    other.advance_to(0.5).unwrap();
    other.set_inputs([0.0, 1.0, 0.0, 0.5]).unwrap();
    other.advance_to(1.0).unwrap();
    assert_eq!(stepper.state(), other.state());
}

/// Energy is conserved while the input is held: `conservative` means that.
#[test]
fn facts_hold_while_inputs_are_held() {
    let facts = <Tilted as Lagrangian<1>>::FACTS;
    assert!(facts.conservative && facts.linear && facts.autonomous && facts.separable);
    let facts = <Arm as Lagrangian<2>>::FACTS;
    assert!(!facts.conservative && facts.autonomous);
    let start = State::new(0.0, [1.0], [0.0]);
    let mut stepper = Stepper::new(Tilted::new(2.0, 8.0), MatrixExponential, FixedStep::new(0.1), start);
    for (k, tilt) in [0.5, -1.0, 3.0].into_iter().enumerate() {
        stepper.set_inputs([tilt]).unwrap();
        let energy = stepper.system().energy_at(stepper.state());
        stepper.advance_to(1.0 + k as f64).unwrap();
        assert!((stepper.system().energy_at(stepper.state()) - energy).abs() < 1e-13);
    }
}

/// Series of the motion take inputs for numbers.
#[test]
fn series_know_inputs() {
    let end = |method: &dyn Fn(&Arm) -> State<f64, 2>| method(&arm());
    let taylor = end(&|arm| {
        integrate(arm, Taylor::of_order(18), TaylorController::tolerance(1e-13), STATE)
            .until(2.0)
            .final_state()
            .unwrap()
    });
    let runge = end(&|arm| {
        integrate(arm, Verner9, PiController::tolerance(1e-13), STATE).until(2.0).final_state().unwrap()
    });
    assert!((taylor.q - runge.q).amax() < 1e-10 && (taylor.qd - runge.qd).amax() < 1e-10);
}

#[test]
fn reduced_systems_have_the_inputs() {
    let orbit = Orbit { thrust: 0.25, ..Orbit::new(1.0) };
    let start = State::new(0.0, [1.0, 0.0], [0.0, 1.0]);
    let (radial, reduced) = orbit.reduce(&start);
    assert_eq!((radial.thrust, radial.p_phi, radial.inputs()[0]), (0.25, 1.0, 0.25));
    assert_eq!(radial.accel(&reduced.q, &reduced.qd, 0.0)[0], orbit.accel(&start.q, &start.qd, 0.0)[0]);
    assert_eq!(radial.input_jacobian(&reduced.q, &reduced.qd, 0.0)[(0, 0)], 1.0);
}

/// At a change of the kinetic energy, velocities stay in the whole system, and momenta in the reduced one.
#[test]
fn reduced_systems_keep_their_momenta() {
    lagrangian! {
        system Spherical {
            param m, l;
            input w = 1.0;
            coord theta, phi;
            T = 0.5 * m * l.powi(2) * (dot(theta).powi(2) + w * (dot(phi) * theta.sin()).powi(2));
            V = -9.81 * m * l * theta.cos();
            routhian Swing;
        }
    }
    let start = State::new(0.0, [1.0, 0.0], [0.0, 3.0]);
    let mut whole = Stepper::new(Spherical::new(1.0, 0.5), Dop853, PiController::tolerance(1e-12), start);
    let (swing, state) = whole.system().reduce(&start);
    let mut reduced = Stepper::new(swing, Dop853, PiController::tolerance(1e-12), state);
    whole.advance_to(0.4).unwrap();
    reduced.advance_to(0.4).unwrap();
    let (qd, p) = (whole.state().qd, reduced.system().p_phi);
    whole.set_inputs([4.0]).unwrap();
    reduced.set_inputs([4.0]).unwrap();
    assert_eq!(whole.state().qd, qd);
    assert_eq!(reduced.system().p_phi, p);
    let (again, state) = whole.system().reduce(whole.state());
    assert!((again.p_phi - 4.0 * p).abs() < 1e-10);
    let mut again = Stepper::new(again, Dop853, PiController::tolerance(1e-12), state);
    // The whole system with the momentum kept: its velocity is that of the reduced one, as the docs of `routhian` say.
    let kept = State { qd: SVector::from([qd[0], 0.25 * qd[1]]), ..*whole.state() };
    let mut slower = whole.clone();
    slower.set_state(kept).unwrap();
    for stepper in [&mut whole, &mut slower] {
        stepper.advance_to(0.8).unwrap();
    }
    reduced.advance_to(0.8).unwrap();
    again.advance_to(0.8).unwrap();
    assert!((whole.state().q[0] - again.state().q[0]).abs() < 1e-10);
    assert!((slower.state().q[0] - reduced.state().q[0]).abs() < 1e-10);
    assert!((whole.state().q[0] - reduced.state().q[0]).abs() > 0.1);
}

lagrangian! {
    /// A carriage with Coulomb friction, a limited drive, quadratic drag of the drive's fan, and a buffer.
    system Carriage {
        param m = 2, friction = 0, limit = 10, fan = 0, buffer = 0;
        input u;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = 0;
        Q[x] = u.clamp(-limit, limit) - friction * dot(x).signum() - fan * u * abs(u) - buffer * max(x, 0);
    }
}

/// On a switch of the forces there is no linear model; where the derivatives agree, there is.
#[test]
fn no_linear_model_on_a_switch() {
    use lagrange_runtime::analysis::{AnalysisError, StateSpace};
    let carriage = |change: fn(&mut Carriage)| {
        let mut carriage = Carriage::default();
        change(&mut carriage);
        carriage
    };
    let rest = State::new(0.0, [-1.0], [0.0]);
    let moving = State::new(0.0, [-1.0], [0.5]);
    let touching = State::new(0.0, [0.0], [0.5]);
    let on_a_switch = |carriage: &Carriage, at: &State<f64, 1>| {
        let model = StateSpace::about(carriage, at);
        assert!(matches!(model, Err(AnalysisError::Switch { .. })), "{model:?}");
    };
    let rubbing = carriage(|c| c.friction = 1.0);
    on_a_switch(&rubbing, &rest);
    assert!(matches!(StateSpace::without_inputs(&rubbing, &rest), Err(AnalysisError::Switch { .. })));
    for u in [10.0, -10.0] {
        let limited = Carriage { u, ..Carriage::default() };
        let refused = StateSpace::about(&limited, &moving).unwrap_err();
        assert_eq!(refused, AnalysisError::SwitchedInput { input: "u" });
        assert_eq!(StateSpace::without_inputs(&limited, &moving).unwrap().a[(1, 1)], 0.0);
    }
    on_a_switch(&carriage(|c| c.buffer = 3.0), &touching);
    let b = |carriage: &Carriage, at: &State<f64, 1>| StateSpace::about(carriage, at).unwrap().b[(1, 0)];
    assert_eq!(b(&rubbing, &moving), 0.5);
    assert_eq!(b(&carriage(|c| c.u = 10.1), &moving), 0.0);
    assert_eq!(b(&carriage(|c| c.u = 9.9), &moving), 0.5);
    // u |u| has a derivative at 0, as max(x, 0) without stiffness has.
    assert_eq!(b(&carriage(|c| c.fan = 0.3), &rest), 0.5);
    assert_eq!(b(&Carriage::default(), &touching), 0.5);
}

/// A, B, C and D against dual numbers.
#[test]
fn the_linear_model_is_exact() {
    use lagrange_runtime::analysis::StateSpace;
    let arm = arm();
    let model = StateSpace::about(&arm, &STATE).unwrap().observed(&arm, &STATE, |arm, s| {
        let [x, y] = arm.tip(&s.q, &s.qd, s.t).into();
        [x, y, arm.load(&s.q, &s.qd, s.t)]
    });
    let model = model.unwrap();
    // (q, q̇, u) to (q̇, q̈, y).
    let whole = |x: [Dual<f64>; 8]| -> [Dual<f64>; 7] {
        let mut arm = arm.map(Dual::constant);
        arm.set_inputs(&SVector::from([x[4], x[5], x[6], x[7]]));
        let (q, qd, t) = (SVector::from([x[0], x[1]]), SVector::from([x[2], x[3]]), Dual::constant(0.0));
        let (accel, tip) = (arm.accel(&q, &qd, t), arm.tip(&q, &qd, t));
        [qd[0], qd[1], accel[0], accel[1], tip[0], tip[1], arm.load(&q, &qd, t)]
    };
    let at = [0.7, -1.2, 0.3, 2.0, 0.7, -0.4, 1.3, 0.2];
    for j in 0..8 {
        let mut x = at.map(Dual::constant);
        x[j].slope = 1.0;
        let exact = whole(x).map(|y| y.slope);
        for (i, exact) in exact.into_iter().enumerate() {
            let found = match (i < 4, j < 4) {
                (true, true) => model.a[(i, j)],
                (true, false) => model.b[(i, j - 4)],
                (false, true) => model.c[(i - 4, j)],
                (false, false) => model.d[(i - 4, j - 4)],
            };
            assert!((found - exact).abs() <= 1e-14 * exact.abs().max(1.0), "{i} {j}: {found} {exact}");
        }
    }
    // From instant to instant, by steps of the linear system itself.
    let rest = State::new(0.0, [1.5], [0.0]);
    let tilted = Tilted::new(2.0, 8.0);
    let sampled = StateSpace::about(&tilted, &rest).unwrap().sampled(0.3).unwrap();
    let (sin, cos) = 0.6f64.sin_cos();
    let exact = [[cos, 0.5 * sin, 0.25 * (1.0 - cos)], [-2.0 * sin, cos, 0.5 * sin]];
    for period in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let refused = StateSpace::about(&tilted, &rest).unwrap().sampled(period).unwrap_err();
        let needs = "a positive and finite period";
        assert_eq!(refused, lagrange_runtime::analysis::AnalysisError::NotApplicable { needs });
    }
    for i in 0..2 {
        assert!((sampled.b[(i, 0)] - exact[i][2]).abs() < 1e-15);
        assert!((0..2).all(|j| (sampled.a[(i, j)] - exact[i][j]).abs() < 1e-15));
    }
}

lagrangian! {
    /// Long enough for derivatives by dual numbers.
    system Chain {
        const N = 8;
        param m;
        input u: [N];
        coord a: [N];
        let x: [N] = |i| if i == 0 { sin(a[0]) } else { x[i - 1] + sin(a[i]) };
        let y: [N] = |i| if i == 0 { -cos(a[0]) } else { y[i - 1] - cos(a[i]) };
        T = (0..N).map(|i| 0.5 * m * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * m * y[i]).sum();
        Q[a] = u;
    }
}

/// `M ∂q̈/∂u` is 1 where the inputs are the generalized forces.
#[test]
fn derivatives_of_a_long_system() {
    let chain = Chain { u: [0.5; 8], ..Chain::new(2.0) };
    let q = SVector::<f64, 8>::from_fn(|i, _| 0.3 * i as f64 - 1.0);
    let qd = SVector::<f64, 8>::from_fn(|i, _| 0.1 * i as f64);
    let rest = chain.inertia(&q, &qd, 0.0) * chain.input_jacobian(&q, &qd, 0.0) - SMatrix::identity();
    assert!(rest.amax() < 1e-12, "{rest}");
}

/// A constraint that an input moves: a jump would need an infinite velocity.
#[test]
fn inputs_do_not_break_constraints() {
    lagrangian! {
        system Lift {
            input height;
            coord x, y;
            T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
            V = 9.81 * y;
            constraint floor: y == height;
        }
    }
    let start = State::new(0.0, [0.0, 0.0], [1.0, 0.0]);
    let mut lift = Stepper::new(Lift::new(), Dop853, PiController::tolerance(1e-9), start);
    lift.advance_to(1.0).unwrap();
    lift.set_inputs([0.5]).unwrap();
    assert!(matches!(lift.advance_to(2.0), Err(Failure::ConstraintViolated { constraint: "floor", .. })));
    assert_eq!(lift.state().t, 1.0);
    lift.set_state(consistent(lift.system(), lift.state()).unwrap()).unwrap();
    lift.advance_to(2.0).unwrap();
    assert!((lift.state().q - SVector::from([2.0, 0.5])).amax() < 1e-12);
}

lagrangian! {
    /// An oscillator with a surface that an input moves across it.
    system Surface {
        param w = 3;
        input u = -1;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * (w * x).powi(2);
        event stop: u + 0.001 * x, rising, terminal;
        event mark: u + 0.001 * x;
    }
}

/// An event that an input crosses when it changes is met at the instant of the change, a terminal one too, wherever the
/// pieces end in which the motion is followed.
#[test]
fn events_are_met_when_an_input_jumps() {
    let start = State::new(0.0, [1.0], [0.0]);
    let law = |at: &State<f64, 1>, u: &mut SVector<f64, 1>| {
        u[0] = if ((at.t / 0.3).round() as i64) % 2 == 0 { -1.0 } else { 1.0 };
    };
    let new = || Stepper::new(Surface::default(), Dop853, PiController::tolerance(1e-9), start);
    let is_at = |t: f64, k: usize| (t - 0.3 * k as f64).abs() < 1e-14;

    let mut whole = new().every(0.3, law);
    let met: Vec<_> = whole.until(2.0).events(Surface::MARK).map(|event| event.unwrap().state.t).collect();
    assert!(met.len() == 6 && met.iter().enumerate().all(|(k, t)| is_at(*t, k + 1)), "{met:?}");

    let mut stopped = new().every(0.3, law);
    for k in [1, 3, 5] {
        let event = stopped.until(2.0).events(Surface::STOP).next().unwrap().unwrap();
        assert!(event.terminal && is_at(event.state.t, k) && *stopped.state() == event.state, "{event:?}");
    }
    assert!(stopped.until(2.0).events(Surface::STOP).next().is_none());

    for beyond in [0.0, 0.1] {
        let mut pieces = new().every(0.3, law);
        let mut met = vec![];
        for k in 1..=6 {
            let end = 0.3 * f64::from(k) + beyond;
            met.extend(pieces.until(end).events(Surface::MARK).map(|event| event.unwrap().state.t));
        }
        met.extend(pieces.until(2.0).events(Surface::MARK).map(|event| event.unwrap().state.t));
        assert!(met.len() == 6 && met.iter().enumerate().all(|(k, t)| is_at(*t, k + 1)), "{beyond} {met:?}");
    }

    let mut by_hand = new();
    assert_eq!(by_hand.until(0.5).events(Surface::MARK).count(), 0);
    by_hand.set_inputs([1.0]).unwrap();
    let met: Vec<_> = by_hand.until(1.0).events(Surface::MARK).map(|event| event.unwrap().state.t).collect();
    assert_eq!(met, [0.5]);
    // 0.001 cos 3 < 0.
    by_hand.set_inputs([0.0]).unwrap();
    assert_eq!(by_hand.until(1.1).events(Surface::MARK).count(), 1);
    // Another state is no crossing.
    by_hand.set_state(State::new(1.1, [0.5], [0.0])).unwrap();
    assert_eq!(by_hand.until(1.15).events(Surface::MARK).count(), 0);
}
