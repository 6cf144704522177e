//! How large residuals of objects are, and how fast they change with the azimuth.

use crate::periodic_fit::{Measured, fit};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use vantage_model::ObservationModel;

/// Concentration of a process that is not fitted: between 12 and 6, which are fitted on validation views of families that
/// `models/objects` knows, and of composites.
const KAPPA: f64 = 8.0;

/// What [`ResidualHyperparameters::fit`] fits by marginal likelihood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualHyperparameters {
    /// Concentration of the kernel over the azimuth; about one over its squared length in radians.
    pub kappa: f64,
    /// Standard deviation of each whitened number over objects and azimuths.
    pub signal: Vec<f64>,
    /// Standard deviation of each whitened number's noise.
    pub noise: Vec<f64>,
    /// Of the noise.
    pub degrees_of_freedom: f64,
}

impl ResidualHyperparameters {
    /// Not fitted: corrections of `size` standard deviations of the model's noise, in every direction alike, beside that noise.
    pub fn of_size(size: f64, model: &dyn ObservationModel) -> Self {
        let components = model.measurement_dim();
        let degrees_of_freedom = model.noise().degrees_of_freedom();
        Self {
            kappa: KAPPA,
            signal: vec![size; components],
            noise: vec![1.0; components],
            degrees_of_freedom,
        }
    }

    /// The best of a grid for `objects`, each the azimuths, radians, and whitened residuals of the views of one object.
    /// Degrees of freedom are the model's: those of the process are not fitted. `None` without a residual.
    pub fn fit(objects: &[Vec<(f64, DVector<f64>)>], degrees_of_freedom: f64) -> Option<Self> {
        let components = objects.iter().flatten().next()?.1.len();
        let measured: Vec<Measured> = objects
            .iter()
            .map(|views| {
                let residuals = DMatrix::from_fn(views.len(), components, |i, j| views[i].1[j]);
                (views.iter().map(|(azimuth, _)| *azimuth).collect(), residuals)
            })
            .collect();
        let found = fit(&measured, components);
        Some(Self { kappa: found.kappa, signal: found.signal, noise: found.noise, degrees_of_freedom })
    }
}
