//! The proper model of a scene: which terms may be neglected, and which coordinates locked?

use super::model::{Evaluated, Model, evaluated_by};
use super::settings::Settings;
use super::{EnsembleError, Source};
use core::fmt;

/// Search for the proper model of a scene, the one that "achieves the accuracy required by the application with
/// minimal complexity" (Ersal, Fathy, Louca, Rideout and Stein, *J. Dyn. Syst. Meas. Control* 130, 2008): which of
/// `K` moves, terms neglected and coordinates locked, may be made, so that no output errs by more than is allowed?
///
/// Each move has a weight, which is 1 in the whole system and 0 where the move is made: of a term a parameter of the
/// system, of a coordinate a weight of [`Locks`](crate::traits::Locks). One sweep over
/// [`Gradient`](crate::scalar::Gradient)s gives the derivatives of all outputs by all weights, and with them to first
/// order the error of each set of moves, sample by sample, with its signs: two terms that cancel are seen to. Moves are
/// tried from the smallest effect on, then pairs, and once more from all of them back. Each set that is tried is
/// verified by runs of the model with these weights, in lanes and on all threads. A set that is proposed keeps the
/// errors allowed on every sample of the scene: a [`Certification`](super::Certification) estimates whether it does on
/// other samples.
///
/// ```
/// use lagrange_runtime::ensemble::{ClosedForm, Proper, Simulation, Sobol};
/// use lagrange_runtime::lanes::FinalState;
/// use lagrange_runtime::prelude::*;
/// use lagrange_runtime::Gradient;
/// lagrangian! {
///     pub system Pendulum {
///         /// Weights of the air's and the hinge's resistance, and of the wind.
///         param air = 1, hinge = 1, wind = 1;
///         coord theta;
///         T = 0.5 * dot(theta).powi(2);
///         V = -cos(theta);
///         Q[theta] = -air * 1e-6 * dot(theta).powi(3) - hinge * 0.1 * dot(theta) + wind * 1e-5 * cos(theta);
///     }
/// }
/// let (method, tolerance, end) = (Dop853, PiController::tolerance(1e-9), 3.0);
/// let angle = FinalState(|_: &Pendulum, end: &State<f64, 1>| [end.q[0]]);
/// let model = Simulation::new(
///     |([release], [air, hinge, wind]): ([f64; 1], [f64; 3])| {
///         (Pendulum { air, hinge, wind }, State::new(0.0, [0.2 + release], [0.0]))
///     },
///     method, tolerance, end, angle,
/// );
/// // The same over numbers that carry their derivatives by the weights.
/// let effects = ClosedForm::new(|[release]: [f64; 1]| {
///     let [air, hinge, wind] = Gradient::variables([1.0; 3]);
///     let number = Gradient::constant;
///     let start = State::new(number(0.0), [number(0.2 + release)], [number(0.0)]);
///     let system = Pendulum { air, hinge, wind };
///     let run = integrate(&system, method, PiController::tolerance(1e-9), start).until(number(end));
///     [run.final_state().map_or([f64::NAN; 3], |end| end.q[0].slopes)]
/// });
/// let scene = Proper::new(Sobol::<1>::seed(1), 32, ["air", "hinge", "wind"], [1e-3], effects, model);
/// let proper = scene.run()?;
/// assert_eq!(proper.statement("Plain"), "pub simplified Plain: neglect air, neglect wind;");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Proper<'p, Src, E, M, const K: usize, const O: usize> {
    source: Src,
    samples: u64,
    moves: [Move; K],
    pub(super) allowed: [f64; O],
    effects: E,
    model: M,
    worth: [f64; K],
    settings: Settings<'p>,
}

impl<Src: fmt::Debug, E: fmt::Debug, M: fmt::Debug, const K: usize, const O: usize> fmt::Debug
    for Proper<'_, Src, E, M, K, O>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Proper { source, samples, moves, allowed, effects, model, worth, .. } = self;
        f.debug_struct("Proper")
            .field("source", source)
            .field("samples", samples)
            .field("moves", moves)
            .field("allowed", allowed)
            .field("effects", effects)
            .field("model", model)
            .field("worth", worth)
            .finish_non_exhaustive()
    }
}

