//! Events, samples and integrals along motions.

mod aims;
mod at_rounding;
mod crossings;
mod integrals;
mod random;
mod samples;
#[path = "../../../lagrange-runtime/tests/systems/mod.rs"]
mod systems;
