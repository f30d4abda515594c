//! Derivatives on the graph: forward (one direction, many expressions) and reverse (one expression, all symbols).
//! Griewank and Walther, *Evaluating Derivatives*, 2nd ed. 2008, ch. 3. The local rules are in [`Graph::partials`].

use super::{
    Comparison, Function, Graph, Id, Node, Number, Symbol, Value,
    roots::Limits,
    stable_map::{IdMap, StableMap},
};
use std::rc::Rc;

impl Graph {
    /// Forward mode: the derivative of each root when every symbol moves at the rate that `seed` gives it.
    pub fn forward(&mut self, roots: &[Value], seed: impl Fn(Symbol) -> Option<Value>) -> Vec<Value> {
        self.forward_within(Limits::none(), roots, seed)
    }

    /// The same for derivatives that are evaluated anywhere: with limits where these exist and the terms of the
    /// derivatives do not.
    pub fn forward_with_limits(
        &mut self,
        roots: &[Value],
        seed: impl Fn(Symbol) -> Option<Value>,
    ) -> Vec<Value> {
        self.forward_within(self.limits(roots), roots, seed)
    }

    fn forward_within(
        &mut self,
        mut limits: Limits,
        roots: &[Value],
        seed: impl Fn(Symbol) -> Option<Value>,
    ) -> Vec<Value> {
        let mut slopes: IdMap<Value> = IdMap::default();
        for id in self.live(roots) {
            let slope = match *self.node(id) {
                Node::Symbol(symbol) => seed(symbol),
                // ∂(if a ∘ b {y} else {n}) = if a ∘ b {∂y} else {∂n}; on the boundary, one-sided. A choice, not a sum
                // of products with 0 and 1: the branch not taken may have no finite slope.
                Node::Select(comparison, ref values) => {
                    let [a, b, yes, no] = **values;
                    let of = |v: Value| match v.node.and_then(|n| slopes.get(&n)) {
                        Some(slope) => slope.scaled(v.k),
                        None => Value::ZERO,
                    };
                    Some(self.select(comparison, a, b, of(yes), of(no)))
                }
                _ => {
                    let mut moving = false;
                    self.operands(id, |v| moving |= v.node.is_some_and(|n| slopes.get(&n).is_some()));
                    moving.then(|| {
                        let mut total = Value::ZERO;
                        for (operand, partial) in self.partials(id) {
                            if let Some(&slope) = operand.node.and_then(|n| slopes.get(&n)) {
                                let slope = slope.scaled(operand.k);
                                let term = self.chained(slope, partial);
                                let term = self.continued(&mut limits, id, [operand, partial, slope, term]);
                                total = self.add(total, term);
                            }
                        }
                        total
                    })
                }
            };
            if let Some(slope) = slope.filter(|s| !s.is_zero()) {
                slopes.insert(id, slope);
            }
        }
        let slope =
            |root: &Value| root.node.and_then(|n| slopes.get(&n)).map_or(Value::ZERO, |s| s.scaled(root.k));
        roots.iter().map(slope).collect()
    }

    /// Partial derivative by one symbol.
    #[cfg(test)]
    pub fn partial(&mut self, root: Value, by: Symbol) -> Value {
        self.forward(&[root], |s| (s == by).then_some(Value::ONE))[0]
    }

    /// Reverse mode: the derivatives of one root by each of the wanted symbols.
    pub fn gradient(&mut self, root: Value, wanted: &[Symbol]) -> Vec<Value> {
        self.reverse(root, wanted, &mut StableMap::default())
    }

    /// `branches` has the gradients of the branches of choices.
    fn reverse(
        &mut self,
        root: Value,
        wanted: &[Symbol],
        branches: &mut StableMap<Value, Vec<Value>>,
    ) -> Vec<Value> {
        if let Some(gradient) = branches.get(&root) {
            return gradient.clone();
        }
        let live = self.live(&[root]);
        let Some(top) = root.node else { return vec![Value::ZERO; wanted.len()] };
        // Only nodes above a wanted symbol carry an adjoint.
        let mut active: IdMap<()> = IdMap::default();
        for &id in &live {
            let mut is = matches!(self.node(id), Node::Symbol(s) if wanted.contains(s));
            self.operands(id, |v| is |= v.node.is_some_and(|n| active.get(&n).is_some()));
            if is {
                active.insert(id, ());
            }
        }
        let mut adjoints: IdMap<Value> = IdMap::default();
        let mut gradient = vec![Value::ZERO; wanted.len()];
        adjoints.insert(top, Value::constant(root.k));
        for &id in live.iter().rev() {
            let Some(&adjoint) = adjoints.get(&id) else { continue };
            if let Node::Symbol(symbol) = *self.node(id) {
                if let Some(i) = wanted.iter().position(|w| *w == symbol) {
                    gradient[i] = self.add(gradient[i], adjoint);
                }
                continue;
            }
            // A choice between the gradients of its branches, see `forward`.
            if let Node::Select(comparison, ref values) = *self.node(id) {
                let [a, b, yes, no] = **values;
                let [yes, no] = [yes, no].map(|branch| {
                    let gradient = self.reverse(branch, wanted, branches);
                    branches.insert(branch, gradient.clone());
                    gradient
                });
                for (total, (yes, no)) in gradient.iter_mut().zip(yes.into_iter().zip(no)) {
                    let slope = self.select(comparison, a, b, yes, no);
                    let term = self.chained(slope, adjoint);
                    *total = self.add(*total, term);
                }
                continue;
            }
            for (operand, partial) in self.partials(id) {
                let Some(n) = operand.node.filter(|n| active.get(n).is_some()) else { continue };
                let term = self.mul(partial.scaled(operand.k), adjoint);
                let before = adjoints.get(&n).copied().unwrap_or(Value::ZERO);
                let total = self.add(before, term);
                adjoints.insert(n, total);
            }
        }
        gradient
    }

