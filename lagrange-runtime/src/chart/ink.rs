//! Text, dashed lines and markers on plotters' canvas.

use super::font::{FAMILY, Font};
use super::palette::Look;
pub(super) use super::sheet::{Canvas, Drawn, FINE, Pixel, fine};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Widths of lines.
pub(super) const LINE: f64 = 1.8;
pub(super) const FAINT: f64 = 1.0;
/// Radius of a marker.
pub(super) const MARKER: f64 = 4.4;

pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);

/// Text whose baseline starts, has its middle, or ends at a point.
pub(super) fn write(
    canvas: &Canvas,
    text: &str,
    (x, y): (f64, f64),
    font: Font,
    colour: RGBColor,
    anchor: HPos,
) -> Drawn {
    canvas.draw(&Text::new(text, (fine(x), fine(y)), style(font, FontTransform::None, colour, anchor)))?;
    Ok(())
}

/// Text that reads upwards, its baseline's middle at a point.
pub(super) fn write_upwards(canvas: &Canvas, text: &str, (x, y): (f64, f64), font: Font) -> Drawn {
    canvas.draw(&Text::new(
        text,
        (fine(x), fine(y)),
        style(font, FontTransform::Rotate270, INK, HPos::Center),
    ))?;
    Ok(())
}

fn style(font: Font, turn: FontTransform, colour: RGBColor, anchor: HPos) -> TextStyle<'static> {
    let weight = if font.bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = FontDesc::new(FontFamily::Name(FAMILY), font.size * FINE, weight).transform(turn);
    TextStyle { font, color: colour.to_backend_color(), pos: Pos::new(anchor, VPos::Bottom) }
}

/// A dashed polyline.
pub(super) fn line(
    canvas: &Canvas,
    points: impl IntoIterator<Item = Pixel>,
    look: Look,
    width: f64,
) -> Drawn {
    let mut points: Vec<Pixel> = points.into_iter().collect();
    points.dedup();
    for dash in dashes(&points, look.dashes) {
        canvas.draw(&PathElement::new(dash, look.colour.stroke_width(fine(width) as u32)))?;
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
pub(super) fn marker(canvas: &Canvas, (x, y): Pixel, look: Look) -> Drawn {
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

/// A dot, for points that are too many to have shapes.
pub(super) fn dot(canvas: &Canvas, at: Pixel, radius: f64, look: Look) -> Drawn {
    canvas.draw(&Circle::new(at, fine(radius), look.colour.filled()))?;
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
