//! Uses of frames: points, velocities, kinetic energies, forces and couples; and frames in the plane.

use super::*;

impl Elaborator<'_> {
    pub(in crate::model::elaborate) fn rigid_function(
        &mut self,
        name: &Ident,
        arguments: Vec<Val>,
        call: &syn::ExprCall,
    ) -> Result {
        let word = name.to_string();
        if ROTATIONS.contains(&word.as_str()) {
            return self.rotation(name, arguments, call);
        }
        match word.as_str() {
            "frame" => self.frame(arguments, call),
            "body" => self.body(arguments, call),
            "particle" => self.particle(arguments, call),
            _ => {
                self.arity(&word, 1, arguments.len(), name)?;
                let mut arguments = arguments.into_iter();
                let frame = arguments.next().unwrap_or(Val::Int(0));
                if let Val::Number(_) = frame {
                    let x = plain(&call.args[0]);
                    let message = format!(
                        "`{word}` is the velocity of a frame, and this is a number\nhelp: the time derivative of a number is `dot({x})`"
                    );
                    return Err(self.errors.push(&call.args[0], message));
                }
                let frame = self.a_frame(frame, &call.args[0])?;
                Ok(self.velocity_word(&word, &frame))
            }
        }
    }

    /// Methods of frames.
    pub(in crate::model::elaborate) fn frame_method(
        &mut self,
        name: &Ident,
        frame: &Frame,
        arguments: Vec<Val>,
        at: impl ToTokens + Copy,
    ) -> Result {
        let word = name.to_string();
        if !METHODS.contains(&word.as_str()) {
            let hint = did_you_mean(&word, METHODS);
            let message = format!(
                "a frame has no method `{word}`{hint}\nhelp: a frame has `point([x, y, z])`, `origin()`, `vector([x, y, z])`, `velocity()` and `angular_velocity()`"
            );
            return Err(self.errors.push(name, message));
        }
        self.arity(&word, usize::from(matches!(word.as_str(), "point" | "vector")), arguments.len(), name)?;
        match (arguments.into_iter().next(), word.as_str()) {
            (None, "origin") => Ok(self.point_in_world(frame, None)),
            (None, _) => Ok(self.velocity_word(&word, frame)),
            (Some(components), _) => {
                let components = self.components(components, at)?;
                let plane = matches!(frame, Frame::Plane { .. });
                let length = match frame {
                    Frame::Plane { .. } => 2,
                    Frame::Space { .. } => 3,
                    Frame::World => components.len().clamp(2, 3),
                };
                if components.len() != length {
                    let message = format!(
                        "a {word} of a frame in {} has {length} components, not {}\nhelp: write `{word}({})`",
                        if plane { "the plane" } else { "space" },
                        components.len(),
                        if plane { "[x, y]" } else { "[x, y, z]" },
                    );
                    return Err(self.errors.push(at, message));
                }
                if word == "point" {
                    self.independent_of_states(&components, "a point", at)?;
                }
                if self.graph.depends(&components, |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_)))
                    && word == "point"
                {
                    let message = "a point depends on velocities\nhelp: its coordinates are positions; a velocity is a vector, `vector([…])`";
                    return Err(self.errors.push(at, message));
                }
                Ok(match word.as_str() {
                    "point" => self.point_in_world(frame, Some(&components)),
                    _ => self.vector_in_world(frame, &components),
                })
            }
        }
    }

    /// Coordinates in the world of a point of a frame, or of its origin.
    fn point_in_world(&mut self, frame: &Frame, at: Option<&[Value]>) -> Val {
        match (*frame, at) {
            (Frame::World, at) => numbers_of(at.unwrap_or(&[Value::ZERO; 3])),
            (Frame::Plane { origin, angle }, at) => {
                let [x, y] = at.map_or([Value::ZERO; 2], |at| [at[0], at[1]]);
                numbers_of(&self.point_in_plane(origin, angle, [x, y]))
            }
            (Frame::Space { origin, axes }, at) => {
                let at = at.map_or([Value::ZERO; 3], |at| [at[0], at[1], at[2]]);
                let point = self.point(origin, axes, at);
                let place: Vec<Value> = (0..3).map(|i| self.place(point, i)).collect();
                numbers_of(&place)
            }
        }
    }

    /// Components in the world of a vector given in the axes of a frame.
    fn vector_in_world(&mut self, frame: &Frame, x: &[Value]) -> Val {
        match *frame {
            Frame::World => numbers_of(x),
            Frame::Plane { angle, .. } => numbers_of(&self.turned_in_plane(angle, [x[0], x[1]])),
            Frame::Space { axes, .. } => {
                let rows: Vec<Vector> = (0..3).map(|i| self.row(axes, i)).collect();
                let x = [x[0], x[1], x[2]];
                let x: Vec<Value> = rows.iter().map(|row| inner(&mut self.graph, row, &x)).collect();
                numbers_of(&x)
            }
        }
    }

    /// Velocity of the origin, or angular velocity, in own axes.
    fn velocity_word(&mut self, word: &str, frame: &Frame) -> Val {
        match (*frame, word) {
            (Frame::World, _) => numbers_of(&[Value::ZERO; 3]),
            (Frame::Plane { angle, .. }, "angular_velocity") => Val::Number(self.velocity(angle)),
            (Frame::Plane { origin, angle }, _) => {
                let rates = origin.map(|x| self.velocity(x));
                numbers_of(&self.turned_in_plane(-angle, rates))
            }
            (Frame::Space { axes, .. }, "angular_velocity") => numbers_of(&self.space.axes[axes].omega),
            (Frame::Space { origin, axes }, _) => {
                numbers_of(&self.velocity_in(origin, axes).unwrap_or([Value::ZERO; 3]))
            }
        }
    }

    /// `body(m, I, frame)`: ½ m v² + ½ ω·I ω, with the mass centre in the origin of the frame and I about it in its
    /// axes.
    fn body(&mut self, arguments: Vec<Val>, call: &syn::ExprCall) -> Result {
        let form = "write `body(m, [Ixx, Iyy, Izz], frame)`, or in the plane `body(m, I, frame)`";
        self.kinetic_here("body", call)?;
        let [mass, inertia, frame] = self.exactly(arguments, "body", form, call)?;
        let mass = self.mass(mass, &call.args[0])?;
        let frame = self.moving_frame(frame, &call.args[2])?;
        let translation = self.translation(mass, &frame);
        let rotation = match frame {
            Frame::Space { axes, .. } => {
                let tensor = self.tensor(inertia, &call.args[1])?;
                let omega = self.space.axes[axes].omega;
                let g = &mut self.graph;
                let mut sum = Value::ZERO;
                for i in 0..3 {
                    for j in 0..=i {
                        let square = g.mul(omega[i], omega[j]);
                        let term = g.mul(tensor[i][j], square);
                        let half = if i == j { Number::Ratio(1, 2) } else { Number::ONE };
                        sum = g.add(sum, term.scaled(half));
                    }
                }
                sum
            }
            Frame::Plane { angle, .. } => {
                let inertia = match inertia {
                    Val::Array(_) => {
                        let message = "the moment of inertia of a body in the plane is one number\nhelp: write `body(m, I, frame)`; a frame in space has a place `[x, y, z]`";
                        return Err(self.errors.push(&call.args[1], message));
                    }
                    number => {
                        let moment = self.number(number, &call.args[1])?;
                        self.check_inertia(&[moment], 0.0, "this moment of inertia", &call.args[1])?;
                        moment
                    }
                };
                let rate = self.velocity(angle);
                let square = self.graph.powi(rate, 2);
                self.graph.mul(inertia, square).scaled(Number::Ratio(1, 2))
            }
            Frame::World => Value::ZERO,
        };
        Ok(Val::Number(self.graph.add(translation, rotation)))
    }

    /// `particle(m, frame)`: ½ m v² of a mass in the origin of the frame.
    fn particle(&mut self, arguments: Vec<Val>, call: &syn::ExprCall) -> Result {
        self.kinetic_here("particle", call)?;
        let [mass, frame] = self.exactly(arguments, "particle", "write `particle(m, frame)`", call)?;
        let mass = self.mass(mass, &call.args[0])?;
        let frame = self.moving_frame(frame, &call.args[1])?;
        Ok(Val::Number(self.translation(mass, &frame)))
    }

    /// Kinetic energies belong to T.
    fn kinetic_here(&mut self, word: &str, call: &syn::ExprCall) -> Result<()> {
        let Some(other) = self.not_kinetic else { return Ok(()) };
        let message = format!(
            "`{word}` is a kinetic energy, and has no place in {other}\nhelp: add it to `T`, as in `T = {word}(…);`"
        );
        Err(self.errors.push(call, message))
    }

    fn exactly<const N: usize>(
        &mut self,
        arguments: Vec<Val>,
        word: &str,
        form: &str,
        call: &syn::ExprCall,
    ) -> Result<[Val; N]> {
        let given = arguments.len();
        <[Val; N]>::try_from(arguments).map_err(|_| {
            let message = format!("`{word}` takes {N} arguments, not {given}\nhelp: {form}");
            self.errors.push(&call.func, message)
        })
    }

    fn moving_frame(&mut self, val: Val, at: &Expr) -> Result<Frame> {
        match self.a_frame(val, at)? {
            Frame::World => {
                let message = "what is fixed in the world has no kinetic energy\nhelp: give the frame that moves with the body, `frame(world, [x, y, z], rotation)`";
                Err(self.errors.push(at, message))
            }
            frame => Ok(frame),
        }
    }

    /// ½ m v² of the origin of a frame, in the axes where its velocity is shortest: those it was placed in.
    fn translation(&mut self, mass: Value, frame: &Frame) -> Value {
        let velocity: Vec<Value> = match *frame {
            Frame::World => Vec::new(),
            Frame::Plane { origin, .. } => origin.iter().map(|x| self.velocity(*x)).collect(),
            Frame::Space { origin, .. } => {
                let axes = self.space.points[origin].axes;
                self.velocity_in(origin, axes).map_or(Vec::new(), |v| v.to_vec())
            }
        };
        let square = self.inner(&velocity, &velocity);
        self.graph.mul(mass, square).scaled(Number::Ratio(1, 2))
    }

    /// An inertia tensor: its principal moments, or a symmetric matrix.
    fn tensor(&mut self, val: Val, at: &Expr) -> Result<Matrix> {
        let help = "write `[Ixx, Iyy, Izz]`, or `[[Ixx, Ixy, Ixz], [Ixy, Iyy, Iyz], [Ixz, Iyz, Izz]]`";
        let rows = match val {
            Val::Array(rows) if rows.len() == 3 => rows,
            other => {
                let message = format!(
                    "expected the moments of inertia about three axes, found {}\nhelp: {help}; a mass without extension is `particle(m, frame)`",
                    other.kind()
                );
                return Err(self.errors.push(at, message));
            }
        };
        if !rows.iter().any(|row| matches!(row, Val::Array(_))) {
            let moments = rows.into_iter().map(|i| self.number(i, at)).collect::<Result<Vec<_>>>()?;
            self.check_inertia(&moments, 0.0, "a moment of inertia", at)?;
            self.check_triangle(&moments, at);
            let entry = |i: usize, j: usize| if i == j { moments[i] } else { Value::ZERO };
            return Ok(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))));
        }
        let mut tensor = [[Value::ZERO; 3]; 3];
        for (into, row) in tensor.iter_mut().zip(rows) {
            *into = self.vector(row, at)?;
        }
        if (0..3).any(|i| (0..i).any(|j| tensor[i][j] != tensor[j][i])) {
            let message = format!("this inertia tensor is not symmetric\nhelp: {help}");
            return Err(self.errors.push(at, message));
        }
        // Of a positive tensor no principal minor is negative (Sylvester); those of a thin rod are 0.
        let size = tensor
            .iter()
            .flatten()
            .filter(|v| v.is_constant())
            .fold(0.0, |a: f64, v| a.max(v.k.to_f64().abs()));
        let g = &mut self.graph;
        let mut minors: Vec<Value> = (0..3).map(|i| tensor[i][i]).collect();
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let (product, square) = (g.mul(tensor[j][j], tensor[k][k]), g.powi(tensor[j][k], 2));
            minors.push(g.sub(product, square));
        }
        let across = cross(g, &tensor[1], &tensor[2]);
        minors.push(inner(g, &tensor[0], &across));
        let rounding = 1e-12 * size.max(size * size * size);
        self.check_inertia(&minors, -rounding, "the moment of inertia about some axis", at)?;
        self.check_triangle(&[tensor[0][0], tensor[1][1], tensor[2][2]], at);
        Ok(tensor)
    }

    fn mass(&mut self, mass: Val, at: &Expr) -> Result<Value> {
        let mass = self.number(mass, at)?;
        self.check_inertia(&[mass], 0.0, "this mass", at)?;
        Ok(mass)
    }

    /// Warns of moments of inertia that no distribution of mass has: Σ m (y² + z²) ≤ Σ m (x² + z²) + Σ m (x² + y²).
    fn check_triangle(&mut self, moments: &[Value], at: &Expr) {
        let known: Option<Vec<f64>> =
            moments.iter().map(|v| v.is_constant().then_some(v.k.to_f64())).collect();
        let Some(known) = known else { return };
        let (largest, sum) = (known.iter().copied().fold(0.0, f64::max), known.iter().sum::<f64>());
        // (One about whose axes it does not turn may be left out.)
        if known.iter().all(|moment| *moment > 0.0) && largest > (sum - largest) * (1.0 + 1e-9) {
            let message = "no body has these moments of inertia: the largest is at most the sum of the others\nhelp: of a flat body it is their sum";
            self.errors.warn(syn::spanned::Spanned::span(at), "an_inertia_of_no_body", message.into());
        }
    }

    /// Checks that a mass or moment of inertia is not below `least`, as far as it is known.
    fn check_inertia(&mut self, values: &[Value], least: f64, what: &str, at: &Expr) -> Result<()> {
        if !values.iter().any(|v| v.is_constant() && v.k.to_f64() < least) {
            return Ok(());
        }
        let message = format!(
            "{what} is negative\nhelp: masses and moments of inertia are not; what is cut out of a body is subtracted, `body(M, …) - body(m, …)`"
        );
        Err(self.errors.push(at, message))
    }

    /// `force F at frame;`: F in the axes of the frame, at its origin.
    pub(in crate::model::elaborate) fn force_on_frame(
        &mut self,
        force: Val,
        frame: &Frame,
        [force_at, at]: [&Expr; 2],
    ) -> Result<()> {
        let force = self.components(force, force_at)?;
        let length = if matches!(frame, Frame::Plane { .. }) { 2 } else { 3 };
        if force.len() != length {
            let message = format!(
                "a force of {} at a frame with {length} axes\nhelp: give its components in these axes",
                counted(force.len(), "component"),
            );
            return Err(self.errors.push(force_at, message));
        }
        let velocity = match *frame {
            Frame::World => None,
            Frame::Plane { origin, angle } => {
                let force = self.turned_in_plane(angle, [force[0], force[1]]);
                self.found.forces.extend(force.into_iter().zip(origin));
                return Ok(());
            }
            Frame::Space { origin, axes } => self.velocity_in(origin, axes),
        };
        let Some(velocity) = velocity else {
            if self.is_derived() {
                return Ok(());
            }
            let message = "the origin of this frame does not move: a force there does no work\nhelp: apply it at another point, `force F at frame(link, [x, y, z])`";
            return Err(self.errors.push(at, message));
        };
        self.found.frame_forces.extend(force.into_iter().zip(velocity));
        Ok(())
    }

    /// `couple M on frame;`: M in the axes of the frame.
    pub(in crate::model::elaborate) fn couple(&mut self, couple: &Expr, on: &Expr) -> Result<()> {
        let (moment, frame) = (self.evaluate(couple), self.evaluate(on));
        let frame = frame.and_then(|frame| self.a_frame(frame, on));
        let (moment, frame) = (moment?, frame?);
        let fixed = match frame {
            Frame::World => true,
            Frame::Plane { angle, .. } => {
                if let Val::Array(_) = moment {
                    let message = "a couple in the plane is one number\nhelp: write `couple M on frame;`; a frame in space has a place `[x, y, z]`";
                    return Err(self.errors.push(couple, message));
                }
                let moment = self.number(moment, couple)?;
                self.found.forces.push((moment, angle));
                !self.graph.depends(&[angle], |s| !matches!(s, Symbol::Parameter(_)))
            }
            Frame::Space { axes, .. } => {
                let moment = self.vector(moment, couple)?;
                let omega = self.space.axes[axes].omega;
                self.found.frame_forces.extend(moment.into_iter().zip(omega));
                self.space.axes[axes].spin.is_none()
            }
        };
        if fixed && !self.is_derived() {
            let message = "this frame does not turn: a couple on it does no work\nhelp: remove this statement, or give the frame of the body that the couple turns";
            return Err(self.errors.push(on, message));
        }
        Ok(())
    }

    // The plane. Positions and angles in the axes of the world are coordinates like any others, and cost less there
    // than in own axes (docs/decisions/0013).

    pub(super) fn plane_frame(
        &mut self,
        parent: &Frame,
        at: [Value; 2],
        rotation: Option<(Val, &Expr)>,
    ) -> Result {
        let (origin, before) = match *parent {
            Frame::Plane { origin, angle } => (origin, angle),
            _ => ([Value::ZERO; 2], Value::ZERO),
        };
        let mut angle = before;
        if let Some((rotation, at)) = rotation {
            if matches!(rotation, Val::Rotation(_)) {
                let message = "a rotation in space cannot turn a frame in the plane\nhelp: in the plane it is an angle, `frame(world, [x, y], theta)`; in space a place has three coordinates, `[x, y, 0]`";
                return Err(self.errors.push(at, message));
            }
            let turn = self.angle(rotation, at)?;
            angle = self.graph.add(angle, turn);
        }
        let name = self.frame_name();
        let angle = self.bound_number(&format!("{name}_angle"), angle);
        let origin = self.point_in_plane(origin, before, at);
        Ok(Val::Frame(Frame::Plane { origin, angle }))
    }

    fn point_in_plane(&mut self, origin: [Value; 2], angle: Value, at: [Value; 2]) -> [Value; 2] {
        let turned = self.turned_in_plane(angle, at);
        let name = self.frame_name();
        std::array::from_fn(|i| {
            let sum = self.graph.add(origin[i], turned[i]);
            let known = sum.node.and_then(|n| self.bound.get(&n)).map(|symbol| symbol.scaled(sum.k));
            known.unwrap_or_else(|| self.bound_number(&format!("{name}_point[{i}]"), sum))
        })
    }

    fn turned_in_plane(&mut self, angle: Value, [x, y]: [Value; 2]) -> [Value; 2] {
        let [s, c] = self.sine_and_cosine(angle);
        let g = &mut self.graph;
        let products = [g.mul(c, x), g.mul(s, y), g.mul(s, x), g.mul(c, y)];
        [g.sub(products[0], products[1]), g.add(products[2], products[3])]
    }
}

fn numbers_of(values: &[Value]) -> Val {
    Val::Array(values.iter().copied().map(Val::Number).collect())
}
