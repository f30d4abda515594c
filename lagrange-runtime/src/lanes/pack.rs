//! Arrays of numbers as vector registers hold them, and the elementary functions of all of them.

use super::policy::Policy;
use super::trigonometric;

/// `L` numbers, aligned as the longest vector registers are. Loops over them, in functions that are inlined, become
/// vector instructions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct Pack<const L: usize>(pub [f64; L]);

impl<const L: usize> Pack<L> {
    /// Returns whether all lie within ±`limit`; a NaN does not.
    #[inline(always)]
    fn within(self, limit: f64) -> bool {
        let mut within = true;
        for i in 0..L {
            within &= self.0[i].abs() <= limit;
        }
        within
    }

    /// Sines and cosines.
    #[inline(always)]
    pub fn sin_cos<P: Policy>(self) -> (Self, Self) {
        let (mut sin, mut cos) = (Pack([0.0; L]), Pack([0.0; L]));
        for i in 0..L {
            (sin.0[i], cos.0[i]) = trigonometric::sin_cos_of_lane::<P>(self.0[i]);
        }
        if !self.within(trigonometric::limit::<P>()) {
            let (s, c) = Pack::<L>(core::array::from_fn(|i| self.0[i])).large_sin_cos::<P>();
            // One by one and from a copy: nothing but what is called only here has to be in memory.
            for i in 0..L {
                (sin.0[i], cos.0[i]) = (s.0[i], c.0[i]);
            }
        }
        (sin, cos)
    }

    /// Replaces results beyond the limit by those of the `libm` crate, which has the same bits on all processors.
    #[cold]
    #[inline(never)]
    pub fn large_sin_cos<P: Policy>(self) -> (Self, Self) {
        let (mut sin, mut cos) = (Pack([0.0; L]), Pack([0.0; L]));
        for i in 0..L {
            let within = self.0[i].abs() <= trigonometric::limit::<P>();
            let x = self.0[i];
            (sin.0[i], cos.0[i]) =
                if within { trigonometric::sin_cos_of_lane::<P>(x) } else { libm::sincos(x) };
        }
        (sin, cos)
    }
}
