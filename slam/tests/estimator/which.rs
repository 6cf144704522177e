//! The estimators under test, by name.

use vantage_dataset::Observations;
use vantage_model::ObservationModel;
use vantage_slam::{
    Estimate, EstimateError, Estimator, Geometric, OdometryOnly, Semantic, Settings, Uninformative,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    Odometry,
    Geometric,
    Semantic,
    Uninformative,
}

impl Which {
    pub const ALL: [Which; 4] = [Which::Odometry, Which::Geometric, Which::Semantic, Which::Uninformative];
}

/// The answer of one of them; the last two need a model.
pub fn estimate(
    observations: &Observations,
    which: Which,
    model: Option<&dyn ObservationModel>,
    settings: &Settings,
) -> Result<Estimate, EstimateError> {
    let estimator: Box<dyn Estimator + '_> = match which {
        Which::Odometry => Box::new(OdometryOnly::new(settings)),
        Which::Geometric => Box::new(Geometric::new(settings)),
        Which::Semantic => Box::new(Semantic::new(settings, model.unwrap())),
        Which::Uninformative => Box::new(Uninformative::new(settings, model.unwrap())),
    };
    estimator.estimate(observations)
}
