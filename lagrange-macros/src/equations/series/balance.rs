//! Taylor coefficients from the equations where they were written, before anything is eliminated.
//!
//! With u̇ = S ẋ + φ_t for the rates of the bindings, x = (u, q), and a force σ that holds each binding to its definition,
//!
//! ```text
//!   H ẍ − (S, 0)ᵀ σ + σ = e        ü − S ẍ = d/dt (S, φ_t) (ẋ, 1) at ẍ = 0
//! ```
//!
//! of which order k − 1 is, with what is known already on the right,
//!
//! ```text
//!   H_0 ẍ_{k−1} − S_0ᵀ σ_{k−1} + σ_{k−1} = e_{k−1} − Σ_{j≥1} H_j ẍ_{k−1−j} + Σ_{j≥1} S_jᵀ σ_{k−1−j}
//!   ü_{k−1} − S_0 ẍ_{k−1} = k ((φ_t)_k + Σ_{j≥1} S_j ẋ_{k−j}).
//! ```
//!
//! The matrix is the same at all orders. It is factored once a step, sparsely and at compile time (`augmented.rs`), so an order costs one
//! sweep over the bindings there and one back. Products of series are what was written and no more: four for each link of a
//! chain. Unknowns are counted one order later than they belong, so that all that is convolved has the order k.

use crate::equations::assemble::flattened;
use crate::equations::augmented::{Arithmetic, Factors};
use crate::equations::formed::Formed;
use crate::equations::series::{Factor, is_number};
use crate::equations::solved::Solved;
use crate::graph::{Graph, Node, Symbol, Value, stable_map::IdMap};
use crate::model::Model;
use crate::model::frames::Motion;
use crate::schedule::below_given;

/// A right-hand side of the equations.
pub enum Right {
    /// Of a position: e, and unknowns times nodes that move.
    Forces { force: Value, tails: Vec<(Value, usize)> },
    /// Of the definition of a binding: φ_t, and the slopes that move with the velocities they belong to.
    Definition { explicit: Value, terms: Vec<[Value; 2]> },
}

/// The equations of one order.
pub struct Balance {
    /// What is `Given` to the solution.
    pub rights: Vec<Right>,
    /// Accelerations of the coordinates, and then the other unknowns that are convolved, in terms of what is given.
    pub solution: Vec<Value>,
    /// Velocities times slopes: the derivatives of sines and cosines are among them.
    rates: Vec<Value>,
}

/// The equations at the bindings; none for systems with constraints or frames in space.
pub fn balance(g: &mut Graph, model: &Model, formed: &Formed, solved: &Solved) -> Option<Balance> {
    let Formed { flat, unreduced: at, .. } = formed;
    let (bound, n) = (at.bound, at.coordinates);
    let positions = model.bindings.iter().all(|b| matches!(b.motion, Motion::Position));
    if bound == 0 || !formed.rows.is_empty() || !positions {
        return None;
    }
    let values: Vec<Value> = model.bindings.iter().map(|b| b.value).collect();
    let explicit = g.forward(&values, |s| (s == Symbol::Time).then_some(Value::ONE));
    let explicit = flattened(g, flat, &explicit);
    let velocity: Vec<Value> = (0..n).map(|i| g.symbol(Symbol::Velocity(i))).collect();
    let rate = |x: usize| if x < bound { flat[x][1] } else { velocity[x - bound] };

    // Unknowns that are convolved: forces that act along slopes that move, accelerations that inertia that moves belongs to.
    let mut wanted: Vec<usize> = (bound..bound + n).collect();
    let mut place = |unknown: usize| {
        wanted.iter().position(|w| *w == unknown).unwrap_or_else(|| {
            wanted.push(unknown);
            wanted.len() - 1
        })
    };
    let mut tails: Vec<Vec<(Value, usize)>> = vec![Vec::new(); bound + n];
    for (i, row) in at.hessian.iter().enumerate() {
        for &(j, h) in row.iter().filter(|(_, h)| !is_number(g, *h)) {
            tails[i].push((-h, place(j)));
        }
    }
    for (k, row) in at.tangents.iter().enumerate() {
        for &(i, s) in row.iter().filter(|(_, s)| !is_number(g, *s)) {
            tails[i].push((s, place(bound + n + k)));
        }
    }

    let mut rights = Vec::new();
    let mut given = vec![Value::ZERO; 2 * bound + n];
    let mut add = |g: &mut Graph, row: usize, right: Right| {
        given[row] = g.symbol(Symbol::Given(rights.len()));
        rights.push(right);
    };
    for (i, tails) in tails.into_iter().enumerate() {
        let force = at.e[i];
        if !force.is_zero() || !tails.is_empty() {
            add(g, i, Right::Forces { force, tails });
        }
    }
    let mut rates = Vec::new();
    for k in 0..bound {
        let moving = at.tangents[k].iter().filter(|(x, s)| !is_number(g, *s) && !rate(*x).is_zero());
        let moving: Vec<[Value; 2]> = moving.map(|&(x, s)| [s, rate(x)]).collect();
        rates.extend(moving.iter().map(|[s, r]| g.mul(*s, *r)));
        if !moving.is_empty() || !is_number(g, explicit[k]) {
            add(g, bound + n + k, Right::Definition { explicit: explicit[k], terms: moving });
        }
    }

    let factors = solved.orders.iter().min_by_key(|factors| Sweep::cost(factors, &given, &wanted))?;
    let all = factors.unknowns(g, given);
    let solution = wanted.iter().map(|x| all[*x]).collect();
    Some(Balance { rights, solution, rates })
}

