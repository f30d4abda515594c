//! Random systems: what the compiler derives against dual numbers of the same energies.
//!
//! The two routes share nothing but the text of the system. `cargo test` tries [`FEW`]; more, or one again, by
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

mod generate;
mod reference;
mod rounding;

use crate::diagnostics::Errors;
use crate::equations::{Equations, equations, routhian::routhian, solve::entry};
use crate::graph::{Symbol, Value};
use crate::{model, syntax};
use generate::{Random, System, system};
use reference::{Named, Reference, State};
use rounding::{Noise, SIZE};

/// Systems tried by `cargo test`.
const FEW: u64 = 2000;
/// Computations with noise on each side.
const RUNS: u64 = 4;
/// Rounding errors may add up where noise in [`RUNS`] computations happened to cancel.
const SAFETY: f64 = 256.0;
/// What is less certain than this, relative to numbers above 1, is counted and not compared.
const KNOWN: f64 = 1e-6;

/// Messages that are true of random systems now and then.
const DEGENERATE: [&str; 4] = [
    "does not move with the coordinates",
    "does not depend on any coordinate",
    "so its rate is 0",
    "coordinates of this system are ignorable",
];

/// A system with numbers.
struct Case {
    seed: u64,
    system: System,
    parameters: Vec<f64>,
    state: State<f64>,
    given: Vec<f64>,
}

impl Case {
    fn new(seed: u64) -> Case {
        let mut random = Random::new(seed);
        let system = system(&mut random);
        let mut numbers = |n: usize, low: f64, high: f64| (0..n).map(|_| random.between(low, high)).collect();
        let n = system.coordinates;
        let (parameters, q, qd) =
            (numbers(system.parameters, 0.4, 1.4), numbers(n, -1.4, 1.4), numbers(n, -1.4, 1.4));
        let given = numbers(n + system.constraints.len(), -1.4, 1.4);
        let t = random.between(-1.4, 1.4);
        Case { seed, system, parameters, state: State { q, qd, t }, given }
    }

    fn text(&self) -> String {
        self.system.written("Random")
    }

    /// Its equations, and those of the reduced system.
    fn compiled(&self) -> Result<(Equations, Option<Equations>), Vec<String>> {
        let mut errors = Errors::default();
        let tokens = format!("@crate [::lagrange_runtime] {}", self.text()).parse().expect("tokens");
        let whole = syntax::parse(tokens, &mut errors)
            .and_then(|definition| model::model(definition, &mut errors))
            .and_then(|model| equations(model, &mut errors));
        let reduced = whole.as_ref().and_then(|e| routhian(e, &mut errors));
        let reduced = reduced.and_then(|model| equations(model, &mut errors));
        whole.filter(|_| errors.is_empty()).map(|e| (e, reduced)).ok_or_else(|| errors.messages())
    }

    /// What the compiler says about the names of the reference; `expected` are the values there, for momenta.
    fn found(&self, e: &Equations, reduced: Option<&Equations>, expected: &Named, noise: &Noise) -> Named {
        let n = self.system.coordinates;
        let mut names = Vec::new();
        let mut values: Vec<Value> = Vec::new();
        let mut add = |name: &str, all: &[Value]| {
            names.extend((0..all.len()).map(|i| format!("{name}[{i}]")));
            values.extend(all);
        };
        add("L", &[e.lagrangian]);
        add("D", &[e.dissipation]);
        add("h", &[e.jacobi]);
        add("power", &[e.power]);
        add("p", &e.momenta);
        add("bias", &e.bias);
        add("force", &e.force);
        let inertia = (0..n).flat_map(|i| (0..=i).map(move |k| (i, k)));
        add("M", &inertia.map(|(i, k)| entry(&e.inertia, i, k)).collect::<Vec<_>>());
        add("accel", &e.accel);
        add("multiplier", &e.multipliers);
        add("reaction", &e.reactions);
        add("response", &e.response);
        if let Some(velocities) = &e.velocities {
            add("velocity", velocities);
        }
        if let Some(j) = &e.jacobian {
            for (k, column) in j.q.iter().chain(&j.qd).chain([&j.t]).enumerate() {
                add(&format!("jacobian {k}"), column);
            }
        }
        let momenta: Vec<f64> = of(expected, "p").collect();
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
        let noisy = |e: &Equations, values: &[Value], symbol: &dyn Fn(Symbol) -> f64| {
            e.model.graph.evaluate_rounded(values, |s| noise.apply(symbol(s)), |x| noise.apply(x))
        };
        let mut found: Named = names.into_iter().zip(noisy(e, &values, &symbol)).collect();
        if let Some(reduced) = reduced {
            let values = noisy(reduced, &reduced.accel, &|s| match s {
                Symbol::Coordinate(i) => symbol(Symbol::Coordinate(kept[i])),
                Symbol::Velocity(i) => symbol(Symbol::Velocity(kept[i])),
                other => symbol(other),
            });
            found.extend(kept.iter().zip(values).map(|(i, x)| (format!("reduced[{i}]"), x)));
        }
        found
    }

