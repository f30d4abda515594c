//! The proper model of a scene: which terms may be neglected?

use super::model::{Evaluated, Model, evaluated_by};
use super::settings::Settings;
use super::{EnsembleError, Source};
use core::fmt;

/// Search for the proper model of a scene, the one that "achieves the accuracy required by the application with
/// minimal complexity" (Ersal, Fathy, Louca, Rideout and Stein, *J. Dyn. Syst. Meas. Control* 130, 2008): which of
/// `K` terms may be neglected, so that no output errs by more than is allowed?
///
/// Each term has a weight, a parameter of the system that is 1 where the term is there and 0 where it is neglected.
/// One sweep over [`Gradient`](crate::scalar::Gradient)s gives the derivatives of all outputs by all weights, and
/// with them to first order the error of each set of neglected terms, sample by sample, with its signs: two terms
/// that cancel are seen to. Terms are tried from the smallest effect on, then pairs, and once more from all terms
/// back; what is tried is verified by runs of the model with these weights, in lanes and on all threads. A set that
/// is proposed keeps what is allowed on every sample of the scene: whether it does on others a
/// [`Certification`](super::Certification) tells.
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
    names: [&'static str; K],
    allowed: [f64; O],
    effects: E,
    model: M,
    worth: [f64; K],
    settings: Settings<'p>,
}

impl<Src: fmt::Debug, E: fmt::Debug, M: fmt::Debug, const K: usize, const O: usize> fmt::Debug
    for Proper<'_, Src, E, M, K, O>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Proper { source, samples, names, allowed, effects, model, worth, .. } = self;
        f.debug_struct("Proper")
            .field("source", source)
            .field("samples", samples)
            .field("names", names)
            .field("allowed", allowed)
            .field("effects", effects)
            .field("model", model)
            .field("worth", worth)
            .finish_non_exhaustive()
    }
}

/// Result of [`Proper`].
#[derive(Clone, Debug, PartialEq)]
pub struct ProperModel<const K: usize, const O: usize> {
    /// Names of the terms.
    pub names: [&'static str; K],
    /// First-order effect of each term on each output: the largest |∂y/∂w| of the samples.
    pub effects: [[f64; O]; K],
    /// The terms that may be neglected together.
    pub neglected: [bool; K],
    /// Error of each output without them, the largest of the samples.
    pub error: [f64; O],
    /// The errors allowed.
    pub allowed: [f64; O],
    /// The number of sets that were verified by runs.
    pub verified: u64,
}

impl<const K: usize, const O: usize> ProperModel<K, O> {
    /// The terms in the order of their first-order effects in units of the errors allowed, the largest first.
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

    /// The statement to paste into the system, which emits the proper model as a type of this name.
    pub fn statement(&self, name: &str) -> String {
        let terms = self.names.iter().zip(self.neglected).filter(|(_, neglected)| *neglected);
        let moves: Vec<String> = terms.map(|(term, _)| format!("neglect {term}")).collect();
        if moves.is_empty() {
            return "// No term may be neglected.".into();
        }
        format!("pub simplified {name}: {};", moves.join(", "))
    }
}

/// A table of terms by their effects in units of what is allowed, and the errors of the proper model.
impl<const K: usize, const O: usize> fmt::Display for ProperModel<K, O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for term in self.ranked() {
            let effects = self.effects[term].iter().zip(&self.allowed);
            write!(f, "{:16}", self.names[term])?;
            effects
                .into_iter()
                .try_for_each(|(effect, allowed)| write!(f, "  {:10.3e}", effect / allowed))?;
            writeln!(f, "  {}", if self.neglected[term] { "neglected" } else { "kept" })?;
        }
        write!(f, "{:16}", "error")?;
        let errors = self.error.iter().zip(&self.allowed);
        errors.into_iter().try_for_each(|(error, allowed)| write!(f, "  {:10.3e}", error / allowed))?;
        writeln!(f, "  of what is allowed; {} sets verified", self.verified)
    }
}

