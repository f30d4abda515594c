//! Motions of models, as what is seen of them and what they cost.

use lagrange_runtime::analysis::ModalModel;
use lagrange_runtime::prelude::*;
use lagrange_runtime::{Controller, Facts};

type Outputs = Vec<SVector<f64, 3>>;

/// An output at even times, and the evaluations of the equations that it took.
pub struct Motion {
    pub outputs: Outputs,
    evaluations: u64,
    end: f64,
}

impl Motion {
    /// The largest distance from another one.
    pub fn error(&self, reference: &Motion) -> f64 {
        self.outputs.iter().zip(&reference.outputs).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }

    /// Operations per simulated second.
    pub fn cost(&self, facts: &Facts) -> f64 {
        self.evaluations as f64 * operations(facts) / self.end
    }
}

/// Operations of an evaluation, weighted by their times as the compiler does: a sine with its cosine counts as forty.
fn operations(facts: &Facts) -> f64 {
    let o = facts.operations;
    (o.additions + o.multiplications + 4 * o.divisions + 40 * o.sin_cos + 30 * o.functions) as f64
}

/// A scene of a whole system: its start, its end and what is seen of it, at 50 even times.
pub struct Scene<'a, Whole, const N: usize> {
    pub whole: &'a Whole,
    pub start: State<f64, N>,
    pub end: f64,
    pub output: fn(&Whole, &State<f64, N>) -> SVector<f64, 3>,
}

impl<Whole: Lagrangian<N, Scalar = f64>, const N: usize> Scene<'_, Whole, N> {
    /// The motion of the whole system by a method.
    pub fn by<M, C>(&self, method: M, controller: C) -> Result<Motion, Failure<f64>>
    where
        M: Method<Whole, N>,
        C: Controller<f64, N, M::Error>,
    {
        motion(self.whole, self.start, self.end, method, controller, |s| (self.output)(self.whole, s))
    }

    /// The motion of one of its models by a method. Coordinates that are held are so at the start, too.
    pub fn model<Small, const L: usize, const HELD: usize, M, C>(
        &self,
        method: M,
        controller: C,
    ) -> Result<Motion, Failure<f64>>
    where
        Small: Restricted<L, HELD, N, Scalar = f64, Whole = Whole>,
        M: Method<Small, L>,
        C: Controller<f64, L, M::Error>,
    {
        let start = &self.start;
        let nearest = |_| {
            let [q, qd] = [start.q, start.qd].map(|of| Small::KEPT.map(|i| of[i]));
            (Small::of(self.whole), State::new(start.t, q, qd))
        };
        let (small, left) = Small::restrict(self.whole, start).unwrap_or_else(nearest);
        motion(&small, left, self.end, method, controller, |s| (self.output)(self.whole, &small.lift(s)))
    }

    /// The motion of the whole system to a tenth of a thousandth of what models may be off.
    pub fn reference(&self) -> Result<Motion, Failure<f64>> {
        self.by(Dop853, PiController::tolerance(1e-8))
    }

    /// The error of a model over the scene; infinite if its motion ends early.
    pub fn error<Small, const L: usize, const HELD: usize>(&self, reference: &Motion) -> f64
    where
        Small: Restricted<L, HELD, N, Scalar = f64, Whole = Whole>,
    {
        let motion = self.model::<Small, L, HELD, _, _>(Dop853, PiController::tolerance(1e-8));
        motion.map_or(f64::INFINITY, |motion| motion.error(reference))
    }

    /// The error of a few modes of the system over the scene, in one exact step.
    pub fn error_of_modes<const R: usize>(
        &self,
        model: &ModalModel<Whole, N, R>,
        reference: &Motion,
    ) -> Result<f64, Failure<f64>> {
        let (kept, _) = model.restrict(&self.start);
        let output = |s: &State<f64, R>| (self.output)(self.whole, &model.lift(s));
        let motion = motion(model, kept, self.end, MatrixExponential, FixedStep::new(self.end), output)?;
        Ok(motion.error(reference))
    }
}

fn motion<Sys, M, C, const N: usize>(
    system: &Sys,
    start: State<f64, N>,
    end: f64,
    method: M,
    controller: C,
    output: impl Fn(&State<f64, N>) -> SVector<f64, 3>,
) -> Result<Motion, Failure<f64>>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    C: Controller<f64, N, M::Error>,
{
    let mut samples = integrate(system, method, controller, start).until(end).sample_evenly(50);
    let mut outputs = Vec::new();
    for state in samples.by_ref() {
        outputs.push(output(&state?));
    }
    Ok(Motion { outputs, evaluations: samples.statistics().evaluations, end })
}
