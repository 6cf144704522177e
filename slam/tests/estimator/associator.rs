//! Who is who in simulated worlds: tracklets whose objects nobody names.

use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use vantage_dataset::{Detection, Observations, Seed, Tracklets};
use vantage_slam::association::Limits;
use vantage_slam::associator::{
    Alternating, Association, AssociationSettings, Associator, Blind, Encoded, EncodedSettings, Heading,
    Hypothesizing, Likeness, Separate, Weights,
};
use vantage_slam::problem::Problem;
use vantage_slam::sighting::Sighting;
use vantage_slam::variable::{Value, Values};
use vantage_slam::{EstimateError, Estimator, Geometric, Key};

pub const GAP: usize = 3;
/// The encoder of these worlds is linear in a model that is not: it errs by more than it says.
pub const LIKENESS: EncodedSettings =
    EncodedSettings { views: 8, latent_exponent: 0.02, side_exponent: 0.1, copies: 0.1 };

pub fn model() -> TanhModel {
    TanhModel::new([6, 12, 24], 0.03, 8.0, Seed(5))
}

pub fn settings(spec: &WorldSpec) -> AssociationSettings {
    // Objects of these worlds are larger than those of scenes.
    let size = World::new(spec, None, Seed(99)).sizes.iter().sum::<f64>() / spec.objects as f64;
    AssociationSettings { size, ..AssociationSettings::default() }
}

/// Objects numbered by their first tracklets.
pub fn named(objects: &[Option<usize>]) -> Vec<Option<usize>> {
    let mut names = BTreeMap::new();
    let name = |object: &Option<usize>| {
        object.map(|object| {
            let next = names.len();
            *names.entry(object).or_insert(next)
        })
    };
    objects.iter().map(name).collect()
}

/// The true object of each tracklet.
pub fn truth(given: &Observations, tracklets: &Tracklets, order: &[usize]) -> Vec<Option<usize>> {
    let mut objects = vec![None; tracklets.count()];
    for (detection, number) in tracklets.observations().detections.iter().zip(order) {
        objects[detection.track] = Some(given.detections[*number].track);
    }
    objects
}

pub fn associate(associator: &impl Associator, given: &Observations) -> (Association, bool) {
    let (tracklets, order) = Tracklets::joined(given, GAP);
    let association = associator.associate(&tracklets).unwrap();
    let truth = truth(given, &tracklets, &order);
    // What is never seen whole has no bearing.
    let is_whole = |tracklet: usize| {
        let mut detections = tracklets.observations().detections.iter();
        detections.any(|d| d.track == tracklet && !d.bounding_box.is_truncated(&given.camera))
    };
    let whole: Vec<usize> = (0..tracklets.count()).filter(|tracklet| is_whole(*tracklet)).collect();
    let of = |objects: &[Option<usize>]| named(&whole.iter().map(|t| objects[*t]).collect::<Vec<_>>());
    let is_right = of(association.objects()) == of(&truth);
    (association, is_right)
}

#[test]
fn geometry_tells_objects_apart_where_drift_is_small() {
    let spec = WorldSpec { odometry_sigma: [0.003, 0.005], ..WorldSpec::sparse_loop() };
    for seed in 0..4 {
        let given = World::new(&spec, None, Seed(seed)).observations;
        let blind = Hypothesizing::new(&matching_settings(&spec), settings(&spec), Blind);
        let (association, is_right) = associate(&blind, &given);
        assert!(is_right, "seed {seed}: {:?}", association.objects());
        let weights: f64 = association.hypotheses.iter().map(|h| h.weight).sum();
        assert!((weights - 1.0).abs() < 1e-9 && association.times.len() == given.steps());
        let (_, is_right) = associate(&Separate, &given);
        assert!(!is_right, "seed {seed}: an object is seen again");
    }
}

