//! Random systems: what the compiler derives against dual numbers of the same energies.
//!
//! The two routes share nothing but the text of the system. `cargo test` tries [`few`]; more, or one again, by
//!
//! ```text
//! LAGRANGE_SYSTEMS=100000 cargo test --release -p lagrange-macros -- --ignored --nocapture many_random_systems
//! LAGRANGE_SEED=17 cargo test -p lagrange-macros -- --nocapture random_systems
//! ```
//!
//! and what rustc makes of them is compared with the interpreter of the graph by
//!
//! ```text
//! LAGRANGE_SYSTEMS=200 cargo test -p lagrange-macros -- --ignored --nocapture random_systems_through_rustc
//! ```

mod changed;
mod compiled;
pub mod generate;
mod recurrences;
mod reference;
mod rounding;
mod scaled;

use crate::compile::{reduced, system as system_of};
use crate::diagnostics::Errors;
use crate::equations::structure::Facts;
use crate::equations::{Derived, Equations};
use crate::graph::{self, Symbol};
use crate::model::Reduction;
use crate::program::lower::program;
use crate::syntax;
use crate::table::{Computation, OUTPUTS};
use generate::{Random, System, driven, system};
use nalgebra::DMatrix;
use reference::{Named, Reference, State};
use rounding::{Noise, SIZE};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{LazyLock, Mutex};

/// Systems tried by `cargo test`, and with [`LONG`]. (`.ci/full` tries thousands.)
pub fn few() -> u64 {
    if *LONG { 150 } else { 10 }
}
/// The environment variable `LAGRANGE_LONG` is set, as `.ci/run` does for optimised builds: more systems, larger ones.
pub static LONG: LazyLock<bool> = LazyLock::new(|| std::env::var_os("LAGRANGE_LONG").is_some());
/// Number of systems after which progress is printed.
const TOLD: u64 = 2000;
/// Computations with noise on each side.
const RUNS: u64 = 4;
/// Rounding errors may add up where noise in [`RUNS`] computations happened to cancel.
const SAFETY: f64 = 256.0;
/// Uncertainty, relative to numbers above 1, beyond which a value is counted and not compared.
const KNOWN: f64 = 1e-6;

/// Messages that are true of random systems now and then.
const DEGENERATE: [&str; 7] = [
    "does not move with the coordinates",
    "does not move: a force there does no work",
    "does not turn: a couple on it does no work",
    "does not depend on any coordinate",
    "so its rate is 0",
    "coordinates of this system are ignorable",
    // A linkage at full reach: a constraint that is the sum of its bars.
    "vanishes wherever it holds",
];

/// Messages about inertia and constraints, true where inertia that is bordered by constraints is singular.
const SINGULAR: [&str; 5] = [
    "the inertia matrix is singular",
    "has a vanishing diagonal",
    "has no kinetic energy",
    "can never hold",
    // Two turns about one axis, of which a coordinate cancels out.
    "`L` is degenerate: it has no term of second degree",
];

/// A system with numbers.
struct Case {
    seed: u64,
    system: System,
    parameters: Vec<f64>,
    state: State<f64>,
    given: Vec<f64>,
}

/// The text of a random system.
pub fn written(seed: u64) -> String {
    Case::new(seed).text()
}

impl Case {
    fn new(seed: u64) -> Case {
        let mut random = Random::new(seed);
        let system = system(&mut random);
        Case::of(seed, system, random)
    }

    /// A system with random numbers.
    fn of(seed: u64, system: System, mut random: Random) -> Case {
        let mut numbers = |n: usize, low: f64, high: f64| (0..n).map(|_| random.between(low, high)).collect();
        let n = system.coordinates;
        let (parameters, q, qd) =
            (numbers(system.parameters, 0.4, 1.4), numbers(n, -1.4, 1.4), numbers(n, -1.4, 1.4));
        let given = numbers((n + system.constraints.len()).max(3), -1.4, 1.4);
        let t = random.between(-1.4, 1.4);
        Case { seed, system, parameters, state: State { q, qd, t }, given }
    }

    fn text(&self) -> String {
        self.system.written("Random")
    }

    /// Its equations, and those of the reduced system.
    fn compiled(&self) -> Result<(Derived, Option<Derived>), Vec<String>> {
        let mut errors = Errors::default();
        let tokens = format!("@crate [::lagrange_runtime] {}", self.text()).parse().expect("tokens");
        let whole =
            syntax::parse(tokens, &mut errors).and_then(|definition| system_of(&definition, &mut errors));
        let reduced = whole.as_ref().and_then(|whole| reduced(whole, &mut errors));
        whole.filter(|_| errors.is_empty()).map(|e| (e, reduced)).ok_or_else(|| errors.messages())
    }

