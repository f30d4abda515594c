//! Texts of runs that fail, and impacts of mechanisms.

use lagrange_runtime::failure::Part;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A sliding block with a rod hinged to it, whose tip meets walls.
    pub system Cart {
        param m = 2, rod = 1.5, l = 0.8, g = 9.81;
        coord x: length, theta: angle;
        let tip = [x + l * sin(theta), -l * cos(theta)];
        let middle = [x + 0.5 * l * sin(theta), -0.5 * l * cos(theta)];
        T = 0.5 * m * dot(x).powi(2)
            + 0.5 * rod * (dot(middle[0]).powi(2) + dot(middle[1]).powi(2))
            + rod * l.powi(2) / 24 * dot(theta).powi(2);
        V = rod * g * middle[1];
        impulse blow at tip;
        observe speed = [dot(tip[0]), dot(tip[1])];
    }
}

lagrangian! {
    /// The same by more coordinates than it has freedoms.
    pub system Held {
        param m = 2, rod = 1.5, l = 0.8, g = 9.81;
        coord x: length, a: length, b: length, theta: angle;
        T = 0.5 * m * dot(x).powi(2)
            + 0.5 * rod * (dot(a).powi(2) + dot(b).powi(2))
            + rod * l.powi(2) / 24 * dot(theta).powi(2);
        V = rod * g * b;
        constraint across: a == x + 0.5 * l * sin(theta);
        constraint upward: b == -0.5 * l * cos(theta);
        impulse blow at [a + 0.5 * l * sin(theta), b - 0.5 * l * cos(theta)];
    }
}

/// The velocity of the point along the normal is reversed, by an impulse along the normal; the energy falls by
/// `(1 − e²)/2` times the square of that velocity over `n·M⁻¹ n`.
#[test]
fn points_rebound() {
    let (cart, held) = (Cart::default(), Held::default());
    for k in 0..200 {
        let u = f64::from(k);
        let (angle, restitution) = (0.031 * u, f64::from(k % 5) * 0.25);
        let at = State::new(1.0, [0.3, 0.017 * u], [1.0 - 0.013 * u, 0.7 * (0.3 * u).sin()]);
        let normal = SVector::from([angle.cos(), angle.sin()]);
        let n = cart.blow(&at.q, at.t, &normal);
        let jump = cart.rebound(&at, &n, restitution);
        let [before, after] = [at, jump.after].map(|at| cart.speed_at(&at).dot(&normal));
        assert!((after + restitution * before).abs() < 1e-13, "{k}: {before} {after}");
        let impulse = cart.inertia_at(&at) * (jump.after.qd - at.qd);
        let along = impulse.dot(&n) / n.norm_squared();
        assert!((impulse - n * along).norm() < 1e-13, "{k}");
        let compliance = n.dot(&(cart.inertia_at(&at).try_inverse().unwrap() * n));
        let lost = 0.5 * (1.0 - restitution * restitution) * before * before / compliance;
        assert!((jump.energy + lost).abs() < 1e-12 * (1.0 + lost), "{k}: {} {lost}", jump.energy);
        // Under constraints.
        let [theta, rate] = [at.q[1], at.qd[1]];
        let full = State::new(
            1.0,
            [0.3, 0.3 + 0.4 * theta.sin(), -0.4 * theta.cos(), theta],
            [at.qd[0], at.qd[0] + 0.4 * theta.cos() * rate, 0.4 * theta.sin() * rate, rate],
        );
        let n = held.blow(&full.q, full.t, &normal);
        let other = held.rebound(&full, &n, restitution).after;
        let apart = (other.qd[0] - jump.after.qd[0]).abs().max((other.qd[3] - jump.after.qd[1]).abs());
        assert!(apart < 1e-12, "{k}: {apart:e}");
    }
}

/// A parameter that is not a number is told as such, at once.
#[test]
fn parameters_that_are_not_numbers() {
    let start = State::new(0.5, [0.0, 0.3], [0.0, 0.0]);
    let rod = Cart { rod: f64::NAN, ..Cart::default() };
    let g = Cart { g: f64::INFINITY, ..Cart::default() };
    for (cart, coordinate) in [(rod, "x"), (g, "theta")] {
        macro_rules! refused {
            ($($method:expr, $controller:expr);*) => {$(
                let failed = integrate(&cart, $method, $controller, start).until(2.0).final_state().unwrap_err();
                let Failure::StateNotFinite { t, part: Part::Equation(named) } = failed.failure else {
                    panic!("{}: {failed}", stringify!($method));
                };
                assert_eq!((t, named.name), (0.5, coordinate), "{}: {failed}", stringify!($method));
            )*};
        }
        refused!(
            Dop853, PiController::tolerance(1e-9);
            DormandPrince5, PiController::tolerance(1e-9);
            Rodas5P, PiController::tolerance(1e-9);
            Radau5, PiController::tolerance(1e-9);
            Rk4, FixedStep::new(0.1)
        );
    }
}

