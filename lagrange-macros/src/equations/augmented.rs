//! The equations of motion with the accelerations of the bindings kept as unknowns, and eliminated one by one.
//!
//! With H ẍ + Cᵀ σ = e at all positions x = (u, q), C ẍ = γ for the bindings ü − S ẍ = γ and for the constraints, and
//! one force σ for each row of C, the system
//!
//! ```text
//!   ⎡ H  Cᵀ ⎤ ⎡ ẍ ⎤   ⎡ e ⎤
//!   ⎣ C  0  ⎦ ⎣ σ ⎦ = ⎣ γ ⎦
//! ```
//!
//! is symmetric and as sparse as the bindings were written: a chain of bodies couples neighbours only. Eliminated in
//! a good order it costs a constant number of operations a body, where M q̈ = f, which is what is left when the
//! bindings go first, costs n³/3. Which order, decides which of the known algorithms comes out:
//!
//! - *leaves first* (Articulated bodies: Featherstone, *Rigid Body Dynamics Algorithms* 2008, ch. 7): a binding is
//!   replaced by what defines it, and an acceleration is eliminated once no definition names it any more;
//! - *dual* (link tensions: masses first, then the forces): where the inertia of the bindings is diagonal, ẍ = H⁻¹ (e
//!   − Cᵀ σ) leaves equations for the forces σ. A coordinate without inertia restricts the two forces that act on it
//!   to one direction, so one tension remains for each link.
//!
//! # Pivots
//!
//! A pivot that vanishes at some state would be a wrong result, so each is nonzero by its structure wherever M is
//! positive definite:
//!
//! - the pair (ü, σ) of a binding has the block \[h, 1; 1, 0\], of determinant −1, at any inertia h;
//! - an acceleration that no definition names any more is a direction of motion: its pivot is the kinetic energy that
//!   is left in it when all that was eliminated follows as it does, a Schur complement of M;
//! - a constraint waits for all accelerations it couples to, as in `solve.rs`;
//! - the dual order divides by the inertia of each binding. It is taken where these are numbers, or made of
//!   parameters by sums, products and quotients: masses, and products like m l². Such parameters are taken to be
//!   positive, as T is to be. If one is 0 the accelerations are not finite, which every method reports. A rotation
//!   divides by |B|², which has to simplify to an expression of the same kind.
//!
//! An order that finds no such pivot gives up, and another one is taken.

use super::assemble::{Attitude, Entry, Unreduced};
use crate::graph::{Function, Graph, Node, Number, Symbol, Value};
use crate::model::attitude::Parameters;
use std::collections::BTreeMap;

/// In which order unknowns are eliminated.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Order {
    /// Bindings that the fewest others are defined by; among equals, that couple to the fewest.
    Leaves,
    /// Unknowns that couple to the fewest others; among equals the last as they were written.
    Degree,
    /// For planar linkages: masses, then forces, of which each joint has two in the plane; the remaining chain from
    /// all its ends at once, which halves the longest chain of dependent operations.
    Dual,
}

/// Orders of elimination; those that cost least in most systems come first.
pub const ORDERS: [Order; 3] = [Order::Dual, Order::Leaves, Order::Degree];

/// The system as it was before elimination, and what elimination found.
pub struct Factors {
    size: usize,
    bound: usize,
    coordinates: usize,
    steps: Vec<Elimination>,
    /// Attitudes with the unknowns that are their accelerations. In the elimination these are ω̇ less its γ, of which
    /// σ̈ = K x.
    attitudes: Vec<(usize, Parameters)>,
}

/// One step of the elimination. Neighbours are what the eliminated unknowns couple to.
enum Elimination {
    /// z = b / pivot − Σ l z.
    Single {
        x: usize,
        inverse: Value,
        l: Vec<Entry>,
    },
    Pair(Box<Pair>),
    /// New unknowns for two: x = c p − d s, y = d p + c s.
    Rotation {
        x: usize,
        y: usize,
        c: Value,
        d: Value,
    },
}

/// Two unknowns at once, by the inverse [P, Q; Q, R] of their block.
struct Pair {
    x: usize,
    y: usize,
    inverse: [Value; 3],
    neighbours: Vec<Neighbour>,
}

struct Neighbour {
    index: usize,
    /// Couplings of the neighbour to x and y.
    coupling: [Value; 2],
    /// Couplings times the inverse of the block.
    weight: [Value; 2],
}

