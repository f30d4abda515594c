//! The compiler behind `lagrangian!`. Use it through `lagrange-runtime`, which re-exports the macro.
mod compile;
mod diagnostics;
mod emit;
mod equations;
#[cfg(test)]
mod expansion_tests;
#[cfg(test)]
mod fuzz;
mod graph;
mod model;
mod schedule;
mod syntax;

use proc_macro::TokenStream;
use proc_macro2::TokenTree;

/// Compiles a mechanical system; `lagrange_runtime::lagrangian!` passes it `@crate [path]` and the definition, and its
/// documentation is there. `@functions callback` calls `callback!` with the table of elementary functions.
#[proc_macro]
pub fn lagrangian(input: TokenStream) -> TokenStream {
    let input = proc_macro2::TokenStream::from(input);
    let mut start = input.clone().into_iter().skip(1);
    match (start.next(), start.next()) {
        (Some(TokenTree::Ident(mode)), Some(TokenTree::Ident(callback))) if mode == "functions" => {
            emit::functions::functions(&callback).into()
        }
        _ => compile::compile(input).into(),
    }
}
