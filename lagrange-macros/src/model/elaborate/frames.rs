//! Frames and bodies: rotations and frames as values, and the bindings that they make.

mod attitudes;
mod bodies;
mod rotations;

use super::*;
use crate::model::frames::{
    Frames, IDENTITY, Matrix, Motion, Point, Vector, cross, inner, plus, turned, turned_back,
};
pub(super) use attitudes::fixed;
pub(super) use rotations::ROTATIONS;

/// The words of this file; names of the user come first.
pub(super) const FUNCTIONS: [&str; 5] = ["frame", "body", "particle", "velocity", "angular_velocity"];
const METHODS: [&str; 5] = ["point", "vector", "origin", "velocity", "angular_velocity"];

/// The frames and points in space that a system has made.
pub(in crate::model) struct Space {
    axes: Vec<Axes>,
    points: Vec<Fixed>,
    spins: Vec<[Option<usize>; 3]>,
    /// The rotations that are coordinates.
    attitudes: Vec<Turn>,
    /// Velocities of points in axes: point, axes, bindings.
    velocities: Vec<(usize, usize, [usize; 3])>,
}

/// An orientation.
struct Axes {
    parent: usize,
    /// Rotation of the frame in its parent: x_parent = R x.
    turn: Matrix,
    /// Its angular velocity, in own axes.
    omega: Vector,
    spin: Option<usize>,
    /// Components of the axes in the world, by rows, where they have been asked for.
    rows: [Option<Vector>; 3],
}

/// A point at an offset from another one.
struct Fixed {
    base: usize,
    axes: usize,
    offset: Vector,
    /// Does it never move?
    still: bool,
    /// Is its base a point that never moves?
    first: bool,
    /// Its coordinates in the world, where they have been asked for, with their bindings.
    place: [Option<(Value, Option<usize>)>; 3],
}

impl Default for Space {
    fn default() -> Space {
        let world =
            Axes { parent: 0, turn: IDENTITY, omega: [Value::ZERO; 3], spin: None, rows: IDENTITY.map(Some) };
        let origin = Fixed {
            base: 0,
            axes: 0,
            offset: [Value::ZERO; 3],
            still: true,
            first: false,
            place: [Some((Value::ZERO, None)); 3],
        };
        Space {
            axes: vec![world],
            points: vec![origin],
            spins: Vec::new(),
            attitudes: Vec::new(),
            velocities: Vec::new(),
        }
    }
}

impl Space {
    /// The data of the frame that the equations need.
    pub(in crate::model) fn frames(self) -> Frames {
        let Space { axes, points, spins, velocities, .. } = self;
        let point = |(point, at, velocity): (usize, usize, [usize; 3])| {
            let own = points[point].axes == at;
            Point {
                spin: axes[at].spin,
                velocity,
                place: points[point].place.map(|place| place.filter(|_| own).and_then(|p| p.1)),
                axes: axes[at].rows,
                first: own && points[point].first,
            }
        };
        Frames { spins, points: velocities.into_iter().map(point).collect() }
    }
}

