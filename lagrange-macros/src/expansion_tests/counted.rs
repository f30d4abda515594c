//! Operations of every system that is written anywhere in the repository, and a hash of what is emitted, for
//! comparing two compilers:
//!
//! ```text
//! LAGRANGE_SYSTEMS=1000 cargo test -p lagrange-macros --lib counted -- --ignored --nocapture
//! ```

use crate::compile::compile;
use crate::diagnostics::Errors;
use crate::differential::{variable, written};
use proc_macro2::{TokenStream, TokenTree};
use quote::quote;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Invocations of the macro among these tokens.
fn definitions(tokens: TokenStream, found: &mut Vec<TokenStream>) {
    let mut before = [String::new(), String::new()];
    for token in tokens {
        if let TokenTree::Group(group) = &token {
            if before == ["lagrangian", "!"] {
                found.push(group.stream());
            }
            definitions(group.stream(), found);
        }
        before = [std::mem::take(&mut before[1]), token.to_string()];
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().expect("a folder of the repository").flatten() {
        let path = entry.path();
        if path.is_dir() && !path.ends_with("ui") && !path.ends_with("target") {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Every system of the repository with its place, and so many random ones.
fn all_systems() -> Vec<(String, TokenStream)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut paths = Vec::new();
    ["tests", "examples", "benches", "lagrange-macros/tests"]
        .iter()
        .for_each(|f| sources(&root.join(f), &mut paths));
    paths.sort();
    let mut all = Vec::new();
    for path in paths {
        let mut found = Vec::new();
        let text = std::fs::read_to_string(&path).expect("a text");
        let Ok(tokens) = text.parse::<TokenStream>() else { continue };
        definitions(tokens, &mut found);
        let name = path.strip_prefix(&root).expect("below the root").display().to_string();
        all.extend(found.into_iter().enumerate().map(|(i, system)| (format!("{name} {i}"), system)));
    }
    for seed in 0..variable("LAGRANGE_SYSTEMS").unwrap_or(0) {
        all.push((format!("random {seed}"), written(seed).parse().expect("tokens")));
    }
    all
}

#[test]
#[ignore = "a measurement"]
fn counted() {
    for (name, system) in all_systems() {
        let items = compile(quote!(@crate [::lagrange_runtime] #system)).to_string();
        let mut hash = DefaultHasher::new();
        items.hash(&mut hash);
        let counts = items.split("Operations {").skip(1).filter_map(|rest| rest.split('}').next());
        println!("{name}: {:016x} {}", hash.finish(), counts.collect::<Vec<_>>().join(";"));
    }
}

/// Costs of all ways that were tried of one thing.
type Tried = Vec<(String, usize)>;

/// Worth of a part of a way: how often a system would cost more without it, and how much.
#[derive(Default)]
struct Worth {
    offered: usize,
    gains: Vec<f64>,
}

/// Prints of each part of the ways in which accelerations and series are found how many systems offer it, how many
/// would cost more without it, and the median and the largest part of the cost that it saves. A form of series that
/// was not counted costs its lower bound here, so that gains are no larger than they are.
///
/// ```text
/// LAGRANGE_SYSTEMS=2000 cargo test --release -p lagrange-macros --lib census -- --ignored --nocapture
/// ```
#[test]
#[ignore = "a measurement"]
fn census() {
    let mut all: [BTreeMap<String, Worth>; 2] = Default::default();
    let mut totals = [0; 2];
    for (name, system) in all_systems() {
        let tokens = quote!(@crate [::lagrange_runtime] #system);
        let definition = crate::syntax::parse(tokens, &mut Errors::default());
        let errors = &mut Errors::default();
        let Some(whole) = definition.and_then(|definition| crate::compile::system(&definition, errors))
        else {
            println!("{name}: no system");
            continue;
        };
        let reduced = crate::compile::reduced(&whole, errors);
        for d in [Some(whole), reduced].into_iter().flatten() {
            let ways = d.equations.solved.tried.iter();
            let accel: Tried = ways.filter_map(|c| Some((c.way.clone(), c.cost?.cost()))).collect();
            let series = d.equations.series.map_or(Vec::new(), |series| series.tried);
            let series = series.into_iter().map(|form| (form.way, form.cost)).collect();
            for (i, tried) in [accel, series].into_iter().enumerate() {
                totals[i] += usize::from(!tried.is_empty());
                note(&tried, &mut all[i]);
            }
        }
    }
    for ((what, parts), total) in ["accelerations", "series"].into_iter().zip(all).zip(totals) {
        println!("| {what}: {total} systems | offered | gains | median | largest |");
        for (part, Worth { offered, mut gains }) in parts {
            gains.sort_by(f64::total_cmp);
            let percent =
                |gain: Option<&f64>| gain.map_or("".into(), |gain| format!("{:.1} %", 100.0 * gain));
            let (median, largest) = (percent(gains.get(gains.len() / 2)), percent(gains.last()));
            println!("| {part} | {offered} | {} | {median} | {largest} |", gains.len());
        }
    }
}

fn note(tried: &Tried, worth: &mut BTreeMap<String, Worth>) {
    let parts = |way: &str| way.split(", ").map(String::from).collect::<BTreeSet<_>>();
    let least = |part: Option<&String>| {
        let others = tried.iter().filter(|(way, _)| part.is_none_or(|part| !parts(way).contains(part)));
        others.map(|(_, cost)| *cost).min()
    };
    let Some(best) = least(None) else { return };
    for part in tried.iter().flat_map(|(way, _)| parts(way)).collect::<BTreeSet<_>>() {
        let without = least(Some(&part));
        let worth = worth.entry(part).or_default();
        worth.offered += 1;
        // A part of all ways has nothing to be compared with.
        worth.gains.extend(without.filter(|cost| *cost > best).map(|cost| 1.0 - best as f64 / cost as f64));
    }
}
