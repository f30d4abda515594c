//! Statistics of an ensemble, fed sample by sample and merged part by part.

use super::record::Record;

mod collect;
mod covariance;
mod extrema;
mod histogram;
pub(super) mod interval;
mod moments;
mod probability;
mod quantiles;
mod survival;

pub use collect::{Collect, Collected, Columns};
pub use covariance::{Covariance, Covariances};
pub use extrema::{Extrema, Extreme, Extremes};
pub use histogram::{Counts, Histogram};
pub use interval::ConfidenceInterval;
pub use moments::{Moment, Moments};
pub use probability::{Frequency, Probability};
pub use quantiles::{Quantiles, Sketch};
pub use survival::{Lifetime, Lifetimes, Survival, Surviving};

/// A statistic of the outputs `O` of samples.
///
/// The value itself says what is wanted; what has been found is its `State`. States are fed the samples of one leaf
/// in the order of their index, and merged in a fixed tree, earlier samples first: see the [module](super) for the
/// policy. A statistic that follows it need not be commutative or associative.
///
/// Tuples of statistics are a statistic, of which each is fed the same output; [`of`] feeds one a part of the output.
pub trait Statistic<O>: Sync {
    /// State of the statistic.
    type State: Record + Send;

    /// The state before the first sample.
    fn empty(&self) -> Self::State;

    /// Takes one more output, that of sample `index`.
    fn add(&self, state: &mut Self::State, index: u64, output: &O);

    /// Takes the samples of `later`, all of which come after those of `state`.
    fn merge(&self, state: &mut Self::State, later: Self::State);

    /// Description that distinguishes the statistic from others, for checkpoints.
    fn describe(&self) -> String;

    /// Checks the parameters of the statistic.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }
}

/// A statistic of a part of the output, or of a function of it; made by [`of`].
#[derive(Clone, Copy, Debug)]
pub struct Of<F, T> {
    part: F,
    statistic: T,
}

/// The `statistic` of a part of the output.
///
/// ```
/// use lagrange_runtime::ensemble::{Extrema, Moments, Statistic, of};
/// let both = (of(|output: &(f64, f64)| output.0, Moments), of(|output: &(f64, f64)| output.1, Extrema));
/// let mut state = both.empty();
/// both.add(&mut state, 0, &(2.0, 1.0));
/// both.add(&mut state, 1, &(3.0, 0.0));
/// assert_eq!(state.0.mean(), 2.5);
/// assert_eq!(state.1.least.map(|least| least.index), Some(1));
/// ```
pub fn of<O, P, F: Fn(&O) -> P, T>(part: F, statistic: T) -> Of<F, T> {
    Of { part, statistic }
}

impl<O, P, F, T> Statistic<O> for Of<F, T>
where
    F: Fn(&O) -> P + Sync,
    T: Statistic<P>,
{
    type State = T::State;

    fn empty(&self) -> T::State {
        self.statistic.empty()
    }

    fn add(&self, state: &mut T::State, index: u64, output: &O) {
        self.statistic.add(state, index, &(self.part)(output));
    }

    fn merge(&self, state: &mut T::State, later: T::State) {
        self.statistic.merge(state, later);
    }

    fn describe(&self) -> String {
        format!("a part: {}", self.statistic.describe())
    }

    fn check(&self) -> Result<(), String> {
        self.statistic.check()
    }
}

/// A statistic of those outputs that are there: of event times, say, where not every sample has the event.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Present<T>(pub T);

impl<O, T: Statistic<O>> Statistic<Option<O>> for Present<T> {
    type State = T::State;

    fn empty(&self) -> T::State {
        self.0.empty()
    }

    fn add(&self, state: &mut T::State, index: u64, output: &Option<O>) {
        if let Some(output) = output {
            self.0.add(state, index, output);
        }
    }

    fn merge(&self, state: &mut T::State, later: T::State) {
        self.0.merge(state, later);
    }

