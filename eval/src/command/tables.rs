//! Answers and truth -> the tables of a scene.

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
/// The tables, and what they are of.
pub struct Tables {
    /// `trajectory` where there are episodes, and those of unseen instances.
    pub tables: Vec<Table>,
    /// Detections of objects in all episodes.
    pub detections: usize,
}

/// Scores every answer against the truth of its episode.
pub fn tables(
    rows: &[Row],
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
                let of_objects = |detection: &&Detection| detection.track < truth.objects.len();
                detections +=
                    read_observations(&episode.folder)?.detections.iter().filter(of_objects).count();
                Some(truth)
            }
            Err(_) => None,
        };
        for answer in answers {
            let method = row_name(answer.row, semantic).to_owned();
            let (outcome, scores) = (answer.outcome.clone(), scores(answer, truth.as_ref(), heading)?);
            runs.push(Run { method, seed: *seed, outcome, scores });
        }
    }
    let methods: Vec<&str> = rows.iter().map(|&row| row_name(row, semantic)).collect();
    let reference = rows.contains(&Row::Geometric).then_some(Row::Geometric.name());
    let mut tables = Vec::new();
    if !episodes.is_empty() {
        tables.push(Table::new("trajectory", &methods, reference, &TRAJECTORY, seeds, runs)?);
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
        (_, Some(Objective::DiscreteClass)) => "discrete_class",
        (Kind::ViewpointPredictive, _) => "viewpoint_predictive",
        _ => Row::ViewpointDependent.name(),
    }
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
        let relative = rpe(&pairs);
        let values = [
            ate(&pairs),
            ate_umeyama(&pairs),
            heading_error(&pairs),
            relative.translation,
            relative.rotation,
            objects.center,
            objects.orientation.filter(|_| heading || !answer.row.is_semantic()),
        ];
        scores
            .extend(TRAJECTORY.into_iter().zip(values).filter_map(|(metric, value)| Some((metric, value?))));
    }
    Ok(scores)
}
