//! Views of a drive that learning is not shown, so that it can be asked how well it predicts them.

use crate::sighting::sightings;
use std::collections::BTreeSet;
use vantage_dataset::Observations;

/// Of an object's views, the share before the later ones.
const EARLIER: (usize, usize) = (2, 3);
/// Steps without a whole box after which another session begins.
const SESSION_GAP: usize = 20;

/// The later views: the detections of each object's last third.
pub(super) fn later_views(observations: &Observations) -> BTreeSet<usize> {
    let (of_track, _) = sightings(observations);
    let later = of_track.values().flat_map(|of| &of[(of.len() * EARLIER.0).div_ceil(EARLIER.1)..]);
    later.map(|sighting| sighting.detection).collect()
}

/// Another session: the detections of each object before it was longest out of sight, for more than [`SESSION_GAP`] steps; none of one that was
/// always seen again soon.
pub(super) fn other_session(observations: &Observations) -> BTreeSet<usize> {
    let (of_track, _) = sightings(observations);
    let before = of_track.values().flat_map(|of| {
        let gap = |at: &usize| of[*at].step - of[at - 1].step;
        let longest = (1..of.len()).rev().max_by_key(gap).filter(|at| gap(at) > SESSION_GAP);
        &of[..longest.unwrap_or(0)]
    });
    before.map(|sighting| sighting.detection).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use vantage_dataset::{BoundingBox, Camera, Crop, Detection, Pose};

    fn seen(tracks_and_steps: &[(usize, usize)]) -> Observations {
        let bounding_box = BoundingBox { min: Vector2::new(100.0, 100.0), max: Vector2::new(140.0, 140.0) };
        let detection = |&(track, step): &(usize, usize)| Detection {
            step,
            track,
            bounding_box,
            mask_pixels: 1600,
            center_depth: None,
            masked_crop: Crop::black(),
            boxed_crop: Crop::black(),
        };
        Observations {
            timestamps: (0..200).map(f64::from).collect(),
            camera: Camera::with_horizontal_fov(512, 384, 1.0),
            robot_from_camera: Pose::identity(),
            odometry: Vec::new(),
            detections: tracks_and_steps.iter().map(detection).collect(),
            landmarks: Vec::new(),
        }
    }

    #[test]
    fn of_each_object_the_last_third_is_hidden_whatever_the_order_of_detections() {
        let hidden = |views: &[(usize, usize)]| later_views(&seen(views)).into_iter().collect::<Vec<_>>();
        assert!(
            hidden(&[]).is_empty() && hidden(&[(0, 3)]).is_empty() && hidden(&[(0, 3), (0, 4)]).is_empty()
        );
        assert_eq!(hidden(&[(0, 1), (0, 2), (0, 3)]), [2]);
        assert_eq!(hidden(&[(0, 9), (1, 1), (0, 7), (1, 2), (0, 8), (1, 3)]), [0, 5]);
    }

    #[test]
    fn what_was_seen_before_the_longest_gap_is_another_session() {
        let hidden = |views: &[(usize, usize)]| other_session(&seen(views)).into_iter().collect::<Vec<_>>();
        assert!(hidden(&[]).is_empty() && hidden(&[(0, 5)]).is_empty());
        assert!(hidden(&[(0, 0), (0, SESSION_GAP)]).is_empty());
        assert_eq!(hidden(&[(0, 0), (0, SESSION_GAP + 1)]), [0]);
        let two_gaps = [(0, 0), (0, 30), (0, 31), (0, 80), (1, 5), (1, 6)];
        assert_eq!(hidden(&two_gaps), [0, 1, 2], "before the longer one, and of that object alone");
    }
}
