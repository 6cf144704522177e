//! TUM trajectories, estimated and recorded: what reads has a pose for each timestamp, and timestamps that do not go back.

#![no_main]

use libfuzzer_sys::fuzz_target;
use vantage_formats::Trajectory;

fuzz_target!(|text: &str| {
    for read in [Trajectory::from_tum, Trajectory::recorded_from_tum] {
        let Ok(trajectory) = read(text) else { continue };
        assert_eq!(trajectory.timestamps().len(), trajectory.world_from_robot().len());
        assert!(trajectory.timestamps().windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(trajectory.timestamps().iter().all(|seconds| seconds.is_finite()));
        let mut rotations = trajectory.world_from_robot().iter().map(|pose| pose.rotation.norm());
        assert!(rotations.all(|norm| (norm - 1.0).abs() < 1e-9));
    }
});
