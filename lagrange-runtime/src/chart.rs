//! Charts of results: SVG and PNG for the reader, CSV with the raw numbers beside them.
//!
//! Made for print and for every eye: the colours of Okabe and Ito (*Color Universal Design*, 2008), and a marker and
//! a dash pattern of its own for each series, so that a chart also reads in grey. Text is drawn with an embedded font
//! (DejaVu Sans) and stored as paths: it looks the same where no font is installed.
//!
//! ```
//! use lagrange_runtime::chart::{Axis, Chart, Series};
//!
//! let chart = Chart::new("Simple pendulum", Axis::log("time", "s"), Axis::log("error in θ", "rad"))
//!     .subtitle("from θ = 1 rad at rest, 10 periods; reference: elliptic functions")
//!     .with(Series::new("RK4", [(1e-5, 1e-4), (1e-4, 1e-8), (1e-3, 1e-12)]))
//!     .with(Series::new("DOP853", [(1e-5, 1e-5), (3e-5, 1e-10), (1e-4, 3e-14)]));
//! let folder = std::env::temp_dir();
//! chart.write(&folder, "pendulum-work-precision")?; // .svg, .png and .csv
//! # for end in ["svg", "png", "csv"] { let _ = std::fs::remove_file(folder.join(format!("pendulum-work-precision.{end}"))); }
//! # Ok::<(), lagrange_runtime::chart::ChartError>(())
//! ```

use std::fmt::Write as _;
use std::path::Path;

mod animation;
mod axis;
mod breakdown;
mod cells;
mod error;
mod font;
mod frontier;
mod ink;
mod layout;
mod map;
mod palette;
mod panels;
mod series;
pub use error::ChartError;
pub use series::{Series, Style};
mod picture;
mod png;
mod sheet;
mod svg;

pub use animation::{Animation, Part, Shape};
pub use breakdown::Breakdown;
pub use map::{Cell, Map};
pub use panels::Panels;

use sheet::Sheet;
use svg::Letters;

/// A chart of named series over two axes.
///
/// Points that cannot be drawn (NaN, infinite, not positive on a logarithmic axis) are left out of the picture, where
/// they interrupt the line, and kept in the CSV.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Subtitle with the facts that the reader needs: system, start, reference. May be empty.
    pub subtitle: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// The series, in the order of the legend.
    pub series: Vec<Series>,
    /// One unit is as long on both axes, as orbits want it. No effect with a logarithmic axis.
    pub equal_aspect: bool,
}

/// One axis: what it shows, in which unit, on which scale.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Name of the quantity.
    pub label: String,
    /// Unit, shown in parentheses; empty if there is none.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: Scale,
}

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal lengths for equal differences.
    Linear,
    /// Equal lengths for equal ratios.
    Log,
}

impl Chart {
    /// A chart without series.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { title: title.into(), subtitle: String::new(), x, y, series: Vec::new(), equal_aspect: false }
    }

    /// Sets the subtitle.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Adds a series.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Makes one unit as long on the vertical axis as on the horizontal one.
    #[must_use]
    pub fn equal_aspect(mut self) -> Self {
        self.equal_aspect = true;
        self
    }

    /// Position of a point along both axes; `None` if it cannot be drawn.
    fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        self.x.place(x).zip(self.y.place(y))
    }

    /// Writes `stem.svg`, `stem.png` and `stem.csv` into the folder `dir`, which must exist.
    ///
    /// # Errors
    /// If there is nothing to draw (then nothing is written), or if a file cannot be written.
    pub fn write(&self, dir: impl AsRef<Path>, stem: &str) -> Result<(), ChartError> {
        write_files(dir.as_ref(), stem, &self.sheet()?, &self.csv())
    }

    /// The chart as SVG, its text as paths.
    ///
    /// # Errors
    /// If there is nothing to draw.
    pub fn svg(&self) -> Result<String, ChartError> {
        Ok(self.sheet()?.svg(Letters::Outlines))
    }

    /// The chart as PNG.
    ///
    /// # Errors
    /// If there is nothing to draw.
    pub fn png(&self) -> Result<Vec<u8>, ChartError> {
        self.sheet()?.png()
    }

    fn sheet(&self) -> Result<Sheet, ChartError> {
        picture::sheet(self, layout::ALONE)
    }

    /// All points as comma-separated values (RFC 4180), with as many digits as it takes to read the same numbers
    /// back. The heading is `series`, then both axes with their units.
    pub fn csv(&self) -> String {
        let mut csv = format!("series,{},{}\n", field(&self.x.caption()), field(&self.y.caption()));
        for series in &self.series {
            let name = field(&series.name);
            for (x, y) in &series.points {
                let _ = writeln!(csv, "{name},{x:?},{y:?}");
            }
        }
        csv
    }
}

/// Writes the files of one picture.
fn write_files(dir: &Path, stem: &str, sheet: &Sheet, csv: &str) -> Result<(), ChartError> {
    write_each(dir, stem, &sheet.svg(Letters::Outlines), &sheet.png()?, csv)
}

fn write_each(dir: &Path, stem: &str, svg: &str, png: &[u8], csv: &str) -> Result<(), ChartError> {
    for (extension, content) in [("svg", svg.as_bytes()), ("png", png), ("csv", csv.as_bytes())] {
        let path = dir.join(format!("{stem}.{extension}"));
        std::fs::write(&path, content).map_err(|source| ChartError::Write { path, source })?;
    }
    Ok(())
}

/// Quoted where it has to be.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), scale: Scale::Linear }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), scale: Scale::Log }
    }

    /// `label (unit)`.
    fn caption(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }

    /// Position of a value along the axis; `None` if it has none.
    fn place(&self, value: f64) -> Option<f64> {
        let place = match self.scale {
            Scale::Linear => value,
            Scale::Log if value > 0.0 => value.log10(),
            Scale::Log => return None,
        };
        place.is_finite().then_some(place)
    }
}

#[cfg(test)]
mod tests;