/// Predicted errors beyond which a set is not tried, in units of those allowed: effects are of first order only.
const HOPELESS: f64 = 4.0;

impl<'p, Src, E, M, const K: usize, const O: usize> Proper<'p, Src, E, M, K, O>
where
    Src: Source,
    E: Model<Src::Draw, Output = [[f64; K]; O]>,
    M: Model<(Src::Draw, [f64; K]), Output = [f64; O]>,
{
    /// A scene: a source and a number of samples, names of the terms' weights, the error allowed in each output, the
    /// derivatives of the outputs by the weights where all are 1, and the model at a draw and weights.
    pub fn new(
        source: Src,
        samples: u64,
        names: [&'static str; K],
        allowed: [f64; O],
        effects: E,
        model: M,
    ) -> Self {
        let (worth, settings) = ([1.0; K], Settings::default());
        Proper { source, samples, names, allowed, effects, model, worth, settings }
    }

    /// Sets what it is worth to neglect each term, in operations, say, instead of 1: the search wants the largest sum.
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

    /// Ranks the terms, and searches for the set to neglect.
    ///
    /// # Errors
    /// If the scene makes no sense: no samples, terms or outputs, an error allowed or a worth that is not positive, a
    /// sample that the model with all of its terms fails, or whose derivatives are not finite.
    pub fn run(&self) -> Result<ProperModel<K, O>, EnsembleError> {
        let Proper { source, samples, names, allowed, effects, model, worth, settings } = self;
        let refused = |what: String| Err(EnsembleError::Refused(what));
        if *samples == 0 {
            return Err(EnsembleError::NoSamples);
        }
        source.check(*samples)?;
        effects.check().map_err(EnsembleError::Refused)?;
        model.check().map_err(EnsembleError::Refused)?;
        if K == 0 || O == 0 {
            return refused(format!("a scene has terms and outputs, but here are {K} terms and {O} outputs"));
        }
        let is_positive = |number: &&f64| **number > 0.0 && number.is_finite();
        if let Some(bad) = allowed.iter().chain(worth).find(|number| !is_positive(number)) {
            return refused(format!(
                "errors allowed and the worth of terms have to be positive and finite, but here is {bad:?}; help: give one for each, in its unit"
            ));
        }
        let pool = settings.driver(*samples).pool()?;
        let slopes: Vec<Evaluated<[[f64; K]; O]>> =
            evaluated_by(pool.as_ref(), effects, *samples, &|index| source.draw(index));
        let outputs = |weights: [f64; K]| -> Vec<Evaluated<[f64; O]>> {
            evaluated_by(pool.as_ref(), model, *samples, &|index| (source.draw(index), weights))
        };
        let mut full = vec![];
        for (index, evaluated) in outputs([1.0; K]).into_iter().enumerate() {
            match evaluated.output {
                Ok(output) if output.iter().all(|y| y.is_finite()) => full.push(output),
                Ok(output) => {
                    return refused(format!(
                        "sample {index} has the outputs {output:?} with all terms; help: leave such draws out of the scene"
                    ));
                }
                Err(failure) => return refused(format!("sample {index} fails with all terms: {failure}")),
            }
        }
        let mut gradients = vec![];
        for (index, evaluated) in slopes.into_iter().enumerate() {
            match evaluated.output {
                Ok(slopes) if slopes.iter().flatten().all(|slope| slope.is_finite()) => {
                    gradients.push(slopes)
                }
                Ok(_) => {
                    return refused(format!(
                        "derivatives of sample {index} by the weights are not finite; help: look whether its run over gradients comes to its end"
                    ));
                }
                Err(failure) => return refused(format!("sample {index} fails over gradients: {failure}")),
            }
        }
        let largest = |output: usize, term: usize| {
            gradients.iter().map(|slopes| slopes[output][term].abs()).fold(0.0, f64::max)
        };
        // The error to first order, in units of what is allowed, and the one that runs show.
        let predicted = |set: &[bool; K]| {
            let of = |slopes: &[[f64; K]; O]| {
                let error = |output: usize| {
                    let terms = slopes[output].iter().zip(set).filter(|(_, neglected)| **neglected);
                    terms.map(|(slope, _)| slope).sum::<f64>().abs() / allowed[output]
                };
                (0..O).map(error).fold(0.0, f64::max)
            };
            gradients.iter().map(of).fold(0.0, f64::max)
        };
        let without = |set: &[bool; K]| -> [f64; O] {
            let without = outputs(set.map(|neglected| if neglected { 0.0 } else { 1.0 }));
            let mut errors = [0.0f64; O];
            for (evaluated, full) in without.into_iter().zip(&full) {
                for (output, error) in errors.iter_mut().enumerate() {
                    let difference =
                        evaluated.output.map_or(f64::INFINITY, |y| (y[output] - full[output]).abs());
                    *error = error.max(if difference.is_nan() { f64::INFINITY } else { difference });
                }
            }
            errors
        };
        // No set is run twice: what was tried and did not hold, and what did.
        let mut tried: Vec<([bool; K], [f64; O])> = vec![([false; K], [0.0; O])];
        let mut holds = |set: &[bool; K]| {
            if predicted(set) > HOPELESS {
                return None;
            }
            let errors = match tried.iter().find(|(other, _)| other == set) {
                Some((_, errors)) => *errors,
                None => {
                    let errors = without(set);
                    tried.push((*set, errors));
                    errors
                }
            };
            errors.iter().zip(allowed).all(|(error, allowed)| error <= allowed).then_some((*set, errors))
        };
        let sum = |set: &[bool; K]| {
            set.iter().zip(worth).filter(|(neglected, _)| **neglected).map(|(_, worth)| worth).sum::<f64>()
        };
        // From no term on, one after the other; and from all terms back, until what is left out may be.
        let mut back = [true; K];
        let back = loop {
            if let Some(found) = holds(&back) {
                break found;
            }
            let kept = |term: usize| {
                let mut set = back;
                set[term] = false;
                (predicted(&set) - predicted(&back)) / worth[term]
            };
            let left = (0..K).filter(|&term| back[term]);
            match left.min_by(|&i, &j| kept(i).total_cmp(&kept(j))) {
                Some(term) => back[term] = false,
                None => break ([false; K], [0.0; O]),
            }
        };
        let (mut neglected, mut error) = ([false; K], [0.0; O]);
        for (mut set, mut errors) in [([false; K], [0.0; O]), back] {
            // Single terms, then pairs, each by what the error is predicted to be for what they are worth.
            loop {
                let free: Vec<usize> = (0..K).filter(|&term| !set[term]).collect();
                let singles = free.iter().map(|&i| [i, i]);
                let pairs =
                    free.iter().flat_map(|&i| free.iter().filter(move |&&j| j > i).map(move |&j| [i, j]));
                let candidate = |[i, j]: [usize; 2]| {
                    let mut more = set;
                    (more[i], more[j]) = (true, true);
                    (i != j, predicted(&more) / (sum(&more) - sum(&set)), more)
                };
                let mut candidates: Vec<_> = singles.chain(pairs).map(candidate).collect();
                candidates.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
                match candidates.iter().find_map(|(.., more)| holds(more)) {
                    Some(found) => (set, errors) = found,
                    None => break,
                }
            }
            if sum(&set) > sum(&neglected) {
                (neglected, error) = (set, errors);
            }
        }
        let verified = tried.len() as u64 - 1;
        Ok(ProperModel {
            names: *names,
            effects: core::array::from_fn(|term| core::array::from_fn(|output| largest(output, term))),
            neglected,
            error,
            allowed: *allowed,
            verified,
        })
    }
}
