//! A plane without headings: everything is linear and Gaussian, so evidence is exact.

use nalgebra::{DMatrix, DVector, Vector2};
use std::f64::consts::PI;
use vantage_slam::Key;
use vantage_slam::association::{
    Addition, Alternative, Choice, Frame, Hypothesis, LocalEstimator, SharedSmoother,
};
use vantage_slam::factor::{Factor, LinearFactor};
use vantage_slam::variable::{Value, Values};

/// `(sum of signed variables - measured) / deviation`.
#[derive(Clone)]
pub struct Sum {
    pub keys: Vec<Key>,
    pub signs: Vec<f64>,
    pub measured: Vector2<f64>,
    pub deviation: f64,
}

impl Factor for Sum {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let mut residual = DVector::from_column_slice((-self.measured).as_slice());
        for (key, sign) in self.keys.iter().zip(&self.signs) {
            residual += values.vector(*key)? * *sign;
        }
        Some(residual / self.deviation)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let jacobian = |sign: &f64| DMatrix::identity(2, 2) * (sign / self.deviation);
        Some(LinearFactor {
            residual: self.residual(values)?,
            jacobians: self.signs.iter().map(jacobian).collect(),
        })
    }
}

impl Sum {
    /// `log` of what makes `exp(-cost)` a density of what was measured.
    pub fn log_normalizer(&self) -> f64 {
        -libm::log(2.0 * PI * self.deviation * self.deviation)
    }
}

/// Densities and deviations of a world.
#[derive(Clone, Copy)]
pub struct Model {
    pub motion: f64,
    pub detection_deviation: f64,
    /// Of the places of objects about the origin.
    pub spread: f64,
    pub detection: f64,
    pub birth: f64,
    pub clutter: f64,
}

pub const MODEL: Model =
    Model { motion: 0.3, detection_deviation: 0.2, spread: 3.0, detection: 0.8, birth: 0.5, clutter: 0.02 };

pub const CLUTTER: usize = usize::MAX;

pub fn zero() -> Value {
    Value::Vector(DVector::zeros(2))
}

impl Model {
    pub fn start(&self) -> Addition<'static> {
        let prior =
            Sum { keys: vec![Key::Robot(0)], signs: vec![1.0], measured: Vector2::zeros(), deviation: 0.1 };
        Addition::default().with_variable(Key::Robot(0), zero()).with(prior)
    }

    pub fn step(&self, step: usize, motion: Vector2<f64>) -> Addition<'static> {
        Addition::default().with_variable(Key::Robot(step), zero()).with(self.motion_factor(step, motion))
    }

    pub fn motion_factor(&self, step: usize, motion: Vector2<f64>) -> Sum {
        let keys = vec![Key::Robot(step - 1), Key::Robot(step)];
        Sum { keys, signs: vec![-1.0, 1.0], measured: motion, deviation: self.motion }
    }

    pub fn sighting(&self, step: usize, object: usize, seen: Vector2<f64>) -> Sum {
        let keys = vec![Key::Robot(step), Key::Landmark(object)];
        Sum { keys, signs: vec![-1.0, 1.0], measured: seen, deviation: self.detection_deviation }
    }

    pub fn prior(&self, object: usize) -> Sum {
        Sum {
            keys: vec![Key::Landmark(object)],
            signs: vec![1.0],
            measured: Vector2::zeros(),
            deviation: self.spread,
        }
    }

    /// Each detection, numbered from `first`, is of an object seen before, of a new one named by its own number, or clutter.
    pub fn frame(
        &self,
        hypothesis: &Hypothesis<SharedSmoother<'static>>,
        step: usize,
        first: usize,
        seen: &[Vector2<f64>],
    ) -> Frame<'static> {
        let known: Vec<usize> = (hypothesis.verdicts().iter())
            .filter(|verdict| verdict.choice == verdict.label)
            .map(|verdict| verdict.label)
            .collect();
        let log_missed = libm::log(1.0 - self.detection);
        let choices = seen.iter().zip(first..).map(|(place, number)| {
            let of = |object: usize| self.sighting(step, object, *place);
            let mut alternatives: Vec<Alternative<'static>> = (known.iter())
                .map(|&object| Alternative {
                    label: object,
                    addition: Addition::default().with(of(object)),
                    log_weight: of(object).log_normalizer() + libm::log(self.detection) - log_missed,
                    claims: Some(object),
                })
                .collect();
            let prior = self.prior(number);
            alternatives.push(Alternative {
                label: number,
                log_weight: of(number).log_normalizer() + prior.log_normalizer() + libm::log(self.birth),
                addition: Addition::default()
                    .with(of(number))
                    .with(prior)
                    .with_variable(Key::Landmark(number), zero()),
                claims: None,
            });
            alternatives.push(Alternative {
                label: CLUTTER,
                addition: Addition::default(),
                log_weight: libm::log(self.clutter),
                claims: None,
            });
            Choice { number, alternatives }
        });
        Frame { choices: choices.collect(), log_weight: known.len() as f64 * log_missed }
    }
}

/// Values of all variables of an estimate.
pub fn values(estimator: &SharedSmoother<'_>) -> Vec<(Key, Vec<f64>)> {
    let numbers = |(key, value): (Key, &Value)| match value {
        Value::Vector(v) => (key, v.as_slice().to_vec()),
        _ => (key, vec![]),
    };
    let mut all: Vec<_> = estimator.values().map(numbers).collect();
    all.sort_by_key(|(key, _)| *key);
    assert!(all.iter().all(|(key, _)| estimator.value(*key).is_some()));
    all
}
