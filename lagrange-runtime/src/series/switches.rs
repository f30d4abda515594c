//! Systems with choices (`if`, `abs`, `signum`, `min`, `max`): on which sides of their switches a series is, and
//! where it leaves them.
//!
//! A switching function g(q, q̇, t) has a series of its own, which says where it first vanishes, with nothing
//! overlooked: a polynomial is divided until each part has no root by the sum of its negative coefficients, or falls
//! from one end to the other. That holds as far as the terms left out are small: accelerations need not say so, since
//! they may be constant on either side.

use crate::event::root::{first_zero, sign};
use crate::scalar::{Real, Scalar, SimdScalar};
use core::fmt::Debug;

/// Signs of the switching functions of a system, or their values or coefficients, over the scalar `S`.
pub trait Switches<S: Scalar>: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Number of switching functions, at most 64.
    const COUNT: usize;

    /// All 0.
    fn zero() -> Self;

    /// 1, 0 or −1 for each of the numbers. It stays 0 where a switching function vanishes for as long as the series
    /// holds, as |x| − x does for x > 0.
    fn signs(self) -> Self;

    /// The element of one switch.
    fn of(&self, switch: usize) -> S;

    /// With the other sign for one switch.
    fn crossed(self, switch: usize) -> Self;

    /// Marks those that are 0: a series that starts there begins at them.
    fn vanishing(&self) -> Self;

    /// Marks one more.
    fn marked(self, switch: usize) -> Self;

    /// Are `others` those of another side of any switch but those marked in `begins`?
    fn left_for(&self, begins: &Self, others: &Self) -> bool;

    /// Has the number at a place another side of any switch, by the switching functions' values after the time h, by
    /// more than their rounding?
    fn are_left<const K: usize>(&self, switching: &[Self; K], values: &Self, h: S, place: usize) -> bool;

    /// Does the series of the number at a place, which begins at a switch, lead to the side of it that is said in the
    /// time h?
    fn go_on<const K: usize>(&self, switching: &[Self; K], switch: usize, h: S, place: usize) -> bool;

    /// First switch that the number at a place meets in the time h, by the series of the switching functions, whose
    /// coefficients are known up to the order before `order`. They begin at the switches marked in `begins`.
    fn met<const K: usize>(
        &self,
        switching: &[Self; K],
        begins: &Self,
        h: S,
        order: usize,
        place: usize,
    ) -> Option<Met<Self>>;
}

/// Switch that a series meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Met<W> {
    /// A switch that it begins at, which it leaves to another side than was said.
    Left {
        /// Its index.
        switch: usize,
        /// Sides after it.
        sides: W,
    },
    /// The first switch that it crosses.
    Crossed {
        /// Its index.
        switch: usize,
        /// The share of the time at which it is crossed.
        share: f64,
    },
    /// None up to this share of the time; beyond it the series of a switching function is too short to say.
    Unknown {
        /// The share of the time.
        share: f64,
    },
}

/// Sides of a system without choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Smooth;

impl<S: Scalar> Switches<S> for Smooth {
    const COUNT: usize = 0;

    #[inline(always)]
    fn zero() -> Self {
        Smooth
    }

    #[inline(always)]
    fn signs(self) -> Self {
        Smooth
    }

    fn of(&self, _: usize) -> S {
        S::zero()
    }

    fn crossed(self, _: usize) -> Self {
        Smooth
    }

    fn vanishing(&self) -> Self {
        Smooth
    }

    fn marked(self, _: usize) -> Self {
        Smooth
    }

    fn left_for(&self, _: &Self, _: &Self) -> bool {
        false
    }

    fn are_left<const K: usize>(&self, _: &[Self; K], _: &Self, _: S, _: usize) -> bool {
        false
    }

    fn go_on<const K: usize>(&self, _: &[Self; K], _: usize, _: S, _: usize) -> bool {
        true
    }

    fn met<const K: usize>(&self, _: &[Self; K], _: &Self, _: S, _: usize, _: usize) -> Option<Met<Self>> {
        None
    }
}

/// Sides of a system with C switches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: crate::Scalar + serde::Serialize",
        deserialize = "S: crate::Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Sides<S, const C: usize>(
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::array"))] pub [S; C],
);

impl<S: SimdScalar, const C: usize> Switches<S> for Sides<S, C> {
    const COUNT: usize = C;

