//! Outputs as columns of a file that data frames read.

use super::EnsembleError;
use super::statistic::Columns;
use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows that are kept in memory until they are written as one group.
const ROWS: usize = 1 << 16;

/// A file in the format [Parquet](https://parquet.apache.org/docs/file-format/): the column `index`, and one column
/// of 64-bit numbers for each number of an output. Rows are written as they come, in constant memory; the file
/// appears when it is [finished](Self::finish), complete or not at all.
///
/// ```
/// use lagrange_runtime::ensemble::{Ensemble, Moments, Parquet, Sobol};
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     pub system Pendulum {
///         param l = 0.85;
///         coord theta;
///         T = 0.5 * (l * dot(theta)).powi(2);
///         V = -9.81 * l * cos(theta);
///     }
/// }
/// # let path = std::env::temp_dir().join(format!("lagrange-doc-{}.parquet", std::process::id()));
/// let mut file = Parquet::create(&path, &["start", "end"])?;
/// Ensemble::new(Sobol::<1>::seed(1), 1000, |[u]| (Pendulum::new(), State::new(0.0, [u], [0.0])))
///     .integrate(Rk4, FixedStep::new(0.01), 1.0)
///     .stream(
///         |_, run| Ok((run.start().q[0], run.final_state()?.q[0])),
///         lagrange_runtime::ensemble::of(|(_, end): &(f64, f64)| *end, Moments),
///         |index, output| file.row(index, output),
///     )?;
/// file.finish()?;
/// # std::fs::remove_file(path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Parquet {
    path: PathBuf,
    /// The file under its name until it is finished; none after that.
    beside: Option<PathBuf>,
    writer: SerializedFileWriter<File>,
    index: Vec<i64>,
    columns: Vec<Vec<f64>>,
    row: Vec<f64>,
}

impl Parquet {
    /// A file with these columns beside the index.
    ///
    /// # Errors
    /// If it cannot be written, or a name is given twice.
    pub fn create(path: impl Into<PathBuf>, names: &[&str]) -> Result<Self, EnsembleError> {
        let path = path.into();
        let mut beside = path.clone().into_os_string();
        beside.push(".part");
        let beside = PathBuf::from(beside);
        let twice = |(k, name): (usize, &&str)| *name == "index" || names[..k].contains(name);
        if let Some((_, name)) = names.iter().enumerate().find(|&(k, name)| twice((k, name))) {
            return Err(EnsembleError::NotWritten {
                path,
                source: io::Error::new(
                    io::ErrorKind::InvalidInput,
                    format!("two columns are called `{name}`"),
                ),
            });
        }
        let column = |name: &str, physical| {
            Type::primitive_type_builder(name, physical)
                .with_repetition(Repetition::REQUIRED)
                .build()
                .map(Arc::new)
        };
        let writer = || -> Result<_, ParquetError> {
            let mut fields = vec![column("index", Physical::INT64)?];
            for name in names {
                fields.push(column(name, Physical::DOUBLE)?);
            }
            let schema = Type::group_type_builder("samples").with_fields(fields).build()?;
            let properties = WriterProperties::builder().set_dictionary_enabled(false).build();
            SerializedFileWriter::new(File::create(&beside)?, Arc::new(schema), Arc::new(properties))
        };
        let writer = writer().map_err(|error| not_written(&path, error))?;
        let columns = names.iter().map(|_| vec![]).collect();
        Ok(Parquet { path, beside: Some(beside), writer, index: vec![], columns, row: vec![] })
    }

    /// The output of a sample.
    ///
    /// # Errors
    /// If it has another number of columns than the file, or the file cannot be written.
    pub fn row(&mut self, index: u64, output: &impl Columns) -> Result<(), EnsembleError> {
        self.row.clear();
        output.columns(&mut self.row);
        let (found, columns) = (self.row.len(), self.columns.len());
        if found != columns {
            return Err(EnsembleError::Columns { found, columns });
        }
        self.index.push(index as i64);
        for (column, x) in self.columns.iter_mut().zip(&self.row) {
            column.push(*x);
        }
        if self.index.len() == ROWS { self.flush() } else { Ok(()) }
    }

