//! Lagrange's equations of a model, solved for the accelerations, and everything else that follows from L, D and Q:
//! each quantity an expression in q, q̇, t and the parameters.
//!
//! Each stage makes plain values of those before it, and adds nodes to the graph: `formed` M and the forces, `solved`
//! the accelerations, `structure` the facts, `outputs` what is emitted beside the accelerations, `series` the
//! recurrences. The order of the stages is that of their nodes, by which sums and products are ordered.

pub mod assemble;
pub mod augmented;
mod average;
pub mod check;
mod common;
pub mod constraints;
pub mod elimination;
pub mod events;
pub mod formed;
mod gauge;
mod impulses;
pub mod quantities;
pub mod responses;
pub mod restriction;
pub mod routhian;
pub mod scaling;
pub mod series;
pub mod simplified;
pub mod solve;
pub mod solved;
pub mod statics;
pub mod structure;
pub mod submodel;
pub mod symmetry;
pub mod text;

use crate::diagnostics::Errors;
use crate::graph::Graph;
use crate::model::Model;
use events::{EventFunction, events};
use formed::{Formed, formed};
use impulses::{Impulses, impulses};
use quantities::{Quantities, quantities};
use responses::{Responses, responses};
use scaling::{Scalings, scalings};
use series::{Series, series};
use solved::{Solved, solved};
use structure::{Facts, facts};
use symmetry::{Symmetries, symmetries};

/// A system with its equations. The graph has the nodes of both.
pub struct Derived {
    pub graph: Graph,
    pub model: Model,
    pub equations: Equations,
}

pub struct Equations {
    pub formed: Formed,
    pub impulses: Impulses,
    pub solved: Solved,
    pub quantities: Quantities,
    pub facts: Facts,
    pub responses: Responses,
    /// Recurrences of the Taylor coefficients.
    pub series: Option<Series>,
    /// Functions of the events.
    pub events: Vec<Vec<EventFunction>>,
    /// First integrals of rotations.
    pub symmetries: Symmetries,
    /// Changes of scale that leave the equations as they are, if they are known.
    pub scalings: Option<Scalings>,
}

impl Equations {
    /// Has the motion Taylor series everywhere, on no side of anything?
    pub fn analytic(&self) -> bool {
        self.series.as_ref().is_some_and(|series| series.switches.is_empty())
    }
}

/// Derives the equations. What only derivation finds (singular inertia, a D that is no quadratic form) is recorded.
pub fn equations(g: &mut Graph, model: &Model, errors: &mut Errors) -> Option<Equations> {
    let formed = formed(g, model, errors)?;
    let impulses = impulses(g, model, &formed, errors);
    // (The size of an impulse is in no equation of motion.)
    if impulses.switches.is_empty() {
        gauge::gauge(g, model, &formed, errors);
    }
    let solved = solved(g, model, &formed, errors)?;
    let quantities = quantities(g, model, &formed, &solved);
    let facts = facts(g, model, &formed, &solved, &quantities);
    let responses = responses(g, model, &formed, &solved, &quantities, &facts, &impulses.switches)?;
    let series = if formed.rows.redundancy.is_some() {
        None
    } else {
        series(g, model, &formed, &solved, &quantities, &facts, &impulses.values())
    };
    let events = events(g, model, &formed, &solved);
    let symmetries = symmetries(g, model, &formed);
    let scalings = scalings(g, model, &formed);
    Some(Equations {
        formed,
        impulses,
        solved,
        quantities,
        facts,
        responses,
        series,
        events,
        symmetries,
        scalings,
    })
}

/// The equations of a model beside it.
pub fn derived((mut graph, model): (Graph, Model), errors: &mut Errors) -> Option<Derived> {
    let equations = equations(&mut graph, &model, errors)?;
    Some(Derived { graph, model, equations })
}
