//! Learning while localising (Eq. 25-26): a domain that differs from training is found and undone, and noise that was told too small is noticed.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings, nothing_to_learn_from};
use nalgebra::{DMatrix, DVector, Vector3};
use vantage_dataset::{Observations, Seed, Viewpoint};
use vantage_model::ObservationModel;
use vantage_slam::{
    Checked, DecoderAdapted, DecoderTaught, DomainAdapted, DomainPrior, Estimate, Estimator, Learner, Lesson,
    Outcome, Refitted, SeenView, Semantic, Settings,
};

fn model() -> TanhModel {
    TanhModel::new([8, 12, 32], 0.03, f64::INFINITY, Seed(1))
}

/// Every crop measured as `gain` times what it was, and `offset` standard deviations of the noise off.
fn moved(world: &mut World, model: &TanhModel, gain: f64, offset: f64) {
    let direction = DVector::from_fn(12, |i, _| if i % 2 == 0 { 1.0 } else { -0.5 });
    for detection in &mut world.observations.detections {
        let measured = model.measure(&detection.masked_crop).unwrap();
        detection.masked_crop = TanhModel::crop(&(measured * gain + &direction * (0.03 * offset)));
    }
}

const PRIOR: DomainPrior = DomainPrior { offset_sigma: 10.0, gain_sigma: 0.3 };

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
        let all: [&dyn Estimator; 3] = [
            &Semantic::new(&settings, &model),
            &Refitted::new(&settings, &model),
            &Checked::new(&settings, &model, &PRIOR),
        ];
        all.map(|estimator| estimator.estimate(observations).unwrap())
    };
    let [frozen, _, checked] = estimates(&observations);
    assert!(
        deviation(&checked) > 1.2 * deviation(&frozen),
        "what the second lap sees again is another session"
    );
    let half = observations.steps() / 2;
    observations.detections.retain(|detection| detection.step < half);
    let [frozen, refitted, checked] = estimates(&observations);
    assert_eq!(checked.world_from_robot, frozen.world_from_robot);
    assert_ne!(refitted.world_from_robot, frozen.world_from_robot, "there is something to roll back");
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
        let all: [&dyn Estimator; 3] = [
            &Refitted::new(&settings, &model),
            &Semantic::new(&settings, &model).in_domain(&PRIOR),
            &Checked::new(&settings, &model, &PRIOR),
        ];
        let mut errors = [0.0; 3];
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
    }
}

#[test]
fn wrong_associations_teach_nothing_that_harms() {
    let (model, spec) = (model(), WorldSpec::sparse_loop());
    let settings = matching_settings(&spec);
    for every in [10, 5, 3] {
        let mut sums = [0.0; 4];
        for seed in 0..4 {
            let mut world = World::new(&spec, Some(&model), Seed(seed));
            for detection in world.observations.detections.iter_mut().step_by(every) {
                detection.track = (detection.track + 1) % spec.objects;
            }
            let all: [&dyn Estimator; 4] = [
                &Semantic::new(&settings, &model),
                &Refitted::new(&settings, &model),
                &Semantic::new(&settings, &model).in_domain(&PRIOR),
                &Checked::new(&settings, &model, &PRIOR),
            ];
            for (sum, estimator) in sums.iter_mut().zip(all) {
                *sum += world.ate(&estimator.estimate(&world.observations).unwrap()) / 4.0;
            }
        }
        println!("one association of {every} wrong: frozen, refitted, learning and checked {sums:.3?} m");
        assert!(sums[3] < 1.1 * sums[0], "{sums:?}");
    }
}

/// Errors of drives in one world, each with what those before it taught, and the lesson after each.
fn life(learner: &dyn Learner, worlds: &[World]) -> Vec<(f64, Lesson)> {
    let mut lesson = Lesson::default();
    let drive = |world: &World| {
        let learnt = learner.learn(&world.observations, &lesson).unwrap();
        lesson = learnt.lesson;
        (world.ate(&learnt.estimate), lesson.clone())
    };
    worlds.iter().map(drive).collect()
}

/// Worlds whose crops are all off alike, of a robot that passes each object once.
fn worlds_that_differ_alike(model: &TanhModel, seeds: u64, [gain, offset]: [f64; 2]) -> Vec<World> {
    let world = |seed| {
        let mut world = World::new(&WorldSpec::sparse_loop(), Some(model), Seed(seed));
        moved(&mut world, model, gain, offset);
        world
    };
    (0..seeds).map(world).collect()
}

