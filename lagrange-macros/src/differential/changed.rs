//! The same system in other coordinates, other units, and another order: equations must change as tensors do.

use super::generate::{Constraint, Expr, Frames, Random, System, Unit};

/// q = C y, t = τ t', and energies in units that are smaller by κ. All numbers are powers of two or small integers,
/// so that the change itself adds no rounding errors to speak of.
pub struct Change {
    /// Rows of C, in eighths.
    rows: Vec<Vec<i32>>,
    /// τ and κ, in eighths.
    time: i32,
    energy: i32,
}

fn eighths(k: i32) -> f64 {
    f64::from(k) / 8.0
}

impl Change {
    /// A triangular matrix with a permutation of its columns.
    pub fn random(random: &mut Random, n: usize) -> Change {
        let mut order: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            order.swap(i, random.below(i + 1));
        }
        let mut rows = vec![vec![0; n]; n];
        for i in 0..n {
            rows[i][order[i]] = [8, 8, 4, 16, -8][random.below(5)];
            if i > 0 && random.below(2) == 0 {
                rows[i][order[random.below(i)]] = [8, -8, 4][random.below(3)];
            }
        }
        Change { rows, time: [4, 8, 16, 32][random.below(4)], energy: [2, 8, 64][random.below(3)] }
    }

    pub fn time(&self) -> f64 {
        eighths(self.time)
    }

    pub fn energy(&self) -> f64 {
        eighths(self.energy)
    }

    /// C y
    pub fn applied(&self, y: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|row| row.iter().zip(y).map(|(c, y)| eighths(*c) * y).sum()).collect()
    }

    /// An expression of the old coordinates in terms of the new ones.
    fn of(&self, e: &Expr) -> Expr {
        let part = |e: &Expr| Box::new(self.of(e));
        match e {
            Expr::Position(i) if *i < self.rows.len() => {
                let terms = self.rows[*i].iter().enumerate().filter(|(_, c)| **c != 0);
                let term = |(j, c): (usize, &i32)| match c {
                    8 => Expr::Position(j),
                    c => Expr::Constant(*c) * Expr::Position(j),
                };
                terms.map(term).reduce(|a, b| a + b).expect("a regular matrix")
            }
            Expr::Time => Expr::Constant(self.time) * Expr::Time,
            Expr::Rate(a) => Expr::Constant(64 / self.time) * Expr::Rate(part(a)),
            Expr::Constant(_) | Expr::Parameter(_) | Expr::Position(_) | Expr::Binding(_) => e.clone(),
            Expr::Sum(a, b) => Expr::Sum(part(a), part(b)),
            Expr::Difference(a, b) => Expr::Difference(part(a), part(b)),
            Expr::Product(a, b) => Expr::Product(part(a), part(b)),
            Expr::Quotient(a, b) => Expr::Quotient(part(a), part(b)),
            Expr::Power(a, k) => Expr::Power(part(a), *k),
            Expr::Root(a, k) => Expr::Root(part(a), *k),
            Expr::Call(f, a) => Expr::Call(*f, part(a)),
            Expr::Pair(f, a, b) => Expr::Pair(*f, part(a), part(b)),
            Expr::Unit(Unit::Time) => Expr::Constant(self.time),
            Expr::Unit(Unit::Frequency) => Expr::Constant(64 / self.time),
            Expr::Unit(Unit::Energy) => Expr::Constant(self.energy),
            Expr::Fused(parts) => Expr::Fused(Box::new(parts.each_ref().map(|e| self.of(e)))),
            Expr::Choice(test, parts) => Expr::Choice(*test, Box::new(parts.each_ref().map(|e| self.of(e)))),
        }
    }

    /// The system in the new coordinates and units. Rates by the new time are τ times those by the old one, so D,
    /// whose derivative by them is a force, is τ times as large.
    pub fn system(&self, old: &System) -> System {
        let in_units = |e: Expr| Expr::Constant(self.energy) * e;
        let mut applied: Vec<(usize, Expr)> = Vec::new();
        for (i, force) in &old.applied {
            for (j, c) in self.rows[*i].iter().enumerate().filter(|(_, c)| **c != 0) {
                let part = Expr::Constant(*c) * in_units(self.of(force));
                match applied.iter_mut().find(|(k, _)| *k == j) {
                    Some((_, sum)) => *sum = sum.clone() + part,
                    None => applied.push((j, part)),
                }
            }
        }
        System {
            kind: old.kind,
            coordinates: old.coordinates,
            parameters: old.parameters,
            prescribed: old.prescribed.iter().map(|e| self.of(e)).collect(),
            bindings: old.bindings.iter().map(|e| self.of(e)).collect(),
            kinetic: in_units(self.of(&old.kinetic)),
            potential: in_units(self.of(&old.potential)),
            whole: old.whole,
            dissipation: old.dissipation.as_ref().map(|d| Expr::Constant(self.time) * in_units(self.of(d))),
            applied,
            forces: old.forces.iter().map(|(f, at)| (in_units(self.of(f)), self.of(at))).collect(),
            constraints: old
                .constraints
                .iter()
                .map(|c| Constraint { left: self.of(&c.left), right: self.of(&c.right), ..*c })
                .collect(),
            struck: Vec::new(),
            observed: Vec::new(),
            ignorable: false,
            frames: old.frames.as_ref().map(|frames| Frames {
                said: frames.said.iter().map(|e| self.of(e)).collect(),
                statements: frames.statements.clone(),
            }),
        }
    }
}
