//! THE table of outputs: what a generated type computes, with the name, trait, arguments, shape and values of each
//! function.
//!
//! Emission, the stubs of a failed compile, the interpreter, the names that no output of the user's can have, those
//! that emitted variables cannot have, and the comparison of random systems with dual numbers read it. A new output
//! is one row of [`OUTPUTS`]; a new length is one variant of [`Size`], a new vector that a function is given one
//! constant beside [`Q`].

use crate::diagnostics::Errors;
use crate::equations::Derived;
use crate::equations::elimination::Solver;
use crate::equations::solve::entry;
use crate::graph::Value;
use crate::program::count::operations;
use crate::syntax::{Definition, Statement};
use proc_macro2::Ident;

/// If M is eliminated as a whole, accelerations of more operations are solved for by a loop at run time.
const MAX_STRAIGHT_OPERATIONS: usize = 5000;
/// An inertia matrix of more operations is found by duals.
const MAX_INERTIA_OPERATIONS: usize = 1000;

/// A function of a generated type.
pub struct Output {
    pub name: &'static str,
    /// The trait of the runtime that declares it.
    pub of: &'static str,
    pub takes: &'static [Argument],
    pub gives: Shape,
    pub inlining: Inlining,
    /// None where the system has no such output; the trait is implemented where it has one.
    pub values: fn(&Derived) -> Option<Computation>,
}

/// An argument of a function, after `&self`.
#[derive(Clone, Copy)]
pub struct Argument {
    pub name: &'static str,
    pub shape: Shape,
    /// Are its elements those that are `Given`, after those of arguments before it?
    pub given: bool,
}

