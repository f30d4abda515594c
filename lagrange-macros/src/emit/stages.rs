//! The stages of one system as text: what each makes, what was tried, what each candidate costs, and which was taken.
//! `LAGRANGE_SHOW=stages` in the environment prints it where a system is expanded (docs/from-formula-to-code.md).

use crate::equations::Derived;
use crate::equations::elimination::Candidate;
use crate::equations::series::{Series, Tried};
use crate::graph::{Comparison, Graph, Id, Node, Symbol, Value};
use crate::model::Model;
use crate::program::count::{Operations, operations};
use crate::table::{Computation, OUTPUTS};
use std::cell::Cell;
use std::fmt::Write;

/// Formulas of more nodes are cut off.
const MAX_NODES: usize = 40;

/// Everything about a system, by stages.
pub fn stages(d: &Derived) -> String {
    let Derived { graph: g, model, equations: e } = d;
    let writer = Writer { g, model, left: Cell::new(0) };
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

/// Values in the names of a model, as formulas of one line.
struct Writer<'a> {
    g: &'a Graph,
    model: &'a Model,
    /// Nodes that the current formula may still have.
    left: Cell<usize>,
}

impl Writer<'_> {
    fn text(&self, v: Value) -> String {
        self.left.set(MAX_NODES);
        let text = self.value(v);
        if text.contains("...") { format!("{text} ({} nodes)", self.g.live(&[v]).len()) } else { text }
    }

    fn value(&self, v: Value) -> String {
        let Some(id) = v.node else { return format!("{}", v.k.to_f64()) };
        match v.k.to_f64() {
            1.0 => self.node(id),
            -1.0 => format!("-{}", self.node(id)),
            k => format!("{k} {}", self.node(id)),
        }
    }

    fn node(&self, id: Id) -> String {
        // What is shared would be written once for each of its users.
        if self.left.get() == 0 {
            return "...".into();
        }
        self.left.set(self.left.get() - 1);
        let list = |values: &[Value]| values.iter().map(|v| self.value(*v)).collect::<Vec<_>>().join(", ");
        match self.g.node(id) {
            Node::Symbol(symbol) => self.symbol(*symbol),
            Node::Sum(a, b) => format!("({} + {})", self.value(*a), self.value(*b)).replace("+ -", "- "),
            Node::Product(a, b) => format!("{} {}", self.node(*a), self.node(*b)),
            Node::Inverse(a) => format!("1/{}", self.node(*a)),
            Node::Call(f, a, b) => {
                format!("{}({})", f.row().name, list(&[*a, *b][..f.row().arguments.len()]))
            }
            Node::Extern(f, _, arguments) => {
                format!("{}({})", self.model.externals[*f].name, list(arguments))
            }
            Node::Select(comparison, values) => {
                let [a, b, yes, no] = values.map(|v| self.value(v));
                let sign = match comparison {
                    Comparison::Less => "<",
                    Comparison::LessEqual => "<=",
                    Comparison::Equal => "==",
                };
                format!("(if {a} {sign} {b} {{ {yes} }} else {{ {no} }})")
            }
        }
    }

    fn symbol(&self, symbol: Symbol) -> String {
        let coordinate = |i: usize| self.model.coordinates[i].label();
        match symbol {
            Symbol::Time => "t".into(),
            Symbol::Parameter(i) => self.model.parameter_labels()[i].clone(),
            Symbol::Coordinate(i) => coordinate(i),
            Symbol::Velocity(i) if i >= self.model.mechanical() => coordinate(i),
            Symbol::Acceleration(i) if i >= self.model.mechanical() => format!("{}'", coordinate(i)),
            Symbol::Velocity(i) => format!("{}'", coordinate(i)),
            Symbol::Acceleration(i) => format!("{}''", coordinate(i)),
            Symbol::Binding(k) => self.model.bindings[k].name.clone(),
            Symbol::Rate(k) => format!("{}'", self.model.bindings[k].name),
            other => format!("{other:?}"),
        }
    }
}
