//! From one end of what may come to the other: a typed outcome and finite numbers, never a panic.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::{DVector, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};
use vantage_dataset::{BoundingBox, CenterDepth, Detection, Pose, Seed};
use vantage_slam::noise::Kernel;
use vantage_slam::{Estimate, Outcome, Settings, UnresolvedReason};

pub const DIMS: [usize; 3] = [8, 12, 32];

pub fn model() -> TanhModel {
    TanhModel::new(DIMS, 0.03, 5.0, Seed(1))
}

/// Settings under which an object may be unknown.
fn doubting(spec: &WorldSpec) -> Settings {
    let mut settings = matching_settings(spec);
    settings.semantics.unknown_margin = Some(0.0);
    settings
}

pub fn is_covariance<const N: usize>(covariance: &nalgebra::SMatrix<f64, N, N>) -> bool {
    covariance.iter().all(|x| x.is_finite()) && covariance.diagonal().iter().all(|x| *x >= 0.0)
}

/// The answer, all of whose numbers are finite.
fn run(world: &World, which: Which, model: &TanhModel, settings: &Settings) -> Estimate {
    let answer = estimate(&world.observations, which, Some(model), settings).unwrap();
    assert_eq!(answer.world_from_robot.len(), world.observations.steps());
    assert!(answer.world_from_robot.iter().all(|pose| pose.to_homogeneous().iter().all(|x| x.is_finite())));
    assert!(answer.pose_covariances.iter().flatten().all(is_covariance));
    for object in answer.objects.iter().flatten() {
        assert!(object.position.iter().all(|x| x.is_finite()));
        assert!(object.position_covariance.iter().all(is_covariance));
        assert!(object.orientation.iter().filter_map(|o| o.covariance.as_ref()).all(is_covariance));
        let latent = object.latent.iter().flat_map(|latent| latent.mean.iter().chain(&latent.variance));
        assert!(latent.into_iter().all(|x| x.is_finite()));
    }
    answer
}

#[test]
fn of_symmetric_objects_the_marginal_says_that_yaw_is_free() {
    let spec = WorldSpec::sparse_loop();
    let model = TanhModel::blind_to_azimuth(DIMS, 0.03, 5.0, Seed(1));
    let world = World::new(&spec, Some(&model), Seed(3));
    let answer = run(&world, Which::Semantic, &model, &matching_settings(&spec));
    assert_eq!(answer.outcome, Outcome::Converged);
    for object in answer.objects.iter().flatten() {
        let covariance = object.orientation.unwrap().covariance.unwrap();
        // Which way it leans, of what little it may, is all that tells yaw: by no less than a radian.
        assert!(covariance[(2, 2)] > 1.0, "yaw is free: {covariance}");
        assert!(covariance[(0, 0)] < 0.01 && covariance[(1, 1)] < 0.01, "tilt is not: {covariance}");
    }
}

#[test]
fn one_view_with_a_depth_is_enough_and_says_little() {
    let (spec, model) = (WorldSpec::sparse_loop(), model());
    let mut world = World::new(&spec, Some(&model), Seed(3));
    let camera = world.observations.camera;
    let whole = |d: &&Detection| !d.bounding_box.is_truncated(&camera);
    let only = world.observations.detections.iter().find(whole).unwrap().clone();
    world.observations.detections = vec![only.clone()];
    for which in [Which::Geometric, Which::Semantic] {
        let answer = run(&world, which, &model, &doubting(&spec));
        assert_eq!(answer.outcome, Outcome::NothingObserved);
        assert_eq!(answer.unresolved[0].reason, UnresolvedReason::SeenOnce);
    }
    let world_from_camera = world.world_from_robot[only.step] * world.observations.robot_from_camera;
    let place = world.world_from_object[only.track].translation.vector;
    let meters = world_from_camera.inverse_transform_point(&place.into()).z;
    world.observations.detections[0].center_depth = Some(CenterDepth { meters, sigma: 0.03 });
    for which in [Which::Geometric, Which::Semantic] {
        let answer = run(&world, which, &model, &doubting(&spec));
        assert_eq!(answer.outcome, Outcome::Converged, "{which:?}");
        let object = answer.objects[only.track].as_ref().unwrap();
        assert!((object.position - place).norm() < 0.3, "{which:?}: {} for {place}", object.position);
    }
}

