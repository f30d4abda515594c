//! Emission.
pub mod functions;
