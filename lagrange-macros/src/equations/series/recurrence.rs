//! Recurrence of the coefficients of an order from those before it, and its cost.

use crate::graph::{Graph, Node, Symbol, Value, stable_map::IdMap};
use crate::program::Program;
use crate::program::count::operations;
use crate::program::lower::program_from;

/// Order of the series whose operations are counted: the highest that `Taylor` chooses by itself.
const COUNTED_ORDER: usize = 20;
/// Convolutions whose inner sums are formed together, as the elements of a vector.
pub const CONVOLUTIONS_PER_VECTOR: usize = 4;
/// Systems of at most this many convolutions have their orders written out one by one by the optimiser, which makes
/// of sums straight lines; others loop.
pub const MAX_UNROLLED_CONVOLUTIONS: usize = 32;

/// Recurrence of the coefficients of an order from those before it.
pub struct Recurrence {
    /// Coefficients 0 and k of the factors of convolutions.
    pub factors: Vec<[Value; 2]>,
    /// The factors of each convolution.
    pub convolutions: Vec<[usize; 2]>,
    /// Coefficients 0 and k of what the next order is given.
    pub memory: Vec<[Value; 2]>,
    /// Coefficients 0 and k of the switching functions.
    pub switching: Vec<[Value; 2]>,
    /// Coefficients 0 and k of the accelerations, and those of order k of the velocities that are found instead.
    pub accelerations: Vec<(usize, [Value; 2])>,
    pub velocities: Vec<(usize, Value)>,
    /// Coefficients of order k of the coordinates that are found themselves.
    pub coordinates: Vec<(usize, Value)>,
}

/// Coefficients by which the motion goes on, by coordinates.
#[derive(Default)]
pub struct Motion {
    pub accelerations: Vec<(usize, [Value; 2])>,
    pub velocities: Vec<(usize, Value)>,
    pub coordinates: Vec<(usize, Value)>,
}

impl Recurrence {
    fn pairs(&self) -> impl Iterator<Item = &[Value; 2]> {
        let pairs = self.factors.iter().chain(&self.memory).chain(&self.switching);
        pairs.chain(self.accelerations.iter().map(|a| &a.1))
    }

    /// All that an order computes.
    pub fn next(&self) -> Vec<Value> {
        let found = self.velocities.iter().chain(&self.coordinates).map(|found| found.1);
        self.pairs().map(|pair| pair[1]).chain(found).collect()
    }

    /// The program of an order, whose constants are known before the order begins.
    pub fn program(&self, g: &Graph) -> Program {
        let next = self.next();
        let moved = moved(g, &next);
        program_from(g, &next, |v| v.node.is_some_and(|id| moved.get(&id).is_none()))
    }

    /// The values that order 0 computes, without velocities and coordinates.
    pub fn first(&self) -> Vec<Value> {
        self.pairs().map(|pair| pair[0]).collect()
    }

    /// The coordinates whose accelerations are found.
    pub fn kept(&self) -> Vec<usize> {
        self.accelerations.iter().map(|(i, _)| *i).collect()
    }

    /// Orders beyond that of the accelerations: velocities that are found themselves have as many coefficients as
    /// what they are found of, where accelerations give one more, and coordinates likewise.
    pub fn further_orders(&self) -> usize {
        match (self.velocities.is_empty(), self.coordinates.is_empty()) {
            (true, true) => 0,
            (false, true) => 1,
            (_, false) => 2,
        }
    }

    /// Are its orders written out one by one?
    pub fn straight(&self) -> bool {
        self.convolutions.len() <= MAX_UNROLLED_CONVOLUTIONS
    }

    /// The convolutions of two factors, and those of one, by their places. A square takes half the operations of a
    /// product, but no more time where a vector of products has room for it.
    pub fn layout(&self) -> [Vec<usize>; 2] {
        let is_square = |i: &usize| self.convolutions[*i][0] == self.convolutions[*i][1];
        let (squares, mut products): (Vec<usize>, Vec<usize>) =
            (0..self.convolutions.len()).partition(is_square);
        let room = products.len().next_multiple_of(CONVOLUTIONS_PER_VECTOR) - products.len();
        if self.straight() && products.len() > CONVOLUTIONS_PER_VECTOR / 2 && squares.len() <= room {
            products.extend(squares);
            return [products, Vec::new()];
        }
        [products, squares]
    }

    /// Operations of a series whose orders this program computes, those of a vector of convolutions counted once.
    pub fn cost(&self, g: &Graph, program: &Program) -> usize {
        let once = operations(g, &self.first()).cost();
        once + self.cost_of_orders(program.operations().cost())
    }

    /// Operations that a series takes at least: one for each node that an order computes.
    pub fn least_cost(&self, g: &Graph) -> usize {
        let moved = moved(g, &self.next()).in_order();
        let is_computed = |id| !matches!(g.node(id), Node::Symbol(_));
        self.cost_of_orders(moved.into_iter().filter(|(id, _)| is_computed(*id)).count())
    }

    /// Operations of all orders, for those of one beside the inner sums.
    fn cost_of_orders(&self, order: usize) -> usize {
        let [products, squares] = self.layout();
        // An inner sum of order k has k − 3 products; that of a square half of them.
        let inner: usize = (4..=COUNTED_ORDER).map(|k| k - 3).sum();
        let rows = 2 * products.len().div_ceil(CONVOLUTIONS_PER_VECTOR)
            + squares.len().div_ceil(CONVOLUTIONS_PER_VECTOR);
        // Coordinates, and velocities where they come from accelerations, are divided by the order.
        let divisions = 2 * self.accelerations.len() + self.velocities.len();
        (COUNTED_ORDER + self.further_orders()) * (order + 4 * divisions) + inner * rows
    }
}

/// The nodes that change from order to order.
fn moved(g: &Graph, next: &[Value]) -> IdMap<()> {
    g.dependent(next, |s| matches!(s, Symbol::Order(_)))
}
