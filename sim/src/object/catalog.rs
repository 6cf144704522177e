//! A list of objects that exist once they are asked for.

use super::{Family, Object};
use vantage_dataset::{Seed, Split};

/// `len` objects of one split, their families in turn; object `i` is always the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Catalog {
    families: Vec<Family>,
    split: Split,
    seed: Seed,
    len: usize,
}

impl Catalog {
    /// The catalogue of `len` objects.
    ///
    /// # Panics
    /// If `families` is empty while `len` is not 0.
    pub fn new(families: Vec<Family>, split: Split, seed: Seed, len: usize) -> Self {
        assert!(len == 0 || !families.is_empty(), "a catalogue of {len} objects needs a family");
        Self { families, split, seed, len }
    }

    /// How many objects there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True without objects.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The split all objects belong to.
    pub fn split(&self) -> Split {
        self.split
    }

    /// Draws object `i`, a millisecond's work.
    ///
    /// # Panics
    /// If `i` is not below [`len`](Self::len).
    pub fn object(&self, i: usize) -> Object {
        assert!(i < self.len, "object {i} of a catalogue of {}", self.len);
        let family = self.families[i % self.families.len()];
        Object::generate(family, self.split, self.seed, (i / self.families.len()) as u64)
    }

    /// All objects, drawn one by one.
    pub fn iter(&self) -> impl Iterator<Item = Object> + '_ {
        (0..self.len).map(|i| self.object(i))
    }
}
