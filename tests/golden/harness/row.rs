//! One row of the catalogue: a system with everything that was found about it, as values. Tests assert on them, the
//! example `chapter11` prints them.

use super::compare::{check, check_equal};
use super::formula::check_formulas;
use super::reference::Fields;
use super::small::{check_small, lowest_frequency};
use super::subject::{Golden, Quantity};
use super::trajectory::{Flight, Measured, check_trajectory, end};
use super::{BALANCE, State, Subject, TOLERANCE, random_states};
use lagrange_runtime::Facts;
use nalgebra::DVector;
use std::ops::Range;

/// Subject of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Reference digits at a state.
    Digits,
    /// Reference digits of a motion.
    Motion,
    /// An equation or an integral that the source prints, or that was derived by hand.
    Equation,
    /// A result of this system alone.
    Special,
    /// A quantity that a motion conserves.
    Conserved,
    /// A statement that holds for every Lagrangian.
    Identity,
}

/// A comparison: what, how far off, and how far it may be off.
#[derive(Clone, Debug)]
pub struct Finding {
    pub kind: Kind,
    pub what: String,
    pub error: f64,
    pub allowed: f64,
    /// Size to which the error is relative: that of the terms that make up the number.
    pub size: f64,
}

impl Finding {
    /// Some numbers against what they should be.
    pub fn compare(kind: Kind, what: impl Into<String>, got: &[f64], expected: &[f64], allowed: f64) -> Self {
        let what = what.into();
        assert_eq!(got.len(), expected.len(), "{what}: number of entries");
        let errors: Vec<f64> = got.iter().zip(expected).map(|(got, expected)| got - expected).collect();
        // The largest of numbers of which one is NaN is NaN.
        let error = errors.iter().fold(0.0, |largest: f64, error| {
            if largest.is_nan() || error.abs() <= largest { largest } else { error.abs() }
        });
        Finding { kind, what, error, allowed, size: allowed / TOLERANCE }
    }

    /// A residue that should be 0, as a difference of terms of some size.
    pub fn residue(kind: Kind, what: impl Into<String>, residue: f64, size: f64, allowed: f64) -> Self {
        Finding { kind, what: what.into(), error: residue.abs(), allowed, size }
    }

    /// A statement that is either true or not.
    pub fn holds(what: impl Into<String>, holds: bool) -> Self {
        let error = if holds { 0.0 } else { f64::INFINITY };
        Finding { kind: Kind::Identity, what: what.into(), error, allowed: 0.0, size: 1.0 }
    }

    /// A comparison that could not be made.
    pub fn failed(what: impl Into<String>, reason: &str) -> Self {
        Finding::holds(format!("{}: {reason}", what.into()), false)
    }

    pub fn ok(&self) -> bool {
        self.error <= self.allowed
    }

    /// The error as a part of what is allowed.
    pub fn share(&self) -> f64 {
        if self.error == 0.0 { 0.0 } else { self.error / self.allowed }
    }

    /// The error in proportion to the terms.
    pub fn relative(&self) -> f64 {
        if self.error == 0.0 { 0.0 } else { self.error / self.size }
    }
}

/// A result of one system alone: its name, what was found, and what it should be.
#[derive(Clone, Debug)]
pub struct Special {
    pub name: String,
    pub value: f64,
    pub reference: f64,
}

/// One row of the catalogue.
pub struct Row {
    /// The catalogue's name of it, which is also that of its file of digits.
    pub id: &'static str,
    /// Facts that the compiler found; none where the row is a statement and not a system.
    pub facts: Option<Facts>,
    /// All comparisons that were made.
    pub findings: Vec<Finding>,
    /// The result that is shown.
    pub special: Option<Special>,
    subject: Option<Subject>,
    /// States at which equations are tried, and writings compared.
    states: Vec<State>,
}

impl Row {
    /// A system against all that its file says. The coordinates of random states are taken from the given ranges.
    pub fn of<G: Golden<N>, const N: usize>(facts: &str, ranges: [Range<f64>; N]) -> Self {
        Self::at(Subject::of::<G, N>(), facts, random_states(&ranges))
    }

