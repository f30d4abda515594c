//! Systems written by hand, in the form that `lagrangian!` emits, for the tests of this crate.

use lagrange_runtime::__private::solved;
use lagrange_runtime::failure::Coordinate;
use lagrange_runtime::traits::{
    Energies, Facts, Independent, Jacobian, Lagrangian, LegendreTransform, Separable, System,
};
use lagrange_runtime::{Scalar, State};
use nalgebra::{SMatrix, SVector};

/// `L = ½ q̇ᵀ M(q) q̇ − V(q)`: what is left to say of such a system.
trait Natural<S: Scalar, const N: usize> {
    fn mass(&self, q: &SVector<S, N>) -> SMatrix<S, N, N>;
    fn potential(&self, q: &SVector<S, N>) -> S;
    /// `∂L/∂q`.
    fn force(&self, q: &SVector<S, N>, qd: &SVector<S, N>) -> SVector<S, N>;
    /// `(∂p/∂q) q̇`.
    fn bias(&self, _: &SVector<S, N>, _: &SVector<S, N>) -> SVector<S, N> {
        SVector::from_fn(|_, _| S::zero())
    }
}

macro_rules! system {
    (<$($generic:ident)?> $name:ty, $n:expr) => {
        impl<S: Scalar $(, const $generic: usize)?> System<{ $n }> for $name {
            type Scalar = S;
            const AUTONOMOUS: bool = true;
            fn accel(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, _: S) -> SVector<S, { $n }> {
                let right = Natural::force(self, q, qd) - Natural::bias(self, q, qd);
                solution(&self.mass(q), right)
            }
        }

        impl<S: Scalar $(, const $generic: usize)?> Lagrangian<{ $n }> for $name {
            const FACTS: Facts = Facts {
                name: stringify!($name),
                scleronomic: true,
                autonomous: true,
                conservative: true,
                quadratic: true,
                quadratic_forces: true,
                ..Facts::UNKNOWN
            };
            fn lagrangian(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, t: S) -> S {
                self.kinetic(q, qd, t) - Natural::potential(self, q)
            }
            fn momenta(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, _: S) -> SVector<S, { $n }> {
                let mass = self.mass(q);
                SVector::from_fn(|i, _| (0..{ $n }).fold(S::zero(), |sum, j| sum + mass[(i, j)] * qd[j]))
            }
            fn energy_function(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, t: S) -> S {
                self.kinetic(q, qd, t) + Natural::potential(self, q)
            }
            fn inertia(&self, q: &SVector<S, { $n }>, _: &SVector<S, { $n }>, _: S) -> SMatrix<S, { $n }, { $n }> {
                self.mass(q)
            }
            fn convective_momentum_rate(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, _: S) -> SVector<S, { $n }> {
                Natural::bias(self, q, qd)
            }
            fn momentum_rate(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, _: S) -> SVector<S, { $n }> {
                Natural::force(self, q, qd)
            }
            fn dissipation(&self, _: &SVector<S, { $n }>, _: &SVector<S, { $n }>, _: S) -> S {
                S::zero()
            }
            fn power(&self, _: &SVector<S, { $n }>, _: &SVector<S, { $n }>, _: S) -> S {
                S::zero()
            }
            fn jacobian(&self, _: &SVector<S, { $n }>, _: &SVector<S, { $n }>, _: S) -> Jacobian<S, { $n }> {
                unimplemented!("no test of this crate asks for it")
            }
        }

        impl<S: Scalar $(, const $generic: usize)?> Energies<{ $n }> for $name {
            fn kinetic(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, t: S) -> S {
                let p = self.momenta(q, qd, t);
                (0..{ $n }).fold(S::zero(), |sum, i| sum + p[i] * qd[i]) * S::from_f64(0.5)
            }
            fn potential(&self, q: &SVector<S, { $n }>, _: S) -> S {
                Natural::potential(self, q)
            }
            fn energy(&self, q: &SVector<S, { $n }>, qd: &SVector<S, { $n }>, t: S) -> S {
                self.energy_function(q, qd, t)
            }
        }

        impl<S: Scalar $(, const $generic: usize)?> Independent<{ $n }> for $name {}

        impl<S: Scalar $(, const $generic: usize)?> LegendreTransform<{ $n }> for $name {
            fn velocities(&self, q: &SVector<S, { $n }>, p: &SVector<S, { $n }>, _: S) -> SVector<S, { $n }> {
                solution(&self.mass(q), *p)
            }
        }
    };
}

