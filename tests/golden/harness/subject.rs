//! A system without its type. Everything that the harness does with a system goes through two function pointers, one
//! for doubles and one for dual numbers, so that it is compiled once and not once for every system.

use super::{INPUT, Reference, TOLERANCE, largest, trajectory};
use lagrange_runtime::{Dual, Facts, Lagrangian, Scalar, System, traits::TaylorSeries};
use nalgebra::{DMatrix, DVector, SVector};

/// One state of a system.
#[derive(Clone, Debug)]
pub struct State {
    pub q: Vec<f64>,
    pub qd: Vec<f64>,
    pub t: f64,
}

impl State {
    pub fn new(q: &[f64], qd: &[f64], t: f64) -> Self {
        State { q: q.to_vec(), qd: qd.to_vec(), t }
    }
}

/// A system together with the file of its reference digits. `golden!` implements it.
pub trait Golden<const N: usize> {
    /// The system over another scalar.
    type Over<S: Scalar>: Lagrangian<N, Scalar = S>;

    /// Name of the file, without `.json`.
    const REFERENCE: &'static str;

    /// The system with the parameters of the file, which are asked for by their names there.
    fn with<S: Scalar>(parameter: impl Fn(&str) -> S) -> Self::Over<S>;

    /// `[T, V, E]`; none where the system is given by L.
    fn energies<S: Scalar>(
        _system: &Self::Over<S>,
        _q: &SVector<S, N>,
        _qd: &SVector<S, N>,
        _t: S,
    ) -> Option<[S; 3]> {
        None
    }

    /// The Taylor series of the motion; none where a function is not written in the language.
    fn series(
        _system: &Self::Over<f64>,
        _at: &lagrange_runtime::State<f64, N>,
        _order: usize,
    ) -> Option<TaylorSeries<f64, N, ROOM>> {
        None
    }

    /// The velocities of given momenta; none where constraints leave no such map.
    fn velocities<S: Scalar>(
        _system: &Self::Over<S>,
        _q: &SVector<S, N>,
        _p: &SVector<S, N>,
        _t: S,
    ) -> Option<SVector<S, N>> {
        None
    }

    /// `[λ, Aᵀλ, f, A q̇ + b]`; none where there are no constraints.
    fn constraints<S: Scalar>(
        _system: &Self::Over<S>,
        _q: &SVector<S, N>,
        _qd: &SVector<S, N>,
        _t: S,
    ) -> Option<[Vec<S>; 4]> {
        None
    }
}

/// Room for the coefficients of `Taylor`.
pub const ROOM: usize = 24;