/// The factors in this order, if all their pivots are nonzero by structure.
pub fn factors(g: &mut Graph, at: &Unreduced, order: Order) -> Option<Factors> {
    let mut front = Front::new(at);
    front.reorient(g);
    match order {
        Order::Dual => front.dual(g)?,
        _ => front.primal(g, order)?,
    }
    let Front { matrix, bound, coordinates, steps, .. } = front;
    let attitudes = at.attitudes.iter().map(|attitude| (bound + attitude.first, attitude.at)).collect();
    Some(Factors { size: matrix.len(), bound, coordinates, steps, attitudes })
}

impl Factors {
    /// Values that are computed before anything is solved for.
    pub fn values(&self) -> Vec<Value> {
        let mut values = Vec::new();
        for step in &self.steps {
            match step {
                Elimination::Single { inverse, l, .. } => {
                    values.push(*inverse);
                    values.extend(l.iter().map(|(_, l)| *l));
                }
                Elimination::Pair(pair) => values.extend(pair.neighbours.iter().flat_map(|n| n.weight)),
                Elimination::Rotation { c, d, .. } => values.extend([*c, *d]),
            }
        }
        values
    }

    /// Accelerations of the coordinates, then −λ.
    pub fn motion(&self, g: &mut Graph, at: &Unreduced) -> Vec<Value> {
        let mut right = at.e.clone();
        right.extend(&at.gamma);
        right.extend(at.drift.iter().map(|drift| -*drift));
        // No force acts on σ̈ itself, nor does anything but ω̇ depend on it: γ of ω, written beside ω̇, is short.
        for k in at.attitudes.iter().flat_map(|attitude| attitude.spin) {
            right[self.bound + self.coordinates + k] = Value::ZERO;
        }
        let all = self.eliminated(g, right);
        let mut solution = self.motions(all);
        for Attitude { first, at, .. } in &at.attitudes {
            let rate = [0, 1, 2].map(|k| g.symbol(Symbol::Velocity(first + k)));
            let omega_rate = [0, 1, 2].map(|k| solution[first + k]);
            let accelerations = at.accelerations(g, &rate, &omega_rate);
            solution[*first..first + 3].copy_from_slice(&accelerations);
        }
        solution
    }

    /// The same for any generalized forces at the coordinates and any right-hand sides of the constraints.
    pub fn response(&self, g: &mut Graph, given: &[Value]) -> Vec<Value> {
        let (forces, rest) = given.split_at(self.coordinates);
        let mut right = vec![Value::ZERO; self.bound];
        right.extend(forces);
        right.resize(self.size - rest.len(), Value::ZERO);
        right.extend(rest);
        self.solve(g, right)
    }

    /// Accelerations of the coordinates, then −λ.
    fn solve(&self, g: &mut Graph, b: Vec<Value>) -> Vec<Value> {
        let all = self.unknowns(g, b);
        self.motions(all)
    }

    /// The accelerations of the coordinates and −λ, of all unknowns.
    fn motions(&self, mut b: Vec<Value>) -> Vec<Value> {
        let multipliers = b.split_off(self.bound + self.coordinates + self.bound);
        let mut result = b.split_off(self.bound);
        result.truncate(self.coordinates);
        result.extend(multipliers);
        result
    }

    /// All unknowns, for any right-hand sides: accelerations of the bindings and of the coordinates, forces of the
    /// bindings, −λ.
    pub fn unknowns<A: Arithmetic>(&self, a: &mut A, mut b: Vec<A::Number>) -> Vec<A::Number> {
        for (first, at) in &self.attitudes {
            apply(a, at, &mut b[*first..first + 3], true);
        }
        let mut all = self.eliminated(a, b);
        for (first, at) in &self.attitudes {
            apply(a, at, &mut all[*first..first + 3], false);
        }
        all
    }

