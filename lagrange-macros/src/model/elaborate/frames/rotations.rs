//! Rotations as values: about an axis by an angle, by a matrix of numbers, and products of these.

use super::*;
use crate::model::frames::{product, transposed};

/// Functions that make rotations.
pub(in crate::model::elaborate) const ROTATIONS: [&str; 4] =
    ["rotation", "rotation_x", "rotation_y", "rotation_z"];

/// Parameters of rotations in other libraries.
const PARAMETERS: [&str; 12] = [
    "angle",
    "angles",
    "axis",
    "axis_angle",
    "euler",
    "euler_angles",
    "matrix",
    "pitch",
    "quaternion",
    "roll",
    "scaled_axis",
    "yaw",
];

const READ: &str = "; angles and quaternions are read of states, `system.attitude_R(&state).euler_angles()`";

/// The same rotation by as few turns as there are angles: what does not turn is part of what does.
pub fn merged(g: &mut Graph, turns: &[Turn]) -> Vec<Turn> {
    let mut all: Vec<Turn> = Vec::new();
    for turn in turns {
        match all.last_mut() {
            Some(last) if last.spin.is_none() || turn.spin.is_none() => {
                last.matrix = product(g, &last.matrix, &turn.matrix);
                last.spin = match (last.spin, turn.spin) {
                    (Some(Spin::About(axis, angle)), None) => {
                        Some(Spin::About(turned_back(g, &turn.matrix, &axis), angle))
                    }
                    (Some(Spin::Free(omega)), None) => Some(Spin::Free(turned_back(g, &turn.matrix, &omega))),
                    (_, spin) => spin,
                };
            }
            _ => all.push(turn.clone()),
        }
    }
    all
}