    /// Slope times partial derivative. Where one branch of a choice does not move, it stays so however steep the
    /// function is there: √max(x, 0) for x < 0.
    fn chained(&mut self, slope: Value, partial: Value) -> Value {
        if let Some(id) = slope.node
            && let Node::Select(comparison, ref values) = *self.node(id)
        {
            let [a, b, yes, no] = **values;
            if yes.is_zero() || no.is_zero() {
                let [yes, no] = [yes, no].map(|v| self.mul(v.scaled(slope.k), partial));
                return self.select(comparison, a, b, yes, no);
            }
        }
        self.mul(slope, partial)
    }

    /// A node's operands with its partial derivative by each.
    pub fn partials(&mut self, id: Id) -> Vec<(Value, Value)> {
        match self.node(id).clone() {
            Node::Symbol(_) => Vec::new(),
            // ∂(a + b) = ∂a + ∂b
            Node::Sum(a, b) => vec![(a, Value::ONE), (b, Value::ONE)],
            // ∂(a b) = b ∂a + a ∂b
            Node::Product(a, b) => vec![(a.into(), b.into()), (b.into(), a.into())],
            // ∂(1/a) = −∂a / a²
            Node::Inverse(a) => {
                let square = self.powi(id.into(), 2);
                vec![(a.into(), -square)]
            }
            // ∂f(a, b) = f₁ ∂a + f₂ ∂b, from the table
            Node::Call(f, a, b) => {
                let arguments = [a, b];
                (0..f.row().arguments.len())
                    .map(|i| (arguments[i], self.table_derivative(f, i, &arguments)))
                    .collect()
            }
            // ∂f(a, …) = f₁ ∂a + …: the same function with one order more
            Node::Extern(f, orders, arguments) => (0..arguments.len())
                .map(|i| {
                    let mut orders = orders.clone();
                    orders[i] = orders[i].saturating_add(1);
                    (arguments[i], self.external(f, orders, arguments.clone()))
                })
                .collect(),
            Node::Select(..) => unreachable!("choices are differentiated branch by branch"),
        }
    }

    /// The i-th derivative of the function table at these arguments.
    fn table_derivative(&mut self, f: Function, i: usize, arguments: &[Value]) -> Value {
        let formula = match self.derivatives.get(&(f, i)) {
            Some(formula) => formula.clone(),
            None => {
                let parsed =
                    syn::parse_str(f.row().derivatives[i]).expect("the table is written in the language");
                let formula = Rc::new(parsed);
                self.derivatives.insert((f, i), Rc::clone(&formula));
                formula
            }
        };
        self.formula(&formula, f.row().arguments, arguments)
    }

    /// An expression of the function table, in the few words that the table uses.
    fn formula(&mut self, formula: &syn::Expr, names: &[&str], values: &[Value]) -> Value {
        use syn::{BinOp, Expr, Lit};
        match formula {
            Expr::Path(path) => {
                let at =
                    names.iter().position(|name| path.path.is_ident(name)).expect("an argument of the row");
                values[at]
            }
            Expr::Lit(lit) => match &lit.lit {
                Lit::Float(x) => Value::constant(Number::parse(x.base10_digits()).expect("a finite literal")),
                _ => unreachable!("literals of the table are floats"),
            },
            Expr::Paren(inner) => self.formula(&inner.expr, names, values),
            Expr::Unary(minus) => -self.formula(&minus.expr, names, values),
            Expr::Binary(binary) => {
                let a = self.formula(&binary.left, names, values);
                let b = self.formula(&binary.right, names, values);
                match binary.op {
                    BinOp::Add(_) => self.add(a, b),
                    BinOp::Sub(_) => self.sub(a, b),
                    BinOp::Mul(_) => self.mul(a, b),
                    BinOp::Div(_) => self.div(a, b),
                    _ => unreachable!("the table uses + − × ÷"),
                }
            }
            Expr::MethodCall(call) => {
                let x = self.formula(&call.receiver, names, values);
                let f = Function::named(&call.method.to_string()).expect("a function of the table");
                match call.args.first() {
                    None => self.call(f, x),
                    Some(y) => {
                        let y = self.formula(y, names, values);
                        self.call2(f, x, y)
                    }
                }
            }
            _ => unreachable!("the table uses arithmetic and method calls"),
        }
    }

