//! Which methods fit a system, and with which steps or tolerances each is tried.

use crate::problems::Problem;
use lagrange_runtime::prelude::*;
use lagrange_runtime::{Controller, ErrorEstimate, Failed, Separable, Statistics};

/// Where a run ended and what it cost.
pub type Outcome<const N: usize> = Result<(State<f64, N>, Statistics), Failed<f64, N>>;

/// One method over a range of its parameter, from coarse to fine.
pub struct Sweep<'a, const N: usize> {
    pub method: &'static str,
    /// What the parameter is: `h` or `tolerance`.
    pub parameter: &'static str,
    pub values: Vec<f64>,
    pub run: Box<dyn Fn(f64) -> Outcome<N> + 'a>,
}

impl<Sys: Legendre<N, Scalar = f64>, const N: usize> Problem<Sys, N> {
    /// The methods for every Lagrangian that is quadratic in the velocities.
    pub fn general(&self) -> Vec<Sweep<'_, N>> {
        vec![
            self.steps("Euler", Euler),
            self.steps("RK4", Rk4),
            self.tolerances("Dormand–Prince 5(4)", DormandPrince5),
            self.tolerances("DOP853", Dop853),
            self.steps("implicit midpoint", ImplicitMidpoint),
            self.steps("Gauss 4", Gauss4),
            self.steps("Gauss 6", Gauss6),
        ]
    }

    /// Steps from a sixteenth of the time down, each tenfold more accurate than the one before, or at least half as
    /// long.
    fn steps<'a, M: Method<Sys, N> + Copy + 'a>(&'a self, name: &'static str, method: M) -> Sweep<'a, N> {
        let finer = 10_f64.powf(1.0 / f64::from(method.order())).min(2.0);
        let numbers = (0..).map(|k| (16.0 * finer.powi(k)).round()).take_while(|&n| n < 1e7);
        let time = self.end.t - self.start.t;
        self.sweep(name, method, "h", Fixed::new, numbers.map(|n| time / n).collect())
    }

    /// Tolerances from 1 to 1e-15.
    fn tolerances<'a, M>(&'a self, name: &'static str, method: M) -> Sweep<'a, N>
    where
        M: Method<Sys, N, Error: ErrorEstimate<f64, N>> + Copy + 'a,
    {
        self.sweep(name, method, "tolerance", Pi::tolerance, (0..=15).map(|k| 10_f64.powi(-k)).collect())
    }

    fn sweep<'a, M, C>(
        &'a self,
        name: &'static str,
        method: M,
        parameter: &'static str,
        controller: fn(f64) -> C,
        values: Vec<f64>,
    ) -> Sweep<'a, N>
    where
        M: Method<Sys, N> + Copy + 'a,
        C: Controller<f64, N, M::Error> + 'a,
    {
        let run = move |value| {
            let mut run = integrate(&self.system, method, controller(value), self.start).until(self.end.t);
            run.run_out()?;
            Ok((*run.state(), run.statistics()))
        };
        Sweep { method: name, parameter, values, run: Box::new(run) }
    }
}

impl<Sys: Legendre<N, Scalar = f64> + Separable<N>, const N: usize> Problem<Sys, N> {
    /// The methods for `T(q̇) + V(q)`. Of a system without the mark, this is a compile error.
    pub fn splitting(&self) -> Vec<Sweep<'_, N>> {
        vec![
            self.steps("Störmer–Verlet (kick)", Verlet),
            self.steps("Störmer–Verlet (position)", PositionVerlet),
        ]
    }
}
