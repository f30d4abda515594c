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
    Separable, System, dual_jacobian,
};

#[doc(hidden)]
pub mod __private {
    pub use lagrange_macros::lagrangian;
}

/// Placeholder docs.
#[macro_export]
macro_rules! lagrangian {
    ($($definition:tt)*) => { $crate::__private::lagrangian! { @crate [$crate] $($definition)* } };
}

/// What most programs need.
pub mod prelude {
    pub use crate::lagrangian;
    pub use crate::scalar::*;
    pub use crate::system::*;
}
