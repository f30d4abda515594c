//! The physics before any derivation: names resolved to nodes, and the statements to T, V, D, Q as expressions.
//!
//! A `let` that depends on coordinates or time, and a prescribed coordinate, is a *binding* `u = φ(q, t)`: it stays a
//! symbol of its own in L, D and the forces, with its rate `u̇` as another. The equations are formed at the bindings
//! and pulled back (`equations/assemble.rs`), so their cost grows with what was written.

pub mod attitude;
pub mod check;
mod elaborate;
pub mod frames;
pub mod submodel;
mod value;

use crate::diagnostics::{Errors, Reported};
use crate::graph::{Graph, Number, Symbol, Value};
use crate::syntax::{Data, Declaration, Definition, Event, Header, Kind, Statement};
use elaborate::{Elaborator, Found, Place};
#[cfg(test)]
pub use elaborate::{METHODS, RESERVED};
use frames::{Frames, Motion};
use proc_macro2::{Ident, TokenStream};
use quote::ToTokens;
use std::collections::BTreeMap;
use submodel::{Origin, Submodel, Variation};
use syn::{Attribute, Expr, Visibility};

/// A field of the generated struct.
#[derive(Clone)]
pub struct Parameter {
    pub attributes: Vec<Attribute>,
    pub name: Ident,
    pub length: Option<usize>,
    /// Values of the defaults, one for each number.
    pub default: Option<Vec<f64>>,
    /// Index of its first number.
    pub first: usize,
    /// The ignorable coordinate whose momentum it is.
    pub momentum_of: Option<String>,
    /// It may change between steps.
    pub input: bool,
    /// Its three numbers are the parameters of a rotation.
    pub rotation: bool,
}

/// One generalized coordinate.
#[derive(Clone)]
pub struct Coordinate {
    pub name: Ident,
    /// Position in its array.
    pub index: Option<usize>,
    /// Position among the three parameters of its rotation.
    pub part: Option<usize>,
    pub kind: Kind,
}

/// States of first order of one name, ż = r(q, q̇, z, t): the velocities of the last coordinates, which are their
/// time integrals (docs/decisions/0018).
pub struct FirstOrder {
    pub name: Ident,
    /// Index of its first coordinate.
    pub first: usize,
    /// Values at the start, one for each.
    pub initial: Vec<f64>,
}

/// Prefixes to the name of a rotation in the names of the functions that read and set it.
pub const ATTITUDE_FUNCTIONS: [&str; 4] =
    ["attitude_", "angular_velocity_", "angular_acceleration_", "with_attitude_"];

/// The same for a direction.
pub const DIRECTION_FUNCTIONS: [&str; 2] = ["direction_", "with_direction_"];

/// Is this the name of a function that reads or sets a coordinate of this kind?
pub fn is_function_of(name: &Ident, kind: Kind, coordinate: &Ident) -> bool {
    let name = name.to_string();
    let prefixes: &[&str] = match kind {
        Kind::Rotation => &ATTITUDE_FUNCTIONS,
        Kind::Direction => &DIRECTION_FUNCTIONS,
        _ => &[],
    };
    prefixes.iter().any(|prefix| name.strip_prefix(prefix).is_some_and(|rest| coordinate == rest))
}

/// A rotation that is a coordinate, R(σ) with Rodrigues' modified parameters σ (`elaborate/frames/attitudes.rs`).
#[derive(Clone)]
pub struct Attitude {
    pub name: Ident,
    /// Position in its array.
    pub index: Option<usize>,
    /// The first of its three coordinates.
    pub first: usize,
    /// Its relative angular velocity, by the bindings that are its components; none where there are no bindings any
    /// more.
    pub spin: Option<[usize; 3]>,
}

/// `u = φ(q, t)`, in terms of earlier bindings, or a component of a velocity of a frame.
pub struct Binding {
    pub name: String,
    /// 0 for a quasi-velocity, which has none.
    pub value: Value,
    /// u̇, in terms of earlier bindings and their rates.
    pub rate: Value,
    pub motion: Motion,
}

/// A named output.
pub struct Observed {
    pub attributes: Vec<Attribute>,
    pub name: Ident,
    /// Values, of a matrix by columns.
    pub values: Vec<Value>,
    pub layout: Layout,
}

