//! Detections of an episode as views: what models are trained on where there is no simulator to ask for more.

use crate::episode::{Episode, ObjectTruth};
use crate::instance::Split;
use crate::se3::Pose;
use crate::sighting::Sighting;
use crate::viewpoint::Viewpoint;
use crate::views::{InstanceRecord, View, ViewSet, box_center_error};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::BTreeMap;

/// The detections of the objects that `takes` says, each object an instance whose views are one session.
///
/// Viewpoints are true, about the object's true centre; sightings are by odometry, from the first step's true tilt, which a robot
/// knows by gravity. Crops are the masked ones. Detections of no object, and from no viewpoint ([`Viewpoint::new`]), are left out, as
/// are objects without a view.
pub fn episode_views(episode: &Episode, split: Split, takes: &dyn Fn(&ObjectTruth) -> bool) -> ViewSet {
    let (observations, truth) = (&episode.observations, &episode.truth);
    let session_from_camera = dead_reckoned(episode);
    let mut set = ViewSet { split, instances: Vec::new(), views: Vec::new() };
    for (track, object) in truth.objects.iter().enumerate().filter(|(_, object)| takes(object)) {
        let instance = set.instances.len();
        let before = set.views.len();
        let detections = observations.detections.iter().zip(&truth.detections);
        let of_track = detections.filter(|(detection, _)| detection.track == track);
        for (detection, known) in of_track.filter(|(_, known)| known.visible_fraction > 0.0) {
            let world_from_camera = truth.world_from_robot[detection.step] * observations.robot_from_camera;
            let object_from_camera = object.world_from_object.inv_mul(&world_from_camera);
            let Some(viewpoint) = Viewpoint::new(&object_from_camera, object.size) else { continue };
            let ray = observations.camera.ray_in_camera(&detection.bounding_box.center()).xy();
            let sighting = Sighting {
                step: set.views.len() - before,
                session_from_camera: session_from_camera[detection.step],
                ray: ray.into(),
                angular_size: detection.bounding_box.side() / observations.camera.focal_length(),
            };
            set.views.push(View {
                instance,
                session: 0,
                viewpoint,
                crop: detection.masked_crop.clone(),
                visible_fraction: known.visible_fraction,
                box_center_error: box_center_error(&ray, &object_from_camera, object.size),
                sighting: Some(sighting),
            });
        }
        if set.views.len() > before {
            let ObjectTruth { instance: id, family, symmetry, .. } = object.clone();
            set.instances.push(InstanceRecord { id, family, symmetry });
        }
    }
    set
}

/// Likewise of several episodes: the views of an instance that occurs in more than one are as many sessions, in their order.
pub fn episodes_views<'a>(
    episodes: impl IntoIterator<Item = &'a Episode>,
    split: Split,
    takes: &dyn Fn(&ObjectTruth) -> bool,
) -> ViewSet {
    let mut instances: Vec<InstanceRecord> = Vec::new();
    let mut views: Vec<Vec<View>> = Vec::new();
    for episode in episodes {
        let set = episode_views(episode, split, takes);
        let mut sessions = BTreeMap::new();
        for view in set.views {
            let record = &set.instances[view.instance];
            let instance = instances.iter().position(|known| known.id == record.id).unwrap_or_else(|| {
                instances.push(record.clone());
                views.push(Vec::new());
                instances.len() - 1
            });
            let session = *sessions
                .entry(instance)
                .or_insert_with(|| views[instance].last().map_or(0, |last: &View| last.session + 1));
            views[instance].push(View { instance, session, ..view });
        }
    }
    ViewSet { split, instances, views: views.into_iter().flatten().collect() }
}

