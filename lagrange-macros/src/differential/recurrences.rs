//! Taylor coefficients by the programs that are emitted for them.

use super::rounding::Noise;
use crate::equations::series::Series;
use crate::graph::{Coefficient, Graph, Symbol};
use crate::program::lower::program;

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
        let side = |s: Symbol| if let Symbol::Side(i) = s { sides[i] } else { at(s) };
        let value = program(g, &[*switch]).evaluate(&[], side, |x| x)[0];
        sides.push(f64::from(i8::from(value > 0.0) - i8::from(value < 0.0)));
    }
    let at = |s: Symbol| if let Symbol::Side(i) = s { sides[i] } else { at(s) };
    let start = program(g, &series.start).evaluate(&[], |s| noise.apply(at(s)), |x| noise.apply(x));
    let (constants, start) = start.split_at(series.program.constants.len());
    let recurrence = &series.recurrence;
    let (factors, memory) = (recurrence.factors.len(), recurrence.memory.len());
    let unpacked = |all: &[f64]| -> [Vec<f64>; 3] {
        let (of_factors, rest) = all.split_at(factors);
        let (before, rest) = rest.split_at(memory);
        [of_factors, before, &rest[recurrence.switching.len()..]].map(<[f64]>::to_vec)
    };
    // Coefficients of the velocities, and of the factors, by orders.
    let mut qd = vec![vec![0.0; n]; orders + 3];
    qd[0] = (0..n).map(|i| at(Symbol::Velocity(i))).collect();
    let advance = |qd: &mut Vec<Vec<f64>>, level: usize, found: &[f64]| {
        let kept = recurrence.accelerations.iter().zip(found);
        kept.for_each(|((i, _), a)| qd[level + 1][*i] = a / (level + 1) as f64);
        let velocities = recurrence.velocities.iter().zip(&found[recurrence.accelerations.len()..]);
        velocities.for_each(|((i, _), v)| qd[level][*i] = *v);
        let place = recurrence.accelerations.len() + recurrence.velocities.len();
        let coordinates = recurrence.coordinates.iter().zip(found.get(place..).unwrap_or_default());
        // (That of order 1 is given.)
        coordinates.filter(|_| level > 1).for_each(|((i, _), x)| qd[level - 1][*i] = level as f64 * x);
    };
    let [first, mut before, found] = unpacked(start);
    advance(&mut qd, 0, &found);
    let mut by_order = vec![first];
    for level in 1..=orders + usize::from(!recurrence.coordinates.is_empty()) {
        let inner = |[a, b]: [usize; 2]| -> f64 {
            let product = |j: usize| noise.apply(by_order[j][a] * by_order[level - j][b]);
            // At order 2 orders 1 and k − 1 are the same, and stand here.
            if level == 2 { product(1) } else { (2..level.saturating_sub(1)).map(product).sum() }
        };
        let input = |input: Coefficient| match input {
            Coefficient::Level => level as f64,
            Coefficient::Over => 1.0 / level as f64,
            Coefficient::Clock => f64::from(u8::from(level == 1)),
            Coefficient::Rate(i) => qd[level - 1][i],
            Coefficient::Coordinate(i) => qd[level - 1][i] / level as f64,
            Coefficient::Velocity(i) => qd[level][i],
            Coefficient::First(i) if level > 2 => by_order[1][i],
            Coefficient::Last(i) if level > 1 => by_order[level - 1][i],
            Coefficient::First(_) | Coefficient::Last(_) => 0.0,
            Coefficient::Inner(i) => inner(recurrence.convolutions[i]),
            Coefficient::Before(i) => before[i],
        };
        let symbol = |s: Symbol| noise.apply(if let Symbol::Order(of) = s { input(of) } else { at(s) });
        let next = series.program.evaluate(constants, symbol, |x| noise.apply(x));
        let [of_order, kept, found] = unpacked(&next);
        by_order.push(of_order);
        before = kept;
        advance(&mut qd, level, &found);
    }
    (0..orders).map(|k| qd[k + 1].iter().map(|v| (k + 1) as f64 * v).collect()).collect()
}
