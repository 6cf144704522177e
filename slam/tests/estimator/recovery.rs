//! Without noise the truth comes back; with noise the bearings help.

use crate::model::TanhModel;
use crate::which::{Which, estimate};
use crate::world::{World, WorldSpec, matching_settings};
use vantage_dataset::Seed;
use vantage_slam::Outcome;

#[test]
fn without_noise_every_estimator_finds_the_truth() {
    let model = TanhModel::new([8, 12, 32], 0.03, 5.0, Seed(1));
    let spec = WorldSpec::sparse_loop().noiseless();
    let world = World::new(&spec, Some(&model), Seed(3));
    for which in Which::ALL {
        let answer = estimate(&world.observations, which, Some(&model), &matching_settings(&spec)).unwrap();
        assert_eq!(answer.outcome, Outcome::Converged, "{which:?}");
        if which == Which::Semantic {
            // The prior on e pulls a little: the latents, and through them the poses, are not exactly the truth.
            assert!(world.ate(&answer) < 5e-3, "{which:?}: {}", world.ate(&answer));
            let errors = world.orientation_errors(&answer);
            assert_eq!(errors.len(), spec.objects);
            assert!(errors.iter().all(|e| *e < 0.05), "{errors:?}");
            continue;
        }
        assert!(world.ate(&answer) < 1e-6, "{which:?}: {}", world.ate(&answer));
        if which != Which::Odometry {
            for (object, truth) in answer.objects.iter().zip(&world.world_from_object) {
                let position = object.as_ref().unwrap().position;
                assert!((position - truth.translation.vector).norm() < 1e-5);
            }
        }
    }
}

#[test]
fn bearings_lower_the_error_of_dead_reckoning() {
    let spec = WorldSpec::sparse_loop();
    let settings = matching_settings(&spec);
    let (mut odometry, mut geometric) = (0.0, 0.0);
    for seed in 0..10 {
        let world = World::new(&spec, None, Seed(seed));
        let of = |which| {
            let answer = estimate(&world.observations, which, None, &settings).unwrap();
            assert_eq!(answer.outcome, Outcome::Converged, "{which:?}, seed {seed}");
            world.ate(&answer)
        };
        odometry += of(Which::Odometry) / 10.0;
        geometric += of(Which::Geometric) / 10.0;
    }
    println!("mean ATE over 10 seeds: odometry {odometry:.4} m, geometric {geometric:.4} m");
    assert!(geometric < 0.7 * odometry);
}

#[test]
fn a_wrong_association_is_outvoted_by_the_kernel() {
    let spec = WorldSpec::sparse_loop();
    let mut world = World::new(&spec, None, Seed(5));
    let mut robust = matching_settings(&spec);
    robust.geometry.bearing_kernel = vantage_slam::noise::Kernel::Huber { threshold: 2.0 };
    let clean = world.ate(&estimate(&world.observations, Which::Geometric, None, &robust).unwrap());
    let wrong = world.observations.detections.len() / 2;
    world.observations.detections[wrong].track = (world.observations.detections[wrong].track + 4) % 8;
    let with =
        |settings| world.ate(&estimate(&world.observations, Which::Geometric, None, settings).unwrap());
    let (huber, gaussian) = (with(&robust), with(&matching_settings(&spec)));
    println!("ATE: clean {clean:.4}, one wrong association: Huber {huber:.4}, Gaussian {gaussian:.4}");
    assert!(huber < gaussian);
}

#[test]
fn a_long_drive_without_a_closure_is_constrained() {
    let spec = WorldSpec { steps: 2000, laps: 30.0, objects: 0, ..WorldSpec::sparse_loop() };
    let world = World::new(&spec, None, Seed(1));
    let answer = estimate(&world.observations, Which::Odometry, None, &matching_settings(&spec)).unwrap();
    assert_eq!(answer.outcome, Outcome::Converged);
    for (step, covariance) in answer.pose_covariances.unwrap().iter().enumerate().skip(1) {
        let rotation = covariance.fixed_view::<3, 3>(0, 0).trace();
        let expected = 3.0 * spec.odometry_sigma[0].powi(2) * step as f64;
        assert!((rotation / expected - 1.0).abs() < 1e-4, "step {step}: {rotation}, expected {expected}");
    }
}
