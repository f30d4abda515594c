//! How far a study has come, in memory and in a file.
//!
//! The file: eight bytes of magic with the version of the format, the description of the study as a list of strings, the
//! state, and the CRC-32 of all that. It is replaced as a whole.

use super::file::replace;
use super::record::Record;
use super::tree::Tree;
use super::{EnsembleError, LEAF};
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::Duration;

/// The format, and its version.
const MAGIC: [u8; 8] = *b"lgr-ens1";

/// How far a study has come: it has done all samples of the leaves before `next`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached<T> {
    /// The next leaf.
    pub next: u64,
    /// The statistics so far.
    pub tree: Tree<T>,
    /// How many samples failed.
    pub failed: u64,
    /// Those whose failures are kept. A failure names coordinates and constraints of the program, which a file cannot give
    /// back: these samples are run again when a study is resumed.
    pub kept: Vec<u64>,
}

impl<T> Reached<T> {
    /// How many samples are done, of a study that has `samples`.
    pub fn samples(&self, samples: u64) -> u64 {
        self.next.saturating_mul(LEAF).min(samples)
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
        self.next.write(bytes);
        self.tree.write(bytes);
        self.failed.write(bytes);
        self.kept.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Reached {
            next: Record::read(bytes)?,
            tree: Record::read(bytes)?,
            failed: Record::read(bytes)?,
            kept: Record::read(bytes)?,
        })
    }
}

/// Where and how often a study writes how far it has come.
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
        let mut bytes = MAGIC.to_vec();
        description.to_vec().write(&mut bytes);
        reached.write(&mut bytes);
        crc32fast::hash(&bytes).write(&mut bytes);
        replace(&self.path, &bytes)
            .map_err(|source| EnsembleError::NotWritten { path: self.path.clone(), source })
    }

    /// What the file holds; `None` if there is none.
    pub fn read<T: Record>(
        &self,
        description: &[String],
        samples: u64,
    ) -> Result<Option<Reached<T>>, EnsembleError> {
        let bytes = match fs::read(&self.path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(EnsembleError::NotRead { path: self.path.clone(), source }),
        };
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
        let sound =
            reached.next <= samples.div_ceil(LEAF) && reached.kept.iter().all(|&index| index < samples);
        if rest.is_empty() && sound { Ok(Some(reached)) } else { Err(unreadable()) }
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

    /// That the checkpoint says one thing and this study another.
    pub fn of_another(&self, checkpoint: String, study: String) -> EnsembleError {
        EnsembleError::OtherStudy { path: self.path.clone(), checkpoint, study }
    }
}
