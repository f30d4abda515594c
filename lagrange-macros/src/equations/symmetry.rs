//! Symmetries of rotations that are coordinates: which angular momenta are first integrals (Noether 1918)?
//!
//! A rotation R turned further about an axis n of its parent, δR = [n]× R, has the same ω in its own axes; about an
//! axis of its own, δR = R [n]×, it has δω = ω × n. Where L does not change, and forces do no work in such a motion
//! of R alone, its momentum (Rᵀ n)·∂L/∂ω, or n·∂L/∂ω, is constant. All variations are taken at the bindings: of ω and
//! of the axes, of which everything else is made.

use super::assemble::flattened;
use super::formed::Formed;
use crate::graph::{Graph, Symbol, Value};
use crate::model::frames::{Vector, cross};
use crate::model::{Attitude, Model};

/// A constant component of an angular momentum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symmetry {
    /// The rotation, by its place among those of the system.
    pub rotation: usize,
    /// Number of the axis.
    pub axis: usize,
    /// Is it an axis of the turned body, and not of the parent?
    pub own: bool,
}

/// First integrals that are angular momenta, and the angular momentum of each rotation in the axes of its parent.
#[derive(Debug, Default)]
pub struct Symmetries {
    pub found: Vec<Symmetry>,
    /// None of rotations without symmetry.
    pub momenta: Vec<Option<[Value; 3]>>,
}

pub fn symmetries(g: &mut Graph, model: &Model, formed: &Formed) -> Symmetries {
    let mut all = Symmetries::default();
    for (rotation, attitude) in model.attitudes.iter().enumerate() {
        let Some(spin) = attitude.spin else { return all };
        let at = At { model, formed, spin };
        let before = all.found.len();
        for own in [false, true] {
            for axis in 0..3 {
                if at.is_symmetric(g, axis, own) {
                    all.found.push(Symmetry { rotation, axis, own });
                }
            }
        }
        let momenta = (all.found.len() > before).then(|| {
            [0, 1, 2].map(|axis| {
                let faster = Moves::faster(g, &at, axis, false);
                let momentum = at.moved(g, &faster, &[model.lagrangian]);
                flattened(g, &formed.flat, &momentum)[0]
            })
        });
        all.momenta.push(momenta);
    }
    all
}

/// A rotation in its system.
struct At<'a> {
    model: &'a Model,
    formed: &'a Formed,
    /// The bindings that are its ω. Those of its axes follow, by rows.
    spin: [usize; 3],
}

/// Given changes of the bindings of a rotation.
struct Moves {
    spin: Vector,
    axes: [Vector; 3],
}

impl Moves {
    /// It is turned further.
    fn further(g: &mut Graph, at: &At, axis: usize, own: bool) -> Moves {
        let unit = unit(axis);
        let axes = at.axes(g);
        match own {
            false => {
                // Columns of [n]× R: n × each column.
                let columns = [0, 1, 2].map(|k| cross(g, &unit, &axes.map(|row| row[k])));
                Moves { spin: [Value::ZERO; 3], axes: [0, 1, 2].map(|r| columns.map(|c| c[r])) }
            }
            true => {
                let omega = at.spin.map(|k| g.symbol(Symbol::Rate(k)));
                // Rows of R [n]×: each row × n.
                let axes = axes.map(|row| cross(g, &row, &unit));
                Moves { spin: cross(g, &omega, &unit), axes }
            }
        }
    }

    /// It turns faster.
    fn faster(g: &mut Graph, at: &At, axis: usize, own: bool) -> Moves {
        let spin = if own { unit(axis) } else { at.axes(g)[axis] };
        Moves { spin, axes: [[Value::ZERO; 3]; 3] }
    }
}

fn unit(axis: usize) -> Vector {
    std::array::from_fn(|k| if k == axis { Value::ONE } else { Value::ZERO })
}

impl At<'_> {
    fn axes(&self, g: &mut Graph) -> [Vector; 3] {
        [0, 1, 2].map(|r| [0, 1, 2].map(|k| g.symbol(Symbol::Binding(self.axis(r, k)))))
    }

    /// The binding of a component of the axes.
    fn axis(&self, row: usize, k: usize) -> usize {
        self.spin[2] + 1 + 3 * row + k
    }

    /// How values change with the bindings of the rotation, and with all that is made of them.
    fn moved(&self, g: &mut Graph, moves: &Moves, values: &[Value]) -> Vec<Value> {
        let count = self.model.bindings.len();
        let (mut places, mut rates) = (vec![Value::ZERO; count], vec![Value::ZERO; count]);
        let change = |g: &mut Graph, places: &[Value], rates: &[Value], values: &[Value]| {
            g.forward(values, |s| match s {
                Symbol::Binding(k) => Some(places[k]).filter(|x| !x.is_zero()),
                Symbol::Rate(k) => Some(rates[k]).filter(|x| !x.is_zero()),
                _ => None,
            })
        };
        for (k, binding) in self.model.bindings.iter().enumerate() {
            if let Some(i) = self.spin.iter().position(|own| *own == k) {
                rates[k] = moves.spin[i];
                continue;
            }
            let changes = change(g, &places, &rates, &[binding.value, binding.rate]);
            let own = (0..9).find(|i| self.axis(i / 3, i % 3) == k);
            places[k] = own.map_or(changes[0], |i| moves.axes[i / 3][i % 3]);
            rates[k] = changes[1];
        }
        change(g, &places, &rates, values)
    }

    fn is_symmetric(&self, g: &mut Graph, axis: usize, own: bool) -> bool {
        let Model { lagrangian, dissipation, forces, frame_forces, constraints, .. } = self.model;
        let [further, faster] = [Moves::further, Moves::faster]
            .map(|moves: fn(&mut Graph, &At, usize, bool) -> Moves| moves(g, self, axis, own));
        let held: Vec<Value> = constraints.iter().map(|c| c.value).collect();
        let mut still: Vec<Value> = vec![*lagrangian];
        still.extend(&held);
        let mut zero = self.moved(g, &further, &still);
        let mut work = Value::ZERO;
        let mut does = |g: &mut Graph, moves: &Moves, pairs: &[(Value, Value)]| {
            for (force, place) in pairs {
                let along = self.moved(g, moves, &[*place])[0];
                let product = g.mul(*force, along);
                work = g.add(work, product);
            }
        };
        does(g, &further, forces);
        does(g, &faster, frame_forces);
        let mut idle = vec![*dissipation];
        idle.extend(&held);
        zero.extend(self.moved(g, &faster, &idle));
        zero.push(work);
        zero.into_iter().all(|v| self.vanishes(g, v))
    }

    /// Is this 0, by multiplying out, or as a rational function of the parameters of the attitude? (That axes are
    /// orthonormal is not seen at the bindings.)
    fn vanishes(&self, g: &mut Graph, v: Value) -> bool {
        if g.vanishes(v) {
            return true;
        }
        let flat = flattened(g, &self.formed.flat, &[v]);
        g.vanishes_as_rational(flat[0])
    }
}

/// The name of the output that is the angular momentum of a rotation.
pub fn name(attitude: &Attitude) -> String {
    format!("angular_momentum_{}", attitude.name)
}