    /// The same with ω̇ less its γ in the place of the accelerations of attitudes.
    pub fn eliminated<A: Arithmetic>(&self, a: &mut A, mut b: Vec<A::Number>) -> Vec<A::Number> {
        for step in &self.steps {
            match step {
                Elimination::Single { x, l, .. } => {
                    for &(i, l) in l {
                        b[i] = less(a, b[i], l, b[*x]);
                    }
                }
                Elimination::Pair(pair) => {
                    let y = pair.solved(a, &b);
                    for Neighbour { index, coupling, .. } in &pair.neighbours {
                        let product = inner(a, *coupling, y);
                        b[*index] = a.sub(b[*index], product);
                    }
                }
                Elimination::Rotation { x, y, c, d } => (b[*x], b[*y]) = rotated(a, [*c, *d], b[*x], b[*y]),
            }
        }
        for step in self.steps.iter().rev() {
            match step {
                Elimination::Single { x, inverse, l } => {
                    b[*x] = a.scale(*inverse, b[*x]);
                    for &(i, l) in l {
                        b[*x] = less(a, b[*x], l, b[i]);
                    }
                }
                Elimination::Pair(pair) => {
                    let mut z = pair.solved(a, &b);
                    for Neighbour { index, weight, .. } in &pair.neighbours {
                        for (z, weight) in z.iter_mut().zip(weight) {
                            *z = less(a, *z, *weight, b[*index]);
                        }
                    }
                    (b[pair.x], b[pair.y]) = (z[0], z[1]);
                }
                Elimination::Rotation { x, y, c, d } => (b[*x], b[*y]) = rotated(a, [*c, -*d], b[*x], b[*y]),
            }
        }
        b
    }
}

/// Arithmetic of right-hand sides: of expressions, or of what it takes to compute them.
pub trait Arithmetic {
    type Number: Copy;
    fn scale(&mut self, k: Value, x: Self::Number) -> Self::Number;
    fn add(&mut self, x: Self::Number, y: Self::Number) -> Self::Number;
    fn sub(&mut self, x: Self::Number, y: Self::Number) -> Self::Number;
}

impl Arithmetic for Graph {
    type Number = Value;

    fn scale(&mut self, k: Value, x: Value) -> Value {
        self.mul(k, x)
    }

    fn add(&mut self, x: Value, y: Value) -> Value {
        Graph::add(self, x, y)
    }

    fn sub(&mut self, x: Value, y: Value) -> Value {
        Graph::sub(self, x, y)
    }
}

impl Pair {
    fn solved<A: Arithmetic>(&self, a: &mut A, b: &[A::Number]) -> [A::Number; 2] {
        let [p, q, r] = self.inverse;
        let b = [b[self.x], b[self.y]];
        [inner(a, [p, q], b), inner(a, [q, r], b)]
    }
}

/// K x, or Kᵀ x, in place.
fn apply<A: Arithmetic>(a: &mut A, at: &Parameters, x: &mut [A::Number], transposed: bool) {
    let old = [x[0], x[1], x[2]];
    let products = [0, 1, 2].map(|i| a.scale(at.vector[i], old[i]));
    let sum = a.add(products[0], products[1]);
    let along = a.add(sum, products[2]);
    for (i, x) in x.iter_mut().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (j, k) = if transposed { (k, j) } else { (j, k) };
        let (straight, radial) = (a.scale(at.scalar, old[i]), a.scale(at.sigma[i], along));
        let (plus, minus) = (a.scale(at.vector[j], old[k]), a.scale(at.vector[k], old[j]));
        let across = a.sub(plus, minus);
        let sum = a.add(straight, across);
        let sum = a.add(sum, radial);
        *x = a.scale(at.whole.scaled(Number::Ratio(1, 2)), sum);
    }
}

/// x − k y
fn less<A: Arithmetic>(a: &mut A, x: A::Number, k: Value, y: A::Number) -> A::Number {
    let product = a.scale(k, y);
    a.sub(x, product)
}

fn inner<A: Arithmetic>(a: &mut A, k: [Value; 2], x: [A::Number; 2]) -> A::Number {
    let (first, second) = (a.scale(k[0], x[0]), a.scale(k[1], x[1]));
    a.add(first, second)
}

/// (c u + d v, c v − d u)
fn rotated<A: Arithmetic>(
    a: &mut A,
    [c, d]: [Value; 2],
    u: A::Number,
    v: A::Number,
) -> (A::Number, A::Number) {
    (inner(a, [c, d], [u, v]), inner(a, [c, -d], [v, u]))
}

/// Is it positive for positive parameters?
fn is_positive(g: &Graph, v: Value) -> bool {
    if v.is_zero() || v.k.is_negative() {
        return false;
    }
    let Some(id) = v.node else { return true };
    match g.node(id) {
        Node::Symbol(symbol) => matches!(symbol, Symbol::Parameter(_)),
        Node::Sum(a, b) => is_positive(g, *a) && is_positive(g, *b),
        Node::Product(a, b) => is_positive(g, (*a).into()) && is_positive(g, (*b).into()),
        Node::Inverse(a) => is_positive(g, (*a).into()),
        Node::Call(Function::sqrt, a, _) => is_positive(g, *a),
        _ => false,
    }
}

