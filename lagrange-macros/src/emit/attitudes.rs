//! Attitudes and directions of a system by name, in the types of nalgebra.

use super::Emitter;
use crate::model::{ATTITUDE_FUNCTIONS, Attitude, Coordinate, DIRECTION_FUNCTIONS, indexed};
use crate::syntax::Kind;
use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

/// A rotation or a direction, or an array of them.
pub struct Named<'a> {
    pub kind: Kind,
    pub name: &'a Ident,
    /// Index of its first coordinate.
    pub first: usize,
    pub is_array: bool,
}

/// Functions that read and set rotations and directions, of `n` coordinates or of any number.
pub fn methods(
    runtime: &TokenStream,
    n: &TokenStream,
    generic: Option<&TokenStream>,
    named: &Named,
) -> TokenStream {
    match named.kind {
        Kind::Direction => of_direction(runtime, n, generic, named),
        _ => of_rotation(runtime, n, generic, named),
    }
}

fn of_direction(
    runtime: &TokenStream,
    n: &TokenStream,
    generic: Option<&TokenStream>,
    named: &Named,
) -> TokenStream {
    let Named { name, first, is_array, .. } = *named;
    let [read, set] = DIRECTION_FUNCTIONS.map(|prefix| format_ident!("{prefix}{name}", span = name.span()));
    let (argument, place) = match is_array {
        true => (quote!(i: usize,), quote!(#first + 3 * i)),
        false => (quote!(), quote!(#first)),
    };
    let (generics, comma) = (generic.map(|g| quote!(<#g>)), generic.map(|_| quote!(,)));
    let of = if is_array { format!("{name}[i]") } else { name.to_string() };
    let panics = if is_array { "\n\n# Panics\nIf there is no such element." } else { "" };
    let reads = format!("The direction `{of}`, a unit vector to rounding.{panics}");
    let sets = format!(
        "The same state with the direction `{of}` along this vector, of any length but 0, and with what this velocity has across it.{panics}"
    );
    quote! {
        #[doc = #reads]
        pub fn #read #generics(&self, #argument at: &#runtime::State<S, #n>) -> #runtime::Vector3<S> {
            at.direction(#place)
        }
        #[doc = #sets]
        pub fn #set <#generic #comma>(
            &self,
            #argument
            at: #runtime::State<S, #n>,
            direction: &#runtime::Vector3<S>,
            velocity: &#runtime::Vector3<S>,
        ) -> #runtime::State<S, #n>
        where
            S: #runtime::Real,
        {
            at.with_direction(#place, direction, velocity)
        }
    }
}

fn of_rotation(
    runtime: &TokenStream,
    n: &TokenStream,
    generic: Option<&TokenStream>,
    named: &Named,
) -> TokenStream {
    let Named { name, first, is_array, .. } = *named;
    let [read, velocity, set] =
        ATTITUDE_FUNCTIONS.map(|prefix| format_ident!("{prefix}{name}", span = name.span()));
    let (argument, place) = match is_array {
        true => (quote!(i: usize,), quote!(#first + 3 * i)),
        false => (quote!(), quote!(#first)),
    };
    let (generics, comma) = (generic.map(|g| quote!(<#g>)), generic.map(|_| quote!(,)));
    let of = if is_array { format!("{name}[i]") } else { name.to_string() };
    let [panics, also] = match is_array {
        true => ["\n\n# Panics\nIf there is no such element.", " (`R` times it: in those of the parent.)"],
        false => ["", " (`R` times it: in those of the parent.)"],
    };
    let reads = format!(
        "The attitude `{of}`: it takes components in the turned axes to those in the axes of the parent.{panics}"
    );
    let velocities =
        format!("Angular velocity of `{of}`, by its components in the turned axes.{also}{panics}");
    let sets = format!(
        "The same state with this attitude `{of}`, and its angular velocity by its components in the turned axes.{panics}"
    );
    quote! {
        #[doc = #reads]
        pub fn #read #generics(&self, #argument at: &#runtime::State<S, #n>) -> #runtime::UnitQuaternion<S> {
            at.attitude(#place)
        }
        #[doc = #velocities]
        pub fn #velocity #generics(&self, #argument at: &#runtime::State<S, #n>) -> #runtime::Vector3<S> {
            at.angular_velocity(#place)
        }
        #[doc = #sets]
        pub fn #set <#generic #comma>(
            &self,
            #argument
            at: #runtime::State<S, #n>,
            attitude: &#runtime::UnitQuaternion<S>,
            angular_velocity: &#runtime::Vector3<S>,
        ) -> #runtime::State<S, #n>
        where
            S: #runtime::Real,
        {
            at.with_attitude(#place, attitude, angular_velocity)
        }
    }
}

impl Emitter<'_> {
    /// The places of the attitudes, for runs.
    pub fn attitudes(&self) -> Option<TokenStream> {
        let first = self.d.model.attitudes.iter().map(|attitude| attitude.first);
        let any = !self.d.model.attitudes.is_empty();
        any.then(|| quote!(const ATTITUDES: &'static [usize] = &[#(#first),*];))
    }

    /// The components of angular momenta that are constant.
    pub fn symmetries(&self) -> Option<TokenStream> {
        let (runtime, model) = (&self.d.model.runtime, &self.d.model);
        let found = self.d.equations.symmetries.found.iter().map(|s| {
            let Attitude { name, index, first, .. } = &model.attitudes[s.rotation];
            let (label, axis, own) = (indexed(&name.to_string(), *index), s.axis, s.own);
            quote!(#runtime::Symmetry { rotation: #label, first: #first, axis: #axis, own: #own })
        });
        let any = !self.d.equations.symmetries.found.is_empty();
        any.then(|| quote!(const SYMMETRIES: &'static [#runtime::Symmetry] = &[#(#found),*];))
    }

    /// The attitudes and directions by name.
    pub fn named_attitudes(&self) -> Option<TokenStream> {
        let model = &self.d.model;
        let (runtime, name, n) = (&model.runtime, &model.name, self.n());
        let named = |(first, c): (usize, &Coordinate)| {
            let named = Named { kind: c.kind, name: &c.name, first, is_array: c.index.is_some() };
            methods(runtime, &quote!(#n), None, &named)
        };
        let begins = |(_, c): &(usize, &Coordinate)| c.part == Some(0) && c.index.unwrap_or(0) == 0;
        let all: Vec<TokenStream> = model.coordinates.iter().enumerate().filter(begins).map(named).collect();
        (!all.is_empty()).then(|| {
            quote! {
                impl<S: #runtime::Scalar> #name<S> {
                    #(#all)*
                }
            }
        })
    }
}
