//! Errors of kernels in units of the last place, against arithmetic of 160 bits (`astro-float-num`, tested by its authors
//! against MPFR).

use super::pack::Pack;
use super::policy::{Fused, Plain, Policy};
use super::trigonometric;
use astro_float_num::{BigFloat, Consts, RoundingMode};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const BITS: usize = 160;
const ROUNDING: RoundingMode = RoundingMode::ToEven;

/// Exact values, and the numbers at which they are asked for.
struct Exact {
    constants: Consts,
    random: ChaCha8Rng,
}

impl Exact {
    fn new() -> Self {
        Exact { constants: Consts::new().expect("constants"), random: ChaCha8Rng::seed_from_u64(1) }
    }

    /// Uniform in [0, 1).
    fn uniform(&mut self) -> f64 {
        (self.random.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Of either sign, with any power of 2 between 2^low and 2^high.
    fn spread(&mut self, low: f64, high: f64) -> f64 {
        let magnitude = (low + (high - low) * self.uniform()).exp2();
        if self.random.next_u64() & 1 == 0 { magnitude } else { -magnitude }
    }
}

/// A number of many digits.
fn big(x: f64) -> BigFloat {
    BigFloat::from_f64(x, BITS)
}

/// The nearest double but for an error of 2⁻⁶³, for differences.
fn small(x: &BigFloat) -> f64 {
    let Some((words, _, sign, exponent, _)) = x.as_raw_parts() else { return f64::NAN };
    if x.is_zero() {
        return 0.0;
    }
    let top = *words.last().expect("a number has words") as f64 * 2f64.powi(-64);
    let magnitude = top * 2f64.powi(exponent);
    if sign == astro_float_num::Sign::Neg { -magnitude } else { magnitude }
}

/// The distance from |x| to the next larger double.
fn last_place(x: f64) -> f64 {
    f64::from_bits(x.abs().to_bits() + 1) - x.abs()
}

/// How far `found` is from `exact`, in units of the last place of `found`.
fn error(found: f64, exact: &BigFloat) -> f64 {
    let difference = big(found).sub(exact, BITS, ROUNDING);
    (small(&difference) / last_place(found)).abs()
}

/// The largest errors of sine and cosine at `x`.
fn worst<P: Policy>(exact: &mut Exact, x: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut worst = [0f64; 2];
    for x in x {
        let (sin, cos) = trigonometric::sin_cos::<P>(x);
        let argument = big(x);
        // Near a zero many leading bits cancel.
        let sine = argument.sin(2 * BITS, ROUNDING, &mut exact.constants);
        let cosine = argument.cos(2 * BITS, ROUNDING, &mut exact.constants);
        worst = [worst[0].max(error(sin, &sine)), worst[1].max(error(cos, &cosine))];
    }
    worst
}

/// Numbers of every size up to `limit`, and those next to multiples of π/2.
fn angles(exact: &mut Exact, limit: f64, count: usize) -> Vec<f64> {
    let mut angles = vec![0.0, limit, -limit, 1e-300];
    for _ in 0..count {
        angles.push(exact.spread(-30.0, limit.log2()));
        angles.push(limit * (2.0 * exact.uniform() - 1.0));
        angles.push(8.0 * (exact.uniform() - 0.5));
        let quarters = (exact.uniform() * limit * core::f64::consts::FRAC_2_PI).floor();
        let zero = quarters * core::f64::consts::FRAC_PI_2;
        angles.extend([zero.next_down(), zero, zero.next_up()].map(|x| x.clamp(-limit, limit)));
    }
    angles
}

fn sines_are_within<P: Policy>(limit: f64, bound: f64) {
    let exact = &mut Exact::new();
    let angles = angles(exact, limit, 4000);
    let worst = worst::<P>(exact, angles.into_iter());
    println!(
        "{} to {limit:e}: sin {:.3} ULP, cos {:.3} ULP",
        core::any::type_name::<P>(),
        worst[0],
        worst[1]
    );
    assert!(worst[0] < bound && worst[1] < bound, "{worst:?}");
}

#[test]
fn sines_and_cosines_have_all_their_digits() {
    sines_are_within::<Fused>(1e6, 1.6);
    sines_are_within::<Fused>(trigonometric::limit::<Fused>(), 1.6);
    sines_are_within::<Plain>(trigonometric::limit::<Plain>(), 1.6);
}

/// The doubles nearest to a multiple of π/2 that there are below the limits, by their continued fractions: what remains of
/// these after reduction is smallest.
#[test]
fn sines_next_to_their_zeros() {
    let exact = &mut Exact::new();
    let mut nearest: Vec<(f64, f64)> = vec![];
    for quarters in 1..600_000u32 {
        let x = f64::from(quarters) * core::f64::consts::FRAC_PI_2;
        let (r, _) = trigonometric::reduced::<Fused>(x);
        nearest.push((r.abs() / x, x));
    }
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let hardest: Vec<f64> = nearest[..2000].iter().map(|&(_, x)| x).collect();
    assert!(nearest[0].0 * nearest[0].1 < 1e-15);
    for worst in
        [worst::<Fused>(exact, hardest.iter().copied()), worst::<Plain>(exact, hardest.iter().copied())]
    {
        assert!(worst[0] < 1.6 && worst[1] < 1.6, "{worst:?}");
    }
}

#[test]
fn packs_fall_back_beyond_the_limit() {
    let exact = &mut Exact::new();
    for x in [1e6, 1.1e6, 1e9, 1.1e9, 1e15, 1e22, 1e300, f64::MAX] {
        let (sin, cos) = Pack([x, -x, 1.0, 2.0]).sin_cos::<Plain>();
        let precision = BITS + 1100;
        let argument = BigFloat::from_f64(x, precision);
        let sine = argument.sin(precision, ROUNDING, &mut exact.constants);
        let cosine = argument.cos(precision, ROUNDING, &mut exact.constants);
        assert!(error(sin.0[0], &sine) < 1.0 && error(cos.0[0], &cosine) < 1.0, "{x}");
        assert_eq!((sin.0[1], cos.0[1]), (-sin.0[0], cos.0[0]));
        assert_eq!(sin.0[2], trigonometric::sin_cos::<Plain>(1.0).0);
    }
}
