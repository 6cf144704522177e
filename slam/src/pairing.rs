//! Which view of an object each view is predicted from.

/// Of the views of one object, by step, the one that each is [given](Pairing::given). Every view is predicted once.
///
/// The product of those predictions is a density of all views, so that no noise counts twice. A view that others are given is taken as it was
/// measured, with its noise, where a model reads it: a [`Star`](Pairing::Star) has all others depend on that of one view, a
/// [`Chain`](Pairing::Chain) each on that of the one before, and of the others no view is in two pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pairing {
    /// The first one.
    Star,
    /// The first one, of whose noise this share is the measurement's own, from 0 to below 1: 0 is a star, and at 1 the first view would
    /// tell no more than the latent. What was measured without it is a [variable](crate::noisy_first).
    NoisyStar(f64),
    /// The one before.
    Chain,
    /// Every other view the one before.
    Neighbours,
    /// Views of the second half those of the first half, in their order.
    Halves,
}

impl Pairing {
    /// Which of `count` views the one with an `index` is given; `None` of one that is predicted by the latent alone.
    pub fn given(self, index: usize, count: usize) -> Option<usize> {
        match self {
            Pairing::Star | Pairing::NoisyStar(_) => (index > 0).then_some(0),
            Pairing::Chain => index.checked_sub(1),
            Pairing::Neighbours => (index % 2 == 1).then(|| index - 1),
            Pairing::Halves => index.checked_sub(count.div_ceil(2)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_given_earlier_ones_and_disjoint_pairs_share_none() {
        let given = |pairing: Pairing, count| (0..count).map(|i| pairing.given(i, count)).collect::<Vec<_>>();
        assert_eq!(given(Pairing::Star, 3), [None, Some(0), Some(0)]);
        assert_eq!(given(Pairing::NoisyStar(0.5), 3), given(Pairing::Star, 3));
        assert_eq!(given(Pairing::Chain, 3), [None, Some(0), Some(1)]);
        assert_eq!(given(Pairing::Neighbours, 5), [None, Some(0), None, Some(2), None]);
        assert_eq!(given(Pairing::Halves, 5), [None, None, None, Some(0), Some(1)]);
        assert_eq!(given(Pairing::Halves, 1), [None]);
    }
}
