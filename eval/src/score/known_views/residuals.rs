//! Residuals of objects that were seen from a few known viewpoints, under another light: what a process beside the model is fitted on.

use super::{finite, known_and_asked, posterior};
use nalgebra::DVector;
use rayon::prelude::*;
use vantage_dataset::ViewSet;
use vantage_model::{AnswerError, ObservationModel};

/// Known views of each object.
const KNOWN: usize = 8;
/// Most objects that a process is fitted to.
pub const FITTED_TO: usize = 128;

/// Azimuth, radians, and whitened residual of each view of an object.
type OfObject = Vec<(f64, DVector<f64>)>;

/// Azimuths and whitened residuals of the views of each object's odd sessions, by the most probable latent of its first views
/// of even sessions. `done` is told of each object.
pub fn residuals(
    set: &ViewSet,
    model: &dyn ObservationModel,
    free_yaw: bool,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<OfObject>, AnswerError> {
    let of_instance = |instance: usize| {
        let (seen, others) = known_and_asked(set, instance, KNOWN);
        let (Some(object), yaw) = posterior(model, &seen, free_yaw)? else { return Ok(Vec::new()) };
        let mut own = Vec::new();
        for view in others {
            let Some(measurement) = finite(model.measure(&view.crop))? else { continue };
            let residual = object.whitened_residual(&measurement, &view.viewpoint.turned(yaw));
            own.extend(residual.map(|residual| (view.viewpoint.azimuth(), residual)));
        }
        Ok(own)
    };
    (0..set.instances.len().min(FITTED_TO))
        .into_par_iter()
        .map(|instance| of_instance(instance).inspect(|_| done()))
        .collect()
}
