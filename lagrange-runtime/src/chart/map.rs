//! A map: rows by columns, each cell an error, coloured by its decade, or a word.

use super::font::Font;
use super::ink::{Canvas, Drawn, INK, fine, write, write_upwards};
use super::sheet::Sheet;
use super::svg::Letters;
use super::{ChartError, field, write_files};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::fmt::Write as _;
use std::path::Path;

/// A grid of cells with names for its rows and columns.
///
/// ```
/// use lagrange_runtime::chart::{Cell, Map};
/// let map = Map::new("Three runs", ["RK4", "DOP853"])
///     .with("oscillator", [Cell::Error(1e-6), Cell::Error(3e-12)])
///     .with("runaway", [Cell::Failure("NonFinite".into()), Cell::Failure("StepSizeUnderflow".into())]);
/// assert!(map.svg()?.contains("<svg"));
/// assert!(map.csv().contains("runaway,RK4,,failure,NonFinite"));
/// # Ok::<(), lagrange_runtime::chart::ChartError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Heading.
    pub title: String,
    /// Subtitle. May be empty.
    pub subtitle: String,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Names and cells of the rows. Cells beyond the last column are not drawn.
    pub rows: Vec<(String, Vec<Cell>)>,
    /// Paragraphs below the grid.
    pub legend: Vec<String>,
}

/// Content of a cell of a [`Map`].
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Nothing: there is no such case.
    Empty,
    /// An error; its colour is that of its decade.
    Error(f64),
    /// The name of a failure, broken into lines before its capitals.
    Failure(String),
    /// An error that is larger than what was promised: it cannot be overlooked.
    Alarm(f64),
}

const MARGIN: f64 = 18.0;
const CELL: (f64, f64) = (60.0, 36.0);
const TITLE: Font = Font::bold(20.0);
const TEXT: Font = Font::regular(14.0);
const NUMBER: Font = Font::regular(13.5);
const WORD: Font = Font::regular(11.0);
const LINE: f64 = 19.0;
/// Errors from here on, and up to here, have colours of their own.
const DECADES: (f64, f64) = (-14.0, 0.0);

impl Map {
    /// A map without rows.
    pub fn new<Name: Into<String>>(
        title: impl Into<String>,
        columns: impl IntoIterator<Item = Name>,
    ) -> Self {
        Map {
            title: title.into(),
            subtitle: String::new(),
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
            legend: Vec::new(),
        }
    }

    /// Sets the subtitle.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Adds a row.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, cells: impl IntoIterator<Item = Cell>) -> Self {
        self.rows.push((name.into(), cells.into_iter().collect()));
        self
    }

    /// Adds a paragraph below the grid.
    #[must_use]
    pub fn legend(mut self, paragraph: impl Into<String>) -> Self {
        self.legend.push(paragraph.into());
        self
    }

    /// Writes `stem.svg`, `stem.png` and `stem.csv` into the folder `dir`, which must exist.
    ///
    /// # Errors
    /// If there is nothing to draw, or if a file cannot be written.
    pub fn write(&self, dir: impl AsRef<Path>, stem: &str) -> Result<(), ChartError> {
        write_files(dir.as_ref(), stem, &self.sheet()?, &self.csv())
    }

    /// The map as SVG, its text as paths.
    ///
    /// # Errors
    /// If there is nothing to draw.
    pub fn svg(&self) -> Result<String, ChartError> {
        Ok(self.sheet()?.svg(Letters::Outlines))
    }

    /// All cells that are not empty as comma-separated values: row, column, error, kind, failure.
    pub fn csv(&self) -> String {
        let mut csv = String::from("row,column,error,kind,failure\n");
        for (row, cells) in &self.rows {
            for (column, cell) in self.columns.iter().zip(cells) {
                let (row, column) = (field(row), field(column));
                let _ = match cell {
                    Cell::Empty => Ok(()),
                    Cell::Error(error) => writeln!(csv, "{row},{column},{error:e},error,"),
                    Cell::Failure(name) => writeln!(csv, "{row},{column},,failure,{}", field(name)),
                    Cell::Alarm(error) => writeln!(csv, "{row},{column},{error:e},silently wrong,"),
                };
            }
        }
        csv
    }

    fn sheet(&self) -> Result<Sheet, ChartError> {
        if self.rows.is_empty() || self.columns.is_empty() {
            return Err(ChartError::NoPoints);
        }
        let widest =
            |names: &mut dyn Iterator<Item = &String>| names.map(|name| TEXT.width(name)).fold(0.0, f64::max);
        let left = MARGIN + widest(&mut self.rows.iter().map(|(name, _)| name)) + 10.0;
        let width = (left + CELL.0 * self.columns.len() as f64 + MARGIN).max(720.0).ceil();
        let wrap = |text: &String| TEXT.wrap(text, width - 2.0 * MARGIN);
        let title = TITLE.wrap(&self.title, width - 2.0 * MARGIN);
        let subtitle = wrap(&self.subtitle);
        let heading = 26.0 * title.len() as f64 + LINE * subtitle.len() as f64;
        let top = (MARGIN + heading + widest(&mut self.columns.iter()) + 20.0).ceil();
        let bottom = top + CELL.1 * self.rows.len() as f64;
        let legend: Vec<Vec<String>> = self.legend.iter().map(wrap).collect();
        let below: f64 = legend.iter().map(|lines| LINE * lines.len() as f64 + 6.0).sum();
        let height = (bottom + 66.0 + below + MARGIN).ceil();

        Sheet::painted((width, height), |canvas| {
            canvas.fill(&WHITE)?;
            let mut baseline = MARGIN + 18.0;
            for line in &title {
                write(canvas, line, (MARGIN, baseline), TITLE, INK, HPos::Left)?;
                baseline += 26.0;
            }
            for line in &subtitle {
                write(canvas, line, (MARGIN, baseline - 3.0), TEXT, INK, HPos::Left)?;
                baseline += LINE;
            }
            for (j, name) in self.columns.iter().enumerate() {
                let middle = left + CELL.0 * (j as f64 + 0.5);
                let at = (middle + 0.36 * TEXT.size, top - 8.0 - 0.5 * TEXT.width(name));
                write_upwards(canvas, name, at, TEXT)?;
            }
            for (i, (name, cells)) in self.rows.iter().enumerate() {
                let y = top + CELL.1 * i as f64;
                let at = (left - 8.0, y + 0.5 * CELL.1 + 0.36 * TEXT.size);
                write(canvas, name, at, TEXT, INK, HPos::Right)?;
                for (j, cell) in cells.iter().take(self.columns.len()).enumerate() {
                    paint_cell(canvas, (left + CELL.0 * j as f64, y), cell)?;
                }
            }
            let mut baseline = scale(canvas, bottom + 16.0)?;
            for lines in &legend {
                for line in lines {
                    write(canvas, line, (MARGIN, baseline), TEXT, INK, HPos::Left)?;
                    baseline += LINE;
                }
                baseline += 6.0;
            }
            Ok(())
        })
    }
}

