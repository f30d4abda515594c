//! Input that would exhaust the stack of a recursive parser is refused before it is parsed.

use proc_macro2::TokenTree;

/// Brackets within brackets.
const MAX_NESTED_GROUPS: usize = 64;
/// Signs, or words, that follow each other.
const MAX_OPERATORS_IN_A_ROW: usize = 32;
/// Tokens after which a parser may recurse once more: `|x| |x| …`, `a < b < …`, `a = a = …`, `else if … else if …`.
const MAX_RECURSIVE_TOKENS: usize = 256;
/// Tokens between commas: `a + b + c …` is a tree as deep as it is long.
const MAX_TOKENS_BETWEEN_COMMAS: usize = 2000;

/// Refuses nesting, runs and chains that no formula has.
pub fn check(tokens: &[TokenTree]) -> syn::Result<()> {
    let mut recursive = 0;
    level(tokens.iter().cloned(), 0, &mut recursive)
}

fn level(tokens: impl Iterator<Item = TokenTree>, depth: usize, recursive: &mut usize) -> syn::Result<()> {
    let (mut puncts, mut words, mut length) = (0, 0, 0);
    for token in tokens {
        (puncts, words) = match &token {
            TokenTree::Punct(_) => (puncts + 1, 0),
            TokenTree::Ident(_) => (0, words + 1),
            _ => (0, 0),
        };
        length = if matches!(&token, TokenTree::Punct(p) if p.as_char() == ',') { 0 } else { length + 1 };
        if length > MAX_TOKENS_BETWEEN_COMMAS {
            let message = "this expression is too long\nhelp: name its parts with `let`";
            return Err(syn::Error::new(token.span(), message));
        }
        *recursive += usize::from(match &token {
            TokenTree::Punct(p) => matches!(p.as_char(), '|' | '<' | '='),
            TokenTree::Ident(word) => word == "else",
            _ => false,
        });
        let too_deep = depth > MAX_NESTED_GROUPS
            || puncts > MAX_OPERATORS_IN_A_ROW
            || words > MAX_OPERATORS_IN_A_ROW
            || *recursive > MAX_RECURSIVE_TOKENS;
        if too_deep {
            let message = "this expression is nested too deeply\nhelp: name its parts with `let`";
            return Err(syn::Error::new(token.span(), message));
        }
        if let TokenTree::Group(group) = &token {
            level(group.stream().into_iter(), depth + 1, recursive)?;
        }
    }
    Ok(())
}