    /// A system with constraints, whose coordinates cannot be chosen at random: at the states of its file.
    pub fn constrained<G: Golden<N>, const N: usize>(facts: &str) -> Self {
        let subject = Subject::of::<G, N>();
        let states = subject.reference.states.iter().map(Fields::state).collect();
        Self::at(subject, facts, states)
    }

    fn at(subject: Subject, facts: &str, states: Vec<State>) -> Self {
        let shown = |(name, value, reference)| Special { name, value, reference };
        let special = lowest_frequency(&subject).or_else(|| end(&subject)).map(shown);
        let mut findings = all(&subject, &states);
        findings.push(compare_facts(&subject, facts));
        let id = subject.id;
        Row { id, facts: Some(subject.facts), findings, special, subject: Some(subject), states }
    }

    /// A statement about a system that has a row of its own.
    pub fn about<G: Golden<N>, const N: usize>(id: &'static str) -> Self {
        Row { subject: Some(Subject::of::<G, N>()), ..Row::statement(id) }
    }

    /// A statement that is not about one system.
    pub fn statement(id: &'static str) -> Self {
        Row { id, facts: None, findings: Vec::new(), special: None, subject: None, states: Vec::new() }
    }

    /// The same system in another writing: against the same file, and against the first writing at random states.
    #[must_use]
    pub fn also<G: Golden<N>, const N: usize>(mut self, facts: &str) -> Self {
        let other = Subject::of::<G, N>();
        self.findings.push(compare_facts(&other, facts));
        self.findings.extend(check_equal(self.subject(), &other, &self.states));
        if G::REFERENCE == self.id {
            self.findings.extend(all(&other, &self.states));
        }
        self
    }

    /// The system of this row.
    pub fn subject(&self) -> &Subject {
        self.subject.as_ref().unwrap_or_else(|| panic!("{}: a statement has no system", self.id))
    }

    /// With one more finding.
    #[must_use]
    pub fn finding(mut self, finding: Finding) -> Self {
        self.findings.push(finding);
        self
    }

    /// With more findings.
    #[must_use]
    pub fn findings(mut self, findings: impl IntoIterator<Item = Finding>) -> Self {
        self.findings.extend(findings);
        self
    }

    /// Something is so.
    #[must_use]
    pub fn holds(self, what: &str, holds: bool) -> Self {
        self.finding(Finding::holds(what, holds))
    }

    /// Terms whose sum is 0, such as an equation of motion.
    #[must_use]
    pub fn balance(self, what: &str, terms: &[f64]) -> Self {
        let size: f64 = terms.iter().map(|term| term.abs()).sum();
        self.finding(Finding::residue(Kind::Equation, what, terms.iter().sum(), size, BALANCE * size))
    }

    /// Such terms at each of the random states.
    #[must_use]
    pub fn balances(mut self, what: &str, terms: impl Fn(&State) -> Vec<f64>) -> Self {
        for state in self.states.clone() {
            self = self.balance(what, &terms(&state));
        }
        self
    }

    /// A number in closed form.
    #[must_use]
    pub fn number(self, what: &str, got: f64, expected: f64) -> Self {
        self.within(what, got, expected, BALANCE * (got.abs() + expected.abs()))
    }

    /// A number, with the error that is allowed.
    #[must_use]
    pub fn within(self, what: &str, got: f64, expected: f64, allowed: f64) -> Self {
        self.finding(Finding::compare(Kind::Special, what, &[got], &[expected], allowed))
    }

    /// A number in closed form, which is shown.
    #[must_use]
    pub fn special(self, name: &str, got: f64, expected: f64) -> Self {
        self.number(name, got, expected).show(name, got, expected)
    }

    /// Shows a result.
    #[must_use]
    pub fn show(mut self, name: &str, value: f64, reference: f64) -> Self {
        self.special = Some(Special { name: name.to_owned(), value, reference });
        self
    }

