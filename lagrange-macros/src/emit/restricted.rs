//! Code for a system with coordinates held: the way there from the whole system, and the way back.

use super::{Emitter, Hidden, hidden};
use crate::model::submodel::Origin;
use proc_macro2::TokenStream;
use quote::quote;

impl Emitter<'_> {
    /// The implementation of `Restricted`.
    pub fn restricted(&self) -> Option<TokenStream> {
        let model = &self.d.model;
        let Origin { of, kept, held, .. } = model.origin.as_ref()?;
        let (name, n, count) = (&model.name, kept.len(), held.len());
        let removed = held.iter().map(|held| held.index);
        let follows = held.iter().map(|held| held.follows);
        let fields = model.parameters.iter().map(|p| {
            let field = &p.name;
            quote!(#field: whole.#field,)
        });
        let Hidden { in_lanes, marker, .. } =
            hidden(&model.runtime, model.parameters.is_empty(), model.data());
        let data = model.data().map(|(field, _)| field).chain(&in_lanes);
        let fields = fields.chain(data.map(|field| quote!(#field: whole.#field.clone(),)));
        let before = quote! {
            type Whole = #of<S>;
            const KEPT: [usize; #n] = [#(#kept),*];
            const REMOVED: [usize; #count] = [#(#removed),*];
            const FOLLOWS: [bool; #count] = [#(#follows),*];
            fn of(whole: &#of<S>) -> Self {
                #name { #(#fields)* #marker }
            }
        };
        self.implementation("Restricted", before, quote!())
    }
}
