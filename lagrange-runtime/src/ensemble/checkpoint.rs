//! Progress of a study, in memory and in a file.
//!
//! The file: eight bytes of magic with the version of the format, the description of the study as a list of strings,
//! the state, and the CRC-32 of all that. It is replaced as a whole.

use super::file::replace;
use super::record::Record;
use super::tree::Tree;
use super::{EnsembleError, LEAF};
use std::fs;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

/// The format, and its version.
const MAGIC: [u8; 8] = *b"lgr-ens2";

/// Progress of a study: of its leaves from `first` to `end` (all of them, unless this is a shard) it has done those
/// before `next`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached<T> {
    /// The first leaf.
    pub first: u64,
    /// The leaf after the last one.
    pub end: u64,
    /// The next leaf.
    pub next: u64,
    /// The statistics so far.
    pub tree: Tree<T>,
    /// Number of failed samples.
    pub failed: u64,
    /// Samples whose failures are kept. A failure names coordinates and constraints of the program, which a file cannot
    /// give back: these samples are run again when a study is resumed.
    pub kept: Vec<u64>,
}

impl<T> Reached<T> {
    /// Nothing yet of these leaves.
    pub fn nothing(leaves: Range<u64>) -> Self {
        let Range { start, end } = leaves;
        Reached { first: start, end, next: start, tree: Tree::EMPTY, failed: 0, kept: vec![] }
    }

    /// Number of samples that are done, of a study that has `samples`.
    pub fn done(&self, samples: u64) -> u64 {
        self.next.saturating_mul(LEAF).min(samples) - self.first.saturating_mul(LEAF).min(samples)
    }

    /// Number of samples to be done.
    pub fn samples(&self, samples: u64) -> u64 {
        self.end.saturating_mul(LEAF).min(samples) - self.first.saturating_mul(LEAF).min(samples)
    }
}

impl<T: Record> Record for Tree<T> {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.nodes.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Tree { nodes: Vec::read(bytes)? })
    }
}

impl<T: Record> Record for Reached<T> {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.first.write(bytes);
        self.end.write(bytes);
        self.next.write(bytes);
        self.tree.write(bytes);
        self.failed.write(bytes);
        self.kept.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Reached {
            first: Record::read(bytes)?,
            end: Record::read(bytes)?,
            next: Record::read(bytes)?,
            tree: Record::read(bytes)?,
            failed: Record::read(bytes)?,
            kept: Record::read(bytes)?,
        })
    }
}

/// A study and how far it has come, as a file or a message has it.
pub fn encode<T: Record>(description: &[String], reached: &Reached<T>) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    description.to_vec().write(&mut bytes);
    reached.write(&mut bytes);
    crc32fast::hash(&bytes).write(&mut bytes);
    bytes
}

/// File and interval of the checkpoints of a study.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    pub path: PathBuf,
    pub every: Duration,
}

impl Checkpoint {
    /// Replaces the file.
    pub fn write<T: Record>(
        &self,
        description: &[String],
        reached: &Reached<T>,
    ) -> Result<(), EnsembleError> {
        replace(&self.path, &encode(description, reached))
            .map_err(|source| EnsembleError::NotWritten { path: self.path.clone(), source })
    }

    /// Reads the file; `None` if there is none.
    pub fn read<T: Record>(
        &self,
        description: &[String],
        samples: u64,
    ) -> Result<Option<Reached<T>>, EnsembleError> {
        match fs::read(&self.path) {
            Ok(bytes) => self.decode(&bytes, description, samples).map(Some),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(source) => Err(EnsembleError::NotRead { path: self.path.clone(), source }),
        }
    }

    /// Decodes the bytes of [`encode`]. The path is for messages.
    pub fn decode<T: Record>(
        &self,
        bytes: &[u8],
        description: &[String],
        samples: u64,
    ) -> Result<Reached<T>, EnsembleError> {
        let corrupt = |what| EnsembleError::Corrupt { path: self.path.clone(), what };
        if !bytes.starts_with(&MAGIC) {
            return Err(corrupt("is not a checkpoint of this version"));
        }
        let (checked, checksum) = bytes.split_last_chunk().ok_or_else(|| corrupt("is cut short"))?;
        if crc32fast::hash(checked) != u32::from_le_bytes(*checksum) {
            return Err(corrupt("is damaged: its checksum is wrong"));
        }
        let unreadable = || corrupt("does not hold what its checksum is right for");
        let mut rest = checked.get(MAGIC.len()..).ok_or_else(unreadable)?;
        let found: Vec<String> = Record::read(&mut rest).ok_or_else(unreadable)?;
        self.compare(&found, description)?;
        let reached: Reached<T> = Record::read(&mut rest).ok_or_else(unreadable)?;
        let sound = reached.first <= reached.next
            && reached.next <= reached.end
            && reached.end <= samples.div_ceil(LEAF)
            && reached.kept.iter().all(|&index| index < samples);
        if rest.is_empty() && sound { Ok(reached) } else { Err(unreadable()) }
    }

    /// Refuses another study, by the first line that differs.
    fn compare(&self, found: &[String], expected: &[String]) -> Result<(), EnsembleError> {
        let line = |lines: &[String], k: usize| lines.get(k).cloned().unwrap_or_default();
        let lines = found.len().max(expected.len());
        match (0..lines).find(|&k| line(found, k) != line(expected, k)) {
            Some(k) => Err(self.of_another(line(found, k), line(expected, k))),
            None => Ok(()),
        }
    }

    /// The error that the checkpoint says one thing and this study another.
    pub fn of_another(&self, checkpoint: String, study: String) -> EnsembleError {
        EnsembleError::OtherStudy { path: self.path.clone(), checkpoint, study }
    }
}
