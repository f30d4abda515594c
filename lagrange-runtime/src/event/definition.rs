//! Definition of an event: a function of the state, the direction of its roots, and whether the run ends there.

use crate::failure::EventName;
use crate::scalar::Scalar;
use crate::state::State;
use crate::system::System;
use core::fmt;
use core::marker::PhantomData;
use nalgebra::SVector;

/// Direction of the roots of g that are occurrences. Rising and falling are meant in the direction of the run, which
/// may be backward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
    /// Both, and zeros that are touched and not crossed.
    Either,
}

/// An event: a function g, and which of its roots matter. g is a closure of the state, or a [`Compiled`] function of
/// the system: the statement `event ground: y, falling, terminal;` of [`lagrangian!`](crate::lagrangian!) makes the
/// constant `GROUND` of the type.
///
/// ```
/// use lagrange_runtime::{Event, State};
/// let turning = Event::either(|s: &State<f64, 2>| s.qd[0]).named("turning point");
/// let upright = Event::rising(|s: &State<f64, 2>| s.q[1].sin()).terminal();
/// ```
///
/// (Where the event is given to [`Run::events`](crate::Run::events) at once, `|s|` will do.)
#[derive(Clone, Copy)]
pub struct Event<G> {
    g: G,
    kind: EventKind,
}

/// Properties of an event besides its function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventKind {
    /// Its name, empty unless given.
    pub name: &'static str,
    /// Direction of the roots that are occurrences.
    pub direction: Direction,
    /// True if the run ends there.
    pub terminal: bool,
    /// The largest |g| at an extremum that counts as a touch, rounding apart, in the unit of g.
    pub touching: f64,
}

impl EventKind {
    /// A hash of these properties, the same in every program (Fowler, Noll and Vo's).
    pub(crate) fn hash(&self) -> u64 {
        let rest = [self.direction as u8, u8::from(self.terminal)];
        let bytes = self.name.bytes().chain(rest).chain(self.touching.to_bits().to_le_bytes());
        bytes
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    /// The event of these properties, as failures speak of it.
    pub(crate) fn at(&self, index: usize) -> EventName {
        EventName { index, name: self.name }
    }
}

impl<G> Event<G> {
    /// An event where `g` passes from negative to positive.
    pub fn rising<const N: usize>(g: G) -> Self
    where
        G: Fn(&State<f64, N>) -> f64,
    {
        Event::new(Direction::Rising, g)
    }

    /// An event where `g` passes from positive to negative.
    pub fn falling<const N: usize>(g: G) -> Self
    where
        G: Fn(&State<f64, N>) -> f64,
    {
        Event::new(Direction::Falling, g)
    }

    /// An event where `g` vanishes.
    pub fn either<const N: usize>(g: G) -> Self
    where
        G: Fn(&State<f64, N>) -> f64,
    {
        Event::new(Direction::Either, g)
    }

    /// The event of the given direction, in numbers of any type:
    /// `Event::new(Direction::Rising, |s: &State<f32, 1>| …)`. (That of the three others is fixed, so that the
    /// compiler knows what `s` is.)
    pub fn new<S, const N: usize>(direction: Direction, g: G) -> Self
    where
        G: Fn(&State<S, N>) -> S,
    {
        Event { g, kind: EventKind { name: "", direction, terminal: false, touching: 0.0 } }
    }

    /// g at a state of the system, in the unit of the event's function.
    pub fn value<Sys: System<N>, const N: usize>(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
    ) -> Sys::Scalar
    where
        G: EventFunction<Sys, N>,
    {
        self.g.value(system, at)
    }

    /// The rest of the event.
    pub fn kind(&self) -> EventKind {
        self.kind
    }

    /// The run ends at this event, on a state as accurate as the ends of its steps, and may be restarted there.
    pub fn terminal(mut self) -> Self {
        self.kind.terminal = true;
        self
    }

    /// Gives the event a name, by which its occurrences are distinguished from those of other events.
    pub fn named(mut self, name: &'static str) -> Self {
        self.kind.name = name;
        self
    }

    /// An extremum of g at which `|g| ≤ distance`, in the unit of g, counts as a touch, which only events of either
    /// direction report.
    pub fn touching(mut self, distance: f64) -> Self {
        self.kind.touching = distance;
        self
    }
}

impl<Of> Event<Compiled<Of>> {
    /// The event of this index of a system.
    #[doc(hidden)]
    pub const fn compiled(index: usize, name: &'static str, direction: Direction, terminal: bool) -> Self {
        Event {
            g: Compiled { index, of: PhantomData },
            kind: EventKind { name, direction, terminal, touching: 0.0 },
        }
    }
}

impl<G> fmt::Debug for Event<G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Event").field("kind", &self.kind).finish_non_exhaustive()
    }
}