/// Says which file belongs to a system and how its parameters are called there.
///
/// `golden!(Pendulum<1>, "file", |p| Pendulum { m: p("m"), l: p("l"), g: p("g") });`, with `, given L` at the end for
/// a system that was given by L, `, constrained` for one with constraints, and `, with an extern fn`.
macro_rules! golden {
    ($system:ident<$n:literal>, $file:literal, |$parameter:ident| $with:expr) => {
        golden! { @implement $system $n $file $parameter ($with) energies velocities series }
    };
    ($system:ident<$n:literal>, $file:literal, |$parameter:ident| $with:expr, with an extern fn) => {
        golden! { @implement $system $n $file $parameter ($with) energies velocities }
    };
    ($system:ident<$n:literal>, $file:literal, |$parameter:ident| $with:expr, given L) => {
        golden! { @implement $system $n $file $parameter ($with) velocities series }
    };
    ($system:ident<$n:literal>, $file:literal, |$parameter:ident| $with:expr, constrained) => {
        golden! { @implement $system $n $file $parameter ($with) energies constraints series }
    };
    (@implement $system:ident $n:literal $file:literal $parameter:ident ($with:expr) $($what:ident)*) => {
        impl super::harness::Golden<$n> for $system {
            type Over<S: ::lagrange_runtime::Scalar> = $system<S>;

            const REFERENCE: &'static str = $file;

            fn with<S: ::lagrange_runtime::Scalar>($parameter: impl Fn(&str) -> S) -> $system<S> {
                $with
            }

            $(golden! { @function $what $system $n })*
        }
    };
    (@function energies $system:ident $n:literal) => {
        fn energies<S: ::lagrange_runtime::Scalar>(
            system: &$system<S>,
            q: &::nalgebra::SVector<S, $n>,
            qd: &::nalgebra::SVector<S, $n>,
            t: S,
        ) -> Option<[S; 3]> {
            use ::lagrange_runtime::Energies;
            Some([system.kinetic(q, qd, t), system.potential(q, t), system.energy(q, qd, t)])
        }
    };
    (@function series $system:ident $n:literal) => {
        fn series(
            system: &$system<f64>,
            at: &::lagrange_runtime::State<f64, $n>,
            order: usize,
        ) -> Option<::lagrange_runtime::traits::TaylorSeries<f64, $n, { super::harness::ROOM }>> {
            Some(::lagrange_runtime::traits::Analytic::series(system, at, order))
        }
    };
    (@function velocities $system:ident $n:literal) => {
        fn velocities<S: ::lagrange_runtime::Scalar>(
            system: &$system<S>,
            q: &::nalgebra::SVector<S, $n>,
            p: &::nalgebra::SVector<S, $n>,
            t: S,
        ) -> Option<::nalgebra::SVector<S, $n>> {
            Some(::lagrange_runtime::traits::LegendreTransform::velocities(system, q, p, t))
        }
    };
    (@function constraints $system:ident $n:literal) => {
        fn constraints<S: ::lagrange_runtime::Scalar>(
            system: &$system<S>,
            q: &::nalgebra::SVector<S, $n>,
            qd: &::nalgebra::SVector<S, $n>,
            t: S,
        ) -> Option<[Vec<S>; 4]> {
            use ::lagrange_runtime::Constrained;
            Some([
                system.multipliers(q, qd, t).as_slice().to_vec(),
                system.constraint_forces(q, qd, t).as_slice().to_vec(),
                system.constraints(q, t).as_slice().to_vec(),
                system.constraint_rates(q, qd, t).as_slice().to_vec(),
            ])
        }
    };
}

/// Quantities that the traits of a system compute, as a list of numbers (matrices by columns).
#[derive(Clone, Copy, Debug)]
pub enum Quantity {
    Acceleration,
    Momenta,
    Inertia,
    Bias,
    Force,
    Lagrangian,
    Jacobi,
    Dissipation,
    Power,
    JacobianQ,
    JacobianQd,
    JacobianT,
    Kinetic,
    Potential,
    Energy,
    /// The velocities, of momenta that stand in the place of the velocities.
    Velocities,
    /// λ.
    Multipliers,
    /// Aᵀλ.
    ConstraintForces,
    /// f.
    Constraints,
    /// A q̇ + b.
    ConstraintRates,
}

/// A quantity as a function of all that a system depends on, `x = [q, q̇, t, parameters]`; none if it is not known.
pub type Evaluate<S> = fn(names: &[String], x: &[S], quantity: Quantity) -> Option<Vec<S>>;

fn evaluate<G: Golden<N>, const N: usize, S: Scalar>(
    names: &[String],
    x: &[S],
    quantity: Quantity,
) -> Option<Vec<S>> {
    let system = G::with(|name| x[2 * N + 1 + position(names, name)]);
    let q = SVector::from_fn(|k, _| x[k]);
    let qd = SVector::from_fn(|k, _| x[N + k]);
    let t = x[2 * N];
    let energy = |index: usize| G::energies(&system, &q, &qd, t).map(|energies| vec![energies[index]]);
    let constraint = |index: usize| G::constraints(&system, &q, &qd, t).map(|all| all[index].clone());
    let vector = |vector: SVector<S, N>| vector.as_slice().to_vec();
    Some(match quantity {
        Quantity::Acceleration => vector(system.accel(&q, &qd, t)),
        Quantity::Momenta => vector(system.momenta(&q, &qd, t)),
        Quantity::Inertia => system.inertia(&q, &qd, t).as_slice().to_vec(),
        Quantity::Bias => vector(system.convective_momentum_rate(&q, &qd, t)),
        Quantity::Force => vector(system.momentum_rate(&q, &qd, t)),
        Quantity::Lagrangian => vec![system.lagrangian(&q, &qd, t)],
        Quantity::Jacobi => vec![system.energy_function(&q, &qd, t)],
        Quantity::Dissipation => vec![system.dissipation(&q, &qd, t)],
        Quantity::Power => vec![system.power(&q, &qd, t)],
        Quantity::JacobianQ => system.jacobian(&q, &qd, t).q.as_slice().to_vec(),
        Quantity::JacobianQd => system.jacobian(&q, &qd, t).qd.as_slice().to_vec(),
        Quantity::JacobianT => vector(system.jacobian(&q, &qd, t).t),
        Quantity::Kinetic => return energy(0),
        Quantity::Potential => return energy(1),
        Quantity::Energy => return energy(2),
        Quantity::Velocities => return G::velocities(&system, &q, &qd, t).map(vector),
        Quantity::Multipliers => return constraint(0),
        Quantity::ConstraintForces => return constraint(1),
        Quantity::Constraints => return constraint(2),
        Quantity::ConstraintRates => return constraint(3),
    })
}

