//! Motions from a start to an end that is known to the last digit.

use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Conservative;

/// Definition of [`Problem::error`], for the axes of charts.
pub const ERROR: &str = "error: largest |Δq|/max|q|, |Δq̇|/max|q̇|";

/// A motion with a known end.
pub struct Problem<Sys, const N: usize> {
    pub name: &'static str,
    /// Name of its files, and on the command line.
    pub stem: &'static str,
    /// In words.
    pub motion: String,
    pub system: Sys,
    pub start: State<f64, N>,
    /// The exact state at the end, rounded.
    pub end: State<f64, N>,
    /// Source of `end`.
    pub reference: &'static str,
    /// For long runs, if there is something to keep.
    pub long: Option<Long<Sys, N>>,
    /// The largest |qₖ| and |q̇ₖ| along the motion: units for the error. A few digits of them are enough.
    size: State<f64, N>,
}

/// A motion to be followed for many periods, with what it keeps.
pub struct Long<Sys, const N: usize> {
    /// The time that is called one period.
    pub period: f64,
    /// Name of that time.
    pub clock: &'static str,
    /// The evaluations of the right-hand side that each method may have in a period.
    pub evaluations: f64,
    /// Decades of periods, unless more are asked for.
    pub decades: u32,
    pub invariants: Vec<Invariant<Sys, N>>,
}

/// A function of the state that the motion keeps.
pub struct Invariant<Sys, const N: usize> {
    pub name: String,
    /// Part of a file name.
    pub stem: String,
    pub value: Value<Sys, N>,
}

/// A function of the state.
pub type Value<Sys, const N: usize> = Box<dyn Fn(&Sys, &State<f64, N>) -> f64>;

impl<Sys: System<N, Scalar = f64>, const N: usize> Problem<Sys, N> {
    /// A motion from its start to its exact end, which is known by what `reference` says.
    pub fn new(
        name: &'static str,
        stem: &'static str,
        motion: String,
        system: Sys,
        [start, end]: [State<f64, N>; 2],
        reference: &'static str,
    ) -> Self {
        let mut size = State { t: 0.0, q: start.q.abs(), qd: start.qd.abs() };
        for step in integrate(&system, Dop853, PiController::tolerance(1e-6), start).until(end.t).flatten() {
            size.q = size.q.sup(&step.to.q.abs());
            size.qd = size.qd.sup(&step.to.qd.abs());
        }
        Problem { name, stem, motion, system, start, end, reference, long: None, size }
    }
}

impl<Sys: Conservative<N, Scalar = f64>, const N: usize> Problem<Sys, N> {
    /// With long runs, in which energy and the momenta of ignorable coordinates are watched.
    pub fn long(mut self, clock: &'static str, period: f64, evaluations: f64, decades: u32) -> Self {
        let energy: Value<Sys, N> = Box::new(|system, at| system.energy_function_at(at));
        let energy = Invariant { name: "energy".into(), stem: "energy".into(), value: energy };
        let momenta = Sys::FACTS.ignorable.iter().map(|&k| {
            let coordinate = Sys::FACTS.coordinates[k];
            let value: Value<Sys, N> = Box::new(move |system, at| system.momenta_at(at)[k]);
            Invariant { name: format!("momentum p_{coordinate}"), stem: format!("p-{coordinate}"), value }
        });
        let invariants = std::iter::once(energy).chain(momenta).collect();
        self.long = Some(Long { period, clock, evaluations, decades, invariants });
        self
    }
}

impl<Sys, const N: usize> Problem<Sys, N> {
    /// Error of a final state: the largest difference in any coordinate or velocity, each in units of its largest
    /// magnitude along the motion.
    pub fn error(&self, end: &State<f64, N>) -> f64 {
        let off = end.minus(&self.end);
        off.q.component_div(&self.size.q).amax().max(off.qd.component_div(&self.size.qd).amax())
    }
}
