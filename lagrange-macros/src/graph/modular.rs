//! Identities of rational expressions, by values in a finite field: exact, whatever the sizes of terms are.

use super::{Graph, Id, Node, Number, Value, stable_map::IdMap};

/// 2⁶¹ − 1, which is prime.
const P: u64 = (1 << 61) - 1;

fn add(a: u64, b: u64) -> u64 {
    (a + b) % P
}

fn mul(a: u64, b: u64) -> u64 {
    (u128::from(a) * u128::from(b) % u128::from(P)) as u64
}

/// 1/a by Fermat's theorem; none of 0.
fn inverse(a: u64) -> Option<u64> {
    let (mut result, mut square, mut rest) = (1, a, P - 2);
    while rest > 0 {
        if rest & 1 == 1 {
            result = mul(result, square);
        }
        square = mul(square, square);
        rest >>= 1;
    }
    (a != 0).then_some(result)
}

/// Increment of the state of SplitMix64.
pub const INCREMENT: u64 = 0x9e37_79b9_7f4a_7c15;

/// An arbitrary number for each state of SplitMix64 (Steele, Lea and Flood 2014).
pub fn mixed(mut state: u64) -> u64 {
    state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    state ^ (state >> 31)
}

/// An arbitrary element of the field for these numbers.
fn element(a: u64, b: u64) -> u64 {
    mixed(a.wrapping_mul(INCREMENT) ^ b.wrapping_add(0x6a09_e667_f3bc_c909)) % P
}

fn constant(k: Number, trial: u64) -> Option<u64> {
    match k {
        Number::Ratio(n, d) => {
            let residue = |x: i64| (i128::from(x).rem_euclid(i128::from(P))) as u64;
            inverse(residue(d)).map(|d| mul(residue(n), d))
        }
        // No rational number: it stands for itself.
        Number::Float(high, low) => Some(element(high ^ low.rotate_left(32), trial)),
    }
}

impl Graph {
    /// Does the expression vanish as a rational function of its symbols, and of its function values as if they were
    /// symbols? By values at arbitrary elements of a field of 2⁶¹ − 1, where one that does not vanish is 0 in 10¹⁸ / d
    /// of all cases for a degree d (Schwartz 1980). What functions have to do with each other (sin² + cos² = 1) is not
    /// seen: then the answer is no.
    pub fn vanishes_as_rational(&self, v: Value) -> bool {
        (0..3).all(|trial| self.residue(v, trial) == Some(0))
    }

    /// Value in the field, unless something is divided by 0.
    fn residue(&self, v: Value, trial: u64) -> Option<u64> {
        let mut values: IdMap<u64> = IdMap::default();
        let of = |values: &IdMap<u64>, v: Value| {
            let k = constant(v.k, trial)?;
            v.node.map_or(Some(k), |n| Some(mul(k, *values.get(&n)?)))
        };
        for id in self.live(&[v]) {
            let at = |n: Id| values.get(&n).copied();
            let value = match self.node(id) {
                Node::Sum(a, b) => add(of(&values, *a)?, of(&values, *b)?),
                Node::Product(a, b) => mul(at(*a)?, at(*b)?),
                Node::Inverse(a) => inverse(at(*a)?)?,
                Node::Symbol(_) | Node::Call(..) | Node::Extern(..) | Node::Select(..) => {
                    element(id.index() as u64, trial)
                }
            };
            values.insert(id, value);
        }
        of(&values, v)
    }
}
