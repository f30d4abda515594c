//! Taylor series of a motion: what the compiler emits for them, and the arithmetic of truncated series that it uses.
//!
//! Coefficients are found order by order. Those of order k of a product are `Σ_{j=0}^{k} a_j b_{k−j}`, of which all
//! terms but the first two and the last two have been known for a while when the order begins. The inner sums of all
//! products of a system are formed side by side ([`Products`], [`Squares`]), as wide as the processor's vectors are,
//! while the order before is being finished; the emitted code adds the ends as they become known.

mod motion;
mod rows;
mod switches;

pub use motion::{Over, TaylorSeries, divided};
pub(crate) use switches::WINDOW;
pub use switches::{Met, Sides, Smooth, Switches};

use crate::lanes::Work;
use crate::scalar::{Scalar, SimdRow};
use crate::state::State;
use crate::system::System;
use rows::Rows;

/// A system whose motion has Taylor series, found order by order by recurrences that the compiler emits. Implemented
/// for every `lagrangian!` system without `extern fn`s, powers whose exponents move and constraints that follow from
/// others (whose pivots are numbers, chosen in each state); where there are choices (`if`, `min`, `max`, `abs`,
/// `signum`), on each side of their switches.
#[diagnostic::on_unimplemented(
    message = "no Taylor series are emitted for `{Self}`",
    note = "a system with an `extern fn`, with a power whose exponent moves, or with constraints that follow from others, has none; use `Dop853` or `Verner9`"
)]
pub trait Analytic<const N: usize>: System<N> {
    /// Values or signs of the switching functions, which are a − b of each choice of `a < b` and x of `x.abs()` and
    /// `x.signum()`.
    type Sides: Switches<Self::Scalar>;

    /// True if the equations have roots whose arguments may vanish where the accelerations are finite. There is no
    /// series at such a state, which [`Taylor`](const@crate::Taylor) leaves by collocation.
    const ROOTS: bool = false;

    /// The recurrences are so long that they are compiled once, and only what takes most of their time for better
    /// processors.
    #[doc(hidden)]
    const LONG: bool = false;

    /// Values of the switching functions, each in its own unit; one that names another takes that to be on its side.
    fn switching(&self, at: &State<Self::Scalar, N>, sides: &Self::Sides) -> Self::Sides;

    /// Writes the series of the motion through `at` on these sides of the switches, with `order` coefficients of the
    /// accelerations, at most K − 2; those of higher orders stay as they are. The coefficients of the switching
    /// functions are returned. (A series is longer than a register, and what follows would wait for a copy of it.)
    fn series_within<const K: usize>(
        &self,
        at: &State<Self::Scalar, N>,
        order: usize,
        sides: &Self::Sides,
        motion: &mut TaylorSeries<Self::Scalar, N, K>,
    ) -> [Self::Sides; K];

    /// The sides of the switches on which a state is.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sides(&self, at: &State<Self::Scalar, N>) -> Self::Sides {
        let mut sides = Self::Sides::zero().signs();
        // Each pass is right about one more of those that name others.
        for _ in 0..Self::Sides::COUNT {
            sides = self.switching(at, &sides).signs();
        }
        sides
    }

    /// The series of the motion through `at`, with `order` coefficients of the accelerations, at most K − 2.
    /// Coefficient k of a coordinate is in its unit per s^k.
    fn series<const K: usize>(
        &self,
        at: &State<Self::Scalar, N>,
        order: usize,
    ) -> TaylorSeries<Self::Scalar, N, K> {
        let mut motion = TaylorSeries::zero();
        self.series_within(at, order, &self.sides(at), &mut motion);
        motion
    }
}

impl<S: Scalar, const C: usize> SimdRow for [S; C] {
    type Elements = Self;

    #[inline(always)]
    fn together(rows: usize) -> bool {
        C >= 4 && (rows > 1 || !S::FUSED)
    }

    #[inline(always)]
    fn of(numbers: Self) -> Self {
        numbers
    }

    #[inline(always)]
    fn numbers(self) -> Self {
        self
    }

    #[inline(always)]
    fn zero() -> Self {
        [S::zero(); C]
    }

    #[inline(always)]
    fn plus(mut self, other: Self) -> Self {
        for c in 0..C {
            self[c] += other[c];
        }
        self
    }

    #[inline(always)]
    fn plus_product(mut self, a: Self, b: Self) -> Self {
        add(&mut self, &a, &b);
        self
    }
}

