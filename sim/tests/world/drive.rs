use crate::scene::{checked, shipped};
use nalgebra::{Vector2, Vector3};
use vantage_dataset::Seed;
use vantage_dataset::Split;
use vantage_sim::error::SimError;
use vantage_sim::physics::Physics;
use vantage_sim::plan::furnishing::Furnishing;
use vantage_sim::plan::ground::Ground;
use vantage_sim::plan::stand::{Outline, Stand};
use vantage_sim::plan::track::Track;
use vantage_sim::robot::{Drive, drive};
use vantage_sim::rollout::roll_out;
use vantage_sim::scene::RobotSpec;

fn driven(robot: &RobotSpec, furnishing: Furnishing) -> Result<Drive, SimError> {
    let room = shipped("sparse_loop").world.room;
    let ground = Ground::new(&room, Vec::new());
    drive(&mut Physics::new(&furnishing, &[]), robot, &ground, Seed(0), &mut |_| ())
}

#[test]
fn a_whole_lap_ends_where_it_began() {
    for name in ["tabletop", "sparse_loop"] {
        let mut robot = shipped(name).robot;
        robot.laps = 1.0;
        let drive = driven(&robot, Furnishing::default()).unwrap();
        let (first, last) = (drive.world_from_robot[0], *drive.world_from_robot.last().unwrap());
        let apart = first.inv_mul(&last);
        assert!(apart.translation.vector.norm() < 0.05, "{name}: {apart}");
        assert!(apart.rotation.angle() < 0.05, "{name}: {apart}");
    }
}

#[test]
fn the_robot_keeps_to_the_floor_and_its_pace() {
    let robot = shipped("sparse_loop").robot;
    let steps = robot.steps.unwrap();
    let drive = driven(&robot, Furnishing::default()).unwrap();
    assert_eq!(drive.world_from_robot.len(), steps as usize);
    let length = Track::fixed(&robot.path).unwrap().length();
    let stride = robot.laps * length / f64::from(steps - 1);
    for (step, pair) in drive.world_from_robot.windows(2).enumerate() {
        let moved = pair[0].inv_mul(&pair[1]).translation.vector;
        assert!((moved.norm() - stride).abs() < 0.05 * stride, "step {step}: {} of {stride}", moved.norm());
        assert!(moved.x > 0.9 * stride, "step {step}: the robot drives forward, not {moved}");
        let seconds = drive.timestamps[step + 1] - drive.timestamps[step];
        assert!((stride / seconds - robot.speed).abs() < 0.01 * robot.speed);
    }
    for pose in &drive.world_from_robot {
        assert!(pose.translation.z.abs() < 2e-3, "the robot is {} m above the floor", pose.translation.z);
        assert!((pose.rotation * Vector3::z()).z > 1.0 - 1e-6);
    }
}

#[test]
fn a_blocked_path_is_an_error() {
    let robot = shipped("sparse_loop").robot;
    let center = Track::fixed(&robot.path).unwrap().waypoint(4.0).position;
    let block = Stand::solid(center, 0.5, Outline::Rectangle { half_extents: [0.5, 0.5] });
    let got = driven(&robot, Furnishing { stands: vec![block], ..Furnishing::default() });
    assert!(matches!(got, Err(SimError::LeftThePath { step: 10..30, .. })), "{got:?}");
}

#[test]
fn the_loop_is_seen_closing() {
    let scene = checked(shipped("sparse_loop"));
    let rollout = roll_out(&scene, Seed(1), Split::Test, &mut |_| ()).unwrap();
    let lap = rollout.drive.world_from_robot.iter().skip(60);
    let start = rollout.drive.world_from_robot[0].translation.vector.xy();
    let nearest = lap.map(|pose| (pose.translation.vector.xy() - start).norm()).fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.15, "{nearest} m");
    let drifted =
        rollout.odometry.iter().fold(rollout.drive.world_from_robot[0], |pose, u| pose * u.robot_from_robot);
    let last = rollout.drive.world_from_robot.last().unwrap();
    let drift: Vector2<f64> = (drifted.translation.vector - last.translation.vector).xy();
    assert!((0.02..4.0).contains(&drift.norm()), "{} m of drift", drift.norm());
}