/// Shape of the values of an output.
#[derive(Clone, Copy, PartialEq)]
pub enum Layout {
    Scalar,
    Vector,
    /// With so many rows.
    Matrix(usize),
}

/// A named event, or an array of them.
#[derive(Clone)]
pub struct NamedEvent {
    pub written: Event,
    pub values: Vec<Value>,
    pub scalar: bool,
}

/// A coordinate whose motion is given.
pub struct Prescribed {
    pub name: String,
    /// The binding that is its motion.
    pub binding: usize,
}

/// One equation between positions, or between velocities: an expression that vanishes.
#[derive(Clone)]
pub struct Constraint {
    pub name: Ident,
    /// Position in its array.
    pub index: Option<usize>,
    pub value: Value,
    /// Tokens as they were written.
    pub written: TokenStream,
    /// May it follow from others?
    pub redundant: bool,
}

/// A point or an angle at which impulses may act.
pub struct Struck {
    pub attributes: Vec<Attribute>,
    pub name: Ident,
    pub position: Vec<Value>,
    pub scalar: bool,
}

/// A function of the user's.
#[derive(Clone)]
pub struct External {
    pub name: Ident,
    pub arity: usize,
    /// The field that it is called through; none for a function in scope.
    pub data: Option<Data>,
}

/// A system as its energies and forces.
pub struct Model {
    pub runtime: TokenStream,
    pub attributes: Vec<Attribute>,
    pub visibility: Visibility,
    pub name: Ident,
    pub parameters: Vec<Parameter>,
    /// Coordinates of the energies, then those of the states.
    pub coordinates: Vec<Coordinate>,
    pub states: Vec<FirstOrder>,
    pub attitudes: Vec<Attitude>,
    pub bindings: Vec<Binding>,
    pub prescribed: Vec<Prescribed>,
    pub constraints: Vec<Constraint>,
    pub externals: Vec<External>,
    pub lagrangian: Value,
    /// T and V, unless L was given whole.
    pub energies: Option<[Value; 2]>,
    pub dissipation: Value,
    /// Q, directly at each coordinate.
    pub applied: Vec<Value>,
    /// Pairs of a force and the position that it moves.
    pub forces: Vec<(Value, Value)>,
    /// Forces and couples at velocities of frames: each with the velocity that it does work with.
    pub frame_forces: Vec<(Value, Value)>,
    /// Positions of which velocities are taken, in energies and forces.
    pub moved: Vec<Value>,
    pub frames: Frames,
    /// Bindings and energies as they were written.
    pub written: Vec<(String, TokenStream)>,
    /// Are there frames among the written bindings?
    pub framed: bool,
    pub observed: Vec<Observed>,
    pub events: Vec<NamedEvent>,
    pub struck: Vec<Struck>,
    /// The second type asked for, with the ignorable coordinates removed.
    pub routhian: Option<Header>,
    /// Coordinates removed of such a second type.
    pub reduction: Option<Reduction>,
    /// Further types that are asked for, with coordinates held.
    pub submodels: Vec<Submodel>,
    /// The system that such a type came from.
    pub origin: Option<Origin>,
    /// Places of the statements, for errors that only derivation can find.
    pub keywords: Keywords,
}

/// Derivation of a system from another one, by removing ignorable coordinates.
pub struct Reduction {
    /// Name of the other.
    pub of: Ident,
    /// Indices of the coordinates that were kept, in the other.
    pub kept: Vec<usize>,
    pub removed: Vec<Removed>,
}

/// An ignorable coordinate that was removed.
pub struct Removed {
    /// Its index in the system that has it.
    pub index: usize,
    pub label: String,
    /// The parameter that holds its momentum.
    pub momentum: Ident,
    /// q̇ᵢ in terms of the coordinates kept, their velocities, time and the momenta.
    pub velocity: Value,
}

/// Tokens to point at.
#[derive(Default)]
pub struct Keywords {
    pub kinetic: Option<Ident>,
    pub potential: Option<Ident>,
    pub dissipation: Option<Ident>,
}

impl Parameter {
    /// Its numbers.
    pub fn numbers(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.length.unwrap_or(1)
    }
}

