//! A sheet as SVG. Each glyph, and each shape or text that occurs more than twice, is defined once and used by its
//! name.

use super::font::{FAMILY, Font};
use super::sheet::{FINE, Mark, Pixel, Shape, Sheet, Text, before};
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;

/// Form in which letters are stored.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Letters {
    /// Outlines, which look the same everywhere.
    Outlines,
    /// Text in the reader's font, which is shorter and can be searched.
    Text,
}

impl Sheet {
    pub(super) fn svg(&self, letters: Letters) -> String {
        let mut writer = Writer { letters, counts: HashMap::new(), definitions: BTreeMap::new() };
        for mark in &self.marks {
            let outline = match &mark.shape {
                Shape::Polygon(corners) => relative(corners),
                Shape::Text(text) => text.text.clone(),
                _ => continue,
            };
            *writer.counts.entry(outline).or_insert(0) += 1;
        }
        let mut body = String::new();
        let mut marks = &self.marks[..];
        while let Some(first) = marks.first() {
            // Lines, disks and rectangles of one look that follow each other are one path: dashes, grids, ticks, dots,
            // cells of a map.
            let alike = marks.iter().take_while(|mark| pen(mark).is_some() && pen(mark) == pen(first));
            let (now, rest) = marks.split_at(alike.count().max(1));
            writer.marks(now, &mut body);
            marks = rest;
        }
        let Sheet { width, height, .. } = self;
        let family = match letters {
            Letters::Outlines => String::new(),
            Letters::Text => format!(" font-family=\"{FAMILY}\""),
        };
        let mut definitions = String::new();
        for (name, outline) in writer.definitions {
            let _ = match outline.strip_prefix("<use") {
                Some(_) => writeln!(definitions, "<g id=\"{name}\">{outline}</g>"),
                None => writeln!(definitions, "<path id=\"{name}\" d=\"{outline}\"/>"),
            };
        }
        format!(
            "<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" xmlns=\"http://www.w3.org/2000/svg\">\n\
             <defs>\n{definitions}</defs>\n\
             <g transform=\"scale({})\" stroke-linejoin=\"round\"{family}>\n{body}</g>\n</svg>\n",
            1.0 / FINE
        )
    }
}

