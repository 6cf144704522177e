//! Input that no robot could have recorded is refused by name.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::{DMatrix, DVector, Matrix6, Vector2};
use vantage_dataset::{CenterDepth, Crop, LandmarkSighting, Seed, Viewpoint};
use vantage_model::{AnswerError, LatentGaussian, Linearization, MeasurementNoise, ObservationModel};
use vantage_slam::{EstimateError, Settings};

fn refused(spoil: impl FnOnce(&mut World)) -> EstimateError {
    let spec = WorldSpec::sparse_loop();
    let mut world = World::new(&spec, None, Seed(1));
    spoil(&mut world);
    estimate(&world.observations, Which::Geometric, None, &matching_settings(&spec)).unwrap_err()
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
    for [meters, sigma] in [[0.0, 0.1], [-1.0, 0.1], [f64::NAN, 0.1], [1.0, 0.0], [1.0, f64::INFINITY]] {
        let depth = Some(CenterDepth { meters, sigma });
        assert!(detection(refused(|w| w.observations.detections[3].center_depth = depth)));
    }
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
fn bad_sightings_of_landmarks() {
    let told = |spoil: &dyn Fn(&mut LandmarkSighting)| {
        let error = refused(|world| {
            let pixel = Vector2::new(10.0, 20.0);
            let good = LandmarkSighting { step: 3, landmark: usize::MAX, pixel, sigma: 1.0 };
            let mut bad = good;
            spoil(&mut bad);
            world.observations.landmarks = vec![good, bad];
        });
        assert!(matches!(error, EstimateError::Landmark { index: 1, .. }), "{error}");
        error.to_string()
    };
    assert!(told(&|s| s.step = 60).contains("expected one below 60"));
    assert!(told(&|s| s.pixel.y = f64::NAN).contains("pixel 10, NaN"));
    for sigma in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(told(&|s| s.sigma = sigma).contains("positive, finite number of pixels"));
    }
}

#[test]
fn bad_settings() {
    let spec = WorldSpec::sparse_loop();
    let world = World::new(&spec, None, Seed(1));
    let model = TanhModel::new([4, 6, 8], 0.03, 5.0, Seed(1));
    let told = |which, spoil: &dyn Fn(&mut Settings)| {
        let mut settings = matching_settings(&spec);
        spoil(&mut settings);
        estimate(&world.observations, which, Some(&model), &settings).unwrap_err().to_string()
    };
    for which in [Which::Semantic, Which::Uninformative] {
        let error = told(which, &|settings| settings.semantics.tilt_sigma = f64::NAN);
        assert!(error.contains("tilt_sigma"), "{error}");
    }
    for which in Which::ALL {
        let error = told(which, &|settings| settings.solver.tolerance = 0.0);
        assert!(error.contains("tolerance"), "{error}");
    }
    let error = told(Which::Geometric, &|settings| settings.geometry.minimum_parallax = -1.0);
    assert!(error.contains("minimum_parallax"), "{error}");
    let error = told(Which::Semantic, &|settings| settings.orientation.yaw_candidates = 0);
    assert!(error.contains("yaw_candidates"), "{error}");
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
    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.inner.measure(crop)
    }
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        self.inner.encode(crop, viewpoint)
    }
    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        self.inner.predict(latent, viewpoint)
    }
    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        self.inner.linearize(latent, viewpoint)
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
        let noise = MeasurementNoise::new(DMatrix::identity(noise_dim, noise_dim), 5.0).unwrap();
        let model = Misfit { inner, claimed, noise };
        let error = estimate(&world.observations, Which::Semantic, Some(&model), &matching_settings(&spec))
            .unwrap_err();
        assert!(matches!(error, EstimateError::Model(AnswerError::Shape { .. })), "{claimed:?}: {error}");
    }
}
