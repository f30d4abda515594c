//! Equations to Rust: the struct, its implementations of the runtime's traits, and its documentation. Nothing here can
//! fail.

mod attitudes;
mod body;
mod constraints;
mod definition;
pub mod docs;
mod events;
pub mod fallback;
pub mod functions;
mod inputs;
pub mod interpreted;
mod mathml;
mod outputs;
mod restricted;
mod routhian;
pub mod stages;
mod states;
mod taylor;

use crate::equations::Derived;
use crate::equations::scaling::Scalings;
use crate::graph::{Number, Symbol, Value};
use crate::model::frames::Motion;
use crate::model::{External, Model, indexed};
use crate::program::lower::{prepared, program};
use crate::syntax::{Data, Kind};
use crate::table::{Part, STATE, Shape, Size};
use body::{Names, Results, body, variable};
use proc_macro2::{Ident, Span, TokenStream};
use quote::{quote, quote_spanned};
use syn::{Index, spanned::Spanned};

/// Accelerations of more operations are compiled once for each scalar, and called: there a call costs less than 1 %
/// of the instructions (docs/lab/performance.md).
const MAX_INLINED_OPERATIONS: usize = 1000;

/// The generated items.
pub fn emit(d: &Derived) -> TokenStream {
    let names = names(d);
    let emitter = Emitter { d, names: &names };
    let definition = definition::definition(&d.model, &docs::documentation(d));
    let system = emitter.system();
    let lagrangian = emitter.lagrangian();
    let prescribed = emitter.prescribed();
    let [energies, legendre, linearize] = ["Energies", "LegendreTransform", "Linearize"]
        .map(|of| emitter.implementation(of, quote!(), quote!()));
    let markers = emitter.markers();
    let choices = emitter.choices(legendre.is_some());
    let constrained = emitter.constrained();
    let impulses = emitter.impulses();
    let analytic = emitter.analytic();
    let observed = emitter.observed();
    let events = emitter.events();
    let attitudes = emitter.named_attitudes();
    let angular_momenta = emitter.angular_momenta();
    let inputs = emitter.inputs();
    let states = emitter.states();
    let by_inputs = emitter.implementation("InputJacobian", quote!(), quote!());
    let routhian = emitter.routhian();
    let restricted = emitter.restricted();
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
            #energies
            #legendre
            #markers
            #choices
            #constrained
            #prescribed
            #impulses
            #linearize
            #analytic
            #observed
            #states
            #events
            #attitudes
            #angular_momenta
            #inputs
            #by_inputs
            #routhian
            #restricted
        };
    }
}

/// The user's names for nodes: values and rates of bindings.
fn names(d: &Derived) -> Names {
    let bindings: Vec<(String, Value)> = d
        .model
        .bindings
        .iter()
        .zip(&d.equations.formed.flat)
        .flat_map(|(b, &[value, rate])| {
            // A quasi-velocity is the rate of nothing that has a name.
            let suffix = if let Motion::Quasi(_) = b.motion { "" } else { "_dot" };
            [(b.name.clone(), value), (format!("{}{suffix}", b.name), rate)]
        })
        .collect();
    let series = d.equations.series.as_ref();
    Names::new(&d.model, &bindings, series.map_or(0, |series| series.switches.len()))
}

/// The traits that follow from the fields. Data may own memory, which is cloned and not copied.
pub fn derives<'a>(mut data: impl Iterator<Item = (&'a Ident, &'a Data)>) -> TokenStream {
    let copy = data.next().is_none().then(|| quote!(Copy,));
    quote!(#[derive(Clone, #copy Debug, PartialEq)])
}

/// The system behind `self` as a value, which `map` takes: a clone, if it has data.
pub fn whole<'a>(mut data: impl Iterator<Item = (&'a Ident, &'a Data)>) -> TokenStream {
    if data.next().is_some() { quote!(::core::clone::Clone::clone(self)) } else { quote!(self) }
}