    /// What should be, by dual numbers.
    fn expected(&self, noise: &Noise) -> Option<(Named, f64)> {
        let reference = Reference { system: &self.system, parameters: &self.parameters, noise };
        let (mut named, condition) = reference.named(&self.state, &self.given)?;
        let velocities = self.state.qd.iter().enumerate().map(|(i, v)| (format!("velocity[{i}]"), *v));
        let kept = of(&named, "accel").enumerate().map(|(i, a)| (format!("reduced[{i}]"), a));
        let more: Named = velocities.chain(kept).collect();
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
            Err(messages) => panic!("refused: {messages:#?}\n{}", text()),
        };
        assert_eq!(reduced.is_some(), self.system.ignorable, "{}", text());
        let runs: Option<Vec<(Named, Named, f64)>> = (0..=RUNS)
            .map(|run| {
                let (expected, condition) = self.expected(&Noise::of_run(run, self.seed))?;
                let noise = Noise::of_run(run, !self.seed);
                let found = self.found(&whole, reduced.as_ref(), &expected, &noise);
                Some((expected, found, condition))
            })
            .collect();
        let runs = runs.unwrap_or_else(|| panic!("singular by nature\n{}", text()));
        let condition = runs[0].2;
        tally.systems += 1;
        for (k, (name, found)) in runs[0].1.iter().enumerate() {
            let place = runs[0].0.iter().position(|(other, _)| other == name);
            let place = place.unwrap_or_else(|| panic!("{name} is not in the reference\n{}", text()));
            let expected = runs[0].0[place].1;
            let moved = |of: &dyn Fn(&(Named, Named, f64)) -> f64| {
                runs.iter().map(|run| (of(run) - of(&runs[0])).abs()).fold(0.0, f64::max) / SIZE
            };
            // How much the result moves for each relative change of its operations.
            let amplified = moved(&|run| run.0[place].1) + moved(&|run| run.1[k].1);
            let tolerance = SAFETY * f64::EPSILON * amplified + f64::MIN_POSITIVE;
            tally.values += 1;
            let known = tolerance <= KNOWN * expected.abs().max(1.0);
            if !known {
                tally.uncertain += 1;
                continue;
            }
            let error = (found - expected).abs();
            assert!(
                error <= tolerance,
                "{name} is {found:e}, should be {expected:e}: off by {error:.1e}, granted {tolerance:.1e} \
                 (condition {condition:.1e})\n{}",
                text()
            );
            tally.note(
                error / (f64::EPSILON * amplified + f64::MIN_POSITIVE),
                error / expected.abs().max(1.0),
                condition,
                self.seed,
                name,
            );
        }
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

    fn merged(self, other: Tally) -> Tally {
        let worse = |a: (f64, String), b: (f64, String)| if a.0 >= b.0 { a } else { b };
        Tally {
            systems: self.systems + other.systems,
            values: self.values + other.values,
            uncertain: self.uncertain + other.uncertain,
            degenerate: self.degenerate + other.degenerate,
            worst: worse(self.worst, other.worst),
            largest: worse(self.largest, other.largest),
        }
    }

