//! Stage `associations`: who is who by every associator, where the estimator is told less than all, and what that makes of the trajectory.
//!
//! What our associators make of a seed is cached, times included.

use super::associator_row::{AssociatorRow, Looks, Told};
use super::embedding::embedding;
use super::estimates::PANICKED;
use super::readouts::readouts;
use super::{EpisodeFolder, Method, Pipeline, SeedEpisode, StageError, code};
use crate::result::metric::Metric;
use crate::result::run::{Outcome, Run};
use crate::result::table::Table;
use crate::scene_file::estimator::EstimatorSpec;
use crate::scene_file::row::Row;
use crate::score::association::{ASSOCIATION, COLUMNS, TrueTracklets, canonical};
use crate::score::association_entry::AssociationEntry;
use crate::score::ate::ate;
use crate::score::embedding::Scores;
use crate::score::pairs::Pairs;
use crate::score::relocation::{self, relocation_scores};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;
use vantage_dataset::store::{Key, read_observations, read_truth};
use vantage_dataset::{Detection, Observations, Seed, Tracklets, Truth};
use vantage_sim::scene::DetectorSpec;
use vantage_slam::{Association, EstimateError, Settings};

/// The row of the association that estimators are given otherwise.
pub const GIVEN: &str = "given";

const FILE: &str = "associations.json";

#[derive(Serialize)]
struct Inputs<'a> {
    code: &'static str,
    episode: &'a str,
    models: Vec<&'a str>,
    /// What identifies the views that the read-outs are fitted on.
    readouts: Option<&'a str>,
    /// What identifies the embedding.
    embedding: &'a [String],
    spec: &'a EstimatorSpec,
    detector: &'a DetectorSpec,
}

/// What a row made of an episode.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Associated {
    /// Of each detection, in the order of the episode's, its object, numbered as they come; none of one that is of nothing.
    pub objects: Vec<Option<usize>>,
    /// How long each step took.
    pub times: Vec<Duration>,
    scores: Scores,
}

/// The answers on a seed, in the order of [`association_rows`].
pub type SeedAssociations = (Seed, Vec<Result<Associated, String>>);

/// The names of the rows: that of the oracle, those of the associators by what they are told, and those of `entries`.
pub fn association_rows(entries: &[AssociationEntry]) -> Vec<String> {
    let own = Told::ALL.iter().flat_map(|told| AssociatorRow::ALL.map(|row| format!("{told}-{row}")));
    let others = entries.iter().map(|entry| entry.name.clone());
    std::iter::once(GIVEN.to_owned()).chain(own).chain(others).collect()
}

