//! The integration of a proper model: which method and tolerance is the cheapest that is accurate enough?

use super::model::{Evaluated, Model, evaluated};
use super::proper::{Proper, ProperModel, largest_errors};
use super::{EnsembleError, Source};
use core::fmt;

/// Evaluations of a model at draws.
type Evaluate<'a, D, const O: usize> = Box<dyn Fn(Vec<D>) -> Vec<Evaluated<[f64; O]>> + 'a>;

/// A way to integrate a proper model, a method and its tolerance say, among which [`Proper::integrations`] chooses.
pub struct Candidate<'a, D, const O: usize> {
    name: String,
    evaluate: Evaluate<'a, D, O>,
    unit_cost: f64,
    /// If it cannot be evaluated, or has no cost.
    checked: Result<(), String>,
}

impl<'a, D: 'a, const O: usize> Candidate<'a, D, O> {
    /// A model of the same draws and weights as that of the study, by another method or tolerance, or over the smaller
    /// system that the statement made, with its [cost](super::Simulation::cost).
    pub fn new(name: impl Into<String>, model: impl Model<D, Output = [f64; O]> + 'a) -> Self {
        let (unit_cost, checked) = (model.unit_cost(), model.check());
        let evaluate = Box::new(move |draws| evaluated(&model, draws));
        Candidate { name: name.into(), evaluate, unit_cost, checked }
    }
}

impl<D, const O: usize> fmt::Debug for Candidate<'_, D, O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Candidate { name, unit_cost, .. } = self;
        f.debug_struct("Candidate").field("name", name).field("unit_cost", unit_cost).finish_non_exhaustive()
    }
}

/// A candidate at the samples of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Integration<const O: usize> {
    /// Name of the candidate.
    pub name: String,
    /// Error of each output by integration, the largest of the samples: against the model of the study with the same
    /// weights.
    pub error: [f64; O],
    /// Error of each output altogether: against the whole model.
    pub total: [f64; O],
    /// Cost of a sample, on the average: evaluations times what each costs.
    pub cost: f64,
    /// True if `error` keeps its share of the errors allowed, and `total` the errors allowed.
    pub holds: bool,
}

/// Result of [`Proper::integrations`].
#[derive(Clone, Debug, PartialEq)]
pub struct Integrations<const O: usize> {
    /// The candidates, in the order given.
    pub all: Vec<Integration<O>>,
    /// The errors allowed.
    pub allowed: [f64; O],
    /// The share of them that integration may take.
    pub share: f64,
}

impl<const O: usize> Integrations<O> {
    /// The cheapest candidate that holds, the first of equal ones; `None` if none does.
    pub fn cheapest(&self) -> Option<&Integration<O>> {
        self.all.iter().filter(|one| one.holds).min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}

/// A table of the candidates: cost of a sample, error of integration and altogether, in units of those allowed, and
/// which one is proposed.
impl<const O: usize> fmt::Display for Integrations<O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:24}  {:>10}  {:>10}  {:>10}", "", "cost", "integration", "altogether")?;
        let largest = |errors: &[f64; O]| {
            errors.iter().zip(&self.allowed).map(|(error, allowed)| error / allowed).fold(0.0, f64::max)
        };
        for one in &self.all {
            let proposed = self.cheapest().is_some_and(|best| std::ptr::eq(best, one));
            let verdict = match (proposed, one.holds) {
                (true, _) => "proposed",
                (_, true) => "holds",
                (_, false) => "too far off",
            };
            let (error, total) = (largest(&one.error), largest(&one.total));
            writeln!(f, "{:24}  {:10.1}  {error:11.3e}  {total:10.3e}  {verdict}", one.name, one.cost)?;
        }
        writeln!(f, "integration may take {} of what is allowed", self.share)
    }
}

