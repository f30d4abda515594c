//! Systems against the rows of their files, and against identities that hold for every Lagrangian: `p = ∂L/∂q̇`,
//! `M = ∂p/∂q̇`, `b = (∂p/∂q) q̇ + ∂p/∂t`, `M q̈ + b = f`, `h = p·q̇ − L`, `dh/dt = power − ∂L/∂t`,
//! `q̇(q, p(q, q̇)) = q̇`, `T = T₂ + T₁ + T₀`. Derivatives in these come from dual numbers.

use super::reference::Fields;
use super::row::{Finding, Kind};
use super::subject::{Point, Quantity};
use super::{INPUT, State, Subject, TOLERANCE, largest};
use nalgebra::DVector;

impl Point<'_> {
    /// Some numbers against what they should be.
    fn close(&self, kind: Kind, what: &str, got: &[f64], expected: &[f64], allowed: f64) -> Finding {
        Finding::compare(kind, format!("{}: {what}", self.place), got, expected, allowed)
    }

    /// A quantity against reference digits. `level` is the size of the terms whose sum it is, where these may cancel; 0
    /// where they cannot. The digits come of 50 digits, where what should be 0 may be 1e-50.
    fn expect(&self, quantity: Quantity, expected: &[f64], level: f64) -> Finding {
        let bound = self.bound(quantity, level) + 1e-45;
        self.close(Kind::Digits, &format!("{quantity:?}"), &self.value(quantity), expected, bound)
    }
}

/// Every row of the file of a system, and the identities of every Lagrangian in each row.
pub fn check(subject: &Subject) -> Vec<Finding> {
    let states = &subject.reference.states;
    let mut findings = vec![Finding::holds("at least eight rows", states.len() >= 8)];
    // The zero of an energy is arbitrary, and `1 − cos θ` is a difference: energies are as accurate as the largest
    // ones that occur.
    let level = states.iter().map(|row| row.number("T").abs() + row.number("V").abs()).fold(0.0, f64::max);
    for (index, row) in states.iter().enumerate() {
        let point = subject.at(format!("row {index}"), &row.state());
        check_row(&point, row, level, &mut findings);
        check_derivatives(&point, &mut findings);
        check_equations(&point, &mut findings);
        check_energy(&point, level, &mut findings);
        findings.extend(split(&point, level).into_iter().flat_map(|split| split.findings(row)));
    }
    findings
}

/// The reference digits.
fn check_row(point: &Point<'_>, row: &Fields, level: f64, findings: &mut Vec<Finding>) {
    let n = point.n();
    let velocities = row.numbers("qd");
    let applied = row.numbers("QN");
    let dissipation = row.number("D");
    findings.extend([
        point.expect(Quantity::Acceleration, &row.numbers("qdd"), 0.0),
        point.expect(Quantity::Momenta, &row.numbers("p"), 0.0),
        point.expect(Quantity::Inertia, &row.matrix("M"), 0.0),
        point.expect(Quantity::Dissipation, &[dissipation], 0.0),
        point.expect(Quantity::Lagrangian, &[row.number("T") - row.number("V")], level),
        point.expect(Quantity::Jacobi, &[row.number("h")], level),
    ]);
    if point.has_energies() {
        findings.extend([
            point.expect(Quantity::Kinetic, &[row.number("T")], 0.0),
            point.expect(Quantity::Potential, &[row.number("V")], level),
            point.expect(Quantity::Energy, &[row.number("E")], level),
        ]);
    }

    if point.try_value(Quantity::Multipliers).is_some() {
        // A given state satisfies the constraints up to its own rounding.
        let satisfied = [Quantity::Constraints, Quantity::ConstraintRates].map(|quantity| {
            let zeros = vec![0.0; point.value(quantity).len()];
            point.expect(quantity, &zeros, 0.0)
        });
        findings.extend(satisfied);
        findings.push(point.expect(Quantity::Multipliers, &row.numbers("lambda"), 0.0));
    }

    // D is quadratic in the velocities, so its power is −2D.
    let works: Vec<f64> = applied.iter().zip(&velocities).map(|(force, velocity)| force * velocity).collect();
    let terms: f64 = works.iter().map(|work| work.abs()).sum::<f64>() + 2.0 * dissipation;
    findings.push(point.expect(Quantity::Power, &[works.iter().sum::<f64>() - 2.0 * dissipation], terms));

    // Q = force − ∂L/∂q + ∂D/∂q̇.
    let force = point.value(Quantity::Force);
    for k in 0..n {
        let gradient = point.partial(Quantity::Lagrangian, k)[0];
        let damping = point.partial(Quantity::Dissipation, n + k)[0];
        let bound = point.bound(Quantity::Force, gradient.abs() + damping.abs());
        let applied = [applied[k]];
        findings.push(point.close(Kind::Digits, "Q", &[force[k] - gradient + damping], &applied, bound));
    }
}

