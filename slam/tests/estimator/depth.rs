//! Depths of objects' centres: what they are worth, and what they place.

use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use vantage_dataset::{CenterDepth, Seed};
use vantage_slam::{Estimate, Outcome, UnresolvedReason};

const SIGMA: f64 = 0.03;

fn spec() -> WorldSpec {
    WorldSpec { objects: 4, odometry_sigma: [0.01, 0.03], bearing_sigma: 0.03, ..WorldSpec::sparse_loop() }
}

/// Gives every detection the depth of its object, with noise.
fn with_depth(mut world: World, seed: Seed) -> World {
    let mut stream = seed.stream("depth", 0);
    for detection in &mut world.observations.detections {
        let pose = world.world_from_robot[detection.step] * world.observations.robot_from_camera;
        let z = pose.inv_mul(&world.world_from_object[detection.track]).translation.vector.z;
        let meters = z + SIGMA * stream.normal();
        detection.center_depth = Some(CenterDepth { meters, sigma: SIGMA });
    }
    world
}

fn geometric(world: &World) -> Estimate {
    estimate(&world.observations, Which::Geometric, None, &matching_settings(&spec())).unwrap()
}

#[test]
fn depth_lowers_the_error_of_robot_and_objects() {
    let (mut ate, mut off) = ([0.0; 2], [0.0; 2]);
    for seed in (0..20).map(Seed) {
        let without = World::new(&spec(), None, seed);
        let with = with_depth(World::new(&spec(), None, seed), seed);
        for (i, world) in [without, with].iter().enumerate() {
            let answer = geometric(world);
            assert_eq!(answer.outcome, Outcome::Converged);
            ate[i] += world.ate(&answer) / 20.0;
            for (object, truth) in answer.objects.iter().zip(&world.world_from_object) {
                off[i] += (object.as_ref().unwrap().position - truth.translation.vector).norm() / 80.0;
            }
        }
    }
    println!("ATE {:.3} m without, {:.3} m with depth; centres {off:.3?}", ate[0], ate[1]);
    assert!(ate[1] < 0.95 * ate[0] && off[1] < 0.8 * off[0], "ATE {ate:?}, centres {off:?}");
}

#[test]
fn a_depth_places_what_is_seen_once() {
    let mut world = with_depth(World::new(&spec(), None, Seed(1)), Seed(1));
    let camera = world.observations.camera;
    let whole = |d: &&vantage_dataset::Detection| !d.bounding_box.is_truncated(&camera);
    let once = world.observations.detections.iter().find(whole).unwrap().clone();
    world.observations.detections = vec![once.clone()];
    let answer = geometric(&world);
    let found = answer.objects[once.track].as_ref().unwrap();
    let truth = world.world_from_object[once.track].translation.vector;
    assert!((found.position - truth).norm() < 0.5, "{} {truth}", found.position);
    assert!(found.position_covariance.is_some());
    world.observations.detections[0].center_depth = None;
    let answer = geometric(&world);
    assert_eq!(answer.unresolved[0].reason, UnresolvedReason::SeenOnce);
}
