//! Asks who is who on an episode: associators that read crops by a model and the embedding, with a scene's settings.

use super::associator_row::Looks;
use super::embedding::{LoadedEmbedding, embedding};
use super::estimates::PANICKED;
use super::readouts::readouts;
use super::{LoadedModel, Pipeline, StageError};
use crate::scene_file::associator::AssociatedBy;
use crate::scene_file::estimator::EstimatorSpec;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use vantage_dataset::{InstanceId, Observations, Tracklets};
use vantage_learn::readout::Readouts;
use vantage_sim::scene::DetectorSpec;
use vantage_slam::{Association, EstimateError};

/// What associators read crops by, and the scene that they are asked in.
pub struct Associating<'p> {
    spec: &'p EstimatorSpec,
    detector: &'p DetectorSpec,
    model: &'p LoadedModel,
    readouts: Readouts,
    /// What identifies the views that the read-outs are fitted on.
    fitted_on: String,
    embedding: LoadedEmbedding,
}

/// All that an answer depends on but the episode and the associator.
#[derive(Serialize)]
pub struct Identity<'a> {
    /// Hashes of the models.
    pub models: Vec<&'a str>,
    /// What identifies the views that the read-outs are fitted on.
    pub readouts: Option<&'a str>,
    /// What identifies the embedding.
    pub embedding: &'a [String],
    /// Settings.
    pub spec: &'a EstimatorSpec,
    /// How the detector errs.
    pub detector: &'a DetectorSpec,
}

/// Tracklets, of each detection its number among the episode's, and what somebody makes of them.
pub struct Answered {
    pub tracklets: Tracklets,
    pub order: Vec<usize>,
    pub answer: Result<Association, String>,
}

impl<'p> Associating<'p> {
    /// By a model of looks, and what is fitted on the scene's validation views.
    pub fn new(pipeline: &'p Pipeline, model: &'p LoadedModel) -> Result<Self, StageError> {
        let (readouts, fitted_on) = readouts(pipeline, &model.model)?;
        let embedding = embedding(pipeline)?;
        let (spec, detector) = (&pipeline.file.estimator, &pipeline.file.sensors.detector);
        Ok(Self { spec, detector, model, readouts, fitted_on, embedding })
    }

    /// All that answers depend on but episode and associator, beside those of `models`.
    pub fn identity<'a>(&'a self, models: Vec<&'a str>) -> Identity<'a> {
        let (spec, detector) = (self.spec, self.detector);
        Identity {
            models,
            readouts: Some(&self.fitted_on),
            embedding: &self.embedding.identity,
            spec,
            detector,
        }
    }

    /// Refuses to score instances that the embedding has seen.
    pub fn check_unseen(&self, scored: impl IntoIterator<Item = InstanceId>) -> Result<(), StageError> {
        self.embedding.check_unseen(scored)
    }

    /// Who is who, by an associator that is told no more than it may be.
    pub fn ask(&self, of: AssociatedBy, observations: &Observations) -> Result<Answered, StageError> {
        let AssociatedBy { told, by } = of;
        let (tracklets, order) = told.of(observations);
        let settings = self.spec.settings();
        let looks = Looks {
            model: self.model.viewing(),
            readouts: &self.readouts,
            embedding: self.embedding.readout(),
        };
        let Some(associator) = by.associator((told, observations), &settings, self.detector, looks) else {
            let reason = "too few validation views to say how near numbers of one object lie";
            return Ok(Answered { tracklets, order, answer: Err(reason.to_owned()) });
        };
        let answer = match catch_unwind(AssertUnwindSafe(|| associator.associate(&tracklets))) {
            Ok(Ok(association)) => Ok(association),
            Ok(Err(error @ (EstimateError::Model(_) | EstimateError::Association { .. }))) => {
                Err(error.to_string())
            }
            Ok(Err(error)) => return Err(error.into()),
            Err(_) => Err(PANICKED.to_owned()),
        };
        Ok(Answered { tracklets, order, answer })
    }
}

/// [`Associating::identity`] where nothing reads crops.
pub fn of_nobody<'a>(pipeline: &'a Pipeline, models: Vec<&'a str>) -> Identity<'a> {
    let (spec, detector) = (&pipeline.file.estimator, &pipeline.file.sensors.detector);
    Identity { models, readouts: None, embedding: &[], spec, detector }
}

impl Answered {
    /// Of each detection of the episode, its object by what is told of tracklets.
    pub fn of_detections(&self, told: &[Option<usize>]) -> Vec<Option<usize>> {
        let mut objects = vec![None; self.order.len()];
        for (detection, &number) in self.tracklets.observations().detections.iter().zip(&self.order) {
            objects[number] = told[detection.track];
        }
        objects
    }
}