/// A state that is not a number is told by its coordinate, also where it comes of another time.
#[test]
fn states_that_are_not_numbers() {
    let cart = Cart::default();
    let start = State::new(0.5, [0.0, 0.3], [0.0, 0.0]);
    let told = |start: State<f64, 2>| {
        let run = integrate(&cart, Dop853, PiController::tolerance(1e-9), start).until(2.0);
        let failure = run.final_state().unwrap_err().failure;
        let mut stepper = Stepper::new(cart, Dop853, PiController::tolerance(1e-9), cart_at_rest());
        assert_eq!(format!("{:?}", stepper.set_state(start).unwrap_err()), format!("{failure:?}"));
        failure.to_string()
    };
    let mut bad = start;
    bad.q[1] = f64::NAN;
    assert!(told(bad).starts_with("at t = 0.5 coordinate `theta` of the state is infinite or not a number"));
    bad = start;
    bad.qd[0] = f64::INFINITY;
    assert!(told(bad).starts_with("at t = 0.5 the velocity of coordinate `x`"));
    assert!(told(State { t: f64::NAN, ..start }).starts_with("the time of a state"));
}

/// A start of the cart.
fn cart_at_rest() -> State<f64, 2> {
    State::new(0.0, [0.0; 2], [0.0; 2])
}

/// `main` prints the debug form of an error that it returns.
#[test]
fn errors_print_their_text() {
    let start = State::new(0.0, [0.0, 0.3], [0.0, 0.0]);
    let endless = integrate(&Cart::default(), Dop853, PiController::tolerance(1e-9), start).final_state();
    let failed = endless.unwrap_err();
    assert_eq!(format!("{:?}", failed.failure), format!("BadEnd: {}", failed.failure));
    assert!(
        format!("{failed:?}").starts_with("BadEnd: this run has no end; give a time to `until`"),
        "{failed:?}"
    );
    let returned: Box<dyn std::error::Error> = failed.into();
    assert_eq!(format!("{returned:?}"), format!("{failed:?}"));
}

lagrangian! {
    system Carriage {
        input force;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = force;
    }
}

/// A million samples use no budget up: that of a call is the number that is given, and the default is for the time
/// between two samples.
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn samples_are_no_sign_of_stiffness() {
    let start = State::new(0.0, [1.0], [0.0]);
    let carriage = || {
        Stepper::new(Carriage::default(), DormandPrince5, PiController::tolerance(1e-6), start)
            .every(1e-3, |at: &State<f64, 1>, u| u[0] = -at.q[0])
    };
    let mut controlled = carriage();
    controlled.advance_to(1100.0).unwrap();
    assert!(controlled.statistics().accepted >= 1_100_000);
    // From sample to sample q and q̇ go by the matrix (1 − T²/2, T; −T, 1), whose n-th power turns and grows.
    let (period, n) = (1e-3f64, 1.1e6);
    let trace: f64 = 2.0 - 0.5 * period * period;
    let determinant = 1.0 + 0.5 * period * period;
    let turn = (0.5 * trace / determinant.sqrt()).acos();
    let (sin, cos) = (n * turn).sin_cos();
    let own = (1.0 - 0.5 * period * period - 0.5 * trace) / determinant.sqrt() / turn.sin();
    let exact = (0.5 * n * determinant.ln()).exp() * (cos + own * sin);
    assert!((controlled.state().q[0] - exact).abs() < 1e-6, "{} {exact}", controlled.state().q[0]);
    let mut limited = carriage().max_steps(500);
    let failure = limited.advance_to(1.0).unwrap_err();
    assert!(matches!(failure, Failure::BudgetUsedUp { max_steps: 500, .. }), "{failure}");
    limited.advance_to(1.0).unwrap();
    let mut asked = carriage();
    assert_eq!(asked.advance_within(1.0, 999), Ok(lagrange_runtime::Advance::NotYet));
    assert_eq!(asked.advance_within(1.0, 2), Ok(lagrange_runtime::Advance::Arrived));
}

lagrangian! {
    system Drifter {
        coord x;
        extern f: Curve(x);
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = f(x);
    }
}

/// A run that leaves a table ends at its end, x = 1 at t = 1.
#[test]
fn beyond_a_refused_table() {
    let drifter = Drifter::new(Curve::linear(&[-1.0, 1.0], &[0.0, 0.0], Beyond::Refused).unwrap());
    let start = State::new(0.0, [0.0], [1.0]);
    let run = integrate(&drifter, Dop853, PiController::tolerance(1e-9), start).until(2.0);
    let failed = run.final_state().unwrap_err();
    assert!(matches!(failed.failure, Failure::StepSizeUnderflow { .. }), "{failed}");
    assert!((failed.last.q[0] - 1.0).abs() < 1e-9, "{failed}");
    assert!(failed.to_string().contains("`Beyond::Refused`"), "{failed}");
    let run = integrate(&drifter, Rk4, FixedStep::new(0.3), start).until(2.0);
    assert!(matches!(run.final_state().unwrap_err().failure, Failure::NonFinite { .. }));
    let beyond = State::new(0.0, [1.5], [1.0]);
    let run = integrate(&drifter, Dop853, PiController::tolerance(1e-9), beyond).until(2.0);
    let failure = run.final_state().unwrap_err().failure;
    assert!(matches!(failure, Failure::StateNotFinite { part: Part::Equation(_), .. }), "{failure}");
}
