//! Compiled code against the interpreter of the graph: two semantics of one program, at reproducible states.

// Potentials of these systems jump, which makes no difference at a state.
#![allow(deprecated)]

// Part of the programs that random systems are compiled to, which are seldom made: here it is compiled always.
#[allow(dead_code, unused_imports, clippy::all)]
#[path = "../lagrange-macros/src/differential/harness.rs"]
mod harness;

use lagrange_runtime::lanes::Lanes;
use lagrange_runtime::prelude::*;

macro_rules! interpreted {
    ($($definition:tt)*) => {
        lagrange_runtime::__private::lagrangian! { @interpreted [lagrange_runtime::__private] $($definition)* }
    };
}

/// A function, and its values at some state as they are interpreted and compiled.
type Row = (&'static str, Vec<f64>, Vec<f64>);

fn compare(system: &str, rows: &[Row]) {
    assert!(rows.len() > 50, "{system}");
    for (function, expected, found) in rows {
        let scale = expected.iter().fold(1.0f64, |largest, x| largest.max(x.abs()));
        assert_eq!(found.len(), expected.len(), "{system}: {function}");
        for (found, expected) in found.iter().zip(expected) {
            // The same operations in the same order; a target with fused operations rounds some of them once less.
            let error = (found - expected).abs();
            assert!(error <= 1e-13 * scale, "{system}: {function} is {found}, should be {expected}");
        }
    }
}

macro_rules! systems {
    ($($name:ident<$n:literal> { $($definition:tt)* })*) => {$(
        #[allow(non_snake_case)]
        #[test]
        fn $name() {
            interpreted! { pub system $name { $($definition)* } }
            compare(stringify!($name), &$name::interpreted());
            assert_eq!(<$name as Lagrangian<$n>>::FACTS.coordinates.len(), $n);
        }
    )*};
}

/// A number without a value has none between bounds, over all scalars; the slope at the upper bound is that below it.
#[test]
fn clamp_keeps_what_is_not_a_number() {
    lagrangian! {
        system Limited {
            coord x;
            T = 0.5 * dot(x).powi(2);
            V = 0;
            Q[x] = sqrt(x).clamp(-1, 1);
        }
    }
    fn force<S: Scalar>(x: S) -> S {
        Limited::default().accel(&SVector::from([x]), &SVector::from([S::zero()]), S::zero())[0]
    }
    for (x, expected, slope) in
        [(-1.0, f64::NAN, f64::NAN), (0.25, 0.5, 1.0), (1.0, 1.0, 0.5), (4.0, 1.0, 0.0)]
    {
        let dual = force(Dual::variable(x));
        let lanes = force(Lanes::<4>::splat(x)).to_array();
        for (found, expected) in [
            (force(x), expected),
            (dual.value, expected),
            (dual.slope, slope),
            (force(DoubleDouble::from(x)).value(), expected),
            (lanes[0], expected),
            (lanes[3], expected),
        ] {
            assert!(found == expected || found.is_nan() && expected.is_nan(), "{x}: {found} {expected}");
        }
    }
}

/// A matrix is written by its rows.
#[test]
fn matrices_that_are_observed() {
    lagrangian! {
        system Turning {
            param m: [3] = [1, 2, 3];
            coord a, b;
            T = 0.5 * dot(a).powi(2) + 0.5 * dot(b).powi(2);
            V = a * b;
            let rows = [[cos(a), -sin(a), b], [sin(a), cos(a), t]];
            observe placed = [[cos(a), -sin(a), b], [sin(a), cos(a), t]];
            observe rows;
            observe products = m.map(|x| [x * a, x * b]);
            observe column = [[a], [b]];
        }
    }
    let turning = Turning::default();
    let (q, qd) = (SVector::from([0.3, 0.7]), SVector::zeros());
    let placed: SMatrix<f64, 2, 3> = turning.placed(&q, &qd, 0.5);
    let (sin, cos) = 0.3f64.sin_cos();
    assert_eq!(placed, SMatrix::from([[cos, sin], [-sin, cos], [0.7, 0.5]]));
    assert_eq!(turning.rows(&q, &qd, 0.5), placed);
    let products: SMatrix<f64, 3, 2> = turning.products(&q, &qd, 0.0);
    assert!((0..3).all(|i| (0..2).all(|j| products[(i, j)] == (i + 1) as f64 * q[j])), "{products}");
    assert_eq!(turning.column(&q, &qd, 0.0), q);
}

systems! {
    Placed<2> {
        param l = 0.4;
        coord a, b;
        T = 0.5 * (l * dot(a)).powi(2) + 0.5 * dot(b).powi(2);
        V = cos(a) * b.powi(2);
        observe placed = [[cos(a), -sin(a), l * dot(b)], [sin(a), cos(a), t]];
    }
    Pendulum<1> {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
    }
    DoublePendulum<2> {
        param m: [2], l: [2], g = 9.81;
        coord th: [2];
        let x: [2] = |i| (0..i + 1).map(|j| l[j] * th[j].sin()).sum();
        let y: [2] = |i| -(0..i + 1).map(|j| l[j] * th[j].cos()).sum();
        T = (0..2).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..2).map(|i| m[i] * g * y[i]).sum();
    }
    Top<3> {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2))
            + 0.5 * I3 * (dot(psi) + dot(phi) * theta.cos()).powi(2);
        V = m * g * l * theta.cos();
    }
    Driven<2> {
        param m, k, c, a, omega;
        coord x, y;
        coord wall = a * sin(omega * t);
        fn soft(s) = k * s * s / (1 + s * s).sqrt();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.1 * (x * y).powi(2) * dot(x) * dot(y);
        V = soft(x - wall) + if x < y { (y - x).powi(4) } else { (x - y).exp() } + x.atan2(y) + x.hypot(y).ln();
        D = 0.5 * c * dot(x).powi(2);
        Q[y] = -c * dot(y) * dot(y).abs();
        force [a * t, x.tanh()] at [x * y, y.powf(1.5)];
    }
    Chain<5> {
        const N = 5;
        param m, l, g = 9.81;
        coord th: [N];
        let x: [N] = |i| (if i == 0 { 0 } else { x[i - 1] }) + l * th[i].sin();
        let y: [N] = |i| (if i == 0 { 0 } else { y[i - 1] }) - l * th[i].cos();
        T = (0..N).map(|i| 0.5 * m * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| m * g * y[i]).sum();
    }
    Rods<4> {
        param m, l, a, omega, g = 9.81;
        coord x: [2], y: [2];
        coord pivot = a * cos(omega * t);
        T = 0.5 * m * (0..2).map(|i| dot(x[i]).powi(2) + dot(y[i]).powi(2)).sum();
        V = m * g * y.sum();
        constraint upper: x[0].powi(2) + (y[0] - pivot).powi(2) == l * l;
        constraint lower: (x[1] - x[0]).powi(2) + (y[1] - y[0]).powi(2) == l * l;
    }
    Skate<3> {
        param m, I, g = 9.81;
        coord x, y, phi;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * I * dot(phi).powi(2);
        V = -m * g * x;
        constraint blade: dot(x) * phi.sin() == dot(y) * phi.cos();
    }
}
