//! Golden systems: each is written as a user would write it, then compared with reference digits and with the
//! equations of motion derived by hand. One system is one file and one line here.

mod harness;

mod bead_in_spinning_tube;
mod block_on_wedge;
mod central_force;
mod coupled_pendula;
mod cylindrical_particle;
mod damped_two_dof;
mod double_pendulum;
mod driven_rigid_pendulum;
mod forced_vibration;
mod ignorable_with_drag;
mod pendulum_moving_support;
mod prescribed_length;
mod reduced_central_force;
mod reduced_ignorable_with_drag;
mod reduced_top;
mod simple_pendulum;
mod spherical_particle;
mod spherical_pendulum;
mod stokes_fall;
mod symmetric_top;
mod table_and_hanging_mass;
mod two_mass_chain;
