//! Equations to Rust: the struct, its implementations of the runtime's traits, and its documentation. Nothing here can
//! fail.

mod body;
mod constraints;
mod docs;
pub mod fallback;
pub mod functions;
pub mod interpreted;
mod linearization;
mod mathml;
mod routhian;
mod taylor;

use crate::equations::Equations;
use crate::equations::solve::entry;
use crate::graph::Value;
use crate::model::frames::Motion;
use crate::model::{External, Model, Parameter, indexed};
use crate::schedule::count::operations;
use crate::schedule::{schedule, schedule_prepared};
use crate::syntax::Kind;
use body::{Names, Results, body, variable};
use proc_macro2::{Ident, Span, TokenStream};
use quote::{quote, quote_spanned};

/// Accelerations of more operations are solved for by loops.
const LOOPED: usize = 5000;
/// Accelerations of more operations are compiled once for each scalar, and called: there a call costs less than 1 % of the instructions
/// (docs/performance.md).
const MAX_INLINED_OPERATIONS: usize = 1000;
/// An inertia matrix of more operations is found by duals.
const INERTIA_BUDGET: usize = 1000;

/// The generated items.
pub fn emit(mut e: Equations) -> TokenStream {
    let documentation = docs::documentation(&mut e);
    let names = names(&e);
    let emitter = Emitter { e: &e, names: &names };
    let definition = structure(&e.model, &documentation);
    let system = emitter.system();
    let lagrangian = emitter.lagrangian();
    let optional = emitter.optional();
    let held = emitter.held();
    let linearize = emitter.linearize();
    let analytic = emitter.analytic();
    let outputs = emitter.outputs();
    let routhian = emitter.routhian();
    let externals = emitter.externals();
    let allow = quote! {
        #[allow(
            non_snake_case, unused_variables, unused_parens, clippy::all, clippy::pedantic, clippy::nursery,
            clippy::restriction
        )]
    };
    quote! {
        #definition
        #allow
        const _: () = {
            #externals
            #system
            #lagrangian
            #optional
            #held
            #linearize
            #analytic
            #outputs
            #routhian
        };
    }
}

/// The user's names for nodes: values and rates of bindings.
fn names(e: &Equations) -> Names {
    let bindings: Vec<(String, Value)> = e
        .model
        .bindings
        .iter()
        .zip(&e.flat)
        .flat_map(|(b, &[value, rate])| {
            // A quasi-velocity is the rate of nothing that has a name.
            let suffix = if let Motion::Quasi(_) = b.motion { "" } else { "_dot" };
            [(b.name.clone(), value), (format!("{}{suffix}", b.name), rate)]
        })
        .collect();
    let sizes = e.series.as_ref().map_or([0; 2], |series| [series.given(), series.switches.len()]);
    Names::new(&e.model, &bindings, sizes)
}