    /// Values that the compiler gives to the names of the reference; `expected` are the values there, for momenta.
    fn found(&self, d: &Derived, reduced: Option<&Derived>, expected: &Named, noise: &Noise) -> Named {
        let n = self.system.coordinates;
        let mut names = Vec::new();
        let mut values: Vec<graph::Value> = Vec::new();
        let mut add = |name: &str, all: &[graph::Value]| {
            names.extend((0..all.len()).map(|i| format!("{name}[{i}]")));
            values.extend(all);
        };
        for output in OUTPUTS {
            if let Some(values) = (output.values)(d).and_then(Computation::values) {
                add(output.name, &values);
            }
        }
        for (j, generalized) in d.equations.quantities.impulses.iter().enumerate() {
            add(&format!("blow {j}"), generalized);
        }
        for (j, value) in d.equations.quantities.observed.iter().enumerate() {
            add(&format!("seen {j}"), value);
        }
        for (j, event) in d.equations.events.iter().flatten().enumerate() {
            let known: Vec<graph::Value> = [event.value].into_iter().chain(event.rates[0]).collect();
            add(&format!("hit {j}"), &known);
        }
        let momenta: Vec<f64> = of(expected, "momenta").collect();
        let reduction = reduced.and_then(|r| r.model.reduction.as_ref());
        let kept: &[usize] = reduction.map_or(&[], |r| &r.kept);
        let removed: Vec<usize> = reduction.iter().flat_map(|r| &r.removed).map(|r| r.index).collect();
        let symbol = |s: Symbol| match s {
            Symbol::Time => self.state.t,
            Symbol::Coordinate(i) => self.state.q[i],
            Symbol::Velocity(i) => self.state.qd[i],
            Symbol::Momentum(i) => momenta[i],
            Symbol::Given(i) => self.given[i],
            // Those of a reduced system are followed by momenta.
            Symbol::Parameter(i) => {
                self.parameters.get(i).copied().unwrap_or_else(|| momenta[removed[i - self.parameters.len()]])
            }
            other => panic!("{other:?} is left in the equations"),
        };
        let noisy = |d: &Derived, values: &[graph::Value], symbol: &dyn Fn(Symbol) -> f64| {
            program(&d.graph, values).evaluate(&[], |s| noise.apply(symbol(s)), |x| noise.apply(x))
        };
        let mut found: Named = names.into_iter().zip(noisy(d, &values, &symbol)).collect();
        if let Some(series) = &d.equations.series {
            let orders =
                recurrences::coefficients(series, &d.graph, n, 1 + reference::ORDERS, &symbol, noise);
            for (order, all) in orders.iter().enumerate().skip(1) {
                found.extend(all.iter().enumerate().map(|(i, x)| (format!("series {order}[{i}]"), *x)));
            }
        }
        if let Some(reduced) = reduced {
            let symbol = |s: Symbol| match s {
                Symbol::Coordinate(i) => symbol(Symbol::Coordinate(kept[i])),
                Symbol::Velocity(i) => symbol(Symbol::Velocity(kept[i])),
                Symbol::Momentum(i) => symbol(Symbol::Momentum(kept[i])),
                other => symbol(other),
            };
            let mut add = |name: &str, values: &[graph::Value]| {
                let values = noisy(reduced, values, &symbol);
                found.extend(kept.iter().zip(values).map(|(i, x)| (format!("reduced {name}[{i}]"), x)));
            };
            let Equations { quantities, solved, responses, .. } = &reduced.equations;
            add("accel", &solved.accel);
            add("momenta", &quantities.momenta);
            if let Some(legendre) = &responses.legendre {
                add("velocities", &legendre.velocities);
            }
            let scalars = noisy(reduced, &[quantities.lagrangian, quantities.energy_function], &symbol);
            let names = ["reduced lagrangian[0]", "reduced energy_function[0]"].map(String::from);
            found.extend(names.into_iter().zip(scalars));
            if let Some(series) = &reduced.equations.series {
                let (g, n) = (&reduced.graph, kept.len());
                let orders = recurrences::coefficients(series, g, n, 1 + reference::ORDERS, &symbol, noise);
                for (order, all) in orders.iter().enumerate().skip(1) {
                    let all = kept.iter().zip(all);
                    found.extend(all.map(|(i, x)| (format!("reduced series {order}[{i}]"), *x)));
                }
            }
        }
        found
    }

    /// Expected values, by dual numbers.
    fn expected(&self, reduction: Option<&Reduction>, noise: &Noise) -> Option<(Named, f64)> {
        let reference = Reference { system: &self.system, parameters: &self.parameters, noise };
        let (mut named, condition) = reference.named(&self.state, &self.given)?;
        let mut more = Named::new();
        for (i, v) in self.state.qd.iter().enumerate() {
            more.push((format!("velocities[{i}]"), *v));
        }
        // A reduced system moves as the whole one, by R = L − Σ p q̇ over the coordinates that are gone.
        if let Some(reduction) = reduction {
            more.extend(more.iter().map(|(name, v)| (format!("reduced {name}"), *v)).collect::<Named>());
            let same = |name: &str| {
                ["accel[", "momenta[", "energy_function[", "series "].iter().any(|n| name.starts_with(n))
            };
            let same = named.iter().filter(|(name, _)| same(name));
            more.extend(same.map(|(name, v)| (format!("reduced {name}"), *v)));
            let momenta: Vec<f64> = of(&named, "momenta").collect();
            let gone =
                reduction.removed.iter().map(|r| noise.apply(momenta[r.index] * self.state.qd[r.index]));
            let lagrangian: f64 = of(&named, "lagrangian").sum();
            more.push(("reduced lagrangian[0]".into(), lagrangian - gone.sum::<f64>()));
        }
        named.extend(more);
        Some((named, condition))
    }

