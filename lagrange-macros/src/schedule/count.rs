//! Cost of a straight-line program.

use crate::graph::{
    Coefficient, Function, Graph, Id, Node, Number, Symbol, Value,
    stable_map::{IdMap, StableMap},
};

/// Operations of a set of outputs, without those on parameters alone, which are not repeated. A coefficient other than ±1
/// costs one multiplication for each distinct coefficient of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Operations {
    pub additions: usize,
    pub multiplications: usize,
    pub divisions: usize,
    pub sin_cos: usize,
    pub functions: usize,
    /// Longest chain of dependent operations, in cycles.
    pub path: usize,
}

impl Operations {
    pub fn arithmetic(&self) -> usize {
        self.additions + self.multiplications + self.divisions
    }

    /// The cost by which programs are compared, in units of an addition: a division occupies its unit four times as long, a
    /// sine–cosine pair takes some forty operations, other functions about thirty. Cycles of the longest chain count a
    /// third: a processor overlaps one evaluation with the next, but not all of it (docs/lab/performance.md).
    pub fn cost(&self) -> usize {
        let work = self.additions
            + self.multiplications
            + 4 * self.divisions
            + 40 * self.sin_cos
            + 30 * self.functions;
        work + self.path / 3
    }
}

/// Cycles of a division.
const DIVISION: usize = 13;

/// Is a product a division by the order of a series?
fn is_quotient(g: &Graph, id: Id) -> bool {
    matches!(g.node(id), Node::Product(_, over) if matches!(g.node(*over), Node::Symbol(Symbol::Order(Coefficient::Over))))
}

/// Cycles of one operation on a current processor (Fog, *Instruction tables*: Zen 3 and Ice Lake).
fn latency(node: &Node) -> usize {
    match node {
        Node::Symbol(_) => 0,
        Node::Sum(..) | Node::Product(..) => 4,
        Node::Inverse(_) => DIVISION,
        Node::Call(..) | Node::Extern(..) => 40,
        Node::Select(..) => 2,
    }
}

pub fn operations(g: &Graph, outputs: &[Value]) -> Operations {
    operations_without(g, outputs, |v| g.is_derived(v))
}

/// The same without those on what is known.
pub fn operations_without(g: &Graph, outputs: &[Value], known: impl Fn(Value) -> bool) -> Operations {
    let mut count = Operations::default();
    let mut scaled: StableMap<(Number, Id), ()> = StableMap::default();
    let mut angles: StableMap<Value, ()> = StableMap::default();
    let mut paths: IdMap<usize> = IdMap::default();
    let live = g.live_without(outputs, &known);
    // A product with an inverse that nothing else uses is one division, not a division and a multiplication.
    let mut uses: IdMap<usize> = IdMap::default();
    let mut note = |v: Value| {
        if let Some(n) = v.node.filter(|_| !known(v)) {
            uses.count(n);
        }
    };
    live.iter().for_each(|id| g.operands(*id, &mut note));
    outputs.iter().copied().for_each(&mut note);
    let divides = |id: Id| matches!(g.node(id), Node::Inverse(_)) && uses.get(&id) == Some(&1);
    for id in live {
        let node = g.node(id);
        match node {
            Node::Symbol(_) => {}
            Node::Sum(..) => count.additions += 1,
            Node::Product(a, b) if divides(*a) || divides(*b) => {}
            Node::Product(..) if is_quotient(g, id) => count.divisions += 1,
            Node::Product(..) => count.multiplications += 1,
            Node::Inverse(_) => count.divisions += 1,
            Node::Call(Function::sin | Function::cos, angle, _) => {
                if angles.get(angle).is_none() {
                    angles.insert(*angle, ());
                    count.sin_cos += 1;
                }
            }
            Node::Call(..) | Node::Extern(..) => count.functions += 1,
            Node::Select(..) => count.additions += 1,
        }
        let mut path = 0;
        let mut scale = |v: Value, path: &mut usize| {
            let Some(n) = v.node.filter(|_| !known(v)) else { return };
            let mut depth = paths.get(&n).copied().unwrap_or(0);
            if !v.k.is_unit() {
                depth += 4;
                if scaled.get(&(v.k.abs(), n)).is_none() {
                    scaled.insert((v.k.abs(), n), ());
                    count.multiplications += 1;
                }
            }
            *path = (*path).max(depth);
        };
        g.operands(id, |v| scale(v, &mut path));
        let quotient = matches!(node, Node::Product(..)) && is_quotient(g, id);
        paths.insert(id, path + if quotient { DIVISION } else { latency(node) });
    }
    for v in outputs {
        let Some(n) = v.node.filter(|_| !known(*v)) else { continue };
        count.path = count.path.max(paths.get(&n).copied().unwrap_or(0));
        if !v.k.is_unit() && scaled.get(&(v.k.abs(), n)).is_none() {
            scaled.insert((v.k.abs(), n), ());
            count.multiplications += 1;
        }
    }
    count
}
