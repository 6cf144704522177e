//! Stage `tables`: answers and truth -> the tables of a scene.

use super::found::{Finding, Found};
use super::taken_for::ari;
use super::{
    Answer, LoadedModel, Method, SeedAnswers, SeedEpisode, SeedOnline, StageError, StoredObject, beliefs,
};
use crate::result::metric::Metric;
use crate::result::run::{Outcome, Run};
use crate::result::table::{Table, TableError};
use crate::scene_file::row::Row;
use crate::score::azimuth::{SeenSide, azimuth_error};
use crate::score::consistency::{self, CONSISTENCY, COVERAGE, ObjectGaussian};
use crate::score::embedding::Scores;
use crate::score::entry::Entry;
use crate::score::extents::{Ellipsoid, extents_error};
use crate::score::landmark::landmark_error;
use crate::score::online::{self, Driven, ONLINE, online_scores};
use crate::score::pairs::Pairs;
use crate::score::trajectory_scores::{TRAJECTORIES, TRAJECTORY, object_scores, pose_scores};
use crate::score::unseen::Unseen;
use crate::score::unseen_table::{TABLES, UnseenTable};
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Detection, Observations, Seed, Truth};

/// The tables, and what they are of.
pub struct Tables {
    /// `trajectory`, `consistency`, `coverage` and, where a row has latents or classes, `semantics` where there are episodes; and those of unseen instances where there are
    /// any.
    pub tables: Vec<Table>,
    /// Detections of objects in all episodes.
    pub detections: usize,
}

