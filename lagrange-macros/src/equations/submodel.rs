//! Derived systems: the definition read again, then changes of its energies, then the equations.
//!
//! What is held and what is neglected are values of names, so they come first; what follows the others as in statics
//! is found from that system, and held in a second reading; expansions and terms of a kind are changes of L, D and Q
//! in q and q̇ (`equations/simplified.rs`), in the order in which they are written.

use super::check::{TRIALS, numbers_of, pivots, sample};
use super::restriction;
use super::simplified::{self, Parts};
use super::solve::Symmetric;
use super::{Derived, derived, statics};
use crate::diagnostics::Errors;
use crate::graph::{Graph, Symbol, Value};
use crate::model::submodel::{Change, Made, Move, Submodel, Variation};
use crate::model::{self, Model};
use crate::syntax::{Definition, Kind};

/// Derives one of the systems that a definition asks for. Whatever is wrong with it is wrong with a move, and not
/// with the definition.
pub fn submodel(
    definition: &Definition,
    whole: &Derived,
    asked: &Submodel,
    errors: &mut Errors,
) -> Option<Derived> {
    let source = Source { definition, whole, asked };
    if asked.exact {
        let small = source.read(&asked.moves).and_then(equations);
        let small = small.map_err(|reason| source.unformed(reason, errors)).ok()?;
        restriction::check(whole, &small, asked, errors);
        return Some(small);
    }
    source.simplified(errors)
}

type Reading = (Graph, Model);

fn equations(reading: Reading) -> Result<Derived, String> {
    let found = &mut Errors::default();
    let small = derived(reading, found);
    small.filter(|_| found.is_empty()).ok_or_else(|| reason(found))
}

/// The first line of the first error.
fn reason(errors: &Errors) -> String {
    errors.earliest().unwrap_or_default().lines().next().unwrap_or_default().to_string()
}

struct Source<'s> {
    definition: &'s Definition,
    whole: &'s Derived,
    asked: &'s Submodel,
}

impl Source<'_> {
    /// The system after these moves, which are sorted.
    fn read(&self, moves: &[Move]) -> Result<Reading, String> {
        let whole = &self.whole.model;
        let found = &mut Errors::default();
        let mut variation =
            Variation { whole, graph: &self.whole.graph, holds: Vec::new(), zeros: Vec::new() };
        let mut following = Vec::new();
        for m in moves {
            match &m.change {
                Change::Hold(holds) => variation.holds.extend(holds),
                Change::Neglect(name, zero) => variation.zeros.push((name, zero)),
                Change::Quasistatic(all) => following.extend(all),
                _ => {}
            }
        }
        let (holds, zeros) = (variation.holds.clone(), variation.zeros.clone());
        let header = &self.asked.header;
        let reading = model::submodel(self.definition, header, variation, found);
        let mut reading = reading.ok_or_else(|| reason(found))?;
        if !following.is_empty() {
            let (graph, follow) = statics::statics(&reading, self.whole, &following)?;
            let holds = [holds, follow].concat();
            let variation = Variation { whole, graph: &graph, holds, zeros };
            let again = model::submodel(self.definition, header, variation, found);
            reading = again.ok_or_else(|| reason(found))?;
            simplified::carried(&mut reading);
        }
        let numbers = numbers(whole, &reading.1);
        for m in moves {
            simplified::apply(&mut reading, &m.change, &self.whole.graph, &numbers)?;
        }
        if let Some(origin) = &mut reading.1.origin {
            origin.exact = self.asked.exact;
        }
        Ok(reading)
    }

    fn simplified(&self, errors: &mut Errors) -> Option<Derived> {
        let mut moves = self.asked.moves.clone();
        moves.sort_by_key(|m| match m.change {
            Change::Hold(_) => 0,
            Change::Neglect(..) => 1,
            Change::Quasistatic(_) => 2,
            _ => 3,
        });
        let held = moves.iter().take_while(|m| matches!(m.change, Change::Hold(_))).count();
        let mut before = self.read(&moves[..held]).map_err(|reason| self.unformed(reason, errors)).ok()?;
        let mut removed = Vec::new();
        for i in held..moves.len() {
            let refused = |reason| refuse(errors, &moves[i], "this move cannot be made", reason);
            let after = self.read(&moves[..=i]).map_err(refused).ok()?;
            let comparison = Comparison::new(&before, &after, &moves[i].change);
            if let Some(message) = comparison.objection() {
                errors.push(&moves[i].at, message);
                return None;
            }
            removed.push(comparison);
            before = after;
        }
        let small = equations(before).map_err(|last| self.culprit(&moves, last, errors));
        let mut small = small.ok()?;
        let cost = |d: &Derived| d.equations.solved.operations.cost();
        // Statics and averages take away what is fast, and so most of the steps, at the price of some operations.
        let slow = moves.iter().any(|m| matches!(m.change, Change::Quasistatic(_) | Change::Average(_)));
        if cost(&small) > cost(self.whole) && !slow {
            let message = format!(
                "this system costs more than the whole one: {} operations, each weighted by its time, and not {}\nhelp: expand to a lower order, or leave out the move that makes it longer",
                cost(&small),
                cost(self.whole)
            );
            errors.push(&self.asked.header.name, message);
            return None;
        }
        document(&mut small, &moves, held, removed);
        Some(small)
    }

    /// Reports that there is no system with these coordinates held, at the first of them with which there is none.
    fn unformed(&self, reason: String, errors: &mut Errors) {
        let message = format!(
            "the system cannot be formed where these coordinates are held: {reason}\nhelp: hold others, or hold them elsewhere"
        );
        let holds = self.asked.moves.iter().filter(|m| matches!(m.change, Change::Hold(_)));
        let holds: Vec<Move> = holds.cloned().collect();
        let meaningless = |k: &usize| self.read(&holds[..=*k]).is_err();
        let without_equations = |k: &usize| self.read(&holds[..=*k]).and_then(equations).is_err();
        match (0..holds.len()).find(meaningless).or_else(|| (0..holds.len()).find(without_equations)) {
            Some(k) => errors.push(&holds[k].at, message),
            None => errors.push(&self.asked.header.name, message),
        };
    }

    /// Reports the first move without which there would be equations.
    fn culprit(&self, moves: &[Move], last: String, errors: &mut Errors) {
        for i in 0..moves.len() {
            if let Err(reason) = self.read(&moves[..=i]).and_then(equations) {
                return refuse(errors, &moves[i], "this leaves no system", reason);
            }
        }
        errors.push(
            &self.asked.header.name,
            format!("these moves leave no system: {last}\nhelp: leave some of them out"),
        );
    }
}