/// A system with the parameters of its file.
pub fn with_reference<G: Golden<N>, const N: usize>() -> G::Over<f64> {
    let reference = Reference::read(G::REFERENCE);
    G::with(|name| reference.parameter(name))
}

/// A system without its type.
#[derive(Clone)]
pub struct Subject {
    /// Name of the file.
    pub id: &'static str,
    pub reference: Reference,
    pub facts: Facts,
    /// Number of coordinates.
    pub n: usize,
    plain: Evaluate<f64>,
    dual: Evaluate<Dual<f64>>,
    pub(super) motion: trajectory::Motion<f64>,
    pub(super) tangent: trajectory::Motion<Dual<f64>>,
    /// The motion by Taylor series.
    pub(super) series: trajectory::Motion<f64>,
}

impl Subject {
    /// A system with the parameters of its file.
    pub fn of<G: Golden<N>, const N: usize>() -> Self {
        Subject {
            id: G::REFERENCE,
            reference: Reference::read(G::REFERENCE),
            facts: <G::Over<f64> as Lagrangian<N>>::FACTS,
            n: N,
            plain: evaluate::<G, N, f64>,
            dual: evaluate::<G, N, Dual<f64>>,
            motion: trajectory::motion::<G, N, f64>,
            tangent: trajectory::motion::<G, N, Dual<f64>>,
            series: trajectory::by_series::<G, N>,
        }
    }

    /// With other values of some parameters.
    #[must_use]
    pub fn with(mut self, parameters: &[(&str, f64)]) -> Self {
        for (name, value) in parameters {
            let index = position(&self.reference.names, name);
            self.reference.values[index] = *value;
        }
        self
    }

    /// The accelerations at a state.
    pub fn accelerations(&self, state: &State) -> Vec<f64> {
        self.at("", state).value(Quantity::Acceleration)
    }

    pub fn at(&self, place: impl Into<String>, state: &State) -> Point<'_> {
        let x = state.q.iter().chain(&state.qd).chain([&state.t]).chain(&self.reference.values).copied();
        let x: Vec<f64> = x.collect();
        assert_eq!(x.len(), 2 * self.n + 1 + self.reference.names.len(), "number of coordinates");
        Point { subject: self, place: place.into(), x }
    }
}

/// A system at one point `x = [q, q̇, t, parameters]`.
pub struct Point<'a> {
    pub subject: &'a Subject,
    pub place: String,
    pub x: Vec<f64>,
}

