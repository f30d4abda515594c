//! Chains and trees of links: what their accelerations cost, by number of links.

use super::{arithmetic::agreed, input, solved};
use crate::schedule::count::Operations;
use proc_macro2::TokenStream;

/// Which links, with unit masses and lengths or with parameters for them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Kind {
    /// A chain by the angles of the links with the vertical,
    Absolute,
    /// or with the link before,
    Relative,
    /// on a cart,
    Cart,
    /// and a binary tree: link i hangs on link (i − 1)/2.
    Tree,
}

pub fn links(kind: Kind, n: usize, symbolic: bool) -> TokenStream {
    let (parameters, m, l, g) = if symbolic {
        ("param m: [N], l: [N], g = 9.81;", "m[i]", "l[i]", "g")
    } else {
        ("", "1", "1", "9.81")
    };
    let parent = match kind {
        Kind::Tree => "(i - 1) / 2",
        _ => "i - 1",
    };
    let (base, cart) = match kind {
        Kind::Cart => ("s", "coord s;"),
        _ => ("0", ""),
    };
    let cart_energy = if kind == Kind::Cart { "0.5 * dot(s).powi(2) +" } else { "" };
    let angle = match kind {
        Kind::Relative => "let phi: [N] = |i| (0..i + 1).map(|j| theta[j]).sum();",
        _ => "let phi: [N] = |i| theta[i];",
    };
    input(&format!(
        "lagrangian! {{
            pub system Links {{
                const N = {n};
                {parameters}
                {cart}
                coord theta: [N];
                {angle}
                let x: [N] = |i| if i == 0 {{ {base} }} else {{ x[{parent}] }} + {l} * phi[i].sin();
                let y: [N] = |i| if i == 0 {{ 0 }} else {{ y[{parent}] }} - {l} * phi[i].cos();
                T = {cart_energy} (0..N).map(|i| 0.5 * {m} * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                V = (0..N).map(|i| {m} * {g} * y[i]).sum();
            }}
        }}"
    ))
}

#[test]
fn costs_are_linear() {
    for symbolic in [false, true] {
        for kind in [Kind::Absolute, Kind::Relative, Kind::Cart, Kind::Tree] {
            for n in [2, 3, 4, 6, 8, 12, 16, 32] {
                let start = std::time::Instant::now();
                let system = solved(links(kind, n, symbolic));
                let (operations, _): (Operations, usize) = agreed("links", system);
                println!(
                    "{kind:?} {symbolic} {n}: {} {operations:?} {:?}",
                    operations.arithmetic(),
                    start.elapsed()
                );
            }
        }
    }
}

#[test]
#[ignore = "prints"]
fn print_accel() {
    let kind = Kind::Absolute;
    let n: usize = std::env::var("LINKS").map_or(6, |n| n.parse().unwrap());
    let e = solved(links(kind, n, std::env::var("SYMBOLIC").is_ok()));
    let file = super::file(super::emit::emit(e));
    let text = prettyplease::unparse(&file);
    let from = text.find("fn accel").unwrap();
    println!("{}", &text[from..from + text[from..].find("SVector::from").unwrap() + 2000]);
}

#[test]
#[ignore = "a measurement"]
fn expand_once() {
    let n: usize = std::env::var("LINKS").map_or(6, |n| n.parse().unwrap());
    let e = solved(links(Kind::Absolute, n, std::env::var("SYMBOLIC").is_ok()));
    drop(super::emit::emit(e));
}
