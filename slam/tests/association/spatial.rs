//! The same engine over poses in space and factors that were there before it.

use nalgebra::{Matrix6, Vector6};
use std::f64::consts::TAU;
use vantage_dataset::{Pose, Seed, Tangent, se3};
use vantage_slam::Key;
use vantage_slam::association::{
    Addition, Alternative, Choice, Frame, Hypotheses, Limits, LocalEstimator, SharedSmoother, Thresholds,
};
use vantage_slam::factor::{BetweenFactor, PosePrior};
use vantage_slam::graph::Graph;
use vantage_slam::laplace::{log_evidence, log_evidence_of_all};
use vantage_slam::solve::{Limits as SolveLimits, solve};
use vantage_slam::variable::{Value, Values};

const POSES: usize = 40;

/// Motions of a ring that climbs, with noise of odometry.
fn motions() -> Vec<Pose> {
    let mut stream = Seed(11).stream("ring", 0);
    let motion = Pose::translation(0.5, 0.0, 0.02) * Pose::rotation(nalgebra::Vector3::z() * (TAU / 20.0));
    let mut noisy =
        || motion * se3::exp(&Tangent::from_fn(|i, _| stream.normal() * if i < 3 { 0.02 } else { 0.05 }));
    (1..POSES).map(|_| noisy()).collect()
}

fn information() -> Matrix6<f64> {
    Matrix6::from_diagonal(&Vector6::new(50.0, 50.0, 50.0, 20.0, 20.0, 20.0))
}

fn prior() -> PosePrior {
    PosePrior::new(Key::Robot(0), Pose::identity(), Matrix6::identity() * 1e3)
}

fn between(from: usize, to: usize, measured: Pose) -> BetweenFactor {
    BetweenFactor::new(Key::Robot(from), Key::Robot(to), measured, information())
}

/// Where a lap leads.
fn lap() -> Pose {
    Pose::translation(0.1, -0.2, 0.4)
}

fn grown(thresholds: Thresholds, limits: Limits) -> Hypotheses<SharedSmoother<'static>> {
    let mut hypotheses = Hypotheses::new(SharedSmoother::new(thresholds), limits);
    let first = Addition::default().with_variable(Key::Robot(0), Value::Pose(Pose::identity())).with(prior());
    hypotheses.observe(|_| first.clone()).unwrap();
    for (step, motion) in motions().into_iter().enumerate() {
        hypotheses
            .observe(|hypothesis| {
                let Some(Value::Pose(pose)) = hypothesis.estimator().value(Key::Robot(step)) else {
                    panic!("no pose")
                };
                let next = Value::Pose(pose * motion);
                Addition::default().with_variable(Key::Robot(step + 1), next).with(between(
                    step,
                    step + 1,
                    motion,
                ))
            })
            .unwrap();
        // A loop to the lap before, or to nowhere.
        if let Some(other) = (step + 1).checked_sub(20) {
            let alternatives = vec![
                Alternative {
                    label: 0,
                    addition: Addition::default().with(between(other, step + 1, lap())),
                    log_weight: 30.0,
                    claims: None,
                },
                Alternative { label: 1, addition: Addition::default(), log_weight: 0.0, claims: None },
            ];
            let choice = Choice { number: step, alternatives };
            hypotheses.choose(|_| Frame { choices: vec![choice.clone()], log_weight: 0.0 }).unwrap();
        }
    }
    hypotheses
}

#[test]
fn poses_in_space_reach_the_maximum_and_its_evidence() {
    let limits = Limits { hypotheses: 1, least_weight: 0.0, merging: None };
    let thresholds = Thresholds { relinearization: 1e-9, propagation: 0.0, rounds: 20 };
    let mut hypotheses = grown(thresholds, limits);
    hypotheses.settle().unwrap();
    let best = hypotheses.best().unwrap();
    let loops = best.verdicts().iter().filter(|verdict| verdict.label == 0).count();
    assert!(loops > 10, "{loops}");

    let (mut graph, mut start) = (Graph::default(), Values::default());
    graph.push(prior());
    let mut pose = Pose::identity();
    start.insert(Key::Robot(0), Value::Pose(pose));
    for (step, motion) in motions().into_iter().enumerate() {
        pose *= motion;
        start.insert(Key::Robot(step + 1), Value::Pose(pose));
        graph.push(between(step, step + 1, motion));
    }
    for verdict in best.verdicts().iter().filter(|verdict| verdict.label == 0) {
        graph.push(between(verdict.choice + 1 - 20, verdict.choice + 1, lap()));
    }
    let solution = solve(&graph, start, |_| true, SolveLimits { iterations: 100, tolerance: 1e-14 });
    let keys: Vec<Key> = (0..POSES).map(Key::Robot).collect();
    for key in &keys {
        let Some(Value::Pose(pose)) = best.estimator().value(*key) else { panic!("{key} is no pose") };
        let off = se3::log(&pose.inv_mul(solution.values.pose(*key).unwrap())).norm();
        assert!(off < 1e-5, "{key}: {off}");
    }
    let expected = log_evidence(&graph, &solution.values, &keys).unwrap();
    let sparse = log_evidence_of_all(&graph, &solution.values).unwrap();
    assert!((sparse - expected).abs() < 1e-8, "{sparse} for {expected}");
    let got = best.estimator().log_evidence();
    assert!((got - expected).abs() < 1e-4, "{got} for {expected}");
}

#[test]
fn what_is_linearised_late_is_found_by_solving_anew() {
    let limits = Limits { hypotheses: 4, least_weight: 1e-4, merging: None };
    let lazy = Thresholds { relinearization: 0.5, propagation: 1e-2, rounds: 3 };
    let exact = Thresholds { relinearization: 1e-9, propagation: 0.0, rounds: 20 };
    let (mut lazy, mut exact) = (grown(lazy, limits), grown(exact, limits));
    lazy.refine().unwrap();
    exact.settle().unwrap();
    let (a, b) = (lazy.best().unwrap(), exact.best().unwrap());
    assert_eq!(a.verdicts(), b.verdicts());
    assert!((a.estimator().log_evidence() - b.estimator().log_evidence()).abs() < 1e-3);
}
