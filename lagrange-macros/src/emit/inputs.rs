//! The inputs of a system as a vector.

use super::Emitter;
use crate::model::Parameter;
use proc_macro2::TokenStream;
use quote::quote;

impl Emitter<'_> {
    /// The implementation of `Inputs`, if there are any.
    pub fn inputs(&self) -> Option<TokenStream> {
        let model = &self.d.model;
        let (runtime, name, n) = (&model.runtime, &model.name, model.coordinates.len());
        let labels = model.input_labels();
        let (count, places) = (labels.len(), 0..labels.len());
        let fields = |p: &Parameter| -> Vec<TokenStream> {
            let field = &p.name;
            match p.length {
                None => vec![quote!(self.#field)],
                Some(length) => (0..length).map(|i| quote!(self.#field[#i])).collect(),
            }
        };
        let fields: Vec<TokenStream> = model.parameters.iter().filter(|p| p.input).flat_map(fields).collect();
        (count > 0).then(|| {
            quote! {
                impl<S: #runtime::Scalar> #runtime::Inputs<#n, #count> for #name<S> {
                    const INPUTS: [&'static str; #count] = [#(#labels),*];
                    fn inputs(&self) -> #runtime::SVector<S, #count> {
                        #runtime::SVector::from([#(#fields),*])
                    }
                    fn set_inputs(&mut self, inputs: &#runtime::SVector<S, #count>) {
                        #(#fields = inputs[#places];)*
                    }
                }
            }
        })
    }
}
