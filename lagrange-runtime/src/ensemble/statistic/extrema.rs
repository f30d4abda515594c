//! The least and the greatest output, and which samples they are.

use super::Statistic;
use crate::ensemble::record::record_fields;

/// The least and the greatest of a real output, with the index of the first sample that has it: it can be replayed.
/// Exact; outputs that are not numbers are counted and left out.
///
/// ```
/// use lagrange_runtime::ensemble::{Extrema, Statistic};
/// let mut state = Extrema.empty();
/// for (index, x) in [2.0, 9.0, 4.0].iter().enumerate() {
///     Extrema.add(&mut state, index as u64, x);
/// }
/// assert_eq!(state.greatest.map(|greatest| (greatest.index, greatest.value)), Some((1, 9.0)));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extrema;

/// An extreme output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// The index of the sample.
    pub index: u64,
    /// The output.
    pub value: f64,
}

record_fields!(Extreme { index, value });

/// Result of [`Extrema`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// The least output.
    pub least: Option<Extreme>,
    /// The greatest output.
    pub greatest: Option<Extreme>,
    /// The number of outputs that are not numbers.
    pub not_a_number: u64,
}

record_fields!(Extremes { least, greatest, not_a_number });

impl Extremes {
    /// Takes later outputs, which replace an extreme only if they are beyond it.
    fn take(&mut self, least: Option<Extreme>, greatest: Option<Extreme>) {
        if least.is_some_and(|new| self.least.is_none_or(|old| new.value < old.value)) {
            self.least = least;
        }
        if greatest.is_some_and(|new| self.greatest.is_none_or(|old| new.value > old.value)) {
            self.greatest = greatest;
        }
    }
}

impl Statistic<f64> for Extrema {
    type State = Extremes;

    fn empty(&self) -> Extremes {
        Extremes::default()
    }

    #[inline]
    fn add(&self, state: &mut Extremes, index: u64, output: &f64) {
        if output.is_nan() {
            state.not_a_number += 1;
        } else {
            let new = Some(Extreme { index, value: *output });
            state.take(new, new);
        }
    }

    fn merge(&self, state: &mut Extremes, later: Extremes) {
        state.not_a_number += later.not_a_number;
        state.take(later.least, later.greatest);
    }

    fn describe(&self) -> String {
        "extrema".into()
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::merged;
    use super::*;

    #[test]
    fn the_first_sample_of_equal_ones_is_kept() {
        let outputs: Vec<f64> = (0..200).map(|k| f64::from((k * 37 + 5) % 50)).collect();
        let found = merged(&Extrema, &outputs);
        let place = |value: f64| outputs.iter().position(|&x| x == value).map(|k| k as u64);
        assert_eq!(found.least.map(|least| least.index), place(0.0));
        assert_eq!(found.greatest.map(|greatest| greatest.index), place(49.0));
        assert_eq!(merged(&Extrema, &[f64::NAN]), Extremes { not_a_number: 1, ..Extremes::default() });
    }
}
