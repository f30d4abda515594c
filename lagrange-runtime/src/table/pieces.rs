//! Polynomials between knots, and beyond them.

/// The value of a table beyond its first and last knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Beyond {
    /// The value at the end. The slope jumps there, unless it is 0.
    Held,
    /// The straight line with the slope at the end.
    Line,
    /// None: the value is not a number. A run that comes there ends in
    /// [`StepSizeUnderflow`](crate::Failure::StepSizeUnderflow) before the end of the table, in
    /// [`NonFinite`](crate::Failure::NonFinite) if its steps are equal, and a start there is
    /// [`StateNotFinite`](crate::Failure::StateNotFinite).
    Refused,
}

/// The pieces between knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Rule {
    Linear,
    Monotone,
    Cubic,
}

/// The part of the largest value by which a piece misses the next knot at most.
const MISSED: f64 = 1e-9;

/// Coefficients of the powers of the distance from the first knot of a piece.
pub type Piece = [f64; 4];

/// The piece that holds at x: 0 before the first knot, i between the knots i − 1 and i, n beyond the last one.
#[inline]
pub fn interval(knots: &[f64], x: f64) -> usize {
    let i = knots.partition_point(|knot| *knot <= x);
    // (The last knot belongs to the last piece between knots.)
    if i == knots.len() && x == knots[i - 1] { i - 1 } else { i }
}

/// The pieces between n knots, with those before and beyond. Values that are NaN have such pieces. Fails with the first
/// piece of which powers of the width underflow or overflow, so that it does not lead to the next value.
pub fn pieces(rule: Rule, beyond: Beyond, x: &[f64], y: &[f64]) -> Result<Vec<Piece>, usize> {
    let widths: Vec<f64> = x.windows(2).map(|x| x[1] - x[0]).collect();
    let chords: Vec<f64> = y.windows(2).zip(&widths).map(|(y, h)| (y[1] - y[0]) / h).collect();
    let last = x.len() - 1;
    let slopes = match rule {
        Rule::Linear => Vec::new(),
        Rule::Monotone => monotone_slopes(&widths, &chords),
        Rule::Cubic => spline_slopes(&widths, &chords),
    };
    let piece = |i: usize| match rule {
        Rule::Linear => [y[i], chords[i], 0.0, 0.0],
        _ => {
            let (h, chord, [from, to]) = (widths[i], chords[i], [slopes[i], slopes[i + 1]]);
            [y[i], from, (3.0 * chord - 2.0 * from - to) / h, (from + to - 2.0 * chord) / h / h]
        }
    };
    let slope = |i: usize| slopes.get(i).copied().unwrap_or_else(|| chords[i.min(last - 1)]);
    let outside = |i: usize| match beyond {
        Beyond::Held => [y[i], 0.0, 0.0, 0.0],
        Beyond::Line => [y[i], slope(i), 0.0, 0.0],
        Beyond::Refused => [f64::NAN; 4],
    };
    let largest = y.iter().fold(0.0, |largest: f64, y| largest.max(y.abs()));
    let leads_on = |i: usize, [a, b, c, d]: Piece| {
        let reached = a + widths[i] * (b + widths[i] * (c + widths[i] * d));
        (reached - y[i + 1]).abs() <= MISSED * largest || y[i].is_nan() || y[i + 1].is_nan()
    };
    let between: Vec<Piece> = (0..last).map(piece).collect();
    match (0..last).find(|i| !leads_on(*i, between[*i])) {
        Some(i) => Err(i),
        None => Ok(core::iter::once(outside(0)).chain(between).chain([outside(last)]).collect()),
    }
}

/// Slopes at the knots of a cubic spline with continuous curvature:
///
/// `hᵢ sᵢ₋₁ + 2 (hᵢ₋₁ + hᵢ) sᵢ + hᵢ₋₁ sᵢ₊₁ = 3 (hᵢ dᵢ₋₁ + hᵢ₋₁ dᵢ)`
///
/// with the widths h and the slopes d of chords, and at the ends a third derivative that is continuous at the next
/// knot. Three points have a parabola, two a line.
fn spline_slopes(h: &[f64], d: &[f64]) -> Vec<f64> {
    let last = h.len();
    if last == 1 {
        return vec![d[0]; 2];
    }
    // Rows of the system: what multiplies the slopes at the knot before, at this one, at the next, and the right side.
    let interior =
        |i: usize| [h[i], 2.0 * (h[i - 1] + h[i]), h[i - 1], 3.0 * (h[i] * d[i - 1] + h[i - 1] * d[i])];
    let end = |[h0, h1]: [f64; 2], [d0, d1]: [f64; 2]| {
        let both = h0 + h1;
        [h1, both, (h0 + 2.0 * both) * (h1 / both) * d0 + h0 * (h0 / both) * d1]
    };
    let [first, final_row] = if last == 2 {
        [[1.0, 1.0, 2.0 * d[0]], [1.0, 1.0, 2.0 * d[1]]]
    } else {
        [end([h[0], h[1]], [d[0], d[1]]), end([h[last - 1], h[last - 2]], [d[last - 1], d[last - 2]])]
    };
    let row = |i: usize| match i {
        0 => [0.0, first[0], first[1], first[2]],
        i if i == last => [final_row[1], final_row[0], 0.0, final_row[2]],
        i => interior(i),
    };
    // Elimination without pivots: what is left on the diagonal is positive, at the end too.
    let mut eliminated: Vec<[f64; 2]> = Vec::with_capacity(last + 1);
    for i in 0..=last {
        let [before, here, next, right] = row(i);
        let [above, known] = eliminated.last().copied().unwrap_or([0.0; 2]);
        let pivot = here - before * above;
        eliminated.push([next / pivot, (right - before * known) / pivot]);
    }
    let mut slopes = vec![0.0; last + 1];
    let mut after = 0.0;
    for (slope, [above, known]) in slopes.iter_mut().zip(&eliminated).rev() {
        after = known - above * after;
        *slope = after;
    }
    slopes
}

/// Slopes at the knots of cubics that are monotone where the data are.
fn monotone_slopes(h: &[f64], d: &[f64]) -> Vec<f64> {
    let last = h.len();
    if last == 1 {
        return vec![d[0]; 2];
    }
    let opposed = |a: f64, b: f64| a * b <= 0.0;
    let interior = |i: usize| {
        let ([h0, h1], [d0, d1]) = ([h[i - 1], h[i]], [d[i - 1], d[i]]);
        let [w0, w1] = [2.0 * h1 + h0, h1 + 2.0 * h0];
        if opposed(d0.signum(), d1.signum()) || d0 == 0.0 || d1 == 0.0 {
            0.0
        } else {
            (w0 + w1) / (w0 / d0 + w1 / d1)
        }
    };
    // The slope of the parabola through three points, if it is that of monotone data.
    let end = |[h0, h1]: [f64; 2], [d0, d1]: [f64; 2]| {
        let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
        if opposed(slope.signum(), d0.signum()) || d0 == 0.0 {
            0.0
        } else if opposed(d0.signum(), d1.signum()) && slope.abs() > 3.0 * d0.abs() {
            3.0 * d0
        } else {
            slope
        }
    };
    let first = end([h[0], h[1]], [d[0], d[1]]);
    let final_slope = end([h[last - 1], h[last - 2]], [d[last - 1], d[last - 2]]);
    core::iter::once(first).chain((1..last).map(interior)).chain([final_slope]).collect()
}
