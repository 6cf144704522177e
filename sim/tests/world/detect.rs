use crate::scene::{checked, even_light, small};
use nalgebra::{Point3, Translation3, Vector3};
use std::sync::Arc;
use vantage_dataset::{Camera, Detection, DetectionTruth, Pose, Seed, Split};
use vantage_sim::object::Object;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Light, Placement, RenderScene, Renderer, Shot};
use vantage_sim::robot::mount::looking;
use vantage_sim::scene::Family;
use vantage_sim::scene::{DetectorSpec, RobotSpec};
use vantage_sim::sensor::detector::{Target, detect};
use vantage_sim::simulate;

const DETECTOR: DetectorSpec =
    DetectorSpec { min_visible_fraction: 0.1, min_mask_pixels: 10, faults: None, depth_sigma: None };

/// Objects of one family at given points, seen by a level camera at the origin that looks along x.
struct Arrangement {
    shot: Shot,
    scene: RenderScene,
    targets: Vec<Target>,
}

impl Arrangement {
    fn of(family: Family, points: &[[f64; 3]]) -> Self {
        let light = Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] };
        let objects = (0..).map(|i| Object::generate(family, Split::Test, Seed(5), i));
        let mut scene = RenderScene { placements: Vec::new(), light, background: [0; 3] };
        let mut targets = Vec::new();
        for (i, (&[x, y, z], object)) in points.iter().zip(objects).enumerate() {
            let world_from_object = Pose::from(Translation3::new(x, y, z));
            let placement = Placement {
                model: Arc::clone(&object.model),
                world_from_model: world_from_object,
                id: i as u32 + 1,
            };
            let alone = RenderScene { placements: vec![placement.clone()], light, background: [0; 3] };
            targets.push(Target { world_from_object, half_extents: object.half_extents, alone });
            scene.placements.push(placement);
        }
        let shot = Shot {
            camera: Camera::with_horizontal_fov(320, 240, 1.0),
            world_from_camera: Pose::from_parts(Translation3::identity(), looking(0.0, 0.0)),
        };
        Self { shot, scene, targets }
    }

    fn detections(&self, spec: &DetectorSpec) -> Vec<(Detection, DetectionTruth)> {
        let mut renderer = ReferenceRenderer::default();
        let frame = renderer.frame(&self.scene, &self.shot).unwrap();
        detect(spec, &self.targets, 7, &self.shot, &frame, &mut renderer, Seed(0)).unwrap()
    }
}

#[test]
fn a_box_is_where_the_object_is() {
    for point in [[1.0, 0.0, 0.0], [1.5, 0.4, -0.2], [2.0, -0.7, 0.4]] {
        let arrangement = Arrangement::of(Family::Crate, &[point]);
        let seen = arrangement.detections(&DETECTOR);
        assert_eq!(seen.len(), 1);
        let (detection, truth) = &seen[0];
        let camera = arrangement.shot.camera;
        let p_in_camera = arrangement.shot.world_from_camera.inverse() * Point3::from(point);
        let bearing = camera.project(&p_in_camera).unwrap();
        let off = (detection.bounding_box.center() - bearing).norm();
        let side = detection.bounding_box.side();
        assert!(off < 0.1 * side, "{off} pixels off, box {side} pixels");
        let extent = arrangement.targets[0].half_extents;
        let widest = 2.0 * camera.fx * extent.xy().norm() / (p_in_camera.z - extent.xy().norm()) + 2.0;
        assert!(detection.bounding_box.side() <= widest.max(widest * extent.z / extent.x));
        assert_eq!((detection.step, detection.track), (7, 0));
        assert!(truth.visible_fraction > 0.95, "{}", truth.visible_fraction);
        assert!(!detection.bounding_box.is_truncated(&camera));
    }
}

