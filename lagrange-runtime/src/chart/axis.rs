//! Ticks of an axis: places and labels.

use super::{Axis, Scale};

/// Extent and ticks of an axis, in places along it: values, or their decimal logarithms.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ruler {
    pub low: f64,
    pub high: f64,
    /// Labelled ticks.
    pub ticks: Vec<(f64, String)>,
    /// Ticks without a label.
    pub minor: Vec<f64>,
}

impl Axis {
    /// The extent of these places with some air around them.
    pub(super) fn extent(&self, low: f64, high: f64) -> (f64, f64) {
        let span = high - low;
        match self.scale {
            // Decades tell more than digits: at least one of them is shown whole.
            Scale::Log if span < 1.0 => (low.floor().min(low - 0.1), high.ceil().max(high + 0.1)),
            Scale::Linear if span <= 1e-12 * low.abs().max(high.abs()) => {
                let air = if high == 0.0 { 1.0 } else { 0.1 * high.abs() };
                (low - air, high + air)
            }
            _ => (low - 0.04 * span, high + 0.04 * span),
        }
    }

    /// Ticks for an extent, of which about `most` can be labelled.
    pub(super) fn ruler(&self, (low, high): (f64, f64), most: f64) -> Ruler {
        let (ticks, minor) = match self.scale {
            Scale::Linear => linear(low, high, most),
            Scale::Log => decades(low, high, most),
        };
        Ruler { low, high, ticks, minor }
    }
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn linear(low: f64, high: f64, most: f64) -> (Vec<(f64, String)>, Vec<f64>) {
    let rough = (high - low) / most.max(2.0);
    let power = rough.log10().floor();
    let magnitude = 10_f64.powf(power);
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|f| f * magnitude >= rough).unwrap_or(10.0);
    let step = factor * magnitude;
    let multiples = |step: f64| (low / step).ceil() as i64..=(high / step).floor() as i64;
    let largest = low.abs().max(high.abs());
    // Very large and very small numbers share a power of ten.
    let shared = if (1e-3..1e5).contains(&largest) { 0 } else { largest.log10().floor() as i32 };
    let decimals = (f64::from(shared) - power - if factor == 10.0 { 1.0 } else { 0.0 }).max(0.0) as usize;
    let label = |place: f64| {
        let digits = format!("{:.decimals$}", place / 10_f64.powi(shared)).replace('-', "−");
        if shared == 0 || place == 0.0 { digits } else { format!("{digits}·10{}", superscript(shared)) }
    };
    let ticks = multiples(step).map(|i| i as f64 * step).map(|place| (place, label(place))).collect();
    let parts = if factor == 2.0 { 4.0 } else { 5.0 };
    let minor = multiples(step / parts).filter(|i| i % parts as i64 != 0).map(|i| i as f64 * step / parts);
    (ticks, minor.collect())
}

/// Powers of ten, every second, third, … of them labelled if they are many; 2, …, 9 between them if they are few.
fn decades(low: f64, high: f64, most: f64) -> (Vec<(f64, String)>, Vec<f64>) {
    let (first, last) = (low.ceil() as i32, high.floor() as i32);
    let count = f64::from(last - first + 1);
    let stride =
        [1, 2, 3, 5, 10, 20, 50, 100].into_iter().find(|&s| count / f64::from(s) <= most).unwrap_or(200);
    let (labelled, mut minor): (Vec<i32>, Vec<f64>) = (
        (first..=last).filter(|n| n.rem_euclid(stride) == 0).collect(),
        (first..=last).filter(|n| n.rem_euclid(stride) != 0).map(f64::from).collect(),
    );
    if count <= 10.0 {
        let between = (first - 1..=last)
            .flat_map(|n| (2..10).map(move |digit| f64::from(n) + f64::from(digit).log10()));
        minor.extend(between.filter(|place| (low..=high).contains(place)));
    }
    let ticks = labelled.into_iter().map(|n| (f64::from(n), format!("10{}", superscript(n)))).collect();
    (ticks, minor)
}

/// `-15` as `⁻¹⁵`.
fn superscript(n: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    n.to_string().chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, extent: (f64, f64), most: f64) -> Vec<String> {
        axis.ruler(extent, most).ticks.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn decades_are_labelled_as_space_permits() {
        let axis = Axis::log("", "");
        assert_eq!(labels(&axis, (-3.2, 0.4), 10.0), ["10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
        assert_eq!(labels(&axis, (-16.5, -0.5), 6.0), ["10⁻¹⁵", "10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³"]);
        assert_eq!(axis.ruler((-16.5, -0.5), 6.0).minor.len(), 11);
        assert_eq!(axis.ruler((-1.0, 0.0), 6.0).minor.len(), 8);
    }

    #[test]
    fn linear_ticks_are_round_numbers() {
        let axis = Axis::linear("", "");
        assert_eq!(labels(&axis, (-1.04, 1.04), 5.0), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(&axis, (0.0, 100.0), 6.0), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(labels(&axis, (0.0, 3.1e-7), 4.0), ["0", "1·10⁻⁷", "2·10⁻⁷", "3·10⁻⁷"]);
        assert_eq!(labels(&axis, (999_999.0, 1_000_001.0), 3.0).len(), 3);
    }

    #[test]
    fn a_single_value_has_an_extent() {
        assert_eq!(Axis::linear("", "").extent(0.0, 0.0), (-1.0, 1.0));
        assert_eq!(Axis::linear("", "").extent(5.0, 5.0), (4.5, 5.5));
        let (low, high) = Axis::log("", "").extent(-3.0, -3.0);
        assert!(low <= -3.1 && high >= -2.9);
    }
}
