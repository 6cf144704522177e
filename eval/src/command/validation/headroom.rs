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
use crate::pipeline::Pipeline;
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;
use std::io::Write;
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Seed, Viewpoint};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, ViewpointDerivative,
};
use vantage_slam::{Estimate, Estimator, Geometric, OdometryOnly, Semantic, SemanticSettings, Settings};

const DEGREES: [f64; 4] = [2.0, 5.0, 10.0, 20.0];

/// Prints the ATE by the sensor's noise, and its paired difference to `geometric`; and what bearings are worth.
pub fn headroom(args: &ValidationArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let pipeline = open(args)?;
    let trials = trials(&pipeline, args)?;
    // Its noise is independent and known: every view counts, and counts in full.
    let told = pipeline.file.estimator.settings();
    let semantics = SemanticSettings {
        information_scale: 1.0,
        minimum_view_separation: 0.0,
        azimuth_discrepancy: None,
        unknown_margin: None,
        ..told.semantics
    };
    let settings = Settings { semantics, ..told };
    bearings(&pipeline, &trials, &settings, stdout)?;
    let geometric = Geometric::new(&settings);
    let geometric = errors(estimated(&pipeline, &trials, |trial| geometric.estimate(&trial.observations))?);
    let mut rows = vec![("geometric".to_owned(), columns(&geometric, &geometric))];
    for degrees in DEGREES {
        let answers = estimated(&pipeline, &trials, |trial| {
            let sensor = AzimuthSensor::new(trial, degrees.to_radians());
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

/// Cosine and sine of the azimuth, measured; a latent of one number that says nothing.
struct AzimuthSensor {
    noise: MeasurementNoise,
    by_crop: HashMap<Vec<u8>, DVector<f64>>,
}

impl AzimuthSensor {
    fn new(Trial { observations, truth }: &Trial, sigma: f64) -> Self {
        let world = truth.objects.first().map_or(0, |object| object.instance.0);
        let mut stream = Seed(world).stream("azimuth sensor", 0);
        let mut by_crop = HashMap::new();
        for detection in &observations.detections {
            // What the detector sees where there is nothing has no azimuth.
            let Some(object) = truth.objects.get(detection.track) else { continue };
            let world_from_camera = truth.world_from_robot[detection.step] * observations.robot_from_camera;
            let object_from_camera = object.world_from_object.inv_mul(&world_from_camera);
            if let Some(viewpoint) = Viewpoint::new(&object_from_camera, object.size) {
                let azimuth = viewpoint.azimuth() + sigma * stream.normal();
                let (sin, cos) = libm::sincos(azimuth);
                by_crop.insert(detection.masked_crop.0.to_vec(), DVector::from_vec(vec![cos, sin]));
            }
        }
        let information = DMatrix::identity(2, 2) / sigma;
        let noise = MeasurementNoise::new(information, f64::INFINITY).expect("sigma is positive");
        Self { noise, by_crop }
    }
}

impl ObservationModel for AzimuthSensor {
    fn latent_dim(&self) -> usize {
        1
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.by_crop.get(&crop.0[..]).cloned().ok_or(AnswerError::NonFinite { what: "azimuth" })
    }

    fn encode(&self, _: &Crop, _: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        Ok(LatentGaussian::prior(1))
    }

    fn predict(&self, _: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(DVector::from_column_slice(&viewpoint.conditioning()[..2]))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        Ok(Linearization {
            mean: self.predict(latent, viewpoint)?,
            d_latent: DMatrix::zeros(2, 1),
            d_viewpoint: ViewpointDerivative::new(DMatrix::identity(2, CONDITIONING)),
        })
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }
}