/// The x with `A x = b`, where A is positive definite.
fn solution<S: Scalar, const N: usize>(a: &SMatrix<S, N, N>, b: SVector<S, N>) -> SVector<S, N> {
    let mut lower = [S::zero(); 45];
    for i in 0..N {
        for j in 0..=i {
            lower[i * (i + 1) / 2 + j] = a[(i, j)];
        }
    }
    solved(&lower, b.into())
}

fn diagonal<S: Scalar, const N: usize>(m: impl Fn(usize) -> S) -> SMatrix<S, N, N> {
    SMatrix::from_fn(|i, j| if i == j { m(i) } else { S::zero() })
}

/// `T = ½ m l² θ̇²`, `V = −m g l cos θ`.
#[derive(Clone, Copy, Debug)]
pub struct Pendulum<S = f64> {
    pub m: S,
    pub l: S,
    pub g: S,
}

impl<S: Scalar> Default for Pendulum<S> {
    fn default() -> Self {
        Pendulum { m: S::one(), l: S::one(), g: S::one() }
    }
}

impl<S: Scalar> Natural<S, 1> for Pendulum<S> {
    fn mass(&self, _: &SVector<S, 1>) -> SMatrix<S, 1, 1> {
        SMatrix::from([[self.m * self.l * self.l]])
    }
    fn potential(&self, q: &SVector<S, 1>) -> S {
        -self.m * self.g * self.l * q[0].cos()
    }
    fn force(&self, q: &SVector<S, 1>, _: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([-self.m * self.g * self.l * q[0].sin()])
    }
}

system!(<> Pendulum<S>, 1);
impl<S: Scalar> Separable<1> for Pendulum<S> {}

/// Kepler's problem in polar coordinates (r, φ), μ = 1: `T = ½(ṙ² + r² φ̇²)`, `V = −1/r`. Not separable.
#[derive(Clone, Copy, Debug)]
pub struct Polar<S = f64> {
    pub mu: S,
}

impl<S: Scalar> Default for Polar<S> {
    fn default() -> Self {
        Polar { mu: S::one() }
    }
}

impl<S: Scalar> Natural<S, 2> for Polar<S> {
    fn mass(&self, q: &SVector<S, 2>) -> SMatrix<S, 2, 2> {
        diagonal(|i| if i == 0 { S::one() } else { q[0] * q[0] })
    }
    fn potential(&self, q: &SVector<S, 2>) -> S {
        -self.mu / q[0]
    }
    fn force(&self, q: &SVector<S, 2>, qd: &SVector<S, 2>) -> SVector<S, 2> {
        SVector::from([q[0] * qd[1] * qd[1] - self.mu / (q[0] * q[0]), S::zero()])
    }
    fn bias(&self, q: &SVector<S, 2>, qd: &SVector<S, 2>) -> SVector<S, 2> {
        SVector::from([S::zero(), S::from_f64(2.0) * q[0] * qd[0] * qd[1]])
    }
}

system!(<> Polar<S>, 2);

/// Kepler's problem in Cartesian coordinates. Separable.
#[derive(Clone, Copy, Debug)]
pub struct Plane<S = f64> {
    pub mu: S,
}

impl<S: Scalar> Default for Plane<S> {
    fn default() -> Self {
        Plane { mu: S::one() }
    }
}

