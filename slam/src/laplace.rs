//! The evidence of variables near a maximum, by Laplace's method.

use crate::graph::Graph;
use crate::linear::{Memory, Reduced, Structure};
use crate::variable::{Key, Values};
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// `log` of the integral of `exp(-cost)` over the tangents of the variables `free` about `values`, which should be a maximum over them.
/// The Hessian is that of Gauss and Newton, dense: for a few variables. `None` where a factor is undefined or the Hessian not positive definite.
pub fn log_evidence(graph: &Graph<'_>, values: &Values, free: &[Key]) -> Option<f64> {
    let mut first = Vec::with_capacity(free.len());
    let mut dim = 0;
    for &key in free {
        first.push(dim);
        dim += values.get(key)?.dim();
    }
    let mut hessian = DMatrix::zeros(dim, dim);
    for factor in graph.factors() {
        let joined: Vec<(usize, usize)> = (factor.keys().iter().enumerate())
            .filter_map(|(i, key)| Some((i, first[free.iter().position(|other| other == key)?])))
            .collect();
        if joined.is_empty() {
            continue;
        }
        let linear = factor.linearize(values)?;
        let s = linear.residual.norm_squared();
        let weight = factor.information_scale() * factor.kernel().weight(s, linear.residual.len());
        for &(i, row) in &joined {
            for &(j, column) in &joined {
                let (a, b) = (&linear.jacobians[i], &linear.jacobians[j]);
                hessian.view_mut((row, column), (a.ncols(), b.ncols())).gemm_tr(weight, a, b, 1.0);
            }
        }
    }
    let root = hessian.cholesky()?;
    let half_log_det: f64 = root.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum();
    let evidence = dim as f64 / 2.0 * libm::log(2.0 * PI) - graph.cost(values)? - half_log_det;
    evidence.is_finite().then_some(evidence)
}

/// [`log_evidence`] of all variables, sparse.
pub fn log_evidence_of_all(graph: &Graph<'_>, values: &Values) -> Option<f64> {
    let structure = Structure::new(graph, values, |_| true)?;
    let system = structure.linearize(graph, values)?;
    let mut memory = Memory::default();
    let half_log_det = Reduced::new(&system, 0.0, &mut memory)?.half_log_det(&mut memory)?;
    let dim: usize = values.iter().map(|(_, value)| value.dim()).sum();
    let evidence = dim as f64 / 2.0 * libm::log(2.0 * PI) - graph.cost(values)? - half_log_det;
    evidence.is_finite().then_some(evidence)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::StandardNormalPrior;
    use crate::variable::Value;
    use approx::assert_relative_eq;
    use nalgebra::DVector;

    #[test]
    fn a_gaussian_integrates_to_its_normaliser_and_what_is_held_is_not_integrated() {
        let mut graph = Graph::default();
        for track in 0..2 {
            graph.push(StandardNormalPrior::new(Key::Latent(track)));
        }
        let mut values = Values::default();
        values.insert(Key::Latent(0), Value::Vector(DVector::zeros(3)));
        values.insert(Key::Latent(1), Value::Vector(DVector::from_element(2, 0.5)));
        let evidence = log_evidence(&graph, &values, &[Key::Latent(0)]).unwrap();
        assert_relative_eq!(evidence, 1.5 * libm::log(2.0 * PI) - 0.25, max_relative = 1e-14);
        assert_eq!(log_evidence(&graph, &values, &[Key::Latent(2)]), None);
        let all = log_evidence(&graph, &values, &[Key::Latent(0), Key::Latent(1)]).unwrap();
        assert_relative_eq!(log_evidence_of_all(&graph, &values).unwrap(), all, max_relative = 1e-14);
    }
}
