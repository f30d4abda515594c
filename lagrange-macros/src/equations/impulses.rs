//! Conditions on which an impulse acts: across them a momentum ∂L/∂q̇ jumps, or L along a coordinate, or a position.
//!
//! Between two forms of L the momenta have the jump λ ∂σ/∂q, where σ is the switching function, and the equations of
//! motion, which hold on either side, do not say how large λ is: a mass that is picked up for good has λ = 0 and loses
//! energy; the corner of a stationary action keeps the energy p·q̇ − L (Weierstrass and Erdmann; Gelfand and Fomin,
//! *Calculus of Variations*, 1963, §15).

use super::assemble::flattened;
use super::check::{TRIALS, sample};
use super::formed::Formed;
use super::series::switches::{Switch, choices, cut, switching};
use crate::diagnostics::Errors;
use crate::graph::{Function, Graph, Node, Symbol, Value};
use crate::model::Model;
use proc_macro2::Ident;

/// Bound of the coordinates and times among which a switch is searched for in equal parts.
const RANGE: f64 = 4.0;
const PARTS: u32 = 64;
/// Number of powers of 10 over which a switch is searched for by orders of magnitude.
const DECADES: i32 = 9;
const MAX_ROOTS: usize = 8;
/// Places at which a switch is looked at.
const PLACES: u64 = 192;
const MAX_LITERALS: usize = 32;
/// Length of a jump that is looked at where a switch is crossed; a longer one counts as a jump everywhere.
const MAX_JUMP_NODES: usize = 200;
/// Part of a value up to which a jump is that of rounded coefficients.
const ROUNDED: f64 = 1e-8;

/// Places at which impulses act.
pub struct Impulses {
    /// The switching functions that vanish there.
    pub switches: Vec<Switch>,
    /// Functions with data, by their places, on whose slopes momenta depend: there, where these have kinks.
    pub slopes: Vec<usize>,
    /// Positions of which velocities are taken, in terms of q and t, if they have choices.
    pub positions: Vec<Value>,
}

impl Impulses {
    pub fn values(&self) -> Vec<Value> {
        self.switches.iter().map(|switch| switch.value).collect()
    }
}

/// A jump, by which an impulse acts.
enum Jump {
    /// The momentum of this coordinate.
    Momentum(usize),
    /// A position of which a velocity is taken.
    Position,
    /// L, along a coordinate.
    Lagrangian,
}

/// The places at which impulses act. Switches are found by numbers, and told in a warning.
pub fn impulses(g: &mut Graph, model: &Model, formed: &Formed, errors: &mut Errors) -> Impulses {
    let mut values = formed.momenta[..model.mechanical()].to_vec();
    let positions = positions(g, model, formed);
    values.extend(&positions);
    values.push(formed.lagrangian);
    let choices = choices(g, &values).into_iter().filter_map(|(switch, mut decided)| {
        decided.retain(|choice| !is_continuous(g, switch, *choice));
        (!decided.is_empty()).then_some((switch, decided))
    });
    let choices: Vec<_> = choices.collect();
    let literals = literals(g, &choices.iter().flat_map(|(_, choices)| choices.clone()).collect::<Vec<_>>());
    let found = choices.iter().filter_map(|choice| {
        let is_cut = cut(g, &choice.1).is_some();
        let jump = jump(g, &values, choice, is_cut, &literals, model.mechanical())?;
        Some((choice, is_cut, jump))
    });
    let found: Vec<_> = found.collect();
    let derived = model.origin.is_some() || model.reduction.is_some();
    let mut told: Vec<&Ident> = Vec::new();
    // (A motion may stay away from a cut, and most do: only a prescribed one has its way.)
    let is_told =
        |(_, is_cut, jump): &&(_, bool, Jump)| !derived && (!is_cut || matches!(jump, Jump::Position));
    for (_, _, jump) in found.iter().filter(is_told) {
        let (keyword, what) = match jump {
            Jump::Momentum(i) => {
                (&model.keywords.kinetic, format!("the momentum of `{}`", model.coordinates[*i].label()))
            }
            Jump::Position => {
                let keywords = &model.keywords;
                let keyword =
                    if keywords.kinetic.is_some() { &keywords.kinetic } else { &keywords.potential };
                (keyword, "a position whose velocity is taken".into())
            }
            Jump::Lagrangian if model.energies.is_none() => {
                (&model.keywords.potential, "the Lagrangian".into())
            }
            Jump::Lagrangian => (&model.keywords.potential, "the potential energy".into()),
        };
        if let Some(keyword) = keyword.as_ref().filter(|keyword| !told.contains(keyword)) {
            told.push(keyword);
            let message = format!(
                "{what} jumps where a condition changes: an impulse acts there, which the equations of motion do not have, and runs across it end in `UnknownImpulse`\nhelp: end the run at an event there and go on from the state after the impact (`jump`), or smooth the jump"
            );
            errors.warn(keyword.span(), "an_energy_that_jumps", message);
        }
    }
    let switches = found.into_iter().map(|((switch, decided), ..)| Switch {
        value: *switch,
        cut: where_decided(g, &values, *switch, decided),
    });
    let switches = switches.collect();
    Impulses { switches, slopes: slopes(g, model, &values[..model.mechanical()]), positions }
}

