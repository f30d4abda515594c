//! Functions: `fn gust(s) = …`, `extern fn mu(t)`, `extern wind: Curve(t)`.

use super::declarations::type_tokens;
use super::{Data, Statement, attributes, words};
use crate::diagnostics::{Errors, plain};
use proc_macro2::{Delimiter, Ident, TokenTree};
use syn::ext::IdentExt;
use syn::parse::{ParseStream, Parser};
use syn::{Attribute, Token, Type, parenthesized};

/// Reads what follows `fn`.
pub fn function(input: ParseStream, errors: &mut Errors) -> syn::Result<Statement> {
    let (name, arguments) = signature(input, errors)?;
    if !input.peek(Token![=]) {
        return Err(input.error(format!("expected `=`\nhelp: write `fn {name}(x) = expression;`")));
    }
    input.parse::<Token![=]>()?;
    Ok(Statement::Function { name, arguments, body: input.parse()? })
}

/// Reads what follows `extern`: a function of the user's, or one with data.
pub fn external(input: ParseStream, given: Vec<Attribute>, errors: &mut Errors) -> syn::Result<Statement> {
    if input.parse::<Token![fn]>().is_ok() {
        if let Some(attribute) = given.iter().find(|a| !a.path().is_ident("doc")) {
            errors.push(attribute, attributes::WITHOUT_EFFECT);
        }
        let (name, arguments) = signature(input, errors)?;
        Ok(Statement::Extern { name, arguments, data: None })
    } else {
        with_data(input, given, errors)
    }
}

/// `name(a, b)`; types are refused, and skipped.
fn signature(input: ParseStream, errors: &mut Errors) -> syn::Result<(Ident, Vec<Ident>)> {
    let name = words::name(input, "expected the name of the function", errors)?;
    let inside;
    parenthesized!(inside in input);
    let arguments = arguments(&inside, errors)?;
    no_type(input, errors)?;
    Ok((name, arguments))
}

/// The names of arguments between parentheses.
fn arguments(inside: ParseStream, errors: &mut Errors) -> syn::Result<Vec<Ident>> {
    let mut arguments = Vec::new();
    while !inside.is_empty() {
        arguments.push(words::name(inside, "expected the name of an argument", errors)?);
        no_type(inside, errors)?;
        if !inside.is_empty() {
            inside.parse::<Token![,]>()?;
        }
    }
    Ok(arguments)
}

/// The rest of `extern name: Type(x, …)`.
fn with_data(input: ParseStream, attributes: Vec<Attribute>, errors: &mut Errors) -> syn::Result<Statement> {
    let form = "write `extern fn name(t);` for a Rust function, or `extern name: Curve(t);` for a function with data, a field of this type";
    if !input.peek(syn::Ident::peek_any) || input.peek2(syn::token::Paren) {
        return Err(input.error(format!("expected `fn`\nhelp: {form}")));
    }
    let name = words::name(input, "expected the name of the function", errors)?;
    if !input.peek(Token![:]) {
        return Err(input.error(format!("expected `:` and the type of the data\nhelp: {form}")));
    }
    input.parse::<Token![:]>()?;
    let mut ty: Vec<TokenTree> = Vec::new();
    while !input.is_empty() && !input.peek(Token![;]) {
        ty.push(input.parse()?);
    }
    let written = match ty.last() {
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis => Some(group.clone()),
        _ => None,
    };
    ty.truncate(ty.len() - usize::from(written.is_some()));
    if ty.is_empty() {
        return Err(syn::Error::new(
            name.span(),
            format!("the function `{name}` needs the type of its data\nhelp: {form}"),
        ));
    }
    let ty: Type = syn::parse2(ty.into_iter().collect())?;
    let mut arguments = match &written {
        Some(group) => (|inside: ParseStream| arguments(inside, errors)).parse2(group.stream())?,
        None => Vec::new(),
    };
    if arguments.is_empty() {
        let message = format!(
            "the function `{name}` needs its arguments\nhelp: write `extern {name}: {}(t);`",
            plain(&ty)
        );
        errors.push(&name, message);
        // Its calls are read as those of one argument, and the field is there.
        arguments.push(name.clone());
    }
    Ok(Statement::Extern { name, arguments, data: Some(Data { attributes, ty }) })
}

/// Refuses and skips `: type` and `-> type`.
fn no_type(input: ParseStream, errors: &mut Errors) -> syn::Result<()> {
    if input.peek(Token![:]) {
        input.parse::<Token![:]>()?;
    } else if input.peek(Token![->]) {
        input.parse::<Token![->]>()?;
    } else {
        return Ok(());
    }
    let ty = type_tokens(input)?;
    errors.push(ty, "a type has no place here: every number is of the system's own type\nhelp: remove it");
    Ok(())
}
