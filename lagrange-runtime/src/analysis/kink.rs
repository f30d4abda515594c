//! Kinks that no switching function shows: those of functions with data, of Rust functions, and of outputs.

use super::AnalysisError;
use crate::failure::Coordinate;
use crate::scalar::{Real, Scalar};
use crate::state::State;
use crate::system::Lagrangian;
use nalgebra::DMatrix;

/// Least displacement, relative to `1 + |x|`, that rounding of a place does not undo.
pub(super) const BESIDE: f64 = 64.0 * f64::EPSILON;

/// A change from one side to the other that is so many times those on either side is a jump.
const JUMP: f64 = 100.0;

/// Returns whether one of these matrices, functions of a displacement, jumps at 0: across it changes by much more than
/// from one place to the next on either side, where it changes by what is smooth and by rounding errors.
pub(super) fn jumps<const K: usize>(values: impl Fn(f64) -> [DMatrix<f64>; K]) -> bool {
    let [below, above] = [-1.0, 1.0].map(&values);
    let change = |which: usize, a: &[DMatrix<f64>; K], b: &[DMatrix<f64>; K]| (&a[which] - &b[which]).amax();
    let suspected = |which: &usize| {
        let size = below[*which].amax().max(above[*which].amax());
        let across = change(*which, &below, &above);
        // (Beyond the last place of a table nothing is known: the other side alone counts.)
        across.is_finite() && across > 256.0 * f64::EPSILON * size
    };
    let suspects: Vec<usize> = (0..K).filter(suspected).collect();
    if suspects.is_empty() {
        return false;
    }
    let sides = [(-1.0, &below), (1.0, &above)].map(|(sign, nearest)| {
        let farther = [2.0, 3.0, 4.0].map(|far| values(sign * far));
        let places: Vec<_> = [nearest].into_iter().chain(&farther).collect();
        suspects
            .iter()
            .map(|which| places.windows(2).map(|next| change(*which, next[0], next[1])).fold(0.0, f64::max))
            .collect::<Vec<_>>()
    });
    let is_jump =
        |(k, which): (usize, &usize)| change(*which, &below, &above) > JUMP * sides[0][k].max(sides[1][k]);
    suspects.iter().enumerate().any(is_jump)
}

/// Refuses a state at which forces or their derivatives jump as a coordinate or a velocity passes it. `uncertainty` is
/// that of the coordinates, relative to `1 + |q|`. Systems whose motions have Taylor series have no kinks.
pub(super) fn smooth<Sys: Lagrangian<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    uncertainty: f64,
    equations: impl Fn(&Sys, &State<Sys::Scalar, N>) -> [DMatrix<f64>; 4],
) -> Result<(), AnalysisError>
where
    Sys::Scalar: Real,
{
    if Sys::FACTS.analytic {
        return Ok(());
    }
    for i in 0..2 * N {
        let beside = |far: f64| {
            let mut there = *at;
            let moved = if i < N { &mut there.q[i] } else { &mut there.qd[i - N] };
            let h = far * (BESIDE + uncertainty) * (1.0 + moved.to_f64().abs());
            *moved += Sys::Scalar::from_f64(h);
            equations(system, &there)
        };
        if jumps(beside) {
            return Err(AnalysisError::Kink {
                coordinate: Coordinate::of::<Sys, N>(i % N),
                velocity: i >= N,
            });
        }
    }
    Ok(())
}
