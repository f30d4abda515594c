//! Controllers of lanes: norms side by side, decisions lane by lane.

use super::lanewise::Lanewise;
use super::number::{Lane, Lanes};
use super::policy::Policy;
use super::processor::Processor;
use crate::controller::{Controller, ErrorEstimate, Fixed, Itself, Pi, Pid, Verdict};
use crate::state::{State, Tangent};

/// A controller that judges the steps of lanes, each as it would alone, with the same bits. There is one for each lane, all of them
/// made from the same.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not control steps in lanes of a method with the error estimate `{E}`",
    note = "`Fixed` does for all methods, `Pi` and `Pid` do for methods with an error estimate"
)]
pub trait LaneController<const L: usize, P: Policy, A: Processor, E: Lanewise<L>, const N: usize>:
    Clone
{
    /// What controls a lane alone.
    type Alone: Controller<Lane<P, A>, N, E::One>;

    /// What controls a lane alone.
    fn alone(&self) -> Self::Alone;

    /// The squares of the errors of a step from `from` to `to`, each over what is tolerated.
    fn squares(&self, from: &State<Lanes<L, P, A>, N>, to: &State<Lanes<L, P, A>, N>, error: &E) -> [f64; L];

    /// What the controller of one lane makes of its square.
    fn decide(&mut self, square: f64, order: u32) -> Verdict;

    /// What it does after a step that could not be made, as [`Controller::after_failure`].
    fn after_failure(&mut self) -> Option<f64>;
}

impl<const L: usize, P, A, E, const N: usize> LaneController<L, P, A, E, N> for Fixed
where
    P: Policy,
    A: Processor,
    E: Lanewise<L>,
{
    type Alone = Fixed<Lane<P, A>>;

    fn alone(&self) -> Self::Alone {
        Fixed::new(Lane::new(self.size()))
    }

    #[inline(always)]
    fn squares(&self, _: &State<Lanes<L, P, A>, N>, _: &State<Lanes<L, P, A>, N>, _: &E) -> [f64; L] {
        [0.0; L]
    }

    #[inline(always)]
    fn decide(&mut self, _: f64, _: u32) -> Verdict {
        Verdict::Accept { factor: 1.0 }
    }

    fn after_failure(&mut self) -> Option<f64> {
        None
    }
}

macro_rules! adaptive {
    ($($controller:ident)*) => {$(
        impl<const L: usize, P, A, E, const N: usize> LaneController<L, P, A, E, N> for $controller
        where
            P: Policy,
            A: Processor,
            E: Lanewise<L, One: ErrorEstimate<Lane<P, A>, N>> + ErrorEstimate<Lanes<L, P, A>, N>,
        {
            type Alone = $controller;

            fn alone(&self) -> $controller {
                *self
            }

            #[inline(always)]
            fn squares(
                &self,
                from: &State<Lanes<L, P, A>, N>,
                to: &State<Lanes<L, P, A>, N>,
                error: &E,
            ) -> [f64; L] {
                self.tolerances().square::<Itself, _, E, N>(from, to, error).to_array()
            }

            #[inline(always)]
            fn decide(&mut self, square: f64, order: u32) -> Verdict {
                $controller::decide(self, square, order)
            }

            fn after_failure(&mut self) -> Option<f64> {
                Controller::<f64, N, Tangent<f64, N>>::after_failure(self)
            }
        }
    )*};
}

adaptive! { Pi Pid }
