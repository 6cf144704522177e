//! An episode: what one robot observed on one path through one world, and what was true.

use crate::camera::Camera;
use crate::crop::Crop;
use crate::instance::{InstanceId, Symmetry};
use crate::se3::Pose;
use crate::seed::Seed;
use nalgebra::{Matrix6, Point3, Vector2, Vector3};

/// One run of a robot through one world.
#[derive(Clone, Debug)]
pub struct Episode {
    /// What it was made from; an estimator that had it could make the truth anew.
    pub seed: Seed,
    /// What the robot has.
    pub observations: Observations,
    /// What only scoring, and training where the paper allows it, may read.
    pub truth: Truth,
}

/// Everything an estimator may use: `H_k` of Eq. 1.
#[derive(Clone, Debug)]
pub struct Observations {
    /// Seconds since the start, one a step, strictly increasing.
    pub timestamps: Vec<f64>,
    /// Intrinsics of the camera.
    pub camera: Camera,
    /// Where the camera sits on the robot (known calibration).
    pub robot_from_camera: Pose,
    /// `U`: one measurement between each pair of consecutive steps.
    pub odometry: Vec<Odometry>,
    /// `Z^g` and `Z^s`, ordered by step, then track.
    pub detections: Vec<Detection>,
    /// The part of `Z^g` that is of point landmarks, ordered by step, then landmark; empty where none are measured.
    pub landmarks: Vec<LandmarkSighting>,
}

impl Observations {
    /// Number of steps, which is the number of robot poses to estimate.
    pub fn steps(&self) -> usize {
        self.timestamps.len()
    }

    /// The steps to which the robot came by a motion that is [unknown](Odometry::is_unknown), in the order of the odometry.
    pub fn set_down(&self) -> impl Iterator<Item = usize> {
        self.odometry.iter().filter(|odometry| odometry.is_unknown()).map(|odometry| odometry.to)
    }

    /// One more than the largest track, or 0.
    pub fn tracks(&self) -> usize {
        self.detections.iter().map(|d| d.track + 1).max().unwrap_or(0)
    }
}

/// Measured motion of the robot between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometry {
    /// Earlier step.
    pub from: usize,
    /// Later step.
    pub to: usize,
    /// `from_robot_from_to_robot`: the later robot's pose in the earlier robot's frame.
    pub robot_from_robot: Pose,
    /// Covariance of the right perturbation of `robot_from_robot`, rotation first.
    pub covariance: Matrix6<f64>,
}

impl Odometry {
    /// Standard deviation of a heading, radians, from which on it may be any.
    const ANY_HEADING: f64 = 1.0;

    /// Whether it tells that the robot was moved and not how, as where it was carried: the later heading may be any.
    pub fn is_unknown(&self) -> bool {
        self.covariance[(2, 2)] > Self::ANY_HEADING * Self::ANY_HEADING
    }
}

/// One object seen in one image.
#[derive(Clone, Debug)]
pub struct Detection {
    /// The step at which it was seen.
    pub step: usize,
    /// Which object, by oracle association: equal tracks are the same object. Says nothing of its class.
    pub track: usize,
    /// Box of the visible mask.
    pub bounding_box: BoundingBox,
    /// Number of pixels of the visible mask.
    pub mask_pixels: u32,
    /// How far off the object's centre is, where the detector tells.
    pub center_depth: Option<CenterDepth>,
    /// The crop with all but the object's own pixels black.
    pub masked_crop: Crop,
    /// The crop with its surroundings.
    pub boxed_crop: Crop,
}

/// The measured depth of an object's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CenterDepth {
    /// Along the optical axis: z in the camera frame, metres.
    pub meters: f64,
    /// Its standard deviation, metres.
    pub sigma: f64,
}

/// One point landmark seen in one image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandmarkSighting {
    /// The step at which it was seen.
    pub step: usize,
    /// Which landmark, by oracle association.
    pub landmark: usize,
    /// Where, pixels.
    pub pixel: Vector2<f64>,
    /// Standard deviation along each axis, pixels.
    pub sigma: f64,
}

/// An axis-aligned box in pixels, `min` inclusive and `max` exclusive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Left and top edge.
    pub min: Vector2<f64>,
    /// Right and bottom edge.
    pub max: Vector2<f64>,
}

impl BoundingBox {
    /// The centre, pixels: the geometric measurement of Z^g.
    pub fn center(&self) -> Vector2<f64> {
        (self.min + self.max) / 2.0
    }

    /// The longer side, pixels.
    pub fn side(&self) -> f64 {
        (self.max.x - self.min.x).max(self.max.y - self.min.y)
    }

    /// Whether the box touches the border of the image, so that the object may go on beyond it.
    pub fn is_truncated(&self, camera: &Camera) -> bool {
        self.min.x <= 0.0
            || self.min.y <= 0.0
            || self.max.x >= f64::from(camera.width)
            || self.max.y >= f64::from(camera.height)
    }
}

/// Ground truth of an episode.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The robot's pose at each step.
    pub world_from_robot: Vec<Pose>,
    /// The objects; a detection's track is its index here. One beyond them is a detection of nothing, as is one of which nothing is
    /// visible: see [`Truth::shown`].
    pub objects: Vec<ObjectTruth>,
    /// `L`, world frame, metres; a sighting's landmark is its index here.
    pub landmarks: Vec<Point3<f64>>,
    /// Of each detection, in the order of [`Observations::detections`].
    pub detections: Vec<DetectionTruth>,
}

impl Truth {
    /// The object that a detection shows, given its number among the detections; none where it shows nothing, whatever its track.
    pub fn shown(&self, number: usize, detection: &Detection) -> Option<&ObjectTruth> {
        let is_something = self.detections.get(number).is_none_or(|truth| truth.visible_fraction > 0.0);
        self.objects.get(detection.track).filter(|_| is_something)
    }
}

/// Ground truth of one object.
#[derive(Clone, Debug)]
pub struct ObjectTruth {
    /// The instance.
    pub instance: InstanceId,
    /// Name of its family.
    pub family: String,
    /// Its settled pose; origin at the centre of its bounding box, z up in its canonical frame.
    pub world_from_object: Pose,
    /// Diameter of its bounding sphere, metres.
    pub size: f64,
    /// Its symmetry about z.
    pub symmetry: Symmetry,
    /// Its extents; none where they are not known.
    pub extents: Option<Extents>,
}

/// How far an object reaches from its centre along its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents {
    /// Half the sides of its bounding box, metres.
    pub half_sides: Vector3<f64>,
    /// Semi-axes of the ellipsoid of the box's proportions that just holds it, metres.
    pub semi_axes: Vector3<f64>,
}

/// Ground truth of one detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionTruth {
    /// Visible share of the object's silhouette (pixels with occluders over pixels without), in `[0, 1]`; 0 where there is
    /// no object.
    pub visible_fraction: f64,
}
