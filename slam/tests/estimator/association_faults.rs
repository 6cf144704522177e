//! Who is who in worlds that are hard or empty.

use crate::associator::{GAP, LIKENESS, associate, model, named, settings, truth};
use crate::model::TanhModel;
use crate::world::{World, WorldSpec, matching_settings};
use nalgebra::Vector3;
use vantage_dataset::{Observations, Seed, Tracklets};
use vantage_slam::associator::{AssociationSettings, Associator, Blind, Encoded, Hypothesizing};
use vantage_slam::{Estimator, Geometric, OdometryOnly};

#[test]
fn detections_of_nothing_no_objects_and_two_at_one_place_end_well() {
    let spec = WorldSpec::sparse_loop();
    let (estimator, own) = (matching_settings(&spec), settings(&spec));
    let blind = |clutter| Hypothesizing::new(&estimator, AssociationSettings { clutter, ..own }, Blind);

    let mut empty = World::new(&spec, None, Seed(1)).observations;
    empty.detections.clear();
    let (nothing, _) = associate(&blind(1e-3), &empty);
    assert_eq!(nothing.objects(), &[] as &[Option<usize>]);

    // Three of ten detections are of nothing, anywhere in the image.
    let mut littered = World::new(&spec, None, Seed(1)).observations;
    let mut stream = Seed(7).stream("litter", 0);
    let real = littered.detections.len();
    for number in 0..real * 3 / 7 {
        let mut detection = littered.detections[stream.below(real)].clone();
        let moved = nalgebra::Vector2::new(stream.normal() * 60.0, stream.normal() * 40.0);
        detection.bounding_box.min += moved;
        detection.bounding_box.max += moved;
        detection.track = 1000 + number;
        littered.detections.push(detection);
    }
    let (tracklets, order) = Tracklets::joined(&littered, GAP);
    let truth = truth(&littered, &tracklets, &order);
    let found = blind(0.3).associate(&tracklets).unwrap();
    let wrong = |is_litter: bool| {
        let pairs = found.objects().iter().zip(&truth).filter(|(_, t)| (t.unwrap() >= 1000) == is_litter);
        let (all, taken) =
            pairs.fold((0usize, 0usize), |(all, taken), (o, _)| (all + 1, taken + usize::from(o.is_some())));
        taken as f64 / all.max(1) as f64
    };
    assert!(wrong(true) < 0.2, "{} of what is not there taken for objects", wrong(true));
    assert!(wrong(false) > 0.8, "{} of tracklets of objects kept", wrong(false));
    let unlittered: Vec<_> = (found.objects().iter().zip(&truth))
        .filter(|(found, truth)| found.is_some() && truth.unwrap() < 1000)
        .map(|(found, truth)| (*found, *truth))
        .collect();
    let (mine, right): (Vec<_>, Vec<_>) = unlittered.into_iter().unzip();
    assert_eq!(named(&mine), named(&right));

    let mut doubled = World::new(&spec, None, Seed(1)).observations;
    let twins: Vec<_> = doubled.detections.iter().filter(|d| d.track == 0).cloned().collect();
    doubled.detections.extend(twins.into_iter().map(|d| vantage_dataset::Detection { track: 500, ..d }));
    let (tracklets, _) = Tracklets::joined(&doubled, GAP);
    let twice = blind(1e-3).associate(&tracklets).unwrap();
    for step in 0..doubled.steps() {
        let here = tracklets.observations().detections.iter().filter(|d| d.step == step);
        let mut objects: Vec<usize> = here.filter_map(|d| twice.objects()[d.track]).collect();
        let seen = objects.len();
        objects.sort_unstable();
        objects.dedup();
        assert_eq!(objects.len(), seen, "step {step}: one object is two detections");
    }
}

/// A world in which an object stands elsewhere from the middle of the run on: then it is a track of its own.
fn rearranged(spec: &WorldSpec, model: &TanhModel, seed: Seed, away: Vector3<f64>) -> World {
    let mut world = World::new(spec, Some(model), seed);
    let mut later = World::new(spec, Some(model), seed);
    later.world_from_object[0].translation.vector += away;
    later.observations.detections.clear();
    later.look(spec, Some(model), seed);
    let middle = spec.steps / 2;
    world.observations.detections.retain(|detection| detection.step < middle);
    let seen = later.observations.detections.into_iter().filter(|detection| detection.step >= middle);
    world.observations.detections.extend(seen.map(|mut detection| {
        if detection.track == 0 {
            detection.track = spec.objects;
        }
        detection
    }));
    world
}

#[test]
fn an_object_that_was_carried_away_is_another() {
    let spec = WorldSpec { steps: 80, laps: 2.0, odometry_sigma: [0.003, 0.005], ..WorldSpec::sparse_loop() };
    let (model, settings) = (model(), settings(&spec));
    let estimator = matching_settings(&spec);
    let geometric = Geometric::new(&estimator);
    let blind = Hypothesizing::new(&estimator, settings, Blind);
    let seeing = Hypothesizing::new(&estimator, settings, Encoded::new(&model, LIKENESS));
    for (seed, away) in (0..6).flat_map(|seed| [(seed, 0.4), (seed, 0.8)]) {
        let world = rearranged(&spec, &model, Seed(seed), Vector3::new(away, away, 0.0));
        let given = &world.observations;
        let (tracklets, _) = Tracklets::joined(given, GAP);
        let ate = |observations: &Observations| world.ate(&geometric.estimate(observations).unwrap());
        let reckoned = world.ate(&OdometryOnly::new(&estimator).estimate(given).unwrap());
        let (found, is_right) = associate(&blind, given);
        assert!(is_right, "seed {seed}, {away} m: {:?}", found.objects());
        let by_place = ate(&tracklets.associated(found.objects()));
        let by_looks = ate(&tracklets.associated(associate(&seeing, given).0.objects()));
        assert!(by_place < reckoned && by_looks < reckoned, "{by_place} {by_looks} {reckoned}");

        let mut still = given.clone();
        still.detections.iter_mut().filter(|d| d.track == spec.objects).for_each(|d| d.track = 0);
        assert!(by_looks < ate(&still), "seed {seed}: told that it stood still");
    }
}

#[test]
fn five_hundred_objects_in_space_are_bounded_work() {
    let spec = WorldSpec { objects: 500, steps: 10, ..WorldSpec::sparse_loop() };
    let (estimator, settings) = (matching_settings(&spec), settings(&spec));
    let associator = Hypothesizing::new(&estimator, settings, Blind);
    let excess = |seed: u64| {
        let world = World::new(&spec, None, Seed(seed));
        let (found, _) = associate(&associator, &world.observations);
        assert!(found.hypotheses.len() <= settings.limits.hypotheses);
        let (tracklets, _) = Tracklets::joined(&world.observations, GAP);
        let found = tracklets.associated(found.objects());
        let ate = world.ate(&Geometric::new(&estimator).estimate(&found).unwrap());
        ate - world.ate(&OdometryOnly::new(&estimator).estimate(&found).unwrap())
    };
    let all: Vec<f64> = (1..5).map(excess).collect();
    let mean = all.iter().sum::<f64>() / 4.0;
    let deviation = (all.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / 3.0).sqrt();
    // Student's t of three degrees of freedom, 95%.
    let half_width = 3.182 * deviation / 2.0;
    println!("{all:?}: {mean} +- {half_width}");
    assert!(mean <= half_width, "worse than odometry: {all:?}");
}
