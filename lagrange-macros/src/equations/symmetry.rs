//! Symmetries of rotations that are coordinates: which angular momenta are first integrals (Noether 1918)?
//!
//! A rotation R turned further about an axis n of its parent, δR = [n]× R, has the same ω in its own axes; about an
//! axis of its own, δR = R [n]×, it has δω = ω × n. Where L does not change, and forces do no work in such a motion
//! of R alone, its momentum (Rᵀ n)·∂L/∂ω, or n·∂L/∂ω, is constant. All variations are taken at the bindings: of ω and
//! of the axes, of which everything else is made.
//!
//! Several rotations, directions and positions may turn together (a satellite on its orbit). Variations add up, so a
//! set of them is a symmetry where the changes of its parts have the sum 0: such sets are the vectors of zeros and
//! ones in the null space of the changes as functions of the state. They are found by values in a finite field, and
//! each is proved as those of one rotation are.

use super::assemble::flattened;
use super::formed::Formed;
use crate::graph::{Graph, Symbol, Value};
use crate::model::attitude::axes;
use crate::model::frames::{Vector, cross};
use crate::model::{Attitude, Model};
use crate::syntax::Kind;

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
    /// Symmetries of what turns together, about axes of the world.
    pub common: Vec<CommonSymmetry>,
}

/// A constant component of the angular momentum of what turns together.
#[derive(Debug)]
pub struct CommonSymmetry {
    /// First coordinates of the rotations, directions and positions.
    pub turned: Vec<usize>,
    /// Number of the axis.
    pub axis: usize,
    pub momentum: Value,
}

pub fn symmetries(g: &mut Graph, model: &Model, formed: &Formed) -> Symmetries {
    let mut all = Symmetries::default();
    for (rotation, attitude) in model.attitudes.iter().enumerate() {
        let Some(spin) = attitude.spin else { return all };
        let at = At { model, formed, part: Part::Rotation(spin) };
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
    all.common = common(g, model, formed);
    all
}

/// Finds the sets of rotations, directions and positions whose common turn about an axis of the world is a symmetry.
fn common(g: &mut Graph, model: &Model, formed: &Formed) -> Vec<CommonSymmetry> {
    let mut parts: Vec<(usize, At)> = Vec::new();
    for attitude in &model.attitudes {
        let Some(spin) = attitude.spin else { return Vec::new() };
        parts.push((attitude.first, At { model, formed, part: Part::Rotation(spin) }));
    }
    let rotations = parts.len();
    let points = points(model);
    if rotations == 0 && points.iter().all(|first| model.coordinates[*first].kind != Kind::Direction) {
        return Vec::new();
    }
    parts.extend(points.into_iter().map(|first| (first, At { model, formed, part: Part::Point(first) })));
    let mut found = Vec::new();
    for axis in 0..3 {
        let changes: Vec<Vec<Value>> = parts
            .iter()
            .map(|(_, at)| {
                let changes = at.changes(g, axis, false);
                flattened(g, &formed.flat, &changes)
            })
            .collect();
        for set in g.vanishing_sets(&changes) {
            // Those of a rotation alone are known.
            if set.len() == 1 && set[0] < rotations {
                continue;
            }
            let is_zero = (0..changes[0].len()).all(|k| {
                let sum = set.iter().fold(Value::ZERO, |sum, part| g.add(sum, changes[*part][k]));
                g.vanishes(sum) || g.vanishes_as_rational(sum)
            });
            if is_zero {
                let momentum = set.iter().fold(Value::ZERO, |sum, part| {
                    let at = &parts[*part].1;
                    let faster = Moves::faster(g, at, axis, false);
                    let momentum = at.moved(g, &faster, &[model.lagrangian]);
                    let momentum = flattened(g, &formed.flat, &momentum)[0];
                    g.add(sum, momentum)
                });
                let mut turned: Vec<usize> = set.into_iter().map(|part| parts[part].0).collect();
                turned.sort_unstable();
                found.push(CommonSymmetry { turned, axis, momentum });
            }
        }
    }
    found
}

/// First coordinates of directions, and of positions, which are arrays of three.
fn points(model: &Model) -> Vec<usize> {
    let is_point = |first: usize| {
        let c = &model.coordinates[first];
        let of_name = || model.coordinates.iter().filter(|other| other.name == c.name).count();
        match c.kind {
            Kind::Rotation | Kind::Angle => false,
            Kind::Direction => c.part == Some(0),
            _ => c.index == Some(0) && of_name() == 3,
        }
    };
    (0..model.mechanical()).filter(|first| is_point(*first)).collect()
}

/// A part of a system that turns.
struct At<'a> {
    model: &'a Model,
    formed: &'a Formed,
    part: Part,
}

enum Part {
    /// A rotation, by the bindings that are its ω. Those of its axes follow, by rows.
    Rotation([usize; 3]),
    /// Three components in the axes of the world, by the first coordinate.
    Point(usize),
}

/// Given changes of symbols: of velocities and axes of a rotation, or of the components of a point.
struct Moves(Vec<(Symbol, Value)>);

impl Moves {
    fn of(&self, symbol: Symbol) -> Option<Value> {
        self.0.iter().find(|(moved, _)| *moved == symbol).map(|(_, change)| *change)
    }

