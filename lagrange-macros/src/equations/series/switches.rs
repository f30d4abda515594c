//! Choices (`if`, `abs`, `signum`, `min`, `max`) in Taylor series.
//!
//! A choice depends on the sign of a *switching function*, a − b of the condition `a < b`. A series is one of a
//! motion on one side of each switch: |x| is ±x there, with a number for the sign. The method stops its steps where a
//! switching function vanishes, and goes on with a series of the other side. The sign is 0 where the function
//! vanishes for longer than a moment, as that of |x| ≤ x does.

use crate::equations::common::is_number;
use crate::graph::{Comparison, Function, Graph, Id, Node, Symbol, Value};

/// Terms of a sum that are looked at for their denominators.
const MAX_SEARCHED_TERMS: usize = 64;

/// A function at whose sign changes values jump or have kinks.
pub struct Switch {
    pub value: Value,
    /// The function that is negative where it decides anything, if it does not everywhere.
    pub cut: Option<Value>,
}

/// Expressions on one side of each switch, and the switching functions, which are nodes that move, with these `others`.
pub fn sided(g: &mut Graph, roots: &[Value], others: &[Value]) -> (Vec<Value>, Vec<Value>) {
    let mut switches: Vec<Id> = Vec::new();
    // The sign of a value that moves.
    let sign = |g: &mut Graph, switches: &mut Vec<Id>, of: Value| -> Option<Value> {
        let of = simple(g, of);
        let id = of.node.filter(|_| !is_number(g, of))?;
        let place = switches.iter().position(|s| *s == id).unwrap_or_else(|| {
            switches.push(id);
            switches.len() - 1
        });
        let side = g.symbol(Symbol::Side(place));
        Some(if of.k.is_negative() { -side } else { side })
    };
    let roots = &[roots, others].concat();
    let mut roots = g.rewritten(roots, |g, _, node, of| match node {
        Node::Call(Function::abs, x, _) => {
            let x = of(*x);
            let sign = sign(g, &mut switches, x)?;
            Some(g.mul(sign, x))
        }
        Node::Call(Function::signum, x, _) => {
            let sign = sign(g, &mut switches, of(*x))?;
            Some(g.select(Comparison::Less, sign, Value::ZERO, -Value::ONE, Value::ONE))
        }
        Node::Select(comparison, values) => {
            let [a, b, yes, no] = values.map(of);
            let difference = g.sub(a, b);
            let sign = sign(g, &mut switches, difference)?;
            Some(g.select(*comparison, sign, Value::ZERO, yes, no))
        }
        // The same function on both sides, whose series goes on as if there were no jump.
        Node::Call(f @ (Function::atan2 | Function::atan | Function::tanh | Function::exp), x, other) => {
            let [x, other] = [x, other].map(|v| of(*v));
            let cut = branch(g, *f, x, other)?;
            sign(g, &mut switches, cut)?;
            None
        }
        // A root of max(x, 0) has a series where that is 0: the root of each side by itself.
        Node::Call(f @ (Function::sqrt | Function::powf), x, exponent) => {
            let x = of(*x);
            let Node::Select(comparison, values) = g.node(x.node?).clone() else { return None };
            let [side, zero, yes, no] = *values;
            let numbers = [yes, no].map(|v| is_number(g, v));
            if !numbers[0] && !numbers[1] {
                return None;
            }
            // Both sides may be the same for as long as the series holds: a root of 0 has no series then, and the
            // number has.
            let difference = g.sub(yes, no).node;
            let comparison =
                match g.node(side.node?) {
                    Node::Symbol(Symbol::Side(place)) if Some(switches[*place]) == difference => {
                        if numbers[0] { Comparison::LessEqual } else { Comparison::Less }
                    }
                    _ => comparison,
                };
            let [yes, no] = [yes, no].map(|v| match *f {
                Function::sqrt => g.call(Function::sqrt, v.scaled(x.k)),
                f => g.call2(f, v.scaled(x.k), *exponent),
            });
            Some(g.select(comparison, side, zero, yes, no))
        }
        _ => None,
    });
    for other in roots.drain(roots.len() - others.len()..) {
        switches.extend(other.node.filter(|id| !switches.contains(id)));
    }
    (roots, switches.into_iter().map(Value::from).collect())
}

/// The switching functions of all choices among these expressions that move: a − b of `a < b`, x of `x.abs()` and
/// `x.signum()`, y of the cut of `atan2(y, x)`, v of `atan(u / v)`, each once, and the choices below them as they are.
pub fn switching(g: &mut Graph, roots: &[Value]) -> Vec<Value> {
    choices(g, roots).into_iter().map(|(switch, _)| switch).collect()
}

