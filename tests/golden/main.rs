//! Golden systems: each is written as a user would write it, then compared with reference digits and with the
//! equations of motion derived by hand. A file holds one system, or a few that belong together, and says all that is
//! known about it in `rows`, which the tests below assert on and the example `chapter11` prints. One file is one line
//! here, and another where it is declared.
//!
//! The rows are the mechanical systems and statements of Beatty, *Principles of Engineering Mechanics 2* (2006),
//! ch. 11.

#[macro_use]
mod harness;

mod atwood;
mod bead_in_spinning_tube;
mod block_on_wedge;
mod central_force;
mod constraints;
mod coupled_pendula;
mod cylindrical_particle;
mod damped_two_dof;
mod double_pendulum;
mod driven_rigid_pendulum;
mod forced_vibration;
mod generic_two_dof;
mod gyrocompass;
mod ignorable_with_drag;
mod impulses;
mod inertia_table;
mod moving_frame;
mod moving_incline;
mod path;
mod pendulum_moving_support;
mod pfaffian;
mod prescribed_length;
mod projectile;
mod rod_in_circle;
mod rod_on_disk;
mod rolling;
mod rotating_frame;
mod rotating_pendulum;
mod simple_pendulum;
mod slider_on_table;
mod spherical_particle;
mod spherical_pendulum;
mod sprung_bodies;
mod stokes_fall;
mod stokes_medium;
mod surfaces;
mod symmetric_top;
mod table_and_hanging_mass;
mod theory;
#[cfg(test)]
mod thirty_digits;
mod two_mass_chain;
mod wheel_and_block;
mod wire_suspended_body;

pub use harness::{Kind, Row};

macro_rules! golden_files {
    ($($file:ident)*) => {
        /// The rows of each file.
        pub const FILES: &[fn() -> Vec<Row>] = &[$($file::rows),*];

        #[cfg(test)]
        mod tests {
            $(
                #[test]
                fn $file() {
                    super::harness::assert_rows(&super::$file::rows());
                }
            )*
        }
    };
}

golden_files! {
    atwood
    bead_in_spinning_tube
    block_on_wedge
    central_force
    constraints
    coupled_pendula
    cylindrical_particle
    damped_two_dof
    double_pendulum
    driven_rigid_pendulum
    forced_vibration
    generic_two_dof
    gyrocompass
    ignorable_with_drag
    impulses
    inertia_table
    moving_frame
    moving_incline
    path
    pendulum_moving_support
    pfaffian
    prescribed_length
    projectile
    rod_in_circle
    rod_on_disk
    rolling
    rotating_frame
    rotating_pendulum
    simple_pendulum
    slider_on_table
    spherical_particle
    spherical_pendulum
    sprung_bodies
    stokes_fall
    stokes_medium
    surfaces
    symmetric_top
    table_and_hanging_mass
    theory
    two_mass_chain
    wheel_and_block
    wire_suspended_body
}

/// The catalogue of the chapter, in its order. The names are those of the files of digits.
pub const CATALOGUE: [&str; 95] = [
    "sec-11.2-disk-point-on-path",
    "sec-11.2.1-pendulum-cartesian",
    "sec-11.2.1-moving-incline",
    "sec-11.2.1-moving-incline-multiplier",
    "sec-11.2.2-rolling-disk",
    "sec-11.2.2-rolling-disk-straight",
    "exer-11.1-pfaffian",
    "sec-11.3-moving-cylindrical-frame",
    "ex-11.1-cylindrical-particle",
    "exer-11.2-generalized-force-two-ways",
    "exer-11.3-spherical-particle",
    "sec-11.4-workless-force",
    "exer-11.4-euler-identity",
    "exer-11.5-kinetic-energy-split",
    "exer-11.6-virtual-work",
    "ex-11.2-simple-pendulum",
    "ex-11.3-central-force",
    "ex-11.4-stokes-fall-QN",
    "ex-11.5a-bead-in-spinning-tube",
    "ex-11.5b-bead-relaxed",
    "exer-11.7-forced-vibration",
    "ex-11.6i-two-mass-chain",
    "ex-11.6ii-two-mass-symmetric",
    "sec-11.10.1-central-force-reduced",
    "ex-11.7-ignorable-nonconservative",
    "sec-11.10.2-projectile",
    "sec-11.10.2-spherical-pendulum-cylindrical",
    "exer-11.8-jacobi-balance",
    "ex-11.8-impulse-dumbbell",
    "ex-11.9-wheel-cable-block",
    "ex-11.10-driven-rigid-pendulum",
    "exer-11.9-action-with-work",
    "sec-11.12.1-inertia-table",
    "sec-11.12.2.1-rotating-pendulum",
    "sec-11.12.2.2-rotating-pendulum-relaxed",
    "sec-11.12.3-gyrocompass-full",
    "sec-11.12.3-gyrocompass-truncated",
    "sec-11.12.3-gyrocompass-small",
    "sec-11.12.4-symmetric-top",
    "sec-11.12.4-top-reduced",
    "sec-11.12.4.3-nutation",
    "sec-11.12.4.4-steady-precession",
    "sec-11.12.4.4-sleeping-top",
    "exer-11.10-sleeping-gyroscopic-pendulum",
    "sec-11.13.1-small-pendulum",
    "ex-11.11-generic-two-dof",
    "ex-11.12i-wire-suspended-body",
    "ex-11.12-small",
    "ex-11.12ii-disk-on-wire",
    "sec-11.14-stokes-particle-energy",
    "ex-11.13-stokes-fall-rayleigh",
    "sec-11.14-lineal-rigid-body",
    "ex-11.14-damped-two-dof",
    "prob-11.1-frobenius-form",
    "prob-11.2-intrinsic",
    "prob-11.2-cycloid",
    "prob-11.3-spherical-pendulum",
    "prob-11.4-string-through-hole",
    "prob-11.4-prescribed-length",
    "prob-11.5-paraboloid-drag",
    "prob-11.6-slider-on-spinning-table",
    "prob-11.7-slider-with-spring",
    "prob-11.8-slider-inclined-rod",
    "prob-11.9-slider-two-springs",
    "prob-11.9b-slider-relaxed",
    "prob-11.10-pendulum-moving-support",
    "prob-11.11-surface-of-revolution",
    "prob-11.12-uniform-motion-rotating-frame",
    "prob-11.13-table-and-hanging-mass",
    "prob-11.14-block-on-wedge",
    "prob-11.15-rod-and-spring",
    "prob-11.16-rod-brought-to-rest",
    "prob-11.17-floating-log",
    "prob-11.18-rod-on-spinning-table",
    "prob-11.18-rod-multiplier",
    "prob-11.19-cylinder-in-trough",
    "prob-11.20-rocking-segment",
    "prob-11.21-rod-in-circle",
    "prob-11.22-rod-in-rotating-hoop",
    "prob-11.23-eccentric-cylinder",
    "prob-11.24-spring-pulley",
    "prob-11.25-hoop-with-rod",
    "prob-11.26-table-rod-slider-driven",
    "prob-11.27-dumbbell-on-springs",
    "prob-11.28-atwood",
    "prob-11.29-two-hinged-rods-impulse",
    "prob-11.30-rod-mass-spring",
    "prob-11.31-rod-on-turning-disk",
    "prob-11.31-rod-on-disk-relaxed",
    "prob-11.32-bounce-pitch",
    "prob-11.33-slider-spring-rod",
    "prob-11.34-coupled-pendula",
    "prob-11.35-double-pendulum",
    "prob-11.36-metronome",
    "prob-11.37-coupled-pendula-stokes",
];
