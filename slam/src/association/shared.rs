//! A vector whose copies share what none of them has changed.

use std::rc::Rc;

/// Items that are copied together when one of them changes.
const CHUNK: usize = 32;

/// A vector in chunks: a copy costs a count a chunk, a change of a copy one chunk.
#[derive(Clone, Debug)]
pub struct Shared<T> {
    chunks: Vec<Rc<Vec<T>>>,
    len: usize,
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self { chunks: Vec::new(), len: 0 }
    }
}

impl<T: Clone> Shared<T> {
    /// Number of items.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Adds an item at the end.
    pub fn push(&mut self, item: T) {
        if self.len.is_multiple_of(CHUNK) {
            self.chunks.push(Rc::new(Vec::with_capacity(CHUNK)));
        }
        if let Some(chunk) = self.chunks.last_mut() {
            Rc::make_mut(chunk).push(item);
        }
        self.len += 1;
    }

    /// An item to change, for this copy alone.
    ///
    /// # Panics
    /// If there is none of that number.
    pub fn get_mut(&mut self, index: usize) -> &mut T {
        &mut Rc::make_mut(&mut self.chunks[index / CHUNK])[index % CHUNK]
    }

    /// The items in order.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.chunks.iter().flat_map(|chunk| chunk.iter())
    }

    /// Chunks that another copy has too.
    pub fn shared_with(&self, other: &Self) -> usize {
        self.chunks.iter().zip(&other.chunks).filter(|(a, b)| Rc::ptr_eq(a, b)).count()
    }
}

impl<T> std::ops::Index<usize> for Shared<T> {
    type Output = T;

    fn index(&self, index: usize) -> &T {
        &self.chunks[index / CHUNK][index % CHUNK]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_a_copy_leaves_the_other_and_copies_one_chunk() {
        let mut first = Shared::default();
        (0..5 * CHUNK + 3).for_each(|i| first.push(i));
        let mut second = first.clone();
        assert_eq!(first.shared_with(&second), 6);
        *second.get_mut(70) = 7;
        second.push(8);
        assert_eq!((first[70], second[70], first.len(), second.len()), (70, 7, 163, 164));
        assert_eq!(first.shared_with(&second), 4);
        assert_eq!(first.iter().copied().collect::<Vec<_>>(), (0..163).collect::<Vec<_>>());
    }
}
