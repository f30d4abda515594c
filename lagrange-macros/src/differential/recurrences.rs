//! What the recurrences of the Taylor coefficients say, order by order, as the emitted code works them out.

use super::rounding::Noise;
use crate::equations::series::{Balance, Outputs, Right, Rule, Series, Slope, is_number, symbol};
use crate::equations::solve::entry;
use crate::graph::{Comparison, Graph, Id, Symbol, Value};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Coefficients of the accelerations from order 0 on, `orders` of them.
pub fn coefficients(
    series: &Series,
    g: &Graph,
    n: usize,
    orders: usize,
    at: &dyn Fn(Symbol) -> f64,
    noise: &Noise,
) -> Vec<Vec<f64>> {
    // Switching functions may depend on earlier switches.
    let mut sides: Vec<f64> = Vec::new();
    for switch in &series.switches {
        let value = g.evaluate(&[*switch], |s| if let Symbol::Side(i) = s { sides[i] } else { at(s) })[0];
        sides.push(f64::from(i8::from(value > 0.0) - i8::from(value < 0.0)));
    }
    let at = &|s: Symbol| if let Symbol::Side(i) = s { sides[i] } else { at(s) };
    let mut motion = Motion { q: Vec::new(), qd: Vec::new(), t: vec![at(Symbol::Time), 1.0] };
    for i in 0..n {
        motion.q.push(vec![at(Symbol::Coordinate(i)), at(Symbol::Velocity(i))]);
        motion.qd.push(vec![at(Symbol::Velocity(i))]);
    }
    let mut rows: BTreeMap<Id, Vec<f64>> = BTreeMap::new();
    let number =
        |v: Value| g.evaluate_rounded(&[series.started(v)], |s| noise.apply(at(s)), |x| noise.apply(x))[0];
    let outputs = series.outputs.values();
    let all = series.rules.iter().map(|(id, _)| (*id).into()).chain(outputs.iter().copied());
    let all: Vec<Value> = all.map(|v| series.started(v)).collect();
    let firsts = g.evaluate_rounded(&all, |s| noise.apply(at(s)), |x| noise.apply(x));
    for ((id, _), first) in series.rules.iter().zip(&firsts) {
        rows.insert(*id, vec![*first]);
    }
    let mut right = firsts[series.rules.len()..].to_vec();
    if let Outputs::Momenta { momenta, force } = &series.outputs {
        return by_momenta(series, g, [momenta, force], orders, (&mut motion, &mut rows), &number, noise);
    }
    if let Outputs::Bindings(balance) = &series.outputs {
        return by_bindings(series, g, balance, orders, (&mut motion, &mut rows), at, &number, noise);
    }
    if let Outputs::Conserved { accelerations, .. } = &series.outputs {
        let firsts = right[right.len() - accelerations.len()..].iter().copied();
        return by_conserved(
            series,
            g,
            accelerations,
            firsts,
            orders,
            (&mut motion, &mut rows),
            &number,
            noise,
        );
    }
    let mut unknowns: Vec<Vec<f64>> = Vec::new();
    let system = match &series.outputs {
        Outputs::Accelerations(_) | Outputs::Momenta { .. } | Outputs::Bindings(_) => None,
        Outputs::Conserved { .. } => unreachable!("has been dealt with"),
        Outputs::System { matrix, right: of_right } => {
            let size = of_right.len();
            let entries = right[..right.len() - size].to_vec();
            right.drain(..right.len() - size);
            let place = |i: usize, j: usize| {
                let (i, j) = (i.max(j), i.min(j));
                i * (i + 1) / 2 + j
            };
            let mut dense = DMatrix::from_fn(size, size, |i, j| entries[place(i, j)]);
            let largest = dense.amax();
            dense.iter_mut().for_each(|x| *x += noise.apply(largest) - largest);
            Some((matrix, dense.full_piv_lu()))
        }
    };
    let mut found = Vec::new();
    for level in 0..orders {
        if level > 0 {
            for (id, rule) in &series.rules {
                let value = noise.apply(motion.next(g, &rows, rows.get(id), rule, level, &number, noise));
                rows.get_mut(id).expect("a row").push(value);
            }
            let of = |v: Value| motion.coefficient(g, &rows, v, level);
            right = match &series.outputs {
                Outputs::Accelerations(accel) => accel.iter().map(|v| of(*v)).collect(),
                Outputs::Momenta { .. } | Outputs::Bindings(_) | Outputs::Conserved { .. } => {
                    unreachable!("has been dealt with")
                }
                Outputs::System { matrix, right } => {
                    let row = |i: usize| {
                        let tail = (0..right.len()).map(|j| {
                            let m = entry(matrix, i, j);
                            let products = (1..=level).map(|k| {
                                noise.apply(motion.coefficient(g, &rows, m, k) * unknowns[j][level - k])
                            });
                            products.sum::<f64>()
                        });
                        noise.apply(of(right[i])) - tail.sum::<f64>()
                    };
                    (0..right.len()).map(row).collect()
                }
            };
        }
        let solution = match &system {
            None => right.clone(),
            Some((_, lu)) => {
                let solution = lu.solve(&DVector::from_column_slice(&right));
                solution.map_or(vec![f64::NAN; right.len()], |s| s.as_slice().to_vec())
            }
        };
        unknowns.resize(solution.len(), Vec::new());
        unknowns.iter_mut().zip(&solution).for_each(|(known, x)| known.push(*x));
        let accelerations = solution[..n].to_vec();
        for (i, a) in accelerations.iter().enumerate() {
            let a = a / (level + 1) as f64;
            motion.qd[i].push(a);
            motion.q[i].push(a / (level + 2) as f64);
        }
        // q̇ is known one order further than the equations.
        motion.q.iter_mut().for_each(|q| q.truncate(level + 3));
        found.push(accelerations);
    }
    found
}

