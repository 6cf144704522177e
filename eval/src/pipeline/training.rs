//! Training as a stage: views in, model folder out.

use super::{Pipeline, StageError, VIEW_CONDITIONS, code, views};
use crate::progress::Stage;
use crate::result::manifest::Host;
use crate::scene_file;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Key, read_manifest, read_views};
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_learn::{MANIFEST, Progress, Training, TrainingDevice, TrainingSpec};

/// The folder of the scene's model, trained where the cache has none.
pub fn trained(pipeline: &Pipeline) -> Result<PathBuf, StageError> {
    let conditions = pipeline.scene.view_conditions();
    let training = &pipeline.file.training;
    let inputs = (code::TRAINED, &conditions, training.seed, &training.model, &pipeline.renderer_info);
    let entry = pipeline.cache.entry(&Key::new("model", &inputs)?, |work| {
        // A run that was killed between the last file and the commit has left a whole model.
        if work.join(MANIFEST).exists() {
            return Ok(());
        }
        pipeline.progress.note(
            "no finished model is named: one is trained first, and kept in the cache; `--model DIR` names one",
        );
        train(pipeline, &TrainingDevice::default(), work)
    })?;
    Ok(entry.folder)
}

/// Trains the scene's model into `folder`, from where an interrupted training left it.
pub fn train(pipeline: &Pipeline, device: &TrainingDevice, folder: &Path) -> Result<(), StageError> {
    let TrainingSpec { trunk_steps, steps, .. } = pipeline.file.training.model;
    pipeline.progress.note(&format!(
        "training a model of {}, in {trunk_steps} and {steps} steps (8000 and 20000 take ten minutes or more \
         on two cores)",
        pipeline.file.name
    ));
    let training = shown_views(pipeline, Split::Train)?.0;
    let validation = shown_views(pipeline, Split::Validation)?.0;
    let conditions = scene_file::hash(&pipeline.scene.view_conditions())?;
    let (spec, seed) = (&pipeline.file.training.model, pipeline.file.training.seed);
    let fitted =
        Fit { training: &training, validation: &validation, conditions, spec, seed, trunks: None, device };
    fit(pipeline, fitted, folder)
}

/// Trains a model as the scene says, but on stored view sets.
pub fn train_on(
    pipeline: &Pipeline,
    training: &Path,
    validation: &Path,
    device: &TrainingDevice,
    folder: &Path,
) -> Result<(), StageError> {
    let conditions = scene_file::hash(&[read_manifest(training)?.seal, read_manifest(validation)?.seal])?;
    let (training, validation) = (read_views(training)?, read_views(validation)?);
    let (spec, seed) = (&pipeline.file.training.model, pipeline.file.training.seed);
    let fitted =
        Fit { training: &training, validation: &validation, conditions, spec, seed, trunks: None, device };
    fit(pipeline, fitted, folder)
}

/// A training, and what its model's manifest says of the views.
pub(super) struct Fit<'a> {
    pub(super) training: &'a ViewSet,
    pub(super) validation: &'a ViewSet,
    /// Hash of the conditions the views were made under.
    pub(super) conditions: String,
    pub(super) spec: &'a TrainingSpec,
    pub(super) seed: Seed,
    pub(super) trunks: Option<&'a Path>,
    pub(super) device: &'a TrainingDevice,
}

/// Trains into `folder`, from where a killed training left it.
pub(super) fn fit(pipeline: &Pipeline, fitted: Fit<'_>, folder: &Path) -> Result<(), StageError> {
    let Fit { training, validation, conditions, spec, seed, trunks, device } = fitted;
    let info = pipeline.renderer_info.clone();
    let provenance = [
        (VIEW_CONDITIONS, conditions),
        ("renderer", info.renderer),
        ("adapter", info.adapter),
        ("driver", info.driver),
        ("code", code::TRAINED.to_owned()),
        ("cpu", Host::this().cpu.unwrap_or_default()),
    ];
    let gpu = device.name().map(|name| ("gpu", name.to_owned()));
    let provenance =
        provenance.into_iter().chain(gpu).map(|(what, value)| (what.to_owned(), value)).collect();
    let mut shown = Shown { pipeline, stage: None };
    let training =
        Training { training, validation, spec, seed, provenance: &provenance, folder, trunks, device };
    vantage_learn::train(training, &mut |event| {
        shown.tell(event);
        ControlFlow::Continue(())
    })?;
    Ok(())
}

/// The views of a split under the seed of the training, with progress, and their seal.
pub(super) fn shown_views(pipeline: &Pipeline, split: Split) -> Result<(ViewSet, String), StageError> {
    let instances = pipeline.scene.view_conditions().views.instances(split) as u64;
    let name = format!("{} views", split.name());
    let mut stage = None;
    let mut made = |count| {
        stage.get_or_insert_with(|| pipeline.progress.stage(&name, instances)).advance(count);
    };
    views(pipeline, split, pipeline.file.training.seed, &mut made)
}

/// The training's own progress as ours.
struct Shown<'a> {
    pipeline: &'a Pipeline,
    stage: Option<(vantage_learn::Stage, Stage, usize)>,
}

impl Shown<'_> {
    fn tell(&mut self, event: &Progress) {
        match event {
            Progress::Step { stage, step, steps, .. } => {
                if self.stage.as_ref().is_none_or(|(shown, ..)| shown != stage) {
                    let fresh = self.pipeline.progress.stage(&format!("train {stage}"), *steps as u64);
                    self.stage = Some((*stage, fresh, 0));
                }
                if let Some((_, shown, done)) = &mut self.stage {
                    shown.advance(step.saturating_sub(*done) as u64);
                    *done = *step;
                }
            }
            Progress::Resumed { stage, step } => {
                self.pipeline.progress.note(&format!("training goes on at step {step} of stage {stage}"));
            }
            Progress::SetAside { path, reason } => {
                self.pipeline.progress.note(&format!(
                    "warning: the training's checkpoint cannot be used ({reason}); it was moved to {}",
                    path.display()
                ));
            }
            _ => self.stage = None,
        }
    }
}