/// Products of series `a b`, in B rows side by side.
pub struct Products<R, const B: usize, const K: usize> {
    left: [[R; K]; B],
    right: [[R; K]; B],
}

impl<R: SimdRow, const B: usize, const K: usize> Products<R, B, K> {
    /// Without any coefficients.
    #[inline(always)]
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Products { left: [[R::zero(); K]; B], right: [[R::zero(); K]; B] }
    }

    /// Keeps rows that are loaded as vectors in memory, where the optimiser would make a variable of each number.
    #[inline(always)]
    pub fn keep(&mut self) {
        if R::together(B) {
            core::hint::black_box(self);
        }
    }

    /// Adds the factors' coefficients of one order.
    #[inline(always)]
    pub fn push(&mut self, k: usize, left: [R::Elements; B], right: [R::Elements; B]) {
        for b in 0..B {
            self.left[b][k] = R::of(left[b]);
            self.right[b][k] = R::of(right[b]);
        }
    }

    /// `Σ_{1<j<k−1} a_j b_{k−j}` of each, and `a_1 b_1` for k = 2.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn middle(&self, k: usize) -> [R::Elements; B] {
        let mut sums = [R::zero().numbers(); B];
        for b in 0..B {
            let sum = middle(&self.left[b], &self.right[b], k).numbers();
            // Numbers that are stored are computed side by side; those that go their own ways from here would not be.
            sums[b] = if R::together(B) { core::hint::black_box(sum) } else { sum };
        }
        sums
    }
}

impl<S: Scalar, const C: usize, const B: usize, const K: usize> Products<[S; C], B, K> {
    /// [`middle`](Self::middle) with the best instructions of the processor, whatever those of its caller are.
    pub fn middle_called(&self, k: usize) -> [[S; C]; B] {
        S::evaluate_long(Middle { of: self, k })
    }
}

/// The inner sums of one order, as [`Work`] that is done in its place.
struct Middle<'a, T> {
    of: &'a T,
    k: usize,
}

impl<S: Scalar, const C: usize, const B: usize, const K: usize> Work for Middle<'_, Products<[S; C], B, K>> {
    type Output = [[S; C]; B];

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.of.middle(self.k)
    }
}

impl<S: Scalar, const C: usize, const B: usize, const K: usize> Work for Middle<'_, Squares<S, C, B, K>> {
    type Output = [[S; C]; B];

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.of.middle(self.k)
    }
}

/// B · C squares of series, in B blocks of C side by side.
pub struct Squares<S, const C: usize, const B: usize, const K: usize> {
    of: [[[S; C]; K]; B],
}

impl<S: Scalar, const C: usize, const B: usize, const K: usize> Squares<S, C, B, K> {
    /// Without any coefficients.
    #[inline(always)]
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Squares { of: [[[S::zero(); C]; K]; B] }
    }

    /// Adds the coefficients of one order.
    #[inline(always)]
    pub fn push(&mut self, k: usize, of: [[S; C]; B]) {
        for b in 0..B {
            self.of[b][k] = of[b];
        }
    }

    /// [`middle`](Self::middle) with the best instructions of the processor, whatever those of its caller are.
    pub fn middle_called(&self, k: usize) -> [[S; C]; B] {
        S::evaluate_long(Middle { of: self, k })
    }

    /// `Σ_{1<j<k−1} a_j a_{k−j}` of each, and `a_1²` for k = 2: twice the sum of its first half, and the middle term
    /// of even k.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn middle(&self, k: usize) -> [[S; C]; B] {
        let mut sums = [[S::zero(); C]; B];
        for b in 0..B {
            let a = &self.of[b];
            let k = k.min(K - 1);
            let mut half = [S::zero(); C];
            // From the middle, whose coefficients have been known longest, to those just computed.
            let mut j = k.div_ceil(2);
            while j > 2 {
                j -= 1;
                add(&mut half, &a[j], &a[k - j]);
            }
            for c in 0..C {
                sums[b][c] = half[c] + half[c];
            }
            if k.is_multiple_of(2) && k > 0 {
                add(&mut sums[b], &a[k / 2], &a[k / 2]);
            }
        }
        sums
    }
}

/// F different factors of products, for scalars that are vectors themselves: each is kept once, and a product is a
/// sum over two columns. (The rows of a double pendulum in eight lanes, factor beside factor, would not fit the first
/// cache.)
pub struct Factors<S, const F: usize, const K: usize> {
    of: Rows<[S; F], K>,
    /// Zeros.
    none: [S; F],
}

