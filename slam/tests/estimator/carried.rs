//! A robot that is carried between two steps.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::Matrix6;
use vantage_dataset::{Observations, Odometry, Pose, Seed, Tangent, Tracklets, se3};
use vantage_slam::association::Limits;
use vantage_slam::associator::{
    AssociationSettings, Associator, Blind, Encoded, EncodedSettings, Hypothesizing, Likeness, Place,
};
use vantage_slam::{Estimator, Geometric, Semantic, StepObservations};

const LIKENESS: EncodedSettings =
    EncodedSettings { views: 8, latent_exponent: 0.02, side_exponent: 0.1, copies: 0.1 };
/// Steps on which it was carried, of two laps.
const LIFTED: std::ops::Range<usize> = 66..76;

fn spec() -> WorldSpec {
    WorldSpec { steps: 120, laps: 2.5, odometry_sigma: [0.003, 0.005], ..WorldSpec::sparse_loop() }
}

/// A world without the steps of `LIFTED`, and where the robot truly was.
fn carried(model: Option<&TanhModel>, seed: u64) -> (Observations, Vec<Pose>) {
    let World { mut observations, mut world_from_robot, .. } = World::new(&spec(), model, Seed(seed));
    let gone = LIFTED.len();
    world_from_robot.drain(LIFTED);
    observations.timestamps.drain(LIFTED);
    let renumbered = |step: usize| if step < LIFTED.start { step } else { step - gone };
    observations.detections.retain(|detection| !LIFTED.contains(&detection.step));
    observations.detections.iter_mut().for_each(|detection| detection.step = renumbered(detection.step));
    observations
        .odometry
        .retain(|odometry| !LIFTED.contains(&odometry.from) && !LIFTED.contains(&odometry.to));
    for odometry in &mut observations.odometry {
        (odometry.from, odometry.to) = (renumbered(odometry.from), renumbered(odometry.to));
    }
    let variances = Tangent::new(1e-4, 1e-4, 6.0, 16.0, 16.0, 1e-4);
    observations.odometry.push(Odometry {
        from: LIFTED.start - 1,
        to: LIFTED.start,
        robot_from_robot: Pose::identity(),
        covariance: Matrix6::from_diagonal(&variances),
    });
    (observations, world_from_robot)
}

fn places<L: Likeness>(likeness: L, hypotheses: usize, given: &Observations) -> Vec<Place> {
    let size = World::new(&spec(), None, Seed(99)).sizes.iter().sum::<f64>() / spec().objects as f64;
    let limits = Limits { hypotheses, ..AssociationSettings::default().limits };
    let settings = AssociationSettings { size, limits, ..AssociationSettings::default() };
    let (tracklets, _) = Tracklets::joined(given, 3);
    let associator = Hypothesizing::new(&matching_settings(&spec()), settings, likeness);
    let places = associator.associate(&tracklets).unwrap().places;
    assert_eq!(places.len(), given.steps());
    places
}

/// Steps from where it is set down until it is within half a metre for good, and how far off it is at the end.
fn resolved(places: &[Place], truth: &[Pose]) -> (usize, f64) {
    let off = |step: usize| {
        (places[step].world_from_robot.translation.vector - truth[step].translation.vector).norm()
    };
    let is_wrong = |step: &usize| !places[*step].is_known || off(*step) > 0.5;
    let wrong = (LIFTED.start..truth.len()).rev().find(is_wrong);
    (wrong.map_or(0, |step| step + 1 - LIFTED.start), off(truth.len() - 1))
}

#[test]
fn a_carried_robot_finds_its_place_sooner_by_sides() {
    let model = TanhModel::new([6, 12, 24], 0.03, 8.0, Seed(5));
    let (mut blind, mut seeing) = (0, 0);
    for seed in 0..6 {
        let (given, truth) = carried(Some(&model), seed);
        let by_geometry = places(Blind, 256, &given);
        let first = given.detections.iter().find(|detection| detection.step >= LIFTED.start).unwrap().step;
        assert!(by_geometry[LIFTED.start..first].iter().all(|place| !place.is_known), "seed {seed}");
        assert!(by_geometry[..LIFTED.start].iter().all(|place| place.is_known), "seed {seed}");
        blind += resolved(&by_geometry, &truth).0;
        let (steps, end) = resolved(&places(Encoded::new(&model, LIKENESS), 256, &given), &truth);
        assert!(end < 0.3, "seed {seed}: {end} m off at the end");
        seeing += steps;
    }
    println!("steps to resolve on 6 seeds: {blind} without crops, {seeing} with them");
    assert!(seeing + 15 <= blind, "{blind} without crops, {seeing} with them");
}

#[test]
fn known_objects_set_a_carried_robot_down() {
    for seed in 0..4 {
        let (given, truth) = carried(None, seed);
        let estimate = Geometric::new(&matching_settings(&spec())).estimate(&given).unwrap();
        for (step, (found, truth)) in estimate.world_from_robot.iter().zip(&truth).enumerate() {
            let off = (found.translation.vector - truth.translation.vector).norm();
            assert!(off < 0.3, "seed {seed}, step {step}: {off} m");
        }
    }
}

/// One known object is in view at first. Without looking for its place the robot is up to 33 m off, for up to ten steps.
#[test]
fn a_carried_robot_knows_after_each_step_where_it_is() {
    let model = TanhModel::new([6, 12, 24], 0.03, 8.0, Seed(5));
    let settings = matching_settings(&spec());
    let estimators: [&dyn Estimator; 2] = [&Geometric::new(&settings), &Semantic::new(&settings, &model)];
    let mut sums = [0.0; 2];
    for seed in 0..12 {
        let (given, truth) = carried(Some(&model), seed);
        for (estimator, sum) in estimators.iter().zip(&mut sums) {
            let mut online = estimator.online(given.camera, given.robot_from_camera).unwrap().unwrap();
            for (step, new) in StepObservations::of(&given).into_iter().enumerate() {
                online.advance(new).unwrap();
                let error = se3::log(&online.world_from_robot(step).unwrap().inv_mul(&truth[step]));
                if step >= LIFTED.start + 2 {
                    let off = error.fixed_rows::<3>(3).norm();
                    assert!(off < 0.7, "seed {seed}, step {step}: {off} m");
                    let covariance = online.pose_covariance(step).unwrap();
                    *sum += error.dot(&covariance.cholesky().unwrap().solve(&error)) / 6.0;
                }
            }
        }
    }
    let steps = 12 * (spec().steps - LIFTED.len() - LIFTED.start - 2);
    let nees = sums.map(|sum| sum / steps as f64);
    assert!(nees.iter().all(|nees| *nees < 2.5), "{nees:?}");
}
