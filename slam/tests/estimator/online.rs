//! The posterior after every step against that of the whole episode.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::Matrix6;
use vantage_dataset::{Observations, Seed};
use vantage_slam::{
    Estimate, Estimator, Geometric, OdometryOnly, Online, Semantic, Settings, StepObservations,
};

fn online<'e>(estimator: &'e dyn Estimator, observations: &Observations) -> Online<'e> {
    let Observations { camera, robot_from_camera, .. } = *observations;
    estimator.online(camera, robot_from_camera).unwrap().unwrap()
}

/// After all steps.
fn run<'e>(estimator: &'e dyn Estimator, observations: &Observations) -> Online<'e> {
    let mut online = online(estimator, observations);
    for step in StepObservations::of(observations) {
        online.advance(step).unwrap();
    }
    online
}

/// Largest distance of a pose from that of the whole episode, in its deviations, and of a variance, as a share.
fn difference(online: &Online<'_>, whole: &Estimate) -> [f64; 2] {
    let covariances = whole.pose_covariances.as_ref().unwrap();
    let mut largest = [0.0f64; 2];
    for (step, (pose, covariance)) in whole.world_from_robot.iter().zip(covariances).enumerate().skip(1) {
        let deviation = |i: usize| covariance[(i, i)].sqrt();
        let apart = vantage_dataset::se3::log(&pose.inv_mul(&online.world_from_robot(step).unwrap()));
        let got: Matrix6<f64> = online.pose_covariance(step).unwrap();
        for i in 0..6 {
            largest[0] = largest[0].max(apart[i].abs() / deviation(i));
            largest[1] = largest[1].max((got[(i, i)] / covariance[(i, i)] - 1.0).abs());
        }
    }
    largest
}

fn model() -> TanhModel {
    TanhModel::new([6, 12, 24], 0.03, 8.0, Seed(5))
}

#[test]
fn odometry_and_bearings_end_at_the_maximum_of_the_whole_episode() {
    let spec = WorldSpec::sparse_loop();
    for seed in 0..4 {
        let world = World::new(&spec, Some(&model()), Seed(seed));
        let settings = matching_settings(&spec);
        let estimators: [&dyn Estimator; 2] = [&OdometryOnly::new(&settings), &Geometric::new(&settings)];
        for estimator in estimators {
            let whole = estimator.estimate(&world.observations).unwrap();
            let mut online = run(estimator, &world.observations);
            let [apart, spread] = difference(&online, &whole);
            println!("seed {seed}: {apart} deviations, variance {spread}");
            assert!(online.settle(1e-6, 20).unwrap());
            let [apart, spread] = difference(&online, &whole);
            assert!(apart < 2e-3 && spread < 1e-3, "seed {seed}, settled: {apart}, {spread}");
        }
    }
}

#[test]
fn crops_end_near_the_maximum_of_the_whole_episode() {
    let spec = WorldSpec::sparse_loop();
    let model = model();
    for seed in 0..4 {
        let world = World::new(&spec, Some(&model), Seed(seed));
        let settings = matching_settings(&spec);
        let estimator = Semantic::new(&settings, &model);
        let whole = estimator.estimate(&world.observations).unwrap();
        let mut online = run(&estimator, &world.observations);
        let [apart, spread] = difference(&online, &whole);
        println!("semantic seed {seed}: {apart} {spread}");
        println!("{}", online.settle(1e-4, 20).unwrap());
        let [apart, spread] = difference(&online, &whole);
        println!("semantic seed {seed} settled: {apart} {spread}");
    }
}

#[test]
fn each_step_has_the_estimate_of_an_episode_that_ends_there() {
    let spec = WorldSpec::sparse_loop();
    let world = World::new(&spec, Some(&model()), Seed(9));
    let estimator = Geometric::new(&Settings { ..matching_settings(&spec) });
    let steps = StepObservations::of(&world.observations);
    let mut online = online(&estimator, &world.observations);
    for (step, new) in steps.iter().enumerate() {
        online.advance(new.clone()).unwrap();
        if step % 10 != 9 {
            continue;
        }
        let until = |at: usize| at <= step;
        let mut so_far = world.observations.clone();
        so_far.timestamps.truncate(step + 1);
        so_far.odometry.retain(|o| until(o.to));
        so_far.detections.retain(|d| until(d.step));
        let whole = estimator.estimate(&so_far).unwrap();
        let [apart, spread] = difference(&online, &whole);
        assert!(apart < 0.1 && spread < 0.1, "step {step}: {apart} deviations, variance {spread}");
    }
    let first = online.world_from_robot(0).unwrap();
    assert!(vantage_dataset::se3::log(&first).norm() < 1e-9, "{first:?}");
}
