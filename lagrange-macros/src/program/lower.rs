//! From the graph to a program: which nodes have slots of their own, which are written inside the expression of their
//! only user, what is fused with an addition, what is a division, and which sines and cosines are computed together.
//! Nothing after this decides any of it.
//!
//! Operands come before users; every node is computed once; an operand is computed as late as its first user allows,
//! depth first, so that values are used soon after they are made.

use super::{Operand, Operation, Program, Slot, Source};
use crate::graph::{
    Coefficient, Function, Graph, Id, Node, Number, Symbol, Value,
    stable_map::{IdMap, StableMap},
};

/// Maximum depth of expressions, in operations that are written inside each other.
const MAX_NESTED_OPERATIONS: usize = 3;
/// Minimum number of sine–cosine pairs, of angles that need no others, that are computed together: a vector of them
/// takes less than as many calls (docs/lab/performance.md).
const MIN_PAIRS_TOGETHER: usize = 2;

/// Sine and cosine of an angle.
#[derive(Clone, Copy)]
struct Circle {
    angle: Value,
    sine: Id,
    cosine: Id,
}

/// A node that is computed.
#[derive(Clone, Copy, Default)]
struct Use {
    count: usize,
    /// Nested operations, if it is written inside its user.
    depth: usize,
    inline: bool,
    visited: bool,
    /// Is it, or is below it, a sine or a cosine?
    above_circle: bool,
    circle: Option<usize>,
    slot: Option<usize>,
}

struct Lowering<'a, K> {
    g: &'a Graph,
    known: K,
    uses: IdMap<Use>,
    circles: Vec<Circle>,
    constants: StableMap<Value, usize>,
    program: Program,
}

/// The program that computes these outputs.
pub fn program(g: &Graph, outputs: &[Value]) -> Program {
    program_from(g, outputs, |_| false)
}

/// The program that computes these outputs from the state, the parameters and the values that follow from these alone.
pub fn prepared(g: &Graph, outputs: &[Value]) -> Program {
    program_from(g, outputs, |v| g.is_derived(v))
}

/// The program that computes these outputs from values that are `known`, whatever their signs, which are its constants.
pub fn program_from(g: &Graph, outputs: &[Value], known: impl Fn(Value) -> bool) -> Program {
    let live = g.live_without(outputs, &known);
    let mut lowering = Lowering {
        g,
        known,
        uses: IdMap::default(),
        circles: Vec::new(),
        constants: StableMap::default(),
        program: Program::default(),
    };
    lowering.count_uses(&live, outputs);
    let together = lowering.pair(&live);
    lowering.nest(&live, outputs);
    if together.len() >= MIN_PAIRS_TOGETHER {
        together.iter().for_each(|circle| lowering.visit(lowering.circles[*circle].angle));
        lowering.circle(&together);
    }
    outputs.iter().for_each(|v| lowering.visit(*v));
    lowering.program.outputs = outputs.iter().map(|v| lowering.operand(*v)).collect();
    lowering.program
}

