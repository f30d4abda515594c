//! Forces that change within a hair's breadth near a position in which constraints are dependent.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// A parallelogram with a torque on its cranks that jumps, and one of a potential that is steep, by their mean
    /// angle; and a mass that has nothing to do with it.
    system Struck {
        param jump = 0, at = 0, steep = 0, width = 1, g = 9.81;
        coord a: angle, b: angle, c: angle, z: length;
        let x = cos(a) + 0.5 * cos(b);
        let y = sin(a) + 0.5 * sin(b);
        let mean = 0.5 * (a + c);
        T = 0.2 * (dot(a).powi(2) + dot(c).powi(2)) + dot(x).powi(2) + dot(y).powi(2) + 0.05 * dot(b).powi(2) + 0.5 * dot(z).powi(2);
        V = 2 * g * y + steep * tanh(mean / width);
        let torque = if mean > at { jump } else { 0 };
        Q[a] = torque;
        Q[c] = torque;
        Q[z] = if z > 0 { 1 } else { -1 };
        constraint pin: [cos(a) + cos(b), sin(a) + sin(b)] == [cos(c) + 1, sin(c)];
        observe pin_force = reaction(pin);
    }
}

const SPEED: f64 = 5.0;
const FROM: f64 = -0.4;

impl Struck<f64> {
    /// Square of the cranks' rate at an angle by the balance of energy, `1.4 (ω² − ω₀²) = W`.
    fn rate_squared(&self, a: f64) -> f64 {
        let well = |a: f64| self.steep * (a / self.width).tanh();
        let work = 2.0 * self.jump * (a - self.at).max(0.0) - 2.0 * self.g * (a.sin() - FROM.sin());
        SPEED * SPEED + (work - well(a) + well(FROM)) / 1.4
    }

    /// Time at which the cranks reach an angle, `∫ da / ω`, by Gauss's rule of two points over parts that end at the
    /// jump and are short beside the width.
    fn time(&self, a: f64) -> f64 {
        let ends = |from: f64, to: f64| {
            let parts = ((to - from) / 1e-5).ceil();
            let h = (to - from) / parts;
            let points = (0..parts as u32).flat_map(move |k| {
                let middle = from + h * (f64::from(k) + 0.5);
                [-0.5, 0.5].map(|side| middle + side * h / 3f64.sqrt())
            });
            points.map(|a| 0.5 * h / self.rate_squared(a).sqrt()).sum::<f64>()
        };
        ends(FROM, self.at) + ends(self.at, a)
    }
}

fn cases() -> [Struck; 4] {
    let jump = |at| Struck { jump: 30.0, at, ..Struck::default() };
    let steep = |width| Struck { steep: 0.5, width, ..Struck::default() };
    [jump(-0.01), jump(0.002), steep(1e-2), steep(1e-3)]
}

/// The ends of runs that meet such a force there are right in place, speed and time.
#[test]
fn forces_that_change_near_the_line_act_on_the_run() -> Result<(), Failure> {
    let start = State::new(0.0, [FROM, 0.0, FROM, 1.0], [SPEED, 0.0, SPEED, 0.0]);
    for system in cases() {
        let check = |end: State<f64, 4>| {
            let (a, rate) = (end.q[0], end.qd[0]);
            assert!((rate * rate - system.rate_squared(a)).abs() < 1e-6, "{system:?}: {rate}");
            assert!((end.t - system.time(a)).abs() < 1e-8, "{system:?}: {}", system.time(a));
            assert!((end.q[2] - a).abs() < 1e-10 && end.q[1].abs() < 1e-10, "{end:?}");
            // The mass is in free fall of another kind.
            assert!((end.q[3] - 1.0 - 0.5 * end.t * end.t).abs() < 1e-8, "{end:?}");
        };
        check(
            integrate(&system, Dop853, PiController::tolerance(1e-9).max_step(1e-3), start)
                .until(0.16)
                .final_state()?,
        );
        check(
            integrate(&system, Radau5, PiController::tolerance(1e-8).max_step(1e-3), start)
                .until(0.16)
                .final_state()?,
        );
    }
    Ok(())
}

/// Accelerations at states there are those of the force at the state itself, on either side of a jump.
#[test]
fn accelerations_at_states_near_the_line_are_of_their_own_force() {
    for system in cases() {
        for a in [-0.011, -0.009, -1e-3, -1e-5, 0.0, 1e-4, 0.00199, 0.00201, 0.01] {
            for z in [-1e-4, 1e-4] {
                let torque = if a > system.at { 2.0 * system.jump } else { 0.0 };
                let well = system.steep / system.width / (a / system.width).cosh().powi(2);
                let right = (torque - well - 2.0 * system.g * a.cos()) / 2.8;
                let at = State::new(0.0, [a, 0.0, a, z], [SPEED, 0.0, SPEED, 0.0]);
                let found = system.accel_at(&at);
                assert!(
                    (found[0] - right).abs() < 1e-8 * (1.0 + right.abs()),
                    "{a}: {} for {right}",
                    found[0]
                );
                assert!((found[3] - z.signum()).abs() < 1e-12, "{a}, {z}: {}", found[3]);
            }
        }
    }
}

/// Reactions at states there, where polynomials do not see such a force, are not numbers; those that are agree with the
/// ones of the state alone, which have at least ten digits there.
#[test]
fn reactions_near_the_line_are_right_or_no_numbers() {
    let (mut right, mut refused) = (0, 0);
    for system in cases() {
        for a in [-0.02, -0.011, -0.009, -4e-3, 2.5e-3, 4e-3, 0.01, 0.02] {
            let at = State::new(0.0, [a, 0.0, a, 1.0], [SPEED, 0.0, SPEED, 0.0]);
            let found = system.pin_force_at(&at);
            let alone = system.pin_force(&at.q, &at.qd, at.t);
            for (found, alone) in found.iter().zip(alone.iter()) {
                match found.is_nan() {
                    true => refused += 1,
                    false => {
                        assert!(
                            (found - alone).abs() < 1e-5 * (1.0 + alone.abs()),
                            "{system:?} {a}: {found} {alone}"
                        );
                        right += 1;
                    }
                }
            }
        }
    }
    assert!(right >= 8 && refused >= 8, "{right} {refused}");
}
