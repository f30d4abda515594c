//! Fourier coefficients of expressions that are polynomials in the sine and cosine of an angle.

use super::{Function, Graph, Number, Symbol, Value};

/// Coefficients of cos kα and sin kα, by k.
pub type Harmonics<T> = Vec<[T; 2]>;

impl Graph {
    /// The coefficients of an expression, free of the angle; none where it is not written as such a polynomial, or is
    /// too long.
    pub fn fourier(&mut self, v: Value, angle: Symbol) -> Option<Harmonics<Value>> {
        let alpha = self.symbol(angle);
        let (sine, cosine) = (self.call(Function::sin, alpha).node?, self.call(Function::cos, alpha).node?);
        let mut total = vec![[Value::ZERO; 2]];
        for (factors, k) in self.monomials(v)? {
            let power = |base| factors.iter().find(|f| f.0 == base).map_or(0, |f| f.1);
            let (m, n) = (power(sine), power(cosine));
            let rest: Vec<_> = factors.iter().filter(|f| f.0 != sine && f.0 != cosine).copied().collect();
            let factor = if rest.is_empty() { Value::ONE } else { self.assemble(&rest) };
            if m < 0 || n < 0 || self.depends(&[factor], |s| s == angle) {
                return None;
            }
            let harmonics = powers(m, n);
            total.resize(total.len().max(harmonics.len()), [Value::ZERO; 2]);
            for (sum, parts) in total.iter_mut().zip(harmonics) {
                for (sum, part) in sum.iter_mut().zip(parts) {
                    *sum = self.add(*sum, factor.scaled(k.mul(part)));
                }
            }
        }
        Some(total)
    }
}

/// The coefficients of sinᵐα cosⁿα, by the products of sines and cosines with sin α and cos α.
fn powers(m: i32, n: i32) -> Harmonics<Number> {
    let mut series = vec![[Number::ONE, Number::ZERO]];
    for factor in (0..m + n).map(|i| i < m) {
        let mut product = vec![[Number::ZERO; 2]; series.len() + 1];
        for (k, [c, s]) in series.into_iter().enumerate() {
            let [c, s] = [c, s].map(|x| x.mul(Number::Ratio(1, 2)));
            let mut add = |harmonic: usize, of: usize, x: Number| {
                let sum = &mut product[harmonic][of];
                *sum = sum.add(x);
            };
            let below = k.abs_diff(1);
            if factor {
                // cos kα sin α = ½ (sin (k+1)α − sin (k−1)α), sin kα sin α = ½ (cos (k−1)α − cos (k+1)α)
                add(k + 1, 1, c);
                add(below, 1, if k == 0 { c } else { c.neg() });
                add(below, 0, if k == 0 { Number::ZERO } else { s });
                add(k + 1, 0, s.neg());
            } else {
                // cos kα cos α = ½ (cos (k+1)α + cos (k−1)α), sin kα cos α = ½ (sin (k+1)α + sin (k−1)α)
                add(k + 1, 0, c);
                add(below, 0, c);
                add(k + 1, 1, s);
                add(below, 1, if k == 0 { s.neg() } else { s });
            }
        }
        // sin 0 = 0
        product[0][1] = Number::ZERO;
        series = product;
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_have_the_values_of_what_they_are_of() {
        let g = &mut Graph::default();
        let (alpha, x) = (g.symbol(Symbol::Time), g.symbol(Symbol::Coordinate(0)));
        let twice = g.add(alpha.scaled(2.into()), x);
        let [s, c, d] =
            [g.call(Function::sin, alpha), g.call(Function::cos, alpha), g.call(Function::cos, twice)];
        let (cube, square) = (g.powi(s, 3), g.powi(c, 2));
        let product = g.mul(cube, square);
        let other = g.mul(d, c);
        let sum = g.add(product, other);
        let series = g.fourier(sum, Symbol::Time).expect("a polynomial");
        for t in [0.3, 1.7, -2.2] {
            let at = |s: Symbol| if s == Symbol::Time { t } else { 0.7 };
            let terms = series.iter().enumerate().map(|(k, pair)| {
                let [c, s] = [0, 1].map(|i| g.evaluate(&[pair[i]], at)[0]);
                c * (k as f64 * t).cos() + s * (k as f64 * t).sin()
            });
            let value = g.evaluate(&[sum], at)[0];
            assert!((terms.sum::<f64>() - value).abs() < 1e-14, "{value}");
        }
        let quotient = g.recip(c);
        let product = g.mul(alpha, s);
        assert!(g.fourier(quotient, Symbol::Time).is_none() && g.fourier(product, Symbol::Time).is_none());
    }
}