/// A change that makes a model smaller, as [`simplified`](crate::lagrangian) writes it. Prints as that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Move {
    /// `neglect air`: a parameter, or a weight, is nothing.
    Neglect(&'static str),
    /// `lock phi = 0`: a coordinate is held there. [`Locks`](crate::traits::Locks) give it a weight, and hold it where
    /// they say, which has to be the same place.
    Lock(&'static str, f64),
}

impl From<&'static str> for Move {
    fn from(term: &'static str) -> Self {
        Move::Neglect(term)
    }
}

impl From<(&'static str, f64)> for Move {
    fn from((coordinate, place): (&'static str, f64)) -> Self {
        Move::Lock(coordinate, place)
    }
}

impl fmt::Display for Move {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Move::Neglect(term) => write!(f, "neglect {term}"),
            Move::Lock(coordinate, place) => write!(f, "lock {coordinate} = {place}"),
        }
    }
}

/// Result of [`Proper`].
#[derive(Clone, Debug, PartialEq)]
pub struct ProperModel<const K: usize, const O: usize> {
    /// The moves that were tried.
    pub moves: [Move; K],
    /// First-order effect of each move on each output, in the unit of the output: the largest |∂y/∂w| of the samples,
    /// an array of the O outputs for each of the K moves.
    pub effects: [[f64; O]; K],
    /// The moves that may be made together.
    pub made: [bool; K],
    /// Error of each output with them, the largest of the samples.
    pub error: [f64; O],
    /// The errors allowed.
    pub allowed: [f64; O],
    /// The number of sets that were verified by runs.
    pub verified: u64,
}

impl<const K: usize, const O: usize> ProperModel<K, O> {
    /// The moves in the order of their first-order effects in units of the errors allowed, the largest first.
    pub fn ranked(&self) -> [usize; K] {
        let effect = |term: usize| {
            let parts =
                self.effects[term].iter().zip(&self.allowed).map(|(effect, allowed)| effect / allowed);
            parts.fold(0.0, f64::max)
        };
        let mut order = core::array::from_fn(|term| term);
        order.sort_by(|&i: &usize, &j| effect(j).total_cmp(&effect(i)));
        order
    }

    /// The weights of the proper model: 0 of the moves that are made, 1 of the others.
    pub fn weights(&self) -> [f64; K] {
        weights(&self.made)
    }

    /// The statement to paste into the system, which emits the proper model as a type of this name.
    pub fn statement(&self, name: &str) -> String {
        let made = self.moves.iter().zip(self.made).filter(|(_, made)| *made);
        let moves: Vec<String> = made.map(|(one, _)| one.to_string()).collect();
        if moves.is_empty() {
            return "// No move keeps the errors allowed.".into();
        }
        format!("pub simplified {name}: {};", moves.join(", "))
    }
}

/// A table of moves by their effects in units of what is allowed, and the errors of the proper model.
impl<const K: usize, const O: usize> fmt::Display for ProperModel<K, O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for term in self.ranked() {
            let effects = self.effects[term].iter().zip(&self.allowed);
            write!(f, "{:24}", self.moves[term].to_string())?;
            effects
                .into_iter()
                .try_for_each(|(effect, allowed)| write!(f, "  {:10.3e}", effect / allowed))?;
            writeln!(f, "  {}", if self.made[term] { "made" } else { "not made" })?;
        }
        write!(f, "{:24}", "error")?;
        let errors = self.error.iter().zip(&self.allowed);
        errors.into_iter().try_for_each(|(error, allowed)| write!(f, "  {:10.3e}", error / allowed))?;
        writeln!(f, "  of what is allowed; {} sets verified", self.verified)
    }
}

