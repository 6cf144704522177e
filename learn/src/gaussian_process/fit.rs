//! Hyper-parameters of most marginal likelihood.

use super::hyperparameters::Hyperparameters;
use super::reduced::{COMPONENTS, measurement};
use crate::periodic_fit::{Measured, fit};
use nalgebra::DMatrix;
use vantage_dataset::Crop;

impl Hyperparameters {
    /// The best of a grid for `objects`, each the crops of one object and the azimuths that they were seen from, and their
    /// log marginal likelihood under Gaussian noise, nats. Each component has deviations of its own, all share the kernel; black crops are left out.
    pub fn fit(objects: &[Vec<(&Crop, f64)>]) -> (Self, f64) {
        let objects: Vec<Measured> = objects.iter().map(|views| measured(views)).collect();
        let found = fit(&objects, COMPONENTS);
        let fitted = Self {
            kappa: found.kappa,
            signal: std::array::from_fn(|j| found.signal[j]),
            noise: std::array::from_fn(|j| found.noise[j]),
            degrees_of_freedom: f64::INFINITY,
        };
        (fitted, found.log_likelihood)
    }
}

fn measured(views: &[(&Crop, f64)]) -> Measured {
    let usable: Vec<_> =
        views.iter().filter_map(|&(crop, azimuth)| Some((measurement(crop)?, azimuth))).collect();
    let numbers = DMatrix::from_fn(usable.len(), COMPONENTS, |i, j| usable[i].0[j]);
    (usable.into_iter().map(|(_, azimuth)| azimuth).collect(), numbers)
}
