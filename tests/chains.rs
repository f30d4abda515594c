//! Chains and trees of 32 links, eliminated in linear time, against accelerations of 50 digits: errors relative to the
//! largest acceleration.

use lagrange_runtime::prelude::*;
use nalgebra::SVector;
use serde_json::Value;

/// A system of links with unit masses and lengths, and one with parameters for them.
macro_rules! links {
    ($unit:ident, $symbolic:ident, [$($cart:tt)*], $base:tt, $energy:tt, $parent:tt, $angle:tt) => {
        lagrangian! {
            pub system $unit {
                const N = 32;
                $($cart)*
                coord theta: [N];
                let phi: [N] = |i| $angle;
                let x: [N] = |i| if i == 0 { $base } else { x[$parent] } + phi[i].sin();
                let y: [N] = |i| if i == 0 { 0 } else { y[$parent] } - phi[i].cos();
                T = $energy + (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                V = (0..N).map(|i| 9.81 * y[i]).sum();
            }
        }
        lagrangian! {
            pub system $symbolic {
                const N = 32;
                param m: [N], l: [N], g = 9.81;
                $($cart)*
                coord theta: [N];
                let phi: [N] = |i| $angle;
                let x: [N] = |i| if i == 0 { $base } else { x[$parent] } + l[i] * phi[i].sin();
                let y: [N] = |i| if i == 0 { 0 } else { y[$parent] } - l[i] * phi[i].cos();
                T = $energy + (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                V = (0..N).map(|i| m[i] * g * y[i]).sum();
            }
        }
    };
}

links!(Absolute, AbsoluteSymbolic, [], 0, 0, (i - 1), (theta[i]));
links!(Relative, RelativeSymbolic, [], 0, 0, (i - 1), ((0..i + 1).map(|j| theta[j]).sum()));
links!(Cart, CartSymbolic, [coord s;], s, (0.5 * dot(s).powi(2)), (i - 1), (theta[i]));
links!(Tree, TreeSymbolic, [], 0, 0, ((i - 1) / 2), (theta[i]));

/// Numbers as they stand, or as strings of more digits than a number has.
fn numbers<const N: usize>(case: &Value, name: &str) -> [f64; N] {
    let list = case[name].as_array().expect("a list");
    assert_eq!(list.len(), N, "{name}");
    std::array::from_fn(|i| {
        list[i].as_f64().unwrap_or_else(|| list[i].as_str().expect("digits").parse().expect("a number"))
    })
}

/// The largest error of the accelerations in the states of the reference, relative to the largest acceleration.
fn error<Sys, const N: usize>(kind: &str, unit: bool, system: impl Fn([f64; 32], [f64; 32]) -> Sys) -> f64
where
    Sys: System<N, Scalar = f64>,
{
    let cases: Value = serde_json::from_str(include_str!("chains/accelerations.json")).expect("reference");
    let cases = cases.as_array().expect("a list");
    let (mut worst, mut count) = (0.0f64, 0);
    for case in cases.iter().filter(|case| case["kind"] == kind && case["unit"] == unit) {
        let [q, qd, accel] = ["q", "qd", "accel"].map(|name| SVector::<f64, N>::from(numbers(case, name)));
        let found = system(numbers(case, "m"), numbers(case, "l")).accel(&q, &qd, 0.0);
        worst = worst.max((found - accel).amax() / accel.amax());
        count += 1;
    }
    assert_eq!(count, 3, "states of {kind}");
    println!("{kind}, {}: {worst:.1e}", if unit { "unit" } else { "symbolic" });
    worst
}

#[test]
fn absolute_angles() {
    assert!(error("absolute", true, |_, _| Absolute::new()) < 1e-14);
    assert!(error("absolute", false, AbsoluteSymbolic::new) < 1e-14);
}

#[test]
fn relative_angles() {
    assert!(error("relative", true, |_, _| Relative::new()) < 1e-14);
    assert!(error("relative", false, RelativeSymbolic::new) < 1e-14);
}

#[test]
fn on_a_cart() {
    assert!(error("cart", true, |_, _| Cart::new()) < 1e-14);
    assert!(error("cart", false, CartSymbolic::new) < 1e-14);
}

#[test]
fn trees() {
    assert!(error("tree", true, |_, _| Tree::new()) < 1e-14);
    assert!(error("tree", false, TreeSymbolic::new) < 1e-14);
}
