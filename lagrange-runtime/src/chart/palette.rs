//! Distinction of series by colour, by dashes and by markers, so that any one of the three is enough.

use super::series::{Series, Style};
use plotters::style::RGBColor;

/// The colours of Okabe and Ito, dark ones first. Their yellow is too faint for lines on white: grey stands in for it.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xB2), // blue
    RGBColor(0xD5, 0x5E, 0x00), // vermillion
    RGBColor(0x00, 0x9E, 0x73), // bluish green
    RGBColor(0xCC, 0x79, 0xA7), // reddish purple
    RGBColor(0x00, 0x00, 0x00), // black
    RGBColor(0xE6, 0x9F, 0x00), // orange
    RGBColor(0x56, 0xB4, 0xE9), // sky blue
    RGBColor(0x77, 0x77, 0x77), // grey
];

/// Lengths of strokes and gaps by turns.
const DASHES: [&[f64]; 8] = [
    &[],
    &[9.0, 4.0],
    &[2.5, 3.0],
    &[11.0, 3.5, 2.5, 3.5],
    &[20.0, 4.0],
    &[5.0, 3.0],
    &[14.0, 3.0, 6.0, 3.0],
    &[9.0, 3.0, 2.0, 3.0, 2.0, 3.0],
];

/// Corners of the markers about their centre, in units of the marker's radius, y downwards; of equal area, so that none
/// looks more important.
const MARKERS: [&[(f64, f64)]; 8] = [
    &[], // a circle
    &[(-0.89, -0.89), (0.89, -0.89), (0.89, 0.89), (-0.89, 0.89)],
    &[(0.0, -1.45), (1.26, 0.78), (-1.26, 0.78)],
    &[(0.0, -1.38), (1.1, 0.0), (0.0, 1.38), (-1.1, 0.0)],
    &[(0.0, 1.45), (1.26, -0.78), (-1.26, -0.78)],
    &[
        (-0.82, -1.31),
        (0.0, -0.49),
        (0.82, -1.31),
        (1.31, -0.82),
        (0.49, 0.0),
        (1.31, 0.82),
        (0.82, 1.31),
        (0.0, 0.49),
        (-0.82, 1.31),
        (-1.31, 0.82),
        (-0.49, 0.0),
        (-1.31, -0.82),
    ],
    &[
        (-0.36, -1.4),
        (0.36, -1.4),
        (0.36, -0.36),
        (1.4, -0.36),
        (1.4, 0.36),
        (0.36, 0.36),
        (0.36, 1.4),
        (-0.36, 1.4),
        (-0.36, 0.36),
        (-1.4, 0.36),
        (-1.4, -0.36),
        (-0.36, -0.36),
    ],
    &[
        (0.0, -1.6),
        (0.43, -0.53),
        (1.52, -0.49),
        (0.7, 0.22),
        (0.94, 1.29),
        (0.0, 0.7),
        (-0.94, 1.29),
        (-0.7, 0.22),
        (-1.52, -0.49),
        (-0.43, -0.53),
    ],
];

/// The look of one series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    pub colour: RGBColor,
    pub dashes: &'static [f64],
    pub marker: &'static [(f64, f64)],
    /// White inside, from the ninth series to the sixteenth.
    pub open: bool,
}

/// Colour of a series that is there for comparison.
pub(super) const CONTEXT: Look =
    Look { colour: RGBColor(0xC4, 0xC4, 0xC4), dashes: &[], marker: &[], open: false };

/// The looks of the series, in their order.
pub(super) fn looks(series: &[Series]) -> Vec<Look> {
    let mut shown = 0..;
    let mut shades = shades(series.iter().filter(|series| series.style == Style::Cells).count());
    let next = |series: &Series| match series.style {
        Style::Context => CONTEXT,
        Style::Cells => shades.next().map_or(CONTEXT, |colour| Look { colour, ..CONTEXT }),
        _ => shown.next().map_or(CONTEXT, look),
    };
    series.iter().map(next).collect()
}

/// The colour of that index.
pub(super) fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

/// The look of the series of that index. Sixteen are distinct at sight.
fn look(index: usize) -> Look {
    let round = index / COLOURS.len();
    Look {
        colour: colour(index),
        dashes: DASHES[(index + round) % DASHES.len()],
        marker: MARKERS[(index + round) % MARKERS.len()],
        open: round % 2 == 1,
    }
}

/// Colours of that many kinds of cells, from light to dark, so that their order shows in grey as well.
fn shades(count: usize) -> impl Iterator<Item = RGBColor> {
    // Evenly bright steps of ColorBrewer's YlGnBu (Harrower and Brewer, *The Cartographic Journal* 40, 2003).
    const SHADES: [[u8; 3]; 5] =
        [[0xFF, 0xF3, 0xB0], [0xA1, 0xDA, 0xB4], [0x41, 0xB6, 0xC4], [0x2C, 0x7F, 0xB8], [0x25, 0x34, 0x94]];
    (0..count).map(move |index| {
        let along = 4.0 * index as f64 / (count.max(2) - 1) as f64;
        let before = (along as usize).min(3);
        let by = along - before as f64;
        let [r, g, b] = [0, 1, 2].map(|i| {
            let [from, to] = [SHADES[before][i], SHADES[before + 1][i]].map(f64::from);
            (from + by * (to - from)).round() as u8
        });
        RGBColor(r, g, b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn context_takes_no_look_from_others() {
        let series = [Series::context([(0.0, 0.0)]), Series::new("a", []), Series::line("b", [])];
        assert_eq!(looks(&series), [CONTEXT, look(0), look(1)]);
    }

    #[test]
    fn sixteen_looks_differ() {
        let looks: Vec<_> = (0..16).map(look).collect();
        for (i, a) in looks.iter().enumerate() {
            assert!(looks[..i].iter().all(|b| a != b), "{i}");
            // Eight shapes, filled and open: told apart in grey as well.
            assert!(looks[..i].iter().all(|b| (a.marker, a.open) != (b.marker, b.open)), "{i}");
        }
    }

    #[test]
    fn shades_become_darker() {
        let light =
            |RGBColor(r, g, b): RGBColor| 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b);
        for count in 1..9 {
            let lights: Vec<u32> = shades(count).map(light).collect();
            assert!(lights.windows(2).all(|pair| pair[0] > pair[1] + 10_000), "{lights:?}");
        }
    }
}
