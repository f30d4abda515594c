//! Analysis of a system without integrating it, or by integrating its neighbours with it: equilibria, small
//! vibrations, steady motions, their stability and their bifurcations; periodic orbits, Floquet multipliers and
//! Lyapunov exponents.
//!
//! Everything follows from what `lagrangian!` emits: [`Linearize`](crate::traits::Linearize) gives the exact
//! derivatives of the forces, [`Lagrangian`](crate::Lagrangian) the inertia, the momenta and the Jacobian. Nothing is
//! differenced.
//!
//! | question | answer |
//! |---|---|
//! | Where can it rest? | [`equilibria`], [`equilibrium`] |
//! | How does it vibrate there? | [`small_vibrations`], [`SmallMotion::modes`], [`SmallMotion::spectrum`], [`SmallMotion::frequency_response`] |
//! | Which of its modes does a scene need? | [`ModalModel`]: the system kept to some modes, propagated exactly |
//! | How does it move steadily, with which rates? | [`Reduced`]: effective potential, turning points, steady rates, thresholds |
//! | Does it stay there? | [`Equilibrium::stability`], [`SmallMotion::energy_criterion`], [`SmallMotion::first_approximation`], [`Spectrum::is_stable`], [`stability_threshold`] |
//! | What becomes of it when a parameter changes? | [`follow`]: folds, pitchforks, transcritical and multiple branch points, flutter |
//! | Which motions repeat, and do they attract? | [`periodic_orbit`] with its Floquet multipliers |
//! | Where do states of first order and coordinates rest, and with which poles? | [`operating_point`], [`StateSpace::poles`] |
//! | How does it answer to its inputs? | [`StateSpace`]: A, B, C and D, also from instant to instant of a sampled controller |
//! | Where do neighbours go? | [`fundamental_matrix`] by [`ByVariationalEquations`] or [`ByGradients`], [`sensitivity`] |
//! | Is it chaotic? | [`lyapunov_spectrum`], [`lyapunov_by_two_trajectories`]; sections by [`Run::events`](crate::Run::events) |
//!
//! Units are those that the system is written in. Documentation names SI units: a frequency or a rate in rad/s is one
//! in rad per unit of t. Vectors have the order of the coordinates ([`Facts::coordinates`](crate::Facts::coordinates)),
//! and q above q̇ where they have both.
//!
//! Where coordinates are not independent, everything is in minimal coordinates of what the constraints admit
//! ([`SmallMotion::basis`]), but for [`follow`], which has their multipliers beside the coordinates.
//!
//! Eigenvalues, Schur forms and singular values are nalgebra's, on dynamic matrices.

mod balance;
mod constrained;
mod continuation;
mod eigen;
mod equilibrium;
mod error;
mod exponential;
mod hypotheses;
mod kink;
mod lyapunov;
mod modal;
mod model;
mod modes;
mod motion;
mod operating_point;
mod pencil;
mod periodic;
mod quadratic;
mod small;
mod spectrum;
mod stability;
mod state_space;
mod steady;
mod switch;
mod tangent;
mod variational;
mod wide;

pub use continuation::{Bifurcation, BifurcationKind, Branch, BranchPoint, Heading, Path, follow};
pub use equilibrium::{Equilibrium, equilibria, equilibrium, small_vibrations};
pub use error::AnalysisError;
pub use lyapunov::{Exponent, Measurement, lyapunov_by_two_trajectories, lyapunov_spectrum};
pub use modal::{ModalModel, Remainder};
pub use model::LinearModel;
pub use modes::{ModeKind, Modes};
pub use motion::SmallMotion;
pub use nalgebra::{Complex, DMatrix, DVector};
pub use operating_point::{OperatingPoint, operating_point};
pub use periodic::{Period, PeriodicOrbit, periodic_orbit};
pub use spectrum::Spectrum;
pub use stability::Stability;
pub use state_space::StateSpace;
pub use steady::{Reduced, Steady, stability_threshold};
pub use variational::{
    ByGradients, ByVariationalEquations, Sensitivity, TangentFlow, Variational, fundamental_matrix,
    sensitivity,
};
