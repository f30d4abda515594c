//! Numbers side by side, computed with the vector instructions that the processor has.

#[cfg(all(test, feature = "ensemble"))]
mod accuracy;
mod array;
mod control;
#[cfg(feature = "std")]
mod extremes;
mod functions;
mod kernels;
mod lanewise;
mod number;
mod pack;
mod policy;
mod processor;
#[cfg(feature = "std")]
mod range;
mod registers;
mod system;
mod trigonometric;
#[cfg(feature = "std")]
mod watch;

#[cfg(feature = "std")]
pub use crate::integrate::lanes::{Bounds, InLanes, Job, Jobs};
pub(crate) use array::sin_cos as sin_cos_array;
pub use control::LaneController;
#[cfg(feature = "std")]
pub use extremes::{Extremes, Range};
pub use lanewise::Lanewise;
pub(crate) use lanewise::lanewise;
pub use number::{Lanes, SingleLane};
pub use policy::{Fused, Native, Plain, Policy};
#[cfg(all(target_arch = "x86_64", feature = "std"))]
pub use processor::{Avx2, Avx512};
pub use processor::{Baseline, Level, Processor, Work};
#[cfg(feature = "std")]
pub use range::InRange;
pub(crate) use registers::Pair;
pub use system::{Accelerations, Rescale};
#[cfg(feature = "std")]
pub(crate) use watch::disordered;
#[cfg(feature = "std")]
pub use watch::{FinalState, FoldSteps, Motion, Observer, Occurrences, Sampled};