    fn check(&self, tally: &mut Tally) {
        let text = || format!("LAGRANGE_SEED={}\n{}", self.seed, self.text());
        let (whole, reduced) = match self.compiled() {
            Ok(pair) => pair,
            // Random terms may cancel, and then nothing moves where something should.
            Err(messages) if messages.iter().all(|m| DEGENERATE.iter().any(|part| m.contains(part))) => {
                tally.degenerate += 1;
                return;
            }
            // Two turns about the same axis, which constraints may lead all the same; coordinates that cancel out of
            // a constraint.
            Err(messages)
                if messages.iter().all(|m| SINGULAR.iter().any(|part| m.contains(part)))
                    && self.is_singular() =>
            {
                tally.degenerate += 1;
                return;
            }
            Err(messages) => panic!("refused: {messages:#?}\n{}", text()),
        };
        assert_eq!(reduced.is_some(), self.system.ignorable, "{}", text());
        let Some(values) = self.values(&whole, reduced.as_ref()) else {
            // A choice may take the coordinates out of a constraint at this state.
            let momenta = (0..self.system.coordinates).map(|i| (format!("momenta[{i}]"), 0.0)).collect();
            let found = self.found(&whole, None, &momenta, &Noise::of_run(0, self.seed));
            let known = of(&found, "accel").all(f64::is_finite);
            assert!(!known, "accelerations where the bordered inertia is singular\n{}", text());
            tally.degenerate += 1;
            return;
        };
        tally.systems += 1;
        for kind in self.kinds(&whole) {
            *tally.kinds.entry(kind).or_default() += 1;
        }
        self.check_cascade(&whole, &values);
        for value in values {
            let Value { name, expected, found, granted, condition, .. } = &value;
            let Some(found) = found else { continue };
            tally.values += 1;
            if !value.known() {
                tally.uncertain += 1;
                continue;
            }
            let error = (found - expected).abs();
            assert!(
                error <= *granted,
                "{name} is {found:e}, should be {expected:e}: off by {error:.1e}, granted {granted:.1e} \
                 (condition {condition:.1e})\n{}",
                text()
            );
            tally.note(
                SAFETY * error / granted,
                error / expected.abs().max(1.0),
                *condition,
                self.seed,
                name,
            );
        }
    }

    /// Accelerations of coordinates that are said to drive others do not depend on these.
    fn check_cascade(&self, whole: &Derived, values: &[Value]) {
        let (n, groups) = (self.system.coordinates, &whole.equations.facts.cascade);
        for (k, group) in groups.iter().enumerate() {
            let (drivers, driven) = (groups[..k].concat(), group);
            let slopes =
                drivers.iter().flat_map(|i| driven.iter().flat_map(move |j| [j * n + i, (n + j) * n + i]));
            for name in slopes.map(|place| format!("jacobian[{place}]")) {
                let slope = values.iter().find(|value| value.name == name).expect("a slope of the reference");
                assert!(
                    !slope.known() || slope.expected.abs() <= slope.granted,
                    "{groups:?}, but {name} is {:e}\n{}",
                    slope.expected,
                    self.text()
                );
            }
        }
    }

    /// Has M, or the bordered inertia, no inverse?
    fn is_singular(&self) -> bool {
        let Some((named, condition)) = self.expected(None, &Noise::of_run(0, self.seed)) else { return true };
        let n = self.system.coordinates;
        let inertia = DMatrix::from_iterator(n, n, of(&named, "inertia"));
        let values = inertia.symmetric_eigenvalues();
        condition > 1e12 || values.min() <= 1e-12 * values.max()
    }

    /// Kinds of which it is counted as one.
    fn kinds(&self, d: &Derived) -> Vec<&'static str> {
        let s = &self.system;
        let parts = [
            ("constraints", !s.constraints.is_empty()),
            ("prescribed coordinates", !s.prescribed.is_empty()),
            ("friction", s.dissipation.is_some()),
            ("forces", !s.forces.is_empty() || !s.applied.is_empty()),
            ("impulses", !s.struck.is_empty()),
            ("a reduced system", s.ignorable),
            ("a Taylor series", d.equations.series.is_some()),
        ];
        [s.kind].into_iter().chain(parts.into_iter().filter(|p| p.1).map(|p| p.0)).collect()
    }

    /// Everything that the reference knows; nothing where the bordered inertia is singular.
    fn values(&self, whole: &Derived, reduced: Option<&Derived>) -> Option<Vec<Value>> {
        let reduction = reduced.and_then(|r| r.model.reduction.as_ref());
        let runs: Option<Vec<(Named, Named, f64)>> = (0..=RUNS)
            .map(|run| {
                let (expected, condition) = self.expected(reduction, &Noise::of_run(run, self.seed))?;
                let noise = Noise::of_run(run, !self.seed);
                let found = self.found(whole, reduced, &expected, &noise);
                Some((expected, found, condition))
            })
            .collect();
        let runs = runs?;
        let strays = runs[0].1.iter().filter(|(name, _)| runs[0].0.iter().all(|(other, _)| other != name));
        let strays: Vec<_> = strays.collect();
        assert!(strays.is_empty(), "{strays:?} not in the reference\n{}", self.text());
        let place_of = |name: &str| runs[0].1.iter().position(|(other, _)| other == name);
        let moved = |of: &dyn Fn(&(Named, Named, f64)) -> f64| {
            runs.iter().map(|run| (of(run) - of(&runs[0])).abs()).fold(0.0, f64::max) / SIZE
        };
        let value = |(k, (name, expected)): (usize, &(String, f64))| {
            let place = place_of(name);
            let of_reference = moved(&|run| run.0[k].1);
            // What only the runtime works out is taken to be as uncertain as the reference.
            let of_found = place.map_or(of_reference, |place| moved(&|run| run.1[place].1));
            // How much the result moves for each relative change of its operations.
            let amplified = of_reference + of_found;
            Value {
                name: name.clone(),
                expected: *expected,
                found: place.map(|place| runs[0].1[place].1),
                granted: SAFETY * f64::EPSILON * amplified + f64::MIN_POSITIVE,
                condition: runs[0].2,
            }
        };
        Some(runs[0].0.iter().enumerate().map(value).collect())
    }
}

