//! Events, samples and integrals along motions.

mod at_rounding;
mod crossings;
mod integrals;
mod samples;
#[path = "../systems/mod.rs"]
mod systems;
