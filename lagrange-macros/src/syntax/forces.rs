//! Forces, couples, generalized forces and rates of states.

use super::{Statement, equals};
use crate::diagnostics::plain;
use proc_macro2::{Ident, TokenTree};
use syn::parse::ParseStream;
use syn::{Token, bracketed, parenthesized};

/// Reads what follows `Q`.
pub fn generalized(input: ParseStream, keyword: Ident) -> syn::Result<Statement> {
    if !input.peek(syn::token::Bracket) {
        let coordinate = match input.parse() {
            Ok(TokenTree::Group(group)) => plain(group.stream()),
            _ => "x".into(),
        };
        let message = format!(
            "expected the coordinate of the generalized force in brackets\nhelp: write `Q[{coordinate}] = …;` for the force along a coordinate `{coordinate}`"
        );
        return Err(syn::Error::new(keyword.span(), message));
    }
    let coordinate;
    bracketed!(coordinate in input);
    let coordinate = coordinate.parse()?;
    equals(input, "Q[…]")?;
    Ok(Statement::Applied { keyword, coordinate, value: input.parse()? })
}

/// Reads what follows `rate`, or a word that was meant so.
pub fn rate(input: ParseStream, keyword: &Ident) -> syn::Result<Statement> {
    if !input.peek(syn::token::Paren) {
        let message =
            "expected the state in parentheses\nhelp: write `rate(i) = …;` for the rate of a state `i`";
        return Err(syn::Error::new(keyword.span(), message));
    }
    let state;
    parenthesized!(state in input);
    let coordinate = state.parse()?;
    equals(input, "rate(…)")?;
    let keyword = Ident::new("rate", keyword.span());
    Ok(Statement::Applied { keyword, coordinate, value: input.parse()? })
}

/// Reads what follows `force`.
pub fn force(input: ParseStream, keyword: &Ident) -> syn::Result<Statement> {
    let form = "write `force [fx, fy] at [x, y];`, or for a force along one coordinate `Q[x] = …;`";
    if input.peek(Token![=]) {
        return Err(input.error(format!("a force needs its point of application\nhelp: {form}")));
    }
    let force = input.parse()?;
    joined(input, "at", keyword, ["the point of application", "a force", "its point of application"], form)?;
    Ok(Statement::Force { force, at: input.parse()? })
}

/// Reads what follows `couple`.
pub fn couple(input: ParseStream, keyword: &Ident) -> syn::Result<Statement> {
    let couple = input.parse()?;
    let form = "write `couple [mx, my, mz] on link;`";
    joined(input, "on", keyword, ["the frame that it turns", "a couple", "the frame that it turns"], form)?;
    Ok(Statement::Couple { couple, on: input.parse()? })
}

/// The word between the two expressions of a statement.
fn joined(
    input: ParseStream,
    word: &str,
    keyword: &Ident,
    [expected, what, needs]: [&str; 3],
    form: &str,
) -> syn::Result<()> {
    match input.parse::<Ident>() {
        Ok(found) if found == word => Ok(()),
        Ok(other) => {
            Err(syn::Error::new(other.span(), format!("expected `{word}` and {expected}\nhelp: {form}")))
        }
        Err(_) => Err(syn::Error::new(keyword.span(), format!("{what} needs {needs}\nhelp: {form}"))),
    }
}