/// A number that two routes lead to.
struct Value {
    name: String,
    expected: f64,
    /// The value of the interpreter, unless the runtime alone works it out.
    found: Option<f64>,
    /// Largest admitted difference of the two.
    granted: f64,
    /// Condition number of the bordered inertia.
    condition: f64,
}

impl Value {
    /// Is it certain enough to be compared? Where the reference overflows on its way, it says nothing.
    fn known(&self) -> bool {
        self.expected.is_finite() && self.granted <= KNOWN * self.expected.abs().max(1.0)
    }
}

fn of<'n>(named: &'n Named, name: &'n str) -> impl Iterator<Item = f64> + 'n {
    let belongs = move |full: &str| full.strip_prefix(name).is_some_and(|rest| rest.starts_with('['));
    named.iter().filter(move |(full, _)| belongs(full)).map(|(_, value)| *value)
}

#[derive(Default)]
struct Tally {
    systems: u64,
    values: u64,
    uncertain: u64,
    degenerate: u64,
    /// Systems of each kind, and with each thing that a system may have.
    kinds: BTreeMap<&'static str, u64>,
    /// Seeds of those that are wrong.
    failed: Vec<u64>,
    /// Largest error, in roundings of all operations; and relative to numbers above 1.
    worst: (f64, String),
    largest: (f64, String),
}

impl Tally {
    fn note(&mut self, rounded: f64, relative: f64, condition: f64, seed: u64, name: &str) {
        for (worst, value) in [(&mut self.worst, rounded), (&mut self.largest, relative)] {
            if value > worst.0 {
                *worst = (
                    value,
                    format!("{name} of system {seed}, condition of the bordered inertia {condition:.1e}"),
                );
            }
        }
    }

    fn add(&mut self, other: Tally) {
        let Tally { systems, values, uncertain, degenerate, kinds, failed, worst, largest } = other;
        self.systems += systems;
        self.values += values;
        self.uncertain += uncertain;
        self.degenerate += degenerate;
        kinds.into_iter().for_each(|(kind, n)| *self.kinds.entry(kind).or_default() += n);
        self.failed.extend(failed);
        for (own, other) in [(&mut self.worst, worst), (&mut self.largest, largest)] {
            if other.0 > own.0 {
                *own = other;
            }
        }
    }

    /// The state of the tally; what is printed last is the result of a run that does not come to its end.
    fn said(&self) -> String {
        let Tally { systems, values, uncertain, degenerate, kinds, failed, worst, largest } = self;
        let kinds: Vec<String> = kinds.iter().map(|(kind, n)| format!("{kind}: {n}")).collect();
        format!(
            "{systems} systems ({degenerate} more are degenerate), {values} values, {uncertain} too uncertain, {} wrong {failed:?}\n\
             of these {}\nworst: {:.2} roundings, {}\nlargest: {:.1e} relative, {}",
            failed.len(),
            kinds.join(", "),
            worst.0,
            worst.1,
            largest.0,
            largest.1
        )
    }

    fn report(&self) {
        let Tally { systems, degenerate, failed, .. } = self;
        println!("{}", self.said());
        assert!(failed.is_empty(), "systems {failed:?}");
        // One system alone may be anything.
        if *systems >= few() / 2 {
            // With bodies on frames 480 of 26 000 are.
            assert!(degenerate * 30 <= *systems, "too many systems are degenerate");
            assert!(
                self.uncertain * 50 <= self.values,
                "generated systems are too ill-conditioned to say much"
            );
        }
    }
}

pub fn variable(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().expect("a number"))
}

