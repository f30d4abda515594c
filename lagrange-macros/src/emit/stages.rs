//! The stages of one system as text: what each makes, what was tried, what each candidate costs, and which was taken.
//! `LAGRANGE_SHOW=stages` in the environment prints it where a system is expanded (docs/from-formula-to-code.md).

use crate::equations::Derived;
use crate::equations::elimination::Candidate;
use crate::equations::series::{Series, Tried};
use crate::equations::text::Writer;
use crate::graph::Value;
use crate::program::count::{Operations, operations};
use crate::table::{Computation, OUTPUTS};
use std::fmt::Write;

/// Everything about a system, by stages.
pub fn stages(d: &Derived) -> String {
    let Derived { graph: g, model, equations: e } = d;
    let writer = Writer::new(g, model);
    let mut text = format!("{} by stages\n", model.name);
    // Writing to a string cannot fail.
    let mut line = |indent: usize, content: String| {
        let _ = writeln!(text, "{:indent$}{content}", "");
    };
    let each = |name: &str, values: &[Value]| -> Vec<String> {
        let labels = model.coordinates.iter().map(|c| format!("{name}[{}]", c.label()));
        labels.zip(values).map(|(label, v)| format!("{label} = {}", writer.text(*v))).collect()
    };

    line(0, "model: names become nodes; a binding stays a symbol, with its rate".into());
    for b in &model.bindings {
        line(2, format!("{} = {}", b.name, writer.text(b.value)));
        line(2, format!("{}' = {}", b.name, writer.text(b.rate)));
    }
    line(2, format!("L = {}", writer.text(model.lagrangian)));

    line(0, "formed: M q'' = f - b, and what M and the right-hand side cost in each form".into());
    each("p", &e.formed.momenta).into_iter().for_each(|momentum| line(2, momentum));
    for system in &e.formed.systems {
        let all: Vec<Value> = system.matrix.iter().flatten().chain(&system.right).copied().collect();
        line(2, format!("{}: {}", system.form, cost(&operations(g, &all))));
    }

    line(0, "solved: all ways that were tried; the cheapest is taken, the first among equals".into());
    let mut taken = false;
    for Candidate { way, cost: found } in &e.solved.tried {
        let is_taken = !taken && *found == Some(e.solved.operations);
        taken |= is_taken;
        let mark = if is_taken { "->" } else { "  " };
        line(2, format!("{mark} {way}: {}", found.map_or("given up".into(), |o| cost(&o))));
    }
    each("accel", &e.solved.accel).into_iter().for_each(|a| line(2, a));

    line(0, "facts: proved by absence or by multiplying out".into());
    line(2, format!("{:?}", e.facts));

    line(0, "series: recurrences of the Taylor coefficients, likewise".into());
    match &e.series {
        None => line(
            2,
            "none: a function of the user's, a power whose exponent moves, constraints that follow from others, or too many products".into(),
        ),
        Some(Series { switches, tried, .. }) => {
            line(2, format!("on one side of {} switches", switches.len()));
            let least = tried.iter().filter(|form| !form.is_bound).map(|form| form.cost).min();
            let mut taken = false;
            for Tried { way, cost, is_bound } in tried {
                let is_taken = !taken && !is_bound && Some(*cost) == least;
                taken |= is_taken;
                let (mark, at_least) =
                    (if is_taken { "->" } else { "  " }, if *is_bound { "at least " } else { "" });
                line(2, format!("{mark} {way}: cost {at_least}{cost} of order 20"));
            }
        }
    }

    line(0, "outputs: how each function is computed".into());
    for output in OUTPUTS {
        let Some(computation) = (output.values)(d) else { continue };
        let how = match &computation {
            Computation::Straight(values) => cost(&operations(g, values)),
            Computation::Duals(function, _) => format!("by {function}"),
            Computation::Loop { .. } => "by a loop".into(),
            Computation::Redundant(_) => "by pivots at run time".into(),
        };
        line(2, format!("{}::{}: {how}", output.of, output.name));
    }
    text
}

fn cost(o: &Operations) -> String {
    let Operations { additions, multiplications, divisions, sin_cos, functions, path } = o;
    format!(
        "cost {} = {additions} add, {multiplications} mul, {divisions} div, {sin_cos} sin_cos, {functions} functions, {path} cycles",
        o.cost()
    )
}
