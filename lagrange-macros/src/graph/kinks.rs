//! Compositions with kinks that their functions do not show, written with `abs` and `signum`, whose switches are known:
//! √(x²) = |x|, asin(sin x) = atan2(sin x, |cos x|).
//!
//! Only what moves is rewritten: a composition of parameters has no kink in a run.

use super::{Function, Graph, Id, Node, Number, Value};

/// Terms that are looked at for their signs.
const MAX_SIGNED_TERMS: usize = 64;

impl Graph {
    /// `f(x)` with the switches of its kinks, if it has any.
    pub(super) fn kinked(&mut self, f: Function, x: Value) -> Option<Value> {
        let node = x.node.filter(|id| !self.is_fixed(*id))?;
        match f {
            Function::sqrt => {
                let (outside, inside) = self.magnitude(x, Number::Ratio(1, 2))?;
                let root = self.call(Function::sqrt, inside);
                Some(self.mul(outside, root))
            }
            Function::asin | Function::acos if x.k.is_unit() => {
                let other = self.partner(node)?;
                let other = self.call(Function::abs, other);
                // Continuous where the magnitude vanishes, also if rounding makes it negative.
                let angle = self.call2(Function::atan2, x, other);
                if f == Function::asin {
                    return Some(angle);
                }
                let quarter_turn = Number::named("FRAC_PI_2")?;
                Some(self.sub(Value { k: quarter_turn, node: None }, angle))
            }
            Function::abs if self.is_never_negative(node) => Some(x),
            // atan(tan x) jumps where cos x changes its sign.
            Function::atan if x.k.is_one() => {
                let [(a, m), (b, n)] = *self.factors(node) else { return None };
                let (sine, cosine) = if m == 1 && n == -1 { (a, b) } else { (b, a) };
                let is_tangent = m * n == -1 && matches!(self.node(sine), Node::Call(Function::sin, ..));
                let cosine = Value::from(cosine);
                if !is_tangent || self.partner(sine)? != cosine {
                    return None;
                }
                let (sign, size) = (self.call(Function::signum, cosine), self.call(Function::abs, cosine));
                let sine = self.mul(sign, sine.into());
                Some(self.call2(Function::atan2, sine, size))
            }
            _ => None,
        }
    }

    /// Splits `x` to the power y, a constant that is no integer, into powers of magnitudes and what is left below the
    /// power: (x² z)^y = |x|^(2y) z^y.
    pub(super) fn magnitude(&mut self, x: Value, y: Number) -> Option<(Value, Value)> {
        let node = x.node.filter(|id| !self.is_fixed(*id))?;
        if let Some(square) = self.complement(node) {
            return self.magnitude(square.scaled(x.k), y);
        }
        let factors = self.factors(node);
        let (even, rest): (Vec<(Id, i32)>, Vec<_>) =
            factors.iter().partition(|(base, e)| e % 2 == 0 && !self.is_fixed(*base));
        if even.is_empty() {
            return None;
        }
        let mut outside = Value::ONE;
        for (base, e) in even {
            let size = self.call(Function::abs, base.into());
            let power = self.call2(Function::powf, size, Value { k: y.mul(i64::from(e).into()), node: None });
            outside = self.mul(outside, power);
        }
        Some((outside, self.assemble(&rest).scaled(x.k)))
    }

    /// Can it be read off that this is 0 or more: a magnitude, an even power, or a sum of such?
    pub fn is_never_negative(&self, id: Id) -> bool {
        let mut stack = vec![Value::from(id)];
        for _ in 0..MAX_SIGNED_TERMS {
            let Some(term) = stack.pop() else { return true };
            let is = match term.node.map(|id| (self.node(id), self.factors(id))) {
                _ if term.k.is_negative() => false,
                None
                | Some((
                    Node::Call(Function::abs | Function::sqrt | Function::exp | Function::cosh, ..),
                    _,
                )) => true,
                Some((Node::Sum(a, b), _)) => {
                    stack.extend([*a, *b]);
                    true
                }
                Some((_, factors)) => factors.iter().all(|(_, e)| e % 2 == 0),
            };
            if !is {
                return false;
            }
        }
        false
    }

    /// 1 − cos² x as sin² x, and the other way round.
    fn complement(&mut self, id: Id) -> Option<Value> {
        let Node::Sum(a, b) = *self.node(id) else { return None };
        let (one, square) = if a.is_constant() { (a, b) } else { (b, a) };
        let [(base, 2)] = *self.factors(square.node?) else { return None };
        if !one.is_constant() || square.k != one.k.neg() {
            return None;
        }
        let partner = self.partner(base)?;
        Some(self.powi(partner, 2).scaled(one.k))
    }

    /// The cosine of a sine, and the sine of a cosine.
    fn partner(&mut self, id: Id) -> Option<Value> {
        let Node::Call(f @ (Function::sin | Function::cos), angle, _) = *self.node(id) else { return None };
        Some(self.call(if f == Function::sin { Function::cos } else { Function::sin }, angle))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Symbol;
    use super::*;

    /// Each pair has one value, and the second one shows its switch.
    #[test]
    fn kinks_are_written_with_their_switches() {
        let g = &mut Graph::default();
        let (x, p) = (g.symbol(Symbol::Coordinate(0)), g.symbol(Symbol::Parameter(0)));
        let size = g.call(Function::abs, x);
        let (square, sixth) = (g.powi(x, 2), g.powi(x, 6));
        assert_eq!(g.call(Function::sqrt, square), size);
        assert_eq!(g.call2(Function::hypot, x, Value::ZERO), size);
        assert_eq!(g.call2(Function::powf, sixth, Value::constant(Number::Ratio(1, 6))), size);
        let (scaled, root) = (g.mul(p, square), g.call(Function::sqrt, p));
        let expected = g.mul(root, size);
        assert_eq!(g.call(Function::sqrt, scaled), expected);
        let (sine, cosine) = (g.call(Function::sin, x), g.call(Function::cos, x));
        let square = g.powi(cosine, 2);
        let rest = g.sub(Value::ONE, square);
        let size = g.call(Function::abs, sine);
        assert_eq!(g.call(Function::sqrt, rest), size);
        let tangent = g.div(sine, cosine);
        for (f, of) in [
            (Function::asin, sine),
            (Function::asin, -cosine),
            (Function::acos, cosine),
            (Function::acos, -cosine),
            (Function::acos, sine),
            (Function::atan, tangent),
            (Function::atan, -tangent),
        ] {
            let value = g.call(f, of);
            for at in [0.3, 1.7, 2.9, 3.3, 4.9, 6.0, -0.4, -2.2] {
                let [of, value] = [of, value].map(|v| g.evaluate(&[v], |_| at)[0]);
                let expected = (f.row().value)(&[of]);
                assert!((value - expected).abs() < 1e-14, "{} at {at}: {value}, {expected}", f.row().name);
            }
            assert_eq!(
                crate::equations::series::switches::switching(g, &[value]).len(),
                1,
                "{}",
                f.row().name
            );
        }
        // A base that is never negative has no kink.
        let (square, exponential) = (g.powi(x, 2), g.call(Function::exp, x));
        let sum = g.add(square, Value::ONE);
        for value in [exponential, sum] {
            let square = g.powi(value, 2);
            assert_eq!(g.call(Function::sqrt, square), value);
        }
    }
}
