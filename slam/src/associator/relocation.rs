//! A robot that was carried somewhere: where an object that it sees again may put it.
//!
//! Its trajectory from there on is a piece of its own, which odometry ties to the map but loosely. One known object gives a whole pose: its bearing
//! and its size where the robot stands about it, and its side the heading. Each of 24 headings is a way to take it, of a weight that the crops'
//! likeness at that heading gives:
//!
//! ```text
//! p(heading | crops)  =  sum_k  d N(heading; h_k, d^2 / 4) R(h_k)      d = 15 degrees, R the ratio of likelihoods at a heading
//! ```

use super::likeness::{Heading, Likeness};
use super::ratios::{Part, Ratios};
use super::scan::{heading, pose};
use super::sensing::Sensing;
use super::tracklet::{Labels, Tracklet, Tracklets};
use crate::association::{Addition, Alternative, LocalEstimator, Moved};
use crate::factor::{DepthFactor, PosePrior};
use crate::noise::Kernel;
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use nalgebra::{Matrix6, Point3, Translation3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::rc::Rc;
use vantage_dataset::{CenterDepth, Pose};

/// Headings that are tried.
const HEADINGS: usize = 24;
/// Standard deviation of each, radians.
const SIGMA: f64 = PI / HEADINGS as f64;
/// Variance of a heading that is known to one of them.
pub(super) const VARIANCE: f64 = SIGMA * SIGMA;
/// Standard deviation of the depth that a box tells of an object of known size, as a share.
const KNOWN_SIZE_SPREAD: f64 = 0.15;
/// Ways that are less likely than the best by so many nats are left out.
const FAINT: f64 = 12.0;

/// A piece of the trajectory whose place in the map is unknown.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    /// Its first step.
    pub since: usize,
}

impl Piece {
    /// Whether a hypothesis has not seen any object of the map again since.
    pub fn is_lost<L: Likeness>(self, labels: &Labels<'_>, tracklets: &Tracklets<L>) -> bool {
        let of_piece = tracklets.iter().filter(|(_, tracklet)| tracklet.began >= self.since);
        let mut objects = of_piece.filter_map(|(number, _)| labels.object(*number));
        objects.all(|object| self.has(object, tracklets))
    }

    /// Whether an object was first seen since.
    pub fn has<R>(self, object: usize, tracklets: &BTreeMap<usize, Tracklet<R>>) -> bool {
        tracklets.get(&object).is_none_or(|tracklet| tracklet.began >= self.since)
    }
}

impl Sensing<'_> {
    /// Ways to take a sighting as one of an object of the map, each of which sets the piece down elsewhere.
    pub fn set_down<L: Likeness>(
        &self,
        ratios: &Ratios<'_, L>,
        (labels, tracklets): (&Labels<'_>, &Tracklets<L>),
        piece: Piece,
        object: usize,
        (number, sighting, reading): (usize, &Sighting, Option<(&L::Reading, f64)>),
    ) -> Vec<Alternative<'static>> {
        let hypothesis = labels.hypothesis;
        let place = hypothesis.estimator().value(Key::Object(object)).and_then(|value| value.position());
        let known = (place, pose(hypothesis, sighting.step), self.size::<L>(labels, tracklets, object));
        let (Some(place), Some(robot), Some(size)) = known else { return Vec::new() };
        let mut parts = labels.parts(tracklets, object, None);
        let before = ratios.log_ratio(&parts);
        let mut log_ratio = |yaw: f64| {
            let Some((reading, variance)) = reading else { return 0.0 };
            parts.push(Part::new(number, (1, reading), Heading { yaw, variance }));
            let ratio = ratios.log_ratio(&parts) - before;
            parts.pop();
            ratio
        };
        let step = 2.0 * PI / HEADINGS as f64;
        let yaws: Vec<(f64, f64)> =
            (0..HEADINGS).map(|k| step * k as f64).map(|yaw| (yaw, log_ratio(yaw))).collect();
        let best = yaws.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
        let meters = size / (sighting.angular_size * self.geometry.size_over_box_side);
        let in_robot = self.observations.robot_from_camera * Point3::from(sighting.ray_in_camera * meters);
        let depth = CenterDepth { meters, sigma: KNOWN_SIZE_SPREAD * meters };
        let keys = (piece.since..=sighting.step)
            .map(Key::Robot)
            .chain(labels.objects().filter(|object| piece.has(*object, tracklets)).map(Key::Object));
        let values: Rc<[(Key, Value)]> =
            keys.filter_map(|key| Some((key, hypothesis.estimator().value(key)?))).collect();
        let mut sqrt_information = Matrix6::zeros();
        sqrt_information[(2, 2)] = 1.0 / SIGMA;
        let way = |(yaw, log_ratio): (f64, f64)| {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw - heading(&robot));
            let rotation = turn * robot.rotation;
            let mut at = place - rotation * in_robot.coords;
            at.z = robot.translation.z;
            let set_down = Pose::from_parts(Translation3::from(at), rotation);
            let motion = set_down * robot.inverse();
            let robot = Key::Robot(sighting.step);
            let addition = Addition { moved: Moved::new(motion, Rc::clone(&values)), ..Addition::default() }
                .with(self.bearing(object, sighting))
                .with(DepthFactor::new(
                    robot,
                    Key::Object(object),
                    self.observations.robot_from_camera,
                    depth,
                    Kernel::Gaussian,
                ))
                .with(PosePrior::new(robot, set_down, sqrt_information));
            let log_densities = -libm::log(2.0 * PI) - libm::log(depth.sigma) - libm::log(SIGMA);
            Alternative {
                label: object,
                addition,
                log_weight: self.log_normalizer(sighting) + log_densities + libm::log(step) + log_ratio,
                claims: Some(object),
            }
        };
        yaws.into_iter().filter(|(_, log)| *log > best - FAINT).map(way).collect()
    }

    /// Diameter of an object by all that a hypothesis takes for it, metres.
    fn size<L: Likeness>(&self, labels: &Labels<'_>, tracklets: &Tracklets<L>, object: usize) -> Option<f64> {
        let mut values = Values::default();
        let mut sightings = Vec::new();
        for tracklet in labels.tracklets(object).filter_map(|number| tracklets.get(&number)) {
            for sighting in &tracklet.sightings {
                values
                    .insert(Key::Robot(sighting.step), Value::Pose(pose(labels.hypothesis, sighting.step)?));
                sightings.push(*sighting);
            }
        }
        values.insert(Key::Object(object), labels.hypothesis.estimator().value(Key::Object(object))?);
        Problem { observations: self.observations, settings: self.geometry }
            .object_size(&values, object, &sightings)
    }
}
