//! Sources of the samples of an ensemble: random numbers, a Sobol sequence, or a table.

use super::EnsembleError;
use super::record::Record;
use super::sobol::Points;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The draw of sample number `index`. It depends on nothing but the source and the index, so that each sample can be
/// drawn alone, by any thread, in any order, and again.
pub trait Source: Sync {
    /// Draw that the user's function is given for one sample.
    type Draw;

    /// The draw of a sample.
    fn draw(&self, index: u64) -> Self::Draw;

    /// Checks that there are that many samples.
    fn check(&self, samples: u64) -> Result<(), EnsembleError>;

    /// Description that distinguishes this source from others, for checkpoints.
    fn describe(&self) -> String;
}

/// Random numbers: each sample has a generator of its own, for the distributions of [`rand_distr`](super::rand_distr).
///
/// The generator is ChaCha with 8 rounds, which counts instead of stepping: its key is the seed, its stream the
/// index. Streams do not overlap, whatever each draws.
///
/// ```
/// use lagrange_runtime::ensemble::{Random, Source, rand_distr::{Distribution, Normal}};
/// let source = Random::seed(7);
/// let normal = Normal::new(1.0, 0.1)?;
/// let first = normal.sample(&mut source.draw(1_000_000));
/// assert_eq!(first, normal.sample(&mut source.draw(1_000_000)));
/// assert_ne!(first, normal.sample(&mut source.draw(1_000_001)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Random {
    seed: u64,
    generator: ChaCha8Rng,
}

impl Random {
    /// Random numbers of this seed.
    pub fn seed(seed: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        Random { seed, generator: ChaCha8Rng::from_seed(key) }
    }
}

impl Source for Random {
    type Draw = ChaCha8Rng;

    fn draw(&self, index: u64) -> ChaCha8Rng {
        let mut generator = self.generator.clone();
        generator.set_stream(index);
        generator
    }

    fn check(&self, _samples: u64) -> Result<(), EnsembleError> {
        Ok(())
    }

    fn describe(&self) -> String {
        format!("ChaCha8, seed {}", self.seed)
    }
}

/// Points of the unit cube in `D` dimensions that fill it more evenly than random ones: the Sobol sequence with the
/// direction numbers of Joe and Kuo, scrambled by Owen's method. Means of smooth functions converge nearly as 1/n and
/// better, instead of as 1/√n; powers of two are the best numbers of samples.
///
/// A coordinate u is uniform in the open interval (0, 1): `a + (b − a) u` is uniform between a and b, and any
/// distribution comes of its quantile function. With several seeds, the scatter of the results estimates their error.
///
/// ```
/// use lagrange_runtime::ensemble::{Sobol, Source};
/// let source = Sobol::<2>::seed(7);
/// let mean = (0..256).map(|index| source.draw(index)).map(|[u, v]| u * v).sum::<f64>() / 256.0;
/// assert!((mean - 0.25).abs() < 1e-3);
/// ```
///
/// # Hypotheses
/// - D is 1 to 64: there are direction numbers for so many dimensions. The compiler rejects others.
///
/// ```compile_fail,E0080
/// let source = lagrange_runtime::ensemble::Sobol::<65>::seed(7);
/// ```
///
/// ```compile_fail,E0080
/// let source = lagrange_runtime::ensemble::Sobol::<0>::seed(7);
/// ```
/// - The index of a sample is below 2⁵²; an ensemble of more fails with [`EnsembleError::TooFewRows`].
#[derive(Clone, Debug)]
pub struct Sobol<const D: usize> {
    seed: u64,
    points: Points<D>,
}

impl<const D: usize> Sobol<D> {
    /// A sequence scrambled by this seed.
    pub fn seed(seed: u64) -> Self {
        Sobol { seed, points: Points::new(seed) }
    }
}

impl<const D: usize> Source for Sobol<D> {
    type Draw = [f64; D];

    fn draw(&self, index: u64) -> [f64; D] {
        self.points.point(index)
    }

    fn check(&self, samples: u64) -> Result<(), EnsembleError> {
        let available = 1 << 52;
        if samples > available {
            return Err(EnsembleError::TooFewRows { rows: available, samples });
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("Sobol in {D} dimensions, Owen scrambling, seed {}", self.seed)
    }
}

/// Given samples: row k is what sample k is made of.
///
/// ```
/// use lagrange_runtime::ensemble::{Source, Table};
/// let source = Table::new([[1.0, 0.0], [1.1, 0.0], [1.2, 0.1]]);
/// assert_eq!(source.draw(2), [1.2, 0.1]);
/// ```
#[derive(Clone, Debug)]
pub struct Table<R> {
    rows: Vec<R>,
}

impl<R> Table<R> {
    /// A table of these rows.
    pub fn new(rows: impl IntoIterator<Item = R>) -> Self {
        Table { rows: rows.into_iter().collect() }
    }

    /// The number of rows.
    pub fn len(&self) -> u64 {
        self.rows.len() as u64
    }

    /// Returns whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

impl<R: Record + Clone + Sync> Source for Table<R> {
    type Draw = R;

    /// # Panics
    /// If there is no such row. An ensemble never needs this value.
    fn draw(&self, index: u64) -> R {
        self.rows[index as usize].clone()
    }

    fn check(&self, samples: u64) -> Result<(), EnsembleError> {
        let rows = self.len();
        if samples > rows { Err(EnsembleError::TooFewRows { rows, samples }) } else { Ok(()) }
    }

    fn describe(&self) -> String {
        let mut bytes = vec![];
        self.rows.iter().for_each(|row| row.write(&mut bytes));
        format!("table of {} rows, checksum {:08x}", self.rows.len(), crc32fast::hash(&bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::Rng;

    #[test]
    fn streams_are_those_of_chacha_with_the_seed_as_key_and_the_index_as_nonce() {
        let mut key = [0; 32];
        key[0] = 9;
        let mut whole = ChaCha8Rng::from_seed(key);
        whole.set_stream(3);
        let mut drawn = Random::seed(9).draw(3);
        for _ in 0..1000 {
            assert_eq!(drawn.next_u64(), whole.next_u64());
        }
        let first = |seed, index| Random::seed(seed).draw(index).next_u64();
        assert_ne!(first(9, 3), first(9, 4));
        assert_ne!(first(9, 3), first(10, 3));
    }

    #[test]
    fn sources_know_what_they_have() {
        assert!(matches!(Table::new([1.0]).check(2), Err(EnsembleError::TooFewRows { rows: 1, samples: 2 })));
        assert!(Sobol::<64>::seed(0).check(1 << 52).is_ok());
        assert!(matches!(Sobol::<1>::seed(0).check((1 << 52) + 1), Err(EnsembleError::TooFewRows { .. })));
        assert_ne!(Table::new([1.0]).describe(), Table::new([2.0]).describe());
    }
}
