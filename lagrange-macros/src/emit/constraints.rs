//! Code for constraints and prescribed coordinates beside the functions of the table.

use super::{Emitter, forced_inlining, whole};
use crate::equations::Derived;
use crate::equations::constraints::{ConstraintKind, Redundancy};
use crate::graph::Symbol;
use crate::model::Model;
use crate::table::{Shape, Size};
use proc_macro2::TokenStream;
use quote::quote;

impl Emitter<'_> {
    /// Keeps a run on the constraints, and says what they admit.
    pub fn restored(&self) -> Option<TokenStream> {
        let (runtime, n, m) = (&self.d.model.runtime, self.n(), self.d.size(Size::Constraints));
        let (inlining, whole) = (self.inlining(forced_inlining()), whole(self.d.model.data()));
        (m > 0).then(|| {
            quote! {
                #inlining
                fn restored(
                    &self,
                    at: &#runtime::State<S, #n>,
                ) -> ::core::result::Result<::core::option::Option<#runtime::Restored<S, #n>>, #runtime::Failure<S>>
                where
                    S: #runtime::SimdScalar,
                {
                    #runtime::restore::<Self, #n, #m>(self, at).map(::core::option::Option::Some)
                }
                const CONSTRAINTS: usize = #m;
                #[inline]
                fn accel_at(&self, at: &#runtime::State<S, #n>) -> #runtime::SVector<S, #n> {
                    #runtime::constraint::motion::<Self, true, false, #n, #m, #n>(self, at, |_, accelerations, _| *accelerations)
                }
                fn independence(&self, start: &#runtime::State<S, #n>, at: &#runtime::State<S, #n>) -> f64
                where
                    S: #runtime::Real,
                {
                    #runtime::constraint::independence::<Self, #n, #m>(self, start, at)
                }
                fn determined(
                    &self,
                    start: &#runtime::State<S, #n>,
                    at: &#runtime::State<S, #n>,
                ) -> ::core::result::Result<(), #runtime::Failure<S>>
                where
                    S: #runtime::Real,
                {
                    #runtime::constraint::determined::<Self, #n, #m>(self, start, at)
                }
                fn differentiable(
                    &self,
                    from: &#runtime::State<S, #n>,
                    to: &#runtime::State<S, #n>,
                ) -> ::core::result::Result<(), #runtime::Failure<S>>
                where
                    S: #runtime::Real,
                {
                    #runtime::constraint::differentiable::<Self, #n, #m>(self, from, to)
                }
                fn begun_across(
                    &self,
                    at: &#runtime::State<S, #n>,
                ) -> ::core::option::Option<#runtime::Begun<S, #n>>
                where
                    S: #runtime::Real,
                {
                    #runtime::constraint::begun_across::<Self, #n, #m>(self, at)
                }
                fn restored_across(
                    &self,
                    reference: &#runtime::State<S, #n>,
                    at: &#runtime::State<S, #n>,
                    h: S,
                ) -> ::core::option::Option<#runtime::State<S, #n>>
                where
                    S: #runtime::Real,
                {
                    #runtime::constraint::restored_across::<Self, #n, #m>(self, reference, at, h)
                }
                fn accel_across(
                    &self,
                    reference: &#runtime::State<S, #n>,
                    at: &#runtime::State<S, #n>,
                    h: S,
                    roughly: bool,
                ) -> #runtime::SVector<S, #n>
                where
                    S: #runtime::Real,
                {
                    #runtime::constraint::accel_across::<Self, #n, #m>(self, reference, at, h, roughly)
                }
                fn constraint_terms(
                    &self,
                    at: &#runtime::State<S, #n>,
                    each: impl ::core::ops::FnMut(#runtime::ConstraintTerms<S, #n>),
                ) {
                    #runtime::admissible::terms::<Self, _, #n, #m>(self, &#whole.map(#runtime::Dual::constant), at, each);
                }
                fn toward_constraints(&self, at: &#runtime::State<S, #n>) -> #runtime::State<S, #n> {
                    #runtime::admissible::toward::<Self, #n, #m>(self, at)
                }
            }
        })
    }

    /// The bodies of `resolved` and `explained`.
    pub fn why_steps_fail(&self) -> [TokenStream; 2] {
        let (runtime, n, m) = (&self.d.model.runtime, self.n(), self.d.size(Size::Constraints));
        let is_definite = self.d.equations.formed.is_definite;
        if m == 0 {
            return [
                quote!(#runtime::diagnosis::resolved(self, start, at, #is_definite)),
                quote!(#runtime::diagnosis::explained(self, start, last, failure)),
            ];
        }
        [
            quote!(#runtime::constraint::resolved::<Self, #n, #m>(self, start, at, #is_definite)),
            quote!(#runtime::constraint::explained::<Self, #n, #m>(self, start, last, failure)),
        ]
    }

    /// `Constrained` with `Impulsive`, or `Independent`.
    pub fn constrained(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.d.model;
        let (n, m) = (self.n(), self.d.size(Size::Constraints));
        let Some(constrained) = self.implementation("Constrained", quote!(), quote!()) else {
            // States of first order are no coordinates.
            if self.d.model.states.is_empty() {
                return quote!(impl<S: #runtime::Scalar> #runtime::Independent<#n> for #name<S> {});
            }
            let jump = quote!(#runtime::jump_beside_states::<Self, #n>(self, at, impulse));
            return if self.d.equations.facts.quadratic { self.impulsive(&jump) } else { quote!() };
        };
        let impulsive =
            self.impulsive(&quote!(#runtime::constrained_jump::<Self, #n, #m>(self, at, impulse)));
        quote! {
            #constrained

            #impulsive
        }
    }

    /// `Impulsive` of a system that is not `Independent`.
    fn impulsive(&self, jump: &TokenStream) -> TokenStream {
        let (Model { name, runtime, .. }, n) = (&self.d.model, self.n());
        quote! {
            impl<S: #runtime::Scalar> #runtime::Impulsive<#n> for #name<S> {
                fn jump(&self, at: &#runtime::State<S, #n>, impulse: &#runtime::SVector<S, #n>) -> #runtime::Jump<S, #n> {
                    #jump
                }
            }
        }
    }

    /// `Prescribed`, if there are such coordinates.
    pub fn prescribed(&self) -> Option<TokenStream> {
        let Derived { model, equations, .. } = self.d;
        let gives = Shape::Vector(Size::Prescribed);
        let at_state = (!model.constraints.is_empty()).then(|| {
            let signature = self.types(|types| types.at_state(quote!(reactions_at), gives));
            let body = self.by_motion(gives, &equations.solved.relaxed);
            quote!(#[inline] #signature { #body })
        });
        self.implementation("Prescribed", quote!(), quote!(#at_state))
    }

    /// The rank of constraints that follow from others, if it is known.
    pub fn rank(&self) -> TokenStream {
        match self.d.equations.formed.rows.redundancy.as_ref().and_then(|r| r.rank) {
            Some(rank) => quote!(::core::option::Option::Some(#rank)),
            None => quote!(::core::option::Option::None),
        }
    }

    /// Tokens of the runtime's `Facts` about constraints.
    pub fn constraint_facts(&self) -> TokenStream {
        let Model { runtime, constraints, prescribed, .. } = &self.d.model;
        let rows = &self.d.equations.formed.rows;
        let inputs: Vec<Symbol> = self.d.model.inputs().map(Symbol::Parameter).collect();
        let constraints = constraints.iter().zip(&rows.kinds).enumerate().map(|(j, (c, kind))| {
            let name = c.label();
            let has_input =
                self.d.graph.symbols(&[rows.values[j], rows.rates[j]]).iter().any(|s| inputs.contains(s));
            let kind = match kind {
                ConstraintKind::Holonomic => quote!(Holonomic),
                ConstraintKind::Integrable => quote!(Integrable),
                ConstraintKind::Nonholonomic => quote!(Nonholonomic),
            };
            quote! {
                #runtime::Constraint { name: #name, kind: #runtime::ConstraintKind::#kind, has_input: #has_input }
            }
        });
        let prescribed = prescribed.iter().map(|p| &p.name);
        let label = |j: &usize| self.d.model.constraints[*j].label();
        let redundancy = match &self.d.equations.formed.rows.redundancy {
            None => quote!(::core::option::Option::None),
            Some(Redundancy { undetermined, superfluous, .. }) => {
                let (rank, undetermined) = (self.rank(), undetermined.iter().map(label));
                let superfluous = superfluous.iter().map(|set| {
                    let labels = set.iter().map(label);
                    quote!(&[#(#labels),*])
                });
                quote! {
                    ::core::option::Option::Some(#runtime::Redundancy {
                        rank: #rank,
                        undetermined: &[#(#undetermined),*],
                        superfluous: &[#(#superfluous),*],
                    })
                }
            }
        };
        quote! {
            constraints: &[#(#constraints),*],
            redundancy: #redundancy,
            prescribed: &[#(#prescribed),*],
        }
    }
}
