//! The loop over the leaves of a study: threads, progress, checkpoints, and where it ends.

use super::checkpoint::{Checkpoint, Reached};
use super::failures::FailedSample;
use super::stopwatch::Stopwatch;
use super::{EnsembleError, LEAF, Progress, Record, Statistic};
use core::ops::Range;
use core::time::Duration;
use rayon::prelude::*;

/// Statistic of some samples, and those of them that failed.
pub type Part<T, F> = (T, Vec<F>);

/// A sample that failed, known by its index.
pub trait Indexed: Send {
    fn index(&self) -> u64;
}

impl<S: Send, const N: usize> Indexed for FailedSample<S, N> {
    fn index(&self) -> u64 {
        self.index
    }
}

/// The way samples are computed: one by one, side by side, or by several models.
pub trait Compute<O>: Sync {
    /// Leaves that are computed together.
    const GROUP: u64;

    /// A sample that failed.
    type Failed: Indexed;

    /// Each of these leaves.
    fn leaves<T: Statistic<O>>(&self, leaves: Range<u64>, statistic: &T)
    -> Vec<Part<T::State, Self::Failed>>;

    /// The failure of one sample, if it fails.
    fn failure(&self, index: u64) -> Option<Self::Failed>;

    /// Description that tells it from other ways, if its answer is another one.
    fn describe(&self) -> Option<String> {
        None
    }
}

/// The samples of some leaves, of which there are `all`.
pub fn samples(leaves: Range<u64>, all: u64) -> Range<u64> {
    leaves.start.saturating_mul(LEAF).min(all)..leaves.end.saturating_mul(LEAF).min(all)
}

/// Parts of the leaves of all outputs in a row, some of which come with a failure.
pub fn parts<O, T: Statistic<O>, F>(
    leaves: Range<u64>,
    statistic: &T,
    outputs: impl IntoIterator<Item = (u64, O, Option<F>)>,
) -> Vec<Part<T::State, F>> {
    let mut outputs = outputs.into_iter();
    let part = |_| {
        let (mut state, mut lost) = (statistic.empty(), vec![]);
        for (index, output, failed) in outputs.by_ref().take(LEAF as usize) {
            statistic.add(&mut state, index, &output);
            lost.extend(failed);
        }
        (state, lost)
    };
    leaves.map(part).collect()
}

/// The larger of two numbers of leaves.
pub const fn larger(a: u64, b: u64) -> u64 {
    if a > b { a } else { b }
}

pub type Tell<'p> = Box<dyn Fn(&Progress) + 'p>;

/// Number of samples, and how a study gets through them.
pub struct Driver<'a, 'p> {
    pub samples: u64,
    pub threads: Option<usize>,
    pub checkpoint: Option<&'a Checkpoint>,
    pub progress: Option<&'a Tell<'p>>,
    pub keep_failures: usize,
}

/// Hooks into the loop: every leaf as it is done, and where the loop pauses or ends.
pub trait Course<T> {
    /// Shows a leaf, in their order, before it is merged.
    fn each(&mut self, leaf: &mut T) -> Result<(), EnsembleError> {
        let _ = leaf;
        Ok(())
    }

    /// The leaf before which to ask again; `None` ends the study. A pure function of what has been reached: a study
    /// that was resumed asks at other leaves, too.
    fn next(&mut self, reached: &Reached<T>) -> Result<Option<u64>, EnsembleError> {
        Ok((reached.next < reached.end).then_some(reached.end))
    }
}

/// All leaves, without a pause.
pub struct Through;

impl<T> Course<T> for Through {}

