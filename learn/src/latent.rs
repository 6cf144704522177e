//! The steerable latent `e`: which of its numbers turn with the viewpoint.

use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use vantage_dataset::viewpoint::HARMONICS;

/// A model's latent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Latent {
    /// Numbers in it.
    pub dimension: usize,
    /// Which of them turn with the azimuth, where the model has learned to turn them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steerable: Option<LatentLayout>,
}

impl Latent {
    /// What of a latent says which object it is, whatever the object's heading: the invariant numbers of a
    /// steerable latent, all numbers of another.
    pub fn steady(&self, latent: &DVector<f64>) -> Vec<f64> {
        match self.steerable {
            Some(layout) => layout.steady(latent),
            None => latent.as_slice().to_vec(),
        }
    }
}

/// How a steerable latent is laid out: `[invariant | first of each pair | second of each pair]`.
///
/// The invariant part looks the same from every azimuth. Pair `p` belongs to harmonic
/// `m = p / pairs_per_harmonic + 1` and turns by `m * azimuth`: an object seen from azimuth `a` has, in the
/// camera's yaw frame, each pair turned by `-m a`. Turning is orthogonal, so that the standard normal prior
/// of Eq. 12 stays what it is. The two numbers of a pair share a variance, so that turning keeps them independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LatentLayout {
    /// Numbers that do not turn.
    pub invariant: usize,
    /// Pairs of each harmonic `m = 1..=HARMONICS`.
    pub pairs_per_harmonic: usize,
}

impl LatentLayout {
    /// The layout of a latent of `dimension` numbers.
    ///
    /// `None` where the pairs leave nothing that does not turn.
    pub fn new(dimension: usize, pairs_per_harmonic: usize) -> Option<Self> {
        let invariant = dimension.checked_sub(2 * HARMONICS * pairs_per_harmonic)?;
        (invariant > 0).then_some(Self { invariant, pairs_per_harmonic })
    }

    /// Number of pairs.
    pub fn pairs(&self) -> usize {
        HARMONICS * self.pairs_per_harmonic
    }

    /// Numbers in a latent.
    pub fn dimension(&self) -> usize {
        self.invariant + 2 * self.pairs()
    }

    /// The harmonic `m` of a pair.
    pub fn harmonic(&self, pair: usize) -> usize {
        pair / self.pairs_per_harmonic + 1
    }

    /// The invariant numbers.
    ///
    /// # Panics
    /// If `latent` is not of this layout's dimension.
    pub fn steady(&self, latent: &DVector<f64>) -> Vec<f64> {
        assert_eq!(latent.len(), self.dimension(), "a latent of another layout");
        latent.iter().take(self.invariant).copied().collect()
    }

    /// The latent of the object turned by `-angle` about its z axis, so that
    /// [`Viewpoint::turned`](vantage_dataset::Viewpoint::turned) by `angle` sees it as before.
    ///
    /// # Panics
    /// If `latent` is not of this layout's dimension.
    pub fn turned(&self, latent: &DVector<f64>, angle: f64) -> DVector<f64> {
        assert_eq!(latent.len(), self.dimension(), "a latent of another layout");
        let mut turned = latent.clone();
        for pair in 0..self.pairs() {
            let (s, c) = libm::sincos(self.harmonic(pair) as f64 * angle);
            let (x, y) = (self.invariant + pair, self.invariant + self.pairs() + pair);
            turned[x] = c * latent[x] - s * latent[y];
            turned[y] = s * latent[x] + c * latent[y];
        }
        turned
    }

    /// The derivative of [`LatentLayout::turned`] by the angle, at a latent that is turned already.
    ///
    /// # Panics
    /// If `latent` is not of this layout's dimension.
    pub fn by_angle(&self, latent: &DVector<f64>) -> DVector<f64> {
        assert_eq!(latent.len(), self.dimension(), "a latent of another layout");
        let mut derivative = DVector::zeros(latent.len());
        for pair in 0..self.pairs() {
            let (x, y) = (self.invariant + pair, self.invariant + self.pairs() + pair);
            let m = self.harmonic(pair) as f64;
            (derivative[x], derivative[y]) = (-m * latent[y], m * latent[x]);
        }
        derivative
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn latent(layout: LatentLayout) -> DVector<f64> {
        DVector::from_fn(layout.dimension(), |i, _| (i as f64 * 0.7).sin())
    }

    #[test]
    fn pairs_leave_the_rest_of_a_latent_invariant() {
        let layout = LatentLayout::new(128, 10).unwrap();
        assert_eq!(layout, LatentLayout { invariant: 28, pairs_per_harmonic: 10 });
        assert_eq!(layout.harmonic(0), 1);
        assert_eq!(layout.harmonic(49), 5);
        assert_eq!(LatentLayout::new(7, 0).unwrap().dimension(), 7);
        assert_eq!(LatentLayout::new(11, 1).unwrap().dimension(), 11);
        assert_eq!(LatentLayout::new(10, 1), None);
    }

    #[test]
    fn turning_is_orthogonal_and_adds_up() {
        let layout = LatentLayout::new(40, 3).unwrap();
        let e = latent(layout);
        let turned = layout.turned(&e, 0.8);
        assert_relative_eq!(turned.norm(), e.norm(), epsilon = 1e-12);
        assert!((&turned - &e).norm() > 0.1);
        assert_relative_eq!(layout.turned(&turned, -0.8), e, epsilon = 1e-12);
        assert_relative_eq!(layout.turned(&turned, 0.5), layout.turned(&e, 1.3), epsilon = 1e-12);
        assert_relative_eq!(layout.turned(&e, 2.0 * std::f64::consts::PI), e, epsilon = 1e-12);
    }

    #[test]
    fn the_derivative_of_a_turn_is_that_of_differences() {
        let layout = LatentLayout::new(40, 3).unwrap();
        let e = latent(layout);
        let numeric = (layout.turned(&e, 0.8 + 1e-6) - layout.turned(&e, 0.8 - 1e-6)) / 2e-6;
        assert_relative_eq!(layout.by_angle(&layout.turned(&e, 0.8)), numeric, epsilon = 1e-8);
    }

    #[test]
    fn what_is_steady_does_not_turn_and_without_a_layout_it_is_everything() {
        let layout = LatentLayout::new(40, 3).unwrap();
        let e = latent(layout);
        let steady = DVector::from_vec(layout.steady(&e));
        assert_eq!(steady.len(), layout.invariant);
        assert_relative_eq!(
            DVector::from_vec(layout.steady(&layout.turned(&e, 1.7))),
            steady,
            epsilon = 1e-12
        );
        let latent = Latent { dimension: 40, steerable: None };
        assert_eq!(latent.steady(&e), e.as_slice());
    }
}