/// Checks these systems on all processors.
fn check(seeds: std::ops::Range<u64>) {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (next, total) = (AtomicU64::new(seeds.start), Mutex::new(Tally::default()));
    let share = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return;
            }
            let mut own = Tally::default();
            // What is wrong with one is printed, and the others are tried.
            let tried =
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| Case::new(seed).check(&mut own)));
            if tried.is_err() {
                own = Tally { failed: vec![seed], ..Tally::default() };
            }
            let mut total = total.lock().expect("no panic while it is held");
            total.add(own);
            if (seed + 1 - seeds.start).is_multiple_of(TOLD) {
                println!("to seed {seed}: {}", total.said());
            }
        }
    };
    std::thread::scope(|scope| {
        (0..threads).for_each(|_| drop(scope.spawn(share)));
    });
    total.into_inner().expect("no panic while it is held").report();
}

#[test]
fn random_systems() {
    match variable("LAGRANGE_SEED") {
        Some(seed) => {
            println!("{}", Case::new(seed).text());
            check(seed..seed + 1);
        }
        None => {
            check(0..few());
            // Where something was found, as the generator is now.
            [52_701, 84_388, 113_456, 5_033_808].into_iter().for_each(|seed| check(seed..seed + 1));
        }
    }
}

/// Groups of oscillators that drive others are found: none is larger than what slopes of the accelerations tell.
#[test]
fn random_cascades() {
    let (mut tally, mut cascades) = (Tally::default(), 0);
    for seed in 0..few() / 2 {
        let mut random = Random::new(seed);
        let case = Case::of(seed, driven(&mut random), random);
        case.check(&mut tally);
        let Ok((whole, _)) = case.compiled() else { continue };
        let Some(values) = case.values(&whole, None) else { continue };
        let n = case.system.coordinates;
        let slopes: BTreeMap<&str, f64> = values.iter().map(|v| (&*v.name, v.expected)).collect();
        let depends = |i: usize, j: usize| {
            [j * n + i, (n + j) * n + i].iter().any(|k| slopes[&*format!("jacobian[{k}]")] != 0.0)
        };
        // Each reaches every other one of its group.
        for group in &whole.equations.facts.cascade {
            let mut reached = vec![group[0]];
            for k in 0.. {
                let Some(&at) = reached.get(k) else { break };
                let more: Vec<usize> =
                    group.iter().copied().filter(|j| depends(at, *j) && !reached.contains(j)).collect();
                reached.extend(more);
            }
            assert_eq!(reached.len(), group.len(), "{group:?}\n{}", case.text());
        }
        cascades += u64::from(whole.equations.facts.cascade.len() > whole.equations.facts.blocks.len());
    }
    tally.report();
    assert!(cascades > few() / 8, "{cascades}");
}