/// All rows on all seeds: associators one after the other, since their times are told; estimates by them in parallel.
pub fn associations(
    pipeline: &Pipeline,
    episodes: &[SeedEpisode],
    methods: &[Method<'_>],
    entries: &[AssociationEntry],
) -> Result<Vec<SeedAssociations>, StageError> {
    for (seed, episode) in episodes.iter().filter_map(|(seed, episode)| Some((seed, episode.as_ref().ok()?)))
    {
        let detections = read_observations(&episode.folder)?.detections.len();
        entries.iter().try_for_each(|entry| entry.fits(*seed, detections))?;
    }
    let stage = pipeline.progress.stage("associations", episodes.len() as u64);
    let own = association_rows(&[]).len();
    let reader = methods
        .first()
        .map(|method| Ok::<_, StageError>((method.model, readouts(pipeline, &method.model.model)?)));
    let reader = reader.transpose()?;
    let embedding = reader.is_some().then(|| embedding(pipeline)).transpose()?;
    let looks = reader.as_ref().zip(embedding.as_ref()).map(|((model, (readouts, _)), embedding)| Looks {
        model: model.viewing(),
        readouts,
        embedding: embedding.readout(),
    });
    let embedded_by = embedding.as_ref().map_or(&[] as &[_], |embedding| &embedding.identity);
    let fitted_on = reader.as_ref().map(|(_, (_, seal))| seal.as_str());
    let mut answers = Vec::with_capacity(episodes.len());
    for (seed, episode) in episodes {
        let of_seed = match episode {
            Ok(episode) => {
                let key = key(pipeline, episode, methods, (fitted_on, embedded_by))?;
                let given = OnceCell::new();
                let mut of_seed: Vec<Result<Associated, String>> = pipeline.cache.json(&key, FILE, || {
                    let given = Given::once(&given, *seed, episode)?;
                    let instances = || given.truth.objects.iter().map(|object| object.instance);
                    embedding.iter().try_for_each(|embedding| embedding.check_unseen(instances()))?;
                    given.own(pipeline, looks, methods)
                })?;
                if !entries.is_empty() {
                    of_seed.extend(Given::once(&given, *seed, episode)?.others(pipeline, methods, entries)?);
                }
                of_seed
            }
            Err(reason) => vec![Err(reason.clone()); own + entries.len()],
        };
        answers.push((*seed, of_seed));
        stage.advance(1);
    }
    Ok(answers)
}

fn key(
    pipeline: &Pipeline,
    episode: &EpisodeFolder,
    methods: &[Method<'_>],
    (readouts, embedding): (Option<&str>, &[String]),
) -> Result<Key, StageError> {
    Ok(Key::new(
        "associations",
        &Inputs {
            code: code::ASSOCIATED,
            episode: &episode.seal,
            models: methods.iter().map(|method| method.model.model.hash()).collect(),
            readouts,
            embedding,
            spec: &pipeline.file.estimator,
            detector: &pipeline.file.sensors.detector,
        },
    )?)
}

/// The table of associations; none where there are no episodes.
pub fn association_table(
    seeds: &[Seed],
    entries: &[AssociationEntry],
    answers: &[SeedAssociations],
) -> Result<Option<Table>, StageError> {
    if answers.is_empty() {
        return Ok(None);
    }
    let names = association_rows(entries);
    let mut runs = Vec::new();
    for (seed, of_seed) in answers {
        for (method, answer) in names.iter().zip(of_seed) {
            let (outcome, scores) = match answer {
                Ok(associated) => (Outcome::Done, associated.scores.clone()),
                Err(reason) => (Outcome::Failed(reason.clone()), Scores::new()),
            };
            runs.push(Run { method: method.clone(), seed: *seed, outcome, scores });
        }
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let is_carried = runs.iter().any(|run| run.scores.contains_key(&Metric::Resolved));
    let of_carried = if is_carried { relocation::COLUMNS.as_slice() } else { &[] };
    let columns = [COLUMNS.as_slice(), of_carried].concat();
    Ok(Some(Table::new(ASSOCIATION, &names, None, &columns, seeds, runs)?))
}

/// An episode.
struct Given {
    seed: Seed,
    observations: Observations,
    truth: Truth,
}

/// Tracklets, of each detection its number among the episode's, and what somebody makes of them.
struct Answered {
    tracklets: Tracklets,
    order: Vec<usize>,
    answer: Result<Association, String>,
}

impl Given {
    /// What is read where it is needed first.
    fn once<'g>(
        given: &'g OnceCell<Self>,
        seed: Seed,
        episode: &EpisodeFolder,
    ) -> Result<&'g Self, StageError> {
        if let Some(given) = given.get() {
            return Ok(given);
        }
        let observations = read_observations(&episode.folder)?;
        let truth = read_truth(&episode.folder)?;
        Ok(given.get_or_init(|| Self { seed, observations, truth }))
    }

    /// The oracle and our associators.
    fn own(
        &self,
        pipeline: &Pipeline,
        looks: Option<Looks<'_>>,
        methods: &[Method<'_>],
    ) -> Result<Vec<Result<Associated, String>>, StageError> {
        let mut answered = vec![self.scored(self.oracle(), true)];
        for told in Told::ALL {
            for row in AssociatorRow::ALL {
                answered.push(self.scored(self.answer(pipeline, looks, told, row)?, true));
            }
        }
        self.estimated(pipeline, methods, answered)
    }

    fn others(
        &self,
        pipeline: &Pipeline,
        methods: &[Method<'_>],
        entries: &[AssociationEntry],
    ) -> Result<Vec<Result<Associated, String>>, StageError> {
        let answered = entries.iter().map(|entry| self.scored(self.entered(entry), false));
        self.estimated(pipeline, methods, answered.collect())
    }

    /// With the errors of trajectories by each answer. Most rows agree: each way to tell who is who is estimated by once.
    fn estimated(
        &self,
        pipeline: &Pipeline,
        methods: &[Method<'_>],
        mut scored: Vec<Result<Associated, String>>,
    ) -> Result<Vec<Result<Associated, String>>, StageError> {
        let settings = pipeline.file.estimator.settings();
        let told: BTreeSet<Vec<Option<usize>>> =
            scored.iter().flatten().map(|associated| associated.objects.clone()).collect();
        let errors: BTreeMap<Vec<Option<usize>>, Result<Scores, String>> = told
            .into_par_iter()
            .map(|objects| {
                let errors = self.errors(&settings, methods, &objects)?;
                Ok((objects, errors))
            })
            .collect::<Result<_, StageError>>()?;
        for answer in &mut scored {
            let Ok(associated) = answer else { continue };
            match &errors[&associated.objects] {
                Ok(errors) => associated.scores.extend(errors.clone()),
                Err(reason) => *answer = Err(reason.clone()),
            }
        }
        Ok(scored)
    }

    /// What estimators are told otherwise.
    fn oracle(&self) -> Answered {
        let (tracklets, order) = Told::Tracklets.of(&self.observations);
        let mut objects = vec![None; tracklets.count()];
        for (detection, &number) in tracklets.observations().detections.iter().zip(&order) {
            objects[detection.track] = Some(self.observations.detections[number].track);
        }
        Answered { tracklets, order, answer: Ok(Association::certain(objects)) }
    }

    fn answer(
        &self,
        pipeline: &Pipeline,
        looks: Option<Looks<'_>>,
        told: Told,
        row: AssociatorRow,
    ) -> Result<Answered, StageError> {
        let (tracklets, order) = told.of(&self.observations);
        let settings = pipeline.file.estimator.settings();
        let Some(looks) = looks else {
            return Ok(Answered { tracklets, order, answer: Err("no row of a model".to_owned()) });
        };
        let detector = &pipeline.file.sensors.detector;
        let Some(associator) = row.associator((told, &self.observations), &settings, detector, looks) else {
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

    /// Each detection is a tracklet of an entry, which tells the object of each.
    fn entered(&self, entry: &AssociationEntry) -> Answered {
        let (tracklets, order) = Told::None.of(&self.observations);
        let told = entry.run(self.seed, self.observations.detections.len());
        let answer = told.map(|told| {
            let mut objects = vec![None; tracklets.count()];
            for (detection, &number) in tracklets.observations().detections.iter().zip(&order) {
                objects[detection.track] = told[number];
            }
            Association::certain(objects)
        });
        Answered { tracklets, order, answer }
    }

    /// The scores of an answer; those of weights where it `weighs`.
    fn scored(&self, answered: Answered, weighs: bool) -> Result<Associated, String> {
        let Answered { tracklets, order, answer } = answered;
        let association = answer?;
        let seen = tracklets.observations();
        let shown = |number: &usize| {
            let detection = &self.observations.detections[*number];
            let object = self.truth.shown(*number, detection).map(|_| detection.track);
            object.filter(|track| *track < self.truth.objects.len())
        };
        let mut is_whole = vec![false; tracklets.count()];
        for detection in &seen.detections {
            is_whole[detection.track] |= !detection.bounding_box.is_truncated(&seen.camera);
        }
        let truth = TrueTracklets {
            tracklets: seen.detections.iter().map(|detection| detection.track).collect(),
            shown: order.iter().map(shown).collect(),
            is_whole,
        };
        let told = association.objects();
        let mut scores = truth.scores(told);
        let of_hypotheses = truth.of_hypotheses(&association);
        scores.extend(of_hypotheses.into_iter().filter(|(metric, _)| weighs || *metric == Metric::AllRight));
        scores.extend(relocation_scores(
            &self.observations,
            &self.truth.world_from_robot,
            &association.places,
        ));
        let mut objects = vec![None; order.len()];
        for (detection, &number) in seen.detections.iter().zip(&order) {
            objects[number] = told[detection.track];
        }
        Ok(Associated { objects: canonical(objects.into_iter()), times: association.times, scores })
    }

    /// ATE of the rows by what was associated; why there is none where an estimator panicked.
    fn errors(
        &self,
        settings: &Settings,
        methods: &[Method<'_>],
        objects: &[Option<usize>],
    ) -> Result<Result<Scores, String>, StageError> {
        let detections = self.observations.detections.iter().zip(objects);
        let mut detections: Vec<Detection> = detections
            .filter_map(|(detection, object)| Some(Detection { track: (*object)?, ..detection.clone() }))
            .collect();
        detections.sort_by_key(|detection| (detection.step, detection.track));
        let observations = Observations { detections, ..self.observations.clone() };
        let mut scores = Scores::new();
        for (metric, row) in [
            (Metric::AteOfGeometric, methods.iter().find(|method| method.row == Row::Geometric)),
            (Metric::AteOfLearned, methods.iter().find(|method| method.row.is_of_model())),
        ] {
            let Some(row) = row else { continue };
            match self.error(settings, row, &observations)? {
                Ok(error) => scores.extend(error.map(|error| (metric, error))),
                Err(reason) => return Ok(Err(reason)),
            }
        }
        Ok(Ok(scores))
    }

    /// ATE of a row; none where it has no answer.
    fn error(
        &self,
        settings: &Settings,
        method: &Method<'_>,
        observations: &Observations,
    ) -> Result<Result<Option<f64>, String>, StageError> {
        let estimator = method.row.estimator(settings, method.model.reader());
        let estimate = match catch_unwind(AssertUnwindSafe(|| estimator.estimate(observations))) {
            Ok(Ok(estimate)) => estimate,
            Ok(Err(EstimateError::Model(_))) => return Ok(Ok(None)),
            Ok(Err(error)) => return Err(error.into()),
            Err(_) => return Ok(Err(PANICKED.to_owned())),
        };
        let pairs = Pairs::by_step(&self.truth.world_from_robot, &estimate.world_from_robot)?;
        Ok(Ok(ate(&pairs)))
    }
}
