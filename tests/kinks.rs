//! States without a linear model: kinks of functions with data, of Rust functions and of outputs, and models that
//! hold at an instant alone.

use lagrange_runtime::analysis::{
    AnalysisError, SmallMotion, StateSpace, equilibria, equilibrium, operating_point, small_vibrations,
};
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A weight on a measured spring at a wall, with a state beside it.
    system Buffer {
        param m = 2.0;
        input u;
        coord x;
        extern f: Curve(x);
        T = 0.5 * m * dot(x).powi(2);
        V = 0;
        Q[x] = f(x) + u;
    }
}

lagrangian! {
    /// The same spring, whose force follows with a lag.
    system Lagging {
        coord x;
        state s;
        extern f: Curve(s);
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = s;
        rate(s) = f(s);
    }
}

lagrangian! {
    /// Forces of a measured damper and a map of position and velocity.
    system Damped {
        coord x;
        extern damper: Curve(v);
        extern map: Surface(a, v);
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = damper(dot(x)) + map(x, dot(x));
    }
}

/// A spring that is stiff on one side.
fn one_sided<S: Scalar>(x: S) -> S {
    x + x.abs()
}

lagrangian! {
    system Foreign {
        param at;
        coord x;
        extern fn one_sided(x);
        T = 0.5 * dot(x).powi(2);
        V = 0;
        Q[x] = -one_sided(x - at) - 3 * (x - at);
    }
}

/// The slopes −2 and −5 meet at 0.
fn bent() -> Curve {
    Curve::linear(&[-1.0, 0.0, 1.0], &[2.0, 0.0, -5.0], Beyond::Line).unwrap()
}

/// The straight line through the same knots.
fn straight() -> Curve {
    Curve::linear(&[-1.0, 0.0, 1.0], &[2.0, 0.0, -2.0], Beyond::Line).unwrap()
}

#[test]
fn a_knot_has_no_linear_model() {
    let named = |error: AnalysisError, is_velocity: bool| match error {
        AnalysisError::Kink { coordinate, velocity } => {
            assert_eq!((coordinate.name, velocity), (if is_velocity { "s" } else { "x" }, is_velocity));
        }
        other => panic!("{other}"),
    };
    let bumping = Buffer::new(bent());
    let rest = State::new(0.0, [0.0], [0.0]);
    named(StateSpace::about(&bumping, &rest).unwrap_err(), false);
    named(StateSpace::without_inputs(&bumping, &rest).unwrap_err(), false);
    named(SmallMotion::about(&bumping, &rest).unwrap_err(), false);
    named(small_vibrations(&bumping, &[0.0]).unwrap_err(), false);
    named(equilibria(&bumping, &[-0.5], &[0.5], 3).unwrap_err(), false);
    for guess in [-0.3, 0.0, 0.2, 1.5] {
        named(equilibrium(&bumping, &[guess]).unwrap_err(), false);
        named(operating_point(&bumping, &State::new(0.0, [guess], [0.0])).unwrap_err(), false);
        let lagging = Lagging::new(bent());
        named(operating_point(&lagging, &lagging.start(0.0, [0.0], [guess])).unwrap_err(), true);
    }
    // Beside the knot each side has its own stiffness, and a line through the knot has one everywhere.
    for (x, k) in [(-1e-6, 2.0), (1e-6, 5.0)] {
        let beside = StateSpace::about(&bumping, &State::new(0.0, [x], [0.0])).unwrap();
        assert_eq!(beside.a[(1, 0)], -k / 2.0);
    }
    let smooth = Buffer::new(straight());
    assert_eq!(small_vibrations(&smooth, &[0.0]).unwrap().stiffness()[0], 2.0);
    assert_eq!(StateSpace::about(&smooth, &rest).unwrap().a[(1, 0)], -1.0);
    let spline =
        Buffer::new(Curve::cubic(&[-1.0, 0.0, 1.0, 2.0], &[2.0, 0.0, -5.0, -8.0], Beyond::Line).unwrap());
    StateSpace::about(&spline, &rest).unwrap();
    let lagging = Lagging::new(straight());
    let poles = operating_point(&lagging, &lagging.start(0.0, [0.0], [0.4])).unwrap().poles;
    assert!((poles[0].re + 2.0).abs() < 1e-14, "{poles:?}");
}

#[test]
fn ends_of_tables_and_cells_of_maps_are_kinks() {
    let held = Curve::linear(&[-1.0, 1.0], &[-3.0, 3.0], Beyond::Held).unwrap();
    let refused = Curve::linear(&[-1.0, 1.0], &[-3.0, 3.0], Beyond::Refused).unwrap();
    for x in [-1.0, 1.0] {
        let at = State::new(0.0, [x], [0.3]);
        let error = StateSpace::about(&Buffer::new(held.clone()), &at).unwrap_err();
        assert!(matches!(error, AnalysisError::Kink { velocity: false, .. }), "{error}");
        // (The side that is not known says nothing.)
        assert_eq!(StateSpace::about(&Buffer::new(refused.clone()), &at).unwrap().a[(1, 0)], 1.5);
    }
    // z = x q̇ is bilinear; a corner that is higher bends it along both arguments.
    let axis = [-1.0, 0.0, 1.0];
    let mut values = [1.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0];
    let damped = |damper: Curve, values: &[f64]| {
        Damped::new(damper, Surface::linear(&axis, &axis, values, Beyond::Line).unwrap())
    };
    let about =
        |damped: &Damped, x: f64, v: f64| StateSpace::without_inputs(damped, &State::new(0.0, [x], [v]));
    let model = about(&damped(straight(), &values), 0.0, 0.0).unwrap();
    assert_eq!((model.a[(1, 0)], model.a[(1, 1)]), (-1.0, -2.0));
    let error = about(&damped(bent(), &values), 0.4, 0.0).unwrap_err();
    assert!(matches!(error, AnalysisError::Kink { velocity: true, .. }), "{error}");
    values[8] = 2.0;
    let bent_map = damped(straight(), &values);
    for (x, v, velocity) in [(0.5, 0.0, true), (0.0, 0.5, false)] {
        let error = about(&bent_map, x, v).unwrap_err();
        assert!(matches!(error, AnalysisError::Kink { velocity: found, .. } if found == velocity), "{error}");
    }
    assert_eq!(about(&bent_map, -0.5, 0.0).unwrap().a[(1, 1)], -2.5);
}

