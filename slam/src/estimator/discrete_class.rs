//! P(X, O, C | U, Z^g, Z^s): geometric, with the semantic factors of Eq. 8, each object of one class of several.

use super::Estimator;
use super::hypotheses::{Hypotheses, Joined, Reading};
use crate::estimate::Estimate;
use crate::factor::ClassFactor;
use crate::factor::semantic::SemanticScaling;
use crate::graph::Graph;
use crate::input::EstimateError;
use crate::semantics::unless_non_finite;
use crate::settings::{SemanticSettings, Settings};
use nalgebra::DVector;
use vantage_dataset::{Crop, Observations};
use vantage_model::{AnswerError, ClassModel};

/// The geometric estimator's factors and those of Eq. 8, by a [model](ClassModel) of classes.
///
/// Inference is hybrid: classes by enumeration, poses by Levenberg-Marquardt under the most probable class of each object.
#[derive(Clone, Debug)]
pub struct DiscreteClass<M> {
    hypotheses: Hypotheses,
    model: M,
}

impl<M: ClassModel> DiscreteClass<M> {
    /// An estimator that reads crops by `model`.
    pub fn new(settings: &Settings, model: M) -> Self {
        Self { hypotheses: Hypotheses::new(settings), model }
    }
}

impl<M: ClassModel> Estimator for DiscreteClass<M> {
    fn estimate(&self, observations: &Observations) -> Result<Estimate, EstimateError> {
        let reading = Classes { model: &self.model, settings: self.hypotheses.semantics };
        let (mut estimate, beliefs) = self.hypotheses.estimate(&reading, observations)?;
        for (track, belief) in beliefs {
            if let Some(Some(object)) = estimate.objects.get_mut(track) {
                object.classes = Some(belief);
            }
        }
        Ok(estimate)
    }
}

/// A hypothesis for each class.
struct Classes<'s> {
    model: &'s dyn ClassModel,
    settings: SemanticSettings,
}

impl Reading for Classes<'_> {
    fn hypotheses(&self) -> usize {
        self.model.classes()
    }

    fn measure(&self, crop: &Crop) -> Result<Option<DVector<f64>>, AnswerError> {
        let measured = unless_non_finite(self.model.measure(crop))?;
        let Some(measured) = measured.filter(|m| m.iter().all(|x| x.is_finite())) else { return Ok(None) };
        for class in 0..self.model.classes() {
            let (got, expected) = (measured.len(), self.model.noise(class).dimension());
            if got != expected {
                return Err(AnswerError::Shape { what: "measurement", got, expected });
            }
        }
        Ok(Some(measured))
    }

    fn add<'m>(&'m self, graph: &mut Graph<'m>, class: usize, of: &Joined<'_>) {
        let (measured, mount) = (of.view.measurement.clone(), of.observations.robot_from_camera);
        let SemanticSettings { noise_scale, information_scale, .. } = self.settings;
        let scaling = SemanticScaling { noise: noise_scale, information: information_scale };
        graph.push(ClassFactor::new(of.keys, (self.model, class), measured, mount, of.object.size, scaling));
    }

    /// Classes of wide noise, or of heavy tails, are not preferred for it.
    fn constant(&self, class: usize) -> f64 {
        -self.model.noise(class).log_normalizer()
    }
}
