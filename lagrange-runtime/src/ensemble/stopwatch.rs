//! Time since a moment. A page in a browser has no clock of the standard library, where `Instant::now` panics: there
//! no time goes by, and the page, which has a clock, measures for itself.

use core::time::Duration;

const HAS_CLOCK: bool = !cfg!(all(target_family = "wasm", target_os = "unknown"));

/// Moment at which it was started.
pub(super) struct Stopwatch(Option<std::time::Instant>);

impl Stopwatch {
    pub fn start() -> Self {
        Stopwatch(HAS_CLOCK.then(std::time::Instant::now))
    }

    pub fn elapsed(&self) -> Duration {
        self.0.map_or(Duration::ZERO, |start| start.elapsed())
    }
}
