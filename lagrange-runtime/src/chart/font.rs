//! The embedded font: DejaVu Sans, regular and bold (licence in `assets/LICENSE-DejaVu.txt`).

use resvg::usvg::{Node, Options, Tree, fontdb};
use std::sync::{Arc, OnceLock};

pub(super) const FAMILY: &str = "DejaVu Sans";

const FACES: [&[u8]; 2] = [
    include_bytes!("../../assets/DejaVuSans.subset.ttf"),
    include_bytes!("../../assets/DejaVuSans-Bold.subset.ttf"),
];

/// Options that know the embedded font and no other, so that a picture does not depend on the machine.
pub(super) fn options() -> Options<'static> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        for face in FACES {
            fonts.load_font_data(face.to_vec());
        }
        Arc::new(fonts)
    });
    Options { fontdb: fonts.clone(), font_family: FAMILY.into(), ..Options::default() }
}

/// A piece of text on one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Font {
    pub size: f64,
    pub bold: bool,
}

impl Font {
    pub(super) const fn regular(size: f64) -> Self {
        Self { size, bold: false }
    }

    pub(super) const fn bold(size: f64) -> Self {
        Self { size, bold: true }
    }

    /// Length of the text, as the renderer will set it.
    pub(super) fn width(self, text: &str) -> f64 {
        let escaped = text.replace('&', "&amp;").replace('<', "&lt;");
        let weight = if self.bold { "bold" } else { "normal" };
        let svg = format!(
            "<svg xmlns='http://www.w3.org/2000/svg'><text id='t' font-family='{FAMILY}' font-weight='{weight}' \
             font-size='{}'>{escaped}</text></svg>",
            self.size
        );
        let tree = Tree::from_str(&svg, &options()).ok();
        match tree.as_ref().and_then(|tree| tree.node_by_id("t")) {
            Some(Node::Text(text)) => f64::from(text.bounding_box().width()),
            _ => 0.0,
        }
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
        assert!(one > 5.0 && (two - 2.0 * one).abs() < 1.0, "{one} {two}");
        assert!(Font::bold(10.0).width("mmm") > font.width("mmm"));
        assert!(font.width("<&") > 10.0);
    }

    #[test]
    fn the_signs_of_mechanics_are_in_both_faces() {
        let drawn = |sign: char, weight: &str| {
            let svg = format!(
                "<svg xmlns='http://www.w3.org/2000/svg'><text y='20' font-weight='{weight}'>{sign}</text></svg>"
            );
            Tree::from_str(&svg, &options()).unwrap().to_string(&resvg::usvg::WriteOptions::default())
        };
        for weight in ["normal", "bold"] {
            let missing = drawn('漢', weight);
            let signs = "αβγδεθλμνξπρστφχψωΓΔΘΛΣΦΨΩ⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻₀₁₂₃₄₅₆₇₈₉ₙ−±×·÷√∂∇∞∫∑≈≠≤≥≪≫∝→↔°′″–—’éöüßØ";
            for sign in signs.chars() {
                assert_ne!(drawn(sign, weight), missing, "{sign} {weight}");
            }
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
