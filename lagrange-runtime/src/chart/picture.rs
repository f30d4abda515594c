//! The drawing itself: plotters makes an SVG, usvg turns its text into paths, resvg makes the PNG of it.

use super::axis::Ruler;
use super::font::{FAMILY, Font, options};
use super::layout::{
    CAPTION, LEGEND, LEGEND_LINE, Layout, SAMPLE, SUBTITLE, SUBTITLE_LINE, TICK, TITLE, TITLE_LINE,
};
use super::palette::{Look, look};
use super::{Axis, Chart, ChartError, Scale, Series, Style};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use resvg::{tiny_skia, usvg};

/// Plotters has integer pixels: it draws on ten times as many, lest curves have steps.
const FINE: f64 = 10.0;
/// Pixels of the PNG for one of the SVG.
const DENSITY: f32 = 2.0;

const LINE: f64 = 1.8;
const MARKER: f64 = 4.4;

const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const GREY: RGBColor = RGBColor(0x55, 0x55, 0x55);
const GRID: RGBColor = RGBColor(0xDD, 0xDD, 0xDD);
const LIGHT_GRID: RGBColor = RGBColor(0xF1, 0xF1, 0xF1);

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Pixel = (i32, i32);
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// SVG and PNG of the chart.
pub(super) fn draw(chart: &Chart) -> Result<(String, Vec<u8>), ChartError> {
    let layout = Layout::of(chart).ok_or(ChartError::NoPoints)?;
    let fine = (fine(layout.width), fine(layout.height));
    let mut svg = String::new();
    let canvas = SVGBackend::with_string(&mut svg, (fine.0 as u32, fine.1 as u32)).into_drawing_area();
    let drawn = paint(chart, &layout, &canvas);
    drop(canvas);
    drawn.and_then(|()| convert(&svg, fine, &layout)).map_err(|error| ChartError::Render(error.to_string()))
}

/// Text to paths, paths to pixels.
fn convert(
    svg: &str,
    (width, height): Pixel,
    layout: &Layout,
) -> Result<(String, Vec<u8>), Box<dyn std::error::Error>> {
    let svg = svg.replacen(
        &format!("width=\"{width}\" height=\"{height}\""),
        &format!("width=\"{}\" height=\"{}\" stroke-linejoin=\"round\"", layout.width, layout.height),
        1,
    );
    let tree = usvg::Tree::from_str(&svg, &options())?;
    let written = usvg::WriteOptions {
        coordinates_precision: 1,
        transforms_precision: 4,
        indent: usvg::Indent::Spaces(1),
        ..Default::default()
    };
    let size = tree.size().to_int_size().scale_by(DENSITY).ok_or("no size")?;
    let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height()).ok_or("no memory")?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(DENSITY, DENSITY), &mut pixels.as_mut());
    // usvg leaves the view box out, without which an SVG is cropped rather than scaled.
    let view = format!("<svg viewBox=\"0 0 {} {}\"", layout.width, layout.height);
    Ok((tree.to_string(&written).replacen("<svg", &view, 1), pixels.encode_png()?))
}

