//! The azimuth head of stage 1 as a sensor: a distribution over bins of the azimuth, linear in `m(z)` but for the softmax.

use super::{LabelledView, halves, softmax};
use crate::residual::ResidualNoise;
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use vantage_dataset::Crop;
use vantage_model::{AnswerError, AzimuthReading, AzimuthSensor, ObservationModel, student_t};

/// Angles told apart, and the concentration of a label: those of stage 1's head.
const BINS: usize = 48;
const CONCENTRATION: f64 = 20.0;
/// Exponents tried.
const EXPONENTS: [f64; 9] = [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0];
/// Least spread of the bins, radians.
const LEAST_SPREAD: f64 = 1e-3;

/// What is fitted: `p(bin | m) = softmax(weights^T [1, m])`, and the error of its mean direction, `sigma = scale spread^exponent`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AzimuthWeights {
    /// `[1 + M, BINS]`.
    weights: DMatrix<f64>,
    /// Of the spread.
    exponent: f64,
    /// Of errors over `spread^exponent`.
    noise: ResidualNoise,
}

/// Mean direction of the bins, radians, and their spread `sqrt(-2 log R)`, `R` the resultant length.
struct Direction {
    azimuth: f64,
    spread: f64,
}

impl AzimuthWeights {
    /// The most probable weights, and the noise of those of the other half; `None` with too few views.
    pub fn fit(views: &[LabelledView]) -> Option<Self> {
        let [even, odd] = halves(views);
        let mut errors = Vec::with_capacity(views.len());
        for (known, tested) in [(&even, &odd), (&odd, &even)] {
            let weights = of_views(known)?;
            let found = directions(&weights, tested);
            errors.extend(found.into_iter().zip(tested.iter()).map(|(found, view)| {
                let turn = Complex::from_polar(1.0, found.azimuth - view.viewpoint.azimuth());
                (libm::atan2(turn.im, turn.re), found.spread)
            }));
        }
        let of_exponent = |exponent: f64| {
            let scaled = errors.iter().map(|(error, spread)| error / libm::pow(*spread, exponent));
            let scaled = DMatrix::from_iterator(errors.len(), 1, scaled);
            let noise = ResidualNoise::fit(&scaled)?;
            let (information, nu) = (noise.sqrt_information[0][0], noise.degrees_of_freedom);
            let of_error = |(scaled, (_, spread)): (&f64, &(f64, f64))| {
                student_t::log_density((information * scaled).powi(2), 1, nu, libm::log(information))
                    - exponent * libm::log(*spread)
            };
            let likelihood: f64 = scaled.iter().zip(&errors).map(of_error).sum();
            Some((likelihood, exponent, noise))
        };
        let fitted = EXPONENTS.into_iter().filter_map(of_exponent).max_by(|a, b| a.0.total_cmp(&b.0));
        let (_, exponent, noise) = fitted?;
        let all: Vec<&LabelledView> = views.iter().collect();
        Some(Self { weights: of_views(&all)?, exponent, noise })
    }

    fn read(&self, measurement: &DVector<f64>) -> AzimuthReading {
        let inputs =
            DMatrix::from_row_slice(1, measurement.len(), measurement.as_slice()).insert_column(0, 1.0);
        let found = direction(softmax::probabilities(inputs * &self.weights).iter());
        let scale = self.noise.sqrt_information[0][0].recip();
        AzimuthReading { azimuth: found.azimuth, sigma: scale * libm::pow(found.spread, self.exponent) }
    }
}

fn of_views(views: &[&LabelledView]) -> Option<DMatrix<f64>> {
    let (first, n) = (views.first()?, views.len());
    let inputs = inputs(first.measurement.len(), views);
    let bump = |i: usize, bin: usize| {
        libm::exp(CONCENTRATION * (libm::cos(views[i].viewpoint.azimuth() - center(bin)) - 1.0))
    };
    let mut labels = DMatrix::from_fn(n, BINS, bump);
    for mut row in labels.row_iter_mut() {
        row /= row.sum();
    }
    softmax::fit(&inputs, &labels)
}

fn directions(weights: &DMatrix<f64>, views: &[&LabelledView]) -> Vec<Direction> {
    let inputs = inputs(weights.nrows() - 1, views);
    softmax::probabilities(inputs * weights).row_iter().map(|row| direction(row.iter())).collect()
}

fn inputs(dimension: usize, views: &[&LabelledView]) -> DMatrix<f64> {
    let number = |i: usize, j: usize| if j == 0 { 1.0 } else { views[i].measurement[j - 1] };
    DMatrix::from_fn(views.len(), 1 + dimension, number)
}

fn direction<'p>(probabilities: impl Iterator<Item = &'p f64>) -> Direction {
    let (mut x, mut y) = (0.0, 0.0);
    for (bin, p) in probabilities.enumerate() {
        let (sin, cos) = libm::sincos(center(bin));
        (x, y) = (x + p * cos, y + p * sin);
    }
    let spread = (-2.0 * libm::log(libm::hypot(x, y).min(1.0))).max(0.0).sqrt();
    Direction { azimuth: libm::atan2(y, x), spread: spread.max(LEAST_SPREAD) }
}

fn center(bin: usize) -> f64 {
    (bin as f64 + 0.5) * 2.0 * PI / BINS as f64
}

/// The sensor of one model.
#[derive(Clone, Copy)]
pub struct AzimuthReadout<'m> {
    model: &'m dyn ObservationModel,
    weights: &'m AzimuthWeights,
}

impl<'m> AzimuthReadout<'m> {
    /// That of `weights` fitted to what `model` measures.
    pub fn new(model: &'m dyn ObservationModel, weights: &'m AzimuthWeights) -> Self {
        Self { model, weights }
    }
}

impl AzimuthSensor for AzimuthReadout<'_> {
    fn read(&self, crop: &Crop) -> Result<AzimuthReading, AnswerError> {
        let (measured, expected) = (self.model.measure(crop)?, self.weights.weights.nrows() - 1);
        if measured.len() != expected {
            return Err(AnswerError::Shape { what: "measurement", got: measured.len(), expected });
        }
        Ok(self.weights.read(&measured))
    }

    fn degrees_of_freedom(&self) -> f64 {
        self.weights.noise.degrees_of_freedom
    }
}
