//! Ensembles on the ranks of MPI.

use super::checkpoint::{Checkpoint, encode};
use super::drive::{Compute, Through};
use super::{EnsembleError, FailedSample, Lost, OneByOne, Outcome, Source, Statistic, Study};
use crate::controller::Controller;
use crate::integrate::Run;
use crate::method::Method;
use crate::scalar::Real;
use crate::state::State;
use crate::system::System;
use core::fmt;
use core::time::Duration;
use mpi::traits::{Communicator, Destination, Source as _};
use std::path::PathBuf;

impl<Src, D, Sys, M, C, const N: usize> Study<'_, Src, D, Sys, M, C, N>
where
    Src: Source,
    Sys: System<N>,
    Sys::Scalar: Real + Send + Sync,
    M: Method<Sys, N> + Clone + Sync + fmt::Debug,
    C: Controller<Sys::Scalar, N, M::Error> + Sync + fmt::Debug,
    D: Fn(Src::Draw) -> (Sys, State<Sys::Scalar, N>) + Sync,
{
    /// Reduces as [`reduce`](Self::reduce), on all ranks of `world`, each of which takes an equal range of samples
    /// and has threads of its own. Rank 0 is given the outcome, which has the bits of a single process; the others
    /// are given `None`.
    ///
    /// Each rank sends rank 0 one message at its end, the statistics of its samples: some kilobytes, whatever their
    /// number. With a [checkpoint](Self::checkpoint) each rank has its own, beside the path that was given, with the
    /// rank and the number of ranks appended: the same number of ranks resumes from there. Started with more than one
    /// thread, MPI has to be initialised with `Threading::Funneled`.
    ///
    /// # Errors
    /// As [`reduce`](Self::reduce), on the rank where it happens; rank 0 then says that one is missing.
    pub fn reduce_on_ranks<O, T, K>(
        &self,
        world: &impl Communicator,
        watch: K,
        statistic: T,
    ) -> Result<Option<Outcome<T::State, Sys::Scalar, N>>, EnsembleError>
    where
        T: Statistic<O>,
        K: Fn(&Sys, Run<'_, Sys, M, C, N>) -> Result<O, Lost<Sys::Scalar, N>> + Sync,
    {
        self.on_ranks(world, &OneByOne { recipe: &self.recipe, watch: &watch }, &statistic)
    }

    pub(super) fn on_ranks<O, T, H>(
        &self,
        world: &impl Communicator,
        how: &H,
        statistic: &T,
    ) -> Result<Option<Outcome<T::State, Sys::Scalar, N>>, EnsembleError>
    where
        T: Statistic<O>,
        H: Compute<O, Failed = FailedSample<Sys::Scalar, N>>,
    {
        let (rank, ranks) = (world.rank(), world.size());
        let checkpoint = self.checkpoint.as_ref().map(|Checkpoint { path, every }| {
            let mut path = path.clone().into_os_string();
            path.push(format!(".{rank}-of-{ranks}"));
            Checkpoint { path: path.into(), every: *every }
        });
        let leaves = self.leaves_of(rank as u64, ranks as u64);
        let mine = self.drive(how, statistic, leaves, checkpoint.as_ref(), &mut Through);
        if rank != 0 {
            // A rank without a result says so by an empty message, for which rank 0 would otherwise wait for ever.
            let message = mine
                .as_ref()
                .map_or(vec![], |(reached, _)| encode(&self.description(statistic, how), reached));
            world.process_at_rank(0).send(&message[..]);
            return mine.map(|_| None);
        }
        let messages: Vec<Vec<u8>> =
            (1..ranks).map(|rank| world.process_at_rank(rank).receive_vec::<u8>().0).collect();
        let (reached, _) = mine?;
        let description = self.description(statistic, how);
        let of_rank = |rank: usize| Checkpoint {
            path: PathBuf::from(format!("the result of rank {rank}")),
            every: Duration::MAX,
        };
        let mut parts = vec![(of_rank(0), reached)];
        for (rank, message) in messages.iter().enumerate() {
            let from = of_rank(rank + 1);
            if message.is_empty() {
                return Err(EnsembleError::Shards(format!("rank {} has none, see its own error", rank + 1)));
            }
            let reached = from.decode(message, &description, self.recipe.ensemble.samples)?;
            parts.push((from, reached));
        }
        self.whole(how, parts, statistic).map(Some)
    }
}
