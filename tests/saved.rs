//! A motion that is saved and restored goes on bit for bit, and nothing of another system is taken for its own.

use lagrange_runtime::method::explicit_rk::{Heun, Tsitouras5};
use lagrange_runtime::prelude::*;
use lagrange_runtime::{
    BlanesMoan4, BlanesMoan6, Compose, Controller, DoubleDouble, Gauss6, KahanLi8, Nystrom12, Stepper,
    Tangent,
    method::compose::{HairerLubichWanner10, KahanLi6, Suzuki4, SuzukiUmeno8, TripleJump, Yoshida6},
    method::explicit_rk::Euler,
    method::nystrom::{Nystrom6, Nystrom8},
    method::rosenbrock::Rodas4,
    method::splitting::PositionVerlet,
    method::taylor::LongTaylor,
    method::variational::VariationalTrapezoid,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

lagrangian! {
    system Motors {
        param m1, m2, l: [2] = [1.0, 0.8], g = 9.81;
        input u;
        coord a, b;
        let x1 = l[0] * a.sin();
        let y1 = -l[0] * a.cos();
        let x2 = x1 + l[1] * b.sin();
        let y2 = y1 - l[1] * b.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
        Q[a] = u;
    }
}

lagrangian! {
    system Springs {
        param k, c;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * k * (x.powi(2) + y.powi(2) + c * x * y);
    }
}

lagrangian! {
    system Falling {
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = -abs(x);
    }
}

lagrangian! {
    /// A drive whose force has a limit, or none.
    system Saturated {
        param lim;
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = min(u, lim);
    }
}

const START: State<f64, 2> =
    State { t: 0.0, q: SVector::<f64, 2>::new(1.5, 2.0), qd: SVector::<f64, 2>::new(0.0, 0.3) };

fn again<T: Serialize + DeserializeOwned>(value: &T) -> T {
    serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
}

/// Saved in the middle of its way, between two times, it arrives where it would have.
fn goes_on<Sys, M, C, const N: usize>(system: Sys, method: M, controller: C, start: State<f64, N>)
where
    Sys: System<N, Scalar = f64> + Serialize + DeserializeOwned + Clone,
    M: Method<Sys, N> + Serialize + DeserializeOwned + Clone,
    M::MethodState: Serialize + DeserializeOwned,
    C: Controller<f64, N, M::Error> + Serialize + DeserializeOwned,
{
    let mut stepper = Stepper::new(system, method, controller, start);
    let mut fresh = again(&stepper);
    let _ = stepper.advance_within(1.0, 7).unwrap();
    let mut restored = again(&stepper);
    for stepper in [&mut stepper, &mut restored, &mut fresh] {
        stepper.advance_to(1.0).unwrap();
        stepper.advance_to(2.0).unwrap();
    }
    assert_eq!(stepper.state(), restored.state());
    assert_eq!(stepper.state(), fresh.state());
    assert_eq!(stepper.statistics(), restored.statistics());
}

#[test]
fn a_restored_motion_goes_on_bit_for_bit() {
    let motors = Motors { u: 0.3, ..Motors::new(1.0, 0.7) };
    goes_on(motors, Rk4, FixedStep::new(0.013), START);
    goes_on(motors, Gauss4, FixedStep::new(0.02), START);
    goes_on(motors, VariationalMidpoint, FixedStep::new(0.02), START);
    goes_on(motors, Dop853, PiController::tolerance(1e-9), START);
    goes_on(motors, Dop853, PidController::h312b(PiController::tolerance(1e-9)), START);
    goes_on(motors.precomputed(), Verner9, PiController::tolerance(1e-9).max_step(0.05), START);
    goes_on(motors, Radau5, PiController::tolerance(1e-7), START);
    goes_on(motors, Rodas5P, PiController::tolerance(1e-7), START);
    goes_on(motors, Taylor::of_order(14), TaylorController::tolerance(1e-9), START);
    let springs = Springs::new(4.0, 0.5);
    goes_on(springs, Verlet, FixedStep::new(0.01), START);
    goes_on(springs, BlanesMoan4, FixedStep::new(0.05), START);
    goes_on(springs, BlanesMoan6, FixedStep::new(0.05), START);
    goes_on(springs, MatrixExponential, FixedStep::new(0.1), START);
    goes_on(springs, Projection(Dop853), PiController::tolerance(1e-9), START);
    goes_on(Falling::new(), Dop853, PiController::tolerance(1e-9), State::new(0.0, [1.0], [-3.0]));
    goes_on(
        Falling::new(),
        Taylor::of_order(14),
        TaylorController::tolerance(1e-9),
        State::new(0.0, [1.0], [-3.0]),
    );
}

#[test]
fn values_come_back_as_they_were() {
    let motors = Motors { u: 0.1 + 0.2, ..Motors::new(1.0 / 3.0, 0.7) };
    assert_eq!(again(&motors), motors);
    assert_eq!(again(&START), START);
    // In any order, as a map that sorts its keys has them.
    let value = serde_json::to_value(motors).unwrap();
    assert_eq!(value["numbers"]["l[1]"], 0.8);
    assert_eq!(serde_json::from_value::<Motors>(value).unwrap(), motors);
    for x in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let (motors, tangent) =
            (Motors { u: x, ..motors }, Tangent { q: [x, 1.0].into(), qd: [0.5, x].into() });
        let (at, wide) = (State { t: x, q: [1.5, x].into(), qd: [x, 0.5].into() }, DoubleDouble::from(x));
        assert_eq!(again(&motors).u.to_bits(), x.to_bits());
        assert_eq!(format!("{:?}", again(&at)), format!("{at:?}"));
        assert_eq!(format!("{:?}", again(&tangent)), format!("{tangent:?}"));
        assert_eq!(again(&wide).hi.to_bits(), x.to_bits());
    }
    // No limit: the checkpoint of a motion with an infinite parameter.
    let saturated = Saturated { u: 0.3, ..Saturated::new(f64::INFINITY) };
    let start = State::new(0.0, [1.0], [0.0]);
    goes_on(saturated, Dop853, PiController::tolerance(1e-9), start);
    assert!(serde_json::to_string(&saturated).unwrap().contains("\"lim\":\"inf\""));
    assert_eq!(serde_json::to_string(&START).unwrap(), r#"{"t":0.0,"q":[1.5,2.0],"qd":[0.0,0.3]}"#);
    for x in [f64::INFINITY, f64::NEG_INFINITY] {
        let pi = PiController::tolerance(1e-9).max_step(x);
        assert_eq!(again(&pi), pi);
    }
    let failure = Failure::StepSizeUnderflow { t: 1.5, h: 1e-17, cause: None };
    assert!(serde_json::to_string(&failure).unwrap().contains("StepSizeUnderflow"));
    let facts = serde_json::to_string(&<Motors as Lagrangian<2>>::FACTS).unwrap();
    assert!(facts.contains("\"inputs\":[\"u\"]"), "{facts}");
}

/// Every method and controller, which rustc tells, and for the memory of each.
#[test]
fn all_methods_and_controllers_are_saved() {
    fn comes_back<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: T) {
        assert_eq!(again(&value), value);
    }
    fn method<M>(method: M)
    where
        M: Method<Springs, 2> + Serialize + DeserializeOwned + PartialEq + std::fmt::Debug,
        M::MethodState: Serialize + DeserializeOwned,
    {
        let memory = method.start(&Springs::new(4.0, 0.5), &START).unwrap();
        let saved = serde_json::to_string(&memory).unwrap();
        assert_eq!(serde_json::to_string(&again(&memory)).unwrap(), saved);
        comes_back(method);
    }
    macro_rules! methods {
        ($($method:expr),* $(,)?) => { $( method($method); )* };
    }
    methods! {
        Euler, Heun, Rk4, DormandPrince5, Tsitouras5, Dop853, Verner9,
        ImplicitMidpoint, Gauss4, Gauss6, Radau5, Rodas4, Rodas5P,
        Verlet, PositionVerlet, BlanesMoan4, BlanesMoan6, Nystrom6, Nystrom8, Nystrom12,
        VariationalMidpoint, VariationalTrapezoid, MatrixExponential, Projection(Rk4), Taylor::of_order(12), LongTaylor::with_order(30),
        Compose(Verlet, TripleJump), Compose(Verlet, Suzuki4), Compose(Verlet, Yoshida6), Compose(Verlet, KahanLi6),
        Compose(Verlet, SuzukiUmeno8), Compose(Verlet, KahanLi8), Compose(Verlet, HairerLubichWanner10),
    }
    comes_back(FixedStep::new(0.1));
    comes_back(PiController::tolerance(1e-9));
    comes_back(PidController::h312b(PiController::tolerance(1e-9)));
    comes_back(TaylorController::tolerance(1e-9));
}