impl Driver<'_, '_> {
    /// Computes these leaves, or as many of them as the course wants. The description tells the study from others.
    pub fn drive<O, T, H>(
        &self,
        how: &H,
        statistic: &T,
        description: &[String],
        leaves: Range<u64>,
        course: &mut impl Course<T::State>,
    ) -> Result<Part<Reached<T::State>, H::Failed>, EnsembleError>
    where
        T: Statistic<O>,
        H: Compute<O>,
    {
        statistic.check().map_err(EnsembleError::Statistic)?;
        let pool = self.pool()?;
        let mut reached = self.resume(description, leaves)?;
        let mut pause = course.next(&reached)?;
        // After the course has been asked, from which the way of computing may learn.
        let mut kept = match self.checkpoint {
            Some(checkpoint) => self.again(how, checkpoint, &reached.kept, 0)?,
            None => vec![],
        };

        let samples = self.samples;
        let resumed = reached.done(samples);
        let (began, mut saved) = (Stopwatch::start(), Stopwatch::start());
        let threads = pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads) as u64;
        let mut pace = Pace::new(threads, H::GROUP);
        while let Some(border) = pause {
            let end = reached.next.saturating_add(pace.groups.saturating_mul(H::GROUP));
            let round = reached.next..end.min(border).min(reached.end);
            let start = Stopwatch::start();
            let group = |group: u64| {
                let first = round.start + group * H::GROUP;
                how.leaves(first..round.end.min(first + H::GROUP), statistic)
            };
            let groups = (round.end - round.start).div_ceil(H::GROUP);
            let done = all_of(pool.as_ref(), groups, &group);
            pace.took(start.elapsed());
            for (leaf, (mut state, failed)) in round.clone().zip(done.into_iter().flatten()) {
                course.each(&mut state)?;
                reached.tree.push(leaf, state, |earlier, later| statistic.merge(earlier, later));
                reached.failed += failed.len() as u64;
                let room = self.keep_failures.saturating_sub(kept.len());
                kept.extend(failed.into_iter().take(room));
            }
            reached.next = round.end;
            reached.kept = kept.iter().map(Indexed::index).collect();
            if reached.next == border || reached.next == reached.end {
                pause = course.next(&reached)?;
            }
            if let Some(checkpoint) = self.checkpoint
                && (saved.elapsed() >= checkpoint.every || pause.is_none())
            {
                checkpoint.write(description, &reached)?;
                saved = Stopwatch::start();
            }
            if let Some(tell) = self.progress {
                let (done, samples) = (reached.done(samples), reached.samples(samples));
                tell(&Progress { done, samples, failed: reached.failed, resumed, elapsed: began.elapsed() });
            }
        }
        Ok((reached, kept))
    }

    /// The threads; none where this one does it alone, and need not wait for another to wake up.
    pub fn pool(&self) -> Result<Option<rayon::ThreadPool>, EnsembleError> {
        if self.threads == Some(1) {
            return Ok(None);
        }
        rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0))
            .build()
            .map(Some)
            .map_err(|error| EnsembleError::Threads(error.to_string()))
    }

    /// The progress from which the study begins: its checkpoint, if there is one.
    fn resume<R: Record>(
        &self,
        description: &[String],
        leaves: Range<u64>,
    ) -> Result<Reached<R>, EnsembleError> {
        let nothing = Reached::nothing(leaves);
        let Some(checkpoint) = self.checkpoint else { return Ok(nothing) };
        let reached = checkpoint
            .read(description, self.samples)?
            .unwrap_or_else(|| Reached::nothing(nothing.first..nothing.end));
        if (reached.first, reached.end) != (nothing.first, nothing.end) {
            let leaves = |first: u64, end: u64| format!("leaves {first} to {end}");
            return Err(
                checkpoint.of_another(leaves(reached.first, reached.end), leaves(nothing.first, nothing.end))
            );
        }
        checkpoint.write(description, &reached)?;
        Ok(reached)
    }

    /// The failed samples of a checkpoint, computed again, as long as there is room beside those that are there.
    pub fn again<O, H: Compute<O>>(
        &self,
        how: &H,
        checkpoint: &Checkpoint,
        kept: &[u64],
        there: usize,
    ) -> Result<Vec<H::Failed>, EnsembleError> {
        let room = self.keep_failures.saturating_sub(there);
        let again = |&index: &u64| {
            how.failure(index).ok_or_else(|| {
                checkpoint
                    .of_another(format!("sample {index} failed"), format!("sample {index} does not fail"))
            })
        };
        kept.iter().take(room).map(again).collect()
    }
}

/// Number of groups of leaves to give to the threads at a time: as take some tenths of a second. They wait for each
/// other at the end of a round, so short rounds waste time; after long ones checkpoints and progress come late. A
/// round keeps what came of all its leaves, so that there are not more of them than 1024 a thread, however short they
/// are.
struct Pace {
    groups: u64,
    least: u64,
    most: u64,
}

impl Pace {
    fn new(threads: u64, leaves: u64) -> Self {
        Pace { groups: threads, least: threads, most: threads * (1024 / leaves).max(1) }
    }

    fn took(&mut self, time: Duration) {
        if time < Duration::from_millis(150) {
            self.groups = (2 * self.groups).min(self.most);
        } else if time > Duration::from_millis(600) {
            self.groups = (self.groups / 2).max(self.least);
        }
    }
}

/// Each of so many groups, by the threads of the pool. It does not know of methods and systems: threads take long to
/// compile.
pub fn all_of<G: Send>(
    pool: Option<&rayon::ThreadPool>,
    groups: u64,
    group: &(dyn Fn(u64) -> G + Sync),
) -> Vec<G> {
    match pool {
        Some(pool) => pool.install(|| (0..groups).into_par_iter().map(group).collect()),
        None => (0..groups).map(group).collect(),
    }
}
