//! `bench headroom SCENE [N]`: what viewpoints are worth in a scene.
//!
//! ATE with an ideal sensor of the azimuth from which an object is seen, of known, independent Gaussian noise, in place of
//! the learned model. Where a sharp sensor gains nothing, a model has little to gain; it may gain more than a sensor as
//! sharp, as crops also tell elevation, roll and distance.
//!
//! Beside it, how often bearings make an episode worse than odometry alone: by chance they do so even where odometry and boxes are drawn
//! from the very distributions that the estimator assumes.

use super::assumed::as_assumed;
use super::{Trial, columns, estimated, open, print, trials};
use crate::command::cli::ValidationArgs;
use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::pipeline::{AzimuthSensor, Pipeline};
use crate::scene_file::row::of_an_ideal_sensor;
use std::io::Write;
use vantage_slam::{Estimate, Estimator, Geometric, OdometryOnly, Semantic, Settings};

const DEGREES: [f64; 4] = [2.0, 5.0, 10.0, 20.0];

/// Prints the ATE by the sensor's noise, and its paired difference to `geometric`; and what bearings are worth.
pub fn headroom(args: &ValidationArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let pipeline = open(args)?;
    let trials = trials(&pipeline, args)?;
    let settings = of_an_ideal_sensor(&pipeline.file.estimator.settings());
    bearings(&pipeline, &trials, &settings, stdout)?;
    let geometric = Geometric::new(&settings);
    let geometric = errors(estimated(&pipeline, &trials, |trial| geometric.estimate(&trial.observations))?);
    let mut rows = vec![("geometric".to_owned(), columns(&geometric, &geometric))];
    for degrees in DEGREES {
        let answers = estimated(&pipeline, &trials, |trial| {
            let sensor = AzimuthSensor::new(&trial.observations, &trial.truth, degrees.to_radians());
            Semantic::new(&settings, &sensor).estimate(&trial.observations)
        })?;
        rows.push((degrees.to_string(), columns(&errors(answers), &geometric)));
    }
    let rows = rows.into_iter().map(|(name, columns)| std::iter::once(name).chain(columns).collect());
    print(stdout, &["Sensor's noise [deg]", "ATE [m]", "Difference [m]", "+- 95% [m]"], rows.collect())?;
    Ok(Exit::Success)
}

fn errors(answers: Vec<(Estimate, f64)>) -> Vec<f64> {
    answers.into_iter().map(|(_, error)| error).collect()
}

/// Prints how often bearings are worse than odometry alone, as measured and as the estimator assumes them.
fn bearings(
    pipeline: &Pipeline,
    trials: &[Trial],
    settings: &Settings,
    stdout: &mut impl Write,
) -> Result<(), BenchError> {
    let (odometry, geometric) = (OdometryOnly::new(settings), Geometric::new(settings));
    let mut rows = Vec::new();
    for (name, drawn) in [("as measured", false), ("as assumed", true)] {
        let read = |trial: &Trial| match drawn {
            true => as_assumed(trial, settings),
            false => trial.observations.clone(),
        };
        let odometry = errors(estimated(pipeline, trials, |trial| odometry.estimate(&read(trial)))?);
        let geometric = errors(estimated(pipeline, trials, |trial| geometric.estimate(&read(trial)))?);
        let worse =
            odometry.iter().zip(&geometric).filter(|(odometry, geometric)| geometric > odometry).count();
        let [of_odometry, ..] = columns(&odometry, &odometry);
        let [of_geometric, ..] = columns(&geometric, &geometric);
        let share = format!("{worse} of {}", geometric.len());
        rows.push(vec![name.to_owned(), of_odometry, of_geometric, share]);
    }
    print(stdout, &["Odometry and boxes", "Odometry [m]", "Geometric [m]", "Worse than odometry"], rows)
}
