//! Cost of a straight-line program.

use super::lower::prepared;
use super::{Operand, Operation, Program, Source};
use crate::graph::{Function, Graph, Number, Value, stable_map::StableMap};

/// Operations of a set of outputs, without those on parameters alone, which are not repeated. A coefficient other
/// than ±1 costs one multiplication for each distinct coefficient of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Operations {
    pub additions: usize,
    pub multiplications: usize,
    pub divisions: usize,
    pub sin_cos: usize,
    pub functions: usize,
    /// Longest chain of dependent operations, in cycles.
    pub path: usize,
}

impl Operations {
    pub fn arithmetic(&self) -> usize {
        self.additions + self.multiplications + self.divisions
    }

    /// The cost by which programs are compared, in units of an addition: a division occupies its unit four times as
    /// long, a sine–cosine pair takes some forty operations, other functions about thirty. Cycles of the longest
    /// chain count a third: a processor overlaps one evaluation with the next, but not all of it
    /// (docs/lab/performance.md).
    pub fn cost(&self) -> usize {
        let work = self.additions
            + self.multiplications
            + 4 * self.divisions
            + 40 * self.sin_cos
            + 30 * self.functions;
        work + self.path / 3
    }
}

/// Cycles of a division.
const DIVISION: usize = 13;

/// Cycles of an operation on a current processor (Fog, *Instruction tables*: Zen 3 and Ice Lake): additions and
/// products, choices, functions. A quotient has a product behind its division.
const LINEAR: usize = 4;
const CHOICE: usize = 2;
const FUNCTION: usize = 40;

pub fn operations(g: &Graph, outputs: &[Value]) -> Operations {
    prepared(g, outputs).operations()
}

impl Program {
    pub fn operations(&self) -> Operations {
        let mut count = Operations::default();
        let mut scaled: StableMap<(Number, Source), ()> = StableMap::default();
        let mut paths: Vec<usize> = Vec::with_capacity(self.slots.len());
        // Counts a multiplication by a coefficient; returns the cycles until the product is there.
        let mut scale = |count: &mut Operations, paths: &[usize], k: Number, of: Source| {
            let path = match of {
                Source::One | Source::Constant(_) => return 0,
                Source::Symbol(_) => 0,
                Source::Slot(slot) => paths[slot],
            };
            if k.is_unit() {
                return path;
            }
            if scaled.get(&(k.abs(), of)).is_none() {
                scaled.insert((k.abs(), of), ());
                count.multiplications += 1;
            }
            path + LINEAR
        };
        for slot in &self.slots {
            let mut at = |count: &mut Operations, v: Operand| scale(count, &paths, v.k, v.of);
            let path = match &slot.operation {
                Operation::Sum(a, b) => {
                    count.additions += 1;
                    at(&mut count, *a).max(at(&mut count, *b)) + LINEAR
                }
                Operation::Fused([x, Operand { k, of: Source::One }], rest) => {
                    count.additions += 1;
                    at(&mut count, Operand { k: *k, ..*x }).max(at(&mut count, *rest)) + LINEAR
                }
                Operation::Fused([x, y], rest) => {
                    count.additions += 1;
                    count.multiplications += 1;
                    let product = at(&mut count, *x).max(at(&mut count, *y)) + LINEAR;
                    product.max(at(&mut count, *rest)) + LINEAR
                }
                Operation::Product(a, b) => {
                    count.multiplications += 1;
                    at(&mut count, *a).max(at(&mut count, *b)) + LINEAR
                }
                Operation::Quotient(a, b) => {
                    count.divisions += 1;
                    let (a, inverse) = (*a, at(&mut count, *b) + DIVISION);
                    if a.of == Source::One { inverse } else { at(&mut count, a).max(inverse) + LINEAR }
                }
                Operation::OverOrder(x) => {
                    count.divisions += 1;
                    at(&mut count, *x) + DIVISION
                }
                Operation::OverOrderPlus(x, rest) => {
                    count.divisions += 1;
                    count.additions += 1;
                    (at(&mut count, *x) + DIVISION).max(at(&mut count, *rest)) + LINEAR
                }
                operation => {
                    let mut path = 0;
                    operation.operands(|v| path = path.max(at(&mut count, v)));
                    let (counted, n, cycles) = match operation {
                        Operation::Circle(angles) => (&mut count.sin_cos, angles.len(), 0),
                        Operation::Sine(_) | Operation::Cosine(_) => (&mut count.sin_cos, 0, FUNCTION),
                        Operation::Call(Function::sin | Function::cos, ..) => {
                            (&mut count.sin_cos, 1, FUNCTION)
                        }
                        Operation::Select(..) => (&mut count.additions, 1, CHOICE),
                        _ => (&mut count.functions, 1, FUNCTION),
                    };
                    *counted += n;
                    path + cycles
                }
            };
            paths.push(path);
        }
        for v in &self.outputs {
            scale(&mut count, &paths, v.k, v.of);
            if let Source::Slot(slot) = v.of {
                count.path = count.path.max(paths[slot]);
            }
        }
        count
    }
}
