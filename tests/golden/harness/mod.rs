//! Compares emitted systems with reference digits and with themselves.
//!
//! A system is checked row by row against `reference/<file>.json`, and each row also against identities that hold for
//! every Lagrangian: `p = ∂L/∂q̇`, `M = ∂p/∂q̇`, `bias = (∂p/∂q) q̇ + ∂p/∂t`, `M q̈ + bias = force`, `h = p·q̇ − L`,
//! `dh/dt = power − ∂L/∂t`, `q̇(q, p(q, q̇)) = q̇`. Derivatives in these come from dual numbers.
//!
//! Tolerances. A vector or matrix is compared entry by entry against `1e-14` of its largest entry, plus what a change
//! of each input by four rounding units would do to it, `4ε Σ |xᵢ ∂f/∂xᵢ|`: the condition of the function itself,
//! whatever the formula that evaluates it (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, §1.6).

mod random;
mod reference;
mod trajectory;

pub use random::random_states;
pub use reference::{Reference, number};
pub use trajectory::check_trajectory;

use lagrange_runtime::{Dual, Facts, Legendre, Scalar};
use nalgebra::{DMatrix, DVector, SVector};

/// Of the largest entry: some ninety roundings.
const TOLERANCE: f64 = 1e-14;

/// Of every input: four roundings.
const INPUT: f64 = 4.0 * f64::EPSILON;

/// Of the terms of a printed equation: at a random state the accelerations carry the condition of the inertia matrix,
/// below 100 for the ranges in use, on top of a few roundings.
const BALANCE: f64 = 1e-13;

/// One state of a system.
#[derive(Clone, Copy, Debug)]
pub struct State<const N: usize> {
    pub q: SVector<f64, N>,
    pub qd: SVector<f64, N>,
    pub t: f64,
}

/// A system together with the file of its reference digits. [`golden!`](crate::golden) implements it.
pub trait Golden<const N: usize> {
    /// The system over another scalar.
    type Over<S: Scalar>: Legendre<N, Scalar = S>;

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
}

/// Says which file belongs to a system and how its parameters are called there.
///
/// `golden!(Pendulum<1>, "file", |p| Pendulum { m: p("m"), l: p("l"), g: p("g") });`, with `, given L` at the end for
/// a system that was given by L.
#[macro_export]
macro_rules! golden {
    ($system:ident<$n:literal>, $file:literal, |$parameter:ident| $with:expr) => {
        $crate::golden! { @implement $system $n $file $parameter ($with) {
            fn energies<S: ::lagrange_runtime::Scalar>(
                system: &$system<S>,
                q: &::nalgebra::SVector<S, $n>,
                qd: &::nalgebra::SVector<S, $n>,
                t: S,
            ) -> Option<[S; 3]> {
                use ::lagrange_runtime::Energies;
                Some([system.kinetic(q, qd, t), system.potential(q, t), system.energy(q, qd, t)])
            }
        } }
    };
    ($system:ident<$n:literal>, $file:literal, |$parameter:ident| $with:expr, given L) => {
        $crate::golden! { @implement $system $n $file $parameter ($with) {} }
    };
    (@implement $system:ident $n:literal $file:literal $parameter:ident ($with:expr) { $($energies:tt)* }) => {
        impl $crate::harness::Golden<$n> for $system {
            type Over<S: ::lagrange_runtime::Scalar> = $system<S>;

            const REFERENCE: &'static str = $file;

            fn with<S: ::lagrange_runtime::Scalar>($parameter: impl Fn(&str) -> S) -> $system<S> {
                $with
            }

            $($energies)*
        }
    };
}

/// What the traits of a system compute, as a list of numbers (matrices by columns).
#[derive(Clone, Copy, Debug)]
enum Quantity {
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
}

