//! Maps without iterators: the order of a hash table cannot leak into what is emitted.

use super::Id;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash, Hasher};

/// A map that can be asked, but not walked.
pub struct StableMap<K, V>(HashMap<K, V, BuildHasherDefault<Fx>>);

impl<K, V> Default for StableMap<K, V> {
    fn default() -> Self {
        StableMap(HashMap::default())
    }
}

impl<K: Hash + Eq, V> StableMap<K, V> {
    pub fn get<Q: ?Sized + Hash + Eq>(&self, key: &Q) -> Option<&V>
    where
        K: std::borrow::Borrow<Q>,
    {
        self.0.get(key)
    }

    pub fn insert(&mut self, key: K, value: V) {
        self.0.insert(key, value);
    }
}

/// The same for nodes, as a table by their numbers: in an unoptimised macro a look at a hash table costs ten times as much.
pub struct IdMap<V> {
    /// Where the value of a node is, counted from 1.
    places: Vec<u32>,
    values: Vec<V>,
}

impl<V> Default for IdMap<V> {
    fn default() -> Self {
        IdMap { places: Vec::new(), values: Vec::new() }
    }
}

impl<V> IdMap<V> {
    pub fn get(&self, key: &Id) -> Option<&V> {
        match self.places.get(key.index()) {
            Some(&place) if place > 0 => self.values.get(place as usize - 1),
            _ => None,
        }
    }

    pub fn insert(&mut self, key: Id, value: V) {
        let at = key.index();
        if at >= self.places.len() {
            // Zeros come from the allocator; pushed one by one they would not.
            let mut places = vec![0; (at + 1).next_power_of_two()];
            places[..self.places.len()].copy_from_slice(&self.places);
            self.places = places;
        }
        match self.places[at] {
            0 => {
                self.values.push(value);
                self.places[at] = self.values.len() as u32;
            }
            place => self.values[place as usize - 1] = value,
        }
    }
}

/// The multiply-and-rotate hash of rustc: an unoptimised macro cannot afford SipHash.
#[derive(Default)]
pub struct Fx(u64);

impl Fx {
    fn mix(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95);
    }
}

impl Hasher for Fx {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.mix(u64::from_le_bytes(word));
        }
    }

    fn write_u8(&mut self, x: u8) {
        self.mix(x.into());
    }

    fn write_u16(&mut self, x: u16) {
        self.mix(x.into());
    }

    fn write_u32(&mut self, x: u32) {
        self.mix(x.into());
    }

    fn write_u64(&mut self, x: u64) {
        self.mix(x);
    }

    fn write_i64(&mut self, x: i64) {
        self.mix(x as u64);
    }

    fn write_usize(&mut self, x: usize) {
        self.mix(x as u64);
    }

    fn write_isize(&mut self, x: isize) {
        self.mix(x as u64);
    }
}