fn refusal<T: DeserializeOwned>(json: &str) -> String {
    serde_json::from_str::<T>(json).err().expect("an error").to_string()
}

#[test]
fn data_of_others_are_refused() {
    let stepper = Stepper::new(Motors::new(1.0, 0.7), Rk4, FixedStep::new(0.01), START);
    let saved = serde_json::to_string(&stepper).unwrap();
    let of_springs = refusal::<Stepper<Springs, Rk4, FixedStep, 2>>(&saved);
    assert!(of_springs.contains("expected the system `Springs`, found the system `Motors`"), "{of_springs}");
    let by_heun = refusal::<Stepper<Motors, Heun, FixedStep, 2>>(&saved);
    assert!(by_heun.contains("expected the method `Heun`, found the method `Rk4`"), "{by_heun}");
    let motors = serde_json::to_string(&Motors::new(1.0, 0.7)).unwrap();
    assert!(refusal::<Springs>(&motors).contains("expected the system `Springs`, found the system `Motors`"));
    assert!(refusal::<Motors>(&motors.replace("m1", "m3")).contains("unknown field `m3`"));
    assert!(refusal::<Motors>(&motors.replace("\"m1\":1.0,", "")).contains("missing field `m1`"));
    let twice = motors.replace("\"m1\":1.0", "\"m1\":1.0,\"m1\":2.0");
    assert!(refusal::<Motors>(&twice).contains("duplicate field `m1`"));
    let one = serde_json::to_string(&State::new(0.0, [1.0], [0.0])).unwrap();
    assert!(!refusal::<State<f64, 2>>(&one).is_empty());
}

