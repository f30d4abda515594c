//! Placeholder.
#![cfg_attr(not(feature = "std"), no_std)]
extern crate self as lagrange_runtime;

pub mod reference;
pub mod scalar;
pub mod system;

pub use nalgebra::{SMatrix, SVector};
pub use scalar::{Comparison, Dual, Functions, Real, Scalar};
pub use system::{
    Conservative, ConstantInertia, Energies, Facts, Jacobian, Lagrangian, Legendre, Linear, Operations,
    Separable, System,
};