/// Stroke of a path: width and ends of the pen, its colour and opacity. Rectangles are filled, by a pen of no width.
type Pen = (u32, &'static str, (u8, u8, u8), f64);

fn pen(mark: &Mark) -> Option<Pen> {
    let (width, ends) = match mark.shape {
        Shape::Line { width, .. } => (width, ""),
        Shape::Disk { radius, .. } => (2 * radius, " stroke-linecap=\"round\""),
        // Where two of one path lie upon each other, they are painted once.
        Shape::Polygon(ref corners) if rectangle(corners).is_some() && mark.opacity == 1.0 => (0, "z"),
        _ => return None,
    };
    Some((width, ends, mark.colour, mark.opacity))
}

struct Writer {
    letters: Letters,
    /// Number of occurrences of each polygon, and of each text.
    counts: HashMap<String, usize>,
    /// Outlines, and glyphs of texts, by name. A name follows from its outline alone, so that the pictures of one page
    /// can share it.
    definitions: BTreeMap<String, String>,
}

impl Writer {
    /// One mark, or several that one pen draws.
    fn marks(&mut self, marks: &[Mark], body: &mut String) {
        let Some(mark) = marks.first() else { return };
        let _ = match &mark.shape {
            Shape::Disk { centre: (x, y), radius } if marks.len() == 1 => {
                writeln!(body, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{}/>", ink("fill", mark))
            }
            Shape::Line { .. } | Shape::Disk { .. } => {
                let path: String = marks.iter().map(stroke).collect();
                let (ink, (width, ends, ..)) = (ink("stroke", mark), pen(mark).unwrap_or_default());
                writeln!(body, "<path d=\"{path}\" fill=\"none\"{ink} stroke-width=\"{width}\"{ends}/>")
            }
            Shape::Polygon(_) if marks.len() > 1 => {
                let path: String = marks.iter().map(stroke).collect();
                writeln!(body, "<path d=\"{path}\"{}/>", ink("fill", mark))
            }
            Shape::Polygon(corners) => {
                let (outline, ink) = (relative(corners), ink("fill", mark));
                let (x, y) = corners.first().copied().unwrap_or_default();
                if self.counts.get(&outline).is_some_and(|&count| count > 2) {
                    let name = self.define(format!("s{:08x}", hash(&outline)), format!("M0 0{outline}z"));
                    writeln!(body, "<use href=\"#{name}\" x=\"{x}\" y=\"{y}\"{ink}/>")
                } else {
                    writeln!(body, "<path d=\"M{x} {y}{outline}z\"{ink}/>")
                }
            }
            Shape::Text(text) => match self.letters {
                Letters::Outlines => self.outlines(text, mark, body),
                Letters::Text => self.text(text, mark, body),
            },
        };
    }

    fn define(&mut self, name: String, outline: String) -> String {
        self.definitions.entry(name.clone()).or_insert(outline);
        name
    }

    fn outlines(&mut self, text: &Text, mark: &Mark, body: &mut String) -> std::fmt::Result {
        let Text { font, at: (x, y), upwards, .. } = text;
        let turn = if *upwards { "rotate(-90)" } else { "" };
        let place =
            format!("transform=\"translate({x} {y}){turn}scale({:.5})\"{}", text.scale(), ink("fill", mark));
        let mut glyphs = String::new();
        for glyph in text.glyphs() {
            let outline = font.outline(glyph.character);
            if outline.is_empty() {
                continue;
            }
            let face = if font.bold { 'b' } else { 'r' };
            let name = self.define(format!("{face}{:x}", u32::from(glyph.character)), outline.to_owned());
            write!(glyphs, "<use href=\"#{name}\" x=\"{:.0}\"", glyph.x)?;
            if glyph.y != 0.0 {
                write!(glyphs, " y=\"{:.0}\"", glyph.y)?;
            }
            glyphs.push_str("/>");
        }
        if !glyphs.is_empty() && self.counts.get(&text.text).is_some_and(|&count| count > 2) {
            let name = self.define(format!("t{:08x}", hash(&glyphs)), glyphs);
            return writeln!(body, "<use href=\"#{name}\" {place}/>");
        }
        writeln!(body, "<g {place}>{glyphs}</g>")
    }

    fn text(&mut self, text: &Text, mark: &Mark, body: &mut String) -> std::fmt::Result {
        let Text { text, font: Font { size, bold }, at: (x, y), anchor, upwards } = text;
        let anchor =
            ["", " text-anchor=\"middle\"", " text-anchor=\"end\""][(2.0 * before(*anchor)) as usize];
        let bold = if *bold { " font-weight=\"bold\"" } else { "" };
        let turn = if *upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        writeln!(
            body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{:.1}\"{bold}{anchor}{turn}{}>{}</text>",
            size * FINE,
            ink("fill", mark),
            text.replace('&', "&amp;").replace('<', "&lt;")
        )
    }
}

fn ink(attribute: &str, Mark { colour: (r, g, b), opacity, .. }: &Mark) -> String {
    let colour = match [r, g, b].map(|part| part.is_multiple_of(0x11)) {
        [true, true, true] => format!(" {attribute}=\"#{:x}{:x}{:x}\"", r / 0x11, g / 0x11, b / 0x11),
        _ => format!(" {attribute}=\"#{r:02x}{g:02x}{b:02x}\""),
    };
    if *opacity < 1.0 { format!("{colour} {attribute}-opacity=\"{opacity}\"") } else { colour }
}

/// The way on from the first point.
fn relative(points: &[Pixel]) -> String {
    let mut path = String::new();
    for ends in points.windows(2) {
        let [(x0, y0), (x1, y1)] = [ends[0], ends[1]].map(|(x, y)| (i64::from(x), i64::from(y)));
        for step in [x1 - x0, y1 - y0] {
            // Commands repeat by themselves.
            let lead = if path.is_empty() { "l" } else { between(step) };
            let _ = write!(path, "{lead}{step}");
        }
    }
    path
}

/// Between numbers of a path: a sign parts them as well as a space.
pub(super) fn between(next: i64) -> &'static str {
    if next < 0 { "" } else { " " }
}

fn stroke(mark: &Mark) -> String {
    match &mark.shape {
        Shape::Line { points, .. } => {
            let (x, y) = points.first().copied().unwrap_or_default();
            format!("M{x} {y}{}", relative(points))
        }
        // A stroke of nearly no length has round ends: a disk.
        Shape::Disk { centre: (x, y), .. } => format!("M{x} {y}h.1"),
        Shape::Polygon(corners) => {
            let Some((x, y, width, height)) = rectangle(corners) else { return String::new() };
            format!("M{x} {y}h{width}v{height}h{}z", -width)
        }
        _ => String::new(),
    }
}

/// Corner, width and height of an upright rectangle as plotters draws it.
fn rectangle(corners: &[Pixel]) -> Option<(i32, i32, i32, i32)> {
    let &[(left, top), (right, upper), (r, bottom), (l, b)] = corners else { return None };
    let is_upright = upper == top && r == right && l == left && b == bottom;
    is_upright.then(|| (left, top, right - left, bottom - top))
}

/// FNV-1a in 32 bits (Fowler, Noll and Vo).
fn hash(text: &str) -> u32 {
    text.bytes().fold(0x811c_9dc5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}
