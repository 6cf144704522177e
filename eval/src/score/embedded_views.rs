//! What is clustered and searched: the part of a latent that does not turn, and raw pixels as the floor.

use super::pca::Pca;
use vantage_dataset::ViewSet;
use vantage_learn::Latent;
use vantage_model::LatentGaussian;

const COMPONENTS: usize = 64;
/// Crops that the floor's basis is fitted on, at most.
const FITTED_ON: usize = 512;

/// Of the posterior mean after each single view, what does not turn with the object's unknown heading.
pub fn steady_latents(factors: &[LatentGaussian], latent: Latent) -> Vec<Vec<f32>> {
    let single = |factor| LatentGaussian::posterior(latent.dimension, std::slice::from_ref(factor)).mean;
    let narrowed = |numbers: Vec<f64>| numbers.into_iter().map(|number| number as f32).collect();
    factors.iter().map(|factor| narrowed(latent.steady(&single(factor)))).collect()
}

/// The pixels of each view, along their own 64 principal axes; empty where these are undefined.
pub fn pixels(set: &ViewSet) -> Vec<Vec<f32>> {
    let pixels: Vec<Vec<f32>> = set.views.iter().map(|view| view.crop.to_chw()).collect();
    let fitted_on: Vec<Vec<f32>> =
        pixels.iter().step_by(pixels.len().div_ceil(FITTED_ON).max(1)).cloned().collect();
    match Pca::fit(&fitted_on, COMPONENTS) {
        Some(pca) => pixels.iter().map(|sample| pca.project(sample)).collect(),
        None => vec![Vec::new(); pixels.len()],
    }
}
