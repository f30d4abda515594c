//! The whole compiler on one page: each stage makes one plain value of those before it.

use crate::diagnostics::Errors;
use crate::emit::fallback::fallback;
use crate::equations::{Derived, derived, restriction, routhian::routhian};
use crate::model::submodel::Submodel;
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

/// The systems with coordinates held that are asked for.
pub fn submodels(definition: &Definition, whole: &Derived, errors: &mut Errors) -> Vec<Derived> {
    let asked = whole.model.submodels.iter();
    asked.filter_map(|asked| submodel(definition, whole, asked, errors)).collect()
}

/// One of them. What is wrong with it is wrong with what was held, and not with what was written.
fn submodel(
    definition: &Definition,
    whole: &Derived,
    asked: &Submodel,
    errors: &mut Errors,
) -> Option<Derived> {
    let found = &mut Errors::default();
    let model = model::submodel(definition, (&whole.graph, &whole.model), asked, found);
    let Some(small) = model.and_then(|model| derived(model, found)) else {
        let reason = found.earliest().unwrap_or_default();
        let reason = reason.lines().next().unwrap_or_default();
        let message = format!(
            "the system cannot be formed where these coordinates are held: {reason}\nhelp: hold others, or hold them elsewhere"
        );
        errors.push(&asked.header.name, message);
        return None;
    };
    restriction::check(whole, &small, asked, errors);
    Some(small)
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
