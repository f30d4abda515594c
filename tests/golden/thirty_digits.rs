//! `reference::SeriesMotion`, against which methods are measured where there is no closed form, itself against 30
//! digits that were computed without this project.

use super::central_force::CentralForce;
use super::double_pendulum::{DoublePendulum, PendulumOfBobs};
use super::harness::{Golden, Reference};
use super::simple_pendulum::SimplePendulum;
use super::surfaces::ParaboloidWithDrag;
use super::symmetric_top::SymmetricTop;
use lagrange_runtime::testing::reference::SeriesMotion;
use lagrange_runtime::{DoubleDouble, State, traits::Analytic};

/// A decimal number to some 31 digits.
fn parsed(digits: &str) -> DoubleDouble {
    let (sign, unsigned) = digits.strip_prefix('-').map_or((1.0, digits), |rest| (-1.0, rest));
    let (whole, fraction) = unsigned.split_once('.').expect("a point");
    let figures = whole.chars().chain(fraction.chars());
    let number = figures.fold(DoubleDouble::ZERO, |number, c| {
        number * 10.0 + DoubleDouble::from(f64::from(c.to_digit(10).expect("a figure")))
    });
    // Powers of ten up to 10²² are doubles.
    let places = fraction.len() as i32;
    number / 10f64.powi(places.min(22)) / 10f64.powi((places - 22).max(0)) * sign
}

/// The largest error of a coordinate or velocity at the end, each in parts of itself, or of 1 if it is smaller.
fn error<G: Golden<N>, const N: usize>() -> f64
where
    G::Over<DoubleDouble>: Analytic<N>,
{
    let reference = Reference::read(G::REFERENCE);
    let system = G::with(|name| DoubleDouble::from(reference.parameter(name)));
    let start = reference.trajectory().remove(0);
    let vector = |x: &[f64]| std::array::from_fn(|k| x[k]);
    let motion = SeriesMotion::new(system, State::new(start.t, vector(&start.q), vector(&start.qd)));
    let (q, qd, t) = reference.end();
    let end = motion.digits(t).unwrap();
    let found = end.q.iter().chain(&end.qd);
    let errors = found.zip(q.into_iter().chain(qd)).map(|(found, digits)| {
        let expected = parsed(digits);
        (*found - expected).value().abs() / expected.value().abs().max(1.0)
    });
    errors.fold(0.0, f64::max)
}

/// A chaotic motion, in which errors grow.
#[test]
fn the_double_pendulum() {
    for error in [error::<DoublePendulum, 2>(), error::<PendulumOfBobs, 2>()] {
        assert!(error < 3e-28, "{error:e}");
    }
}

/// With one coordinate, with ignorable ones, with dissipation.
#[test]
fn regular_motions() {
    for error in [
        error::<SimplePendulum, 1>(),
        error::<CentralForce, 2>(),
        error::<SymmetricTop, 3>(),
        error::<ParaboloidWithDrag, 2>(),
    ] {
        assert!(error < 1e-29, "{error:e}");
    }
}
