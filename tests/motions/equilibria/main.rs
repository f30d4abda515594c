//! Equilibria, their stability, and their curves.

mod curves;
mod hypotheses;
mod random;
