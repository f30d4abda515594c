use super::*;
use crate::prelude::*;
use crate::traits::InputJacobian;
use crate::traits::{Linearize, dual_jacobian};

const X: [f64; 6] = [0.0, 0.7, 1.1, 2.5, 3.0, 4.6];
const Y: [f64; 6] = [1.0, 4.0, 2.5, -3.0, -3.5, 0.5];

/// Arguments of the digits below.
const AT: [f64; 8] = [0.0, 0.35, 0.7, 0.9, 1.7, 2.75, 3.9, 4.6];

/// Value and the first two derivatives.
fn derivatives(curve: &Curve, x: f64) -> [f64; 3] {
    let first = Dual::variable(Dual::variable(x));
    let y = curve.value([first]);
    assert_eq!(y.value.slope, y.slope.value);
    [y.value.value, y.slope.value, y.slope.slope]
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 2e-14 * expected.abs().max(1.0), "{found:?} {expected:?}");
}

fn agree(curve: &Curve, expected: [[f64; 8]; 3]) {
    for (i, x) in AT.into_iter().enumerate() {
        for (k, found) in derivatives(curve, x).into_iter().enumerate() {
            close(found, expected[k][i]);
        }
    }
}

/// Digits of `scipy.interpolate.CubicSpline` of SciPy 1, which solves the same equations by LAPACK.
#[test]
fn splines_have_the_digits_of_scipy() {
    let expected = [
        [
            1.0,
            3.821286852001253,
            4.0,
            3.3751284171750187,
            -0.27137208075798114,
            -3.3774471281863567,
            -2.122414122721154,
            0.5,
        ],
        [
            12.972992837551637,
            3.7171803012277613,
            -2.12742832817698,
            -3.935643750036413,
            -4.390734553137645,
            -0.9874159667461135,
            2.9038039195550986,
            4.490149038937733,
        ],
        [
            -31.31832711366697,
            -21.57203023675517,
            -11.825733359843388,
            -6.256420858750942,
            1.4846487527908667,
            4.078308101963412,
            2.6890308307343482,
            1.8433837960731796,
        ],
    ];
    agree(&Curve::cubic(&X, &Y, Beyond::Refused).expect("a table"), expected);
    let three = Curve::cubic(&X[..3], &Y[..3], Beyond::Refused).expect("a table");
    for (x, y) in [(0.3, 3.162337662337662), (1.0, 3.0941558441558445)] {
        close(three.value([x]), y);
    }
}

/// Digits of `scipy.interpolate.PchipInterpolator`.
#[test]
fn monotone_cubics_have_the_digits_of_scipy() {
    let expected = [
        [
            1.0,
            3.3224431818181817,
            4.0,
            3.441037735849057,
            -0.19912142867500043,
            -3.3410913528591353,
            -2.2712890624999997,
            0.5,
        ],
        [
            9.399350649350648,
            4.078733766233766,
            0.0,
            -4.669811320754715,
            -4.702636335410232,
            -1.135634588563459,
            2.7832031250000013,
            5.166666666666667,
        ],
        [
            -16.975881261595543,
            -13.427643784786643,
            -37.14622641509431,
            -9.551886792452823,
            0.8985991852447017,
            2.914923291492329,
            3.268229166666668,
            3.541666666666667,
        ],
    ];
    agree(&Curve::monotone(&X, &Y, Beyond::Refused).expect("a table"), expected);
    let three = Curve::monotone(&X[..3], &Y[..3], Beyond::Refused).expect("a table");
    for (x, y) in [(0.3, 3.1015107341637953), (1.0, 3.1096793831168834)] {
        close(three.value([x]), y);
    }
    // An end whose parabola falls where the data rise, and one whose slope is limited.
    let ends = Curve::monotone(&[0.0, 1.0, 1.5, 4.0, 5.0], &[0.0, 0.1, 5.0, 5.1, 5.0], Beyond::Refused)
        .expect("a table");
    let y = [0.0032906801007556684, 0.06116272040302269, 1.835890291905396, 5.043104519119351, 5.0675];
    for (x, y) in [0.2, 0.8, 1.2, 2.0, 4.5].into_iter().zip(y) {
        close(ends.value([x]), y);
    }
    assert_eq!(derivatives(&ends, 0.0)[1], 0.0);
    close(derivatives(&ends, 5.0)[1], -0.14);
}

