//! Physics, odometry and labels: the same bits for the same seed, whatever the number of threads.

use crate::scene::{checked, shipped, small};
use vantage_dataset::{Pose, Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::rollout::{Rollout, roll_out};

/// Digests of episode 0 of the shipped scenes. A change of objects, physics, paths, odometry or scene files re-mints
/// them, and says in the changelog why.
const PINNED: [(&str, &str); 2] =
    [("tabletop", "b2f22cb8d8333a2c ab1d59a08ca83476"), ("sparse_loop", "83311d849f92661d ac4b1a97d36e17a3")];

fn rollout(spec: SceneSpec, seed: u64) -> Rollout {
    roll_out(&checked(spec), Seed(seed), Split::Test, &mut |_| ()).unwrap()
}

fn add_pose(hasher: &mut blake3::Hasher, pose: &Pose) {
    for x in pose.translation.vector.iter().chain(pose.rotation.coords.iter()) {
        hasher.update(&x.to_bits().to_le_bytes());
    }
}

fn poses_digest(rollout: &Rollout) -> String {
    let mut hasher = blake3::Hasher::new();
    for (time, pose) in rollout.drive.timestamps.iter().zip(&rollout.drive.world_from_robot) {
        hasher.update(&time.to_bits().to_le_bytes());
        add_pose(&mut hasher, pose);
    }
    for object in rollout.world.truth() {
        hasher.update(&object.instance.0.to_le_bytes());
        hasher.update(object.family.as_bytes());
        hasher.update(&object.size.to_bits().to_le_bytes());
        add_pose(&mut hasher, &object.world_from_object);
    }
    hasher.finalize().to_hex().to_string()
}

fn odometry_digest(rollout: &Rollout) -> String {
    let mut hasher = blake3::Hasher::new();
    for odometry in &rollout.odometry {
        add_pose(&mut hasher, &odometry.robot_from_robot);
        for x in odometry.covariance.iter() {
            hasher.update(&x.to_bits().to_le_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}

fn digest(rollout: &Rollout) -> String {
    format!("{} {}", &poses_digest(rollout)[..16], &odometry_digest(rollout)[..16])
}

#[test]
fn shipped_episodes_are_pinned_under_one_and_two_threads() {
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let got = PINNED.map(|(name, _)| pool.install(|| digest(&rollout(shipped(name), 0))));
        assert_eq!(got, PINNED.map(|(_, digest)| digest), "with {threads} threads");
    }
}

#[test]
fn another_seed_is_another_world() {
    let (a, b) = (rollout(small(), 1), rollout(small(), 2));
    assert_ne!(poses_digest(&a), poses_digest(&b));
    assert_ne!(odometry_digest(&a), odometry_digest(&b));
    let instances = |rollout: &Rollout| rollout.world.truth().iter().map(|o| o.instance).collect::<Vec<_>>();
    assert!(instances(&a).iter().all(|id| !instances(&b).contains(id)));
}

#[test]
fn other_odometry_noise_leaves_the_world_alone() {
    let mut noisy = small();
    noisy.sensors.odometry.translation_per_metre *= 2.0;
    let (a, b) = (rollout(small(), 1), rollout(noisy, 1));
    assert_eq!(poses_digest(&a), poses_digest(&b));
    assert_ne!(odometry_digest(&a), odometry_digest(&b));
}

#[test]
fn other_light_and_cameras_leave_poses_and_odometry_alone() {
    let mut lit = small();
    lit.world.lighting = crate::scene::even_light();
    lit.sensors.camera.width = 200;
    lit.robot.camera.pitch_deg = -5.0;
    let (a, b) = (rollout(small(), 1), rollout(lit, 1));
    assert_eq!(digest(&a), digest(&b));
}