/// The struct with its constructors.
pub fn structure(model: &Model, documentation: &[String]) -> TokenStream {
    let Model { name, visibility, attributes, parameters, runtime, .. } = model;
    let field_type = |p: &Parameter, s: TokenStream| match p.length {
        None => s,
        Some(n) => quote!([#s; #n]),
    };
    let fields = parameters.iter().map(|p| {
        let (attributes, field, ty) = (&p.attributes, &p.name, field_type(p, quote!(S)));
        let fallback = unless_documented(attributes, || match (p.length, &p.momentum_of) {
            (_, Some(coordinate)) => format!("The constant momentum of `{coordinate}`."),
            (None, None) => format!("Parameter `{field}`."),
            (Some(n), None) => format!("Parameters `{field}[0]` to `{field}[{}]`.", n - 1),
        });
        quote!(#(#attributes)* #fallback pub #field: #ty,)
    });
    // Without parameters the scalar would be unused.
    let phantom = parameters.is_empty().then(|| quote!(scalar: ::core::marker::PhantomData<S>,));
    let phantom_value = parameters.is_empty().then(|| quote!(scalar: ::core::marker::PhantomData,));

    let required: Vec<&Parameter> = parameters.iter().filter(|p| p.default.is_none()).collect();
    let arguments = required.iter().map(|p| {
        let (argument, ty) = (argument(&p.name), field_type(p, quote!(f64)));
        quote!(#argument: #ty)
    });
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
    let new_doc = if required.is_empty() {
        "The system with the default values of its parameters.".to_string()
    } else {
        let list: Vec<String> = required.iter().map(|p| format!("`{}`", p.name)).collect();
        let others =
            if required.len() < parameters.len() { "; the others have their default values" } else { "" };
        format!("The system with these values of {}{others}.", list.join(", "))
    };
    let default = required.is_empty().then(|| {
        let values = parameters.iter().map(|p| set(p, &|x| quote!(<S as #runtime::Scalar>::from_f64(#x))));
        quote! {
            impl<S: #runtime::Scalar> ::core::default::Default for #name<S> {
                fn default() -> Self {
                    #name { #(#values)* #phantom_value }
                }
            }
        }
    });
    let mapped = parameters.iter().map(|p| {
        let field = &p.name;
        match p.length {
            None => quote!(#field: f(self.#field),),
            Some(_) => quote!(#field: self.#field.map(&mut f),),
        }
    });
    let mutable = (!parameters.is_empty()).then(|| quote!(mut));
    let other = other_scalar(name);
    quote! {
        #(#attributes)*
        #(#[doc = #documentation])*
        #[allow(non_snake_case)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        #visibility struct #name<S = f64> {
            #(#fields)*
            #phantom
        }

        #[allow(non_snake_case, clippy::too_many_arguments, clippy::new_without_default, clippy::excessive_precision)]
        impl #name<f64> {
            #[doc = #new_doc]
            pub const fn new(#(#arguments),*) -> Self {
                #name { #(#values)* #phantom_value }
            }
        }

        #[allow(non_snake_case, unused_variables, unused_mut)]
        impl<S> #name<S> {
            /// The same system over other numbers: each parameter through `f`. A sweep puts lanes into the
            /// parameters, a sensitivity duals.
            pub fn map<#other>(self, #mutable f: impl ::core::ops::FnMut(S) -> #other) -> #name<#other> {
                #name { #(#mapped)* #phantom_value }
            }
        }

        #default
    }
}

/// The argument of `new` for a parameter: a field's name may be that of a constant, which no argument can have.
pub fn argument(field: &Ident) -> Ident {
    Ident::new(&variable(&field.to_string()), field.span())
}

/// A field of the argument for it.
pub fn as_given(field: &Ident) -> TokenStream {
    let argument = argument(field);
    if argument == *field { quote!(#field,) } else { quote!(#field: #argument,) }
}

/// The generic parameter for other numbers, which is not called as the system is.
pub fn other_scalar(system: &Ident) -> Ident {
    Ident::new(if system == "R" { "R_" } else { "R" }, Span::call_site())
}

/// The attribute of a function that is inlined by force, but in builds for debugging: there it would be compiled once for each call.
pub fn forced_inlining() -> TokenStream {
    quote!(#[cfg_attr(not(debug_assertions), inline(always))])
}

/// A documentation of ours for what the user has not documented.
fn unless_documented(attributes: &[syn::Attribute], text: impl FnOnce() -> String) -> Option<TokenStream> {
    let documented = attributes.iter().any(|a| a.path().is_ident("doc"));
    (!documented).then(|| {
        let text = text();
        quote!(#[doc = #text])
    })
}

/// Results of an emitted function.
enum Output<'a> {
    Scalar(Value),
    Vector(&'a [Value]),
    Matrix(Vec<Vec<Value>>),
}

struct Emitter<'a> {
    e: &'a Equations,
    names: &'a Names,
}

impl Emitter<'_> {
    /// The statements that compute these values, and the values.
    fn statements(&self, values: &[Value]) -> (TokenStream, Results<'_>) {
        let g = &self.e.model.graph;
        body(g, self.names, &schedule(g, values))
    }

    /// A trait method computing these outputs.
    fn function(&self, signature: TokenStream, output: Output) -> TokenStream {
        let inline = forced_inlining();
        let runtime = &self.e.model.runtime;
        let flat: Vec<Value> = match &output {
            Output::Scalar(v) => vec![*v],
            Output::Vector(values) => values.to_vec(),
            Output::Matrix(columns) => columns.concat(),
        };
        let (statements, outputs) = self.statements(&flat);
        let result = match output {
            Output::Scalar(_) => outputs.one(0),
            Output::Vector(_) => {
                let outputs = outputs.array();
                quote!(#runtime::SVector::from(#outputs))
            }
            Output::Matrix(columns) => {
                let columns = outputs.columns(0..flat.len(), columns.first().map_or(1, Vec::len));
                quote!(#runtime::SMatrix::from(#columns))
            }
        };
        quote! {
            #inline
            #signature {
                #statements
                #result
            }
        }
    }

    /// Arguments `(&self, q, qd, t)` of a function called `name`.
    fn signature(&self, name: &str, returns: TokenStream) -> TokenStream {
        let (runtime, n) = (&self.e.model.runtime, self.n());
        let name = Ident::new(name, Span::call_site());
        quote! {
            fn #name(&self, q: &#runtime::SVector<S, #n>, qd: &#runtime::SVector<S, #n>, t: S) -> #returns
        }
    }

    fn n(&self) -> usize {
        self.e.momenta.len()
    }

    fn vector(&self) -> TokenStream {
        let (runtime, n) = (&self.e.model.runtime, self.n());
        quote!(#runtime::SVector<S, #n>)
    }

    fn scalar_function(&self, name: &str, value: Value) -> TokenStream {
        self.function(self.signature(name, quote!(S)), Output::Scalar(value))
    }

    fn vector_function(&self, name: &str, values: &[Value]) -> TokenStream {
        self.function(self.signature(name, self.vector()), Output::Vector(values))
    }

    /// Functions through which those of the user's are called: a variable of ours cannot hide them here.
    fn externals(&self) -> TokenStream {
        let Model { runtime, externals, .. } = &self.e.model;
        let functions = externals.iter().enumerate().map(|(i, External { name, arity })| {
            let function = Ident::new(self.names.external(i), Span::call_site());
            let arguments: Vec<Ident> = (0..*arity)
                .map(|i| Ident::new(&format!("{}_{i}", variable(&name.to_string())), name.span()))
                .collect();
            let call = quote_spanned!(name.span()=> #name(#(#arguments),*));
            quote! {
                #[inline(always)]
                fn #function<S: #runtime::Scalar>(#(#arguments: S),*) -> S {
                    #call
                }
            }
        });
        quote!(#(#functions)*)
    }

    fn system(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.e.model;
        let n = self.n();
        let inline = forced_inlining();
        let accel = self.signature("accel", self.vector());
        let other = other_scalar(name);
        let (restored, prepare, switches) = (self.restored(), self.prepare(), self.switches());
        let [resolved, explained] = self.why_steps_fail();
        let autonomous = self.e.facts.autonomous.then(|| {
            quote!(
                const AUTONOMOUS: bool = true;
            )
        });
        quote! {
            impl<S: #runtime::Scalar> #runtime::System<#n> for #name<S> {
                type Scalar = S;
                #autonomous
                #[inline(always)]
                #accel {
                    #runtime::Prepare::accel_with(self, &#runtime::Prepare::constants(self), q, qd, t)
                }
                #restored
                #switches
                #inline
                fn resolved(
                    &self,
                    start: &#runtime::State<S, #n>,
                    at: &#runtime::State<S, #n>,
                ) -> ::core::result::Result<(), #runtime::Failure<S>>
                where
                    S: #runtime::Real,
                {
                    #resolved
                }
                fn explained(
                    &self,
                    start: &#runtime::State<S, #n>,
                    last: &#runtime::State<S, #n>,
                    failure: #runtime::Failure<S>,
                ) -> #runtime::Failure<S>
                where
                    S: #runtime::Real,
                {
                    #explained
                }
            }
            impl<S: #runtime::Scalar> #runtime::Prepare<#n> for #name<S> {
                #prepare
            }
            impl<S: #runtime::Scalar> #runtime::lanes::Rescale<#n> for #name<S> {
                type Over<#other: #runtime::Scalar> = #runtime::Prepared<#name<#other>, #n>;
                fn over<#other: #runtime::Scalar>(&self, f: impl ::core::ops::FnMut(S) -> #other) -> Self::Over<#other> {
                    #runtime::Prepare::prepared(self.map(f))
                }
            }
        }
    }

    /// Switching functions of the accelerations, if there are any.
    fn switches(&self) -> Option<TokenStream> {
        let (runtime, n, vector) = (&self.e.model.runtime, self.n(), self.vector());
        let count = self.e.switches.len();
        if count == 0 {
            return None;
        }
        let (statements, outputs) = self.statements(&self.e.switches.concat());
        let values = outputs.columns(0..2 * count, 2);
        let places: Vec<usize> = (0..count).collect();
        Some(quote! {
            const SWITCHES: usize = #count;
            fn switches(
                &self,
                at: &#runtime::State<S, #n>,
                accelerations: &#vector,
                mut each: impl ::core::ops::FnMut(usize, [S; 2]),
            ) {
                let (q, qd, t) = (&at.q, &at.qd, at.t);
                let given = accelerations;
                #statements
                let found: [[S; 2]; #count] = #values;
                #(each(#places, found[#places]);)*
            }
        })
    }

    /// The accelerations, and what of them can be computed beforehand from the parameters (docs/decisions/0012).
    fn prepare(&self) -> TokenStream {
        let Model { runtime, graph, .. } = &self.e.model;
        let (n, vector) = (self.n(), self.vector());
        let signature = |name: TokenStream| {
            quote! {
                fn #name(
                    &self,
                    constants: &Self::Constants,
                    q: &#runtime::SVector<S, #n>,
                    qd: &#runtime::SVector<S, #n>,
                    t: S,
                ) -> #vector
            }
        };
        if self.looped() {
            let accel = self.solved(signature(quote!(accel_with)), &self.e.right);
            return quote! {
                type Constants = [S; 0];
                #[inline(always)]
                fn constants(&self) -> Self::Constants {
                    []
                }
                #accel
            };
        }
        let program = schedule_prepared(graph, &self.e.accel);
        let count = program.constants.len();
        let (prologue, constants) = self.statements(&program.constants);
        let (statements, outputs) = body(graph, self.names, &program);
        let (constants, outputs) = (constants.array(), outputs.array());
        let (called, inlined) = (signature(quote!(accel_with)), signature(quote!(accel_inlined)));
        let inline = forced_inlining();
        let inlining = self.inlining(quote!(#[inline]));
        quote! {
            type Constants = [S; #count];
            #inline
            fn constants(&self) -> Self::Constants {
                #prologue
                #constants
            }
            #inlining
            #called {
                S::evaluate(#runtime::lanes::Accelerations { system: self, constants, q, qd, t })
            }
            #inline
            #inlined {
                #statements
                #runtime::SVector::from(#outputs)
            }
        }
    }

    /// Is M eliminated by loops at run time? That takes no longer than the same in straight lines, and these take long to
    /// compile when there are many.
    fn looped(&self) -> bool {
        let e = self.e;
        e.operations.arithmetic() > LOOPED
            && e.rows.is_empty()
            && e.inertia.iter().enumerate().all(|(i, row)| !row[i].is_zero())
    }

    /// The attribute of a function that evaluates the equations: `inlined`, unless these are so long that a call costs nothing beside them.
    /// Each stage of each method would have a copy, which took LLVM minutes.
    fn inlining(&self, inlined: TokenStream) -> TokenStream {
        let long = self.e.operations.arithmetic() > MAX_INLINED_OPERATIONS;
        if long { quote!(#[inline(never)]) } else { inlined }
    }

    /// A function that solves M x = right.
    fn solved(&self, signature: TokenStream, right: &[Value]) -> TokenStream {
        let (runtime, n) = (&self.e.model.runtime, self.n());
        let all: Vec<Value> = self.e.inertia.iter().flatten().chain(right).copied().collect();
        let (statements, outputs) = self.statements(&all);
        let (lower, right) = (outputs.part(0..all.len() - n), outputs.part(all.len() - n..all.len()));
        quote! {
            #signature {
                #statements
                #runtime::solved(&#lower, #right)
            }
        }
    }

    fn lagrangian(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.e.model;
        let (e, n) = (self.e, self.n());
        let facts = self.facts();
        let scalars = [
            ("lagrangian", e.lagrangian),
            ("jacobi", e.jacobi),
            ("dissipation", e.dissipation),
            ("power", e.power),
        ]
        .map(|(name, value)| self.scalar_function(name, value));
        let vectors = [("momenta", &e.momenta), ("bias", &e.bias), ("force", &e.force)]
            .map(|(name, values)| self.vector_function(name, values));
        let inertia = self.inertia();
        let jacobian = self.jacobian();
        let roots = e.series.as_ref().is_some_and(|series| series.has_roots(&e.model.graph));
        let roots = roots.then(|| {
            quote!(
                const ROOTS: bool = true;
            )
        });
        let inline = forced_inlining();
        let series = e.analytic().then(|| {
            quote! {
                #roots
                #inline
                fn motion_series<const K: usize>(
                    &self,
                    at: &#runtime::State<S, #n>,
                    order: usize,
                    motion: &mut #runtime::Series<S, #n, { K }>,
                ) -> bool {
                    #runtime::Analytic::series_within(self, at, order, &#runtime::Analytic::sides(self, at), motion);
                    true
                }
            }
        });
        quote! {
            impl<S: #runtime::Scalar> #runtime::Lagrangian<#n> for #name<S> {
                const FACTS: #runtime::Facts = #facts;
                #(#scalars)*
                #(#vectors)*
                #inertia
                #jacobian
                #series
            }
        }
    }

    /// M, by duals where its n² entries are more than the system itself.
    fn inertia(&self) -> TokenStream {
        let (e, n, runtime) = (self.e, self.n(), &self.e.model.runtime);
        let signature = self.signature("inertia", quote!(#runtime::SMatrix<S, #n, #n>));
        let entries: Vec<Value> = e.inertia.iter().flatten().copied().collect();
        if operations(&e.model.graph, &entries).arithmetic() > INERTIA_BUDGET && !self.looped() {
            return quote! {
                #signature {
                    #runtime::dual_inertia(&self.map(#runtime::Dual::constant), q, qd, t)
                }
            };
        }
        let columns = (0..n).map(|j| (0..n).map(|i| entry(&e.inertia, i, j)).collect()).collect();
        self.function(signature, Output::Matrix(columns))
    }

    fn jacobian(&self) -> TokenStream {
        let (runtime, n) = (&self.e.model.runtime, self.n());
        let signature = self.signature("jacobian", quote!(#runtime::Jacobian<S, #n>));
        let Some(jacobian) = &self.e.jacobian else {
            return quote! {
                #signature {
                    #runtime::dual_jacobian(&self.map(#runtime::Dual::constant), q, qd, t)
                }
            };
        };
        let inline = forced_inlining();
        let all: Vec<Value> =
            jacobian.q.iter().chain(&jacobian.qd).chain([&jacobian.t]).flatten().copied().collect();
        let (statements, outputs) = self.statements(&all);
        let (q, qd) = (outputs.columns(0..n * n, n), outputs.columns(n * n..2 * n * n, n));
        let t = outputs.part(2 * n * n..all.len());
        quote! {
            #inline
            #signature {
                #statements
                #runtime::Jacobian {
                    q: #runtime::SMatrix::from(#q),
                    qd: #runtime::SMatrix::from(#qd),
                    t: #runtime::SVector::from(#t),
                }
            }
        }
    }

    /// Traits that only some systems have.
    fn optional(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.e.model;
        let (e, n) = (self.e, self.n());
        let energies = e.energies.map(|[t, v]| {
            let kinetic = self.scalar_function("kinetic", t);
            let signature = quote!(fn potential(&self, q: &#runtime::SVector<S, #n>, t: S) -> S);
            let potential = self.function(signature, Output::Scalar(v));
            quote! {
                impl<S: #runtime::Scalar> #runtime::Energies<#n> for #name<S> {
                    #kinetic
                    #potential
                }
            }
        });
        let legendre = e.velocities.as_ref().map(|velocities| {
            let vector = self.vector();
            let signature = quote!(fn velocities(&self, q: &#vector, p: &#vector, t: S) -> #vector);
            let velocities = if self.looped() {
                self.solved(signature, &e.driven)
            } else {
                self.function(signature, Output::Vector(velocities))
            };
            quote! {
                impl<S: #runtime::Scalar> #runtime::Legendre<#n> for #name<S> {
                    #velocities
                }
            }
        });
        let (facts, free) = (&e.facts, e.rows.is_empty());
        let markers = [
            (facts.separable, quote!(Separable)),
            (facts.constant_inertia, quote!(ConstantInertia)),
            (facts.conservative && free, quote!(Conservative)),
            (facts.linear, quote!(Linear)),
            (facts.autonomous, quote!(Autonomous)),
        ]
        .into_iter()
        .filter(|m| m.0)
        .map(|(_, marker)| quote!(impl<S: #runtime::Scalar> #runtime::#marker<#n> for #name<S> {}));
        quote!(#energies #legendre #(#markers)*)
    }

    /// The user's `observe`d quantities as methods.
    fn outputs(&self) -> TokenStream {
        let Model { name, runtime, observed, .. } = &self.e.model;
        if observed.is_empty() {
            return TokenStream::new();
        }
        let functions = observed.iter().zip(&self.e.observed).map(|(o, values)| {
            let (attributes, count) = (&o.attributes, values.len());
            let returns = if o.scalar { quote!(S) } else { quote!(#runtime::SVector<S, #count>) };
            let signature = self.signature(&o.name.to_string(), returns);
            let output = if o.scalar { Output::Scalar(values[0]) } else { Output::Vector(values) };
            let text = unless_documented(attributes, || format!("The observed quantity `{}`.", o.name));
            self.function(quote!(#(#attributes)* #text pub #signature), output)
        });
        quote! {
            impl<S: #runtime::Scalar> #name<S> {
                #(#functions)*
            }
        }
    }

    fn facts(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.e.model;
        let text = name.to_string();
        let coordinates = self.e.model.coordinates.iter().map(|c| indexed(&c.name.to_string(), c.index));
        let kinds = self.e.model.coordinates.iter().map(|c| match c.kind {
            Kind::Angle => quote!(#runtime::Kind::Angle),
            Kind::Length => quote!(#runtime::Kind::Length),
            Kind::Plain => quote!(#runtime::Kind::Plain),
        });
        let f = &self.e.facts;
        let (scleronomic, conservative, separable) = (f.scleronomic, f.conservative, f.separable);
        let (constant_inertia, quadratic, linear) = (f.constant_inertia, f.quadratic, f.linear);
        let (autonomous, quadratic_forces, linear_damping) =
            (f.autonomous, f.quadratic_forces, f.linear_damping);
        let analytic = self.e.analytic();
        let ignorable = &f.ignorable;
        let blocks = f.blocks.iter().map(|block| quote!(&[#(#block),*]));
        let o = &self.e.operations;
        let (additions, multiplications, divisions) = (o.additions, o.multiplications, o.divisions);
        let (sin_cos, functions) = (o.sin_cos, o.functions);
        let constraints = self.constraint_facts();
        quote! {
            #runtime::Facts {
                name: #text,
                coordinates: &[#(#coordinates),*],
                kinds: &[#(#kinds),*],
                scleronomic: #scleronomic,
                autonomous: #autonomous,
                conservative: #conservative,
                linear_damping: #linear_damping,
                ignorable: &[#(#ignorable),*],
                separable: #separable,
                constant_inertia: #constant_inertia,
                quadratic: #quadratic,
                quadratic_forces: #quadratic_forces,
                linear: #linear,
                analytic: #analytic,
                blocks: &[#(#blocks),*],
                #constraints
                operations: #runtime::Operations {
                    additions: #additions,
                    multiplications: #multiplications,
                    divisions: #divisions,
                    sin_cos: #sin_cos,
                    functions: #functions,
                },
            }
        }
    }
}
