//! Rigid bodies on frames, in space and in the plane, in all words that the language has for them.
//!
//! What they amount to is written without angular velocities and quasi-velocities: the axes eⱼ of each frame by their
//! components in the world, products of rotations that are followed from frame to frame. With K = ½ tr(I) 1 − I of a
//! body,
//!
//!   T = ½ m |ṗ|² + ½ Σ Kᵢⱼ ėᵢ·ėⱼ,  ωᵢ = eₖ·ėⱼ for (i, j, k) cyclic,  vᵢ = eᵢ·ṗ
//!
//! and a couple M is the forces Mᵢ eₖ at "places" eⱼ, since δω is ω with δeⱼ for ėⱼ.

use super::*;

type Vector = [Expr; 3];
/// Matrix by rows: entry (i, j) is component i of axis j.
type Matrix = [Vector; 3];

/// A frame, called `name`.
#[derive(Clone)]
struct Link {
    name: String,
    origin: Vector,
    axes: Matrix,
    /// Do the coordinates move its origin, and turn it?
    travels: bool,
    turns: bool,
}

/// Text that has been written, and its meaning.
struct Scene<'r> {
    random: &'r mut Random,
    /// Free coordinates of the whole scene; prescribed ones follow them.
    all: usize,
    /// Number of coordinates so far.
    coordinates: usize,
    parameters: usize,
    prescribed: Vec<Expr>,
    bindings: Vec<Expr>,
    links: Vec<Link>,
    statements: Vec<String>,
    said: Vec<Expr>,
    kinetic: Vec<(String, Expr)>,
    potential: Vec<(String, Expr)>,
    plane: bool,
    /// May anything move by itself?
    timed: bool,
    /// The first coordinate is to be ignorable.
    ignorable: bool,
    choices: bool,
    /// Are all frames there? Then nothing moves by further coordinates.
    built: bool,
}

/// Coordinates, but for those that a scene needs.
const MOST: usize = 7;

pub(super) fn bodies(random: &mut Random) -> System {
    // Prescribed coordinates follow the free ones, whose number is known in the end.
    let all = scene(&mut random.clone(), 0).coordinates;
    scene(random, all)
}

fn constant(k: i32) -> Expr {
    Expr::Constant(k)
}

fn half() -> Expr {
    constant(4)
}

fn is(e: &Expr, k: i32) -> bool {
    matches!(e, Expr::Constant(c) if *c == k)
}

fn sum(terms: impl IntoIterator<Item = Expr>) -> Expr {
    terms.into_iter().filter(|e| !is(e, 0)).reduce(|a, b| a + b).unwrap_or(constant(0))
}

fn product(a: &Expr, b: &Expr) -> Expr {
    match (a, b) {
        (a, b) if is(a, 0) || is(b, 0) => constant(0),
        (a, b) if is(a, 8) => b.clone(),
        (a, b) if is(b, 8) => a.clone(),
        (a, b) => a.clone() * b.clone(),
    }
}

fn inner(a: &Vector, b: &Vector) -> Expr {
    sum(a.iter().zip(b).map(|(a, b)| product(a, b)))
}

fn column(m: &Matrix, j: usize) -> Vector {
    m.each_ref().map(|row| row[j].clone())
}

fn rates(v: &Vector) -> Vector {
    v.each_ref().map(|x| match x {
        Expr::Constant(_) => constant(0),
        x => x.clone().rate(),
    })
}

fn square(v: &Vector) -> Expr {
    sum(v.iter().filter(|x| !is(x, 0)).map(|x| x.clone().power(2)))
}

fn identity() -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| constant(8 * i32::from(i == j))))
}

