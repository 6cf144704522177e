//! Weights against those of all assignments, each integrated densely.

use crate::linear_world::{CLUTTER, MODEL, Model, values};
use nalgebra::{DMatrix, DVector, Vector2};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use vantage_dataset::Seed;
use vantage_slam::Key;
use vantage_slam::association::{Hypotheses, Limits, SharedSmoother, Thresholds};

/// Everything is solved for.
const THRESHOLDS: Thresholds = Thresholds { relinearization: 0.1, propagation: 0.0, rounds: 10 };

/// Motions and what is seen at each step.
fn world(seed: u64, counts: &[usize]) -> (Vec<Vector2<f64>>, Vec<Vec<Vector2<f64>>>) {
    let mut stream = Seed(seed).stream("world", 0);
    let mut draw = |scale: f64| Vector2::new(stream.normal(), stream.normal()) * scale;
    let motions = counts.iter().map(|_| draw(0.5)).collect();
    let objects = [draw(0.6), draw(0.6)];
    let seen = counts.iter().map(|&n| (0..n).map(|i| objects[i % 2] + draw(0.4)).collect()).collect();
    (motions, seen)
}

/// `log` of the weight of one assignment: its terms as one dense information matrix.
fn log_weight(model: &Model, motions: &[Vector2<f64>], seen: &[Vec<Vector2<f64>>], labels: &[usize]) -> f64 {
    let steps = seen.len();
    let mut objects: Vec<usize> = Vec::new();
    let mut log = 0.0;
    // Rows: coefficients of poses and then objects, the measured place, the deviation.
    let mut rows: Vec<(BTreeMap<usize, f64>, Vector2<f64>, f64)> = Vec::new();
    rows.push((BTreeMap::from([(0, 1.0)]), Vector2::zeros(), 0.1));
    let mut number = 0;
    for step in 0..steps {
        if step > 0 {
            rows.push((BTreeMap::from([(step - 1, -1.0), (step, 1.0)]), motions[step], model.motion));
        }
        let before = objects.clone();
        let mut assigned = 0;
        for place in &seen[step] {
            let label = labels[number];
            if label == CLUTTER {
                log += model.clutter.ln();
            } else {
                if label == number {
                    objects.push(label);
                    rows.push((
                        BTreeMap::from([(steps + objects.len() - 1, 1.0)]),
                        Vector2::zeros(),
                        model.spread,
                    ));
                    log += model.birth.ln() - (2.0 * PI * model.spread * model.spread).ln();
                } else {
                    assigned += 1;
                    log += model.detection.ln();
                }
                let at = objects.iter().position(|object| *object == label).unwrap();
                rows.push((
                    BTreeMap::from([(step, -1.0), (steps + at, 1.0)]),
                    *place,
                    model.detection_deviation,
                ));
                log -= (2.0 * PI * model.detection_deviation * model.detection_deviation).ln();
            }
            number += 1;
        }
        log += (before.len() - assigned) as f64 * (1.0 - model.detection).ln();
    }
    let n = steps + objects.len();
    let (mut information, mut right, mut square) = (DMatrix::zeros(n, n), DMatrix::zeros(n, 2), 0.0);
    for (row, measured, deviation) in &rows {
        let w = 1.0 / (deviation * deviation);
        square += w * measured.norm_squared();
        for (&i, a) in row {
            for (&j, b) in row {
                information[(i, j)] += w * a * b;
            }
            (0..2).for_each(|axis| right[(i, axis)] += w * a * measured[axis]);
        }
    }
    let cholesky = information.cholesky().unwrap();
    let fit: f64 = right.dot(&cholesky.solve(&right));
    // Both axes share the information.
    log + n as f64 * (2.0 * PI).ln() - cholesky.ln_determinant() - (square - fit) / 2.0
}