#[test]
fn a_rust_function_may_have_a_kink() {
    for at in [0.0, 0.3, -7e3] {
        let error = equilibrium(&Foreign::new(at), &[at + 0.1]).unwrap_err();
        assert!(matches!(error, AnalysisError::Kink { velocity: false, .. }), "{error}");
        let aside = State::new(0.0, [at - 0.1], [0.0]);
        assert_eq!(StateSpace::without_inputs(&Foreign::new(at), &aside).unwrap().a[(1, 0)], -3.0);
    }
}

lagrangian! {
    system Gauged {
        param m = 2.0;
        input u;
        coord x;
        extern f: Curve(x);
        T = 0.5 * m * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = u;
        observe distance = x.abs();
        observe drive = u.clamp(-1, 1);
        observe side = dot(x).signum();
        observe drag = -x.abs() * x;
        observe measured = f(x);
    }
}

#[test]
fn outputs_on_a_kink_have_no_c_and_d() {
    let at = |x, v| State::new(0.0, [x], [v]);
    let with = |u| Gauged { u, ..Gauged::new(bent()) };
    let outputs = |system: &Gauged, at: State<f64, 1>, which: usize| {
        StateSpace::about(system, &at).unwrap().observed(system, &at, |system, s| {
            let all = [
                system.distance_at(s),
                system.drive_at(s),
                system.side_at(s),
                system.drag_at(s),
                system.measured_at(s),
            ];
            [s.q[0], all[which]]
        })
    };
    let refused = Err(AnalysisError::SwitchedOutput { output: 1 });
    assert_eq!(outputs(&with(0.0), at(0.0, 1.0), 0), refused);
    assert_eq!(outputs(&with(1.0), at(0.5, 1.0), 1), refused);
    assert_eq!(outputs(&with(0.0), at(0.5, 0.0), 2), refused);
    assert_eq!(outputs(&with(0.0), at(0.0, 1.0), 4), refused);
    let rows = |found: Result<StateSpace, AnalysisError>| {
        let model = found.unwrap();
        [model.c[(1, 0)], model.c[(1, 1)], model.d[(1, 0)]]
    };
    assert_eq!(rows(outputs(&with(0.0), at(-0.5, 1.0), 0)), [-1.0, 0.0, 0.0]);
    assert_eq!(rows(outputs(&with(0.9), at(0.5, 1.0), 1)), [0.0, 0.0, 1.0]);
    assert_eq!(rows(outputs(&with(1.1), at(0.5, 1.0), 1)), [0.0, 0.0, 0.0]);
    assert_eq!(rows(outputs(&with(0.0), at(0.5, 0.1), 2)), [0.0, 0.0, 0.0]);
    // |x| x has a derivative at 0.
    assert_eq!(rows(outputs(&with(0.0), at(0.0, 1.0), 3)), [0.0, 0.0, 0.0]);
    assert_eq!(rows(outputs(&with(0.0), at(0.5, 1.0), 4)), [-5.0, 0.0, 0.0]);
}

lagrangian! {
    system Swaying {
        param k = 4.0, depth = 0.5;
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * k * (1 + depth * cos(t)) * x.powi(2);
        Q[x] = u;
    }
}

lagrangian! {
    system Loaded {
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = u + sin(3 * t);
    }
}

/// A model of one instant is not that of a period; beside a load f(t) it is.
#[test]
fn a_model_that_depends_on_time_is_not_sampled() {
    let rest = State::new(0.0, [0.0], [0.0]);
    let swaying = Swaying::default();
    let model = StateSpace::about(&swaying, &rest).unwrap();
    assert_eq!(model.clone().sampled(0.1), Err(AnalysisError::TimeDependent));
    assert_eq!(
        StateSpace::without_inputs(&swaying, &rest).unwrap().sampled(0.1),
        Err(AnalysisError::TimeDependent)
    );
    let told = AnalysisError::TimeDependent.to_string();
    assert!(
        told.contains("where a parameter multiplies that force, `pub simplified Free: neglect parameter;`"),
        "{told}"
    );
    let loaded = Loaded::default();
    let alone = StateSpace::without_inputs(&loaded, &rest).unwrap().sampled(0.3).unwrap();
    let model = StateSpace::about(&loaded, &rest).unwrap();
    assert_eq!(model.clone().sampled(0.3), Err(AnalysisError::TimeDependent));
    let told = StateSpace { time_dependent: false, ..model }.sampled(0.3).unwrap();
    for sampled in [alone, told] {
        assert!((sampled.a[(0, 0)] - 0.3f64.cos()).abs() < 1e-15);
    }
}
