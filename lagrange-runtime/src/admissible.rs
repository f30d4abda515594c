//! Displacements and velocities that constraints admit: the terms of their linear equations, and derivatives of
//! admissible states.

use crate::constraint::Constrained;
use crate::scalar::{Dual, Scalar};
use crate::state::{ConstraintTerms, State, constant};
use nalgebra::{SMatrix, SVector};

/// [`System::constraint_terms`](crate::System::constraint_terms) of a system with constraints. `over` is the system
/// over duals, with constant parameters.
#[cold]
pub fn terms<Sys, Over, const N: usize, const M: usize>(
    system: &Sys,
    over: &Over,
    at: &State<Sys::Scalar, N>,
    mut each: impl FnMut(ConstraintTerms<Sys::Scalar, N>),
) where
    Sys: Constrained<N, M>,
    Over: Constrained<N, M, Scalar = Dual<Sys::Scalar>>,
{
    let State { t, q, qd } = at;
    let (values, rates) = (system.constraints(q, *t), system.constraint_rates(q, qd, *t));
    let spare = Sys::FACTS.redundancy.map_or(0, |redundancy| M - redundancy.rank.unwrap_or(0));
    let (multipliers, rows) = (system.multipliers(q, qd, *t), system.constraint_jacobian(q, *t));
    for (j, &of) in Sys::FACTS.constraints.iter().enumerate().take(M) {
        let zero = Sys::Scalar::zero();
        let mut row_by_coordinates = SMatrix::from([[zero; N]; N]);
        let mut rate_by_coordinates = constant(zero);
        for k in 0..N {
            // Evaluated anew for each constraint: nothing is kept that would have to be allocated.
            let mut moved = at.map(Dual::constant);
            moved.q[k].slope = Sys::Scalar::one();
            let slopes = over.constraint_jacobian(&moved.q, moved.t);
            for i in 0..N {
                row_by_coordinates[(i, k)] = slopes[(j, i)].slope;
            }
            rate_by_coordinates[k] = over.constraint_rates(&moved.q, &moved.qd, moved.t)[j].slope;
        }
        each(ConstraintTerms {
            of,
            spare,
            value: values[j],
            rate: rates[j],
            multiplier: multipliers[j],
            row: SVector::from_fn(|i, _| rows[(j, i)]),
            row_by_coordinates,
            rate_by_coordinates,
        });
    }
}

/// [`System::toward_constraints`](crate::System::toward_constraints) of a system with constraints: the smallest
/// correction, measured by the inertia matrix, of the positions, and then of the velocities.
#[cold]
pub fn toward<Sys: Constrained<N, M>, const N: usize, const M: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
) -> State<Sys::Scalar, N> {
    let State { t, q, qd } = *at;
    let none = constant(Scalar::zero());
    let corrected = |q: &SVector<Sys::Scalar, N>, rest: SVector<Sys::Scalar, M>| {
        system.response(q, &qd, t, &none, &SVector::from_fn(|j, _| -rest[j])).0
    };
    let q = q + corrected(&q, system.constraints(&q, t));
    let qd = qd + corrected(&q, system.constraint_rates(&q, &qd, t));
    State { t, q, qd }
}
