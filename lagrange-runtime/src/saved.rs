//! States, controllers, systems and steppers as data of serde (feature `serde`): saved and restored, a motion continues
//! bit for bit.
//!
//! [`State`](crate::State), [`Statistics`](crate::Statistics), controllers, methods, steppers without controllers of
//! inputs, and the systems of `lagrangian!` are saved and restored; [`Failure`](crate::Failure) and
//! [`Facts`](crate::Facts) are saved alone, since they refer to names in the program. A system and a stepper know
//! which one they are: data of another system, or of another method, is an error that says so. JSON needs numbers
//! that come back as they were (`float_roundtrip` of `serde_json`); what is infinite or no number is a string there,
//! `"inf"`.
//!
//! ```
//! use lagrange_runtime::prelude::*;
//! use lagrange_runtime::Stepper;
//! lagrangian! {
//!     pub system Pendulum {
//!         param l, g = 9.81;
//!         coord theta: angle;
//!         T = 0.5 * (l * dot(theta)).powi(2);
//!         V = -g * l * cos(theta);
//!     }
//! }
//! type Motion = Stepper<Pendulum, Dop853, PiController, 1>;
//! let mut motion: Motion = Stepper::new(Pendulum::new(0.5), Dop853, PiController::tolerance(1e-9), State::new(0.0, [1.0], [0.0]));
//! motion.advance_to(1.0)?;
//! let saved = serde_json::to_string(&motion)?;
//! let mut restored: Motion = serde_json::from_str(&saved)?;
//! motion.advance_to(5.0)?;
//! restored.advance_to(5.0)?;
//! assert_eq!(motion.state(), restored.state());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::scalar::Scalar;
use core::fmt;
use core::marker::PhantomData;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, SerializeStruct, SerializeTuple};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A scalar, of which an `f64` may be infinite or none. Formats for people have no such numbers, and get their names.
pub(crate) mod number {
    use super::*;
    use core::any::{Any, TypeId};

    pub fn serialize<T: Serialize + 'static, S: Serializer>(x: &T, to: S) -> Result<S::Ok, S::Error> {
        match (x as &dyn Any).downcast_ref::<f64>() {
            Some(x) if !x.is_finite() && to.is_human_readable() => to.serialize_str(if x.is_nan() {
                "nan"
            } else if *x > 0.0 {
                "inf"
            } else {
                "-inf"
            }),
            _ => x.serialize(to),
        }
    }

    pub fn deserialize<'de, T: Copy + Deserialize<'de> + 'static, D: Deserializer<'de>>(
        from: D,
    ) -> Result<T, D::Error> {
        if !from.is_human_readable() || TypeId::of::<T>() != TypeId::of::<f64>() {
            return T::deserialize(from);
        }
        let x: f64 = from.deserialize_any(Number)?;
        (&x as &dyn Any).downcast_ref().copied().ok_or_else(|| D::Error::custom("not a number"))
    }

    struct Number;

    impl Visitor<'_> for Number {
        type Value = f64;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number, `inf`, `-inf` or `nan`")
        }

        fn visit_f64<E: Error>(self, x: f64) -> Result<f64, E> {
            Ok(x)
        }

        fn visit_u64<E: Error>(self, x: u64) -> Result<f64, E> {
            Ok(x as f64)
        }

        fn visit_i64<E: Error>(self, x: i64) -> Result<f64, E> {
            Ok(x as f64)
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<f64, E> {
            match name {
                "nan" => Ok(f64::NAN),
                "inf" => Ok(f64::INFINITY),
                "-inf" => Ok(f64::NEG_INFINITY),
                _ => Err(E::invalid_value(serde::de::Unexpected::Str(name), &self)),
            }
        }
    }
}

/// An element of what is saved as [`number`]s.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(bound(serialize = "T: Serialize + 'static", deserialize = "T: Copy + Deserialize<'de> + 'static"))]
struct Entry<T>(#[serde(with = "number")] T);

/// Vectors of [`number`]s.
pub(crate) mod vector {
    use super::*;
    use nalgebra::SVector;

    pub fn serialize<T: Copy + Serialize + 'static, S: Serializer, const N: usize>(
        all: &SVector<T, N>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        array::serialize(&core::array::from_fn::<_, N, _>(|i| Entry(all[i])), to)
    }

    pub fn deserialize<'de, T: Scalar + Deserialize<'de>, D: Deserializer<'de>, const N: usize>(
        from: D,
    ) -> Result<SVector<T, N>, D::Error> {
        Ok(SVector::from(array::deserialize::<Entry<T>, D, N>(from)?.map(|entry| entry.0)))
    }
}

