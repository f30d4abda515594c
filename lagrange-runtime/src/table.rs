//! Measured data as functions: curves of one argument, surfaces of two.
//!
//! Knots are shared by all clones, so that a system with a table is cheap to clone.

mod pieces;

use crate::external::ExternFunction;
use crate::failure::debug_is_text;
use crate::scalar::Scalar;
use core::fmt;
pub use pieces::Beyond;
use pieces::{Piece, Rule, interval, pieces};
use std::sync::Arc;

/// A reason why data are no table.
#[derive(Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidTable {
    /// There are fewer than two knots along an axis.
    TooShort {
        /// Number of knots.
        knots: usize,
    },
    /// There is another number of values than of knots, or of knots of one axis times those of the other.
    Lengths {
        /// Number of values that the knots need.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A knot is not larger than the one before it, or not finite.
    Knot {
        /// Its index along its axis.
        index: usize,
    },
    /// A value is not finite.
    Value {
        /// Its index.
        index: usize,
    },
    /// Powers of the distance of two knots underflow or overflow.
    Units {
        /// Index of the first of the two along its axis.
        index: usize,
    },
}

impl fmt::Display for InvalidTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InvalidTable::TooShort { knots } => {
                write!(f, "a table of {knots} knots along an axis; it needs two")
            }
            InvalidTable::Lengths { expected, found } => {
                write!(f, "a table whose knots need {expected} values and that has {found}")
            }
            InvalidTable::Knot { index } => {
                write!(
                    f,
                    "knot {index} of a table is not finite, or not larger than the one before it; sort the data and merge those of equal knots"
                )
            }
            InvalidTable::Value { index } => write!(f, "value {index} of a table is not finite"),
            InvalidTable::Units { index } => write!(
                f,
                "powers of the distance between knots {index} and {} of a table underflow or overflow; give the data in other units",
                index + 1
            ),
        }
    }
}

debug_is_text! { [] InvalidTable }

impl core::error::Error for InvalidTable {}

/// Part of the largest slope by which slopes before and after a knot differ by rounding.
const SAME_SLOPE: f64 = 1e-9;

/// Fails unless these can be the knots of an axis.
fn check_knots(x: &[f64]) -> Result<(), InvalidTable> {
    if x.len() < 2 {
        return Err(InvalidTable::TooShort { knots: x.len() });
    }
    let ordered = |i: usize| x[i].is_finite() && (i == 0 || x[i - 1] < x[i]);
    (0..x.len()).find(|i| !ordered(*i)).map_or(Ok(()), |index| Err(InvalidTable::Knot { index }))
}

/// Fails unless there are so many values, all of them finite.
fn check_values(y: &[f64], expected: usize) -> Result<(), InvalidTable> {
    if y.len() != expected {
        return Err(InvalidTable::Lengths { expected, found: y.len() });
    }
    y.iter().position(|y| !y.is_finite()).map_or(Ok(()), |index| Err(InvalidTable::Value { index }))
}

/// A function of one argument through measured points (xᵢ, yᵢ), in the units of the definition that calls it: an
/// [`ExternFunction`].
///
/// | | between the knots | continuous | error for knots h apart, f smooth |
/// |---|---|---|---|
/// | [`linear`](Curve::linear) | chords | value | h² |
/// | [`monotone`](Curve::monotone) | cubics that rise and fall as the data do | and slope | h², h³ where f' ≠ 0 |
/// | [`cubic`](Curve::cubic) | the cubic spline | and curvature | h⁴ |
///
/// A jump of the k-th derivative of a force at a knot within a step costs a method of order p > k + 1 its order there;
/// error control makes steps shorter. The spline is the choice for high orders.
///
/// Clones share the points. The value is NaN where the argument is.
///
/// ```
/// use lagrange_runtime::prelude::*;
/// lagrangian! {
///     /// A body in a measured wind.
///     system Drifter {
///         param m, c;
///         coord x;
///         extern wind: Curve(t);
///         T = 0.5 * m * dot(x).powi(2);
///         V = 0;
///         Q[x] = c * (wind(t) - dot(x));
///     }
/// }
/// let wind = Curve::cubic(&[0.0, 1.0, 2.0, 3.0, 4.0], &[1.0, 4.0, 2.5, -3.0, 0.5], Beyond::Held)?;
/// let drifter = Drifter::new(2.0, 0.7, wind);
/// let start = State::new(0.0, [0.0], [0.0]);
/// let end = integrate(&drifter, Dop853, PiController::tolerance(1e-10), start).until(60.0).final_state()?;
/// assert!((end.qd[0] - 0.5).abs() < 1e-8, "the wind of the last measurement carries it along");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "CurveData", try_from = "CurveData"))]
pub struct Curve(Arc<Interpolated<CurveData>>);