impl Scene<'_> {
    fn bind(&mut self, value: Expr) -> Expr {
        match value {
            Expr::Constant(_) | Expr::Parameter(_) | Expr::Position(_) | Expr::Time | Expr::Binding(_) => {
                value
            }
            value => {
                self.bindings.push(value);
                Expr::Binding(self.bindings.len() - 1)
            }
        }
    }

    fn multiplied(&mut self, a: &Matrix, b: &Matrix) -> Matrix {
        std::array::from_fn(|i| std::array::from_fn(|j| self.bind(inner(&a[i], &column(b, j)))))
    }

    /// A place for an expression in a statement.
    fn say(&mut self, e: &Expr) -> String {
        self.said.push(e.clone());
        format!("«{}»", self.said.len() - 1)
    }

    /// A list of as many components as there are dimensions.
    fn list(&mut self, v: &Vector) -> String {
        let v = &v[..self.dimensions()];
        let parts: Vec<String> = v.iter().map(|x| self.say(x)).collect();
        format!("[{}]", parts.join(", "))
    }

    fn unit(&mut self, unit: Unit) -> String {
        self.say(&Expr::Unit(unit))
    }

    fn dimensions(&self) -> usize {
        if self.plane { 2 } else { 3 }
    }

    fn axis(&mut self) -> usize {
        self.random.below(self.dimensions())
    }

    /// A mass, a moment, a stiffness.
    fn size(&mut self) -> Expr {
        match self.random.once_in(2) {
            true => constant(2 + self.random.below(15) as i32),
            false => Expr::Parameter(self.random.below(self.parameters)),
        }
    }

    /// A vector of numbers and parameters.
    fn arm(&mut self) -> Vector {
        let dimensions = self.dimensions();
        std::array::from_fn(|i| match self.random.below(5) {
            _ if i >= dimensions => constant(0),
            0 => constant(0),
            1 => Expr::Parameter(self.random.below(self.parameters)),
            _ => constant(self.random.below(17) as i32 - 8),
        })
    }

    /// One of the coordinates that are not to be ignorable, if there is any.
    fn known(&mut self) -> Option<Expr> {
        let first = usize::from(self.ignorable);
        (self.coordinates > first)
            .then(|| Expr::Position(first + self.random.below(self.coordinates - first)))
    }

    fn fresh(&mut self) -> Expr {
        self.coordinates += 1;
        Expr::Position(self.coordinates - 1)
    }

    /// A prescribed coordinate.
    fn given(&mut self) -> Expr {
        if self.prescribed.is_empty() || self.random.once_in(3) {
            let turning = Expr::Parameter(self.random.below(self.parameters)) * Expr::Time;
            let swinging = constant(4) * turning.clone().call(Call::Sin);
            self.prescribed.push(if self.random.once_in(2) { turning } else { swinging });
        }
        Expr::Position(self.all + self.random.below(self.prescribed.len()))
    }

    /// An angle or a displacement; does a coordinate move it?
    fn motion(&mut self) -> (Expr, bool) {
        let full = self.built || self.coordinates >= MOST;
        let known = self.known();
        match (self.random.below(12), known) {
            (0, _) if self.timed => (Expr::Parameter(self.random.below(self.parameters)) * Expr::Time, false),
            (1, _) if self.timed => (self.given(), false),
            (2, _) if self.timed && !full => (self.fresh() + constant(4) * Expr::Time, true),
            (3, _) => (constant(1 + self.random.below(12) as i32), false),
            (4, Some(known)) => (known.call(Call::Sin), true),
            (5, Some(known)) if !full => (self.fresh() + known, true),
            (6, _) if !full => (constant(-8) * self.fresh(), true),
            (7, _) if !full => {
                let x = self.fresh();
                (constant(2) * x.clone().power(2) + x, true)
            }
            (_, Some(known)) if full => (half() * known, true),
            _ => (self.fresh(), true),
        }
    }

    /// A rotation, with its matrix, and whether coordinates turn it.
    fn rotation(&mut self, deep: bool) -> (String, Matrix, bool) {
        match self.random.below(9) {
            0 => {
                // A unit quaternion (cos a/2, n sin a/2).
                let axis = match self.random.below(3) {
                    0 => [Expr::Parameter(self.random.below(self.parameters)), constant(8), constant(-4)],
                    1 => [8, 16, 16].map(constant),
                    _ => [constant(0), constant(24), self.size()],
                };
                let (angle, turns) = self.motion();
                let word = format!("rotation({}, {})", self.list(&axis), self.say(&angle));
                let halved = half() * angle;
                let norm = self.bind(square(&axis).call(Call::Sqrt));
                let (w, s) = (self.bind(halved.clone().call(Call::Cos)), self.bind(halved.call(Call::Sin)));
                let u = axis.map(|n| self.bind(product(&s, &n.over(norm.clone()))));
                // x ↦ (w² − u²) x + 2 (u·x) u + 2 w u × x
                let spread = self.bind(w.clone().power(2) - square(&u));
                let matrix = std::array::from_fn(|i| {
                    std::array::from_fn(|j| {
                        let twice = constant(16) * u[i].clone() * u[j].clone();
                        if i == j {
                            return self.bind(spread.clone() + twice);
                        }
                        let sign = if (i + 1) % 3 == j { -16 } else { 16 };
                        self.bind(twice + constant(sign) * w.clone() * u[3 - i - j].clone())
                    })
                });
                (word, matrix, turns)
            }
            1 => {
                let fifth = |k: i32| constant(8 * k).over(constant(40));
                let third = |k: i32| constant(8 * k).over(constant(24));
                let matrix: Matrix = match self.random.below(3) {
                    0 => [[0, 0, 8], [8, 0, 0], [0, 8, 0]].map(|row| row.map(constant)),
                    1 => [
                        [fifth(3), constant(0), fifth(4)],
                        [constant(0), constant(-8), constant(0)],
                        [fifth(4), constant(0), fifth(-3)],
                    ],
                    _ => [[2, -1, 2], [2, 2, -1], [-1, 2, 2]].map(|row| row.map(third)),
                };
                let rows: Vec<String> = matrix.iter().map(|row| self.list(row)).collect();
                (format!("rotation([{}])", rows.join(", ")), matrix, false)
            }
            2 if deep => {
                let count = 1 + self.random.below(2);
                let (word, matrix, turns) = self.rotations(count);
                let reversed = std::array::from_fn(|i| column(&matrix, i));
                (format!("({word}).inverse()"), reversed, turns)
            }
            _ => {
                let axis = self.random.below(3);
                let (angle, turns) = self.motion();
                let word = format!("rotation_{}({})", ["x", "y", "z"][axis], self.say(&angle));
                (word, self.about(axis, angle), turns)
            }
        }
    }

    /// About an axis of coordinates.
    fn about(&mut self, axis: usize, angle: Expr) -> Matrix {
        let (s, c) = (self.bind(angle.clone().call(Call::Sin)), self.bind(angle.call(Call::Cos)));
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut matrix = identity();
        (matrix[j][j], matrix[k][k]) = (c.clone(), c);
        (matrix[j][k], matrix[k][j]) = (constant(-8) * s.clone(), s);
        matrix
    }

    fn rotations(&mut self, count: usize) -> (String, Matrix, bool) {
        let (mut words, mut matrix, mut turns) = (Vec::new(), identity(), false);
        for _ in 0..count {
            let (word, next, turning) = self.rotation(count > 1);
            words.push(word);
            matrix = self.multiplied(&matrix, &next);
            turns |= turning;
        }
        (words.join(" * "), matrix, turns)
    }

    /// The point at `arm` in a frame, in the world.
    fn inside(&self, link: &Link, arm: &Vector) -> Vector {
        std::array::from_fn(|i| sum([link.origin[i].clone(), inner(&link.axes[i], arm)]))
    }

    /// `frame(parent, at, rotation)`, and what it is.
    fn frame(&mut self, parent: Option<usize>, k: usize) {
        let world = Link {
            name: "world".into(),
            origin: [0; 3].map(constant),
            axes: identity(),
            travels: false,
            turns: false,
        };
        let base = parent.map_or(world.clone(), |p| self.links[p].clone());
        let mut at = self.arm();
        let mut travels = base.travels || (base.turns && at.iter().any(|x| !is(x, 0)));
        // The first coordinate slides along x or turns about z, and all else hangs on that.
        let first = self.ignorable && k == 0;
        let slid = first && (self.plane || self.random.once_in(2));
        let mut word = None;
        let mut origin = None;
        if slid {
            at[0] = self.fresh();
            travels = true;
        } else if parent.is_none() && !self.ignorable && k > 0 && self.random.once_in(2) {
            // At a point of another frame, with axes that do not turn with it.
            let other = self.random.below(k);
            let other = self.links[other].clone();
            word = Some(format!("{}.point({})", other.name, self.list(&at)));
            origin = Some(self.inside(&other, &at));
            travels = other.travels || other.turns;
        } else if !first && self.random.once_in(3) {
            let (slide, moves) = self.motion();
            let axis = self.axis();
            at[axis] = slide;
            travels |= moves;
        }
        let word = word.unwrap_or_else(|| self.list(&at));
        let origin = origin.unwrap_or_else(|| self.inside(&base, &at));
        let origin = origin.map(|x| self.bind(x));

        let spin = (first && !slid).then(|| self.fresh());
        let (mut turn, mut relative, mut turns) = match self.plane {
            true if self.random.once_in(5) => (String::new(), identity(), false),
            true => {
                let (angle, turns) = self.motion();
                (self.say(&angle), self.about(2, angle), turns)
            }
            false => {
                let count = [0, 1, 1, 1, 2, 3][self.random.below(6)];
                self.rotations(count)
            }
        };
        if let Some(spin) = spin {
            let after = if turn.is_empty() { String::new() } else { format!(" * {turn}") };
            turn = format!("rotation_z({}){after}", self.say(&spin));
            let about = self.about(2, spin);
            relative = self.multiplied(&about, &relative);
            turns = true;
        }
        let axes = self.multiplied(&base.axes, &relative);
        let turn = if turn.is_empty() { turn } else { format!(", {turn}") };
        self.statements.push(format!("let f{k} = frame({}, {word}{turn});", base.name));
        self.links.push(Link { name: format!("f{k}"), origin, axes, travels, turns: turns || base.turns });
    }

    /// ½ m v² + ½ ω·I ω of a body in a frame, written as `name`.
    fn body(&mut self, name: &str, link: &Link, mass: &Expr) {
        let m = self.say(mass);
        let mut energy = vec![half() * mass.clone() * square(&rates(&link.origin))];
        let axes: [Vector; 3] = std::array::from_fn(|j| rates(&column(&link.axes, j)));
        let word = match (self.plane, self.random.once_in(4)) {
            (true, _) => {
                let moment = self.size();
                energy.push(half() * moment.clone() * square(&axes[0]));
                format!("body({m}, {}, {name})", self.say(&moment))
            }
            (false, full) => {
                let moments = match full {
                    true => std::array::from_fn(|_| constant(8) + self.size()),
                    false => std::array::from_fn(|_| self.size()),
                };
                let products: Vector = match full {
                    true => std::array::from_fn(|_| constant(self.random.below(9) as i32 - 4)),
                    false => [0; 3].map(constant),
                };
                let trace = sum(moments.clone());
                for i in 0..3 {
                    let weight = half() * (half() * trace.clone() - moments[i].clone());
                    energy.push(weight * square(&axes[i]));
                    // −Iⱼₖ once for each order of the two.
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    if full && !is(&products[i], 0) {
                        let both = product(&products[i], &inner(&axes[j], &axes[k]));
                        energy.push(constant(-8) * both);
                    }
                }
                let inertia = match full {
                    false => self.list(&moments),
                    true => {
                        let entry = |i: usize, j: usize| match i == j {
                            true => moments[i].clone(),
                            false => products[3 - i - j].clone(),
                        };
                        let rows: Vec<String> =
                            (0..3).map(|i| self.list(&std::array::from_fn(|j| entry(i, j)))).collect();
                        format!("[{}]", rows.join(", "))
                    }
                };
                format!("body({m}, {inertia}, {name})")
            }
        };
        let energy = sum(energy);
        self.kinetic(word, energy);
    }

    /// A kinetic energy, of the dimension of velocities squared.
    fn kinetic(&mut self, word: String, energy: Expr) {
        let rates = [self.unit(Unit::Frequency), self.unit(Unit::Frequency)].join(" * ");
        self.kinetic.push((format!("{rates} * {word}"), energy));
    }

    /// Load of a frame: a body in its origin, or one or more elsewhere on it.
    fn load(&mut self, link: &Link, geared: bool) {
        let mass = self.size();
        let kind = self.random.below(6);
        let mut centre = link.clone();
        if kind < 4 {
            let arm = self.arm();
            centre.origin = self.inside(link, &arm).map(|x| self.bind(x));
            let at = self.list(&arm);
            centre.name = match (kind, self.plane) {
                (3, false) => {
                    let turn = self.about(0, constant(3));
                    centre.axes = self.multiplied(&link.axes, &turn);
                    format!("frame({}, {at}, rotation_x(0.375))", link.name)
                }
                _ => format!("frame({}, {at})", link.name),
            };
        }
        if kind < 2 && geared {
            let word = format!("particle({}, {})", self.say(&mass), centre.name);
            self.kinetic(word, half() * mass.clone() * square(&rates(&centre.origin)));
        } else {
            let name = centre.name.clone();
            self.body(&name, &centre, &mass);
        }
        // Weight, for all alike or not.
        let up = self.dimensions() - 1;
        let pull = if self.random.once_in(4) { self.size() } else { constant(78) };
        let words = [self.say(&mass), self.say(&pull)].join(" * ");
        let weight = mass * pull;
        self.potential.push((
            format!("{words} * {}.origin()[{up}]", centre.name),
            weight.clone() * centre.origin[up].clone(),
        ));
        if !self.ignorable && self.random.once_in(6) {
            let word = format!("0.5 * {words} * {}.origin()[0]", centre.name);
            self.potential.push((word, half() * weight * centre.origin[0].clone()));
        }
    }

    /// Component i of ω in own axes.
    fn omega(link: &Link, i: usize) -> Expr {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        inner(&column(&link.axes, k), &rates(&column(&link.axes, j)))
    }

    fn some_link(&mut self) -> Link {
        self.links[self.random.below(self.links.len())].clone()
    }

    /// A number that is linear in the velocities.
    fn velocity(&mut self) -> (String, Expr) {
        let link = self.some_link();
        let (name, i) = (link.name.clone(), self.axis());
        let per = self.unit(Unit::Frequency);
        let axes: [Vector; 3] = std::array::from_fn(|j| column(&link.axes, j));
        let moving = rates(&link.origin);
        match self.random.below(6) {
            0 => (format!("{per} * velocity({name})[{i}]"), inner(&axes[i], &moving)),
            1 => {
                let arm = self.arm();
                let parts = (0..3).map(|j| product(&arm[j], &inner(&axes[j], &moving)));
                (
                    format!("{per} * {name}.velocity().dot({})", self.list(&arm)),
                    sum(parts.collect::<Vec<_>>()),
                )
            }
            2 | 3 if self.plane => (format!("{per} * angular_velocity({name})"), Scene::omega(&link, 2)),
            2 => (format!("{per} * angular_velocity({name})[{i}]"), Scene::omega(&link, i)),
            3 => (format!("{per} * {name}.angular_velocity()[{i}]"), Scene::omega(&link, i)),
            kind => {
                // The rate of what never moves would be refused.
                let known = self.known().unwrap_or(Expr::Position(0));
                let arm = self.arm();
                let (word, at) = match kind {
                    4 => ("point", self.inside(&link, &arm)[i].clone()),
                    _ => ("vector", inner(&link.axes[i], &arm)),
                };
                let (q, arm) = (self.say(&known), self.list(&arm));
                (format!("{per} * dot({q} + {name}.{word}({arm})[{i}])"), sum([known, at]).rate())
            }
        }
    }

    /// A number of places.
    fn place(&mut self) -> (String, Expr) {
        let (link, arm, i) = (self.some_link(), self.arm(), self.axis());
        let (name, at) = (link.name.clone(), self.list(&arm));
        match self.random.below(5) {
            0 => (format!("{name}.origin()[{i}]"), link.origin[i].clone()),
            1 | 2 => (format!("{name}.point({at})[{i}]"), self.inside(&link, &arm)[i].clone()),
            3 if !self.plane => {
                let (word, matrix, _) = self.rotations(1);
                (format!("({word} * {at})[{i}]"), inner(&matrix[i], &arm))
            }
            _ => (format!("{name}.vector({at})[{i}]"), inner(&link.axes[i], &arm)),
        }
    }

    /// A function of coordinates and time that knows nothing of frames.
    fn function(&mut self, depth: usize) -> Expr {
        let positions = (usize::from(self.ignorable)..self.coordinates).collect();
        let (parameters, choices) = (self.parameters, self.choices);
        let mut scope = Scope { random: self.random, parameters, positions, bindings: 0, choices };
        scope.place(depth)
    }

    /// Springs, and whatever else depends on places.
    fn springs(&mut self) {
        if self.ignorable {
            return;
        }
        for _ in 0..self.random.below(3) {
            let stiffness = self.size();
            let k = self.say(&stiffness);
            match self.random.below(5) {
                0 | 1 => {
                    let (one, two) = (self.some_link(), self.some_link());
                    let (a, b) = (self.arm(), self.arm());
                    let [from, to] = [self.inside(&one, &a), self.inside(&two, &b)];
                    let apart: Vector = std::array::from_fn(|i| from[i].clone() - to[i].clone());
                    let (a, b) = (self.list(&a), self.list(&b));
                    let word = format!(
                        "0.5 * {k} * ({}.point({a}) - {}.point({b})).norm_squared()",
                        one.name, two.name
                    );
                    self.potential.push((word, half() * stiffness * square(&apart)));
                }
                2 if self.choices => {
                    let (word, place) = self.place();
                    let squared = stiffness.clone() * place.clone().power(2);
                    let (test, parts) = match self.random.once_in(2) {
                        true => {
                            let word =
                                format!("(if {word} < 0.25 {{ {k} * ({word}).powi(2) }} else {{ {word} }})");
                            (
                                word,
                                Expr::Choice(
                                    Test::Less,
                                    Box::new([place.clone(), constant(2), squared, place]),
                                ),
                            )
                        }
                        false => (format!("{k} * abs({word})"), stiffness * place.call(Call::Abs)),
                    };
                    self.potential.push((test, parts));
                }
                _ => {
                    let (word, place) = self.place();
                    let (other, factor) = self.place();
                    self.potential.push((format!("{k} * ({word}) * ({other})"), stiffness * place * factor));
                }
            }
        }
    }

    /// D, where nothing moves by itself.
    fn friction(&mut self) -> Option<Expr> {
        if self.timed || !self.random.once_in(3) {
            return None;
        }
        let (size, known) = (self.size(), self.known()?);
        let mut words = vec![format!(
            "0.5 * {} * ({} * dot({})).powi(2)",
            self.say(&size),
            self.unit(Unit::Frequency),
            self.say(&known)
        )];
        let mut all = half() * size * known.rate().power(2);
        if !self.ignorable && self.random.once_in(2) {
            let (size, (word, velocity)) = (self.size(), self.velocity());
            words.push(format!("0.5 * {} * ({word}).powi(2)", self.say(&size)));
            all = all + half() * size * velocity.power(2);
        }
        let units = [self.unit(Unit::Energy), self.unit(Unit::Time)].join(" * ");
        self.statements.push(format!("D = {units} * ({});", words.join(" + ")));
        Some(all)
    }

    /// Forces and couples, as forces and where they act.
    fn forces(&mut self) -> Vec<(Expr, Expr)> {
        let mut forces = Vec::new();
        if self.ignorable {
            return forces;
        }
        for _ in 0..[0, 0, 1, 1, 2][self.random.below(5)] {
            let link = self.some_link();
            let (name, dimensions) = (link.name.clone(), self.dimensions());
            let mut push: Vector =
                std::array::from_fn(|i| if i < dimensions { self.function(1) } else { constant(0) });
            let mut written: Vec<String> = push[..dimensions].iter().map(|x| self.say(x)).collect();
            if self.random.once_in(3) {
                // Drag.
                let (size, (word, velocity)) = (self.size(), self.velocity());
                written[0] = format!("-{} * ({word})", self.say(&size));
                push[0] = constant(-8) * size * velocity;
            }
            let energy = self.unit(Unit::Energy);
            let list = format!("[{}]", written.join(", "));
            let in_world = |push: &Vector| -> Vector { std::array::from_fn(|i| inner(&link.axes[i], push)) };
            match self.random.below(5) {
                0 | 1 if link.travels => {
                    self.statements.push(format!("force {energy} * {list} at {name};"));
                    forces.extend(in_world(&push).into_iter().zip(link.origin.clone()));
                }
                2 | 3 if link.turns => {
                    let couple = if self.plane { written[0].clone() } else { list };
                    self.statements.push(format!("couple {energy} * {couple} on {name};"));
                    let about = if self.plane { vec![2] } else { vec![0, 1, 2] };
                    for (i, moment) in about.into_iter().zip(&push) {
                        let [j, k] = [(i + 1) % 3, (i + 2) % 3].map(|j| column(&link.axes, j));
                        forces.extend(k.into_iter().zip(j).map(|(k, j)| (product(moment, &k), j)));
                    }
                }
                kind if link.travels => {
                    let arm = self.arm();
                    let at = self.list(&arm);
                    let place = self.inside(&link, &arm);
                    let (word, push) = match kind {
                        4 => (format!("{name}.vector({list})"), in_world(&push)),
                        _ => (list, push),
                    };
                    self.statements.push(format!("force {energy} * {word} at {name}.point({at});"));
                    forces.extend(push.into_iter().zip(place).take(dimensions));
                }
                _ => {}
            }
        }
        forces
    }

    /// The j-th coordinate leads the j-th constraint, so that none follows from the others.
    fn constraints(&mut self) -> Vec<Constraint> {
        let mut constraints: Vec<Constraint> = Vec::new();
        if self.ignorable || self.coordinates < 2 || !self.random.once_in(3) {
            return constraints;
        }
        let lead = |k: i32, j: usize| constant(k) * Expr::Position(j);
        let dimensions = self.dimensions();
        if self.coordinates > dimensions && self.random.once_in(3) {
            let (link, arm) = (self.some_link(), self.arm());
            let at = self.list(&arm);
            let place = self.inside(&link, &arm);
            let leads: Vector =
                std::array::from_fn(|j| if j < dimensions { lead(12, j) } else { constant(0) });
            let ends: Vector = std::array::from_fn(|_| constant(self.random.below(9) as i32));
            let (written, right) = (self.list(&leads), self.list(&ends));
            self.statements.push(format!("constraint c0: {}.point({at}) - {written} == {right};", link.name));
            for (j, (place, end)) in place.into_iter().zip(ends).take(dimensions).enumerate() {
                let left = place - lead(12, j);
                constraints.push(Constraint { left, right: end, on_velocities: false });
            }
            return constraints;
        }
        for j in 0..1 + self.random.below(2.min(self.coordinates - 1)) {
            let on_velocities = self.random.once_in(2);
            let (word, left, leading) = match on_velocities {
                true => {
                    let (word, velocity) = self.velocity();
                    let (two, q) = (self.say(&constant(16)), self.say(&Expr::Position(j)));
                    let leading = format!("{two} * {} * dot({q})", self.unit(Unit::Frequency));
                    (word, velocity + constant(16) * Expr::Position(j).rate(), leading)
                }
                false => {
                    let (word, place) = self.place();
                    (word, place + lead(20, j), self.say(&lead(20, j)))
                }
            };
            let right = match self.random.below(3) {
                0 if self.timed => half() * Expr::Time,
                1 => self.size(),
                _ => constant(4),
            };
            let written = self.say(&right);
            self.statements.push(format!("constraint c{j}: {word} + {leading} == {written};"));
            constraints.push(Constraint { left, right, on_velocities });
        }
        constraints
    }
}

