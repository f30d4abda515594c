//! Survival: the part of a study to which something has not happened yet, with censoring and competing risks.

use super::Statistic;
use crate::ensemble::normal_quantile;
use crate::ensemble::record::{Record, record_fields};
use crate::event::Occurrence;
use crate::state::State;

/// Time to an event: when it happened and which one it was, or until when nothing has happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lifetime {
    /// The time t of the event, or of the end of the observation.
    pub time: f64,
    /// Index of the event; `None` if the observation was censored, that is, ended before any.
    pub cause: Option<usize>,
}

impl Lifetime {
    /// The first of the events of a trajectory, which compete; censored at its end if there are none.
    pub fn first<const N: usize>(met: &[Occurrence<f64, N>], end: &State<f64, N>) -> Self {
        match met.first() {
            Some(first) => Lifetime { time: first.state.t, cause: Some(first.event) },
            None => Lifetime { time: end.t, cause: None },
        }
    }

    /// The first occurrence of one event, whatever happens before it; censored at the end of the trajectory if there
    /// is none.
    pub fn of<const N: usize>(event: usize, met: &[Occurrence<f64, N>], end: &State<f64, N>) -> Self {
        let first = met.iter().position(|m| m.event == event);
        Lifetime::first(first.map_or(&[], |first| &met[first..]), end)
    }
}

/// Survival curve of [`Lifetime`]s that end by one of `K` causes: the product-limit estimator of Kaplan and Meier
/// (*J. Amer. Statist. Assoc.* 53, 1958) with Greenwood's variance (1926), and the cumulative incidence of each cause
/// (Aalen and Johansen, *Scand. J. Statist.* 5, 1978).
///
/// Times are counted in equal bins from `start` to `end`, so that memory does not grow with the number of samples,
/// and merging is exact. A curve has its values at the ends of bins. They are those of the exact times if no
/// observation is censored within a bin, as where all end at the same time; otherwise, one that is censored counts as
/// at risk for the whole of its bin. What is left at `end` is censored there.
///
/// ```
/// use lagrange_runtime::ensemble::{Lifetime, Statistic, Survival};
/// let survival = Survival::<1>::new(0.0, 3.0, 3);
/// let mut state = survival.empty();
/// for (index, (time, cause)) in [(0.5, Some(0)), (1.5, Some(0)), (2.0, None), (2.5, Some(0))].into_iter().enumerate() {
///     survival.add(&mut state, index as u64, &Lifetime { time, cause });
/// }
/// let curve = state.curve(0.95);
/// // 3/4, then 3/4 · 2/3, then nobody of the one who is left.
/// assert_eq!([curve[1].survival, curve[2].survival, curve[3].survival], [0.75, 0.5, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survival<const K: usize> {
    start: f64,
    end: f64,
    bins: usize,
}

impl<const K: usize> Survival<K> {
    /// Lifetimes from the time `start` on, counted up to `end`, in so many equal bins. Causes are 0 to K − 1: a
    /// lifetime that another cause has ended panics, since a curve without it would be biased.
    pub const fn new(start: f64, end: f64, bins: usize) -> Self {
        Survival { start, end, bins }
    }
}

/// Result of [`Survival`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lifetimes<const K: usize> {
    start: f64,
    end: f64,
    /// Events of each cause in each bin.
    events: Vec<[u64; K]>,
    /// Observations censored in each bin.
    censored: Vec<u64>,
    /// Events and censorings after the last bin.
    left: u64,
    invalid: u64,
}

record_fields!(Lifetimes<; K> { start, end, events, censored, left, invalid });

impl Record for Lifetime {
    fn write(&self, bytes: &mut Vec<u8>) {
        (self.time, self.cause.map(|cause| cause as u64)).write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let (time, cause): (f64, Option<u64>) = Record::read(bytes)?;
        Some(Lifetime { time, cause: cause.map(|cause| cause as usize) })
    }
}

/// One point of a survival curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surviving<const K: usize> {
    /// The time, the end of a bin.
    pub time: f64,
    /// Number of observations at risk just before the bin that ends here; at the start all.
    pub at_risk: u64,
    /// Estimate of the probability S(t) that nothing has happened by then.
    pub survival: f64,
    /// Greenwood's variance of the estimate, S² Σ d/(n (n − d)).
    pub variance: f64,
    /// Pointwise band `S ± z √variance` within [0, 1].
    pub band: [f64; 2],
    /// Cumulative incidence of each cause: the probability that it has happened by then before any other. They and S
    /// sum to 1.
    pub incidence: [f64; K],
}

