//! What is clustered and searched: the part of a latent that does not turn, and raw pixels as the floor.

use crate::score::pca::Pca;
use nalgebra::DVector;
use vantage_dataset::ViewSet;
use vantage_learn::{LatentGaussian, LatentLayout};

const COMPONENTS: usize = 64;
/// Crops that the floor's basis is fitted on, at most.
const FITTED_ON: usize = 512;

/// Of the posterior mean after each single view, what does not turn with the object's unknown heading: the invariant
/// numbers, and each pair's length.
pub fn steady_latents(factors: &[LatentGaussian], layout: LatentLayout) -> Vec<Vec<f32>> {
    let single = |factor| LatentGaussian::posterior(layout.dimension(), std::slice::from_ref(factor)).mean;
    factors.iter().map(|factor| steady(&single(factor), layout)).collect()
}

fn steady(latent: &DVector<f64>, layout: LatentLayout) -> Vec<f32> {
    let pairs = layout.pairs();
    let length =
        |pair: usize| libm::hypot(latent[layout.invariant + pair], latent[layout.invariant + pairs + pair]);
    let invariant = latent.iter().take(layout.invariant).copied();
    invariant.chain((0..pairs).map(length)).map(|number| number as f32).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_an_object_changes_nothing_that_is_compared() {
        let layout = LatentLayout::with_dimension(40).unwrap();
        let latent = DVector::from_fn(40, |i, _| libm::sin(i as f64 * 1.3));
        let turned = layout.turned(&latent, 2.1);
        let (a, b) = (steady(&latent, layout), steady(&turned, layout));
        assert_eq!(a.len(), layout.invariant + layout.pairs());
        assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-6));
        assert!((latent - turned).norm() > 1.0);
    }
}
