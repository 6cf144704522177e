//! The graph: the product of all factors.

use crate::factor::Factor;
use crate::variable::{Key, Values};
use std::collections::BTreeMap;

/// A negative log-posterior as a sum of factors.
#[derive(Default)]
pub struct Graph<'m> {
    factors: Vec<Box<dyn Factor + 'm>>,
}

impl<'m> Graph<'m> {
    /// Adds a factor.
    pub fn push(&mut self, factor: impl Factor + 'm) {
        self.factors.push(Box::new(factor));
    }

    /// Adds the factors of another.
    pub fn extend(&mut self, other: Graph<'m>) {
        self.factors.extend(other.factors);
    }

    /// Removes all factors but the first `kept`.
    pub fn truncate(&mut self, kept: usize) {
        self.factors.truncate(kept);
    }

    /// The factors, in the order they were added.
    pub fn factors(&self) -> impl Iterator<Item = &(dyn Factor + 'm)> {
        self.factors.iter().map(|factor| &**factor)
    }

    /// The factors, in the order they were added, each on its own.
    pub fn into_factors(self) -> impl Iterator<Item = Box<dyn Factor + 'm>> {
        self.factors.into_iter()
    }

    /// The negative log-posterior up to a constant, nats; `None` where any factor is undefined.
    pub fn cost(&self, values: &Values) -> Option<f64> {
        self.factors().map(|factor| factor.cost(values)).sum()
    }

    /// The first pose or point, in the order of keys, that no chain of factors ties to an anchor.
    pub fn first_unanchored(&self, values: &Values) -> Option<Key> {
        let keys: Vec<Key> =
            values.iter().filter(|(_, value)| value.position().is_some()).map(|(key, _)| key).collect();
        let index: BTreeMap<Key, usize> = keys.iter().enumerate().map(|(i, key)| (*key, i)).collect();
        let mut parent: Vec<usize> = (0..keys.len()).collect();
        let mut anchored = vec![false; keys.len()];
        for factor in self.factors() {
            let joined: Vec<usize> = factor.keys().iter().filter_map(|key| index.get(key).copied()).collect();
            for pair in joined.windows(2) {
                let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
                parent[a.max(b)] = a.min(b);
            }
            if let (true, Some(&first)) = (factor.is_anchor(), joined.first()) {
                anchored[first] = true;
            }
        }
        let mut root_anchored = vec![false; keys.len()];
        for (i, anchored) in anchored.into_iter().enumerate() {
            let root = root(&mut parent, i);
            root_anchored[root] |= anchored;
        }
        (0..keys.len()).find(|&i| !root_anchored[root(&mut parent, i)]).map(|i| keys[i])
    }
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::{BetweenFactor, PosePrior};
    use crate::variable::Value;
    use nalgebra::Matrix6;
    use vantage_dataset::Pose;

    #[test]
    fn names_the_first_variable_of_a_part_without_an_anchor() {
        let mut values = Values::default();
        for step in 0..5 {
            values.insert(Key::Robot(step), Value::Pose(Pose::identity()));
        }
        let between =
            |a, b| BetweenFactor::new(Key::Robot(a), Key::Robot(b), Pose::identity(), Matrix6::identity());
        let mut graph = Graph::default();
        graph.push(between(0, 1));
        graph.push(between(3, 2));
        graph.push(between(4, 3));
        assert_eq!(graph.first_unanchored(&values), Some(Key::Robot(0)));
        graph.push(PosePrior::new(Key::Robot(1), Pose::identity(), Matrix6::identity()));
        assert_eq!(graph.first_unanchored(&values), Some(Key::Robot(2)));
        graph.push(between(0, 4));
        assert_eq!(graph.first_unanchored(&values), None);
    }
}