/// Every word of the language is written by the generator, or it would never be compared.
#[test]
fn every_word_is_written() {
    let all: Vec<String> = (0..150).map(|seed| Case::new(seed).text()).collect();
    let functions = graph::function::TABLE.iter().map(|row| format!("{}(", row.name));
    let words = "frame( body( particle( velocity( angular_velocity( .velocity() .angular_velocity() .point( .vector( .origin() \
        rotation([ rotation([[ rotation_x( rotation_y( rotation_z( .inverse() .norm_squared() .dot( couple force impulse constraint \
        routhian observe L D Q[ dot( powi( recip( mul_add( min( max( to_radians( to_degrees( < <= > >= != ! && || if";
    let words = words.split_whitespace().map(String::from);
    let missing: Vec<String> =
        functions.chain(words).filter(|word| !all.iter().any(|text| text.contains(word.as_str()))).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
#[ignore = "minutes"]
fn many_random_systems() {
    let first = variable("LAGRANGE_SEED").unwrap_or(few());
    check(first..first + variable("LAGRANGE_SYSTEMS").unwrap_or(100_000));
}
/// Values found, and values expected.
type Both = (Vec<f64>, Vec<f64>);

/// A random system and the same after a change of coordinates, order and units: accelerations, energy function and
/// power of the one, compiled, are those of the other, by duals.
fn check_changed(seed: u64) -> Option<()> {
    let old = Case::new(seed);
    let random = &mut Random::new(!seed);
    let n = old.system.coordinates;
    let change = changed::Change::random(random, n);
    let system = change.system(&old.system);
    let new = Case { system, given: Vec::new(), ..Case::new(seed) };
    let new = Case { given: vec![0.0; (n + new.system.constraints.len()).max(3)], ..new };
    let slower = 1.0 / change.time();
    let qd = change.applied(&new.state.qd).into_iter().map(|v| slower * v).collect();
    let state = State { q: change.applied(&new.state.q), qd, t: change.time() * new.state.t };
    let old = Case { state, ..old };
    let (equations, _) = new.compiled().ok()?;
    let runs: Vec<Both> = (0..=RUNS)
        .map(|run| {
            let (expected, _) = old.expected(None, &Noise::of_run(run, seed))?;
            let found = new.found(&equations, None, &expected, &Noise::of_run(run, !seed));
            let a: Vec<f64> = of(&found, "accel").collect();
            let a = change.applied(&a).into_iter().map(|a| slower * slower * a);
            let scalar = |name: &str, by: f64| of(&found, name).map(move |x| x / by).collect::<Vec<_>>();
            let energy = change.energy();
            let found: Vec<f64> = a
                .chain(scalar("energy_function", energy))
                .chain(scalar("power", energy * change.time()))
                .collect();
            let expected =
                ["accel", "energy_function", "power"].iter().flat_map(|name| of(&expected, name)).collect();
            Some((found, expected))
        })
        .collect::<Option<_>>()?;
    for k in 0..n + 2 {
        let moved = |of: &dyn Fn(&Both) -> f64| {
            runs.iter().map(|run| (of(run) - of(&runs[0])).abs()).fold(0.0, f64::max) / SIZE
        };
        let amplified = moved(&|run| run.0[k]) + moved(&|run| run.1[k]);
        let granted = SAFETY * f64::EPSILON * amplified + f64::MIN_POSITIVE;
        let (found, expected) = (runs[0].0[k], runs[0].1[k]);
        if granted <= KNOWN * expected.abs().max(1.0) {
            let error = (found - expected).abs();
            assert!(
                error <= granted,
                "value {k} is {found:e}, should be {expected:e}: off by {error:.1e}, granted {granted:.1e}\n\
                 LAGRANGE_SEED={seed}\n{}\nchanged to\n{}",
                old.text(),
                new.text()
            );
        }
    }
    Some(())
}

/// Seeds that are asked for, or some.
fn seeds() -> std::ops::Range<u64> {
    match variable("LAGRANGE_SEED") {
        Some(seed) => seed..seed + variable("LAGRANGE_SYSTEMS").unwrap_or(1),
        None => 0..few() / 2,
    }
}

/// Equations do not depend on the choice of coordinates, their order, or units.
#[test]
fn changed_systems() {
    let seeds = seeds();
    let all = seeds.end - seeds.start;
    let tried = seeds.filter(|seed| check_changed(*seed).is_some()).count() as u64;
    println!("{tried} changed systems");
    assert!(20 * tried >= 19 * all, "{tried} of {all}");
}

/// Masses, lengths and stiffnesses that are 0. An order of elimination may divide by a mass where M has an inverse
/// without it: then numbers are not finite, which every method reports; what is finite must be right, unless it jumps
/// there, as `signum(p * q)` does: a product of 0 has no sign.
#[test]
fn parameters_that_vanish() {
    let (mut finite, mut lost, mut singular, mut jumps) = (0, 0, 0, 0);
    for seed in seeds() {
        let mut case = Case::new(seed);
        let random = &mut Random::new(!seed);
        let hit = random.below(case.parameters.len());
        case.parameters[hit] = 0.0;
        let Ok((whole, _)) = case.compiled() else { continue };
        if !case.expected(None, &Noise::of_run(0, seed)).is_some_and(|(_, condition)| condition < 1e8) {
            singular += 1;
            continue;
        }
        let beside = [1e-12, -1e-12].map(|small| {
            let mut beside = Case { parameters: case.parameters.clone(), ..Case::new(seed) };
            beside.parameters[hit] = small;
            beside.values(&whole, None)
        });
        for (k, value) in case.values(&whole, None).expect("a regular inertia").into_iter().enumerate() {
            let Some(found) = value.found else { continue };
            let is_near = |other: &Option<Vec<Value>>| {
                let other = other.as_ref().and_then(|values| values.get(k));
                other.is_some_and(|at| {
                    (at.expected - value.expected).abs() <= 1e-6 * (1.0 + value.expected.abs())
                })
            };
            if !found.is_finite() {
                lost += 1;
            } else if value.known() && !beside.iter().all(is_near) {
                jumps += 1;
            } else if value.known() {
                finite += 1;
                let (name, expected) = (&value.name, value.expected);
                assert!(
                    (found - expected).abs() <= value.granted,
                    "{name} is {found:e}, should be {expected:e}, where p{hit} is 0\nLAGRANGE_SEED={seed}\n{}",
                    case.text()
                );
            }
        }
    }
    println!("{finite} values, {lost} not finite, {jumps} that jump, {singular} systems without inertia");
    assert!(finite > 20 * lost.max(jumps), "{finite} {lost} {jumps}");
}

/// Writes systems with Taylor series, their accelerations and what these are uncertain by, for
/// `tests/peers/sympy_systems.py`.
#[test]
#[ignore = "part of tests/peers/sympy_systems.py"]
fn written_for_sympy() {
    let file = std::env::var("LAGRANGE_FILE").expect("LAGRANGE_FILE: where to write");
    let first = variable("LAGRANGE_SEED").unwrap_or(0);
    let count = variable("LAGRANGE_SYSTEMS").unwrap_or(300) as usize;
    let mut all = Vec::new();
    for seed in first.. {
        let case = Case::new(seed);
        let Ok((equations, _)) = case.compiled() else { continue };
        // Choices between constants, or of what is not used, have series, and no word in that script.
        let text = case.text();
        let choices = ["(if ", "abs(", ".signum(", ").min(", ").max("].iter().any(|word| text.contains(word));
        if equations.equations.series.is_none() || choices {
            continue;
        }
        let Some(values) = case.values(&equations, None) else { continue };
        let values: Vec<String> = values
            .iter()
            .filter(|v| v.name.starts_with("accel[") && v.known())
            .map(|v| format!("[{:?}, {:e}, {:e}]", v.name, v.found.unwrap_or(f64::NAN), v.granted))
            .collect();
        let State { q, qd, t } = &case.state;
        all.push(format!(
            "{{\"seed\": {seed}, {}, \"p\": {:?}, \"q\": {q:?}, \"qd\": {qd:?}, \"t\": {t:?}, \"values\": [{}]}}",
            case.system.json(),
            case.parameters,
            values.join(", ")
        ));
        if all.len() == count {
            break;
        }
    }
    std::fs::write(file, format!("[{}]", all.join(",\n"))).expect("written");
}

/// Pivots of a coordinate without inertia that a constraint leads vanish without being written as 0: such an order of
/// elimination must not be taken. Found by random systems, whose accelerations or responses were not finite.
#[test]
fn pivots_that_vanish_unseen() {
    for text in [
        "param m, a, b; coord x, y; let f = frame(world, [a, 0, 0], rotation_z(x) * rotation_z(y + x)); \
         T = body(m, [[a, 0.1, 0.2], [0.1, a, 0.1], [0.2, 0.1, b]], frame(f, [a, b, -0.25])); V = m * x.powi(2) + b * y.powi(2); \
         constraint c: f.point([1, b, 0])[2] + 2.5 * x == 0.5;",
        "param m, a, b; coord x, y; let f = frame(world, [a, 0, 0], rotation_x(x.powi(2) + x) * rotation_x(y)); \
         T = body(m, [a, a, b], frame(f, [0, b, a])); V = m * x.powi(2) + b * y.powi(2); constraint c: 2.5 * x == b;",
        "param m, a, b; coord x, y; let u = (x + a * y).sin(); let v = (x + a * y).cos(); \
         T = 0.5 * m * (dot(u).powi(2) + dot(v).powi(2)); V = b * x * y; constraint c: x * y == 0.5;",
        "param m, a, b; coord x, y, z; let u = x.sin(); let v = x.cos(); \
         L = (dot(u).powi(2) + dot(v).powi(2)) * m + 2 * m * dot(x) * dot(y) + m * dot(y).powi(2) + a * dot(y) * dot(z) + b * x * y * z;",
    ] {
        let mut errors = Errors::default();
        let tokens = format!("@crate [::lagrange_runtime] system A {{ {text} }}").parse().expect("tokens");
        let d = syntax::parse(tokens, &mut errors).and_then(|definition| system_of(&definition, &mut errors));
        let Some(Derived { graph, equations: e, .. }) = d else {
            let messages = errors.messages();
            assert!(messages.iter().all(|m| SINGULAR.iter().any(|part| m.contains(part))), "{messages:?}");
            continue;
        };
        let Equations { formed, solved, responses, .. } = &e;
        let (matrix, right) = formed.rows.border(&solved.inertia, &solved.right);
        let at = |s: Symbol| crate::equations::check::sample(s, 7, 0);
        let values = |all: &[graph::Value]| graph.evaluate(all, at);
        let n = right.len();
        let lower = values(&matrix.concat());
        let dense = DMatrix::from_fn(n, n, |i, j| lower[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]);
        let solve = |right: Vec<f64>| {
            let right = nalgebra::DVector::from_vec(right);
            let mut x = dense.clone().full_piv_lu().solve(&right).expect("regular").as_slice().to_vec();
            x[solved.accel.len()..].iter_mut().for_each(|x| *x = -*x);
            x
        };
        let given = (0..n).map(|i| at(Symbol::Given(i))).collect();
        let response = responses.response.as_deref().unwrap_or_default();
        let found = [values(&[&solved.accel[..], &solved.multipliers].concat()), values(response)].concat();
        let response = if formed.rows.is_empty() { Vec::new() } else { solve(given) };
        let expected = [solve(values(&right)), response].concat();
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() <= 1e-10 * expected.abs().max(1.0),
                "{found} {expected}\n{text}"
            );
        }
    }
}