/// Emitted derivatives against dual numbers.
fn check_derivatives(point: &Point<'_>, findings: &mut Vec<Finding>) {
    let n = point.n();
    let columns = |quantity, from: usize, count: usize| -> Vec<f64> {
        (from..from + count).flat_map(|i| point.partial(quantity, i)).collect()
    };
    let compare = |what: &str, quantity, expected: Vec<f64>, level: f64| {
        let bound = point.bound(quantity, largest(&expected).max(level));
        point.close(Kind::Identity, what, &point.value(quantity), &expected, bound)
    };
    let level = point.agility();
    findings.extend([
        compare("momenta against ∂L/∂q̇", Quantity::Momenta, columns(Quantity::Lagrangian, n, n), 0.0),
        compare("inertia against ∂p/∂q̇", Quantity::Inertia, columns(Quantity::Momenta, n, n), 0.0),
        compare("∂q̈/∂q", Quantity::JacobianQ, columns(Quantity::Acceleration, 0, n), level),
        compare("∂q̈/∂q̇", Quantity::JacobianQd, columns(Quantity::Acceleration, n, n), level),
        compare("∂q̈/∂t", Quantity::JacobianT, columns(Quantity::Acceleration, 2 * n, 1), level),
    ]);

    // At zero acceleration q changes at the rate q̇, q̇ not at all, and t at the rate 1. The terms of the sum may
    // cancel.
    let rate = |i: usize| match i {
        i if i < n => point.x[n + i],
        i if i == 2 * n => 1.0,
        _ => 0.0,
    };
    let mut terms = vec![0.0; n];
    for i in (0..n).chain([2 * n]) {
        for (term, partial) in terms.iter_mut().zip(point.partial(Quantity::Momenta, i)) {
            *term += (rate(i) * partial).abs();
        }
    }
    let expected = point.along(Quantity::Momenta, rate);
    findings.push(compare(
        "bias against (∂p/∂q) q̇ + ∂p/∂t",
        Quantity::Bias,
        expected,
        largest(&terms).max(point.gyration()),
    ));
}

/// `M` symmetric, `M q̈ + b = f + Aᵀλ`, `q̇(q, p) = q̇`.
fn check_equations(point: &Point<'_>, findings: &mut Vec<Finding>) {
    let vector = |quantity| DVector::from_vec(point.value(quantity));
    let inertia = point.inertia();
    findings.push(Finding::holds(
        format!("{}: the inertia matrix is symmetric", point.place),
        inertia == inertia.transpose(),
    ));

    let (acceleration, bias, force) =
        (vector(Quantity::Acceleration), vector(Quantity::Bias), vector(Quantity::Force));
    let constraint = DVector::from_vec(point.constraint_forces());
    let rate = &inertia * &acceleration + &bias;
    let terms = inertia.abs() * acceleration.abs() + bias.abs() + force.abs() + constraint.abs();
    let force = force + constraint;
    let bound = TOLERANCE * terms.amax()
        + INPUT
            * (inertia.abs() * DVector::repeat(point.n(), point.condition(Quantity::Acceleration))).amax()
        + INPUT * (point.condition(Quantity::Bias) + point.condition(Quantity::Force));
    findings.push(point.close(
        Kind::Identity,
        "M q̈ + bias against the forces",
        rate.as_slice(),
        force.as_slice(),
        bound,
    ));

    // The condition of a linear system whose matrix and right-hand side are rounded: |M⁻¹| (|M| |q̇| + |p|) (Skeel,
    // 1979).
    let momenta = vector(Quantity::Momenta);
    let velocities = DVector::from_column_slice(point.velocities());
    let Some(back) = point.moving(momenta.as_slice()).try_value(Quantity::Velocities) else {
        return;
    };
    let condition =
        (point.inverse_inertia().abs() * (inertia.abs() * velocities.abs() + momenta.abs())).amax();
    findings.push(point.close(
        Kind::Identity,
        "velocities of the momenta",
        &back,
        velocities.as_slice(),
        TOLERANCE * velocities.amax() + INPUT * condition,
    ));
}

/// `h = p·q̇ − L`, `E = T + V`, `L = T − V`, and `dh/dt = power − ∂L/∂t` along the motion.
fn check_energy(point: &Point<'_>, level: f64, findings: &mut Vec<Finding>) {
    let momenta = point.value(Quantity::Momenta);
    let works: Vec<f64> = momenta.iter().zip(point.velocities()).map(|(p, qd)| p * qd).collect();
    let terms = level + works.iter().map(|work| work.abs()).sum::<f64>();
    let lagrangian = point.number(Quantity::Lagrangian);
    let bound = point.bound(Quantity::Jacobi, terms);
    let expected = [works.iter().sum::<f64>() - lagrangian];
    findings.push(point.close(
        Kind::Identity,
        "h = p·q̇ − L",
        &point.value(Quantity::Jacobi),
        &expected,
        bound,
    ));

    if point.has_energies() {
        let [kinetic, potential, energy] =
            [Quantity::Kinetic, Quantity::Potential, Quantity::Energy].map(|quantity| point.number(quantity));
        let bound = TOLERANCE * level;
        findings.push(point.close(Kind::Identity, "E = T + V", &[energy], &[kinetic + potential], bound));
        findings.push(point.close(Kind::Identity, "L = T − V", &[lagrangian], &[kinetic - potential], bound));
    }
    findings.push(jacobi_balance(point));
}

