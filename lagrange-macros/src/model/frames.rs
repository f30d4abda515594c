//! Frames in space as velocities: what the equations have to know of them.
//!
//! A frame has the configuration (p, R) ∈ SE(3), and moves with the angular velocity ω and the velocity v of its
//! origin, both in its own axes: ṗ = R v, Ṙ = R [ω]×. The components of ω and v are *quasi-velocities*: linear in
//! earlier rates,
//!
//!   ω = Rᵣᵀ ωₚ + n θ̇,   v = Rᵣᵀ (vₚ + ωₚ × r + ṙ)
//!
//! in a parent at r, turned by Rᵣ about n through θ; but not rates of any positions. They are bindings without a value.
//! What L says of p and R in the axes of the world are bindings with values, whose rates are written in ω and v.

use crate::graph::{Graph, Value};

/// Three components.
pub type Vector = [Value; 3];
/// Rows of a matrix.
pub type Matrix = [Vector; 3];

/// Kind of the motion of a binding.
#[derive(Clone, Copy)]
pub enum Motion {
    /// A position u = φ(q, t), with the rate φ̇.
    Position,
    /// A position whose rate is written in quasi-velocities.
    Carried,
    /// The same, with what its second derivative is at rest of the accelerations.
    Turning(Value),
    /// A quasi-velocity, with what its rate is at rest of the accelerations that it is linear in.
    Quasi(Value),
}

/// The quasi-velocities of a system, by the bindings that are their components.
#[derive(Clone, Default)]
pub struct Frames {
    /// Angular velocities in own axes; a component that is always 0 is none.
    pub spins: Vec<[Option<usize>; 3]>,
    pub points: Vec<Point>,
}

/// The velocity of a point in the axes of a frame. Its accelerations are counted as those of the point in these axes,
/// v̇ + ω × v, not as v̇.
#[derive(Clone)]
pub struct Point {
    /// The angular velocity of the axes, unless they never turn.
    pub spin: Option<usize>,
    pub velocity: [usize; 3],
    /// Its coordinates in the axes of the world, as far as they are used.
    pub place: [Option<usize>; 3],
    /// Axes of the frame by their components in the world, by rows, as far as they are used.
    pub axes: [Option<Vector>; 3],
    /// Is its velocity not carried on from that of another point?
    pub first: bool,
}

pub fn cross(g: &mut Graph, a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (plus, minus) = (g.mul(a[j], b[k]), g.mul(a[k], b[j]));
        g.sub(plus, minus)
    })
}

pub fn plus(g: &mut Graph, a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| g.add(a[i], b[i]))
}

pub fn inner(g: &mut Graph, a: &Vector, b: &Vector) -> Value {
    (0..3).fold(Value::ZERO, |sum, i| {
        let product = g.mul(a[i], b[i]);
        g.add(sum, product)
    })
}

/// R x
pub fn turned(g: &mut Graph, r: &Matrix, x: &Vector) -> Vector {
    std::array::from_fn(|i| inner(g, &r[i], x))
}

/// Rᵀ x
pub fn turned_back(g: &mut Graph, r: &Matrix, x: &Vector) -> Vector {
    std::array::from_fn(|i| inner(g, &[r[0][i], r[1][i], r[2][i]], x))
}

pub fn product(g: &mut Graph, a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transposed(b);
    std::array::from_fn(|i| std::array::from_fn(|j| inner(g, &a[i], &columns[j])))
}

pub fn transposed(r: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| r[j][i]))
}

pub const IDENTITY: Matrix = [
    [Value::ONE, Value::ZERO, Value::ZERO],
    [Value::ZERO, Value::ONE, Value::ZERO],
    [Value::ZERO, Value::ZERO, Value::ONE],
];
