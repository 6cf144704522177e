//! Stage `known_views`: azimuths of objects that were seen from a few known viewpoints, by a model, by a Gaussian process alone, and by one
//! whose prior mean is the model.

use super::object_process::residual_process;
use super::{ModelRefusal, Pipeline, ScoredViews, StageError, code};
use crate::score::known_views::{CALIBRATING, KnownViewTrial, information_scale, known_view_trials};
use vantage_dataset::store::Key;
use vantage_dataset::{Crop, ViewSet};
use vantage_learn::gaussian_process::{GaussianProcess, Hyperparameters};
use vantage_learn::residual_process::ResidualProcess;
use vantage_learn::{Kind, Model};
use vantage_model::{AnswerError, ObservationModel};

const FILE: &str = "known_views.json";
const SCALE: &str = "scale.json";

/// What tells the azimuth.
#[derive(Clone, Copy)]
pub enum Teller<'a> {
    /// A Gaussian process per object on pixels.
    Process,
    /// A model of looks.
    Model(&'a Model),
    /// That with a process beside it.
    Both(&'a Model),
}

impl Teller<'_> {
    fn identity(&self) -> (&'static str, &str) {
        match self {
            Teller::Process => ("process", ""),
            Teller::Model(model) => ("model", model.hash()),
            Teller::Both(model) => ("both", model.hash()),
        }
    }
}

/// The queries of all sets together. Processes are fitted on the views of `validation`, of that seal. `None` of a model that tells no
/// looks, or whose residuals cannot be fitted.
pub fn known_views(
    pipeline: &Pipeline,
    (validation, seal): (&ViewSet, &str),
    sets: &[ScoredViews],
    known: usize,
    teller: Teller<'_>,
) -> Result<Option<Vec<KnownViewTrial>>, StageError> {
    let cache = &pipeline.cache;
    let of_set = |model: &dyn ObservationModel, free_yaw: bool| {
        let (kind, hash) = teller.identity();
        let key = Key::new("known_views_scale", &(code::SCORED, seal, known, kind, hash))?;
        let scale: f64 = cache.json(&key, SCALE, || {
            let name = format!("calibrating {known} known views");
            let objects = validation.instances.len().min(CALIBRATING) as u64;
            let stage = pipeline.progress.stage(&name, objects);
            Ok(information_scale(validation, known, model, free_yaw, &|| stage.advance(1))
                .map_err(refused)?)
        })?;
        let objects = sets.iter().map(|scored| scored.set.instances.len() as u64).sum();
        let mut stage = None;
        let trials: Result<Vec<Vec<KnownViewTrial>>, StageError> = sets
            .iter()
            .map(|scored| {
                let key = Key::new("known_views", &(code::SCORED, &scored.seal, seal, known, kind, hash))?;
                cache.json(&key, FILE, || {
                    let name = format!("azimuths from {known} known views");
                    let stage = stage.get_or_insert_with(|| pipeline.progress.stage(&name, objects));
                    let told = &|| stage.advance(1);
                    Ok(known_view_trials(&scored.set, known, model, free_yaw, scale, told)
                        .map_err(refused)?)
                })
            })
            .collect();
        Ok(Some(trials?.concat()))
    };
    let (Teller::Model(model) | Teller::Both(model)) = teller else {
        return of_set(&process(validation).map_err(refused)?, false);
    };
    let Some(viewing) = model.viewing() else { return Ok(None) };
    let free_yaw = model.manifest().kind == Kind::ViewpointDependent;
    if matches!(teller, Teller::Model(_)) {
        return of_set(viewing, free_yaw);
    }
    let Some(fitted) = residual_process(pipeline, (validation, seal), model)? else { return Ok(None) };
    of_set(&ResidualProcess::new(viewing, &fitted).map_err(refused)?, free_yaw)
}

/// A process on pixels, with the deviations of most marginal likelihood of these objects.
fn process(validation: &ViewSet) -> Result<GaussianProcess, AnswerError> {
    let mut objects: Vec<Vec<(&Crop, f64)>> = vec![Vec::new(); validation.instances.len()];
    for view in &validation.views {
        objects[view.instance].push((&view.crop, view.viewpoint.azimuth()));
    }
    let degrees_of_freedom = Hyperparameters::FITTED.degrees_of_freedom;
    GaussianProcess::new(Hyperparameters { degrees_of_freedom, ..Hyperparameters::fit(&objects).0 })
}

fn refused(error: AnswerError) -> ModelRefusal {
    ModelRefusal::Answer(error)
}