/// The points of a curve, and the rules by which it joins them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct CurveData {
    rule: Rule,
    beyond: Beyond,
    x: Vec<f64>,
    y: Vec<f64>,
}

/// A function of two arguments through values on a grid, such as a motor's torque by speed and voltage: an
/// [`ExternFunction`]. Each argument is treated as that of a [`Curve`].
///
/// ```
/// use lagrange_runtime::prelude::*;
/// let values = [0.0, 2.0, 1.0, 4.0, 5.0, 9.0]; // at (0, 0), (0, 10), (1, 0), …
/// let torque = Surface::linear(&[0.0, 1.0, 2.0], &[0.0, 10.0], &values, Beyond::Refused)?;
/// assert_eq!(torque.at(0.5, 5.0), 1.75);
/// assert!(f64::is_nan(torque.at(0.5, 11.0)));
/// # Ok::<(), lagrange_runtime::traits::InvalidTable>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "SurfaceData", try_from = "SurfaceData"))]
pub struct Surface(Arc<Interpolated<SurfaceData, { 4 * 4 }>>);

/// The values of a surface, by rows of equal x, and the rules by which it joins them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct SurfaceData {
    rule: Rule,
    beyond: Beyond,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

/// Data, and the coefficients of the polynomials that follow from them.
#[derive(Debug)]
struct Interpolated<D, const K: usize = 4> {
    data: D,
    pieces: Vec<[f64; K]>,
}

/// The pieces follow from the data.
impl<D: PartialEq, const K: usize> PartialEq for Interpolated<D, K> {
    fn eq(&self, o: &Self) -> bool {
        self.data == o.data
    }
}

impl Curve {
    /// Chords between the points `(x[i], y[i])`.
    ///
    /// # Errors
    /// Data that are no table: fewer than two points, knots that do not increase, other lengths, numbers that are not
    /// finite, knots so close or far apart that powers of their distance underflow or overflow.
    pub fn linear(x: &[f64], y: &[f64], beyond: Beyond) -> Result<Curve, InvalidTable> {
        Curve::of(Rule::Linear, beyond, x, y)
    }

    /// Cubics that have no extremum but at a knot (Fritsch and Carlson, *SIAM J. Numer. Anal.* 17 (1980) 238; the
    /// slopes at knots by Fritsch and Butland's weighted harmonic mean, *SIAM J. Sci. Stat. Comput.* 5 (1984) 300).
    ///
    /// # Errors
    /// As [`linear`](Self::linear).
    pub fn monotone(x: &[f64], y: &[f64], beyond: Beyond) -> Result<Curve, InvalidTable> {
        Curve::of(Rule::Monotone, beyond, x, y)
    }

    /// The cubic spline. Its third derivative is continuous at the second and the last knot but one ("not a knot":
    /// de Boor, *A Practical Guide to Splines*, 1978, ch. IV), so that cubics are met exactly.
    ///
    /// # Errors
    /// As [`linear`](Self::linear).
    pub fn cubic(x: &[f64], y: &[f64], beyond: Beyond) -> Result<Curve, InvalidTable> {
        Curve::of(Rule::Cubic, beyond, x, y)
    }