    /// From a start at t = 0 some coordinates and velocities `x = [q, q̇]` are reached at a time; the first is what is
    /// shown.
    #[must_use]
    pub fn motion(self, what: &str, start: (&[f64], &[f64]), time: f64, expected: &[(usize, f64)]) -> Self {
        self.motion_with(&[], what, start, time, expected)
    }

    /// The same with other values of some parameters.
    #[must_use]
    pub fn motion_with(
        mut self,
        parameters: &[(&str, f64)],
        what: &str,
        start: (&[f64], &[f64]),
        time: f64,
        expected: &[(usize, f64)],
    ) -> Self {
        let subject = self.subject().clone().with(parameters);
        match reach(&subject, start, time) {
            Err(reason) => self.finding(Finding::failed(what, &reason)),
            Ok((reached, rates)) => {
                for &(k, expected) in expected {
                    // What is expected is rounded, and so is the time at which it is.
                    let rounding = f64::EPSILON * (expected.abs() + rates[k].abs() * time);
                    let place = format!("{what}, x[{k}]");
                    self = self.within(&place, reached[k].value, expected, reached[k].allowed + rounding);
                }
                let shown = expected.first().map(|&(k, expected)| (reached[k].value, expected));
                shown.into_iter().fold(self, |row, (found, expected)| row.show(what, found, expected))
            }
        }
    }

    /// From a start at t = 0 the coordinate or velocity `x[k]` passes a value at a time; a multiple of that time is
    /// what is shown.
    #[must_use]
    pub fn passage(
        self,
        what: &str,
        start: (&[f64], &[f64]),
        time: f64,
        (k, value): (usize, f64),
        multiple: f64,
    ) -> Self {
        match reach(self.subject(), start, time) {
            Err(reason) => self.finding(Finding::failed(what, &reason)),
            Ok((reached, rates)) => {
                let found = multiple * (time - (reached[k].value - value) / rates[k]);
                let allowed = multiple * (reached[k].allowed / rates[k]).abs();
                let expected = multiple * time;
                self.within(what, found, expected, allowed + 2.0 * f64::EPSILON * expected)
                    .show(what, found, expected)
            }
        }
    }

    /// Released at rest, coordinate `k` passes 0 after a quarter of the period.
    #[must_use]
    pub fn period(self, what: &str, q: &[f64], k: usize, period: f64) -> Self {
        self.passage(what, (q, &vec![0.0; q.len()]), 0.25 * period, (k, 0.0), 4.0)
    }

    /// The force on coordinate `k` of a relaxed system that keeps it as a constraint of this system does.
    #[must_use]
    pub fn reaction(
        self,
        what: &str,
        relaxed: &Subject,
        at: (&State, &[f64]),
        k: usize,
        expected: f64,
    ) -> Self {
        self.reaction_of_terms(what, relaxed, at, k, expected, expected.abs())
    }

    /// The same where the terms that make it up cancel within one emitted expression, which does not show their size.
    pub fn reaction_of_terms(
        self,
        what: &str,
        relaxed: &Subject,
        (state, accelerations): (&State, &[f64]),
        k: usize,
        expected: f64,
        size: f64,
    ) -> Self {
        let (force, allowed) = required(relaxed, state, accelerations)[k];
        self.within(what, force, expected, allowed + BALANCE * size)
    }

    /// Returns whether every comparison is within its bound.
    pub fn ok(&self) -> bool {
        self.findings.iter().all(Finding::ok)
    }

    /// The largest relative error among the findings of some kinds; none if there is no such finding.
    pub fn error(&self, kinds: &[Kind]) -> Option<f64> {
        let errors =
            self.findings.iter().filter(|finding| kinds.contains(&finding.kind)).map(Finding::relative);
        errors.max_by(f64::total_cmp)
    }

    /// The largest error as a part of what is allowed.
    pub fn share(&self) -> f64 {
        self.findings.iter().map(Finding::share).max_by(f64::total_cmp).unwrap_or(0.0)
    }
}

