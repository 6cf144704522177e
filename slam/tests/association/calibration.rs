//! Whether a weight of 70% is right 70 times of 100, and whether the truth survives.

use crate::linear_world::{CLUTTER, MODEL, Model, zero};
use nalgebra::Vector2;
use vantage_dataset::Seed;
use vantage_slam::Key;
use vantage_slam::association::{
    Addition, Alternative, Choice, Frame, Hypotheses, Limits, Merging, SharedSmoother, Thresholds,
};

const OBJECTS: usize = 4;
const STEPS: usize = 8;
const FALSE_SHARE: f64 = 0.2;
/// Clutter is spread as objects seen from the origin are.
const CLUTTER_DEVIATION: f64 = 3.0;

struct Outcome {
    /// Probability given to each way to take each choice, and whether it is true.
    stated: Vec<(f64, bool)>,
    survived: bool,
    given_up: f64,
}

/// A robot among objects whose places are known to 0.8 m, one of which, or clutter, it sees at a step; drawn from what the engine is told.
fn run(seed: u64, limits: Limits) -> Outcome {
    let model = Model { motion: 0.5, ..MODEL };
    let mut stream = Seed(seed).stream("calibration", 0);
    let mut draw = |scale: f64| Vector2::new(stream.normal(), stream.normal()) * scale;
    let guesses: Vec<Vector2<f64>> = (0..OBJECTS).map(|_| draw(1.5)).collect();
    let objects: Vec<Vector2<f64>> = guesses.iter().map(|guess| guess + draw(0.8)).collect();
    let mut robot = draw(0.1);
    let mut track = vec![(robot, Vector2::zeros())];
    for _ in 1..STEPS {
        let motion = draw(0.3);
        robot += motion + draw(model.motion);
        track.push((robot, motion));
    }
    let noise: Vec<Vector2<f64>> = (0..STEPS).map(|_| draw(model.detection_deviation)).collect();
    let clutter: Vec<Vector2<f64>> = (0..STEPS).map(|_| draw(CLUTTER_DEVIATION)).collect();

    let mut hypotheses = Hypotheses::new(SharedSmoother::new(Thresholds::default()), limits);
    let mut truth = Vec::new();
    for step in 0..STEPS {
        let mut addition = if step == 0 { model.start() } else { model.step(step, track[step].1) };
        if step == 0 {
            for (object, guess) in guesses.iter().enumerate() {
                let mut prior = model.prior(object);
                (prior.measured, prior.deviation) = (*guess, 0.8);
                addition = addition.with_variable(Key::Landmark(object), zero()).with(prior);
            }
        }
        hypotheses.observe(|_| addition.clone()).unwrap();
        let is_false = stream.chance(FALSE_SHARE);
        let object = stream.below(OBJECTS);
        let seen = if is_false { clutter[step] } else { objects[object] - track[step].0 + noise[step] };
        truth.push(if is_false { CLUTTER } else { object });
        let mut alternatives: Vec<Alternative<'static>> = (0..OBJECTS)
            .map(|object| {
                let factor = model.sighting(step, object, seen);
                let log_weight = factor.log_normalizer() + ((1.0 - FALSE_SHARE) / OBJECTS as f64).ln();
                Alternative {
                    label: object,
                    addition: Addition::default().with(factor),
                    log_weight,
                    claims: None,
                }
            })
            .collect();
        let squared = CLUTTER_DEVIATION * CLUTTER_DEVIATION;
        let log_density =
            -seen.norm_squared() / (2.0 * squared) - (2.0 * std::f64::consts::PI * squared).ln();
        alternatives.push(Alternative {
            label: CLUTTER,
            addition: Addition::default(),
            log_weight: FALSE_SHARE.ln() + log_density,
            claims: None,
        });
        let choice = Choice { number: step, alternatives };
        hypotheses.choose(|_| Frame { choices: vec![choice.clone()], log_weight: 0.0 }).unwrap();
    }
    hypotheses.settle().unwrap();
    let labels = || (0..OBJECTS).chain([CLUTTER]);
    let stated = (0..STEPS)
        .flat_map(|step| labels().map(move |label| (step, label)))
        .map(|(step, label)| (hypotheses.probability(step, label), truth[step] == label))
        .collect();
    let is_true = |labels: Vec<usize>| labels == truth;
    let survived = (hypotheses.all().iter())
        .any(|hypothesis| is_true(hypothesis.verdicts().iter().map(|verdict| verdict.label).collect()));
    let given_up = hypotheses.given_up();
    let given_up = 1.0 - (1.0 - given_up.dropped) * (1.0 - given_up.merged);
    Outcome { stated, survived, given_up }
}

/// Compares what was stated with what was true, in bins, at four deviations of a binomial.
fn check(outcomes: &[Outcome]) {
    const BINS: usize = 10;
    let mut bins = [(0.0, 0.0, 0.0); BINS];
    for (stated, is_true) in outcomes.iter().flat_map(|outcome| &outcome.stated) {
        let bin = &mut bins[((stated * BINS as f64) as usize).min(BINS - 1)];
        bin.0 += 1.0;
        bin.1 += stated;
        bin.2 += f64::from(*is_true);
    }
    for (count, stated, hits) in bins {
        // Choices of one world go together, so the deviation is taken twice as wide.
        let deviation = 2.0 * (stated * (1.0 - stated / f64::max(count, 1.0))).max(1.0).sqrt();
        assert!((stated - hits).abs() < 4.0 * deviation, "{count}: {stated} stated, {hits} true");
    }
    let filled = bins.iter().filter(|bin| bin.0 > 40.0).count();
    assert!(filled >= 9, "{filled} bins are filled");
}

#[test]
fn weights_are_calibrated() {
    let limits = Limits { hypotheses: 500, least_weight: 1e-5, merging: None };
    let outcomes: Vec<Outcome> = (0..200).map(|seed| run(seed, limits)).collect();
    check(&outcomes);
}

#[test]
fn the_truth_is_lost_as_often_as_what_is_given_up_says() {
    let merging = Some(Merging { window: 3, distance: 0.3 });
    for limits in [
        Limits { hypotheses: 20, least_weight: 0.0, merging: None },
        Limits { hypotheses: 1000, least_weight: 1e-2, merging: None },
        Limits { hypotheses: 1000, least_weight: 1e-4, merging },
    ] {
        let outcomes: Vec<Outcome> = (0..200).map(|seed| run(1000 + seed, limits)).collect();
        let lost = outcomes.iter().filter(|outcome| !outcome.survived).count() as f64;
        let expected: f64 = outcomes.iter().map(|outcome| outcome.given_up).sum();
        assert!(expected > 1.0, "{limits:?} gives up {expected}");
        assert!(
            (lost - expected).abs() < 4.0 * expected.sqrt() + 1.0,
            "{limits:?}: {lost} lost, {expected} expected"
        );
    }
}
