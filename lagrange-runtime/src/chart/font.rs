//! The embedded font: outlines, kerning and marks of DejaVu Sans, regular and bold (licence in
//! `assets/LICENSE-DejaVu.txt`; `assets/glyphs.py` makes the tables).

use std::collections::HashMap;
use std::sync::OnceLock;

/// Family for text that stays text.
pub(super) const FAMILY: &str = "DejaVu Sans";

/// Units of outlines and advances to the em.
pub(super) const UNITS: f64 = 2048.0;

/// Drawn for characters that the font lacks.
const MISSING: char = '\0';

/// Combining marks of rates.
const DOT: char = '\u{307}';
const TWO_DOTS: char = '\u{308}';

/// Size and weight of a text on one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Font {
    pub size: f64,
    pub bold: bool,
}

/// One glyph of a text, at its place in units of the font.
pub(super) struct Placed {
    /// Names the glyph in its face.
    pub character: char,
    pub x: f64,
    pub y: f64,
}

/// One weight of the font.
#[derive(Default)]
struct Face {
    /// Advance and outline, as in SVG.
    glyphs: HashMap<char, (f64, &'static str)>,
    kerning: HashMap<(char, char), f64>,
    /// Place of a combining mark, seen from the end of the character before it.
    marks: HashMap<(char, char), (f64, f64)>,
}

impl Face {
    fn parse(table: &'static str) -> Face {
        let mut face = Face::default();
        for line in table.lines() {
            face.add(line).unwrap_or_else(|| panic!("the font has a line {line:?}"));
        }
        face
    }

    fn add(&mut self, line: &'static str) -> Option<()> {
        let mut words = line.split(' ');
        match words.next()? {
            "pair" => {
                let advance = words.next()?.parse().ok()?;
                self.kerning.extend(words.filter_map(pair).map(|pair| (pair, advance)));
            }
            "mark" => {
                let place = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
                self.marks.extend(words.filter_map(pair).map(|pair| (pair, place)));
            }
            code => {
                let character = char::from_u32(u32::from_str_radix(code, 16).ok()?)?;
                let advance = words.next()?;
                // Numbers of the outline have spaces between them.
                let outline = line[code.len() + 1 + advance.len()..].trim_start();
                self.glyphs.insert(character, (advance.parse().ok()?, outline));
            }
        }
        Some(())
    }
}

/// Letters with dots, which the font composes, as a letter and its mark; others as they are.
fn parts(character: char) -> impl Iterator<Item = char> {
    let (letter, mark) = match character {
        'ṗ' => ('p', Some(DOT)),
        'ṙ' => ('r', Some(DOT)),
        'ṡ' => ('s', Some(DOT)),
        'ẋ' => ('x', Some(DOT)),
        'ẏ' => ('y', Some(DOT)),
        'ż' => ('z', Some(DOT)),
        'ẍ' => ('x', Some(TWO_DOTS)),
        other => (other, None),
    };
    std::iter::once(letter).chain(mark)
}

fn pair(word: &str) -> Option<(char, char)> {
    let mut characters = word.chars();
    characters.next().zip(characters.next())
}

impl Font {
    pub(super) const fn regular(size: f64) -> Self {
        Self { size, bold: false }
    }

    pub(super) const fn bold(size: f64) -> Self {
        Self { size, bold: true }
    }

    fn face(self) -> &'static Face {
        static FACES: [OnceLock<Face>; 2] = [OnceLock::new(), OnceLock::new()];
        let table = match self.bold {
            false => include_str!("../../assets/DejaVuSans.glyphs"),
            true => include_str!("../../assets/DejaVuSans-Bold.glyphs"),
        };
        FACES[usize::from(self.bold)].get_or_init(|| Face::parse(table))
    }

