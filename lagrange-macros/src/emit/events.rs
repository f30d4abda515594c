//! Events of a system: constants of its type, and the functions behind them.

use super::{Emitter, unless_documented};
use crate::equations::Derived;
use crate::graph::Value;
use crate::model::{Model, NamedEvent, indexed};
use crate::syntax::Direction;
use crate::table::Shape;
use proc_macro2::{Ident, TokenStream};
use quote::quote;

/// The constant of an event of which the first function has this index, with its documentation.
pub fn constant(
    NamedEvent { written: event, values, scalar }: &NamedEvent,
    first: usize,
    runtime: &TokenStream,
    system: &Ident,
) -> TokenStream {
    let constant = Ident::new(&event.constant(), event.name.span());
    let (direction, way) = match event.direction {
        Direction::Rising => (quote!(Rising), "rises"),
        Direction::Falling => (quote!(Falling), "falls"),
        Direction::Either => (quote!(Either), "passes"),
    };
    let text = unless_documented(&event.attributes, || {
        let end = if event.terminal { " A run ends there." } else { "" };
        let of = match *scalar {
            true => format!("Event `{}`: its function", event.name),
            false => {
                format!("Events `{}`, one for each of {} functions: the function", event.name, values.len())
            }
        };
        format!("{of}, in its own unit, {way} through 0.{end}")
    });
    let (attributes, terminal, count) = (&event.attributes, event.terminal, values.len());
    let ty = quote!(#runtime::Event<#runtime::Compiled<#system<f64>>>);
    let value = |i: usize| {
        let label = indexed(&event.name.to_string(), (!scalar).then_some(i));
        let index = first + i;
        quote!(#runtime::Event::compiled(#index, #label, #runtime::Direction::#direction, #terminal))
    };
    let (ty, value) = match scalar {
        true => (ty, value(0)),
        false => {
            let values = (0..count).map(value);
            (quote!([#ty; #count]), quote!([#(#values),*]))
        }
    };
    quote!(#(#attributes)* #text pub const #constant: #ty = #value;)
}

impl Emitter<'_> {
    /// The constants, and the implementation of `CompiledEvents`, if there are events.
    pub fn events(&self) -> Option<TokenStream> {
        let Derived { model: Model { name, runtime, events, .. }, equations, .. } = self.d;
        if events.is_empty() {
            return None;
        }
        let (n, vector) = (self.n(), self.vector());
        let firsts = events.iter().scan(0, |next, event| {
            let first = *next;
            *next += event.values.len();
            Some(first)
        });
        let constants = events.iter().zip(firsts).map(|(event, first)| constant(event, first, runtime, name));
        let functions: Vec<_> = equations.events.iter().flatten().collect();
        let arms = |body: &dyn Fn(usize) -> TokenStream| {
            let last = functions.len() - 1;
            let arms = (0..last).map(|i| {
                let body = body(i);
                quote!(#i => { #body })
            });
            let body = body(last);
            quote!(match event { #(#arms)* _ => { #body } })
        };
        let values = arms(&|i| {
            if let Some(value) = functions[i].by_motion {
                return self.by_motion(Shape::Scalar, &[value]);
            }
            let value = [functions[i].value];
            let (statements, results) = self.statements(&value);
            let value = results.one(0);
            quote!(#statements #value)
        });
        let rates = arms(&|i| {
            let known: Vec<Value> = functions[i].rates.iter().flatten().copied().collect();
            let (statements, results) = self.statements(&known);
            let [first, second] = [0, 1].map(|k| match functions[i].rates[k] {
                Some(_) => {
                    let value = results.one(k);
                    quote!(::core::option::Option::Some(#value))
                }
                None => quote!(::core::option::Option::None),
            });
            quote!(#statements [#first, #second])
        });
        let state = quote!(#runtime::State<S, #n>);
        Some(quote! {
            impl #name<f64> {
                #(#constants)*
            }
            impl<S: #runtime::Scalar> #runtime::CompiledEvents<#n> for #name<S> {
                type Of = #name<f64>;
                #[inline]
                fn event_value(&self, event: usize, at: &#state) -> S {
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    #values
                }
                #[inline]
                fn event_rates(
                    &self,
                    event: usize,
                    at: &#state,
                    accelerations: &#vector,
                ) -> [::core::option::Option<S>; 2] {
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    let given = accelerations;
                    #rates
                }
            }
        })
    }
}
