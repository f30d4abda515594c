//! The motion of lanes within their steps: interpolants, what is looked at of them, and steps of a lane alone.

use super::job::{Alone, LANES, Packed};
use crate::controller::Controller;
use crate::event::scan::Grid;
use crate::event::search::MOST_PARTS;
use crate::event::within::Within;
use crate::failure::Failure;
use crate::integrate::engine::attempt_beside;
use crate::lanes::{Lanes, Lanewise, Motion, Policy, Processor, Rescale, SingleLane, Work};
use crate::method::{Interpolant, Method, Step};
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::System;

/// The interpolant of a step, or the cheaper one, if there is one.
struct Interpolate<'a, Sys: System<N>, M: Method<Sys, N>, const N: usize> {
    method: &'a M,
    system: &'a Sys,
    step: &'a Step<Sys, M, N>,
    coarse: bool,
}

impl<Sys: System<N>, M: Method<Sys, N>, const N: usize> Work for Interpolate<'_, Sys, M, N> {
    type Output = Option<M::Interpolant>;

    #[inline(always)]
    fn run(self) -> Option<M::Interpolant> {
        match self.coarse {
            true => self.method.coarse_interpolant(self.system, self.step),
            false => Some(self.method.interpolant(self.system, self.step)),
        }
    }
}

/// The interpolant of a step at a time of each lane.
struct At<'a, D, T, const N: usize> {
    dense: &'a D,
    t: T,
}

impl<D: Interpolant<T, N>, T: Scalar, const N: usize> Work for At<'_, D, T, N> {
    type Output = State<T, N>;

    #[inline(always)]
    fn run(self) -> State<T, N> {
        self.dense.at(self.t)
    }
}

/// A step of a lane alone, and what its next one begins with.
pub struct Apart<'a, Sys: System<N>, M, C, MethodState, const N: usize> {
    pub method: &'a M,
    pub controller: C,
    pub system: Sys,
    pub memory: MethodState,
    pub from: State<Sys::Scalar, N>,
    pub h: Sys::Scalar,
}

impl<Sys, M, C, const N: usize> Work for Apart<'_, Sys, M, C, M::MethodState, N>
where
    Sys: System<N>,
    Sys::Scalar: Real,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    type Output = Result<(Step<Sys, M, N>, M::MethodState), Failure<Sys::Scalar>>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        attempt_beside(&self.system, self.method, &self.controller, &self.memory, &self.from, self.h)
    }
}

/// One of the two interpolants of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Which {
    Dense,
    Coarse,
}

/// Interpolants of a lane whose step was made alone.
pub struct Own<D> {
    pub lane: usize,
    pub t: f64,
    dense: Option<D>,
    coarse: Option<D>,
}

impl<D> Own<D> {
    /// The interpolants of a step, the coarse one if it is asked for.
    pub fn new<Sys, M, const N: usize>(
        lane: usize,
        method: &M,
        system: &Sys,
        step: &Step<Sys, M, N>,
        coarse: bool,
    ) -> Self
    where
        Sys: System<N, Scalar: Real>,
        M: Method<Sys, N, Interpolant = D>,
    {
        let make = |coarse| Sys::Scalar::evaluate(Interpolate { method, system, step, coarse });
        let coarse = if coarse { make(true) } else { None };
        Own { lane, t: step.to.t.to_f64(), dense: make(false), coarse }
    }
}

/// States of lanes at parts of their steps.
pub type Looked<P, A, const N: usize> = Vec<(f64, State<Lanes<LANES, P, A>, N>)>;

/// The motion of the lanes within their steps.
pub struct Course<'a, Sys: Rescale<N, Scalar = f64>, M, P: Policy, A: Processor, const N: usize>
where
    M: Method<Packed<Sys, P, A, N>, N> + Method<Alone<Sys, P, A, N>, N>,
{
    pub method: &'a M,
    pub system: &'a Packed<Sys, P, A, N>,
    pub memory: &'a <M as Method<Packed<Sys, P, A, N>, N>>::MethodState,
    pub step: &'a Step<Packed<Sys, P, A, N>, M, N>,
    pub own: &'a [Own<<M as Method<Alone<Sys, P, A, N>, N>>::Interpolant>],
    /// The two interpolants, made when they are asked for; of the coarse one also whether there is one.
    dense: Option<<M as Method<Packed<Sys, P, A, N>, N>>::Interpolant>,
    coarse: Option<Option<<M as Method<Packed<Sys, P, A, N>, N>>::Interpolant>>,
    looked: &'a mut [Looked<P, A, N>; 2],
}

