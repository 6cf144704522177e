//! What viewpoints are worth in a scene: ATE with an ideal sensor of the azimuth from which an object is seen, of known,
//! independent Gaussian noise, in place of the learned model, on validation objects. Where a sharp sensor gains nothing, a
//! model has little to gain; it may gain more than a sensor as sharp, as crops also tell elevation, roll and distance.
//!
//! `cargo run --release -p vantage-eval --example headroom -- scenes/sparse_loop.yaml 30`
//!
//! Columns: the sensor's noise, degrees; mean ATE, metres; its paired difference to `geometric` and half the 95%
//! interval.

mod support;

use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;
use std::error::Error;
use support::{Episode, arguments, columns, scored, validation_episodes};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Seed, Viewpoint};
use vantage_model::{
    AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel, ViewpointDerivative,
};
use vantage_slam::{Estimator, Geometric, Semantic, SemanticSettings, Settings};

const DEGREES: [f64; 4] = [2.0, 5.0, 10.0, 20.0];

/// Cosine and sine of the azimuth, measured; a latent of one number that says nothing.
struct AzimuthSensor {
    noise: MeasurementNoise,
    by_crop: HashMap<Vec<u8>, DVector<f64>>,
}

impl AzimuthSensor {
    fn new(Episode { observations, truth }: &Episode, sigma: f64) -> Self {
        let world = truth.objects.first().map_or(0, |object| object.instance.0);
        let mut stream = Seed(world).stream("azimuth sensor", 0);
        let mut by_crop = HashMap::new();
        for detection in &observations.detections {
            let object = &truth.objects[detection.track];
            let world_from_camera = truth.world_from_robot[detection.step] * observations.robot_from_camera;
            let object_from_camera = object.world_from_object.inv_mul(&world_from_camera);
            if let Some(viewpoint) = Viewpoint::new(&object_from_camera, object.size) {
                let azimuth = viewpoint.azimuth() + sigma * stream.normal();
                let (sin, cos) = azimuth.sin_cos();
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

fn main() -> Result<(), Box<dyn Error>> {
    let (pipeline, count) = arguments()?;
    let episodes = validation_episodes(&pipeline, count)?;
    // Its noise is independent and known: every view counts, and counts in full.
    let told = pipeline.file.estimator.settings();
    let semantics =
        SemanticSettings { information_scale: 1.0, minimum_view_separation: 0.0, ..told.semantics };
    let settings = Settings { semantics, ..told };
    let errors = |answers: Vec<(_, f64)>| answers.into_iter().map(|(_, error)| error).collect::<Vec<_>>();
    let geometric = Geometric::new(&settings);
    let geometric = errors(scored(&episodes, |episode| geometric.estimate(&episode.observations))?);
    println!("sigma     ATE  difference  half width");
    println!("    -  {}", columns(&geometric, &geometric));
    for degrees in DEGREES {
        let answers = scored(&episodes, |episode| {
            let sensor = AzimuthSensor::new(episode, degrees.to_radians());
            Semantic::new(&settings, &sensor).estimate(&episode.observations)
        })?;
        println!("{degrees:5}  {}", columns(&errors(answers), &geometric));
    }
    Ok(())
}
