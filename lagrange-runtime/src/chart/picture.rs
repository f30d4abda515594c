//! The drawing itself.

use super::axis::Ruler;
use super::cells::Lattice;
use super::ink::{
    Canvas, Drawn, FAINT, FINE, INK, LINE, MARKER, Pixel, dot, fine, line, marker, write, write_upwards,
};
use super::layout::{
    CAPTION, CAPTION_LINE, Frame, LEGEND, LEGEND_LINE, Layout, MARGIN, SAMPLE, SUBTITLE, SUBTITLE_LINE, TICK,
    TITLE, TITLE_LINE,
};
use super::palette::{Look, looks};
use super::sheet::Sheet;
use super::{Axis, Chart, ChartError, Scale, Series, Style};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

const GREY: RGBColor = RGBColor(0x55, 0x55, 0x55);
const GRID: RGBColor = RGBColor(0xDD, 0xDD, 0xDD);
const LIGHT_GRID: RGBColor = RGBColor(0xF1, 0xF1, 0xF1);

/// The chart in a frame.
pub(super) fn sheet(chart: &Chart, frame: Frame) -> Result<Sheet, ChartError> {
    let layout = Layout::of(chart, frame).ok_or(ChartError::NoPoints)?;
    Sheet::painted((layout.width, layout.height), |canvas| paint(chart, &layout, canvas))
}

fn paint(chart: &Chart, layout: &Layout, canvas: &Canvas) -> Drawn {
    canvas.fill(&WHITE)?;
    headings(&layout.title, &layout.subtitle, canvas)?;
    let looks = looks(&chart.series);
    let area = canvas.clone().shrink(
        (fine(layout.left), fine(layout.top)),
        (fine(layout.right - layout.left), fine(layout.bottom - layout.top)),
    );
    let (x, y) = (&layout.x, &layout.y);
    let data = ChartBuilder::on(&area).build_cartesian_2d(x.low..x.high, y.low..y.high)?;
    grid(chart, layout, canvas, |x, y| data.backend_coord(&(x, y)))?;
    if let Some(lattice) = Lattice::of(chart) {
        for (series, look) in
            chart.series.iter().zip(&looks).filter(|(series, _)| series.style == Style::Cells)
        {
            for place in series.points.iter().filter_map(|&point| chart.place(point)) {
                lattice.paint(canvas, place, look.colour, |x, y| data.backend_coord(&(x, y)))?;
            }
        }
    }
    axes(layout, canvas, |x, y| data.backend_coord(&(x, y)))?;
    let pixels = |point| chart.place(point).map(|place| data.backend_coord(&place));
    let drawn: Vec<Vec<Option<Pixel>>> = chart
        .series
        .iter()
        .map(|series| series.points.iter().map(|&point| pixels(point)).collect())
        .collect();
    let all = || chart.series.iter().zip(&looks).zip(&drawn);
    // What is there for comparison lies below everything else.
    let (context, others): (Vec<_>, Vec<_>) =
        all().partition(|((series, _), _)| series.style == Style::Context);
    for ((series, look), points) in context.into_iter().chain(others) {
        let width = match series.style {
            Style::Markers | Style::Cells => continue,
            Style::Context => FAINT,
            Style::Line | Style::LineAndMarkers => LINE,
        };
        for run in points.split(Option::is_none) {
            line(canvas, run.iter().flatten().copied(), *look, width)?;
        }
    }
    for (index, ((series, &look), points)) in all().enumerate() {
        let points: Vec<Pixel> = points.iter().flatten().copied().collect();
        match series.style {
            Style::Line | Style::Context | Style::Cells => {}
            Style::Markers if are_dots(series) => {
                points.iter().try_for_each(|&at| dot(canvas, at, 1.3, look))?;
            }
            // Markers that would touch each other say less than a few.
            Style::LineAndMarkers if points.len() > 40 => {
                let every = points.len().div_ceil(12);
                for &at in points.iter().skip(index * every / 8 % every).step_by(every) {
                    marker(canvas, at, look)?;
                }
            }
            _ => points.iter().try_for_each(|&at| marker(canvas, at, look))?,
        }
    }
    legend(chart, layout, &looks, canvas)
}

/// Title and subtitle, in lines.
pub(super) fn headings(title: &[String], subtitle: &[String], canvas: &Canvas) -> Drawn {
    let mut baseline = MARGIN + TITLE.size - 2.0;
    for text in title {
        write(canvas, text, (MARGIN, baseline), TITLE, INK, HPos::Left)?;
        baseline += TITLE_LINE;
    }
    for text in subtitle {
        write(canvas, text, (MARGIN, baseline - 3.0), SUBTITLE, GREY, HPos::Left)?;
        baseline += SUBTITLE_LINE;
    }
    Ok(())
}

