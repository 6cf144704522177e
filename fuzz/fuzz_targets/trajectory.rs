//! TUM trajectories: what reads has finite poses, one a timestamp, and timestamps that do not go back.

#![no_main]

use libfuzzer_sys::fuzz_target;
use vantage_formats::Trajectory;

fuzz_target!(|text: &str| {
    let Ok(trajectory) = Trajectory::from_tum(text) else { return };
    assert_eq!(trajectory.timestamps().len(), trajectory.world_from_robot().len());
    assert!(trajectory.timestamps().windows(2).all(|pair| pair[0] <= pair[1]));
    assert!(trajectory.timestamps().iter().all(|seconds| seconds.is_finite()));
    let rotations = trajectory.world_from_robot().iter().map(|pose| pose.rotation.norm());
    assert!(rotations.into_iter().all(|norm| (norm - 1.0).abs() < 1e-9));
});