/// Arrays whose length is a generic argument.
pub(crate) mod array {
    use super::*;

    pub fn serialize<T: Serialize, S: Serializer, const K: usize>(
        all: &[T; K],
        to: S,
    ) -> Result<S::Ok, S::Error> {
        let mut tuple = to.serialize_tuple(K)?;
        for element in all {
            tuple.serialize_element(element)?;
        }
        tuple.end()
    }

    pub fn deserialize<'de, T: Copy + Deserialize<'de>, D: Deserializer<'de>, const K: usize>(
        from: D,
    ) -> Result<[T; K], D::Error> {
        from.deserialize_tuple(K, Elements(PhantomData))
    }

    struct Elements<T, const K: usize>(PhantomData<T>);

    impl<'de, T: Copy + Deserialize<'de>, const K: usize> Visitor<'de> for Elements<T, K> {
        type Value = [T; K];

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "an array of {K}")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<[T; K], A::Error> {
            let mut next = |i: usize| from.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self));
            let mut all = [next(0)?; K];
            for (i, element) in all.iter_mut().enumerate().skip(1) {
                *element = next(i)?;
            }
            Ok(all)
        }
    }
}

/// Coefficients of series, by orders.
pub(crate) mod series {
    use super::*;

    #[derive(Clone, Copy, Serialize, Deserialize)]
    #[serde(bound(serialize = "S: Serialize", deserialize = "S: Copy + Deserialize<'de>"))]
    struct Order<S, const N: usize>(#[serde(with = "array")] [S; N]);

    pub fn serialize<T: Copy + Serialize, S: Serializer, const N: usize, const K: usize>(
        all: &[[T; N]; K],
        to: S,
    ) -> Result<S::Ok, S::Error> {
        array::serialize(&all.map(Order), to)
    }

    pub fn deserialize<
        'de,
        T: Copy + Deserialize<'de>,
        D: Deserializer<'de>,
        const N: usize,
        const K: usize,
    >(
        from: D,
    ) -> Result<[[T; N]; K], D::Error> {
        Ok(array::deserialize::<Order<T, N>, D, K>(from)?.map(|order| order.0))
    }
}

/// A system of `lagrangian!` by its name, the names of its numbers, and the data of its functions.
#[doc(hidden)]
pub trait Saved: Sized {
    type Number: Scalar;
    /// [`Kept`].
    type Data;
    const SYSTEM: &'static str;
    const LABELS: &'static [&'static str];
    const HAS_DATA: bool;

    fn numbers(&self, each: impl FnMut(Self::Number));

    fn data(&self) -> Self::Data;

    /// `None` where there is no data, which it needs.
    fn of(next: impl FnMut() -> Self::Number, data: Option<Self::Data>) -> Option<Self>;
}

/// Data of a system over S. A type without serde's traits can be data: its system has none then.
#[doc(hidden)]
pub struct Kept<S, D>(pub D, pub PhantomData<S>);

impl<N, D: Serialize> Serialize for Kept<N, D> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(to)
    }
}

impl<'de, N, T: Deserialize<'de>> Deserialize<'de> for Kept<N, T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        T::deserialize(from).map(|data| Kept(data, PhantomData))
    }
}

#[doc(hidden)]
pub fn save<Sys: Saved, S: Serializer>(system: &Sys, to: S) -> Result<S::Ok, S::Error>
where
    Sys::Number: Serialize,
    Sys::Data: Serialize,
{
    let mut numbers = Vec::with_capacity(Sys::LABELS.len());
    system.numbers(|x| numbers.push(x));
    let mut all = to.serialize_struct("System", if Sys::HAS_DATA { 3 } else { 2 })?;
    all.serialize_field("system", Sys::SYSTEM)?;
    all.serialize_field("numbers", &Numbers::<Sys>(numbers))?;
    if Sys::HAS_DATA {
        all.serialize_field("data", &system.data())?;
    }
    all.end()
}

/// The numbers of a system, with their names.
struct Numbers<Sys: Saved>(Vec<Sys::Number>);

