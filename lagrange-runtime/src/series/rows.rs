//! Rows that are written one after the other, and read up to there. They need no zeros before, which in lanes are 20
//! kB a step.

#![allow(unsafe_code)]

use core::mem::MaybeUninit;

/// Room for K rows.
pub struct Rows<T, const K: usize> {
    rows: [MaybeUninit<T>; K],
    /// Number of rows that have been written.
    count: usize,
}

impl<T: Copy, const K: usize> Rows<T, K> {
    /// None so far.
    #[inline(always)]
    pub const fn new() -> Self {
        Rows { rows: [const { MaybeUninit::uninit() }; K], count: 0 }
    }

    /// Adds one, if there is room.
    #[inline(always)]
    pub fn push(&mut self, row: T) {
        if self.count < K {
            self.rows[self.count] = MaybeUninit::new(row);
            self.count += 1;
        }
    }

    /// The rows that have been written.
    #[inline(always)]
    pub fn written(&self) -> &[T] {
        // SAFETY: `count` is at most K, and each of the first `count` rows has been written by `push`, the only one
        // to change it; a `MaybeUninit<T>` is laid out as a `T`.
        unsafe { core::slice::from_raw_parts(self.rows.as_ptr().cast::<T>(), self.count) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_that_were_written() {
        let mut rows = Rows::<[f64; 2], 3>::new();
        assert!(rows.written().is_empty());
        for k in 0..5 {
            rows.push([f64::from(k), 0.5]);
            assert_eq!(rows.written().len(), (k as usize + 1).min(3));
        }
        assert_eq!(rows.written(), [[0.0, 0.5], [1.0, 0.5], [2.0, 0.5]]);
    }
}
