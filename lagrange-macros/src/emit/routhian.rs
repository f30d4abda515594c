//! Code for a reduced system: the way there from the whole system, and the way back.

use super::{Emitter, hidden};
use crate::model::{Reduction, Removed};
use proc_macro2::TokenStream;
use quote::quote;

impl Emitter<'_> {
    /// `reduce` of the whole system, and the implementation of `Routhian`.
    pub fn routhian(&self) -> TokenStream {
        let model = &self.d.model;
        let Some(Reduction { of, kept, removed }) = &model.reduction else { return TokenStream::new() };
        let (runtime, name) = (&model.runtime, &model.name);
        let (n, ignorable) = (kept.len(), removed.len());
        let whole = n + ignorable;

        let fields = model.parameters.iter().filter(|p| p.momentum_of.is_none()).map(|p| {
            let field = &p.name;
            quote!(#field: self.#field,)
        });
        let in_lanes = hidden(runtime, false, model.data()).in_lanes;
        let data = model.data().map(|(field, _)| field).chain(&in_lanes);
        let fields = fields.chain(data.map(|field| quote!(#field: self.#field.clone(),)));
        let momenta = removed.iter().map(|Removed { momentum, index, .. }| quote!(#momentum: p[#index],));
        let text = format!(
            "The system [`{name}`] without the ignorable coordinates, with the momenta that they have in `state`, and the \
             state of the other coordinates."
        );
        // Where each coordinate of the whole system comes from.
        let back = |left: TokenStream, out: TokenStream| {
            let entries = (0..whole).map(|i| match kept.iter().position(|k| *k == i) {
                Some(k) => quote!(#left[#k]),
                None => {
                    let r = removed.iter().position(|r| r.index == i);
                    quote!(#out[#r])
                }
            });
            quote!(#runtime::SVector::from([#(#entries),*]))
        };
        let (q, qd) = (back(quote!(state.q), quote!(ignorable)), back(quote!(state.qd), quote!(velocities)));
        let expand = quote! {
            fn expand(
                &self,
                state: &#runtime::State<S, #n>,
                ignorable: &#runtime::SVector<S, #ignorable>,
            ) -> #runtime::State<S, #whole> {
                let velocities = #runtime::Routhian::ignorable_velocities(self, &state.q, &state.qd, state.t);
                #runtime::State { t: state.t, q: #q, qd: #qd }
            }
        };
        let implementation = self.implementation("Routhian", quote!(), expand);
        quote! {
            impl<S: #runtime::Scalar> #of<S> {
                #[doc = #text]
                pub fn reduce(&self, state: &#runtime::State<S, #whole>) -> (#name<S>, #runtime::State<S, #n>) {
                    let p = #runtime::Lagrangian::momenta(self, &state.q, &state.qd, state.t);
                    let reduced = #name { #(#fields)* #(#momenta)* };
                    (reduced, #runtime::State::new(state.t, [#(state.q[#kept]),*], [#(state.qd[#kept]),*]))
                }
            }

            #implementation
        }
    }
}
