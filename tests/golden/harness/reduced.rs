//! Does a reduced system move as the whole one?

use super::reference::Reference;
use super::row::{Finding, Kind, Row};
use super::subject::Golden;
use lagrange_runtime::prelude::{Dop853, Lagrangian, PiController, Routhian, SVector, State, integrate};

/// Error of a trajectory that is recovered by quadrature, in units of the coordinates and rates.
const RECOVERED: f64 = 1e-11;

/// The motion of the whole system's file, by the reduced system and quadrature for what was removed.
pub fn recovered<Whole, Reduced, const N: usize, const I: usize, const WHOLE: usize>(
    row: Row,
    whole: &Whole,
    reduce: impl Fn(&Whole, &State<f64, WHOLE>) -> (Reduced, State<f64, N>),
) -> Row
where
    Whole: Golden<WHOLE> + Lagrangian<WHOLE, Scalar = f64>,
    Reduced: Routhian<N, I, WHOLE, Scalar = f64>,
{
    let motion = Reference::read(<Whole as Golden<WHOLE>>::REFERENCE).trajectory();
    let of = |at: &super::State| State {
        t: at.t,
        q: SVector::from_column_slice(&at.q),
        qd: SVector::from_column_slice(&at.qd),
    };
    let start: State<f64, WHOLE> = of(&motion[0]);
    let (reduced, state) = reduce(whole, &start);
    let removed: [f64; I] = std::array::from_fn(|k| start.q[Whole::FACTS.ignorable[k]]);
    motion[1..].iter().fold(row, |row, expected| {
        let what = format!("recovered at t = {}", expected.t);
        let run = integrate(&reduced, Dop853, PiController::tolerance(1e-14), state).until(expected.t);
        let Some(Ok(end)) = run.recover(removed).last() else {
            return row.finding(Finding::failed(what, "the run failed"));
        };
        let x = |q: &[f64], qd: &[f64]| [q, qd].concat();
        let (got, expected) = (x(end.q.as_slice(), end.qd.as_slice()), x(&expected.q, &expected.qd));
        let size = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
        row.finding(Finding::compare(Kind::Motion, what, &got, &expected, RECOVERED * size))
    })
}
