//! Attitudes and directions of a system by name, in the types of nalgebra.

use super::Emitter;
use crate::equations::symmetry::CommonSymmetry;
use crate::model::{ATTITUDE_FUNCTIONS, Attitude, Coordinate, DIRECTION_FUNCTIONS, Model, indexed};
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
    let Named { name, first, is_array, .. } = *named;
    let (argument, place) = match is_array {
        true => (quote!(i: usize,), quote!(#first + 3 * i)),
        false => (quote!(), quote!(#first)),
    };
    let (generics, comma) = (generic.map(|g| quote!(<#g>)), generic.map(|_| quote!(,)));
    let of = if is_array { format!("{name}[i]") } else { name.to_string() };
    let panics = if is_array { "\n\n# Panics\nIf there is no such element." } else { "" };
    let (vector, state) = (quote!(#runtime::Vector3<S>), quote!(#runtime::State<S, #n>));
    let function = |prefix: &str| format_ident!("{prefix}{name}", span = name.span());
    let reads = |prefix: &str, method: TokenStream, result: &TokenStream, says: String| {
        let (function, says) = (function(prefix), says + panics);
        quote! {
            #[doc = #says]
            pub fn #function #generics(&self, #argument at: &#state) -> #result {
                at.#method
            }
        }
    };
    let sets =
        |prefix: &str, method: TokenStream, [to, rate]: [TokenStream; 2], ty: &TokenStream, says: String| {
            let (function, says) = (function(prefix), says + panics);
            quote! {
                #[doc = #says]
                pub fn #function <#generic #comma>(
                    &self,
                    #argument
                    at: #state,
                    #to: &#ty,
                    #rate: &#vector,
                ) -> #state
                where
                    S: #runtime::Real,
                {
                    at.#method(#place, #to, #rate)
                }
            }
        };
    if named.kind == Kind::Direction {
        let [read, set] = DIRECTION_FUNCTIONS;
        let says = format!(
            "The direction `{of}`: three components without unit in the axes of the world, of length 1 to rounding."
        );
        let read = reads(read, quote!(direction(#place)), &vector, says);
        let says = format!(
            "The state `at` with the direction `{of}` along the vector `direction`, of any length but 0, and with the part of \
             `velocity`, in 1/s, that is perpendicular to it."
        );
        let arguments = [quote!(direction), quote!(velocity)];
        let set = sets(set, quote!(with_direction), arguments, &vector, says);
        return quote!(#read #set);
    }
    let quaternion = quote!(#runtime::UnitQuaternion<S>);
    let [read, velocity, acceleration, set] = ATTITUDE_FUNCTIONS;
    let says = format!(
        "The attitude `{of}`, a unit quaternion: it takes components in the turned axes to those in the axes of the parent."
    );
    let read = reads(read, quote!(attitude(#place)), &quaternion, says);
    let says = format!(
        "Angular velocity of `{of}` in rad/s: three components in the turned axes. The attitude takes them to the axes of \
             the parent."
    );
    let velocity = reads(velocity, quote!(angular_velocity(#place)), &vector, says);
    let says = format!(
        "Angular acceleration of `{of}` in rad/s², by the equations of motion: three components in the turned axes, the \
             rates of those of the angular velocity."
    );
    // (What stands for a system with mistakes has no accelerations.)
    let by = match generic {
        None => quote!(&#runtime::System::accel(self, &at.q, &at.qd, at.t)),
        Some(_) => quote!(&at.qd),
    };
    let acceleration = reads(acceleration, quote!(angular_acceleration(#place, #by)), &vector, says);
    let says = format!(
        "The state `at` with this attitude of `{of}`, and with this angular velocity in rad/s: three components in the \
             turned axes."
    );
    let arguments = [quote!(attitude), quote!(angular_velocity)];
    let set = sets(set, quote!(with_attitude), arguments, &quaternion, says);
    quote!(#read #velocity #acceleration #set)
}

/// The name of a rotation, a direction or a position by its first coordinate.
pub fn turned_name(model: &Model, first: usize) -> String {
    let Coordinate { name, index, part, .. } = &model.coordinates[first];
    indexed(&name.to_string(), index.filter(|_| part.is_some()))
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
        let alone = any.then(|| quote!(const SYMMETRIES: &'static [#runtime::Symmetry] = &[#(#found),*];));
        let all = &self.d.equations.symmetries.common;
        let common = all.iter().map(|CommonSymmetry { turned, axis, .. }| {
            let names = turned.iter().map(|first| turned_name(model, *first));
            quote!(#runtime::CommonSymmetry { turned: &[#(#names),*], axis: #axis })
        });
        let together = (!all.is_empty())
            .then(|| quote!(const COMMON_SYMMETRIES: &'static [#runtime::CommonSymmetry] = &[#(#common),*];));
        Some(quote!(#alone #together))
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