/// A quantity as a function of all that the system depends on, `x = [q, q̇, t, parameters]`.
fn evaluate<G: Golden<N>, const N: usize, S: Scalar>(
    names: &[String],
    x: &[S],
    quantity: Quantity,
) -> Vec<S> {
    use lagrange_runtime::{Lagrangian, System};
    let system = G::with(|name| x[2 * N + 1 + position(names, name)]);
    let q = SVector::from_fn(|k, _| x[k]);
    let qd = SVector::from_fn(|k, _| x[N + k]);
    let t = x[2 * N];
    let energy = |index: usize| match G::energies(&system, &q, &qd, t) {
        Some(energies) => vec![energies[index]],
        None => panic!("{}: given by L, so T and V are unknown", G::REFERENCE),
    };
    match quantity {
        Quantity::Acceleration => system.accel(&q, &qd, t).iter().copied().collect(),
        Quantity::Momenta => system.momenta(&q, &qd, t).iter().copied().collect(),
        Quantity::Inertia => system.inertia(&q, &qd, t).iter().copied().collect(),
        Quantity::Bias => system.bias(&q, &qd, t).iter().copied().collect(),
        Quantity::Force => system.force(&q, &qd, t).iter().copied().collect(),
        Quantity::Lagrangian => vec![system.lagrangian(&q, &qd, t)],
        Quantity::Jacobi => vec![system.jacobi(&q, &qd, t)],
        Quantity::Dissipation => vec![system.dissipation(&q, &qd, t)],
        Quantity::Power => vec![system.power(&q, &qd, t)],
        Quantity::JacobianQ => system.jacobian(&q, &qd, t).q.iter().copied().collect(),
        Quantity::JacobianQd => system.jacobian(&q, &qd, t).qd.iter().copied().collect(),
        Quantity::JacobianT => system.jacobian(&q, &qd, t).t.iter().copied().collect(),
        Quantity::Kinetic => energy(0),
        Quantity::Potential => energy(1),
        Quantity::Energy => energy(2),
    }
}

/// A system at one point `x = [q, q̇, t, parameters]`.
struct Point<'a, G, const N: usize> {
    place: String,
    names: &'a [String],
    x: Vec<f64>,
    system: std::marker::PhantomData<G>,
}

impl<'a, G: Golden<N>, const N: usize> Point<'a, G, N> {
    fn new(place: String, reference: &'a Reference, state: &State<N>) -> Self {
        let x = state.q.iter().chain(&state.qd).chain([&state.t]).chain(&reference.values).copied().collect();
        Point { place, names: &reference.names, x, system: std::marker::PhantomData }
    }

    fn value(&self, quantity: Quantity) -> Vec<f64> {
        evaluate::<G, N, f64>(self.names, &self.x, quantity)
    }

    /// A quantity of one number.
    fn number(&self, quantity: Quantity) -> f64 {
        self.value(quantity)[0]
    }

    /// The derivative of a quantity along a direction in `x`.
    fn along(&self, quantity: Quantity, direction: impl Fn(usize) -> f64) -> Vec<f64> {
        let x: Vec<_> =
            (self.x.iter().enumerate()).map(|(i, &value)| Dual { value, slope: direction(i) }).collect();
        evaluate::<G, N, Dual<f64>>(self.names, &x, quantity).iter().map(|y| y.slope).collect()
    }

    /// `∂(quantity)/∂xᵢ`.
    fn partial(&self, quantity: Quantity, i: usize) -> Vec<f64> {
        self.along(quantity, |j| if i == j { 1.0 } else { 0.0 })
    }

    /// `max_k Σᵢ |xᵢ ∂f_k/∂xᵢ|`.
    fn condition(&self, quantity: Quantity) -> f64 {
        let mut sums = vec![0.0; self.value(quantity).len()];
        for i in 0..self.x.len() {
            for (sum, partial) in sums.iter_mut().zip(self.partial(quantity, i)) {
                *sum += (self.x[i] * partial).abs();
            }
        }
        largest(&sums)
    }

    /// Compares a quantity with what it should be. `level` is the size of the terms whose sum it is, where these may
    /// cancel; 0 where they cannot.
    fn expect(&self, quantity: Quantity, expected: &[f64], level: f64) {
        self.close(&format!("{quantity:?}"), &self.value(quantity), expected, self.bound(quantity, level));
    }

    /// The error that is allowed for a quantity.
    fn bound(&self, quantity: Quantity, level: f64) -> f64 {
        TOLERANCE * largest(&self.value(quantity)).max(level) + INPUT * self.condition(quantity)
    }

    /// Size of the centrifugal and Coriolis terms per unit of a coordinate, |q̇|ᵀ |M| |q̇|, with 2T for what prescribed
    /// motion adds. Positions that were written as `r cos φ`, `r sin φ` have these terms in full, and they cancel in
    /// the sum.
    fn gyration(&self) -> f64 {
        let inertia = self.value(Quantity::Inertia);
        let speed = |k: usize| self.x[N + k].abs();
        let own: f64 =
            (0..N * N).map(|entry| speed(entry / N) * inertia[entry].abs() * speed(entry % N)).sum();
        let kinetic = if self.has_energies() { self.number(Quantity::Kinetic) } else { 0.0 };
        own + 2.0 * kinetic.abs()
    }