    /// It is turned further.
    fn further(g: &mut Graph, at: &At, axis: usize, own: bool) -> Moves {
        let unit = unit(axis);
        let moved = |symbols: [Symbol; 3], v: Vector| symbols.into_iter().zip(v);
        let spin = match at.part {
            Part::Rotation(spin) => spin,
            Part::Point(first) => {
                let all = components(first).into_iter().flat_map(|symbols| {
                    let v = symbols.map(|s| g.symbol(s));
                    moved(symbols, cross(g, &unit, &v))
                });
                return Moves(all.collect());
            }
        };
        let rows = axes(spin);
        let at_rows = rows.map(|row| row.map(|s| g.symbol(s)));
        if !own {
            // Columns of [n]× R: n × each column.
            let columns = [0, 1, 2].map(|k| cross(g, &unit, &at_rows.map(|row| row[k])));
            let turned = [0, 1, 2].map(|r| columns.map(|c| c[r]));
            let still = moved(spin.map(Symbol::Rate), [Value::ZERO; 3]);
            return Moves(
                still.chain(rows.into_iter().zip(turned).flat_map(|(row, v)| moved(row, v))).collect(),
            );
        }
        let omega = spin.map(|k| g.symbol(Symbol::Rate(k)));
        let mut all: Vec<_> = moved(spin.map(Symbol::Rate), cross(g, &omega, &unit)).collect();
        for (row, v) in rows.into_iter().zip(at_rows) {
            // Rows of R [n]×: each row × n.
            all.extend(moved(row, cross(g, &v, &unit)));
        }
        Moves(all)
    }

    /// It turns faster.
    fn faster(g: &mut Graph, at: &At, axis: usize, own: bool) -> Moves {
        let (symbols, v) = match at.part {
            Part::Rotation(spin) if own => (spin.map(Symbol::Rate), unit(axis)),
            Part::Rotation(spin) => (spin.map(Symbol::Rate), axes(spin)[axis].map(|s| g.symbol(s))),
            Part::Point(first) => {
                let [places, rates] = components(first);
                let place = places.map(|s| g.symbol(s));
                (rates, cross(g, &unit(axis), &place))
            }
        };
        let mut all: Vec<_> = symbols.into_iter().zip(v).collect();
        if let Part::Rotation(spin) = at.part {
            all.extend(axes(spin).into_iter().flatten().map(|s| (s, Value::ZERO)));
        }
        Moves(all)
    }
}

fn unit(axis: usize) -> Vector {
    std::array::from_fn(|k| if k == axis { Value::ONE } else { Value::ZERO })
}

/// The components of a point, and their rates.
fn components(first: usize) -> [[Symbol; 3]; 2] {
    let all = [first, first + 1, first + 2];
    [all.map(Symbol::Coordinate), all.map(Symbol::Velocity)]
}

impl At<'_> {
    /// Changes of values with what is moved, and with all that is made of it.
    fn moved(&self, g: &mut Graph, moves: &Moves, values: &[Value]) -> Vec<Value> {
        let count = self.model.bindings.len();
        let (mut places, mut rates) = (vec![Value::ZERO; count], vec![Value::ZERO; count]);
        let change = |g: &mut Graph, places: &[Value], rates: &[Value], values: &[Value]| {
            g.forward(values, |s| match s {
                Symbol::Binding(k) => Some(places[k]).filter(|x| !x.is_zero()),
                Symbol::Rate(k) => Some(rates[k]).filter(|x| !x.is_zero()),
                other => moves.of(other),
            })
        };
        for (k, binding) in self.model.bindings.iter().enumerate() {
            let changes = change(g, &places, &rates, &[binding.value, binding.rate]);
            places[k] = moves.of(Symbol::Binding(k)).unwrap_or(changes[0]);
            rates[k] = moves.of(Symbol::Rate(k)).unwrap_or(changes[1]);
        }
        change(g, &places, &rates, values)
    }

    /// Changes that vanish if turning this part is a symmetry: of L and the constraints as it is turned further, of
    /// the dissipation and the constraints as it turns faster, and the work of forces.
    fn changes(&self, g: &mut Graph, axis: usize, own: bool) -> Vec<Value> {
        let Model { lagrangian, dissipation, applied, forces, frame_forces, constraints, .. } = self.model;
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
        if let Part::Point(first) = self.part {
            for k in 0..3 {
                let along = further.of(Symbol::Coordinate(first + k)).unwrap_or(Value::ZERO);
                let product = g.mul(applied[first + k], along);
                work = g.add(work, product);
            }
        }
        let mut idle = vec![*dissipation];
        idle.extend(&held);
        zero.extend(self.moved(g, &faster, &idle));
        zero.push(work);
        zero
    }

    fn is_symmetric(&self, g: &mut Graph, axis: usize, own: bool) -> bool {
        self.changes(g, axis, own).into_iter().all(|v| self.vanishes(g, v))
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

/// The name of the output that is the angular momenta of what turns together.
pub const COMMON: &str = "common_angular_momenta";

/// The name of the output that is the angular momentum of a rotation.
pub fn name(attitude: &Attitude) -> String {
    format!("angular_momentum_{}", attitude.name)
}