#[test]
fn an_answer_that_is_right_gives_the_estimate_of_given_association() {
    let spec = WorldSpec::sparse_loop();
    let given = World::new(&spec, None, Seed(1)).observations;
    let estimator = Geometric::new(&matching_settings(&spec));
    let blind = Hypothesizing::new(&matching_settings(&spec), settings(&spec), Blind);
    let (tracklets, _) = Tracklets::joined(&given, GAP);
    let found = tracklets.associated(blind.associate(&tracklets).unwrap().objects());
    let (told, found) = (estimator.estimate(&given).unwrap(), estimator.estimate(&found).unwrap());
    for (a, b) in told.world_from_robot.iter().zip(&found.world_from_robot) {
        assert!((a.translation.vector - b.translation.vector).norm() < 1e-6);
    }
}

#[test]
fn crops_that_say_nothing_change_no_weight() {
    let spec = WorldSpec::sparse_loop();
    let model = model();
    let given = World::new(&spec, Some(&model), Seed(2)).observations;
    let silent = EncodedSettings { latent_exponent: 0.0, side_exponent: 0.0, ..LIKENESS };
    let (estimator, own) = (matching_settings(&spec), settings(&spec));
    let (a, _) = associate(&Hypothesizing::new(&estimator, own, Blind), &given);
    let (b, _) = associate(&Hypothesizing::new(&estimator, own, Encoded::new(&model, silent)), &given);
    assert_eq!(a.hypotheses.len(), b.hypotheses.len());
    for (a, b) in a.hypotheses.iter().zip(&b.hypotheses) {
        assert_eq!(a.objects, b.objects);
        assert!((a.weight - b.weight).abs() < 1e-9);
    }
}

#[test]
fn crops_tell_objects_apart_that_drift_mixes_up() {
    let spec = WorldSpec { odometry_sigma: [0.05, 0.02], semantic_sigma: 0.3, ..WorldSpec::sparse_loop() };
    let model = TanhModel::new([6, 12, 24], 0.3, 8.0, Seed(5));
    let (estimator, own) = (matching_settings(&spec), settings(&spec));
    let (mut blind, mut seeing) = (0, 0);
    for seed in 0..30 {
        let given = World::new(&spec, Some(&model), Seed(seed)).observations;

        blind += usize::from(associate(&Hypothesizing::new(&estimator, own, Blind), &given).1);
        let encoded = Encoded::new(
            &model,
            EncodedSettings { views: 8, latent_exponent: 0.3, side_exponent: 0.3, copies: 0.1 },
        );
        seeing += usize::from(associate(&Hypothesizing::new(&estimator, own, encoded), &given).1);
    }
    println!("right on 30 seeds: {blind} without crops, {seeing} with them");
    assert!(blind + 4 <= seeing, "{blind} without crops, {seeing} with them");
}