fn rectangle(canvas: &Canvas, (x, y): (f64, f64), (width, height): (f64, f64), colour: RGBColor) -> Drawn {
    let corners = [(fine(x + 1.0), fine(y + 1.0)), (fine(x + width - 1.0), fine(y + height - 1.0))];
    canvas.draw(&Rectangle::new(corners, colour.filled()))?;
    Ok(())
}

fn paint_cell(canvas: &Canvas, (x, y): (f64, f64), cell: &Cell) -> Drawn {
    const GREY: RGBColor = RGBColor(0xE2, 0xE2, 0xE2);
    const FAINT: RGBColor = RGBColor(0xBB, 0xBB, 0xBB);
    let (text, font, ground, ink) = match cell {
        Cell::Empty => ("·".to_owned(), NUMBER, WHITE, FAINT),
        Cell::Error(error) => (number(*error), NUMBER, colour(*error), INK),
        Cell::Failure(name) => (broken(name), WORD, GREY, INK),
        Cell::Alarm(error) => (number(*error), Font::bold(13.5), BLACK, WHITE),
    };
    rectangle(canvas, (x, y), CELL, ground)?;
    let lines: Vec<&str> = text.lines().collect();
    for (k, line) in lines.iter().enumerate() {
        let above = (k as f64 - 0.5 * (lines.len() - 1) as f64) * 12.0;
        let at = (x + 0.5 * CELL.0, y + 0.5 * CELL.1 + above + 0.36 * font.size);
        write(canvas, line, at, font.fit(line, CELL.0 - 6.0), ink, HPos::Center)?;
    }
    Ok(())
}

/// The key to the colours; gives the baseline below it.
fn scale(canvas: &Canvas, top: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let mut x = MARGIN;
    for decade in [-14, -12, -10, -8, -6, -4, -2, 0] {
        paint_cell(canvas, (x, top), &Cell::Error(10f64.powi(decade)))?;
        x += CELL.0;
    }
    for (cell, words) in [
        (Cell::Failure("Failure".into()), "ended by a failure, which says so"),
        (Cell::Alarm(1.0), "silently wrong"),
        (Cell::Empty, "does not apply"),
    ] {
        x += 14.0;
        paint_cell(canvas, (x, top), &cell)?;
        x += CELL.0 + 6.0;
        write(canvas, words, (x, top + 0.5 * CELL.1 + 5.0), TEXT, INK, HPos::Left)?;
        x += TEXT.width(words);
    }
    Ok(top + CELL.1 + 28.0)
}

fn number(error: f64) -> String {
    if error.is_finite() { format!("{error:.0e}").replace('-', "−") } else { "∞".to_owned() }
}

/// The colour of an error, from blue for rounding over white to vermillion for 1 and more, all light enough for dark
/// text.
fn colour(error: f64) -> RGBColor {
    let (low, high) = DECADES;
    let place = if error.is_nan() { high } else { error.abs().log10().floor().clamp(low, high) };
    let along = (place - low) / (high - low);
    let mix = |from: [f64; 3], to: [f64; 3], by: f64| {
        let [r, g, b] = [0, 1, 2].map(|i| (from[i] + by * (to[i] - from[i])) as u8);
        RGBColor(r, g, b)
    };
    let (blue, white, red) = ([0x56, 0xA4, 0xD9], [0xFB, 0xF8, 0xEC], [0xEA, 0x7A, 0x38]);
    let [blue, white, red] = [blue, white, red].map(|colour| colour.map(f64::from));
    if along < 0.5 { mix(blue, white, 2.0 * along) } else { mix(white, red, 2.0 * along - 1.0) }
}

/// `StepSizeUnderflow` in three lines, the short words together.
fn broken(name: &str) -> String {
    let mut text = String::new();
    for sign in name.chars() {
        if sign.is_uppercase() && text.lines().last().is_some_and(|line| line.len() > 3 || name.len() > 12) {
            text.push('\n');
        }
        text.push(sign);
    }
    text.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_follow_decades() {
        assert_eq!(colour(0.0), colour(1e-14));
        assert_eq!(colour(f64::NAN), colour(1e3));
        assert_ne!(colour(1e-6), colour(1e-5));
    }

    #[test]
    fn a_map_without_rows_is_an_error() {
        assert!(matches!(Map::new("", ["a"]).svg(), Err(ChartError::NoPoints)));
    }
}