/// From k p_k = f_{k−1}: M_0 by what unit velocities of order k add to the momenta.
fn by_momenta(
    series: &Series,
    g: &Graph,
    [momenta, force]: [&Vec<Value>; 2],
    orders: usize,
    (motion, rows): (&mut Motion, &mut BTreeMap<Id, Vec<f64>>),
    number: &dyn Fn(Value) -> f64,
    noise: &Noise,
) -> Vec<Vec<f64>> {
    let n = momenta.len();
    let values = |motion: &Motion, rows: &BTreeMap<Id, Vec<f64>>, of: &[Value], level: usize| -> Vec<f64> {
        // A number is no node with a row.
        let value = |v: &Value| match level {
            0 if is_number(g, *v) => number(*v),
            _ => noise.apply(motion.coefficient(g, rows, *v, level)),
        };
        of.iter().map(value).collect()
    };
    let mut found = Vec::new();
    let (mut before, mut inertia) = (values(motion, rows, force, 0), None);
    for level in 1..=orders {
        let mut with = |velocities: &[f64]| {
            for (i, v) in velocities.iter().enumerate() {
                motion.qd[i].truncate(level);
                motion.qd[i].push(*v);
            }
            for (id, rule) in &series.rules {
                let own = rows.get_mut(id).expect("a row");
                own.truncate(level);
                let value = noise.apply(motion.next(g, rows, rows.get(id), rule, level, number, noise));
                rows.get_mut(id).expect("a row").push(value);
            }
            [momenta, force].map(|of| values(motion, rows, of, level))
        };
        let [without, _] = with(&vec![0.0; n]);
        // The emitted code takes what moves with the velocities alone; here it is a difference, of velocities as large as the momenta,
        // so that it is not lost in these.
        let large = without.iter().fold(1.0f64, |large, p| large.max(p.abs()));
        let lu = inertia.get_or_insert_with(|| {
            let columns: Vec<Vec<f64>> = (0..n)
                .map(|j| {
                    let unit: Vec<f64> = (0..n).map(|i| if i == j { large } else { 0.0 }).collect();
                    let [all, _] = with(&unit);
                    all.iter().zip(&without).map(|(all, without)| (all - without) / large).collect()
                })
                .collect();
            DMatrix::from_fn(n, n, |i, j| columns[j][i]).full_piv_lu()
        });
        let right = DVector::from_fn(n, |i, _| before[i] / level as f64 - without[i]);
        let velocities = lu.solve(&right);
        let velocities = velocities.map_or(vec![f64::NAN; n], |v| v.as_slice().to_vec());
        [_, before] = with(&velocities);
        for (q, v) in motion.q.iter_mut().zip(&velocities) {
            q.push(v / (level + 1) as f64);
        }
        found.push(velocities.iter().map(|v| v * level as f64).collect());
    }
    found
}

