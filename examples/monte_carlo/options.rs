//! The command line.

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand, value_parser};
use std::ffi::OsString;
use std::path::PathBuf;

/// Does the top sleep? Tolerance analysis of a spinning top.
#[derive(Parser)]
#[command(version)]
pub struct Arguments {
    /// Number of tops; with --confidence the most that are computed.
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = value_parser!(u64).range(2..))]
    pub samples: u64,
    /// Seed of the random numbers.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// Tolerance of a step, absolute and relative.
    #[arg(long, value_name = "ERROR", default_value_t = 1e-9, value_parser = positive)]
    pub tolerance: f64,
    /// Number of threads; 0 for as many as there are processors.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Stop once the mean moment of waking is known to so many seconds, the half-width of its 95 % interval. Tops
    /// that do not wake count with the end.
    #[arg(long, value_name = "SECONDS", value_parser = positive, conflicts_with = "shard")]
    pub confidence: Option<f64>,
    /// Let Lagrange's threshold, a closed form, do most of the work: few tops are simulated, as many as it takes.
    #[arg(long, requires = "confidence", conflicts_with = "csv")]
    pub multifidelity: bool,
    /// Compute one part of the study only, and leave it in the folder.
    #[arg(long, value_name = "K/N", value_parser = shard)]
    pub shard: Option<(u64, u64)>,
    /// Folder of checkpoints and charts (default: charts, in cargo's target folder).
    #[arg(long, value_name = "FOLDER")]
    pub folder: Option<PathBuf>,
    /// Write the dimensions and moments of waking of all tops as a table, too; each shard needs this option, too.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Subcommand)]
pub enum Command {
    /// Put together what the shards of a study left in the folder. Give the options that they had before this word.
    Merge {
        /// Number of shards.
        #[arg(value_parser = value_parser!(u64).range(1..))]
        shards: u64,
    },
}

/// K/N with 1 ≤ K ≤ N.
fn shard(text: &str) -> Result<(u64, u64), String> {
    let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((k, n)) if 1 <= k && k <= n => Ok((k, n)),
        Some((k, n)) => Err(format!("there is no shard {k} of {n}: the first is 1, the last {n}")),
        None => Err("two whole numbers are wanted, as in 2/3".into()),
    }
}

/// A positive number.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "a positive number is wanted".into())
}

impl Arguments {
    /// The words of a command line, or what is wrong with them.
    pub fn checked(
        words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    ) -> Result<Self, clap::Error> {
        let arguments = Arguments::try_parse_from(words)?;
        let refused = |what| Err(Arguments::command().error(ErrorKind::ArgumentConflict, what));
        if arguments.command.is_some() && arguments.shard.is_some() {
            return refused("`merge` puts all shards together: leave out --shard");
        }
        if arguments.command.is_some() && arguments.confidence.is_some() {
            return refused("a study that stops by itself has no shards to merge: leave out --confidence");
        }
        Ok(arguments)
    }
}