/// The function that is negative where a switch decides anything, if it does not everywhere: less than 0 by the jump of
/// the values, or of `atan2(y, x)` the x.
fn where_decided(g: &mut Graph, values: &[Value], switch: Value, decided: &[Value]) -> Option<Value> {
    // (L may jump with time.)
    let moves = g.depends(&[switch], |symbol| matches!(symbol, Symbol::Coordinate(_)));
    let values = &values[..values.len() - usize::from(!moves)];
    let mut least: Option<Value> = None;
    for choice in decided {
        let sides = match g.node(choice.node?) {
            Node::Select(_, all) => [all[2], all[3]],
            Node::Call(Function::signum, ..) => [Value::ONE, -Value::ONE],
            _ => {
                let x = cut(g, &[*choice])?;
                least = Some(least.map_or(x, |other| g.choose(true, x, other)));
                continue;
            }
        };
        let [one, other] =
            sides.map(|side| g.replace(values, |id, _| (Some(id) == choice.node).then_some(side)));
        let mut jumps = Vec::new();
        for (one, other) in one.into_iter().zip(other) {
            let jump = g.sub(one, other);
            jumps.push(g.call(Function::abs, jump));
        }
        let sum = jumps.into_iter().reduce(|a, b| g.add(a, b)).unwrap_or(Value::ZERO);
        if sum.node.is_none_or(|id| g.is_fixed(id)) && !sum.is_zero() || g.live(&[sum]).len() > MAX_JUMP_NODES
        {
            return None;
        }
        least = Some(least.map_or(-sum, |other| g.choose(true, -sum, other)));
    }
    least
}

fn positions(g: &mut Graph, model: &Model, formed: &Formed) -> Vec<Value> {
    let mut moved = flattened(g, &formed.flat, &model.moved);
    moved.sort_by_key(|value| value.node);
    moved.dedup_by_key(|value| value.node);
    moved.retain(|value| !switching(g, &[*value]).is_empty());
    moved
}

/// Functions with data on whose slopes momenta depend, at arguments that move.
fn slopes(g: &Graph, model: &Model, momenta: &[Value]) -> Vec<usize> {
    let moves = |s: &Symbol| matches!(s, Symbol::Coordinate(_) | Symbol::Time);
    let slope = |id| match g.node(id) {
        Node::Extern(f, orders, arguments) => {
            let is_slope = model.externals[*f].data.is_some() && orders.iter().any(|order| *order > 0);
            (is_slope && g.symbols(arguments).iter().any(moves)).then_some(*f)
        }
        _ => None,
    };
    let mut slopes: Vec<usize> = g.live(momenta).into_iter().filter_map(slope).collect();
    slopes.sort_unstable();
    slopes.dedup();
    slopes
}

/// Do the two sides of this choice differ by a multiple of the switching function?
fn is_continuous(g: &mut Graph, switch: Value, choice: Value) -> bool {
    let node = choice.node.map(|id| g.node(id).clone());
    match node {
        Some(Node::Select(_, values)) => {
            let [_, _, yes, no] = *values;
            let difference = g.sub(yes, no);
            let factors = difference.node.map(|id| g.factors(id));
            factors.is_some_and(|factors| factors.iter().any(|f| Some(f.0) == switch.node && f.1 > 0))
        }
        Some(Node::Call(function, ..)) => function == Function::abs,
        _ => false,
    }
}

/// The first of the momenta, the positions, and then L, that jumps where this switching function vanishes, by the
/// choices that it decides. A position that jumps by the turn of an angle, at a cut, has the same velocity on both
/// sides; of one that is prescribed nobody knows whether it is an angle.
fn jump(
    g: &Graph,
    values: &[Value],
    (switch, choices): &(Value, Vec<Value>),
    is_cut: bool,
    literals: &[f64],
    mechanical: usize,
) -> Option<Jump> {
    let all = values.len();
    let moving = g.symbols(&[*switch]).into_iter();
    let moving: Vec<Symbol> = moving.filter(|s| matches!(s, Symbol::Coordinate(_) | Symbol::Time)).collect();
    moving.iter().enumerate().find_map(|(number, &symbol)| {
        // (L may change with time, and with a state that is no position.)
        let is_position = matches!(symbol, Symbol::Coordinate(i) if i < mechanical);
        let jumps = |which: usize| match which {
            _ if which < mechanical => Some(Jump::Momentum(which)),
            _ if which < all - 1 => (!is_cut || symbol == Symbol::Time).then_some(Jump::Position),
            _ => is_position.then_some(Jump::Lagrangian),
        };
        // Later places are shared among the symbols.
        let shared = |trial: &u64| *trial < TRIALS || *trial as usize % moving.len() == number;
        (0..PLACES).filter(shared).find_map(|trial| {
            let at = |values: &[Value], x: f64| {
                g.evaluate(values, |s| if s == symbol { x } else { place(s, trial, literals) })
            };
            let roots = roots(|x| at(&[*switch], x)[0], literals);
            roots.into_iter().find_map(|root| {
                // The choices are few nodes; what depends on them may be many.
                jumping(choices.len(), root, |x| at(choices, x)).next()?;
                jumping(all, root, |x| at(values, x)).find_map(jumps)
            })
        })
    })
}