/// The system while it is being eliminated.
struct Front {
    matrix: Vec<BTreeMap<usize, Value>>,
    alive: Vec<bool>,
    /// Have rows changed since an unknown was chosen last?
    changed: Vec<bool>,
    /// Unknowns are accelerations of `bound` bindings and of the coordinates, forces of the bindings, multipliers.
    bound: usize,
    coordinates: usize,
    steps: Vec<Elimination>,
}

impl Front {
    fn new(at: &Unreduced) -> Front {
        let (bound, n) = (at.bound, at.coordinates);
        let size = 2 * bound + n + at.rows.len();
        let mut front = Front {
            matrix: vec![BTreeMap::new(); size],
            alive: vec![true; size],
            changed: vec![true; size],
            bound,
            coordinates: n,
            steps: Vec::new(),
        };
        for (i, row) in at.hessian.iter().enumerate() {
            row.iter().for_each(|&(j, h)| front.put(i, j, h));
        }
        for (k, row) in at.tangents.iter().enumerate() {
            front.put(front.force(k), k, Value::ONE);
            let attitude = |a: &&Attitude| a.spin.contains(&k);
            if let Some(attitude) = at.attitudes.iter().find(attitude) {
                front.put(front.force(k), bound + attitude.first + k - attitude.spin[0], -Value::ONE);
                continue;
            }
            row.iter().for_each(|&(i, s)| front.put(front.force(k), i, -s));
        }
        for (j, row) in at.rows.iter().enumerate() {
            row.iter().for_each(|&(i, a)| front.put(2 * bound + n + j, i, a));
        }
        front
    }

    /// The force of a binding.
    fn force(&self, k: usize) -> usize {
        self.bound + self.coordinates + k
    }

    fn is_acceleration(&self, i: usize) -> bool {
        i < self.bound + self.coordinates
    }

    fn at(&self, i: usize, j: usize) -> Value {
        self.matrix[i].get(&j).copied().unwrap_or(Value::ZERO)
    }

    fn put(&mut self, i: usize, j: usize, v: Value) {
        (self.changed[i], self.changed[j]) = (true, true);
        if v.is_zero() {
            self.matrix[i].remove(&j);
            self.matrix[j].remove(&i);
        } else {
            self.matrix[i].insert(j, v);
            self.matrix[j].insert(i, v);
        }
    }

    /// Unknowns that it couples to, but for itself.
    fn neighbours(&self, x: usize) -> Vec<usize> {
        let mut all = Vec::with_capacity(self.matrix[x].len());
        for &i in self.matrix[x].keys() {
            if i != x {
                all.push(i);
            }
        }
        all
    }

    /// Unknowns that one of these couples to, but for themselves.
    fn neighbours_of_both(&self, x: usize, y: usize) -> Vec<usize> {
        let mut all = self.neighbours(x);
        for &i in self.matrix[y].keys() {
            if i != y && !self.matrix[x].contains_key(&i) {
                all.push(i);
            }
        }
        all.retain(|i| *i != y && *i != x);
        all.sort_unstable();
        all
    }

    /// Number of unknowns that one of these couples to, but for themselves. Without optimisation a set of them would
    /// take most of the time of an elimination.
    fn degree(&self, x: usize, with: Option<usize>) -> usize {
        let others = |i: usize| self.matrix[i].len() - usize::from(self.matrix[i].contains_key(&i));
        let Some(y) = with else { return others(x) };
        let coupled = self.matrix[x].contains_key(&y);
        let shared =
            self.matrix[y].keys().filter(|i| **i != x && **i != y && self.matrix[x].contains_key(i)).count();
        others(x) + others(y) - shared - 2 * usize::from(coupled)
    }

    fn remove(&mut self, x: usize) {
        (self.alive[x], self.changed[x]) = (false, true);
        for i in std::mem::take(&mut self.matrix[x]).into_keys() {
            self.matrix[i].remove(&x);
            self.changed[i] = true;
        }
    }

