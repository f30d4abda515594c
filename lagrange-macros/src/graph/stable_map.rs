//! Maps without iterators: the order of a hash table cannot leak into what is emitted.

use std::borrow::Borrow;
use std::hash::{Hash, Hasher};

/// Index of a node; operands have smaller ids than their users.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, PartialOrd, Ord)]
pub struct Id(pub(super) u32);

/// A map that can be asked, but not walked.
///
/// Without optimisation a look into the standard library's table takes some 700 instructions, for the sake of vector
/// instructions that are function calls there. This one has open addresses, looked at one after the other, and
/// nothing is ever removed.
#[derive(Clone)]
pub struct StableMap<K, V> {
    /// Index of the entry of a hash, counted from 1; a power of two of slots, or none, of which at most half are taken.
    places: Box<[u32]>,
    entries: Vec<(K, V)>,
}

impl<K, V> Default for StableMap<K, V> {
    fn default() -> Self {
        StableMap { places: Box::default(), entries: Vec::new() }
    }
}

impl<K: Hash + Eq, V> StableMap<K, V> {
    pub fn get<Q: ?Sized + Hash + Eq>(&self, key: &Q) -> Option<&V>
    where
        K: Borrow<Q>,
    {
        if self.places.is_empty() {
            return None;
        }
        match self.places[self.search(key)] {
            0 => None,
            place => Some(&self.entries[place as usize - 1].1),
        }
    }

    pub fn insert(&mut self, key: K, value: V) {
        match self.entry(&key) {
            (_, Some(known)) => self.entries[known].1 = value,
            (free, None) => self.push(free, key, value),
        }
    }

    /// The value of this key, which is the given one if there was none.
    pub fn get_or_insert(&mut self, key: K, value: V) -> &V {
        let at = match self.entry(&key) {
            (_, Some(known)) => known,
            (free, None) => {
                self.push(free, key, value);
                self.entries.len() - 1
            }
        };
        &self.entries[at].1
    }

    /// The place of this key, and its entry if there is one.
    fn entry(&mut self, key: &K) -> (usize, Option<usize>) {
        if self.places.len() <= 2 * self.entries.len() {
            self.grow();
        }
        let at = self.search(key);
        (at, (self.places[at] as usize).checked_sub(1))
    }

    fn push(&mut self, place: usize, key: K, value: V) {
        self.entries.push((key, value));
        self.places[place] = self.entries.len() as u32;
    }

    /// The place of this key, or a free one for it.
    fn search<Q: ?Sized + Hash + Eq>(&self, key: &Q) -> usize
    where
        K: Borrow<Q>,
    {
        let places = &*self.places;
        let mut at = first(key, places.len());
        loop {
            match places[at] {
                0 => return at,
                place if self.entries[place as usize - 1].0.borrow() == key => return at,
                _ => at = (at + 1) & (places.len() - 1),
            }
        }
    }

    fn grow(&mut self) {
        let size = (4 * self.entries.len()).next_power_of_two().max(32);
        let mut places = vec![0; size].into_boxed_slice();
        let mut place = 0;
        while place < self.entries.len() {
            let mut at = first(&self.entries[place].0, size);
            while places[at] != 0 {
                at = (at + 1) & (size - 1);
            }
            place += 1;
            places[at] = place as u32;
        }
        self.places = places;
    }
}

/// First slot to probe among a power of two: the upper bits of the hash, into which all others have been mixed.
fn first<Q: ?Sized + Hash>(key: &Q, places: usize) -> usize {
    let mut hash = Fx(0);
    key.hash(&mut hash);
    (hash.0 >> (64 - places.trailing_zeros())) as usize
}

/// The same for nodes, as a table by their numbers: in an unoptimised macro a look at a hash table costs ten times as
/// much.
#[derive(Clone)]
pub struct IdMap<V> {
    /// Index of the value of a node, counted from 1.
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
        // Looks into slices, by conditions, take no calls without optimisation.
        let (at, places) = (key.0 as usize, self.places.as_slice());
        if at >= places.len() || places[at] == 0 {
            return None;
        }
        Some(&self.values.as_slice()[places[at] as usize - 1])
    }

    pub fn get_mut(&mut self, key: &Id) -> Option<&mut V> {
        let at = key.0 as usize;
        match self.places.as_slice().get(at) {
            None | Some(0) => None,
            Some(place) => Some(&mut self.values.as_mut_slice()[*place as usize - 1]),
        }
    }

    pub fn insert(&mut self, key: Id, value: V) {
        let at = key.0 as usize;
        if at >= self.places.len() {
            // Zeros come from the allocator; pushed one by one they would not.
            let mut places = vec![0; (at + 1).next_power_of_two()];
            places[..self.places.len()].copy_from_slice(&self.places);
            self.places = places;
        }
        let place = &mut self.places.as_mut_slice()[at];
        if *place == 0 {
            self.values.push(value);
            *place = self.values.len() as u32;
        } else {
            self.values[*place as usize - 1] = value;
        }
    }
}

impl<V> IdMap<V> {
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// All entries, by the numbers of their nodes.
    pub fn in_order(self) -> Vec<(Id, V)> {
        let mut values: Vec<Option<V>> = self.values.into_iter().map(Some).collect();
        let mut all = Vec::with_capacity(values.len());
        let (mut at, places) = (0, self.places.as_slice());
        while at < places.len() {
            if places[at] > 0
                && let Some(value) = values[places[at] as usize - 1].take()
            {
                all.push((Id(at as u32), value));
            }
            at += 1;
        }
        all
    }
}

impl IdMap<usize> {
    /// Counts one more of this node.
    pub fn count(&mut self, key: Id) {
        let before = self.get(&key).copied().unwrap_or(0);
        self.insert(key, before + 1);
    }
}

/// The multiply-and-rotate hash of rustc: an unoptimised macro cannot afford SipHash.
struct Fx(u64);

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
