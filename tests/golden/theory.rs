//! Statements of the chapter about all systems, tested on many: generalized forces, the parts of the kinetic energy,
//! the balance of energy, Hamilton's principle. Each at the random states of the golden systems that it names.

use super::harness::{
    Finding, Kind, Quantity, Row, State, Subject, jacobi_balance, random_states, split, states,
};
use super::{
    bead_in_spinning_tube as bead, central_force, coupled_pendula, cylindrical_particle, damped_two_dof,
    double_pendulum, driven_rigid_pendulum, gyrocompass, ignorable_with_drag, moving_frame, moving_incline,
    pendulum_moving_support, prescribed_length, rod_on_disk, rolling, rotating_frame, rotating_pendulum,
    simple_pendulum, slider_on_table, spherical_pendulum, stokes_fall, surfaces, symmetric_top,
};
use lagrange_runtime::{Dual, Functions, Scalar};
use std::ops::Range;

pub fn rows() -> Vec<Row> {
    vec![
        generalized_force_two_ways(),
        workless_force(),
        euler_identity(),
        kinetic_energy_split(),
        virtual_work(),
        jacobi(),
        hamilton(),
    ]
}

/// A number with a first derivative along two directions, and with the mixed second one.
type Number = Dual<Dual<f64>>;

/// Places of particles, as a function of the coordinates: x, y, z of the first, of the second, and so on.
type Places = fn(subject: &Subject, q: &[Number]) -> Vec<Number>;

/// Forces on the particles in the same order, as a function of state.
type Forces = fn(subject: &Subject, state: &State) -> Vec<f64>;

/// The generalized forces in two ways: `F·∂x/∂qₖ` (11.14), `F·∂v/∂q̇ₖ` (11.20), with the size of their terms.
fn generalized(subject: &Subject, state: &State, places: Places, forces: &[f64]) -> Vec<[f64; 3]> {
    let force = |k: usize| {
        // v = Σ ∂x/∂qⱼ q̇ⱼ is the derivative of x along q̇, and its derivative by q̇ₖ the mixed one.
        let q: Vec<Number> = (0..subject.n)
            .map(|j| {
                let unit = if j == k { 1.0 } else { 0.0 };
                let value = Dual { value: state.q[j], slope: unit };
                Dual { value, slope: Dual { value: state.qd[j], slope: unit } }
            })
            .collect();
        let still: Vec<Number> =
            (q.iter()).map(|x| Dual { value: Dual::constant(x.value.value), slope: x.slope }).collect();
        let by_place = places(subject, &q).into_iter().map(|x| x.value.slope);
        let by_velocity = places(subject, &still).into_iter().map(|x| x.slope.slope);
        let work = |(slope, force): (f64, &f64)| slope * force;
        let [by_place, by_velocity]: [Vec<f64>; 2] =
            [by_place.zip(forces).map(work).collect(), by_velocity.zip(forces).map(work).collect()];
        let size = by_place.iter().map(|term| term.abs()).sum();
        [by_place.iter().sum(), by_velocity.iter().sum(), size]
    };
    (0..subject.n).map(force).collect()
}

/// Both ways against what is expected.
fn compare(
    mut row: Row,
    (subject, state): (&Subject, &State),
    places: Places,
    forces: &[f64],
    expected: &[f64],
) -> Row {
    let found = generalized(subject, state, places, forces);
    for ([by_place, by_velocity, size], expected) in found.into_iter().zip(expected) {
        let size = size.max(expected.abs());
        for (what, found) in [("F·∂x/∂q", by_place), ("F·∂v/∂q̇", by_velocity)] {
            let what = format!("{}: {what}", subject.facts.name);
            row = row.finding(Finding::residue(Kind::Equation, what, found - expected, size, 1e-13 * size));
        }
    }
    row
}

/// Parameters of a system as constants.
fn parameter(subject: &Subject, name: &str) -> Number {
    Number::from_f64(subject.reference.parameter(name))
}

