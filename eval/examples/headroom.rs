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
use vantage_slam::{
    EstimatorSpec, LatentGaussian, Linearization, MeasurementNoise, ModelError, ObservationModel, Row,
    estimate,
};

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
        let noise = MeasurementNoise::new(information, f64::INFINITY, 1.0).expect("sigma is positive");
        Self { noise, by_crop }
    }
}

impl ObservationModel for AzimuthSensor {
    fn latent_dim(&self) -> usize {
        1
    }

    fn measurement_dim(&self) -> usize {
        2
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        self.by_crop.get(&crop.0[..]).cloned().ok_or(ModelError::NonFinite { what: "azimuth" })
    }

    fn encode(&self, _: &Crop, _: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        Ok(LatentGaussian::prior(1))
    }

    fn predict(&self, _: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<DVector<f64>, ModelError> {
        Ok(DVector::from_column_slice(&x[..2]))
    }

    fn linearize(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Linearization, ModelError> {
        Ok(Linearization {
            mean: self.predict(latent, x)?,
            d_latent: DMatrix::zeros(2, 1),
            d_conditioning: DMatrix::identity(2, CONDITIONING),
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
    let spec = EstimatorSpec {
        semantic_information_scale: 1.0,
        minimum_view_separation: 0.0,
        ..pipeline.file.estimator.clone()
    };
    let errors = |row: Row, degrees: f64| -> Result<Vec<f64>, Box<dyn Error>> {
        let answers = scored(&episodes, |episode| {
            let sensor = AzimuthSensor::new(episode, degrees.to_radians());
            estimate(&episode.observations, row, Some(&sensor), &spec)
        })?;
        Ok(answers.into_iter().map(|(_, error)| error).collect())
    };
    let geometric = errors(Row::Geometric, 1.0)?;
    println!("sigma     ATE  difference  half width");
    println!("    -  {}", columns(&geometric, &geometric));
    for degrees in DEGREES {
        println!("{degrees:5}  {}", columns(&errors(Row::ViewpointDependent, degrees)?, &geometric));
    }
    Ok(())
}