    fn zero() -> Self {
        Sides([S::zero(); C])
    }

    fn signs(self) -> Self {
        Sides(self.0.map(|g| S::of(|i| S::Element::from_f64(sign(g.number(i).to_f64())))))
    }

    fn of(&self, switch: usize) -> S {
        self.0[switch]
    }

    fn crossed(mut self, switch: usize) -> Self {
        self.0[switch] = -self.0[switch];
        self
    }

    fn vanishing(&self) -> Self {
        let mark = |g: S::Element| S::Element::from_f64(if g.to_f64() == 0.0 { 1.0 } else { 0.0 });
        Sides(self.0.map(|g| S::of(|i| mark(g.number(i)))))
    }

    fn marked(mut self, switch: usize) -> Self {
        self.0[switch] = S::one();
        self
    }

    fn left_for(&self, begins: &Self, others: &Self) -> bool {
        (0..C).any(|c| begins.0[c] == S::zero() && self.0[c] != others.0[c])
    }

    fn are_left<const K: usize>(&self, switching: &[Self; K], values: &Self, h: S, place: usize) -> bool {
        let number = |of: S| of.number(place).to_f64();
        (0..C).any(|c| {
            let value = number(values.0[c]);
            value * number(self.0[c]) < 0.0 && {
                let terms =
                    switching.iter().rev().fold(0.0, |sum, k| sum * number(h).abs() + number(k.0[c]).abs());
                value.abs() > ROUNDINGS * f64::EPSILON * terms
            }
        })
    }

    fn go_on<const K: usize>(&self, switching: &[Self; K], switch: usize, h: S, place: usize) -> bool {
        let number = |of: S| of.number(place).to_f64();
        let change = (1..K).rev().fold(0.0, |sum, k| (sum + number(switching[k].0[switch])) * number(h));
        change * number(self.0[switch]) > 0.0
    }

    fn met<const K: usize>(
        &self,
        switching: &[Self; K],
        begins: &Self,
        h: S,
        order: usize,
        place: usize,
    ) -> Option<Met<Self>> {
        if let Some((switch, sides)) = self.contradicted(switching, begins, h, place) {
            return Some(Met::Left { switch, sides });
        }
        let h = h.number(place).to_f64();
        let known = (0..C)
            .map(|c| known(switching.map(|of| of.0[c].number(place).to_f64()), h, order))
            .fold(1.0, f64::min);
        if let Some((share, switch)) = self.first(switching, begins, known * h, place) {
            return Some(Met::Crossed { switch, share: known * share });
        }
        (known < 1.0).then_some(Met::Unknown { share: known })
    }
}

impl<S: SimdScalar, const C: usize> Sides<S, C> {
    /// The switch that the series begins at and leaves to another side than `self` says, for times of the sign of h,
    /// and the sides after it.
    fn contradicted<const K: usize>(
        &self,
        switching: &[Self; K],
        begins: &Self,
        h: S,
        place: usize,
    ) -> Option<(usize, Self)> {
        (0..C).find_map(|c| {
            let [side, begins] = [self, begins].map(|of| of.0[c].number(place).to_f64());
            let coefficient = |k: usize| switching[k].0[c].number(place).to_f64();
            let from = |k: usize| (k..K).find(|k| coefficient(*k) != 0.0);
            let left = match from(0) {
                None => 0.0,
                Some(_) if begins == 0.0 && side != 0.0 => return None,
                // The first coefficient that does not vanish says where it goes.
                Some(_) => match from(1) {
                    None => return None,
                    Some(k) => {
                        let back = h.number(place).to_f64() < 0.0 && k % 2 == 1;
                        if (coefficient(k) < 0.0) == back { 1.0 } else { -1.0 }
                    }
                },
            };
            let mut sides = *self;
            sides.0[c] = S::from_f64(left);
            (left != side).then_some((c, sides))
        })
    }