fn paint(chart: &Chart, layout: &Layout, canvas: &Canvas) -> Drawn {
    canvas.fill(&WHITE)?;
    headings(layout, canvas)?;
    let area = canvas.clone().shrink(
        (fine(layout.left), fine(layout.top)),
        (fine(layout.right - layout.left), fine(layout.bottom - layout.top)),
    );
    let (x, y) = (&layout.x, &layout.y);
    let data = ChartBuilder::on(&area).build_cartesian_2d(x.low..x.high, y.low..y.high)?;
    grid(chart, layout, canvas, |x, y| data.backend_coord(&(x, y)))?;
    axes(chart, layout, canvas, |x, y| data.backend_coord(&(x, y)))?;
    let pixels = |point| chart.place(point).map(|place| data.backend_coord(&place));
    let drawn: Vec<Vec<Option<Pixel>>> = chart
        .series
        .iter()
        .map(|series| series.points.iter().map(|&point| pixels(point)).collect())
        .collect();
    for (index, (series, points)) in chart.series.iter().zip(&drawn).enumerate() {
        if series.style != Style::Markers {
            for run in points.split(Option::is_none) {
                line(canvas, run.iter().flatten().copied(), look(index))?;
            }
        }
    }
    for (index, (series, points)) in chart.series.iter().zip(&drawn).enumerate() {
        let points: Vec<Pixel> = points.iter().flatten().copied().collect();
        match series.style {
            Style::Line => {}
            Style::Markers if are_dots(series) => {
                points.iter().try_for_each(|&at| dot(canvas, at, 1.3, look(index)))?;
            }
            // Markers that would touch each other say less than a few.
            Style::LineAndMarkers if points.len() > 40 => {
                let every = points.len().div_ceil(12);
                for &at in points.iter().skip(index * every / 8 % every).step_by(every) {
                    marker(canvas, at, look(index))?;
                }
            }
            _ => points.iter().try_for_each(|&at| marker(canvas, at, look(index)))?,
        }
    }
    legend(chart, layout, canvas)?;
    canvas.present()?;
    Ok(())
}

fn headings(layout: &Layout, canvas: &Canvas) -> Drawn {
    let mut baseline = layout.margin() + TITLE.size - 2.0;
    for text in &layout.title {
        write(canvas, text, (layout.margin(), baseline), TITLE, INK, HPos::Left)?;
        baseline += TITLE_LINE;
    }
    for text in &layout.subtitle {
        write(canvas, text, (layout.margin(), baseline - 3.0), SUBTITLE, GREY, HPos::Left)?;
        baseline += SUBTITLE_LINE;
    }
    Ok(())
}

/// A line at each labelled tick, and a fainter one at the others of a logarithmic axis, where their distances are the scale.
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
fn axes(chart: &Chart, layout: &Layout, canvas: &Canvas, at: impl Fn(f64, f64) -> Pixel) -> Drawn {
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
    let caption = chart.x.caption();
    let font = CAPTION.fit(&caption, layout.right - layout.left);
    let middle = 0.5 * (layout.left + layout.right);
    let baseline = layout.bottom + 9.0 + TICK.size + 10.0 + CAPTION.size;
    write(canvas, &caption, (middle, baseline), font, INK, HPos::Center)?;
    let caption = chart.y.caption();
    let font = CAPTION.fit(&caption, layout.bottom - layout.top);
    let middle = 0.5 * (layout.top + layout.bottom);
    write_upwards(canvas, &caption, (layout.margin() + CAPTION.size - 2.0, middle), font)
}

