//! Point landmarks as variables: what they are worth, and what is left out.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::{Vector2, Vector3};
use vantage_dataset::{LandmarkSighting, Seed};
use vantage_slam::noise::Kernel;
use vantage_slam::{Estimate, Outcome, Settings, UnresolvedReason};

const PIXEL_SIGMA: f64 = 1.0;

fn spec() -> WorldSpec {
    WorldSpec { objects: 3, ..WorldSpec::sparse_loop() }
}

/// Landmarks on a ring behind the objects, in the frame of the first pose, and their sightings with noise.
fn with_landmarks(mut world: World, count: usize, seed: Seed) -> (World, Vec<Vector3<f64>>) {
    let mut stream = seed.stream("landmarks", 0);
    let center = world.world_from_robot[0].transform_point(&Vector3::new(0.0, 2.0, 0.0).into());
    let landmarks: Vec<Vector3<f64>> = (0..count)
        .map(|_| {
            let (angle, radius) = (stream.uniform(-3.2, 3.2), stream.uniform(4.5, 6.0));
            center.coords
                + Vector3::new(radius * angle.cos(), radius * angle.sin(), stream.uniform(-1.0, 1.5))
        })
        .collect();
    let camera = world.observations.camera;
    for (step, world_from_robot) in world.world_from_robot.iter().enumerate() {
        let world_from_camera = world_from_robot * world.observations.robot_from_camera;
        for (landmark, point) in landmarks.iter().enumerate() {
            let p = world_from_camera.inverse_transform_point(&(*point).into());
            let Some(exact) = camera.project(&p) else { continue };
            let pixel = exact + Vector2::new(stream.normal(), stream.normal()) * PIXEL_SIGMA;
            let size = Vector2::new(f64::from(camera.width), f64::from(camera.height));
            if pixel.min() >= 0.0 && (size - pixel).min() > 0.0 {
                let sighting = LandmarkSighting { step, landmark, pixel, sigma: PIXEL_SIGMA };
                world.observations.landmarks.push(sighting);
            }
        }
    }
    (world, landmarks)
}

fn world(count: usize, seed: Seed) -> (World, Vec<Vector3<f64>>) {
    with_landmarks(World::new(&spec(), None, seed), count, seed)
}

fn geometric(world: &World) -> Estimate {
    estimate(&world.observations, Which::Geometric, None, &matching_settings(&spec())).unwrap()
}

