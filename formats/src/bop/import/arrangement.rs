//! Which images show objects in the same places, and where the camera was.

use super::files::{Annotated, Frame, Key};
use crate::mean_pose::mean_pose;
use std::collections::{BTreeMap, BTreeSet};
use vantage_dataset::{Pose, se3};

/// How far apart two poses of one standing object may be: metres, radians.
const STILL: [f64; 2] = [0.01, 0.052];
/// Objects that have to agree on a camera's pose that is not given.
const AGREEING: usize = 2;

/// Images in a row, all of one arrangement; its frame is that of the first camera, or the world of the cameras that are given.
#[derive(Clone, Debug)]
pub(super) struct Arrangement<'a> {
    pub(super) frames: &'a [Frame],
    /// By frame.
    pub(super) arrangement_from_camera: Vec<Pose>,
    /// Of the objects that stood still: `arrangement_from_model`.
    pub(super) placements: BTreeMap<Key, Pose>,
    pub(super) moved: BTreeSet<Key>,
    /// Whether its frame is that of cameras that are given.
    pub(super) is_given: bool,
}

/// The arrangements of a scene, in the order of its images.
pub(super) fn arrangements(frames: &[Frame], lone_object_stands: bool) -> Vec<Arrangement<'_>> {
    let is_given = frames.iter().all(|frame| frame.world_from_camera.is_some());
    let is_lone = frames.iter().all(|frame| frame.objects.len() <= 1);
    let least_agreeing = if lone_object_stands && is_lone { 1 } else { AGREEING };
    let mut found = Vec::new();
    let mut first = 0;
    while first < frames.len() {
        let arrangement = arrangement(&frames[first..], is_given, least_agreeing);
        first += arrangement.frames.len();
        found.push(arrangement);
    }
    found
}

/// The longest that the first images make.
fn arrangement(frames: &[Frame], is_given: bool, least_agreeing: usize) -> Arrangement<'_> {
    let mut known = Known::default();
    let mut cameras = Vec::new();
    for frame in frames {
        let given = frame.world_from_camera.filter(|_| is_given);
        // That of the first image is the arrangement's frame.
        let first = cameras.is_empty().then(Pose::identity);
        let Some(camera) = given.or(first).or_else(|| known.camera(frame, least_agreeing)) else { break };
        let mut with_it = known.clone();
        with_it.add(frame, &camera);
        if !cameras.is_empty() && 3 * with_it.moved.len() > with_it.placed.len() {
            break;
        }
        known = with_it;
        cameras.push(camera);
    }
    let placements = known.standing().map(|(key, poses)| (*key, mean_pose(poses))).collect();
    Arrangement {
        frames: &frames[..cameras.len()],
        arrangement_from_camera: cameras,
        placements,
        moved: known.moved,
        is_given,
    }
}

/// What the images up to one tell: the poses of each object, as each image has it.
#[derive(Clone, Default)]
struct Known {
    placed: BTreeMap<Key, Vec<Pose>>,
    moved: BTreeSet<Key>,
}

impl Known {
    fn standing(&self) -> impl Iterator<Item = (&Key, &Vec<Pose>)> {
        self.placed.iter().filter(|(key, _)| !self.moved.contains(key))
    }

    /// The camera's pose that most standing objects agree on, at least so many.
    fn camera(&self, frame: &Frame, least_agreeing: usize) -> Option<Pose> {
        let standing: BTreeMap<&Key, &Vec<Pose>> = self.standing().collect();
        let by_object: Vec<Pose> = frame
            .objects
            .iter()
            .filter_map(|object| {
                let before = standing.get(&object.key)?.first()?;
                Some(*before * object.camera_from_model.inverse())
            })
            .collect();
        let agreeing = |camera: &Pose| -> Vec<Pose> {
            let agrees = |object: &&Annotated| {
                let before = standing.get(&object.key).and_then(|poses| poses.first());
                before.is_some_and(|before| are_near(before, &(camera * object.camera_from_model)))
            };
            let of = |object: &Annotated| standing[&object.key][0] * object.camera_from_model.inverse();
            frame.objects.iter().filter(agrees).map(of).collect()
        };
        let best = by_object.iter().map(agreeing).reduce(|a, b| if b.len() > a.len() { b } else { a })?;
        (best.len() >= least_agreeing).then(|| mean_pose(&best))
    }

