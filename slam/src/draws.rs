//! Draws from the Gaussian of a posterior about its maximum.
//!
//! ```text
//! delta = H^-1 J^T w,   w ~ N(0, I)   has the covariance H^-1 J^T J H^-1 = H^-1
//! ```

use crate::factor::{Factor, LinearFactor};
use crate::graph::Graph;
use crate::linear::{Memory, Structure};
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::DVector;
use vantage_dataset::Stream;

/// A factor with a draw of noise in place of its residual.
struct Drawn {
    keys: Vec<Key>,
    /// Its Jacobians are weighted.
    linear: LinearFactor,
}

impl Factor for Drawn {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, _: &Values) -> Option<DVector<f64>> {
        Some(self.linear.residual.clone())
    }

    fn linearize(&self, _: &Values) -> Option<LinearFactor> {
        Some(self.linear.clone())
    }

    fn kernel(&self) -> Kernel {
        Kernel::Gaussian
    }
}

/// As many draws; `None` where a factor is undefined at the maximum or the normal equations are singular.
pub fn draws(graph: &Graph<'_>, maximum: &Values, count: usize, random: &mut Stream) -> Option<Vec<Values>> {
    let mut linear = Vec::new();
    for factor in graph.factors() {
        let mut of_factor = factor.linearize(maximum)?;
        let s = of_factor.residual.norm_squared();
        let weight = factor.information_scale() * factor.kernel().weight(s, of_factor.residual.len());
        of_factor.jacobians.iter_mut().for_each(|jacobian| *jacobian *= weight.sqrt());
        linear.push((factor.keys().to_vec(), of_factor));
    }
    let mut memory = Memory::default();
    let mut draw = || {
        let mut drawn = Graph::default();
        for (keys, of_factor) in &linear {
            let residual = of_factor.residual.map(|_| random.normal());
            drawn.push(Drawn { keys: keys.clone(), linear: LinearFactor { residual, ..of_factor.clone() } });
        }
        let structure = Structure::new(&drawn, maximum, |_| true)?;
        let step = structure.linearize(&drawn, maximum)?.step(0.0, &mut memory)?;
        Some(structure.retract(maximum, &step))
    };
    (0..count).map(|_| draw()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::{GaussianPrior, StandardNormalPrior};
    use crate::lesson::DomainBelief;
    use crate::variable::Value;
    use nalgebra::DMatrix;
    use vantage_dataset::Seed;

    #[test]
    fn they_have_the_mean_and_the_covariance_of_the_gaussian() {
        let mean = DVector::from_vec(vec![1.0, -2.0]);
        let covariance = DMatrix::from_row_slice(2, 2, &[0.5, 0.3, 0.3, 0.4]);
        let mut graph = Graph::default();
        graph.push(
            GaussianPrior::new(
                Key::Domain,
                &DomainBelief { mean: mean.clone(), covariance: covariance.clone() },
            )
            .unwrap(),
        );
        graph.push(StandardNormalPrior::new(Key::Latent(0)));
        let mut maximum = Values::default();
        maximum.insert(Key::Domain, Value::Vector(mean.clone()));
        maximum.insert(Key::Latent(0), Value::Vector(DVector::zeros(1)));
        let count = 4000;
        let drawn = draws(&graph, &maximum, count, &mut Seed(0).stream("draws", 0)).unwrap();
        let (mut sum, mut squares) = (DVector::zeros(2), DMatrix::zeros(2, 2));
        for values in &drawn {
            let off = values.vector(Key::Domain).unwrap() - &mean;
            sum += &off;
            squares += &off * off.transpose();
        }
        let (sum, squares) = (sum / count as f64, squares / count as f64);
        assert!(sum.norm() < 0.04, "{sum}");
        assert!((squares - covariance).norm() < 0.05);
    }
}