    /// Writes what is left, and gives the file its name.
    ///
    /// # Errors
    /// If it cannot be written. A file that was there before is then as it was.
    pub fn finish(mut self) -> Result<(), EnsembleError> {
        if !self.index.is_empty() {
            self.flush()?;
        }
        let end = || -> Result<(), ParquetError> {
            self.writer.finish()?;
            self.writer.inner().sync_all()?;
            if let Some(beside) = &self.beside {
                fs::rename(beside, &self.path)?;
            }
            Ok(())
        };
        let ended = { end }();
        ended.map_err(|error| not_written(&self.path, error))?;
        self.beside = None;
        Ok(())
    }

    /// Writes the rows that are in memory.
    fn flush(&mut self) -> Result<(), EnsembleError> {
        let Parquet { path, writer, index, columns, .. } = self;
        let group = || -> Result<(), ParquetError> {
            let mut group = writer.next_row_group()?;
            if let Some(mut column) = group.next_column()? {
                column.typed::<Int64Type>().write_batch(index, None, None)?;
                column.close()?;
            }
            for values in &*columns {
                if let Some(mut column) = group.next_column()? {
                    column.typed::<DoubleType>().write_batch(values, None, None)?;
                    column.close()?;
                }
            }
            group.close().map(|_| ())
        };
        let written = { group }();
        written.map_err(|error| not_written(path, error))?;
        index.clear();
        columns.iter_mut().for_each(Vec::clear);
        Ok(())
    }
}

/// Removes the file if it was not finished.
impl Drop for Parquet {
    fn drop(&mut self) {
        if let Some(beside) = &self.beside {
            // That it cannot be removed is no news beside whatever was the reason.
            let _ = fs::remove_file(beside);
        }
    }
}

impl std::fmt::Debug for Parquet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Parquet").field("path", &self.path).finish_non_exhaustive()
    }
}

fn not_written(path: &Path, error: ParquetError) -> EnsembleError {
    EnsembleError::NotWritten { path: path.into(), source: io::Error::other(error) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    /// Read back by the reader of the crate: every row of more than one group, bit for bit.
    #[test]
    fn rows_come_back() {
        let path = std::env::temp_dir().join(format!("lagrange-parquet-{}", std::process::id()));
        let value = |index: u64| [(index as f64).sqrt(), if index % 100 == 7 { f64::NAN } else { -1.5 }];
        let rows = 150_001;
        let mut file = Parquet::create(&path, &["root", "other"]).expect("a file");
        (0..rows).for_each(|index| file.row(2 * index, &value(index)).expect("room"));
        assert!(!path.exists());
        assert!(matches!(file.row(0, &1.0), Err(EnsembleError::Columns { found: 1, columns: 2 })));
        file.finish().expect("room");
        let reader = SerializedFileReader::new(File::open(&path).expect("there")).expect("a sound file");
        assert_eq!(reader.metadata().num_row_groups(), 3);
        let mut count = 0;
        for (row, index) in reader.get_row_iter(None).expect("rows").zip(0..) {
            let row = row.expect("a row");
            let fields: Vec<_> = row.get_column_iter().collect();
            assert_eq!(
                fields.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
                ["index", "root", "other"]
            );
            let [(_, Field::Long(found)), (_, Field::Double(root)), (_, Field::Double(other))] = fields[..]
            else {
                panic!("{fields:?}");
            };
            let expected = value(index);
            assert_eq!(
                (*found, root.to_bits(), other.to_bits()),
                (2 * index as i64, expected[0].to_bits(), expected[1].to_bits())
            );
            count += 1;
        }
        assert_eq!(count, rows);
        std::fs::remove_file(path).expect("removed");
    }
}