/// g of an event of the system type `Of`, written in its definition. It reads the parameters and inputs of the system
/// that moves, so that one constant serves every run, stepper, sample and lane.
pub struct Compiled<Of> {
    index: usize,
    of: PhantomData<fn() -> Of>,
}

impl<Of> Clone for Compiled<Of> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<Of> Copy for Compiled<Of> {}

impl<Of> fmt::Debug for Compiled<Of> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Compiled").field("index", &self.index).finish()
    }
}

/// Systems with events in their definition.
#[diagnostic::on_unimplemented(
    message = "the definition of `{Self}` has no events",
    note = "an event is written `event name: g;` in `lagrangian! {{ … }}`, or as a closure, `Event::rising(|at| …)`"
)]
pub trait CompiledEvents<const N: usize>: System<N> {
    /// The system over `f64`, which has the events as constants.
    type Of;

    /// The function g(q, q̇, t) of the event of this index, in its own unit.
    fn event_value(&self, event: usize, at: &State<Self::Scalar, N>) -> Self::Scalar;

    /// The rates ġ and g̈ of the event along a motion with the accelerations q̈, in the unit of g per s and per s².
    /// g̈ is known where g depends on positions and time alone; neither is where its expression would be longer than
    /// what it saves.
    fn event_rates(
        &self,
        event: usize,
        at: &State<Self::Scalar, N>,
        accelerations: &SVector<Self::Scalar, N>,
    ) -> [Option<Self::Scalar>; 2];
}

/// Function g of an event at states of `Sys`: a closure of the state, or one that the system has [`Compiled`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no event of `{Sys}`",
    note = "an event is a closure of the state, `Event::rising(|at| …)`, or one that the definition of this system has, `event name: g;`"
)]
pub trait EventFunction<Sys: System<N>, const N: usize> {
    /// g at a state, in the unit of the event's function.
    fn value(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Sys::Scalar;

    /// ġ and g̈ along a motion with these accelerations, in the unit of g per unit of t and per its square; `None` if
    /// not known.
    #[inline(always)]
    fn rates(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
        accelerations: &SVector<Sys::Scalar, N>,
    ) -> [Option<Sys::Scalar>; 2] {
        let _ = (system, at, accelerations);
        [None; 2]
    }
}

impl<Sys, G, const N: usize> EventFunction<Sys, N> for G
where
    Sys: System<N>,
    G: Fn(&State<Sys::Scalar, N>) -> Sys::Scalar,
{
    #[inline(always)]
    fn value(&self, _: &Sys, at: &State<Sys::Scalar, N>) -> Sys::Scalar {
        self(at)
    }
}

impl<Sys, Of, const N: usize> EventFunction<Sys, N> for Compiled<Of>
where
    Sys: CompiledEvents<N, Of = Of>,
{
    #[inline(always)]
    fn value(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Sys::Scalar {
        system.event_value(self.index, at)
    }

    #[inline(always)]
    fn rates(
        &self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
        accelerations: &SVector<Sys::Scalar, N>,
    ) -> [Option<Sys::Scalar>; 2] {
        system.event_rates(self.index, at, accelerations)
    }
}

/// `K` events of states of `Sys`: an [`Event`], an array of events whose functions are of one type, or a tuple of up
/// to eight. Those that `lagrangian!` has compiled are of one type.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a set of events of states of `{Sys}` with {N} coordinates",
    note = "give an `Event`, an array of events with functions of one type, or a tuple of up to eight events"
)]
pub trait EventSet<Sys: System<N>, const N: usize, const K: usize> {
    /// The function g of the event with this index at a state, in the unit of g.
    fn value(&self, system: &Sys, event: usize, at: &State<Sys::Scalar, N>) -> Sys::Scalar;

    /// ġ and g̈ of the event with this index, in the units of [`EventFunction::rates`].
    fn rates(
        &self,
        system: &Sys,
        event: usize,
        at: &State<Sys::Scalar, N>,
        accelerations: &SVector<Sys::Scalar, N>,
    ) -> [Option<Sys::Scalar>; 2];

    /// The rest of the event.
    fn kind(&self, event: usize) -> EventKind;
}

/// Events beside the system at whose states they are evaluated.
#[derive(Debug)]
pub(crate) struct On<'a, E, Sys>(pub &'a E, pub &'a Sys);