/// By momenta that are conserved.
#[allow(clippy::too_many_arguments)]
fn by_conserved(
    series: &Series,
    g: &Graph,
    accelerations: &[(usize, Value)],
    firsts: impl Iterator<Item = f64>,
    orders: usize,
    (motion, rows): (&mut Motion, &mut BTreeMap<Id, Vec<f64>>),
    number: &dyn Fn(Value) -> f64,
    noise: &Noise,
) -> Vec<Vec<f64>> {
    let mut known: Vec<f64> = firsts.collect();
    let mut found = Vec::new();
    for level in 1..=orders {
        for (&(i, _), a) in accelerations.iter().zip(&known) {
            motion.qd[i].push(a / level as f64);
        }
        for (id, rule) in &series.rules {
            let value = noise.apply(motion.next(g, rows, rows.get(id), rule, level, number, noise));
            rows.get_mut(id).expect("a row").push(value);
            if let Some(Symbol::Velocity(i)) = symbol(g, *id) {
                motion.qd[i].push(value);
            }
        }
        known = accelerations.iter().map(|(_, v)| motion.coefficient(g, rows, *v, level)).collect();
        found.push(motion.qd.iter().map(|qd| level as f64 * qd[level]).collect());
        for (q, qd) in motion.q.iter_mut().zip(&motion.qd) {
            q.push(qd[level] / (level + 1) as f64);
        }
    }
    found
}

/// From the equations at the bindings.
#[allow(clippy::too_many_arguments)]
fn by_bindings(
    series: &Series,
    g: &Graph,
    balance: &Balance,
    orders: usize,
    (motion, rows): (&mut Motion, &mut BTreeMap<Id, Vec<f64>>),
    at: &dyn Fn(Symbol) -> f64,
    number: &dyn Fn(Value) -> f64,
    noise: &Noise,
) -> Vec<Vec<f64>> {
    let n = motion.q.len();
    let mut unknowns: Vec<Vec<f64>> = vec![Vec::new(); balance.solution.len()];
    let mut found = Vec::new();
    for level in 1..=orders {
        // Twice: what moves with the velocities is not known before the solution.
        let next = |motion: &Motion, rows: &mut BTreeMap<Id, Vec<f64>>| {
            for (id, rule) in &series.rules {
                rows.get_mut(id).expect("a row").truncate(level);
                let value = noise.apply(motion.next(g, rows, rows.get(id), rule, level, number, noise));
                rows.get_mut(id).expect("a row").push(value);
            }
        };
        next(motion, rows);
        let of = |v: Value, k: usize| match k {
            0 if is_number(g, v) => number(v),
            _ => motion.coefficient(g, rows, v, k),
        };
        let right = |right: &Right| match right {
            Right::Forces { force, tails } => {
                let tail = |(v, x): &(Value, usize)| -> f64 {
                    (1..level).map(|k| noise.apply(of(*v, k) * unknowns[*x][level - 1 - k])).sum()
                };
                noise.apply(of(*force, level - 1)) + tails.iter().map(tail).sum::<f64>()
            }
            Right::Definition { explicit, terms } => {
                let term = |[slope, rate]: &[Value; 2]| -> f64 {
                    (1..=level).map(|k| noise.apply(of(*slope, k) * of(*rate, level - k))).sum()
                };
                level as f64 * (noise.apply(of(*explicit, level)) + terms.iter().map(term).sum::<f64>())
            }
        };
        let given: Vec<f64> = balance.rights.iter().map(right).collect();
        let symbol = |s| if let Symbol::Given(i) = s { given[i] } else { at(s) };
        let solution = g.evaluate_rounded(&balance.solution, |s| noise.apply(symbol(s)), |x| noise.apply(x));
        unknowns.iter_mut().zip(&solution).for_each(|(known, x)| known.push(*x));
        for i in 0..n {
            let v = solution[i] / level as f64;
            motion.qd[i].push(v);
            motion.q[i].push(v / (level + 1) as f64);
        }
        next(motion, rows);
        found.push(solution[..n].to_vec());
    }
    found
}

