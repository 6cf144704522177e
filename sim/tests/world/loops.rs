//! Loops that a seed draws, and laps driven the other way.

use crate::scene::{checked, shipped};
use crate::sides::turned;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::error::SimError;
use vantage_sim::plan::body;
use vantage_sim::plan::furnishing::Furnishing;
use vantage_sim::plan::ground::Ground;
use vantage_sim::plan::track::TURN;
use vantage_sim::rollout::{Rollout, roll_out};
use vantage_sim::scene::{Direction, PathSpec, RandomLoopSpec, RobotSpec, StartSpec, SurfaceSpec};

const LOOP: RandomLoopSpec =
    RandomLoopSpec { radius: 2.0, amplitude: 0.25, direction: Direction::CounterClockwise, clearance: 0.1 };
const SEEDS: std::ops::Range<u64> = 0..12;

/// The objects of the tabletop, driven round on a loop in a room that is wide enough.
fn looping(path: RandomLoopSpec) -> SceneSpec {
    let mut spec = shipped("tabletop");
    spec.world.room = shipped("revisit").world.room;
    spec.world.objects = 3;
    spec.robot = RobotSpec { path: PathSpec::RandomLoop(path), laps: 1.5, steps: Some(300), ..spec.robot };
    spec
}

fn rolled_out(spec: &SceneSpec, seed: u64) -> Result<(Rollout, Ground), SimError> {
    let scene = checked(spec.clone());
    let rollout = roll_out(&scene, Seed(seed), Split::Test, &mut |_| ())?;
    let ground = rollout.world.ground(&scene.world().room);
    Ok((rollout, ground))
}

fn positions(rollout: &Rollout) -> Vec<Vector2<f64>> {
    rollout.drive.world_from_robot.iter().map(|pose| pose.translation.vector.xy()).collect()
}

/// By how much the direction from the origin turns, radians, counter-clockwise.
fn swept(positions: &[Vector2<f64>]) -> f64 {
    positions.windows(2).map(|pair| libm::atan2(pair[0].perp(&pair[1]), pair[0].dot(&pair[1]))).sum()
}

#[test]
fn loops_differ_by_seed_keep_clear_and_close() {
    let mut shapes = Vec::new();
    for seed in SEEDS {
        let (rollout, ground) = rolled_out(&looping(LOOP), seed).unwrap();
        let way = positions(&rollout);
        for at in &way {
            assert!(ground.clearance(at) > body::RADIUS + 0.05, "seed {seed}: {} m", ground.clearance(at));
            assert!((1.45..2.55).contains(&at.norm()), "seed {seed}: {} m", at.norm());
        }
        assert!(
            (swept(&way) / (2.0 * PI) - 1.5).abs() < 0.1,
            "seed {seed}: {} laps",
            swept(&way) / (2.0 * PI)
        );
        let after_a_lap = way[200..].iter().map(|at| (at - way[0]).norm()).fold(f64::INFINITY, f64::min);
        let stride = (way[1] - way[0]).norm();
        assert!(after_a_lap < stride, "seed {seed}: {after_a_lap} m");
        let radii = || way.iter().map(|at| at.norm());
        shapes.push(radii().fold(0.0, f64::max) / radii().fold(f64::INFINITY, f64::min));
        let again = positions(&rolled_out(&looping(LOOP), seed).unwrap().0);
        assert_eq!(way, again, "seed {seed}");
    }
    assert!(shapes.iter().all(|ratio| (1.1..1.67).contains(ratio)), "{shapes:?}");
    assert!(shapes.windows(2).all(|pair| pair[0] != pair[1]), "{shapes:?}");
}

#[test]
fn the_seed_draws_the_direction_where_either_will_do() {
    let path = RandomLoopSpec { direction: Direction::Either, ..LOOP };
    let ways: Vec<_> = SEEDS.map(|seed| positions(&rolled_out(&looping(path), seed).unwrap().0)).collect();
    let clockwise = ways.iter().filter(|way| swept(way) < 0.0).count();
    assert!((2..=10).contains(&clockwise), "{clockwise} of 12");
    // Of the others the loops are the same.
    for (seed, way) in SEEDS.zip(&ways).filter(|(_, way)| swept(way) > 0.0) {
        assert_eq!(way, &positions(&rolled_out(&looping(LOOP), seed).unwrap().0), "seed {seed}");
    }
}

