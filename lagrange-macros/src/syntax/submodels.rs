//! Systems that are derived from another one by what is held: `restriction Planar: phi = 0, psi = 0;`.

use super::Header;
use crate::diagnostics::plain;
use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::parse::ParseStream;
use syn::{Expr, Token};

/// A second type, and the moves that lead to it.
#[derive(Clone)]
pub struct Submodel {
    pub header: Header,
    pub moves: Vec<Move>,
}

/// One of the changes that make a system smaller.
#[derive(Clone)]
pub enum Move {
    /// `coordinate = value`
    Hold { coordinate: Expr, value: Expr },
}

impl Move {
    /// Its tokens, to point at.
    pub fn tokens(&self) -> TokenStream {
        match self {
            Move::Hold { coordinate, value } => {
                let equals = <Token![=]>::default();
                [coordinate.to_token_stream(), equals.to_token_stream(), value.to_token_stream()]
                    .into_iter()
                    .collect()
            }
        }
    }
}

/// Reads what follows the name of the type.
pub fn submodel(header: Header, input: ParseStream) -> syn::Result<Submodel> {
    let name = &header.name;
    if !input.peek(Token![:]) {
        let message = format!(
            "a restriction says which coordinates are held\nhelp: write `restriction {name}: phi = 0;`, with as many as there are"
        );
        return Err(syn::Error::new(name.span(), message));
    }
    input.parse::<Token![:]>()?;
    let mut moves = vec![held(input)?];
    while input.peek(Token![,]) {
        input.parse::<Token![,]>()?;
        if input.is_empty() || input.peek(Token![;]) {
            break;
        }
        moves.push(held(input)?);
    }
    Ok(Submodel { header, moves })
}

/// `coordinate = value`
fn held(input: ParseStream) -> syn::Result<Move> {
    let whole: Expr = input.parse()?;
    match whole {
        Expr::Assign(assign) => Ok(Move::Hold { coordinate: *assign.left, value: *assign.right }),
        other => {
            let target = match &other {
                Expr::Binary(binary) => plain(&binary.left),
                other => plain(other),
            };
            let message =
                format!("expected a coordinate and the value that it is held at\nhelp: write `{target} = 0`");
            Err(syn::Error::new_spanned(other, message))
        }
    }
}
