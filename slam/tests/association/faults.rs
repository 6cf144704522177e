//! Worlds that are hard or empty: every one ends in bounded work with an answer, or with an error that says why.

use nalgebra::Vector2;
use std::f64::consts::PI;
use vantage_dataset::Seed;
use vantage_slam::Key;
use vantage_slam::association::planar::{
    CLUTTER, Detection, Motion, MotionMeasurement, PlanarBetween, PlanarNoise, PlanarPrior, PlanarSlam,
    Sensing, Sensor, pose, whitening,
};
use vantage_slam::association::{
    Addition, AssociationError, Choice, Frame, Hypotheses, Limits, SharedSmoother, Thresholds, Unsolved,
};

const ODOMETRY: [f64; 3] = [0.03, 0.03, 0.01];
const LIMITS: Limits = Limits { hypotheses: 50, ..DEFAULT };
const DEFAULT: Limits = Limits { hypotheses: 0, least_weight: 1e-4, merging: None };

struct Case {
    objects: Vec<(Vector2<f64>, usize)>,
    clutter: f64,
    steps: usize,
    classes: usize,
}

struct Answer {
    hypotheses: Hypotheses<SharedSmoother<'static>>,
    /// The object of each detection, or [`CLUTTER`].
    truth: Vec<usize>,
    /// Errors of the last pose, metres: of the estimate, and of odometry.
    errors: [f64; 2],
}

/// A robot that drives round a circle of 3 m twice.
fn run(case: &Case, seed: u64) -> Answer {
    let sensor = Sensor {
        range: 6.0,
        half_angle: PI,
        sqrt_information: whitening([0.05; 2]),
        detection: 0.9,
        clutter: f64::max(case.clutter, 0.01),
        density: f64::max(case.objects.len() as f64, 1.0) / 144.0,
        classes: case.classes,
        candidates: 4,
    };
    let mut stream = Seed(seed).stream("faults", 0);
    let motion = Motion::new(6.0 * PI * 2.0 / case.steps as f64, 0.0, 4.0 * PI / case.steps as f64);
    let limits = Limits { merging: Limits::default().merging, ..LIMITS };
    let mut hypotheses = Hypotheses::new(SharedSmoother::new(Thresholds::default()), limits);
    let mut sensing = Sensing::new(sensor);
    let mut truth = Vec::new();
    let (mut robot, mut reckoned) = (Motion::new(0.0, 0.0, 0.0), Motion::new(0.0, 0.0, 0.0));
    for step in 0..case.steps {
        let mut addition = Addition::default();
        let key = Key::Robot(step);
        if step == 0 {
            let prior = PlanarPrior::new(key, robot, whitening([1e-3; 3]));
            hypotheses
                .observe(|_| addition.clone().with(prior.clone()).with_variable(key, robot.to_value()))
                .unwrap();
        } else {
            robot = robot.then(motion);
            let mut noisy = |value: f64, deviation: f64| value + deviation * stream.normal();
            let measured = Motion::new(
                noisy(motion.x, ODOMETRY[0]),
                noisy(motion.y, ODOMETRY[1]),
                noisy(motion.heading, ODOMETRY[2]),
            );
            reckoned = reckoned.then(measured);
            addition =
                addition.with(PlanarBetween::new(Key::Robot(step - 1), key, measured, whitening(ODOMETRY)));
            hypotheses
                .observe(|hypothesis| {
                    let first = pose(hypothesis.estimator(), step - 1).unwrap().then(measured);
                    addition.clone().with_variable(key, first.to_value())
                })
                .unwrap();
        }
        let mut frame = Vec::new();
        let mut see = |measured: Vector2<f64>, class: usize, object: usize| {
            frame.push(Detection { number: truth.len(), measured, class });
            truth.push(object);
        };
        for (object, (place, class)) in case.objects.iter().enumerate() {
            let noise = Vector2::new(stream.normal(), stream.normal()) * 0.05;
            if sensor.sees(robot, *place) && stream.chance(sensor.detection) {
                see(robot.seen(*place) + noise, *class, object);
            }
        }
        // A Poisson number of them, drawn as a sum of rare events.
        for _ in (0..100).filter(|_| stream.chance(case.clutter / 100.0)).collect::<Vec<_>>() {
            let (range, turn) = (sensor.range * stream.unit().sqrt(), stream.uniform(-PI, PI));
            let class = stream.below(case.classes);
            see(Vector2::new(range * libm::cos(turn), range * libm::sin(turn)), class, CLUTTER);
        }
        hypotheses.choose(|hypothesis| sensing.frame(hypothesis, step, &frame)).unwrap();
        sensing.look(step, &frame);
        assert!(hypotheses.all().len() <= limits.hypotheses);
        let total: f64 = hypotheses.all().iter().map(|hypothesis| hypothesis.weight()).sum();
        assert!((total - 1.0).abs() < 1e-9);
    }
    hypotheses.settle().unwrap();
    let last = pose(hypotheses.best().unwrap().estimator(), case.steps - 1).unwrap();
    let off = |at: Motion| (Vector2::new(at.x, at.y) - Vector2::new(robot.x, robot.y)).norm();
    Answer { hypotheses, truth, errors: [off(last), off(reckoned)] }
}

