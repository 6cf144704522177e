//! Stage `tables`: answers and truth -> the tables of a scene.

use super::{Answer, LoadedModel, Pipeline, SeedAnswers, SeedEpisode, StageError};
use crate::result::row_name::{row_name, semantic_row};
use crate::result::table::{Outcome, Run, Table};
use crate::score::embedding::Scores;
use crate::score::entry::Entry;
use crate::score::pairs::Pairs;
use crate::score::trajectory_scores::{TRAJECTORIES, TRAJECTORY, object_scores, pose_scores};
use crate::score::unseen::Unseen;
use crate::score::unseen_table::TABLES;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Detection, Seed, Truth};
use vantage_learn::Kind;
use vantage_slam::Row;

/// The tables, and what they are of.
pub struct Tables {
    /// `trajectory` where there are episodes, and those of unseen instances.
    pub tables: Vec<Table>,
    /// Detections of objects in all episodes.
    pub detections: usize,
}

/// Scores every answer, and every entry's trajectory, against the truth of its episode.
pub fn tables(
    pipeline: &Pipeline,
    seeds: &[Seed],
    entries: &[Entry],
    episodes: &[SeedEpisode],
    answers: &[SeedAnswers],
    unseen: &[Unseen],
    model: &LoadedModel,
) -> Result<Tables, StageError> {
    let rows = &pipeline.file.estimator.rows;
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

/// The scores of an answer; without the orientation of objects where the model knows no `heading` that they share with the truth, as
/// a viewpoint-predictive one.
fn scores(answer: &Answer, truth: Option<&Truth>, heading: bool) -> Result<Scores, StageError> {
    let (Some(truth), false) = (truth, matches!(answer.outcome, Outcome::Failed(_))) else {
        return Ok(Scores::new());
    };
    let pairs = Pairs::by_step(&truth.world_from_robot, &answer.world_from_robot)?;
    let mut scores = pose_scores(&pairs);
    let oriented = heading || !answer.row.is_semantic();
    scores.extend(object_scores(
        &pairs,
        &truth.objects,
        &answer.scored_objects(truth.objects.len()),
        oriented,
    ));
    Ok(scores)
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