/// A cubic is its own spline, in every digit that its values have.
#[test]
fn splines_meet_cubics_exactly() {
    let f = |x: f64| 2.0 - x * (1.5 - x * (0.25 + 0.5 * x));
    let x: Vec<f64> = (0..20).map(|i| f64::from(i) * 0.37 - 2.0).collect();
    let y: Vec<f64> = x.iter().map(|x| f(*x)).collect();
    let spline = Curve::cubic(&x, &y, Beyond::Line).expect("a table");
    for i in 0..100 {
        let at = -2.0 + 0.07 * f64::from(i);
        let [value, slope, curvature] = derivatives(&spline, at);
        close(value, f(at));
        assert!((slope - (-1.5 + at * (0.5 + 1.5 * at))).abs() < 1e-12);
        assert!((curvature - (0.5 + 3.0 * at)).abs() < 1e-10, "{at}");
    }
}

#[test]
fn values_beyond_the_knots_are_as_chosen() {
    for rule in [Curve::linear, Curve::monotone, Curve::cubic] {
        let of = |beyond| rule(&X, &Y, beyond).expect("a table");
        let [held, line, refused] = [Beyond::Held, Beyond::Line, Beyond::Refused].map(of);
        for (knot, outside, y) in [(0.0, -1.5, 1.0), (4.6, 6.1, 0.5)] {
            let slope = derivatives(&line, knot)[1];
            assert_eq!(derivatives(&held, outside), [y, 0.0, 0.0]);
            close(derivatives(&line, outside)[0], y + slope * (outside - knot));
            close(derivatives(&line, outside)[1], slope);
            assert_eq!(derivatives(&line, outside)[2], 0.0);
            assert!(refused.value([outside]).is_nan());
            close(refused.value([knot]), y);
        }
        assert!(held.value([f64::NAN]).is_nan());
    }
}

#[test]
fn data_that_are_no_table_are_refused() {
    let cubic = |x: &[f64], y: &[f64]| Curve::cubic(x, y, Beyond::Held).expect_err("no table");
    assert_eq!(cubic(&[], &[]), InvalidTable::TooShort { knots: 0 });
    assert_eq!(cubic(&[1.0], &[1.0]), InvalidTable::TooShort { knots: 1 });
    assert_eq!(cubic(&[0.0, 1.0], &[1.0]), InvalidTable::Lengths { expected: 2, found: 1 });
    assert_eq!(cubic(&[0.0, 1.0, 1.0], &[0.0; 3]), InvalidTable::Knot { index: 2 });
    assert_eq!(cubic(&[0.0, 2.0, 1.0], &[0.0; 3]), InvalidTable::Knot { index: 2 });
    assert_eq!(cubic(&[0.0, f64::NAN, 1.0], &[0.0; 3]), InvalidTable::Knot { index: 1 });
    assert_eq!(cubic(&[0.0, f64::INFINITY], &[0.0; 2]), InvalidTable::Knot { index: 1 });
    assert_eq!(cubic(&[0.0, 1.0], &[0.0, f64::NAN]), InvalidTable::Value { index: 1 });
    let surface =
        |x: &[f64], y: &[f64], z: &[f64]| Surface::linear(x, y, z, Beyond::Held).expect_err("no table");
    assert_eq!(surface(&[0.0, 1.0], &[0.0], &[0.0; 2]), InvalidTable::TooShort { knots: 1 });
    assert_eq!(surface(&[0.0, 1.0], &[1.0, 0.0], &[0.0; 4]), InvalidTable::Knot { index: 1 });
    assert_eq!(surface(&[0.0, 1.0], &[0.0, 1.0], &[0.0; 3]), InvalidTable::Lengths { expected: 4, found: 3 });
}