    /// The same in the units of the accelerations, together with the forces: |M⁻¹| (|q̇|ᵀ |M| |q̇| + |force|).
    fn agility(&self) -> f64 {
        let inverse = self.inverse_inertia().abs();
        let force = self.gyration() + largest(&self.value(Quantity::Force));
        (inverse * DVector::repeat(N, force)).amax()
    }

    fn state(&self) -> State<N> {
        State {
            q: SVector::from_fn(|k, _| self.x[k]),
            qd: SVector::from_fn(|k, _| self.x[N + k]),
            t: self.x[2 * N],
        }
    }

    fn system(&self) -> G::Over<f64> {
        G::with(|name| self.x[2 * N + 1 + position(self.names, name)])
    }

    /// Whether the system was given by T and V.
    fn has_energies(&self) -> bool {
        let State { q, qd, t } = self.state();
        G::energies(&self.system(), &q, &qd, t).is_some()
    }

    fn inertia(&self) -> DMatrix<f64> {
        DMatrix::from_vec(N, N, self.value(Quantity::Inertia))
    }

    fn inverse_inertia(&self) -> DMatrix<f64> {
        let inverse = self.inertia().try_inverse();
        inverse.unwrap_or_else(|| panic!("{}: the inertia matrix is singular", self.place))
    }

    fn close(&self, what: &str, got: &[f64], expected: &[f64], bound: f64) {
        assert_eq!(got.len(), expected.len(), "{}: {what}: number of entries", self.place);
        for (k, (got, expected)) in got.iter().zip(expected).enumerate() {
            let error = (got - expected).abs();
            assert!(
                error <= bound,
                "{}: {what}[{k}] is {got:e}, should be {expected:e}: off by {error:.1e}, allowed {bound:.1e}",
                self.place
            );
        }
    }
}

/// Checks every row of the file of a system, and the identities of every Lagrangian in each row.
pub fn check<G: Golden<N>, const N: usize>() {
    let reference = Reference::read(G::REFERENCE);
    assert!(reference.rows.len() >= 8, "{}: at least eight rows", G::REFERENCE);
    // The zero of an energy is arbitrary, and `1 − cos θ` is a difference: energies are as accurate as the largest
    // ones that occur.
    let level =
        reference.rows.iter().map(|row| row.number("T").abs() + row.number("V").abs()).fold(0.0, f64::max);
    for (index, row) in reference.rows.iter().enumerate() {
        let state = row.state();
        let point = Point::<G, N>::new(format!("{} row {index}", G::REFERENCE), &reference, &state);
        check_row(&point, row, level);
        check_derivatives(&point);
        check_equations(&point);
        check_energy(&point, level);
    }
}

/// The reference digits.
fn check_row<G: Golden<N>, const N: usize>(point: &Point<G, N>, row: &reference::Row, level: f64) {
    let velocities = row.numbers("qd");
    let applied = row.numbers("QN");
    let dissipation = row.number("D");
    point.expect(Quantity::Acceleration, &row.numbers("qdd"), 0.0);
    point.expect(Quantity::Momenta, &row.numbers("p"), 0.0);
    point.expect(Quantity::Inertia, &row.matrix("M"), 0.0);
    point.expect(Quantity::Dissipation, &[dissipation], 0.0);
    point.expect(Quantity::Lagrangian, &[row.number("T") - row.number("V")], level);
    point.expect(Quantity::Jacobi, &[row.number("h")], level);
    if point.has_energies() {
        point.expect(Quantity::Kinetic, &[row.number("T")], 0.0);
        point.expect(Quantity::Potential, &[row.number("V")], level);
        point.expect(Quantity::Energy, &[row.number("E")], level);
    }

    // D is quadratic in the velocities, so its power is −2D.
    let works: Vec<f64> = applied.iter().zip(&velocities).map(|(force, velocity)| force * velocity).collect();
    let terms: f64 = works.iter().map(|work| work.abs()).sum::<f64>() + 2.0 * dissipation;
    point.expect(Quantity::Power, &[works.iter().sum::<f64>() - 2.0 * dissipation], terms);

    // Q = force − ∂L/∂q + ∂D/∂q̇.
    let force = point.value(Quantity::Force);
    for k in 0..N {
        let gradient = point.partial(Quantity::Lagrangian, k)[0];
        let damping = point.partial(Quantity::Dissipation, N + k)[0];
        let bound = point.bound(Quantity::Force, gradient.abs() + damping.abs());
        point.close(&format!("Q[{k}]"), &[force[k] - gradient + damping], &[applied[k]], bound);
    }
}