/// Reports a move and the reason against it, which may have its own way out.
fn refuse(errors: &mut Errors, at: &Move, said: &str, reason: String) {
    let help = if reason.contains("help:") { "" } else { "\nhelp: leave this move out" };
    errors.push(&at.at, format!("{said}: {reason}{help}"));
}

/// The numbers of the parameters of a derived system by those of another one; none for those that are gone.
fn numbers(of: &Model, small: &Model) -> Vec<Option<usize>> {
    let place =
        |p: &model::Parameter| small.parameters.iter().find(|other| other.name == p.name).map(|p| p.first);
    of.parameters.iter().flat_map(|p| p.numbers().map(move |i| Some(place(p)? + i - p.first))).collect()
}

/// Differences of two systems, one move apart.
struct Comparison {
    graph: Graph,
    /// L, D and the forces of the first, less those of the second.
    differences: Option<Parts>,
    /// The next terms of an expansion.
    leading: Vec<(&'static str, Value)>,
    /// Coordinates that only the first depends on.
    freed: Vec<String>,
    /// Is the inertia matrix positive definite in the first alone?
    indefinite: bool,
    /// Names of the parameters of the first.
    labels: Vec<String>,
}

impl Comparison {
    fn new((graph, before): &Reading, (other, after): &Reading, change: &Change) -> Comparison {
        let mut g = graph.clone();
        let labels = before.parameter_labels();
        let mut comparison = Comparison {
            graph: Graph::default(),
            differences: None,
            leading: Vec::new(),
            freed: Vec::new(),
            indefinite: false,
            labels,
        };
        if let Change::Quasistatic(_) = change {
            return comparison;
        }
        let first = Parts::of(&mut g, before);
        let numbers = numbers(before, after);
        let back = |i: usize| numbers.iter().position(|n| *n == Some(i)).expect("it has no other parameters");
        let mut small = other.clone();
        let second = Parts::of(&mut small, after);
        let imported = |g: &mut Graph, values: &[Value]| {
            g.import(&small, values, |g, symbol| match symbol {
                Symbol::Parameter(i) => g.symbol(Symbol::Parameter(back(i))),
                other => g.symbol(other),
            })
        };
        let second = second.map(|values| imported(&mut g, values));
        let depends =
            |g: &Graph, parts: &Parts, i: usize| g.depends(&parts.all(), |s| s == Symbol::Coordinate(i));
        // The components of a direction are tied to each other.
        let is_direction = |i: usize| before.coordinates[i].kind == Kind::Direction;
        let freed = (0..before.mechanical())
            .filter(|&i| depends(&g, &first, i) && !depends(&g, &second, i) && !is_direction(i));
        comparison.freed = freed.map(|i| before.coordinates[i].label()).collect();
        if let Change::Neglect(..) = change {
            let [was, is] = [&first, &second].map(|parts| is_indefinite(&mut g, parts, before.mechanical()));
            comparison.indefinite = is && !was;
        }
        if let Change::Expand(..) = change {
            let made = after.origin.iter().flat_map(|o| &o.moves).last();
            let remainders = made.iter().flat_map(|made| &made.remainders);
            comparison.leading =
                remainders.map(|&(letter, value)| (letter, imported(&mut g, &[value])[0])).collect();
        }
        comparison.differences = Some(first.less(&second, &mut g));
        comparison.graph = g;
        comparison
    }