impl<const K: usize> Lifetimes<K> {
    /// The number of lifetimes, censored ones included.
    pub fn count(&self) -> u64 {
        self.happened() + self.censored.iter().sum::<u64>() + self.left
    }

    /// The number of those that ended by an event before the end of the last bin.
    pub fn happened(&self) -> u64 {
        self.events.iter().flatten().sum()
    }

    /// The number of lifetimes that were left out: not finite, or before the start.
    pub fn invalid(&self) -> u64 {
        self.invalid
    }

    /// The curve at the start and the end of each bin, with a pointwise band of this probability, such as 0.95.
    pub fn curve(&self, probability: f64) -> Vec<Surviving<K>> {
        let z = normal_quantile(0.5 + 0.5 * probability);
        let mut at_risk = self.count();
        let (mut survival, mut sum, mut incidence) = (1.0, 0.0, [0.0; K]);
        let width = (self.end - self.start) / self.events.len() as f64;
        let first =
            Surviving { time: self.start, at_risk, survival, variance: 0.0, band: [1.0; 2], incidence };
        let rest = self.events.iter().zip(&self.censored).enumerate().map(|(bin, (events, censored))| {
            let (before, n, d) = (survival, at_risk, events.iter().sum::<u64>());
            if d > 0 {
                for (sum, happened) in incidence.iter_mut().zip(events) {
                    *sum += before * *happened as f64 / n as f64;
                }
                survival *= (n - d) as f64 / n as f64;
                sum += d as f64 / (n as f64 * (n - d) as f64);
            }
            at_risk = n - d - censored;
            // (Where nobody is left, the variance is 0 · ∞.)
            let variance = if survival > 0.0 { survival * survival * sum } else { 0.0 };
            let half = z * variance.sqrt();
            Surviving {
                time: self.start + width * (bin + 1) as f64,
                at_risk: n,
                survival,
                variance,
                band: [(survival - half).max(0.0), (survival + half).min(1.0)],
                incidence,
            }
        });
        core::iter::once(first).chain(rest).collect()
    }

    /// The time at the end of the first bin by which at least this part (0 to 1) has had an event; `None` if the curve
    /// does not come down so far.
    pub fn quantile(&self, part: f64) -> Option<f64> {
        self.curve(0.95).iter().find(|point| point.survival <= 1.0 - part).map(|point| point.time)
    }
}

impl<const K: usize> Statistic<Lifetime> for Survival<K> {
    type State = Lifetimes<K>;

    fn empty(&self) -> Lifetimes<K> {
        let &Survival { start, end, bins } = self;
        Lifetimes { start, end, events: vec![[0; K]; bins], censored: vec![0; bins], left: 0, invalid: 0 }
    }

    fn add(&self, state: &mut Lifetimes<K>, _index: u64, &Lifetime { time, cause }: &Lifetime) {
        let place = (time - self.start) / (self.end - self.start);
        if let Some(cause) = cause {
            assert!(
                cause < K,
                "a lifetime was ended by cause {cause}, and `Survival<{K}>` has the causes 0 to {K} − 1"
            );
        }
        if !(time.is_finite() && place >= 0.0) {
            state.invalid += 1;
            return;
        }
        // A bin has its end, and not its start, so that the curve at an end has seen what happened then.
        let bin = ((place * self.bins as f64).ceil() as usize).saturating_sub(1);
        match cause {
            _ if bin >= self.bins => state.left += 1,
            Some(cause) => state.events[bin][cause] += 1,
            None => state.censored[bin] += 1,
        }
    }

    fn merge(&self, state: &mut Lifetimes<K>, later: Lifetimes<K>) {
        for (bin, later) in state.events.iter_mut().zip(&later.events) {
            bin.iter_mut().zip(later).for_each(|(count, more)| *count += more);
        }
        state.censored.iter_mut().zip(&later.censored).for_each(|(count, more)| *count += more);
        state.left += later.left;
        state.invalid += later.invalid;
    }

    fn describe(&self) -> String {
        format!("survival of {K} causes from {:?} to {:?} in {} bins", self.start, self.end, self.bins)
    }

    fn check(&self) -> Result<(), String> {
        let Survival { start, end, bins } = *self;
        match (start.is_finite() && end.is_finite() && start < end, bins) {
            (true, 1..=1_000_000) => Ok(()),
            (true, _) => Err(format!("survival has from 1 to 1000000 bins, not {bins}")),
            (false, _) => {
                Err(format!("survival is counted from a time to a later one, not from {start:?} to {end:?}"))
            }
        }
    }
}

#[cfg(test)]
mod tests;
