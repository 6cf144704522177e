//! Worlds and ways of the shipped scenes and of paths that no shipped scene has.

use crate::scene::{checked, shipped};
use nalgebra::Vector3;
use vantage_dataset::{Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::plan::body;
use vantage_sim::plan::ground::Ground;
use vantage_sim::rollout::{Rollout, roll_out};
use vantage_sim::scene::rule::Interval;
use vantage_sim::scene::{HandheldSpec, PathSpec};

fn rolled_out(spec: SceneSpec, seed: u64) -> (Rollout, Ground) {
    let scene = checked(spec);
    let rollout = roll_out(&scene, Seed(seed), Split::Test, &mut |_| ()).unwrap();
    let ground = rollout.world.ground(&scene.world().room);
    (rollout, ground)
}

fn walking(legs: u32) -> SceneSpec {
    let mut spec = shipped("room");
    spec.robot.path = PathSpec::RandomWalk { legs, leg_length: Interval([1.0, 2.5]), clearance: 0.15 };
    spec.robot.laps = 1.0;
    spec.robot.steps = Some(60);
    spec
}

#[test]
fn every_object_stands_on_its_furniture() {
    for name in ["shelves", "room", "apartment", "corridor", "aliased", "turntable"] {
        for seed in 0..3 {
            let (rollout, _) = rolled_out(shipped(name), seed);
            for (object, pose) in rollout.world.objects.iter().zip(&rollout.world.world_from_object) {
                let at = pose.translation.vector;
                let below = rollout.world.furnishing.stands.iter().filter(|stand| {
                    let gap = at.z - stand.height;
                    stand.spans(&at.xy()) && gap > 0.0 && gap < object.size / 2.0 + 1e-3
                });
                assert!(below.count() > 0, "{name} {seed}: {} at {at:?}", object.family);
            }
        }
    }
}

#[test]
fn random_walks_keep_clear_and_differ_by_seed() {
    let mut ends = Vec::new();
    for seed in 0..3 {
        let (rollout, ground) = rolled_out(walking(8), seed);
        for pose in &rollout.drive.world_from_robot {
            let clearance = ground.clearance(&pose.translation.vector.xy());
            assert!(clearance > body::RADIUS, "seed {seed}: {clearance} m");
        }
        ends.push(rollout.drive.world_from_robot.last().unwrap().translation.vector);
    }
    assert!((ends[0] - ends[1]).norm() > 0.1 && (ends[1] - ends[2]).norm() > 0.1);
}

#[test]
fn a_lawnmower_covers_its_lanes() {
    let mut spec = shipped("corridor");
    spec.world.room.width = 8.0;
    spec.world.room.length = 8.0;
    spec.world.surface = shipped("tabletop").world.surface;
    spec.world.objects = 2;
    spec.robot.path = PathSpec::Lawnmower { length: 6.0, width: 6.0, lanes: 4 };
    let (rollout, _) = rolled_out(spec, 0);
    let track = &rollout.drive.world_from_robot;
    for lane in [-3.0, -1.0, 1.0, 3.0] {
        let on_lane = track.iter().filter(|pose| (pose.translation.y - lane).abs() < 0.05).count();
        assert!(on_lane >= 15, "{on_lane} images on the lane at {lane}");
    }
}

#[test]
fn a_hand_leaves_the_plane_and_a_robot_does_not() {
    let upright = |spec: SceneSpec| {
        let (rollout, _) = rolled_out(spec, 0);
        let tilts = rollout.drive.world_from_robot.iter().map(|pose| (pose.rotation * Vector3::z()).z);
        tilts.fold(1.0, f64::min)
    };
    assert!(upright(shipped("room")) > 1.0 - 1e-6);
    let mut carried = shipped("room");
    carried.robot.handheld = Some(HandheldSpec { sway: 0.05, tilt_deg: 6.0, period: 2.0 });
    assert!(upright(carried) < 5f64.to_radians().cos());
}

#[test]
fn an_apartment_is_visited_in_twelve_directions_from_every_point() {
    let (rollout, ground) = rolled_out(shipped("apartment"), 0);
    let poses = &rollout.drive.world_from_robot;
    assert_eq!(poses.len() % 12, 0);
    assert!((50..250).contains(&(poses.len() / 12)), "{} points", poses.len() / 12);
    for point in poses.chunks_exact(12) {
        assert!(ground.clearance(&point[0].translation.vector.xy()) >= body::RADIUS + 0.1);
        for pair in point.windows(2) {
            let turn = pair[0].inv_mul(&pair[1]);
            assert!(turn.translation.vector.norm() < 1e-9);
            assert!((turn.rotation.angle() - 30f64.to_radians()).abs() < 1e-9);
        }
    }
}

#[test]
fn look_alikes_are_one_category_and_other_instances() {
    let (rollout, _) = rolled_out(shipped("aliased"), 0);
    let objects = &rollout.world.objects;
    assert!(objects.iter().all(|object| object.family == objects[0].family));
    let ids: std::collections::BTreeSet<_> = objects.iter().map(|object| object.id).collect();
    assert_eq!(ids.len(), objects.len());
    let (a, b) = (objects[0].model.texture.level(0), objects[1].model.texture.level(0));
    let texels = a.iter().flatten().zip(b.iter().flatten());
    let apart = texels.map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!((1..=16).contains(&apart), "{apart} levels");
}
