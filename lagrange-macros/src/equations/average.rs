//! The mean of a system over a fast phase.

use super::common::{independent, shortest};
use super::routhian::cheapest;
use crate::graph::fourier::Harmonics;
use crate::graph::{Function, Graph, Number, Symbol, Value};
use crate::model::Model;

/// The angle of the phase, while the mean is taken.
const ANGLE: Symbol = Symbol::Given(0);

/// The mean over a fast phase α = ω t, to leading order in 1/ω with velocities of the given motion that stay as they
/// are (Kapitza 1951; Landau and Lifshitz, *Mechanics*, §30). With L = ½ q̇·M q̇ + b·q̇ + L₀ the Hamiltonian ½ (p −
/// b)·M⁻¹ (p − b) − L₀ is averaged, which gives
///
///   ⟨L⟩ = ½ q̇·M q̇ + ⟨b⟩·q̇ + ⟨L₀⟩ − ½ ⟨b̃·M⁻¹ b̃⟩,   b̃ = b − ⟨b⟩.
///
/// First dG/dt with ∂G/∂t = −(L₀ − ⟨L₀⟩) is added, so that forces −m s̈ count as what they are, whichever way they
/// are written. The velocities −M⁻¹ b̃ are those that the mean has lost.
pub fn average(g: &mut Graph, model: &mut Model, phase: Value) -> Result<(), String> {
    let (n, mechanical) = (model.coordinates.len(), model.mechanical());
    let all = [&[model.lagrangian, model.dissipation][..], &model.applied].concat();
    if !g.depends(&all, |s| s == Symbol::Time) {
        return Err("nothing depends on time, so that nothing is averaged".into());
    }
    let alpha = g.symbol(ANGLE);
    let rate = g.forward(&[phase], |s| (s == Symbol::Time).then_some(Value::ONE))[0];
    let time = g.quotient(alpha, rate);
    let mut in_phase = |values: &[Value]| g.substitute(values, |s| (s == Symbol::Time).then_some(time));
    let lagrangian = in_phase(&[model.lagrangian])[0];
    let dissipation = in_phase(&[model.dissipation])[0];
    let applied = in_phase(&model.applied);
    let velocities: Vec<Symbol> = (0..mechanical).map(Symbol::Velocity).collect();
    let at_rest = |s: Symbol| velocities.contains(&s).then_some(Value::ZERO);
    let momenta = g.gradient(lagrangian, &velocities);
    let inertia = inertia(g, &momenta, &velocities)?;
    let rest = g.substitute(&[lagrangian], at_rest)[0];
    let rest = moving(g, rest);
    let rest = harmonics(g, rest)?;
    let drift = g.substitute(&momenta, at_rest);
    let mut drifts = drift.into_iter().map(|b| harmonics(g, b)).collect::<Result<Vec<_>, _>>()?;
    transform(g, &mut drifts, &rest, rate);
    let (effective, fast) = oscillations(g, &inertia, &drifts, phase, n)?;
    let kinetic = kinetic(g, &inertia, &velocities);
    let potential = g.sub(effective, rest[0][0]);
    let [kinetic, potential] = [kinetic, potential].map(|v| shortest(g, n, &[v])[0]);
    let mut lagrangian = g.sub(kinetic, potential);
    let mut straight = true;
    for (drift, velocity) in drifts.iter().zip(&velocities) {
        let qd = g.symbol(*velocity);
        let term = g.mul(drift[0][0], qd);
        lagrangian = g.add(lagrangian, term);
        straight &= g.vanishes(drift[0][0]);
    }
    if !independent(g, &[dissipation], |s| s == ANGLE) {
        return Err("the dissipation function depends on the phase".into());
    }
    let forces =
        applied.into_iter().map(|force| mean_force(g, force, &velocities)).collect::<Result<_, _>>()?;
    model.energies = model.energies.filter(|_| straight).map(|_| [kinetic, potential]);
    (model.lagrangian, model.applied) = (lagrangian, forces);
    model.dissipation = at_any_phase(g, dissipation);
    model.origin.as_mut().expect("a derived system").fast = fast;
    Ok(())
}

fn harmonics(g: &mut Graph, v: Value) -> Result<Harmonics<Value>, String> {
    let series = g.fourier(v, ANGLE);
    series.ok_or_else(|| {
        "time appears otherwise than in sines and cosines of this phase, or in a quotient or a root".into()
    })
}

/// A value that is the same at every phase.
fn at_any_phase(g: &mut Graph, v: Value) -> Value {
    g.substitute(&[v], |s| (s == ANGLE).then_some(Value::ZERO))[0]
}

