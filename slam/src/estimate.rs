//! What an estimator answers.

use crate::solve::Outcome;
use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use vantage_dataset::Pose;
use vantage_model::LatentGaussian;

/// The posterior of one episode: its maximum, and marginals where asked for.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// How it ended. Whatever the outcome, poses, positions and covariances are finite and worth scoring.
    pub outcome: Outcome,
    /// X: the robot's pose at each step, in the frame of its first pose.
    pub world_from_robot: Vec<Pose>,
    /// Covariance of the right perturbation of each robot pose, rotation first; `None` where not asked for
    /// or not defined.
    pub pose_covariances: Option<Vec<Matrix6<f64>>>,
    /// O and E by track; `None` for a track without detections and for the unresolved ones.
    pub objects: Vec<Option<ObjectEstimate>>,
    /// Tracks that were seen and yet could not be placed, in order.
    pub unresolved: Vec<Unresolved>,
    /// L by number: the landmarks that could be placed. Empty of odometry alone.
    pub landmarks: BTreeMap<usize, LandmarkEstimate>,
    /// Landmarks that were seen and yet could not be placed, in order.
    pub unresolved_landmarks: Vec<UnresolvedLandmark>,
    /// Linearisations of the last problem over all variables, from all of its starts.
    pub iterations: usize,
    /// Negative log-posterior, nats up to a constant; comparable only between answers of one estimator to one episode. Not a
    /// number where the outcome is [`Outcome::Diverged`] from the start.
    pub cost: f64,
    /// Detections and sightings of landmarks that were not used, or not fully.
    pub dropped_detections: Dropped,
}

/// One object.
#[derive(Clone, Debug)]
pub struct ObjectEstimate {
    /// Its centre in the world, metres.
    pub position: Vector3<f64>,
    /// Covariance of the position, world axes; `None` where not asked for or not defined.
    pub position_covariance: Option<Matrix3<f64>>,
    /// Its diameter from box and distance, metres; `None` where no view told.
    pub size: Option<f64>,
    /// Semi-axes, metres, of an ellipsoid along its axes, or of one of revolution about the world's vertical where it has no
    /// orientation; `None` where objects are centres alone.
    pub extents: Option<Vector3<f64>>,
    /// Its orientation, of estimators with semantic factors and objects with semantic views.
    pub orientation: Option<Orientation>,
    /// P(e | H): mean at the maximum, marginal variances; as for the orientation.
    pub latent: Option<LatentGaussian>,
    /// P(c | H) of each class, of an estimator by discrete classes.
    pub classes: Option<Vec<f64>>,
    /// Bearings used.
    pub bearings: usize,
    /// Semantic measurements used.
    pub semantic_views: usize,
}

/// One point landmark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandmarkEstimate {
    /// Where it is in the world, metres.
    pub position: Vector3<f64>,
    /// Covariance of the position, world axes; `None` where not asked for or not defined.
    pub covariance: Option<Matrix3<f64>>,
    /// Sightings used.
    pub sightings: usize,
}

/// How an object is turned.
#[derive(Clone, Copy, Debug)]
pub struct Orientation {
    /// The rotation of `world_from_object`.
    pub world_from_object: UnitQuaternion<f64>,
    /// Covariance of its right perturbation; `None` where not asked for or not defined.
    pub covariance: Option<Matrix3<f64>>,
    /// By how much the second distinct mode of the yaw is worse, nats; infinite where there was no other.
    pub margin: f64,
}

/// A track that could not be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unresolved {
    /// The track.
    pub track: usize,
    /// Why.
    pub reason: UnresolvedReason,
}

/// A landmark that could not be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnresolvedLandmark {
    /// Its number.
    pub landmark: usize,
    /// Why.
    pub reason: UnresolvedReason,
}

/// Why a track or landmark could not be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnresolvedReason {
    /// All its boxes touch the border of the image.
    Truncated,
    /// Only one of its boxes does not touch the border, and that has no depth; of a landmark, one sighting.
    SeenOnce,
    /// Its rays are too close to parallel.
    NoParallax,
    /// Its rays do not meet in front of the cameras.
    BehindCamera,
}

/// Counts of detections and sightings of landmarks that were not used, or not fully.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Not used at all: the box touches the border of the image.
    pub truncated: usize,
    /// Not used at all: of a track that could not be placed.
    pub unresolved: usize,
    /// Bearing used, crop not: the model's output was not finite.
    pub non_finite: usize,
    /// Bearing used, crop not: the viewpoint is undefined, as from straight above.
    pub undefined_viewpoint: usize,
    /// Bearing used, crop not: too close in viewpoint to one that is.
    pub redundant_viewpoint: usize,
    /// Bearing used, crop not: of an object that the model does not know.
    pub unknown_object: usize,
    /// Sightings of landmarks that could not be placed.
    pub unresolved_landmark: usize,
    /// Sightings of landmarks from where the first values have the landmark behind the camera.
    pub landmark_behind_camera: usize,
}
