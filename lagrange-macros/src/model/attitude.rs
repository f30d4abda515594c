//! Attitudes by three numbers that no attitude is singular for: Rodrigues' modified parameters.
//!
//! σ = n tan(θ/4) for the turn by θ about the unit vector n. With D = 1 + |σ|² *half* the unit quaternion of the
//! attitude is (c, v) = (1/D − ½, σ/D), the stereographic projection of S³ from −1 (Wiener 1962; Marandi and
//! Modi, *Acta Astronautica* 15, 1987). The matrix and the angular velocity in the turned axes are
//!
//!   R = 1 + 8 c [v]× + 8 [v]×²,   ω = 8 (c a − v × a + (v·a) σ),   a = σ̇/D.
//!
//! σ and −σ/|σ|² are quaternions of opposite signs, so the same attitude: one formula holds for all of R³, and who
//! steps takes the smaller of the two (the runtime's `attitude`). The metric is conformal: ω is σ̇ turned and
//! multiplied by 4/D, so that the inverse is a transpose,
//!
//!   σ̇ = K ω,   K x = ½ D (c x + v × x + (v·x) σ),
//!
//! and the accelerations are those of ω and of the geodesics of S³:
//!
//!   σ̈ = ½ D (c ω̇ + v × ω̇ + (D (v·ω̇) − 4 a·σ̇) v + 8 (v·a) σ̇).
//!
//! No sine, no root, one division.

use super::frames::{Matrix, Vector, cross, inner};
use crate::graph::{Graph, Number, Symbol, Value};

/// An attitude by its parameters.
#[derive(Clone, Copy)]
pub struct Parameters {
    pub sigma: Vector,
    /// D and 1/D
    pub whole: Value,
    pub inverse: Value,
    /// c and v, of half the quaternion, so that powers of 2 stand in front of whole sums.
    pub scalar: Value,
    pub vector: Vector,
}

const HALF: Number = Number::Ratio(1, 2);
const EIGHT: Number = Number::Ratio(8, 1);

impl Parameters {
    pub fn new(g: &mut Graph, sigma: Vector) -> Parameters {
        let square = inner(g, &sigma, &sigma);
        let whole = g.add(Value::ONE, square);
        let inverse = g.recip(whole);
        let scalar = g.sub(inverse, Value::ONE.scaled(HALF));
        let vector = sigma.map(|s| g.mul(s, inverse));
        Parameters { sigma, whole, inverse, scalar, vector }
    }

    /// R, by rows.
    pub fn matrix(&self, g: &mut Graph) -> Matrix {
        matrix(g, self.scalar, &self.vector)
    }

    /// ω
    pub fn angular_velocity(&self, g: &mut Graph, rate: &Vector) -> Vector {
        let a = rate.map(|rate| g.mul(self.inverse, rate));
        let (along, across) = (inner(g, &self.vector, &a), cross(g, &self.vector, &a));
        std::array::from_fn(|i| {
            let (straight, radial) = (g.mul(self.scalar, a[i]), g.mul(along, self.sigma[i]));
            let rest = g.sub(straight, across[i]);
            g.add(rest, radial).scaled(EIGHT)
        })
    }

    /// σ̈ for an ω̇.
    pub fn accelerations(&self, g: &mut Graph, rate: &Vector, x: &Vector) -> Vector {
        let a = rate.map(|rate| g.mul(self.inverse, rate));
        let (along, square) = (inner(g, &self.vector, &a), inner(g, &a, rate));
        let forward = along.scaled(EIGHT);
        let radial = inner(g, &self.vector, x);
        let radial = g.mul(self.whole, radial);
        let radial = g.sub(radial, square.scaled(Number::Ratio(4, 1)));
        let across = cross(g, &self.vector, x);
        std::array::from_fn(|i| {
            let products = [(self.scalar, x[i]), (radial, self.vector[i]), (forward, rate[i])];
            let sum = products.into_iter().fold(across[i], |sum, (k, x)| {
                let product = g.mul(k, x);
                g.add(sum, product)
            });
            g.mul(self.whole, sum).scaled(HALF)
        })
    }
}

/// Rates of half a quaternion, ċ = −½ v·ω and v̇ = ½ (c ω + v × ω).
pub fn rates(g: &mut Graph, c: Value, v: &Vector, omega: &Vector) -> [Value; 4] {
    let (along, across) = (inner(g, v, omega), cross(g, v, omega));
    let straight = omega.map(|omega| g.mul(c, omega));
    let [x, y, z] = [0, 1, 2].map(|i| g.add(straight[i], across[i]).scaled(HALF));
    [-along.scaled(HALF), x, y, z]
}

