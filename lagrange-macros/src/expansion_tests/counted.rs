//! Operations of every system that is written anywhere in the repository, and a hash of what is emitted, for comparing two compilers:
//!
//! ```text
//! LAGRANGE_SYSTEMS=1000 cargo test -p lagrange-macros --lib counted -- --ignored --nocapture
//! ```

use crate::compile::compile;
use crate::differential::{variable, written};
use proc_macro2::{TokenStream, TokenTree};
use quote::quote;
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

#[test]
#[ignore = "a measurement"]
fn counted() {
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
    for (name, system) in all {
        let items = compile(quote!(@crate [::lagrange_runtime] #system)).to_string();
        let mut hash = DefaultHasher::new();
        items.hash(&mut hash);
        let counts = items.split("Operations {").skip(1).filter_map(|rest| rest.split('}').next());
        println!("{name}: {:016x} {}", hash.finish(), counts.collect::<Vec<_>>().join(";"));
    }
}
