//! Reasons why a chart was not written.

use crate::failure::debug_is_text;
use std::fmt;
use std::path::PathBuf;

/// Reason why there is no chart.
#[non_exhaustive]
pub enum ChartError {
    /// No series has a point that can be drawn.
    NoPoints,
    /// The frames of an [`Animation`](super::Animation) do not fit together, in these words.
    Frames(String),
    /// A file could not be written.
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The picture could not be made. Please report it.
    Render(String),
}

impl fmt::Display for ChartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPoints => write!(
                f,
                "the chart has no point to draw: add a series with finite values (positive ones on a logarithmic axis)"
            ),
            Self::Frames(reason) => write!(
                f,
                "the frames do not make an animation: {reason}; every part that moves needs as many frames, and each of its \
                 frames as many points"
            ),
            Self::Write { path, source } => {
                let help = match source.kind() {
                    std::io::ErrorKind::NotFound => "; the folder has to exist",
                    _ => "",
                };
                write!(f, "cannot write {}: {source}{help}", path.display())
            }
            Self::Render(reason) => write!(f, "the chart could not be rendered: {reason}"),
        }
    }
}

debug_is_text! { [] ChartError }

impl std::error::Error for ChartError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Write { source, .. } => Some(source),
            _ => None,
        }
    }
}
