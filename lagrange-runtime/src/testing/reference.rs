//! Exact motions to measure methods against: closed forms, and Taylor series where there are none, in arithmetic of
//! 32 digits, rounded once at the end.
//!
//! A method is never compared with itself at a smaller step. Errors of good methods come down to 1e-15, so a
//! reference has to be right to the last digit, after a thousand periods too. Plain `f64` is not: the phase `ω₀ t` of
//! a hundred periods alone is uncertain by `600 × 2⁻⁵³ = 7e-14`. Parameters, initial values and t are therefore taken
//! as the exact doubles that they are, and everything up to the result is computed in double-double arithmetic.
//!
//! | motion | closed form |
//! |---|---|
//! | [`SimplePendulum`] | Jacobi's elliptic functions [`jacobi_elliptic`], period `4K/ω₀` with [`elliptic_k`] |
//! | [`KeplerOrbit`] | Kepler's equation in the difference of eccentric anomaly, Lagrange's f and g |
//! | [`LinearChain`] | normal modes of equal masses between equal springs |
//! | [`SeriesMotion`] | none: any system by its Taylor series, to 1e-30 a step, for all methods but [`Taylor`](const@crate::Taylor) itself |

mod chain;
mod elliptic;
mod kepler;
mod pendulum;
mod series;

pub use chain::LinearChain;
pub use elliptic::{elliptic_k, jacobi_elliptic};
pub use kepler::KeplerOrbit;
pub use pendulum::SimplePendulum;
pub use series::SeriesMotion;