    fn of(rule: Rule, beyond: Beyond, x: &[f64], y: &[f64]) -> Result<Curve, InvalidTable> {
        Curve::try_from(CurveData { rule, beyond, x: x.to_vec(), y: y.to_vec() })
    }

    /// The value at x, in the unit of the ordinates.
    #[inline]
    pub fn at<S: Scalar>(&self, x: S) -> S {
        self.value([x])
    }

    /// The first and the last knot, in the unit of x.
    pub fn range(&self) -> [f64; 2] {
        let x = &self.0.data.x;
        [x[0], x[x.len() - 1]]
    }

    /// The first knot of the piece at x, and the coefficients of its powers of the distance from there.
    #[inline]
    fn piece(&self, x: f64) -> [f64; 5] {
        let (knots, piece) = (&self.0.data.x, interval(&self.0.data.x, x));
        let [a, b, c, d] = self.0.pieces[piece];
        [knots[piece.saturating_sub(1)], a, b, c, d]
    }
}

impl TryFrom<CurveData> for Curve {
    type Error = InvalidTable;

    fn try_from(data: CurveData) -> Result<Curve, InvalidTable> {
        check_knots(&data.x)?;
        check_values(&data.y, data.x.len())?;
        let pieces = pieces(data.rule, data.beyond, &data.x, &data.y)
            .map_err(|index| InvalidTable::Units { index })?;
        Ok(Curve(Arc::new(Interpolated { data, pieces })))
    }
}

impl From<Curve> for CurveData {
    fn from(curve: Curve) -> CurveData {
        curve.0.data.clone()
    }
}

impl ExternFunction<1> for Curve {
    #[inline]
    fn value<S: Scalar>(&self, [x]: [S; 1]) -> S {
        let [knot, piece @ ..] = S::lookup([x], |_, [x]| self.piece(x));
        polynomial(piece, x - knot)
    }

    fn has_kinks(&self) -> bool {
        let (pieces, x) = (&self.0.pieces, &self.0.data.x);
        // The slopes of the pieces before and after a knot. (Those of a refused piece are NaN.)
        let slopes = |i: usize| {
            let [_, b, c, d] = pieces[i];
            let h = if i == 0 { 0.0 } else { x[i] - x[i - 1] };
            [b + h * (2.0 * c + 3.0 * h * d), pieces[i + 1][1]]
        };
        let largest = pieces.iter().fold(0.0, |largest: f64, piece| largest.max(piece[1].abs()));
        (0..x.len()).map(slopes).any(|[before, after]| (after - before).abs() > SAME_SLOPE * largest)
    }

    #[inline]
    fn side_by_side<'a, S: Scalar>(_: usize, of_lane: impl Fn(usize) -> &'a Self, [x]: [S; 1]) -> S {
        let [knot, piece @ ..] = S::lookup([x], |lane, [x]| of_lane(lane).piece(x));
        polynomial(piece, x - knot)
    }
}

/// a + b u + c u² + d u³
#[inline]
fn polynomial<S: Scalar>([a, b, c, d]: [S; 4], u: S) -> S {
    d.mul_add(u, c).mul_add(u, b).mul_add(u, a)
}

impl Surface {
    /// Bilinear between the values `z[i * y.len() + j]` at `(x[i], y[j])`.
    ///
    /// # Errors
    /// Data that are no table: fewer than two knots of an axis, knots that do not increase, other lengths, numbers that
    /// are not finite, knots so close or far apart that powers of their distance underflow or overflow.
    pub fn linear(x: &[f64], y: &[f64], z: &[f64], beyond: Beyond) -> Result<Surface, InvalidTable> {
        Surface::of(Rule::Linear, beyond, x, y, z)
    }

    /// The tensor product of cubic splines, as [`Curve::cubic`] along each axis.
    ///
    /// # Errors
    /// As [`linear`](Self::linear).
    pub fn cubic(x: &[f64], y: &[f64], z: &[f64], beyond: Beyond) -> Result<Surface, InvalidTable> {
        Surface::of(Rule::Cubic, beyond, x, y, z)
    }

