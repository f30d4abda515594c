//! Identities of rational expressions, by values in a finite field: exact, whatever the sizes of terms are.

use super::{Function, Graph, Id, Node, Number, Value, stable_map::IdMap};

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

/// Reduces the rows to echelon form with ones as pivots and zeros above and below them; the columns of the pivots.
fn reduce(rows: &mut [Vec<u64>], columns: usize) -> Vec<usize> {
    let mut pivots = Vec::new();
    for column in 0..columns {
        let top = pivots.len();
        let Some(found) = (top..rows.len()).find(|row| rows[*row][column] != 0) else { continue };
        rows.swap(top, found);
        let scale = inverse(rows[top][column]).expect("an element that is not 0");
        rows[top].iter_mut().for_each(|x| *x = mul(*x, scale));
        let pivot = rows[top].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(row, _)| *row != top) {
            let factor = P - row[column];
            for (x, y) in row.iter_mut().zip(&pivot) {
                *x = add(*x, mul(factor % P, *y));
            }
        }
        pivots.push(column);
    }
    pivots
}

impl Graph {
    /// Does the expression vanish as a rational function of its symbols, of sines and cosines of its angles, and of
    /// other function values as if they were symbols? By values at arbitrary elements of a field of 2⁶¹ − 1, where one
    /// that does not vanish is 0 in 10¹⁸ / d of all cases for a degree d (Schwartz 1980). Sine and cosine of an angle
    /// are a point of the circle, and those of sums are by the addition theorems. What other functions have to do with
    /// each other (√x √x = x) is not seen: then the answer is no.
    pub fn vanishes_as_rational(&self, v: Value) -> bool {
        (0..3).all(|trial| self.residues(&[v], trial).is_some_and(|all| all[0] == 0))
    }

    /// Sets of parts whose changes have the sum 0, in all of their components: the vectors of zeros and ones in the
    /// basis of the null space that elimination gives. By values at elements of the field that
    /// [`Graph::vanishes_as_rational`] does not look at.
    pub fn vanishing_sets(&self, changes: &[Vec<Value>]) -> Vec<Vec<usize>> {
        let n = changes.len();
        let all: Vec<Value> = changes.iter().flatten().copied().collect();
        let count = all.len() / n.max(1);
        let (mut rows, mut pivots) = (Vec::new(), Vec::new());
        for trial in 3..6 + n as u64 {
            let Some(values) = self.residues(&all, trial) else { return Vec::new() };
            rows.extend((0..count).map(|k| (0..n).map(|part| values[part * count + k]).collect()));
            pivots = reduce(&mut rows, n);
            if pivots.len() == n {
                return Vec::new();
            }
        }
        let free = (0..n).filter(|part| !pivots.contains(part));
        let sets = free.map(|part| {
            // The pivot's variable is minus the entry beside it.
            let entries = pivots.iter().zip(&rows).map(|(pivot, row)| (*pivot, (P - row[part]) % P));
            let all: Vec<(usize, u64)> = entries.chain([(part, 1)]).filter(|(_, x)| *x != 0).collect();
            let mut set: Vec<usize> = all.iter().map(|(part, _)| *part).collect();
            set.sort_unstable();
            all.iter().all(|(_, x)| *x == 1).then_some(set)
        });
        sets.flatten().collect()
    }

    /// Values in the field, unless something is divided by 0.
    fn residues(&self, of_interest: &[Value], trial: u64) -> Option<Vec<u64>> {
        let mut values: IdMap<u64> = IdMap::default();
        let of = |values: &IdMap<u64>, v: Value| {
            let k = constant(v.k, trial)?;
            v.node.map_or(Some(k), |n| Some(mul(k, *values.get(&n)?)))
        };
        for id in self.live(of_interest) {
            let at = |n: Id| values.get(&n).copied();
            let value = match self.node(id) {
                Node::Sum(a, b) => add(of(&values, *a)?, of(&values, *b)?),
                Node::Product(a, b) => mul(at(*a)?, at(*b)?),
                Node::Inverse(a) => inverse(at(*a)?)?,
                Node::Call(Function::cos, angle, _) => self.on_circle(*angle, trial)[0],
                Node::Call(Function::sin, angle, _) => self.on_circle(*angle, trial)[1],
                Node::Symbol(_) | Node::Call(..) | Node::Extern(..) | Node::Select(..) => {
                    element(id.index() as u64, trial)
                }
            };
            values.insert(id, value);
        }
        of_interest.iter().map(|v| of(&values, *v)).collect()
    }

    /// Cosine and sine of an angle: those of the sum of its terms, each a multiple of the angle of a node over
    /// [`PARTS`].
    fn on_circle(&self, angle: Value, trial: u64) -> [u64; 2] {
        let terms = self.terms(angle).into_iter().map(|Value { k, node }| {
            // (None that a node has as its value.)
            let key = element(!node.map_or(0, |node| 1 + node.index() as u64), trial);
            match k {
                Number::Ratio(n, d) if node.is_some() && PARTS % d == 0 && n.abs() < LARGEST_MULTIPLE => {
                    multiple(point(key), n * (PARTS / d))
                }
                // One that is no such multiple has an angle of its own.
                Number::Ratio(n, d) => point(element(element(key, n as u64), d as u64)),
                Number::Float(high, low) => point(element(element(key, high), low)),
            }
        });
        terms.fold([1, 0], turned)
    }
}

/// Parts of an angle of which multiples are known: halves, thirds, quarters.
const PARTS: i64 = 12;

/// Multiples of angles below this are known.
const LARGEST_MULTIPLE: i64 = 1 << 32;

/// A point of the circle, `((1 − t²)/(1 + t²), 2t/(1 + t²))`; −1 is no square in this field.
fn point(t: u64) -> [u64; 2] {
    let square = mul(t, t);
    let under = inverse(add(1, square)).expect("1 + t² is not 0");
    [mul(add(1, P - square), under), mul(mul(2, t), under)]
}

/// The sum of two angles.
fn turned([c, s]: [u64; 2], [d, t]: [u64; 2]) -> [u64; 2] {
    [add(mul(c, d), P - mul(s, t)), add(mul(s, d), mul(c, t))]
}

/// A multiple of an angle.
fn multiple([c, s]: [u64; 2], times: i64) -> [u64; 2] {
    let (mut power, mut rest) = ([c, if times < 0 { (P - s) % P } else { s }], times.unsigned_abs());
    let mut all = [1, 0];
    while rest > 0 {
        if rest & 1 == 1 {
            all = turned(all, power);
        }
        power = turned(power, power);
        rest >>= 1;
    }
    all
}
