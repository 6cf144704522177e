//! What an estimator refuses to start from.

use crate::association::AssociationError;
use crate::noise::sqrt_information;
use crate::odometry_bias::OdometryBias;
use crate::settings::OdometrySettings;
use garde::Validate;
use vantage_dataset::Observations;
use vantage_dataset::se3::is_finite;
use vantage_model::{AnswerError, ObservationModel};

/// Tracks above this are taken for corrupt, not for that many objects.
const MOST_TRACKS: usize = 1_000_000;

/// Why there is no estimate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EstimateError {
    /// A setting is out of range.
    #[error("estimator settings: {report}")]
    Spec {
        /// Every field that is wrong, and how.
        report: String,
    },
    /// The model failed for a reason other than a number that is not finite.
    #[error("observation model: {0}")]
    Model(#[from] AnswerError),
    /// The camera's intrinsics or mount are not usable.
    #[error("camera: got {got}, expected finite numbers and positive focal lengths")]
    Camera {
        /// The camera, or its mount.
        got: String,
    },
    /// An odometry measurement is not usable.
    #[error("odometry {index}: {problem}")]
    Odometry {
        /// Its index in the observations.
        index: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// The bias that is to be a variable leaves nothing of the covariance of an odometry measurement.
    #[error(
        "odometry {index}: the bias leaves nothing of its covariance; got {} m/m and {} deg/m, expected deviations whose share of the error that the robot is told leaves some white noise: lower the larger of `odometry_bias`", bias.translation_per_metre, bias.rotation_deg_per_metre
    )]
    Bias {
        /// Its index in the observations.
        index: usize,
        /// The bias.
        bias: OdometryBias,
    },
    /// A sighting of a landmark is not usable.
    #[error("landmark sighting {index}: {problem}")]
    Landmark {
        /// Its index in the observations.
        index: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// No odometry reaches a step from an earlier one, which an estimator that goes step by step needs.
    #[error(
        "odometry: got none to step {step} from an earlier one, expected at least one: estimate the whole episode at once, or add a motion of large covariance"
    )]
    Unreached {
        /// The step.
        step: usize,
    },
    /// The posterior after a step is not a Gaussian: some of its equations are not numbers.
    #[error(
        "step {step}: the normal equations are not positive definite, expected finite observations of scales that a double tells apart"
    )]
    Indefinite {
        /// The step.
        step: usize,
    },
    /// Who is who cannot be told any further.
    #[error("step {step}: {error}")]
    Association {
        /// The step.
        step: usize,
        /// Why.
        error: AssociationError,
    },
    /// A detection is not usable.
    #[error("detection {index}: {problem}")]
    Detection {
        /// Its index in the observations.
        index: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
}

/// Checks a group of settings.
pub fn check_settings(settings: &impl Validate<Context = ()>) -> Result<(), EstimateError> {
    settings.validate().map_err(|report| EstimateError::Spec { report: report.to_string() })
}

/// Checks all of the observations that an estimator relies on, under settings that are in range.
pub fn check_observations(
    observations: &Observations,
    settings: &OdometrySettings,
) -> Result<(), EstimateError> {
    check_camera(observations)?;
    check_odometry(observations, settings)?;
    check_detections(observations)?;
    check_landmarks(observations)
}

/// Checks that a model's noise is that of its measurement.
pub fn check_model(model: &dyn ObservationModel) -> Result<(), AnswerError> {
    let (got, expected) = (model.noise().dimension(), model.measurement_dim());
    if got == expected {
        Ok(())
    } else {
        Err(AnswerError::Shape { what: "square root of the information (rows)", got, expected })
    }
}

fn check_camera(observations: &Observations) -> Result<(), EstimateError> {
    let camera = observations.camera;
    let usable = [camera.fx, camera.fy].iter().all(|f| f.is_finite() && *f > 0.0)
        && camera.cx.is_finite()
        && camera.cy.is_finite();
    if !usable {
        return Err(EstimateError::Camera { got: format!("{camera:?}") });
    }
    if !is_finite(&observations.robot_from_camera) {
        return Err(EstimateError::Camera {
            got: format!("robot_from_camera {:?}", observations.robot_from_camera),
        });
    }
    Ok(())
}

fn check_odometry(observations: &Observations, settings: &OdometrySettings) -> Result<(), EstimateError> {
    let steps = observations.steps();
    for (index, odometry) in observations.odometry.iter().enumerate() {
        let (from, to) = (odometry.from, odometry.to);
        let problem = if from >= steps || to >= steps || from == to {
            format!("got steps {from} to {to}, expected two different steps below {steps}")
        } else if !is_finite(&odometry.robot_from_robot) {
            format!("got motion {:?}, expected finite numbers", odometry.robot_from_robot)
        } else if sqrt_information(&odometry.covariance).is_none() {
            format!("got covariance {}, expected a positive definite matrix", odometry.covariance)
        } else if let Some(bias) = settings.bias.filter(|_| settings.sqrt_information(odometry).is_none()) {
            return Err(EstimateError::Bias { index, bias });
        } else {
            continue;
        };
        return Err(EstimateError::Odometry { index, problem });
    }
    Ok(())
}

fn check_detections(observations: &Observations) -> Result<(), EstimateError> {
    let steps = observations.steps();
    for (index, detection) in observations.detections.iter().enumerate() {
        let bounds = detection.bounding_box;
        let positive = bounds.min.x < bounds.max.x && bounds.min.y < bounds.max.y;
        let problem = if detection.step >= steps {
            format!("got step {}, expected one below {steps}", detection.step)
        } else if detection.track >= MOST_TRACKS {
            format!("got track {}, expected one below {MOST_TRACKS}", detection.track)
        } else if !(positive && bounds.side().is_finite() && bounds.center().iter().all(|c| c.is_finite())) {
            format!("got box {bounds:?}, expected finite edges and a positive area")
        } else if detection
            .center_depth
            .is_some_and(|depth| ![depth.meters, depth.sigma].iter().all(|x| x.is_finite() && *x > 0.0))
        {
            format!("got {:?}, expected positive, finite metres", detection.center_depth)
        } else {
            continue;
        };
        return Err(EstimateError::Detection { index, problem });
    }
    Ok(())
}

fn check_landmarks(observations: &Observations) -> Result<(), EstimateError> {
    let steps = observations.steps();
    for (index, sighting) in observations.landmarks.iter().enumerate() {
        let problem = if sighting.step >= steps {
            format!("got step {}, expected one below {steps}", sighting.step)
        } else if !sighting.pixel.iter().all(|x| x.is_finite()) {
            format!("got pixel {}, {}, expected finite numbers", sighting.pixel.x, sighting.pixel.y)
        } else if !(sighting.sigma.is_finite() && sighting.sigma > 0.0) {
            format!("got sigma {}, expected a positive, finite number of pixels", sighting.sigma)
        } else {
            continue;
        };
        return Err(EstimateError::Landmark { index, problem });
    }
    Ok(())
}