impl<Src, E, M, const K: usize, const O: usize> Proper<'_, Src, E, M, K, O>
where
    Src: Source,
    E: Model<Src::Draw, Output = [[f64; K]; O]>,
    M: Model<(Src::Draw, [f64; K]), Output = [f64; O]>,
{
    /// Runs the proper model by each candidate over the samples of the scene: the cheapest one whose integration errs
    /// by no more than `share` of what is allowed, a third say, and which keeps what is allowed altogether, is
    /// proposed. A model that is not exact needs no more digits than it has.
    ///
    /// The model of the study is the reference, so its own tolerance has to be finer. Costs are counted in evaluations,
    /// so that they are the same on each machine.
    ///
    /// # Errors
    /// Those of [`run`](Self::run); if the share is not between 0 and 1, a candidate has no positive cost, the proper
    /// model is of other errors allowed, or the study's model fails with these weights.
    ///
    /// ```
    /// use lagrange_runtime::Gradient;
    /// use lagrange_runtime::ensemble::{Candidate, ClosedForm, Proper, Simulation, Sobol};
    /// use lagrange_runtime::lanes::FinalState;
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     pub system Pendulum {
    ///         param air = 1;
    ///         coord theta;
    ///         T = 0.5 * dot(theta).powi(2);
    ///         V = -cos(theta);
    ///         Q[theta] = -air * 1e-4 * dot(theta).powi(3);
    ///     }
    /// }
    /// let draw = |([release], [air]): ([f64; 1], [f64; 1])| (Pendulum { air }, State::new(0.0, [0.5 + release], [0.0]));
    /// let angle = FinalState(|_: &Pendulum, end: &State<f64, 1>| [end.q[0]]);
    /// let by = |tolerance| Simulation::new(draw, Dop853, PiController::tolerance(tolerance), 5.0, angle);
    /// let effects = ClosedForm::new(|[release]: [f64; 1]| {
    ///     let number = Gradient::<f64, 1>::constant;
    ///     let [air] = Gradient::variables([1.0]);
    ///     let start = State::new(number(0.0), [number(0.5 + release)], [number(0.0)]);
    ///     let system = Pendulum { air };
    ///     let run = integrate(&system, Dop853, PiController::tolerance(1e-9), start).until(number(5.0));
    ///     [run.final_state().map_or([f64::NAN], |end| end.q[0].slopes)]
    /// });
    /// let scene = Proper::new(Sobol::<1>::seed(1), 8, ["air"], [1e-3], effects, by(1e-11));
    /// let small = scene.run()?;
    /// let candidates = [1e-3, 1e-5, 1e-9].map(|tolerance| Candidate::new(format!("DOP853 {tolerance:e}"), by(tolerance)));
    /// let found = scene.integrations(&small, &candidates, 1.0 / 3.0)?;
    /// println!("{small}{found}");
    /// assert!(found.cheapest().is_some_and(|best| best.error[0] < 1e-3 / 3.0 && best.cost < found.all[2].cost));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn integrations(
        &self,
        found: &ProperModel<K, O>,
        candidates: &[Candidate<'_, (Src::Draw, [f64; K]), O>],
        share: f64,
    ) -> Result<Integrations<O>, EnsembleError> {
        if !(share > 0.0 && share <= 1.0) {
            return Err(EnsembleError::Refused(format!(
                "the share of the errors allowed that integration may take is between 0 and 1, but here is {share:?}; help: a third, 1.0 / 3.0"
            )));
        }
        if found.allowed != self.allowed {
            return Err(EnsembleError::Refused(format!(
                "the proper model is of another scene, whose errors allowed are {:?}, not {:?}; help: give that of this scene's `run`",
                found.allowed, self.allowed
            )));
        }
        for Candidate { name, checked, .. } in candidates {
            checked
                .clone()
                .map_err(|cause| EnsembleError::Refused(format!("the candidate {name:?}: {cause}")))?;
        }
        let [full, reference] = self.references(found.weights())?;
        let of = |candidate: &Candidate<'_, (Src::Draw, [f64; K]), O>| {
            let all = (candidate.evaluate)(self.draws(found.weights()));
            let work = all.iter().map(|one| one.work).sum::<u64>();
            let cost = work as f64 * candidate.unit_cost / full.len() as f64;
            let [error, total] = [&reference, &full].map(|exact| largest_errors(&all, exact));
            let within = |errors: &[f64; O], share: f64| {
                errors.iter().zip(&found.allowed).all(|(error, allowed)| *error <= share * allowed)
            };
            let holds = within(&error, share) && within(&total, 1.0);
            Integration { name: candidate.name.clone(), error, total, cost, holds }
        };
        let all = candidates.iter().map(of).collect();
        Ok(Integrations { all, allowed: found.allowed, share })
    }
}
