//! Eq. 8: for each class, a regression of `m(z)` on the conditioning of the viewpoint.

use super::{LabelledView, halves, ridge};
use crate::residual::ResidualNoise;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};
use vantage_model::{AnswerError, ClassModel, MeasurementNoise, ObservationModel, ViewpointDerivative};

/// Of the regressions: far less than the views of a class, so that it is felt only where they lack a direction.
const RIDGE: f64 = 1.0;

/// What is fitted, by class: `h(c, x) = B_c [1, conditioning(x)]` and the Student t of `m(z) - h`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassWeights {
    /// Names of the classes.
    names: Vec<String>,
    /// `B_c`, `[M, 1 + CONDITIONING]`.
    coefficients: Vec<DMatrix<f64>>,
    noise: Vec<ResidualNoise>,
}

impl ClassWeights {
    /// The classes' regressions, and the noise of those of the other half of the instances, of all classes together where a class has
    /// too few views; `None` where all have.
    pub fn fit(names: &[&str], views: &[LabelledView]) -> Option<Self> {
        let [even, odd] = halves(views);
        let of_class = |views: &[&LabelledView], class: usize| -> Vec<LabelledView> {
            views.iter().filter(|view| view.class == class).map(|&view| view.clone()).collect()
        };
        let (mut coefficients, mut residuals) = (Vec::new(), Vec::new());
        for class in 0..names.len() {
            let halves = [of_class(&even, class), of_class(&odd, class)];
            let across = [(0, 1), (1, 0)].map(|(known, tested)| {
                let fitted = regression(&halves[known])?;
                let (inputs, outputs) = table(&halves[tested])?;
                Some(outputs - inputs * fitted)
            });
            residuals.push(across.into_iter().flatten().reduce(|a, b| stacked(&a, &b)));
            coefficients.push(regression(&halves.concat())?.transpose());
        }
        let together = residuals.iter().flatten().cloned().reduce(|a, b| stacked(&a, &b))?;
        let together = ResidualNoise::fit(&together)?;
        let noise = residuals.iter().map(|of_class| of_class.as_ref().and_then(ResidualNoise::fit));
        let noise = noise.map(|noise| noise.unwrap_or_else(|| together.clone())).collect();
        Some(Self { names: names.iter().map(|&name| name.to_owned()).collect(), coefficients, noise })
    }

    /// Names of the classes.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}

/// `B_c^T`.
fn regression(views: &[LabelledView]) -> Option<DMatrix<f64>> {
    let (inputs, outputs) = table(views)?;
    ridge(&inputs, &outputs, RIDGE)
}

/// `[1, conditioning]` and measurements, a view a row.
fn table(views: &[LabelledView]) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let dimension = views.first()?.measurement.len();
    let mut inputs = DMatrix::from_element(views.len(), 1 + CONDITIONING, 1.0);
    for (mut row, view) in inputs.row_iter_mut().zip(views) {
        row.columns_mut(1, CONDITIONING).copy_from_slice(&view.viewpoint.conditioning());
    }
    Some((inputs, DMatrix::from_fn(views.len(), dimension, |i, j| views[i].measurement[j])))
}

fn stacked(above: &DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = above.clone().resize_vertically(above.nrows() + below.nrows(), 0.0);
    both.rows_mut(above.nrows(), below.nrows()).copy_from(below);
    both
}

/// The classes of one model.
pub struct ClassReadout<'m> {
    model: &'m dyn ObservationModel,
    weights: &'m ClassWeights,
    noise: Vec<MeasurementNoise>,
}

impl<'m> ClassReadout<'m> {
    /// Those of `weights` fitted to what `model` measures.
    pub fn new(model: &'m dyn ObservationModel, weights: &'m ClassWeights) -> Self {
        Self { model, weights, noise: weights.noise.iter().map(ResidualNoise::law).collect() }
    }
}

impl ClassModel for ClassReadout<'_> {
    fn classes(&self) -> usize {
        self.noise.len()
    }

    fn noise(&self, class: usize) -> &MeasurementNoise {
        &self.noise[class]
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        self.model.measure(crop)
    }

    fn linearize(&self, class: usize, viewpoint: &Viewpoint) -> (DVector<f64>, ViewpointDerivative) {
        let coefficients = &self.weights.coefficients[class];
        let by_coordinates = coefficients.columns(1, CONDITIONING).into_owned();
        let conditioning = DVector::from_column_slice(&viewpoint.conditioning());
        let expected = coefficients.column(0) + &by_coordinates * conditioning;
        (expected, ViewpointDerivative::new(by_coordinates))
    }
}
