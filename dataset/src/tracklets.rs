//! Observations that do not tell which object a detection is of.

use crate::episode::{Detection, Observations};
use std::collections::BTreeMap;

/// What a robot observes of objects that nobody names: each track is a tracklet, of which several may be of one object.
///
/// Tracklets are numbered by their first detections, those of one step from left to right: neither number nor order tells the object.
#[derive(Clone, Debug)]
pub struct Tracklets {
    observations: Observations,
    count: usize,
    gap: usize,
}

impl Tracklets {
    /// Detections joined while an object stays in view, at most `gap` steps apart: the association between consecutive frames that
    /// the paper takes for granted. None goes on where the robot was carried. Also returns, of each
    /// detection, its number among those of `given`, which only scoring may read.
    pub fn joined(given: &Observations, gap: usize) -> (Self, Vec<usize>) {
        let mut open: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
        let carried: Vec<usize> = given.set_down().collect();
        Self::numbered(given, gap, |detection, next| {
            let is_on = |last: usize| {
                detection.step - last <= gap
                    && !carried.iter().any(|at| (last + 1..=detection.step).contains(at))
            };
            let last = open.get(&detection.track).filter(|(step, _)| is_on(*step));
            let tracklet = last.map_or(next, |(_, tracklet)| *tracklet);
            open.insert(detection.track, (detection.step, tracklet));
            tracklet
        })
    }

    /// Detections alone: each is a tracklet. Returns what [`Tracklets::joined`] does.
    pub fn alone(given: &Observations) -> (Self, Vec<usize>) {
        Self::numbered(given, 0, |_, next| next)
    }

    /// The tracklet of a detection by `tracklet`, which is told the number of the next new one.
    fn numbered(
        given: &Observations,
        gap: usize,
        mut tracklet: impl FnMut(&Detection, usize) -> usize,
    ) -> (Self, Vec<usize>) {
        let mut order: Vec<usize> = (0..given.detections.len()).collect();
        let place = |detection: &Detection| {
            let bounds = detection.bounding_box;
            [bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y]
        };
        order.sort_by(|&a, &b| {
            let (a, b) = (&given.detections[a], &given.detections[b]);
            let apart = place(a).into_iter().zip(place(b)).map(|(a, b)| a.total_cmp(&b));
            a.step.cmp(&b.step).then(apart.fold(std::cmp::Ordering::Equal, |so_far, next| so_far.then(next)))
        });
        let mut count = 0;
        let mut detections = Vec::with_capacity(order.len());
        for &number in &order {
            let detection = &given.detections[number];
            let track = tracklet(detection, count);
            count = count.max(track + 1);
            detections.push(Detection { track, ..detection.clone() });
        }
        (Self { observations: Observations { detections, ..given.clone() }, count, gap }, order)
    }

    /// What is observed; tracks are tracklets.
    pub fn observations(&self) -> &Observations {
        &self.observations
    }

    /// Most steps between detections of a tracklet; 0 where each is one detection.
    pub fn gap(&self) -> usize {
        self.gap
    }

    /// Number of tracklets.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The same with an object's number as the track of each tracklet that is of one, `objects[tracklet]`; detections of others are left out.
    pub fn associated(&self, objects: &[Option<usize>]) -> Observations {
        let of_object = |detection: &Detection| {
            let track = *objects.get(detection.track)?;
            Some(Detection { track: track?, ..detection.clone() })
        };
        let mut detections: Vec<Detection> =
            self.observations.detections.iter().filter_map(of_object).collect();
        detections.sort_by_key(|detection| (detection.step, detection.track));
        Observations { detections, ..self.observations.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crop::Crop;
    use crate::episode::{BoundingBox, Odometry};
    use crate::{Camera, Pose};
    use nalgebra::{Matrix6, Vector2};

    fn seen(step: usize, track: usize, x: f64) -> Detection {
        Detection {
            step,
            track,
            bounding_box: BoundingBox { min: Vector2::new(x, 10.0), max: Vector2::new(x + 5.0, 20.0) },
            mask_pixels: 20,
            center_depth: None,
            masked_crop: Crop::black(),
            boxed_crop: Crop::black(),
        }
    }

    fn observations(detections: Vec<Detection>) -> Observations {
        Observations {
            timestamps: (0..10).map(f64::from).collect(),
            camera: Camera::with_horizontal_fov(640, 480, 1.0),
            robot_from_camera: Pose::identity(),
            odometry: Vec::new(),
            detections,
            landmarks: Vec::new(),
        }
    }

    #[test]
    fn detections_are_joined_while_in_view_and_numbered_from_left_to_right() {
        let given = observations(vec![
            seen(0, 3, 50.0),
            seen(0, 4, 20.0),
            seen(1, 3, 51.0),
            seen(3, 3, 52.0),
            seen(6, 3, 53.0),
            seen(6, 4, 54.0),
        ]);
        let (tracklets, order) = Tracklets::joined(&given, 2);
        let got: Vec<_> = tracklets.observations().detections.iter().map(|d| (d.step, d.track)).collect();
        assert_eq!(got, [(0, 0), (0, 1), (1, 1), (3, 1), (6, 2), (6, 3)]);
        assert_eq!((tracklets.count(), order), (4, vec![1, 0, 2, 3, 4, 5]));

        let (alone, _) = Tracklets::alone(&given);
        assert_eq!(alone.count(), 6);
    }

    #[test]
    fn nothing_is_joined_across_a_motion_that_is_unknown() {
        let mut given = observations((0..4).map(|step| seen(step, 0, 50.0)).collect());
        given.odometry = (0..3)
            .map(|from| Odometry {
                from,
                to: from + 1,
                robot_from_robot: Pose::identity(),
                covariance: Matrix6::identity() * if from == 1 { 4.0 } else { 0.01 },
            })
            .collect();
        let (tracklets, _) = Tracklets::joined(&given, 3);
        let got: Vec<_> = tracklets.observations().detections.iter().map(|d| d.track).collect();
        assert_eq!(got, [0, 0, 1, 1]);
    }

    #[test]
    fn an_association_gives_tracklets_back_to_objects() {
        let given = observations(vec![seen(0, 0, 50.0), seen(0, 1, 20.0), seen(5, 0, 30.0)]);
        let (tracklets, _) = Tracklets::joined(&given, 2);
        let named = tracklets.associated(&[None, Some(7), Some(7)]);
        let got: Vec<_> = named.detections.iter().map(|d| (d.step, d.track)).collect();
        assert_eq!(got, [(0, 7), (5, 7)]);
    }
}
