//! From one end of what may come to the other, step by step: every step is answered, with finite numbers.

use crate::model::TanhModel;
use crate::ranges::{DIMS, is_covariance, model, on_a_line, spoil};
use crate::world::{World, WorldSpec, matching_settings};
use vantage_dataset::{Pose, Seed};
use vantage_slam::{EstimateError, Estimator, Geometric, Semantic, StepObservations};

/// How many steps are answered, and what ends them before the last.
fn answered(estimator: &dyn Estimator, world: &World) -> (usize, Option<EstimateError>) {
    let observations = &world.observations;
    let mut online = estimator.online(observations.camera, observations.robot_from_camera).unwrap().unwrap();
    for (number, step) in StepObservations::of(observations).into_iter().enumerate() {
        if let Err(error) = online.advance(step) {
            return (number, Some(error));
        }
        let newest = online.world_from_robot(number).unwrap();
        assert!(newest.to_homogeneous().iter().all(|x| x.is_finite()), "step {number}: {newest}");
        assert!(online.pose_covariance(number).iter().all(is_covariance), "step {number}");
    }
    if let Err(error) = online.settle(1e-6, 30) {
        return (observations.steps(), Some(error));
    }
    for step in 0..observations.steps() {
        let pose = online.world_from_robot(step).unwrap();
        assert!(pose.to_homogeneous().iter().all(|x| x.is_finite()), "settled, step {step}: {pose}");
    }
    (observations.steps(), None)
}

#[test]
fn all_steps_are_answered_whatever_objects_tell() {
    let (spec, known) = (WorldSpec::sparse_loop(), model());
    let symmetric = TanhModel::blind_to_azimuth(DIMS, 0.03, 5.0, Seed(1));
    let of = |model: &TanhModel| World::new(&spec, Some(model), Seed(3));
    let camera = of(&known).observations.camera;
    let mut one_view = of(&known);
    let whole = one_view.observations.detections.iter().position(|d| !d.bounding_box.is_truncated(&camera));
    one_view.observations.detections = vec![one_view.observations.detections[whole.unwrap()].clone()];
    let mut slipped = of(&known);
    slipped.observations.odometry[spec.steps / 2].robot_from_robot *= Pose::translation(1.0, 0.0, 0.0);
    let mut garbage = of(&known);
    spoil(&mut garbage, &spec, Seed(3), |_| true, true);
    let worlds = [
        ("symmetric objects", of(&symmetric), &symmetric),
        ("one view", one_view, &known),
        ("all on a line", on_a_line(&spec, &known), &known),
        ("a slip of a metre", slipped, &known),
        ("crops of nothing", garbage, &known),
    ];
    let settings = matching_settings(&spec);
    for (name, world, model) in &worlds {
        let estimators: [&dyn Estimator; 2] = [&Geometric::new(&settings), &Semantic::new(&settings, *model)];
        for estimator in estimators {
            let (steps, ended) = answered(estimator, world);
            assert!(ended.is_none() && steps == world.observations.steps(), "{name}, {steps}: {ended:?}");
        }
    }
}

/// Poses of dead reckoning are off by radians before the loop closes.
#[test]
fn all_steps_are_answered_where_odometry_tells_next_to_nothing() {
    let spec = WorldSpec { odometry_sigma: [0.055, 0.05], ..WorldSpec::sparse_loop() };
    let geometric = Geometric::new(&matching_settings(&spec));
    for seed in 0..30 {
        let (steps, ended) = answered(&geometric, &World::new(&spec, None, Seed(seed)));
        assert!(ended.is_none() && steps == spec.steps, "seed {seed}, {steps}: {ended:?}");
    }
}
