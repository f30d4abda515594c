//! Values of the interpreter of the graph at some states beside those of the compiled functions:
//! `lagrangian! { @interpreted [path] … }`. Tests compare the two; nothing else uses it.

use super::outputs::ident;
use crate::equations::Derived;
use crate::equations::check::sample;
use crate::graph::Symbol;
use crate::model::Model;
use crate::program::lower::program;
use crate::table::{Argument, OUTPUTS, Shape};
use proc_macro2::TokenStream;
use quote::quote;

/// States at which the two are compared.
const STATES: u64 = 6;

/// `fn interpreted()`: of every function of the table at some states its name and its values, interpreted and compiled.
pub fn interpreted(d: &Derived) -> TokenStream {
    let Derived { graph, model: Model { name, runtime, parameters, .. }, .. } = d;
    let size = |size| d.size(size);
    let outputs = OUTPUTS.iter().filter_map(|o| Some((o, (o.values)(d)?.values()?)));
    let outputs: Vec<_> = outputs.collect();
    let states = (1..=STATES).map(|trial| {
        let value = |s: Symbol| sample(s, trial, 0);
        let fields = parameters.iter().map(|p| {
            let field = &p.name;
            let mut numbers = p.numbers().map(|i| value(Symbol::Parameter(i)));
            match p.length {
                None => {
                    let number = numbers.next();
                    quote!(#field: #number,)
                }
                Some(_) => quote!(#field: [#(#numbers),*],),
            }
        });
        let system = if parameters.is_empty() { quote!(#name::new()) } else { quote!(#name { #(#fields)* }) };
        let rows = outputs.iter().map(|(output, values)| {
            let (trait_name, function, text) = (ident(output.of), ident(output.name), output.name);
            let mut given = 0;
            let arguments = output.takes.iter().map(|argument: &Argument| {
                let symbol: fn(usize) -> Symbol = match argument.name {
                    "q" => Symbol::Coordinate,
                    "qd" => Symbol::Velocity,
                    "p" => Symbol::Momentum,
                    "t" => |_| Symbol::Time,
                    _ => Symbol::Given,
                };
                let first = given;
                let count = argument.shape.len(&size);
                given += if argument.given { count } else { 0 };
                let numbers = (0..count).map(|i| value(symbol(if argument.given { first + i } else { i })));
                match argument.shape {
                    Shape::Scalar => quote!(#(#numbers),*),
                    _ => quote!(&#runtime::SVector::from([#(#numbers),*])),
                }
            });
            let call = quote!(#runtime::#trait_name::#function(&system, #(#arguments),*));
            let compiled = numbers(quote!(found), output.gives);
            let interpreted = program(graph, values).evaluate(&[], value, |x| x);
            quote!({
                let found = #call;
                (#text, ::std::vec![#(#interpreted),*], #compiled)
            })
        });
        quote!({
            let system = #system;
            all.extend([#(#rows),*]);
        })
    });
    quote! {
        impl #name<f64> {
            #[doc(hidden)]
            #[allow(clippy::all, clippy::pedantic)]
            pub fn interpreted() -> ::std::vec::Vec<(&'static str, ::std::vec::Vec<f64>, ::std::vec::Vec<f64>)> {
                let mut all = ::std::vec::Vec::new();
                #(#states)*
                all
            }
        }
    }
}

/// The numbers of a result, as a vector.
fn numbers(result: TokenStream, shape: Shape) -> TokenStream {
    match shape {
        Shape::Scalar => quote!(::std::vec![#result]),
        Shape::Vector(_) | Shape::Matrix(..) => quote!(#result.as_slice().to_vec()),
        Shape::Structure(_, fields) => {
            let parts = fields.iter().map(|(field, shape)| {
                let field = ident(field);
                numbers(quote!(#result.#field), *shape)
            });
            quote!([#(#parts),*].concat())
        }
        Shape::Tuple(parts) => {
            let parts = parts.iter().enumerate().map(|(i, shape)| {
                let i = syn::Index::from(i);
                numbers(quote!(#result.#i), *shape)
            });
            quote!([#(#parts),*].concat())
        }
    }
}