/// The type of an argument or of a result.
#[derive(Clone, Copy)]
pub enum Shape {
    Scalar,
    Vector(Size),
    /// Rows and columns. Values come by columns.
    Matrix(Size, Size),
    /// A structure of the runtime with these fields, for so many coordinates.
    Structure(&'static str, &'static [(&'static str, Shape)]),
    Tuple(&'static [Shape]),
}

/// A length.
#[derive(Clone, Copy)]
pub enum Size {
    Coordinates,
    Constraints,
    Prescribed,
    Inputs,
    /// The coordinates of the energies.
    Mechanical,
    /// The states of first order.
    States,
    /// The coordinates that a reduced or restricted system does not have.
    Ignorable,
    /// The coordinates of the system that a reduced or restricted one came from.
    Whole,
    Fixed(usize),
}

#[derive(Clone, Copy)]
pub enum Inlining {
    /// Inlined by force, but in builds for debugging.
    Forced,
    /// In other crates as well.
    Possible,
    /// Inlined as the compiler sees fit.
    Free,
}

/// Computation of the values of a function.
pub enum Computation {
    /// Straight-line code.
    Straight(Vec<Value>),
    /// This function of the runtime over dual numbers, and expressions of the values, if there are any.
    Duals(&'static str, Option<Vec<Value>>),
    /// A loop that solves M x = right.
    Loop { values: Vec<Value>, right: Vec<Value> },
    /// Part of the solution of least norm of M x − Aᵀ λ = right, A x = rates, where constraints follow from
    /// others.
    Redundant(Part),
}

/// The part of a solution (x, λ).
#[derive(Clone, Copy)]
pub enum Part {
    Accelerations,
    Multipliers,
    /// Both, of an impulse and rates that are given.
    Response,
}

impl Computation {
    /// Expressions of the values, in the order in which a shape has them.
    pub fn values(self) -> Option<Vec<Value>> {
        match self {
            Computation::Straight(values) | Computation::Loop { values, .. } => Some(values),
            Computation::Duals(_, values) => values,
            Computation::Redundant(_) => None,
        }
    }
}

impl Shape {
    /// Number of values.
    pub fn len(self, size: &dyn Fn(Size) -> usize) -> usize {
        match self {
            Shape::Scalar => 1,
            Shape::Vector(n) => size(n),
            Shape::Matrix(rows, columns) => size(rows) * size(columns),
            Shape::Structure(_, fields) => fields.iter().map(|f| f.1.len(size)).sum(),
            Shape::Tuple(parts) => parts.iter().map(|part| part.len(size)).sum(),
        }
    }
}

impl Derived {
    pub fn size(&self, size: Size) -> usize {
        let model = &self.model;
        let reduced = || model.reduction.as_ref().map_or(0, |r| r.removed.len());
        let ignorable = || model.origin.as_ref().map_or_else(reduced, |origin| origin.held.len());
        match size {
            Size::Coordinates => model.coordinates.len(),
            Size::Constraints => model.constraints.len(),
            Size::Prescribed => model.prescribed.len(),
            Size::Inputs => model.inputs().count(),
            Size::Mechanical => model.mechanical(),
            Size::States => model.coordinates.len() - model.mechanical(),
            Size::Ignorable => ignorable(),
            Size::Whole => model.coordinates.len() + ignorable(),
            Size::Fixed(n) => n,
        }
    }

    /// Is M eliminated by loops at run time? That takes no longer than the same in straight lines, and these take
    /// long to compile when there are many. An elimination along the bindings has no M, and is shorter than one.
    pub fn is_looped(&self) -> bool {
        let e = &self.equations;
        matches!(e.solved.solver, Solver::Dense(..))
            && e.solved.operations.arithmetic() > MAX_STRAIGHT_OPERATIONS
            && e.formed.rows.is_empty()
            && e.solved.inertia.iter().enumerate().all(|(i, row)| !row[i].is_zero())
    }

    /// Do constraints follow from others?
    pub fn is_redundant(&self) -> bool {
        self.equations.formed.rows.redundancy.is_some()
    }

    /// A part of the motion under constraints that follow from others.
    fn redundant(&self, part: Part) -> Option<Computation> {
        self.is_redundant().then_some(Computation::Redundant(part))
    }

    /// A solution of M x = right.
    fn solution(&self, values: &[Value], right: &[Value]) -> Computation {
        let (values, right) = (values.to_vec(), right.to_vec());
        if self.is_looped() { Computation::Loop { values, right } } else { Computation::Straight(values) }
    }
}

const fn argument(name: &'static str, shape: Shape) -> Argument {
    Argument { name, shape, given: false }
}

pub const fn given(name: &'static str, shape: Shape) -> Argument {
    Argument { name, shape, given: true }
}

const COORDINATES: Shape = Shape::Vector(Size::Coordinates);
const CONSTRAINTS: Shape = Shape::Vector(Size::Constraints);
const REMOVED: Shape = Shape::Vector(Size::Ignorable);
const SQUARE: Shape = Shape::Matrix(Size::Coordinates, Size::Coordinates);

pub const Q: Argument = argument("q", COORDINATES);
const QD: Argument = argument("qd", COORDINATES);
const P: Argument = argument("p", COORDINATES);
pub const T: Argument = argument("t", Shape::Scalar);
pub const STATE: &[Argument] = &[Q, QD, T];

/// Every output. Functions of a trait are emitted in this order.
#[rustfmt::skip]
pub const OUTPUTS: &[Output] = &[
    output("accel", "System", STATE, COORDINATES,
        |d| d.redundant(Part::Accelerations).or_else(|| Some(d.solution(&d.equations.solved.accel, &d.equations.solved.right)))),
    output("lagrangian", "Lagrangian", STATE, Shape::Scalar, |d| straight([d.equations.quantities.lagrangian])),
    output("energy_function", "Lagrangian", STATE, Shape::Scalar, |d| straight([d.equations.quantities.energy_function])),
    output("dissipation", "Lagrangian", STATE, Shape::Scalar, |d| straight([d.equations.quantities.dissipation])),
    output("power", "Lagrangian", STATE, Shape::Scalar, |d| straight([d.equations.quantities.power])),
    output("momenta", "Lagrangian", STATE, COORDINATES, |d| straight(d.equations.quantities.momenta.clone())),
    output("convective_momentum_rate", "Lagrangian", STATE, COORDINATES, |d| straight(d.equations.quantities.bias.clone())),
    output("momentum_rate", "Lagrangian", STATE, COORDINATES, |d| straight(d.equations.quantities.force.clone())),
    output("inertia", "Lagrangian", STATE, SQUARE, inertia),
    output("jacobian", "Lagrangian", STATE, Shape::Structure("Jacobian", &[("q", SQUARE), ("qd", SQUARE), ("t", COORDINATES)]),
        |d| columns(&d.equations.responses.jacobian, "dual_jacobian")),
    output("kinetic", "Energies", STATE, Shape::Scalar, |d| straight([d.equations.formed.energies?[0]])),
    output("potential", "Energies", &[Q, T], Shape::Scalar, |d| straight([d.equations.formed.energies?[1]])),
    output("velocities", "LegendreTransform", &[Q, P, T], COORDINATES,
        |d| d.equations.responses.legendre.as_ref().map(|l| d.solution(&l.velocities, &l.right))),
    output("constraints", "Constrained", &[Q, T], CONSTRAINTS, |d| held(d, d.equations.formed.rows.values.clone())),
    output("constraint_rates", "Constrained", STATE, CONSTRAINTS, |d| held(d, d.equations.formed.rows.rates.clone())),
    output("constraint_jacobian", "Constrained", &[Q, T], Shape::Matrix(Size::Constraints, Size::Coordinates),
        |d| held(d, transposed(&d.equations.formed.rows.jacobian))),
    output("multipliers", "Constrained", STATE, CONSTRAINTS,
        |d| d.redundant(Part::Multipliers).or_else(|| held(d, d.equations.solved.multipliers.clone()))),
    Output { inlining: Inlining::Possible, ..output("response", "Constrained",
        &[Q, QD, T, given("impulse", COORDINATES), given("rates", CONSTRAINTS)], Shape::Tuple(&[COORDINATES, CONSTRAINTS]),
        |d| d.redundant(Part::Response).or_else(|| straight(d.equations.responses.response.clone()?))) },
    output("reactions", "Prescribed", STATE, Shape::Vector(Size::Prescribed),
        |d| Some(d.equations.solved.reactions.clone()).filter(|all| !all.is_empty()).and_then(straight)),
    Output { inlining: Inlining::Free, ..output("linearize", "Linearize", STATE,
        Shape::Structure("Linearization", &[("stiffness", SQUARE), ("damping", SQUARE)]),
        |d| columns(&d.equations.responses.linearization, "dual_linearization")) },
    output("input_jacobian", "InputJacobian", STATE, Shape::Matrix(Size::Coordinates, Size::Inputs),
        |d| d.model.inputs().next().and_then(|_| columns(&d.equations.responses.by_inputs, "dual_input_jacobian"))),
    output("ignorable_velocities", "Routhian", STATE, Shape::Vector(Size::Ignorable),
        |d| straight(d.model.reduction.as_ref()?.removed.iter().map(|r| r.velocity).collect::<Vec<_>>())),
    output("held", "Restricted", STATE, Shape::Tuple(&[REMOVED, REMOVED]),
        |d| d.model.origin.as_ref().and_then(|_| straight(d.equations.quantities.held.concat()))),
    output("fast_velocities", "Restricted", &[Q, T], COORDINATES,
        |d| Some(d.equations.quantities.fast.clone()).filter(|all| !all.is_empty()).and_then(straight)),
];

const fn output(
    name: &'static str,
    of: &'static str,
    takes: &'static [Argument],
    gives: Shape,
    values: fn(&Derived) -> Option<Computation>,
) -> Output {
    Output { name, of, takes, gives, inlining: Inlining::Forced, values }
}

fn straight(values: impl Into<Vec<Value>>) -> Option<Computation> {
    Some(Computation::Straight(values.into()))
}

/// Computation for constraints, if there are any.
fn held(d: &Derived, values: Vec<Value>) -> Option<Computation> {
    if d.model.constraints.is_empty() { None } else { straight(values) }
}

/// Columns, or duals where there are none.
fn columns(columns: &Option<Vec<Vec<Value>>>, dual: &'static str) -> Option<Computation> {
    Some(columns.as_ref().map_or(Computation::Duals(dual, None), |all| Computation::Straight(all.concat())))
}

fn transposed(rows: &[Vec<Value>]) -> Vec<Value> {
    let columns = rows.first().map_or(0, Vec::len);
    (0..columns).flat_map(|i| rows.iter().map(move |row| row[i])).collect()
}

/// M, by duals where its n² entries are more than the system itself.
fn inertia(d: &Derived) -> Option<Computation> {
    let (m, n) = (&d.equations.solved.inertia, d.model.coordinates.len());
    let all: Vec<Value> = (0..n * n).map(|at| entry(m, at % n, at / n)).collect();
    let lower: Vec<Value> = m.iter().flatten().copied().collect();
    let long = operations(&d.graph, &lower).arithmetic() > MAX_INERTIA_OPERATIONS && !d.is_looped();
    Some(if long { Computation::Duals("dual_inertia", Some(all)) } else { Computation::Straight(all) })
}

/// A trait that generated types implement, or derive.
pub struct Trait {
    pub name: &'static str,
    /// Its generic parameters.
    pub sizes: &'static [Size],
    /// Its functions beside those of [`OUTPUTS`].
    pub functions: &'static [&'static str],
}

const fn of_trait(name: &'static str, sizes: &'static [Size], functions: &'static [&'static str]) -> Trait {
    Trait { name, sizes, functions }
}

const N: &[Size] = &[Size::Coordinates];

/// Every trait with functions; the first row are functions of the type itself.
#[rustfmt::skip]
pub const TRAITS: &[Trait] = &[
    of_trait("", &[], &["new", "map", "reduce"]),
    of_trait("Clone", &[], &["clone", "clone_from"]),
    of_trait("Debug", &[], &["fmt"]),
    of_trait("PartialEq", &[], &["eq", "ne"]),
    of_trait("Default", &[], &["default"]),
    of_trait("System", N, &["restored", "resolved", "explained", "saltated", "shortened", "switches", "decides", "kinked", "constraint_terms", "toward_constraints", "independence", "determined", "differentiable", "begun_across", "restored_across", "accel_across", "accel_at"]),
    of_trait("Precompute", N, &["constants", "accel_with", "accel_inlined", "precomputed"]),
    of_trait("Rescale", N, &["over", "set_lane"]),
    of_trait("Lagrangian", N, &[
        "lagrangian_at", "momenta_at", "energy_function_at", "inertia_at", "convective_momentum_rate_at", "momentum_rate_at",
        "dissipation_at", "power_at", "jacobian_at",
    ]),
    of_trait("Energies", N, &["energy", "energy_at", "kinetic_at", "potential_at"]),
    of_trait("LegendreTransform", N, &[]),
    of_trait("Constrained", &[Size::Coordinates, Size::Constraints], &["constraint_forces", "constraints_at", "constraint_rates_at", "multipliers_at", "constraint_forces_at"]),
    of_trait("Impulsive", N, &["jump", "rebound"]),
    of_trait("Prescribed", &[Size::Coordinates, Size::Prescribed], &["reactions_at"]),
    of_trait("Linearize", N, &["linearize_at"]),
    of_trait("Analytic", N, &["switching", "series_within", "sides", "series"]),
    of_trait("Routhian", &[Size::Coordinates, Size::Ignorable, Size::Whole], &["expand", "ignorable_velocities_at"]),
    of_trait("Restricted", &[Size::Coordinates, Size::Ignorable, Size::Whole], &["of", "lift", "restrict"]),
    of_trait("Inputs", &[Size::Coordinates, Size::Inputs], &["inputs", "set_inputs"]),
    of_trait("States", &[Size::Coordinates, Size::Mechanical, Size::States], &["initial_states", "states", "set_states", "start"]),
    of_trait("CompiledEvents", N, &["event_value", "event_rates"]),
    of_trait("InputJacobian", &[Size::Coordinates, Size::Inputs], &["input_jacobian_at"]),
];

impl Trait {
    pub fn named(name: &str) -> &'static Trait {
        TRAITS.iter().find(|t| t.name == name).expect("a trait of the table")
    }

    pub fn outputs(&self) -> impl Iterator<Item = &'static Output> {
        let name = self.name;
        OUTPUTS.iter().filter(move |o| o.of == name)
    }

    /// The names of its functions.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.functions.iter().copied().chain(self.outputs().map(|o| o.name))
    }
}