/// Coefficients known so far.
struct Motion {
    q: Vec<Vec<f64>>,
    qd: Vec<Vec<f64>>,
    t: Vec<f64>,
}

impl Motion {
    /// The k-th coefficient of a value.
    fn coefficient(&self, g: &Graph, rows: &BTreeMap<Id, Vec<f64>>, v: Value, k: usize) -> f64 {
        let Some(id) = v.node else { return if k == 0 { v.k.to_f64() } else { 0.0 } };
        let series = match symbol(g, id) {
            Some(Symbol::Coordinate(i)) => &self.q[i],
            Some(Symbol::Velocity(i)) => &self.qd[i],
            Some(Symbol::Time) => &self.t,
            // Parameters, and what is made of them, do not move.
            _ => match rows.get(&id) {
                Some(row) => row,
                None => return if k == 0 { f64::NAN } else { 0.0 },
            },
        };
        // Of time there are no more.
        v.k.to_f64() * series.get(k).copied().unwrap_or(0.0)
    }

    #[allow(clippy::too_many_arguments)]
    fn next(
        &self,
        g: &Graph,
        rows: &BTreeMap<Id, Vec<f64>>,
        own: Option<&Vec<f64>>,
        rule: &Rule,
        level: usize,
        number: &dyn Fn(Value) -> f64,
        noise: &Noise,
    ) -> f64 {
        let at = |v: Value, k: usize| self.coefficient(g, rows, v, k);
        let own = |k: usize| own.map_or(f64::NAN, |row| row[k]);
        let product = |a: Value, b: Value| -> f64 {
            (0..=level).map(|k| noise.apply(at(a, k) * at(b, level - k))).sum()
        };
        match rule {
            Rule::Linear(terms) => terms.iter().map(|(k, x)| noise.apply(number(*k) * at(*x, level))).sum(),
            Rule::Product(a, b) => product((*a).into(), (*b).into()),
            Rule::Square(a) => product((*a).into(), (*a).into()),
            Rule::Quotient(a, b) => {
                let b = Value::from(*b);
                let tail: f64 = (1..=level).map(|k| noise.apply(at(b, k) * own(level - k))).sum();
                (at(*a, level) - tail) / at(b, 0)
            }
            Rule::Root(a) => {
                let tail: f64 = (1..level).map(|k| noise.apply(own(k) * own(level - k))).sum();
                (at(*a, level) - tail) / (2.0 * own(0))
            }
            Rule::Power(a, r) => {
                let (a, r) = (Value::from(*a), number(*r));
                let term =
                    |k: usize| noise.apply((r * (level - k) as f64 - k as f64) * at(a, level - k) * own(k));
                (0..level).map(term).sum::<f64>() / (level as f64 * at(a, 0))
            }
            Rule::Choice(comparison, values) => {
                let [a, b] = [values[0], values[1]].map(number);
                let holds = match comparison {
                    Comparison::Less => a < b,
                    Comparison::LessEqual => a <= b,
                    Comparison::Equal => a == b,
                };
                at(if holds { values[2] } else { values[3] }, level)
            }
            Rule::Function(slopes) => {
                let slope = |slope: &Slope| match slope {
                    Slope::Number(slope, x) => number(*slope) * at(*x, level),
                    Slope::Known(k, product) => k.to_f64() * at((*product).into(), level - 1) / level as f64,
                    Slope::Rate(k, a, slope) => {
                        let (a, slope) = ((*a).into(), (*slope).into());
                        let term = |j: usize| noise.apply(j as f64 * at(a, j) * at(slope, level - j));
                        k.to_f64() * (1..=level).map(term).sum::<f64>() / level as f64
                    }
                };
                slopes.iter().map(slope).sum::<f64>()
            }
        }
    }
}
