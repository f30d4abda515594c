//! Models: functions of a draw that cost something, a simulation or a closed form.

use super::LEAF;
use super::drive::all_of;
use crate::controller::Controller;
use crate::failed::{Failed, Statistics};
use crate::failure::Failure;
use crate::integrate::integrate;
use crate::integrate::lanes::{Bounds, InLanes, Job, Jobs};
use crate::lanes::{Level, Observer, Policy, Rescale};
use crate::method::Method;
use crate::state::State;
use crate::system::System;
use core::fmt;
use core::marker::PhantomData;

/// A function of the draw of a sample, and its cost. Studies of several models
/// ([`Multifidelity`](super::Multifidelity)) and studies that choose their own draws take models; a [`Simulation`] is
/// one, and so is a [`ClosedForm`].
///
/// A model is pure: its outputs and its work depend on the draw alone, whatever the draws beside it are.
pub trait Model<D>: Sync {
    /// Output of a sample.
    type Output: Send;

    /// Number of leaves of samples that are best evaluated together.
    const GROUP: u64 = 1;

    /// Evaluations at these draws, in their order.
    fn evaluate(&self, draws: Vec<D>) -> Vec<Evaluated<Self::Output>>;

    /// Cost of a unit of work, in the unit in which the costs of all models of a study are.
    fn unit_cost(&self) -> f64;

    /// The model whose outputs are a function of this one's: an extreme of several, or 1 where something happens and
    /// 0 elsewhere, whose mean is a probability.
    fn map<O: Send, F: Fn(Self::Output) -> O + Sync>(self, function: F) -> Mapped<Self, F>
    where
        Self: Sized,
    {
        Mapped { model: self, function }
    }

    /// Description that distinguishes the model from others, for checkpoints. It may be given the draw of sample 0.
    fn describe(&self, draw: D) -> String;

    /// Checks the parameters of the model.
    ///
    /// # Errors
    /// If it cannot be evaluated, or has no cost.
    fn check(&self) -> Result<(), String> {
        is_cost(self.unit_cost())
    }
}

fn is_cost(cost: f64) -> Result<(), String> {
    match cost > 0.0 && cost.is_finite() {
        true => Ok(()),
        false => Err(format!("a model's cost has to be positive and finite, but it is {cost:?}")),
    }
}

/// A model whose outputs are functions of another one's, made by [`Model::map`].
#[derive(Clone, Copy)]
pub struct Mapped<M, F> {
    model: M,
    function: F,
}

impl<M: fmt::Debug, F> fmt::Debug for Mapped<M, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mapped").field("model", &self.model).finish_non_exhaustive()
    }
}

impl<D, O: Send, M: Model<D>, F: Fn(M::Output) -> O + Sync> Model<D> for Mapped<M, F> {
    type Output = O;

    const GROUP: u64 = M::GROUP;

    fn evaluate(&self, draws: Vec<D>) -> Vec<Evaluated<O>> {
        let mapped = |Evaluated { output, work }| Evaluated { output: output.map(&self.function), work };
        self.model.evaluate(draws).into_iter().map(mapped).collect()
    }

    fn unit_cost(&self) -> f64 {
        self.model.unit_cost()
    }

    fn describe(&self, draw: D) -> String {
        self.model.describe(draw)
    }

    fn check(&self) -> Result<(), String> {
        self.model.check()
    }
}

/// Result of a model at one draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluated<O> {
    /// The output, or why there is none.
    pub output: Result<O, Failure>,
    /// Units of work: evaluations of the accelerations of a simulation.
    pub work: u64,
}

/// Evaluations of all draws, whatever a model that others have written returns: those that are missing have failed.
pub(super) fn evaluated<D, M: Model<D>>(model: &M, draws: Vec<D>) -> Vec<Evaluated<M::Output>> {
    let count = draws.len();
    let mut all = if draws.is_empty() { vec![] } else { model.evaluate(draws) };
    all.truncate(count);
    all.resize_with(count, Evaluated::missing);
    all
}