    fn report(&self) {
        let Tally { systems, values, uncertain, degenerate, .. } = self;
        println!(
            "{systems} systems ({degenerate} more are degenerate), {values} values, {uncertain} too uncertain"
        );
        println!("worst: {:.2} roundings, {}", self.worst.0, self.worst.1);
        println!("largest: {:.1e} relative, {}", self.largest.0, self.largest.1);
        assert!(degenerate * 50 <= *systems, "too many systems are degenerate");
        assert!(self.uncertain * 50 <= self.values, "generated systems are too ill-conditioned to say much");
    }
}

fn variable(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().expect("a number"))
}

/// Checks these systems on all processors.
fn check(seeds: std::ops::Range<u64>) {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = &|first: usize| {
        let mut tally = Tally::default();
        seeds.clone().skip(first).step_by(threads).for_each(|seed| Case::new(seed).check(&mut tally));
        tally
    };
    let tallies: Vec<Tally> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|first| scope.spawn(move || share(first))).collect();
        running.into_iter().map(|thread| thread.join().expect("the share of a thread")).collect()
    });
    tallies.into_iter().reduce(Tally::merged).unwrap_or_default().report();
}

#[test]
fn random_systems() {
    match variable("LAGRANGE_SEED") {
        Some(seed) => {
            println!("{}", Case::new(seed).text());
            check(seed..seed + 1);
        }
        None => check(0..FEW),
    }
}

#[test]
#[ignore = "minutes"]
fn many_random_systems() {
    let first = variable("LAGRANGE_SEED").unwrap_or(FEW);
    check(first..first + variable("LAGRANGE_SYSTEMS").unwrap_or(100_000));
}

/// Writes a crate of random systems, in which the comparison of `tests/interpreter.rs` is made of each.
#[test]
#[ignore = "minutes: hundreds of systems are compiled"]
fn random_systems_through_rustc() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let folder = std::env::temp_dir().join(format!("lagrange-random-systems-{}", std::process::id()));
    let harness = std::fs::read_to_string(root.join("tests/interpreter.rs")).expect("the comparison");
    let (harness, _) = harness.split_once("macro_rules! systems").expect("the comparison before its systems");
    let mut tests = harness.to_string();
    let first = variable("LAGRANGE_SEED").unwrap_or(0);
    let mut written = 0;
    for seed in first..first + variable("LAGRANGE_SYSTEMS").unwrap_or(200) {
        let case = Case::new(seed);
        if case.compiled().is_err() {
            continue;
        }
        let energies = match case.system.whole {
            true => "unreachable!()",
            false => "[system.kinetic(q, qd, t), system.potential(q, t)]",
        };
        tests += &format!(
            "#[allow(unused_variables, dead_code)]\nmod random_{seed} {{\n    use super::*;\n    interpreted! {{ {} }}\n    \
             #[test]\n    fn agrees() {{\n        compare(Random::interpreted(), |system: &Random, q, qd, t| {energies});\n    }}\n}}\n",
            case.text()
        );
        written += 1;
    }
    let manifest = format!(
        "[package]\nname = \"random-systems\"\nedition = \"2024\"\n\n[dependencies]\n\
         lagrange-runtime = {{ path = {:?} }}\nnalgebra = {{ version = \"0.35\", default-features = false }}\n\n[workspace]\n",
        root.join("lagrange-runtime")
    );
    std::fs::create_dir_all(folder.join("tests")).expect("a folder for them");
    std::fs::create_dir_all(folder.join("src")).expect("a folder for them");
    std::fs::write(folder.join("src/lib.rs"), "").expect("written");
    std::fs::write(folder.join("Cargo.toml"), manifest).expect("written");
    std::fs::write(folder.join("tests/random.rs"), tests).expect("written");
    // The versions that the workspace was tested with.
    std::fs::copy(root.join("Cargo.lock"), folder.join("Cargo.lock")).expect("copied");
    let cargo = std::env::var("CARGO").unwrap_or("cargo".into());
    let status =
        std::process::Command::new(cargo).arg("test").current_dir(&folder).status().expect("cargo runs");
    assert!(status.success(), "the systems are in {}", folder.display());
    std::fs::remove_dir_all(&folder).expect("removed");
    println!("{written} systems through rustc");
}
