//! Input that no robot could have recorded is refused by name.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_spec};
use nalgebra::{DMatrix, DVector, Matrix6};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Seed, Viewpoint};
use vantage_slam::{
    EstimateError, EstimatorSpec, LatentGaussian, Linearization, MeasurementNoise, ModelError,
    ObservationModel, Row, estimate,
};

fn refused(spoil: impl FnOnce(&mut World)) -> EstimateError {
    let spec = WorldSpec::sparse_loop();
    let mut world = World::new(&spec, None, Seed(1));
    spoil(&mut world);
    estimate(&world.observations, Row::Geometric, None, &matching_spec(&spec)).unwrap_err()
}

#[test]
fn bad_observations() {
    let detection = |e| matches!(e, EstimateError::Detection { index: 3, .. });
    assert!(detection(refused(|w| w.observations.detections[3].step = 60)));
    assert!(detection(refused(|w| w.observations.detections[3].track = usize::MAX)));
    assert!(detection(refused(|w| w.observations.detections[3].bounding_box.min.x = f64::NAN)));
    assert!(detection(refused(|w| {
        let bounds = &mut w.observations.detections[3].bounding_box;
        std::mem::swap(&mut bounds.min, &mut bounds.max);
    })));
    let odometry = |e| matches!(e, EstimateError::Odometry { index: 5, .. });
    assert!(odometry(refused(|w| w.observations.odometry[5].to = 60)));
    assert!(odometry(refused(|w| w.observations.odometry[5].to = 5)));
    assert!(odometry(refused(|w| w.observations.odometry[5].covariance = Matrix6::zeros())));
    assert!(odometry(refused(|w| w.observations.odometry[5].covariance[(2, 2)] = f64::NAN)));
    assert!(odometry(refused(|w| w.observations.odometry[5].robot_from_robot.translation.x = f64::INFINITY)));
    let camera = |e| matches!(e, EstimateError::Camera { .. });
    assert!(camera(refused(|w| w.observations.camera.fx = 0.0)));
    assert!(camera(refused(|w| w.observations.robot_from_camera.translation.y = f64::NAN)));
}

#[test]
fn bad_settings_and_a_missing_model() {
    let spec = WorldSpec::sparse_loop();
    let world = World::new(&spec, None, Seed(1));
    let settings = EstimatorSpec { tilt_sigma: f64::NAN, ..matching_spec(&spec) };
    let error = estimate(&world.observations, Row::Geometric, None, &settings).unwrap_err();
    assert!(error.to_string().contains("tilt_sigma"), "{error}");
    for row in [Row::ViewpointDependent, Row::Uninformative] {
        let error = estimate(&world.observations, row, None, &matching_spec(&spec)).unwrap_err();
        assert_eq!(error, EstimateError::ModelMissing { row });
    }
}

/// A model that claims other dimensions than it answers with.
struct Misfit {
    inner: TanhModel,
    claimed: [usize; 2],
    noise: MeasurementNoise,
}

impl ObservationModel for Misfit {
    fn latent_dim(&self) -> usize {
        self.claimed[0]
    }
    fn measurement_dim(&self) -> usize {
        self.claimed[1]
    }
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        self.inner.measure(crop)
    }
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        self.inner.encode(crop, viewpoint)
    }
    fn predict(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<DVector<f64>, ModelError> {
        self.inner.predict(latent, x)
    }
    fn linearize(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Linearization, ModelError> {
        self.inner.linearize(latent, x)
    }
    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }
}

#[test]
fn a_model_that_does_not_fit_itself() {
    let spec = WorldSpec::sparse_loop();
    let inner = TanhModel::new([8, 12, 16], 0.1, 5.0, Seed(1));
    let world = World::new(&spec, Some(&inner), Seed(1));
    for (claimed, noise_dim) in [([9, 12], 12), ([8, 11], 11), ([8, 12], 11)] {
        let inner = TanhModel::new([8, 12, 16], 0.1, 5.0, Seed(1));
        let noise = MeasurementNoise::new(DMatrix::identity(noise_dim, noise_dim), 5.0, 1.0).unwrap();
        let model = Misfit { inner, claimed, noise };
        let error =
            estimate(&world.observations, Row::ViewpointDependent, Some(&model), &matching_spec(&spec))
                .unwrap_err();
        assert!(matches!(error, EstimateError::Model(ModelError::Shape { .. })), "{claimed:?}: {error}");
    }
}