/// Scores every answer, and every entry's trajectory, against the truth of its episode.
pub fn tables(
    seeds: &[Seed],
    methods: &[Method<'_>],
    entries: &[Entry],
    episodes: &[SeedEpisode],
    answers: &[SeedAnswers],
    models: &[LoadedModel],
    unseen: &[Vec<Unseen>],
) -> Result<Tables, StageError> {
    let (mut runs, mut consistent) = (Vec::new(), Vec::new());
    let mut left = Vec::new();
    let mut detections = 0;
    let mut columns = TRAJECTORY.to_vec();
    let stored = answers.iter().flat_map(|(_, answers)| answers).flat_map(|answer| &answer.objects);
    if stored.flatten().any(|object| object.extents.is_some()) {
        columns.push(Metric::Extents);
    }
    for ((seed, episode), (_, answers)) in episodes.iter().zip(answers) {
        let truth = match episode {
            Ok(episode) => {
                let truth = read_truth(&episode.folder)?;
                let observations = read_observations(&episode.folder)?;
                let shown = |(number, detection): (usize, &Detection)| truth.shown(number, detection);
                if !truth.landmarks.is_empty() && !columns.contains(&Metric::Landmark) {
                    columns.push(Metric::Landmark);
                }
                detections += observations.detections.iter().enumerate().filter_map(shown).count();
                for entry in entries {
                    runs.push(entered(entry, *seed, &observations.timestamps, &truth)?);
                }
                Some(truth)
            }
            Err(reason) => {
                runs.extend(entries.iter().map(|entry| failed(entry, *seed, reason.clone())));
                None
            }
        };
        for (method, answer) in methods.iter().zip(answers) {
            let manifest = method.model.model.manifest();
            let run =
                |scores| Run { method: method.name(), seed: *seed, outcome: answer.outcome.clone(), scores };
            let heading = method.model.shares_frames();
            let Scored { trajectory, consistency } = scores(answer, truth.as_ref(), heading)?;
            let objects = truth.as_ref().map_or(&[][..], |truth| &truth.objects);
            let names =
                method.model.readouts.as_ref().map_or(&[][..], |(readouts, _)| readouts.classes.names());
            left.push((run(Scores::new()), beliefs::of(answer, objects, manifest.latent, names)));
            runs.push(run(trajectory));
            consistent.push(run(consistency));
        }
    }
    let reference = methods.iter().find(|method| method.row == Row::Geometric).map(Method::name);
    let own: Vec<String> = methods.iter().map(Method::name).collect();
    let own: Vec<&str> = own.iter().map(String::as_str).collect();
    let names: Vec<&str> = own.iter().copied().chain(entries.iter().map(|entry| &*entry.name)).collect();
    let mut tables = Vec::new();
    if !episodes.is_empty() {
        tables.push(Table::new(TRAJECTORIES, &names, reference.as_deref(), &columns, seeds, runs)?);
        for (name, columns) in [(CONSISTENCY, &consistency::COLUMNS[..]), (COVERAGE, &consistency::INSIDE)] {
            let of_columns = |run: &Run| {
                let scores = run.scores.iter().filter(|(metric, _)| columns.contains(metric));
                Run { scores: scores.map(|(&metric, &score)| (metric, score)).collect(), ..run.clone() }
            };
            let runs = consistent.iter().map(of_columns).collect();
            tables.push(Table::new(name, &own, None, columns, seeds, runs)?);
        }
        tables.extend(beliefs::table(&own, seeds, left)?);
    }
    let unseen: Vec<(&str, &[Unseen])> =
        models.iter().map(|model| model.name.as_str()).zip(unseen.iter().map(Vec::as_slice)).collect();
    for table in TABLES.iter().filter(|_| unseen.iter().any(|(_, unseen)| !unseen.is_empty())) {
        tables.push(of_unseen(table, seeds, &unseen)?);
    }
    Ok(Tables { tables, detections })
}

/// The runs of trajectories alone, with those of their scores that are in `columns`; by what was `found`, where episodes do not tell who is
/// who.
pub fn trajectory_runs(
    methods: &[Method<'_>],
    episodes: &[SeedEpisode],
    answers: &[SeedAnswers],
    found: Option<&[Finding]>,
    columns: &[Metric],
) -> Result<Vec<Run>, StageError> {
    let mut runs = Vec::new();
    for (index, ((seed, episode), (_, answers))) in episodes.iter().zip(answers).enumerate() {
        let truth = episode.as_ref().ok().map(|episode| read_truth(&episode.folder)).transpose()?;
        let found = found.and_then(|found| found[index].as_ref().ok()).map(Found::likeliest);
        let sides = match (episode, &truth) {
            (Ok(episode), Some(truth)) if columns.contains(&Metric::Azimuth) => {
                let observations = read_observations(&episode.folder)?;
                Some(Sides { views: seen_views(&observations, truth, found), truth, observations })
            }
            _ => None,
        };
        let ari = found.and(sides.as_ref()).and_then(|sides| ari(&sides.views));
        for (method, answer) in methods.iter().zip(answers) {
            let Scored { mut trajectory, consistency } = scores(answer, truth.as_ref(), false)?;
            trajectory.extend(consistency);
            let azimuth = sides.as_ref().and_then(|sides| sides.azimuth_error(answer));
            trajectory.extend(azimuth.map(|azimuth| (Metric::Azimuth, azimuth)));
            trajectory.extend(answer.gain.map(|gain| (Metric::PrequentialGain, gain)));
            trajectory.extend(ari.map(|ari| (Metric::Ari, ari)));
            trajectory.retain(|metric, _| columns.contains(metric));
            let outcome = answer.outcome.clone();
            runs.push(Run { method: method.name(), seed: *seed, outcome, scores: trajectory });
        }
    }
    Ok(runs)
}

/// The views of objects on an episode.
struct Sides<'t> {
    truth: &'t Truth,
    observations: Observations,
    views: Vec<SeenSide>,
}

/// The views that show an object, with what each was taken for: by what was `found`, or else what it shows.
fn seen_views(observations: &Observations, truth: &Truth, found: Option<&[Option<usize>]>) -> Vec<SeenSide> {
    let view = |(number, detection): (usize, &Detection)| {
        truth.shown(number, detection)?;
        let (step, object) = (detection.step, detection.track);
        Some(SeenSide { step, object, taken_for: found.map_or(Some(object), |found| found[number]) })
    };
    observations.detections.iter().enumerate().filter_map(view).collect()
}

impl Sides<'_> {
    /// How far an answer is off in the azimuths from which objects were seen.
    fn azimuth_error(&self, answer: &Answer) -> Option<f64> {
        if matches!(answer.outcome, Outcome::Failed(_)) {
            return None;
        }
        let centers: Vec<_> =
            answer.objects.iter().map(|object| object.as_ref().map(|object| object.position)).collect();
        let mount = &self.observations.robot_from_camera;
        azimuth_error(
            &self.views,
            &self.truth.objects,
            (&self.truth.world_from_robot, mount),
            (&answer.world_from_robot, &centers),
        )
    }
}

