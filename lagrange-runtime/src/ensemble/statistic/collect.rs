//! The outputs themselves, and files of them.

use super::Statistic;
use crate::ensemble::EnsembleError;
use crate::ensemble::file::replace;
use crate::ensemble::record::Record;
use std::path::Path;

/// All outputs, in the order of their index. It is the one statistic whose memory, and whose checkpoints, grow with
/// the number of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Collect;

/// Result of [`Collect`]: outputs with the index of their sample. Failed samples are missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collected<O> {
    /// Index and output.
    pub rows: Vec<(u64, O)>,
}

impl<O: Record> Record for Collected<O> {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.rows.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Collected { rows: Vec::read(bytes)? })
    }
}

impl<O: Record + Clone + Send> Statistic<O> for Collect {
    type State = Collected<O>;

    fn empty(&self) -> Collected<O> {
        Collected { rows: vec![] }
    }

    fn add(&self, state: &mut Collected<O>, index: u64, output: &O) {
        state.rows.push((index, output.clone()));
    }

    fn merge(&self, state: &mut Collected<O>, mut later: Collected<O>) {
        state.rows.append(&mut later.rows);
    }

    fn describe(&self) -> String {
        "all outputs".into()
    }
}

/// An output that is a row of numbers in a file.
pub trait Columns {
    /// Appends the numbers. Their count is the same for each value of the type.
    fn columns(&self, row: &mut Vec<f64>);
}

impl Columns for f64 {
    fn columns(&self, row: &mut Vec<f64>) {
        row.push(*self);
    }
}

/// NaN, an empty field of a CSV, stands for what is missing.
impl Columns for Option<f64> {
    fn columns(&self, row: &mut Vec<f64>) {
        row.push(self.unwrap_or(f64::NAN));
    }
}

impl<T: Columns, const K: usize> Columns for [T; K] {
    fn columns(&self, row: &mut Vec<f64>) {
        self.iter().for_each(|value| value.columns(row));
    }
}

impl<A: Columns, B: Columns> Columns for (A, B) {
    fn columns(&self, row: &mut Vec<f64>) {
        self.0.columns(row);
        self.1.columns(row);
    }
}

impl<A: Columns, B: Columns, C: Columns> Columns for (A, B, C) {
    fn columns(&self, row: &mut Vec<f64>) {
        self.0.columns(row);
        self.1.columns(row);
        self.2.columns(row);
    }
}

impl<const N: usize> Columns for crate::State<f64, N> {
    fn columns(&self, row: &mut Vec<f64>) {
        row.push(self.t);
        row.extend(self.q.iter().chain(self.qd.iter()));
    }
}

impl<O: Columns> Collected<O> {
    /// Writes comma-separated values (RFC 4180): the column `index`, then those named, each number with as many
    /// digits as it takes to read the same one back, and nothing where it is not a number. The file appears complete
    /// or not at all.
    ///
    /// # Errors
    /// If the number of names is not that of the columns, or the file cannot be written.
    pub fn write_csv(&self, path: impl AsRef<Path>, names: &[&str]) -> Result<(), EnsembleError> {
        let path = path.as_ref();
        let not_written = |source| EnsembleError::NotWritten { path: path.into(), source };
        let mut writer = csv::Writer::from_writer(vec![]);
        let put = |writer: &mut csv::Writer<Vec<u8>>, fields: Vec<String>| {
            writer.write_record(fields).map_err(|error| not_written(std::io::Error::other(error)))
        };
        let heading = ["index"].iter().chain(names).map(ToString::to_string).collect();
        put(&mut writer, heading)?;
        for (index, row) in self.numbers(names.len())? {
            let numbers = row.iter().map(|x| if x.is_nan() { String::new() } else { format!("{x:?}") });
            put(&mut writer, std::iter::once(index.to_string()).chain(numbers).collect())?;
        }
        let bytes =
            writer.into_inner().map_err(|error| not_written(std::io::Error::other(error.to_string())))?;
        replace(path, &bytes).map_err(not_written)
    }

    /// Writes a file of NumPy's format `.npy` 1.0: a matrix of 64-bit numbers, column after column in the file, the
    /// first of them the index. `numpy.load(path)[:, 1]` is the first output of all samples.
    ///
    /// # Errors
    /// If outputs differ in their number of columns, or the file cannot be written.
    pub fn write_npy(&self, path: impl AsRef<Path>) -> Result<(), EnsembleError> {
        let path = path.as_ref();
        let mut first = vec![];
        if let Some((_, output)) = self.rows.first() {
            output.columns(&mut first);
        }
        let rows = self.numbers(first.len())?;
        let shape = (rows.len(), first.len() + 1);
        let mut header = format!("{{'descr': '<f8', 'fortran_order': True, 'shape': {shape:?}, }}");
        // Magic, version, length and header are a multiple of 64 bytes, the last of which is a line feed.
        let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
        header.push_str(&" ".repeat(length - header.len() - 1));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend_from_slice(&(length as u16).to_le_bytes());
        bytes.extend_from_slice(header.as_bytes());
        rows.iter().for_each(|(index, _)| (*index as f64).write(&mut bytes));
        for column in 0..first.len() {
            rows.iter().for_each(|(_, row)| row[column].write(&mut bytes));
        }
        replace(path, &bytes).map_err(|source| EnsembleError::NotWritten { path: path.into(), source })
    }

    /// The rows as numbers, of which each has `columns`.
    fn numbers(&self, columns: usize) -> Result<Vec<(u64, Vec<f64>)>, EnsembleError> {
        let numbers = |(index, output): &(u64, O)| {
            let mut row = Vec::with_capacity(columns);
            output.columns(&mut row);
            let found = row.len();
            if found == columns { Ok((*index, row)) } else { Err(EnsembleError::Columns { found, columns }) }
        };
        self.rows.iter().map(numbers).collect()
    }
}