    fn single(&mut self, g: &mut Graph, x: usize) -> Option<()> {
        let pivot = self.at(x, x);
        if pivot.is_zero() {
            return None;
        }
        let inverse = g.recip(pivot);
        let column: Vec<Entry> = self.neighbours(x).into_iter().map(|i| (i, self.at(i, x))).collect();
        let l: Vec<Entry> = column.iter().map(|&(i, a)| (i, g.mul(a, inverse))).collect();
        for (at, &(i, a)) in column.iter().enumerate() {
            for &(j, l) in &l[at..] {
                let product = g.mul(l, a);
                let entry = g.sub(self.at(i, j), product);
                self.put(i, j, entry);
            }
        }
        self.remove(x);
        self.steps.push(Elimination::Single { x, inverse, l });
        Some(())
    }

    fn pair(&mut self, g: &mut Graph, x: usize, y: usize) -> Option<()> {
        let (h, o, m) = (self.at(x, x), self.at(x, y), self.at(y, y));
        let (hm, oo) = (g.mul(h, m), g.mul(o, o));
        let determinant = g.sub(hm, oo);
        if determinant.is_zero() {
            return None;
        }
        let inverse = [g.div(m, determinant), g.div(-o, determinant), g.div(h, determinant)];
        let [p, q, r] = inverse;
        let neighbours: Vec<Neighbour> = self
            .neighbours_of_both(x, y)
            .into_iter()
            .map(|index| {
                let coupling = [self.at(index, x), self.at(index, y)];
                let weight = [inner(g, [p, q], coupling), inner(g, [q, r], coupling)];
                Neighbour { index, coupling, weight }
            })
            .collect();
        for (at, first) in neighbours.iter().enumerate() {
            for second in &neighbours[at..] {
                let product = inner(g, first.coupling, second.weight);
                if !product.is_zero() {
                    let entry = g.sub(self.at(first.index, second.index), product);
                    self.put(first.index, second.index, entry);
                }
            }
        }
        self.remove(x);
        self.remove(y);
        self.steps.push(Elimination::Pair(Box::new(Pair { x, y, inverse, neighbours })));
        Some(())
    }

    /// A binding that is a coordinate more or less, such as φ₂ = φ₁ + q₂, takes the place of that coordinate, if it
    /// has no inertia of its own: its definition gives q̈₂, whose own equation gives the force.
    fn reorient(&mut self, g: &mut Graph) {
        for k in 0..self.bound {
            let force = self.force(k);
            let instead = self.matrix[force].iter().find_map(|(&i, v)| {
                let coordinate = (self.bound..self.bound + self.coordinates).contains(&i);
                (coordinate && v.is_constant() && self.matrix[i].len() == 1).then_some(i)
            });
            if let Some(i) = instead {
                self.pair(g, i, force);
            }
        }
    }

    /// All the rest, each as soon as it may be and the order wants it.
    fn primal(&mut self, g: &mut Graph, order: Order) -> Option<()> {
        let accelerations = self.bound + self.coordinates;
        let mut keys = vec![None; self.matrix.len()];
        while self.alive.contains(&true) {
            let mut best: Option<([usize; 3], usize)> = None;
            let mut x = 0;
            while x < keys.len() {
                let own = if x < self.bound { self.force(x) } else { x };
                if self.changed[x] || self.changed[own] {
                    keys[x] = self.key(order, x);
                }
                if let Some(key) = keys[x]
                    && best.is_none_or(|(least, _)| key < least)
                {
                    best = Some((key, x));
                }
                x += 1;
                // Forces go with their bindings.
                if x == accelerations {
                    x += self.bound;
                }
            }
            self.changed.fill(false);
            let (_, x) = best?;
            if x < self.bound && self.alive[self.force(x)] {
                self.pair(g, x, self.force(x))?;
            } else {
                self.single(g, x)?;
            }
        }
        Some(())
    }

    /// Rank of an unknown in the order of elimination, if it may be eliminated now.
    fn key(&self, order: Order, x: usize) -> Option<[usize; 3]> {
        if !self.alive[x] {
            return None;
        }
        let forces = self.bound + self.coordinates..self.bound + self.coordinates + self.bound;
        let own = (x < self.bound && self.alive[self.force(x)]).then(|| self.force(x));
        let row = &self.matrix[x];
        let users = row.keys().filter(|i| forces.contains(i) && Some(**i) != own).count();
        let allowed = match own {
            Some(_) => true,
            None if self.is_acceleration(x) => users == 0 && row.contains_key(&x),
            None => row.contains_key(&x) && row.keys().all(|i| !self.is_acceleration(*i)),
        };
        let (degree, last) = (self.degree(x, own), self.matrix.len() - x);
        allowed.then_some(match order {
            Order::Leaves => [users, degree, last],
            _ => [degree, usize::from(own.is_some()), last],
        })
    }

