//! The whole compiler on one page: each stage hands the next one plain value.

use crate::diagnostics::Errors;
use crate::emit::fallback::fallback;
use crate::equations::{Equations, equations, routhian::routhian};
use crate::{emit, model, syntax};
use proc_macro2::TokenStream;

/// Tokens of a definition to tokens of its items; with errors, the errors and stubs.
pub fn compile(input: TokenStream) -> TokenStream {
    through(input, emit::emit)
}

/// The same, with what the interpreter says beside what is compiled.
pub fn compile_interpreted(input: TokenStream) -> TokenStream {
    through(input, |equations| {
        let interpreted = emit::interpreted::interpreted(&equations);
        let items = emit::emit(equations);
        quote::quote!(#items #interpreted)
    })
}

fn through(input: TokenStream, emit: impl FnMut(Equations) -> TokenStream) -> TokenStream {
    let mut errors = Errors::default();
    let Some(definition) = syntax::parse(input.clone(), &mut errors) else { return errors.to_tokens() };
    let system = model::model(definition, &mut errors).and_then(|model| equations(model, &mut errors));
    let reduced = system.as_ref().and_then(|system| routhian(system, &mut errors));
    let reduced = reduced.and_then(|model| equations(model, &mut errors));
    if errors.is_empty() {
        let warnings = errors.warnings();
        system.into_iter().chain(reduced).map(emit).chain([warnings]).collect()
    } else {
        // Read again, so that nobody pays for stubs but who needs them.
        let stubs = syntax::parse(input, &mut Errors::default()).map(|definition| fallback(&definition));
        let errors = errors.to_tokens();
        quote::quote!(#errors #stubs)
    }
}
