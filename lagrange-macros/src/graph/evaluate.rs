//! Interpreter of the graph: numbers by which the compiler probes expressions, and looks for singular inertia. What
//! is emitted is evaluated as a program (`Program::evaluate`).

use super::{Comparison, Graph, Id, Node, Symbol, Value, stable_map::IdMap};

impl Comparison {
    pub fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Comparison::Less => a < b,
            Comparison::LessEqual => a <= b,
            Comparison::Equal => a == b,
        }
    }
}

/// A derivative of a function of the user's, which the compiler cannot call: some arbitrary smooth function.
pub fn external(f: usize, orders: &[u8], arguments: impl Iterator<Item = f64>) -> f64 {
    let phase: f64 = arguments.enumerate().map(|(i, a)| a / (i + 2) as f64).sum();
    let order: usize = orders.iter().map(|o| usize::from(*o)).sum();
    (phase + f as f64 + order as f64).sin() + 1.5
}

impl Graph {
    /// The roots in floating point, for given values of the symbols. A function of the user's, which the compiler
    /// cannot call, is taken to be some arbitrary smooth function.
    pub fn evaluate(&self, roots: &[Value], symbol: impl Fn(Symbol) -> f64) -> Vec<f64> {
        self.evaluate_rounded(roots, symbol, |x| x)
    }

    /// The same with the result of every operation rounded in some way.
    pub fn evaluate_rounded(
        &self,
        roots: &[Value],
        symbol: impl Fn(Symbol) -> f64,
        rounded: impl Fn(f64) -> f64,
    ) -> Vec<f64> {
        let mut values: IdMap<f64> = IdMap::default();
        let of = |values: &IdMap<f64>, v: Value| {
            v.k.to_f64() * v.node.map_or(1.0, |n| values.get(&n).copied().unwrap_or(f64::NAN))
        };
        for id in self.live(roots) {
            let at = |v: Value| of(&values, v);
            let value = match self.node(id) {
                Node::Symbol(s) => symbol(*s),
                Node::Sum(a, b) => at(*a) + at(*b),
                Node::Product(a, b) => at((*a).into()) * at((*b).into()),
                Node::Inverse(a) => 1.0 / at((*a).into()),
                Node::Call(f, a, b) => (f.row().value)(&[at(*a), at(*b)]),
                Node::Extern(f, orders, arguments) => external(*f, orders, arguments.iter().map(|a| at(*a))),
                Node::Select(comparison, values) => {
                    let [a, b, yes, no] = values.map(at);
                    if comparison.holds(a, b) { yes } else { no }
                }
            };
            values.insert(id, rounded(value));
        }
        roots.iter().map(|v| of(&values, *v)).collect()
    }

    /// The first node without a value in floating point at a state where its operands have one: at a pole, or
    /// outside of a domain, but for those that `is_ignored` for the value that they have instead. What cancels to
    /// rounding is 0 here, as the sine of a rounded π is.
    pub fn singular(
        &self,
        root: Value,
        symbol: impl Fn(Symbol) -> f64,
        is_ignored: impl Fn(Id, f64) -> bool,
    ) -> Option<Id> {
        const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
        // Values, with the sums of the sizes of what they were made of.
        let mut values: IdMap<[f64; 2]> = IdMap::default();
        let of = |values: &IdMap<[f64; 2]>, v: Value| {
            let k = v.k.to_f64();
            let [x, size] = v.node.map_or([1.0; 2], |n| values.get(&n).copied().unwrap_or([f64::NAN; 2]));
            [k * x, k.abs() * size]
        };
        for id in self.live(&[root]) {
            let at = |v: Value| of(&values, v);
            let mut found = match self.node(id) {
                Node::Symbol(s) => [symbol(*s), symbol(*s).abs()],
                Node::Sum(a, b) => [at(*a)[0] + at(*b)[0], at(*a)[1] + at(*b)[1]],
                Node::Product(a, b) => {
                    let [a, b] = [*a, *b].map(|id| at(id.into()));
                    [a[0] * b[0], a[1] * b[1]]
                }
                Node::Inverse(a) => {
                    let [x, size] = at((*a).into());
                    [1.0 / x, size / (x * x)]
                }
                Node::Call(f, a, b) => {
                    let ([a, size], [b, _]) = (at(*a), at(*b));
                    let [x, beside] = [a, a + ROUNDINGS * size].map(|a| (f.row().value)(&[a, b]));
                    let change = (beside - x).abs();
                    // The largest tangents are those of angles that rounding cannot tell from π/2.
                    let is_pole = change > 0.25 * x.abs() && x.abs() > 1.0 / f64::EPSILON.sqrt();
                    [if is_pole { f64::INFINITY } else { x }, x.abs() + change / ROUNDINGS]
                }
                Node::Extern(f, orders, arguments) => {
                    let x = external(*f, orders, arguments.iter().map(|a| at(*a)[0]));
                    [x, x.abs()]
                }
                Node::Select(comparison, values) => {
                    let [a, b, yes, no] = values.map(at);
                    if comparison.holds(a[0], b[0]) { yes } else { no }
                }
            };
            if !found[0].is_finite() {
                if !is_ignored(id, found[0]) {
                    return Some(id);
                }
                found = [0.7; 2];
            }
            if found[0].abs() <= ROUNDINGS * found[1] {
                found = [0.0; 2];
            }
            values.insert(id, found);
        }
        None
    }

    /// Is the value at some state so far from zero that rounding does not explain it? Most expressions that do not
    /// vanish are known by this, for less than it costs to multiply them out.
    pub fn differs_from_zero(&self, v: Value) -> bool {
        // Values and the sums of the sizes of what they were made of, which bound their errors but for a factor.
        let mut values: IdMap<(f64, f64)> = IdMap::default();
        let of = |values: &IdMap<(f64, f64)>, v: Value| {
            let k = v.k.to_f64();
            v.node.map_or((k, k.abs()), |n| {
                let (x, size) = values.get(&n).copied().unwrap_or((f64::NAN, f64::NAN));
                (k * x, k.abs() * size)
            })
        };
        for id in self.live(&[v]) {
            let at = |v: Value| of(&values, v);
            let value = match self.node(id) {
                // Nothing special about these numbers but that they are.
                Node::Symbol(_) => {
                    let x = 0.4 + (id.index() as f64 * 0.618_033_988_749_895).fract();
                    (x, x)
                }
                Node::Sum(a, b) => (at(*a).0 + at(*b).0, at(*a).1 + at(*b).1),
                Node::Product(a, b) => {
                    let (a, b) = (at((*a).into()), at((*b).into()));
                    (a.0 * b.0, a.1 * b.1)
                }
                Node::Inverse(a) => {
                    let (x, size) = at((*a).into());
                    (1.0 / x, size / (x * x))
                }
                Node::Call(f, a, _) if matches!(f.row().name, "sin" | "cos") => {
                    let (x, size) = at(*a);
                    ((f.row().value)(&[x, 0.0]), 1.0 + size)
                }
                // What these do to errors is left to those who multiply out.
                Node::Call(..) | Node::Extern(..) | Node::Select(..) => return false,
            };
            values.insert(id, value);
        }
        let (x, size) = of(&values, v);
        x.abs() > 1e-9 * size
    }
}