#[test]
fn an_occluder_and_the_border_take_their_share() {
    let whole = Arrangement::of(Family::Crate, &[[1.0, 0.0, 0.0]]).detections(&DETECTOR);
    let arrangement = Arrangement::of(Family::Crate, &[[1.0, 0.0, 0.0], [0.7, 0.09, 0.0]]);
    let seen = arrangement.detections(&DETECTOR);
    let tracks: Vec<usize> = seen.iter().map(|(detection, _)| detection.track).collect();
    assert_eq!(tracks, [0, 1]);
    let share = f64::from(seen[0].0.mask_pixels) / f64::from(whole[0].0.mask_pixels);
    assert!(share < 0.9, "the crate in front hides nothing: {share}");
    assert!((seen[0].1.visible_fraction - share).abs() < 0.03, "{} {share}", seen[0].1.visible_fraction);
    assert!(seen[1].1.visible_fraction > 0.97);
    let strict = DetectorSpec { min_visible_fraction: 0.95, ..DETECTOR };
    let tracks: Vec<usize> = arrangement.detections(&strict).iter().map(|(d, _)| d.track).collect();
    assert_eq!(tracks, [1]);

    let edge = 1.5 * (0.5_f64).tan();
    let cut = Arrangement::of(Family::Crate, &[[1.5, edge, 0.0]]).detections(&DETECTOR);
    assert!(cut[0].0.bounding_box.is_truncated(&Camera::with_horizontal_fov(320, 240, 1.0)));
    assert!((cut[0].1.visible_fraction - 0.5).abs() < 0.15, "{}", cut[0].1.visible_fraction);
}

#[test]
fn a_masked_crop_is_the_boxed_one_without_the_rest() {
    let arrangement = Arrangement::of(Family::Duck, &[[1.5, 0.0, 0.0], [1.2, 0.1, -0.05]]);
    for (detection, _) in arrangement.detections(&DETECTOR) {
        let pairs = detection.masked_crop.0.iter().zip(detection.boxed_crop.0.iter());
        assert!(pairs.clone().all(|(masked, boxed)| masked <= boxed));
        assert!(pairs.filter(|(masked, boxed)| masked == boxed).count() > 1000);
    }
}

#[test]
fn few_pixels_are_no_detection() {
    let far = Arrangement::of(Family::Mug, &[[30.0, 0.0, 0.0]]);
    assert!(far.detections(&DETECTOR).is_empty());
}

#[test]
fn an_episode_lines_up_with_its_truth() {
    let scene = checked(small());
    let episode =
        simulate(&scene, Seed(4), Split::Test, &mut ReferenceRenderer::default(), &mut |_| ()).unwrap();
    let (observations, truth) = (&episode.observations, &episode.truth);
    assert_eq!(observations.steps(), 8);
    assert_eq!(observations.odometry.len(), 7);
    assert_eq!(truth.world_from_robot.len(), 8);
    assert_eq!(truth.detections.len(), observations.detections.len());
    assert!(observations.detections.len() > 8, "{} detections", observations.detections.len());
    assert!(observations.detections.is_sorted_by_key(|d| (d.step, d.track)));
    for detection in &observations.detections {
        let world_from_camera = truth.world_from_robot[detection.step] * observations.robot_from_camera;
        let object = &truth.objects[detection.track];
        let center = world_from_camera.inv_mul(&object.world_from_object).translation.vector;
        let bearing = observations.camera.project(&Point3::from(center)).unwrap();
        let off = (detection.bounding_box.center() - bearing).norm();
        let reach = observations.camera.fx * object.size / 2.0 / center.z;
        assert!(off < reach, "step {} track {}: {off} of {reach} pixels", detection.step, detection.track);
    }
}

#[test]
fn a_robot_that_looks_away_sees_nothing() {
    let mut spec = small();
    spec.robot = RobotSpec {
        camera: vantage_sim::scene::MountSpec { pitch_deg: 70.0, ..spec.robot.camera },
        ..spec.robot
    };
    spec.world.lighting = even_light();
    let mut renderer = ReferenceRenderer::default();
    let episode = simulate(&checked(spec), Seed(1), Split::Test, &mut renderer, &mut |_| ()).unwrap();
    assert_eq!(episode.observations.detections.len(), 0);
    assert_eq!(episode.observations.tracks(), 0);
    assert_eq!(episode.observations.steps(), 8);
}
