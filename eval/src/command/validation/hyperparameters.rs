//! The hyper-parameters that validation objects ask of the Gaussian process over the azimuth.

use super::Trial;
use crate::pipeline::true_viewpoint;
use vantage_learn::gaussian_process::Hyperparameters;

/// Those of most marginal likelihood for the trials' objects, and that likelihood's logarithm, nats.
pub fn hyperparameters(trials: &[Trial]) -> (Hyperparameters, f64) {
    let of_trial = |Trial { observations, truth }: &'_ Trial| {
        let object = |track: usize| {
            let detections = observations.detections.iter().enumerate();
            let of_track = detections.filter(|(_, detection)| detection.track == track);
            let views = of_track.filter_map(|(number, detection)| {
                let (_, viewpoint) = true_viewpoint(observations, truth, number)?;
                Some((detection.masked_crop.clone(), viewpoint.azimuth()))
            });
            views.collect::<Vec<_>>()
        };
        (0..truth.objects.len()).map(object).collect::<Vec<_>>()
    };
    let objects: Vec<_> = trials.iter().flat_map(of_trial).collect();
    let lent: Vec<Vec<_>> =
        objects.iter().map(|views| views.iter().map(|(crop, azimuth)| (crop, *azimuth)).collect()).collect();
    Hyperparameters::fit(&lent)
}
