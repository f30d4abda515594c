//! Oscillators of which some drive others and are not driven by them.

use super::*;

/// Some oscillators, some of them coupled by inertia or springs, some driven by functions of others.
pub fn driven(random: &mut Random) -> System {
    let n = 2 + random.below(4);
    let half = || Expr::Constant(4);
    let (place, velocity) = (Expr::Position, |i: usize| Expr::Position(i).rate());
    let mut kinetic = half() * Expr::Parameter(0).positive() * velocity(0).power(2);
    let mut potential = Expr::Parameter(1) * place(0).power(2);
    for i in 1..n {
        kinetic = kinetic + half() * velocity(i).power(2);
        potential = potential + half() * place(i).power(2);
        if random.once_in(4) {
            kinetic = kinetic + half() * (velocity(i) + velocity(random.below(i))).power(2);
        }
        if random.once_in(4) {
            potential = potential - (place(i) - place(random.below(i))).call(Call::Cos);
        }
    }
    let mut applied = Vec::new();
    for i in 0..n {
        let (other, third) = (random.below(n), random.below(n));
        match random.below(4) {
            0 => applied.push((i, place(other).call(Call::Sin))),
            1 => applied.push((i, place(other) * velocity(third))),
            2 => applied.push((i, velocity(other) * Expr::Time - velocity(i))),
            _ => {}
        }
    }
    System {
        kind: "driven oscillators",
        coordinates: n,
        parameters: 2,
        prescribed: Vec::new(),
        bindings: Vec::new(),
        kinetic,
        potential,
        whole: false,
        dissipation: None,
        applied,
        forces: Vec::new(),
        constraints: Vec::new(),
        struck: Vec::new(),
        observed: Vec::new(),
        ignorable: false,
        frames: None,
    }
}
