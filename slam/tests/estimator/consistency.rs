//! Calibration: the normalised estimation error squared of poses and objects is chi-square distributed.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use vantage_dataset::{Seed, se3};
use vantage_slam::Estimate;

const SEEDS: u64 = 40;

/// Two-sided 99.9% interval of chi-square over its degrees of freedom (Wilson-Hilferty).
pub fn interval(degrees_of_freedom: f64) -> (f64, f64) {
    let spread = (2.0 / (9.0 * degrees_of_freedom)).sqrt();
    let bound = |z: f64| (1.0 - 2.0 / (9.0 * degrees_of_freedom) + z * spread).powi(3);
    (bound(-3.2905), bound(3.2905))
}

/// NEES over its dimension of the pose at a step.
pub fn nees_of_pose(world: &World, answer: &Estimate, step: usize) -> f64 {
    let error = se3::log(&answer.world_from_robot[step].inv_mul(&world.world_from_robot[step]));
    let covariance = answer.pose_covariances.as_ref().unwrap()[step];
    error.dot(&covariance.cholesky().unwrap().solve(&error)) / 6.0
}

/// Mean NEES over its dimension, of the middle pose and of an object, with its interval.
fn check(which: Which, model: Option<&TanhModel>) {
    let spec = WorldSpec { odometry_sigma: [0.005, 0.005], ..WorldSpec::sparse_loop() };
    let (mut pose, mut object) = (0.0, 0.0);
    for seed in 0..SEEDS {
        let world = World::new(&spec, model, Seed(1000 + seed));
        let model = model.map(|m| m as &dyn vantage_model::ObservationModel);
        let answer = estimate(&world.observations, which, model, &matching_settings(&spec)).unwrap();
        pose += nees_of_pose(&world, &answer, spec.steps / 2) / SEEDS as f64;
        let first = answer.objects[3].as_ref().unwrap();
        let error = first.position - world.world_from_object[3].translation.vector;
        let solved = first.position_covariance.unwrap().cholesky().unwrap().solve(&error);
        object += error.dot(&solved) / (3 * SEEDS) as f64;
    }
    let (of_pose, of_object) = (interval((6 * SEEDS) as f64), interval((3 * SEEDS) as f64));
    println!(
        "{which:?}: NEES per dimension: pose {pose:.3} in {of_pose:.3?}, object {object:.3} in {of_object:.3?}"
    );
    assert!(of_pose.0 < pose && pose < of_pose.1);
    assert!(of_object.0 < object && object < of_object.1);
}

#[test]
fn odometry_alone_is_consistent() {
    let spec = WorldSpec::sparse_loop();
    let mut nees = 0.0;
    for seed in 0..SEEDS {
        let world = World::new(&spec, None, Seed(seed));
        let answer = estimate(&world.observations, Which::Odometry, None, &matching_settings(&spec)).unwrap();
        nees += nees_of_pose(&world, &answer, 20) / SEEDS as f64;
    }
    let bounds = interval((6 * SEEDS) as f64);
    println!("odometry: NEES per dimension {nees:.3} in {bounds:.3?}");
    assert!(bounds.0 < nees && nees < bounds.1);
}

#[test]
fn geometric_is_consistent() {
    check(Which::Geometric, None);
}

#[test]
fn viewpoint_dependent_is_consistent() {
    let model = TanhModel::new([8, 12, 32], 0.03, f64::INFINITY, Seed(1));
    check(Which::Semantic, Some(&model));
}