/// The lower triangle of the inertia matrix, which has to be free of velocities and the phase.
fn inertia(g: &mut Graph, momenta: &[Value], velocities: &[Symbol]) -> Result<Vec<Vec<Value>>, String> {
    let mut inertia = Vec::new();
    for (i, p) in momenta.iter().enumerate() {
        let row = g.gradient(*p, &velocities[..=i]);
        if !independent(g, &row, |s| velocities.contains(&s)) {
            return Err("L is not quadratic in the velocities".into());
        }
        if !independent(g, &row, |s| s == ANGLE) {
            return Err("the inertia matrix depends on the phase".into());
        }
        inertia.push(g.substitute(&row, |s| (s == ANGLE).then_some(Value::ZERO)));
    }
    Ok(inertia)
}

/// Harmonics of b after dG/dt is added, with ∂G/∂t the negative of those of L₀.
fn transform(g: &mut Graph, drifts: &mut [Harmonics<Value>], rest: &[[Value; 2]], rate: Value) {
    let coordinates: Vec<Symbol> = (0..drifts.len()).map(Symbol::Coordinate).collect();
    for (k, [c, s]) in rest.iter().enumerate().skip(1) {
        let by = g.recip(rate).scaled(Number::Ratio(1, k as i64));
        let slopes = [g.gradient(*s, &coordinates), g.gradient(-*c, &coordinates)];
        for (i, drift) in drifts.iter_mut().enumerate() {
            drift.resize(drift.len().max(k + 1), [Value::ZERO; 2]);
            for (part, slopes) in drift[k].iter_mut().zip(&slopes) {
                let more = g.mul(slopes[i], by);
                *part = g.add(*part, more);
            }
        }
    }
}

/// ½ ⟨b̃·M⁻¹ b̃⟩ and the `n` velocities −M⁻¹ b̃.
fn oscillations(
    g: &mut Graph,
    inertia: &[Vec<Value>],
    drifts: &[Harmonics<Value>],
    phase: Value,
    n: usize,
) -> Result<(Value, Vec<Value>), String> {
    let (mut effective, mut fast) = (Value::ZERO, vec![Value::ZERO; n]);
    for k in 1..drifts.iter().map(Vec::len).max().unwrap_or(0) {
        let angle = phase.scaled((k as i64).into());
        for (of, function) in [(0, Function::cos), (1, Function::sin)] {
            let b: Vec<Value> =
                drifts.iter().map(|d| d.get(k).map_or(Value::ZERO, |pair| pair[of])).collect();
            if b.iter().all(|b| b.is_zero()) {
                continue;
            }
            let Some((square, solution)) = cheapest(g, inertia, &b) else {
                return Err("the inertia matrix is singular".into());
            };
            effective = g.add(effective, square.scaled(Number::Ratio(1, 2)));
            let oscillates = g.call(function, angle);
            for (fast, x) in fast.iter_mut().zip(solution) {
                let term = g.mul(x, oscillates);
                *fast = g.sub(*fast, term);
            }
        }
    }
    Ok((effective, fast))
}

/// ½ q̇·M q̇ by the lower triangle of M.
fn kinetic(g: &mut Graph, inertia: &[Vec<Value>], velocities: &[Symbol]) -> Value {
    let mut sum = Value::ZERO;
    for (i, row) in inertia.iter().enumerate() {
        for (j, m) in row.iter().enumerate() {
            let product = [i, j].map(|i| g.symbol(velocities[i]));
            let product = g.mul(product[0], product[1]);
            let half = if i == j { Number::Ratio(1, 2) } else { Number::ONE };
            let term = g.mul(*m, product).scaled(half);
            sum = g.add(sum, term);
        }
    }
    sum
}

/// The mean of an applied force.
fn mean_force(g: &mut Graph, force: Value, velocities: &[Symbol]) -> Result<Value, String> {
    // A large one would have effects beyond its mean.
    if !independent(g, &[force], |s| s == ANGLE) {
        return Err("an applied force depends on the phase; if it has a potential, write it in `V`, where more than its mean is known".into());
    }
    if g.degree(force, |s| velocities.contains(&s)).is_none_or(|degree| degree > 1) {
        return Err("the mean of a force that is not linear in the velocities is not known".into());
    }
    Ok(at_any_phase(g, force))
}

/// A Lagrangian without those of its terms that depend on time and parameters alone: they act on nothing.
fn moving(g: &mut Graph, v: Value) -> Value {
    let Some(terms) = g.monomials(v) else { return v };
    let mut sum = Value::ZERO;
    for (factors, k) in terms.into_iter().filter(|(factors, _)| !factors.is_empty()) {
        let term = g.assemble(&factors);
        if g.depends(&[term], |s| matches!(s, Symbol::Coordinate(_) | Symbol::Velocity(_))) {
            sum = g.add(sum, term.scaled(k));
        }
    }
    sum
}
