//! Probabilities of associations against GTSAM's `DiscreteMarginals`: `slam/benches/discrete_marginals.py` wrote what is compared with.

use crate::linear_world::{Sum, zero};
use nalgebra::Vector2;
use vantage_slam::Key;
use vantage_slam::association::{
    Addition, Alternative, Choice, Frame, Hypotheses, Limits, SharedSmoother, Thresholds,
};

const WORLDS: &str = include_str!("discrete_marginals.txt");
const MOTION: f64 = 0.3;
const DETECTION: f64 = 0.2;
const SPREAD: f64 = 1.0;
const START: f64 = 0.1;
const FALSE: f64 = 0.05;
const LANDMARKS: usize = 2;

/// Motions each with what is seen after it, and the probabilities of both landmarks and of nothing for each sighting.
#[derive(Default)]
struct World {
    steps: Vec<(Vector2<f64>, Vec<Vector2<f64>>)>,
    marginals: Vec<Vec<f64>>,
}

fn worlds() -> Vec<World> {
    let mut worlds = Vec::new();
    for line in WORLDS.lines() {
        let (what, numbers) = line.split_once(' ').unwrap_or((line, ""));
        let numbers: Vec<f64> = numbers.split_whitespace().map(|number| number.parse().unwrap()).collect();
        if what == "world" {
            worlds.push(World::default());
        }
        let world = worlds.last_mut().unwrap();
        match what {
            "motion" => world.steps.push((Vector2::from_column_slice(&numbers), Vec::new())),
            "seen" => world.steps.last_mut().unwrap().1.push(Vector2::from_column_slice(&numbers)),
            "marginal" => world.marginals.push(numbers),
            _ => {}
        }
    }
    worlds
}

/// What is there before anything is seen.
fn start() -> Addition<'static> {
    let prior = |key, measured, deviation| Sum { keys: vec![key], signs: vec![1.0], measured, deviation };
    let landmarks = (0..LANDMARKS).map(|i| (Key::Landmark(i), Vector2::new(1.0 - 2.0 * i as f64, 0.5)));
    landmarks.fold(
        Addition::default().with_variable(Key::Robot(0), zero()).with(prior(
            Key::Robot(0),
            Vector2::zeros(),
            START,
        )),
        |addition, (key, place)| addition.with_variable(key, zero()).with(prior(key, place, SPREAD)),
    )
}

fn frame(step: usize, number: usize, seen: Vector2<f64>) -> Frame<'static> {
    let of_landmark = |landmark: usize| {
        let keys = vec![Key::Robot(step), Key::Landmark(landmark)];
        let sighting = Sum { keys, signs: vec![-1.0, 1.0], measured: seen, deviation: DETECTION };
        let log_weight = sighting.log_normalizer();
        Alternative {
            label: landmark,
            addition: Addition::default().with(sighting),
            log_weight,
            claims: None,
        }
    };
    let nothing = Alternative {
        label: LANDMARKS,
        addition: Addition::default(),
        log_weight: libm::log(FALSE),
        claims: None,
    };
    let alternatives = (0..LANDMARKS).map(of_landmark).chain([nothing]).collect();
    Frame { choices: vec![Choice { number, alternatives }], log_weight: 0.0 }
}

#[test]
fn probabilities_are_those_of_another_library() {
    let thresholds = Thresholds { relinearization: 0.1, propagation: 0.0, rounds: 10 };
    let worlds = worlds();
    assert_eq!(worlds.len(), 3);
    for world in worlds {
        let mut hypotheses = Hypotheses::new(SharedSmoother::new(thresholds), Limits::exact());
        let mut number = 0;
        for (step, (motion, seen)) in world.steps.iter().enumerate() {
            let addition = if step == 0 {
                start()
            } else {
                let keys = vec![Key::Robot(step - 1), Key::Robot(step)];
                let moved = Sum { keys, signs: vec![-1.0, 1.0], measured: *motion, deviation: MOTION };
                Addition::default().with_variable(Key::Robot(step), zero()).with(moved)
            };
            hypotheses.observe(|_| addition.clone()).unwrap();
            for &place in seen {
                hypotheses.choose(|_| frame(step, number, place)).unwrap();
                number += 1;
            }
        }
        hypotheses.settle().unwrap();
        assert_eq!((hypotheses.all().len(), number), (3_usize.pow(6), world.marginals.len()));
        for (choice, marginal) in world.marginals.iter().enumerate() {
            for (label, expected) in marginal.iter().enumerate() {
                let got = hypotheses.probability(choice, label);
                assert!(
                    (got - expected).abs() < 1e-9,
                    "choice {choice}, label {label}: {got} for {expected}"
                );
            }
        }
    }
}
