//! What a failed compile still emits: the type with every function, so that the rest of the user's crate type-checks
//! and only the mistakes in the system are reported.

use crate::syntax::{Declaration, Definition, Statement};
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Expr, Lit};

/// The struct and stubs of its implementations. Array lengths that are not plain literals or constants are unknown
/// here; nothing is emitted for such a system but the struct.
pub fn fallback(definition: &Definition) -> TokenStream {
    let Definition { runtime, header, statements } = definition;
    let (name, visibility) = (&header.name, &header.visibility);
    let declarations = |wanted: fn(&Statement) -> Option<&Vec<Declaration>>| {
        statements.iter().filter_map(wanted).flatten().collect::<Vec<_>>()
    };
    let parameters = declarations(|s| match s {
        Statement::Param(list) => Some(list),
        _ => None,
    });
    let coordinates = declarations(|s| match s {
        Statement::Coord(list) => Some(list),
        _ => None,
    });
    let mut seen = Vec::new();
    let parameters: Vec<&Declaration> = parameters
        .into_iter()
        .filter(|p| {
            let new = !seen.contains(&&p.name);
            seen.push(&p.name);
            new
        })
        .collect();
    let sizes: Option<Vec<usize>> =
        coordinates.iter().filter(|c| c.value.is_none()).map(|c| size(c, statements)).collect();
    let n: usize = sizes.map_or(1, |sizes| sizes.into_iter().sum::<usize>().max(1));
    let ty = |p: &Declaration, s: TokenStream| match (&p.length, size(p, statements)) {
        (None, _) => s,
        (Some(_), Some(size)) => quote!([#s; #size]),
        (Some(_), None) => quote!([#s; 1]),
    };
    let fields = parameters.iter().map(|p| {
        let (field, ty) = (&p.name, ty(p, quote!(S)));
        quote!(#[doc(hidden)] pub #field: #ty,)
    });
    let required = parameters.iter().filter(|p| p.value.is_none()).map(|p| {
        let (field, ty) = (&p.name, ty(p, quote!(f64)));
        quote!(#field: #ty)
    });
    let phantom = parameters.is_empty().then(|| quote!(scalar: ::core::marker::PhantomData<S>,));
    let observed = statements.iter().filter_map(|s| match s {
        Statement::Observe(d) => Some(d),
        _ => None,
    });
    let mut seen = Vec::new();
    let observed: Vec<TokenStream> = observed
        .filter(|d| {
            let new = !seen.contains(&&d.name);
            seen.push(&d.name);
            new && !matches!(d.name.to_string().as_str(), "new" | "map")
        })
        .map(|d| {
            let output = &d.name;
            let returns = match &d.value {
                Some(Expr::Array(array)) => {
                    let count = array.elems.len();
                    quote!(#runtime::SVector<S, #count>)
                }
                _ => quote!(S),
            };
            quote! {
                #[doc(hidden)]
                pub fn #output(&self, _: &#runtime::SVector<S, #n>, _: &#runtime::SVector<S, #n>, _: S) -> #returns {
                    ::core::unreachable!()
                }
            }
        })
        .collect();
    let stub = |name: TokenStream, returns: TokenStream| {
        quote! {
            fn #name(&self, _: &#runtime::SVector<S, #n>, _: &#runtime::SVector<S, #n>, _: S) -> #returns {
                ::core::unreachable!()
            }
        }
    };
    let vector = quote!(#runtime::SVector<S, #n>);
    let accel = stub(quote!(accel), vector.clone());
    let scalars =
        [quote!(lagrangian), quote!(jacobi), quote!(dissipation), quote!(power)].map(|f| stub(f, quote!(S)));
    let vectors = [quote!(momenta), quote!(bias), quote!(force)].map(|f| stub(f, vector.clone()));
    let inertia = stub(quote!(inertia), quote!(#runtime::SMatrix<S, #n, #n>));
    let jacobian = stub(quote!(jacobian), quote!(#runtime::Jacobian<S, #n>));
    let kinetic = stub(quote!(kinetic), quote!(S));
    let markers = [quote!(Separable), quote!(ConstantInertia), quote!(Conservative), quote!(Linear)]
        .map(|m| quote!(impl<S: #runtime::Scalar> #runtime::#m<#n> for #name<S> {}));
    quote! {
        #[doc(hidden)]
        #[allow(non_snake_case, dead_code)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        #visibility struct #name<S = f64> {
            #(#fields)*
            #phantom
        }

        #[allow(non_snake_case, unused_variables, dead_code, clippy::all)]
        const _: () = {
            impl #name<f64> {
                #[doc(hidden)]
                pub const fn new(#(#required),*) -> Self {
                    ::core::unreachable!()
                }
            }
            impl<S> #name<S> {
                #[doc(hidden)]
                pub fn map<R>(self, f: impl FnMut(S) -> R) -> #name<R> {
                    ::core::unreachable!()
                }
            }
            impl<S: #runtime::Scalar> #name<S> {
                #(#observed)*
            }
            impl<S: #runtime::Scalar> ::core::default::Default for #name<S> {
                fn default() -> Self {
                    ::core::unreachable!()
                }
            }
            impl<S: #runtime::Scalar> #runtime::System<#n> for #name<S> {
                type Scalar = S;
                #accel
            }
            impl<S: #runtime::Scalar> #runtime::Lagrangian<#n> for #name<S> {
                const FACTS: #runtime::Facts = #runtime::Facts::UNKNOWN;
                #(#scalars)*
                #(#vectors)*
                #inertia
                #jacobian
            }
            impl<S: #runtime::Scalar> #runtime::Energies<#n> for #name<S> {
                #kinetic
                fn potential(&self, _: &#vector, _: S) -> S {
                    ::core::unreachable!()
                }
            }
            impl<S: #runtime::Scalar> #runtime::Legendre<#n> for #name<S> {
                fn velocities(&self, _: &#vector, _: &#vector, _: S) -> #vector {
                    ::core::unreachable!()
                }
            }
            #(#markers)*
        };
    }
}

/// Length of a declaration as far as it can be read off: a literal, or a constant of a literal.
fn size(d: &Declaration, statements: &[Statement]) -> Option<usize> {
    let literal = |e: &Expr| match e {
        Expr::Lit(lit) => match &lit.lit {
            Lit::Int(n) => n.base10_parse().ok().filter(|n| *n <= 10_000),
            _ => None,
        },
        _ => None,
    };
    let Some(length) = &d.length else { return Some(1) };
    literal(length).or_else(|| {
        let Expr::Path(path) = length else { return None };
        statements.iter().find_map(|s| match s {
            Statement::Const(c) if path.path.is_ident(&c.name) => literal(c.value.as_ref()?),
            _ => None,
        })
    })
}