/// Digits of `CubicSpline` along each axis, which are those of `RectBivariateSpline(s=0)`.
#[test]
fn surfaces_have_the_digits_of_scipy() {
    let z = [
        [-2.49, -1.58, 1.81, 0.49, -2.44],
        [-0.4, -0.13, -2.04, 1.41, -2.32],
        [-0.65, 0.1, -0.42, 0.52, 1.43],
        [2.74, -1.29, 0.89, 1.18, -1.24],
        [-2.99, 2.84, -1.21, -1.12, 2.35],
        [0.51, -0.17, 1.64, -2.82, 1.24],
    ];
    let surface =
        Surface::cubic(&X, &[-1.0, 0.0, 0.5, 2.0, 2.2], z.as_flattened(), Beyond::Refused).expect("a table");
    let expected = [
        ([0.35, -0.5], [1.77087686719427, 7.584300673693153, -2.6873415171771304, -2.7614315011330337]),
        ([0.9, 0.2], [-0.634745550962145, 3.2630597071475673, -3.4326877584480533, 10.377504647758956]),
        ([2.75, 1.3], [0.10155824034780903, -19.75956579491886, 0.5760126453210106, -3.376756383386133]),
        ([4.6, 2.2], [1.24, -27.228178009182393, 25.995656993464053, -222.9461465242896]),
    ];
    for ([x, y], [value, by_x, by_y, mixed]) in expected {
        let found = surface.value([Dual::variable(Dual::constant(x)), Dual::constant(Dual::variable(y))]);
        for (found, expected) in [
            (found.value.value, value),
            (found.slope.value, by_x),
            (found.value.slope, by_y),
            (found.slope.slope, mixed),
        ] {
            let expected: f64 = expected;
            assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0), "{found:?} {expected:?}");
        }
    }
}

lagrangian! {
    /// A cart driven by a motor whose torque depends on its speed and its voltage, in a wind.
    system Cart {
        param m, c;
        input u;
        coord x, y;
        extern wind: Curve(t);
        extern torque: Surface(speed, voltage);
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0.5 * (x - y).powi(2);
        Q[x] = torque(dot(x), u);
        Q[y] = c * (wind(t) - dot(y)) + 0.1 * wind(x * y);
        observe blown = wind(t);
    }
}

fn torque() -> Surface {
    let (x, y) = ([-2.0, 0.0, 1.0, 2.5], [0.0, 1.0, 2.0]);
    let z: Vec<f64> = x.iter().flat_map(|x| y.map(|y| y * (1.0 - 0.3 * x) - 0.1 * x * x * y * y)).collect();
    Surface::cubic(&x, &y, &z, Beyond::Line).expect("a table")
}

fn cart() -> Cart {
    let wind = Curve::cubic(&X, &Y, Beyond::Held).expect("a table");
    Cart { u: 0.7, ..Cart::new(2.0, 0.3, wind, torque()) }
}

/// The emitted derivatives are those of duals, and of differences of the table itself.
#[test]
fn derivatives_of_systems_with_tables_are_exact() {
    let (cart, q, qd, t) = (cart(), SVector::from([0.8, 1.1]), SVector::from([0.4, -0.2]), 1.9);
    let wind = derivatives(&cart.wind, t)[0];
    assert_eq!(cart.blown(&q, &qd, t), wind);
    let jacobian = cart.jacobian(&q, &qd, t);
    let dual = dual_jacobian(&cart.clone().map(Dual::constant), &q, &qd, t);
    for (emitted, dual) in [(jacobian.q, dual.q), (jacobian.qd, dual.qd)] {
        assert!((emitted - dual).abs().max() < 1e-14, "{emitted} {dual}");
    }
    let by_speed = cart.torque.value([Dual::variable(qd[0]), Dual::constant(cart.u)]);
    close(jacobian.qd[(0, 0)], by_speed.slope / cart.m);
    let by_voltage = cart.torque.value([Dual::constant(qd[0]), Dual::variable(cart.u)]);
    close(cart.input_jacobian(&q, &qd, t)[(0, 0)], by_voltage.slope / cart.m);
    let by_place = derivatives(&cart.wind, q[0] * q[1])[1];
    close(jacobian.q[(1, 0)], (1.0 + 0.1 * by_place * q[1]) / cart.m);
    let linear = cart.linearize(&q, &qd, t);
    close(linear.damping[(0, 0)], -by_speed.slope);
    #[cfg(feature = "analysis")]
    {
        let model = crate::analysis::StateSpace::about(&cart, &State { t, q, qd }).expect("a model");
        close(model.b[(2, 0)], by_voltage.slope / cart.m);
    }
}

