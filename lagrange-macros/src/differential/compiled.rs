//! Random systems through rustc: what a user gets, against dual numbers of what was written.

use super::{Case, SAFETY, Value, variable};
use crate::equations::Derived;
use crate::table::OUTPUTS;
use crate::through_rustc::Package;
use std::fmt::Write;

/// Systems of one file, and so of one program.
const SYSTEMS_PER_FILE: u64 = 20;

/// `linearization` of `linearization 3[2]`.
fn family(name: &str) -> &str {
    name.split([' ', '[']).next().unwrap_or(name)
}

/// Calls of all functions of a system at a state, whose results are added to `named`.
fn calls(d: &Derived, system: &str, at: &str) -> String {
    let mut calls = String::new();
    for output in OUTPUTS.iter().filter(|output| (output.values)(d).is_some()) {
        let (name, mut given) = (output.name, 0);
        let arguments = output.takes.iter().map(|argument| match argument.name {
            "t" => format!("{at}.t"),
            "p" => format!("&{system}.momenta(&{at}.q, &{at}.qd, {at}.t)"),
            _ if argument.given => {
                let first = given;
                given += argument.shape.len(&|size| d.size(size));
                format!("&SVector::from_fn(|i, _| GIVEN[{first} + i])")
            }
            name => format!("&{at}.{name}"),
        });
        let arguments = arguments.collect::<Vec<_>>().join(", ");
        let _ = writeln!(calls, "add(&mut named, {name:?}, &{system}.{name}({arguments}).flat());");
    }
    if d.equations.series.is_some() {
        let _ = writeln!(calls, "analytic(&mut named, &{system}, &{at});");
    }
    calls
}

impl Case {
    /// A module with a test of this system; none if it is refused.
    fn module(&self) -> Option<String> {
        let (whole, reduced) = self.compiled().ok()?;
        let reduction = reduced.as_ref().and_then(|r| r.model.reduction.as_ref());
        let mut expected = String::new();
        let values = self.values(&whole, reduced.as_ref())?;
        for value in &values {
            // What duals work out at run time sums terms whose rounding the reference alone does not show: of
            // matrices, the largest entry says how large they are.
            let summed = |other: &&Value| value.found.is_none() && family(&other.name) == family(&value.name);
            let largest = values.iter().filter(summed).map(|v| v.expected.abs()).fold(0.0, f64::max);
            let granted = value.granted + SAFETY * f64::EPSILON * largest;
            let granted = if value.known() { format!("{granted:e}") } else { "f64::INFINITY".into() };
            let _ = writeln!(expected, "({:?}, {:e}, {granted}),", value.name, value.expected);
        }
        let mut calls = calls(&whole, "system", "at");
        for (j, place) in self.system.struck.iter().enumerate() {
            let k = place.len();
            calls += &format!(
                "add(&mut named, \"blow {j}\", system.blow{j}(&at.q, at.t, &SVector::<f64, {k}>::from_fn(|i, _| GIVEN[i])).as_slice());\n"
            );
        }
        for j in 0..self.system.observed.len() {
            calls += &format!("add(&mut named, \"seen {j}\", &[system.seen{j}(&at.q, &at.qd, at.t)]);\n");
            let n = self.system.coordinates;
            calls += &format!(
                "let given = SVector::<f64, {n}>::from_fn(|i, _| GIVEN[i]);\n\
                 let mut hit = vec![Random::HIT{j}.value(&system, &at)];\n\
                 hit.extend(CompiledEvents::event_rates(&system, {j}, &at, &given)[0]);\n\
                 add(&mut named, \"hit {j}\", &hit);\n"
            );
        }
        if let (Some(reduction), Some(reduced)) = (reduction, &reduced) {
            calls += &format!(
                "let (less, there) = system.reduce(&at);\nlet of_reduced = {{ let mut named = Named::new();\n{}named }};\n\
                 reduced(&mut named, of_reduced, &{:?});\n",
                self::calls(reduced, "less", "there"),
                reduction.kept
            );
        }
        let seed = self.seed;
        // A potential that jumps gives and takes energy where no force does work.
        if whole.equations.series.as_ref().is_some_and(|series| series.switches.is_empty()) {
            let held = match whole.model.constraints.is_empty() {
                true => "|_| 0.0",
                false => {
                    "|s| system.multipliers(&s.q, &s.qd, s.t).dot(&(system.constraint_jacobian(&s.q, s.t) * s.qd))"
                }
            };
            let start =
                if whole.model.constraints.is_empty() { "Some(at)" } else { "consistent(&system, &at).ok()" };
            calls += &format!(
                "if let Some(start) = {start} {{ balanced({seed}, &system, &system.map(Dual::constant), start, {held}); }}\n"
            );
        }
        let text = self.text();
        let fields: Vec<String> =
            self.parameters.iter().enumerate().map(|(i, x)| format!("p{i}: {x:e}")).collect();
        let (fields, given, state) = (fields.join(", "), &self.given, &self.state);
        let (q, qd, t) = (&state.q, &state.qd, state.t);
        Some(format!(
            "mod random_{seed} {{\n    use super::*;\n    lagrangian! {{ {text} }}\n    #[test]\n    fn agrees() {{\n\
             const GIVEN: [f64; {}] = {given:?};\nlet system: Random = Random {{ {fields} }};\n\
             let at = State::new({t:?}, {q:?}, {qd:?});\n\
             let mut named = Named::new();\n{calls}compare({seed}, &named, &[\n{expected}]);\n    }}\n}}\n",
            given.len()
        ))
    }
}

/// Writes a crate of random systems and tests it.
#[test]
#[ignore = "minutes: hundreds of systems are compiled"]
fn random_systems_through_rustc() {
    let package = Package::new("random-systems", include_str!("harness.rs"));
    let first = variable("LAGRANGE_SEED").unwrap_or(0);
    let mut written = 0;
    let seeds: Vec<u64> = (first..first + variable("LAGRANGE_SYSTEMS").unwrap_or(200)).collect();
    for seeds in seeds.chunks(SYSTEMS_PER_FILE as usize) {
        let modules: Vec<String> = seeds.iter().filter_map(|seed| Case::new(*seed).module()).collect();
        written += modules.len();
        let file = format!(
            "#![allow(unused, clippy::all)]\nuse lagrange_runtime::__private::*;\nuse lagrange_runtime::lagrangian;\nuse lagrange_runtime::prelude::*;\nuse random_systems::*;\n{}",
            modules.concat()
        );
        package.add(&format!("from_{}", seeds[0]), &file);
    }
    package.cargo(&["test", "--no-fail-fast", "--", "--nocapture"]);
    println!("{written} systems through rustc");
}
