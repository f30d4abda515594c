//! The listings of the guide, of the README and of the runtime's documentation compile and run: `build.rs` makes a test
//! of each, named by its line.
#![allow(unused, clippy::assertions_on_constants, clippy::excessive_precision)]

include!(concat!(env!("OUT_DIR"), "/listings.rs"));
