//! Every method of the library, and which of them fit a system: the compiler decides.

use crate::methods::{Family, Sweep};
use crate::problems::Problem;
use lagrange_runtime::method::explicit_rk::{Euler, Heun, Tsitouras5};
use lagrange_runtime::method::rosenbrock::Rodas4;
use lagrange_runtime::method::splitting::PositionVerlet;
use lagrange_runtime::method::variational::VariationalTrapezoid;
use lagrange_runtime::prelude::*;
use lagrange_runtime::testing::reference::SeriesMotion;
use lagrange_runtime::traits::{Analytic, Autonomous, Conservative, LegendreTransform, Linear, Separable};
use lagrange_runtime::{
    BlanesMoan4, BlanesMoan6, DoubleDouble, KahanLi8, Nystrom12,
    method::compose::{HairerLubichWanner10, KahanLi6, Suzuki4, SuzukiUmeno8, TripleJump, Yoshida6},
    method::nystrom::{Nystrom6, Nystrom8},
};
use std::error::Error;

/// The largest [`Problem::error`] of an end against that by Taylor series in double-double: both are rounded.
const ROUNDING: f64 = f64::EPSILON;

impl<Sys, const N: usize> Problem<Sys, N> {
    /// The problem, if Taylor series lead to its end as well: those of the same system over double-double.
    pub fn checked(self, precise: impl Analytic<N, Scalar = DoubleDouble>) -> Result<Self, Box<dyn Error>> {
        let apart = self.error(&SeriesMotion::new(precise, self.start).state(self.end.t)?);
        let Problem { name, reference, .. } = &self;
        if apart <= ROUNDING {
            Ok(self)
        } else {
            Err(format!("{name}: {reference}, and Taylor series in double-double, are {apart:e} apart")
                .into())
        }
    }
}

impl<Sys: LegendreTransform<N, Scalar = f64> + Analytic<N> + Clone, const N: usize> Problem<Sys, N> {
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

impl<Sys: LegendreTransform<N, Scalar = f64> + Separable<N> + Clone, const N: usize> Problem<Sys, N> {
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

impl<Sys: LegendreTransform<N, Scalar = f64> + Conservative<N> + Clone, const N: usize> Problem<Sys, N> {
    /// The methods that keep the energy by force.
    pub fn conservative(&self) -> Vec<Sweep<'_, N>> {
        vec![
            self.tolerances(Family::Explicit, "projected DP 5(4)", Projection(DormandPrince5)),
            self.tolerances(Family::Explicit, "projected DOP853", Projection(Dop853)),
        ]
    }
}

impl<Sys: LegendreTransform<N, Scalar = f64> + Linear<N> + Autonomous<N> + Clone, const N: usize>
    Problem<Sys, N>
{
    /// The exact solution of equations of motion that are linear with constant coefficients.
    pub fn linear(&self) -> Vec<Sweep<'_, N>> {
        vec![self.steps(Family::Stiff, "modal", MatrixExponential)]
    }
}

/// Methods of systems without a mark: an inherent method precedes that of a trait, but only if its bounds hold.
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
