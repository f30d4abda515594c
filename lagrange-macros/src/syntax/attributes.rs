//! Attributes: those that would be dropped, or would break the generated items, are refused.

use crate::diagnostics::Errors;
use syn::punctuated::Punctuated;
use syn::{Attribute, Path, Token};

/// Destination of the attributes of a statement.
#[derive(Clone, Copy, PartialEq)]
pub enum Kept {
    OnField,
    OnFunction,
    Nowhere,
}

/// The message on attributes of what becomes no item.
pub const WITHOUT_EFFECT: &str =
    "this attribute has no effect here\nhelp: remove it; only parameters and outputs become items of Rust";

/// Traits that every system implements.
const DERIVED: [&str; 5] = ["Clone", "Copy", "Debug", "PartialEq", "Default"];

/// The attributes that the type can have.
pub fn of_system(attributes: Vec<Attribute>, errors: &mut Errors) -> Vec<Attribute> {
    attributes.into_iter().filter(|a| allowed_on_system(a, errors)).collect()
}

fn allowed_on_system(attribute: &Attribute, errors: &mut Errors) -> bool {
    if attribute.path().is_ident("cfg") {
        errors.push(attribute, "a part of what is generated cannot be conditional\nhelp: put this attribute in front of `lagrangian!`");
        return false;
    }
    if !attribute.path().is_ident("derive") {
        return true;
    }
    let derived = attribute.parse_args_with(Punctuated::<Path, Token![,]>::parse_terminated);
    let mut allowed = true;
    for path in derived.into_iter().flatten() {
        let Some(name) = path.segments.last().map(|s| s.ident.to_string()) else { continue };
        if DERIVED.contains(&name.as_str()) {
            let help = if name == "Default" {
                "remove it, and give every parameter a default value"
            } else {
                "remove it"
            };
            errors.push(path, format!("a system implements `{name}` already\nhelp: {help}"));
            allowed = false;
        }
    }
    allowed
}

/// The attributes that what a statement declares can have.
pub fn of_statement(attributes: Vec<Attribute>, kept: Kept, errors: &mut Errors) -> Vec<Attribute> {
    let mut allowed = |attribute: &Attribute| {
        if attribute.path().is_ident("cfg") && kept != Kept::OnFunction {
            errors.push(attribute, "a part of a system cannot be conditional\nhelp: write two systems, each behind its own `#[cfg]` in front of `lagrangian!`");
            return false;
        }
        if !attribute.path().is_ident("doc") && kept == Kept::Nowhere {
            errors.push(attribute, WITHOUT_EFFECT);
            return false;
        }
        true
    };
    attributes.into_iter().filter(|a| allowed(a)).collect()
}