/// All assignments: no object twice in a step.
fn assignments(counts: &[usize]) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    let mut number = 0;
    for &count in counts {
        let first = number;
        for _ in 0..count {
            let mut next = Vec::new();
            for labels in &all {
                let mut options: Vec<usize> = (0..first).filter(|&i| labels[i] == i).collect();
                options.retain(|object| !labels[first..].contains(object));
                options.extend([number, CLUTTER]);
                next.extend(options.into_iter().map(|option| [labels.as_slice(), &[option]].concat()));
            }
            all = next;
            number += 1;
        }
    }
    all
}

fn run(model: &Model, seed: u64, counts: &[usize], limits: Limits) -> Hypotheses<SharedSmoother<'static>> {
    let (motions, seen) = world(seed, counts);
    let mut hypotheses = Hypotheses::new(SharedSmoother::new(THRESHOLDS), limits);
    let mut number = 0;
    for (step, places) in seen.iter().enumerate() {
        let addition = if step == 0 { model.start() } else { model.step(step, motions[step]) };
        hypotheses.observe(|_| addition.clone()).unwrap();
        hypotheses.choose(|hypothesis| model.frame(hypothesis, step, number, places)).unwrap();
        number += places.len();
    }
    hypotheses.settle().unwrap();
    hypotheses
}

#[test]
fn weights_are_those_of_all_assignments() {
    for (seed, counts) in [(1, vec![1, 1, 1, 1, 1]), (2, vec![2, 2, 1]), (3, vec![2, 0, 3]), (4, vec![3, 2])]
    {
        let hypotheses = run(&MODEL, seed, &counts, Limits::exact());
        let (motions, seen) = world(seed, &counts);
        let all = assignments(&counts);
        let logs: Vec<f64> = all.iter().map(|labels| log_weight(&MODEL, &motions, &seen, labels)).collect();
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = logs.iter().map(|log| (log - largest).exp()).sum();
        let expected: BTreeMap<&[usize], f64> = (all.iter().zip(&logs))
            .map(|(labels, log)| (labels.as_slice(), (log - largest).exp() / total))
            .collect();
        assert_eq!(hypotheses.all().len(), all.len(), "{counts:?}");
        assert!(all.len() > 30 && expected.values().all(|weight| *weight < 0.9), "{counts:?} is too plain");
        for hypothesis in hypotheses.all() {
            let labels: Vec<usize> = hypothesis.verdicts().iter().map(|verdict| verdict.label).collect();
            let weight = expected[labels.as_slice()];
            assert!(
                (hypothesis.weight() - weight).abs() < 1e-9,
                "{labels:?}: {} for {weight}",
                hypothesis.weight()
            );
        }
        assert_eq!(hypotheses.given_up().dropped, 0.0);
    }
}

#[test]
fn what_pruning_drops_bounds_the_error_of_weights() {
    let counts = [2, 2, 1, 2];
    let whole = run(&MODEL, 5, &counts, Limits::exact());
    let mut is_used = false;
    for (hypotheses, least_weight) in [(200, 0.0), (40, 0.0), (usize::MAX, 1e-4), (usize::MAX, 1e-3)] {
        let pruned = run(&MODEL, 5, &counts, Limits { hypotheses, least_weight, merging: None });
        let dropped = pruned.given_up().dropped;
        assert!(pruned.all().len() < whole.all().len() && dropped > 0.0);
        is_used |= dropped > 1e-3;
        let exact: BTreeMap<_, f64> = whole.all().iter().map(|h| (h.verdicts(), h.weight())).collect();
        let kept: f64 = pruned.all().iter().map(|h| exact[&h.verdicts()]).sum();
        // Half the sum of differences of two distributions, one the other restricted to what is kept, is the mass that is not.
        let differences: f64 = pruned.all().iter().map(|h| (h.weight() - exact[&h.verdicts()]).abs()).sum();
        let total = (differences + 1.0 - kept) / 2.0;
        assert!(total < 10.0 * dropped, "{hypotheses}: {total} for {dropped}");
    }
    assert!(is_used);
}

