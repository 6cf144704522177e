//! Answers and truth -> the tables of a scene.

use super::entry::Entry;
use crate::error::BenchError;
use crate::metric::Metric;
use crate::pipeline::{Answer, LoadedModel, SeedEpisode, TABLES, Unseen};
use crate::score::ate::{ate, ate_umeyama};
use crate::score::heading::heading_error;
use crate::score::object::object_errors;
use crate::score::pairs::Pairs;
use crate::score::rpe::rpe;
use crate::table::{Outcome, Run, Table};
use std::collections::BTreeMap;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Detection, Seed, Truth};
use vantage_learn::{Kind, Manifest as ModelManifest, Objective};
use vantage_slam::Row;

const TRAJECTORY: [Metric; 7] = [
    Metric::Ate,
    Metric::AteUmeyama,
    Metric::Heading,
    Metric::RpeTranslation,
    Metric::RpeRotation,
    Metric::ObjectCenter,
    Metric::ObjectOrientation,
];
/// The semantic row's name with a model of discrete classes.
const DISCRETE_CLASS: &str = "discrete_class";
/// The semantic row's name with a viewpoint-predictive model.
const VIEWPOINT_PREDICTIVE: &str = "viewpoint_predictive";
/// The name of the table of trajectories.
pub const TRAJECTORIES: &str = "trajectory";
/// The name of the true trajectory among those of a seed.
pub const TRUTH: &str = "truth";

/// The tables, and what they are of.
pub struct Tables {
    /// `trajectory` where there are episodes, and those of unseen instances.
    pub tables: Vec<Table>,
    /// Detections of objects in all episodes.
    pub detections: usize,
}

/// Scores every answer, and every entry's trajectory, against the truth of its episode.
pub fn tables(
    rows: &[Row],
    entries: &[Entry],
    seeds: &[Seed],
    episodes: &[SeedEpisode],
    answers: &[(Seed, Vec<Answer>)],
    unseen: &[Unseen],
    model: &LoadedModel,
) -> Result<Tables, BenchError> {
    let manifest = model.model.inner().manifest();
    let semantic = semantic_row(manifest);
    let heading = manifest.kind == Kind::ViewpointDependent;
    let mut runs = Vec::new();
    let mut detections = 0;
    for ((seed, episode), (_, answers)) in episodes.iter().zip(answers) {
        let truth = match episode {
            Ok(episode) => {
                let truth = read_truth(&episode.folder)?;
                let observations = read_observations(&episode.folder)?;
                let of_objects = |detection: &&Detection| detection.track < truth.objects.len();
                detections += observations.detections.iter().filter(of_objects).count();
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
        for answer in answers {
            let method = row_name(answer.row, semantic).to_owned();
            let (outcome, scores) = (answer.outcome.clone(), scores(answer, truth.as_ref(), heading)?);
            runs.push(Run { method, seed: *seed, outcome, scores });
        }
    }
    let ours = rows.iter().map(|&row| row_name(row, semantic));
    let methods: Vec<&str> = ours.chain(entries.iter().map(|entry| entry.name.as_str())).collect();
    let reference = rows.contains(&Row::Geometric).then_some(Row::Geometric.name());
    let mut tables = Vec::new();
    if !episodes.is_empty() {
        tables.push(Table::new(TRAJECTORIES, &methods, reference, &TRAJECTORY, seeds, runs)?);
    }
    for table in &TABLES {
        let of = |seed: &Unseen| seed.runs.get(table.name).cloned().unwrap_or_default();
        tables.push(table.of(semantic, seeds, unseen.iter().flat_map(of).collect())?);
    }
    Ok(Tables { tables, detections })
}

/// The name of the semantic row, which is the model's.
pub fn semantic_row(manifest: &ModelManifest) -> &'static str {
    let trained = manifest.training.details.as_ref().map(|details| details.spec.objective);
    match (manifest.kind, trained) {
        (_, Some(Objective::DiscreteClass)) => DISCRETE_CLASS,
        (Kind::ViewpointPredictive, _) => VIEWPOINT_PREDICTIVE,
        _ => Row::ViewpointDependent.name(),
    }
}

/// Names that no other estimator may have: all that rows of ours can have, and that of the truth's file.
pub fn taken_names() -> Vec<&'static str> {
    Row::ALL.map(Row::name).into_iter().chain([DISCRETE_CLASS, VIEWPOINT_PREDICTIVE, TRUTH]).collect()
}

/// The name of a row, given that of the semantic one.
pub fn row_name(row: Row, semantic: &'static str) -> &'static str {
    if row == Row::ViewpointDependent { semantic } else { row.name() }
}

/// The scores of an answer; without the orientation of objects where the model knows no `heading` that they share with the truth, as
/// a viewpoint-predictive one.
fn scores(
    answer: &Answer,
    truth: Option<&Truth>,
    heading: bool,
) -> Result<BTreeMap<Metric, f64>, BenchError> {
    let mut scores = BTreeMap::new();
    if let (Some(truth), false) = (truth, matches!(answer.outcome, Outcome::Failed(_))) {
        let pairs = Pairs::by_step(&truth.world_from_robot, &answer.world_from_robot)?;
        let objects = object_errors(&pairs, &truth.objects, &answer.scored_objects(truth.objects.len()));
        let orientation = objects.orientation.filter(|_| heading || !answer.row.is_semantic());
        scores.extend(of_poses(&pairs));
        scores.extend(objects.center.map(|error| (Metric::ObjectCenter, error)));
        scores.extend(orientation.map(|error| (Metric::ObjectOrientation, error)));
    }
    Ok(scores)
}

/// An entry on a seed.
fn entered(entry: &Entry, seed: Seed, timestamps: &[f64], truth: &Truth) -> Result<Run, BenchError> {
    let poses = match entry.run(seed, timestamps) {
        Ok(poses) => poses,
        Err(reason) => return Ok(failed(entry, seed, reason)),
    };
    let scores = of_poses(&Pairs::by_step(&truth.world_from_robot, &poses)?);
    Ok(Run { method: entry.name.clone(), seed, outcome: Outcome::Done, scores })
}

fn failed(entry: &Entry, seed: Seed, reason: String) -> Run {
    Run { method: entry.name.clone(), seed, outcome: Outcome::Failed(reason), scores: BTreeMap::new() }
}

/// The scores of the robot's poses.
fn of_poses(pairs: &Pairs) -> BTreeMap<Metric, f64> {
    let relative = rpe(pairs);
    let values = [
        (Metric::Ate, ate(pairs)),
        (Metric::AteUmeyama, ate_umeyama(pairs)),
        (Metric::Heading, heading_error(pairs)),
        (Metric::RpeTranslation, relative.translation),
        (Metric::RpeRotation, relative.rotation),
    ];
    values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect()
}