fn scene(random: &mut Random, all: usize) -> System {
    let plane = random.once_in(4);
    let ignorable = random.once_in(5);
    let (parameters, count) = (1 + random.below(4), 1 + random.below(4));
    let (timed, choices) = (random.once_in(2), random.once_in(4));
    // The motors of a robot: then what hangs on a joint may be a point.
    let geared = random.once_in(2);
    let mut s = Scene {
        random,
        all,
        coordinates: 0,
        parameters,
        prescribed: Vec::new(),
        bindings: Vec::new(),
        links: Vec::new(),
        statements: Vec::new(),
        said: Vec::new(),
        kinetic: Vec::new(),
        potential: Vec::new(),
        plane,
        timed,
        ignorable,
        choices,
        built: false,
    };
    for k in 0..count {
        let loose = k > 0 && !ignorable && s.random.once_in(4);
        let parent = (k > 0 && !loose).then(|| if s.random.once_in(4) { s.random.below(k) } else { k - 1 });
        s.frame(parent, k);
    }
    let needed = if ignorable { 2 } else { 1 };
    while s.coordinates < needed {
        // Something that moves beside it.
        let slide = s.fresh();
        let k = s.links.len();
        let at = [slide, constant(0), constant(0)];
        let (word, parent) = (s.list(&at), s.links[k - 1].clone());
        s.statements.push(format!("let f{k} = frame(f{}, {word});", k - 1));
        let origin = s.inside(&parent, &at).map(|x| s.bind(x));
        s.links.push(Link { name: format!("f{k}"), origin, travels: true, ..parent });
    }
    s.built = true;
    for link in s.links.clone() {
        s.load(&link, geared);
    }
    if geared {
        for i in usize::from(ignorable)..s.coordinates {
            let (rotor, q) = (s.size(), Expr::Position(i));
            let word = format!("0.5 * {} * dot({}).powi(2)", s.say(&rotor), s.say(&q));
            s.kinetic(word, half() * rotor * q.rate().power(2));
        }
    }
    if !ignorable {
        for _ in 0..s.random.below(2) {
            let (size, one, two) = (s.size(), s.velocity(), s.velocity());
            let word = format!("0.5 * {} * ({} + {}).powi(2)", s.say(&size), one.0, two.0);
            // The velocities bring their units themselves.
            s.kinetic.push((word, half() * size * (one.1 + two.1).power(2)));
        }
    }
    // Every parameter is used, and every coordinate that is not to be ignorable.
    for i in 0..parameters.max(s.coordinates) {
        let at = usize::from(ignorable) + i % (s.coordinates - usize::from(ignorable));
        let spring = Expr::Parameter(i % parameters) * Expr::Position(at).power(2);
        let word = s.say(&spring);
        s.potential.push((word, spring));
    }
    let rest = s.function(2);
    let word = s.say(&rest);
    s.potential.push((word, rest));
    s.springs();
    let dissipation = s.friction();
    let mut applied = Vec::new();
    for i in usize::from(ignorable)..s.coordinates {
        if s.random.once_in(6) {
            applied.push((i, s.function(2) - s.function(1) * Expr::Position(i).rate()));
        }
    }
    let forces = s.forces();
    let constraints = s.constraints();
    let mut struck = Vec::new();
    let hit = s.some_link();
    if hit.travels && s.random.once_in(3) {
        let arm = s.arm();
        let at = s.list(&arm);
        struck.push(s.inside(&hit, &arm)[..s.dimensions()].to_vec());
        s.statements.push(format!("impulse blow0 at {}.point({at});", hit.name));
    }
    let mut observed = Vec::new();
    for k in 0..s.random.below(3) {
        let (word, value) = if s.random.once_in(2) { s.velocity() } else { s.place() };
        s.statements.push(format!("observe seen{k} = {word};"));
        s.statements.push(format!("event hit{k}: t + ({word}), rising;"));
        observed.push(value);
    }
    let whole = s.random.once_in(6);
    let energy = [s.unit(Unit::Energy), s.unit(Unit::Energy)];
    let split = |terms: &[(String, Expr)]| -> (String, Expr) {
        let words: Vec<&str> = terms.iter().map(|(word, _)| word.as_str()).collect();
        (words.join(" + "), sum(terms.iter().map(|(_, e)| e.clone())))
    };
    let ((t, kinetic), (v, potential)) = (split(&s.kinetic), split(&s.potential));
    s.statements.push(match whole {
        true => format!("L = {} * ({t} - ({v}));", energy[0]),
        false => format!("T = {} * ({t}); V = {} * ({v});", energy[0], energy[1]),
    });
    System {
        kind: if plane { "bodies in the plane" } else { "bodies in space" },
        coordinates: s.coordinates,
        parameters,
        prescribed: s.prescribed,
        bindings: s.bindings,
        kinetic,
        potential,
        whole,
        dissipation,
        applied,
        forces,
        constraints,
        struck,
        observed,
        ignorable,
        frames: Some(Frames { statements: s.statements.join("\n    "), said: s.said }),
    }
}