    fn add(&mut self, frame: &Frame, camera: &Pose) {
        for object in &frame.objects {
            let pose = camera * object.camera_from_model;
            let poses = self.placed.entry(object.key).or_default();
            if poses.first().is_some_and(|before| !are_near(before, &pose)) {
                self.moved.insert(object.key);
            }
            poses.push(pose);
        }
    }
}

fn are_near(a: &Pose, b: &Pose) -> bool {
    let change = a.inv_mul(b);
    change.translation.vector.norm() < STILL[0] && se3::so3_log(&change.rotation).norm() < STILL[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Six objects in a row, some of which are elsewhere from an image on: `(object, image)`.
    fn frames(images: u32, moves: &[(u32, u32)]) -> Vec<Frame> {
        let frame = |image: u32| {
            let angle = 0.1 * f64::from(image);
            let camera = Pose::new(Vector3::new(angle, 0.2, -1.5), Vector3::new(0.02, angle, 0.01));
            let object = |object: u32| {
                let moved = moves.iter().filter(|(of, from)| *of == object && *from <= image).count();
                let place = Vector3::new(0.2 * f64::from(object), 0.1, 0.3 * moved as f64);
                let pose = Pose::new(place, Vector3::z() * f64::from(object));
                Annotated {
                    index: object as usize,
                    key: Key { object, nth: 0 },
                    camera_from_model: camera.inverse() * pose,
                    visible_fraction: None,
                    visible_box: None,
                }
            };
            Frame {
                image,
                intrinsics: [500.0, 500.0, 320.0, 240.0],
                world_from_camera: None,
                objects: (0..6).map(object).collect(),
            }
        };
        (0..images).map(frame).collect()
    }

    fn lengths(found: &[Arrangement<'_>]) -> Vec<usize> {
        found.iter().map(|arrangement| arrangement.frames.len()).collect()
    }

    #[test]
    fn cameras_follow_from_what_stands_still() {
        let frames = frames(4, &[]);
        let found = arrangements(&frames, false);
        assert_eq!(lengths(&found), [4]);
        let (first, last) = (&frames[0].objects[2], &frames[3].objects[2]);
        let moved = first.camera_from_model * last.camera_from_model.inverse();
        let told = found[0].arrangement_from_camera[3];
        assert!((told.translation.vector - moved.translation.vector).norm() < 1e-9);
        assert_eq!(found[0].placements.len(), 6);
    }

    #[test]
    fn a_few_that_move_are_left_out_and_many_make_another_arrangement() {
        let moves = [(0, 2), (1, 4), (2, 6), (3, 6), (4, 6)];
        let frames = frames(9, &moves);
        let found = arrangements(&frames, false);
        assert_eq!(lengths(&found), [6, 3]);
        let moved: Vec<u32> = found[0].moved.iter().map(|key| key.object).collect();
        assert_eq!((moved, found[0].placements.len()), (vec![0, 1], 4));
        assert!(found[1].moved.is_empty());
    }

    #[test]
    fn one_object_alone_tells_the_camera_where_it_is_taken_to_stand() {
        let mut frames = frames(3, &[]);
        frames.iter_mut().for_each(|frame| frame.objects.truncate(1));
        assert_eq!(lengths(&arrangements(&frames, false)), [1, 1, 1]);
        assert_eq!(lengths(&arrangements(&frames, true)), [3]);
        let mut exchanged = frames.clone();
        exchanged[2].objects[0].key.object = 7;
        assert_eq!(lengths(&arrangements(&exchanged, true)), [2, 1]);
        for frame in &mut frames {
            frame.world_from_camera = Some(frame.objects[0].camera_from_model.inverse());
        }
        assert_eq!(lengths(&arrangements(&frames, false)), [3]);
    }

    #[test]
    fn images_without_objects_say_nothing_of_those_after_them() {
        let mut frames = frames(5, &[]);
        frames.iter_mut().take(2).for_each(|frame| frame.objects.clear());
        let found = arrangements(&frames, false);
        assert_eq!(lengths(&found), [1, 1, 3]);
        assert!(found[0].placements.is_empty() && found[2].placements.len() == 6);
    }

    #[test]
    fn noise_of_annotations_is_no_motion_and_averages() {
        let mut frames = frames(8, &[]);
        for (i, frame) in frames.iter_mut().enumerate() {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            frame.objects[i % 6].camera_from_model.translation.vector.x += sign * 0.004;
        }
        let found = arrangements(&frames, false);
        assert_eq!((lengths(&found), found[0].moved.len()), (vec![8], 0));
    }
}