/// The same with the choices that each decides.
pub fn choices(g: &mut Graph, roots: &[Value]) -> Vec<(Value, Vec<Value>)> {
    let mut switches: Vec<(Value, Vec<Value>)> = Vec::new();
    for id in g.live(roots) {
        let function = match g.node(id) {
            Node::Call(Function::abs | Function::signum, x, _) => *x,
            Node::Select(_, values) => {
                let [a, b, ..] = **values;
                g.sub(a, b)
            }
            &Node::Call(f, x, other) => match branch(g, f, x, other) {
                Some(cut) => cut,
                None => continue,
            },
            _ => continue,
        };
        let function = simple(g, function);
        let Some(switch) = function.node.filter(|_| !is_number(g, function)).map(Value::from) else {
            continue;
        };
        match switches.iter_mut().find(|(known, _)| *known == switch) {
            Some((_, decided)) => decided.push(id.into()),
            None => switches.push((switch, vec![id.into()])),
        }
    }
    switches
}

/// The function at whose sign changes one of these functions jumps from branch to branch: y of `atan2(y, x)`, if x may
/// be negative, and the denominators in the argument of the others, which have a limit at each end.
fn branch(g: &mut Graph, f: Function, x: Value, other: Value) -> Option<Value> {
    match f {
        Function::atan2 => {
            let is_right = !other.k.is_negative() && other.node.is_none_or(|id| g.is_never_negative(id));
            (!is_right).then_some(x)
        }
        Function::atan | Function::tanh | Function::exp => {
            let below: Vec<(Id, i32)> = poles(g, x).into_iter().map(|base| (base, 1)).collect();
            (!below.is_empty()).then(|| g.assemble(&below))
        }
        _ => None,
    }
}

/// The denominators of the terms of a sum, as far as they may change their signs.
fn poles(g: &Graph, sum: Value) -> Vec<Id> {
    let (mut found, mut terms): (Vec<Id>, Vec<Id>) = (Vec::new(), sum.node.into_iter().collect());
    for _ in 0..MAX_SEARCHED_TERMS {
        let Some(term) = terms.pop() else { break };
        if let Node::Sum(a, b) = g.node(term) {
            terms.extend([a, b].into_iter().filter_map(|v| v.node));
            continue;
        }
        for &(base, e) in g.factors(term).iter() {
            if e < 0 && e % 2 != 0 && !g.is_never_negative(base) && !found.contains(&base) {
                found.push(base);
            }
        }
    }
    found.sort_unstable();
    found
}

/// The function that is negative where a switch decides anything, if all that it decides are cuts of `atan2(y, x)`:
/// the least of the x.
pub fn cut(g: &mut Graph, decided: &[Value]) -> Option<Value> {
    let beside = decided.iter().map(|choice| match choice.node.map(|id| g.node(id)) {
        Some(Node::Call(Function::atan2, _, x)) => Some(*x),
        _ => None,
    });
    let beside = beside.collect::<Option<Vec<Value>>>()?;
    beside.into_iter().reduce(|a, b| g.choose(true, a, b))
}

/// A function of the same sign without multiple roots: each factor once that stands in an odd power, and none in an
/// even one. The time at which x³ vanishes has a third of the digits of that at which x does.
fn simple(g: &mut Graph, of: Value) -> Value {
    let Some(id) = of.node else { return of };
    let odd: Vec<(Id, i32)> = g.factors(id).iter().filter(|f| f.1 % 2 != 0).map(|f| (f.0, 1)).collect();
    let simple = g.assemble(&odd);
    if is_number(g, simple) { of } else { simple.scaled(of.k) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_switch_for_all_that_depends_on_one_sign() {
        let mut g = Graph::default();
        let x = g.symbol(Symbol::Coordinate(0));
        let abs = g.call(Function::abs, x);
        let less = g.select(Comparison::Less, Value::ZERO, x, Value::ONE, x);
        let jump = g.call(Function::signum, x.scaled((-2).into()));
        let sum = g.add(abs, less);
        let sum = g.add(sum, jump);
        assert_eq!(switching(&mut g, &[sum]), [x]);
        let (sided, switches) = sided(&mut g, &[sum], &[]);
        assert_eq!(switches, [x]);
        for (x, side, expected) in
            [(3.0, 1.0, 3.0 + 1.0 - 1.0), (-3.0, -1.0, 3.0 - 3.0 + 1.0), (-0.5, 1.0, -0.5)]
        {
            let symbol = |s| if let Symbol::Side(_) = s { side } else { x };
            assert_eq!(g.evaluate(&sided, symbol), [expected]);
        }
    }

    #[test]
    fn switching_functions_have_simple_roots() {
        let mut g = Graph::default();
        let [x, y] = [0, 1].map(|i| g.symbol(Symbol::Coordinate(i)));
        let (cube, square, over) = (g.powi(x, 3), g.powi(x, 2), g.recip(y));
        let product = g.mul(cube, over);
        let xy = g.mul(x, y);
        for (of, simple) in [(cube.scaled((-2).into()), x), (square, square), (product, xy)] {
            let jump = g.call(Function::signum, of);
            assert_eq!(switching(&mut g, &[jump]), [simple]);
            assert_eq!(sided(&mut g, &[jump], &[]).1, [simple]);
        }
    }
}