    /// The reason why a move is none, or too much.
    fn objection(&self) -> Option<String> {
        let differences = self.differences.as_ref()?;
        if differences.all().iter().all(|v| v.is_zero()) {
            return Some("this changes neither an energy nor a force\nhelp: leave this move out".into());
        }
        if self.indefinite {
            let message = "without these terms the inertia matrix is not positive definite: some velocities have a kinetic energy that is negative\nhelp: leave this move out, or neglect the products with these velocities as well";
            return Some(message.into());
        }
        let label = self.freed.first()?;
        Some(format!(
            "without these terms nothing depends on `{label}`: neither an energy nor a force says where it is\nhelp: leave this move out, or hold `{label}` by `lock {label} = …`"
        ))
    }
}

/// Has the inertia matrix a negative pivot at some state, with positive parameters? (One that vanishes is told with
/// the equations.)
fn is_indefinite(g: &mut Graph, parts: &Parts, mechanical: usize) -> bool {
    let velocities: Vec<Symbol> = (0..mechanical).map(Symbol::Velocity).collect();
    let momenta = g.gradient(parts.lagrangian, &velocities);
    let rows = momenta.iter().enumerate().map(|(i, p)| g.gradient(*p, &velocities[..=i]));
    let inertia: Symmetric = rows.collect();
    (0..TRIALS).any(|trial| {
        let m = numbers_of(g, &inertia, |s| sample(s, trial, 31));
        let largest = m.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        pivots(m).into_iter().any(|pivot| pivot < -1e-9 * largest)
    })
}

/// Notes what was left out by each move, in the names of the derived system and of what is gone.
fn document(small: &mut Derived, moves: &[Move], held: usize, removed: Vec<Comparison>) {
    let Derived { graph, model, .. } = small;
    let mut labels = model.parameter_labels();
    let count = labels.len();
    let mut made: Vec<Made> = moves[..held].iter().map(|m| made_of(m, Vec::new())).collect();
    for (m, comparison) in moves[held..].iter().zip(removed) {
        let Comparison { graph: other, differences, leading, labels: names, .. } = comparison;
        let parts = match &m.change {
            Change::Expand(..) => leading,
            Change::Average(_) => Vec::new(),
            _ => differences.iter().flat_map(Parts::named).collect(),
        };
        let parts = parts.into_iter().map(|(letter, value)| {
            let value = graph.import(&other, &[value], |g, symbol| match symbol {
                Symbol::Parameter(i) => {
                    let place = labels.iter().position(|label| *label == names[i]).unwrap_or_else(|| {
                        labels.push(names[i].clone());
                        labels.len() - 1
                    });
                    g.symbol(Symbol::Parameter(place))
                }
                other => g.symbol(other),
            })[0];
            (letter, value)
        });
        made.push(made_of(m, parts.collect()));
    }
    if let Some(origin) = &mut model.origin {
        (origin.moves, origin.gone) = (made, labels.split_off(count));
    }
}

fn made_of(m: &Move, remainders: Vec<(&'static str, Value)>) -> Made {
    Made { words: crate::diagnostics::plain(&m.at), remainders }
}
