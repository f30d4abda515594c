//! Runs whose method is chosen, of systems that were prepared, and with constraints.

mod choice;
mod constraints;
mod prepared;
#[path = "../../../lagrange-runtime/tests/systems/mod.rs"]
mod systems;
mod told;