/// Exercise 11.2: a force (F_r, F_φ, F_z) on a particle in cylindrical coordinates has the generalized forces F_r, r
/// F_φ and F_z, and the compiled system has them, too.
fn generalized_force_two_ways() -> Row {
    let subject = Subject::of::<cylindrical_particle::CylindricalParticle, 3>();
    let mut row = Row::statement("exer-11.2-generalized-force-two-ways");
    let places: Places = |_, q| vec![q[0] * q[1].cos(), q[0] * q[1].sin(), q[2]];
    for state in random_states(&[0.4..2.0, -3.0..3.0, -2.0..2.0]) {
        let [f1, f2, f3, om] = ["f1", "f2", "f3", "Om"].map(|name| subject.reference.parameter(name));
        let [f_r, f_phi, f_z] = [f1 * (om * state.t).cos(), f2 * (om * state.t).sin(), f3 + 0.1 * state.t];
        let (sin, cos) = state.q[1].sin_cos();
        let forces = [f_r * cos - f_phi * sin, f_r * sin + f_phi * cos, f_z];
        let point = subject.at("", &state);
        // Q = force − ∂L/∂q.
        let force = point.value(Quantity::Force);
        for k in 0..3 {
            let expected = [f_r, state.q[0] * f_phi, f_z][k];
            let gradient = point.partial(Quantity::Lagrangian, k)[0];
            row = row.balance("Q of the system", &[force[k], -gradient, -expected, gradient, -gradient]);
        }
        row = compare(row, (&subject, &state), places, &forces, &[f_r, state.q[0] * f_phi, f_z]);
    }
    row
}

/// Section 11.4: the tension of the pendulum, along its rod, has no generalized force; its weight has −m g l sin θ.
fn workless_force() -> Row {
    let subject = Subject::of::<simple_pendulum::SimplePendulum, 1>();
    let mut row = Row::statement("sec-11.4-workless-force");
    let places: Places = |subject, q| {
        let l = parameter(subject, "l");
        vec![l * q[0].sin(), -l * q[0].cos()]
    };
    for state in random_states(&[-3.0..3.0]) {
        let [m, g, l] = ["m", "g", "l"].map(|name| subject.reference.parameter(name));
        let (sin, cos) = state.q[0].sin_cos();
        let tension = m * (l * state.qd[0].powi(2) + g * cos);
        row = compare(row, (&subject, &state), places, &[-tension * sin, tension * cos], &[0.0]);
        row = compare(row, (&subject, &state), places, &[0.0, -m * g], &[-m * g * l * sin]);
        row = compare(
            row,
            (&subject, &state),
            places,
            &[0.0, -m * g],
            &subject.at("", &state).value(Quantity::Force),
        );
    }
    row
}

/// A system with random states.
type Sampled = (Subject, Vec<State>);

const ANGLE: Range<f64> = -3.0..3.0;

/// Systems whose T is homogeneous of degree 2, and systems where prescribed motion adds to it, with random states.
fn kinetic() -> [Vec<Sampled>; 2] {
    let with = |subject, ranges: &[Range<f64>]| (subject, random_states(ranges));
    let homogeneous = vec![
        with(Subject::of::<simple_pendulum::PendulumOfBob, 1>(), &[ANGLE]),
        with(Subject::of::<central_force::CentralForceInThePlane, 2>(), &[0.4..3.0, ANGLE]),
        with(Subject::of::<double_pendulum::PendulumOfBobs, 2>(), &[ANGLE, ANGLE]),
        with(Subject::of::<symmetric_top::SymmetricTop, 3>(), &[ANGLE, 0.4..2.7, ANGLE]),
        with(Subject::of::<surfaces::ParaboloidWithDrag, 2>(), &[0.4..2.0, ANGLE]),
        with(Subject::of::<rolling::RockingSegment, 1>(), &[-1.5..1.5]),
        with(Subject::of::<rod_on_disk::RodOnDrivenDisk, 2>(), &[ANGLE, ANGLE]),
        with(Subject::of::<coupled_pendula::DampedPendula, 2>(), &[ANGLE, ANGLE]),
    ];
    let with_drive = vec![
        with(Subject::of::<bead::BeadInTube, 1>(), &[ANGLE]),
        with(Subject::of::<moving_incline::MovingIncline, 1>(), &[-2.0..2.0]),
        with(Subject::of::<moving_frame::MovingFrame, 3>(), &[0.4..2.0, ANGLE, -2.0..2.0]),
        with(Subject::of::<rotating_pendulum::RotatingPendulum, 1>(), &[ANGLE]),
        with(Subject::of::<gyrocompass::Gyrocompass, 2>(), &[ANGLE, ANGLE]),
        with(Subject::of::<slider_on_table::SliderOnTable, 1>(), &[-2.0..2.0]),
        with(Subject::of::<pendulum_moving_support::PendulumOnDrive, 1>(), &[ANGLE]),
        with(Subject::of::<prescribed_length::PrescribedLength, 1>(), &[ANGLE]),
        with(Subject::of::<rotating_frame::RotatingFrame, 2>(), &[-2.0..2.0, -2.0..2.0]),
        with(Subject::of::<ignorable_with_drag::IgnorableSplit, 2>(), &[ANGLE, ANGLE]),
        with(Subject::of::<rod_on_disk::RodOnTurningDisk, 1>(), &[ANGLE]),
    ];
    [homogeneous, with_drive]
}

