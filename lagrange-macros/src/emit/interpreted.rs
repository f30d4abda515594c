//! What the interpreter of the graph says about a system at some states, as a function beside the compiled ones:
//! `lagrangian! { @interpreted [path] … }`. Tests compare the two; nothing else uses it.

use crate::equations::Equations;
use crate::equations::check::sample;
use crate::equations::solve::entry;
use crate::graph::{Symbol, Value};
use proc_macro2::TokenStream;
use quote::quote;

/// States at which the two are compared.
const STATES: u64 = 6;

/// `fn interpreted()`: systems with states and, by name, the values of every function there.
pub fn interpreted(e: &Equations) -> TokenStream {
    let n = e.momenta.len();
    let name = &e.model.name;
    let mut functions: Vec<(&str, Vec<Value>)> = vec![
        ("accel", e.accel.clone()),
        ("lagrangian", vec![e.lagrangian]),
        ("jacobi", vec![e.jacobi]),
        ("dissipation", vec![e.dissipation]),
        ("power", vec![e.power]),
        ("momenta", e.momenta.clone()),
        ("bias", e.bias.clone()),
        ("force", e.force.clone()),
        (
            "inertia",
            (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| entry(&e.inertia, i, j)).collect(),
        ),
    ];
    if let Some(jacobian) = &e.jacobian {
        functions.push((
            "jacobian",
            jacobian.q.iter().chain(&jacobian.qd).chain([&jacobian.t]).flatten().copied().collect(),
        ));
    }
    if let Some([t, v]) = e.energies {
        functions.extend([("kinetic", vec![t]), ("potential", vec![v])]);
    }
    let rows = (1..=STATES).map(|trial| {
        let value = |s: Symbol| sample(s, trial, 0);
        let fields = e.model.parameters.iter().map(|p| {
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
        let system =
            if e.model.parameters.is_empty() { quote!(#name::new()) } else { quote!(#name { #(#fields)* }) };
        let q = (0..n).map(|i| value(Symbol::Coordinate(i)));
        let qd = (0..n).map(|i| value(Symbol::Velocity(i)));
        let t = value(Symbol::Time);
        let outputs = functions.iter().map(|(function, values)| {
            let values = e.model.graph.evaluate(values, value);
            quote!((#function, ::std::vec![#(#values),*]))
        });
        quote!((#system, [#(#q),*], [#(#qd),*], #t, ::std::vec![#(#outputs),*]))
    });
    quote! {
        impl #name<f64> {
            #[doc(hidden)]
            #[allow(clippy::all, clippy::type_complexity)]
            pub fn interpreted() -> ::std::vec::Vec<(Self, [f64; #n], [f64; #n], f64, ::std::vec::Vec<(&'static str, ::std::vec::Vec<f64>)>)> {
                ::std::vec![#(#rows),*]
            }
        }
    }
}
