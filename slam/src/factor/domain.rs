//! The semantic measurement of Eq. 9-10 in a domain that is a variable: Eq. 25-26.

use super::{Factor, LinearFactor, SemanticFactor, finite};
use crate::domain::Domain;
use crate::noise::Kernel;
use crate::variable::{Key, Values};
use nalgebra::DVector;

/// [`SemanticFactor`], its prediction [changed](Domain::changed) as all of the episode's are.
#[derive(Clone)]
pub struct DomainFactor<'m> {
    keys: [Key; 4],
    of: SemanticFactor<'m>,
    domain: &'m Domain,
}

impl<'m> DomainFactor<'m> {
    /// Joins what `of` does, and the domain.
    pub fn new(of: SemanticFactor<'m>, domain: &'m Domain) -> Self {
        let [robot, object, latent] = *of.joined();
        Self { keys: [robot, object, latent, Key::Domain], of, domain }
    }

    fn numbers<'v>(&self, values: &'v Values) -> Option<&'v DVector<f64>> {
        values.vector(Key::Domain).filter(|u| u.len() == self.domain.dim())
    }
}

impl Factor for DomainFactor<'_> {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn residual(&self, values: &Values) -> Option<DVector<f64>> {
        let (measured, predicted) = (self.of.measurement(), self.of.predicted(values)?);
        let changed = self.domain.changed(self.numbers(values)?, &predicted);
        finite(self.of.whitening() * (measured - changed))
    }

    fn linearize(&self, values: &Values) -> Option<LinearFactor> {
        let u = self.numbers(values)?;
        let (near, view) = self.of.near(values)?;
        let whiten = self.of.whitening();
        let by_prediction = &whiten * self.domain.by_prediction(u);
        let [d_robot, d_object, d_latent] = self.of.jacobians(&by_prediction, &near, &view)?;
        let changed = self.domain.changed(u, &near.mean);
        LinearFactor {
            residual: &whiten * (self.of.measurement() - changed),
            jacobians: vec![d_robot, d_object, d_latent, -(whiten * self.domain.by_numbers(&near.mean))],
        }
        .finite()
    }

    fn kernel(&self) -> Kernel {
        self.of.kernel()
    }

    fn information_scale(&self) -> f64 {
        self.of.information_scale()
    }
}
