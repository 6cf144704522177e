//! Answers and truth -> the tables of a scene.

use crate::exit::BenchError;
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
use vantage_dataset::{Seed, Truth};
use vantage_learn::Kind;
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
    /// `trajectory`, and those of unseen instances.
    pub tables: Vec<Table>,
    /// Detections in all episodes.
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
    let kind = model.model.inner().manifest().kind;
    let mut runs = Vec::new();
    let mut detections = 0;
    for ((seed, episode), (_, answers)) in episodes.iter().zip(answers) {
        let truth = match episode {
            Ok(episode) => {
                detections += read_observations(&episode.folder)?.detections.len();
                let truth = read_truth(&episode.folder)?;
                model.check_unseen(truth.objects.iter().map(|object| object.instance))?;
                Some(truth)
            }
            Err(_) => None,
        };
        for answer in answers {
            let method = row_name(answer.row, kind).to_owned();
            let (outcome, scores) = (answer.outcome.clone(), scores(answer, truth.as_ref())?);
            runs.push(Run { method, seed: *seed, outcome, scores });
        }
    }
    let methods: Vec<&str> = rows.iter().map(|&row| row_name(row, kind)).collect();
    let reference = rows.contains(&Row::Geometric).then_some(Row::Geometric.name());
    let trajectory = Table::new("trajectory", &methods, reference, &TRAJECTORY, seeds, runs)?;
    let mut tables = vec![trajectory];
    for table in &TABLES {
        let of = |seed: &Unseen| seed.runs.get(table.name).cloned().unwrap_or_default();
        tables.push(table.of(
            row_name(Row::ViewpointDependent, kind),
            seeds,
            unseen.iter().flat_map(of).collect(),
        )?);
    }
    Ok(Tables { tables, detections })
}

/// The semantic row is named by the model.
pub fn row_name(row: Row, kind: Kind) -> &'static str {
    match (row, kind) {
        (Row::ViewpointDependent, Kind::ViewpointPredictive) => "viewpoint_predictive",
        (row, _) => row.name(),
    }
}

fn scores(answer: &Answer, truth: Option<&Truth>) -> Result<BTreeMap<Metric, f64>, BenchError> {
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
            objects.orientation,
        ];
        scores
            .extend(TRAJECTORY.into_iter().zip(values).filter_map(|(metric, value)| Some((metric, value?))));
    }
    Ok(scores)
}
