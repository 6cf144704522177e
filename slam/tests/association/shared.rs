//! Victoria Park and City10000 of MH-iSAM2, shuffled.

use nalgebra::Vector2;
use std::io::Write;
use std::path::{Path, PathBuf};
use vantage_dataset::Seed;
use vantage_formats::mh::{self, MhMeasurement, MhTarget};
use vantage_slam::association::planar::{
    Motion, MotionMeasurement, PlanarNoise, PlanarSlam, PointMeasurement,
};
use vantage_slam::association::{Limits, Thresholds};

fn folder() -> Option<PathBuf> {
    let root = std::env::var_os("VANTAGE_SHARED").map(PathBuf::from);
    let root = root.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"));
    let folder = root.join("data/association");
    if !folder.is_dir() {
        let told =
            "SKIPPED: no cases of association; set VANTAGE_SHARED to a folder that holds data/association";
        let _ = writeln!(std::io::stderr(), "{told}");
    }
    folder.is_dir().then_some(folder)
}

fn take(slam: &mut PlanarSlam, measurement: &MhMeasurement) {
    match &measurement.target {
        MhTarget::Pose { candidates, modes } => {
            let modes = modes.iter().map(|[x, y, heading]| Motion::new(*x, *y, *heading)).collect();
            let is_loop = candidates[0].abs_diff(measurement.from) != 1;
            let motion = MotionMeasurement {
                from: measurement.from,
                to: candidates[0],
                modes,
                is_detachable: is_loop,
            };
            slam.move_by(measurement.line, &motion).unwrap();
        }
        MhTarget::Landmark { candidates, modes } => {
            let seen = PointMeasurement { candidates: candidates.clone(), measured: Vector2::from(modes[0]) };
            slam.see(measurement.from, &[measurement.line], &[seen]).unwrap();
        }
    }
}

#[test]
fn victoria_park_is_associated_as_published() {
    let Some(folder) = folder() else { return };
    let measurements = mh::read(&folder.join("mh_T2_victoriaPark_01.txt"), Seed(1)).unwrap();
    assert_eq!(measurements.iter().filter(|m| m.alternatives() > 1).count(), 412);
    let noise = PlanarNoise {
        motion: [0.01, 0.002, 0.002],
        start: [1e-3; 3],
        point: [0.4_f64.sqrt(); 2],
        reach: 25.0,
        false_share: 0.5,
    };
    let mut slam = PlanarSlam::new(noise, Limits::default(), Thresholds::default()).unwrap();
    measurements.iter().for_each(|measurement| take(&mut slam, measurement));
    let best = slam.hypotheses().best().unwrap();
    let labels: Vec<usize> = best.verdicts().iter().map(|verdict| verdict.label).collect();
    let truth: Vec<usize> =
        measurements.iter().filter(|m| m.alternatives() > 1).map(|m| m.first[0]).collect();
    assert!(truth.iter().filter(|place| **place == 0).count() < 250, "candidates are shuffled");
    assert_eq!(labels, truth);
}

#[test]
fn city_is_right_wherever_its_loops_tell() {
    let Some(folder) = folder() else { return };
    let mut measurements = mh::read(&folder.join("mh_T1_city10000_04.txt"), Seed(1)).unwrap();
    measurements.truncate(500);
    let noise = PlanarNoise {
        motion: [1.0 / 30.0, 1.0 / 30.0, 1.0 / 100.0],
        start: [1e-3; 3],
        point: [1.0; 2],
        reach: 3.0,
        false_share: 0.5,
    };
    let mut slam = PlanarSlam::new(noise, Limits::default(), Thresholds::default()).unwrap();
    measurements.iter().for_each(|measurement| take(&mut slam, measurement));
    slam.settle().unwrap();
    let mut open = Vec::new();
    let is_choice = |m: &&MhMeasurement| match &m.target {
        MhTarget::Pose { candidates, modes } => candidates[0].abs_diff(m.from) != 1 || modes.len() > 1,
        MhTarget::Landmark { .. } => false,
    };
    let choices: Vec<&MhMeasurement> = measurements.iter().filter(is_choice).collect();
    assert_eq!(choices.len(), 69);
    for choice in choices {
        let right = slam.hypotheses().probability(choice.line, choice.first[1]);
        if right < 0.95 {
            // No loop of these lines spans the two edges.
            assert!((right - 0.5).abs() < 0.05, "line {}: {right}", choice.line);
            open.push(choice.line);
        }
    }
    assert_eq!(open, [99, 176]);
}