#[test]
fn hypotheses_share_what_they_have_in_common() {
    let model = MODEL;
    let mut hypotheses = Hypotheses::new(SharedSmoother::new(Thresholds::default()), Limits::exact());
    hypotheses.observe(|_| model.start()).unwrap();
    for step in 1..400 {
        hypotheses.observe(|_| model.step(step, Vector2::new(0.01, 0.0))).unwrap();
    }
    for number in 0..2 {
        let seen = [Vector2::new(0.1, 0.2)];
        hypotheses.choose(|hypothesis| model.frame(hypothesis, 399, number, &seen)).unwrap();
        hypotheses.settle().unwrap();
    }
    let all = hypotheses.all();
    assert_eq!(all.len(), 5);
    for other in &all[1..] {
        let (fronts, shared) = all[0].estimator().shared_fronts(other.estimator());
        assert!(fronts > 50 && fronts - shared <= 3, "{shared} of {fronts}");
    }
}

#[test]
fn an_estimate_is_the_dense_solution_whatever_the_order_it_came_in() {
    let (motions, seen) = world(7, &[1; 30]);
    let model = Model { clutter: 1e-300, ..MODEL };
    let counts = [1; 30];
    let hypotheses = run(&model, 7, &counts, Limits { hypotheses: 1, least_weight: 0.0, merging: None });
    let best = hypotheses.best().unwrap();
    let labels: Vec<usize> = best.verdicts().iter().map(|verdict| verdict.label).collect();
    let mut keys: Vec<Key> = (0..30).map(Key::Robot).collect();
    let objects: Vec<usize> = (0..30).filter(|i| labels[*i] == *i).collect();
    keys.extend(objects.iter().map(|object| Key::Landmark(*object)));
    let at = |key: Key| keys.iter().position(|other| *other == key).unwrap();
    let n = keys.len();
    let mut information = DMatrix::<f64>::zeros(n, n);
    let mut right = DMatrix::<f64>::zeros(n, 2);
    let mut add = |row: &[(Key, f64)], measured: Vector2<f64>, deviation: f64| {
        let w = 1.0 / (deviation * deviation);
        for (a, x) in row {
            row.iter().for_each(|(b, y)| information[(at(*a), at(*b))] += w * x * y);
            (0..2).for_each(|axis| right[(at(*a), axis)] += w * x * measured[axis]);
        }
    };
    add(&[(Key::Robot(0), 1.0)], Vector2::zeros(), 0.1);
    for step in 0..30 {
        if step > 0 {
            add(&[(Key::Robot(step - 1), -1.0), (Key::Robot(step), 1.0)], motions[step], model.motion);
        }
        let object = Key::Landmark(labels[step]);
        add(&[(Key::Robot(step), -1.0), (object, 1.0)], seen[step][0], model.detection_deviation);
    }
    objects.iter().for_each(|object| add(&[(Key::Landmark(*object), 1.0)], Vector2::zeros(), model.spread));
    let solution = information.clone().cholesky().unwrap().solve(&right);
    for (key, value) in values(best.estimator()) {
        let expected = solution.row(at(key));
        assert!((0..2).all(|axis| (value[axis] - expected[axis]).abs() < 1e-9), "{key}");
    }
    let covariance = information.try_inverse().unwrap();
    use vantage_slam::association::LocalEstimator;
    let pair = [Key::Robot(3), Key::Landmark(objects[0]), Key::Robot(29)];
    let joint = best.estimator().joint(&pair).unwrap();
    let difference = DVector::from_fn(3, |i, _| {
        let own = joint.covariance(pair[i]).unwrap();
        (own[(0, 0)] - covariance[(at(pair[i]), at(pair[i]))]).abs() + own[(0, 1)].abs()
    });
    assert!(difference.max() < 1e-12, "{difference}");
}
