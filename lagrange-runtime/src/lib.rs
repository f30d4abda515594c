//! Placeholder.
#![cfg_attr(not(feature = "std"), no_std)]
extern crate self as lagrange_runtime;

#[cfg(feature = "chart")]
pub mod chart;
pub mod reference;
pub mod scalar;
pub mod system;
#[cfg(feature = "std")]
pub mod work_precision;

pub use nalgebra::{SMatrix, SVector};
pub use scalar::{Comparison, Dual, Functions, Real, Scalar};
pub use system::{
    Conservative, ConstantInertia, Energies, Facts, Jacobian, Lagrangian, Legendre, Linear, Operations,
    Separable, System,
};
