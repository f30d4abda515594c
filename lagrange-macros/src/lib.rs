//! The compiler behind `lagrangian!`. Use it through `lagrange-runtime`, which re-exports the macro.
mod emit;
mod graph;

use proc_macro::TokenStream;

/// Placeholder.
#[proc_macro]
pub fn lagrangian(input: TokenStream) -> TokenStream {
    let mut tokens = proc_macro2::TokenStream::from(input).into_iter().skip(2);
    match tokens.next() {
        Some(proc_macro2::TokenTree::Ident(callback)) => emit::functions::functions(&callback).into(),
        _ => TokenStream::new(),
    }
}
