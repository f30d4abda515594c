//! The examples of linkages and of a controller. Each holds its results against closed forms, balances and conserved
//! quantities, and fails if one is off.

// Each example brings what it shares with others itself, so that it is a program.
#![allow(clippy::duplicate_mod)]

#[path = "../../examples/cart_pole.rs"]
mod cart_pole;
#[path = "../../examples/chain_on_a_cart.rs"]
mod chain_on_a_cart;
#[path = "../../examples/four_bar.rs"]
mod four_bar;
#[path = "../../examples/motor.rs"]
mod motor;
#[path = "../../examples/quadrotor.rs"]
mod quadrotor;
#[path = "../../examples/smaller_models/main.rs"]
mod smaller_models;
#[path = "../../examples/spherical_pendulum.rs"]
mod spherical_pendulum;
#[path = "../../examples/tree.rs"]
mod tree;
#[path = "../../examples/tumbling.rs"]
mod tumbling;
#[path = "../../examples/wind_turbine.rs"]
mod wind_turbine;

#[test]
fn a_pole_on_a_cart() {
    cart_pole::main().unwrap();
}

#[test]
fn a_chain_on_a_cart() {
    chain_on_a_cart::main().unwrap();
}

#[test]
fn smaller_models_hold_and_break_down() {
    smaller_models::draw(5).unwrap();
}

#[test]
fn a_tree() {
    tree::main().unwrap();
}

#[test]
fn a_four_bar_linkage() {
    four_bar::main().unwrap();
}

#[test]
fn a_wind_turbine_follows_a_measured_wind() {
    wind_turbine::main().unwrap();
}

#[test]
fn a_motor_lifts_a_pendulum() {
    motor::main().unwrap();
}

#[test]
fn a_quadrotor_thrown_upside_down_takes_its_load_along() {
    quadrotor::main().unwrap();
}

#[test]
fn a_body_that_turns_over() {
    tumbling::main().unwrap();
}

#[test]
fn a_spherical_pendulum() {
    spherical_pendulum::main().unwrap();
}
