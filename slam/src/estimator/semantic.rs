//! P(X, O, E | U, Z^g, Z^s): geometric, with the semantic factors of an observation model.

mod added;
mod drawn;

use added::try_alternatives;
pub(super) use added::{Added, Start, add_semantics};
pub(super) use drawn::Drawn;
pub use drawn::SeenView;

use super::{Estimator, Geometric};
use crate::discrepancy::Discrepant;
use crate::domain::{Domain, DomainPrior};
use crate::estimate::Estimate;
use crate::factor::{GaussianPrior, StandardNormalPrior};
use crate::input::{EstimateError, check_model, check_settings};
use crate::laplace::log_evidence_of_all;
use crate::lesson::DomainBelief;
use crate::online::{Online, Reading};
use crate::orientation::modes;
use crate::posterior::Posterior;
use crate::semantics::{SemanticObject, Semantics};
use crate::settings::{OrientationSettings, SemanticSettings, Settings};
use crate::sighting::Sighting;
use crate::solve::Outcome;
use crate::unknown_object::{Geometry, log_odds};
use crate::variable::{Key, Value, Values};
use nalgebra::DVector;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use vantage_dataset::{Camera, Observations, Pose};
use vantage_model::{AnswerError, ObservationModel};

/// The geometric estimator's factors and those of Eq. 9-10, by one observation model.
pub struct Semantic<'m> {
    model: &'m dyn ObservationModel,
    discrepant: Option<Discrepant<'m, dyn ObservationModel + 'm>>,
    geometric: Geometric,
    semantics: SemanticSettings,
    orientation: OrientationSettings,
    domain: Option<Domain>,
    /// The domain's prior; without it, that of a first drive.
    belief: Option<DomainBelief>,
    /// Detections whose crops are not read.
    hidden: BTreeSet<usize>,
}

impl<'m> Semantic<'m> {
    /// An estimator that reads crops by `model`.
    pub fn new(settings: &Settings, model: &'m dyn ObservationModel) -> Self {
        let Settings { semantics, orientation, .. } = *settings;
        let discrepant = semantics.azimuth_discrepancy.map(|of| Discrepant::new(model, &of));
        let (geometric, hidden) = (Geometric::new(settings), BTreeSet::new());
        Self { model, discrepant, geometric, semantics, orientation, domain: None, belief: None, hidden }
    }

    /// The same in a domain that it learns, under a prior.
    pub fn in_domain(self, prior: &DomainPrior) -> Self {
        let domain = Some(Domain::new(self.model.noise(), prior));
        Self { domain, ..self }
    }

    /// The same, its domain under this prior.
    pub(super) fn believing(self, belief: DomainBelief) -> Self {
        Self { belief: Some(belief), ..self }
    }

    /// The same, without the crops of some detections. Their bearings stay.
    pub(super) fn without(self, hidden: &BTreeSet<usize>) -> Self {
        Self { hidden: hidden.clone(), ..self }
    }

    /// The domain's prior, where it is not that of a first drive.
    fn prior(&self) -> Option<GaussianPrior> {
        let dim = self.domain.as_ref()?.dim();
        let belief = self.belief.as_ref().filter(|belief| belief.mean.len() == dim)?;
        GaussianPrior::new(Key::Domain, belief)
    }

    /// The model with its discrepancy.
    fn reader(&self) -> &dyn ObservationModel {
        self.discrepant.as_ref().map_or(self.model, |model| model)
    }
}

