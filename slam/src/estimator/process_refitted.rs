//! P(X, O, E, B | U, Z^g, Z^s): semantic, with a process per object that corrects the model's predictions by the object's own views. How large
//! corrections are, and how far crops are trusted, is refitted on the run itself, from one drive on to the next: nothing is told of how far the
//! model is off.
//!
//! Of the model alone and of each size of the process, that is taken which makes all that is observed most probable; under it, as of
//! [`Refitted`](super::Refitted), the spread of the semantic residual and the discrepancy of azimuths.

use super::refitted::{Tried, best_of, known_before, likeliest, most_probable};
use super::{Estimator, Learner, Learnt, Semantic, crops_read, is_at_maximum};
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::{Lesson, PROCESSES, ProcessOdds};
use crate::settings::{SemanticSettings, Settings};
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

/// Deviations of the corrections that are tried, in those of the model's noise.
pub const PROCESS_SIZES: [f64; PROCESSES] = [0.5, 1.0, 2.0];

/// [`Semantic`] by the model, or by a process of one of several sizes beside it.
pub struct ProcessRefitted<'m> {
    settings: Settings,
    model: &'m dyn ObservationModel,
    processes: [&'m dyn ObservationModel; PROCESSES],
}

/// A way to read crops: by the model alone or with the process of that number, under these settings.
#[derive(Clone, Copy, PartialEq)]
struct Way {
    process: Option<usize>,
    semantics: SemanticSettings,
}

/// Ways that were tried on a drive, with their log-evidences.
struct Trial<'t> {
    of: &'t ProcessRefitted<'t>,
    observations: &'t Observations,
    tried: Vec<(Way, Option<f64>)>,
    /// Crops that the first way read.
    crops: Option<Vec<usize>>,
}

impl<'m> ProcessRefitted<'m> {
    /// An estimator that reads crops by `model`, or by one of `processes` beside it, of the sizes of [`PROCESS_SIZES`], whose latents begin
    /// with those of the model.
    pub fn new(
        settings: &Settings,
        model: &'m dyn ObservationModel,
        processes: [&'m dyn ObservationModel; PROCESSES],
    ) -> Self {
        Self { settings: *settings, model, processes }
    }
}

impl Trial<'_> {
    /// The estimate, and its log-evidence. That is comparable between ways: `None` where the solver came to no maximum, or where other crops
    /// are read than by the first way.
    fn by(&mut self, way: &Way) -> Result<Tried<Estimate>, EstimateError> {
        let ProcessRefitted { settings, model, processes } = self.of;
        let settings = Settings { semantics: way.semantics, ..*settings };
        let reader = way.process.map_or(*model, |process| processes[process]);
        let (mut estimate, evidence) =
            Semantic::new(&settings, reader).evidenced_among_models(self.observations)?;
        let latents = estimate.objects.iter_mut().flatten().filter_map(|object| object.latent.as_mut());
        latents.for_each(|latent| latent.truncate(model.latent_dim()));
        let crops = crops_read(&estimate);
        let are_same = self.crops.get_or_insert_with(|| crops.clone()) == &crops;
        let is_comparable = are_same && is_at_maximum(&estimate);
        let evidence = evidence.filter(|_| is_comparable);
        self.tried.push((*way, evidence));
        Ok((estimate, evidence))
    }

    /// The log-evidence of a way.
    fn evidence(&mut self, way: &Way) -> Result<Option<f64>, EstimateError> {
        match self.tried.iter().find(|(tried, _)| tried == way) {
            Some((_, evidence)) => Ok(*evidence),
            None => Ok(self.by(way)?.1),
        }
    }
}

impl Estimator for ProcessRefitted<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        Ok(self.learn(observations, &Lesson::default())?.estimate)
    }
}

/// By the evidences of all drives so far, those of older ones counting less.
impl Learner for ProcessRefitted<'_> {
    fn learn(&self, observations: &Observations, before: &Lesson) -> Result<Learnt, EstimateError> {
        let semantics = self.settings.semantics;
        let alone = Way { process: None, semantics };
        let mut trial = Trial { of: self, observations, tried: Vec::new(), crops: None };
        let first = trial.by(&alone)?;
        let ways = std::array::from_fn(|size| Way { process: size.checked_sub(1), semantics });
        let (way, best, size) = best_of(ways, first, &before.process.size, |way| trial.by(way))?;
        let by = |semantics: &SemanticSettings| trial.by(&Way { semantics: *semantics, ..way });
        let (refit, estimate) = most_probable(semantics, best, &before.process.noise, by)?;

        let known = Way {
            process: likeliest(&before.process.size).checked_sub(1),
            semantics: known_before(semantics, &before.process.noise),
        };
        let crops: usize = crops_read(&estimate).iter().sum();
        let gain = trial.evidence(&known)?.zip(trial.evidence(&alone)?);
        let gain =
            gain.filter(|_| crops > 0).map(|(of_known, of_alone)| (of_known - of_alone) / crops as f64);
        let process = before.process.after(&ProcessOdds { size, noise: refit.odds });
        Ok(Learnt { estimate, lesson: Lesson { process, ..before.clone() }, gain })
    }
}