    /// The value at (x, y), in the unit of the values of the table.
    #[inline]
    pub fn at<S: Scalar>(&self, x: S, y: S) -> S {
        self.value([x, y])
    }

    fn of(rule: Rule, beyond: Beyond, x: &[f64], y: &[f64], z: &[f64]) -> Result<Surface, InvalidTable> {
        Surface::try_from(SurfaceData { rule, beyond, x: x.to_vec(), y: y.to_vec(), z: z.to_vec() })
    }

    /// The corner of the cell at (x, y), and the coefficients of powers of the distances from there.
    #[inline]
    fn cell(&self, [x, y]: [f64; 2]) -> [f64; 18] {
        let SurfaceData { x: rows, y: columns, .. } = &self.0.data;
        let (i, j) = (interval(rows, x), interval(columns, y));
        let mut cell = [0.0; 18];
        cell[..2].copy_from_slice(&[rows[i.saturating_sub(1)], columns[j.saturating_sub(1)]]);
        cell[2..].copy_from_slice(&self.0.pieces[i * (columns.len() + 1) + j]);
        cell
    }
}

impl TryFrom<SurfaceData> for Surface {
    type Error = InvalidTable;

    fn try_from(data: SurfaceData) -> Result<Surface, InvalidTable> {
        let SurfaceData { rule, beyond, x, y, z } = &data;
        check_knots(x)?;
        check_knots(y)?;
        check_values(z, x.len() * y.len())?;
        // Splines along y through each row, whose coefficients are values of splines along x.
        let pieces = |x: &[f64], of: &[f64]| {
            pieces(*rule, *beyond, x, of).map_err(|index| InvalidTable::Units { index })
        };
        let rows: Vec<Vec<Piece>> = z.chunks(y.len()).map(|row| pieces(y, row)).collect::<Result<_, _>>()?;
        let columns = y.len() + 1;
        let mut cells = vec![[0.0; 16]; (x.len() + 1) * columns];
        for j in 0..columns {
            for power in 0..4 {
                let along: Vec<f64> = rows.iter().map(|row| row[j][power]).collect();
                for (i, piece) in pieces(x, &along)?.iter().enumerate() {
                    for (of_x, coefficient) in piece.iter().enumerate() {
                        cells[i * columns + j][4 * of_x + power] = *coefficient;
                    }
                }
            }
        }
        Ok(Surface(Arc::new(Interpolated { data, pieces: cells })))
    }
}

impl From<Surface> for SurfaceData {
    fn from(surface: Surface) -> SurfaceData {
        surface.0.data.clone()
    }
}

/// The value of a cell.
#[inline]
fn bicubic<S: Scalar>(cell: [S; 18], [x, y]: [S; 2]) -> S {
    let [u, v] = [x - cell[0], y - cell[1]];
    let row = |i: usize| polynomial([cell[2 + i], cell[3 + i], cell[4 + i], cell[5 + i]], v);
    polynomial([row(0), row(4), row(8), row(12)], u)
}

impl ExternFunction<2> for Surface {
    #[inline]
    fn value<S: Scalar>(&self, x: [S; 2]) -> S {
        bicubic(S::lookup(x, |_, x| self.cell(x)), x)
    }

    fn has_kinks(&self) -> bool {
        let SurfaceData { rule, beyond, x, y, .. } = &self.0.data;
        *beyond == Beyond::Held || *rule == Rule::Linear && (x.len() > 2 || y.len() > 2)
    }

    #[inline]
    fn side_by_side<'a, S: Scalar>(_: usize, of_lane: impl Fn(usize) -> &'a Self, x: [S; 2]) -> S {
        bicubic(S::lookup(x, |lane, x| of_lane(lane).cell(x)), x)
    }
}

#[cfg(test)]
mod tests;
