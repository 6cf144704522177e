//! Learning while localising (Eq. 25-26): a domain that differs from training is found and undone, and noise that was told too small is noticed.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings, nothing_to_learn_from};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::{Observations, Seed};
use vantage_model::ObservationModel;
use vantage_slam::{
    Checked, DecoderAdapted, DecoderChecked, DomainPrior, Estimate, Estimator, LayerSettings, Outcome,
    Refitted, Semantic, Settings,
};

pub fn model() -> TanhModel {
    TanhModel::new([8, 12, 32], 0.03, f64::INFINITY, Seed(1))
}

/// Every crop measured as `gain` times what it was, and `offset` standard deviations of the noise off.
pub fn moved(world: &mut World, model: &TanhModel, gain: f64, offset: f64) {
    let direction = DVector::from_fn(12, |i, _| if i % 2 == 0 { 1.0 } else { -0.5 });
    for detection in &mut world.observations.detections {
        let measured = model.measure(&detection.masked_crop).unwrap();
        detection.masked_crop = TanhModel::crop(&(measured * gain + &direction * (0.03 * offset)));
    }
}

pub const PRIOR: DomainPrior = DomainPrior { offset_sigma: 10.0, gain_sigma: 0.3 };

/// Mean ATE of the frozen model, of the one in a domain that is learnt, and of the one that keeps what predicts hidden crops.
fn errors(gain: f64, offset: f64) -> [f64; 3] {
    let (model, spec) = (model(), WorldSpec::sparse_loop());
    let settings = matching_settings(&spec);
    let mut sums = [0.0; 3];
    for seed in 0..6 {
        let mut world = World::new(&spec, Some(&model), Seed(seed));
        moved(&mut world, &model, gain, offset);
        let frozen = Semantic::new(&settings, &model);
        let learning = Semantic::new(&settings, &model).in_domain(&PRIOR);
        let checked = Checked::new(&settings, &model, &PRIOR);
        let all: [&dyn Estimator; 3] = [&frozen, &learning, &checked];
        for (sum, estimator) in sums.iter_mut().zip(all) {
            let estimate = estimator.estimate(&world.observations).unwrap();
            let given_up = matches!(estimate.outcome, Outcome::Diverged | Outcome::Underconstrained { .. });
            assert!(!given_up, "seed {seed}: {}", estimate.outcome);
            *sum += world.ate(&estimate) / 6.0;
        }
    }
    println!("gain {gain}, offset {offset}: frozen, learning and checked {sums:.4?} m");
    sums
}

#[test]
fn a_domain_that_differs_from_training_is_learnt() {
    let [frozen, learning, checked] = errors(1.3, 8.0);
    assert!(learning < 0.75 * frozen && checked < 0.75 * frozen, "{learning} {checked} {frozen}");
}

#[test]
fn in_the_domain_of_training_little_is_lost() {
    let [frozen, learning, checked] = errors(1.0, 0.0);
    assert!(learning < 1.1 * frozen && checked < 1.05 * frozen, "{learning} {checked} {frozen}");
}

#[test]
fn noise_that_was_told_too_small_is_refitted_and_right_noise_is_kept() {
    let model = model();
    let deviation = |sigma: f64, refit: bool| {
        let spec = WorldSpec { semantic_sigma: sigma, ..WorldSpec::sparse_loop() };
        let (settings, world) = (matching_settings(&spec), World::new(&spec, Some(&model), Seed(3)));
        let refitted = Refitted::new(&settings, &model);
        let frozen = Semantic::new(&settings, &model);
        let estimator: &dyn Estimator = if refit { &refitted } else { &frozen };
        let estimate = estimator.estimate(&world.observations).unwrap();
        estimate.pose_covariances.unwrap().last().unwrap().trace().sqrt()
    };
    assert_eq!(deviation(0.03, true), deviation(0.03, false), "the right noise");
    let ratio = deviation(0.08, true) / deviation(0.08, false);
    assert!(ratio > 1.2, "told {ratio} times as much");
}

fn deviation(estimate: &Estimate) -> f64 {
    estimate.pose_covariances.as_ref().unwrap().last().unwrap().trace().sqrt()
}

#[test]
fn what_cannot_be_checked_on_another_session_is_rolled_back() {
    let (model, spec) = (model(), WorldSpec { semantic_sigma: 0.08, ..WorldSpec::sparse_loop() });
    let settings = matching_settings(&WorldSpec::sparse_loop());
    let mut observations = World::new(&spec, Some(&model), Seed(3)).observations;
    let estimates = |observations: &Observations| {
        let all: [&dyn Estimator; 5] = [
            &Semantic::new(&settings, &model),
            &Refitted::new(&settings, &model),
            &Checked::new(&settings, &model, &PRIOR),
            &DecoderAdapted::new(&settings, &model),
            &DecoderChecked::new(&settings, &model),
        ];
        all.map(|estimator| estimator.estimate(observations).unwrap())
    };
    let [frozen, _, checked, ..] = estimates(&observations);
    assert!(
        deviation(&checked) > 1.2 * deviation(&frozen),
        "what the second lap sees again is another session"
    );
    let half = observations.steps() / 2;
    observations.detections.retain(|detection| detection.step < half);
    let [frozen, refitted, checked, decoder, decoder_checked] =
        estimates(&observations).map(|of| of.world_from_robot);
    assert!(checked == frozen && decoder_checked == frozen);
    assert!(refitted != frozen && decoder != frozen, "there is something to roll back");
}

