//! The states of first order by their names.

use super::Emitter;
use crate::model::FirstOrder;
use crate::table::Size;
use proc_macro2::TokenStream;
use quote::quote;

impl Emitter<'_> {
    /// The implementation of `States`, if there are any.
    pub fn states(&self) -> Option<TokenStream> {
        let model = &self.d.model;
        let (runtime, name, n) = (&model.runtime, &model.name, self.n());
        let [m, k] = [Size::Mechanical, Size::States].map(|size| self.d.size(size));
        let labels = model.coordinates[m..].iter().map(|c| c.label());
        let initial = model.states.iter().flat_map(|FirstOrder { initial, .. }| initial);
        (k > 0).then(|| {
            quote! {
                impl<S: #runtime::Scalar> #runtime::States<#n, #m, #k> for #name<S> {
                    const STATES: [&'static str; #k] = [#(#labels),*];
                    fn initial_states(&self) -> #runtime::SVector<S, #k> {
                        #runtime::SVector::from([#(<S as #runtime::Scalar>::from_f64(#initial)),*])
                    }
                }
            }
        })
    }
}