/// Exercise 11.4, (11.26): p·q̇ = 2T where T is homogeneous. It fails, by T₁ + 2T₀, where prescribed motion adds terms
/// of lower degree, and in Example 11.7, whose text applies it (erratum).
fn euler_identity() -> Row {
    let mut row = Row::statement("exer-11.4-euler-identity");
    let [homogeneous, with_drive] = kinetic();
    for (subject, states) in homogeneous {
        for state in states {
            let point = subject.at(subject.facts.name, &state);
            let momenta = point.value(Quantity::Momenta);
            let mut terms: Vec<f64> = momenta.iter().zip(&state.qd).map(|(p, qd)| p * qd).collect();
            terms.push(-2.0 * point.number(Quantity::Kinetic));
            row = row.balance(subject.facts.name, &terms);
        }
    }
    for (subject, states) in with_drive {
        let mut fails = false;
        for state in states {
            let point = subject.at(subject.facts.name, &state);
            let split = split(&point, 0.0).expect("given by T and V");
            let [square, linear, still] = split.parts;
            fails |= (linear + 2.0 * still).abs() > 1e-3 * square.abs();
            row = row.finding(split.euler());
        }
        row = row.holds(&format!("{}: fails with T₁ and T₀", subject.facts.name), fails);
    }
    row
}

/// Exercise 11.5, (11.30): T = T₂ + T₁ + T₀.
fn kinetic_energy_split() -> Row {
    let mut row = Row::statement("exer-11.5-kinetic-energy-split");
    let [homogeneous, with_drive] = kinetic();
    for (systems, is_homogeneous) in [(homogeneous, true), (with_drive, false)] {
        for (subject, states) in systems {
            for state in states {
                let point = subject.at(subject.facts.name, &state);
                let split = split(&point, 0.0).expect("given by T and V");
                row = row.finding(split.sum());
                if is_homogeneous {
                    row = row.holds(subject.facts.name, split.parts[1..] == [0.0, 0.0]);
                }
            }
        }
    }
    row
}

/// Exercise 11.6: −∂V/∂qₖ is the generalized force of the forces that have the potential V.
fn virtual_work() -> Row {
    let mut row = Row::statement("exer-11.6-virtual-work");
    let weight: Forces = |subject, _| {
        let [m, g] = ["m", "g"].map(|name| subject.reference.parameter(name));
        vec![0.0, 0.0, -m * g]
    };
    let systems: [(Subject, Places, Forces, &[Range<f64>]); 4] = [
        (
            Subject::of::<spherical_pendulum::SphericalPendulum, 2>(),
            |subject, q| {
                let l = parameter(subject, "l");
                let rho = l * q[0].sin();
                vec![rho * q[1].cos(), rho * q[1].sin(), -l * q[0].cos()]
            },
            weight,
            &[0.3..2.8, -3.0..3.0],
        ),
        (
            Subject::of::<surfaces::ParaboloidWithDrag, 2>(),
            |subject, q| vec![q[0] * q[1].cos(), q[0] * q[1].sin(), q[0] * q[0] / parameter(subject, "a")],
            weight,
            &[0.4..2.0, -3.0..3.0],
        ),
        (
            Subject::of::<central_force::CentralForce, 2>(),
            |_, q| vec![q[0] * q[1].cos(), q[0] * q[1].sin()],
            |subject, state| {
                let [m, mu] = ["m", "mu"].map(|name| subject.reference.parameter(name));
                let ((sin, cos), pull) = (state.q[1].sin_cos(), mu * m / state.q[0].powi(2));
                vec![-pull * cos, -pull * sin]
            },
            &[0.4..3.0, -3.0..3.0],
        ),
        (
            Subject::of::<double_pendulum::DoublePendulum, 2>(),
            |subject, q| {
                let [l1, l2] = ["l1", "l2"].map(|name| parameter(subject, name));
                let y1 = -l1 * q[0].cos();
                vec![l1 * q[0].sin(), y1, l1 * q[0].sin() + l2 * q[1].sin(), y1 - l2 * q[1].cos()]
            },
            |subject, _| {
                let [m1, m2, g] = ["m1", "m2", "g"].map(|name| subject.reference.parameter(name));
                vec![0.0, -m1 * g, 0.0, -m2 * g]
            },
            &[-3.0..3.0, -3.0..3.0],
        ),
    ];
    for (subject, places, forces, ranges) in systems {
        for state in random_states(ranges) {
            let point = subject.at("", &state);
            let expected: Vec<f64> =
                (0..subject.n).map(|k| -point.partial(Quantity::Potential, k)[0]).collect();
            row = compare(row, (&subject, &state), places, &forces(&subject, &state), &expected);
        }
    }
    row
}

