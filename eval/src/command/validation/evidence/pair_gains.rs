//! What it gains to predict views from others of their object (Eq. 15), by how they are paired.

use super::{Alone, Predicted, TrueViews, ViewNoise};
use nalgebra::DVector;
use rayon::prelude::*;
use vantage_model::{
    FirstView, Linearization, MeasurementNoise, ObservationModel, PairLinearization, PairModel,
};
use vantage_slam::Pairing;

/// Ways to pair views that are tried, with their names.
pub const PAIRINGS: [(&str, Pairing); 7] = [
    ("star", Pairing::Star),
    ("star, 25% own noise", Pairing::NoisyStar(0.25)),
    ("star, 50% own noise", Pairing::NoisyStar(0.5)),
    ("star, 75% own noise", Pairing::NoisyStar(0.75)),
    ("chain", Pairing::Chain),
    ("disjoint, neighbours", Pairing::Neighbours),
    ("disjoint, halves", Pairing::Halves),
];

/// Views by the latent, and by the one that each is given.
struct Paired<'m> {
    model: &'m dyn PairModel,
    pairing: Pairing,
}

impl Predicted for Paired<'_> {
    fn prior_precision(&self, _: &TrueViews) -> DVector<f64> {
        DVector::from_element(self.model.latent_dim(), 1.0)
    }

    fn at(
        &self,
        object: &TrueViews,
        index: usize,
        latent: &DVector<f64>,
    ) -> Option<(Linearization, &MeasurementNoise)> {
        let view = &object.views[index];
        let Some(given) = self.pairing.given(index, object.len()) else {
            return Some((self.model.linearize(latent, &view.viewpoint).ok()?, self.model.noise()));
        };
        let given = &object.views[given];
        let first = FirstView { measurement: &given.measurement, viewpoint: &given.viewpoint };
        let PairLinearization { mean, d_latent, d_second_viewpoint, .. } =
            self.model.linearize_pair(latent, first, &view.viewpoint).ok()?;
        Some((Linearization { mean, d_latent, d_viewpoint: d_second_viewpoint }, self.model.pair_noise()))
    }
}

/// Of each of [`PAIRINGS`], how much more probable it makes views than the latent alone does, nats a view; `None` where the model gives no finite
/// answer, and of a first view with noise of its own. That noise is as many variables that little but one view's Student t bounds: Laplace's method
/// with its weights takes them for narrower than they are, by nats an object.
pub fn pair_gains(objects: &[TrueViews], model: &dyn PairModel) -> [Option<f64>; PAIRINGS.len()] {
    let views: usize = objects.iter().map(TrueViews::len).sum();
    let sum = |predicted: &dyn Predicted| -> Option<f64> {
        let of = |object: &TrueViews| Some(object.evidence(predicted, ViewNoise::NONE)?.value);
        objects.par_iter().map(of).sum()
    };
    let alone: &dyn ObservationModel = model;
    let none = sum(&Alone(alone));
    PAIRINGS.map(|(_, pairing)| match pairing {
        Pairing::NoisyStar(_) => None,
        _ => Some((sum(&Paired { model, pairing })? - none?) / views as f64),
    })
}
