//! A sheet of marks: plotters draws on it, `svg` and `png` make files of it.

use super::error::ChartError;
use super::font::{Font, Placed, UNITS};
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, DrawingBackend, IntoDrawingArea};
use plotters::style::text_anchor::HPos;
use plotters_backend::{
    BackendColor, BackendStyle, BackendTextStyle, DrawingErrorKind, FontStyle, FontTransform,
};
use std::convert::Infallible;

/// Plotters has integer pixels: it draws on ten times as many, lest curves have steps.
pub(super) const FINE: f64 = 10.0;

pub(super) type Canvas<'a> = DrawingArea<Paper<'a>, Shift>;

pub(super) type Pixel = (i32, i32);

pub(super) type Drawn = Result<(), Box<dyn std::error::Error>>;

pub(super) fn fine(pixels: f64) -> i32 {
    (pixels * FINE).round() as i32
}

/// Marks from the background to the foreground, on a sheet of that size in pixels.
pub(super) struct Sheet {
    pub width: f64,
    pub height: f64,
    pub marks: Vec<Mark>,
}

/// One mark, in fine pixels.
pub(super) struct Mark {
    pub shape: Shape,
    pub colour: (u8, u8, u8),
    pub opacity: f64,
}

pub(super) enum Shape {
    Polygon(Vec<Pixel>),
    Disk { centre: Pixel, radius: u32 },
    Line { points: Vec<Pixel>, width: u32 },
    Text(Text),
}

/// Text on one line.
pub(super) struct Text {
    pub text: String,
    pub font: Font,
    /// The start, the middle or the end of the baseline, as the anchor says.
    pub at: Pixel,
    pub anchor: HPos,
    /// Turned by a quarter to the left.
    pub upwards: bool,
}

impl Text {
    /// Its glyphs, at their places from the anchor in units of the font.
    pub(super) fn glyphs(&self) -> Vec<Placed> {
        let (mut glyphs, end) = self.font.set(&self.text);
        for glyph in &mut glyphs {
            glyph.x -= before(self.anchor) * end;
        }
        glyphs
    }

    /// Fine pixels to a unit of the font.
    pub(super) fn scale(&self) -> f64 {
        self.font.size * FINE / UNITS
    }
}

/// The part of a text that lies before its anchor.
pub(super) fn before(anchor: HPos) -> f64 {
    match anchor {
        HPos::Left => 0.0,
        HPos::Center => 0.5,
        HPos::Right => 1.0,
    }
}

impl Sheet {
    /// The marks that are painted on a canvas of that size in pixels.
    pub(super) fn painted(
        (width, height): (f64, f64),
        paint: impl FnOnce(&Canvas) -> Drawn,
    ) -> Result<Sheet, ChartError> {
        let mut sheet = Sheet { width, height, marks: Vec::new() };
        let canvas = Paper(&mut sheet).into_drawing_area();
        let drawn = paint(&canvas);
        drop(canvas);
        drawn.map(|()| sheet).map_err(|error| ChartError::Render(error.to_string()))
    }

    /// Adds the marks of another sheet, whose corner comes to that pixel.
    pub(super) fn place(&mut self, other: Sheet, (x, y): (f64, f64)) {
        let (dx, dy) = (fine(x), fine(y));
        let shift = |(x, y): &mut Pixel| (*x, *y) = (*x + dx, *y + dy);
        for mut mark in other.marks {
            match &mut mark.shape {
                Shape::Polygon(points) | Shape::Line { points, .. } => points.iter_mut().for_each(shift),
                Shape::Disk { centre: at, .. } | Shape::Text(Text { at, .. }) => shift(at),
            }
            self.marks.push(mark);
        }
    }
}

/// The side of the sheet that plotters knows.
pub(super) struct Paper<'a>(&'a mut Sheet);

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl Paper<'_> {
    fn add(&mut self, shape: Shape, colour: BackendColor) -> Done {
        self.0.marks.push(Mark { shape, colour: colour.rgb, opacity: colour.alpha });
        Ok(())
    }
}

impl DrawingBackend for Paper<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (fine(self.0.width) as u32, fine(self.0.height) as u32)
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): Pixel, colour: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: Pixel, to: Pixel, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): Pixel,
        (right, bottom): Pixel,
        style: &S,
        fill: bool,
    ) -> Done {
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        if fill { self.fill_polygon(corners[..4].to_vec(), style) } else { self.draw_path(corners, style) }
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = Pixel>>(&mut self, path: I, style: &S) -> Done {
        let points: Vec<Pixel> = path.into_iter().collect();
        // A point alone, between others that cannot be drawn, has no line.
        if points.len() < 2 {
            return Ok(());
        }
        self.add(Shape::Line { points, width: style.stroke_width() }, style.color())
    }

    /// Disks alone: nothing draws a circle's outline.
    fn draw_circle<S: BackendStyle>(&mut self, centre: Pixel, radius: u32, style: &S, _: bool) -> Done {
        self.add(Shape::Disk { centre, radius }, style.color())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = Pixel>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Done {
        self.add(Shape::Polygon(corners.into_iter().collect()), style.color())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: Pixel) -> Done {
        let bold = matches!(style.style(), FontStyle::Bold);
        let text = Text {
            text: text.to_owned(),
            font: Font { size: style.size() / FINE, bold },
            at,
            anchor: style.anchor().h_pos,
            upwards: matches!(style.transform(), FontTransform::Rotate270),
        };
        self.add(Shape::Text(text), style.color())
    }
}