/// The table of estimates after every step, of the methods that have them, beside `answers` by whole episodes.
pub fn online_table(
    seeds: &[Seed],
    methods: &[Method<'_>],
    episodes: &[SeedEpisode],
    answers: &[SeedAnswers],
    online: &[SeedOnline],
) -> Result<Option<Table>, StageError> {
    let mut runs = Vec::new();
    for (((seed, episode), (_, answers)), (_, online)) in episodes.iter().zip(answers).zip(online) {
        let truth = episode.as_ref().ok().map(|episode| read_truth(&episode.folder)).transpose()?;
        for ((method, answer), online) in methods.iter().zip(answers).zip(online) {
            let Some(driven) = online else { continue };
            let (outcome, scores) = match (driven, &truth) {
                (Err(reason), _) => (Outcome::Failed(reason.clone()), Scores::new()),
                (Ok(_), None) => continue,
                (Ok(run), Some(truth)) => {
                    let driven = Driven {
                        newest: &run.newest,
                        covariances: run.covariances.as_deref(),
                        at_end: &run.at_end,
                        settled: &run.settled,
                        whole: &answer.world_from_robot,
                    };
                    (Outcome::Done, online_scores(&truth.world_from_robot, &driven)?)
                }
            };
            runs.push(Run { method: method.name(), seed: *seed, outcome, scores });
        }
    }
    let has_runs = |name: &String| runs.iter().any(|run: &Run| run.method == *name);
    let names: Vec<String> = methods.iter().map(Method::name).filter(has_runs).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let columns = online::COLUMNS;
    (!names.is_empty()).then(|| Ok(Table::new(ONLINE, &names, None, &columns, seeds, runs)?)).transpose()
}

/// A table of some models, each with its name and what it is worth on the instances of each seed.
fn of_unseen(table: &UnseenTable, seeds: &[Seed], models: &[(&str, &[Unseen])]) -> Result<Table, TableError> {
    let run = |method: &str, &seed: &Seed, scores: Option<&Scores>| Run {
        method: method.to_owned(),
        seed,
        outcome: Outcome::Done,
        scores: scores.cloned().unwrap_or_default(),
    };
    let mut runs = Vec::new();
    for (name, unseen) in models {
        let scored = seeds.iter().zip(*unseen);
        runs.extend(scored.map(|(seed, on)| run(name, seed, on.model.get(table.name))));
    }
    // A floor knows no model: that beside the first is that beside all.
    if let (Some(floor), Some((_, unseen))) = (table.floor(), models.first()) {
        let scored = seeds.iter().zip(*unseen);
        runs.extend(scored.map(|(seed, on)| run(floor, seed, on.floor.get(table.name))));
    }
    let names: Vec<&str> = models.iter().map(|(name, _)| *name).chain(table.floor()).collect();
    Table::new(table.name, &names, table.floor(), table.metrics(), seeds, runs)
}

/// The scores of an answer in each table that has a row for every estimator.
#[derive(Default)]
struct Scored {
    trajectory: Scores,
    consistency: Scores,
}

/// Scores an answer; without the orientation of objects where the model knows no `heading` that they share with the truth, as
/// a viewpoint-predictive one.
fn scores(answer: &Answer, truth: Option<&Truth>, heading: bool) -> Result<Scored, StageError> {
    let (Some(truth), false) = (truth, matches!(answer.outcome, Outcome::Failed(_))) else {
        return Ok(Scored::default());
    };
    let pairs = Pairs::by_step(&truth.world_from_robot, &answer.world_from_robot)?;
    let mut trajectory = pose_scores(&pairs);
    let objects = answer.scored_objects(truth.objects.len());
    trajectory.extend(object_scores(&pairs, &truth.objects, &objects, heading));
    let landmarks = answer.landmarks.iter().map(|(&number, landmark)| (number, landmark.position));
    let off = landmark_error(&pairs, &truth.landmarks, landmarks);
    trajectory.extend(off.map(|off| (Metric::Landmark, off)));
    let ellipsoid = |object: &StoredObject| {
        let world_from_axes = object.rotation.unwrap_or_default();
        Some(Ellipsoid { world_from_axes, semi_axes: object.extents? })
    };
    let ellipsoids = answer.objects.iter().map(|object| object.as_ref().and_then(ellipsoid));
    let off = extents_error(&pairs, &truth.objects, ellipsoids);
    trajectory.extend(off.map(|off| (Metric::Extents, off)));
    let mut consistency = consistency::pose_scores(&pairs, answer.pose_covariances.as_deref());
    let gaussian = |object: &StoredObject| ObjectGaussian {
        center_in_world: object.position,
        center_covariance: object.position_covariance,
        rotation: object.rotation,
        rotation_covariance: object.rotation_covariance,
    };
    let gaussians: Vec<_> = answer.objects.iter().map(|object| object.as_ref().map(gaussian)).collect();
    consistency.extend(consistency::object_scores(&pairs, &truth.objects, &gaussians, heading));
    Ok(Scored { trajectory, consistency })
}

/// An entry on a seed.
fn entered(entry: &Entry, seed: Seed, timestamps: &[f64], truth: &Truth) -> Result<Run, StageError> {
    let poses = match entry.run(seed, timestamps) {
        Ok(poses) => poses,
        Err(reason) => return Ok(failed(entry, seed, reason)),
    };
    let scores = pose_scores(&Pairs::by_step(&truth.world_from_robot, &poses)?);
    Ok(Run { method: entry.name.clone(), seed, outcome: Outcome::Done, scores })
}

fn failed(entry: &Entry, seed: Seed, reason: String) -> Run {
    Run { method: entry.name.clone(), seed, outcome: Outcome::Failed(reason), scores: Scores::new() }
}
