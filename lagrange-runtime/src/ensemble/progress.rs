//! Progress of a study.

use std::fmt;
use std::time::Duration;

/// Progress of a study: samples done, rate, and time left. It is shown as one line.
///
/// ```
/// use lagrange_runtime::ensemble::Progress;
/// use std::time::Duration;
/// let progress =
///     Progress { done: 3000, samples: 4000, failed: 2, resumed: 1000, elapsed: Duration::from_secs(8) };
/// assert_eq!((progress.rate(), progress.left()), (Some(250.0), Some(Duration::from_secs(4))));
/// assert_eq!(progress.to_string(), "3000 of 4000 samples (75.0 %), 2 failed, 250 samples/s, 4.0 s left");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Samples that are done, failed ones included.
    pub done: u64,
    /// All samples.
    pub samples: u64,
    /// Samples that failed.
    pub failed: u64,
    /// Samples of `done` that a checkpoint had.
    pub resumed: u64,
    /// Time since this run began.
    pub elapsed: Duration,
}

impl Progress {
    /// Samples a second in this run; `None` before the first.
    pub fn rate(&self) -> Option<f64> {
        let rate = self.done.saturating_sub(self.resumed) as f64 / self.elapsed.as_secs_f64();
        (rate > 0.0 && rate.is_finite()).then_some(rate)
    }

    /// The time left at this rate.
    pub fn left(&self) -> Option<Duration> {
        Duration::try_from_secs_f64(self.samples.saturating_sub(self.done) as f64 / self.rate()?).ok()
    }
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = 100.0 * self.done as f64 / self.samples as f64;
        write!(f, "{} of {} samples ({percent:.1} %)", self.done, self.samples)?;
        if self.failed > 0 {
            write!(f, ", {} failed", self.failed)?;
        }
        if let Some((rate, left)) = self.rate().zip(self.left()) {
            write!(f, ", {rate:.0} samples/s, {:.1} s left", left.as_secs_f64())?;
        }
        Ok(())
    }
}