impl Elaborator<'_> {
    /// `frame(parent, [x, y, z], rotation)`; in the plane `frame(parent, [x, y], angle)`.
    pub(super) fn frame(&mut self, arguments: Vec<Val>, call: &syn::ExprCall) -> Result {
        let given = arguments.len();
        if !(2..=3).contains(&given) {
            let message = format!(
                "`frame` takes a parent, a point and a rotation, not {}\nhelp: write `frame(world, [x, y, z], rotation_z(psi))`, or in the plane `frame(world, [x, y], theta)`",
                counted(given, "argument")
            );
            return Err(self.errors.push(&call.func, message));
        }
        let mut arguments = arguments.into_iter();
        let mut next = || arguments.next().unwrap_or(Val::Int(0));
        let (parent, at) = (next(), next());
        let parent = self.a_frame(parent, &call.args[0])?;
        let at = self.components(at, &call.args[1])?;
        self.independent_of_states(&at, "the place of a frame", &call.args[1])?;
        if self.graph.depends(&at, |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_))) {
            let message = "the place of a frame depends on velocities\nhelp: it is a point of its parent, such as `[x, 0, 0]`";
            return Err(self.errors.push(&call.args[1], message));
        }
        let rotation = (given == 3).then(|| (next(), &call.args[2]));
        match (parent, at.as_slice()) {
            (Frame::World | Frame::Plane { .. }, &[x, y]) => self.plane_frame(&parent, [x, y], rotation),
            (Frame::World, &[x, y, z]) => self.space_frame(0, 0, [x, y, z], rotation),
            (Frame::Space { origin, axes }, &[x, y, z]) => {
                self.space_frame(origin, axes, [x, y, z], rotation)
            }
            _ => {
                let message = format!(
                    "the place of a frame in {} has {}, not {}\nhelp: a point of the plane is `[x, y]`, one of space `[x, y, z]`",
                    match parent {
                        Frame::World => "the world",
                        Frame::Plane { .. } => "the plane",
                        Frame::Space { .. } => "space",
                    },
                    match parent {
                        Frame::World => "2 or 3 coordinates".into(),
                        Frame::Plane { .. } => counted(2, "coordinate"),
                        Frame::Space { .. } => counted(3, "coordinate"),
                    },
                    at.len()
                );
                Err(self.errors.push(&call.args[1], message))
            }
        }
    }

    pub(super) fn a_frame(&mut self, val: Val, at: impl ToTokens) -> Result<Frame> {
        match val {
            Val::Frame(frame) => Ok(frame),
            other => {
                let message = format!(
                    "expected a frame, found {}\nhelp: frames are `world` and what `frame(parent, [x, y, z], rotation)` makes",
                    other.kind()
                );
                Err(self.errors.push(at, message))
            }
        }
    }

    /// The numbers of an array.
    fn components(&mut self, val: Val, at: impl ToTokens + Copy) -> Result<Vec<Value>> {
        match val {
            Val::Array(items) => items.into_iter().map(|item| self.number(item, at)).collect(),
            other => {
                let message = format!(
                    "expected the components of a vector, found {}\nhelp: write `[x, y, z]`, or `[x, y]` in the plane",
                    other.kind()
                );
                Err(self.errors.push(at, message))
            }
        }
    }

    /// Three components.
    pub(super) fn vector(&mut self, val: Val, at: impl ToTokens + Copy) -> Result<Vector> {
        let components = self.components(val, at)?;
        <Vector>::try_from(components).map_err(|other| {
            let message =
                format!("a vector in space has 3 components, not {}\nhelp: write `[x, y, z]`", other.len());
            self.errors.push(at, message)
        })
    }

    fn space_frame(
        &mut self,
        origin: usize,
        mut axes: usize,
        at: Vector,
        rotation: Option<(Val, &Expr)>,
    ) -> Result {
        let origin = self.point(origin, axes, at);
        if let Some((rotation, at)) = rotation {
            let Val::Rotation(turns) = rotation else {
                let message = format!(
                    "expected a rotation, found {}\nhelp: rotations are `rotation_x(a)`, `rotation_y(a)`, `rotation_z(a)`, `rotation([x, y, z], a)`, coordinates `R: rotation`, and products of them",
                    rotation.kind()
                );
                return Err(self.errors.push(at, message));
            };
            for turn in rotations::merged(&mut self.graph, &turns) {
                axes = self.turned_axes(axes, &turn);
            }
        }
        Ok(Val::Frame(Frame::Space { origin, axes }))
    }

    /// A binding that belongs to a frame.
    fn carried(&mut self, name: String, value: Value, rate: Value, motion: Motion) -> usize {
        let k = self.found.bindings.len();
        self.found.bindings.push(Binding { name, value, rate, motion });
        self.graph.symbol(Symbol::Binding(k));
        self.graph.symbol(Symbol::Rate(k));
        k
    }

    fn rate_of(&mut self, k: usize) -> Value {
        self.graph.symbol(Symbol::Rate(k))
    }

    /// Prefix of the names of bindings of the frame that is being defined.
    fn frame_name(&self) -> String {
        self.naming.clone().unwrap_or_else(|| "frame".into())
    }

    /// Axes turned in others: ω = Rᵀ ωₚ + n θ̇, whose rate at rest of accelerations is ω × n θ̇ + n θ̈. (A free
    /// relative angular velocity is an unknown itself, in the place of n θ̇.)
    fn turned_axes(&mut self, parent: usize, turn: &Turn) -> usize {
        let before = self.space.axes[parent].omega;
        let mut psi = turned_back(&mut self.graph, &turn.matrix, &before);
        let mut relative = [Value::ZERO; 3];
        let mut drift = [Value::ZERO; 3];
        if let Some(spin) = turn.spin {
            relative = self.relative(&spin);
            if let Spin::About(axis, angle) = spin {
                let rate = self.velocity(angle);
                let second = self.rate(rate);
                drift = axis.map(|n| self.graph.mul(n, second));
            }
            psi = plus(&mut self.graph, &psi, &relative);
        }
        // That of a coordinate in a parent at rest has its bindings.
        if let (Some(Spin::Free(_)), Some(spin)) = (&turn.spin, self.known_spin(&psi)) {
            let (turn, spin) = (turn.matrix, Some(spin));
            self.space.axes.push(Axes { parent, turn, omega: psi, spin, rows: [None; 3] });
            return self.space.axes.len() - 1;
        }
        let name = self.frame_name();
        let spin: [Option<usize>; 3] = std::array::from_fn(|i| {
            let quasi = Motion::Quasi(Value::ZERO);
            (!psi[i].is_zero())
                .then(|| self.carried(format!("{name}_omega[{i}]"), Value::ZERO, psi[i], quasi))
        });
        let omega = spin.map(|k| k.map_or(Value::ZERO, |k| self.rate_of(k)));
        let turning = cross(&mut self.graph, &omega, &relative);
        let gamma = plus(&mut self.graph, &turning, &drift);
        for (k, gamma) in spin.iter().zip(gamma) {
            if let Some(k) = *k {
                self.found.bindings[k].motion = Motion::Quasi(gamma);
            }
        }
        let moves = spin.iter().any(Option::is_some);
        let spin = moves.then(|| {
            self.space.spins.push(spin);
            self.space.spins.len() - 1
        });
        self.space.axes.push(Axes { parent, turn: turn.matrix, omega, spin, rows: [None; 3] });
        self.space.axes.len() - 1
    }

    /// The point at an offset from another, in these axes.
    fn point(&mut self, base: usize, axes: usize, offset: Vector) -> usize {
        if offset.iter().all(|r| r.is_zero()) {
            return base;
        }
        let known = |p: &Fixed| p.base == base && p.axes == axes && p.offset == offset;
        if let Some(known) = self.space.points.iter().position(known) {
            return known;
        }
        let before = self.velocity_in(base, axes);
        let omega = self.space.axes[axes].omega;
        let rates = offset.map(|r| self.velocity(r));
        let turning = cross(&mut self.graph, &omega, &offset);
        // What it adds to the velocity, ω × r + ṙ, and to the acceleration, ω × (ω × r + ṙ) + ω × ṙ + r̈.
        let relative = plus(&mut self.graph, &turning, &rates);
        let still = before.is_none() && relative.iter().all(|v| v.is_zero());
        let point = self.space.points.len();
        let first = before.is_none();
        self.space.points.push(Fixed { base, axes, offset, still, first, place: [None; 3] });
        if still {
            return point;
        }
        let velocity = plus(&mut self.graph, &before.unwrap_or([Value::ZERO; 3]), &relative);
        let [a, b] = [relative, rates].map(|v| cross(&mut self.graph, &omega, &v));
        let second = rates.map(|r| self.rate(r));
        let gamma = plus(&mut self.graph, &a, &b);
        let gamma = plus(&mut self.graph, &gamma, &second);
        self.moving(point, axes, velocity, gamma);
        point
    }

    /// Bindings for the velocity of a point in these axes.
    fn moving(&mut self, point: usize, axes: usize, velocity: Vector, gamma: Vector) -> Vector {
        let name = self.frame_name();
        let bindings: [usize; 3] = std::array::from_fn(|i| {
            let quasi = Motion::Quasi(gamma[i]);
            self.carried(format!("{name}_v[{i}]"), Value::ZERO, velocity[i], quasi)
        });
        self.space.velocities.push((point, axes, bindings));
        bindings.map(|k| self.rate_of(k))
    }

    /// The velocity of a point in axes that descend from its own; none if it never moves.
    fn velocity_in(&mut self, point: usize, axes: usize) -> Option<Vector> {
        if self.space.points[point].still {
            return None;
        }
        let known = |(p, a, _): &&(usize, usize, _)| *p == point && *a == axes;
        if let Some(&(_, _, bindings)) = self.space.velocities.iter().find(known) {
            return Some(bindings.map(|k| self.rate_of(k)));
        }
        let Axes { parent, turn, .. } = self.space.axes[axes];
        let before = self.velocity_in(point, parent)?;
        let velocity = turned_back(&mut self.graph, &turn, &before);
        Some(self.moving(point, axes, velocity, [Value::ZERO; 3]))
    }

    /// Component i in the world of each of the axes: Rᵢ = Rₚᵢ Rᵣ, Ṙᵢ = Rᵢ [ω]×.
    fn row(&mut self, axes: usize, i: usize) -> Vector {
        if let Some(row) = self.space.axes[axes].rows[i] {
            return row;
        }
        let Axes { parent, turn, omega, .. } = self.space.axes[axes];
        let before = self.row(parent, i);
        let values = turned_back(&mut self.graph, &turn, &before);
        let simple = |g: &Graph, v: Value| g.symbols(&[v]).len() <= 1;
        let row = if values.iter().all(|v| simple(&self.graph, *v)) {
            values
        } else {
            let name = self.frame_name();
            let rates = cross(&mut self.graph, &values, &omega);
            let bindings: [usize; 3] = std::array::from_fn(|j| {
                self.carried(format!("{name}_axes[{i}][{j}]"), values[j], rates[j], Motion::Carried)
            });
            bindings.map(|k| self.graph.symbol(Symbol::Binding(k)))
        };
        self.space.axes[axes].rows[i] = Some(row);
        row
    }

    /// Coordinate i in the world of a point: pᵢ = p₀ᵢ + Rᵢ r, ṗᵢ = Rᵢ v.
    fn place(&mut self, point: usize, i: usize) -> Value {
        if let Some((place, _)) = self.space.points[point].place[i] {
            return place;
        }
        let Fixed { base, axes, offset, still, .. } = self.space.points[point];
        let before = self.place(base, i);
        let row = self.row(axes, i);
        let along = inner(&mut self.graph, &row, &offset);
        let value = self.graph.add(before, along);
        let place = match self.velocity_in(point, axes).filter(|_| !still) {
            None => (value, None),
            Some(velocity) => {
                let rate = inner(&mut self.graph, &row, &velocity);
                let name = format!("{}_point[{i}]", self.frame_name());
                let k = self.carried(name, value, rate, Motion::Carried);
                (self.graph.symbol(Symbol::Binding(k)), Some(k))
            }
        };
        self.space.points[point].place[i] = Some(place);
        place.0
    }
}