fn legend(chart: &Chart, layout: &Layout, canvas: &Canvas) -> Drawn {
    for (index, top, lines) in &layout.entries {
        let (look, style) = (look(*index), chart.series[*index].style);
        let left = layout.legend;
        let height = fine(top + 0.5 * LEGEND_LINE);
        if style != Style::Markers {
            line(canvas, [(fine(left), height), (fine(left + SAMPLE), height)], look)?;
        }
        let middle = (fine(left + 0.5 * SAMPLE), height);
        match style {
            Style::Line => {}
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

fn fine(pixels: f64) -> i32 {
    (pixels * FINE).round() as i32
}

/// Text whose baseline starts, has its middle, or ends at a point.
fn write(
    canvas: &Canvas,
    text: &str,
    (x, y): (f64, f64),
    font: Font,
    colour: RGBColor,
    anchor: HPos,
) -> Drawn {
    // Of the anchors of plotters' SVG, `Bottom` is the one at a known distance, 0.5 ex = 0.25 em, above the baseline.
    let at = (fine(x), fine(y + 0.25 * font.size));
    canvas.draw(&Text::new(text, at, style(font, FontTransform::None, colour, anchor)))?;
    Ok(())
}

/// Text that reads upwards, its baseline's middle at a point.
fn write_upwards(canvas: &Canvas, text: &str, (x, y): (f64, f64), font: Font) -> Drawn {
    let at = (fine(x + 0.25 * font.size), fine(y));
    canvas.draw(&Text::new(text, at, style(font, FontTransform::Rotate270, INK, HPos::Center)))?;
    Ok(())
}

fn style(font: Font, turn: FontTransform, colour: RGBColor, anchor: HPos) -> TextStyle<'static> {
    let weight = if font.bold { FontStyle::Bold } else { FontStyle::Normal };
    // Plotters' sizes are those of the line, 1.24 of the font's.
    let font = FontDesc::new(FontFamily::Name(FAMILY), font.size * FINE * 1.24, weight).transform(turn);
    TextStyle { font, color: colour.to_backend_color(), pos: Pos::new(anchor, VPos::Bottom) }
}

/// A dashed polyline.
fn line(canvas: &Canvas, points: impl IntoIterator<Item = Pixel>, look: Look) -> Drawn {
    let mut points: Vec<Pixel> = points.into_iter().collect();
    points.dedup();
    for dash in dashes(&points, look.dashes) {
        canvas.draw(&PathElement::new(dash, look.colour.stroke_width(fine(LINE) as u32)))?;
    }
    Ok(())
}

/// The strokes of a dashed polyline, for lengths of strokes and gaps by turns (none: one stroke).
fn dashes(points: &[Pixel], pattern: &[f64]) -> Vec<Vec<Pixel>> {
    if pattern.is_empty() || points.len() < 2 {
        return vec![points.to_vec()];
    }
    let (mut strokes, mut stroke) = (Vec::new(), vec![points[0]]);
    let (mut turn, mut left) = (0, pattern[0] * FINE);
    for ends in points.windows(2) {
        let [(x0, y0), (x1, y1)] = [ends[0], ends[1]].map(|(x, y)| (f64::from(x), f64::from(y)));
        let length = (x1 - x0).hypot(y1 - y0);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let at = ((x0 + (x1 - x0) * done / length) as i32, (y0 + (y1 - y0) * done / length) as i32);
            stroke.push(at);
            if turn % 2 == 0 {
                strokes.push(std::mem::take(&mut stroke));
            }
            stroke = vec![at];
            turn = (turn + 1) % pattern.len();
            left = pattern[turn] * FINE;
        }
        left -= length - done;
        stroke.push(ends[1]);
    }
    if turn % 2 == 0 {
        strokes.push(stroke);
    }
    strokes
}

/// A marker with a white rim, which keeps it apart from the lines and markers below.
fn marker(canvas: &Canvas, (x, y): Pixel, look: Look) -> Drawn {
    let shape = |radius: f64, colour: RGBColor| -> Drawn {
        if look.marker.is_empty() {
            canvas.draw(&Circle::new((x, y), fine(radius), colour.filled()))?;
        } else {
            let corner = |&(dx, dy): &(f64, f64)| (x + fine(dx * radius), y + fine(dy * radius));
            canvas
                .draw(&Polygon::new(look.marker.iter().map(corner).collect::<Vec<_>>(), colour.filled()))?;
        }
        Ok(())
    };
    shape(MARKER + 1.1, WHITE)?;
    shape(MARKER, look.colour)?;
    if look.open { shape(MARKER * 0.55, WHITE) } else { Ok(()) }
}

/// Whether the markers of a series are too many to have shapes.
fn are_dots(series: &Series) -> bool {
    series.style == Style::Markers && series.points.len() > 150
}

/// A dot. Its eight corners look round at that size, and are a third of a circle's text in the SVG.
fn dot(canvas: &Canvas, (x, y): Pixel, radius: f64, look: Look) -> Drawn {
    let corner = |i: i32| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
        (x + fine(radius * cos), y + fine(radius * sin))
    };
    canvas.draw(&Polygon::new((0..8).map(corner).collect::<Vec<_>>(), look.colour.filled()))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_go_around_corners() {
        let corner = [(0, 0), (100, 0), (100, 100)];
        assert_eq!(dashes(&corner, &[]), [corner.to_vec()]);
        assert_eq!(dashes(&corner, &[8.0, 4.0]), [vec![(0, 0), (80, 0)], vec![(100, 20), (100, 100)]]);
    }
}