impl Answer {
    fn labels(&self) -> Vec<usize> {
        self.hypotheses.best().unwrap().verdicts().iter().map(|verdict| verdict.label).collect()
    }

    /// F1 of pairs of detections in one object.
    fn f1(&self) -> f64 {
        let labels = self.labels();
        assert_eq!(labels.len(), self.truth.len());
        let (mut both, mut either) = (0, 0);
        for i in 0..labels.len() {
            for j in 0..i {
                let told = labels[i] == labels[j] && labels[i] != CLUTTER;
                let real = self.truth[i] == self.truth[j] && self.truth[i] != CLUTTER;
                both += 2 * usize::from(told && real);
                either += usize::from(told) + usize::from(real);
            }
        }
        both as f64 / either as f64
    }

    fn objects(&self) -> usize {
        let mut labels: Vec<usize> = self.labels().into_iter().filter(|label| *label != CLUTTER).collect();
        labels.sort_unstable();
        labels.dedup();
        labels.len()
    }
}

fn scattered(count: usize, classes: usize, side: f64) -> Vec<(Vector2<f64>, usize)> {
    let mut stream = Seed(count as u64).stream("objects", 0);
    let half = side / 2.0;
    (0..count)
        .map(|i| (Vector2::new(stream.uniform(-half, half), 3.0 + stream.uniform(-half, half)), i % classes))
        .collect()
}

#[test]
fn without_an_object_the_track_is_odometry() {
    let answer = run(&Case { objects: vec![], clutter: 0.0, steps: 60, classes: 1 }, 1);
    assert_eq!(answer.hypotheses.all().len(), 1);
    assert!((answer.errors[0] - answer.errors[1]).abs() < 1e-9, "{:?}", answer.errors);
}

#[test]
fn objects_all_alike_are_told_apart_by_place() {
    let answer = run(&Case { objects: scattered(8, 1, 12.0), clutter: 0.0, steps: 80, classes: 1 }, 2);
    assert!(answer.f1() > 0.99, "{}", answer.f1());
    assert_eq!(answer.objects(), 8);
    assert!(answer.errors[0] < answer.errors[1], "{:?}", answer.errors);
}

#[test]
fn two_objects_at_one_place_are_two_where_both_are_seen_at_once() {
    let mut objects = scattered(4, 1, 12.0);
    objects.push(objects[0]);
    let answer = run(&Case { objects, clutter: 0.0, steps: 60, classes: 1 }, 3);
    // Which of the two a detection is of cannot be known.
    assert_eq!(answer.objects(), 5);
    assert!(answer.errors[0] < answer.errors[1], "{:?}", answer.errors);
}

