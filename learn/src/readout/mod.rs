//! Read-outs of what a model makes of single crops, fitted on labelled views of instances that it has not seen: what a supervised
//! feature is worth without the paper's latent.
//!
//! | symbol | here |
//! |---|---|
//! | `p(azimuth \| m(z))`, stage 1's head | [`AzimuthReadout`] |
//! | `p(m(z) \| c, x_rel)` of Eq. 8 | [`ClassReadout`] |
//! | an embedding's covariances within and between objects | [`EmbeddingReadout`] |
//!
//! Noise is fitted to the errors of a read-out of the other half of the instances.

mod azimuth;
mod class;
mod embedding;
mod softmax;

pub use azimuth::{AzimuthReadout, AzimuthWeights};
pub use class::{ClassReadout, ClassWeights};
pub use embedding::{EmbeddingReadout, EmbeddingWeights};

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use vantage_dataset::{ViewSet, Viewpoint};
use vantage_model::{AnswerError, ObservationModel};

/// The read-outs of one model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Readouts {
    /// Of the azimuth.
    pub azimuth: AzimuthWeights,
    /// By class.
    pub classes: ClassWeights,
}

/// A view as a read-out is fitted to it.
#[derive(Clone, Debug)]
pub struct LabelledView {
    /// `m(z)`, `[M]`.
    pub measurement: DVector<f64>,
    /// `x_rel`.
    pub viewpoint: Viewpoint,
    /// Which instance it shows.
    pub instance: usize,
    /// Its instance's class.
    pub class: usize,
}

impl Readouts {
    /// The read-outs of the views that `model` measures, their families as classes; `Ok(None)` with too few views for the noise.
    pub fn fit(model: &dyn ObservationModel, set: &ViewSet) -> Result<Option<Self>, AnswerError> {
        let mut names: Vec<&str> = set.instances.iter().map(|instance| instance.family.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let mut views = Vec::with_capacity(set.views.len());
        for view in &set.views {
            let family = set.instances[view.instance].family.as_str();
            let measurement = match model.measure(&view.crop) {
                Ok(measurement) if measurement.iter().all(|x| x.is_finite()) => measurement,
                Ok(_) | Err(AnswerError::NonFinite { .. }) => continue,
                Err(error) => return Err(error),
            };
            let class = names.binary_search(&family).expect("every family is listed");
            let (viewpoint, instance) = (view.viewpoint, view.instance);
            views.push(LabelledView { measurement, viewpoint, instance, class });
        }
        let azimuth = AzimuthWeights::fit(&views);
        let classes = ClassWeights::fit(&names, &views);
        Ok(azimuth.zip(classes).map(|(azimuth, classes)| Self { azimuth, classes }))
    }
}

/// The views of every other instance of each class, and those of the rest: a half's noise is that of a fit to the other.
fn halves(views: &[LabelledView]) -> [Vec<&LabelledView>; 2] {
    let instances: BTreeSet<_> = views.iter().map(|view| (view.class, view.instance)).collect();
    let second: BTreeSet<_> = instances.into_iter().skip(1).step_by(2).collect();
    let (second, first) = views.iter().partition(|view| second.contains(&(view.class, view.instance)));
    [first, second]
}

/// `(X^T X + ridge I)^-1 X^T Y`, of inputs `[n, p]` and outputs `[n, q]`.
fn ridge(inputs: &DMatrix<f64>, outputs: &DMatrix<f64>, ridge: f64) -> Option<DMatrix<f64>> {
    let normal = inputs.tr_mul(inputs) + DMatrix::identity(inputs.ncols(), inputs.ncols()) * ridge;
    Some(normal.cholesky()?.solve(&inputs.tr_mul(outputs)))
}

#[cfg(test)]
mod tests;