impl Semantic<'_> {
    /// The estimate, and the log-evidence of all that is observed, nats up to a constant, by Laplace's method; that is `None` where it is
    /// not defined.
    pub(super) fn evidenced(
        &self,
        observations: &Observations,
    ) -> Result<(Estimate, Option<f64>), EstimateError> {
        let (posterior, added) = self.posterior(observations)?;
        let evidence = self.evidence_of(&posterior, &added);
        Ok((self.told(posterior, &added, observations), evidence))
    }

    /// Likewise, with the normalizers of the latents' prior and of the model's whitening: the constant is that of all models of one measurement
    /// and of the same degrees of freedom, that read the same crops.
    pub(super) fn evidenced_among_models(
        &self,
        observations: &Observations,
    ) -> Result<(Estimate, Option<f64>), EstimateError> {
        let (posterior, added) = self.posterior(observations)?;
        let numbers = (added.len() * self.reader().latent_dim()) as f64;
        let upper = self.model.noise().sqrt_information().clone().lu().u();
        let log_det: f64 = upper.diagonal().iter().map(|x| libm::log(x.abs())).sum();
        let of_views = self.semantics.information_scale * views_of(&added) as f64 * log_det;
        let normalizer = of_views - numbers * libm::log(TAU) / 2.0;
        let evidence = self.evidence_of(&posterior, &added).map(|evidence| evidence + normalizer);
        let evidence = evidence.filter(|evidence| evidence.is_finite());
        Ok((self.told(posterior, &added, observations), evidence))
    }

    fn evidence_of(&self, posterior: &Posterior<'_>, added: &BTreeMap<usize, Added>) -> Option<f64> {
        let Posterior { graph, solution, .. } = posterior;
        // What whitening takes out of each view's density.
        let SemanticSettings { noise_scale, information_scale, .. } = self.semantics;
        let numbers = (views_of(added) * self.model.measurement_dim()) as f64;
        let spread = information_scale * numbers * libm::log(noise_scale);
        log_evidence_of_all(graph, &solution.values).map(|evidence| evidence - spread)
    }

    /// Likewise, with the normalizer of the domain's prior; and what is known of the domain after it, which is `None` where the solver came
    /// to no maximum.
    pub(super) fn taught(
        &self,
        observations: &Observations,
    ) -> Result<(Estimate, Option<f64>, Option<DomainBelief>), EstimateError> {
        let (posterior, added) = self.posterior(observations)?;
        let is_at_maximum = matches!(posterior.solution.outcome, Outcome::Converged | Outcome::Stalled);
        let belief = posterior.domain().filter(|_| is_at_maximum);
        let dim = self.domain.as_ref().map_or(0, Domain::dim) as f64;
        let log_det = self.prior().map_or(0.0, |prior| -2.0 * prior.log_det_sqrt_information());
        let evidence = self.evidence_of(&posterior, &added);
        let evidence = evidence.map(|evidence| evidence - (dim * libm::log(TAU) + log_det) / 2.0);
        Ok((self.told(posterior, &added, observations), evidence, belief))
    }

    fn told(
        &self,
        posterior: Posterior<'_>,
        added: &BTreeMap<usize, Added>,
        observations: &Observations,
    ) -> Estimate {
        let seen = |track| added.get(&track).map(Added::seen);
        let mut estimate = self.geometric.estimate_of(posterior, observations, seen);
        let latents = estimate.objects.iter_mut().flatten().filter_map(|object| object.latent.as_mut());
        latents.for_each(|latent| latent.truncate(self.model.latent_dim()));
        estimate
    }

    /// The maximum, and the objects that semantic factors are of.
    fn posterior(
        &self,
        observations: &Observations,
    ) -> Result<(Posterior<'_>, BTreeMap<usize, Added>), EstimateError> {
        check_settings(&self.semantics)?;
        check_settings(&self.orientation)?;
        check_model(self.model)?;
        let model = self.reader();
        let mut posterior = self.geometric.posterior(observations)?;
        let problem = self.geometric.problem(observations);
        let domain = self.domain.as_ref();
        if let Some(domain) = domain {
            let prior = self.prior();
            let start = match &prior {
                Some(prior) => prior.mean().clone(),
                None => DVector::zeros(domain.dim()),
            };
            match prior {
                Some(prior) => posterior.graph.push(prior),
                None => posterior.graph.push(StandardNormalPrior::new(Key::Domain)),
            }
            posterior.solution.values.insert(Key::Domain, Value::Vector(start));
        }
        let semantics = Semantics { problem, model, settings: self.semantics, domain };
        let unknown = self.unknown(&semantics, &mut posterior)?;
        let added = self.read(&semantics, &mut posterior, |track| !unknown.contains_key(&track))?;
        posterior.dropped.unknown_object = unknown.into_values().sum();
        Ok((posterior, added))
    }

    /// Adds the crops of the tracks that are `of` interest, and solves again.
    fn read<'p>(
        &self,
        semantics: &Semantics<'_, 'p>,
        posterior: &mut Posterior<'p>,
        of: impl Fn(usize) -> bool,
    ) -> Result<BTreeMap<usize, Added>, AnswerError> {
        let start = |object: &SemanticObject, sightings: &[Sighting], values: &Values| {
            let modes = modes(semantics, &self.orientation, object, sightings, values)?;
            let margin = match modes.as_slice() {
                [best, second, ..] => second.cost - best.cost,
                _ => f64::INFINITY,
            };
            Ok(Start { modes, margin })
        };
        let reads = |track, sighting: &Sighting| of(track) && !self.hidden.contains(&sighting.detection);
        let solver = &self.geometric.solver;
        let mut added = add_semantics(semantics, posterior, solver, reads, start)?;
        try_alternatives(posterior, &mut added, solver, &self.orientation);
        Ok(added)
    }

    /// The objects that the model does not know, with the numbers of their views: each is asked by its own crops, without those of others.
    fn unknown<'p>(
        &self,
        semantics: &Semantics<'_, 'p>,
        posterior: &mut Posterior<'p>,
    ) -> Result<BTreeMap<usize, usize>, AnswerError> {
        let mut unknown = BTreeMap::new();
        let Some(margin) = self.semantics.unknown_margin else { return Ok(unknown) };
        let (factors, dropped) = (posterior.graph.factors().count(), posterior.dropped);
        let alone = posterior.solution.clone();
        let Some(log_evidence) = log_evidence_of_all(&posterior.graph, &alone.values) else {
            return Ok(unknown);
        };
        let geometry = Geometry { values: alone.values.clone(), log_evidence };
        for track in posterior.sightings.keys().copied().collect::<Vec<_>>() {
            let added = self.read(semantics, posterior, |other| other == track)?;
            if let Some(Added { object, .. }) = added.get(&track) {
                let known = (&posterior.graph, &posterior.solution.values);
                if log_odds(semantics, object, known, &geometry).is_some_and(|odds| odds < -margin) {
                    unknown.insert(track, object.views.len());
                }
            }
            posterior.graph.truncate(factors);
            (posterior.solution, posterior.dropped) = (alone.clone(), dropped);
        }
        Ok(unknown)
    }
}

/// Views that are read.
fn views_of(added: &BTreeMap<usize, Added>) -> usize {
    added.values().map(|added| added.object.views.len()).sum()
}

impl Estimator for Semantic<'_> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        let (posterior, added) = self.posterior(observations)?;
        Ok(self.told(posterior, &added, observations))
    }

    /// None where objects are to be asked for whether the model knows them: that is of all of their views. Nor is there one in a domain that
    /// is learnt.
    fn online(&self, camera: Camera, robot_from_camera: Pose) -> Option<Result<Online<'_>, EstimateError>> {
        if self.semantics.unknown_margin.is_some() || self.domain.is_some() {
            return None;
        }
        let checked = || -> Result<Online<'_>, EstimateError> {
            check_settings(&self.semantics)?;
            check_settings(&self.orientation)?;
            check_model(self.model)?;
            let reading =
                Reading { model: self.reader(), semantics: self.semantics, orientation: self.orientation };
            self.geometric.online_by(Some(reading), (camera, robot_from_camera))
        };
        Some(checked())
    }
}
