//! Reduction of angles by quarter turns, exact for every number.
//!
//! As Payne and Hanek (*Radian reduction for trigonometric functions*, ACM SIGNUM Newsletter 18, 1983): of the
//! product of a number by 2/π only what is left modulo 4 is needed, and for that only those bits of 2/π whose product
//! with the last bit of the number is less than 4.

use super::{Double, PI};

/// The first bits of 2/π behind the binary point.
#[rustfmt::skip]
const TWO_OVER_PI: [u64; 22] = [
    0xa2f9_836e_4e44_1529, 0xfc27_57d1_f534_ddc0, 0xdb62_9599_3c43_9041, 0xfe51_63ab_debb_c561,
    0xb724_6e3a_424d_d2e0, 0x0649_2eea_09d1_921c, 0xfe1d_eb1c_b129_a73e, 0xe882_35f5_2ebb_4484,
    0xe99c_7026_b45f_7e41, 0x3991_d639_8353_39f4, 0x9c84_5f8b_bdf9_283b, 0x1ff8_97ff_de05_980f,
    0xef2f_118b_5a0a_6d1f, 0x6d36_7ecf_27cb_09b7, 0x4f46_3f66_9e5f_ea2d, 0x7527_bac7_ebe5_f17b,
    0x3d07_39f7_8a52_92ea, 0x6bfb_5fb1_1f8d_5d08, 0x5603_3046_fc7b_6bab, 0xf0cf_bc20_9af4_361d,
    0xa9e3_9161_5ee6_1b08, 0x6599_855f_14a0_6840,
];

/// A fraction of 256 bits, most significant word first: 2 bits before the binary point, 254 behind it. It wraps
/// around at 4.
type Fixed = [u64; 4];

/// Bits of 2/π from the one of weight 2^(1 − skip) on; those before the binary point are 0.
fn window(skip: i32) -> Fixed {
    let bit_word = |start: i32| {
        let (word, shift) = (start.div_euclid(64), start.rem_euclid(64) as u32);
        let at = |i: i32| usize::try_from(i).ok().and_then(|i| TWO_OVER_PI.get(i)).copied().unwrap_or(0);
        if shift == 0 { at(word) } else { at(word) << shift | at(word + 1) >> (64 - shift) }
    };
    [0, 64, 128, 192].map(|offset| bit_word(skip - 2 + offset))
}

/// `x 2/π` modulo 4.
fn quarters_of(x: f64) -> Fixed {
    // |x| = mantissa · 2^exponent
    let exponent = (x.to_bits() >> 52 & 0x7ff) as i32;
    let fraction = x.to_bits() & ((1 << 52) - 1);
    let (mantissa, exponent) =
        if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
    let (mut product, mut carry) = ([0; 4], 0);
    for (digit, word) in product.iter_mut().zip(window(exponent)).rev() {
        let sum = u128::from(word) * u128::from(mantissa) + carry;
        (*digit, carry) = (sum as u64, sum >> 64);
    }
    if x < 0.0 { negative(product) } else { product }
}

fn plus(a: Fixed, b: Fixed) -> Fixed {
    let (mut sum, mut carry) = ([0; 4], 0);
    for ((digit, a), b) in sum.iter_mut().zip(a).zip(b).rev() {
        let whole = u128::from(a) + u128::from(b) + carry;
        (*digit, carry) = (whole as u64, whole >> 64);
    }
    sum
}

fn negative(x: Fixed) -> Fixed {
    plus(x.map(|digit| !digit), [0, 0, 0, 1])
}

/// Its first 128 bits that are not 0, as a number.
fn number(x: Fixed) -> Double {
    let first = x.iter().position(|&digit| digit != 0).unwrap_or(3);
    let digit = |i: usize| u128::from(x.get(first + i).copied().unwrap_or(0));
    let shift = x[first].leading_zeros();
    let [a, b] = [digit(0) << 64 | digit(1), digit(2) << 64];
    let bits = if shift == 0 { a } else { a << shift | b >> (128 - shift) };
    // 64 bits are two numbers, exactly.
    let part = |bits: u128, scale: i32| {
        Double::from((bits >> 32) as f64).scaled(scale + 32)
            + Double::from((bits & 0xffff_ffff) as f64).scaled(scale)
    };
    let scale = -62 - 64 * first as i32 - shift as i32;
    part(bits >> 64, scale) + part(bits & u128::from(u64::MAX), scale - 64)
}

/// The nearest number n of quarter turns, modulo 4, and `x − n π/2`. `x` is finite.
pub(super) fn reduced(x: Double) -> (u64, Double) {
    if x.hi.abs() < core::f64::consts::FRAC_PI_4 {
        return (0, x);
    }
    let all = plus(quarters_of(x.hi), quarters_of(x.lo));
    let nearest = plus(all, [1 << 61, 0, 0, 0])[0] >> 62;
    let rest = plus(all, [(4 - nearest) << 62, 0, 0, 0]);
    let below = rest[0] >> 63 == 1;
    let rest = number(if below { negative(rest) } else { rest }) * PI * 0.5;
    (nearest, if below { -rest } else { rest })
}