#[test]
fn landmarks_lower_the_error_and_are_where_they_are_thought_to_be() {
    let (mut without, mut with, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
    for seed in (0..10).map(Seed) {
        let (seen, landmarks) = world(30, seed);
        let answer = geometric(&seen);
        assert_eq!(answer.outcome, Outcome::Converged);
        with += seen.ate(&answer) / 10.0;
        without += seen.ate(&geometric(&world(0, seed).0)) / 10.0;
        assert!(answer.landmarks.len() >= 25, "{} placed", answer.landmarks.len());
        for (&landmark, found) in &answer.landmarks {
            let error = found.position - landmarks[landmark];
            squares += error.dot(&found.covariance.unwrap().cholesky().unwrap().solve(&error));
            count += 3.0;
            assert!(found.sightings >= 2);
        }
    }
    println!("ATE {without:.3} m without, {with:.3} m with landmarks; NEES {:.2}", squares / count);
    assert!(with < 0.5 * without, "{with} m with landmarks, {without} m without");
    assert!((0.6..1.5).contains(&(squares / count)), "NEES per number {}", squares / count);
}

#[test]
fn a_landmark_without_noise_is_found_exactly() {
    let exact = WorldSpec { objects: 3, ..WorldSpec::sparse_loop() }.noiseless();
    let (mut seen, landmarks) = with_landmarks(World::new(&exact, None, Seed(1)), 20, Seed(1));
    for sighting in &mut seen.observations.landmarks {
        let pose = seen.world_from_robot[sighting.step] * seen.observations.robot_from_camera;
        let p = pose.inverse_transform_point(&landmarks[sighting.landmark].into());
        sighting.pixel = seen.observations.camera.project(&p).unwrap();
    }
    let answer = geometric(&seen);
    assert!(seen.ate(&answer) < 1e-6);
    assert!(!answer.landmarks.is_empty());
    for (&landmark, found) in &answer.landmarks {
        assert!((found.position - landmarks[landmark]).norm() < 1e-5);
    }
}

#[test]
fn the_order_of_sightings_changes_nothing_and_odometry_alone_ignores_them() {
    let (mut seen, _) = world(20, Seed(2));
    let before = geometric(&seen);
    seen.observations.landmarks.reverse();
    let after = geometric(&seen);
    assert_eq!(before.landmarks, after.landmarks);
    assert_eq!(before.world_from_robot, after.world_from_robot);
    let settings = matching_settings(&spec());
    let odometry = estimate(&seen.observations, Which::Odometry, None, &settings).unwrap();
    assert!(odometry.landmarks.is_empty() && odometry.unresolved_landmarks.is_empty());
}

#[test]
fn every_estimator_of_boxes_has_them() {
    let model = TanhModel::new([4, 6, 8], 0.03, 5.0, Seed(1));
    let world = World::new(&spec(), Some(&model), Seed(3));
    let (seen, _) = with_landmarks(world, 20, Seed(3));
    for which in [Which::Geometric, Which::Semantic, Which::Uninformative] {
        let answer = estimate(&seen.observations, which, Some(&model), &matching_settings(&spec())).unwrap();
        assert_eq!(answer.outcome, Outcome::Converged, "{which:?}");
        assert!(answer.landmarks.len() >= 15, "{which:?}");
    }
}

#[test]
fn landmarks_alone_are_observations() {
    let (mut seen, _) = world(30, Seed(4));
    seen.observations.detections.clear();
    let answer = geometric(&seen);
    assert_eq!(answer.outcome, Outcome::Converged);
    assert!(seen.ate(&answer) < 0.2, "{}", seen.ate(&answer));
}

/// A sighting of landmark `landmark` at each of some steps of a robot that goes straight on, looking ahead along y.
fn seen_from(at: &[(usize, [f64; 2])], landmark: usize) -> World {
    let (mut world, _) = world(0, Seed(5));
    world.observations.detections.clear();
    for &(step, pixel) in at {
        let sighting = LandmarkSighting { step, landmark, pixel: pixel.into(), sigma: 1.0 };
        world.observations.landmarks.push(sighting);
    }
    world
}

#[test]
fn what_cannot_be_placed_is_left_out_and_counted() {
    let exact = spec().noiseless();
    let seen = World::new(&exact, None, Seed(5));
    let camera = seen.observations.camera;
    let pixel_of = |step: usize, point: Vector3<f64>| {
        let pose = seen.world_from_robot[step] * seen.observations.robot_from_camera;
        let p = pose.inverse_transform_point(&point.into());
        // The pixel of a point behind the camera is that of the opposite ray.
        [camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy]
    };
    let once = seen_from(&[(4, [100.0, 100.0])], 3);
    let far = {
        let mount = seen.world_from_robot[0] * seen.observations.robot_from_camera;
        let point = mount.transform_point(&Vector3::new(0.0, 0.0, 1e6).into()).coords;
        seen_from(&[(0, pixel_of(0, point)), (1, pixel_of(1, point))], usize::MAX)
    };
    let behind = {
        let pose = |step: usize| seen.world_from_robot[step] * seen.observations.robot_from_camera;
        let point = pose(0).transform_point(&Vector3::new(0.0, 0.0, -3.0).into()).coords;
        seen_from(&[(0, pixel_of(0, point)), (1, pixel_of(1, point)), (2, pixel_of(2, point))], 8)
    };
    for (mut world, landmark, reason, sightings) in [
        (once, 3, UnresolvedReason::SeenOnce, 1),
        (far, usize::MAX, UnresolvedReason::NoParallax, 2),
        (behind, 8, UnresolvedReason::BehindCamera, 3),
    ] {
        world.observations.odometry = seen.observations.odometry.clone();
        let answer = geometric(&world);
        assert_eq!(answer.outcome, Outcome::NothingObserved);
        assert!(answer.landmarks.is_empty());
        assert_eq!(answer.dropped_detections.unresolved_landmark, sightings);
        let [lost] = answer.unresolved_landmarks[..] else { panic!("{:?}", answer.unresolved_landmarks) };
        assert_eq!((lost.landmark, lost.reason), (landmark, reason));
    }
}

#[test]
fn a_wrong_sighting_is_outweighed_by_the_kernel() {
    let (mut seen, _) = world(40, Seed(6));
    let robust = |kernel| {
        let mut settings: Settings = matching_settings(&spec());
        settings.geometry.bearing_kernel = kernel;
        settings
    };
    for (i, sighting) in seen.observations.landmarks.iter_mut().enumerate() {
        if i % 20 == 0 {
            sighting.pixel = Vector2::new(sighting.pixel.y, 384.0 - sighting.pixel.x * 0.7);
        }
    }
    let ate = |kernel| {
        let answer = estimate(&seen.observations, Which::Geometric, None, &robust(kernel)).unwrap();
        assert!(answer.world_from_robot.iter().all(|p| p.to_homogeneous().iter().all(|x| x.is_finite())));
        seen.ate(&answer)
    };
    let (gaussian, huber) = (ate(Kernel::Gaussian), ate(Kernel::Huber { threshold: 2.0 }));
    assert!(huber < 0.5 * gaussian, "Huber {huber} m, Gaussian {gaussian} m");
}
