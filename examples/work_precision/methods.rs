//! Every method of the library, and which of them fit a system: the compiler decides.

use crate::problems::Problem;
use lagrange_runtime::prelude::*;
use lagrange_runtime::{
    BlanesMoan4, BlanesMoan6, Controller, ErrorEstimate, Failed, HairerLubichWanner10, KahanLi6, KahanLi8,
    Nystrom6, Nystrom8, Nystrom12, Statistics, Suzuki4, SuzukiUmeno8, TripleJump, Yoshida6,
};

/// Where a run is and what it cost so far.
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

/// What makes a method more accurate and more expensive.
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

impl<Sys: Legendre<N, Scalar = f64> + Analytic<N> + Clone, const N: usize> Problem<Sys, N> {
    /// The methods for every Lagrangian that is quadratic in the velocities.
    pub fn general(&self) -> Vec<Sweep<'_, N>> {
        use Family::{Explicit, Implicit, Stiff};
        vec![
            self.steps(Explicit, "Euler", Euler),
            self.steps(Explicit, "Heun", Heun),
            self.steps(Explicit, "RK4", Rk4),
            self.tolerances(Explicit, "Tsitouras 5(4)", Tsitouras5),
            self.tolerances(Explicit, "Dormand–Prince 5(4)", DormandPrince5),
            self.tolerances(Explicit, "DOP853", Dop853),
            self.tolerances(Explicit, "Verner 9(8)", Verner9),
            self.series(),
            self.steps(Implicit, "implicit midpoint", ImplicitMidpoint),
            self.steps(Implicit, "Gauss 4", Gauss4),
            self.steps(Implicit, "Gauss 6", Gauss6),
            self.steps(Implicit, "variational midpoint", VariationalMidpoint),
            self.steps(Implicit, "variational trapezoid", VariationalTrapezoid),
            self.steps(Implicit, "midpoint, Suzuki 4", Compose(VariationalMidpoint, Suzuki4)),
            self.steps(Implicit, "midpoint, Kahan–Li 6", Compose(VariationalMidpoint, KahanLi6)),
            self.steps(Implicit, "midpoint, Kahan–Li 8", Compose(VariationalMidpoint, KahanLi8)),
            self.steps(Implicit, "trapezoid, Kahan–Li 8", Compose(VariationalTrapezoid, KahanLi8)),
            self.tolerances(Stiff, "Rodas4", Rodas4),
            self.tolerances(Stiff, "Rodas5P", Rodas5P),
            self.tolerances(Stiff, "Radau IIA 5", Radau5),
        ]
    }
}

impl<Sys: Legendre<N, Scalar = f64> + Separable<N> + Clone, const N: usize> Problem<Sys, N> {
    /// The methods for `T(q̇) + V(q, t)`.
    pub fn separable(&self) -> Vec<Sweep<'_, N>> {
        use Family::{Nystrom, Splitting};
        vec![
            self.tolerances(Nystrom, "Nyström 6", Nystrom6),
            self.tolerances(Nystrom, "Nyström 8", Nystrom8),
            self.tolerances(Nystrom, "Nyström 12", Nystrom12),
            self.steps(Splitting, "velocity Verlet", Verlet),
            self.steps(Splitting, "position Verlet", PositionVerlet),
            self.steps(Splitting, "Blanes–Moan 4", BlanesMoan4),
            self.steps(Splitting, "Blanes–Moan 6", BlanesMoan6),
            self.steps(Splitting, "triple jump 4", Compose(Verlet, TripleJump)),
            self.steps(Splitting, "Suzuki 4", Compose(Verlet, Suzuki4)),
            self.steps(Splitting, "Yoshida 6", Compose(Verlet, Yoshida6)),
            self.steps(Splitting, "Kahan–Li 6", Compose(Verlet, KahanLi6)),
            self.steps(Splitting, "Kahan–Li 8", Compose(Verlet, KahanLi8)),
            self.steps(Splitting, "Suzuki–Umeno 8", Compose(Verlet, SuzukiUmeno8)),
            self.steps(Splitting, "Hairer et al. 10", Compose(Verlet, HairerLubichWanner10)),
        ]
    }
}

