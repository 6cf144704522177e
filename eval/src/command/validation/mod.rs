//! Episodes to try settings on: *validation* objects, and seeds far from those of any scene's evaluation.

mod assumed;
mod boxes;
mod calibrate;
pub mod error;
mod evidence;
mod headroom;
mod hyperparameters;
mod likeness;
mod offset_fit;
mod told_evidence;

pub use calibrate::calibrate;
pub use headroom::headroom;

use super::cli::ValidationArgs;
use super::error::BenchError;
use crate::pipeline::{Pipeline, StageError, episodes};
use crate::result::grid::{Style, draw};
use crate::result::metric::Metric;
use crate::result::statistics::Mean;
use crate::score::ate::ate;
use crate::score::pairs::Pairs;
use error::ValidationError;
use rayon::prelude::*;
use std::io::Write;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Observations, Seed, Split, Truth};
use vantage_slam::{Estimate, EstimateError};

const FIRST_SEED: u64 = 1_000_000;

/// An episode with its truth.
struct Trial {
    observations: Observations,
    truth: Truth,
}

/// Opens a scene whose robot drives.
fn open(args: &ValidationArgs) -> Result<Pipeline, BenchError> {
    let pipeline = Pipeline::open(&args.scene, &args.making.cache, args.making.renderer.into())?;
    pipeline.file.check_simulated(&args.scene)?;
    match pipeline.drives() {
        true => Ok(pipeline),
        false => Err(ValidationError::Undriven { scene: args.scene.clone() }.into()),
    }
}

/// Simulates the episodes, or takes them from the cache; a seed without a world is told of and left out.
fn trials(pipeline: &Pipeline, args: &ValidationArgs) -> Result<Vec<Trial>, BenchError> {
    let seeds: Vec<Seed> = (0..args.episodes).map(|i| Seed(FIRST_SEED + i)).collect();
    let mut trials = Vec::new();
    for (seed, episode) in episodes(pipeline, &seeds, Split::Validation)? {
        match episode {
            Err(reason) => pipeline.progress.note(&format!("seed {} is left out: {reason}", seed.0)),
            Ok(episode) => {
                let observations = read_observations(&episode.folder)?;
                trials.push(Trial { observations, truth: read_truth(&episode.folder)? });
            }
        }
    }
    let seen = |Trial { observations, truth }: &Trial| {
        let mut detections = observations.detections.iter().enumerate();
        detections.any(|(number, detection)| truth.shown(number, detection).is_some())
    };
    match trials.iter().any(seen) {
        true => Ok(trials),
        false => Err(ValidationError::NothingSeen { scene: args.scene.clone() }.into()),
    }
}

/// Each trial's estimate and its ATE in metres, trials in parallel.
fn estimated(
    pipeline: &Pipeline,
    trials: &[Trial],
    estimate: impl Fn(&Trial) -> Result<Estimate, EstimateError> + Sync,
) -> Result<Vec<(Estimate, f64)>, StageError> {
    let stage = pipeline.progress.stage("estimates", trials.len() as u64);
    let one = |trial: &Trial| -> Result<(Estimate, f64), StageError> {
        let answer = estimate(trial)?;
        let pairs = Pairs::by_step(&trial.truth.world_from_robot, &answer.world_from_robot)?;
        stage.advance(1);
        Ok((answer, ate(&pairs).unwrap_or(f64::NAN)))
    };
    trials.par_iter().map(one).collect()
}

/// The mean of errors, their mean difference to a reference, and half the 95% interval of that, as tables print them.
fn columns(errors: &[f64], reference: &[f64]) -> [String; 3] {
    let differences: Vec<f64> = errors.iter().zip(reference).map(|(a, b)| a - b).collect();
    let mean = |values: &[f64]| Mean::of(values).map(|mean| mean.mean);
    let half = Mean::of(&differences).and_then(|mean| mean.half_width);
    [mean(errors), mean(&differences), half].map(|value| Metric::Ate.display(value.unwrap_or(f64::NAN)))
}

/// Prints a table of trials.
fn print(stdout: &mut impl Write, head: &[&str], rows: Vec<Vec<String>>) -> Result<(), BenchError> {
    let head: Vec<String> = head.iter().map(|&name| name.to_owned()).collect();
    Ok(writeln!(stdout, "{}", draw(Style::terminal(), &head, rows))?)
}
