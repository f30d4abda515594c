//! Fewer sines and cosines: the pair of a sum or difference of angles from the pairs of its parts,
//!
//!   sin(a ± b) = sin a cos b ± cos a sin b,   cos(a ± b) = cos a cos b ∓ sin a sin b,
//!
//! and of a double angle (Abramowitz and Stegun 1964, 4.3.16–17, 4.3.24–25). Six operations replace a sine–cosine
//! pair, which costs about forty, so it pays whenever the parts' own pairs are needed anyway, and only then.

use super::{
    Function, Graph, Node, Number, Value,
    stable_map::{IdMap, StableMap},
};

impl Graph {
    /// The roots with every sine–cosine pair expressed by others where these are there already.
    pub fn share_angles(&mut self, roots: &[Value]) -> Vec<Value> {
        let mut roots = roots.to_vec();
        // A replaced pair may stand inside the argument of another: one pass for each level.
        for _ in 0..4 {
            let angles = self.angles(&roots);
            let mut pairs: StableMap<Value, (Value, Value)> = StableMap::default();
            let mut replaced: IdMap<Value> = IdMap::default();
            let mut any = false;
            for &angle in &angles {
                if let Some((sine, cosine)) = self.pair(angle, &angles, &mut pairs) {
                    for (f, new) in [(Function::sin, sine), (Function::cos, cosine)] {
                        if let Some(old) = self.call(f, angle).node.filter(|old| Some(*old) != new.node) {
                            replaced.insert(old, new);
                            any = true;
                        }
                    }
                }
            }
            if !any {
                break;
            }
            roots = self.replace(&roots, |id, _| replaced.get(&id).copied());
        }
        roots
    }

    /// Arguments of the sines and cosines below the roots.
    fn angles(&self, roots: &[Value]) -> Vec<Value> {
        let mut angles = Vec::new();
        for id in self.live(roots) {
            if let Node::Call(Function::sin | Function::cos, angle, _) = self.node(id)
                && !angles.contains(angle)
            {
                angles.push(*angle);
            }
        }
        angles
    }

    /// Sine and cosine of a composite angle from those of its parts, if the parts' are at hand.
    fn pair(
        &mut self,
        angle: Value,
        angles: &[Value],
        pairs: &mut StableMap<Value, (Value, Value)>,
    ) -> Option<(Value, Value)> {
        if let Some(&pair) = pairs.get(&angle) {
            return Some(pair);
        }
        let (a, b) = self.parts(angle)?;
        let mut of = |g: &mut Graph, part: Value| {
            let positive = if part.k.is_negative() { -part } else { part };
            let (s, c) = match g.pair(positive, angles, pairs) {
                Some(pair) => pair,
                None if angles.contains(&positive) => {
                    (g.call(Function::sin, positive), g.call(Function::cos, positive))
                }
                None => return None,
            };
            Some(if part.k.is_negative() { (-s, c) } else { (s, c) })
        };
        let ((sa, ca), (sb, cb)) = (of(self, a)?, of(self, b)?);
        let (ss, cc) = (self.mul(sa, sb), self.mul(ca, cb));
        let (sc, cs) = (self.mul(sa, cb), self.mul(ca, sb));
        let pair = (self.add(sc, cs), self.sub(cc, ss));
        pairs.insert(angle, pair);
        Some(pair)
    }

    /// An angle as a sum of two.
    fn parts(&mut self, angle: Value) -> Option<(Value, Value)> {
        if let Some(2..=4) = angle.k.integer() {
            let one = Value { k: Number::ONE, ..angle };
            return Some((
                one,
                angle.scaled(Number::ONE).scaled(angle.k.add(Number::MINUS_ONE).mul(angle.k.recip())),
            ));
        }
        match *self.node(angle.node?) {
            Node::Sum(a, b) if !b.is_constant() => Some((a.scaled(angle.k), b.scaled(angle.k))),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Symbol;
    use super::*;

    #[test]
    fn a_difference_needs_no_third_pair() {
        let g = &mut Graph::default();
        let (a, b) = (g.symbol(Symbol::Coordinate(0)), g.symbol(Symbol::Coordinate(1)));
        let d = g.sub(a, b);
        let twice = a.scaled(2.into());
        let calls: Vec<_> =
            [(Function::sin, a), (Function::sin, b), (Function::cos, d), (Function::sin, twice)]
                .map(|(f, x)| g.call(f, x))
                .to_vec();
        let shared = g.share_angles(&calls);
        assert_eq!(g.angles(&shared), [a, b]);
        let at = |s| if s == Symbol::Coordinate(0) { 0.7 } else { -2.1 };
        for (old, new) in g.evaluate(&calls, at).into_iter().zip(g.evaluate(&shared, at)) {
            assert!((old - new).abs() < 1e-15);
        }
        // Alone, a difference is cheaper as one angle.
        let alone = [calls[2]];
        assert_eq!(g.share_angles(&alone), alone);
    }
}