impl<S: Scalar, const F: usize, const K: usize> Factors<S, F, K> {
    /// Without any coefficients.
    #[inline(always)]
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Factors { of: Rows::new(), none: [S::zero(); F] }
    }

    /// Adds the coefficients of the next order.
    #[inline(always)]
    pub fn push(&mut self, of: &[S; F]) {
        self.of.push(*of);
    }

    /// Coefficients of order 1, once they are factors of products (from order 3 on), and of the order before k.
    #[inline(always)]
    pub fn ends(&self, k: usize) -> [&[S; F]; 2] {
        let of = self.of.written();
        let first = if k > 2 && of.len() > 1 { &of[1] } else { &self.none };
        let last = if k > 1 && of.len() > 1 { &of[of.len() - 1] } else { &self.none };
        [first, last]
    }

    /// Variant of [`Products::middle`] for these pairs, in blocks. Each order is looked up once for several of them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn products<const P: usize, const C: usize, const B: usize>(
        &self,
        k: usize,
        pairs: &[[usize; 2]; P],
    ) -> [[S; C]; B] {
        let mut sums = [[S::zero(); C]; B];
        let of = self.of.written();
        let k = k.min(of.len());
        let mut p = 0;
        while p < P {
            let mut some = [[0; 2]; SIDE];
            for c in 0..SIDE {
                some[c] = pairs[(p + c).min(P - 1)];
            }
            let mut sum = [S::zero(); SIDE];
            if k == 2 {
                for c in 0..SIDE {
                    sum[c] = of[1][some[c][0]] * of[1][some[c][1]];
                }
            }
            let mut j = 2;
            while j + 1 < k {
                let (left, right) = (&of[j], &of[k - j]);
                for c in 0..SIDE {
                    sum[c] = left[some[c][0]].mul_add(right[some[c][1]], sum[c]);
                }
                j += 1;
            }
            for c in 0..SIDE {
                if p + c < P {
                    sums[(p + c) / C][(p + c) % C] = sum[c];
                }
            }
            p += SIDE;
        }
        sums
    }

    /// Variant of [`Squares::middle`] for these factors, in blocks.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn squares<const P: usize, const C: usize, const B: usize>(
        &self,
        k: usize,
        factors: &[usize; P],
    ) -> [[S; C]; B] {
        let mut sums = [[S::zero(); C]; B];
        let of = self.of.written();
        let k = k.min(of.len());
        for (p, &a) in factors.iter().enumerate() {
            let mut half = S::zero();
            let mut j = k.div_ceil(2);
            while j > 2 {
                j -= 1;
                half = of[j][a].mul_add(of[k - j][a], half);
            }
            let mut sum = half + half;
            if k.is_multiple_of(2) && k > 0 {
                sum = of[k / 2][a].mul_add(of[k / 2][a], sum);
            }
            sums[p / C][p % C] = sum;
        }
        sums
    }
}

/// Products whose sums are formed in one loop: their accumulators stay in registers.
const SIDE: usize = 4;

#[inline(always)]
fn add<S: Scalar, const C: usize>(sum: &mut [S; C], a: &[S; C], b: &[S; C]) {
    for c in 0..C {
        sum[c] = a[c].mul_add(b[c], sum[c]);
    }
}

/// From the middle to the ends, and in two halves, so that additions need not wait.
///
/// Written without iterators: where k is a number, the compiler makes a straight line of it.
#[cfg_attr(not(debug_assertions), inline(always))]
fn middle<R: SimdRow, const K: usize>(a: &[R; K], b: &[R; K], k: usize) -> R {
    // Says that no index is out of bounds.
    let k = k.min(K - 1);
    let (mut low, mut high) = (R::zero(), R::zero());
    if k == 2 {
        low = low.plus_product(a[1], b[1]);
    }
    let start = k.div_ceil(2);
    let (mut i, mut j) = (start, start);
    while j + 1 < k {
        high = high.plus_product(a[j], b[k - j]);
        j += 1;
        if i > 2 {
            i -= 1;
            low = low.plus_product(a[i], b[k - i]);
        }
    }
    low.plus(high)
}

/// Ends a part of a long straight line, by a branch that is never taken, which the optimiser does not know.
#[doc(hidden)]
#[inline(always)]
pub fn cut() {
    if core::hint::black_box(false) {
        core::hint::black_box(());
    }
}

/// Are orders written out one by one? Not in builds for debugging, in which it takes long and gains little.
#[doc(hidden)]
pub const UNROLLED: bool = !cfg!(debug_assertions);