    /// Outline of a glyph, as in SVG, in units of the font with y downwards; empty for spaces.
    pub(super) fn outline(self, glyph: char) -> &'static str {
        self.face().glyphs.get(&glyph).map_or("", |(_, outline)| outline)
    }

    /// The glyphs of a text at their places, and its length, in units of the font.
    pub(super) fn set(self, text: &str) -> (Vec<Placed>, f64) {
        let face = self.face();
        let (mut glyphs, mut end, mut last) = (Vec::new(), 0.0, MISSING);
        for wanted in text.chars().flat_map(parts) {
            if let Some((x, y)) = face.marks.get(&(last, wanted)) {
                glyphs.push(Placed { character: wanted, x: end + x, y: *y });
                continue;
            }
            let character = if face.glyphs.contains_key(&wanted) { wanted } else { MISSING };
            end += face.kerning.get(&(last, character)).copied().unwrap_or(0.0);
            glyphs.push(Placed { character, x: end, y: 0.0 });
            end += face.glyphs.get(&character).map_or(0.0, |(advance, _)| *advance);
            last = character;
        }
        (glyphs, end)
    }

    /// Length of the text, as it is drawn.
    pub(super) fn width(self, text: &str) -> f64 {
        self.set(text).1 * self.size / UNITS
    }

    /// The text broken at spaces into lines no longer than `width` (a longer word stays whole).
    pub(super) fn wrap(self, text: &str, width: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line} {word}")) <= width => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// The font, smaller if the text would be longer than `width`.
    pub(super) fn fit(self, text: &str, width: f64) -> Self {
        Self { size: self.size * (width / self.width(text).max(1.0)).min(1.0), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_has_a_width() {
        let font = Font::regular(10.0);
        let (one, two) = (font.width("θ̇"), font.width("θ̇θ̇"));
        assert!(one > 5.0 && (two - 2.0 * one).abs() < 1e-9, "{one} {two}");
        assert!(Font::bold(10.0).width("mmm") > font.width("mmm"));
        assert!(font.width("<&") > 10.0);
        // Kerning.
        assert!(font.width("To") < font.width("T") + font.width("o"));
    }

    /// Left, right, top and bottom of a glyph.
    fn extent(outline: &str) -> [f64; 4] {
        let words = outline.split(|c: char| c == ' ' || c.is_alphabetic()).filter(|word| !word.is_empty());
        let numbers: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        let of = |part: usize| numbers[part..].iter().step_by(2).copied();
        [
            of(0).fold(f64::MAX, f64::min),
            of(0).fold(f64::MIN, f64::max),
            of(1).fold(f64::MAX, f64::min),
            of(1).fold(f64::MIN, f64::max),
        ]
    }

    #[test]
    fn a_dot_is_above_its_letter() {
        for font in [Font::regular(10.0), Font::bold(10.0)] {
            let [dot_left, dot_right, _, dot_bottom] = extent(font.outline('\u{307}'));
            for letter in ['q', 'θ', 'x', 'φ', 'A', 'ψ', 'r'] {
                let (glyphs, end) = font.set(&format!("{letter}\u{307}"));
                assert_eq!(end, font.set(&letter.to_string()).1, "{letter}");
                let [left, right, top, _] = extent(font.outline(letter));
                let middle = glyphs[1].x + 0.5 * (dot_left + dot_right);
                assert!((left..right).contains(&middle), "{letter}: {left} {middle} {right}");
                assert!(glyphs[1].y + dot_bottom < top, "{letter}");
            }
        }
    }

    #[test]
    fn the_signs_of_mechanics_are_in_both_faces() {
        let signs = "αβγδεθλμνξπρστφχψωΓΔΘΛΣΦΨΩ⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻₀₁₂₃₄₅₆₇₈₉ₙ−±×·÷√∂∇∞∫∑≈≠≤≥≪≫∝→↔°′″–—’éöüßØ";
        for font in [Font::regular(1.0), Font::bold(1.0)] {
            for sign in signs.chars() {
                assert!(!font.outline(sign).is_empty(), "{sign}");
            }
            assert!(font.set("ṗṙṡẋẏżẍ").0.iter().all(|glyph| glyph.character != MISSING));
            assert_eq!(font.set("漢").0[0].character, MISSING);
            assert!(!font.outline(MISSING).is_empty());
        }
    }

    #[test]
    fn long_text_is_wrapped_or_made_smaller() {
        let font = Font::regular(10.0);
        assert_eq!(font.wrap("one two three", 1.0), ["one", "two", "three"]);
        assert_eq!(font.wrap("one two three", 1000.0), ["one two three"]);
        assert!(font.fit("one two three", 20.0).size < 5.0);
    }
}
