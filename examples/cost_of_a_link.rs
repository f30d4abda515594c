//! The number of operations of accelerations, by the number of links: chains and trees whose links hang from each
//! other cost as much for each further link. A dense solve grows with the cube.
//!
//! `cargo run --release --example cost_of_a_link`

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::{Checks, table};
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

/// A chain, or a tree whose links carry two others each, of so many links with a mass at the end of each.
macro_rules! linkages {
    ($($name:ident $links:literal $parent:tt)*) => {$(
        mod $name {
            lagrange_runtime::lagrangian! {
                /// θ from the vertical.
                pub system Linkage {
                    const N = $links;
                    param m: [N], l: [N], g = 9.81;
                    coord theta: [angle; N];
                    let x: [N] = |i| l[i] * theta[i].sin() + if i == 0 { 0 } else { x[(i - 1) / $parent] };
                    let y: [N] = |i| -l[i] * theta[i].cos() + if i == 0 { 0 } else { y[(i - 1) / $parent] };
                    T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                    V = (0..N).map(|i| m[i] * g * y[i]).sum();
                }
            }
        }
    )*};
}

linkages! {
    chain_1 1 1  chain_2 2 1  chain_3 3 1  chain_4 4 1  chain_6 6 1  chain_8 8 1  chain_12 12 1  chain_16 16 1  chain_24 24 1
    chain_32 32 1  chain_48 48 1
    tree_3 3 2  tree_7 7 2  tree_15 15 2  tree_31 31 2
}

/// Links and operations of each module.
macro_rules! counts {
    ($($name:ident)*) => {
        [$({
            let facts = $name::Linkage::<f64>::FACTS;
            (facts.degrees_of_freedom() as f64, facts.operations.arithmetic() as f64)
        }),*]
    };
}

fn main() -> Result<(), Box<dyn Error>> {
    let chains =
        counts!(chain_1 chain_2 chain_3 chain_4 chain_6 chain_8 chain_12 chain_16 chain_24 chain_32 chain_48);
    let trees = counts!(tree_3 tree_7 tree_15 tree_31);
    println!(
        "{}",
        table(
            ["links", "operations", "per link"],
            chains.iter().chain(&trees).map(|(n, cost)| [
                n.to_string(),
                cost.to_string(),
                format!("{:.1}", cost / n)
            ])
        )
    );
    let solve = |n: f64| n.powi(3) / 3.0;
    let cube = (2..=48).map(|n| (f64::from(n), solve(n.into())));
    let folder = support::charts()?;
    Chart::new("What accelerations cost", Axis::log("links", ""), Axis::log("operations per evaluation", ""))
        .subtitle(
            "arithmetic operations that the compiler has counted, for masses and lengths that are parameters",
        )
        .with(Series::new("chain", chains))
        .with(Series::new("tree, two links on each", trees))
        .with(Series::line("n³/3: a dense solve alone", cube))
        .write(&folder, "cost-of-a-link")?;
    println!("{}", folder.join("cost-of-a-link.svg").display());

    let mut checks = Checks::default();
    let [.., before, last] = chains;
    checks.at_most(
        "operations of a further link of a chain",
        (last.1 - before.1) / (last.0 - before.0),
        26.0,
    );
    let [.., before, last] = trees;
    checks.at_most("operations of a further link of a tree", (last.1 - before.1) / (last.0 - before.0), 37.0);
    checks.holds(
        "a dense solve costs more from 12 links on",
        chains.iter().all(|&(n, cost)| n < 12.0 || cost < solve(n)),
    );
    Ok(checks.report()?)
}