/// Evaluations of the draws with the numbers from 0 to `count`, in groups by the threads of the pool: a model does not
/// depend on what it is evaluated with.
pub(super) fn evaluated_by<D, M: Model<D>>(
    pool: Option<&rayon::ThreadPool>,
    model: &M,
    count: u64,
    draw: &(dyn Fn(u64) -> D + Sync),
) -> Vec<Evaluated<M::Output>> {
    let threads = pool.map_or(1, rayon::ThreadPool::current_num_threads) as u64;
    let group = count.div_ceil(threads).clamp(LEAF, LEAF * M::GROUP);
    let part = |k: u64| evaluated(model, (k * group..count.min((k + 1) * group)).map(draw).collect());
    all_of(pool, count.div_ceil(group), &part).into_iter().flatten().collect()
}

impl<O> Evaluated<O> {
    fn missing() -> Self {
        Evaluated { output: Err(Failure::BadEnd { end: None }), work: 0 }
    }
}

/// A function of the draw that needs no simulation: a closed form, a fit, a table.
///
/// ```
/// use lagrange_runtime::ensemble::ClosedForm;
/// // The period of a pendulum, to second order in its amplitude; a hundredth of the cost of a simulation.
/// let period = ClosedForm::new(|[l, amplitude]: [f64; 2]| {
///     std::f64::consts::TAU * (l / 9.81).sqrt() * (1.0 + amplitude.powi(2) / 16.0)
/// })
/// .cost(0.01);
/// # let _ = period;
/// ```
#[derive(Clone, Copy)]
pub struct ClosedForm<F> {
    function: F,
    cost: f64,
}

impl<F> ClosedForm<F> {
    /// A function of the cost 1.
    pub fn new(function: F) -> Self {
        ClosedForm { function, cost: 1.0 }
    }

    /// Sets the cost of a sample, in the unit of the other models of the study.
    #[must_use]
    pub fn cost(self, cost: f64) -> Self {
        ClosedForm { cost, ..self }
    }
}

impl<D, O: Send, F: Fn(D) -> O + Sync> Model<D> for ClosedForm<F> {
    type Output = O;

    fn evaluate(&self, draws: Vec<D>) -> Vec<Evaluated<O>> {
        draws.into_iter().map(|draw| Evaluated { output: Ok((self.function)(draw)), work: 1 }).collect()
    }

    fn unit_cost(&self) -> f64 {
        self.cost
    }

    fn describe(&self, _: D) -> String {
        format!("closed form of cost {:?}", self.cost)
    }
}

