//! What a generated type says about small motions.

use super::Emitter;
use crate::graph::Value;
use crate::model::Model;
use proc_macro2::TokenStream;
use quote::quote;

impl Emitter<'_> {
    /// The implementation of `Linearize`.
    pub fn linearize(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.e.model;
        let n = self.n();
        let signature = self.signature("linearize", quote!(#runtime::Linearization<S, #n>));
        let value = match &self.e.linearization {
            None => quote!(#runtime::dual_linearization(&self.map(#runtime::Dual::constant), q, qd, t)),
            Some(l) => {
                let all: Vec<Value> = l.stiffness.iter().chain(&l.damping).flatten().copied().collect();
                let (statements, outputs) = self.statements(&all);
                let stiffness = outputs.columns(0..n * n, n);
                let damping = outputs.columns(n * n..2 * n * n, n);
                quote! {
                    #statements
                    #runtime::Linearization {
                        stiffness: #runtime::SMatrix::from(#stiffness),
                        damping: #runtime::SMatrix::from(#damping),
                    }
                }
            }
        };
        quote! {
            impl<S: #runtime::Scalar> #runtime::Linearize<#n> for #name<S> {
                #signature {
                    #value
                }
            }
        }
    }
}