    /// The share of the time h at which the first switch is crossed, and the index of that switch.
    fn first<const K: usize>(
        &self,
        switching: &[Self; K],
        begins: &Self,
        h: f64,
        place: usize,
    ) -> Option<(f64, usize)> {
        let number = |of: &Self, c: usize| of.0[c].number(place).to_f64();
        let mut found: Option<(f64, usize)> = None;
        for c in (0..C).filter(|c| number(self, *c) != 0.0) {
            // The polynomial in the share of h that has passed, positive on the side of the series. Of a switch at
            // which the series begins the root there is taken out.
            let from = if number(begins, c) == 0.0 {
                0
            } else {
                (1..K).find(|k| number(&switching[*k], c) != 0.0).unwrap_or(K)
            };
            let mut polynomial = [0.0; K];
            let mut power = number(self, c);
            for k in 0..K {
                let coefficient = number(&switching[k], c);
                // (The power may overflow.)
                if k >= from && coefficient != 0.0 {
                    polynomial[k - from] = power * coefficient;
                }
                power *= h;
            }
            if let Some(x) = first_root(&polynomial, found.map_or(1.0, |(x, _)| x)) {
                found = Some((x, c));
            }
        }
        found
    }
}

/// Coefficients that are asked how long the next step may be.
pub(crate) const WINDOW: usize = 4;

/// Roundings of its largest terms that a switching function is apart from 0 where its sign counts.
const ROUNDINGS: f64 = 64.0;

/// The distance from 0 of a switching function, over the last of its terms, at which that sign is certain: 2¹⁰.
const FAR: f64 = 1024.0;

/// The share of the time h in which the terms that are left out of a switching function, from the given order on, are
/// small: below 2^(−3 (p − 7)) of the largest one of those of order p and lower, but for the constant one, about the
/// tolerance that an order is chosen for ([`Taylor`](const@crate::Taylor)). Let its terms
/// decay from that of order j like (h/ρ)ᵏ; each of the last [`WINDOW`] known ones gives a ρ.
fn known<const K: usize>(coefficients: [f64; K], h: f64, order: usize) -> f64 {
    let end = order.min(K);
    let (mut power, mut rest, mut late) = (h, 0.0, 0.0f64);
    for (k, a) in coefficients[..end].iter().enumerate().skip(1) {
        let term = (a * power).abs();
        rest += term;
        if k + WINDOW >= end {
            late = late.max(term);
        }
        power *= h;
    }
    if late == 0.0 || rest + FAR * late <= coefficients[0].abs() {
        return 1.0;
    }
    let size = coefficients.map(|a| libm::log2(a.abs()));
    let least = -3.0 * order.saturating_sub(7) as f64;
    let longest = |k: usize| {
        let by = |j: usize| (size[j] - size[k]) / (k - j) as f64 + least.min(-10.0) / (order - j) as f64;
        (1..end - WINDOW).map(by).fold(f64::NEG_INFINITY, f64::max)
    };
    let longest = (end - WINDOW..end).map(longest).fold(f64::INFINITY, f64::min);
    libm::exp2(longest - libm::log2(h.abs())).min(1.0)
}

/// Largest number of halvings of an interval.
const HALVINGS: u32 = 52;

/// First root of a polynomial with a positive constant, up to `end` ≤ 1; 0 where the constant is not positive. NaN if
/// terms overflow: the step is too long, and has no end.
fn first_root<const K: usize>(polynomial: &[f64; K], end: f64) -> Option<f64> {
    let mut scaled = *polynomial;
    let mut power = 1.0;
    for k in 0..K {
        scaled[k] *= power;
        power *= end;
    }
    if scaled[0] > 0.0 {
        within(&scaled, HALVINGS).map(|x| x * end)
    } else {
        scaled.iter().any(|a| *a != 0.0).then_some(0.0)
    }
}

