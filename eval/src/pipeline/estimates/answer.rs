//! What a row answers on a seed, as it is stored.

use crate::result::run::Outcome;
use crate::score::object::ObjectEstimate;
use nalgebra::{Matrix3, Matrix6, Point3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::Pose;
use vantage_slam::{Estimate, LandmarkEstimate, ObjectEstimate as EstimatedObject, Outcome as Ending};

/// What one method answered on one seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// How it ended.
    pub outcome: Outcome,
    /// The robot's pose at each step; empty where there is no answer.
    pub world_from_robot: Vec<Pose>,
    /// Covariance of the right perturbation of each pose, rotation first; `None` where not asked for or not defined.
    pub pose_covariances: Option<Vec<Matrix6<f64>>>,
    /// The objects by track.
    pub objects: Vec<Option<StoredObject>>,
    /// The landmarks that were placed, by number.
    pub landmarks: BTreeMap<usize, StoredLandmark>,
    /// Detections whose crop could not be used.
    pub dropped: usize,
    /// Of a row that learns, on a drive of a life: how much more probable the drive's crops were before it than by the model as it was
    /// trained, nats a crop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
}

/// A landmark as it is stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredLandmark {
    /// Where it is in the world, metres.
    pub position: Point3<f64>,
    /// Covariance of the position, world axes.
    pub covariance: Option<Matrix3<f64>>,
}

impl From<&LandmarkEstimate> for StoredLandmark {
    fn from(landmark: &LandmarkEstimate) -> Self {
        Self { position: Point3::from(landmark.position), covariance: landmark.covariance }
    }
}

/// An object as it is stored; orientation and latent are those of a semantic estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredObject {
    /// Its centre in the world, metres.
    pub position: Point3<f64>,
    /// Covariance of the position, world axes.
    pub position_covariance: Option<Matrix3<f64>>,
    /// Semi-axes, metres, where objects are ellipsoids.
    pub extents: Option<Vector3<f64>>,
    /// `world_from_object`.
    pub rotation: Option<UnitQuaternion<f64>>,
    /// Covariance of the rotation's right perturbation.
    pub rotation_covariance: Option<Matrix3<f64>>,
    /// By how much the second mode of the orientation is worse, nats; `None` where there was no other.
    pub margin: Option<f64>,
    /// P(e | H): means, then variances.
    pub latent: Option<[Vec<f64>; 2]>,
    /// P(c | H) of the classes of the model's read-out, in its order; of an estimator by discrete classes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub classes: Option<Vec<f64>>,
}

impl From<&EstimatedObject> for StoredObject {
    fn from(object: &EstimatedObject) -> Self {
        Self {
            position: Point3::from(object.position),
            position_covariance: object.position_covariance,
            extents: object.extents,
            rotation: object.orientation.map(|orientation| orientation.world_from_object),
            rotation_covariance: object.orientation.and_then(|orientation| orientation.covariance),
            margin: object.orientation.map(|orientation| orientation.margin).filter(|nats| nats.is_finite()),
            latent: object.latent.as_ref().map(|e| [&e.mean, &e.variance].map(|v| v.as_slice().to_vec())),
            classes: object.classes.clone(),
        }
    }
}

impl StoredObject {
    /// Keeps so many numbers of the latent, the first.
    pub(super) fn keep_latent(&mut self, numbers: usize) {
        self.latent.iter_mut().flatten().for_each(|of| of.truncate(numbers));
    }

    /// Leaves the object's place alone: its frame is no other estimator's, nor the truth's.
    pub(super) fn forget_frame(&mut self) {
        let Self {
            position: _,
            position_covariance: _,
            extents,
            rotation,
            rotation_covariance,
            margin,
            latent,
            classes,
        } = self;
        *extents = None;
        (*rotation, *rotation_covariance, *margin, *latent) = (None, None, None, None);
        *classes = None;
    }
}

