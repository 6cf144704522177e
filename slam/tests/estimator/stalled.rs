//! A promise that no step keeps is told.

use nalgebra::{DMatrix, DVector};
use vantage_slam::factor::{Factor, LinearFactor};
use vantage_slam::graph::Graph;
use vantage_slam::solve::{Limits, solve};
use vantage_slam::variable::{Value, Values};
use vantage_slam::{Key, Outcome};

/// A residual that moves in stairs of a given height, with the derivative of a ramp.
struct Stairs {
    height: f64,
}

impl Stairs {
    fn at(&self, values: &Values) -> Option<DVector<f64>> {
        Some(values.vector(Key::Latent(0))?.map(|x| 0.25 + self.height * (x / self.height).round()))
    }
}

impl Factor for Stairs {
    fn keys(&self) -> &[Key] {
        &[Key::Latent(0)]
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        self.at(values)
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        Some(LinearFactor { residual: self.at(values)?, jacobians: vec![DMatrix::identity(1, 1)] })
    }
}

#[test]
fn steps_that_never_lower_the_cost_are_a_stall_and_small_ones_are_not() {
    for (height, expected) in [(1.0, Outcome::Stalled), (1e-9, Outcome::Converged)] {
        let mut graph = Graph::default();
        graph.push(Stairs { height });
        let mut start = Values::default();
        start.insert(Key::Latent(0), Value::Vector(DVector::zeros(1)));
        let solution = solve(&graph, start, |_| true, Limits { iterations: 50, tolerance: 1e-6 });
        assert_eq!(solution.outcome, expected, "stairs of {height}");
    }
}
