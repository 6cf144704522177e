//! Errors of one kind, of steps or of objects, against their covariances.

use super::super::calibration::REGIONS;
use super::Normalized;
use crate::result::distribution::chi_squared_cdf;

/// NEES and negative log-likelihoods of errors of the same numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NormalizedErrors {
    degrees: usize,
    /// NEES over the error's numbers.
    pub nees: Vec<f64>,
    /// `-log N(e; 0, S)`, nats.
    pub surprise: Vec<f64>,
}

impl NormalizedErrors {
    /// Of errors of `degrees` numbers.
    pub(super) fn of(degrees: usize) -> Self {
        Self { degrees, ..Self::default() }
    }

    pub(super) fn push(&mut self, error: Normalized) {
        self.nees.push(error.per_number);
        self.surprise.push(error.surprise);
    }

    /// The mean NEES over the numbers; `None` of none.
    pub fn mean_nees(&self) -> Option<f64> {
        mean(&self.nees)
    }

    /// The mean negative log-likelihood, nats; `None` of none.
    pub fn mean_surprise(&self) -> Option<f64> {
        mean(&self.surprise)
    }

    /// The shares inside the regions that should hold [`REGIONS`]; `None` of none.
    pub fn inside(&self) -> [Option<f64>; 3] {
        let degrees = self.degrees as f64;
        let is_inside = |nees: f64, region| chi_squared_cdf(nees * degrees, degrees) <= region;
        REGIONS.map(|region| {
            let inside = self.nees.iter().filter(|&&nees| is_inside(nees, region)).count();
            (!self.nees.is_empty()).then(|| inside as f64 / self.nees.len() as f64)
        })
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