impl<Sys: Saved> Serialize for Numbers<Sys>
where
    Sys::Number: Serialize,
{
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(Sys::LABELS.len()))?;
        for (label, x) in Sys::LABELS.iter().zip(&self.0) {
            map.serialize_entry(label, &Entry(*x))?;
        }
        map.end()
    }
}

impl<'de, Sys: Saved> Deserialize<'de> for Numbers<Sys>
where
    Sys::Number: Deserialize<'de>,
{
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Labelled(PhantomData))
    }
}

struct Labelled<Sys>(PhantomData<Sys>);

impl<'de, Sys: Saved> Visitor<'de> for Labelled<Sys>
where
    Sys::Number: Deserialize<'de>,
{
    type Value = Numbers<Sys>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the numbers of the system `{}`", Sys::SYSTEM)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut from: A) -> Result<Self::Value, A::Error> {
        let mut all: Vec<Option<Sys::Number>> = vec![None; Sys::LABELS.len()];
        while let Some(label) = from.next_key::<String>()? {
            match Sys::LABELS.iter().position(|known| *known == label) {
                Some(i) if all[i].is_some() => return Err(A::Error::duplicate_field(Sys::LABELS[i])),
                Some(i) => all[i] = Some(from.next_value::<Entry<_>>()?.0),
                None => return Err(A::Error::unknown_field(&label, Sys::LABELS)),
            }
        }
        if let Some(missing) = all.iter().position(Option::is_none) {
            return Err(A::Error::missing_field(Sys::LABELS[missing]));
        }
        Ok(Numbers(all.into_iter().flatten().collect()))
    }
}

#[doc(hidden)]
pub fn restore<'de, Sys: Saved, D: Deserializer<'de>>(from: D) -> Result<Sys, D::Error>
where
    Sys::Number: Deserialize<'de>,
    Sys::Data: Deserialize<'de>,
{
    let (numbers, data) = if Sys::HAS_DATA {
        let WithData { numbers, data, .. } = WithData::<Sys>::deserialize(from)?;
        (numbers, Some(data))
    } else {
        (Whole::<Sys>::deserialize(from)?.numbers, None)
    };
    let mut numbers = numbers.0.into_iter();
    Sys::of(|| numbers.next().unwrap_or(Sys::Number::zero()), data)
        .ok_or_else(|| D::Error::missing_field("data"))
}

#[derive(Deserialize)]
#[serde(rename = "System", bound(deserialize = "Sys: Saved, Sys::Number: Deserialize<'de>"))]
struct Whole<Sys: Saved> {
    #[serde(rename = "system")]
    _system: Is<Sys>,
    numbers: Numbers<Sys>,
}

#[derive(Deserialize)]
#[serde(
    rename = "System",
    bound(deserialize = "Sys: Saved, Sys::Number: Deserialize<'de>, Sys::Data: Deserialize<'de>")
)]
struct WithData<Sys: Saved> {
    #[serde(rename = "system")]
    _system: Is<Sys>,
    numbers: Numbers<Sys>,
    data: Sys::Data,
}

/// The name of a system.
struct Is<Sys>(PhantomData<Sys>);

impl<'de, Sys: Saved> Deserialize<'de> for Is<Sys> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        expect(from, "system", Sys::SYSTEM).map(|()| Is(PhantomData))
    }
}

/// Fails unless this name is read.
fn expect<'de, D: Deserializer<'de>>(from: D, what: &str, expected: &str) -> Result<(), D::Error> {
    let found = String::deserialize(from)?;
    if found == expected {
        return Ok(());
    }
    Err(D::Error::custom(format!("expected the {what} `{expected}`, found the {what} `{found}`")))
}

/// The name of a method, by its type.
pub(crate) struct Named<M>(PhantomData<M>);

impl<M> Named<M> {
    pub const NEW: Named<M> = Named(PhantomData);

    /// The name of the type without paths.
    fn name() -> String {
        let mut name = String::new();
        for part in core::any::type_name::<M>().split_inclusive(['<', '>', ',', ' ']) {
            name.push_str(part.rsplit("::").next().unwrap_or_default());
        }
        name
    }
}

impl<M> Serialize for Named<M> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&Self::name())
    }
}

impl<'de, M> Deserialize<'de> for Named<M> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        expect(from, "method", &Self::name()).map(|()| Self::NEW)
    }
}