#[test]
fn what_a_drive_teaches_of_the_domain_helps_the_next() {
    let model = model();
    let worlds = worlds_that_differ_alike(&model, 6, [1.3, 8.0]);
    let settings = Settings { domain: PRIOR, ..matching_settings(&WorldSpec::sparse_loop()) };
    let learner = DomainAdapted::new(&settings, &model);
    let lived = life(&learner, &worlds);
    let alone: Vec<f64> =
        worlds.iter().map(|world| world.ate(&learner.estimate(&world.observations).unwrap())).collect();
    let later: f64 = lived[1..].iter().map(|(ate, _)| ate).sum();
    println!("alone {alone:.3?}, after others {:.3?}", lived.iter().map(|(ate, _)| ate).collect::<Vec<_>>());
    assert_eq!(lived[0].0, alone[0], "a first drive knows nothing of others");
    assert!(later < alone[1..].iter().sum::<f64>(), "{later}");
    let spread = |lesson: &Lesson| lesson.domain.as_ref().unwrap().covariance.trace();
    assert!(spread(&lived[5].1) < spread(&lived[0].1), "it is known better");
}

#[test]
fn a_life_that_was_stopped_goes_on_to_the_same_bits_and_its_lesson_does_not_grow() {
    let model = model();
    let worlds = worlds_that_differ_alike(&model, 3, [1.3, 8.0]);
    let settings = Settings { domain: PRIOR, ..matching_settings(&WorldSpec::sparse_loop()) };
    let all: [&dyn Learner; 2] = [&DomainAdapted::new(&settings, &model), &Refitted::new(&settings, &model)];
    for learner in all {
        let whole = life(learner, &worlds);
        let mut lengths = Vec::new();
        let mut lesson = Lesson::default();
        for (world, (ate, after)) in worlds.iter().zip(&whole) {
            let text = serde_json::to_string(&lesson).unwrap();
            lengths.push(text.len());
            let stored: Lesson = serde_json::from_str(&text).unwrap();
            let learnt = learner.learn(&world.observations, &stored).unwrap();
            assert_eq!((world.ate(&learnt.estimate), &learnt.lesson), (*ate, after));
            lesson = learnt.lesson;
        }
        assert!(lengths[2] < 2 * lengths[1].max(500), "{lengths:?}");
    }
}

#[test]
fn garbage_teaches_a_domain_that_later_drives_forget() {
    let model = model();
    let settings = Settings { domain: PRIOR, ..matching_settings(&WorldSpec::sparse_loop()) };
    let learner = DomainAdapted::new(&settings, &model);
    let mut garbage = World::new(&WorldSpec::sparse_loop(), Some(&model), Seed(0));
    moved(&mut garbage, &model, -3.0, 200.0);
    let lesson = learner.learn(&garbage.observations, &Lesson::default()).unwrap().lesson;
    let worlds: Vec<World> =
        (1..5).map(|seed| World::new(&WorldSpec::sparse_loop(), Some(&model), Seed(seed))).collect();
    let mut known = lesson;
    let mut errors = Vec::new();
    for world in &worlds {
        let learnt = learner.learn(&world.observations, &known).unwrap();
        known = learnt.lesson;
        let frozen = Semantic::new(&settings, &model).estimate(&world.observations).unwrap();
        errors.push(world.ate(&learnt.estimate) / world.ate(&frozen));
    }
    println!("over the frozen model's after garbage: {errors:.2?}");
    assert!(errors[3] < 1.5, "{errors:?}");
}