impl Constraint {
    /// The name that a reader would use.
    pub fn label(&self) -> String {
        indexed(&self.name.to_string(), self.index)
    }
}

impl Coordinate {
    /// The name that a reader would use: `theta`, `x[2]`; of a rotation its three parameters.
    pub fn label(&self) -> String {
        indexed(&self.whole(), self.part)
    }

    /// The rotation or the direction that it is a part of, or itself.
    pub fn whole(&self) -> String {
        indexed(&self.name.to_string(), self.index)
    }
}

pub fn indexed(name: &str, index: Option<usize>) -> String {
    index.map_or(name.to_string(), |i| format!("{name}[{i}]"))
}

impl Model {
    /// Names of the numbers of the parameters, by symbol index.
    pub fn parameter_labels(&self) -> Vec<String> {
        let labels = |p: &Parameter| match p.length {
            None => vec![p.name.to_string()],
            Some(n) => (0..n).map(|i| indexed(&p.name.to_string(), Some(i))).collect(),
        };
        self.parameters.iter().flat_map(labels).collect()
    }

    /// The fields that hold the data of functions, by their names.
    pub fn data(&self) -> impl Iterator<Item = (&Ident, &Data)> {
        self.externals.iter().filter_map(|f| Some((&f.name, f.data.as_ref()?)))
    }

    /// The value that a parameter has by default.
    pub fn default_of(&self, parameter: usize) -> Option<f64> {
        let of = self.parameters.iter().find(|p| p.numbers().contains(&parameter))?;
        Some(of.default.as_ref()?[parameter - of.first])
    }

    /// The numbers of the parameters that are inputs.
    pub fn inputs(&self) -> impl Iterator<Item = usize> + '_ {
        self.parameters.iter().filter(|p| p.input).flat_map(Parameter::numbers)
    }

    /// Number of the coordinates that the energies have, which come before those of the states.
    pub fn mechanical(&self) -> usize {
        self.states.first().map_or(self.coordinates.len(), |state| state.first)
    }

    /// Names of the inputs.
    pub fn input_labels(&self) -> Vec<String> {
        let labels = self.parameter_labels();
        self.inputs().map(|i| labels[i].clone()).collect()
    }
}

/// Meaning of a name.
#[derive(Clone)]
enum Entry {
    Const(i64),
    Parameter(usize),
    Coordinate {
        first: usize,
        length: Option<usize>,
    },
    /// Coordinates some of which are held.
    Mixed {
        places: Vec<Place>,
        length: Option<usize>,
    },
    State {
        first: usize,
        length: Option<usize>,
    },
    /// Rotations, by their place among those of the system.
    Rotation {
        first: usize,
        length: Option<usize>,
    },
    Prescribed(value::Val),
    Let(value::Val),
    Function(usize),
    External(usize),
    Constraint {
        first: usize,
        length: Option<usize>,
    },
    /// Its definition failed; the error has been reported.
    Broken,
}

/// Resolves a definition to a model and the graph of its expressions. Errors are recorded; the model is returned only
/// if there are none.
pub fn model(definition: &Definition, errors: &mut Errors) -> Option<(Graph, Model)> {
    read(definition, &definition.header, None, errors)
}

/// The same of a derived system: the definition is read again.
pub fn submodel(
    definition: &Definition,
    header: &Header,
    variation: Variation,
    errors: &mut Errors,
) -> Option<(Graph, Model)> {
    read(definition, header, Some(variation), errors)
}

