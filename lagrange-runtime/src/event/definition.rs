//! Definition of an event: a function of the state, the direction of its roots, and whether the run ends there.

use crate::state::State;
use core::fmt;

/// Direction of the roots of g that are occurrences. Rising and falling are meant in the direction of the run, which may be backward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
    /// Both, and zeros that are touched and not crossed.
    Either,
}

/// An event: a function of the state, and which of its roots matter.
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
    /// The largest |g| at an extremum that counts as a touch, rounding apart.
    pub touching: f64,
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

    /// The event of the given direction, in numbers of any type: `Event::new(Direction::Rising, |s: &State<f32, 1>| …)`.
    /// (That of the three others is fixed, so that the compiler knows what `s` is.)
    pub fn new<S, const N: usize>(direction: Direction, g: G) -> Self
    where
        G: Fn(&State<S, N>) -> S,
    {
        Event { g, kind: EventKind { name: "", direction, terminal: false, touching: 0.0 } }
    }

    /// The run ends at this event, on a state as accurate as the ends of its steps, and may be restarted there.
    pub fn terminal(mut self) -> Self {
        self.kind.terminal = true;
        self
    }

    /// Gives the event a name, by which its occurrences can be told from others.
    pub fn named(mut self, name: &'static str) -> Self {
        self.kind.name = name;
        self
    }

    /// An extremum of g at which `|g| ≤ distance` counts as a touch, which only events of either direction report.
    pub fn touching(mut self, distance: f64) -> Self {
        self.kind.touching = distance;
        self
    }
}

impl<G> fmt::Debug for Event<G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Event").field("kind", &self.kind).finish_non_exhaustive()
    }
}

/// `K` events: an [`Event`], an array of events whose functions are of one type, or a tuple of up to eight.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a set of events of states with {N} coordinates",
    note = "give an `Event`, an array of events with functions of one type, or a tuple of up to eight events"
)]
pub trait EventSet<S, const N: usize, const K: usize> {
    /// The function of an event at a state.
    fn value(&self, event: usize, at: &State<S, N>) -> S;
    /// The rest of the event.
    fn kind(&self, event: usize) -> EventKind;
}

impl<S, G: Fn(&State<S, N>) -> S, const N: usize> EventSet<S, N, 1> for Event<G> {
    #[inline]
    fn value(&self, _: usize, at: &State<S, N>) -> S {
        (self.g)(at)
    }

    fn kind(&self, _: usize) -> EventKind {
        self.kind
    }
}

impl<S, G: Fn(&State<S, N>) -> S, const N: usize, const K: usize> EventSet<S, N, K> for [Event<G>; K] {
    #[inline]
    fn value(&self, event: usize, at: &State<S, N>) -> S {
        (self[event].g)(at)
    }

    fn kind(&self, event: usize) -> EventKind {
        self[event].kind
    }
}

macro_rules! tuples {
    ($($count:literal: [$($i:tt $g:ident),*] $last:tt $h:ident;)*) => {$(
        impl<S, $($g: Fn(&State<S, N>) -> S,)* $h: Fn(&State<S, N>) -> S, const N: usize> EventSet<S, N, $count>
            for ($(Event<$g>,)* Event<$h>,)
        {
            #[inline]
            fn value(&self, event: usize, at: &State<S, N>) -> S {
                match event {
                    $($i => (self.$i.g)(at),)*
                    _ => (self.$last.g)(at),
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
