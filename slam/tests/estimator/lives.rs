//! Learning over lives: what a drive teaches, the next one knows; a life that was stopped goes on; garbage is forgotten.

use crate::learning::{PRIOR, model, moved};
use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::{DMatrix, DVector, Vector3};
use vantage_dataset::{Seed, Viewpoint};
use vantage_model::ObservationModel;
use vantage_slam::{
    DecoderAdapted, DecoderChecked, DecoderTaught, DomainAdapted, Estimator, Learner, Lesson, Refitted,
    SeenView, Semantic, Settings,
};

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
    let off_alike = worlds_that_differ_alike(&model, 4, [1.3, 8.0]);
    let spec = WorldSpec::sparse_loop();
    let settings = Settings { domain: PRIOR, ..matching_settings(&spec) };
    let other = model.with_output(&other_layer());
    let of_another_layer: Vec<World> =
        (0..4).map(|seed| World::new(&spec, Some(&other), Seed(seed))).collect();
    let all: [(&dyn Learner, &[World]); 4] = [
        (&DomainAdapted::new(&settings, &model), &off_alike),
        (&Refitted::new(&settings, &model), &off_alike),
        (&DecoderAdapted::new(&settings, &model), &off_alike),
        (&DecoderChecked::new(&settings, &model), &of_another_layer),
    ];
    for (learner, worlds) in all {
        let whole = life(learner, worlds);
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
        assert_ne!(lesson, Lesson::default(), "something is taught");
        assert!(lengths[3] < 2 * lengths[2].max(500), "{lengths:?}");
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

/// What another layer has otherwise than the model's.
fn other_layer() -> DMatrix<f64> {
    let mut random = Seed(7).stream("another layer", 0);
    DMatrix::from_fn(12, 33, |_, j| if j < 32 { 0.02 * random.normal() } else { 0.0 })
}

#[test]
fn a_last_layer_that_is_wrong_is_learnt_over_a_life() {
    let model = model();
    let change = other_layer();
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
fn a_checked_life_keeps_what_predicts_other_crops_and_noise_teaches_it_nothing() {
    let model = model();
    let change = other_layer();
    let other = model.with_output(&change);
    let spec = WorldSpec::sparse_loop();
    let settings = matching_settings(&spec);
    let learner = DecoderChecked::new(&settings, &model);
    let worlds: Vec<World> = (0..6).map(|seed| World::new(&spec, Some(&other), Seed(seed))).collect();
    let lived = life(&learner, &worlds);
    let layer = |lesson: &Lesson| lesson.decoder.as_ref().map(|of| of.change.clone());
    let mut changes = vec![None];
    changes.extend(lived.iter().map(|(_, lesson)| layer(lesson)));
    let kept = changes.windows(2).filter(|of| of[0] != of[1]).count();
    let off = |lesson: &Lesson| layer(lesson).map_or(1.0, |own| (own - &change).norm() / change.norm());
    println!(
        "kept on {kept} of 6 drives; layer {:.3?}",
        lived.iter().map(|(_, of)| off(of)).collect::<Vec<_>>()
    );
    assert!(kept >= 3, "{kept}");
    assert!(off(&lived[5].1) < 0.95 * off(&lived[0].1), "more is known than the first drive taught");

    let known = &lived[5].1;
    let learnt_model = model.with_output(&layer(known).unwrap());
    let noisy = WorldSpec { semantic_sigma: 0.15, ..spec };
    let mut kept = 0;
    for seed in 6..9 {
        let learn = |learner: &dyn Learner, spec: &WorldSpec| {
            let world = World::new(spec, Some(&other), Seed(seed));
            let learnt = learner.learn(&world.observations, known).unwrap();
            let by_known = Semantic::new(&settings, &learnt_model).estimate(&world.observations).unwrap();
            (learnt, by_known.world_from_robot)
        };
        kept += usize::from(&learn(&learner, &spec).0.lesson != known);
        let (learnt, by_known) = learn(&learner, &noisy);
        let (unchecked, _) = learn(&DecoderAdapted::new(&settings, &model), &noisy);
        assert_eq!(&learnt.lesson, known, "what is rolled back teaches nothing");
        assert_eq!(learnt.estimate.world_from_robot, by_known, "what was known answers");
        assert_ne!(unchecked.estimate.world_from_robot, by_known, "unchecked, noise is learnt");
        assert_eq!(learnt.gain.unwrap(), unchecked.gain.unwrap(), "before it is seen both know the same");
    }
    assert!(kept >= 2, "without noise the same drives teach: {kept}");
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
    let change = other_layer();
    let other = model.with_output(&change);
    let mut random = Seed(7).stream("views", 0);
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