/// Between 0 and 1, of a polynomial that is positive at 0.
fn within<const K: usize>(a: &[f64; K], halvings: u32) -> Option<f64> {
    let lowest = a[0] + a[1..].iter().map(|x| x.min(0.0)).sum::<f64>();
    if lowest > 0.0 {
        return None;
    }
    let mut value = |x: f64| a.iter().rev().fold(0.0, |sum, a| sum * x + a);
    let end = value(1.0);
    if !(lowest + end).is_finite() {
        return Some(f64::NAN);
    }
    let steepest = (1..K).map(|k| k as f64 * if k == 1 { a[1] } else { a[k].max(0.0) }).sum::<f64>();
    if end < 0.0 && steepest < 0.0 {
        return Some(first_zero(&mut value, (0.0, a[0]), (1.0, end), f64::EPSILON));
    }
    if halvings == 0 {
        // A touch, as far as can be seen.
        return (end < 0.0).then_some(0.5);
    }
    let mut left = *a;
    let mut power = 1.0;
    for k in 0..K {
        left[k] *= power;
        power *= 0.5;
    }
    if let Some(x) = within(&left, halvings - 1) {
        return Some(0.5 * x);
    }
    // About the middle (Horner's scheme, Knuth 4.6.4).
    let mut right = left;
    for i in 0..K {
        for k in (i..K - 1).rev() {
            right[k] += right[k + 1];
        }
    }
    if right[0] <= 0.0 { Some(0.5) } else { within(&right, halvings - 1).map(|x| 0.5 + 0.5 * x) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of x − r for all r.
    fn with_roots(roots: &[f64]) -> [f64; 12] {
        let mut a = [0.0; 12];
        a[0] = 1.0;
        for (n, r) in roots.iter().enumerate() {
            for k in (0..=n + 1).rev() {
                a[k] = if k > 0 { a[k - 1] } else { 0.0 } - r * a[k];
            }
        }
        a
    }

    #[test]
    fn the_first_root_is_found_however_near_the_next_one_is() {
        for (roots, first) in [
            (vec![0.5, 0.7], Some(0.5)),
            (vec![0.5, 0.500001], Some(0.5)),
            (vec![0.3, 0.3000001, 0.6, 0.9], Some(0.3)),
            (vec![-0.2, -0.4], None),
            (vec![1.2, 1.4], None),
            (vec![0.999, 3.0], Some(0.999)),
            (vec![1e-9, 0.5], Some(1e-9)),
        ] {
            let a = with_roots(&roots);
            let sign = if a[0] < 0.0 { -1.0 } else { 1.0 };
            let found = first_root(&a.map(|x| sign * x), 1.0);
            match (found, first) {
                (Some(x), Some(first)) => {
                    // Rounding of the coefficients moves a root by as much over the slope there.
                    let slope: f64 =
                        roots.iter().filter(|r| **r != first).map(|r| (first - r).abs()).product();
                    assert!((x - first).abs() < 1e-9 + 4.0 * f64::EPSILON / slope, "{x} {roots:?}");
                }
                other => assert_eq!(other.0, other.1, "{roots:?}"),
            }
        }
        assert!(first_root(&[1.0, f64::NEG_INFINITY, 0.0], 1.0).unwrap().is_nan());
        assert!(first_root(&[1.0, -2.0, f64::NAN], 1.0).unwrap().is_nan());
        // A minimum above 0, and a touch.
        let mut a = with_roots(&[0.4, 0.4]);
        assert_eq!(first_root(&a, 1.0), None);
        a[0] += 1e-9;
        assert_eq!(first_root(&a, 1.0), None);
        a[0] -= 2e-9;
        assert!((first_root(&a, 1.0).unwrap() - (0.4 - 1e-9f64.sqrt())).abs() < 1e-9);
    }

    #[test]
    fn sides_follow_from_the_first_coefficient_that_does_not_vanish() {
        let (sides, both, none) = (Sides([1.0, -1.0]), Sides([1.0; 2]), Sides([0.0; 2]));
        let switching = [Sides([0.0, 0.0]), Sides([0.0, 2.0]), Sides([3.0, 0.0])];
        assert_eq!(sides.contradicted(&switching, &both, 1.0, 0), Some((1, Sides([1.0, 1.0]))));
        assert_eq!(Sides([0.0, 1.0]).contradicted(&switching, &none, 1.0, 0), Some((0, Sides([1.0, 1.0]))));
        let border = [Sides([0.0, 0.5]), Sides([0.0, 0.0])];
        assert_eq!(Sides([0.0, 1.0]).contradicted(&border, &both, 1.0, 0), None);
        assert_eq!(Sides([1.0, 1.0]).contradicted(&border, &none, 1.0, 0), Some((0, Sides([0.0, 1.0]))));
        assert_eq!(sides.contradicted(&switching, &both, -1.0, 0), None);
        assert_eq!(sides.contradicted(&switching, &Sides([1.0, 0.0]), 1.0, 0), None);
        assert_eq!(sides.crossed(0), Sides([-1.0, -1.0]));
        assert_eq!(switching[1].vanishing(), Sides([1.0, 0.0]));
    }
}