/// A stepper with controllers is saved without them, and goes on with them bit for bit, wherever it was saved and
/// whatever origin their instants have.
#[test]
fn sampled_control_goes_on_by_its_origin() {
    let motors = || Motors::new(1.0, 0.7);
    for origin in [0.0, -60.0, 1.0e3] {
        let start = State { t: origin, ..START };
        let at = |k: u32| f64::from(k).mul_add(0.01, origin);
        for (saved_at, end) in [(at(37), at(90)), (at(37) + 0.003, at(90)), (at(100), at(101))] {
            // One law adds up, so that a call more or less is seen; the other one acts at its own instants.
            let slow = |at: &State<f64, 2>, u: &mut SVector<f64, 1>| u[0] -= 0.2 * at.qd[0];
            let fast = |at: &State<f64, 2>, u: &mut SVector<f64, 1>| u[0] += 0.01 * at.q[1].sin();
            let mut whole = Stepper::new(motors(), Dop853, PiController::tolerance(1e-9), start)
                .every(0.1, slow)
                .every(0.01, fast);
            whole.advance_to(saved_at).unwrap();
            let saved = serde_json::to_string(&whole).unwrap();
            let plain: Stepper<Motors, Dop853, PiController, 2> = serde_json::from_str(&saved).unwrap();
            let mut restored = plain.every_from(origin, 0.1, slow).every_from(origin, 0.01, fast);
            whole.advance_to(end).unwrap();
            restored.advance_to(end).unwrap();
            assert_eq!(whole.state(), restored.state(), "{origin} {saved_at}");
            assert_eq!(whole.inputs(), restored.inputs());
        }
        // At its origin, and before it, nothing is past.
        for t in [origin, origin - 0.05] {
            let plant = Stepper::new(motors(), Rk4, FixedStep::new(0.01), State { t, ..START });
            let mut plant =
                plant.every_from(origin, 0.1, |at: &State<f64, 2>, u: &mut SVector<f64, 1>| u[0] = at.t);
            plant.advance_to(origin).unwrap();
            assert_eq!(plant.inputs()[0], origin);
        }
    }
    let plant = Stepper::new(motors(), Rk4, FixedStep::new(0.01), START);
    let mut plant = plant.every_from(f64::NAN, 0.1, |_: &State<f64, 2>, _: &mut SVector<f64, 1>| ());
    assert!(matches!(plant.advance_to(1.0), Err(Failure::BadPeriod { .. })));
}
