//! Whole systems through the compiler: what the emitted Rust looks like, that it is always the same, and what it costs.
//!
//! A fixture is a file of `tests/systems`, written as a user would write it; its expansion is a file of
//! `tests/expansions`. `INSTA_UPDATE=always cargo test -p lagrange-macros` writes the expansions anew.

mod arithmetic;
mod attitudes;
mod chains;
mod counted;
mod frames;
mod impulses;
mod names;
mod restrictions;
mod robust;
mod speed;
mod taken;

use crate::diagnostics::Errors;
use crate::differential::LONG;
use crate::equations::Derived;
use crate::program::count::Operations;
use crate::syntax::{Definition, parse};
use crate::{compile, emit};
use proc_macro2::TokenStream;
use quote::quote;
use std::path::Path;

/// The definition in a fixture, as the macro of the runtime passes it on.
fn input(text: &str) -> TokenStream {
    let file: syn::ItemMacro = syn::parse_str(text).expect("one invocation of the macro");
    let definition = file.mac.tokens;
    quote!(@crate [::lagrange_runtime] #definition)
}

/// Name and definition of each fixture, by name.
fn systems() -> Vec<(String, TokenStream)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/systems");
    let mut paths: Vec<_> =
        folder.read_dir().expect("the folder of fixtures").map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let read = |path: &Path| {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        (name, input(&std::fs::read_to_string(path).unwrap()))
    };
    paths.iter().map(|path| read(path)).collect()
}

fn defined(input: TokenStream) -> Definition {
    let mut errors = Errors::default();
    let definition = parse(input, &mut errors).filter(|_| errors.is_empty());
    definition.unwrap_or_else(|| panic!("{}", errors.to_tokens()))
}

/// The equations of a system without errors.
fn solved(input: TokenStream) -> Derived {
    let mut errors = Errors::default();
    compile::system(&defined(input), &mut errors).unwrap_or_else(|| panic!("{}", errors.to_tokens()))
}

/// The reduced system, where one is asked for.
fn reduced(system: &Derived) -> Option<Derived> {
    let mut errors = Errors::default();
    let reduced = compile::reduced(system, &mut errors);
    assert!(errors.is_empty(), "{}", errors.to_tokens());
    reduced
}

/// Emitted items without the documentation of the type, which says in words what is tested here in Rust.
fn file(items: TokenStream) -> syn::File {
    let mut file: syn::File = syn::parse2(items).expect("emitted tokens are items");
    for item in &mut file.items {
        if let syn::Item::Struct(item) = item {
            item.attrs.retain(|attribute| !attribute.path().is_ident("doc"));
        }
    }
    file
}

fn sentence(o: &Operations) -> String {
    format!(
        "// accel: {} additions, {} multiplications, {} divisions, {} sin_cos, {} functions; {} cycles at least",
        o.additions, o.multiplications, o.divisions, o.sin_cos, o.functions, o.path
    )
}

#[test]
fn expansions() {
    let mut settings = insta::Settings::new();
    settings.set_snapshot_path("../tests/expansions");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for (name, input) in systems() {
            let system = solved(input.clone());
            let reduced = reduced(&system);
            let mut errors = Errors::default();
            let submodels = compile::submodels(&defined(input), &system, &mut errors);
            assert!(errors.is_empty(), "{}", errors.to_tokens());
            let expansions: Vec<String> = std::iter::once(system)
                .chain(reduced)
                .chain(submodels)
                .map(|d| {
                    let header = sentence(&d.equations.solved.operations);
                    let text = prettyplease::unparse(&file(emit::emit(&d)));
                    format!("{header}\n\n{text}")
                })
                .collect();
            insta::assert_snapshot!(name, expansions.join("\n"));
        }
    });
}

/// Nothing that reaches tokens depends on the order of a hash table, the address of an allocation or what was compiled
/// before: threads have hash seeds of their own.
#[test]
fn expansions_are_reproducible() {
    let compiled = || -> Vec<String> {
        systems().into_iter().map(|(_, input)| compile::compile(input).to_string()).collect()
    };
    let first = compiled();
    assert_eq!(first, std::thread::spawn(compiled).join().unwrap());
    // Each system alone, or one in three, the last one first.
    for (i, (name, input)) in systems().into_iter().enumerate().rev().step_by(if *LONG { 1 } else { 3 }) {
        assert!(first[i] == compile::compile(input).to_string(), "{name}");
    }
}

/// The page that follows a system through the compiler shows what the compiler says.
#[test]
fn the_page_shows_the_stages() {
    let page = include_str!("../../docs/from-formula-to-code.md");
    let (_, input) = systems().into_iter().find(|(name, _)| name == "cart_pole").expect("a fixture");
    let stages = emit::stages::stages(&solved(input));
    assert!(page.contains(stages.trim_end()), "{stages}");
}
