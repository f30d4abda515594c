//! Observers of single runs: the rules by which lanes observe trajectories, for one that runs alone.

use crate::controller::Controller;
use crate::event::landing::{Judge, Landing, Outlook};
use crate::event::locate::{approached, outline};
use crate::event::within::Within;
use crate::failed::Failed;
#[cfg(feature = "ensemble")]
use crate::failed::Statistics;
use crate::failure::Failure;
use crate::integrate::{Drive, Run};
use crate::lanes::{Motion, Observer, disordered};
use crate::method::{Interpolant, Method, Step};
use crate::state::State;
use crate::system::System;
use core::cell::RefCell;

impl<Sys, M, C, const N: usize> Run<'_, Sys, M, C, N>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    C: Controller<f64, N, M::Error>,
{
    /// Runs to the end, or to where the observer ends the run, and gives the observer's output. The same observers
    /// serve trajectories in lanes, see `Study::observe` of the feature `ensemble`.
    ///
    /// ```
    /// use lagrange_runtime::lanes::FoldSteps;
    /// use lagrange_runtime::prelude::*;
    /// # struct Oscillator;
    /// # impl System<1> for Oscillator {
    /// #     type Scalar = f64;
    /// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
    /// #         -q
    /// #     }
    /// # }
    /// let highest = FoldSteps {
    ///     start: |_: &Oscillator, start: &State<f64, 1>| start.q[0],
    ///     step: |most: &mut f64, _: &Oscillator, _: &State<f64, 1>, to: &State<f64, 1>| *most = most.max(to.q[0]),
    ///     finish: |most, _: &Oscillator, _: &State<f64, 1>| most,
    /// };
    /// let run = integrate(&Oscillator, Dop853, PiController::tolerance(1e-9), State::new(0.0, [0.0], [1.0])).until(20.0);
    /// let most = run.observe(&highest)?;
    /// assert!(most > 0.9 && most < 1.0 + 1e-8);
    /// # Ok::<(), Failure>(())
    /// ```
    ///
    /// # Errors
    /// The failure of the run; [`Failure::SampleOrder`] if the observer wants a time that is not after the one
    /// before; those of events.
    pub fn observe<W: Observer<Sys, N>>(mut self, observer: &W) -> Result<W::Output, Failed<f64, N>> {
        self.observe_to_end(observer)
    }

    /// Variant of [`observe`](Self::observe) that also returns the cost of the run.
    #[cfg(feature = "ensemble")]
    pub(crate) fn observe_with_cost<W: Observer<Sys, N>>(
        mut self,
        observer: &W,
    ) -> (Result<W::Output, Failed<f64, N>>, Statistics) {
        (self.observe_to_end(observer), self.statistics())
    }

    fn observe_to_end<W: Observer<Sys, N>>(&mut self, observer: &W) -> Result<W::Output, Failed<f64, N>> {
        observed(self, observer).map_err(|failure| {
            if Run::failure(self).is_none() {
                self.fail(failure);
            }
            self.failed(failure)
        })
    }
}

fn observed<Sys, M, C, W, const N: usize>(
    run: &mut Run<'_, Sys, M, C, N>,
    observer: &W,
) -> Result<W::Output, Failure>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    C: Controller<f64, N, M::Error>,
    W: Observer<Sys, N>,
{
    let (system, start) = (Run::system(run), *run.start());
    let end = Run::end(run).ok_or(Failure::BadEnd { end: None })?;
    let mut seen = observer.start(system, &start);
    if observer.wanted(&seen) == Some(start.t) {
        observer.sample(&mut seen, system, &start);
    }
    if let Some(failure) = disordered(start.t, end - start.t, observer.wanted(&seen)) {
        return Err(failure);
    }
    let mut aim = f64::INFINITY;
    loop {
        let memory = if W::WITHIN { Some(run.memory()?.clone()) } else { None };
        let Some(step) = run.advance_towards(Some(aim)) else { break };
        let step = step?;
        let (mut dense, mut last) = (None, None);
        let outline = outline::<Sys, M, N>(&run.engine().method, &step).filter(|_| W::WITHIN);
        let outlook = outline.map_or(Outlook::Unclear, |outline| {
            observer.outlook(&mut seen, system, &outline, run.engine().h)
        });
        aim = if let Outlook::Clear { aim } = outlook { aim } else { f64::INFINITY };
        if let (Outlook::Crossing(landing), Some(outline), Some(memory)) = (outlook, &outline, &memory)
            && Sys::SWITCHES == 0
            && observer.wanted(&seen).is_none()
        {
            let (system, engine) = run.parts();
            let approach = |landing: &mut Landing, reached: &_, judge: &dyn Judge<f64, N>| {
                observer.approach(&mut seen, system, outline, landing, reached, judge)
            };
            last = approached(engine, system, memory, (&step, outline), landing, approach);
        }
        if let Some(memory) = memory.filter(|_| last.is_none() && !matches!(outlook, Outlook::Clear { .. })) {
            let parts = run.engine().method.parts(&memory, step.h);
            let between = Run::interpolant(run, &step);
            let inside = Inside {
                step: &step,
                between: &between,
                memory: &memory,
                parts,
                run: RefCell::new(&mut *run),
            };
            last = observer.within(&mut seen, system, &inside)?;
            dense = Some(between);
        }
        let to = last.unwrap_or(step.to);
        if W::STEPS {
            observer.step(&mut seen, system, &step.from, &to);
        }
        let reached = |time: &f64| if step.h < 0.0 { *time >= to.t } else { *time <= to.t };
        while let Some(time) = observer.wanted(&seen).filter(reached) {
            let at = if time == to.t {
                to
            } else {
                let between = dense.get_or_insert_with(|| Run::interpolant(run, &step)).at(time);
                run.on_constraints(between)?
            };
            observer.sample(&mut seen, system, &at);
            if let Some(failure) = disordered(at.t, step.h, observer.wanted(&seen)) {
                return Err(failure);
            }
        }
        if last.is_some() {
            return Ok(observer.finish(seen, system, &to));
        }
    }
    match Run::failure(run) {
        Some(failure) => Err(failure),
        None => Ok(observer.finish(seen, system, Run::state(run))),
    }
}

/// The motion within a step of a run.
struct Inside<'a, 'r, Sys: System<N, Scalar = f64>, M: Method<Sys, N>, C, const N: usize> {
    step: &'a Step<Sys, M, N>,
    between: &'a M::Interpolant,
    memory: &'a M::MethodState,
    parts: u32,
    /// The run, which counts the evaluations of steps to events.
    run: RefCell<&'a mut Run<'r, Sys, M, C, N>>,
}

impl<Sys, M, C, const N: usize> Within<f64, N> for Inside<'_, '_, Sys, M, C, N>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
{
    fn parts(&self) -> u32 {
        self.parts
    }

    fn ends(&self) -> [State<f64, N>; 2] {
        [self.step.from, self.step.to]
    }

    fn size(&self) -> f64 {
        self.step.h
    }

    fn between(&self, x: f64) -> State<f64, N> {
        self.between.at(self.time(x))
    }
}

impl<Sys, M, C, const N: usize> Motion<N> for Inside<'_, '_, Sys, M, C, N>
where
    Sys: System<N, Scalar = f64>,
    M: Method<Sys, N>,
    C: Controller<f64, N, M::Error>,
{
    fn stepped(&self, x: f64) -> Result<State<f64, N>, Failure> {
        let mut run = self.run.borrow_mut();
        let (system, engine) = run.parts();
        let (step, _) = engine.attempt_from(system, self.memory, &self.step.from, self.step.h * x)?;
        Ok(step.to)
    }
}