/// Exercise 11.8: dh/dt = Q·q̇ − ∂L/∂t. (11.53) is the case of an L without time, and (11.52), for T + V in place of h,
/// needs besides that T is homogeneous (erratum): it fails for a rod on a disk that is turned.
fn jacobi() -> Row {
    let mut row = Row::statement("exer-11.8-jacobi-balance");
    let [mut systems, with_drive] = kinetic();
    systems.extend(with_drive);
    let line = || random_states(&[-2.0..2.0]);
    systems.push((Subject::of::<stokes_fall::StokesFall, 1>(), line()));
    systems.push((Subject::of::<driven_rigid_pendulum::DrivenRigidPendulum, 1>(), line()));
    systems.push((Subject::of::<damped_two_dof::DampedTwoDof, 2>(), random_states(&[-2.0..2.0, -2.0..2.0])));
    for (subject, states) in systems {
        row = row.findings(states.iter().map(|state| jacobi_balance(&subject.at(subject.facts.name, state))));
    }
    let turned = Subject::of::<rod_on_disk::RodOnTurningDisk, 1>();
    let works = line().iter().any(|state| {
        let point = turned.at("", state);
        point.along(Quantity::Energy, point.rate())[0].abs() > 1e-3
    });
    row.holds("the disk works on the rod", works)
}

/// Exercise 11.9, (11.75): ∫ (p·δq̇ + (∂L/∂q + Q)·δq) dt = 0 along a motion, for every δq that vanishes at its ends;
/// here along that of Example 11.10, for sines. (That the work is a function of state, as (11.68) to (11.72) have it,
/// is not needed, erratum.)
fn hamilton() -> Row {
    let mut row = Row::statement("exer-11.9-action-with-work");
    let subject = Subject::of::<driven_rigid_pendulum::DrivenRigidPendulum, 1>();
    let start = subject.reference.trajectory().remove(0);
    let (end, panels) = (3.0, 200);
    // Gauss's rule with three points in each panel is exact up to degree 5.
    let node = 0.6f64.sqrt();
    let width = end / f64::from(panels);
    let nodes: Vec<(f64, f64)> = (0..panels)
        .flat_map(|panel| {
            let middle = (f64::from(panel) + 0.5) * width;
            [(-node, 5.0 / 18.0), (0.0, 4.0 / 9.0), (node, 5.0 / 18.0)]
                .map(|(at, weight)| (middle + 0.5 * at * width, weight * width))
        })
        .collect();
    let times: Vec<f64> = nodes.iter().map(|node| node.0).collect();
    let motion = match states(&subject, &start, &times) {
        Ok(motion) => motion,
        Err(reason) => return row.finding(Finding::failed("motion", &reason)),
    };
    for wave in 1..=5 {
        let rate = f64::from(wave) * std::f64::consts::PI / end;
        let (mut sum, mut size) = (0.0, 0.0);
        for ((_, weight), state) in nodes.iter().zip(&motion) {
            let point = subject.at("", state);
            let (sin, cos) = (rate * state.t).sin_cos();
            let terms = [point.number(Quantity::Momenta) * rate * cos, point.number(Quantity::Force) * sin]
                .map(|term| term * weight);
            sum += terms[0] + terms[1];
            size += terms[0].abs() + terms[1].abs();
        }
        // The rule errs by h⁶/2016000 times the sixth derivative, here that of sines of the highest rate, (Ω + kπ/T)⁶.
        let highest = subject.reference.parameter("Om") + rate;
        let rule = (highest * width).powi(6) / 2_016_000.0;
        // A run ends a step at each node, and each step errs by 1e-13, independently of the others.
        let steps = 1e-13 * (nodes.len() as f64).sqrt();
        let bound = (rule + steps) * size;
        row = row.finding(Finding::residue(Kind::Equation, "δ∫L dt + ∫δW dt", sum, size, bound));
    }
    row
}
