//! The struct of a system: its fields, constructors, `map`, and what saves it.

use super::{Hidden, argument, as_given, derives, hidden, other_scalar, unless_documented, whole};
use crate::model::{Model, Parameter};
use proc_macro2::{Ident, TokenStream};
use quote::quote;
use syn::Index;

/// The units of parameters, which are not declared.
const UNITS_OF_PARAMETERS: &str = "SI units unless the energies are in others";

/// The struct with its constructors.
pub fn definition(model: &Model, documentation: &[String]) -> TokenStream {
    let hidden = hidden(&model.runtime, model.parameters.is_empty(), model.data());
    let structure = structure(model, &hidden, documentation);
    let [new, default] = constructors(model, &hidden);
    let (map, saved) = (map(model, &hidden), saved(model, &hidden));
    quote!(#structure #new #map #default #saved)
}

fn structure(model: &Model, hidden: &Hidden, documentation: &[String]) -> TokenStream {
    let Model { name, visibility, attributes, parameters, .. } = model;
    let fields = parameters.iter().map(|p| {
        let (attributes, field, ty) = (&p.attributes, &p.name, of_length(p, quote!(S)));
        let text = unless_documented(attributes, || documentation_of(p));
        quote!(#(#attributes)* #text pub #field: #ty,)
    });
    let data = model.data().map(|(field, data)| {
        let (attributes, ty) = (&data.attributes, &data.ty);
        let text = unless_documented(attributes, || {
            format!("Data of the function `{field}`: arguments and values in {UNITS_OF_PARAMETERS}.")
        });
        quote!(#(#attributes)* #text pub #field: #ty,)
    });
    let hidden = &hidden.declared;
    let derives = derives(model.data());
    quote! {
        #(#attributes)*
        #(#[doc = #documentation])*
        #[allow(non_snake_case)]
        #derives
        #visibility struct #name<S = f64> {
            #(#fields)*
            #(#data)*
            #hidden
        }
    }
}

/// The type of a parameter with elements of this one.
fn of_length(p: &Parameter, element: TokenStream) -> TokenStream {
    match p.length {
        None => element,
        Some(n) => quote!([#element; #n]),
    }
}

fn documentation_of(p: &Parameter) -> String {
    let field = &p.name;
    match (p.length, &p.momentum_of) {
        (_, Some(coordinate)) => format!(
            "Constant momentum of `{coordinate}`, in J s per unit of `{coordinate}` (N s of a length, N m s of an angle)."
        ),
        _ if p.rotation => format!(
            "Rotation `{field}`: three parameters without unit, as `by_matrix` and `by_quaternion` of \
             `traits::rotation` make them."
        ),
        (None, None) if p.input => {
            format!("Input `{field}`, in {UNITS_OF_PARAMETERS}; it may change between steps.")
        }
        (Some(n), None) if p.input => format!(
            "Inputs `{field}[0]` to `{field}[{}]`, in {UNITS_OF_PARAMETERS}; they may change between steps.",
            n - 1
        ),
        (None, None) => format!("Parameter `{field}`, in {UNITS_OF_PARAMETERS}."),
        (Some(n), None) => {
            format!("Parameters `{field}[0]` to `{field}[{}]`, in {UNITS_OF_PARAMETERS}.", n - 1)
        }
    }
}

/// `new`, whose arguments are what has no default value, and `Default`, where everything has one.
fn constructors(model: &Model, hidden: &Hidden) -> [TokenStream; 2] {
    let Model { name, parameters, runtime, .. } = model;
    let hidden = &hidden.new;
    let required: Vec<&Parameter> = parameters.iter().filter(|p| p.default.is_none()).collect();
    let arguments = required.iter().map(|p| {
        let (argument, ty) = (argument(&p.name), of_length(p, quote!(f64)));
        quote!(#argument: #ty)
    });
    let arguments = arguments.chain(model.data().map(|(field, data)| {
        let (argument, ty) = (argument(field), &data.ty);
        quote!(#argument: #ty)
    }));
    let set = |p: &Parameter, number: &dyn Fn(f64) -> TokenStream| {
        let field = &p.name;
        match (&p.default, p.length) {
            (None, _) => as_given(field),
            (Some(values), None) => {
                let value = number(values[0]);
                quote!(#field: #value,)
            }
            (Some(values), Some(_)) => {
                let values = values.iter().map(|x| number(*x));
                quote!(#field: [#(#values),*],)
            }
        }
    };
    let values = parameters.iter().map(|p| set(p, &|x| quote!(#x)));
    let values = values.chain(model.data().map(|(field, _)| as_given(field)));
    let given = required.iter().map(|p| &p.name).chain(model.data().map(|(name, _)| name));
    let given: Vec<String> = given.map(|name| format!("`{name}`")).collect();
    let text = if given.is_empty() {
        "System with the default values of its parameters.".to_string()
    } else {
        let others =
            if required.len() < parameters.len() { "; the others have their default values" } else { "" };
        format!("System with these values of {}, each in the unit of its field{others}.", given.join(", "))
    };
    let new = quote! {
        #[allow(non_snake_case, clippy::too_many_arguments, clippy::new_without_default, clippy::excessive_precision)]
        impl #name<f64> {
            #[doc = #text]
            pub const fn new(#(#arguments),*) -> Self {
                #name { #(#values)* #hidden }
            }
        }
    };
    let default = given.is_empty().then(|| {
        let values = parameters.iter().map(|p| set(p, &|x| quote!(<S as #runtime::Scalar>::from_f64(#x))));
        quote! {
            impl<S: #runtime::Scalar> ::core::default::Default for #name<S> {
                fn default() -> Self {
                    #name { #(#values)* #hidden }
                }
            }
        }
    });
    [new, quote!(#default)]
}

fn map(model: &Model, hidden: &Hidden) -> TokenStream {
    let Model { name, parameters, .. } = model;
    let Hidden { in_lanes, marker, .. } = hidden;
    let mapped = parameters.iter().map(|p| {
        let field = &p.name;
        match p.length {
            None => quote!(#field: f(self.#field),),
            Some(_) => quote!(#field: self.#field.map(&mut f),),
        }
    });
    let data = model.data().map(|(field, _)| field).chain(in_lanes).map(|field| quote!(#field: self.#field,));
    let mutable = (!parameters.is_empty()).then(|| quote!(mut));
    let other = other_scalar(name);
    quote! {
        #[allow(non_snake_case, unused_variables, unused_mut)]
        impl<S> #name<S> {
            /// System over another scalar: each parameter through `f`, in its unit. A sweep puts lanes into the
            /// parameters, a sensitivity duals.
            pub fn map<#other>(self, #mutable f: impl ::core::ops::FnMut(S) -> #other) -> #name<#other> {
                #name { #(#mapped)* #(#data)* #marker }
            }
        }
    }
}

fn saved(model: &Model, hidden: &Hidden) -> TokenStream {
    let Model { name, parameters, runtime, .. } = model;
    let hidden = &hidden.new;
    let (text, labels) = (name.to_string(), model.parameter_labels());
    let read = parameters.iter().map(|p| {
        let field = &p.name;
        match p.length {
            None => quote!(#field: next(),),
            Some(n) => quote!(#field: [(); #n].map(|()| next()),),
        }
    });
    let (fields, types): (Vec<&Ident>, Vec<&syn::Type>) =
        model.data().map(|(field, data)| (field, &data.ty)).unzip();
    let places = (0..types.len()).map(Index::from);
    let read = read.chain(fields.iter().zip(places).map(|(field, place)| quote!(#field: data.#place,)));
    let has_data = !types.is_empty();
    let unpacked = has_data.then(|| quote!(let data = data?.0;));
    let whole = whole(model.data());
    quote! {
        #runtime::__saved! {
            #name {
                const SYSTEM: &'static str = #text;
                const LABELS: &'static [&'static str] = &[#(#labels),*];
                const HAS_DATA: bool = #has_data;
                type Data = #runtime::saved::Kept<S, (#(#types,)*)>;
                #[allow(unused_mut)]
                fn numbers(&self, mut each: impl ::core::ops::FnMut(S)) {
                    #whole.map(|x| each(x));
                }
                fn data(&self) -> Self::Data {
                    #runtime::saved::Kept((#(self.#fields.clone(),)*), ::core::marker::PhantomData)
                }
                #[allow(unused_mut, unused_variables)]
                fn of(
                    mut next: impl ::core::ops::FnMut() -> S,
                    data: ::core::option::Option<Self::Data>,
                ) -> ::core::option::Option<Self> {
                    #unpacked
                    ::core::option::Option::Some(#name { #(#read)* #hidden })
                }
            }
        }
    }
}