/// A robot that drives at objects which all stand on its own line.
pub fn on_a_line(spec: &WorldSpec, model: &TanhModel) -> World {
    let mut world = World::new(spec, Some(model), Seed(3));
    let steps = spec.steps;
    let forward = Pose::translation(0.05, 0.0, 0.0);
    world.world_from_robot = (0..steps).map(|k| Pose::translation(0.05 * k as f64, 0.0, 0.0)).collect();
    world.observations.odometry.iter_mut().for_each(|o| o.robot_from_robot = forward);
    let axes = Matrix3::from_columns(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    let looking = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    world.observations.robot_from_camera = Pose::from_parts(Translation3::identity(), looking);
    let camera = world.observations.camera;
    let crops: Vec<_> = world.observations.detections.drain(..).map(|d| d.masked_crop).collect();
    for step in 0..steps {
        for track in 0..3 {
            let depth = 5.0 + track as f64 - 0.05 * step as f64;
            let half = Vector2::repeat(camera.fx * 0.1 / depth);
            let centre = Vector2::new(camera.cx, camera.cy);
            let crop = crops[(3 * step + track) % crops.len()].clone();
            world.observations.detections.push(Detection {
                step,
                track,
                bounding_box: BoundingBox { min: centre - half, max: centre + half },
                mask_pixels: 100,
                center_depth: None,
                masked_crop: crop.clone(),
                boxed_crop: crop,
            });
        }
    }
    world
}

#[test]
fn objects_on_the_robots_own_line_have_no_parallax() {
    let (spec, model) = (WorldSpec::sparse_loop(), model());
    let world = on_a_line(&spec, &model);
    for which in [Which::Geometric, Which::Semantic, Which::Uninformative] {
        let answer = run(&world, which, &model, &doubting(&spec));
        assert_eq!(answer.outcome, Outcome::NothingObserved, "{which:?}");
        assert_eq!(answer.unresolved.len(), 3);
        assert!(answer.unresolved.iter().all(|lost| lost.reason == UnresolvedReason::NoParallax));
    }
}

#[test]
fn with_depths_objects_on_the_robots_own_line_are_placed() {
    let (spec, model) = (WorldSpec::sparse_loop(), model());
    let mut world = on_a_line(&spec, &model);
    for detection in &mut world.observations.detections {
        let meters = 5.0 + detection.track as f64 - 0.05 * detection.step as f64;
        detection.center_depth = Some(CenterDepth { meters, sigma: 0.03 });
    }
    for which in [Which::Geometric, Which::Semantic, Which::Uninformative] {
        let answer = run(&world, which, &model, &doubting(&spec));
        assert_eq!(answer.outcome, Outcome::Converged, "{which:?}");
        assert!(world.ate(&answer) < 0.05, "{which:?}: {}", world.ate(&answer));
        assert_eq!(answer.objects.iter().flatten().count(), 3);
    }
}

#[test]
fn a_slip_of_a_metre_is_outcome_and_numbers_and_objects_mend_much_of_it() {
    let (spec, model) = (WorldSpec::sparse_loop(), model());
    let mut world = World::new(&spec, Some(&model), Seed(3));
    let slipped = &mut world.observations.odometry[spec.steps / 2].robot_from_robot;
    *slipped *= Pose::translation(1.0, 0.0, 0.0);
    let mut settings = matching_settings(&spec);
    settings.geometry.bearing_kernel = Kernel::Huber { threshold: 2.0 };
    let of = |which| {
        let answer = run(&world, which, &model, &settings);
        println!("{which:?}: {}, ATE {:.3} m", answer.outcome, world.ate(&answer));
        assert!(!matches!(answer.outcome, Outcome::Diverged | Outcome::Underconstrained { .. }), "{which:?}");
        world.ate(&answer)
    };
    let odometry = of(Which::Odometry);
    for which in [Which::Geometric, Which::Semantic, Which::Uninformative] {
        assert!(of(which) < odometry, "{which:?}");
    }
}

/// Gives some tracks crops that the model has nothing to do with: of another model, or noise.
pub fn spoil(
    world: &mut World,
    spec: &WorldSpec,
    seed: Seed,
    is_spoilt: impl Fn(usize) -> bool,
    noise: bool,
) {
    let other = TanhModel::new(DIMS, 0.03, 5.0, Seed(77));
    let twin = World::new(spec, Some(&other), seed);
    let mut stream = seed.stream("garbage", 0);
    for (detection, of_other) in world.observations.detections.iter_mut().zip(twin.observations.detections) {
        if is_spoilt(detection.track) {
            detection.masked_crop = match noise {
                true => TanhModel::crop(&DVector::from_fn(DIMS[1], |_, _| stream.normal())),
                false => of_other.masked_crop,
            };
        }
    }
}

/// Mean and half the 95% interval of six numbers.
fn interval(numbers: &[f64]) -> (f64, f64) {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, 2.571 * (variance / count).sqrt())
}

