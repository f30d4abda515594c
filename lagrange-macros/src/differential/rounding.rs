//! Change of a result when the result of every operation is moved a little: stochastic arithmetic (Vignes 2004),
//! as a measure of the rounding error that a computation in floating point must be granted.

use super::generate::Random;
use num_dual::{Dual, Dual3, DualNum, HyperDual};
use std::cell::RefCell;

/// Relative changes, far above rounding and far below what could bend a function.
pub const SIZE: f64 = 1.0 / (1u64 << 34) as f64;

/// Random relative changes, or none.
pub struct Noise(Option<RefCell<Random>>);

impl Noise {
    /// The first computation is without noise.
    pub fn of_run(run: u64, seed: u64) -> Noise {
        Noise((run > 0).then(|| RefCell::new(Random::new(seed ^ run << 48))))
    }

    pub fn apply(&self, x: f64) -> f64 {
        let Some(random) = &self.0 else { return x };
        let r = random.borrow_mut().between(-1.0, 1.0);
        // Between half and the whole size, so that a single operation shows in every run.
        x * (1.0 + SIZE * (r + r.signum()) / 2.0)
    }
}

/// A number each of whose parts can be disturbed by itself.
pub trait Noisy: DualNum<Primitive = f64> + Copy + 'static {
    fn noisy(self, noise: &Noise) -> Self;
}

impl Noisy for f64 {
    fn noisy(self, noise: &Noise) -> f64 {
        noise.apply(self)
    }
}

impl<T: Noisy> Noisy for Dual<T> {
    fn noisy(self, noise: &Noise) -> Self {
        Dual::new(self.re.noisy(noise), self.eps.noisy(noise))
    }
}

impl<T: Noisy> Noisy for HyperDual<T> {
    fn noisy(self, noise: &Noise) -> Self {
        let HyperDual { re, eps1, eps2, eps1eps2 } = self;
        HyperDual::new(re.noisy(noise), eps1.noisy(noise), eps2.noisy(noise), eps1eps2.noisy(noise))
    }
}

impl<T: Noisy> Noisy for Dual3<T> {
    fn noisy(self, noise: &Noise) -> Self {
        let Dual3 { re, v1, v2, v3 } = self;
        Dual3::new(re.noisy(noise), v1.noisy(noise), v2.noisy(noise), v3.noisy(noise))
    }
}
