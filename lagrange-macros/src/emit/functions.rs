//! The function table as tokens, so that the runtime's `Scalar` is generated from it: `lagrangian! { @functions m }`
//! becomes `m! { sin(x) = sin, sin, "Sine."; [x.cos()] … }`, with literals wrapped for any scalar `S`.

use super::body::constant;
use crate::graph::function::TABLE;
use crate::graph::number::Number;
use proc_macro2::{Group, Ident, Span, TokenStream, TokenTree};
use quote::quote;

/// The invocation of `callback!` with every row of the table.
pub fn functions(callback: &Ident) -> TokenStream {
    let ident = |name: &str| Ident::new(name, Span::call_site());
    let rows = TABLE.iter().map(|row| {
        let (name, std, libm, doc) = (ident(row.name), ident(row.std), ident(row.libm), row.doc);
        let arguments = row.arguments.iter().map(|a| ident(a));
        let derivatives = row.derivatives.iter().map(|text| {
            let tokens: TokenStream = text.parse().expect("the table is written in Rust tokens");
            over_scalar(tokens)
        });
        quote! { #name(#(#arguments),*) = #std, #libm, #doc; [#(#derivatives),*] }
    });
    quote! { #callback! { #(#rows)* } }
}

/// Every literal as a number of `S`, with all digits that it has there.
fn over_scalar(tokens: TokenStream) -> TokenStream {
    tokens
        .into_iter()
        .map(|tree| match tree {
            TokenTree::Literal(literal) => {
                let number = Number::parse(&literal.to_string()).expect("literals of the table are floats");
                constant(number).parse::<TokenStream>().expect("a constant is a call")
            }
            TokenTree::Group(group) => {
                TokenTree::Group(Group::new(group.delimiter(), over_scalar(group.stream()))).into()
            }
            other => other.into(),
        })
        .collect()
}