/// Facts of a system, or the messages that refuse it.
fn facts(text: &str) -> Result<Facts, String> {
    let mut errors = Errors::default();
    let tokens = format!("@crate [::lagrange_runtime] system A {{ {text} }}").parse().expect("tokens");
    let d = syntax::parse(tokens, &mut errors).and_then(|definition| system_of(&definition, &mut errors));
    d.map(|d| d.equations.facts).ok_or_else(|| errors.messages().concat())
}

/// Forces of time and of higher degree are seen wherever they are written, and what drops out is not.
#[test]
fn time_and_degrees_in_the_equations() {
    let kinetic = "param c; coord x, y; T = dot(x).powi(2) + dot(y).powi(2); V = x * x;";
    for (rest, [autonomous, quadratic_forces]) in [
        ("", [true, true]),
        ("Q[x] = if t > 5 && t < 10 { 1 } else { 0 };", [false, true]),
        ("Q[x] = c * exp(-(t - 50).powi(2));", [false, true]),
        ("Q[x] = min(max(t - 5, 0), 1);", [false, true]),
        ("Q[x] = signum(t - 5);", [false, true]),
        ("D = 0.5 * t * dot(x).powi(2);", [false, true]),
        ("constraint line: x + y == t;", [false, true]),
        ("constraint skate: dot(x) + t * dot(y) == 0;", [false, true]),
        ("constraint line: x + y == 1;", [true, true]),
        // Time that drops out.
        ("Q[x] = sin(t).powi(2) + cos(t).powi(2);", [true, true]),
        ("D = c * dot(x).powi(2) * (1 + y * y);", [true, true]),
        ("Q[x] = c * dot(x) * dot(y) - dot(x).powi(2) / (1 + x * x);", [true, true]),
        ("Q[x] = c * dot(x).powi(3);", [true, false]),
        ("Q[x] = -c * dot(x).abs() * dot(x);", [true, false]),
        ("Q[x] = if dot(y) > 0 { 1 } else { 0 };", [true, false]),
        ("Q[x] = if y > 0 { dot(x) } else { c };", [true, true]),
        ("Q[x] = 1 / (1 + dot(x));", [true, false]),
        ("Q[x] = sin(dot(y));", [true, false]),
    ] {
        let found = facts(&format!("{kinetic} {rest}")).expect(rest);
        assert_eq!([found.autonomous, found.quadratic_forces], [autonomous, quadratic_forces], "{rest}");
    }
    let relative = facts(
        "param w; coord r; let x = r * cos(w * t); let y = r * sin(w * t); T = dot(x).powi(2) + dot(y).powi(2); V = r;",
    );
    assert_eq!(relative.map(|f| [f.autonomous, f.scleronomic]), Ok([true, false]));
    let relativistic = facts("param c; coord x; L = -c * sqrt(c * c - dot(x).powi(2));");
    assert_eq!(relativistic.map(|f| [f.quadratic_forces, f.autonomous]), Ok([false, true]));
}