    fn describe(&self) -> String {
        format!("if present: {}", self.0.describe())
    }

    fn check(&self) -> Result<(), String> {
        self.0.check()
    }
}

/// The same statistic of each of `K` outputs: of observables at `K` times, say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Each<T>(pub T);

impl<O, T: Statistic<O>, const K: usize> Statistic<[O; K]> for Each<T> {
    type State = [T::State; K];

    fn empty(&self) -> Self::State {
        core::array::from_fn(|_| self.0.empty())
    }

    fn add(&self, state: &mut Self::State, index: u64, output: &[O; K]) {
        for (state, output) in state.iter_mut().zip(output) {
            self.0.add(state, index, output);
        }
    }

    fn merge(&self, state: &mut Self::State, later: Self::State) {
        for (state, later) in state.iter_mut().zip(later) {
            self.0.merge(state, later);
        }
    }

    fn describe(&self) -> String {
        format!("each of {K}: {}", self.0.describe())
    }

    fn check(&self) -> Result<(), String> {
        self.0.check()
    }
}

macro_rules! tuples {
    ($(($($name:ident $place:tt),*))*) => {$(
        impl<O, $($name: Statistic<O>),*> Statistic<O> for ($($name,)*) {
            type State = ($($name::State,)*);

            fn empty(&self) -> Self::State {
                ($(self.$place.empty(),)*)
            }

            fn add(&self, state: &mut Self::State, index: u64, output: &O) {
                $(self.$place.add(&mut state.$place, index, output);)*
            }

            fn merge(&self, state: &mut Self::State, later: Self::State) {
                $(self.$place.merge(&mut state.$place, later.$place);)*
            }

            fn describe(&self) -> String {
                format!("({})", [$(self.$place.describe()),*].join("; "))
            }

            fn check(&self) -> Result<(), String> {
                $(self.$place.check()?;)*
                Ok(())
            }
        }
    )*};
}

tuples! {
    (A 0, B 1)
    (A 0, B 1, C 2)
    (A 0, B 1, C 2, D 3)
    (A 0, B 1, C 2, D 3, E 4)
    (A 0, B 1, C 2, D 3, E 4, F 5)
}

/// Numbers for the tests of statistics, and the ways to feed them.
#[cfg(test)]
mod testing {
    use super::Statistic;
    use crate::ensemble::source::{Random, Source};
    use rand_distr::{Distribution, StandardNormal};

    /// Standard normal numbers.
    pub fn normal(n: u64) -> Vec<f64> {
        (0..n).map(|index| StandardNormal.sample(&mut Random::seed(11).draw(index))).collect()
    }

    /// The state of `outputs`, in parts of different lengths that are merged in a lopsided tree.
    pub fn merged<O, T: Statistic<O>>(statistic: &T, outputs: &[O]) -> T::State {
        let mut whole = statistic.empty();
        let mut first = 0;
        for length in (1..).map(|k| 1 + k * k % 37) {
            let part = &outputs[first..(first + length).min(outputs.len())];
            let mut state = statistic.empty();
            for (k, output) in part.iter().enumerate() {
                statistic.add(&mut state, (first + k) as u64, output);
            }
            statistic.merge(&mut whole, state);
            first += part.len();
            if first == outputs.len() {
                break;
            }
        }
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_combinations_are_fed_what_is_theirs() {
        let statistic = (Each(Moments), of(|x: &[f64; 2]| (x[0] > 1.0).then_some(x[1]), Present(Moments)));
        let (each, present) = testing::merged(&statistic, &[[1.0, 10.0], [2.0, 20.0], [3.0, 60.0]]);
        assert_eq!((each[0].mean(), each[1].mean()), (2.0, 30.0));
        assert_eq!((present.count(), present.mean()), (2, 40.0));
        let bad = (Moments, of(|x: &f64| *x, Histogram::new(1.0, 0.0, 3)));
        assert!(Statistic::<f64>::check(&bad).is_err());
    }
}
