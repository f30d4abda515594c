//! Rows of numbers, of which sums of products of series are formed.

use core::fmt::Debug;

/// Numbers side by side, as sums of products of series are formed of them.
pub trait SimdRow: Copy + Debug {
    /// The numbers as they are handed over: `[S; C]`.
    type Elements: Copy + Debug;

    /// Are so many of them kept in memory, and sums formed there? The optimiser makes vectors of them then, where it
    /// would otherwise make a variable of each number. From four numbers on that pays, and from more where a product
    /// and a sum are one operation.
    fn together(rows: usize) -> bool;

    /// A row of these elements.
    fn of(numbers: Self::Elements) -> Self;
    /// The numbers.
    fn numbers(self) -> Self::Elements;
    /// Nothing but zeros.
    fn zero() -> Self;
    /// The sum of each two.
    fn plus(self, other: Self) -> Self;
    /// `self + a b` of each three.
    fn plus_product(self, a: Self, b: Self) -> Self;
}