fn weights<const K: usize>(made: &[bool; K]) -> [f64; K] {
    made.map(|made| if made { 0.0 } else { 1.0 })
}

/// Predicted errors beyond which a set is not tried, in units of those allowed: effects are of first order only.
const HOPELESS: f64 = 4.0;

impl<'p, Src, E, M, const K: usize, const O: usize> Proper<'p, Src, E, M, K, O>
where
    Src: Source,
    E: Model<Src::Draw, Output = [[f64; K]; O]>,
    M: Model<(Src::Draw, [f64; K]), Output = [f64; O]>,
{
    /// A scene: a source and a number of samples, the moves (of terms the names of their weights, of coordinates name
    /// and place), the error allowed in each output, the derivatives of the outputs by the weights where all are 1, and
    /// the model at a draw and weights.
    pub fn new(
        source: Src,
        samples: u64,
        moves: [impl Into<Move>; K],
        allowed: [f64; O],
        effects: E,
        model: M,
    ) -> Self {
        let (moves, worth, settings) = (moves.map(Into::into), [1.0; K], Settings::default());
        Proper { source, samples, moves, allowed, effects, model, worth, settings }
    }

    /// Sets what each move is worth, in operations, say, instead of 1: the search wants the largest sum.
    #[must_use]
    pub fn worth(self, worth: [f64; K]) -> Self {
        Proper { worth, ..self }
    }

    /// Sets the number of threads, as [`Study::threads`](super::Study::threads).
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.settings.threads = Some(threads);
        self
    }

    /// Ranks the moves, and searches for the set to make.
    ///
    /// # Errors
    /// If the scene makes no sense: no samples, moves or outputs, an error allowed or a worth that is not positive, a
    /// sample that the whole model fails, or whose derivatives are not finite, or an output that is the same in all
    /// samples, whatever is left out.
    pub fn run(&self) -> Result<ProperModel<K, O>, EnsembleError> {
        self.check()?;
        let pool = self.settings.driver(self.samples).pool()?;
        let pool = pool.as_ref();
        let (full, slopes) = (self.sound(pool, [1.0; K])?, self.slopes(pool)?);
        let largest = |output: usize, term: usize| {
            slopes.iter().map(|slopes| slopes[output][term].abs()).fold(0.0, f64::max)
        };
        let effects = core::array::from_fn(|term| core::array::from_fn(|output| largest(output, term)));
        let errors = |made: &[bool; K]| largest_errors(&self.outputs(pool, weights(made)), &full);
        let tried = vec![([false; K], [0.0; O])];
        let mut search = Search { slopes, allowed: self.allowed, worth: self.worth, errors: &errors, tried };
        let (made, error) = search.best();
        let is_constant = |&output: &usize| {
            full.len() > 1
                && full.iter().all(|outputs| outputs[output] == full[0][output])
                && effects.iter().all(|effect: &[f64; O]| effect[output] == 0.0)
                && search.tried.iter().all(|(_, errors)| errors[output] == 0.0)
        };
        if let Some(output) = (0..O).find(is_constant) {
            return Err(EnsembleError::Refused(format!(
                "output {output} is {:?} in all samples, whatever is left out; help: give one that depends on the scene",
                full[0][output]
            )));
        }
        let verified = search.tried.len() as u64 - 1;
        Ok(ProperModel { moves: self.moves, effects, made, error, allowed: self.allowed, verified })
    }

    fn check(&self) -> Result<(), EnsembleError> {
        if self.samples == 0 {
            return Err(EnsembleError::NoSamples);
        }
        self.source.check(self.samples)?;
        self.effects.check().map_err(EnsembleError::Refused)?;
        self.model.check().map_err(EnsembleError::Refused)?;
        if K == 0 || O == 0 {
            return Err(EnsembleError::Refused(format!(
                "a scene has moves and outputs, but here are {K} moves and {O} outputs"
            )));
        }
        let is_nowhere = |of: &&Move| matches!(of, Move::Lock(_, place) if !place.is_finite());
        if let Some(bad) = self.moves.iter().find(is_nowhere) {
            return Err(EnsembleError::Refused(format!(
                "`{bad}` names no place; help: that of the study's locks"
            )));
        }
        let is_positive = |number: &&f64| **number > 0.0 && number.is_finite();
        match self.allowed.iter().chain(&self.worth).find(|number| !is_positive(number)) {
            Some(bad) => Err(EnsembleError::Refused(format!(
                "errors allowed and the worth of moves have to be positive and finite, but here is {bad:?}; help: give one for each, in its unit"
            ))),
            None => Ok(()),
        }
    }

    /// Outputs of all samples with these weights.
    fn outputs(&self, pool: Option<&rayon::ThreadPool>, weights: [f64; K]) -> Vec<Evaluated<[f64; O]>> {
        let Proper { source, samples, model, .. } = self;
        evaluated_by(pool, model, *samples, &|index| (source.draw(index), weights))
    }

    /// Outputs of the model with these weights, all of them finite.
    fn sound(
        &self,
        pool: Option<&rayon::ThreadPool>,
        weights: [f64; K],
    ) -> Result<Vec<[f64; O]>, EnsembleError> {
        let of = |(index, evaluated): (usize, Evaluated<[f64; O]>)| match evaluated.output {
            Ok(output) if output.iter().all(|y| y.is_finite()) => Ok(output),
            Ok(output) => Err(EnsembleError::Refused(format!(
                "sample {index} has the outputs {output:?} with the weights {weights:?}; help: leave such draws out of the scene"
            ))),
            Err(failure) => Err(EnsembleError::Refused(format!(
                "sample {index} fails with the weights {weights:?}: {failure}"
            ))),
        };
        self.outputs(pool, weights).into_iter().enumerate().map(of).collect()
    }

    /// The draws of the scene, with these weights.
    pub(super) fn draws(&self, weights: [f64; K]) -> Vec<(Src::Draw, [f64; K])> {
        (0..self.samples).map(|index| (self.source.draw(index), weights)).collect()
    }

    /// Outputs of the whole model, and with these weights.
    pub(super) fn references(&self, weights: [f64; K]) -> Result<[Vec<[f64; O]>; 2], EnsembleError> {
        self.check()?;
        let pool = self.settings.driver(self.samples).pool()?;
        Ok([self.sound(pool.as_ref(), [1.0; K])?, self.sound(pool.as_ref(), weights)?])
    }

    /// Derivatives of the outputs of all samples by the weights, where these are 1.
    fn slopes(&self, pool: Option<&rayon::ThreadPool>) -> Result<Vec<[[f64; K]; O]>, EnsembleError> {
        let Proper { source, samples, effects, .. } = self;
        let all = evaluated_by(pool, effects, *samples, &|index| source.draw(index));
        let of = |(index, evaluated): (usize, Evaluated<[[f64; K]; O]>)| match evaluated.output {
            Ok(slopes) if slopes.iter().flatten().all(|slope| slope.is_finite()) => Ok(slopes),
            Ok(_) => Err(EnsembleError::Refused(format!(
                "derivatives of sample {index} by the weights are not finite; help: look whether its run over gradients comes to its end"
            ))),
            Err(failure) => {
                Err(EnsembleError::Refused(format!("sample {index} fails over gradients: {failure}")))
            }
        };
        all.into_iter().enumerate().map(of).collect()
    }
}

