//! The steps at which methods blow up: theory from their coefficients against the steps that they make.

#![allow(dead_code)]

#[path = "../examples/stability/limits.rs"]
mod limits;
#[path = "../examples/stability/systems.rs"]
mod systems;

#[test]
fn limits_of_theory_are_met_within_one_per_cent() {
    for limit in limits::limits() {
        assert!(
            limit.agrees(),
            "{} on the {} oscillator: {:?}, should be {:?}",
            limit.method,
            limit.axis,
            limit.measured,
            limit.theory
        );
    }
}
