//! A share of numbered things.

/// One part of several alike: every so many-th thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which one, from 0 on.
    pub index: usize,
    /// Of how many.
    pub of: usize,
}

impl Default for Part {
    /// All of it.
    fn default() -> Self {
        Self { index: 0, of: 1 }
    }
}

impl Part {
    /// The things that are in it, in their order.
    pub fn of<T>(self, things: Vec<T>) -> Vec<T> {
        let (index, of) = (self.index, self.of);
        things
            .into_iter()
            .enumerate()
            .filter(|(number, _)| number % of == index)
            .map(|(_, thing)| thing)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_every_thing_once() {
        let all: Vec<usize> = (0..11).collect();
        let mut found: Vec<usize> = (0..4).flat_map(|index| Part { index, of: 4 }.of(all.clone())).collect();
        assert_eq!(Part { index: 3, of: 4 }.of(all.clone()), [3, 7]);
        found.sort_unstable();
        assert_eq!(found, all);
        assert_eq!(Part::default().of(all.clone()), all);
    }
}