#[test]
fn a_loop_goes_between_furniture_and_says_where_it_cannot() {
    let mut spec = shipped("room");
    let path = RandomLoopSpec {
        radius: 1.3,
        amplitude: 0.2,
        direction: Direction::CounterClockwise,
        clearance: 0.05,
    };
    spec.robot = RobotSpec { path: PathSpec::RandomLoop(path), laps: 1.0, ..spec.robot };
    for seed in 0..4 {
        let (rollout, ground) = rolled_out(&spec, seed).unwrap();
        for at in positions(&rollout) {
            assert!(ground.clearance(&at) > body::RADIUS, "seed {seed}: {} m", ground.clearance(&at));
        }
    }
    let SurfaceSpec::Furniture(pieces) = &mut spec.world.surface else { panic!("furniture") };
    // From the table to the wall.
    pieces.truncate(1);
    pieces.push(vantage_sim::scene::PieceSpec::Block { at: [2.35, 0.0], size: [3.3, 0.3, 1.0] });
    let got = rolled_out(&spec, 0).err().unwrap();
    assert!(matches!(got, SimError::NoLoop { .. }) && got.to_string().contains("clear the room"), "{got}");
}

#[test]
fn too_sharp_a_loop_is_none() {
    let spec = looping(RandomLoopSpec { radius: 0.5, amplitude: 0.5, clearance: 0.0, ..LOOP });
    let ground = Ground::new(&spec.world.room, Vec::new());
    let mut physics = vantage_sim::physics::Physics::new(&Furnishing::default(), &[]);
    let got = vantage_sim::robot::drive(&mut physics, &spec.robot, &ground, Seed(0), &mut |_| ());
    assert!(matches!(got, Err(SimError::NoLoop { .. })), "{got:?}");
}

/// Round the pedestals, with a camera that looks ahead.
fn reversing(laps: f64, reverse_after: Option<f64>) -> SceneSpec {
    let mut spec = shipped("sparse_loop");
    spec.robot = RobotSpec { laps, reverse_after, steps: Some(240), ..spec.robot };
    spec.robot.camera.yaw_deg = 0.0;
    spec.world.surface = SurfaceSpec::Pedestals { radius: 0.22, height: 0.85, offset: 1.0 };
    spec.sensors.camera.width = 160;
    spec.sensors.camera.height = 120;
    spec.sensors.detector.min_mask_pixels = 25;
    spec
}

#[test]
fn a_robot_that_turns_round_drives_the_same_way_back() {
    for path in [None, Some(LOOP)] {
        let mut spec = path.map_or_else(|| reversing(2.0, Some(1.0)), looping);
        spec.robot = RobotSpec { laps: 2.0, reverse_after: Some(1.0), steps: Some(600), ..spec.robot };
        let (rollout, ground) = rolled_out(&spec, 3).unwrap();
        let way = positions(&rollout);
        let length: f64 = way.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let turn = (600.0 * TURN / length) as usize;
        let last_out = (600 - turn) / 2;
        let heading = |step: usize| (rollout.drive.world_from_robot[step].rotation * Vector3::x()).xy();
        for step in (0..last_out - 10).step_by(20) {
            let nearest = (last_out + turn..600)
                .min_by(|a, b| (way[*a] - way[step]).norm().total_cmp(&(way[*b] - way[step]).norm()));
            let back = nearest.unwrap();
            assert!(
                (way[back] - way[step]).norm() < 0.1,
                "step {step}: {} m",
                (way[back] - way[step]).norm()
            );
            assert!(heading(back).dot(&heading(step)) < -0.98, "step {step}");
        }
        assert!(way.iter().all(|at| ground.clearance(at) > body::RADIUS));
        assert!(swept(&way).abs() < 0.3, "{}", swept(&way));
    }
}

#[test]
fn the_way_back_sees_objects_from_the_other_side() {
    let degrees = |spec: &SceneSpec| turned(spec, 5, 0.5);
    let (there, back) = (degrees(&reversing(2.0, None)), degrees(&reversing(2.0, Some(1.0))));
    println!("mean change of azimuth: {there:.0} degrees on the same way round, {back:.0} on the way back");
    assert!(there < 20.0, "{there}");
    assert!(back > 90.0, "{back}");
}

#[test]
fn a_turn_into_a_wall_is_the_error_of_the_seeds_that_begin_there() {
    let mut spec = reversing(1.5, Some(1.0));
    // The path is 8 m by 6 m: room for its turn at the beginning, on a long side, but not on the short sides.
    spec.world.room.length = 8.9;
    spec.robot.start = StartSpec::Anywhere;
    let refused: Vec<u64> = SEEDS
        .filter(|&seed| match rolled_out(&spec, seed) {
            Ok(_) => false,
            Err(SimError::BlockedPath { gap, .. }) => gap < body::RADIUS,
            Err(other) => panic!("{other}"),
        })
        .collect();
    assert!(!refused.is_empty() && refused.len() < SEEDS.count(), "{refused:?}");
}
