//! Settings that all studies of models have.

use super::checkpoint::Checkpoint;
use super::drive::{Driver, Tell};

/// Name, threads, checkpoint and progress of a study.
#[derive(Default)]
pub struct Settings<'p> {
    pub name: String,
    pub threads: Option<usize>,
    pub checkpoint: Option<Checkpoint>,
    pub progress: Option<Tell<'p>>,
}

impl<'p> Settings<'p> {
    /// The loop over so many samples.
    pub fn driver(&self, samples: u64) -> Driver<'_, 'p> {
        Driver {
            samples,
            threads: self.threads,
            checkpoint: self.checkpoint.as_ref(),
            progress: self.progress.as_ref(),
            keep_failures: 1000,
        }
    }
}

/// The functions that set them, of a study whose field `settings` has them and whose lifetime is `'p`.
macro_rules! set_settings {
    () => {
        /// Sets the number of threads, as [`Study::threads`](super::Study::threads).
        #[must_use]
        pub fn threads(mut self, threads: usize) -> Self {
            self.settings.threads = Some(threads);
            self
        }

        /// Saves the progress of the study in a file, and resumes from it, as
        /// [`Study::checkpoint`](super::Study::checkpoint).
        #[must_use]
        pub fn checkpoint(
            mut self,
            path: impl Into<std::path::PathBuf>,
            every: core::time::Duration,
        ) -> Self {
            self.settings.checkpoint =
                Some($crate::ensemble::checkpoint::Checkpoint { path: path.into(), every });
            self
        }

        /// Gives the study a name, by which its checkpoints are distinguished from those of other studies.
        #[must_use]
        pub fn named(mut self, name: impl Into<String>) -> Self {
            self.settings.name = name.into();
            self
        }

        /// Calls `tell` with the progress of the study, as [`Study::progress`](super::Study::progress).
        #[must_use]
        pub fn progress(mut self, tell: impl Fn(&super::Progress) + 'p) -> Self {
            self.settings.progress = Some(Box::new(tell));
            self
        }
    };
}
pub(crate) use set_settings;
