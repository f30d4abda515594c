//! Terms of L that are total time derivatives d/dt F(q, t): they are linear in the velocities, and have no part in the
//! equations of motion (Landau and Lifshitz, *Mechanics*, 3rd ed. 1976, §2). Who writes −c q̇ for friction means
//! another thing.

use super::check::{TRIALS, sample};
use super::formed::Formed;
use crate::diagnostics::Errors;
use crate::graph::{Graph, Symbol, Value};
use crate::model::{Model, Parameter};

/// Warns of parameters that are in such terms alone, unless their names say that nothing depends on them.
pub fn gauge(g: &Graph, model: &Model, formed: &Formed, errors: &mut Errors) {
    let derived = model.origin.is_some() || model.reduction.is_some();
    let Some(keyword) = model.keywords.kinetic.as_ref().filter(|_| !derived && model.routhian.is_none())
    else {
        return;
    };
    let written = g.symbols(&[formed.lagrangian]);
    let elsewhere = elsewhere(g, model, formed);
    let is_of = |p: &Parameter, s: &Symbol| matches!(s, Symbol::Parameter(i) if p.numbers().contains(i));
    let candidates = model.parameters.iter().filter(|p| {
        written.iter().any(|s| is_of(p, s))
            && !elsewhere.iter().any(|s| is_of(p, s))
            && !p.name.to_string().starts_with('_')
    });
    for p in candidates {
        // One form of the equations without it is a proof.
        let is_free = formed.systems.iter().any(|system| {
            let all: Vec<Value> = system.matrix.iter().flatten().chain(&system.right).copied().collect();
            !g.depends(&all, |s| is_of(p, &s))
        });
        if is_free && is_linear(g, formed.energy_function, |s| is_of(p, &s)) {
            let (name, x) = (&p.name, model.coordinates[0].label());
            let message = format!(
                "no equation of motion depends on `{name}`: its terms in `{keyword}` are a total time derivative\nhelp: a force that dissipates is a term of `D`, as `D = 0.5 * {name} * dot({x}).powi(2);`, or of `Q[{x}]`; if `{name}` is meant to be without effect, call it `_{name}`"
            );
            errors.warn(name.span(), "unused_parameter", message);
        }
    }
}

/// Symbols of all that is emitted beside what follows from L.
fn elsewhere(g: &Graph, model: &Model, formed: &Formed) -> Vec<Symbol> {
    let observed = model.observed.iter().flat_map(|o| &o.values);
    let events = model.events.iter().flat_map(|e| &e.values);
    let struck = model.struck.iter().flat_map(|s| &s.position);
    let constraints = model.constraints.iter().map(|c| &c.value);
    let values: Vec<Value> = observed.chain(events).chain(struck).chain(constraints).copied().collect();
    let symbols = g.symbols(&values);
    let bound = symbols.iter().filter_map(|s| match s {
        Symbol::Binding(k) | Symbol::Rate(k) => formed.flat.get(*k),
        _ => None,
    });
    let prescribed = model.prescribed.iter().map(|p| &formed.flat[p.binding]);
    let bound: Vec<Value> = bound.chain(prescribed).flatten().copied().collect();
    let more = g.symbols(&[&bound[..], &formed.nonconservative].concat());
    [symbols, more].concat()
}

/// Are terms of L with these parameters linear in the velocities, so that h = p·q̇ − L does not depend on them? Tried
/// at reproducible states: a dependence is always found but for an accident.
fn is_linear(g: &Graph, energy: Value, is_of: impl Fn(Symbol) -> bool) -> bool {
    (0..TRIALS).all(|trial| {
        let at = |k: f64| g.evaluate(&[energy], |s| sample(s, trial, 0) * if is_of(s) { k } else { 1.0 })[0];
        let (one, other) = (at(1.0), at(2.0));
        (one - other).abs() <= 1e-9 * (1.0 + one.abs())
    })
}
