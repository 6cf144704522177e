//! P(X, O, E, B | U, Z^g, Z^s): semantic, with a process per object that corrects the model's predictions by the object's own views. How large
//! corrections are, and how far crops are trusted, is refitted on the run itself, from one drive on to the next: nothing is told of how far the
//! model is off.
//!
//! Of the processes that are tried and of the model alone, that is taken which makes all that is observed most probable; under it, likewise,
//! the spread of the semantic residual. With a process there is no discrepancy of azimuths: what it would explain, the process does.

use super::refitted::{SPREAD, Tried, best_of, likeliest, with_spread};
use super::{Estimator, Learner, Learnt, Semantic, gain_a_crop, is_at_maximum};
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::{Lesson, PROCESSES, ProcessOdds};
use crate::settings::{SemanticSettings, Settings};
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

/// [`Semantic`] by the model, or by one of several processes beside it.
pub struct ProcessRefitted<'m> {
    settings: Settings,
    model: &'m dyn ObservationModel,
    processes: [&'m dyn ObservationModel; PROCESSES],
}

/// A way to read crops: by the model alone or the process of that number less 1, and with that factor of the residual's spread.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    process: usize,
    spread: f64,
}

impl Way {
    const TOLD: Self = Self { process: 0, spread: 1.0 };
}

impl<'m> ProcessRefitted<'m> {
    /// An estimator that reads crops by `model`, or by one of `processes`: models that correct it, whose latents begin with its own.
    pub fn new(
        settings: &Settings,
        model: &'m dyn ObservationModel,
        processes: [&'m dyn ObservationModel; PROCESSES],
    ) -> Self {
        Self { settings: *settings, model, processes }
    }

    /// The estimate, and the log-evidence of it, which is comparable between ways.
    fn by(&self, way: &Way, observations: &Observations) -> Result<Tried<Estimate>, EstimateError> {
        let semantics = with_spread(self.settings.semantics, way.spread);
        let (semantics, model) = match way.process.checked_sub(1) {
            None => (semantics, self.model),
            Some(process) => {
                (SemanticSettings { azimuth_discrepancy: None, ..semantics }, self.processes[process])
            }
        };
        let settings = Settings { semantics, ..self.settings };
        let (mut estimate, evidence) =
            Semantic::new(&settings, model).evidenced_among_models(observations)?;
        let latents = estimate.objects.iter_mut().flatten().filter_map(|object| object.latent.as_mut());
        latents.for_each(|latent| latent.truncate(self.model.latent_dim()));
        Ok((estimate, evidence))
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
        let by = |way: &Way| self.by(way, observations);
        let told = by(&Way::TOLD)?;
        let of_told = (told.0.clone(), told.1);
        let ways = std::array::from_fn::<_, { PROCESSES + 1 }, _>(|process| Way { process, ..Way::TOLD });
        let (way, best, process) = best_of(ways, told, &before.process.process, by)?;
        let (_, best, spread) =
            best_of(SPREAD.map(|spread| Way { spread, ..way }), best, &before.process.spread, by)?;

        let known = Way {
            process: likeliest(&before.process.process),
            spread: SPREAD[likeliest(&before.process.spread)],
        };
        let own = if known == Way::TOLD { (of_told.0.clone(), of_told.1) } else { by(&known)? };
        let gain = gain_a_crop((&own.0, own.1), (&of_told.0, of_told.1));
        let odds =
            if is_at_maximum(&best.0) { ProcessOdds { process, spread } } else { ProcessOdds::default() };
        let lesson = Lesson { process: before.process.after(&odds), ..before.clone() };
        Ok(Learnt { estimate: best.0, lesson, gain })
    }
}