/// The largest error of each output; infinite where a sample has none.
pub(super) fn largest_errors<const O: usize>(found: &[Evaluated<[f64; O]>], exact: &[[f64; O]]) -> [f64; O] {
    let mut errors = [0.0f64; O];
    for (evaluated, exact) in found.iter().zip(exact) {
        for (output, error) in errors.iter_mut().enumerate() {
            let difference =
                evaluated.output.as_ref().map_or(f64::INFINITY, |y| (y[output] - exact[output]).abs());
            *error = error.max(if difference.is_nan() { f64::INFINITY } else { difference });
        }
    }
    errors
}

/// A set of moves that holds, and its errors.
type Found<const K: usize, const O: usize> = ([bool; K], [f64; O]);

/// The search among sets of moves.
struct Search<'s, const K: usize, const O: usize> {
    slopes: Vec<[[f64; K]; O]>,
    allowed: [f64; O],
    worth: [f64; K],
    /// Errors of a set, by runs.
    errors: &'s dyn Fn(&[bool; K]) -> [f64; O],
    /// Sets that were run, whether they hold or not: none is run twice.
    tried: Vec<Found<K, O>>,
}

impl<const K: usize, const O: usize> Search<'_, K, O> {
    /// The error of a set to first order, in units of what is allowed.
    fn predicted(&self, set: &[bool; K]) -> f64 {
        let of = |slopes: &[[f64; K]; O]| {
            let error = |output: usize| {
                let terms = slopes[output].iter().zip(set).filter(|(_, made)| **made);
                terms.map(|(slope, _)| slope).sum::<f64>().abs() / self.allowed[output]
            };
            (0..O).map(error).fold(0.0, f64::max)
        };
        self.slopes.iter().map(of).fold(0.0, f64::max)
    }

    fn worth(&self, set: &[bool; K]) -> f64 {
        set.iter().zip(&self.worth).filter(|(made, _)| **made).map(|(_, worth)| worth).sum()
    }

    /// The set with its errors, if runs show that it keeps those allowed.
    fn held(&mut self, set: &[bool; K]) -> Option<Found<K, O>> {
        if self.predicted(set) > HOPELESS {
            return None;
        }
        let errors = match self.tried.iter().find(|(other, _)| other == set) {
            Some((_, errors)) => *errors,
            None => {
                let errors = (self.errors)(set);
                self.tried.push((*set, errors));
                errors
            }
        };
        errors.iter().zip(&self.allowed).all(|(error, allowed)| error <= allowed).then_some((*set, errors))
    }

    /// From all moves back, until those that are left hold.
    fn back(&mut self) -> Found<K, O> {
        let mut set = [true; K];
        loop {
            if let Some(found) = self.held(&set) {
                return found;
            }
            let whole = self.predicted(&set);
            let kept = |term: usize| {
                let mut less = set;
                less[term] = false;
                (self.predicted(&less) - whole) / self.worth[term]
            };
            let left = (0..K).filter(|&term| set[term]);
            match left.min_by(|&i, &j| kept(i).total_cmp(&kept(j))) {
                Some(term) => set[term] = false,
                None => return ([false; K], [0.0; O]),
            }
        }
    }

    /// A set and further moves, one after the other: single ones, then pairs, each by what the error is predicted to be
    /// for what they are worth.
    fn grown(&mut self, mut found: Found<K, O>) -> Found<K, O> {
        loop {
            let set = found.0;
            let free: Vec<usize> = (0..K).filter(|&term| !set[term]).collect();
            let singles = free.iter().map(|&i| [i, i]);
            let pairs = free.iter().flat_map(|&i| free.iter().filter(move |&&j| j > i).map(move |&j| [i, j]));
            let candidate = |[i, j]: [usize; 2]| {
                let mut more = set;
                (more[i], more[j]) = (true, true);
                (i != j, self.predicted(&more) / (self.worth(&more) - self.worth(&set)), more)
            };
            let mut candidates: Vec<_> = singles.chain(pairs).map(candidate).collect();
            candidates.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            match candidates.iter().find_map(|(.., more)| self.held(more)) {
                Some(more) => found = more,
                None => return found,
            }
        }
    }

    /// The set that is worth most, from none on and from all back.
    fn best(&mut self) -> Found<K, O> {
        let none = ([false; K], [0.0; O]);
        let back = self.back();
        let mut best = none;
        for start in [none, back] {
            let found = self.grown(start);
            if self.worth(&found.0) > self.worth(&best.0) {
                best = found;
            }
        }
        best
    }
}