#[test]
fn where_there_is_nothing_to_learn_from_the_answer_is_finite() {
    let model = model();
    for (what, spec, garbage) in nothing_to_learn_from() {
        let mut world = World::new(&spec, Some(&model), Seed(2));
        if garbage {
            moved(&mut world, &model, -3.0, 200.0);
        }
        let settings = matching_settings(&spec);
        let all: [&dyn Estimator; 5] = [
            &Refitted::new(&settings, &model),
            &Semantic::new(&settings, &model).in_domain(&PRIOR),
            &Checked::new(&settings, &model, &PRIOR),
            &DecoderAdapted::new(&settings, &model),
            &DecoderChecked::new(&settings, &model),
        ];
        let mut errors = [0.0; 5];
        for (learning, estimator) in all.into_iter().enumerate() {
            let estimate = estimator.estimate(&world.observations).unwrap();
            println!("{what}, {learning}: {}, {:.3} m", estimate.outcome, world.ate(&estimate));
            assert_eq!(estimate.world_from_robot.len(), world.observations.steps(), "{what}");
            errors[learning] = world.ate(&estimate);
            assert!(errors[learning].is_finite(), "{what}");
            let finite = |covariance: &nalgebra::Matrix6<f64>| covariance.iter().all(|x| x.is_finite());
            assert!(estimate.pose_covariances.iter().flatten().all(finite), "{what}");
        }
        if garbage {
            assert!(errors[1] > 5.0 * errors[0], "what is learnt is no good: {errors:?}");
        }
        assert_eq!(errors[2], errors[0], "{what}: a domain that does not converge is rolled back");
        assert!(
            errors[3..].iter().all(|error| *error < 1.2 * errors[0]),
            "{what}: a decoder does no harm: {errors:?}"
        );
    }
}

#[test]
fn wrong_associations_teach_nothing_that_harms() {
    let (model, spec) = (model(), WorldSpec::sparse_loop());
    let settings = matching_settings(&spec);
    for every in [10, 5, 3] {
        let mut sums = [0.0; 6];
        for seed in 0..4 {
            let mut world = World::new(&spec, Some(&model), Seed(seed));
            for detection in world.observations.detections.iter_mut().step_by(every) {
                detection.track = (detection.track + 1) % spec.objects;
            }
            let all: [&dyn Estimator; 6] = [
                &Semantic::new(&settings, &model),
                &Refitted::new(&settings, &model),
                &Semantic::new(&settings, &model).in_domain(&PRIOR),
                &Checked::new(&settings, &model, &PRIOR),
                &DecoderAdapted::new(&settings, &model),
                &DecoderChecked::new(&settings, &model),
            ];
            for (sum, estimator) in sums.iter_mut().zip(all) {
                *sum += world.ate(&estimator.estimate(&world.observations).unwrap()) / 4.0;
            }
        }
        println!(
            "one association of {every} wrong: frozen, refitted, domain, checked, decoder and decoder checked {sums:.3?} m"
        );
        assert!(sums[3] < 1.1 * sums[0] && sums[5] < 1.1 * sums[0], "{sums:?}");
        assert!(sums.iter().all(|sum| *sum < 1.2 * sums[0]), "{sums:?}");
    }
}

#[test]
fn rounds_that_predict_hidden_crops_better_are_kept_and_those_of_noise_are_not() {
    let (model, spec) = (model(), WorldSpec::sparse_loop());
    let mut random = Seed(7).stream("another layer", 0);
    let change = DMatrix::from_fn(12, 33, |_, j| if j < 32 { 0.02 * random.normal() } else { 0.0 });
    let other = model.with_output(&change);
    let settings = matching_settings(&spec);
    let rounds = |rounds| Settings { layer: LayerSettings { rounds }, ..settings };
    let poses = |world: &World| {
        let all: [&dyn Estimator; 4] = [
            &Semantic::new(&settings, &model),
            &DecoderAdapted::new(&rounds(1), &model),
            &DecoderAdapted::new(&rounds(2), &model),
            &DecoderChecked::new(&rounds(2), &model),
        ];
        all.map(|estimator| estimator.estimate(&world.observations).unwrap().world_from_robot)
    };
    let mut kept = [0; 3];
    for seed in 0..6 {
        let [frozen, once, twice, checked] = poses(&World::new(&spec, Some(&other), Seed(seed)));
        assert!(once != frozen && twice != once);
        let of = [&frozen, &once, &twice].iter().position(|of| **of == checked);
        kept[of.expect("a round is kept as it is, or rolled back")] += 1;
    }
    println!("of two rounds none, one and both kept: {kept:?}");
    assert!(kept[1] + kept[2] >= 4, "{kept:?}");
    let noisy = WorldSpec { semantic_sigma: 0.15, ..spec };
    for seed in 0..6 {
        let [frozen, once, _, checked] = poses(&World::new(&noisy, Some(&model), Seed(seed)));
        assert_ne!(once, frozen, "unchecked, noise is learnt");
        assert_eq!(checked, frozen, "it predicts no other crops");
    }
}
