//! The expression graph.
pub mod function;
