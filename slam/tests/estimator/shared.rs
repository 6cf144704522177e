//! Errors that many measurements share, the offset of an object's boxes and odometry's bias: as variables they are estimated and the
//! covariances are honest; as white noise they are not.

use crate::consistency::interval;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::{Const, SMatrix, SVector};
use vantage_dataset::{Seed, se3};
use vantage_slam::bearing_offset::BearingOffset;
use vantage_slam::noise::BearingNoise;
use vantage_slam::odometry_bias::OdometryBias;
use vantage_slam::{EstimateError, Outcome, Settings};

const SEEDS: u64 = 40;

fn nees<const N: usize>(error: &SVector<f64, N>, covariance: SMatrix<f64, N, N>) -> f64
where
    Const<N>: nalgebra::DimMin<Const<N>, Output = Const<N>>,
{
    error.dot(&covariance.cholesky().unwrap().solve(error)) / N as f64
}

/// Mean ATE, and mean NEES over dimensions of the middle pose, the last pose and the centre of the first object that is placed.
fn scores(spec: &WorldSpec, settings: &Settings, which: Which) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for seed in 0..SEEDS {
        let world = World::new(spec, None, Seed(2000 + seed));
        let answer = estimate(&world.observations, which, None, settings).unwrap();
        assert_eq!(answer.outcome, Outcome::Converged, "seed {seed}");
        let covariances = answer.pose_covariances.as_ref().unwrap();
        let of_pose = |step: usize| {
            let error = se3::log(&answer.world_from_robot[step].inv_mul(&world.world_from_robot[step]));
            nees(&error, covariances[step])
        };
        let placed = answer.objects.iter().zip(&world.world_from_object).find_map(|(object, truth)| {
            let object = object.as_ref()?;
            Some(nees(&(object.position - truth.translation.vector), object.position_covariance.unwrap()))
        });
        let of_seed =
            [world.ate(&answer), of_pose(spec.steps / 2), of_pose(spec.steps - 1), placed.unwrap_or(1.0)];
        for (sum, score) in sums.iter_mut().zip(of_seed) {
            *sum += score / SEEDS as f64;
        }
    }
    sums
}

fn is_inside(nees: f64, dimensions: u64) -> bool {
    let (low, high) = interval((dimensions * SEEDS) as f64);
    low < nees && nees < high
}

#[test]
fn offsets_of_boxes_as_variables_are_consistent_and_as_noise_are_not() {
    let offset = BearingOffset { horizontal: 0.1, vertical: 0.1, length: 1.0, smoothness: 2.0 };
    let spec = WorldSpec {
        odometry_sigma: [0.005, 0.005],
        bearing_sigma: 0.002,
        bearing_offset: Some(offset),
        ..WorldSpec::sparse_loop()
    };
    let told = matching_settings(&spec);
    let mut as_noise = told;
    as_noise.geometry.bearing_offset = None;
    as_noise.geometry.bearing_noise = BearingNoise { fixed: 0.002, proportional: 0.1 };
    let (variable, noise) =
        (scores(&spec, &told, Which::Geometric), scores(&spec, &as_noise, Which::Geometric));
    println!("ATE, NEES of middle, last, centre: as variables {variable:.3?}, as noise {noise:.3?}");
    assert!(is_inside(variable[1], 6) && is_inside(variable[2], 6) && is_inside(variable[3], 3));
    assert!(noise[3] > interval(3.0 * SEEDS as f64).1);
    assert!(variable[0] < noise[0]);
}

#[test]
fn a_strong_bias_as_a_variable_is_consistent_and_better() {
    let bias = OdometryBias { translation_per_metre: 0.03, rotation_deg_per_metre: 1.0 };
    let spec = WorldSpec {
        odometry_sigma: [0.003, 0.003],
        bearing_sigma: 0.003,
        odometry_bias: Some(bias),
        ..WorldSpec::sparse_loop()
    };
    let told = matching_settings(&spec);
    let mut as_noise = told;
    as_noise.odometry.bias = None;
    for which in [Which::Odometry, Which::Geometric] {
        let (variable, noise) = (scores(&spec, &told, which), scores(&spec, &as_noise, which));
        println!("{which:?}: ATE, NEES of middle, last, centre: variable {variable:.3?}, noise {noise:.3?}");
        assert!(is_inside(variable[1], 6), "{which:?}");
        assert!(noise[1] > interval(6.0 * SEEDS as f64).1, "{which:?}");
        if which == Which::Geometric {
            assert!(is_inside(variable[2], 6) && is_inside(variable[3], 3));
            assert!(variable[0] < noise[0]);
        }
    }
}

#[test]
fn a_bias_beyond_the_covariance_it_is_part_of_is_refused() {
    let spec = WorldSpec::sparse_loop();
    let world = World::new(&spec, None, Seed(1));
    for which in Which::ALL.into_iter().take(2) {
        let mut settings = matching_settings(&spec);
        settings.odometry.bias =
            Some(OdometryBias { translation_per_metre: 0.9, rotation_deg_per_metre: 0.0 });
        let error = estimate(&world.observations, which, None, &settings).unwrap_err();
        assert!(matches!(error, EstimateError::Bias { index: 0, .. }), "{error}");
        assert!(error.to_string().contains("lower the larger of `odometry_bias`"), "{error}");
        settings.odometry.bias =
            Some(OdometryBias { translation_per_metre: f64::NAN, rotation_deg_per_metre: 0.0 });
        let error = estimate(&world.observations, which, None, &settings).unwrap_err();
        assert!(error.to_string().contains("translation_per_metre"), "{error}");
    }
}

#[test]
fn no_bias_and_no_offset_change_nothing() {
    let spec = WorldSpec::sparse_loop();
    let world = World::new(&spec, None, Seed(4));
    let plain = matching_settings(&spec);
    let mut with_none = plain;
    with_none.odometry.bias = Some(OdometryBias { translation_per_metre: 0.0, rotation_deg_per_metre: 0.0 });
    with_none.geometry.bearing_offset =
        Some(BearingOffset { horizontal: 0.0, vertical: 0.0, length: 1.0, smoothness: 2.0 });
    let of = |settings| estimate(&world.observations, Which::Geometric, None, settings).unwrap();
    for (a, b) in of(&plain).world_from_robot.iter().zip(&of(&with_none).world_from_robot) {
        assert!(se3::log(&a.inv_mul(b)).norm() < 1e-6);
    }
}
