//! Reasons why there is no result of an ensemble.

use crate::failure::debug_is_text;
use std::fmt;
use std::io;
use std::path::PathBuf;

/// Reason why an ensemble cannot be computed, or its result not be kept. A failed *sample* is no error: it is counted,
/// see [`Failures`](super::Failures).
#[non_exhaustive]
pub enum EnsembleError {
    /// The study has no samples.
    NoSamples,
    /// The study has more samples than the table has rows, or the sequence points.
    TooFewRows {
        /// Number of rows that there are.
        rows: u64,
        /// Number of samples that were asked for.
        samples: u64,
    },
    /// An argument of a statistic is invalid.
    Statistic(String),
    /// The study does not support this setting or result.
    Refused(String),
    /// There is no sample of this index.
    NoSuchSample {
        /// The index.
        index: u64,
        /// The number of samples.
        samples: u64,
    },
    /// The threads could not be started.
    Threads(String),
    /// A file could not be written. If there was one before, it is as it was.
    NotWritten {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// A checkpoint is there and cannot be read.
    NotRead {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// A file is no checkpoint, or a damaged one.
    Corrupt {
        /// The file.
        path: PathBuf,
        /// The defect.
        what: &'static str,
    },
    /// A checkpoint belongs to another study.
    OtherStudy {
        /// The file.
        path: PathBuf,
        /// Content of the checkpoint.
        checkpoint: String,
        /// Content that this study expects.
        study: String,
    },
    /// A study with a checkpoint is to hand its outputs on.
    StreamWithCheckpoint,
    /// There is no such shard.
    NoSuchShard {
        /// The shard, from 0.
        shard: u64,
        /// Number of samples.
        of: u64,
    },
    /// A shard of a study is to stop by itself.
    SequentialShard,
    /// Shards do not make a whole.
    Shards(String),
    /// A file of results has another number of columns than the outputs, or the outputs differ in it.
    Columns {
        /// The columns of an output.
        found: usize,
        /// The columns expected.
        columns: usize,
    },
}

impl fmt::Display for EnsembleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSamples => write!(f, "an ensemble needs at least one sample"),
            Self::TooFewRows { rows, samples } => {
                write!(f, "{samples} samples were asked for, but the source has {rows}; ask for fewer")
            }
            Self::Statistic(why) | Self::Refused(why) => f.write_str(why),
            Self::NoSuchSample { index, samples } => {
                write!(f, "there is no sample {index}; the {samples} samples are numbered from 0")
            }
            Self::Threads(why) => write!(f, "the threads could not be started: {why}"),
            Self::NotWritten { path, source } => {
                write!(
                    f,
                    "{} could not be written: {source}; what was there before is intact",
                    path.display()
                )
            }
            Self::NotRead { path, source } => {
                write!(f, "the checkpoint {} could not be read: {source}", path.display())
            }
            Self::Corrupt { path, what } => write!(
                f,
                "{} {what}; remove it to begin anew, or give the path of another checkpoint",
                path.display()
            ),
            Self::OtherStudy { path, checkpoint, study } => write!(
                f,
                "the checkpoint {} is of another study: it has `{checkpoint}`, this one `{study}`; remove it to \
                 begin anew, or give another path",
                path.display()
            ),
            Self::StreamWithCheckpoint => write!(
                f,
                "outputs that were handed on cannot be taken back when a study goes on from its checkpoint; leave the \
                 checkpoint out, and divide a long study into shards instead"
            ),
            Self::NoSuchShard { shard, of } => {
                write!(f, "there is no shard {shard} of {of}; shards are numbered from 0")
            }
            Self::SequentialShard => write!(
                f,
                "a shard cannot know when the others stop; help: run a study that stops by itself on one machine, and divide one whose number of \
                 samples is known"
            ),
            Self::Shards(what) => write!(f, "the shards do not make a whole: {what}"),
            Self::Columns { found, columns } => {
                write!(f, "an output has {found} columns where {columns} are expected; give a name for each")
            }
        }
    }
}

debug_is_text! { [] EnsembleError }

impl std::error::Error for EnsembleError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::NotWritten { source, .. } | Self::NotRead { source, .. } => Some(source),
            _ => None,
        }
    }
}