/// `dh/dt = power − ∂L/∂t`, with the power of the constraints.
pub fn jacobi_balance(point: &Point<'_>) -> Finding {
    let n = point.n();
    let rate = point.rate();
    let gradient: Vec<f64> = (0..=2 * n).map(|i| point.partial(Quantity::Jacobi, i)[0]).collect();
    let terms: f64 = (0..=2 * n).map(|i| (rate(i) * gradient[i]).abs()).sum();
    let slopes: f64 = gradient[n..2 * n].iter().map(|slope| slope.abs()).sum();
    let works: Vec<f64> =
        point.constraint_forces().iter().zip(point.velocities()).map(|(force, rate)| force * rate).collect();
    let expected = point.number(Quantity::Power) + works.iter().sum::<f64>()
        - point.partial(Quantity::Lagrangian, 2 * n)[0];
    let bound = TOLERANCE * (terms + works.iter().map(|work| work.abs()).sum::<f64>())
        + INPUT * point.condition(Quantity::Power)
        + INPUT * slopes * point.condition(Quantity::Acceleration);
    point.close(
        Kind::Identity,
        "dh/dt = power − ∂L/∂t",
        &point.along(Quantity::Jacobi, rate),
        &[expected],
        bound,
    )
}

/// The parts of T of degree 2, 1 and 0 in the velocities, (11.30): `½ q̇·M q̇`, `q̇·p(q, 0, t)`, `T(q, 0, t)`.
pub struct Split<'a> {
    point: &'a Point<'a>,
    pub parts: [f64; 3],
    bound: f64,
}

/// None where the system is given by L.
pub fn split<'a>(point: &'a Point<'a>, level: f64) -> Option<Split<'a>> {
    let rest = point.moving(&vec![0.0; point.n()]);
    let still = rest.try_value(Quantity::Kinetic)?[0];
    let velocities = DVector::from_column_slice(point.velocities());
    let square = 0.5 * velocities.dot(&(point.inertia() * &velocities));
    let linear = velocities.dot(&DVector::from_vec(rest.value(Quantity::Momenta)));
    let terms = square.abs() + linear.abs() + still.abs();
    Some(Split {
        point,
        parts: [square, linear, still],
        bound: point.bound(Quantity::Kinetic, terms.max(level)) + rest.bound(Quantity::Kinetic, 0.0),
    })
}

impl Split<'_> {
    /// `T₂ + T₁ + T₀ = T`.
    pub fn sum(&self) -> Finding {
        let kinetic = self.point.value(Quantity::Kinetic);
        let sum = [self.parts.iter().sum()];
        self.point.close(Kind::Identity, "T₂ + T₁ + T₀ = T", &sum, &kinetic, self.bound)
    }

    /// Euler's identity (11.26): `p·q̇ = 2T₂ + T₁`, which is 2T only if T is homogeneous. V is free of velocities.
    pub fn euler(&self) -> Finding {
        let momenta = DVector::from_vec(self.point.value(Quantity::Momenta));
        let product = momenta.dot(&DVector::from_column_slice(self.point.velocities()));
        let [square, linear, _] = self.parts;
        let expected = [2.0 * square + linear];
        self.point.close(Kind::Identity, "p·q̇ = 2T₂ + T₁", &[product], &expected, 2.0 * self.bound)
    }

    fn findings(self, row: &Fields) -> [Finding; 3] {
        let digits = row.numbers("T210");
        let parts = self.point.close(Kind::Digits, "T₂, T₁, T₀", &self.parts, &digits, self.bound);
        [parts, self.sum(), self.euler()]
    }
}

/// Two systems that say the same: all quantities agree at the given states.
pub fn check_equal(mine: &Subject, other: &Subject, states: &[State]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, state) in states.iter().enumerate() {
        let a =
            mine.at(format!("{} against {}, random state {index}", mine.facts.name, other.facts.name), state);
        let b = other.at("", state);
        for (quantity, level) in [
            (Quantity::Acceleration, a.agility()),
            (Quantity::Momenta, 0.0),
            (Quantity::Inertia, 0.0),
            (Quantity::Bias, a.gyration()),
            (Quantity::Force, a.gyration()),
        ] {
            let what = format!("{quantity:?}");
            let bound = a.bound(quantity, level);
            findings.push(a.close(Kind::Identity, &what, &a.value(quantity), &b.value(quantity), bound));
        }
    }
    findings
}