    /// `max` and `min` as choices; their derivatives are those of the chosen branch.
    pub fn choose(&mut self, smaller: bool, a: Value, b: Value) -> Value {
        let (yes, no) = if smaller { (a, b) } else { (b, a) };
        self.select(Comparison::LessEqual, a, b, yes, no)
    }
}

#[cfg(test)]
mod tests {
    use super::super::function::TABLE;
    use super::*;

    /// Every derivative of the table against a central difference of the value.
    #[test]
    fn table_derivatives_are_slopes() {
        let g = &mut Graph::default();
        let (x, y) = (g.symbol(Symbol::Coordinate(0)), g.symbol(Symbol::Coordinate(1)));
        for row in TABLE {
            let f = Function::named(row.name).unwrap();
            let at = if row.name == "acosh" { [1.7, 0.6] } else { [0.43, 0.6] };
            let call = if row.arguments.len() == 1 { g.call(f, x) } else { g.call2(f, x, y) };
            for i in 0..row.arguments.len() {
                let derivative = g.partial(call, Symbol::Coordinate(i));
                let value = |g: &Graph, v, d: f64| {
                    let at = std::array::from_fn::<_, 2, _>(|j| at[j] + if i == j { d } else { 0.0 });
                    g.evaluate(&[v], |s| match s {
                        Symbol::Coordinate(j) => at[j],
                        _ => f64::NAN,
                    })[0]
                };
                let h = 1e-5;
                let slope = (value(g, call, h) - value(g, call, -h)) / (2.0 * h);
                let exact = value(g, derivative, 0.0);
                assert!(
                    (exact - slope).abs() < 1e-8 * (1.0 + exact.abs()),
                    "{} by {i}: {exact} {slope}",
                    row.name
                );
            }
        }
    }

    /// V = if x < 0 { (−x)^(5/2) } else { x² }: for x > 0 the other branch has no real value.
    #[test]
    fn the_branch_not_taken_may_be_undefined() {
        let g = &mut Graph::default();
        let x = g.symbol(Symbol::Coordinate(0));
        let steep = g.call2(Function::powf, -x, Value::constant(Number::Ratio(5, 2)));
        let square = g.powi(x, 2);
        let v = g.select(Comparison::Less, x, Value::ZERO, steep, square);
        let twice = g.mul(v, x);
        let forward = g.partial(twice, Symbol::Coordinate(0));
        let reverse = g.gradient(twice, &[Symbol::Coordinate(0)])[0];
        for (at, slope) in [(0.5, 0.75), (-1.0, 3.5)] {
            assert_eq!(g.evaluate(&[forward, reverse], |_| at), [slope, slope]);
        }
    }

    /// d/dx max(x, 0)^(3/2), and once more: all 0 for x < 0.
    #[test]
    fn a_branch_at_rest_stays_at_rest() {
        let g = &mut Graph::default();
        let x = g.symbol(Symbol::Coordinate(0));
        let contact = g.choose(false, x, Value::ZERO);
        let v = g.call2(Function::powf, contact, Value::constant(Number::Ratio(3, 2)));
        let forward = g.partial(v, Symbol::Coordinate(0));
        let reverse = g.gradient(v, &[Symbol::Coordinate(0)])[0];
        let twice =
            [g.partial(reverse, Symbol::Coordinate(0)), g.gradient(forward, &[Symbol::Coordinate(0)])[0]];
        let all = [forward, reverse, twice[0], twice[1]];
        assert_eq!(g.evaluate(&all, |_| -1.0), [0.0; 4]);
        assert_eq!(g.evaluate(&all, |_| 4.0), [3.0, 3.0, 0.375, 0.375]);
    }

    #[test]
    fn reverse_agrees_with_forward() {
        let g = &mut Graph::default();
        let (x, y) = (g.symbol(Symbol::Coordinate(0)), g.symbol(Symbol::Coordinate(1)));
        let s = g.call(Function::sin, x);
        let q = g.div(s, y);
        let e = g.call(Function::exp, q);
        let r = g.mul(e, x);
        let wanted = [Symbol::Coordinate(0), Symbol::Coordinate(1)];
        let reverse = g.gradient(r, &wanted);
        for (i, by) in wanted.into_iter().enumerate() {
            let forward = g.partial(r, by);
            let at = |s| if s == Symbol::Coordinate(0) { 0.3 } else { 1.7 };
            let v = g.evaluate(&[forward, reverse[i]], at);
            assert!((v[0] - v[1]).abs() < 1e-15);
        }
    }
}
