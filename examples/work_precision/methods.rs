//! Methods over ranges of their steps or tolerances.

use crate::problems::Problem;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Analytic;
use lagrange_runtime::{Controller, Statistics, controller::ErrorEstimate, integrate::Failed};

/// State of a run and its cost so far.
pub type Outcome<const N: usize> = Result<(State<f64, N>, Statistics), Failed<f64, N>>;

/// A run that goes on to each time that it is given.
pub type Running<'a, const N: usize> = Box<dyn FnMut(f64) -> Outcome<N> + 'a>;

/// Methods that are shown in one panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Explicit,
    Taylor,
    Nystrom,
    Splitting,
    Implicit,
    Stiff,
}

impl Family {
    /// In the order of the panels.
    pub const ALL: [Family; 6] = [
        Family::Explicit,
        Family::Taylor,
        Family::Nystrom,
        Family::Splitting,
        Family::Implicit,
        Family::Stiff,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Family::Explicit => "Explicit Runge–Kutta",
            Family::Taylor => "Taylor series",
            Family::Nystrom => "Nyström",
            Family::Splitting => "Splittings of T and V",
            Family::Implicit => "Gauss, variational",
            Family::Stiff => "Radau, Rosenbrock, modal",
        }
    }
}

/// Parameter that makes a method more accurate and more expensive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Equal steps of this size.
    Step,
    /// Adaptive steps with this tolerance, absolute and relative.
    Tolerance,
}

impl Parameter {
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Step => "h",
            Parameter::Tolerance => "tolerance",
        }
    }
}

/// One method, to be tried over a range of its parameter.
pub struct Sweep<'a, const N: usize> {
    pub method: &'static str,
    pub family: Family,
    pub parameter: Parameter,
    /// From coarse to fine.
    pub values: Vec<f64>,
    /// A run with a value of the parameter, which fails after so many steps.
    pub start: Box<dyn Fn(f64, u64) -> Running<'a, N> + 'a>,
}

impl<Sys: System<N, Scalar = f64> + Clone, const N: usize> Problem<Sys, N> {
    /// Steps from an eighth of the time down, each fivefold more accurate than the one before, or at least half as
    /// long.
    pub fn steps<'a, M: Method<Sys, N> + Copy + 'a>(
        &'a self,
        family: Family,
        name: &'static str,
        method: M,
    ) -> Sweep<'a, N> {
        let finer = 5_f64.powf(1.0 / f64::from(method.order())).clamp(1.1, 2.0);
        let numbers = (0..).map(|k| (8.0 * finer.powi(k)).round()).take_while(|&n| n < 1e7);
        let time = self.end.t - self.start.t;
        let values = numbers.map(|n| time / n).collect();
        self.sweep(family, name, move |_| method, (Parameter::Step, values), FixedStep::new)
    }

    /// Tolerances from 1 to 1e-15.
    pub fn tolerances<'a, M>(&'a self, family: Family, name: &'static str, method: M) -> Sweep<'a, N>
    where
        M: Method<Sys, N, Error: ErrorEstimate<f64, N>> + Copy + 'a,
    {
        let values = (0..=15).map(|k| 10_f64.powi(-k)).collect();
        self.sweep(family, name, move |_| method, (Parameter::Tolerance, values), PiController::tolerance)
    }

    /// Taylor series of the order that belongs to each tolerance.
    pub fn series(&self) -> Sweep<'_, N>
    where
        Sys: Analytic<N>,
    {
        let values = (0..=15).map(|k| 10_f64.powi(-k)).chain([f64::EPSILON]).collect();
        let parameter = (Parameter::Tolerance, values);
        self.sweep(Family::Taylor, "Taylor", |_| Taylor, parameter, TaylorController::tolerance)
    }

    fn sweep<'a, M, C>(
        &'a self,
        family: Family,
        method: &'static str,
        kind: impl Fn(f64) -> M + 'a,
        (parameter, values): (Parameter, Vec<f64>),
        controller: fn(f64) -> C,
    ) -> Sweep<'a, N>
    where
        M: Method<Sys, N> + Copy + 'a,
        C: Controller<f64, N, M::Error> + 'a,
    {
        let start = move |value, most| -> Running<'a, N> {
            let mut paused =
                integrate(&self.system, kind(value), controller(value), self.start).max_steps(most);
            Box::new(move |end| {
                // A run of its own, so that the loop has it in registers and not behind a reference.
                let mut run = paused.clone().until(end);
                let outcome = run.run_to_end().map(|()| (*run.state(), run.statistics()));
                paused = run;
                outcome
            })
        };
        Sweep { method, family, parameter, values, start: Box::new(start) }
    }
}
