//! What a model sees in the crops of an episode, by the truth: what a control is taught by.

use std::collections::BTreeMap;
use vantage_dataset::{ObjectTruth, Observations, Truth, Viewpoint};
use vantage_model::{AnswerError, LatentGaussian, ObservationModel};
use vantage_slam::SeenView;
use vantage_slam::sighting::sightings;

/// The object that a detection shows, and from where; none of a detection of nothing, or from where there is no viewpoint.
pub fn true_viewpoint<'t>(
    observations: &Observations,
    truth: &'t Truth,
    number: usize,
) -> Option<(&'t ObjectTruth, Viewpoint)> {
    let detection = &observations.detections[number];
    let object = truth.shown(number, detection)?;
    let world_from_camera = truth.world_from_robot[detection.step] * observations.robot_from_camera;
    let object_from_camera = object.world_from_object.inv_mul(&world_from_camera);
    Some((object, Viewpoint::new(&object_from_camera, object.size)?))
}

/// Of each object's whole detections, the measurement, the true viewpoint and the latent that all of them together tell. Crops that the model does
/// not answer with finite numbers are left out.
pub fn true_views(
    observations: &Observations,
    truth: &Truth,
    model: &dyn ObservationModel,
) -> Result<Vec<SeenView>, AnswerError> {
    let mut of_object: BTreeMap<u64, Vec<(usize, Viewpoint)>> = BTreeMap::new();
    for sighting in sightings(observations).0.into_values().flatten() {
        if let Some((object, viewpoint)) = true_viewpoint(observations, truth, sighting.detection) {
            of_object.entry(object.instance.0).or_default().push((sighting.detection, viewpoint));
        }
    }
    let mut seen = Vec::new();
    for views in of_object.values() {
        let crop = |detection: usize| &observations.detections[detection].masked_crop;
        let mut read = Vec::new();
        for (detection, viewpoint) in views {
            let crop = crop(*detection);
            match model.measure(crop).and_then(|measured| Ok((measured, model.encode(crop, viewpoint)?))) {
                Ok((measurement, factor)) => read.push((measurement, factor, *viewpoint)),
                Err(AnswerError::NonFinite { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        let factors: Vec<LatentGaussian> = read.iter().map(|(_, factor, _)| factor.clone()).collect();
        let latent = LatentGaussian::posterior(model.latent_dim(), &factors).mean;
        seen.extend(read.into_iter().map(|(measurement, _, viewpoint)| SeenView {
            measurement,
            latent: latent.clone(),
            viewpoint,
            weight: 1.0,
        }));
    }
    Ok(seen)
}
