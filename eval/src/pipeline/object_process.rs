//! Stage `residual_process`: how far a model is off on the views of validation objects, for a process per object beside it; and processes of
//! which a row finds on its own drives how far it is off.

use super::{ModelRefusal, Pipeline, StageError, code, views};
use crate::score::known_views::{FITTED_TO, residuals};
use vantage_dataset::store::Key;
use vantage_dataset::{Split, ViewSet};
use vantage_learn::residual_process::{ResidualHyperparameters, ResidualProcess};
use vantage_learn::{Kind, Model};
use vantage_model::ObservationModel;
use vantage_slam::{PROCESS_SIZES, PROCESSES};

const FILE: &str = "residual_process.json";

/// Fitted on the scene's validation views, and what identifies these.
pub fn object_process(
    pipeline: &Pipeline,
    model: &Model,
) -> Result<(ResidualHyperparameters, String), StageError> {
    let (set, seal) = views(pipeline, Split::Validation, pipeline.file.training.seed, &mut |_| ())?;
    let too_few = || ModelRefusal::NoReadouts { scene: pipeline.file.name.clone(), views: set.views.len() };
    let fitted = residual_process(pipeline, (&set, &seal), model)?.ok_or_else(too_few)?;
    Ok((fitted, seal))
}

/// Processes of the [`PROCESS_SIZES`] beside a model, of which nothing is fitted.
pub fn processes(model: &dyn ObservationModel) -> Result<[ResidualProcess<'_>; PROCESSES], ModelRefusal> {
    let of_size = |size| ResidualProcess::new(model, &ResidualHyperparameters::of_size(size, model));
    let [small, middle, large] = PROCESS_SIZES.map(of_size);
    let all = || Ok([small?, middle?, large?]);
    all().map_err(ModelRefusal::Answer)
}

/// Fitted on views of that seal; `None` of a model that tells no looks, or without a residual.
pub fn residual_process(
    pipeline: &Pipeline,
    (set, seal): (&ViewSet, &str),
    model: &Model,
) -> Result<Option<ResidualHyperparameters>, StageError> {
    let Some(viewing) = model.viewing() else { return Ok(None) };
    let free_yaw = model.manifest().kind == Kind::ViewpointDependent;
    let key = Key::new("residual_process", &(code::SCORED, seal, model.hash()))?;
    pipeline.cache.json(&key, FILE, || {
        let stage =
            pipeline.progress.stage("residuals of objects", set.instances.len().min(FITTED_TO) as u64);
        let objects =
            residuals(set, viewing, free_yaw, &|| stage.advance(1)).map_err(ModelRefusal::Answer)?;
        Ok(ResidualHyperparameters::fit(&objects, viewing.noise().degrees_of_freedom()))
    })
}
