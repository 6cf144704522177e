//! The factors of the posterior: whitened residuals with exact Jacobians.

pub mod azimuth;
pub mod bearing;
pub mod between;
pub mod biased_between;
pub mod box_edges;
pub mod class;
pub mod depth;
pub mod domain;
pub mod offset_bearing;
pub mod pair;
pub mod prior;
pub mod projection;
pub mod semantic;
pub mod upright;
mod view;

use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::{DMatrix, DVector, Matrix6, Vector6};

pub use azimuth::AzimuthFactor;
pub use bearing::BearingFactor;
pub use between::BetweenFactor;
pub use biased_between::BiasedBetweenFactor;
pub use box_edges::BoxEdgesFactor;
pub use class::ClassFactor;
pub use depth::DepthFactor;
pub use domain::DomainFactor;
pub use offset_bearing::OffsetBearingFactor;
pub use pair::PairFactor;
pub use prior::{ExtentsPrior, GaussianPrior, PosePrior, StandardNormalPrior};
pub use projection::ProjectionFactor;
pub use semantic::SemanticFactor;
pub use upright::UprightFactor;

/// One term of the negative log-posterior: `information_scale * kernel(|residual|^2)`.
pub trait Factor {
    /// The variables it joins.
    fn keys(&self) -> &[Key];

    /// The whitened residual, or `None` where it is undefined or not finite.
    fn residual(&self, values: &Values) -> Option<DVector<f64>>;

    /// The whitened residual and its derivatives, or `None` where either is undefined or not finite.
    fn linearize(&self, values: &Values) -> Option<LinearFactor>;

    /// The kernel over the squared norm of the whole residual.
    fn kernel(&self) -> Kernel {
        Kernel::Gaussian
    }

    /// What multiplies the cost.
    fn information_scale(&self) -> f64 {
        1.0
    }

    /// Whether it fixes a variable in the world.
    fn is_anchor(&self) -> bool {
        false
    }

    /// Its share of the negative log-posterior, nats.
    fn cost(&self, values: &Values) -> Option<f64> {
        let residual = self.residual(values)?;
        let cost = self.information_scale() * self.kernel().loss(residual.norm_squared(), residual.len());
        cost.is_finite().then_some(cost)
    }
}

/// A factor near a point.
#[derive(Clone, Debug)]
pub struct LinearFactor {
    /// Whitened residual, `[n]`.
    pub residual: DVector<f64>,
    /// For each key, the derivative to a right perturbation of its variable, `[n x dim]`.
    pub jacobians: Vec<DMatrix<f64>>,
}

impl LinearFactor {
    fn finite(self) -> Option<Self> {
        let finite = self.residual.iter().all(|x| x.is_finite())
            && self.jacobians.iter().all(|j| j.iter().all(|x| x.is_finite()));
        finite.then_some(self)
    }
}

fn finite(residual: DVector<f64>) -> Option<DVector<f64>> {
    residual.iter().all(|x| x.is_finite()).then_some(residual)
}

fn dynamic_vector(v: &Vector6<f64>) -> DVector<f64> {
    DVector::from_column_slice(v.as_slice())
}

fn dynamic_matrix(m: &Matrix6<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(6, 6, m.as_slice())
}