/// A simulation: a function from the draw to a system and its start, as an [`Ensemble`](super::Ensemble) has it, the
/// method and controller with which it is integrated to the end, and the observer that makes the output.
///
/// Work is counted in evaluations of the accelerations, so that it is the same on each machine. [`cost`](Self::cost)
/// weighs them, where two models of a study have different accelerations: by their
/// [operations](crate::facts::Facts::operations), say.
///
/// ```
/// use lagrange_runtime::ensemble::{Model, Simulation};
/// use lagrange_runtime::lanes::FinalState;
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     pub system Pendulum {
///         param m, l, g = 9.81;
///         coord theta;
///         T = 0.5 * m * (l * dot(theta)).powi(2);
///         V = -m * g * l * cos(theta);
///     }
/// }
/// let angle = FinalState(|_: &Pendulum, end: &State<f64, 1>| end.q[0]);
/// let draw = |theta: f64| (Pendulum::new(1.0, 0.85), State::new(0.0, [theta], [0.0]));
/// let full = Simulation::new(draw, Dop853, PiController::tolerance(1e-9), 10.0, angle);
/// let loose = Simulation::new(draw, Dop853, PiController::tolerance(1e-3), 10.0, angle);
/// let [work, less] = [full.evaluate(vec![1.0])[0].work, loose.evaluate(vec![1.0])[0].work];
/// assert!(less < work / 3);
/// ```
pub struct Simulation<D, Sys, M, C, W, const N: usize> {
    draw: D,
    method: M,
    controller: C,
    end: f64,
    observer: W,
    max_steps: Option<u64>,
    cost: Option<f64>,
    system: PhantomData<fn() -> Sys>,
}

impl<D, Sys, M, C, W, const N: usize> Simulation<D, Sys, M, C, W, N>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<f64, N, M::Error> + Sync + fmt::Debug,
    W: Observer<Sys, N> + Sync,
{
    /// Runs by a method and controller to `t = end`, whose observer makes the output. `draw` has to be a pure function.
    pub fn new<Draw>(draw: D, method: M, controller: C, end: f64, observer: W) -> Self
    where
        D: Fn(Draw) -> (Sys, State<f64, N>) + Sync,
    {
        let (max_steps, cost) = (None, None);
        Simulation { draw, method, controller, end, observer, max_steps, cost, system: PhantomData }
    }

    /// Fails a sample by [`Failure::BudgetUsedUp`] if `max_steps` steps, accepted or not, do not suffice.
    #[must_use]
    pub fn max_steps(self, max_steps: u64) -> Self {
        Simulation { max_steps: Some(max_steps), ..self }
    }

    /// Sets the cost of one evaluation of the accelerations, instead of 1.
    #[must_use]
    pub fn cost(self, cost: f64) -> Self {
        Simulation { cost: Some(cost), ..self }
    }

    /// The same simulation in lanes, as [`Study::in_lanes`](super::Study::in_lanes).
    ///
    /// Iterations of implicit methods go on until all lanes have converged, so that their evaluations depend on the
    /// company: there steps are counted instead, accepted or not, and their [`cost`](Self::cost) has to be given.
    #[must_use]
    pub fn in_lanes<P: Policy>(self, policy: P) -> LaneSimulation<D, Sys, M, C, W, P, N>
    where
        Sys: Rescale<N, Scalar = f64>,
        M: InLanes<Sys, C, P, N>,
    {
        let _ = policy;
        LaneSimulation { simulation: self, level: Level::best(), policy: PhantomData }
    }

    fn description(&self, system: &Sys, start: &State<f64, N>) -> String {
        let Simulation { method, controller, end, max_steps, cost, .. } = self;
        let accel = system.accel(&start.q, &start.qd, start.t);
        format!(
            "{method:?}, {controller:?}, to t = {end:?}, at most {max_steps:?} steps, of cost {cost:?}; sample 0 at t = {:?}: {:?}, {:?}, \
             accelerations {:?}",
            start.t,
            start.q.as_slice(),
            start.qd.as_slice(),
            accel.as_slice()
        )
    }
}

impl<Draw, D, Sys, M, C, W, const N: usize> Model<Draw> for Simulation<D, Sys, M, C, W, N>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<f64, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Draw) -> (Sys, State<f64, N>) + Sync,
    W: Observer<Sys, N> + Sync,
    W::Output: Send,
{
    type Output = W::Output;

    fn evaluate(&self, draws: Vec<Draw>) -> Vec<Evaluated<W::Output>> {
        let one = |draw| {
            let (system, start) = (self.draw)(draw);
            let run = integrate(&system, self.method.clone(), self.controller.clone(), start).until(self.end);
            let run = match self.max_steps {
                Some(max_steps) => run.max_steps(max_steps),
                None => run,
            };
            let (output, cost) = run.observe_with_cost(&self.observer);
            Evaluated { output: output.map_err(|failed| failed.failure), work: cost.evaluations }
        };
        draws.into_iter().map(one).collect()
    }

    fn unit_cost(&self) -> f64 {
        self.cost.unwrap_or(1.0)
    }

    fn describe(&self, draw: Draw) -> String {
        let (system, start) = (self.draw)(draw);
        self.description(&system, &start)
    }
}

/// A [`Simulation`] in lanes, made by [`Simulation::in_lanes`].
pub struct LaneSimulation<D, Sys, M, C, W, P, const N: usize> {
    simulation: Simulation<D, Sys, M, C, W, N>,
    level: Level,
    policy: PhantomData<fn() -> P>,
}