/// Does a step for each of the orders `1..end`, which is a number in each of the steps, so that the loops over orders
/// before it are straight lines in the machine's code.
#[doc(hidden)]
#[macro_export]
macro_rules! __orders {
    (1..$end:expr, $level:ident => $step:expr) => {
        $crate::__orders!(
            [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23] $end, $level => $step
        )
    };
    ([$($order:literal)*] $end:expr, $level:ident => $step:expr) => {{
        let end = $end;
        $(
            if $order < end {
                let $level = $order;
                $step;
            }
        )*
        for $level in 24..end {
            $step;
        }
    }};
}

pub use __orders as orders;

#[cfg(test)]
mod tests {
    use super::motion::RECIPROCALS;
    use super::*;
    use crate::lanes::{Fused, SingleLane};

    #[test]
    fn inner_sums() {
        let a: [f64; 12] = core::array::from_fn(|k| [3.0, -1.0, 2.0, 0.5, 7.0, -2.0, 1.0, 4.0][k % 8]);
        let b: [f64; 12] = core::array::from_fn(|k| [1.0, 0.25, -3.0, 5.0, 2.0][k % 5]);
        let mut products = Products::<[f64; 2], 2, 12>::new();
        let mut in_registers = Products::<<f64 as Scalar>::Pair, 2, 12>::new();
        let mut squares = Squares::<f64, 2, 1, 12>::new();
        let mut factors = Factors::<f64, 3, 12>::new();
        for k in 0..12 {
            // All terms are small multiples of 1/16: nothing is rounded.
            let inner = |j: &usize| k == 2 || (*j > 1 && j + 1 < k);
            let by_hand =
                |x: &[f64; 12], y: &[f64; 12]| (1..k).filter(inner).map(|j| x[j] * y[k - j]).sum::<f64>();
            assert_eq!(products.middle(k), [[by_hand(&a, &b), by_hand(&b, &a)], [by_hand(&a, &a), 0.0]]);
            assert_eq!(squares.middle(k), [[by_hand(&a, &a), by_hand(&b, &b)]]);
            assert_eq!(in_registers.middle(k), products.middle(k));
            assert_eq!(products.middle_called(k), products.middle(k));
            assert_eq!(squares.middle_called(k), squares.middle(k));
            let ends = factors.ends(k);
            let end = |at: usize, known: bool| if known { [a[at], b[at], 0.0] } else { [0.0; 3] };
            assert_eq!(ends.map(|x| *x), [end(1, k > 2), end(k.saturating_sub(1), k > 1)]);
            let pairs = [[0, 1], [1, 0], [0, 0]];
            assert_eq!(factors.products::<3, 2, 2>(k, &pairs), products.middle(k));
            assert_eq!(factors.squares::<2, 2, 1>(k, &[0, 1]), squares.middle(k));
            factors.push(&[a[k], b[k], 0.0]);
            products.push(k, [[a[k], b[k]], [a[k], 0.0]], [[b[k], a[k]], [a[k], 0.0]]);
            in_registers.push(k, [[a[k], b[k]], [a[k], 0.0]], [[b[k], a[k]], [a[k], 0.0]]);
            squares.push(k, [[a[k], b[k]]]);
        }
    }

    #[test]
    fn quotients_have_no_bias() {
        for k in [3, 5, 7, 10, 11, 13, 19, 23, 49, 65] {
            let mut biases = [0.0f64; 4];
            for i in 0..4000 {
                let x = 1.0 + f64::from(i) / 4000.0;
                let quotients = [
                    divided([x], k)[0],
                    Over::new(k).add(x, 0.0),
                    divided([SingleLane::<Fused>::new(x)], k)[0].value(),
                    Over::new(k).add(SingleLane::<Fused>::new(x), SingleLane::new(0.0)).value(),
                ];
                for (bias, quotient) in biases.iter_mut().zip(quotients) {
                    // The remainder of the division, which is exact.
                    *bias += f64::mul_add(-quotient, k as f64, x) / x / 4000.0;
                }
            }
            // That of the rounded reciprocal is as large as 1e-17 to 1e-16 for these k.
            assert!(biases.iter().all(|bias| bias.abs() < 3e-18), "{k}: {biases:?}");
            let [near, rest] = RECIPROCALS[k];
            assert_eq!(f64::mul_add(near, k as f64, -1.0) + rest * k as f64, 0.0, "{k}");
        }
    }
}