/// Emitted derivatives against dual numbers.
fn check_derivatives<G: Golden<N>, const N: usize>(point: &Point<G, N>) {
    let columns = |quantity, from: usize, count: usize| -> Vec<f64> {
        (from..from + count).flat_map(|i| point.partial(quantity, i)).collect()
    };
    let compare = |what: &str, quantity, expected: Vec<f64>, level: f64| {
        let bound = point.bound(quantity, largest(&expected).max(level));
        point.close(what, &point.value(quantity), &expected, bound);
    };
    compare("momenta against ∂L/∂q̇", Quantity::Momenta, columns(Quantity::Lagrangian, N, N), 0.0);
    compare("inertia against ∂p/∂q̇", Quantity::Inertia, columns(Quantity::Momenta, N, N), 0.0);
    let level = point.agility();
    compare("∂q̈/∂q", Quantity::JacobianQ, columns(Quantity::Acceleration, 0, N), level);
    compare("∂q̈/∂q̇", Quantity::JacobianQd, columns(Quantity::Acceleration, N, N), level);
    compare("∂q̈/∂t", Quantity::JacobianT, columns(Quantity::Acceleration, 2 * N, 1), level);

    // At zero acceleration q changes at the rate q̇, q̇ not at all, and t at the rate 1. The terms of the sum may
    // cancel.
    let mut terms = vec![0.0; N];
    for i in (0..N).chain([2 * N]) {
        let rate = if i < N { point.x[N + i] } else { 1.0 };
        for (term, partial) in terms.iter_mut().zip(point.partial(Quantity::Momenta, i)) {
            *term += (rate * partial).abs();
        }
    }
    let expected = point.along(Quantity::Momenta, |i| match i {
        i if i < N => point.x[N + i],
        i if i == 2 * N => 1.0,
        _ => 0.0,
    });
    let bound = point.bound(Quantity::Bias, largest(&terms).max(point.gyration()));
    point.close("bias against (∂p/∂q) q̇ + ∂p/∂t", &point.value(Quantity::Bias), &expected, bound);
}

/// `M` symmetric, `M q̈ + bias = force`, `q̇(q, p) = q̇`.
fn check_equations<G: Golden<N>, const N: usize>(point: &Point<G, N>) {
    let inertia = point.inertia();
    assert_eq!(inertia, inertia.transpose(), "{}: the inertia matrix is symmetric", point.place);

    let acceleration = DVector::from_vec(point.value(Quantity::Acceleration));
    let bias = DVector::from_vec(point.value(Quantity::Bias));
    let force = DVector::from_vec(point.value(Quantity::Force));
    let rate = &inertia * &acceleration + &bias;
    let terms = inertia.abs() * acceleration.abs() + bias.abs() + force.abs();
    let bound = TOLERANCE * terms.amax()
        + INPUT * (inertia.abs() * DVector::repeat(N, point.condition(Quantity::Acceleration))).amax()
        + INPUT * (point.condition(Quantity::Bias) + point.condition(Quantity::Force));
    point.close("M q̈ + bias against force", rate.as_slice(), force.as_slice(), bound);

    // The condition of a linear system whose matrix and right-hand side are rounded: |M⁻¹| (|M| |q̇| + |p|) (Skeel,
    // 1979).
    let State { q, qd: velocities, t } = point.state();
    let momenta = SVector::<f64, N>::from_vec(point.value(Quantity::Momenta));
    let back = point.system().velocities(&q, &momenta, t);
    let speeds = DVector::from_iterator(N, velocities.iter().map(|velocity| velocity.abs()));
    let impulses = DVector::from_iterator(N, momenta.iter().map(|momentum| momentum.abs()));
    let condition = (point.inverse_inertia().abs() * (inertia.abs() * speeds + impulses)).amax();
    point.close(
        "velocities of the momenta",
        back.as_slice(),
        velocities.as_slice(),
        TOLERANCE * velocities.amax() + INPUT * condition,
    );
}

