//! Numbers side by side, computed with the vector instructions that the processor has.

#[cfg(all(test, feature = "ensemble"))]
mod accuracy;
mod array;
mod pack;
mod policy;
mod processor;
mod trigonometric;

pub(crate) use array::sin_cos as sin_cos_array;
pub use policy::{Fused, Native, Plain, Policy};
#[cfg(all(target_arch = "x86_64", feature = "std"))]
pub use processor::{Avx2, Avx512};
pub use processor::{Baseline, Level, Processor, Work};
