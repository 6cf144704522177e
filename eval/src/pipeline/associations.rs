//! Stage `associations`: who is who by every associator, where the estimator is told less than all, and what that makes of the trajectory.
//!
//! What our associators make of a seed is cached, times included.

use super::associating::{Answered, Associating, of_nobody};
use super::estimates::{PANICKED, with_objects};
use super::{EpisodeFolder, Method, Pipeline, SeedEpisode, StageError, code};
use crate::result::metric::Metric;
use crate::result::run::{Outcome, Run};
use crate::result::table::Table;
use crate::scene_file::associator::{AssociatedBy, AssociatorRow, Told};
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
use vantage_dataset::{Observations, Seed, Truth};
use vantage_slam::{Association, EstimateError, Settings};

/// The row of the association that estimators are given otherwise.
pub const GIVEN: &str = "given";

const FILE: &str = "associations.json";

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
    let own = own_rows().map(|row| row.to_string());
    let others = entries.iter().map(|entry| entry.name.clone());
    std::iter::once(GIVEN.to_owned()).chain(own).chain(others).collect()
}

fn own_rows() -> impl Iterator<Item = AssociatedBy> {
    Told::ALL.into_iter().flat_map(|told| AssociatorRow::ALL.map(|by| AssociatedBy { told, by }))
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
    let associating = methods.first().map(|method| Associating::new(pipeline, method.model)).transpose()?;
    let associating = associating.as_ref();
    let mut answers = Vec::with_capacity(episodes.len());
    for (seed, episode) in episodes {
        let of_seed = match episode {
            Ok(episode) => {
                let models = methods.iter().map(|method| method.model.model.hash()).collect();
                let identity = match associating {
                    Some(associating) => associating.identity(models),
                    None => of_nobody(pipeline, models),
                };
                let key = Key::new("associations", &(code::ASSOCIATED, &episode.seal, identity))?;
                let given = OnceCell::new();
                let mut of_seed: Vec<Result<Associated, String>> = pipeline.cache.json(&key, FILE, || {
                    let given = Given::once(&given, *seed, episode)?;
                    let instances = || given.truth.objects.iter().map(|object| object.instance);
                    associating.iter().try_for_each(|by| by.check_unseen(instances()))?;
                    given.own(pipeline, associating, methods)
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
        associating: Option<&Associating<'_>>,
        methods: &[Method<'_>],
    ) -> Result<Vec<Result<Associated, String>>, StageError> {
        let mut answered = vec![self.scored(self.oracle(), true)];
        for row in own_rows() {
            answered.push(match associating {
                Some(associating) => self.scored(associating.ask(row, &self.observations)?, true),
                None => Err("no row of a model".to_owned()),
            });
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
        let association = answered.answer.as_ref().map_err(String::clone)?;
        let (tracklets, order) = (&answered.tracklets, &answered.order);
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
        let of_hypotheses = truth.of_hypotheses(association);
        scores.extend(of_hypotheses.into_iter().filter(|(metric, _)| weighs || *metric == Metric::AllRight));
        scores.extend(relocation_scores(
            &self.observations,
            &self.truth.world_from_robot,
            &association.places,
        ));
        let objects = canonical(answered.of_detections(told).into_iter());
        Ok(Associated { objects, times: association.times.clone(), scores })
    }

    /// ATE of the rows by what was associated; why there is none where an estimator panicked.
    fn errors(
        &self,
        settings: &Settings,
        methods: &[Method<'_>],
        objects: &[Option<usize>],
    ) -> Result<Result<Scores, String>, StageError> {
        let observations = with_objects(&self.observations, objects);
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