/// Constants that generated types have by their traits.
pub const CONSTANTS: [&str; 6] = ["FACTS", "AUTONOMOUS", "FIRST_ORDER", "SWITCHES", "INPUTS", "STATES"];

/// An output of the user's must not hide what systems have.
pub fn check_names(definition: &Definition, errors: &mut Errors) {
    let names = definition.statements.iter().flat_map(|statement| match statement {
        Statement::Observe(d) => vec![&d.name],
        Statement::Impulse { name, .. } => vec![name],
        // A state is an output as well.
        Statement::State(list) => list.iter().map(|d| &d.name).collect(),
        _ => Vec::new(),
    });
    let names: Vec<&Ident> = names.collect();
    for statement in &definition.statements {
        let Statement::Event(event) = statement else { continue };
        let (name, constant) = (&event.name, event.constant());
        let message = if CONSTANTS.contains(&constant.as_str()) {
            format!(
                "systems have a constant `{constant}` already\nhelp: choose another name, such as `{name}_`"
            )
        } else if names.iter().any(|output| **output == constant) {
            format!(
                "the constant of this event is `{constant}`, and an output is called so\nhelp: give one of them another name"
            )
        } else {
            continue;
        };
        errors.push(name, message);
    }
    // Only where there is such a type: a wing has a lift.
    let is_restricted = definition.statements.iter().any(|s| matches!(s, Statement::Submodel(_)));
    for name in names {
        let traits = TRAITS.iter().filter(|t| is_restricted || t.name != "Restricted");
        if traits.flat_map(Trait::names).any(|taken| name == taken) {
            let message = format!(
                "systems have a function `{name}` already\nhelp: choose another name, such as `{name}_`"
            );
            errors.push(name, message);
        }
    }
}