/// The forces besides those of L are linear in the velocities with constant coefficients, or not.
#[test]
fn damping_with_constant_coefficients() {
    let kinetic = "param c; coord x, y; T = dot(x).powi(2) + dot(y).powi(2); V = 1 - cos(x) + y.powi(4);";
    for (rest, expected) in [
        ("", true),
        ("D = 0.5 * c * (dot(x) - dot(y)).powi(2);", true),
        ("Q[x] = -c * dot(x) + 2 * dot(y);", true),
        ("Q[x] = c * x * dot(y) - c * dot(y) * x - dot(x);", true),
        ("D = 0.5 * c * (x * dot(x)).powi(2);", false),
        ("D = 0.5 * t * dot(x).powi(2);", false),
        ("Q[x] = 1;", false),
        ("Q[x] = -c * y;", false),
        ("Q[x] = -c * dot(x).powi(3);", false),
        ("Q[x] = -c * dot(x).abs();", false),
        ("Q[x] = -signum(dot(x));", false),
        ("Q[x] = if x > 0 { -dot(x) } else { dot(x) };", false),
        ("Q[x] = c * sin(t) - dot(x);", false),
    ] {
        assert_eq!(facts(&format!("{kinetic} {rest}")).expect(rest).linear_damping, expected, "{rest}");
    }
    let shaken = "param a; coord x; T = dot(x).powi(2); V = x * sin(a * t); D = dot(x).powi(2);";
    assert_eq!(facts(shaken).map(|f| f.linear_damping), Ok(false));
}

/// Found by random systems: each was compiled to something else than what was written.
#[test]
fn found_before() {
    // Derivatives of choices and signs vanish, and what they depend on is no ignorable coordinate for that.
    let kinetic = "coord x, y, z; T = dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2);";
    for rest in [
        "V = if y < 1 { x } else { x * x };",
        "V = x * x; Q[x] = if y < 1 { 1 } else { 2 };",
        "V = x * x; Q[x] = y.signum();",
        "V = x * x; D = if y < 1 { 1 } else { 2 } * dot(x).powi(2);",
        "V = x * x; constraint c: dot(x) == if y < 1 { 1 } else { 2 } * dot(z);",
    ] {
        let facts = facts(&format!("{kinetic} {rest}")).expect("accepted");
        assert!(!facts.ignorable.contains(&1), "{rest}: {facts:?}");
    }
    let piecewise = facts(&format!("{kinetic} V = if x < 0 {{ x * x }} else {{ 2 * x * x }};"));
    assert!(!piecewise.expect("accepted").linear);
    let jumping =
        facts("coord x, y; T = (if x < 0 { 1 } else { 2 }) * dot(x).powi(2) + dot(y).powi(2); V = 0;");
    assert!(!jumping.expect("accepted").constant_inertia);
    let timed =
        facts("coord x, y; T = dot(x).powi(2) + dot(y).powi(2); V = if t < 1 { x * x } else { y * y };");
    assert!(!timed.expect("accepted").conservative);
    let refused =
        facts(&format!("{kinetic} V = 0; constraint c: if dot(x) < 0 {{ dot(y) }} else {{ dot(z) }} == 0;"));
    assert!(refused.is_err_and(|message| message.contains("not linear in the velocities")));
    let refused = facts(&format!("{kinetic} V = 0; constraint c: if dot(x) < 0 {{ y }} else {{ z }} == 0;"));
    assert!(refused.is_err_and(|message| message.contains("not linear in the velocities")));
}