#[test]
fn a_likeness_turns_with_its_frames_and_knows_no_order() {
    let spec = WorldSpec { laps: 2.0, ..WorldSpec::sparse_loop() }.noiseless();
    let model = model();
    let world = World::new(&spec, Some(&model), Seed(3));
    let settings = matching_settings(&spec);
    let (tracklets, order) = Tracklets::joined(&world.observations, GAP);
    let truth = truth(&world.observations, &tracklets, &order);
    let encoded = Encoded::new(&model, LIKENESS);
    let latents = Encoded::new(&model, EncodedSettings { side_exponent: 0.0, ..LIKENESS });
    let observations = tracklets.observations();
    let problem = Problem { observations, settings: &settings.geometry };
    let read = |tracklet: usize| {
        let object = truth[tracklet].unwrap();
        let numbered = observations.detections.iter().enumerate();
        let sightings: Vec<Sighting> = numbered
            .filter(|(_, detection)| detection.track == tracklet)
            .filter_map(|(index, detection)| Sighting::new(&observations.camera, index, detection))
            .collect();
        let mut values = Values::default();
        let place = world.world_from_object[object].translation.vector;
        values.insert(Key::Object(0), Value::Point(place));
        for sighting in &sightings {
            values.insert(Key::Robot(sighting.step), Value::Pose(world.world_from_robot[sighting.step]));
        }
        (object, encoded.read(&problem, &values, &sightings).unwrap())
    };
    let readings: Vec<_> =
        (0..tracklets.count()).map(read).filter(|(_, reading)| reading.is_some()).collect();
    let at = |yaw| Heading { yaw, variance: 0.0 };
    let (mut of_same, mut of_other) = (Vec::new(), Vec::new());
    for (i, (a, first)) in readings.iter().enumerate() {
        assert!(encoded.log_ratio_of(&[(first, at(0.3))]).abs() < 1e-9);
        for (b, second) in &readings[..i] {
            let ratio = encoded.log_ratio_of(&[(first, at(0.0)), (second, at(0.0))]);
            let swapped = encoded.log_ratio_of(&[(second, at(0.0)), (first, at(0.0))]);
            let turned = encoded.log_ratio_of(&[(first, at(PI / 2.0)), (second, at(PI / 2.0))]);
            assert!((ratio - swapped).abs() < 1e-9 && (ratio - turned).abs() < 1e-9);
            if a == b {
                assert!(ratio > 0.5, "object {a}: {ratio}");
                let apart = encoded.log_ratio_of(&[(first, at(0.0)), (second, at(PI / 2.0))]);
                assert!(apart < ratio - 0.5, "object {a} turned by a quarter: {apart} for {ratio}");
                let lost = Heading { yaw: 0.0, variance: 9.0 };
                let unknown = encoded.log_ratio_of(&[(first, at(0.0)), (second, lost)]);
                assert!(unknown < ratio, "object {a} by a lost robot: {unknown} for {ratio}");
                let alone = |yaw| latents.log_ratio_of(&[(first, at(0.0)), (second, at(yaw))]);
                assert!((alone(0.0) - alone(PI / 2.0)).abs() < 1e-9, "object {a}");
                of_same.push(alone(0.0));
            } else {
                assert!(ratio < -2.0, "objects {a} and {b}: {ratio}");
                of_other.push(latents.log_ratio_of(&[(first, at(0.0)), (second, at(0.0))]));
            }
        }
    }
    assert!(of_same.len() >= 4 && of_other.len() >= 20, "{} and {} pairs", of_same.len(), of_other.len());
    let mean = |ratios: &[f64]| ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!(mean(&of_same) > mean(&of_other) + 0.3, "latents alone: {of_same:?} {of_other:?}");
}

#[test]
fn a_tracklet_of_one_sighting_is_charged_once_and_when_it_has_ended() {
    let spec = WorldSpec::sparse_loop();
    let estimator = matching_settings(&spec);
    let mut seen = World::new(&spec, None, Seed(1)).observations;
    let odds = |seen: &Observations, single: f64| {
        let own = AssociationSettings { single, clutter: 0.5, ..settings(&spec) };
        let (association, _) = associate(&Hypothesizing::new(&estimator, own, Blind), seen);
        let weight = |is_object: bool| -> f64 {
            let all = association.hypotheses.iter().filter(|h| h.objects[0].is_some() == is_object);
            all.map(|hypothesis| hypothesis.weight).sum()
        };
        weight(true) / weight(false)
    };
    let ratio = |seen: &Observations| odds(seen, 0.3) / odds(seen, 0.1);
    let whole: Vec<Detection> = (seen.detections.iter())
        .filter(|detection| !detection.bounding_box.is_truncated(&seen.camera))
        .cloned()
        .collect();
    seen.detections = whole[..1].to_vec();
    assert!((ratio(&seen) - 3.0).abs() < 1e-6, "{}", ratio(&seen));
    seen.detections = whole[whole.len() - 1..].to_vec();
    assert_eq!(seen.detections[0].step + 1, seen.steps(), "it is seen at the last step");
    assert!((ratio(&seen) - 1.0).abs() < 1e-6, "{}", ratio(&seen));
}

