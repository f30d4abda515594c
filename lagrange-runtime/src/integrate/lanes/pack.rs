//! Lanes and the runs in them.

use super::job::{Job, LANES, Packed};
use crate::failed::Statistics;
use crate::failure::Cause;
use crate::integrate::memories::DoubleBuffer;
use crate::integrate::switches::Approach;
use crate::lanes::{Lanes, Lanewise, Plain, Policy, Processor, Rescale, SingleLane};
use crate::state::State;

/// A run, and what is observed of it.
pub struct Occupant<Sys, T, const N: usize> {
    pub job: Job<Sys, N>,
    pub watched: T,
}

macro_rules! paces {
    ($($(#[$doc:meta])* $field:ident: $type:ty = $none:expr;)*) => {
        /// Time and steps of a run, as the fields of `Engine`.
        #[derive(Clone, Copy, Debug)]
        pub struct Pace {
            $($(#[$doc])* pub $field: $type,)*
        }

        /// Time and steps of the runs in lanes.
        #[derive(Clone, Copy, Debug)]
        pub struct Paces {
            $(pub $field: [$type; LANES],)*
        }

        impl Pace {
            pub const NONE: Pace = Pace { $($field: $none),* };
        }

        impl Paces {
            fn splat(pace: Pace) -> Self {
                Paces { $($field: [pace.$field; LANES]),* }
            }

            fn lane(&self, lane: usize) -> Pace {
                Pace { $($field: self.$field[lane]),* }
            }

            fn put(&mut self, lane: usize, pace: &Pace) {
                $(self.$field[lane] = pace.$field;)*
            }
        }
    };
}

paces! {
    h: f64 = 0.0;
    origin: f64 = 0.0;
    count: f64 = 0.0;
    total: f64 = f64::INFINITY;
    longest: f64 = 0.0;
    bound: f64 = f64::INFINITY;
    /// The time of the next step to a little beyond an event that ends the run.
    aim: f64 = f64::INFINITY;
    approach: Approach = Approach::NONE;
    cause: Option<Cause> = None;
    /// The last step ended at a switch.
    stopped: bool = false;
    /// Accepted steps, equal ones that ended at their times not counted, and rejected ones.
    accepted: u64 = 0;
    rejected: u64 = 0;
    /// Attempted steps; in a lane those of the pack less those of the run.
    attempts: u64 = 0;
    /// Evaluations, in the same way.
    evaluations: u64 = 0;
}

/// A run on its way into a lane.
pub struct Entry<Sys, T, C, S, Memory, const N: usize> {
    pub occupant: Occupant<Sys, T, N>,
    pub state: State<S, N>,
    pub memory: Memory,
    pub controller: C,
    pub pace: Pace,
}

/// Lanes and the runs in them.
pub struct Pack<Sys, P: Policy, A: Processor, C, Memory, T, const N: usize>
where
    Sys: Rescale<N, Scalar = f64>,
{
    parameters: Parameters,
    pub system: Packed<Sys, P, A, N>,
    pub state: State<Lanes<LANES, P, A>, N>,
    pub memories: DoubleBuffer<Memory>,
    pub variable: Memory,
    pub controllers: [C; LANES],
    pub occupants: [Option<Occupant<Sys, T, N>>; LANES],
    pub live: [bool; LANES],
    pub paces: Paces,
    /// There are lanes whose step has met a failure that has a cause, or ended at a switch: looking at single flags
    /// in each step takes a fifth of RK4's time.
    pub caused: bool,
    pub interrupted: bool,
    /// Steps that it has attempted, and their evaluations.
    pub attempts: u64,
    pub evaluations: u64,
    /// Its lanes are not filled again: they look for events in one step each.
    pub searches: bool,
}

type EntryOf<Sys, P, A, C, Memory, T, const N: usize> =
    Entry<Sys, T, C, SingleLane<P, A>, <Memory as Lanewise<LANES>>::Element, N>;

impl<Sys, P, A, C, Memory, T, const N: usize> Pack<Sys, P, A, C, Memory, T, N>
where
    Sys: Rescale<N, Scalar = f64>,
    P: Policy,
    A: Processor,
    C: Clone,
    Memory: Lanewise<LANES>,
{
    /// Lanes that wait for runs: they compute on copies of this one, by steps of size 0.
    pub fn like(entry: &EntryOf<Sys, P, A, C, Memory, T, N>, searches: bool) -> Self {
        let mut parameters = Parameters::of(&entry.occupant.job.system);
        let memory = Memory::splat(&entry.memory);
        Pack {
            system: parameters.put(0, &entry.occupant.job.system),
            parameters,
            state: Lanewise::splat(&entry.state),
            variable: memory.clone(),
            memories: DoubleBuffer::new(memory),
            controllers: core::array::from_fn(|_| entry.controller.clone()),
            occupants: [const { None }; LANES],
            live: [false; LANES],
            paces: Paces::splat(Pace::NONE),
            caused: false,
            interrupted: false,
            attempts: 0,
            evaluations: 0,
            searches,
        }
    }

    /// Puts a run into a lane.
    pub fn enter(&mut self, lane: usize, entry: EntryOf<Sys, P, A, C, Memory, T, N>) {
        let Entry { occupant, state, memory, controller, mut pace } = entry;
        self.system = self.parameters.beside(&self.occupants, lane, &occupant.job.system);
        self.state.put(lane, &state);
        self.memories.now_mut().put(lane, &memory);
        self.controllers[lane] = controller;
        pace.attempts = self.attempts.wrapping_sub(pace.attempts);
        pace.evaluations = self.evaluations.wrapping_sub(pace.evaluations);
        self.paces.put(lane, &pace);
        self.caused |= pace.cause.is_some();
        self.interrupted |= pace.stopped;
        (self.occupants[lane], self.live[lane]) = (Some(occupant), true);
    }

    /// The time and steps of the run of a lane.
    pub fn pace(&self, lane: usize) -> Pace {
        let mut pace = self.paces.lane(lane);
        pace.attempts = self.attempts.wrapping_sub(pace.attempts);
        pace.evaluations = self.evaluations.wrapping_sub(pace.evaluations);
        pace
    }

    /// The cost of the run of a lane.
    pub fn statistics(&self, lane: usize) -> Statistics {
        let Pace { count, accepted, rejected, evaluations, .. } = self.pace(lane);
        Statistics { accepted: accepted + count as u64, rejected, evaluations }
    }

    /// Gives a lane what it had before a step that is to be made again, of so many attempts and evaluations.
    pub fn restore(
        &mut self,
        lane: usize,
        paces: &Paces,
        controller: C,
        (attempts, evaluations): (u64, u64),
    ) {
        self.paces.put(lane, &paces.lane(lane));
        self.paces.attempts[lane] = paces.attempts[lane].wrapping_add(attempts);
        self.paces.evaluations[lane] = paces.evaluations[lane].wrapping_add(evaluations);
        self.controllers[lane] = controller;
    }

    /// Takes the run out of a lane, which waits.
    pub fn take(&mut self, lane: usize) -> Option<EntryOf<Sys, P, A, C, Memory, T, N>> {
        let occupant = self.occupants[lane].take()?;
        let pace = self.pace(lane);
        (self.live[lane], self.paces.h[lane]) = (false, 0.0);
        let (state, memory) = (self.state.lane(lane), self.memories.now().lane(lane));
        Some(Entry { occupant, state, memory, controller: self.controllers[lane].clone(), pace })
    }

    /// Lets a lane without a run compute on a copy of another one.
    pub fn idle(&mut self, lane: usize) {
        if let Some((other, Some(occupant))) =
            self.occupants.iter().enumerate().find(|(_, occupant)| occupant.is_some())
        {
            self.system = self.parameters.beside(&self.occupants, lane, &occupant.job.system);
            let (copied, remembered) = (self.state.lane(other), self.memories.now().lane(other));
            self.state.put(lane, &copied);
            self.memories.now_mut().put(lane, &remembered);
        }
    }
}

/// The parameters of the systems in the lanes, in the order of [`Rescale::over`].
struct Parameters(Vec<[f64; LANES]>);

impl Parameters {
    /// The parameters of `system` in all lanes.
    fn of<Sys: Rescale<N, Scalar = f64>, const N: usize>(system: &Sys) -> Self {
        let mut values = vec![];
        let _ = system.over(|x| {
            values.push([x; LANES]);
            SingleLane::<Plain>::new(x)
        });
        Parameters(values)
    }

    /// Gives a lane those of `system`, and what comes of it all: the systems side by side.
    fn put<Sys, P, A, const N: usize>(&mut self, lane: usize, system: &Sys) -> Packed<Sys, P, A, N>
    where
        Sys: Rescale<N, Scalar = f64>,
        P: Policy,
        A: Processor,
    {
        let mut values = self.0.iter_mut();
        system.over(|x| {
            let all = values.next().map(|all| {
                all[lane] = x;
                *all
            });
            Lanes::new(all.unwrap_or([x; LANES]))
        })
    }

    /// The same with the data of the functions of each system, whose lanes the occupants have.
    fn beside<Sys, T, P, A, const N: usize>(
        &mut self,
        occupants: &[Option<Occupant<Sys, T, N>>; LANES],
        lane: usize,
        system: &Sys,
    ) -> Packed<Sys, P, A, N>
    where
        Sys: Rescale<N, Scalar = f64>,
        P: Policy,
        A: Processor,
    {
        let mut packed = self.put(lane, system);
        for (other, occupant) in occupants.iter().enumerate() {
            if let Some(Occupant { job, .. }) = occupant {
                job.system.set_lane(&mut packed, other);
            }
        }
        system.set_lane(&mut packed, lane);
        packed
    }
}
