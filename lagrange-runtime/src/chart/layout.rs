//! Layout of a chart, in pixels: the data get what the labels and the legend beside it leave.

use super::axis::Ruler;
use super::cells::Lattice;
use super::font::Font;
use super::{Chart, Scale, Series, Style};

/// The width that a chart is given.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub width: f64,
    /// The least width of its legend, so that charts beside each other have axes of one length.
    pub legend: f64,
}

/// Frame of a chart by itself. Printed 16 cm wide, 14 px are 7.5 points.
pub(super) const ALONE: Frame = Frame { width: 840.0, legend: 0.0 };
const PLOT_HEIGHT: f64 = 410.0;
pub(super) const MARGIN: f64 = 18.0;

pub(super) const TITLE: Font = Font::bold(19.0);
pub(super) const SUBTITLE: Font = Font::regular(14.5);
pub(super) const CAPTION: Font = Font::regular(16.0);
pub(super) const TICK: Font = Font::regular(14.0);
pub(super) const LEGEND: Font = Font::regular(14.5);

pub(super) const TITLE_LINE: f64 = 25.0;
pub(super) const SUBTITLE_LINE: f64 = 20.0;
pub(super) const CAPTION_LINE: f64 = 20.0;
pub(super) const LEGEND_LINE: f64 = 18.0;
const LEGEND_GAP: f64 = 8.0;
/// Length of the sample of a series in the legend.
pub(super) const SAMPLE: f64 = 44.0;

pub(super) struct Layout {
    pub width: f64,
    pub height: f64,
    pub title: Vec<String>,
    pub subtitle: Vec<String>,
    /// Edges of the data.
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub x: Ruler,
    pub y: Ruler,
    /// Captions of the axes, in lines.
    pub x_caption: Vec<String>,
    pub y_caption: Vec<String>,
    /// Left edge of the legend.
    pub legend: f64,
    /// Entries of the legend: index of the series, top of the entry, name in lines.
    pub entries: Vec<(usize, f64, Vec<String>)>,
}

impl Layout {
    /// `None` if there is nothing to draw.
    pub(super) fn of(chart: &Chart, frame: Frame) -> Option<Layout> {
        let (mut x_extent, mut y_extent) = extents(chart)?;
        let title = TITLE.wrap(&chart.title, frame.width - 2.0 * MARGIN);
        let subtitle = SUBTITLE.wrap(&chart.subtitle, frame.width - 2.0 * MARGIN);
        let heading = TITLE_LINE * title.len() as f64 + SUBTITLE_LINE * subtitle.len() as f64;
        let top = MARGIN + heading + 12.0;

        let (entries, legend_width, legend_height) = legend(chart, top);
        let legend_width = legend_width.max(frame.legend);
        let right = frame.width - MARGIN - if legend_width == 0.0 { 14.0 } else { legend_width + 20.0 };

        let equal = chart.equal_aspect && chart.x.scale == Scale::Linear && chart.y.scale == Scale::Linear;
        let mut height = PLOT_HEIGHT.max(legend_height);
        let mut y = chart.y.ruler(y_extent, y_labels(chart, height));
        let (mut left, mut y_caption) = (0.0, Vec::new());
        // Twice: the labels of the vertical axis take width from the data, and with equal units thereby height.
        for _ in 0..2 {
            let labels = y.ticks.iter().map(|(_, label)| TICK.width(label)).fold(0.0, f64::max);
            y_caption = CAPTION.wrap(&chart.y.caption(), height);
            left = MARGIN + CAPTION_LINE * y_caption.len() as f64 + 8.0 + labels + 9.0;
            if equal {
                let width = right - left;
                let natural = width * (y_extent.1 - y_extent.0) / (x_extent.1 - x_extent.0);
                height = natural.clamp(legend_height.max(0.3 * width), legend_height.max(1.05 * width));
                let unit = ((x_extent.1 - x_extent.0) / width).max((y_extent.1 - y_extent.0) / height);
                x_extent = widened(x_extent, unit * width);
                y_extent = widened(y_extent, unit * height);
            }
            y = chart.y.ruler(y_extent, y_labels(chart, height));
        }
        let most = (right - left) / if chart.x.scale == Scale::Log { 50.0 } else { 62.0 };
        let x = chart.x.ruler(x_extent, most);
        let x_caption = CAPTION.wrap(&chart.x.caption(), right - left);
        let bottom = top + height;
        let below = 9.0 + TICK.size + 8.0 + CAPTION_LINE * x_caption.len() as f64;
        Some(Layout {
            width: frame.width,
            height: (bottom + below + MARGIN).ceil(),
            title,
            subtitle,
            left,
            right,
            top,
            bottom,
            x,
            y,
            x_caption,
            y_caption,
            legend: right + 20.0,
            entries,
        })
    }
}

fn y_labels(chart: &Chart, height: f64) -> f64 {
    height / if chart.y.scale == Scale::Log { 22.0 } else { 48.0 }
}

/// The smallest extents that hold every point that can be drawn, with air, and all cells.
#[allow(clippy::type_complexity)]
fn extents(chart: &Chart) -> Option<((f64, f64), (f64, f64))> {
    let others = chart.series.iter().filter(|series| series.style != Style::Cells);
    let places = others.flat_map(|series| &series.points).filter_map(|&point| chart.place(point));
    let grow = |(low, high): (f64, f64), place: f64| (low.min(place), high.max(place));
    let points =
        places.map(|(x, y)| ((x, x), (y, y))).reduce(|(x, y), ((px, _), (py, _))| (grow(x, px), grow(y, py)));
    let curves = points.map(|(x, y)| (chart.x.extent(x.0, x.1), chart.y.extent(y.0, y.1)));
    let cells = Lattice::of(chart).map(|lattice| lattice.extents());
    let both = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
    match (curves, cells) {
        (Some((x, y)), Some([cells_x, cells_y])) => Some((both(x, cells_x), both(y, cells_y))),
        (None, Some([x, y])) => Some((x, y)),
        (curves, None) => curves,
    }
}

fn widened((low, high): (f64, f64), span: f64) -> (f64, f64) {
    let middle = 0.5 * (low + high);
    (middle - 0.5 * span, middle + 0.5 * span)
}

/// The width of a chart's legend; 0 if it has none.
pub(super) fn legend_width(chart: &Chart) -> f64 {
    legend(chart, 0.0).1
}

/// The entries from `top` down, with their width and height.
#[allow(clippy::type_complexity)]
fn legend(chart: &Chart, top: f64) -> (Vec<(usize, f64, Vec<String>)>, f64, f64) {
    let (mut entries, mut width, mut below) = (Vec::new(), 0.0_f64, top);
    let shown = |(_, series): &(usize, &Series)| !series.name.is_empty() && series.style != Style::Context;
    for (index, series) in chart.series.iter().enumerate().filter(shown) {
        let lines = LEGEND.wrap(&series.name, 200.0);
        width = lines.iter().map(|line| LEGEND.width(line)).fold(width, f64::max);
        let height = LEGEND_LINE * lines.len() as f64 + LEGEND_GAP;
        entries.push((index, below, lines));
        below += height;
    }
    let width = if entries.is_empty() { 0.0 } else { SAMPLE + 10.0 + width };
    (entries, width, below - top)
}
