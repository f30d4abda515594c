//! Small multiples: charts of one kind side by side, for more curves than one picture holds (Tufte, *The Visual
//! Display of Quantitative Information*, 1983).

use super::layout::{ALONE, Frame, MARGIN, SUBTITLE, SUBTITLE_LINE, TITLE, TITLE_LINE, legend_width};
use super::picture::{self, headings};
use super::sheet::Sheet;
use super::svg::Letters;
use super::{Chart, ChartError, Style, field, write_files};
use plotters::prelude::*;
use std::fmt::Write as _;
use std::path::Path;

/// Width of one of several panels.
const PANEL: f64 = 700.0;
const COLUMNS: usize = 2;

/// Charts under one heading, two in a row. What is a chart's own is coloured in it; what it is to be compared with
/// comes as [`Style::Context`], which also makes axes equal.
///
/// ```
/// use lagrange_runtime::chart::{Axis, Chart, Panels, Series};
/// let curve = |p: i32| (1..10).map(move |n| (f64::from(n), f64::from(n).powi(-p)));
/// let panel = |p| {
///     Chart::new(format!("Order {p}"), Axis::log("steps", ""), Axis::log("error", ""))
///         .with(Series::context(curve(6 - p)))
///         .with(Series::new("method", curve(p)))
/// };
/// let panels = Panels::new("Two orders", [panel(2), panel(4)]);
/// assert!(panels.svg()?.contains("<svg"));
/// assert_eq!(panels.csv().lines().count(), 1 + 2 * 9);
/// # Ok::<(), lagrange_runtime::chart::ChartError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Panels {
    /// Heading.
    pub title: String,
    /// Subtitle. May be empty.
    pub subtitle: String,
    /// Row by row.
    pub charts: Vec<Chart>,
}

impl Panels {
    /// These charts under one heading.
    pub fn new(title: impl Into<String>, charts: impl IntoIterator<Item = Chart>) -> Self {
        Self { title: title.into(), subtitle: String::new(), charts: charts.into_iter().collect() }
    }

    /// Sets the subtitle.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Writes `stem.svg`, `stem.png` and `stem.csv` into the folder `dir`, which must exist.
    ///
    /// # Errors
    /// If a chart has nothing to draw (then nothing is written), or if a file cannot be written.
    pub fn write(&self, dir: impl AsRef<Path>, stem: &str) -> Result<(), ChartError> {
        write_files(dir.as_ref(), stem, &self.sheet()?, &self.csv())
    }

    /// The panels as SVG, their text as paths.
    ///
    /// # Errors
    /// If a chart has nothing to draw.
    pub fn svg(&self) -> Result<String, ChartError> {
        Ok(self.sheet()?.svg(Letters::Outlines))
    }

    /// All points but those of [`Style::Context`] as comma-separated values: title of the panel, name of the series,
    /// both values, headed by the axes of the first chart.
    pub fn csv(&self) -> String {
        let axes = self.charts.first().map(|chart| (field(&chart.x.caption()), field(&chart.y.caption())));
        let (x, y) = axes.unwrap_or_default();
        let mut csv = format!("panel,series,{x},{y}\n");
        for chart in &self.charts {
            for series in chart.series.iter().filter(|series| series.style != Style::Context) {
                let (panel, name) = (field(&chart.title), field(&series.name));
                for (x, y) in &series.points {
                    let _ = writeln!(csv, "{panel},{name},{x:?},{y:?}");
                }
            }
        }
        csv
    }

    /// The panels as SVG with their text as text, for a page of HTML: a fraction as long, and it can be searched, but
    /// letters are those of the reader's fonts.
    ///
    /// # Errors
    /// If a chart has nothing to draw.
    pub fn svg_with_text(&self) -> Result<String, ChartError> {
        Ok(self.sheet()?.svg(Letters::Text))
    }

    fn sheet(&self) -> Result<Sheet, ChartError> {
        let legend = self.charts.iter().map(legend_width).fold(0.0, f64::max);
        let panel = if self.charts.len() > 1 { PANEL } else { ALONE.width };
        let panels = self.charts.iter().map(|chart| picture::sheet(chart, Frame { width: panel, legend }));
        let panels = panels.collect::<Result<Vec<Sheet>, _>>()?;
        if panels.is_empty() {
            return Err(ChartError::NoPoints);
        }
        let width = panel * panels.len().min(COLUMNS) as f64;
        let title = TITLE.wrap(&self.title, width - 2.0 * MARGIN);
        let subtitle = SUBTITLE.wrap(&self.subtitle, width - 2.0 * MARGIN);

        let heading = MARGIN + TITLE_LINE * title.len() as f64 + SUBTITLE_LINE * subtitle.len() as f64;
        let rows = panels.chunks(COLUMNS).map(|row| row.iter().map(|part| part.height).fold(0.0, f64::max));
        let rows: Vec<f64> = rows.collect();
        let size = (width, heading + rows.iter().sum::<f64>());
        let mut sheet = Sheet::painted(size, |canvas| {
            canvas.fill(&WHITE)?;
            headings(&title, &subtitle, canvas)?;
            Ok(())
        })?;
        for (index, part) in panels.into_iter().enumerate() {
            let (row, column) = (index / COLUMNS, index % COLUMNS);
            let above: f64 = rows[..row].iter().sum();
            sheet.place(part, (panel * column as f64, heading + above));
        }
        Ok(sheet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Axis, Series};

    fn chart(name: &str) -> Chart {
        Chart::new(name, Axis::log("time", "s"), Axis::log("error", ""))
            .with(Series::context([(1.0, 1e-3), (10.0, 1e-9)]))
            .with(Series::new(format!("{name}, 1"), [(1.0, 1e-2), (10.0, 1e-4)]))
    }

    #[test]
    fn csv_names_panels_and_leaves_context_out() {
        let csv = Panels::new("", [chart("a"), chart("b")]).csv();
        assert_eq!(
            csv,
            "panel,series,time (s),error\na,\"a, 1\",1.0,0.01\na,\"a, 1\",10.0,0.0001\n\
             b,\"b, 1\",1.0,0.01\nb,\"b, 1\",10.0,0.0001\n"
        );
    }

    #[test]
    fn a_row_more_is_higher_and_not_wider() {
        let size = |n: usize| {
            let svg = Panels::new("Title", vec![chart("a"); n]).svg().unwrap();
            let view = svg.split('"').nth(1).unwrap().to_owned();
            let numbers: Vec<f64> = view.split(' ').map(|word| word.parse().unwrap()).collect();
            (numbers[2], numbers[3])
        };
        assert_eq!(size(2).0, size(3).0);
        assert!(size(3).1 > 1.8 * size(2).1);
        assert_eq!(size(1).0, ALONE.width);
    }

    #[test]
    fn text_may_stay_text() {
        let panels = Panels::new("A title", [chart("a"), chart("b")]);
        let (paths, text) = (panels.svg().unwrap(), panels.svg_with_text().unwrap());
        assert!(!paths.contains("<text") && text.contains("A title"));
        assert!(text.len() < paths.len() / 2);
    }

    #[test]
    fn an_empty_panel_is_an_error() {
        assert!(matches!(Panels::new("", []).svg(), Err(ChartError::NoPoints)));
        let empty = Chart::new("", Axis::log("", ""), Axis::log("", ""));
        assert!(matches!(Panels::new("", [chart("a"), empty]).svg(), Err(ChartError::NoPoints)));
    }
}