/// The fields that nobody declares.
pub struct Hidden {
    /// The field of the data which functions have in lanes, if there are any.
    pub in_lanes: Option<Ident>,
    /// The marker of a system without parameters, in which the scalar would be unused, with its value.
    pub marker: Option<TokenStream>,
    /// The declarations.
    pub declared: TokenStream,
    /// The values of a new system.
    pub new: TokenStream,
}

/// The fields that nobody declares, of a system whose scalar is unused or not.
pub fn hidden<'a>(
    runtime: &TokenStream,
    unused: bool,
    data: impl Iterator<Item = (&'a Ident, &'a Data)>,
) -> Hidden {
    let (names, types): (Vec<&Ident>, Vec<&syn::Type>) = data.map(|(field, data)| (field, &data.ty)).unzip();
    let in_lanes = (!types.is_empty()).then(|| Ident::new(body::IN_LANES, Span::call_site()));
    let taken = names.iter().any(|field| *field == "scalar");
    let scalar = Ident::new(if taken { "scalar_" } else { "scalar" }, Span::call_site());
    let marker = unused.then(|| quote!(#scalar: ::core::marker::PhantomData));
    let lanes = in_lanes.iter();
    let declared =
        lanes.clone().map(|field| quote!(#[doc(hidden)] pub #field: #runtime::DataInLanes<(#(#types,)*)>,));
    let declared = declared.chain(marker.iter().map(|marker| quote!(#marker<S>,))).collect();
    let new = lanes.map(|field| quote!(#field: #runtime::DataInLanes::NONE,));
    let new = new.chain(marker.clone()).collect();
    Hidden { in_lanes, marker, declared, new }
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

/// The methods that are chosen for a system with these facts, see the runtime's `choice`.
pub fn choices(
    header: &TokenStream,
    runtime: &TokenStream,
    analytic: bool,
    separable: bool,
    exact: bool,
    momenta: bool,
) -> TokenStream {
    quote! {
        #header {
            type Accurate = #runtime::choice::Accurate<#separable>;
            type Fine = #runtime::choice::Fine<#analytic, #separable>;
            type FineControl = #runtime::choice::FineControl<#analytic>;
            type Geometric = #runtime::choice::Geometric<#exact, #separable, #momenta>;
        }
    }
}

/// The attribute of a function that is inlined by force, but in builds for debugging: there it would be compiled once
/// for each call.
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

/// Traits that say what is proved, in the order of `Emitter::markers`.
pub const MARKERS: [&str; 5] = ["Separable", "ConstantInertia", "Conservative", "Linear", "Autonomous"];

struct Emitter<'a> {
    d: &'a Derived,
    names: &'a Names,
}

impl Emitter<'_> {
    /// The statements that compute these values, and the values.
    fn statements(&self, values: &[Value]) -> (TokenStream, Results<'_>) {
        body(self.names, &program(&self.d.graph, values))
    }

    fn n(&self) -> usize {
        self.d.model.coordinates.len()
    }

    fn vector(&self) -> TokenStream {
        self.types(|types| types.of(Shape::Vector(Size::Coordinates)))
    }

    /// Functions through which those of the user's are called: a variable of ours cannot hide them here.
    fn externals(&self) -> TokenStream {
        let Model { runtime, externals, .. } = &self.d.model;
        let functions = externals.iter().enumerate().map(|(i, External { name, arity, data })| {
            let function = Ident::new(self.names.external(i), Span::call_site());
            let arguments: Vec<Ident> = (0..*arity)
                .map(|i| Ident::new(&format!("{}_{i}", variable(&name.to_string())), name.span()))
                .collect();
            let (data, call) = match data {
                None => (None, quote_spanned!(name.span()=> #name(#(#arguments),*))),
                Some(Data { ty, .. }) => {
                    let place =
                        Index::from(self.d.model.data().take_while(|(data, _)| *data != name).count());
                    let all = self.d.model.data().map(|(_, data)| &data.ty);
                    let taken = quote!(data: &#ty, lanes: &#runtime::DataInLanes<(#(#all,)*)>,);
                    let value = quote_spanned!(ty.span()=> value::<#ty, S, #arity>);
                    (Some(taken), quote!(lanes.#value(data, |all| &all.#place, [#(#arguments),*])))
                }
            };
            quote! {
                #[inline(always)]
                fn #function<S: #runtime::Scalar>(#data #(#arguments: S),*) -> S {
                    #call
                }
            }
        });
        quote!(#(#functions)*)
    }

    fn system(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.d.model;
        let n = self.n();
        let inline = forced_inlining();
        let accel = self.signature(outputs::ident("accel"), STATE, Shape::Vector(Size::Coordinates));
        let other = other_scalar(name);
        let (restored, prepare, switches) = (self.restored(), self.prepare(), self.switches());
        let kinked = self.kinked();
        let attitudes = self.attitudes();
        let [resolved, explained] = self.why_steps_fail();
        let (scaled, lane) = self.over();
        let autonomous = self.d.equations.facts.autonomous.then(|| {
            quote!(
                const AUTONOMOUS: bool = true;
            )
        });
        let states = self.d.size(Size::States);
        let first_order = (states > 0).then(|| {
            quote!(
                const FIRST_ORDER: usize = #states;
            )
        });
        quote! {
            impl<S: #runtime::Scalar> #runtime::System<#n> for #name<S> {
                type Scalar = S;
                #autonomous
                #first_order
                #attitudes
                #[inline(always)]
                #accel {
                    #runtime::Precompute::accel_with(self, &#runtime::Precompute::constants(self), q, qd, t)
                }
                #restored
                #switches
                #kinked
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
            impl<S: #runtime::Scalar> #runtime::Precompute<#n> for #name<S> {
                #prepare
            }
            impl<S: #runtime::Scalar> #runtime::lanes::Rescale<#n> for #name<S> {
                type Over<#other: #runtime::Scalar> = #runtime::Precomputed<#name<#other>, #n>;
                fn over<#other: #runtime::Scalar>(&self, f: impl ::core::ops::FnMut(S) -> #other) -> Self::Over<#other> {
                    #runtime::Precompute::precomputed(#scaled)
                }
                #lane
            }
        }
    }

    /// The system over other numbers, and the function that gives a lane its data, if there are any.
    fn over(&self) -> (TokenStream, Option<TokenStream>) {
        let Model { name, runtime, .. } = &self.d.model;
        let whole = whole(self.d.model.data());
        let fields = self.d.model.data().map(|(field, _)| field);
        let Some(in_lanes) = hidden(runtime, false, self.d.model.data()).in_lanes else {
            return (quote!(#whole.map(f)), None);
        };
        let other = other_scalar(name);
        let lane = quote! {
            fn set_lane<#other: #runtime::Scalar>(&self, packed: &mut Self::Over<#other>, lane: usize) {
                packed.update(|packed| packed.#in_lanes.set(lane, (#(self.#fields.clone(),)*)));
            }
        };
        (quote!(#whole.map(f)), Some(lane))
    }

    /// Functions with kinks on whose slopes momenta depend, if there may be any.
    fn kinked(&self) -> Option<TokenStream> {
        let Model { runtime, externals, .. } = &self.d.model;
        let slopes = self.d.equations.impulses.slopes.iter().map(|f| {
            let External { name, arity, .. } = &externals[*f];
            let text = name.to_string();
            quote! {
                if #runtime::ExternFunction::<#arity>::has_kinks(&self.#name) {
                    return ::core::option::Option::Some(#text);
                }
            }
        });
        let slopes: TokenStream = slopes.collect();
        (!slopes.is_empty()).then(|| {
            quote! {
                fn kinked(&self) -> ::core::option::Option<&'static str> {
                    #slopes
                    ::core::option::Option::None
                }
            }
        })
    }

    /// Switching functions of the accelerations, if there are any.
    fn switches(&self) -> Option<TokenStream> {
        let (runtime, n, vector) = (&self.d.model.runtime, self.n(), self.vector());
        let switches = &self.d.equations.responses.switches;
        let count = switches.len();
        if count == 0 {
            return None;
        }
        let values: Vec<Value> = switches.iter().flat_map(|(both, _)| *both).collect();
        let (statements, outputs) = self.statements(&values);
        let values = outputs.columns(0..2 * count, 2);
        let cuts = self.cuts();
        let places: Vec<usize> = (0..count).collect();
        let impulses = self.d.equations.impulses.switches.len();
        let impulses = (impulses > 0).then(|| quote!(const IMPULSES: usize = #impulses;));
        let rates: Vec<Value> = switches.iter().map(|([_, rate], _)| *rate).collect();
        let holds = self.d.graph.depends(&rates, |symbol| matches!(symbol, Symbol::Given(_)));
        let holds = holds.then(|| {
            quote!(
                const HOLDS: bool = true;
            )
        });
        Some(quote! {
            #impulses
            #holds
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
            #cuts
        })
    }

    /// The function that tells where the switching functions decide anything, if they do not everywhere.
    fn cuts(&self) -> Option<TokenStream> {
        let (runtime, n) = (&self.d.model.runtime, self.n());
        let switches = self.d.equations.responses.switches.iter().enumerate();
        let (places, cuts): (Vec<usize>, Vec<Value>) =
            switches.filter_map(|(i, (_, cut))| Some((i, (*cut)?))).unzip();
        if cuts.is_empty() {
            return None;
        }
        let (statements, outputs) = self.statements(&cuts);
        let values = outputs.columns(0..cuts.len(), 1);
        let indices = 0..cuts.len();
        Some(quote! {
            fn decides(&self, switch: usize, at: &#runtime::State<S, #n>) -> bool
            where
                S: #runtime::Real,
            {
                let (q, qd, t) = (&at.q, &at.qd, at.t);
                #statements
                let found = #values;
                match switch {
                    #(#places => #runtime::Real::to_f64(found[#indices][0]) < 0.0,)*
                    _ => true,
                }
            }
        })
    }

    /// The accelerations, and what of them can be computed beforehand from the parameters (docs/decisions/0012).
    fn prepare(&self) -> TokenStream {
        let Derived { graph, model: Model { runtime, .. }, equations } = self.d;
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
        if self.d.is_looped() || self.d.is_redundant() {
            let solved = match self.d.is_redundant() {
                true => self.least_norm(Part::Accelerations),
                false => self.solved(&equations.solved.right),
            };
            let signature = signature(quote!(accel_with));
            return quote! {
                type Constants = [S; 0];
                #[inline(always)]
                fn constants(&self) -> Self::Constants {
                    []
                }
                #signature {
                    #solved
                }
            };
        }
        let program = prepared(graph, &equations.solved.accel);
        let count = program.constants.len();
        let (prologue, constants) = self.statements(&program.constants);
        let (statements, outputs) = body(self.names, &program);
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

    /// The attribute of a function that evaluates the equations: `inlined`, unless these are so long that a call
    /// costs nothing beside them. Each stage of each method would have a copy, which took LLVM minutes.
    fn inlining(&self, inlined: TokenStream) -> TokenStream {
        let long = self.d.equations.solved.operations.arithmetic() > MAX_INLINED_OPERATIONS;
        if long { quote!(#[inline(never)]) } else { inlined }
    }

    fn lagrangian(&self) -> Option<TokenStream> {
        let (runtime, facts) = (&self.d.model.runtime, self.facts());
        let symmetries = self.symmetries();
        let facts = quote!(
            const FACTS: #runtime::Facts = #facts;
            #symmetries
        );
        self.implementation("Lagrangian", facts, quote!())
    }

    /// The methods that are chosen, by the facts of the system and whether velocities follow from momenta.
    fn choices(&self, momenta: bool) -> TokenStream {
        let Derived { model: Model { name, runtime, attitudes, .. }, equations, .. } = self.d;
        let (n, facts) = (self.n(), &equations.facts);
        // (Energies drift with each change of an attitude's parameters.)
        let bounded = momenta && equations.formed.rows.is_empty() && attitudes.is_empty();
        choices(
            &quote!(impl<S: #runtime::Real> #runtime::choice::RecommendedMethods<#n> for #name<S>),
            runtime,
            equations.analytic(),
            facts.separable,
            facts.linear && facts.conservative && facts.autonomous,
            bounded,
        )
    }

    /// Traits without functions.
    fn markers(&self) -> TokenStream {
        let Derived { model: Model { name, runtime, .. }, equations, .. } = self.d;
        let (n, facts, free) = (self.n(), &equations.facts, equations.formed.rows.is_empty());
        let markers = [
            facts.separable,
            facts.constant_inertia,
            facts.conservative && free,
            facts.linear,
            facts.autonomous,
        ];
        let markers = MARKERS.into_iter().zip(markers).filter(|m| m.1).map(|(marker, _)| {
            let marker = outputs::ident(marker);
            quote!(impl<S: #runtime::Scalar> #runtime::#marker<#n> for #name<S> {})
        });
        markers.collect()
    }

    /// Tokens of the runtime's `Facts` about changes of scale. Where these are not known, each parameter matters.
    fn scalings(&self) -> TokenStream {
        let Derived { model, equations, .. } = self.d;
        let (runtime, labels) = (&model.runtime, model.parameter_labels());
        let whole = |k: &Number| {
            let k = k.integer().and_then(|k| i32::try_from(k).ok());
            k.expect("exponents of groups and similarities are whole numbers")
        };
        let group = |factors: &[(usize, Number)]| {
            let powers = factors.iter().map(|(i, k)| (&labels[*i], whole(k)));
            let powers = powers.map(|(name, power)| quote!((#name, #power)));
            quote!(&[#(#powers),*])
        };
        let (groups, similar): (Vec<_>, Vec<_>) = match &equations.scalings {
            Some(Scalings { groups, similar, .. }) => {
                (groups.iter().map(|factors| group(factors)).collect(), similar.iter().collect())
            }
            None => ((0..labels.len()).map(|i| group(&[(i, Number::ONE)])).collect(), Vec::new()),
        };
        let similar = similar.into_iter().map(|exponents| {
            let (time, coordinates) = (whole(&exponents[0]), exponents[1..].iter().map(whole));
            quote!(#runtime::Similarity { time: #time, coordinates: &[#(#coordinates),*] })
        });
        quote! {
            dimensionless_groups: &[#(#groups),*],
            similarities: &[#(#similar),*],
        }
    }

    fn facts(&self) -> TokenStream {
        let Model { name, runtime, .. } = &self.d.model;
        let text = name.to_string();
        let coordinates = self.d.model.coordinates.iter().map(|c| indexed(&c.name.to_string(), c.index));
        let inputs = self.d.model.input_labels();
        let kinds = self.d.model.coordinates.iter().map(|c| match c.kind {
            Kind::Angle => quote!(#runtime::CoordinateKind::Angle),
            Kind::Length => quote!(#runtime::CoordinateKind::Length),
            Kind::Rotation => quote!(#runtime::CoordinateKind::Rotation),
            Kind::Direction => quote!(#runtime::CoordinateKind::Direction),
            Kind::Plain => quote!(#runtime::CoordinateKind::Plain),
            Kind::State => quote!(#runtime::CoordinateKind::State),
        });
        let f = &self.d.equations.facts;
        let (scleronomic, conservative, separable) = (f.scleronomic, f.conservative, f.separable);
        let (constant_inertia, quadratic, linear) = (f.constant_inertia, f.quadratic, f.linear);
        let (autonomous, quadratic_forces, linear_damping) =
            (f.autonomous, f.quadratic_forces, f.linear_damping);
        let analytic = self.d.equations.analytic();
        let ignorable = &f.ignorable;
        let [blocks, cascade] = [&f.blocks, &f.cascade]
            .map(|groups| groups.iter().map(|group| quote!(&[#(#group),*])).collect::<Vec<_>>());
        let o = &self.d.equations.solved.operations;
        let (additions, multiplications, divisions) = (o.additions, o.multiplications, o.divisions);
        let (sin_cos, functions) = (o.sin_cos, o.functions);
        let constraints = self.constraint_facts();
        let scalings = self.scalings();
        quote! {
            #runtime::Facts {
                name: #text,
                coordinates: &[#(#coordinates),*],
                kinds: &[#(#kinds),*],
                inputs: &[#(#inputs),*],
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
                cascade: &[#(#cascade),*],
                #scalings
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
