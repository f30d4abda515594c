//! A sheet as SVG. Each glyph, and each shape and text that occurs more than twice, is defined once and used by its
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
                Shape::Text(text) if letters == Letters::Outlines => writer.glyphs(text),
                _ => continue,
            };
            *writer.counts.entry(outline).or_insert(0) += 1;
        }
        let mut body = String::new();
        let mut marks = &self.marks[..];
        while let Some(first) = marks.first() {
            // Lines and disks of one look that follow each other are one path: dashes, grids, ticks, dots. So are small
            // polygons of one shape: the cells of a map.
            let alike = marks.iter().take_while(|mark| {
                pen(mark).is_some() && pen(mark) == pen(first) || is_cell(mark) && are_alike(mark, first)
            });
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
        for (name, shape) in writer.definitions {
            let _ = match shape {
                Defined::Path(outline) => writeln!(definitions, "<path id=\"{name}\" d=\"{outline}\"/>"),
                Defined::Glyphs(glyphs) => writeln!(definitions, "<g id=\"{name}\">{glyphs}</g>"),
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

/// Stroke of a path: width and ends of the pen, its colour and opacity.
type Pen = (u32, &'static str, (u8, u8, u8), f64);

fn pen(mark: &Mark) -> Option<Pen> {
    let (width, ends) = match mark.shape {
        Shape::Line { width, .. } => (width, ""),
        Shape::Disk { radius, .. } => (2 * radius, " stroke-linecap=\"round\""),
        _ => return None,
    };
    Some((width, ends, mark.colour, mark.opacity))
}

/// Is a mark an opaque quadrangle? Several of one shape, which have one sense, fill what they cover in one path, too.
fn is_cell(mark: &Mark) -> bool {
    mark.opacity == 1.0 && matches!(&mark.shape, Shape::Polygon(corners) if corners.len() == 4)
}

/// Have two polygons one shape and one colour?
fn are_alike(a: &Mark, b: &Mark) -> bool {
    let outline = |mark: &Mark| match &mark.shape {
        Shape::Polygon(corners) => Some(relative(corners)),
        _ => None,
    };
    (a.colour, a.opacity) == (b.colour, b.opacity) && outline(a) == outline(b)
}

/// A shape with a name: an outline, or the glyphs of a text.
enum Defined {
    Path(String),
    Glyphs(String),
}

struct Writer {
    letters: Letters,
    /// Number of occurrences of each polygon and each text.
    counts: HashMap<String, usize>,
    /// Shapes by name. A name follows from its shape alone, so that the pictures of one page can share it.
    definitions: BTreeMap<String, Defined>,
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
            Shape::Polygon(corners) => {
                let (outline, ink) = (relative(corners), ink("fill", mark));
                let (x, y) = corners.first().copied().unwrap_or_default();
                if is_cell(mark) {
                    let path: String = marks.iter().map(cell).collect();
                    writeln!(body, "<path d=\"{path}\"{ink}/>")
                } else if self.counts.get(&outline).is_some_and(|&count| count > 2) {
                    let path = Defined::Path(format!("M0 0{outline}z"));
                    let name = self.define(format!("s{:08x}", hash(&outline)), path);
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

    fn define(&mut self, name: String, shape: Defined) -> String {
        self.definitions.entry(name.clone()).or_insert(shape);
        name
    }

    fn outlines(&mut self, text: &Text, mark: &Mark, body: &mut String) -> std::fmt::Result {
        let Text { at: (x, y), upwards, .. } = text;
        let turn = if *upwards { "rotate(-90)" } else { "" };
        let (scale, ink, glyphs) = (text.scale(), ink("fill", mark), self.glyphs(text));
        let place = format!("transform=\"translate({x} {y}){turn}scale({scale:.5})\"{ink}");
        if self.counts.get(&glyphs).is_some_and(|&count| count > 2) {
            let name = self.define(format!("t{:08x}", hash(&glyphs)), Defined::Glyphs(glyphs));
            writeln!(body, "<use href=\"#{name}\" {place}/>")
        } else {
            writeln!(body, "<g {place}>{glyphs}</g>")
        }
    }

    /// The glyphs of a text by their names, which are defined.
    fn glyphs(&mut self, text: &Text) -> String {
        let Text { font, .. } = text;
        let mut glyphs = String::new();
        for glyph in text.glyphs() {
            let outline = font.outline(glyph.character);
            if outline.is_empty() {
                continue;
            }
            let face = if font.bold { 'b' } else { 'r' };
            let path = Defined::Path(outline.to_owned());
            let name = self.define(format!("{face}{:x}", u32::from(glyph.character)), path);
            let _ = write!(glyphs, "<use href=\"#{name}\" x=\"{:.0}\"", glyph.x);
            if glyph.y != 0.0 {
                let _ = write!(glyphs, " y=\"{:.0}\"", glyph.y);
            }
            glyphs.push_str("/>");
        }
        glyphs
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
            // Commands repeat by themselves, and a sign parts numbers as well as a space.
            let lead = if path.is_empty() {
                "l"
            } else if step < 0 {
                ""
            } else {
                " "
            };
            let _ = write!(path, "{lead}{step}");
        }
    }
    path
}

/// A polygon as a part of a path.
fn cell(mark: &Mark) -> String {
    match &mark.shape {
        Shape::Polygon(corners) => {
            let (x, y) = corners.first().copied().unwrap_or_default();
            format!("M{x} {y}{}z", relative(corners))
        }
        _ => String::new(),
    }
}

fn stroke(mark: &Mark) -> String {
    match &mark.shape {
        Shape::Line { points, .. } => {
            let (x, y) = points.first().copied().unwrap_or_default();
            format!("M{x} {y}{}", relative(points))
        }
        // A stroke of nearly no length has round ends: a disk.
        Shape::Disk { centre: (x, y), .. } => format!("M{x} {y}h.1"),
        _ => String::new(),
    }
}

/// FNV-1a in 32 bits (Fowler, Noll and Vo).
fn hash(text: &str) -> u32 {
    text.bytes().fold(0x811c_9dc5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}