#[test]
fn a_model_of_garbage_does_no_harm() {
    let spec = WorldSpec::sparse_loop();
    // What garbage pulls to has no sharp minimum.
    let hasty = |mut settings: Settings| {
        settings.solver.max_iterations = 30;
        settings
    };
    for (noise, nu) in [(false, 5.0), (true, 5.0), (true, f64::INFINITY)] {
        let model = TanhModel::new(DIMS, 0.03, nu, Seed(1));
        let (mut trusting, mut doubtful) = (Vec::new(), Vec::new());
        let (mut unknown, mut all) = (0, 0);
        for seed in (0..6).map(Seed) {
            let mut world = World::new(&spec, Some(&model), seed);
            spoil(&mut world, &spec, seed, |_| true, noise);
            let geometric = world.ate(&run(&world, Which::Geometric, &model, &matching_settings(&spec)));
            let trusted = run(&world, Which::Semantic, &model, &hasty(matching_settings(&spec)));
            trusting.push(world.ate(&trusted) - geometric);
            let answer = run(&world, Which::Semantic, &model, &hasty(doubting(&spec)));
            doubtful.push(world.ate(&answer) - geometric);
            unknown += answer.objects.iter().flatten().filter(|object| object.orientation.is_none()).count();
            all += answer.objects.iter().flatten().count();
        }
        let (before, after) = (interval(&trusting), interval(&doubtful));
        println!(
            "noise {noise}, nu {nu}: trusting {before:.4?}, doubting {after:.4?}, {unknown} of {all} unknown"
        );
        // The Student t alone keeps most of the harm away.
        assert!(nu.is_finite() || before.0 > 0.1, "garbage harms who trusts it: {before:?}");
        assert!(after.0 - after.1 <= 0.0 && after.0 < 0.01, "{after:?}");
        assert!(10 * unknown >= 9 * all, "{unknown} of {all}");
    }
}

#[test]
fn one_unknown_object_leaves_and_the_known_ones_stay() {
    let (spec, model) = (WorldSpec::sparse_loop(), model());
    for seed in (0..4).map(Seed) {
        let mut world = World::new(&spec, Some(&model), seed);
        let trusting = run(&world, Which::Semantic, &model, &matching_settings(&spec));
        let doubtful = run(&world, Which::Semantic, &model, &doubting(&spec));
        assert_eq!(trusting.world_from_robot, doubtful.world_from_robot, "nothing is unknown, {seed:?}");
        spoil(&mut world, &spec, seed, |track| track == 2, true);
        let answer = run(&world, Which::Semantic, &model, &doubting(&spec));
        for (track, object) in answer.objects.iter().enumerate() {
            let Some(object) = object else { continue };
            assert_eq!(object.orientation.is_none(), track == 2, "object {track}, {seed:?}");
        }
        let views = trusting.objects[2].as_ref().map_or(0, |object| object.semantic_views);
        assert_eq!(answer.dropped_detections.unknown_object, views);
    }
}

#[test]
fn ten_thousand_poses() {
    let model = model();
    let spec = WorldSpec { steps: 10_000, odometry_sigma: [0.001, 0.001], ..WorldSpec::sparse_loop() };
    let world = World::new(&spec, Some(&model), Seed(3));
    let mut settings = doubting(&spec);
    settings.semantics.minimum_view_separation = 0.2;
    // Their time goes with the square of the poses: here it is minutes.
    settings.solver.covariances = false;
    let mut ates = Vec::new();
    for which in [Which::Odometry, Which::Geometric, Which::Semantic] {
        let before = std::time::Instant::now();
        let answer = run(&world, which, &model, &settings);
        println!("{which:?}: {}, ATE {:.4} m, {:?}", answer.outcome, world.ate(&answer), before.elapsed());
        assert_eq!(answer.outcome, Outcome::Converged, "{which:?}");
        ates.push(world.ate(&answer));
    }
    assert!(ates[1] < ates[0] && ates[2] < ates[0], "{ates:?}");
}