impl Elaborator<'_> {
    /// `rotation_x(a)`, `rotation([x, y, z], a)`, `rotation([[…], […], […]])`
    pub(in crate::model::elaborate) fn rotation(
        &mut self,
        name: &Ident,
        arguments: Vec<Val>,
        call: &syn::ExprCall,
    ) -> Result {
        let word = name.to_string();
        let coordinate = ["rotation_x", "rotation_y", "rotation_z"].iter().position(|w| *w == word);
        let mut given = arguments.into_iter();
        let turn = match (coordinate, given.next(), given.next(), given.next()) {
            (Some(axis), Some(angle), None, None) => {
                let angle = self.angle(angle, &call.args[0])?;
                self.about(IDENTITY[axis], angle)
            }
            (None, Some(Val::Int(_) | Val::Number(_)), Some(Val::Array(_)), None) => {
                let [angle, axis] = [0, 1].map(|i| plain(&call.args[i]));
                let message = format!(
                    "the axis of a rotation comes before its angle\nhelp: write `rotation({axis}, {angle})`"
                );
                return Err(self.errors.push(&call.args, message));
            }
            (None, Some(axis), Some(angle), None) => {
                let angle = self.angle(angle, &call.args[1])?;
                let axis = self.direction(axis, &call.args[0])?;
                self.about(axis, angle)
            }
            (None, Some(matrix), None, None) => {
                Turn { matrix: self.orthonormal(matrix, &call.args[0])?, spin: None }
            }
            _ => {
                let form = match coordinate {
                    Some(_) => format!("`{word}` takes an angle"),
                    None => "`rotation` takes an axis and an angle, or a matrix of numbers".into(),
                };
                let help = match coordinate {
                    Some(_) => format!("write `{word}(theta)`"),
                    None => {
                        "write `rotation([0, 0, 1], theta)`; in the plane the angle itself is the rotation"
                            .into()
                    }
                };
                return Err(self.errors.push(&call.func, format!("{form}\nhelp: {help}")));
            }
        };
        Ok(Val::Rotation(Rc::new(vec![turn])))
    }

    pub(super) fn angle(&mut self, val: Val, at: &Expr) -> Result<Value> {
        let angle = self.number(val, at)?;
        self.independent_of_states(&[angle], "the angle of a rotation", at)?;
        if self.graph.depends(&[angle], |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_))) {
            let message = "the angle of a rotation depends on velocities\nhelp: it is an angle, such as `theta` or `omega * t`";
            return Err(self.errors.push(at, message));
        }
        Ok(angle)
    }

    /// The unit vector of an axis, which is the same at all times.
    fn direction(&mut self, val: Val, at: &Expr) -> Result<Vector> {
        let axis = self.vector(val, at)?;
        let moves = |s| !matches!(s, Symbol::Parameter(_));
        if self.graph.depends(&axis, moves) {
            let message = "the axis of a rotation moves\nhelp: it is fixed in both frames, made of numbers and parameters; a moving axis is a product of rotations, `rotation_z(psi) * rotation_x(theta)`";
            return Err(self.errors.push(at, message));
        }
        if axis.iter().all(|n| n.is_zero()) {
            let message = "the axis of a rotation has no direction\nhelp: one of its components is not 0, as in `[0, 0, 1]`";
            return Err(self.errors.push(at, message));
        }
        let g = &mut self.graph;
        // No square may overflow, or an axis of 1e200 would count as none, without a word.
        if axis.iter().all(|n| n.is_constant()) {
            let size = |n: &Value| n.k.to_f64().abs();
            let largest = axis.into_iter().fold(Value::ZERO, |a, b| if size(&a) < size(&b) { b } else { a });
            let axis = axis.map(|n| g.div(n, largest));
            let square = inner(g, &axis, &axis);
            let norm = g.call(Function::sqrt, square);
            // The largest may have been negative.
            let norm = if largest.k.to_f64() < 0.0 { -norm } else { norm };
            return Ok(axis.map(|n| g.div(n, norm)));
        }
        let norm = axis
            .into_iter()
            .filter(|n| !n.is_zero())
            .fold(Value::ZERO, |a, b| g.call2(Function::hypot, a, b));
        Ok(axis.map(|n| g.div(n, norm)))
    }

    /// A matrix of numbers whose columns are the axes of a frame in those of its parent.
    fn orthonormal(&mut self, val: Val, at: &Expr) -> Result<Matrix> {
        let Val::Array(rows) = val else {
            let message = format!(
                "expected the matrix of a rotation, found {}\nhelp: by an angle it is `rotation([x, y, z], angle)`, or `rotation_x(angle)` and the like",
                val.kind()
            );
            return Err(self.errors.push(at, message));
        };
        let rows = rows.into_iter().map(|row| self.vector(row, at)).collect::<Result<Vec<_>>>()?;
        let Ok(matrix) = Matrix::try_from(rows) else {
            return Err(self.errors.push(
                at,
                "the matrix of a rotation has 3 rows\nhelp: write `[[1, 0, 0], [0, 1, 0], [0, 0, 1]]`",
            ));
        };
        let all: Vec<Value> = matrix.iter().flatten().copied().collect();
        if !self.graph.symbols(&all).is_empty() {
            let message = "the matrix of a rotation is made of numbers\nhelp: one that is given to `new` is a parameter, `param R: rotation`; an angle that depends on something is given to `rotation_x(angle)` and the like";
            return Err(self.errors.push(at, message));
        }
        let r: Vec<f64> = self.graph.evaluate(&all, |_| f64::NAN);
        let dot = |i: usize, j: usize| (0..3).map(|k| r[3 * i + k] * r[3 * j + k]).sum::<f64>();
        let right = (0..3).all(|i| (0..3).all(|j| (dot(i, j) - f64::from(u8::from(i == j))).abs() < 1e-12));
        let determinant: f64 = (0..3)
            .map(|i| {
                r[i] * (r[3 + (i + 1) % 3] * r[6 + (i + 2) % 3] - r[3 + (i + 2) % 3] * r[6 + (i + 1) % 3])
            })
            .sum();
        if !right || determinant < 0.0 {
            let message = match right {
                true => {
                    "this matrix is a reflection, not a rotation\nhelp: its determinant is 1; change the sign of one row"
                }
                false => {
                    "this matrix is no rotation: its rows are not of unit length and perpendicular to each other\nhelp: give 16 digits, or angles, `rotation_x(angle)`"
                }
            };
            return Err(self.errors.push(at, message));
        }
        Ok(matrix)
    }

    /// R = cos θ 1 + (1 − cos θ) n nᵀ + sin θ [n]× (Rodrigues 1840).
    fn about(&mut self, axis: Vector, angle: Value) -> Turn {
        let turns = self
            .graph
            .depends(&[angle], |s| matches!(s, Symbol::Coordinate(_) | Symbol::Binding(_) | Symbol::Time));
        let [s, c] = self.sine_and_cosine(angle);
        let g = &mut self.graph;
        let rest = g.sub(Value::ONE, c);
        let matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let product = g.mul(axis[i], axis[j]);
                // On the diagonal nᵢ² + (1 − nᵢ²) cos θ: exactly cos θ across a coordinate axis.
                if i == j {
                    let across = g.sub(Value::ONE, product);
                    let turned = g.mul(across, c);
                    return g.add(product, turned);
                }
                let k = 3 - i - j;
                let skew = g.mul(axis[k], s);
                let skew = if (i + 1) % 3 == j { -skew } else { skew };
                let both = g.mul(product, rest);
                g.add(both, skew)
            })
        });
        Turn { matrix, spin: turns.then_some(Spin::About(axis, angle)) }
    }

    /// sin and cos of an angle; of a number they are exact at multiples of a right angle.
    pub(super) fn sine_and_cosine(&mut self, angle: Value) -> [Value; 2] {
        if angle.is_constant() {
            let quarters = angle.k.to_f64() / std::f64::consts::FRAC_PI_2;
            let nearest = quarters.round();
            if (quarters - nearest).abs() <= 4.0 * f64::EPSILON * nearest.abs() {
                let sine = [0, 1, 0, -1][(nearest as i64).rem_euclid(4) as usize];
                let cosine = [1, 0, -1, 0][(nearest as i64).rem_euclid(4) as usize];
                return [sine, cosine].map(|n: i64| Value::constant(n));
            }
        }
        [Function::sin, Function::cos].map(|f| self.graph.call(f, angle))
    }

    /// The error of `R.x`.
    pub(in crate::model::elaborate) fn field_of_rotation(&mut self, field: &syn::Member) -> Reported {
        let name = field.to_token_stream().to_string();
        let message = format!(
            "a rotation has no field `{name}`\nhelp: its axes are `R * [1, 0, 0]`, `R * [0, 1, 0]` and `R * [0, 0, 1]`, and `dot(R)` is its angular velocity{READ}"
        );
        self.errors.push(field, message)
    }

    /// `R.inverse()`
    pub(in crate::model::elaborate) fn rotation_method(
        &mut self,
        name: &Ident,
        turns: &[Turn],
        arguments: &[Val],
    ) -> Result {
        if name != "inverse" {
            let hint = did_you_mean(&name.to_string(), ["inverse"]);
            let message = format!(
                "a rotation has no method `{name}`{hint}\nhelp: rotations are multiplied, `A * B` and `A * [x, y, z]`, and reversed, `A.inverse()`{}",
                if PARAMETERS.contains(&name.to_string().as_str()) { READ } else { "" }
            );
            return Err(self.errors.push(name, message));
        }
        self.arity("inverse", 0, arguments.len(), name)?;
        let reversed = turns.iter().rev().map(|turn| {
            // The axis of a single turn is the same in both frames, but not that of a turn which constants are part of.
            let spin = turn.spin.map(|spin| match spin {
                Spin::About(axis, angle) => Spin::About(turned(&mut self.graph, &turn.matrix, &axis), -angle),
                Spin::Free(omega) => Spin::Free(turned(&mut self.graph, &turn.matrix, &omega).map(|x| -x)),
            });
            Turn { matrix: transposed(&turn.matrix), spin }
        });
        Ok(Val::Rotation(Rc::new(reversed.collect())))
    }

    /// `R * [x, y, z]`
    pub(in crate::model::elaborate) fn rotated(&mut self, turns: &[Turn], x: Vector) -> Val {
        let x = turns.iter().rev().fold(x, |x, turn| turned(&mut self.graph, &turn.matrix, &x));
        Val::Array(x.map(Val::Number).to_vec())
    }
}
