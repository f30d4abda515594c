//! The Taylor series of a motion, order by order, from the same graph that `accel` comes from.
//!
//! With x_k the k-th Taylor coefficient of x(t), each node of the graph gives its k-th coefficient from those of its
//! operands up to k (Moore 1966; Jorba and Zou 2005; Griewank and Walther 2008, ch. 13):
//!
//! ```text
//! (a b)_k = Σ a_j b_{k−j}                  (a/b)_k = (a_k − Σ_{j≥1} b_j (a/b)_{k−j}) / b_0
//! f(a)_k  = (1/k) Σ j a_j f'(a)_{k−j}      (a^r)_k = Σ_{j<k} (r (k−j) − j) a_{k−j} (a^r)_j / (k a_0)
//! ```
//!
//! The rule for functions needs the series of the derivative one order behind, so the formulas of the function table
//! serve for all of them, and sine and cosine are each other's. What depends on parameters alone is a number, and is not
//! convolved. Where it costs less, M q̈ = right is solved as a series: M_0 a_k = right_k − Σ_{j≥1} M_j a_{k−j}.

use super::Equations;
use super::solve::{Symmetric, entry};
use crate::graph::{Function, Graph, Id, Node, Number, Symbol, Value, stable_map::StableMap};

/// Systems of more products of series have none emitted: it would cost more to compile than it saves.
const LONGEST: usize = 20_000;

/// How the coefficients of a node follow from those of others.
pub enum Rule {
    /// A sum of series and numbers, each with a factor that is a number.
    Linear(Vec<(Value, Value)>),
    Product(Id, Id),
    Square(Id),
    Quotient(Value, Id),
    /// A power with a number for its exponent.
    Power(Value, Value),
    /// A function by its arguments that move, and its partial derivatives.
    Function(Vec<(Value, Value)>),
}

/// What is known of each order in the end.
pub enum Outputs {
    Accelerations(Vec<Value>),
    /// The bordered matrix and its right-hand side.
    System {
        matrix: Symmetric,
        right: Vec<Value>,
    },
}

/// The recurrences of a system: nodes that move, operands first.
pub struct Series {
    pub rules: Vec<(Id, Rule)>,
    pub outputs: Outputs,
}

/// The recurrences with the fewest products of series; none for systems with choices, absolute values or functions of
/// the user's, which have no Taylor series everywhere or none that is known.
pub fn series(e: &mut Equations) -> Option<Series> {
    let direct = of(&mut e.model.graph, Outputs::Accelerations(e.accel.clone()))?;
    let mut best = direct;
    if e.accel.len() > 1 {
        let (matrix, right) = e.rows.border(&e.inertia, &e.right);
        if let Some(system) = of(&mut e.model.graph, Outputs::System { matrix, right })
            && system.products(&e.model.graph) < best.products(&e.model.graph)
        {
            best = system;
        }
    }
    (best.products(&e.model.graph) <= LONGEST).then_some(best)
}

/// Does it depend on nothing but parameters?
pub fn is_number(g: &Graph, v: Value) -> bool {
    v.node.is_none_or(|id| g.is_fixed(id))
}

impl Series {
    /// Products of two series that each order needs.
    pub fn products(&self, g: &Graph) -> usize {
        let of_rules = self.rules.iter().map(|(_, rule)| match rule {
            Rule::Linear(_) => 0,
            Rule::Product(..) | Rule::Square(_) | Rule::Quotient(..) | Rule::Power(..) => 1,
            Rule::Function(slopes) => slopes.len(),
        });
        let of_system = match &self.outputs {
            Outputs::Accelerations(_) => 0,
            Outputs::System { matrix, right } => {
                let all = (0..right.len()).flat_map(|i| (0..right.len()).map(move |j| (i, j)));
                all.filter(|&(i, j)| !is_number(g, entry(matrix, i, j))).count()
            }
        };
        of_rules.sum::<usize>() + of_system
    }
}

impl Outputs {
    pub fn values(&self) -> Vec<Value> {
        match self {
            Outputs::Accelerations(accel) => accel.clone(),
            Outputs::System { matrix, right } => matrix.iter().flatten().chain(right).copied().collect(),
        }
    }
}

fn of(g: &mut Graph, outputs: Outputs) -> Option<Series> {
    let mut known: StableMap<Id, ()> = StableMap::default();
    let mut rules: Vec<(Id, Rule)> = Vec::new();
    // Derivatives of functions are new roots, and are made of the function itself or of nodes that end soon.
    let mut stack: Vec<Id> = outputs.values().iter().filter_map(|v| v.node).collect();
    while let Some(id) = stack.pop() {
        if g.is_fixed(id) || matches!(g.node(id), Node::Symbol(_)) || known.get(&id).is_some() {
            continue;
        }
        let rule = rule(g, id)?;
        rule.operands(|v| stack.extend(v.node));
        known.insert(id, ());
        rules.push((id, rule));
    }
    rules.sort_unstable_by_key(|(id, _)| *id);
    Some(Series { rules, outputs })
}

impl Rule {
    /// Calls `visit` with each series that the rule is about.
    pub fn operands(&self, mut visit: impl FnMut(Value)) {
        match self {
            Rule::Linear(terms) => terms.iter().for_each(|(_, x)| visit(*x)),
            Rule::Product(a, b) => [*a, *b].into_iter().for_each(|id| visit(id.into())),
            Rule::Square(a) => visit((*a).into()),
            Rule::Quotient(a, b) => [*a, (*b).into()].into_iter().for_each(visit),
            Rule::Power(a, _) => visit(*a),
            Rule::Function(slopes) => slopes.iter().flat_map(|(a, b)| [*a, *b]).for_each(visit),
        }
    }
}

/// The rule of a node that moves.
fn rule(g: &mut Graph, id: Id) -> Option<Rule> {
    Some(match g.node(id).clone() {
        Node::Sum(a, b) => Rule::Linear(vec![(Value::ONE, a), (Value::ONE, b)]),
        Node::Product(a, b) => match (g.node(a).clone(), g.node(b).clone()) {
            _ if g.is_fixed(a) => Rule::Linear(vec![(a.into(), b.into())]),
            _ if g.is_fixed(b) => Rule::Linear(vec![(b.into(), a.into())]),
            _ if a == b => Rule::Square(a),
            (_, Node::Inverse(under)) => Rule::Quotient(a.into(), under),
            (Node::Inverse(under), _) => Rule::Quotient(b.into(), under),
            _ => Rule::Product(a, b),
        },
        Node::Inverse(under) => Rule::Quotient(Value::ONE, under),
        Node::Call(Function::sqrt, a, _) => Rule::Power(a, Value::constant(Number::Ratio(1, 2))),
        Node::Call(Function::powf, a, r) if is_number(g, r) => Rule::Power(a, r),
        // Its derivatives have ever more powers; and the others are not smooth.
        Node::Call(Function::powf | Function::abs | Function::signum, ..) => return None,
        Node::Call(..) => {
            let partials = g.partials(id);
            Rule::Function(partials.into_iter().filter(|(a, _)| !is_number(g, *a)).collect())
        }
        Node::Symbol(_) | Node::Extern(..) | Node::Select(..) => return None,
    })
}

/// The symbol of a node, if it is one.
pub fn symbol(g: &Graph, id: Id) -> Option<Symbol> {
    match g.node(id) {
        Node::Symbol(symbol) => Some(*symbol),
        _ => None,
    }
}