/// A line at each labelled tick, and a fainter one at the others of a logarithmic axis, where their distances are the
/// scale.
fn grid(chart: &Chart, layout: &Layout, canvas: &Canvas, at: impl Fn(f64, f64) -> Pixel) -> Drawn {
    let (x, y) = (&layout.x, &layout.y);
    let labelled = |ruler: &Ruler| ruler.ticks.iter().map(|(place, _)| *place).collect();
    let others = |axis: &Axis, ruler: &Ruler| match axis.scale {
        Scale::Linear => Vec::new(),
        Scale::Log => ruler.minor.clone(),
    };
    let kinds: [(Vec<f64>, Vec<f64>, RGBColor); 2] =
        [(others(&chart.x, x), others(&chart.y, y), LIGHT_GRID), (labelled(x), labelled(y), GRID)];
    for (across, up, colour) in kinds {
        let vertical = across.into_iter().map(|place| vec![at(place, y.low), at(place, y.high)]);
        let horizontal = up.into_iter().map(|place| vec![at(x.low, place), at(x.high, place)]);
        for path in vertical.chain(horizontal) {
            canvas.draw(&PathElement::new(path, colour.stroke_width(fine(1.0) as u32)))?;
        }
    }
    Ok(())
}

/// Frame, ticks, their labels and the captions.
fn axes(layout: &Layout, canvas: &Canvas, at: impl Fn(f64, f64) -> Pixel) -> Drawn {
    let stroke = |path: Vec<Pixel>, width: f64| PathElement::new(path, INK.stroke_width(fine(width) as u32));
    let (x, y) = (&layout.x, &layout.y);
    let corner = at(x.low, y.low);
    canvas.draw(&stroke(vec![at(x.low, y.high), corner, at(x.high, y.low)], 1.2))?;
    for (place, label) in &x.ticks {
        let (px, py) = at(*place, y.low);
        canvas.draw(&stroke(vec![(px, py), (px, py + fine(5.0))], 1.2))?;
        let baseline = layout.bottom + 9.0 + TICK.size;
        write(canvas, label, (f64::from(px) / FINE, baseline), TICK, INK, HPos::Center)?;
    }
    for (place, label) in &y.ticks {
        let (px, py) = at(x.low, *place);
        canvas.draw(&stroke(vec![(px, py), (px - fine(5.0), py)], 1.2))?;
        let baseline = f64::from(py) / FINE + 0.36 * TICK.size;
        write(canvas, label, (layout.left - 9.0, baseline), TICK, INK, HPos::Right)?;
    }
    for place in &x.minor {
        let (px, py) = at(*place, y.low);
        canvas.draw(&stroke(vec![(px, py), (px, py + fine(3.0))], 0.8))?;
    }
    for place in &y.minor {
        let (px, py) = at(x.low, *place);
        canvas.draw(&stroke(vec![(px, py), (px - fine(3.0), py)], 0.8))?;
    }
    let (across, up) = (layout.right - layout.left, layout.bottom - layout.top);
    for (i, text) in layout.x_caption.iter().enumerate() {
        let baseline = layout.bottom + 9.0 + TICK.size + 8.0 + CAPTION_LINE * i as f64 + CAPTION.size + 2.0;
        let at = (layout.left + 0.5 * across, baseline);
        write(canvas, text, at, CAPTION.fit(text, across), INK, HPos::Center)?;
    }
    for (i, text) in layout.y_caption.iter().enumerate() {
        let baseline = MARGIN + CAPTION_LINE * i as f64 + CAPTION.size - 2.0;
        write_upwards(canvas, text, (baseline, layout.top + 0.5 * up), CAPTION.fit(text, up))?;
    }
    Ok(())
}

fn legend(chart: &Chart, layout: &Layout, looks: &[Look], canvas: &Canvas) -> Drawn {
    for (index, top, lines) in &layout.entries {
        let (look, style) = (looks[*index], chart.series[*index].style);
        let left = layout.legend;
        let height = fine(top + 0.5 * LEGEND_LINE);
        if style == Style::Cells {
            let (across, up) = (fine(left + SAMPLE), fine(0.42 * LEGEND_LINE));
            let corners = [(fine(left), height - up), (across, height + up)];
            canvas.draw(&Rectangle::new(corners, look.colour.filled()))?;
        } else if style != Style::Markers {
            line(canvas, [(fine(left), height), (fine(left + SAMPLE), height)], look, LINE)?;
        }
        let middle = (fine(left + 0.5 * SAMPLE), height);
        match style {
            Style::Line | Style::Context | Style::Cells => {}
            Style::Markers if are_dots(&chart.series[*index]) => dot(canvas, middle, MARKER, look)?,
            _ => marker(canvas, middle, look)?,
        }
        for (i, text) in lines.iter().enumerate() {
            let baseline = top + (i as f64 + 0.5) * LEGEND_LINE + 0.36 * LEGEND.size;
            write(canvas, text, (left + SAMPLE + 10.0, baseline), LEGEND, INK, HPos::Left)?;
        }
    }
    Ok(())
}

/// Returns whether the markers of a series are too many to have shapes.
fn are_dots(series: &Series) -> bool {
    series.style == Style::Markers && series.points.len() > 150
}
