//! What is seen in the crops of a drive, at draws of its posterior.

use super::{Added, Semantic};
use crate::draws::draws;
use crate::estimate::Estimate;
use crate::factor::Factor;
use crate::input::EstimateError;
use crate::posterior::Posterior;
use crate::semantics::{SemanticObject, SemanticView, Semantics};
use crate::solve::Outcome;
use crate::variable::{Key, Values};
use nalgebra::DVector;
use std::collections::BTreeMap;
use vantage_dataset::{Observations, Stream, Viewpoint};

/// An estimate, its log-evidence, and what was seen at draws of the posterior.
pub(in crate::estimator) type Drawn = (Estimate, Option<f64>, Option<Vec<SeenView>>);

/// A crop with what is seen in it.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenView {
    /// `m(z)`, `[M]`.
    pub measurement: DVector<f64>,
    /// The model's own latent, `[D]`.
    pub latent: DVector<f64>,
    /// From where the model sees.
    pub viewpoint: Viewpoint,
    /// Of the crop: less than 1 where it fits badly, or is one of several draws.
    pub weight: f64,
}

impl Semantic<'_> {
    /// The estimate with its log-evidence, and what was seen of objects at so many draws of the posterior; that is `None` where the solver came to no maximum.
    pub(in crate::estimator) fn drawn(
        &self,
        observations: &Observations,
        (count, random): (usize, &mut Stream),
    ) -> Result<Drawn, EstimateError> {
        let (posterior, added) = self.posterior(observations)?;
        let Posterior { graph, solution, .. } = &posterior;
        let is_at_maximum = matches!(solution.outcome, Outcome::Converged | Outcome::Stalled);
        let drawn = if is_at_maximum { draws(graph, &solution.values, count, random) } else { None };
        let views = drawn.map(|drawn| {
            let at = |values| self.views_at(values, &added, observations);
            let mut views: Vec<SeenView> = drawn.iter().flat_map(at).collect();
            views.iter_mut().for_each(|view| view.weight /= count as f64);
            views
        });
        let evidence = self.evidence_of(&posterior, &added);
        Ok((self.told(posterior, &added, observations), evidence, views))
    }

    fn views_at(
        &self,
        values: &Values,
        added: &BTreeMap<usize, Added>,
        observations: &Observations,
    ) -> Vec<SeenView> {
        let problem = self.geometric.problem(observations);
        let semantics = Semantics { problem, model: self.reader(), settings: self.semantics, domain: None };
        let view = |object: &SemanticObject, view: &SemanticView| {
            let world_from_camera = problem.world_from_camera(values, view.sighting.step)?;
            let object_from_camera = values.pose(Key::Object(object.track))?.inv_mul(&world_from_camera);
            let viewpoint = Viewpoint::new(&object_from_camera, object.size)?;
            let latent = values.vector(Key::Latent(object.track))?;
            let (latent, viewpoint) = match &self.discrepant {
                Some(discrepant) => discrepant.within(latent, &viewpoint),
                None => (latent.clone(), viewpoint),
            };
            let factor = semantics.factor(object, view);
            let residual = factor.residual(values)?;
            let weight =
                factor.information_scale() * factor.kernel().weight(residual.norm_squared(), residual.len());
            Some(SeenView { measurement: view.measurement.clone(), latent, viewpoint, weight })
        };
        let objects = added.values().map(|added| &added.object);
        objects.flat_map(|object| object.views.iter().filter_map(move |of| view(object, of))).collect()
    }
}