/// The camera at each step by odometry alone: z up, origin and heading those of the robot at the first step.
fn dead_reckoned(episode: &Episode) -> Vec<Pose> {
    let observations = &episode.observations;
    let first = episode.truth.world_from_robot[0].rotation;
    let ahead = first * Vector3::x();
    let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), libm::atan2(ahead.y, ahead.x));
    let mut robot = Pose::from_parts(nalgebra::Translation3::identity(), heading.inverse() * first);
    let mut cameras = vec![robot * observations.robot_from_camera];
    for odometry in &observations.odometry {
        robot *= odometry.robot_from_robot;
        cameras.push(robot * observations.robot_from_camera);
    }
    cameras
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sighting::estimated_viewpoints;
    use crate::{
        BoundingBox, Camera, Crop, Detection, DetectionTruth, InstanceId, Observations, Odometry, Seed,
        Symmetry, Truth,
    };
    use approx::assert_relative_eq;
    use nalgebra::{Matrix6, Point3, Vector2};

    /// A camera on its way past two objects, one of which it sees, and a detection of neither; odometry is exact.
    fn episode() -> Episode {
        let camera = Camera { width: 640, height: 480, fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0 };
        let object = |id: u64, family: &str| ObjectTruth {
            instance: InstanceId(id),
            family: family.into(),
            world_from_object: Pose::new(Vector3::new(3.0, -1.0, 0.8), Vector3::z() * 0.4),
            size: 0.3,
            symmetry: Symmetry::None,
            extents: None,
        };
        let target = Point3::new(3.0, -1.0, 0.8);
        let world_from_robot: Vec<Pose> = (0..4)
            .map(|step| {
                let eye = Point3::new(1.0 + 0.4 * f64::from(step), 1.0, 1.3);
                Pose::face_towards(&eye, &target, &-Vector3::z())
            })
            .collect();
        let detection = |(step, track): (usize, usize)| Detection {
            step,
            track,
            bounding_box: BoundingBox { min: Vector2::new(300.0, 220.0), max: Vector2::new(340.0, 260.0) },
            mask_pixels: 900,
            center_depth: None,
            masked_crop: Crop::black(),
            boxed_crop: Crop::black(),
        };
        let seen = [(0, 0), (1, 0), (1, 2), (2, 0), (3, 0)];
        let odometry = world_from_robot.windows(2).enumerate().map(|(from, pair)| Odometry {
            from,
            to: from + 1,
            robot_from_robot: pair[0].inv_mul(&pair[1]),
            covariance: Matrix6::identity(),
        });
        Episode {
            seed: Seed(0),
            observations: Observations {
                timestamps: (0..4).map(f64::from).collect(),
                camera,
                robot_from_camera: Pose::identity(),
                odometry: odometry.collect(),
                detections: seen.into_iter().map(detection).collect(),
                landmarks: Vec::new(),
            },
            truth: Truth {
                objects: vec![object(7, "mug"), object(8, "can")],
                landmarks: Vec::new(),
                detections: seen.iter().map(|_| DetectionTruth { visible_fraction: 0.9 }).collect(),
                world_from_robot,
            },
        }
    }

    #[test]
    fn an_object_s_views_are_what_was_seen_of_it() {
        let set = episode_views(&episode(), Split::Train, &|_| true);
        assert_eq!((set.instances.len(), set.views.len()), (1, 4), "the can was not seen");
        assert_eq!(set.instances[0].id, InstanceId(7));
        let centred = |view: &View| view.box_center_error.iter().all(|error| error.abs() < 1e-9);
        assert!(set.views.iter().all(|view| view.instance == 0 && centred(view)));
        assert!(episode_views(&episode(), Split::Train, &|object| object.family == "can").views.is_empty());
    }

    #[test]
    fn an_instance_of_several_episodes_has_as_many_sessions() {
        let (first, mut second) = (episode(), episode());
        second.observations.detections.retain(|detection| detection.step > 0);
        second.truth.detections.truncate(second.observations.detections.len());
        second.observations.detections[1].track = 1;
        let set = episodes_views([&first, &second], Split::Test, &|_| true);
        let families: Vec<&str> = set.instances.iter().map(|instance| instance.family.as_str()).collect();
        assert_eq!(families, ["mug", "can"]);
        let seen: Vec<(usize, usize)> = set.views.iter().map(|view| (view.instance, view.session)).collect();
        let mug = [(0, 0), (0, 0), (0, 0), (0, 0), (0, 1), (0, 1), (0, 1)];
        assert_eq!(seen, [&mug[..], &[(1, 0)]].concat());
    }

    #[test]
    fn exact_odometry_tells_the_true_changes_of_viewpoint() {
        let set = episode_views(&episode(), Split::Train, &|_| true);
        let sightings: Vec<&Sighting> = set.views.iter().filter_map(|view| view.sighting.as_ref()).collect();
        let estimated = estimated_viewpoints(&sightings);
        let change = |of: &dyn Fn(usize) -> f64| of(3) - of(0);
        let by_odometry = change(&|step| estimated[step].unwrap().azimuth());
        let truly = change(&|step| set.views[step].viewpoint.azimuth());
        assert_relative_eq!(by_odometry, truly, epsilon = 1e-9);
    }
}