impl<K: Fn(Value) -> bool> Lowering<'_, K> {
    /// Counts the uses of nodes; finds the constants and inputs of the program.
    fn count_uses(&mut self, live: &[Id], outputs: &[Value]) {
        let Lowering { g, known, constants, program, uses, .. } = self;
        let mut note = |uses: &mut IdMap<Use>, v: Value| {
            let Some(node) = v.node else { return };
            if let Some(of) = uses.get_mut(&node) {
                of.count += 1;
            }
            if known(v) {
                let unsigned = Value { k: v.k.abs(), ..v };
                if constants.get(&unsigned).is_none() {
                    constants.insert(unsigned, program.constants.len());
                    program.constants.push(unsigned);
                }
            }
        };
        for id in live {
            uses.insert(*id, Use::default());
            g.operands(*id, |v| note(uses, v));
            if let Node::Symbol(symbol) = g.node(*id) {
                program.inputs.push(*symbol);
            }
        }
        outputs.iter().for_each(|v| note(uses, *v));
    }

    /// Finds the pairs of a sine and a cosine; returns those whose angles need no others.
    fn pair(&mut self, live: &[Id]) -> Vec<usize> {
        let g = self.g;
        let mut first: Vec<usize> = Vec::new();
        let mut sines: StableMap<Value, (Option<Id>, Option<Id>)> = StableMap::default();
        for &id in live {
            let mut above = false;
            g.operands(id, |v| {
                above |= v.node.and_then(|n| self.uses.get(&n)).is_some_and(|of| of.above_circle)
            });
            if let Node::Call(f @ (Function::sin | Function::cos), angle, _) = g.node(id) {
                let (mut s, mut c) = sines.get(angle).copied().unwrap_or_default();
                if *f == Function::sin {
                    s = Some(id)
                } else {
                    c = Some(id)
                }
                sines.insert(*angle, (s, c));
                if let (Some(sine), Some(cosine)) = (s, c) {
                    if !above && angle.node.is_some() {
                        first.push(self.circles.len());
                    }
                    let circle = Some(self.circles.len());
                    [sine, cosine].iter().for_each(|id| self.change(*id, |of| of.circle = circle));
                    self.circles.push(Circle { angle: *angle, sine, cosine });
                }
                above = true;
            }
            if above {
                self.change(id, |of| of.above_circle = true);
            }
        }
        first
    }

    /// Decides which nodes are written inside their only users.
    fn nest(&mut self, live: &[Id], outputs: &[Value]) {
        let g = self.g;
        // A result that is alone needs no name.
        let alone = match outputs {
            [output] if !(self.known)(*output) => output.node,
            _ => None,
        };
        for &id in live {
            let node = g.node(id);
            if matches!(node, Node::Symbol(_)) {
                continue;
            }
            let mut depth = 0;
            g.operands(id, |v| {
                if let Some(below) = v.node.and_then(|n| self.uses.get(&n))
                    && below.inline
                    && below.depth > depth
                {
                    depth = below.depth;
                }
            });
            // An inverse belongs to the division that it is part of.
            let shallow =
                depth < MAX_NESTED_OPERATIONS || matches!(node, Node::Inverse(_)) || alone == Some(id);
            self.change(id, |of| {
                of.depth = depth + 1;
                of.inline = shallow && of.count == 1 && of.circle.is_none();
            });
        }
    }

    /// Knowledge of a node; none of one that is not computed.
    fn of(&self, id: Id) -> Use {
        if let Some(of) = self.uses.get(&id) { *of } else { Use::default() }
    }

    fn change(&mut self, id: Id, change: impl FnOnce(&mut Use)) {
        if let Some(of) = self.uses.get_mut(&id) {
            change(of);
        }
    }

    /// Fills the slots below a value, depth first.
    fn visit(&mut self, root: Value) {
        let g = self.g;
        // (node, have its operands been visited?)
        let mut stack: Vec<(Id, bool)> =
            root.node.filter(|_| !(self.known)(root)).map(|n| (n, false)).into_iter().collect();
        while let Some((id, visited)) = stack.pop() {
            let of = self.of(id);
            if of.visited {
                continue;
            }
            if !visited {
                stack.push((id, true));
                let from = stack.len();
                g.operands(id, |v| {
                    if let Some(n) = v.node
                        && !(self.known)(v)
                    {
                        stack.push((n, false));
                    }
                });
                // Without optimisation, to reverse two of them takes ten times as long as to exchange them.
                match stack.len() - from {
                    0 | 1 => {}
                    2 => stack.swap(from, from + 1),
                    _ => stack[from..].reverse(),
                }
                continue;
            }
            self.change(id, |of| of.visited = true);
            if let Some(circle) = of.circle {
                self.circle(&[circle]);
            } else if !of.inline && !matches!(g.node(id), Node::Symbol(_)) {
                self.node(id);
            }
        }
    }

    fn is_inline(&self, id: Id) -> bool {
        self.of(id).inline
    }

    fn push(&mut self, node: Id, operation: Operation) -> usize {
        self.program.slots.push(Slot { operation, node, inline: self.is_inline(node) });
        self.program.slots.len() - 1
    }

    fn circle(&mut self, circles: &[usize]) {
        let circles: Vec<Circle> = circles.iter().map(|circle| self.circles[*circle]).collect();
        let angles: Vec<Operand> = circles.iter().map(|circle| self.operand(circle.angle)).collect();
        self.push(circles[0].sine, Operation::Circle(angles.clone()));
        for (circle, angle) in circles.iter().zip(angles) {
            let parts = [(circle.sine, Operation::Sine(angle)), (circle.cosine, Operation::Cosine(angle))];
            for (node, operation) in parts {
                let slot = self.push(node, operation);
                self.change(node, |of| (of.slot, of.visited) = (Some(slot), true));
            }
        }
    }

    /// Fills the slot of a node.
    fn node(&mut self, id: Id) -> usize {
        let operation = match self.g.node(id) {
            Node::Symbol(_) => unreachable!("symbols are operands"),
            Node::Sum(a, b) => self.sum(*a, *b),
            &Node::Product(a, b) => match (self.inverse(a), self.inverse(b)) {
                (_, Some(under)) => self.quotient(a.into(), under),
                (Some(under), None) => self.quotient(b.into(), under),
                (None, None) => match self.beside_over(a, b) {
                    Some(x) => Operation::OverOrder(self.operand(x.into())),
                    None => Operation::Product(self.operand(a.into()), self.operand(b.into())),
                },
            },
            Node::Inverse(a) => self.quotient(Value::ONE, *a),
            Node::Call(f, a, b) => Operation::Call(*f, self.operand(*a), self.operand(*b)),
            Node::Extern(f, orders, arguments) => {
                let arguments = arguments.iter().map(|a| self.operand(*a)).collect();
                Operation::Extern(*f, orders.clone(), arguments)
            }
            Node::Select(comparison, values) => {
                Operation::Select(*comparison, values.map(|v| self.operand(v)))
            }
        };
        let slot = self.push(id, operation);
        self.change(id, |of| of.slot = Some(slot));
        slot
    }

    fn quotient(&mut self, over: Value, under: Id) -> Operation {
        Operation::Quotient(self.operand(over), self.operand(under.into()))
    }

    /// Operand of an inverse that is written inside its user.
    fn inverse(&self, id: Id) -> Option<Id> {
        match self.g.node(id) {
            Node::Inverse(under) if self.is_inline(id) => Some(*under),
            _ => None,
        }
    }

    /// The other one if one of these is the reciprocal of the order of a series.
    fn beside_over(&self, a: Id, b: Id) -> Option<Id> {
        let is_over = |id| matches!(self.g.node(id), Node::Symbol(Symbol::Order(Coefficient::Over)));
        if is_over(a) { Some(b) } else { Some(a).filter(|_| is_over(b)) }
    }

    /// a + b, as one fused operation where one of them is a product, or a quotient by the order, that is needed
    /// nowhere else.
    fn sum(&mut self, a: Value, b: Value) -> Operation {
        let ways = [(b, a), (a, b)];
        if let Some((x, rest)) = ways.iter().find_map(|(v, rest)| Some((self.by_order(*v)?, *rest))) {
            return Operation::OverOrderPlus(self.operand(x), self.operand(rest));
        }
        if let Some(([x, y], rest)) = ways.iter().find_map(|(v, rest)| Some((self.fusible(*v)?, *rest))) {
            return Operation::Fused([self.operand(x), self.operand(y)], self.operand(rest));
        }
        let (a, b) = if a.k.is_negative() && !b.k.is_negative() { (b, a) } else { (a, b) };
        let a = self.operand(a);
        // What is subtracted keeps its own sign.
        let b = if b.k.is_negative() { -self.operand(-b) } else { self.operand(b) };
        Operation::Sum(a, b)
    }

    /// Dividend of a division by the order, in a quotient that is needed nowhere else.
    fn by_order(&self, v: Value) -> Option<Value> {
        let id = v.node.filter(|id| v.k.is_unit() && self.is_inline(*id))?;
        let Node::Product(a, b) = *self.g.node(id) else { return None };
        Some(Value { k: v.k, node: Some(self.beside_over(a, b)?) })
    }

    /// The factors of a product that can be fused with an addition.
    fn fusible(&self, v: Value) -> Option<[Value; 2]> {
        let id = v.node.filter(|_| self.constant(v).is_none())?;
        if !v.k.is_unit() {
            return Some([id.into(), Value::constant(v.k)]);
        }
        let Node::Product(x, y) = *self.g.node(id) else { return None };
        let divides = [x, y].into_iter().any(|id| self.inverse(id).is_some());
        let fuses = self.is_inline(id) && !divides && self.beside_over(x, y).is_none();
        fuses.then(|| [Value { k: v.k, node: Some(x) }, y.into()])
    }

    fn constant(&self, v: Value) -> Option<usize> {
        if !(self.known)(v) {
            return None;
        }
        self.constants.get(&Value { k: v.k.abs(), ..v }).copied()
    }

    fn operand(&mut self, v: Value) -> Operand {
        let Some(id) = v.node else { return Operand { k: v.k, of: Source::One } };
        if let Some(constant) = self.constant(v) {
            let k = if v.k.is_negative() { Number::MINUS_ONE } else { Number::ONE };
            return Operand { k, of: Source::Constant(constant) };
        }
        match *self.g.node(id) {
            Node::Symbol(symbol) => Operand { k: v.k, of: Source::Symbol(symbol) },
            // −(a − b) is b − a: rustc may not say so, for the sake of the sign of zero.
            Node::Sum(a, b) if v.k == Number::MINUS_ONE && self.is_inline(id) => {
                let operation = self.sum(-a, -b);
                Operand { k: Number::ONE, of: Source::Slot(self.push(id, operation)) }
            }
            _ => {
                let slot = self.of(id).slot.unwrap_or_else(|| self.node(id));
                Operand { k: v.k, of: Source::Slot(slot) }
            }
        }
    }
}
