//! The motion by M q̈ = right as a series, `M_0 a_k = right_k − Σ_{j≥1} M_j a_{k−j}`, with M bordered by constraints.

use super::orders::{Factor, Orders};
use super::{form::Form, recurrence::Motion, substitution::Substitution};
use crate::equations::common::is_number;
use crate::equations::solve::{Symmetric, entry};
use crate::graph::Value;
use std::rc::Rc;

pub struct Matrix {
    pub coordinates: usize,
    pub matrix: Symmetric,
    pub right: Vec<Value>,
    /// M⁻¹
    pub solution: Rc<Substitution>,
}

impl Form for Matrix {
    fn name(&self) -> &'static str {
        "matrix"
    }

    fn values(&self) -> Vec<Value> {
        self.matrix.iter().flatten().chain(&self.right).copied().collect()
    }

    fn advance(&self, values: &[Value], orders: &mut Orders) -> Motion {
        let size = self.right.len();
        let (entries, right) = values.split_at(values.len() - size);
        let mut entries = entries.iter().copied();
        let matrix: Symmetric =
            self.matrix.iter().map(|row| entries.by_ref().take(row.len()).collect()).collect();
        let first = self.solution.solve(orders.g, right);
        let mut rights = orders.of(right);
        orders.of(values);
        for (i, right) in rights.iter_mut().enumerate() {
            for (j, &x) in first.iter().enumerate() {
                let m = entry(&matrix, i, j);
                if let Some(id) = m.node.filter(|_| !is_number(orders.g, m)) {
                    let sum = orders.middle([Factor::Of(id), Factor::Unknown(j)]);
                    let newest = orders.of(&[id.into()])[0];
                    let sum = orders.g.plus_product(sum, newest, x);
                    *right = orders.g.minus(*right, sum.scaled(m.k));
                }
            }
        }
        let next = self.solution.solve(orders.g, &rights);
        orders.unknowns = first.into_iter().zip(next).map(|(first, next)| [first, next]).collect();
        let accelerations = orders.unknowns[..self.coordinates].iter().copied().enumerate().collect();
        Motion { accelerations, ..Motion::default() }
    }
}