impl<Sys: Legendre<N, Scalar = f64> + Conservative<N> + Clone, const N: usize> Problem<Sys, N> {
    /// The methods that keep the energy by force.
    pub fn conservative(&self) -> Vec<Sweep<'_, N>> {
        vec![
            self.tolerances(Family::Explicit, "projected DP 5(4)", Projection(DormandPrince5)),
            self.tolerances(Family::Explicit, "projected DOP853", Projection(Dop853)),
        ]
    }
}

impl<Sys: Legendre<N, Scalar = f64> + Linear<N> + Clone, const N: usize> Problem<Sys, N> {
    /// The exact solution of equations of motion that are linear with constant coefficients.
    pub fn linear(&self) -> Vec<Sweep<'_, N>> {
        vec![self.steps(Family::Stiff, "modal", Modal)]
    }
}

/// What the compiler takes where a system lacks a mark: an inherent method goes before that of a trait, but only if its
/// bounds hold.
pub trait Unmarked<const N: usize> {
    fn separable(&self) -> Vec<Sweep<'_, N>> {
        Vec::new()
    }
    fn conservative(&self) -> Vec<Sweep<'_, N>> {
        Vec::new()
    }
    fn linear(&self) -> Vec<Sweep<'_, N>> {
        Vec::new()
    }
}

impl<Sys, const N: usize> Unmarked<N> for Problem<Sys, N> {}

/// Every method that fits. A macro, since the choice is made where the system is known by name.
macro_rules! every_method {
    ($problem:expr) => {{
        #[allow(unused_imports)]
        use $crate::methods::Unmarked as _;
        let groups = [$problem.general(), $problem.separable(), $problem.conservative(), $problem.linear()];
        groups.into_iter().flatten().collect::<Vec<_>>()
    }};
}
pub(crate) use every_method;

impl<Sys: System<N, Scalar = f64> + Clone, const N: usize> Problem<Sys, N> {
    /// Steps from an eighth of the time down, each fivefold more accurate than the one before, or at least half as long.
    fn steps<'a, M: Method<Sys, N> + Copy + 'a>(
        &'a self,
        family: Family,
        name: &'static str,
        method: M,
    ) -> Sweep<'a, N> {
        let finer = 5_f64.powf(1.0 / f64::from(method.order())).clamp(1.1, 2.0);
        let numbers = (0..).map(|k| (8.0 * finer.powi(k)).round()).take_while(|&n| n < 1e7);
        let time = self.end.t - self.start.t;
        let values = numbers.map(|n| time / n).collect();
        self.sweep(family, name, move |_| method, (Parameter::Step, values), Fixed::new)
    }

    /// Tolerances from 1 to 1e-15.
    fn tolerances<'a, M>(&'a self, family: Family, name: &'static str, method: M) -> Sweep<'a, N>
    where
        M: Method<Sys, N, Error: ErrorEstimate<f64, N>> + Copy + 'a,
    {
        let values = (0..=15).map(|k| 10_f64.powi(-k)).collect();
        self.sweep(family, name, move |_| method, (Parameter::Tolerance, values), Pi::tolerance)
    }

    /// Taylor series of the order that belongs to each tolerance.
    fn series(&self) -> Sweep<'_, N>
    where
        Sys: Analytic<N>,
    {
        let values = (0..=15).map(|k| 10_f64.powi(-k)).chain([f64::EPSILON]).collect();
        let parameter = (Parameter::Tolerance, values);
        self.sweep(Family::Taylor, "Taylor", Taylor::for_tolerance, parameter, Decay::tolerance)
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
                let outcome = run.run_out().map(|()| (*run.state(), run.statistics()));
                paused = run;
                outcome
            })
        };
        Sweep { method, family, parameter, values, start: Box::new(start) }
    }
}