/// The indices of values that jump at a root: by more, within 1e-9 of the root, than they change on either side, and
/// than rounded coefficients make of it.
fn jumping(count: usize, root: f64, at: impl Fn(f64) -> Vec<f64>) -> impl Iterator<Item = usize> {
    let d = 1e-9 * if root == 0.0 { 1.0 } else { root.abs() };
    let [before, below, above, after] = [-3.0, -1.0, 1.0, 3.0].map(|parts| at(root + parts * d));
    (0..count).filter(move |&i| {
        let (jump, size) = ((above[i] - below[i]).abs(), above[i].abs().max(below[i].abs()));
        let beside = (below[i] - before[i]).abs().max((after[i] - above[i]).abs());
        jump > 100.0 * beside && (jump > ROUNDED * size || jump.is_infinite())
    })
}

/// Literals of these expressions, and places at which their sums vanish, without their signs.
fn literals(g: &Graph, of: &[Value]) -> Vec<f64> {
    let mut found: Vec<f64> = vec![0.0];
    let mut add = |x: f64| {
        if x.is_finite() && x != 0.0 && !found.contains(&x.abs()) && found.len() < MAX_LITERALS {
            found.push(x.abs());
        }
    };
    for id in g.live(of) {
        let operands: &[Value] = match g.node(id) {
            Node::Sum(a, b) => &[*a, *b],
            Node::Call(_, a, b) => &[*a, *b],
            Node::Select(_, all) => &all[..2],
            _ => &[],
        };
        let constant = operands.iter().filter(|v| v.node.is_none()).map(|v| v.k.to_f64());
        for constant in constant {
            add(constant);
            operands.iter().for_each(|v| add(constant / v.k.to_f64()));
        }
    }
    found
}

/// A value of a symbol in a trial: about 1 in the first ones, and then near a literal of the conditions, so that it is
/// on both sides of the other ones, or of any size.
fn place(symbol: Symbol, trial: u64, literals: &[f64]) -> f64 {
    let uniform = |salt: u64| sample(symbol, trial, salt) - 0.4;
    if trial < TRIALS || !matches!(symbol, Symbol::Coordinate(_) | Symbol::Time | Symbol::Parameter(_)) {
        return sample(symbol, trial, 0);
    }
    let signed = |x: f64| if uniform(2) < 0.5 { x } else { -x };
    match uniform(1) {
        kind if kind < 0.5 => {
            let literal = literals[(uniform(3) * literals.len() as f64) as usize % literals.len()];
            let beside = 10f64.powf(-4.0 * uniform(4)) * if uniform(5) < 0.5 { 1.0 } else { -1.0 };
            signed(literal) + beside * if literal == 0.0 { 1.0 } else { literal.abs().min(1.0) }
        }
        kind if kind < 0.75 => signed(10f64.powf(6.0 * uniform(3) - 3.0)),
        _ => sample(symbol, trial, 0),
    }
}

/// Places at which a function changes its sign: that of a straight line, or those in a range of any size.
fn roots(f: impl Fn(f64) -> f64, literals: &[f64]) -> Vec<f64> {
    let [start, next, third] = [0.0, 1.0, 2.0].map(&f);
    let straight = start / (start - next);
    let beside = 1e-6 * straight.abs().max(1.0);
    if (third - 2.0 * next + start).abs() <= 1e-9 * (next - start).abs()
        && (f(straight - beside) < 0.0) != (f(straight + beside) < 0.0)
        && f(straight).abs() <= 1e-12 * start.abs()
    {
        return vec![straight];
    }
    let even = (0..=PARTS).map(|k| RANGE * (2.0 * f64::from(k) / f64::from(PARTS) - 1.0) + 1e-3);
    let sizes = (-2 * DECADES..=2 * DECADES).map(|k| 10f64.powf(0.5 * f64::from(k)));
    let eighths = (1..=8).map(|k| 0.25 * f64::from(k) * core::f64::consts::PI);
    let sizes = sizes.chain(eighths).chain(literals.iter().copied()).flat_map(|x| [-x, x]);
    let mut places: Vec<(f64, f64)> =
        even.chain(sizes).map(|x| (x, f(x))).filter(|(_, y)| !y.is_nan()).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let changes = places.windows(2).filter(|ends| (ends[0].1 < 0.0) != (ends[1].1 < 0.0));
    let root = |ends: &[(f64, f64)]| {
        let (mut low, mut high, negative) = (ends[0].0, ends[1].0, ends[0].1 < 0.0);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return high;
            }
            let end = if (f(middle) < 0.0) == negative { &mut low } else { &mut high };
            *end = middle;
        }
    };
    changes.take(MAX_ROOTS).map(root).collect()
}
