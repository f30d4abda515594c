//! What constraints, prescribed coordinates and impulses add to a generated type.

use super::{Emitter, Output};
use crate::equations::constraints::Kind;
use crate::model::Model;
use proc_macro2::TokenStream;
use quote::quote;

impl Emitter<'_> {
    /// Everything of this file.
    pub fn held(&self) -> TokenStream {
        let (constrained, prescribed, impulses) = (self.constrained(), self.prescribed(), self.impulses());
        quote!(#constrained #prescribed #impulses)
    }

    /// Keeps a run on the constraints.
    pub fn restored(&self) -> TokenStream {
        let (runtime, n, m) = (&self.e.model.runtime, self.n(), self.e.rows.len());
        if m == 0 {
            return TokenStream::new();
        }
        let inlining = self.inlining(super::forced_inlining());
        quote! {
            #inlining
            fn restored(
                &self,
                at: &#runtime::State<S, #n>,
            ) -> ::core::result::Result<::core::option::Option<#runtime::Restored<S, #n>>, #runtime::Failure<S>>
            where
                S: #runtime::Numbers,
            {
                #runtime::restore::<Self, #n, #m>(self, at).map(::core::option::Option::Some)
            }
        }
    }

    /// The bodies of `resolved` and `explained`.
    pub fn why_steps_fail(&self) -> [TokenStream; 2] {
        let (runtime, n, m) = (&self.e.model.runtime, self.n(), self.e.rows.len());
        if m == 0 {
            return [
                quote!(#runtime::system::resolved(self, start, at)),
                quote!(#runtime::failure::explained(self, start, last, failure)),
            ];
        }
        [
            quote!(#runtime::constraint::resolved::<Self, #n, #m>(self, start, at)),
            quote!(#runtime::constraint::explained::<Self, #n, #m>(self, start, last, failure)),
        ]
    }

    fn constrained(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.e.model;
        let (n, rows, vector) = (self.n(), &self.e.rows, self.vector());
        let m = rows.len();
        if m == 0 {
            return quote!(impl<S: #runtime::Scalar> #runtime::Independent<#n> for #name<S> {});
        }
        let of_constraints = quote!(#runtime::SVector<S, #m>);
        let values = self.function(
            quote!(fn constraints(&self, q: &#vector, t: S) -> #of_constraints),
            Output::Vector(&rows.values),
        );
        let rates = self.function(
            self.signature("constraint_rates", of_constraints.clone()),
            Output::Vector(&rows.rates),
        );
        let columns = (0..n).map(|i| rows.jacobian.iter().map(|row| row[i]).collect()).collect();
        let jacobian = self.function(
            quote!(fn constraint_jacobian(&self, q: &#vector, t: S) -> #runtime::SMatrix<S, #m, #n>),
            Output::Matrix(columns),
        );
        let multipliers = self.function(
            self.signature("multipliers", of_constraints.clone()),
            Output::Vector(&self.e.multipliers),
        );
        let (statements, outputs) = self.statements(&self.e.response);
        let (velocities, impulses) = (outputs.part(0..n), outputs.part(n..n + m));
        let given = (0..n).map(|i| quote!(impulse[#i])).chain((0..m).map(|j| quote!(rates[#j])));
        quote! {
            impl<S: #runtime::Scalar> #runtime::Constrained<#n, #m> for #name<S> {
                #values
                #rates
                #jacobian
                #multipliers

                #[inline]
                fn response(
                    &self,
                    q: &#vector,
                    qd: &#vector,
                    t: S,
                    impulse: &#vector,
                    rates: &#of_constraints,
                ) -> (#vector, #of_constraints) {
                    let given = [#(#given),*];
                    #statements
                    (#runtime::SVector::from(#velocities), #runtime::SVector::from(#impulses))
                }
            }

            impl<S: #runtime::Scalar> #runtime::Impulsive<#n> for #name<S> {
                fn jump(&self, at: &#runtime::State<S, #n>, impulse: &#vector) -> #runtime::Jump<S, #n> {
                    #runtime::constrained_jump::<Self, #n, #m>(self, at, impulse)
                }
            }
        }
    }

    fn prescribed(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.e.model;
        let (n, count) = (self.n(), self.e.reactions.len());
        if count == 0 {
            return TokenStream::new();
        }
        let reactions = self.function(
            self.signature("reactions", quote!(#runtime::SVector<S, #count>)),
            Output::Vector(&self.e.reactions),
        );
        quote! {
            impl<S: #runtime::Scalar> #runtime::Prescribed<#n, #count> for #name<S> {
                #reactions
            }
        }
    }

    /// The user's points of impulse as methods.
    fn impulses(&self) -> TokenStream {
        let Model { name, runtime, struck, .. } = &self.e.model;
        if struck.is_empty() {
            return TokenStream::new();
        }
        let vector = self.vector();
        let functions = struck.iter().zip(&self.e.impulses).map(|(s, generalized)| {
            let (attributes, function, k) = (&s.attributes, &s.name, s.position.len());
            let text = super::unless_documented(attributes, || {
                format!("The generalized impulse, in the order of the coordinates, of an impulse at the point `{function}`.")
            });
            let (ty, given) = match s.scalar {
                true => (quote!(S), vec![quote!(impulse)]),
                false => (
                    quote!(&#runtime::SVector<S, #k>),
                    (0..k).map(|i| quote!(impulse[#i])).collect(),
                ),
            };
            let (statements, outputs) = self.statements(generalized);
            let outputs = outputs.array();
            quote! {
                #(#attributes)*
                #text
                #[inline]
                pub fn #function(&self, q: &#vector, t: S, impulse: #ty) -> #vector {
                    let given = [#(#given),*];
                    #statements
                    #runtime::SVector::from(#outputs)
                }
            }
        });
        quote! {
            impl<S: #runtime::Scalar> #name<S> {
                #(#functions)*
            }
        }
    }

    /// What the runtime's `Facts` say about constraints.
    pub fn constraint_facts(&self) -> TokenStream {
        let Model { runtime, constraints, prescribed, .. } = &self.e.model;
        let constraints = constraints.iter().zip(&self.e.rows.kinds).map(|(c, kind)| {
            let name = c.label();
            let kind = match kind {
                Kind::Holonomic => quote!(Holonomic),
                Kind::Integrable => quote!(Integrable),
                Kind::Nonholonomic => quote!(Nonholonomic),
            };
            quote!(#runtime::Constraint { name: #name, kind: #runtime::ConstraintKind::#kind })
        });
        let prescribed = prescribed.iter().map(|p| &p.name);
        quote! {
            constraints: &[#(#constraints),*],
            prescribed: &[#(#prescribed),*],
        }
    }
}
