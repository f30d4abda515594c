//! Rotations that are coordinates (`coord R: rotation;`), as values and as bindings.

use super::*;
use crate::model::attitude::{Parameters, drift, turning};

impl Space {
    /// The rotation of an attitude, by its place among those of the system.
    pub(in crate::model::elaborate) fn attitude(&self, i: usize) -> Val {
        Val::Rotation(Rc::new(vec![self.attitudes[i].clone()]))
    }
}

/// The rotation of parameters that do not change.
pub(in crate::model::elaborate) fn fixed(g: &mut Graph, sigma: Vector) -> Val {
    let matrix = Parameters::new(g, sigma).matrix(g);
    Val::Rotation(Rc::new(vec![Turn { matrix, spin: None }]))
}

impl Elaborator<'_> {
    /// Makes the bindings of all attitudes: ω, and the components of the axes, whose rates are written in ω. Nothing
    /// else names their parameters.
    pub(in crate::model) fn attitudes(&mut self) {
        for i in 0..self.found.attitudes.len() {
            let Attitude { name, index, first, .. } = self.found.attitudes[i].clone();
            let label = indexed(&name.to_string(), index);
            let sigma = [0, 1, 2].map(|k| self.graph.symbol(Symbol::Coordinate(first + k)));
            let rate = [0, 1, 2].map(|k| self.graph.symbol(Symbol::Velocity(first + k)));
            let at = Parameters::new(&mut self.graph, sigma);
            let psi = at.angular_velocity(&mut self.graph, &rate);
            let gamma = drift(&mut self.graph, &at, &rate);
            let spin: [usize; 3] = std::array::from_fn(|k| {
                self.carried(format!("{label}_omega[{k}]"), Value::ZERO, psi[k], Motion::Quasi(gamma[k]))
            });
            let omega = spin.map(|k| self.rate_of(k));
            let values = at.matrix(&mut self.graph);
            let mut row = |r: usize| {
                let [rates, seconds] = turning(&mut self.graph, &values[r], &omega);
                let bindings: [usize; 3] = std::array::from_fn(|k| {
                    let name = format!("{label}_axes[{r}][{k}]");
                    self.carried(name, values[r][k], rates[k], Motion::Turning(seconds[k]))
                });
                bindings.map(|k| self.graph.symbol(Symbol::Binding(k)))
            };
            let matrix = [row(0), row(1), row(2)];
            self.space.spins.push(spin.map(Some));
            self.space.attitudes.push(Turn { matrix, spin: Some(Spin::Free(omega)) });
            self.found.attitudes[i].spin = Some(spin);
        }
    }

    /// A relative angular velocity, in the turned axes.
    pub(super) fn relative(&mut self, spin: &Spin) -> Vector {
        match *spin {
            Spin::Free(omega) => omega,
            Spin::About(axis, angle) => {
                let rate = self.velocity(angle);
                axis.map(|n| self.graph.mul(n, rate))
            }
        }
    }

    /// The bindings that are these angular velocities.
    pub(super) fn known_spin(&mut self, psi: &Vector) -> Option<usize> {
        let g = &mut self.graph;
        let is = |spin: &[Option<usize>; 3]| {
            spin.iter().zip(psi).all(|(k, psi)| k.is_some_and(|k| g.symbol(Symbol::Rate(k)) == *psi))
        };
        self.space.spins.iter().position(is)
    }

    /// `dot(R)`: the angular velocity of the turned axes in those that they are turned in, by its components in the
    /// turned axes.
    pub(in crate::model::elaborate) fn rate_of_rotation(&mut self, turns: &[Turn], at: &Expr) -> Result {
        if turns.iter().all(|turn| turn.spin.is_none()) {
            if self.is_derived() {
                return Ok(Val::Array(vec![Val::Number(Value::ZERO); 3]));
            }
            let message = "this rotation does not turn, so its angular velocity is 0\nhelp: remove this term, or give a rotation by a coordinate";
            return Err(self.errors.push(at, message));
        }
        let mut omega = [Value::ZERO; 3];
        for turn in turns {
            omega = turned_back(&mut self.graph, &turn.matrix, &omega);
            if let Some(spin) = turn.spin {
                let relative = self.relative(&spin);
                omega = plus(&mut self.graph, &omega, &relative);
            }
        }
        Ok(Val::Array(omega.map(Val::Number).to_vec()))
    }

    /// The attitudes that an expression names, if it names any.
    pub(in crate::model::elaborate) fn turned_targets(
        &mut self,
        expression: &Expr,
    ) -> Result<Option<Vec<usize>>> {
        let (base, index, known) = self.named(expression);
        let Some(Entry::Rotation { first, length }) = known else { return Ok(None) };
        match (length, index) {
            (None, None) => Ok(Some(vec![first])),
            (Some(n), None) => Ok(Some((first..first + n).collect())),
            (Some(n), Some(index)) => Ok(Some(vec![first + self.index(index, n)?])),
            (None, Some(_)) => {
                let name = base.to_token_stream();
                let message = format!(
                    "the rotation `{name}` has no elements\nhelp: give all three moments, in the turned axes, `Q[{name}] = [Mx, My, Mz];`"
                );
                Err(self.errors.push(expression, message))
            }
        }
    }

    /// `Q[R] = [Mx, My, Mz];`: moments in the turned axes, which do work with ω.
    pub(in crate::model::elaborate) fn moments_on(
        &mut self,
        attitudes: &[usize],
        at: &Expr,
        value: &Expr,
    ) -> Result<()> {
        let moments = match (self.evaluate(value)?, attitudes) {
            (Val::Array(items), [_, _, ..]) if items.len() == attitudes.len() => {
                items.into_iter().map(|item| self.vector(item, value)).collect::<Result<Vec<_>>>()?
            }
            (one, [_]) => vec![self.vector(one, value)?],
            (other, _) => {
                let message = format!(
                    "{} for {}\nhelp: each rotation has its moments in the turned axes, `[[Mx, My, Mz], …]`",
                    other.kind(),
                    counted(attitudes.len(), "rotation")
                );
                return Err(self.errors.push(value, message));
            }
        };
        for (&i, moment) in attitudes.iter().zip(moments) {
            let Attitude { name, index, first, spin } = self.found.attitudes[i].clone();
            if self.found.applied[first].replace(Value::ZERO).is_some() {
                let label = indexed(&name.to_string(), index);
                let message = format!(
                    "a second `Q[{label}]`\nhelp: add the moments in one statement, `Q[{label}] = [… + …, …, …];`"
                );
                self.errors.push(at, message);
            }
            for (k, moment) in spin.into_iter().flatten().zip(moment) {
                let omega = self.rate_of(k);
                self.found.frame_forces.push((moment, omega));
            }
        }
        Ok(())
    }
}