/// The operations of one order as they are written, without any of their results: what an order of elimination would cost.
#[derive(Default)]
struct Sweep {
    /// Operands of each operation, as 1 more than their numbers; 0 is what is known or given.
    operands: Vec<[u32; 2]>,
}

impl Sweep {
    /// Operations, and a third of the cycles of the longest chain of them.
    fn cost(factors: &Factors, given: &[Value], wanted: &[usize]) -> usize {
        let mut sweep = Sweep::default();
        // What vanishes takes no operations.
        let given = given.iter().map(|v| (!v.is_zero()).then_some(0)).collect();
        let all = factors.unknowns(&mut sweep, given);
        let operands = sweep.operands.as_slice();
        let (mut live, mut depths) = (vec![false; operands.len() + 1], vec![0; operands.len() + 1]);
        let (live, depths) = (live.as_mut_slice(), depths.as_mut_slice());
        for x in wanted {
            if let Some(x) = all[*x] {
                live[x as usize] = true;
            }
        }
        let mut at = operands.len();
        while at > 0 {
            if live[at] {
                let [x, y] = operands[at - 1];
                (live[x as usize], live[y as usize]) = (true, true);
            }
            at -= 1;
        }
        let (mut operations, mut longest) = (0, 0);
        while at < operands.len() {
            let [x, y] = operands[at];
            at += 1;
            if live[at] {
                operations += 1;
                depths[at] = 4 + depths[x as usize].max(depths[y as usize]);
                longest = longest.max(depths[at]);
            }
        }
        operations + longest / 3
    }

    fn operation(&mut self, x: u32, y: u32) -> Option<u32> {
        self.operands.push([x, y]);
        Some(self.operands.len() as u32)
    }
}

impl Arithmetic for Sweep {
    /// None of what vanishes.
    type Number = Option<u32>;

    fn scale(&mut self, k: Value, x: Option<u32>) -> Option<u32> {
        match x {
            Some(x) if !(k.is_zero() || k.is_constant() && k.k.is_unit()) => self.operation(x, 0),
            _ => x.filter(|_| !k.is_zero()),
        }
    }

    fn add(&mut self, x: Option<u32>, y: Option<u32>) -> Option<u32> {
        match (x, y) {
            (Some(x), Some(y)) => self.operation(x, y),
            (x, y) => x.or(y),
        }
    }

    fn sub(&mut self, x: Option<u32>, y: Option<u32>) -> Option<u32> {
        self.add(x, y)
    }
}

/// Operations of one order, and a third of the cycles of the longest chain of them.
fn cost(g: &Graph, solution: &[Value]) -> usize {
    let moved = below_given(g, solution);
    let mut depths: IdMap<usize> = IdMap::default();
    let (mut operations, mut longest) = (0, 0);
    for id in g.live(solution).into_iter().filter(|id| moved.get(id).is_some()) {
        let mut depth = 0;
        g.operands(id, |v| depth = depth.max(v.node.and_then(|n| depths.get(&n)).copied().unwrap_or(0)));
        if !matches!(g.node(id), Node::Symbol(_)) {
            operations += 1;
            depth += 4;
        }
        longest = longest.max(depth);
        depths.insert(id, depth);
    }
    operations + longest / 3
}

impl Balance {
    /// What an order costs beside its products.
    pub fn cost(&self, g: &Graph) -> usize {
        cost(g, &self.solution)
    }

    /// All that has to be known as a series or a number.
    pub fn values(&self) -> Vec<Value> {
        let mut values = self.rates.clone();
        for right in &self.rights {
            match right {
                Right::Forces { force, tails } => {
                    values.push(*force);
                    values.extend(tails.iter().map(|(v, _)| *v));
                }
                Right::Definition { explicit, terms } => {
                    values.push(*explicit);
                    values.extend(terms.iter().flatten());
                }
            }
        }
        values
    }

    /// The products of series in the right-hand sides.
    pub fn convolutions(&self, g: &Graph) -> Vec<[Factor; 2]> {
        let mut pairs = Vec::new();
        for right in &self.rights {
            match right {
                Right::Forces { tails, .. } => {
                    pairs.extend(
                        tails.iter().filter_map(|(v, x)| Some([Factor::Of(v.node?), Factor::Unknown(*x)])),
                    );
                }
                Right::Definition { terms, .. } => {
                    pairs.extend(terms.iter().filter_map(|term| term_pair(g, *term)))
                }
            }
        }
        pairs
    }
}

/// The factors of a slope and a velocity, unless the velocity is a number.
pub fn term_pair(g: &Graph, [slope, rate]: [Value; 2]) -> Option<[Factor; 2]> {
    let rate = rate.node.filter(|_| !is_number(g, rate))?;
    Some([Factor::Of(slope.node?), Factor::Of(rate)])
}
