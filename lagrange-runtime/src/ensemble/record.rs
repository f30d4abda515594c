//! Values as bytes, bit for bit: what checkpoints are made of.

use crate::state::State;
use nalgebra::SVector;

/// A value that is written to a checkpoint and read back with the same bits, NaNs included.
///
/// Numbers are little-endian; lists begin with their length. There are no names or types in the bytes: a checkpoint
/// says beside them of which study it is, and has a checksum.
///
/// ```
/// use lagrange_runtime::ensemble::Record;
/// let mut bytes = vec![];
/// (7u64, [0.5, -0.0]).write(&mut bytes);
/// assert_eq!(<(u64, [f64; 2])>::read(&mut bytes.as_slice()), Some((7, [0.5, -0.0])));
/// assert_eq!(<(u64, [f64; 3])>::read(&mut bytes.as_slice()), None);
/// ```
pub trait Record: Sized {
    /// Appends the value.
    fn write(&self, bytes: &mut Vec<u8>);

    /// Takes the value from the front of `bytes`; `None` if they are not one.
    fn read(bytes: &mut &[u8]) -> Option<Self>;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Record for $number {
            fn write(&self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }

            fn read(bytes: &mut &[u8]) -> Option<Self> {
                let (number, rest) = bytes.split_first_chunk()?;
                *bytes = rest;
                Some(Self::from_le_bytes(*number))
            }
        }
    )*};
}

numbers!(u8, i32, u32, i64, u64, f32, f64);

impl Record for bool {
    fn write(&self, bytes: &mut Vec<u8>) {
        u8::from(*self).write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        match u8::read(bytes)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl<T: Record> Record for Option<T> {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.is_some().write(bytes);
        if let Some(value) = self {
            value.write(bytes);
        }
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        if bool::read(bytes)? { T::read(bytes).map(Some) } else { Some(None) }
    }
}

impl<T: Record> Record for Vec<T> {
    fn write(&self, bytes: &mut Vec<u8>) {
        (self.len() as u64).write(bytes);
        for value in self {
            value.write(bytes);
        }
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        // Not reserved beforehand: the length may be anything in bytes that are no record.
        let len = u64::read(bytes)?;
        (0..len).map(|_| T::read(bytes)).collect()
    }
}

impl<T: Record, const K: usize> Record for [T; K] {
    fn write(&self, bytes: &mut Vec<u8>) {
        for value in self {
            value.write(bytes);
        }
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let values: Option<Vec<T>> = (0..K).map(|_| T::read(bytes)).collect();
        values?.try_into().ok()
    }
}

impl Record for String {
    fn write(&self, bytes: &mut Vec<u8>) {
        (self.len() as u64).write(bytes);
        bytes.extend_from_slice(self.as_bytes());
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        String::from_utf8(Vec::read(bytes)?).ok()
    }
}

impl<S: Record + crate::Scalar, const N: usize> Record for SVector<S, N> {
    fn write(&self, bytes: &mut Vec<u8>) {
        for value in self.iter() {
            value.write(bytes);
        }
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        <[S; N]>::read(bytes).map(SVector::from)
    }
}

impl<S: Record + crate::Scalar, const N: usize> Record for State<S, N> {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.t.write(bytes);
        self.q.write(bytes);
        self.qd.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(State { t: S::read(bytes)?, q: SVector::read(bytes)?, qd: SVector::read(bytes)? })
    }
}

macro_rules! tuples {
    ($(($($name:ident $place:tt),*))*) => {$(
        impl<$($name: Record),*> Record for ($($name,)*) {
            fn write(&self, bytes: &mut Vec<u8>) {
                $(self.$place.write(bytes);)*
            }

            fn read(bytes: &mut &[u8]) -> Option<Self> {
                Some(($($name::read(bytes)?,)*))
            }
        }
    )*};
}

tuples! {
    (A 0, B 1)
    (A 0, B 1, C 2)
    (A 0, B 1, C 2, D 3)
    (A 0, B 1, C 2, D 3, E 4)
    (A 0, B 1, C 2, D 3, E 4, F 5)
}

/// Writes a struct of records as the sequence of its fields.
macro_rules! record_fields {
    ($type:ident $(<$($name:ident),*; $size:ident>)? { $($field:ident),* }) => {
        impl $(<$($name,)* const $size: usize>)? $crate::ensemble::Record for $type $(<$($name,)* $size>)? {
            fn write(&self, bytes: &mut Vec<u8>) {
                $($crate::ensemble::Record::write(&self.$field, bytes);)*
            }

            fn read(bytes: &mut &[u8]) -> Option<Self> {
                Some($type { $($field: $crate::ensemble::Record::read(bytes)?),* })
            }
        }
    };
}
pub(crate) use record_fields;

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip<T: Record>(value: &T) -> T {
        let mut bytes = vec![];
        value.write(&mut bytes);
        let mut rest = bytes.as_slice();
        let back = T::read(&mut rest);
        assert!(rest.is_empty());
        // Every record that is cut short is refused.
        for len in 0..bytes.len() {
            assert!(T::read(&mut &bytes[..len]).is_none());
        }
        back.expect("what was written can be read")
    }

    #[test]
    fn values_come_back_with_their_bits() {
        let odd = f64::from_bits(0x7ff8_0000_dead_beef);
        assert_eq!(round_trip(&odd).to_bits(), odd.to_bits());
        assert_eq!(round_trip(&vec![Some(-0.0), None]), [Some(-0.0), None]);
        assert_eq!(round_trip(&("θ".to_string(), [1u64, 2], true)), ("θ".to_string(), [1, 2], true));
        let state = State::new(0.5, [1.0, 2.0], [3.0, 4.0]);
        assert_eq!(round_trip(&state), state);
    }

    #[test]
    fn bytes_of_something_else_are_refused() {
        assert_eq!(bool::read(&mut [2u8].as_slice()), None);
        assert_eq!(Vec::<u64>::read(&mut [255u8; 8].as_slice()), None);
        assert_eq!(String::read(&mut [1u8, 0, 0, 0, 0, 0, 0, 0, 0xff].as_slice()), None);
    }
}