impl<'a, Sys, M, P, A, const N: usize> Course<'a, Sys, M, P, A, N>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    M: Method<Packed<Sys, P, A, N>, N, MethodState: Lanewise<LANES>>,
    M: Method<
            Alone<Sys, P, A, N>,
            N,
            MethodState = <<M as Method<Packed<Sys, P, A, N>, N>>::MethodState as Lanewise<LANES>>::Element,
        >,
{
    #[inline(always)]
    pub fn new(
        method: &'a M,
        system: &'a Packed<Sys, P, A, N>,
        memory: &'a <M as Method<Packed<Sys, P, A, N>, N>>::MethodState,
        step: &'a Step<Packed<Sys, P, A, N>, M, N>,
        own: &'a [Own<<M as Method<Alone<Sys, P, A, N>, N>>::Interpolant>],
        looked: &'a mut [Looked<P, A, N>; 2],
    ) -> Self {
        looked.iter_mut().for_each(Vec::clear);
        Course { method, system, memory, step, own, dense: None, coarse: None, looked }
    }

    fn interpolate(&self, coarse: bool) -> Option<<M as Method<Packed<Sys, P, A, N>, N>>::Interpolant> {
        A::call(Interpolate { method: self.method, system: self.system, step: self.step, coarse })
    }

    /// Makes an interpolant, the dense one if there is no coarse one: returns which.
    pub fn make(&mut self, which: Which) -> Which {
        if which == Which::Coarse {
            if self.coarse.is_none() {
                self.coarse = Some(self.interpolate(true));
            }
            if matches!(self.coarse, Some(Some(_))) {
                return which;
            }
        }
        if self.dense.is_none() {
            self.dense = self.interpolate(false);
        }
        Which::Dense
    }

    fn made(&self, which: Which) -> Option<&<M as Method<Packed<Sys, P, A, N>, N>>::Interpolant> {
        match which {
            Which::Dense => self.dense.as_ref(),
            Which::Coarse => self.coarse.as_ref()?.as_ref(),
        }
    }

    /// The states of all lanes at these times, after [`make`](Self::make).
    pub fn at(&self, which: Which, t: Lanes<LANES, P, A>) -> Option<State<Lanes<LANES, P, A>, N>> {
        self.made(which).map(|dense| A::call(At::<_, _, N> { dense, t }))
    }

    /// Equal parts of the step of a lane at whose ends events are looked at.
    pub fn parts(&self, lane: usize) -> u32 {
        let h = SingleLane::new(self.step.h.as_array()[lane]);
        <M as Method<Alone<Sys, P, A, N>, N>>::parts(self.method, &self.memory.lane(lane), h)
    }

    /// Looks at the states of all lanes at the parts of the finest division of their steps. (Those that depend on the
    /// step are powers of two, and each lane's are among the finest.) Returns of which interpolant.
    pub fn look(&mut self, which: Which) -> Which {
        let which = self.make(which);
        if self.looked[which as usize].is_empty() {
            let parts = (0..LANES).map(|lane| self.parts(lane)).filter(|parts| *parts <= MOST_PARTS);
            for x in Grid::new(parts.max().unwrap_or(1), false, f64::EPSILON).places() {
                let at = self.at(which, self.step.h.mul_add(Lanes::splat(x), self.step.from.t));
                self.looked[which as usize].extend(at.map(|at| (x, at)));
            }
        }
        which
    }

    /// The interpolants of a lane whose step was made alone.
    pub fn own(&self, lane: usize) -> Option<&Own<<M as Method<Alone<Sys, P, A, N>, N>>::Interpolant>> {
        self.own.iter().find(|own| own.lane == lane)
    }

    /// The state of a lane whose step was made alone at a time.
    pub fn own_at(
        &self,
        own: &Own<<M as Method<Alone<Sys, P, A, N>, N>>::Interpolant>,
        which: Which,
        t: f64,
    ) -> Option<State<SingleLane<P, A>, N>> {
        let dense = own.coarse.as_ref().filter(|_| which == Which::Coarse).or(own.dense.as_ref())?;
        Some(A::call(At::<_, _, N> { dense, t: SingleLane::new(t) }))
    }

    /// The state of a lane at a part of its step, after [`look`](Self::look); that of its end if there is no
    /// interpolant.
    pub fn between(&self, which: Which, lane: usize, x: f64) -> State<SingleLane<P, A>, N> {
        let time = || P::mul_add(self.step.h.as_array()[lane], x, self.step.from.t.as_array()[lane]);
        let found = match self.own(lane) {
            Some(own) => self.own_at(own, which, time()),
            None => match self.looked[which as usize].iter().find(|(place, _)| *place == x) {
                Some((_, at)) => Some(at.lane(lane)),
                None => self.at(which, Lanes::splat(time())).map(|at| at.lane(lane)),
            },
        };
        found.unwrap_or_else(|| self.step.to.lane(lane))
    }
}

/// Step of one lane, as its observer sees it.
pub struct Inside<'a, const N: usize> {
    pub ends: [State<f64, N>; 2],
    pub h: f64,
    pub parts: u32,
    pub between: &'a dyn Fn(f64) -> State<f64, N>,
    pub stepped: &'a dyn Fn(f64) -> Result<State<f64, N>, Failure>,
}

impl<const N: usize> Within<f64, N> for Inside<'_, N> {
    fn parts(&self) -> u32 {
        self.parts
    }

    fn ends(&self) -> [State<f64, N>; 2] {
        self.ends
    }

    fn size(&self) -> f64 {
        self.h
    }

    fn between(&self, x: f64) -> State<f64, N> {
        (self.between)(x)
    }
}

impl<const N: usize> Motion<N> for Inside<'_, N> {
    fn stepped(&self, x: f64) -> Result<State<f64, N>, Failure> {
        (self.stepped)(x)
    }
}
