//! P(X, O, E, u | U, Z^g, Z^s): semantic, in a domain `u` that is learnt beside it (Eq. 25-26), from one drive on to the next.

use super::{Estimator, Learner, Learnt, Semantic, gain_a_crop};
use crate::domain::DomainPrior;
use crate::estimate::Estimate;
use crate::input::EstimateError;
use crate::lesson::Lesson;
use crate::settings::Settings;
use vantage_dataset::Observations;
use vantage_model::ObservationModel;

/// [`Semantic`] in a domain that it learns.
pub struct DomainAdapted<'m> {
    settings: Settings,
    model: &'m dyn ObservationModel,
}

impl<'m> DomainAdapted<'m> {
    /// An estimator that reads crops by `model`, under the settings' [`DomainPrior`].
    pub fn new(settings: &Settings, model: &'m dyn ObservationModel) -> Self {
        Self { settings: *settings, model }
    }

    fn prior(&self) -> &DomainPrior {
        &self.settings.domain
    }
}

impl Estimator for DomainAdapted<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        Semantic::new(&self.settings, self.model).in_domain(self.prior()).estimate(observations)
    }
}

/// Where the solver does not come to a maximum, the drive teaches nothing.
impl Learner for DomainAdapted<'_> {
    fn learn(&self, observations: &Observations, before: &Lesson) -> Result<Learnt, EstimateError> {
        let belief = before.domain.as_ref().map(|belief| belief.of_next_drive());
        let semantic = Semantic::new(&self.settings, self.model).in_domain(self.prior());
        let semantic = match belief.clone() {
            Some(belief) => semantic.believing(belief),
            None => semantic,
        };
        let (estimate, evidence, learnt) = semantic.taught(observations)?;
        let frozen = Semantic::new(&self.settings, self.model).evidenced(observations)?;
        let gain = gain_a_crop((&estimate, evidence), (&frozen.0, frozen.1));
        Ok(Learnt { estimate, lesson: Lesson { domain: learnt.or(belief), ..before.clone() }, gain })
    }
}