/// A spline through a cubic is the cubic: the motion has a closed form.
#[test]
fn motions_through_tables_are_those_of_their_formulas() {
    lagrangian! {
        system Pushed {
            param m;
            coord x;
            extern push: Curve(t);
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = push(t);
        }
    }
    let t: Vec<f64> = (0..=8).map(f64::from).collect();
    let y: Vec<f64> = t.iter().map(|t| t * t * t - 9.0 * t * t).collect();
    let push = Curve::cubic(&t, &y, Beyond::Refused).expect("a table");
    let pushed = Pushed::new(2.0, push);
    let start = State::new(0.0, [0.0], [0.0]);
    let x = |t: f64| (t.powi(5) / 20.0 - 0.75 * t.powi(4)) / 2.0;
    let end = integrate(&pushed, Dop853, PiController::tolerance(1e-12), start).until(8.0).final_state();
    assert!((end.expect("a motion").q[0] - x(8.0)).abs() < 1e-9);
    let end = integrate(&pushed, Rk4, FixedStep::new(0.5), start).until(8.0).final_state();
    assert!((end.expect("a motion").q[0] - x(8.0)).abs() < 1e-2);
    // Beyond the table there is no motion.
    let refused = integrate(&pushed, Dop853, PiController::tolerance(1e-12), start).until(8.5).final_state();
    assert!(refused.is_err(), "{refused:?}");
}

lagrangian! {
    /// A top in a field that was measured: its ignorable angle can be removed, and a coordinate held.
    system Planet {
        param m;
        coord r, phi: angle;
        extern field: Curve(r);
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = m * field(r);
        routhian Radial;
        restriction Falling: phi = 0;
    }
}

#[test]
fn derived_systems_have_the_data() {
    let r: Vec<f64> = (1..40).map(|i| 0.1 * f64::from(i)).collect();
    let field: Vec<f64> = r.iter().map(|r| -1.0 / r).collect();
    let planet = Planet::new(1.5, Curve::cubic(&r, &field, Beyond::Refused).expect("a table"));
    let start = State::new(0.0, [1.0, 0.3], [0.1, 1.1]);
    let whole = integrate(&planet, Dop853, PiController::tolerance(1e-11), start).until(5.0).final_state();
    let (radial, reduced) = planet.reduce(&start);
    let left = integrate(&radial, Dop853, PiController::tolerance(1e-11), reduced).until(5.0).final_state();
    let (whole, left) = (whole.expect("a motion"), left.expect("a motion"));
    assert!((whole.q[0] - left.q[0]).abs() < 1e-8);
    let energy = planet.energy(&start.q, &start.qd, 0.0);
    assert!((planet.energy(&whole.q, &whole.qd, 5.0) - energy).abs() < 1e-8);
    let falling = <Falling as Restricted<1, 1, 2>>::of(&planet);
    assert_eq!(falling.field, planet.field);
}

#[test]
fn scalars_of_more_and_fewer_digits_read_tables() {
    let spline = Curve::cubic(&X, &Y, Beyond::Held).expect("a table");
    let third = DoubleDouble::from(1.0) / DoubleDouble::from(3.0);
    assert!((spline.value([third]).to_f64() - spline.value([1.0 / 3.0])).abs() < 1e-15);
    assert!((spline.value([0.35f32]) - 3.821_287).abs() < 1e-5);
    let gradient = spline.value([Gradient::<f64, 2> { value: 0.35, slopes: [0.0, 1.0] }]);
    assert_eq!(gradient.slopes, [0.0, derivatives(&spline, 0.35)[1]]);
}

#[cfg(feature = "serde")]
#[test]
fn systems_with_tables_are_saved_and_restored() {
    let cart = cart();
    let text = serde_json::to_string(&cart).expect("text");
    assert_eq!(serde_json::from_str::<Cart>(&text).expect("a system"), cart);
    let error = serde_json::from_str::<Cart>(&text.replace("0.7,1.1", "0.7,0.7")).expect_err("no table");
    assert!(error.to_string().contains("knot 2 of a table"), "{error}");
    let error =
        serde_json::from_str::<Cart>(&text[..text.find(",\"data\"").expect("data")]).expect_err("no data");
    assert!(error.to_string().contains("EOF"), "{error}");
}