/// `K` events as functions of the state alone.
pub(crate) trait Bound<S, const N: usize, const K: usize> {
    fn value(&self, event: usize, at: &State<S, N>) -> S;
    fn rates(&self, event: usize, at: &State<S, N>, accelerations: &SVector<S, N>) -> [Option<S>; 2];
    fn kind(&self, event: usize) -> EventKind;
}

impl<S: Scalar, Sys: System<N, Scalar = S>, E: EventSet<Sys, N, K>, const N: usize, const K: usize>
    Bound<S, N, K> for On<'_, E, Sys>
{
    #[inline(always)]
    fn value(&self, event: usize, at: &State<S, N>) -> S {
        self.0.value(self.1, event, at)
    }

    #[inline(always)]
    fn rates(&self, event: usize, at: &State<S, N>, accelerations: &SVector<S, N>) -> [Option<S>; 2] {
        self.0.rates(self.1, event, at, accelerations)
    }

    #[inline(always)]
    fn kind(&self, event: usize) -> EventKind {
        self.0.kind(event)
    }
}

impl<Sys, G, const N: usize> EventSet<Sys, N, 1> for Event<G>
where
    Sys: System<N>,
    G: EventFunction<Sys, N>,
{
    #[inline]
    fn value(&self, system: &Sys, _: usize, at: &State<Sys::Scalar, N>) -> Sys::Scalar {
        self.g.value(system, at)
    }

    #[inline]
    fn rates(
        &self,
        system: &Sys,
        _: usize,
        at: &State<Sys::Scalar, N>,
        accelerations: &SVector<Sys::Scalar, N>,
    ) -> [Option<Sys::Scalar>; 2] {
        self.g.rates(system, at, accelerations)
    }

    fn kind(&self, _: usize) -> EventKind {
        self.kind
    }
}

impl<Sys, G, const N: usize, const K: usize> EventSet<Sys, N, K> for [Event<G>; K]
where
    Sys: System<N>,
    G: EventFunction<Sys, N>,
{
    #[inline]
    fn value(&self, system: &Sys, event: usize, at: &State<Sys::Scalar, N>) -> Sys::Scalar {
        self[event].g.value(system, at)
    }

    #[inline]
    fn rates(
        &self,
        system: &Sys,
        event: usize,
        at: &State<Sys::Scalar, N>,
        accelerations: &SVector<Sys::Scalar, N>,
    ) -> [Option<Sys::Scalar>; 2] {
        self[event].g.rates(system, at, accelerations)
    }

    fn kind(&self, event: usize) -> EventKind {
        self[event].kind
    }
}

macro_rules! tuples {
    ($($count:literal: [$($i:tt $g:ident),*] $last:tt $h:ident;)*) => {$(
        impl<Sys, $($g,)* $h, const N: usize> EventSet<Sys, N, $count> for ($(Event<$g>,)* Event<$h>,)
        where
            Sys: System<N>,
            $($g: EventFunction<Sys, N>,)*
            $h: EventFunction<Sys, N>,
        {
            #[inline]
            fn value(&self, system: &Sys, event: usize, at: &State<Sys::Scalar, N>) -> Sys::Scalar {
                match event {
                    $($i => self.$i.g.value(system, at),)*
                    _ => self.$last.g.value(system, at),
                }
            }

            #[inline]
            fn rates(
                &self,
                system: &Sys,
                event: usize,
                at: &State<Sys::Scalar, N>,
                accelerations: &SVector<Sys::Scalar, N>,
            ) -> [Option<Sys::Scalar>; 2] {
                match event {
                    $($i => self.$i.g.rates(system, at, accelerations),)*
                    _ => self.$last.g.rates(system, at, accelerations),
                }
            }

            fn kind(&self, event: usize) -> EventKind {
                match event {
                    $($i => self.$i.kind,)*
                    _ => self.$last.kind,
                }
            }
        }
    )*};
}

tuples! {
    1: [] 0 A;
    2: [0 A] 1 B;
    3: [0 A, 1 B] 2 C;
    4: [0 A, 1 B, 2 C] 3 D;
    5: [0 A, 1 B, 2 C, 3 D] 4 E;
    6: [0 A, 1 B, 2 C, 3 D, 4 E] 5 F;
    7: [0 A, 1 B, 2 C, 3 D, 4 E, 5 F] 6 G;
    8: [0 A, 1 B, 2 C, 3 D, 4 E, 5 F, 6 G] 7 H;
}