impl Answer {
    /// The objects as the scores take them, one a true object.
    pub fn scored_objects(&self, objects: usize) -> Vec<Option<ObjectEstimate>> {
        let object = |index: usize| {
            let object = self.objects.get(index)?.as_ref()?;
            Some(ObjectEstimate { center_in_world: object.position, rotation: object.rotation })
        };
        (0..objects).map(object).collect()
    }

    pub(super) fn new(estimate: Estimate) -> Self {
        let dropped = estimate.dropped_detections;
        Self {
            outcome: match estimate.outcome {
                Ending::Converged => Outcome::Done,
                ending => Outcome::Flagged(ending.to_string()),
            },
            world_from_robot: estimate.world_from_robot,
            pose_covariances: estimate.pose_covariances,
            objects: estimate.objects.iter().map(|object| object.as_ref().map(StoredObject::from)).collect(),
            landmarks: estimate
                .landmarks
                .iter()
                .map(|(&number, landmark)| (number, landmark.into()))
                .collect(),
            dropped: dropped.non_finite + dropped.undefined_viewpoint,
            gain: None,
        }
    }

    pub(super) fn failed(reason: String) -> Self {
        Self {
            outcome: Outcome::Failed(reason),
            world_from_robot: Vec::new(),
            pose_covariances: None,
            objects: Vec::new(),
            landmarks: BTreeMap::new(),
            dropped: 0,
            gain: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_an_object_in_a_free_frame_its_place_is_left() {
        let mut object = StoredObject {
            position: Point3::new(0.1, 0.2, 0.3),
            position_covariance: Some(Matrix3::identity()),
            extents: Some(Vector3::repeat(0.1)),
            rotation: Some(UnitQuaternion::identity()),
            rotation_covariance: Some(Matrix3::identity()),
            margin: Some(2.0),
            latent: Some([vec![0.1], vec![0.2]]),
            classes: Some(vec![1.0]),
        };
        object.forget_frame();
        assert!(object.position_covariance.is_some() && object.position.y == 0.2);
        assert!(object.rotation.is_none() && object.rotation_covariance.is_none());
        assert!(object.margin.is_none() && object.latent.is_none() && object.extents.is_none());
        assert!(object.classes.is_none());
    }

    #[test]
    fn answers_round_trip_to_the_bit() {
        let pose = Pose::rotation(Vector3::new(0.1, 0.2, 0.3));
        let object = StoredObject {
            position: Point3::new(0.1, 0.2, 0.3),
            position_covariance: Some(Matrix3::from_fn(|i, j| 1.0 / (3 + i + 7 * j) as f64)),
            extents: Some(Vector3::new(0.1, 1.0 / 3.0, 0.2)),
            rotation: Some(pose.rotation),
            rotation_covariance: None,
            margin: Some(1.0 / 3.0),
            latent: Some([vec![0.1, -0.2], vec![1.0 / 7.0, 1e-300]]),
            classes: Some(vec![1.0 / 3.0, 2.0 / 3.0]),
        };
        let landmark = StoredLandmark {
            position: Point3::new(1.0 / 3.0, -0.2, 1e-9),
            covariance: Some(Matrix3::from_fn(|i, j| 1.0 / (5 + i + 3 * j) as f64)),
        };
        let answer = Answer {
            outcome: Outcome::Done,
            world_from_robot: vec![pose],
            pose_covariances: Some(vec![Matrix6::from_fn(|i, j| 1.0 / (1 + i + 5 * j) as f64)]),
            objects: vec![None, Some(object)],
            landmarks: BTreeMap::from([(7, landmark)]),
            dropped: 1,
            gain: Some(1.0 / 9.0),
        };
        let json = serde_json::to_string(&answer).unwrap();
        let read: Answer = serde_json::from_str(&json).unwrap();
        assert_eq!(read, answer);
        assert_eq!(serde_json::to_string(&read).unwrap(), json);
    }
}
