//! Stubs for a failed compile: the type with every function, so that the rest of the user's crate type-checks
//! and only the mistakes in the system are reported.

use super::attitudes::{Named, methods};
use super::outputs::{Types, at_state, ident};
use super::{MARKERS, argument, as_given, derives, hidden, other_scalar};
use crate::graph::Value;
use crate::model::{NamedEvent, is_function_of};
use crate::syntax::{Data, Declaration, Definition, Header, Kind, Statement, Submodel};
use crate::table::{Argument, Q, STATE, Shape, Size, T, TRAITS, Trait, given};
use proc_macro2::{Ident, Span, TokenStream};
use quote::{ToTokens, quote};
use syn::{Expr, Lit};

/// Generic parameters of the stubs, in words that no type is called by.
const N: &str = "__N";
const IGNORABLE: &str = "__IGNORABLE";
const WHOLE: &str = "__WHOLE";

/// The type, that of its Routhian, and those with coordinates held.
pub fn fallback(definition: &Definition) -> TokenStream {
    let Definition { runtime, header, statements } = definition;
    let derived = statements.iter().find_map(|s| match s {
        Statement::Submodel(asked) if asked.header.is_public() => Some(&asked.header),
        _ => None,
    });
    // A public derived type names the whole one.
    let visibility = derived.unwrap_or(header).visibility.clone();
    let system = stubs(runtime, &Header { visibility, ..header.clone() }, statements);
    let reduced = statements.iter().find_map(|s| match s {
        Statement::Routhian(reduced) if reduced.name != header.name => Some(reduced),
        _ => None,
    });
    let reduced = reduced.map(|reduced| routhian(runtime, header, reduced, statements));
    let mut names = vec![&header.name];
    let submodels = statements.iter().filter_map(|s| match s {
        Statement::Submodel(asked) if !names.contains(&&asked.header.name) => {
            names.push(&asked.header.name);
            Some(restricted(runtime, header, asked, statements))
        }
        _ => None,
    });
    quote!(#system #reduced #(#submodels)*)
}

/// A system of as many coordinates as the statement leaves; where it says too little, of any number.
fn restricted(
    runtime: &TokenStream,
    whole: &Header,
    asked: &Submodel,
    statements: &[Statement],
) -> TokenStream {
    let all = coordinates(statements);
    let removed = asked.moves.iter().filter_map(|m| m.change.removed());
    let held: usize = removed.map(|coordinates| named(coordinates, statements)).sum();
    let kept = all.map(|all| all.checked_sub(held).filter(|kept| *kept > 0).unwrap_or(all));
    let mut left = vec![match kept {
        Some(n) => Statement::Coord((0..n).map(|_| Declaration::named(asked.header.name.clone())).collect()),
        None => Statement::Unread(Vec::new()),
    }];
    left.extend(statements.iter().filter(|s| is_inherited(s)).cloned());
    let stubs = stubs(runtime, &asked.header, &left);
    let (of, name) = (&whole.name, &asked.header.name);
    let generic = |generic| Ident::new(generic, Span::call_site());
    let (generics, [n, i, all]) = match (kept, all) {
        (Some(n), Some(all)) => {
            let removed = all - n;
            (quote!(), [quote!(#n), quote!(#removed), quote!(#all)])
        }
        _ => {
            let [n, i, all] = [N, IGNORABLE, WHOLE].map(generic);
            (
                quote!(const #n: usize, const #i: usize, const #all: usize),
                [quote!(#n), quote!(#i), quote!(#all)],
            )
        }
    };
    quote! {
        #stubs
        const _: () = {
            impl<S: #runtime::Scalar, #generics>
                #runtime::Restricted<#n, #i, #all> for #name<S>
            {
                type Whole = #of<S>;
                const KEPT: [usize; #n] = [0; #n];
                const REMOVED: [usize; #i] = [0; #i];
                const FOLLOWS: [bool; #i] = [false; #i];
                fn of(_: &#of<S>) -> Self {
                    ::core::unreachable!()
                }
                fn held(
                    &self,
                    _: &#runtime::SVector<S, #n>,
                    _: &#runtime::SVector<S, #n>,
                    _: S,
                ) -> (#runtime::SVector<S, #i>, #runtime::SVector<S, #i>) {
                    ::core::unreachable!()
                }
            }
        };
    }
}

/// A system that may have a momentum for each coordinate, and any number of coordinates: which are ignorable is not
/// known. What `reduce` gives has as many as there were, so that the compiler need not ask for their number.
fn routhian(
    runtime: &TokenStream,
    whole: &Header,
    reduced: &Header,
    statements: &[Statement],
) -> TokenStream {
    let momentum = |d: &Declaration| Declaration {
        attributes: Vec::new(),
        name: quote::format_ident!("p_{}", d.name),
        value: None,
        ..d.clone()
    };
    let mut left = vec![Statement::Unread(Vec::new())];
    left.extend(statements.iter().filter_map(|s| match s {
        Statement::Coord(list) => Some(Statement::Param(list.iter().map(momentum).collect())),
        _ => is_inherited(s).then(|| s.clone()),
    }));
    let stubs = stubs(runtime, reduced, &left);
    let (of, name) = (&whole.name, &reduced.name);
    let [n, i, all] = [N, IGNORABLE, WHOLE].map(|generic| Ident::new(generic, Span::call_site()));
    quote! {
        #stubs
        const _: () = {
            impl<S: #runtime::Scalar> #of<S> {
                #[doc(hidden)]
                pub fn reduce<const #n: usize>(
                    &self,
                    _: &#runtime::State<S, #n>,
                ) -> (#name<S>, #runtime::State<S, #n>) {
                    ::core::unreachable!()
                }
            }
            impl<S: #runtime::Scalar, const #n: usize, const #i: usize, const #all: usize>
                #runtime::Routhian<#n, #i, #all> for #name<S>
            {
                fn ignorable_velocities(
                    &self,
                    _: &#runtime::SVector<S, #n>,
                    _: &#runtime::SVector<S, #n>,
                    _: S,
                ) -> #runtime::SVector<S, #i> {
                    ::core::unreachable!()
                }
                fn expand(
                    &self,
                    _: &#runtime::State<S, #n>,
                    _: &#runtime::SVector<S, #i>,
                ) -> #runtime::State<S, #all> {
                    ::core::unreachable!()
                }
            }
        };
    }
}

/// Has a derived system what this statement declares?
fn is_inherited(s: &Statement) -> bool {
    use Statement::{Const, Event, Extern, Let, Observe, Param};
    matches!(s, Const(_) | Param(_) | Let(_) | Observe(_) | Event(_) | Extern { .. })
}

/// Number of the coordinates that an expression names.
fn named(coordinate: &Expr, statements: &[Statement]) -> usize {
    let path = match coordinate {
        Expr::Array(list) => return list.elems.iter().map(|one| named(one, statements)).sum(),
        Expr::Path(path) => path,
        _ => return 1,
    };
    let mut declared = statements.iter().flat_map(Statement::coordinates);
    declared.find(|d| path.path.is_ident(&d.name)).and_then(|d| size(d, statements)).unwrap_or(1)
}

/// The struct and stubs of its implementations: for its number of coordinates, or, where that is not known, for any.
fn stubs(runtime: &TokenStream, header: &Header, statements: &[Statement]) -> TokenStream {
    let stubs = Stubs::of(runtime, &header.name, statements);
    let (structure, construction) = (stubs.structure(header), stubs.construction());
    let (methods, implementations) = (stubs.methods(), stubs.implementations());
    let (engine, choices) = (stubs.engine(), stubs.choices());
    let events = events(runtime, &header.name, statements, &stubs.generic, &stubs.n);
    quote! {
        #structure
        #[allow(non_snake_case, unused_variables, dead_code, clippy::all)]
        const _: () = {
            #construction
            #methods
            #implementations
            #engine
            #choices
            #events
        };
    }
}

/// The parts of stubs, as far as they can be read off.
struct Stubs<'a> {
    runtime: &'a TokenStream,
    name: &'a Ident,
    statements: &'a [Statement],
    parameters: Vec<&'a Declaration>,
    data: Vec<(&'a Ident, &'a Data)>,
    /// The number of coordinates, and the generic parameter for it where it is not known.
    n: TokenStream,
    generic: Option<TokenStream>,
    /// Numbers of first-order states and of inputs.
    states: usize,
    inputs: usize,
}

impl<'a> Stubs<'a> {
    fn of(runtime: &'a TokenStream, name: &'a Ident, statements: &'a [Statement]) -> Self {
        let parameters = first_of_a_name(statements.iter().flat_map(Statement::parameters));
        let (n, generic) = match coordinates(statements) {
            Some(n) => (quote!(#n), None),
            None => {
                let n = Ident::new(N, Span::call_site());
                (quote!(#n), Some(quote!(const #n: usize)))
            }
        };
        let data = data(statements, &parameters);
        let states = total(statements.iter().flat_map(Statement::states), statements);
        let inputs = total(parameters.iter().copied().filter(|p| p.input), statements);
        Stubs { runtime, name, statements, parameters, data, n, generic, states, inputs }
    }

    /// The type of a field in numbers of type `s`.
    fn ty(&self, p: &Declaration, s: TokenStream) -> TokenStream {
        match (&p.length, size(p, self.statements)) {
            (None, _) => s,
            (Some(_), Some(size)) => quote!([#s; #size]),
            (Some(_), None) => quote!([#s; 1]),
        }
    }

    /// The struct itself.
    fn structure(&self, header: &Header) -> TokenStream {
        let Header { name, visibility, attributes, .. } = header;
        let fields = self.parameters.iter().map(|p| {
            let (field, ty) = (&p.name, self.ty(p, quote!(S)));
            quote!(#[doc(hidden)] pub #field: #ty,)
        });
        let data = self.data.iter().map(|(field, Data { ty, .. })| quote!(#[doc(hidden)] pub #field: #ty,));
        let hidden = hidden(self.runtime, self.parameters.is_empty(), self.data.iter().copied()).declared;
        let derives = derives(self.data.iter().copied());
        quote! {
            #(#attributes)*
            #[doc(hidden)]
            #[allow(non_snake_case, dead_code)]
            #derives
            #visibility struct #name<S = f64> {
                #(#fields)*
                #(#data)*
                #hidden
            }
        }
    }

    /// `new`, `map` and `default`.
    fn construction(&self) -> TokenStream {
        let Stubs { runtime, name, parameters, data, .. } = self;
        let other = other_scalar(name);
        let is_asked = |p: &Declaration| p.value.is_none() && !p.input;
        let numbers = parameters.iter().filter(|p| is_asked(p)).map(|p| {
            let (argument, ty) = (argument(&p.name), self.ty(p, quote!(f64)));
            quote!(#argument: #ty)
        });
        let tables = data.iter().map(|(field, Data { ty, .. })| {
            let argument = argument(field);
            quote!(#argument: #ty)
        });
        let required: Vec<TokenStream> = numbers.chain(tables).collect();
        let values = parameters.iter().map(|p| {
            let field = &p.name;
            match (is_asked(p), &p.length) {
                (true, _) => as_given(field),
                (false, None) => quote!(#field: 0.0,),
                (false, Some(_)) => {
                    let size = size(p, self.statements).unwrap_or(1);
                    quote!(#field: [0.0; #size],)
                }
            }
        });
        let tables = data.iter().map(|(field, _)| as_given(field));
        let hidden = hidden(runtime, parameters.is_empty(), data.iter().copied()).new;
        let default = required.is_empty().then(|| {
            quote! {
                impl<S: #runtime::Scalar> ::core::default::Default for #name<S> {
                    fn default() -> Self {
                        ::core::unreachable!()
                    }
                }
            }
        });
        quote! {
            impl #name<f64> {
                #[doc(hidden)]
                pub const fn new(#(#required),*) -> Self {
                    #name { #(#values)* #(#tables)* #hidden }
                }
            }
            impl<S> #name<S> {
                #[doc(hidden)]
                pub fn map<#other>(self, f: impl ::core::ops::FnMut(S) -> #other) -> #name<#other> {
                    ::core::unreachable!()
                }
            }
            #default
        }
    }

    fn types<T>(&self, written: impl FnOnce(Types) -> T) -> T {
        let Stubs { statements, states, .. } = *self;
        let size = |size| match size {
            Size::Coordinates | Size::Whole | Size::Ignorable => self.n.clone(),
            Size::Constraints => constraints(statements).to_token_stream(),
            Size::Prescribed => prescribed(statements).to_token_stream(),
            Size::Inputs => self.inputs.to_token_stream(),
            Size::States => states.to_token_stream(),
            Size::Mechanical => {
                coordinates(statements).unwrap_or(states).saturating_sub(states).to_token_stream()
            }
            Size::Fixed(k) => k.to_token_stream(),
        };
        written(Types { runtime: self.runtime, size: &size })
    }

    fn stub(&self, name: impl ToTokens, takes: &[Argument], gives: Shape) -> TokenStream {
        let signature = self.types(|types| types.signature(name, takes, gives, |_| quote!(_)));
        quote!(#signature { ::core::unreachable!() })
    }

    /// The methods of the type itself: outputs, points of impulse, attitudes.
    fn methods(&self) -> TokenStream {
        let Stubs { runtime, name, statements, .. } = *self;
        let observed = first_of_a_name(statements.iter().flat_map(|s| match s {
            Statement::Observe(d) => std::slice::from_ref(d),
            _ => s.states(),
        }));
        let mut rotations = first_of_a_name(statements.iter().flat_map(Statement::coordinates));
        rotations.retain(|d| d.kind.coordinates() > 1);
        let own = Trait::named("").functions;
        let is_own = |d: &Declaration| {
            own.iter().any(|taken| d.name == taken)
                || rotations.iter().any(|r| is_function_of(&d.name, r.kind, &r.name))
        };
        let generic = self.generic.as_ref().map(|g| quote!(<#g>));
        let outputs = observed.iter().filter(|d| !is_own(d)).map(|d| {
            let (output, shape) = (&d.name, output_shape(d, statements));
            let stub = self.stub(quote!(#output #generic), STATE, shape);
            let at = at_state(output);
            let at_state = (!observed.iter().any(|other| other.name == at)).then(|| {
                let signature = self.types(|types| types.at_state(quote!(#at #generic), shape));
                quote!(#[doc(hidden)] pub #signature { ::core::unreachable!() })
            });
            quote!(#[doc(hidden)] pub #stub #at_state)
        });
        let mut known: Vec<&Ident> = Vec::new();
        let struck = statements.iter().filter_map(|s| match s {
            Statement::Impulse { name, at: Some(at), .. } if !known.contains(&name) => {
                known.push(name);
                let shape = elements(at).map_or(Shape::Scalar, |k| Shape::Vector(Size::Fixed(k)));
                let takes = [Q, T, given("impulse", shape)];
                let stub = self.stub(quote!(#name #generic), &takes, Shape::Vector(Size::Coordinates));
                Some(quote!(#[doc(hidden)] pub #stub))
            }
            _ => None,
        });
        let attitudes = rotations.iter().map(|d| {
            let named = Named { kind: d.kind, name: &d.name, first: 0, is_array: d.length.is_some() };
            methods(runtime, &self.n, self.generic.as_ref(), &named)
        });
        quote! {
            impl<S: #runtime::Scalar> #name<S> {
                #(#outputs)*
                #(#struck)*
                #(#attitudes)*
            }
        }
    }

    /// The traits of the table, and those that only some systems have.
    fn implementations(&self) -> TokenStream {
        let Stubs { runtime, name, statements, ref n, ref generic, states, inputs, .. } = *self;
        // Of constrained systems or of those without constraints.
        let (free, held) = (constraints(statements) == 0, prescribed(statements) > 0);
        let of_table = TRAITS.iter().filter_map(|of| {
            let before = match of.name {
                "Constrained" if free => return None,
                "LegendreTransform" if !free || states > 0 => return None,
                "Prescribed" if !held => return None,
                "InputJacobian" if inputs == 0 => return None,
                "Routhian" | "Restricted" => return None,
                "System" => quote!(
                    type Scalar = S;
                ),
                "Lagrangian" => quote!(const FACTS: #runtime::Facts = #runtime::Facts::UNKNOWN;),
                _ => quote!(),
            };
            let functions: Vec<_> =
                of.outputs().map(|o| self.stub(ident(o.name), o.takes, o.gives)).collect();
            (!functions.is_empty()).then(|| {
                let of = self.types(|types| types.of_trait(of));
                quote! {
                    impl<S: #runtime::Scalar, #generic> #of for #name<S> {
                        #before
                        #(#functions)*
                    }
                }
            })
        });
        let independent = match free && states == 0 {
            true => quote!(impl<S: #runtime::Scalar, #generic> #runtime::Independent<#n> for #name<S> {}),
            false => quote! {
                impl<S: #runtime::Scalar, #generic> #runtime::Impulsive<#n> for #name<S> {
                    fn jump(&self, _: &#runtime::State<S, #n>, _: &#runtime::SVector<S, #n>) -> #runtime::Jump<S, #n> {
                        ::core::unreachable!()
                    }
                }
            },
        };
        let held_inputs = (inputs > 0).then(|| {
            quote! {
                impl<S: #runtime::Scalar, #generic> #runtime::Inputs<#n, #inputs> for #name<S> {
                    const INPUTS: [&'static str; #inputs] = [""; #inputs];
                    fn inputs(&self) -> #runtime::SVector<S, #inputs> {
                        ::core::unreachable!()
                    }
                    fn set_inputs(&mut self, _: &#runtime::SVector<S, #inputs>) {
                        ::core::unreachable!()
                    }
                }
            }
        });
        let first_order = (states > 0).then(|| {
            let m = self.types(|types| (types.size)(Size::Mechanical));
            quote! {
                impl<S: #runtime::Scalar, #generic> #runtime::States<#n, #m, #states> for #name<S> {
                    const STATES: [&'static str; #states] = [""; #states];
                    fn initial_states(&self) -> #runtime::SVector<S, #states> {
                        ::core::unreachable!()
                    }
                }
            }
        });
        quote! {
            #(#of_table)*
            #independent
            #held_inputs
            #first_order
        }
    }

    /// The traits by which methods integrate: all a system may be.
    fn engine(&self) -> TokenStream {
        let Stubs { runtime, name, ref n, ref generic, .. } = *self;
        let (other, vector) = (other_scalar(name), quote!(#runtime::SVector<S, #n>));
        quote! {
            impl<S: #runtime::Scalar, #generic> #runtime::Precompute<#n> for #name<S> {
                type Constants = [S; 0];
                fn constants(&self) -> Self::Constants {
                    ::core::unreachable!()
                }
                fn accel_with(
                    &self,
                    _: &Self::Constants,
                    _: &#vector,
                    _: &#vector,
                    _: S,
                ) -> #vector {
                    ::core::unreachable!()
                }
            }
            impl<S: #runtime::Scalar, #generic> #runtime::lanes::Rescale<#n> for #name<S> {
                type Over<#other: #runtime::Scalar> = #runtime::Precomputed<#name<#other>, #n>;
                fn over<#other: #runtime::Scalar>(&self, f: impl ::core::ops::FnMut(S) -> #other) -> Self::Over<#other> {
                    ::core::unreachable!()
                }
            }
            impl<S: #runtime::Scalar, #generic> #runtime::Analytic<#n> for #name<S> {
                type Sides = #runtime::series::Smooth;
                fn switching(&self, _: &#runtime::State<S, #n>, _: &Self::Sides) -> Self::Sides {
                    ::core::unreachable!()
                }
                fn series_within<const K: usize>(
                    &self,
                    _: &#runtime::State<S, #n>,
                    _: usize,
                    _: &Self::Sides,
                    _: &mut #runtime::TaylorSeries<S, #n, { K }>,
                ) -> [Self::Sides; K] {
                    ::core::unreachable!()
                }
            }
        }
    }

    /// The markers, and the methods that are recommended.
    fn choices(&self) -> TokenStream {
        let Stubs { runtime, name, ref n, ref generic, .. } = *self;
        let markers = MARKERS.map(|marker| {
            let marker = ident(marker);
            quote!(impl<S: #runtime::Scalar, #generic> #runtime::#marker<#n> for #name<S> {})
        });
        let header =
            quote!(impl<S: #runtime::Real, #generic> #runtime::choice::RecommendedMethods<#n> for #name<S>);
        let choices = super::choices(&header, runtime, false, false, false, false);
        quote!(#(#markers)* #choices)
    }
}

/// The constants of events, and their functions.
fn events(
    runtime: &TokenStream,
    system: &Ident,
    statements: &[Statement],
    generic: &Option<TokenStream>,
    n: &TokenStream,
) -> Option<TokenStream> {
    let outputs = statements.iter().flat_map(|statement| match statement {
        Statement::Observe(d) => vec![d.name.to_string()],
        Statement::Impulse { name, .. } => vec![name.to_string()],
        Statement::State(list) => list.iter().map(|d| d.name.to_string()).collect(),
        _ => Vec::new(),
    });
    let mut taken: Vec<String> = outputs.collect();
    let mut constants: Vec<TokenStream> = Vec::new();
    for statement in statements {
        let Statement::Event(event) = statement else { continue };
        if taken.contains(&event.constant()) {
            continue;
        }
        taken.push(event.constant());
        let of_family = event.length.as_ref().map(|length| whole(length, statements).unwrap_or(1));
        let count = event.value.as_ref().and_then(elements).or(of_family);
        let stub = NamedEvent {
            written: event.clone(),
            values: vec![Value::ZERO; count.unwrap_or(1)],
            scalar: count.is_none(),
        };
        constants.push(super::events::constant(&stub, 0, runtime, system));
    }
    (!constants.is_empty()).then(|| {
        quote! {
            impl #system<f64> {
                #(#constants)*
            }
            impl<S: #runtime::Scalar, #generic> #runtime::CompiledEvents<#n> for #system<S> {
                type Of = #system<f64>;
                fn event_value(&self, _: usize, _: &#runtime::State<S, #n>) -> S {
                    ::core::unreachable!()
                }
                fn event_rates(
                    &self,
                    _: usize,
                    _: &#runtime::State<S, #n>,
                    _: &#runtime::SVector<S, #n>,
                ) -> [::core::option::Option<S>; 2] {
                    ::core::unreachable!()
                }
            }
        }
    })
}

/// Number of constraints, as far as it can be read off.
fn constraints(statements: &[Statement]) -> usize {
    let of = |s: &Statement| match s {
        Statement::Constraint { declared, .. } if declared.length.is_some() => {
            size(declared, statements).unwrap_or(1)
        }
        Statement::Constraint { sides, .. } => {
            sides.as_ref().and_then(|(left, _)| elements(left)).unwrap_or(1)
        }
        Statement::Coord(list) => {
            total(list.iter().filter(|d| d.kind == Kind::Direction && d.value.is_none()), statements)
        }
        _ => 0,
    };
    statements.iter().map(of).sum()
}

/// Number of prescribed coordinates.
fn prescribed(statements: &[Statement]) -> usize {
    let coordinates = statements.iter().flat_map(Statement::coordinates);
    total(coordinates.filter(|d| d.value.is_some()), statements)
}

/// Length of an array that is written out.
fn elements(expression: &Expr) -> Option<usize> {
    match expression {
        Expr::Array(array) => Some(array.elems.len()),
        Expr::Paren(inner) => elements(&inner.expr),
        _ => None,
    }
}

/// The fields that hold the data of functions, without those that repeat a name.
fn data<'a>(statements: &'a [Statement], parameters: &[&Declaration]) -> Vec<(&'a Ident, &'a Data)> {
    let mut first: Vec<(&Ident, &Data)> = Vec::new();
    for statement in statements {
        if let Statement::Extern { name, data: Some(data), .. } = statement
            && first.iter().all(|(known, _)| *known != name)
            && parameters.iter().all(|p| p.name != *name)
        {
            first.push((name, data));
        }
    }
    first
}

/// The declarations without those that repeat a name.
fn first_of_a_name<'a>(all: impl IntoIterator<Item = &'a Declaration>) -> Vec<&'a Declaration> {
    let mut first: Vec<&Declaration> = Vec::new();
    for d in all {
        if first.iter().all(|known| known.name != d.name) {
            first.push(d);
        }
    }
    first
}

/// Number of coordinates of the system, if it can be read off.
fn coordinates(statements: &[Statement]) -> Option<usize> {
    if statements.iter().any(|s| matches!(s, Statement::Unread(_))) {
        return None;
    }
    let free = statements.iter().flat_map(Statement::coordinates).filter(|d| d.value.is_none());
    let all = free.chain(statements.iter().flat_map(Statement::states));
    let n = all.map(|d| Some(size(d, statements)? * d.kind.coordinates())).sum::<Option<usize>>();
    n.filter(|n| *n > 0)
}

/// Shape of an output: an array, or the name of one, gives a vector.
fn output_shape(d: &Declaration, statements: &[Statement]) -> Shape {
    let binding = |name: &Ident| {
        statements.iter().find_map(|s| match s {
            Statement::Let(d) if d.name == *name => Some(d),
            _ => None,
        })
    };
    let named = match &d.value {
        _ if statements.iter().flat_map(Statement::states).any(|s| s.name == d.name) => Some(d),
        None => binding(&d.name),
        Some(Expr::Path(path)) => path.path.get_ident().and_then(binding),
        Some(_) => None,
    };
    if let Declaration { value: Some(Expr::Array(array)), .. } = named.unwrap_or(d)
        && let Some(Expr::Array(row)) = array.elems.first()
    {
        return Shape::Matrix(Size::Fixed(array.elems.len()), Size::Fixed(row.elems.len()));
    }
    let elements = match named.unwrap_or(d) {
        Declaration { value: Some(Expr::Array(array)), .. } => Some(array.elems.len()),
        Declaration { length: Some(_), .. } => named.and_then(|d| size(d, statements)),
        _ => None,
    };
    elements.map_or(Shape::Scalar, |n| Shape::Vector(Size::Fixed(n)))
}

/// Sum of the lengths of these declarations, as far as they can be read off.
fn total<'a>(all: impl Iterator<Item = &'a Declaration>, statements: &[Statement]) -> usize {
    all.map(|d| size(d, statements).unwrap_or(1)).sum()
}

/// Length of a declaration as far as it can be read off.
fn size(d: &Declaration, statements: &[Statement]) -> Option<usize> {
    d.length.as_ref().map_or(Some(1), |length| whole(length, statements))
}

/// A length as far as it can be read off: a literal, or a constant of a literal.
fn whole(length: &Expr, statements: &[Statement]) -> Option<usize> {
    let literal = |e: &Expr| match e {
        Expr::Lit(lit) => match &lit.lit {
            Lit::Int(n) => n.base10_parse().ok().filter(|n| (1..=10_000).contains(n)),
            _ => None,
        },
        _ => None,
    };
    literal(length).or_else(|| {
        let Expr::Path(path) = length else { return None };
        statements.iter().find_map(|s| match s {
            Statement::Const(c) if path.path.is_ident(&c.name) => literal(c.value.as_ref()?),
            _ => None,
        })
    })
}
