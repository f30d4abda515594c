//! A cost over an error, interpolated logarithm over logarithm.

/// Points (error, cost) from coarse to fine tolerances.
pub struct Curve(Vec<(f64, f64)>);

impl Curve {
    pub fn new(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let good = points.filter(|(error, _)| error.is_finite());
        Curve(good.map(|(error, cost)| (error.ln(), cost.ln())).collect())
    }

    /// The cost at the given error: where the error falls below it for good. (At coarse tolerances errors may be
    /// small by chance.)
    pub fn at(&self, error: f64) -> Option<f64> {
        let error = error.ln();
        let (a, b) =
            self.0.windows(2).rev().map(|w| (w[0], w[1])).find(|(a, b)| a.0 >= error && error > b.0)?;
        let share = (error - a.0) / (b.0 - a.0);
        Some((a.1 + share * (b.1 - a.1)).exp())
    }
}