/// `h = p·q̇ − L`, `E = T + V`, `L = T − V`, and `dh/dt = power − ∂L/∂t` along the motion.
fn check_energy<G: Golden<N>, const N: usize>(point: &Point<G, N>, level: f64) {
    let momenta = point.value(Quantity::Momenta);
    let works: Vec<f64> = (0..N).map(|k| momenta[k] * point.x[N + k]).collect();
    let terms = level + works.iter().map(|work| work.abs()).sum::<f64>();
    let lagrangian = point.number(Quantity::Lagrangian);
    point.expect(Quantity::Jacobi, &[works.iter().sum::<f64>() - lagrangian], terms);

    let State { q, qd, t } = point.state();
    if let Some([kinetic, potential, energy]) = G::energies(&point.system(), &q, &qd, t) {
        point.close("E against T + V", &[energy], &[kinetic + potential], TOLERANCE * level);
        point.close("L against T − V", &[lagrangian], &[kinetic - potential], TOLERANCE * level);
    }

    let acceleration = point.value(Quantity::Acceleration);
    let rate = |i: usize| match i {
        i if i < N => point.x[N + i],
        i if i < 2 * N => acceleration[i - N],
        i if i == 2 * N => 1.0,
        _ => 0.0,
    };
    let gradient: Vec<f64> = (0..=2 * N).map(|i| point.partial(Quantity::Jacobi, i)[0]).collect();
    let terms: f64 = (0..=2 * N).map(|i| (rate(i) * gradient[i]).abs()).sum();
    let slopes: f64 = gradient[N..2 * N].iter().map(|slope| slope.abs()).sum();
    let expected = point.number(Quantity::Power) - point.partial(Quantity::Lagrangian, 2 * N)[0];
    let bound = TOLERANCE * terms
        + INPUT * point.condition(Quantity::Power)
        + INPUT * slopes * point.condition(Quantity::Acceleration);
    point.close("dh/dt against power − ∂L/∂t", &point.along(Quantity::Jacobi, rate), &[expected], bound);
}

/// Two systems that say the same: all quantities agree in the rows of the file and at random states.
pub fn check_equal<A: Golden<N>, B: Golden<N>, const N: usize>(q: [std::ops::Range<f64>; N]) {
    let mine = Reference::read(A::REFERENCE);
    let other = Reference::read(B::REFERENCE);
    for state in random_states(q) {
        let a = Point::<A, N>::new(format!("{} at {state:?}", A::REFERENCE), &mine, &state);
        let b = Point::<B, N>::new(format!("{} at {state:?}", B::REFERENCE), &other, &state);
        for (quantity, level) in [
            (Quantity::Acceleration, a.agility()),
            (Quantity::Momenta, 0.0),
            (Quantity::Inertia, 0.0),
            (Quantity::Bias, a.gyration()),
            (Quantity::Force, a.gyration()),
        ] {
            a.expect(quantity, &b.value(quantity), level);
        }
    }
}

/// A system with the parameters of its file.
pub fn with_reference<G: Golden<N>, const N: usize>() -> G::Over<f64> {
    let reference = Reference::read(G::REFERENCE);
    G::with(|name| reference.parameter(name))
}

/// A printed equation of motion, as the terms whose sum is 0.
#[track_caller]
pub fn assert_balance(equation: &str, terms: &[f64]) {
    let sum: f64 = terms.iter().sum();
    let size: f64 = terms.iter().map(|term| term.abs()).sum();
    assert!(sum.abs() <= BALANCE * size, "{equation}: {terms:?} leave {sum:e}");
}

/// A number in closed form.
#[track_caller]
pub fn assert_number(what: &str, got: f64, expected: f64) {
    assert_balance(what, &[got, -expected]);
}

/// What the compiler found: the facts that hold, the ignorable coordinates, and the groups that move independently.
#[track_caller]
pub fn assert_facts<G: Golden<N>, const N: usize>(
    holding: &[&str],
    ignorable: &[usize],
    blocks: &[&[usize]],
) {
    let facts = facts::<G, N>();
    let found = [
        ("scleronomic", facts.scleronomic),
        ("conservative", facts.conservative),
        ("separable", facts.separable),
        ("constant inertia", facts.constant_inertia),
        ("quadratic", facts.quadratic),
        ("linear", facts.linear),
    ];
    let found: Vec<&str> = found.iter().filter(|(_, holds)| *holds).map(|(name, _)| *name).collect();
    assert_eq!(found, holding, "{}: facts", facts.name);
    assert_eq!(facts.ignorable, ignorable, "{}: ignorable coordinates", facts.name);
    assert_eq!(facts.blocks, blocks, "{}: independent blocks", facts.name);
    assert_eq!(facts.coordinates.len(), N, "{}: coordinates", facts.name);
}

/// What the compiler found out about a system.
pub fn facts<G: Golden<N>, const N: usize>() -> Facts {
    <G::Over<f64> as lagrange_runtime::Lagrangian<N>>::FACTS
}

/// Where a parameter stands in the list of names.
fn position(names: &[String], name: &str) -> usize {
    let found = names.iter().position(|known| known == name);
    found.unwrap_or_else(|| panic!("no parameter {name:?} among {names:?}"))
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}
