//! Time that the compiler takes, stage by stage. Macros are built without optimisation, so that is how it is measured:
//! `CARGO_PROFILE_DEV_OPT_LEVEL=0 cargo test -p lagrange-macros speed -- --ignored --nocapture`.

use super::chains::{Kind, links};
use super::{arithmetic::chain, defined, emit, input, systems};
use crate::diagnostics::Errors;
use crate::equations::derived;
use crate::model::model;
use proc_macro2::TokenStream;
use std::time::Instant;

/// n bobs on a cart, by their positions.
fn on_a_cart(n: usize, symbolic: bool) -> TokenStream {
    let (parameters, m, l, g) = if symbolic {
        ("param M, m: [N], l: [N], g = 9.81;", "m[i]", "l[j]", "g")
    } else {
        ("param M;", "1", "1", "9.81")
    };
    input(&format!(
        "lagrangian! {{
            pub system OnACart {{
                const N = {n};
                {parameters}
                coord s, theta: [N];
                let x: [N] = |i| s + (0..i + 1).map(|j| {l} * theta[j].sin()).sum();
                let y: [N] = |i| -(0..i + 1).map(|j| {l} * theta[j].cos()).sum();
                T = 0.5 * M * dot(s).powi(2)
                    + (0..N).map(|i| 0.5 * {m} * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                V = (0..N).map(|i| {m} * {g} * y[i]).sum();
            }}
        }}"
    ))
}

#[test]
#[ignore = "a measurement"]
fn speed() {
    let mut all = systems();
    all.extend([2, 8, 25].map(|n| (format!("chain of {n}"), chain(n))));
    all.extend([(5, false), (10, false), (25, false), (5, true), (10, true), (25, true)].map(
        |(n, symbolic)| {
            let kind = if symbolic { "symbolic" } else { "unit" };
            (format!("{n} on a cart, {kind}"), on_a_cart(n, symbolic))
        },
    ));
    for n in [8, 32, 64, 100] {
        all.push((format!("{n} links, unit"), links(Kind::Absolute, n, false)));
        all.push((format!("{n} links, symbolic"), links(Kind::Absolute, n, true)));
    }
    println!(
        "{:26} {:>8} {:>8} {:>9} {:>8} {:>8}  nodes  operations",
        "milliseconds", "syntax", "model", "equations", "emit", "total"
    );
    for (name, input) in all {
        let mut times = vec![Instant::now()];
        let definition = defined(input);
        times.push(Instant::now());
        let mut errors = Errors::default();
        let model = model(&definition, &mut errors).expect("a system without errors");
        times.push(Instant::now());
        let system = derived(model, &mut errors).expect("a system without errors");
        times.push(Instant::now());
        let (nodes, operations) = (system.graph.len(), system.equations.solved.operations.arithmetic());
        let items = emit::emit(&system);
        times.push(Instant::now());
        drop(items);
        let ms = |a: usize, b: usize| (times[b] - times[a]).as_secs_f64() * 1e3;
        println!(
            "{name:26} {:8.2} {:8.2} {:9.2} {:8.2} {:8.2}  {nodes:5}  {operations}",
            ms(0, 1),
            ms(1, 2),
            ms(2, 3),
            ms(3, 4),
            ms(0, 4)
        );
    }
}