#[test]
fn three_false_detections_of_ten_are_told_from_objects() {
    // Each of 8 objects is seen in 9 of 10 views: 3.1 false ones make 30%.
    let answer = run(&Case { objects: scattered(8, 2, 8.0), clutter: 3.1, steps: 80, classes: 2 }, 4);
    let clutter = answer.truth.iter().filter(|object| **object == CLUTTER).count() as f64;
    assert!((clutter / answer.truth.len() as f64 - 0.3).abs() < 0.05);
    assert!(answer.f1() > 0.98, "{}", answer.f1());
    assert!(answer.errors[0] < answer.errors[1], "{:?}", answer.errors);
}

#[test]
fn five_hundred_objects_are_bounded_work() {
    let answer = run(&Case { objects: scattered(500, 5, 60.0), clutter: 0.5, steps: 40, classes: 5 }, 5);
    let work = answer.hypotheses.work();
    assert!(work.most <= LIMITS.hypotheses && work.updates <= 60 * LIMITS.hypotheses, "{work:?}");
    assert!(answer.errors[0] < answer.errors[1], "{:?}", answer.errors);
}

#[test]
fn what_cannot_be_is_an_error() {
    let mut hypotheses = Hypotheses::new(SharedSmoother::new(Thresholds::default()), Limits::default());
    let origin = Motion::new(0.0, 0.0, 0.0);
    let free = Addition::default().with_variable(Key::Robot(0), origin.to_value());
    hypotheses.observe(|_| free.clone()).unwrap();
    let error = hypotheses.settle().unwrap_err();
    assert_eq!(error, AssociationError::Unsolved(Unsolved::Free(Key::Robot(0))));
    assert!(hypotheses.best().is_none());

    let mut hypotheses = Hypotheses::new(SharedSmoother::new(Thresholds::default()), Limits::default());
    let between = PlanarBetween::new(Key::Robot(0), Key::Robot(9), origin, whitening(ODOMETRY));
    let undefined = free.with(between);
    let error = hypotheses.observe(|_| undefined.clone()).unwrap_err();
    assert_eq!(error, AssociationError::Unsolved(Unsolved::Undefined(Key::Robot(0))));

    let mut hypotheses = Hypotheses::new(SharedSmoother::new(Thresholds::default()), Limits::default());
    let none = Frame { choices: vec![Choice { number: 7, alternatives: vec![] }], log_weight: 0.0 };
    assert_eq!(hypotheses.choose(|_| none.clone()), Err(AssociationError::Impossible(7)));
}

#[test]
fn odometry_of_two_modes_stays_open_until_a_loop_tells() {
    let noise = PlanarNoise {
        motion: [0.03, 0.03, 0.01],
        start: [1e-3; 3],
        point: [0.1; 2],
        reach: 3.0,
        false_share: 0.5,
    };
    let limits = Limits { merging: Limits::default().merging, ..LIMITS };
    let mut slam = PlanarSlam::new(noise, limits, Thresholds::default()).unwrap();
    let quarter = Motion::new(1.0, 0.0, PI / 2.0);
    let other = Motion::new(1.5, 0.5, PI / 4.0);
    for step in 0..8 {
        let modes = if step == 2 { vec![other, quarter] } else { vec![quarter] };
        let measurement = MotionMeasurement { from: step, to: step + 1, modes, is_detachable: false };
        slam.move_by(step, &measurement).unwrap();
    }
    slam.settle().unwrap();
    assert!((slam.hypotheses().probability(2, 1) - 0.5).abs() < 1e-6);
    let home = MotionMeasurement {
        from: 8,
        to: 0,
        modes: vec![Motion::new(0.02, -0.03, 0.01)],
        is_detachable: true,
    };
    slam.move_by(100, &home).unwrap();
    slam.settle().unwrap();
    assert!(slam.hypotheses().probability(2, 1) > 0.999 && slam.hypotheses().probability(100, 0) > 0.999);
    assert!(slam.hypotheses().entropy() < 0.01);
}