impl<S: Scalar> Natural<S, 2> for Plane<S> {
    fn mass(&self, _: &SVector<S, 2>) -> SMatrix<S, 2, 2> {
        diagonal(|_| S::one())
    }
    fn potential(&self, q: &SVector<S, 2>) -> S {
        -self.mu / (q[0] * q[0] + q[1] * q[1]).sqrt()
    }
    fn force(&self, q: &SVector<S, 2>, _: &SVector<S, 2>) -> SVector<S, 2> {
        let square = q[0] * q[0] + q[1] * q[1];
        let factor = -self.mu / (square * square.sqrt());
        SVector::from([factor * q[0], factor * q[1]])
    }
}

system!(<> Plane<S>, 2);
impl<S: Scalar> Separable<2> for Plane<S> {}

/// Two equal pendulums of length 1 in a row, g = 1. Not separable, chaotic.
#[derive(Clone, Copy, Debug)]
pub struct DoublePendulum<S = f64> {
    pub g: S,
}

impl<S: Scalar> Default for DoublePendulum<S> {
    fn default() -> Self {
        DoublePendulum { g: S::one() }
    }
}

impl<S: Scalar> Natural<S, 2> for DoublePendulum<S> {
    fn mass(&self, q: &SVector<S, 2>) -> SMatrix<S, 2, 2> {
        let c = (q[0] - q[1]).cos();
        SMatrix::from([[S::from_f64(2.0), c], [c, S::one()]])
    }
    fn potential(&self, q: &SVector<S, 2>) -> S {
        -self.g * (S::from_f64(2.0) * q[0].cos() + q[1].cos())
    }
    fn force(&self, q: &SVector<S, 2>, qd: &SVector<S, 2>) -> SVector<S, 2> {
        let coupling = qd[0] * qd[1] * (q[0] - q[1]).sin();
        SVector::from([-coupling - S::from_f64(2.0) * self.g * q[0].sin(), coupling - self.g * q[1].sin()])
    }
    fn bias(&self, q: &SVector<S, 2>, qd: &SVector<S, 2>) -> SVector<S, 2> {
        let factor = -(q[0] - q[1]).sin() * (qd[0] - qd[1]);
        SVector::from([factor * qd[1], factor * qd[0]])
    }
}

system!(<> DoublePendulum<S>, 2);

/// Hénon and Heiles 1964: `V = ½(x² + y²) + x² y − y³/3`. Separable.
#[derive(Clone, Copy, Debug)]
pub struct HenonHeiles<S = f64> {
    pub epsilon: S,
}

impl<S: Scalar> Default for HenonHeiles<S> {
    fn default() -> Self {
        HenonHeiles { epsilon: S::one() }
    }
}

impl<S: Scalar> Natural<S, 2> for HenonHeiles<S> {
    fn mass(&self, _: &SVector<S, 2>) -> SMatrix<S, 2, 2> {
        diagonal(|_| S::one())
    }
    fn potential(&self, q: &SVector<S, 2>) -> S {
        let (x, y) = (q[0], q[1]);
        (x * x + y * y) * S::from_f64(0.5) + self.epsilon * (x * x * y - y * y * y / S::from_f64(3.0))
    }
    fn force(&self, q: &SVector<S, 2>, _: &SVector<S, 2>) -> SVector<S, 2> {
        let (x, y) = (q[0], q[1]);
        SVector::from([-x - S::from_f64(2.0) * self.epsilon * x * y, -y - self.epsilon * (x * x - y * y)])
    }
}

system!(<> HenonHeiles<S>, 2);
impl<S: Scalar> Separable<2> for HenonHeiles<S> {}

/// N masses in a row between walls, all springs 1: `V = ½ Σ (qᵢ₊₁ − qᵢ)²`. One mass alone swings with ω² = 2.
#[derive(Clone, Copy, Debug)]
pub struct Chain<S, const N: usize> {
    pub k: S,
}