    fn dual(&mut self, g: &mut Graph) -> Option<()> {
        let accelerations = self.bound + self.coordinates;
        // Bindings without inertia are what defines them.
        for k in (0..self.bound).rev() {
            let free = self.matrix[k].keys().all(|i| !self.is_acceleration(*i));
            if self.alive[k] && self.alive[self.force(k)] && free {
                self.pair(g, k, self.force(k))?;
            }
        }
        for x in 0..accelerations {
            let alone = self.matrix[x].keys().all(|i| *i == x || !self.is_acceleration(*i));
            if self.alive[x] && self.matrix[x].contains_key(&x) {
                if !alone || !is_positive(g, self.at(x, x)) {
                    return None;
                }
                self.single(g, x)?;
            }
        }
        // All rotations first, so that no force is named in its old directions any more.
        let free: Vec<usize> = (0..accelerations).filter(|x| self.alive[*x]).collect();
        for &x in &free {
            let forces: Vec<usize> = self.matrix[x].keys().copied().collect();
            match forces[..] {
                [_] => {}
                [force, other] => self.rotate(g, x, force, other)?,
                _ => return None,
            }
        }
        for x in free {
            let [force] = self.matrix[x].keys().copied().collect::<Vec<_>>()[..] else { return None };
            if !is_positive(g, self.at(x, force)) && !is_positive(g, -self.at(x, force)) {
                return None;
            }
            self.pair(g, x, force)?;
        }
        // What is left is negative definite: any order will do.
        let mut level = vec![0; self.matrix.len()];
        let alive = |front: &Front| (0..front.matrix.len()).filter(|x| front.alive[*x]).collect::<Vec<_>>();
        while let Some(x) =
            alive(self).into_iter().min_by_key(|&x| (self.matrix[x].len(), level[x], usize::MAX - x))
        {
            for i in self.neighbours(x) {
                level[i] = level[i].max(level[x] + 1);
            }
            self.single(g, x)?;
        }
        Some(())
    }

    /// The forces x and y that act on a coordinate along B, turned into B/|B| and its normal: the first is what the
    /// coordinate's own equation says.
    fn rotate(&mut self, g: &mut Graph, coordinate: usize, x: usize, y: usize) -> Option<()> {
        let along = [self.at(coordinate, x), self.at(coordinate, y)];
        let square = inner(g, along, along);
        if !is_positive(g, square) {
            return None;
        }
        // Where the length is no monomial, the forces keep the factor |B|.
        let length = root(g, square).unwrap_or(Value::ONE);
        let [c, d] = along.map(|b| g.div(b, length));
        let (a, b, e) = (self.at(x, x), self.at(x, y), self.at(y, y));
        for j in self.neighbours_of_both(x, y) {
            let (u, v) = rotated(g, [c, d], self.at(x, j), self.at(y, j));
            self.put(x, j, u);
            self.put(y, j, v);
        }
        let coupling = g.div(square, length);
        self.put(coordinate, x, coupling);
        self.put(coordinate, y, Value::ZERO);
        if a == e && b.is_zero() {
            let norm = inner(g, [c, d], [c, d]);
            let a = g.mul(a, norm);
            self.put(x, x, a);
            self.put(y, y, a);
        } else {
            let (p, q) = (inner(g, [c, d], [a, b]), inner(g, [c, d], [b, e]));
            let (r, s) = (inner(g, [c, -d], [b, a]), inner(g, [c, -d], [e, b]));
            let (xx, xy, yy) =
                (inner(g, [c, d], [p, q]), inner(g, [c, -d], [q, p]), inner(g, [c, -d], [s, r]));
            self.put(x, x, xx);
            self.put(x, y, xy);
            self.put(y, y, yy);
        }
        self.steps.push(Elimination::Rotation { x, y, c, d });
        Some(())
    }
}

/// The square root of a number times even powers.
fn root(g: &mut Graph, v: Value) -> Option<Value> {
    let k = v.k.sqrt()?;
    let Some(id) = v.node else { return Some(Value { k, node: None }) };
    let factors = g.factors(id);
    if factors.iter().any(|f| f.1 % 2 != 0) {
        return None;
    }
    let mut result = Value { k, node: None };
    for &(base, e) in factors.iter() {
        let power = g.powi(base.into(), e / 2);
        result = g.mul(result, power);
    }
    Some(result)
}