impl<D, Sys, M, C, W, P, const N: usize> LaneSimulation<D, Sys, M, C, W, P, N> {
    /// Uses the instructions of processors of this kind, as [`LaneStudy::level`](super::LaneStudy::level).
    #[must_use]
    pub fn level(self, level: Level) -> Self {
        LaneSimulation { level, ..self }
    }
}

/// Draws that are taken one after the other, and what came of them.
struct Queue<'a, Draw, D, O> {
    draw: &'a D,
    draws: std::vec::IntoIter<Draw>,
    next: u64,
    implicit: bool,
    done: Vec<Option<Evaluated<O>>>,
}

impl<Draw, D, Sys, O, const N: usize> Jobs<Sys, O, N> for Queue<'_, Draw, D, O>
where
    D: Fn(Draw) -> (Sys, State<f64, N>),
{
    fn next(&mut self) -> Option<Job<Sys, N>> {
        let (system, start) = (self.draw)(self.draws.next()?);
        let index = self.next;
        self.next += 1;
        Some(Job { index, system, start })
    }

    fn done(&mut self, index: u64, cost: Statistics, output: Result<O, Failed<f64, N>>) {
        let work = if self.implicit { cost.accepted + cost.rejected } else { cost.evaluations };
        if let Some(place) = self.done.get_mut(index as usize) {
            *place = Some(Evaluated { output: output.map_err(|failed| failed.failure), work });
        }
    }
}

impl<Draw, D, Sys, M, C, W, P, const N: usize> Model<Draw> for LaneSimulation<D, Sys, M, C, W, P, N>
where
    Sys: Rescale<N, Scalar = f64>,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug + InLanes<Sys, C, P, N>,
    C: Controller<f64, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Draw) -> (Sys, State<f64, N>) + Sync,
    W: Observer<Sys, N> + Sync,
    W::Output: Send,
    P: Policy,
{
    type Output = W::Output;

    const GROUP: u64 = 16;

    fn evaluate(&self, draws: Vec<Draw>) -> Vec<Evaluated<W::Output>> {
        let Simulation { draw, method, controller, end, observer, max_steps, .. } = &self.simulation;
        let bounds = Bounds { end: *end, max_steps: *max_steps };
        let done = draws.iter().map(|_| None).collect();
        let implicit = method.implicit();
        let mut queue = Queue { draw, draws: draws.into_iter(), next: 0, implicit, done };
        method.runs(self.level, controller, bounds, observer, &mut queue);
        // (Each run that has entered a lane leaves it.)
        queue.done.into_iter().map(|done| done.unwrap_or_else(Evaluated::missing)).collect()
    }

    fn unit_cost(&self) -> f64 {
        self.simulation.cost.unwrap_or(1.0)
    }

    fn describe(&self, draw: Draw) -> String {
        let (system, start) = (self.simulation.draw)(draw);
        let policy = if P::FUSED { "fused" } else { "rounded" };
        format!("{}; in lanes, {policy} multiply-adds", self.simulation.description(&system, &start))
    }

    fn check(&self) -> Result<(), String> {
        if self.simulation.method.implicit() && self.simulation.cost.is_none() {
            return Err(format!(
                "evaluations of the implicit method {:?} depend on the lanes beside; help: give the cost of a step, as `.cost(20.0)`, before \
                 `.in_lanes(…)`",
                self.simulation.method
            ));
        }
        is_cost(Model::<Draw>::unit_cost(self))
    }
}

impl<F> fmt::Debug for ClosedForm<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ClosedForm").field("cost", &self.cost).finish_non_exhaustive()
    }
}

impl<D, Sys, M: fmt::Debug, C: fmt::Debug, W, const N: usize> fmt::Debug for Simulation<D, Sys, M, C, W, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Simulation { method, controller, end, .. } = self;
        f.debug_struct("Simulation")
            .field("method", method)
            .field("controller", controller)
            .field("end", end)
            .finish_non_exhaustive()
    }
}

impl<D, Sys, M: fmt::Debug, C: fmt::Debug, W, P, const N: usize> fmt::Debug
    for LaneSimulation<D, Sys, M, C, W, P, N>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("LaneSimulation").field(&self.simulation).finish()
    }
}
