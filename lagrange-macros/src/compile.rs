//! The whole compiler on one page: each stage makes one plain value of those before it.

use crate::diagnostics::Errors;
use crate::emit::fallback::fallback;
use crate::equations::{Derived, derived, routhian::routhian, submodel::submodel};
use crate::syntax::Definition;
use crate::{emit, model, syntax, table};
use proc_macro2::TokenStream;

/// Tokens of a definition to tokens of its items; with errors, the errors and stubs.
pub fn compile(input: TokenStream) -> TokenStream {
    through(input, &mut Errors::default(), emit::emit)
}

/// The same, and the errors.
#[cfg(test)]
pub fn compile_with(input: TokenStream, errors: &mut Errors) -> TokenStream {
    through(input, errors, emit::emit)
}

/// The same, with what the interpreter says beside what is compiled.
pub fn compile_interpreted(input: TokenStream) -> TokenStream {
    through(input, &mut Errors::default(), |system| {
        let (items, interpreted) = (emit::emit(system), emit::interpreted::interpreted(system));
        quote::quote!(#items #interpreted)
    })
}

/// The system of a definition.
pub fn system(definition: &Definition, errors: &mut Errors) -> Option<Derived> {
    table::check_names(definition, errors);
    model::model(definition, errors).and_then(|model| derived(model, errors))
}

/// The reduced system, where one is asked for.
pub fn reduced(whole: &Derived, errors: &mut Errors) -> Option<Derived> {
    routhian(whole, errors).and_then(|model| derived(model, errors))
}

/// The restricted and simplified systems that are asked for.
pub fn submodels(definition: &Definition, whole: &Derived, errors: &mut Errors) -> Vec<Derived> {
    let asked = whole.model.submodels.iter();
    asked.filter_map(|asked| submodel(definition, whole, asked, errors)).collect()
}

fn through(input: TokenStream, errors: &mut Errors, emit: impl Fn(&Derived) -> TokenStream) -> TokenStream {
    let Some(definition) = syntax::parse(input.clone(), errors) else { return errors.to_tokens() };
    let whole = system(&definition, errors);
    let reduced = whole.as_ref().and_then(|whole| reduced(whole, errors));
    let submodels = whole.as_ref().map_or(Vec::new(), |whole| submodels(&definition, whole, errors));
    let all = || whole.iter().chain(&reduced).chain(&submodels);
    if errors.is_empty() {
        if std::env::var_os("LAGRANGE_SHOW").is_some_and(|what| what == "stages") {
            all().for_each(|system| eprintln!("{}", emit::stages::stages(system)));
        }
        let warnings = errors.warnings();
        all().map(emit).chain([warnings]).collect()
    } else {
        // Read again, so that nobody pays for stubs but who needs them.
        let stubs = syntax::parse(input, &mut Errors::default()).map(|definition| fallback(&definition));
        let errors = errors.to_tokens();
        quote::quote!(#errors #stubs)
    }
}
