//! Puts the graph below some outputs in sequential order: which nodes become `let`s, which are written inside the
//! expression of their only user, which sines and cosines are computed together.
//!
//! Operands come before users; every node is computed once; an operand is computed as late as its first user allows,
//! depth first, so that values are used soon after they are made.

pub mod count;

use crate::graph::{
    Function, Graph, Id, Node, Symbol, Value,
    stable_map::{IdMap, StableMap},
};

/// Expressions are nested no deeper than this.
const DEEPEST: usize = 3;
/// Minimum number of sine–cosine pairs, of angles that need no others, that are computed together: a vector of them takes
/// less than as many calls (docs/performance.md).
const TOGETHER: usize = 2;

/// A straight-line function.
pub struct Program {
    /// Numbers that it is given beside its inputs, without their signs.
    pub constants: Vec<Value>,
    /// Symbols that it reads.
    pub inputs: Vec<Id>,
    pub steps: Vec<Step>,
    pub outputs: Vec<Value>,
    inline: IdMap<()>,
}

pub enum Step {
    /// One node.
    Let(Id),
    /// Sine and cosine of one angle, or of several at once.
    SinCos(Vec<Circular>),
}

/// Sine and cosine of an angle.
#[derive(Clone, Copy)]
pub struct Circular {
    pub angle: Value,
    pub sine: Id,
    pub cosine: Id,
}

impl Program {
    /// Is the node written inside its only user?
    pub fn is_inline(&self, id: Id) -> bool {
        self.inline.get(&id).is_some()
    }
}

/// The program that computes these outputs.
pub fn schedule(g: &Graph, outputs: &[Value]) -> Program {
    schedule_from(g, outputs, |_| false)
}

/// The program that computes these outputs from the state, the parameters and what can be known of these beforehand.
pub fn schedule_prepared(g: &Graph, outputs: &[Value]) -> Program {
    schedule_from(g, outputs, |v| g.is_derived(v))
}

/// The program that computes these outputs from values that are `known`, which are its constants.
pub fn schedule_from(g: &Graph, outputs: &[Value], known: impl Fn(Value) -> bool) -> Program {
    let live = g.live_without(outputs, &known);
    let inputs = live.iter().copied().filter(|id| matches!(g.node(*id), Node::Symbol(_))).collect();
    let mut constants: Vec<Value> = Vec::new();
    let mut named: StableMap<Value, ()> = StableMap::default();
    let mut uses: IdMap<usize> = IdMap::default();
    let mut used = |v: Value| {
        if let Some(n) = v.node {
            uses.count(n);
        }
        let unsigned = Value { k: v.k.abs(), ..v };
        if known(unsigned) && named.get(&unsigned).is_none() {
            named.insert(unsigned, ());
            constants.push(unsigned);
        }
    };
    live.iter().for_each(|id| g.operands(*id, &mut used));
    outputs.iter().copied().for_each(&mut used);

    // Pairs of a sine and a cosine.
    let mut partners: IdMap<Circular> = IdMap::default();
    let mut first: Vec<Circular> = Vec::new();
    let mut above: IdMap<()> = IdMap::default();
    let mut sines: StableMap<Value, (Option<Id>, Option<Id>)> = StableMap::default();
    for &id in &live {
        if let Node::Call(f @ (Function::sin | Function::cos), angle, _) = g.node(id) {
            let (mut s, mut c) = sines.get(angle).copied().unwrap_or_default();
            if *f == Function::sin {
                s = Some(id)
            } else {
                c = Some(id)
            }
            sines.insert(*angle, (s, c));
            if let (Some(s), Some(c)) = (s, c) {
                let pair = Circular { angle: *angle, sine: s, cosine: c };
                partners.insert(s, pair);
                partners.insert(c, pair);
                first.extend(angle.node.filter(|n| above.get(n).is_none()).map(|_| pair));
            }
            above.insert(id, ());
        }
        g.operands(id, |v| {
            if v.node.is_some_and(|n| above.get(&n).is_some()) {
                above.insert(id, ());
            }
        });
    }
    let together = if first.len() < TOGETHER { Vec::new() } else { first };

    let alone = match outputs {
        [output] if !known(*output) => output.node,
        _ => None,
    };
    let mut inline: IdMap<()> = IdMap::default();
    let mut depths: IdMap<usize> = IdMap::default();
    for &id in &live {
        let mut depth = 0;
        g.operands(id, |v| {
            let below = v.node.filter(|n| inline.get(n).is_some()).and_then(|n| depths.get(&n));
            depth = depth.max(below.copied().unwrap_or(0));
        });
        depths.insert(id, depth + 1);
        let symbol = matches!(g.node(id), Node::Symbol(_));
        // An inverse belongs to the division that it is part of; a result that is alone needs no name.
        let shallow = depth < DEEPEST || matches!(g.node(id), Node::Inverse(_)) || alone == Some(id);
        if !symbol && uses.get(&id) == Some(&1) && partners.get(&id).is_none() && shallow {
            inline.insert(id, ());
        }
    }

    let mut steps = Vec::new();
    let mut done: IdMap<()> = IdMap::default();
    let mut follow = |roots: &mut dyn Iterator<Item = Value>, together: &[Circular]| {
        // (node, have its operands been visited?)
        let mut stack: Vec<(Id, bool)> =
            roots.filter(|v| !known(*v)).filter_map(|v| v.node).map(|n| (n, false)).collect();
        stack.reverse();
        while let Some((id, visited)) = stack.pop() {
            if done.get(&id).is_some() {
                continue;
            }
            if !visited {
                stack.push((id, true));
                let from = stack.len();
                g.operands(id, |v| stack.extend(v.node.filter(|_| !known(v)).map(|n| (n, false))));
                // Two of them as a rule, for which an iterator takes too long without optimisation.
                if stack.len() > from + 1 {
                    stack[from..].reverse();
                }
                continue;
            }
            done.insert(id, ());
            if let Some(&pair) = partners.get(&id) {
                done.insert(pair.sine, ());
                done.insert(pair.cosine, ());
                steps.push(Step::SinCos(vec![pair]));
            } else if !matches!(g.node(id), Node::Symbol(_)) && inline.get(&id).is_none() {
                steps.push(Step::Let(id));
            }
        }
        if !together.is_empty() {
            together.iter().flat_map(|pair| [pair.sine, pair.cosine]).for_each(|id| done.insert(id, ()));
            steps.push(Step::SinCos(together.to_vec()));
        }
    };
    follow(&mut together.iter().map(|pair| pair.angle), &together);
    follow(&mut outputs.iter().copied(), &[]);
    Program { constants, inputs, steps, outputs: outputs.to_vec(), inline }
}

/// The nodes below some outputs that depend on symbols of a kind.
pub fn below(g: &Graph, outputs: &[Value], wanted: impl Fn(Symbol) -> bool) -> IdMap<()> {
    let mut moved: IdMap<()> = IdMap::default();
    for id in g.live(outputs) {
        let mut moves = matches!(g.node(id), Node::Symbol(s) if wanted(*s));
        g.operands(id, |v| moves |= v.node.is_some_and(|n| moved.get(&n).is_some()));
        if moves {
            moved.insert(id, ());
        }
    }
    moved
}