fn read(
    definition: &Definition,
    header: &Header,
    variation: Option<Variation>,
    errors: &mut Errors,
) -> Option<(Graph, Model)> {
    let Definition { runtime, statements, .. } = definition;
    let mut e = Elaborator::new(errors, &header.name, variation);
    e.declare(statements);
    for statement in statements {
        e.statement(statement);
        if e.exhausted() {
            return None;
        }
    }
    if e.is_derived() {
        check::derived(&mut e, header);
    } else {
        statements.iter().for_each(|statement| {
            if let Statement::Submodel(asked) = statement {
                e.submodel(asked);
            }
        });
        check::complete(&mut e, header, statements);
    }
    let finished = e.errors.is_empty();
    let Elaborator { mut graph, found, space, variation, .. } = e;
    if !finished {
        return None;
    }
    let origin = variation.map(|Variation { whole, .. }| {
        let kept = |i: &usize| found.held.iter().all(|held| held.index != *i);
        let kept = (0..whole.coordinates.len()).filter(kept).collect();
        Origin {
            of: whole.name.clone(),
            exact: true,
            kept,
            held: found.held,
            fast: Vec::new(),
            moves: Vec::new(),
            gone: Vec::new(),
        }
    });
    let Found { energies, applied, .. } = found;
    let [kinetic, potential, whole, dissipation] = energies;
    let value = |energy: &Option<(Ident, Value)>| energy.as_ref().map(|(_, value)| *value);
    let pair = value(&kinetic).zip(value(&potential)).map(|(t, v)| [t, v]);
    let lagrangian = match pair {
        Some([t, v]) => graph.sub(t, v),
        None => value(&whole)?,
    };
    let model = Model {
        runtime: runtime.clone(),
        attributes: header.attributes.clone(),
        visibility: header.visibility.clone(),
        name: header.name.clone(),
        parameters: found.parameters,
        coordinates: found.coordinates,
        states: found.states,
        attitudes: found.attitudes,
        bindings: found.bindings,
        prescribed: found.prescribed,
        constraints: found.constraints,
        externals: found.externals,
        lagrangian,
        energies: pair,
        dissipation: value(&dissipation).unwrap_or(Value::ZERO),
        applied: applied.into_iter().map(|q| q.unwrap_or(Value::ZERO)).collect(),
        forces: found.forces,
        frame_forces: found.frame_forces,
        moved: found.moved,
        frames: space.frames(),
        written: found.written,
        framed: found.framed,
        observed: found.observed,
        events: found.events,
        struck: found.struck,
        routhian: found.routhian,
        reduction: None,
        submodels: found.submodels,
        origin,
        keywords: Keywords {
            potential: potential.or(whole.clone()).map(|(keyword, _)| keyword),
            kinetic: kinetic.or(whole).map(|(keyword, _)| keyword),
            dissipation: dissipation.map(|(keyword, _)| keyword),
        },
    };
    Some((graph, model))
}

/// A function of the system.
struct FunctionDefinition {
    name: Ident,
    arguments: Vec<Ident>,
    body: Expr,
}

