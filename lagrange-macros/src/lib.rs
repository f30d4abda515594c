//! The compiler behind `lagrangian!`. Use it through `lagrange-runtime`, which re-exports the macro.
#![forbid(unsafe_code)]

#[cfg(test)]
mod against_rustc;
#[cfg(test)]
mod beginners;
mod compile;
mod diagnostics;
#[cfg(test)]
mod differential;
mod emit;
mod equations;
#[cfg(test)]
mod expansion_tests;
#[cfg(test)]
mod fuzz;
mod graph;
mod model;
mod program;
mod syntax;
mod table;
#[cfg(test)]
mod through_rustc;

/// Entry for `fuzz/`, which cannot call a macro.
#[cfg(fuzzing)]
pub use compile::compile;

#[cfg(not(fuzzing))]
use proc_macro::TokenStream;
#[cfg(not(fuzzing))]
use proc_macro2::TokenTree;

/// Compiles a mechanical system; `lagrange_runtime::lagrangian!` passes it `@crate [path]` and the definition, and its
/// documentation is there. Two more modes serve the project itself: `@functions callback` calls `callback!` with the
/// table of elementary functions, `@interpreted [path] …` adds the values that the interpreter finds.
#[cfg(not(fuzzing))]
#[proc_macro]
pub fn lagrangian(input: TokenStream) -> TokenStream {
    allow_greek(&input);
    let input = proc_macro2::TokenStream::from(input);
    let mut start = input.clone().into_iter();
    match (start.next(), start.next()) {
        (Some(at), Some(TokenTree::Ident(mode))) if mode == "functions" => match start.next() {
            Some(TokenTree::Ident(callback)) => emit::functions::functions(&callback).into(),
            _ => syn::Error::new(at.span(), "expected the name of a macro").to_compile_error().into(),
        },
        (Some(at), Some(TokenTree::Ident(mode))) if mode == "interpreted" => {
            let rest: proc_macro2::TokenStream = start.collect();
            compile::compile_interpreted(quote::quote!(#at crate #rest)).into()
        }
        _ => compile::compile(input).into(),
    }
}

/// Keeps rustc from its warning `mixed_script_confusables` where a system has Greek letters, which formulas have: it
/// is given where all Greek letters of a crate look like Latin ones, as rustc finds of `θ`, `φ` and `ρ`. No attribute
/// of a macro reaches this lint; λ does, which rustc's lexer has then seen.
#[cfg(not(fuzzing))]
fn allow_greek(input: &TokenStream) {
    if input.to_string().contains(|c| ('\u{370}'..='\u{3ff}').contains(&c)) {
        drop("λ".parse::<TokenStream>());
    }
}