#[test]
fn a_robot_without_odometry_is_told() {
    let spec = WorldSpec::sparse_loop();
    let estimator = matching_settings(&spec);
    let mut seen = World::new(&spec, None, Seed(1)).observations;
    seen.odometry.retain(|odometry| odometry.to != 5);
    let (tracklets, _) = Tracklets::joined(&seen, GAP);
    let told = Hypothesizing::new(&estimator, settings(&spec), Blind).associate(&tracklets).unwrap_err();
    assert_eq!(told, EstimateError::Unreached { step: 5 });
}

#[test]
fn a_model_that_fails_is_told() {
    let spec = WorldSpec::sparse_loop();
    let given = World::new(&spec, None, Seed(1)).observations;
    let mut settings = matching_settings(&spec);
    settings.odometry.bias = None;
    let mut broken = given.clone();
    broken.odometry[3].to = 10_000;
    let (tracklets, _) = Tracklets::joined(&broken, GAP);
    let blind = Hypothesizing::new(&settings, AssociationSettings::default(), Blind);
    assert!(matches!(blind.associate(&tracklets), Err(EstimateError::Odometry { index: 3, .. })));
}

#[test]
fn rivals_find_who_is_who_where_drift_is_small() {
    let spec = WorldSpec { odometry_sigma: [0.002, 0.003], ..WorldSpec::sparse_loop() };
    let (estimator, own) = (matching_settings(&spec), settings(&spec));
    let model = model();
    let gated =
        AssociationSettings { gate: Some(9.21), limits: Limits { hypotheses: 1, ..own.limits }, ..own };
    let latents = EncodedSettings { side_exponent: 0.0, ..LIKENESS };
    let mut right = [0; 3];
    for seed in 0..6 {
        let given = World::new(&spec, Some(&model), Seed(seed)).observations;
        let (_, is_right) = associate(&Hypothesizing::new(&estimator, gated, Blind), &given);
        right[0] += usize::from(is_right);
        for (which, weights) in [Weights::Expected, Weights::Largest].into_iter().enumerate() {
            let rival = Alternating::new(&estimator, gated, Encoded::new(&model, latents), weights);
            right[1 + which] += usize::from(associate(&rival, &given).1);
        }
    }
    println!("right on 6 seeds: nearest, expectation maximisation, max-mixture {right:?}");
    assert!(right.iter().all(|right| *right >= 4), "{right:?}");
}

#[test]
fn turns_drop_what_no_object_explains() {
    let spec = WorldSpec { odometry_sigma: [0.002, 0.003], ..WorldSpec::sparse_loop() };
    let mut given = World::new(&spec, None, Seed(1)).observations;
    // A box that jumps about is of nothing that stands still.
    let mut stream = Seed(8).stream("jump", 0);
    for step in 20..26 {
        let mut detection = given.detections[0].clone();
        let at = nalgebra::Vector2::new(stream.uniform(60.0, 400.0), stream.uniform(60.0, 300.0));
        (detection.step, detection.track) = (step, 900);
        detection.bounding_box.min = at;
        detection.bounding_box.max = at + nalgebra::Vector2::new(30.0, 30.0);
        given.detections.push(detection);
    }
    let own = AssociationSettings { gate: Some(9.21), ..settings(&spec) };
    let (tracklets, order) = Tracklets::joined(&given, GAP);
    let truth = truth(&given, &tracklets, &order);
    for weights in [Weights::Expected, Weights::Largest] {
        let rival = Alternating::new(&matching_settings(&spec), own, Blind, weights);
        let found = rival.associate(&tracklets).unwrap();
        for (found, truth) in found.objects().iter().zip(&truth) {
            assert_eq!(found.is_some(), *truth != Some(900), "{weights:?}");
        }
    }
}
