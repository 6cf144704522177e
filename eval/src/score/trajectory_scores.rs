//! All that a trajectory and a map of objects are scored by.

use super::ate::{ate, ate_umeyama};
use super::embedding::Scores;
use super::heading::heading_error;
use super::object::{ObjectEstimate, object_errors};
use super::pairs::Pairs;
use super::rpe::rpe;
use crate::result::metric::Metric;
use vantage_dataset::ObjectTruth;

/// The name of the table of trajectories.
pub const TRAJECTORIES: &str = "trajectory";
/// Its columns; [`Metric::Landmark`] is another where the world has landmarks, [`Metric::Extents`] where objects are ellipsoids.
pub const TRAJECTORY: [Metric; 7] = [
    Metric::Ate,
    Metric::AteUmeyama,
    Metric::Heading,
    Metric::RpeTranslation,
    Metric::RpeRotation,
    Metric::ObjectCenter,
    Metric::ObjectOrientation,
];

/// The scores of the robot's poses.
pub fn pose_scores(pairs: &Pairs) -> Scores {
    let relative = rpe(pairs);
    let values = [
        (Metric::Ate, ate(pairs)),
        (Metric::AteUmeyama, ate_umeyama(pairs)),
        (Metric::Heading, heading_error(pairs)),
        (Metric::RpeTranslation, relative.translation),
        (Metric::RpeRotation, relative.rotation),
    ];
    values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect()
}

/// The scores of objects, one estimate a true one; without their orientation where that is not `oriented` as the truth's.
pub fn object_scores(
    pairs: &Pairs,
    truth: &[ObjectTruth],
    estimates: &[Option<ObjectEstimate>],
    oriented: bool,
) -> Scores {
    let errors = object_errors(pairs, truth, estimates);
    let values = [
        (Metric::ObjectCenter, errors.center),
        (Metric::ObjectOrientation, errors.orientation.filter(|_| oriented)),
    ];
    values.into_iter().filter_map(|(metric, value)| Some((metric, value?))).collect()
}
