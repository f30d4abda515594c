//! Equality of values that move: it holds for an instant, so a choice by it has no effect on the motion.

use super::*;
use crate::graph::Node;
use proc_macro2::Span;

/// A comparison of two values that move by `==` or `!=`.
pub(super) struct Equality {
    values: (Value, Value),
    at: Span,
    message: String,
}

/// Functions without poles, jumps and kinks.
const SMOOTH: [&str; 9] = ["sin", "cos", "exp", "exp_m1", "sinh", "cosh", "tanh", "atan", "asinh"];

impl Elaborator<'_> {
    /// Remembers a comparison by `==` or `!=`, if its values move.
    pub(super) fn equality(&mut self, binary: &syn::ExprBinary, a: Value, b: Value) {
        if !self.moves(&[a, b]) {
            return;
        }
        let (left, right) = (plain(&binary.left), plain(&binary.right));
        let difference = match (b.is_zero(), is_operand(&binary.left), is_operand(&binary.right)) {
            (true, ..) => left,
            (_, _, true) => format!("{left} - {right}"),
            _ => format!("{left} - ({right})"),
        };
        let (operator, at, within) = match binary.op {
            BinOp::Eq(equal) => ("==", equal.spans[0], "<"),
            BinOp::Ne(unequal) => ("!=", unequal.spans[0], ">"),
            _ => return,
        };
        let message = format!(
            "values that move are equal for an instant only, so a choice by `{operator}` has no effect on the motion\nhelp: compare with a tolerance, `abs({difference}) {within} eps`; what happens at an instant is an event of the run, or an `impulse`"
        );
        self.equalities.push(Equality { values: (a, b), at, message });
    }

    /// Warns of a choice between these values that an instant decides. The value of a function at its pole or jump is
    /// such a choice, too, and is meant: `if r == 0 { 1 } else { sin(r) / r }`. Outputs may show an instant.
    pub(super) fn check_equality(&mut self, condition: &Condition, yes: &Val, no: &Val) {
        if self.observing || self.equalities.is_empty() {
            return;
        }
        let mut compared = Vec::new();
        equal(condition, &mut compared);
        let found: Vec<usize> =
            (0..self.equalities.len()).filter(|&i| compared.contains(&self.equalities[i].values)).collect();
        if found.is_empty() {
            return;
        }
        let mut values = Vec::new();
        numbers(yes, &mut values);
        numbers(no, &mut values);
        if self.is_singular(&values) {
            return;
        }
        for i in found {
            let Equality { at, message, .. } = &self.equalities[i];
            self.errors.warn(*at, "equality_for_an_instant", message.clone());
        }
    }

    /// Do these values depend on the state or on time?
    fn moves(&self, values: &[Value]) -> bool {
        self.graph.symbols(values).into_iter().any(|symbol| match symbol {
            Symbol::Coordinate(_) | Symbol::Velocity(_) | Symbol::Time | Symbol::Rate(_) => true,
            Symbol::Binding(i) => {
                let Binding { value, rate, .. } = &self.found.bindings[i];
                !rate.is_zero() || value.is_zero()
            }
            _ => false,
        })
    }

    /// May these values have poles, jumps or kinks?
    fn is_singular(&self, values: &[Value]) -> bool {
        self.graph.live(values).into_iter().any(|id| match self.graph.node(id) {
            Node::Inverse(_) => self.moves(&[Value { k: Number::ONE, node: Some(id) }]),
            Node::Call(function, ..) => !SMOOTH.contains(&function.row().name),
            Node::Extern(..) => true,
            Node::Symbol(Symbol::Binding(i)) => self.is_singular(&[self.found.bindings[*i].value]),
            _ => false,
        })
    }
}

/// The values that a condition compares for equality.
fn equal(condition: &Condition, found: &mut Vec<(Value, Value)>) {
    match condition {
        Condition::Compare(Comparison::Equal, a, b) => found.push((*a, *b)),
        Condition::Compare(..) => {}
        Condition::Not(inner) => equal(inner, found),
        Condition::And(p, q) | Condition::Or(p, q) => {
            equal(p, found);
            equal(q, found);
        }
    }
}

/// The numbers of which a value consists.
fn numbers(val: &Val, found: &mut Vec<Value>) {
    match val {
        Val::Number(value) => found.push(*value),
        Val::Array(items) | Val::Tuple(items) => items.iter().for_each(|item| numbers(item, found)),
        Val::Reference(val) => numbers(val, found),
        _ => {}
    }
}

/// Does this expression need no parentheses behind a minus?
fn is_operand(expression: &Expr) -> bool {
    matches!(
        expression,
        Expr::Lit(_) | Expr::Path(_) | Expr::Paren(_) | Expr::Call(_) | Expr::MethodCall(_) | Expr::Index(_)
    )
}

#[cfg(test)]
mod tests {
    use crate::diagnostics::Errors;
    use crate::{model, syntax};

    /// The warnings about an oscillator with these statements, with their tokens.
    fn warnings(statements: &str) -> Vec<(String, String)> {
        let text = format!(
            "@crate [::lagrange_runtime] system A {{ const N = 3; param m, k, a, b; coord x, y: [N]; {statements} \
             T = m * dot(x).powi(2) + dot(y).norm_squared(); V = k * x * x * (a + b); }}"
        );
        let mut errors = Errors::default();
        let definition = syntax::parse(text.parse().expect("tokens"), &mut errors).expect("a definition");
        model::model(&definition, &mut errors).expect("a model");
        let said = errors.said().into_iter();
        said.map(|(at, message)| (at.source_text().unwrap_or_default(), message)).collect()
    }

    #[test]
    fn a_choice_by_an_instant_is_a_warning_at_its_operator() {
        for (condition, help) in [
            ("x == 0", "`abs(x) < eps`"),
            ("t == a", "`abs(t - a) < eps`"),
            ("dot(x) != 0", "`abs(dot(x)) > eps`"),
            ("x > 0 && !(x == a + 1)", "`abs(x - (a + 1)) < eps`"),
        ] {
            let said = warnings(&format!("Q[x] = if {condition} {{ k }} else {{ 0 }};"));
            let [(_, message)] = &said[..] else { panic!("{condition}: {said:?}") };
            assert!(message.contains(help), "{message}");
        }
        assert_eq!(warnings("let u = 2 * x; let c = u == 1; Q[x] = if c { k } else { 0 };").len(), 1);
        let once = "Q[x] = (0..N).map(|i| if y[0] == 0 { k } else { i as f64 }).sum();";
        assert_eq!(warnings(once).len(), 1);
    }

    #[test]
    fn constants_outputs_and_values_at_a_pole_may_be_equal() {
        for statements in [
            "Q[x] = if a == b { k } else { 0 };",
            "let c = a + b; Q[x] = if c == 1 { k } else { 0 };",
            "Q[x] = if x == 0 { 1 } else { sin(x) / x };",
            "let s = sin(x) / x; Q[x] = if x != 0 { s } else { 1 };",
            "Q[x] = if dot(x) == 0 { 0 } else { -k * signum(dot(x)) };",
            "observe rests = if dot(x) == 0 { 1 } else { 0 };",
            "let z: [N] = |i| if i == 0 { x } else { z[i - 1] + y[i] }; Q[x] = z[2];",
        ] {
            assert_eq!(warnings(statements), [], "{statements}");
        }
    }
}
