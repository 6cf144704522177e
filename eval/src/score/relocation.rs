//! Whether a robot that was carried somewhere finds out where it is, and how soon.

use super::embedding::Scores;
use super::root_mean_square;
use crate::result::metric::Metric;
use vantage_dataset::{Observations, Pose};
use vantage_slam::associator::Place;

/// Distance from the truth within which a robot is where it believes to be, metres.
const NEAR: f64 = 1.0;

/// The columns of scenes whose robot is carried.
pub const COLUMNS: [Metric; 7] = [
    Metric::Resolved,
    Metric::DetectionsToResolve,
    Metric::PlaceError,
    Metric::FinalPlace,
    Metric::WithinHalf,
    Metric::WithinOne,
    Metric::WithinTwo,
];

/// The scores of places, one a step, since the robot was set down last, with the first pose laid on the first true one; none of a robot that was not carried.
pub fn relocation_scores(observations: &Observations, world_from_robot: &[Pose], places: &[Place]) -> Scores {
    let mut scores = Scores::new();
    let (Some(since), Some(first)) = (observations.set_down().max(), world_from_robot.first()) else {
        return scores;
    };
    if places.len() != world_from_robot.len() || since >= places.len() {
        return scores;
    }
    let off = |(place, truth): (&Place, &Pose)| {
        let truth = first.inv_mul(truth).translation.vector;
        ((place.world_from_robot.translation.vector - truth).norm(), place.is_known)
    };
    let errors: Vec<(f64, bool)> = places.iter().zip(world_from_robot).map(off).collect();
    let last = errors[errors.len() - 1];
    let is_near = |(error, is_known): &(f64, bool)| *is_known && *error < NEAR;
    let resolved =
        errors[since..].iter().rposition(|error| !is_near(error)).map_or(since, |step| since + step + 1);
    let whole = observations.detections.iter().filter(|detection| {
        (since..=resolved).contains(&detection.step)
            && !detection.bounding_box.is_truncated(&observations.camera)
    });
    let within = |metres: f64| f64::from(last.1 && last.0 < metres);
    scores.extend(
        root_mean_square(errors[since..].iter().map(|error| error.0 * error.0))
            .map(|error| (Metric::PlaceError, error)),
    );
    scores.extend([
        (Metric::Resolved, f64::from(resolved < errors.len())),
        (Metric::DetectionsToResolve, whole.count() as f64),
        (Metric::FinalPlace, last.0),
        (Metric::WithinHalf, within(0.5)),
        (Metric::WithinOne, within(1.0)),
        (Metric::WithinTwo, within(2.0)),
    ]);
    scores
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix6, Vector2};
    use vantage_dataset::{BoundingBox, Camera, Crop, Detection, Odometry};

    /// Ten steps along x, carried before the fourth, one whole detection a step.
    fn episode() -> (Observations, Vec<Pose>) {
        let poses: Vec<Pose> = (0..10).map(|step| Pose::translation(f64::from(step), 5.0, 0.0)).collect();
        let odometry = (0..9).map(|from| Odometry {
            from,
            to: from + 1,
            robot_from_robot: Pose::translation(1.0, 0.0, 0.0),
            covariance: Matrix6::identity() * if from == 3 { 5.0 } else { 0.01 },
        });
        let detections = (0..10).map(|step| Detection {
            step,
            track: 0,
            bounding_box: BoundingBox { min: Vector2::new(50.0, 50.0), max: Vector2::new(70.0, 90.0) },
            mask_pixels: 500,
            center_depth: None,
            masked_crop: Crop::black(),
            boxed_crop: Crop::black(),
        });
        let observations = Observations {
            timestamps: (0..10).map(f64::from).collect(),
            camera: Camera::with_horizontal_fov(640, 480, 1.0),
            robot_from_camera: Pose::identity(),
            odometry: odometry.collect(),
            detections: detections.collect(),
            landmarks: Vec::new(),
        };
        (observations, poses)
    }

    fn places(errors: [f64; 10], known_from: usize) -> Vec<Place> {
        let place = |(step, error): (usize, f64)| Place {
            world_from_robot: Pose::translation(step as f64, error, 0.0),
            is_known: step >= known_from,
        };
        errors.into_iter().enumerate().map(place).collect()
    }

    #[test]
    fn detections_are_counted_until_the_place_is_right_for_good() {
        let (observations, poses) = episode();
        let errors = [0.0, 0.0, 0.0, 0.0, 3.0, 0.5, 4.0, 0.9, 0.2, 0.7];
        let scores = relocation_scores(&observations, &poses, &places(errors, 0));
        assert_eq!((scores[&Metric::Resolved], scores[&Metric::DetectionsToResolve]), (1.0, 4.0));
        assert_eq!((scores[&Metric::WithinHalf], scores[&Metric::WithinOne]), (0.0, 1.0));
        assert!((scores[&Metric::FinalPlace] - 0.7).abs() < 1e-12);
        let squares: f64 = errors[4..].iter().map(|error| error * error).sum();
        assert!((scores[&Metric::PlaceError] - (squares / 6.0).sqrt()).abs() < 1e-12);
        let at_once = relocation_scores(&observations, &poses, &places([0.1; 10], 0));
        assert_eq!(at_once[&Metric::DetectionsToResolve], 1.0);
    }

    #[test]
    fn who_does_not_know_is_not_right_by_chance() {
        let (observations, poses) = episode();
        let scores = relocation_scores(&observations, &poses, &places([0.1; 10], 100));
        assert_eq!((scores[&Metric::Resolved], scores[&Metric::DetectionsToResolve]), (0.0, 6.0));
        assert_eq!(scores[&Metric::WithinTwo], 0.0);
        let late = relocation_scores(&observations, &poses, &places([0.1; 10], 6));
        assert_eq!((late[&Metric::Resolved], late[&Metric::DetectionsToResolve]), (1.0, 3.0));
    }

    #[test]
    fn a_robot_that_was_not_carried_has_no_scores() {
        let (mut observations, poses) = episode();
        assert!(relocation_scores(&observations, &poses, &[]).is_empty(), "no places");
        observations.odometry.remove(3);
        assert!(relocation_scores(&observations, &poses, &places([0.0; 10], 0)).is_empty());
    }
}