#[test]
fn a_last_layer_that_is_wrong_is_learnt_over_a_life() {
    let model = model();
    let mut random = Seed(7).stream("another layer", 0);
    let change = DMatrix::from_fn(12, 33, |_, j| if j < 32 { 0.02 * random.normal() } else { 0.0 });
    let other = model.with_output(&change);
    let spec = WorldSpec::sparse_loop();
    let settings = matching_settings(&spec);
    let worlds: Vec<World> = (0..12).map(|seed| World::new(&spec, Some(&other), Seed(seed))).collect();
    let frozen: Vec<f64> = worlds
        .iter()
        .map(|world| world.ate(&Semantic::new(&settings, &model).estimate(&world.observations).unwrap()))
        .collect();
    let oracle: Vec<f64> = worlds
        .iter()
        .map(|world| world.ate(&Semantic::new(&settings, &other).estimate(&world.observations).unwrap()))
        .collect();
    let lived = life(&DecoderAdapted::new(&settings, &model), &worlds);
    let off = |lesson: &Lesson| (&lesson.decoder.as_ref().unwrap().change - &change).norm() / change.norm();
    let errors: Vec<f64> = lived.iter().map(|(ate, _)| *ate).collect();
    let layers: Vec<f64> = lived.iter().map(|(_, lesson)| off(lesson)).collect();
    println!("frozen {frozen:.3?}\nlearning {errors:.3?}\noracle {oracle:.3?}\nlayer {layers:.2?}");
    let later = |of: &[f64]| of[2..].iter().sum::<f64>();
    assert!(later(&errors) < later(&frozen), "{errors:?} {frozen:?}");
    assert!(layers[11] < 0.95, "{layers:?}");
}

#[test]
fn crops_of_a_later_drive_are_known_better_before_they_are_seen() {
    let (model, spec) = (model(), WorldSpec::sparse_loop());
    let gains = |learner: &dyn Learner, worlds: &[World]| {
        let mut lesson = Lesson::default();
        let drive = |world: &World| {
            let learnt = learner.learn(&world.observations, &lesson).unwrap();
            lesson = learnt.lesson;
            learnt.gain.unwrap()
        };
        worlds.iter().map(drive).collect::<Vec<f64>>()
    };
    let settings = Settings { domain: PRIOR, ..matching_settings(&spec) };
    let off_alike = worlds_that_differ_alike(&model, 3, [1.05, 1.0]);
    let noisy: Vec<World> = (0..3)
        .map(|seed| World::new(&WorldSpec { semantic_sigma: 0.08, ..spec }, Some(&model), Seed(seed)))
        .collect();
    let as_trained: Vec<World> = (0..3).map(|seed| World::new(&spec, Some(&model), Seed(seed))).collect();
    let domain = DomainAdapted::new(&settings, &model);
    for worlds in [&off_alike, &as_trained] {
        let last = worlds.len() - 1;
        let (after, alone) = (gains(&domain, worlds)[last], gains(&domain, &worlds[last..])[0]);
        println!("domain: {after:.2} nat a crop after other drives, {alone:.2} on a first one");
        assert!(after > alone, "{after} {alone}");
    }
    let noise = gains(&Refitted::new(&settings, &model), &noisy);
    println!("noise {noise:.2?}");
    assert_eq!(noise[0], 0.0, "on a first drive nothing is known");
    assert!(noise[1] > 0.5 && noise[2] > 0.5, "{noise:?}");
}

#[test]
fn a_decoder_that_is_taught_by_the_truth_comes_nearer_to_the_right_one() {
    let model = model();
    let mut random = Seed(7).stream("another layer", 0);
    let change = DMatrix::from_fn(12, 33, |_, j| if j < 32 { 0.02 * random.normal() } else { 0.0 });
    let other = model.with_output(&change);
    let mut view = |_| {
        let latent = DVector::from_fn(8, |_, _| random.normal());
        let [x, y] = [random.normal(), random.normal()];
        let viewpoint = Viewpoint {
            direction: Vector3::new(x, y, 0.3 * x.hypot(y)).normalize(),
            roll: 0.0,
            log_distance: 0.5,
        };
        let measurement = other.predict(&latent, &viewpoint).unwrap();
        SeenView { measurement, latent, viewpoint, weight: 1.0 }
    };
    let seen: Vec<SeenView> = (0..2000).map(&mut view).collect();
    let spec = WorldSpec { objects: 0, ..WorldSpec::sparse_loop() };
    let world = World::new(&spec, Some(&model), Seed(0));
    let taught = DecoderTaught::new(&matching_settings(&spec), &model, &seen);
    let lesson = taught.learn(&world.observations, &Lesson::default()).unwrap().lesson;
    let off = (&lesson.decoder.unwrap().change - &change).norm() / change.norm();
    assert!(off < 0.2, "{off}");
}
