//! Placeholder.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]
extern crate self as lagrange_runtime;

pub mod controller;
pub mod failure;
pub mod integrate;
pub mod linear;
pub mod method;
pub mod sample;
pub mod scalar;
pub mod state;
pub mod system;
pub mod testing;

pub use controller::{Controller, ErrorEstimate, Fixed, NoEstimate, Pi};
pub use failure::Failure;
pub use integrate::{Run, Statistics, integrate};
pub use method::explicit_rk::{Dop853, DormandPrince5, Euler, Rk4};
pub use method::gauss::{Gauss4, Gauss6, ImplicitMidpoint};
pub use method::splitting::{PositionVerlet, Verlet};
pub use method::{Dense, Method, Step};
pub use nalgebra::{SMatrix, SVector};
pub use sample::{Failed, Samples};
pub use scalar::{Comparison, Dual, Functions, Real, Scalar};
pub use state::{State, Tangent};
pub use system::{
    Conservative, ConstantInertia, Energies, Facts, Jacobian, Lagrangian, Legendre, Linear, Operations,
    Separable, System,
};

/// What a program that integrates needs: `use lagrange_runtime::prelude::*;`.
pub mod prelude {
    pub use crate::{
        Dense, Dop853, DormandPrince5, Dual, Euler, Failure, Fixed, Functions, Gauss4, Gauss6,
        ImplicitMidpoint, Lagrangian, Method, Pi, PositionVerlet, Real, Rk4, SMatrix, SVector, Scalar, State,
        System, Verlet, integrate,
    };
}
