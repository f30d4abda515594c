//! The dozen methods that one would choose among, of every family, and which of them fit a system: the compiler
//! decides.

use crate::methods::{Family, Sweep};
use crate::problems::Problem;
use lagrange_runtime::method::explicit_rk::Tsitouras5;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::{Analytic, LegendreTransform, Separable};
use lagrange_runtime::{BlanesMoan6, Nystrom12, method::compose::Yoshida6};

impl<Sys: LegendreTransform<N, Scalar = f64> + Analytic<N> + Clone, const N: usize> Problem<Sys, N> {
    /// The methods for every Lagrangian that is quadratic in the velocities.
    pub fn general(&self) -> Vec<Sweep<'_, N>> {
        use Family::{Explicit, Implicit, Stiff};
        vec![
            self.steps(Explicit, "RK4", Rk4),
            self.tolerances(Explicit, "Tsitouras 5(4)", Tsitouras5),
            self.tolerances(Explicit, "DOP853", Dop853),
            self.tolerances(Explicit, "Verner 9(8)", Verner9),
            self.series(),
            self.steps(Implicit, "Gauss 6", Gauss6),
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
            self.tolerances(Nystrom, "Nyström 12", Nystrom12),
            self.steps(Splitting, "velocity Verlet", Verlet),
            self.steps(Splitting, "Yoshida 6", Compose(Verlet, Yoshida6)),
            self.steps(Splitting, "Blanes–Moan 6", BlanesMoan6),
        ]
    }
}

/// Methods of systems without a mark: an inherent method precedes that of a trait, but only if its bounds hold.
pub trait Unmarked<const N: usize> {
    fn separable(&self) -> Vec<Sweep<'_, N>> {
        Vec::new()
    }
}

impl<Sys, const N: usize> Unmarked<N> for Problem<Sys, N> {}
