//! A robot that is carried somewhere between two images.

use crate::scene::{checked, shipped};
use vantage_dataset::{Pose, Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::rollout::{Rollout, roll_out};

fn carried(after: Option<f64>) -> SceneSpec {
    let mut spec = shipped("aliased");
    (spec.robot.laps, spec.robot.steps, spec.robot.carried_after) = (2.0, Some(201), after);
    spec
}

fn rolled_out(after: Option<f64>, seed: u64) -> Rollout {
    roll_out(&checked(carried(after)), Seed(seed), Split::Test, &mut |_| ()).unwrap()
}

#[test]
fn a_robot_is_set_down_somewhere_on_its_path_and_drives_on() {
    let mut places = Vec::new();
    for seed in 0..4 {
        let rollout = rolled_out(Some(1.2), seed);
        assert_eq!(rollout.drive.carried, Some(121));
        let poses = &rollout.drive.world_from_robot;
        let moved = |step: usize| poses[step].inv_mul(&poses[step - 1]).translation.vector.norm();
        assert!((1..201).filter(|step| *step != 121).all(|step| moved(step) < 0.25), "seed {seed}");
        for pose in poses {
            assert!((pose.translation.vector.xy().norm() - 3.0).abs() < 0.1, "seed {seed}: off the circle");
        }
        places.push(moved(121));
        let plain = rolled_out(None, seed);
        assert_eq!(poses[..121], plain.drive.world_from_robot[..121], "seed {seed}");
        let of = |rollout: &Rollout, step: usize| rollout.odometry[step - 1].clone();
        assert_eq!(of(&rollout, 120), of(&plain, 120));
        let lifted = of(&rollout, 121);
        assert_eq!(lifted.robot_from_robot, Pose::identity());
        assert!(lifted.covariance[(2, 2)] > 4.0 && lifted.covariance[(3, 3)] > 9.0);
        assert!(of(&rollout, 122).covariance[(3, 3)] < 0.01, "it drives on");
    }
    assert!(places.iter().any(|far| *far > 1.5), "{places:?}");
}