/// R of half a quaternion, by rows.
pub fn matrix(g: &mut Graph, c: Value, v: &Vector) -> Matrix {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if i == j {
                let squares = [(i + 1) % 3, (i + 2) % 3].map(|k| g.mul(v[k], v[k]));
                let sum = g.add(squares[0], squares[1]).scaled(EIGHT);
                return g.sub(Value::ONE, sum);
            }
            let (product, skew) = (g.mul(v[i], v[j]), g.mul(c, v[3 - i - j]));
            let sum = if (i + 1) % 3 == j { g.sub(product, skew) } else { g.add(product, skew) };
            sum.scaled(EIGHT)
        })
    })
}

/// The axes of a rotation by rows, which are the bindings after those of its ω.
pub fn axes(spin: [usize; 3]) -> [[Symbol; 3]; 3] {
    [0, 1, 2].map(|r| [0, 1, 2].map(|k| Symbol::Binding(spin[2] + 1 + 3 * r + k)))
}

/// γ of ω, its derivative while σ̈ = 0: −B σ̈ of a motion that coasts.
pub fn drift(g: &mut Graph, parameters: &Parameters, rate: &Vector) -> Vector {
    let coasting = parameters.accelerations(g, rate, &[Value::ZERO; 3]);
    parameters.angular_velocity(g, &coasting).map(|x| -x)
}

/// Derivative of the axes R at rest of ω̇: their rows r have ṙ = r × ω.
pub fn turning(g: &mut Graph, row: &Vector, omega: &Vector) -> [Vector; 2] {
    let rate = cross(g, row, omega);
    [rate, cross(g, &rate, omega)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All formulas against the derivative of R along a motion, on numbers.
    #[test]
    fn parameters_are_those_of_a_rotation() {
        let g = &mut Graph::default();
        let [sigma, rate] = [
            std::array::from_fn(|i| g.symbol(Symbol::Coordinate(i))),
            std::array::from_fn(|i| g.symbol(Symbol::Velocity(i))),
        ];
        let at = Parameters::new(g, sigma);
        let matrix = at.matrix(g);
        let omega = at.angular_velocity(g, &rate);
        let entries: Vec<Value> = matrix.iter().flatten().copied().collect();
        let moved = g.forward(&entries, |s| match s {
            Symbol::Coordinate(i) => Some(rate[i]),
            _ => None,
        });
        let mut zero = Vec::new();
        for i in 0..3 {
            let across = cross(g, &matrix[i], &omega);
            for j in 0..3 {
                zero.push(g.sub(moved[3 * i + j], across[j]));
                let product = inner(g, &matrix[i], &matrix[j]);
                zero.push(g.sub(product, if i == j { Value::ONE } else { Value::ZERO }));
            }
        }
        // dω/dt with σ̈ = K ω̇ + what coasts, where ω̇ = 0, vanishes.
        let coasting = at.accelerations(g, &rate, &[Value::ZERO; 3]);
        let omega_rate = g.forward(&omega, |s| match s {
            Symbol::Coordinate(i) => Some(rate[i]),
            Symbol::Velocity(i) => Some(coasting[i]),
            _ => None,
        });
        zero.extend(omega_rate);
        // K B σ̇ = σ̇, where K ω is what is left of σ̈ without what coasts.
        let both = at.accelerations(g, &rate, &omega);
        for i in 0..3 {
            let back = g.sub(both[i], coasting[i]);
            zero.push(g.sub(back, rate[i]));
        }
        let values = g.evaluate(&zero, |s| match s {
            Symbol::Coordinate(i) => [0.3, -1.2, 0.7][i],
            Symbol::Velocity(i) => [-0.4, 0.9, 1.3][i],
            _ => f64::NAN,
        });
        let worst = values.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()));
        assert!(worst < 1e-14, "{worst}");
        // A quarter turn about z takes x to y.
        let quarter = [0.0, 0.0, (std::f64::consts::PI / 8.0).tan()];
        let x = g.evaluate(&[matrix[0][0], matrix[1][0], matrix[2][0]], |s| match s {
            Symbol::Coordinate(i) => quarter[i],
            _ => 0.0,
        });
        assert!(x.iter().zip([0.0, 1.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-15), "{x:?}");
    }
}