impl Point<'_> {
    pub fn n(&self) -> usize {
        self.subject.n
    }

    pub fn try_value(&self, quantity: Quantity) -> Option<Vec<f64>> {
        (self.subject.plain)(&self.subject.reference.names, &self.x, quantity)
    }

    pub fn value(&self, quantity: Quantity) -> Vec<f64> {
        let value = self.try_value(quantity);
        value.unwrap_or_else(|| panic!("{}: {quantity:?} is not known", self.place))
    }

    /// A quantity of one number.
    pub fn number(&self, quantity: Quantity) -> f64 {
        self.value(quantity)[0]
    }

    /// The generalized forces of the constraints.
    pub fn constraint_forces(&self) -> Vec<f64> {
        self.try_value(Quantity::ConstraintForces).unwrap_or_else(|| vec![0.0; self.n()])
    }

    /// Returns whether the system was given by T and V.
    pub fn has_energies(&self) -> bool {
        self.try_value(Quantity::Kinetic).is_some()
    }

    /// The same point with other velocities, or with momenta in their place.
    pub fn moving(&self, velocities: &[f64]) -> Self {
        let mut x = self.x.clone();
        x[self.n()..2 * self.n()].copy_from_slice(velocities);
        Point { subject: self.subject, place: self.place.clone(), x }
    }

    /// The derivative of a quantity along a direction in `x`.
    pub fn along(&self, quantity: Quantity, direction: impl Fn(usize) -> f64) -> Vec<f64> {
        let x: Vec<_> =
            (self.x.iter().enumerate()).map(|(i, &value)| Dual { value, slope: direction(i) }).collect();
        let slopes = (self.subject.dual)(&self.subject.reference.names, &x, quantity);
        slopes.expect("known where its value is").iter().map(|y| y.slope).collect()
    }

    /// `∂(quantity)/∂xᵢ`.
    pub fn partial(&self, quantity: Quantity, i: usize) -> Vec<f64> {
        self.along(quantity, |j| if i == j { 1.0 } else { 0.0 })
    }

    /// `dx/dt` along the motion.
    pub fn rate(&self) -> impl Fn(usize) -> f64 + use<> {
        let n = self.n();
        let velocities = self.x[n..2 * n].to_vec();
        let acceleration = self.value(Quantity::Acceleration);
        move |i| match i {
            i if i < n => velocities[i],
            i if i < 2 * n => acceleration[i - n],
            i if i == 2 * n => 1.0,
            _ => 0.0,
        }
    }

    /// `max_k Σᵢ |xᵢ ∂f_k/∂xᵢ|`.
    pub fn condition(&self, quantity: Quantity) -> f64 {
        let mut sums = vec![0.0; self.value(quantity).len()];
        for i in 0..self.x.len() {
            for (sum, partial) in sums.iter_mut().zip(self.partial(quantity, i)) {
                *sum += (self.x[i] * partial).abs();
            }
        }
        largest(&sums)
    }

    /// The error that is allowed for a quantity. `level` is the size of the terms whose sum it is, where these may
    /// cancel; 0 where they cannot.
    pub fn bound(&self, quantity: Quantity, level: f64) -> f64 {
        TOLERANCE * largest(&self.value(quantity)).max(level) + INPUT * self.condition(quantity)
    }

    /// Size of the centrifugal and Coriolis terms per unit of a coordinate, |q̇|ᵀ |M| |q̇|, with 2T for what prescribed
    /// motion adds. Positions that were written as `r cos φ`, `r sin φ` have these terms in full, and they cancel in
    /// the sum.
    pub fn gyration(&self) -> f64 {
        let speeds = DVector::from_iterator(self.n(), self.velocities().iter().map(|speed| speed.abs()));
        let kinetic = self.try_value(Quantity::Kinetic).map_or(0.0, |kinetic| kinetic[0].abs());
        speeds.dot(&(self.inertia().abs() * &speeds)) + 2.0 * kinetic
    }

    /// The same in the units of the accelerations, together with the forces: |M⁻¹| (|q̇|ᵀ |M| |q̇| + |force|).
    pub fn agility(&self) -> f64 {
        let force =
            self.gyration() + largest(&self.value(Quantity::Force)) + largest(&self.constraint_forces());
        (self.inverse_inertia().abs() * DVector::repeat(self.n(), force)).amax()
    }

    pub fn velocities(&self) -> &[f64] {
        &self.x[self.n()..2 * self.n()]
    }

    pub fn matrix(&self, quantity: Quantity) -> DMatrix<f64> {
        DMatrix::from_vec(self.n(), self.n(), self.value(quantity))
    }

    pub fn inertia(&self) -> DMatrix<f64> {
        self.matrix(Quantity::Inertia)
    }

    pub fn inverse_inertia(&self) -> DMatrix<f64> {
        let inverse = self.inertia().try_inverse();
        inverse.unwrap_or_else(|| panic!("{}: the inertia matrix is singular", self.place))
    }
}

/// Index of a parameter in the list of names.
pub fn position(names: &[String], name: &str) -> usize {
    let found = names.iter().position(|known| known == name);
    found.unwrap_or_else(|| panic!("no parameter {name:?} among {names:?}"))
}
