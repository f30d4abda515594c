//! Systems of several tests: written by hand, written in the language, and by their address.
#![allow(dead_code)]

pub mod any;
pub mod bank;
pub mod emitted;
