//! Priors: on a pose (the gauge), P(e) = N(0, I) on a latent, one on an object's extents, and what earlier drives taught of a domain.

use super::{Factor, LinearFactor, dynamic_matrix, dynamic_vector, finite};
use crate::lesson::DomainBelief;
use crate::se3_jacobian::right_jacobian_inverse;
use crate::variable::{Key, Values};
use nalgebra::{DMatrix, DVector, Matrix6};
use vantage_dataset::{Pose, se3};

/// `W Log(mean^-1 * x)`.
#[derive(Clone, Debug)]
pub struct PosePrior {
    keys: [Key; 1],
    mean: Pose,
    sqrt_information: Matrix6<f64>,
}

impl PosePrior {
    /// A prior with the information of the mean's right perturbation.
    pub fn new(key: Key, mean: Pose, sqrt_information: Matrix6<f64>) -> Self {
        Self { keys: [key], mean, sqrt_information }
    }
}

impl Factor for PosePrior {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let error = se3::log(&self.mean.inv_mul(values.pose(self.keys[0])?));
        finite(dynamic_vector(&(self.sqrt_information * error)))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let error = se3::log(&self.mean.inv_mul(values.pose(self.keys[0])?));
        LinearFactor {
            residual: dynamic_vector(&(self.sqrt_information * error)),
            jacobians: vec![dynamic_matrix(&(self.sqrt_information * right_jacobian_inverse(&error)))],
        }
        .finite()
    }

    fn is_anchor(&self) -> bool {
        true
    }
}

/// P(e) = N(0, I): the residual is `e` itself.
#[derive(Clone, Debug)]
pub struct StandardNormalPrior {
    keys: [Key; 1],
}

impl StandardNormalPrior {
    /// The prior of one latent.
    pub fn new(key: Key) -> Self {
        Self { keys: [key] }
    }
}

impl Factor for StandardNormalPrior {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        finite(values.vector(self.keys[0])?.clone())
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let e = values.vector(self.keys[0])?.clone();
        let identity = DMatrix::identity(e.len(), e.len());
        LinearFactor { residual: e, jacobians: vec![identity] }.finite()
    }
}

/// `L^-1 (u - mean)`, of a covariance `L L^T`.
#[derive(Clone, Debug)]
pub struct GaussianPrior {
    keys: [Key; 1],
    mean: DVector<f64>,
    sqrt_information: DMatrix<f64>,
}

impl GaussianPrior {
    /// The prior of numbers that are believed to be so; `None` where the covariance is not positive definite.
    pub fn new(key: Key, belief: &DomainBelief) -> Option<Self> {
        let DomainBelief { mean, covariance } = belief;
        let root = covariance.clone().cholesky()?.unpack();
        let identity = DMatrix::identity(mean.len(), mean.len());
        let sqrt_information = root.solve_lower_triangular(&identity)?;
        Some(Self { keys: [key], mean: mean.clone(), sqrt_information })
    }

    /// `log det L^-1`.
    pub fn log_det_sqrt_information(&self) -> f64 {
        self.sqrt_information.diagonal().iter().map(|x| libm::log(*x)).sum()
    }

    /// Its mean.
    pub fn mean(&self) -> &DVector<f64> {
        &self.mean
    }
}

impl Factor for GaussianPrior {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let numbers = values.vector(self.keys[0]).filter(|numbers| numbers.len() == self.mean.len())?;
        finite(&self.sqrt_information * (numbers - &self.mean))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let residual = self.residual(values)?;
        LinearFactor { residual, jacobians: vec![self.sqrt_information.clone()] }.finite()
    }
}

/// Log-normal semi-axes: `(log a - log m) / s` of each.
#[derive(Clone, Debug)]
pub struct ExtentsPrior {
    keys: [Key; 1],
    log_median: f64,
    log_sigma: f64,
}

impl ExtentsPrior {
    /// The prior of logarithms of semi-axes whose median is `half_axis` metres, with the standard deviation `log_sigma`.
    pub fn new(key: Key, half_axis: f64, log_sigma: f64) -> Self {
        Self { keys: [key], log_median: libm::log(half_axis), log_sigma }
    }
}

impl Factor for ExtentsPrior {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let logs = values.vector(self.keys[0])?;
        finite(logs.map(|log| (log - self.log_median) / self.log_sigma))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let residual = self.residual(values)?;
        let n = residual.len();
        let jacobian = DMatrix::from_diagonal_element(n, n, 1.0 / self.log_sigma);
        LinearFactor { residual, jacobians: vec![jacobian] }.finite()
    }
}
