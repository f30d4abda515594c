//! The functions of the table of outputs as tokens, and the user's outputs, which are like them.

use super::body::Results;
use super::{Emitter, docs, forced_inlining, unless_documented, whole};
use crate::equations::constraints::ConstraintKind;
use crate::equations::{Derived, symmetry};
use crate::graph::{Symbol, Value};
use crate::model::{Layout, Model, Observed};
use crate::table::{Argument, Computation, Inlining, Output, Part, Q, STATE, Shape, Size, T, Trait, given};
use proc_macro2::{Ident, Span, TokenStream};
use quote::{ToTokens, format_ident, quote};
use std::ops::Range;

/// Notation of the types of the table where a system stands.
pub struct Types<'a> {
    pub runtime: &'a TokenStream,
    /// Lengths as generic arguments.
    pub size: &'a dyn Fn(Size) -> TokenStream,
}

pub fn ident(name: &str) -> Ident {
    Ident::new(name, Span::call_site())
}

impl Types<'_> {
    pub fn of(&self, shape: Shape) -> TokenStream {
        let (runtime, size) = (self.runtime, self.size);
        match shape {
            Shape::Scalar => quote!(S),
            Shape::Vector(n) => {
                let n = size(n);
                quote!(#runtime::SVector<S, #n>)
            }
            Shape::Matrix(rows, columns) => {
                let (rows, columns) = (size(rows), size(columns));
                quote!(#runtime::SMatrix<S, #rows, #columns>)
            }
            Shape::Structure(name, _) => {
                let (name, n) = (ident(name), size(Size::Coordinates));
                quote!(#runtime::#name<S, #n>)
            }
            Shape::Tuple(parts) => {
                let parts = parts.iter().map(|part| self.of(*part));
                quote!((#(#parts),*))
            }
        }
    }

    /// `fn name(&self, …) -> …`, with the arguments under these names.
    pub fn signature(
        &self,
        name: impl ToTokens,
        takes: &[Argument],
        gives: Shape,
        named: impl Fn(&Argument) -> TokenStream,
    ) -> TokenStream {
        let arguments = takes.iter().map(|argument| {
            let (name, ty) = (named(argument), self.of(argument.shape));
            let by = if let Shape::Scalar = argument.shape { quote!() } else { quote!(&) };
            quote!(#name: #by #ty)
        });
        let gives = self.of(gives);
        quote!(fn #name(&self, #(#arguments),*) -> #gives)
    }

    /// The head of a function of a state.
    pub fn at_state(&self, name: impl ToTokens, gives: Shape) -> TokenStream {
        let (runtime, n, gives) = (self.runtime, (self.size)(Size::Coordinates), self.of(gives));
        quote!(fn #name(&self, at: &#runtime::State<S, #n>) -> #gives)
    }

    /// The trait with its generic arguments.
    pub fn of_trait(&self, of: &Trait) -> TokenStream {
        let (runtime, name) = (self.runtime, ident(of.name));
        let sizes = of.sizes.iter().map(|size| (self.size)(*size));
        quote!(#runtime::#name<#(#sizes),*>)
    }
}

/// The name of the function of a state beside that of (q, q̇, t).
pub fn at_state(name: &Ident) -> Ident {
    format_ident!("{name}_at")
}

/// An argument under its own name.
pub fn named(argument: &Argument) -> TokenStream {
    ident(argument.name).to_token_stream()
}

impl Emitter<'_> {
    /// The implementation of a trait, with these items before and after the functions of the table; none if all are
    /// missing.
    pub fn implementation(&self, of: &str, before: TokenStream, after: TokenStream) -> Option<TokenStream> {
        let Model { name, runtime, .. } = &self.d.model;
        let of = Trait::named(of);
        let functions: Vec<TokenStream> = of.outputs().filter_map(|output| self.output(output)).collect();
        let of = self.types(|types| types.of_trait(of));
        (!functions.is_empty()).then(|| {
            quote! {
                impl<S: #runtime::Scalar> #of for #name<S> {
                    #before
                    #(#functions)*
                    #after
                }
            }
        })
    }

    /// A function of the table, unless the system has none.
    fn output(&self, output: &Output) -> Option<TokenStream> {
        let &Output { name, takes, gives, inlining, values, .. } = output;
        let runtime = &self.d.model.runtime;
        let signature = self.signature(ident(name), takes, gives);
        Some(match values(self.d)? {
            Computation::Straight(values) => {
                let inline = match inlining {
                    Inlining::Forced => self.inlining(forced_inlining()),
                    Inlining::Possible => self.inlining(quote!(#[inline])),
                    Inlining::Free => quote!(),
                };
                self.straight(quote!(#inline #signature), takes, gives, &values)
            }
            Computation::Duals(dual, _) => {
                let (dual, whole, arguments) =
                    (ident(dual), whole(self.d.model.data()), takes.iter().map(named));
                quote!(#signature { #runtime::#dual(&#whole.map(#runtime::Dual::constant), #(#arguments),*) })
            }
            Computation::Loop { right, .. } => {
                let solved = self.solved(&right);
                quote!(#signature { #solved })
            }
            Computation::Redundant(part) => {
                let solved = self.least_norm(part);
                quote!(#signature { #solved })
            }
        })
    }

    pub fn signature(&self, name: impl ToTokens, takes: &[Argument], gives: Shape) -> TokenStream {
        self.types(|types| types.signature(name, takes, gives, named))
    }

    pub fn types<T>(&self, written: impl FnOnce(Types) -> T) -> T {
        let size = |size| self.d.size(size).to_token_stream();
        written(Types { runtime: &self.d.model.runtime, size: &size })
    }

    /// The function with this head that computes these values.
    fn straight(&self, head: TokenStream, takes: &[Argument], gives: Shape, values: &[Value]) -> TokenStream {
        let size = |size| self.d.size(size);
        let given = takes.iter().filter(|a| a.given).flat_map(|argument| {
            let name = ident(argument.name);
            let elements = (0..argument.shape.len(&size)).map(move |i| match argument.shape {
                Shape::Scalar => quote!(#name),
                _ => quote!(#name[#i]),
            });
            elements.collect::<Vec<_>>()
        });
        let given = takes.iter().any(|a| a.given).then(|| quote!(let given = [#(#given),*];));
        let solved = self.d.is_redundant().then(|| self.motion(values));
        let (statements, results) = self.statements(values);
        let result = self.result(&results, gives, 0..values.len());
        quote!(#head { #given #solved #statements #result })
    }

    /// The accelerations and multipliers that these values are made of, where a function of the runtime finds them.
    pub fn motion(&self, values: &[Value]) -> TokenStream {
        let runtime = &self.d.model.runtime;
        let [n, m] = [Size::Coordinates, Size::Constraints].map(|size| self.d.size(size));
        let [accelerations, multipliers] = self.read(values);
        let accelerations =
            accelerations.then(|| quote!(let accelerations = #runtime::System::<#n>::accel(self, q, qd, t);));
        let multipliers = multipliers
            .then(|| quote!(let multipliers = #runtime::Constrained::<#n, #m>::multipliers(self, q, qd, t);));
        quote!(#accelerations #multipliers)
    }

    /// Are these values made of accelerations, and of multipliers?
    fn read(&self, values: &[Value]) -> [bool; 2] {
        let reads = |symbol: fn(Symbol) -> bool| self.d.graph.depends(values, symbol);
        [reads(|s| matches!(s, Symbol::Acceleration(_))), reads(|s| matches!(s, Symbol::Multiplier(_)))]
    }

    /// A part of the solution of least norm under constraints that follow from others.
    pub fn least_norm(&self, part: Part) -> TokenStream {
        let runtime = &self.d.model.runtime;
        let e = &self.d.equations;
        let [n, m] = [Size::Coordinates, Size::Constraints].map(|size| self.d.size(size));
        let (inertia, rows) = (&e.solved.inertia, &e.formed.rows);
        let entries = inertia.iter().flatten().chain(rows.jacobian.iter().flatten()).copied();
        let drift = rows.drift.iter().map(|x| -*x);
        let right = e.solved.right.iter().copied().chain(drift);
        let all: Vec<Value> = match part {
            Part::Response => entries.collect(),
            Part::Accelerations | Part::Multipliers => entries.chain(right).collect(),
        };
        let (statements, results) = self.statements(&all);
        let (lower, size) = (n * (n + 1) / 2, n * (n + 1) / 2 + n * m);
        let (matrix, rows) = (results.part(0..lower), results.columns(lower..size, n));
        let [right, rates] = match part {
            Part::Response => [quote!(impulse), quote!(rates)],
            Part::Accelerations | Part::Multipliers => {
                [size..size + n, size + n..size + n + m].map(|range| {
                    let part = results.part(range);
                    quote!(&#runtime::SVector::from(#part))
                })
            }
        };
        let part = match part {
            Part::Accelerations => Some(quote!(.0)),
            Part::Multipliers => Some(quote!(.1)),
            Part::Response => None,
        };
        let rank = self.rank();
        quote! {
            #statements
            #runtime::constraint::least_norm::<S, #n, #m>(&#matrix, &#rows, #right, #rates, #rank) #part
        }
    }

    /// Some results as one value.
    fn result(&self, results: &Results, shape: Shape, range: Range<usize>) -> TokenStream {
        let runtime = &self.d.model.runtime;
        let mut at = range.start;
        let mut part = |shape: Shape| {
            let from = at;
            at += shape.len(&|size| self.d.size(size));
            self.result(results, shape, from..at)
        };
        match shape {
            Shape::Scalar => results.one(range.start),
            Shape::Vector(_) => {
                let elements = results.part(range);
                quote!(#runtime::SVector::from(#elements))
            }
            Shape::Matrix(rows, _) => {
                let columns = results.columns(range, self.d.size(rows));
                quote!(#runtime::SMatrix::from(#columns))
            }
            Shape::Structure(name, fields) => {
                let name = ident(name);
                let fields = fields.iter().map(|(field, shape)| {
                    let (field, value) = (ident(field), part(*shape));
                    quote!(#field: #value,)
                });
                quote!(#runtime::#name { #(#fields)* })
            }
            Shape::Tuple(parts) => {
                let parts = parts.iter().map(|shape| part(*shape));
                quote!((#(#parts),*))
            }
        }
    }

    /// A solution of M x = right by a loop.
    pub fn solved(&self, right: &[Value]) -> TokenStream {
        let runtime = &self.d.model.runtime;
        let inertia = &self.d.equations.solved.inertia;
        let all: Vec<Value> = inertia.iter().flatten().chain(right).copied().collect();
        let (statements, results) = self.statements(&all);
        let (lower, right) =
            (results.part(0..all.len() - right.len()), results.part(all.len() - right.len()..all.len()));
        quote!(#statements #runtime::solved(&#lower, #right))
    }

    /// The user's points of impulse as methods.
    pub fn impulses(&self) -> TokenStream {
        let struck = self.d.model.struck.iter().zip(&self.d.equations.quantities.impulses);
        self.methods(struck.map(|(s, generalized)| {
            let takes = [Q, T, given("impulse", shape(s.scalar, s.position.len()))];
            let text = || {
                let components = match s.scalar {
                    true => "one component".into(),
                    false => format!("{} components", s.position.len()),
                };
                format!(
                    "Generalized impulse of an impulse at the point `{}`: an element for each coordinate, in N s of a length \
                     and N m s of an angle. `impulse` has {components} in N s, along those of the point.",
                    s.name
                )
            };
            let text = unless_documented(&s.attributes, text);
            let (attributes, gives) = (&s.attributes, Shape::Vector(Size::Coordinates));
            let signature = self.signature(&s.name, &takes, gives);
            let head = quote!(#(#attributes)* #text #[inline] pub #signature);
            self.straight(head, &takes, gives, generalized)
        }))
    }

    /// The user's observed quantities as methods.
    pub fn observed(&self) -> TokenStream {
        let model = &self.d.model;
        let quantities = &self.d.equations.quantities;
        let observed = model.observed.iter().zip(&quantities.observed).zip(&quantities.by_motion);
        self.methods(observed.map(|((o, values), by_motion)| {
            let gives = match o.layout {
                Layout::Scalar => Shape::Scalar,
                Layout::Vector => Shape::Vector(Size::Fixed(values.len())),
                Layout::Matrix(rows) => Shape::Matrix(Size::Fixed(rows), Size::Fixed(values.len() / rows)),
            };
            let text = unless_documented(&o.attributes, || self.documentation_of_output(o));
            let (attributes, inline) = (&o.attributes, forced_inlining());
            let signature = self.signature(&o.name, STATE, gives);
            let head = quote!(#inline #(#attributes)* #text pub #signature);
            let function = self.straight(head, STATE, gives, values);
            let body = by_motion.as_ref().map(|values| self.by_motion(gives, values));
            let at_state = self.at_state(&o.name, gives, body);
            quote!(#function #at_state)
        }))
    }

    /// The documentation of an output of the user's: its shape and units.
    fn documentation_of_output(&self, o: &Observed) -> String {
        let model = &self.d.model;
        let (name, n) = (&o.name, o.values.len());
        if model.states.iter().any(|s| s.name == *name) {
            let elements = if o.layout == Layout::Scalar { String::new() } else { format!(": {n} elements") };
            return format!("State of first order `{name}`{elements}, in its own unit.");
        }
        let whole =
            o.values.first().filter(|_| o.layout == Layout::Scalar).and_then(|v| self.d.graph.alone(*v));
        match (whole, o.layout) {
            (Some(Symbol::Multiplier(j)), _) => format!(
                "Output `{name}`: the multiplier of the constraint `{}`, in {} per unit of the constraint.",
                model.constraints[j].label(),
                match self.d.equations.formed.rows.kinds[j] {
                    ConstraintKind::Holonomic => "J",
                    ConstraintKind::Integrable | ConstraintKind::Nonholonomic => "W",
                }
            ),
            (Some(Symbol::Reaction(k)), _) => format!(
                "Output `{name}`: the generalized force that makes `{0}` move as it does, in J per unit of `{0}` (N of a \
                 length, N m of an angle).",
                model.prescribed[k].name
            ),
            (_, Layout::Scalar) => format!("Output `{name}`, in the unit of its formula."),
            (_, Layout::Vector) => format!("Output `{name}`: {n} elements, in the units of their formulas."),
            (_, Layout::Matrix(rows)) => {
                format!(
                    "Output `{name}`: a matrix of {rows} × {} elements, in the units of their formulas.",
                    n / rows
                )
            }
        }
    }

    /// These values at the state `at`, by its accelerations and multipliers.
    pub fn by_motion(&self, gives: Shape, values: &[Value]) -> TokenStream {
        let runtime = &self.d.model.runtime;
        let [n, m] = [Size::Coordinates, Size::Constraints].map(|size| self.d.size(size));
        let [accelerations, multipliers] = self.read(values);
        let (statements, results) = self.statements(values);
        let (count, all) = (values.len(), results.part(0..values.len()));
        let result = match gives {
            Shape::Scalar => quote!(found[0]),
            Shape::Matrix(rows, columns) => {
                let [rows, columns] = [rows, columns].map(|size| self.d.size(size));
                quote!(#runtime::SMatrix::<S, #rows, #columns>::from_iterator(found.iter().copied()))
            }
            _ => quote!(found),
        };
        quote! {
            let found = #runtime::constraint::motion::<Self, #accelerations, #multipliers, #n, #m, #count>(
                self,
                at,
                |at, accelerations, multipliers| {
                    let (q, qd, t) = (&at.q, &at.qd, at.t);
                    #statements
                    #runtime::SVector::from(#all)
                },
            );
            #result
        }
    }

    /// The function of this name at a state, unless the user has an output of its name: with this body, or that of
    /// (q, q̇, t) there.
    fn at_state(&self, name: &Ident, gives: Shape, body: Option<TokenStream>) -> Option<TokenStream> {
        let Model { observed, struck, runtime, .. } = &self.d.model;
        let at = at_state(name);
        let is_taken = observed.iter().any(|o| o.name == at) || struck.iter().any(|s| s.name == at);
        (!is_taken).then(|| {
            let signature = self.types(|types| types.at_state(&at, gives));
            let text = match body {
                None => format!("[`{name}`](Self::{name}) at a state."),
                Some(_) => format!(
                    "[`{name}`](Self::{name}) at a state; near one at which constraints are dependent, on its branch."
                ),
            };
            let body = body.unwrap_or_else(|| {
                quote! {
                    let #runtime::State { t, q, qd } = at;
                    self.#name(q, qd, *t)
                }
            });
            quote! {
                #[doc = #text]
                #[inline]
                pub #signature {
                    #body
                }
            }
        })
    }

    /// The angular momenta of rotations of which a component is constant, unless the user has an output of that name.
    pub fn angular_momenta(&self) -> TokenStream {
        let Derived { model, equations: e, .. } = self.d;
        let mut methods = Vec::new();
        for attitude in model.attitudes.iter().filter(|a| a.index.unwrap_or(0) == 0) {
            let all = model.attitudes.iter().zip(&e.symmetries.momenta);
            let of: Vec<Option<[Value; 3]>> =
                all.filter(|(a, _)| a.name == attitude.name).map(|(_, momentum)| *momentum).collect();
            let name = symmetry::name(attitude);
            if of.iter().all(Option::is_none) || model.observed.iter().any(|o| o.name == name) {
                continue;
            }
            let values: Vec<Value> = of.into_iter().flat_map(|p| p.unwrap_or([Value::ZERO; 3])).collect();
            let gives = shape(false, values.len());
            let text = match attitude.index {
                None => format!(
                    "Angular momentum of `{}` in N m s, its momentum as a rotation: three components in the axes of the parent, {}.",
                    attitude.name,
                    docs::conserved(self.d, attitude)
                ),
                Some(_) => format!(
                    "Angular momenta of `{}` in N m s: three components in the axes of the parent for each element; 0 where none \
                     is constant.",
                    attitude.name
                ),
            };
            let name = Ident::new(&name, attitude.name.span());
            let (signature, inline) = (self.signature(&name, STATE, gives), forced_inlining());
            methods.push(self.straight(quote!(#inline #[doc = #text] pub #signature), STATE, gives, &values));
            methods.extend(self.at_state(&name, gives, None));
        }
        let common = &e.symmetries.common;
        let name = Ident::new(symmetry::COMMON, model.name.span());
        if !common.is_empty() && model.observed.iter().all(|o| o.name != name) {
            let values: Vec<Value> = common.iter().map(|s| s.momentum).collect();
            let gives = shape(false, values.len());
            let text = format!(
                "Constant angular momenta in N m s of parts that turn together about axes of the world, an element for each: {}.",
                docs::common(self.d)
            );
            let (signature, inline) = (self.signature(&name, STATE, gives), forced_inlining());
            methods.push(self.straight(quote!(#inline #[doc = #text] pub #signature), STATE, gives, &values));
            methods.extend(self.at_state(&name, gives, None));
        }
        self.methods(methods.into_iter())
    }

    fn methods(&self, methods: impl ExactSizeIterator<Item = TokenStream>) -> TokenStream {
        let Model { name, runtime, .. } = &self.d.model;
        if methods.len() == 0 {
            return TokenStream::new();
        }
        quote! {
            impl<S: #runtime::Scalar> #name<S> {
                #(#methods)*
            }
        }
    }
}

fn shape(scalar: bool, n: usize) -> Shape {
    if scalar { Shape::Scalar } else { Shape::Vector(Size::Fixed(n)) }
}