/// State at a time of a motion from `q, q̇` at t = 0: `x = [q, q̇]` and ẋ.
fn reach(
    subject: &Subject,
    (q, qd): (&[f64], &[f64]),
    time: f64,
) -> Result<(Vec<Measured>, Vec<f64>), String> {
    let flight = Flight::new(subject, &State::new(q, qd, 0.0), &[time])?;
    let reached = flight.at(time)?;
    let x: Vec<f64> = reached.iter().map(|measured| measured.value).collect();
    let (q, qd) = x.split_at(subject.n);
    let accelerations = subject.accelerations(&State::new(q, qd, time));
    let rates = [qd, &accelerations].concat();
    Ok((reached, rates))
}

/// The generalized force besides those of a system that gives it these accelerations at a state; each component with
/// the bound of its error.
pub fn required(subject: &Subject, state: &State, accelerations: &[f64]) -> Vec<(f64, f64)> {
    let point = subject.at("", state);
    let inertia = point.inertia();
    let accelerations = DVector::from_column_slice(accelerations);
    let bias = DVector::from_vec(point.value(Quantity::Bias));
    let force = DVector::from_vec(point.value(Quantity::Force));
    let size = inertia.abs() * accelerations.abs() + bias.abs() + force.abs();
    let required = inertia * accelerations + bias - force;
    required.iter().zip(&size).map(|(&required, size)| (required, BALANCE * size)).collect()
}

/// Everything in the file.
fn all(subject: &Subject, states: &[State]) -> Vec<Finding> {
    [check(subject), check_formulas(subject, states), check_small(subject), check_trajectory(subject)]
        .concat()
}

/// Facts that the compiler found, against those expected: see [`summary`].
fn compare_facts(subject: &Subject, expected: &str) -> Finding {
    let found = summary(&subject.facts);
    Finding::holds(
        format!("{}: facts are {found:?}, not {expected:?}", subject.facts.name),
        found == expected,
    )
}

/// The facts that hold, the constraints with their kinds, the ignorable coordinates, and the groups of coordinates
/// that move independently if there are several: `scleronomic, quadratic, ignorable phi, blocks r phi | z`.
fn summary(facts: &Facts) -> String {
    let names = |indices: &[usize]| {
        let names: Vec<&str> = indices.iter().map(|&k| facts.coordinates[k]).collect();
        names.join(" ")
    };
    let mut found: Vec<String> = [
        ("scleronomic", facts.scleronomic),
        ("conservative", facts.conservative),
        ("separable", facts.separable),
        ("constant inertia", facts.constant_inertia),
        ("quadratic", facts.quadratic),
        ("linear", facts.linear),
    ]
    .iter()
    .filter(|(_, holds)| *holds)
    .map(|(name, _)| (*name).to_owned())
    .collect();
    for constraint in facts.constraints {
        found.push(format!("{} {}", constraint.name, format!("{:?}", constraint.kind).to_lowercase()));
    }
    if !facts.ignorable.is_empty() {
        found.push(format!("ignorable {}", names(facts.ignorable)));
    }
    if facts.blocks.len() > 1 {
        let blocks: Vec<String> = facts.blocks.iter().map(|block| names(block)).collect();
        found.push(format!("blocks {}", blocks.join(" | ")));
    }
    if facts.cascade.len() > facts.blocks.len() {
        let groups: Vec<String> = facts.cascade.iter().map(|group| names(group)).collect();
        found.push(format!("cascade {}", groups.join(" > ")));
    }
    found.join(", ")
}

/// Every comparison of some rows is within its bound.
#[cfg(test)]
pub fn assert_rows(rows: &[Row]) {
    let failures = rows.iter().flat_map(|row| {
        let failed = row.findings.iter().filter(|finding| !finding.ok());
        failed.map(move |f| {
            format!("{}: {}: off by {:.1e}, allowed {:.1e}", row.id, f.what, f.error, f.allowed)
        })
    });
    let failures: Vec<String> = failures.collect();
    assert!(failures.is_empty(), "{} comparisons failed:\n{}", failures.len(), failures.join("\n"));
}