impl Elaborator<'_> {
    /// Names that may be used before they are written: constants, parameters, coordinates, functions.
    fn declare(&mut self, statements: &[Statement]) {
        for statement in statements {
            match statement {
                Statement::Const(d) | Statement::Let(d) => drop(self.scope.later.insert(d.name.to_string())),
                Statement::Param(list) | Statement::Coord(list) | Statement::State(list) => {
                    for d in list {
                        let names = if d.input { &mut self.scope.inputs } else { &mut self.scope.later };
                        names.insert(d.name.to_string());
                    }
                }
                Statement::Observe(d) if d.value.is_some() => {
                    self.scope.outputs.insert(d.name.to_string());
                }
                Statement::Unread(words) => {
                    self.scope.unread.extend(words.iter().map(|word| (word.to_string(), word.clone())));
                    self.scope.incomplete = true;
                }
                _ => {}
            }
        }
        for statement in statements {
            match statement {
                Statement::Const(d) => self.declare_const(d),
                Statement::Param(list) => {
                    list.iter().filter(|d| !d.input).for_each(|d| self.declare_parameter(d))
                }
                Statement::Function { name, arguments, body } => {
                    self.check_arguments(arguments);
                    self.scope.functions.push(FunctionDefinition {
                        name: name.clone(),
                        arguments: arguments.clone(),
                        body: body.clone(),
                    });
                    self.define(name, Entry::Function(self.scope.functions.len() - 1));
                }
                Statement::Extern { name, arguments, data } => {
                    self.check_arguments(arguments);
                    self.found.externals.push(External {
                        name: name.clone(),
                        arity: arguments.len(),
                        data: data.clone(),
                    });
                    self.define(name, Entry::External(self.found.externals.len() - 1));
                }
                _ => {}
            }
        }
        // Inputs after parameters, and coordinates after both: the older a node, the earlier it stands in a product,
        // so that products of parameters alone come together.
        let first = self.found.parameters.last().map_or(0, |p| p.numbers().end);
        self.graph.inputs = first..usize::MAX;
        for d in statements.iter().flat_map(Statement::parameters).filter(|d| d.input) {
            self.declare_parameter(d);
        }
        self.graph.inputs.end = self.found.parameters.last().map_or(0, |p| p.numbers().end);
        for d in statements.iter().flat_map(Statement::coordinates).filter(|d| d.value.is_none()) {
            self.declare_coordinate(d);
        }
        statements.iter().flat_map(Statement::states).for_each(|d| self.declare_state(d));
        self.found.applied.resize(self.found.coordinates.len(), None);
        self.hold();
        self.attitudes();
    }

    fn declare_const(&mut self, d: &Declaration) {
        if let Some(length) = &d.length {
            self.errors
                .push(length, "a constant is one integer\nhelp: an array of numbers is a `param` or a `let`");
        }
        let entry = match &d.value {
            None => {
                self.errors.push(
                    &d.name,
                    format!("a constant needs its value\nhelp: write `const {} = 8;`", d.name),
                );
                Entry::Broken
            }
            Some(value) => self.constant_integer(d, value).map_or(Entry::Broken, Entry::Const),
        };
        self.define(&d.name, entry);
    }

    fn constant_integer(&mut self, d: &Declaration, value: &Expr) -> Result<i64, Reported> {
        match self.evaluate(value)? {
            value::Val::Int(n) => Ok(n),
            value::Val::Number(_) => {
                let (name, number) = (&d.name, value.to_token_stream());
                let message = format!(
                    "a `const` is an integer, for lengths and ranges\nhelp: a number is `param {name} = {number};`, or `let {name} = {number};`"
                );
                Err(self.errors.push(value, message))
            }
            _ => self.whole(value),
        }
    }

    fn declare_parameter(&mut self, d: &Declaration) {
        let Ok(length) = self.length(d) else { return self.define(&d.name, Entry::Broken) };
        let rotation = d.kind == Kind::Rotation;
        if rotation && (length.is_some() || d.value.is_some()) {
            let name = &d.name;
            let (at, message): (&Expr, String) = match (&d.length, &d.value) {
                (Some(length), _) => (length, format!("parameters that are rotations are single ones\nhelp: give each a name, `param {name}0: rotation, {name}1: rotation;`")),
                (None, Some(value)) => (value, "a parameter that is a rotation has no default value\nhelp: it is given to `new`, as `rotation::by_matrix(…)?`; one of numbers is `let R = rotation([[…], […], […]]);`".into()),
                (None, None) => return,
            };
            let _: Reported = self.errors.push(at, message);
            return self.define(&d.name, Entry::Broken);
        }
        let length = if rotation { Some(3) } else { length };
        let default = match &d.value {
            None => d.input.then(|| vec![0.0; length.unwrap_or(1)]),
            Some(value) => match self.defaults(value, length) {
                Ok(default) => Some(default),
                Err(_) => return self.define(&d.name, Entry::Broken),
            },
        };
        if let Some(zero) = self.neglected(&d.name) {
            self.numbers.extend(vec![Value::ZERO; length.unwrap_or(1)]);
            return self.define(&d.name, Entry::Let(zero));
        }
        let first = self.found.parameters.last().map_or(0, |p| p.numbers().end);
        let parameter = Parameter {
            attributes: d.attributes.clone(),
            name: d.name.clone(),
            length,
            default,
            first,
            momentum_of: None,
            input: d.input,
            rotation,
        };
        for number in parameter.numbers() {
            let symbol = self.graph.symbol(Symbol::Parameter(number));
            self.numbers.push(symbol);
        }
        self.found.parameters.push(parameter);
        self.define(&d.name, Entry::Parameter(self.found.parameters.len() - 1));
    }

    fn declare_coordinate(&mut self, d: &Declaration) {
        let Ok(length) = self.length(d) else { return self.define(&d.name, Entry::Broken) };
        let (first, attitude) = (self.found.coordinates.len(), self.found.attitudes.len());
        let (rotation, parts) = (d.kind == Kind::Rotation, d.kind.coordinates());
        let declared = self.declared;
        self.declared += length.unwrap_or(1) * parts;
        if (declared..self.declared).any(|i| self.is_held(i)) {
            return self.declare_mixed(d, length, declared);
        }
        for i in 0..length.unwrap_or(1) {
            let (name, index) = (d.name.clone(), length.map(|_| i));
            if rotation {
                let first = self.found.coordinates.len();
                self.found.attitudes.push(Attitude { name: name.clone(), index, first, spin: None });
            }
            for part in 0..parts {
                self.graph.symbol(Symbol::Coordinate(self.found.coordinates.len()));
                let part = (parts > 1).then_some(part);
                self.found.coordinates.push(Coordinate { name: name.clone(), index, part, kind: d.kind });
            }
        }
        let entry = match d.kind {
            Kind::Rotation => Entry::Rotation { first: attitude, length },
            Kind::Direction => self.directions(d, first, length),
            _ => Entry::Coordinate { first, length },
        };
        self.define(&d.name, entry);
    }

    /// Directions from this coordinate on: vectors, whose lengths are 1 by constraints ½ (n·n − 1) = 0.
    fn directions(&mut self, d: &Declaration, first: usize, length: Option<usize>) -> Entry {
        let mut all = Vec::new();
        for i in 0..length.unwrap_or(1) {
            let parts = [0, 1, 2].map(|k| self.graph.symbol(Symbol::Coordinate(first + 3 * i + k)));
            let square = frames::inner(&mut self.graph, &parts, &parts);
            let value = self.graph.sub(square, Value::ONE).scaled(Number::Ratio(1, 2));
            let (name, index) = (d.name.clone(), length.map(|_| i));
            let written = d.name.to_token_stream();
            self.found.constraints.push(Constraint { name, index, value, written, redundant: false });
            all.push(value::Val::Array(parts.map(value::Val::Number).to_vec()));
        }
        match length {
            None => Entry::Coordinate { first, length: Some(3) },
            Some(_) => Entry::Let(value::Val::Array(all)),
        }
    }

    /// Coordinates some of which are held, at values that are known when all are declared.
    fn declare_mixed(&mut self, d: &Declaration, length: Option<usize>, declared: usize) {
        for i in declared..self.declared {
            if self.is_held(i) {
                continue;
            }
            self.graph.symbol(Symbol::Coordinate(self.found.coordinates.len()));
            let (name, index) = (d.name.clone(), length.map(|_| i - declared));
            self.found.coordinates.push(Coordinate { name, index, part: None, kind: d.kind });
        }
        self.mixed.push((d.name.to_string(), (declared..self.declared).collect()));
        self.define(&d.name, Entry::Mixed { places: Vec::new(), length });
    }

    /// A state is the velocity of a coordinate that nothing depends on, and an output.
    fn declare_state(&mut self, d: &Declaration) {
        let Ok(length) = self.length(d) else { return self.define(&d.name, Entry::Broken) };
        let initial = match &d.value {
            None => vec![0.0; length.unwrap_or(1)],
            Some(value) => match self.defaults(value, length) {
                Ok(initial) => initial,
                Err(_) => return self.define(&d.name, Entry::Broken),
            },
        };
        // What has the name already is what the others mean by it.
        if let Some((_, known)) = self.scope.names.get(&d.name.to_string()) {
            let known = known.clone();
            return self.define(&d.name, known);
        }
        let first = self.found.coordinates.len();
        let mut values = Vec::new();
        for i in 0..initial.len() {
            let index = length.map(|_| i);
            self.found.coordinates.push(Coordinate {
                name: d.name.clone(),
                index,
                part: None,
                kind: Kind::State,
            });
            values.push(self.graph.symbol(Symbol::Velocity(first + i)));
        }
        self.found.applied.resize(self.found.coordinates.len(), None);
        let (attributes, name) = (d.attributes.clone(), d.name.clone());
        let layout = length.map_or(Layout::Scalar, |_| Layout::Vector);
        self.found.observed.push(Observed { attributes, name, values, layout });
        self.found.states.push(FirstOrder { name: d.name.clone(), first, initial });
        self.define(&d.name, Entry::State { first, length });
    }
}

/// Names and their meanings.
type Names = BTreeMap<String, (Ident, Entry)>;

/// Definitions of bindings by their node, so that a later expression that contains one is written with its symbol.
type Bound = crate::graph::stable_map::IdMap<Value>;
