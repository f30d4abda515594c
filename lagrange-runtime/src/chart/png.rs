//! A sheet as PNG.

use super::ChartError;
use super::ink::{FINE, Pixel};
use super::sheet::{Mark, Shape, Sheet, Text};
use tiny_skia::{Color, FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

/// Pixels of the PNG for one of the sheet.
const DENSITY: f64 = 2.0;

impl Sheet {
    pub(super) fn png(&self) -> Result<Vec<u8>, ChartError> {
        let [width, height] = [self.width, self.height].map(|length| (length * DENSITY).ceil() as u32);
        let mut pixels =
            Pixmap::new(width, height).ok_or_else(|| ChartError::Render("the picture has no size".into()))?;
        for mark in &self.marks {
            draw(mark, &mut pixels);
        }
        pixels.encode_png().map_err(|error| ChartError::Render(error.to_string()))
    }
}

fn draw(mark: &Mark, pixels: &mut Pixmap) {
    let (r, g, b) = mark.colour;
    let mut paint = Paint::default();
    paint.set_color(Color::from_rgba8(r, g, b, (255.0 * mark.opacity).round() as u8));
    let scale = (DENSITY / FINE) as f32;
    let fine = Transform::from_scale(scale, scale);
    let mut fill = |path: Option<Path>, transform: Transform| {
        if let Some(path) = path {
            pixels.fill_path(&path, &paint, FillRule::Winding, transform, None);
        }
    };
    match &mark.shape {
        Shape::Polygon(corners) => fill(polyline(corners, true), fine),
        Shape::Disk { centre: (x, y), radius } => {
            fill(PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32), fine);
        }
        Shape::Line { points, width } => {
            let stroke = Stroke { width: *width as f32, line_join: LineJoin::Round, ..Stroke::default() };
            if let Some(path) = polyline(points, false) {
                pixels.stroke_path(&path, &paint, &stroke, fine, None);
            }
        }
        Shape::Text(text) => {
            let Text { font, at: (x, y), upwards, .. } = text;
            let turn = Transform::from_rotate(if *upwards { -90.0 } else { 0.0 });
            let size = text.scale() as f32;
            let line = fine.pre_translate(*x as f32, *y as f32).pre_concat(turn).pre_scale(size, size);
            for glyph in text.glyphs() {
                let (x, y) = (glyph.x as f32, glyph.y as f32);
                fill(outline(font.outline(glyph.character)), line.pre_translate(x, y));
            }
        }
    }
}

fn polyline(points: &[Pixel], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (index, &(x, y)) in points.iter().enumerate() {
        let (x, y) = (x as f32, y as f32);
        if index == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if closed {
        path.close();
    }
    path.finish()
}

/// The outline of a glyph; none for spaces.
fn outline(mut text: &str) -> Option<Path> {
    let mut path = PathBuilder::new();
    while let Some(letter) = text.chars().next() {
        let end = text[1..].find(char::is_alphabetic).map_or(text.len(), |next| next + 1);
        let numbers: Vec<f32> = text[1..end].split(' ').filter_map(|number| number.parse().ok()).collect();
        match (letter, &numbers[..]) {
            ('M', &[x, y]) => path.move_to(x, y),
            ('L', &[x, y]) => path.line_to(x, y),
            ('Q', &[x1, y1, x, y]) => path.quad_to(x1, y1, x, y),
            _ => path.close(),
        }
        text = &text[end..];
    }
    path.finish()
}
