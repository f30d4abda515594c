//! A curve of a chart.

/// A named sequence of points, joined in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend. If no series has a name there is no legend.
    pub name: String,
    /// `(x, y)`.
    pub points: Vec<(f64, f64)>,
    /// Lines, markers or both.
    pub style: Style,
}

/// Style in which the points of a series are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A line with a marker at each point; of many points, at some of them.
    #[default]
    LineAndMarkers,
    /// A line alone, for time series and phase portraits.
    Line,
    /// Markers alone, dots if they are many: Poincaré sections.
    Markers,
    /// A thin grey line below the others, without an entry in the legend: what the others are compared with.
    Context,
    /// Cells of a map about the points, coloured by their series; all cells of a chart have one lattice, and the series
    /// are in order from light to dark.
    Cells,
}

impl Series {
    /// A line with markers.
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { name: name.into(), points: points.into_iter().collect(), style: Style::LineAndMarkers }
    }

    /// A line without markers.
    pub fn line(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { style: Style::Line, ..Self::new(name, points) }
    }

    /// The outline of bars, each from a left end to a right end and from 0 to a height, as of a histogram.
    pub fn bars(name: impl Into<String>, bars: impl IntoIterator<Item = (f64, f64, f64)>) -> Self {
        let corners = |(left, right, height)| [(left, 0.0), (left, height), (right, height), (right, 0.0)];
        Self::line(name, bars.into_iter().flat_map(corners))
    }

    /// Markers without a line.
    pub fn markers(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { style: Style::Markers, ..Self::new(name, points) }
    }

    /// Cells of a map about the points.
    pub fn cells(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { style: Style::Cells, ..Self::new(name, points) }
    }

    /// A thin grey line below the others, without an entry in the legend.
    pub fn context(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { style: Style::Context, ..Self::new("", points) }
    }
}