impl<S: Scalar, const N: usize> Natural<S, N> for Chain<S, N> {
    fn mass(&self, _: &SVector<S, N>) -> SMatrix<S, N, N> {
        diagonal(|_| S::one())
    }
    fn potential(&self, q: &SVector<S, N>) -> S {
        let at = |i: usize| if i == 0 || i == N + 1 { S::zero() } else { q[i - 1] };
        (0..=N).fold(S::zero(), |sum, i| sum + (at(i + 1) - at(i)) * (at(i + 1) - at(i)))
            * self.k
            * S::from_f64(0.5)
    }
    fn force(&self, q: &SVector<S, N>, _: &SVector<S, N>) -> SVector<S, N> {
        let at = |i: usize| if i == 0 || i == N + 1 { S::zero() } else { q[i - 1] };
        SVector::from_fn(|i, _| self.k * (at(i) + at(i + 2) - at(i + 1) - at(i + 1)))
    }
}

system!(<N> Chain<S, N>, N);
impl<S: Scalar, const N: usize> Separable<N> for Chain<S, N> {}

/// One coordinate, made of its accelerations `q̈(q, q̇, t)` alone. (By its address: runs are compiled once for all.)
#[derive(Clone, Copy)]
pub struct Law<'a>(pub &'a dyn Fn(f64, f64, f64) -> f64);

impl System<1> for Law<'_> {
    type Scalar = f64;
    fn accel(&self, q: &SVector<f64, 1>, qd: &SVector<f64, 1>, t: f64) -> SVector<f64, 1> {
        [(self.0)(q[0], qd[0], t)].into()
    }
}

/// The first normal mode of the chain: `qᵢ = sin(iπ/(N+1)) cos ωt`, `ω = 2 sin(π/(2(N+1)))`.
pub fn mode<const N: usize>(t: f64) -> State<f64, N> {
    let angle = core::f64::consts::PI / (N + 1) as f64;
    let omega = 2.0 * (0.5 * angle).sin();
    let shape = SVector::<f64, N>::from_fn(|i, _| ((i + 1) as f64 * angle).sin());
    State { t, q: shape * (omega * t).cos(), qd: shape * (-omega * (omega * t).sin()) }
}

/// An ellipse of eccentricity 0.3 and period 2π, at its pericentre, in Cartesian coordinates.
pub const ELLIPSE: State<f64, 2> = plane([0.7, 0.0], [0.0, 1.3627702877384937]);

/// A state of the double pendulum that moves in both coordinates.
pub const DOUBLE: State<f64, 2> = plane([1.0, -0.4], [0.2, 0.5]);

const fn plane(q: [f64; 2], qd: [f64; 2]) -> State<f64, 2> {
    State { t: 0.0, q: SVector::<f64, 2>::new(q[0], q[1]), qd: SVector::<f64, 2>::new(qd[0], qd[1]) }
}

/// The ellipse at time t by Kepler's equation `E − e sin E = t`, solved by Newton's method.
pub fn ellipse<S: Scalar>(t: S) -> State<S, 2> {
    let e = S::from_f64(3.0) / S::from_f64(10.0);
    let mut anomaly = t;
    for _ in 0..20 {
        anomaly -= (anomaly - e * anomaly.sin() - t) / (S::one() - e * anomaly.cos());
    }
    let (s, c) = anomaly.sin_cos();
    let (b, rate) = ((S::one() - e * e).sqrt(), S::one() / (S::one() - e * c));
    State::new(t, [c - e, b * s], [-s * rate, b * c * rate])
}

/// The same in polar coordinates, with φ counted on from turn to turn.
pub fn polar(t: f64) -> State<f64, 2> {
    let State { q, qd, .. } = ellipse(t);
    let r = q.norm();
    let turns = (t / core::f64::consts::TAU).round();
    let phi = q[1].atan2(q[0]) + turns * core::f64::consts::TAU;
    State::new(t, [r, phi], [q.dot(&qd) / r, (q[0] * qd[1] - q[1] * qd[0]) / (r * r)])
}

/// The period of a pendulum (g = l = 1) of amplitude θ: `2π / agm(1, cos θ/2)` (Gauss).
pub fn pendulum_period(amplitude: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    core::f64::consts::TAU / a
}

/// A coordinate, to compare with.
pub const fn coordinate(index: usize, name: &'static str) -> Coordinate {
    Coordinate { index, name }
}
