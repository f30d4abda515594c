//! Controllers of lanes: norms side by side, decisions lane by lane.

use super::lanewise::Lanewise;
use super::number::{Lanes, SingleLane};
use super::policy::Policy;
use super::processor::Processor;
use crate::controller::{
    AbsoluteTolerance, Controller, ErrorEstimate, FixedStep, PiController, PidController, Verdict, Verdicts,
};
use crate::method::taylor::{Remainder, TaylorController};
use crate::state::{State, Tangent};

/// A controller that judges the steps of lanes, each as it would alone, with the same bits. There is one for each
/// lane, all of them made from the same.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not control steps in lanes of a method with the error estimate `{E}`",
    note = "`FixedStep` does for all methods, `PiController` and `PidController` do for methods with an error estimate"
)]
pub trait LaneController<const L: usize, P: Policy, A: Processor, E: Lanewise<L>, const N: usize>:
    Clone
{
    /// The controller of a lane alone.
    type Alone: Controller<SingleLane<P, A>, N, E::Element>;

    /// Measure of a step: for most controllers the square of the error over the tolerated one.
    type Measure: Copy;

    /// The controller of a lane alone.
    fn alone(&self) -> Self::Alone;

    /// The measure of a step from `from` to `to`.
    fn measures(
        &self,
        from: &State<Lanes<L, P, A>, N>,
        to: &State<Lanes<L, P, A>, N>,
        error: &E,
    ) -> [Self::Measure; L];

    /// Decisions of the lanes' controllers by their measures. A lane that is not `judged`, since its step could not
    /// be made, learns nothing.
    fn decide(
        lanes: &mut [Self; L],
        measures: &[Self::Measure; L],
        judged: &[bool; L],
        order: u32,
    ) -> Verdicts<L>;

    /// The factor after a step that could not be made, as [`Controller::after_failure`].
    fn after_failure(&mut self) -> Option<f64>;
}

impl<const L: usize, P, A, E, const N: usize> LaneController<L, P, A, E, N> for FixedStep
where
    P: Policy,
    A: Processor,
    E: Lanewise<L>,
{
    type Alone = FixedStep<SingleLane<P, A>>;
    type Measure = ();

    fn alone(&self) -> Self::Alone {
        FixedStep::new(SingleLane::new(self.size()))
    }

    #[inline(always)]
    fn measures(&self, _: &State<Lanes<L, P, A>, N>, _: &State<Lanes<L, P, A>, N>, _: &E) -> [(); L] {
        [(); L]
    }

    #[inline(always)]
    fn decide(_: &mut [Self; L], _: &[(); L], _: &[bool; L], _: u32) -> Verdicts<L> {
        Verdicts { accepted: [true; L], factor: [1.0; L] }
    }

    fn after_failure(&mut self) -> Option<f64> {
        None
    }
}

/// Verdicts on those lanes that are judged, one after the other.
macro_rules! each {
    ($judged:ident, $lane:ident => $verdict:expr) => {{
        let mut verdicts = Verdicts { accepted: [false; L], factor: [1.0; L] };
        for $lane in 0..L {
            if $judged[$lane] {
                (verdicts.accepted[$lane], verdicts.factor[$lane]) = match $verdict {
                    Verdict::Accept { factor } => (true, factor),
                    Verdict::Reject { factor } => (false, factor),
                };
            }
        }
        verdicts
    }};
}

macro_rules! adaptive {
    ($($controller:ident: $lanes:ident $squares:ident $judged:ident $order:ident $decide:expr;)*) => {$(
        impl<const L: usize, P, A, E, T, const N: usize> LaneController<L, P, A, E, N> for $controller<T>
        where
            T: AbsoluteTolerance<N>,
            P: Policy,
            A: Processor,
            E: Lanewise<L, Element: ErrorEstimate<SingleLane<P, A>, N>> + ErrorEstimate<Lanes<L, P, A>, N>,
        {
            type Alone = $controller<T>;
            type Measure = f64;

            fn alone(&self) -> $controller<T> {
                *self
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn measures(
                &self,
                from: &State<Lanes<L, P, A>, N>,
                to: &State<Lanes<L, P, A>, N>,
                error: &E,
            ) -> [f64; L] {
                self.tolerances().square(|x: Lanes<L, P, A>| x, from, to, error).to_array()
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn decide(
                $lanes: &mut [Self; L],
                $squares: &[f64; L],
                $judged: &[bool; L],
                $order: u32,
            ) -> Verdicts<L> {
                $decide
            }

            fn after_failure(&mut self) -> Option<f64> {
                Controller::<f64, N, Tangent<f64, N>>::after_failure(self)
            }
        }
    )*};
}

adaptive! {
    PiController: lanes squares judged order PiController::decide(lanes, squares, judged, order);
    PidController: lanes squares judged order each!(judged, i => lanes[i].decide(squares[i], order));
}

impl<const L: usize, P, A, T, const N: usize> LaneController<L, P, A, Remainder<Lanes<L, P, A>, N>, N>
    for TaylorController<T>
where
    T: AbsoluteTolerance<N>,
    P: Policy,
    A: Processor,
{
    type Alone = TaylorController<T>;
    /// The error over what is tolerated, and the factor by which the next step may be longer.
    type Measure = [f64; 2];

    fn alone(&self) -> TaylorController<T> {
        *self
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn measures(
        &self,
        from: &State<Lanes<L, P, A>, N>,
        to: &State<Lanes<L, P, A>, N>,
        error: &Remainder<Lanes<L, P, A>, N>,
    ) -> [[f64; 2]; L] {
        let mut h = [0.0; L];
        for i in 0..L {
            h[i] = (to.t.as_array()[i] - from.t.as_array()[i]).abs();
        }
        self.measured(h, to, error, |x, i| x.as_array()[i].abs())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn decide(
        lanes: &mut [Self; L],
        measures: &[[f64; 2]; L],
        judged: &[bool; L],
        order: u32,
    ) -> Verdicts<L> {
        each!(judged, i => lanes[i].decide::<N>(measures[i], order, f64::EPSILON))
    }

    fn after_failure(&mut self) -> Option<f64> {
        Controller::<f64, N, Remainder<f64, N>>::after_failure(self)
    }
}
