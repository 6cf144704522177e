//! A random two-layer network with analytic derivatives; its measurements travel inside the crop's bytes.

use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Crop, Seed, Viewpoint};
use vantage_model::{
    AnswerError, LastLayer, LatentGaussian, Linearization, MeasurementNoise, ObservationModel,
    ViewpointDerivative,
};

#[derive(Clone)]
pub struct TanhModel {
    latent: DMatrix<f64>,
    conditioning: DMatrix<f64>,
    bias: DVector<f64>,
    output: DMatrix<f64>,
    noise: MeasurementNoise,
}

impl TanhModel {
    /// `D`, `M` and hidden units, with measurement noise of standard deviation `sigma`.
    pub fn new(dims: [usize; 3], sigma: f64, degrees_of_freedom: f64, seed: Seed) -> Self {
        let [d, m, hidden] = dims;
        let mut stream = seed.stream("tanh model", 0);
        let mut random = |rows: usize, columns: usize, scale: f64| {
            DMatrix::from_fn(rows, columns, |_, _| scale * stream.normal())
        };
        let latent = random(hidden, d, 1.0 / (d as f64).sqrt());
        let mut conditioning = random(hidden, CONDITIONING, 0.3);
        conditioning.columns_mut(0, 2).scale_mut(2.0);
        Self {
            latent,
            conditioning,
            bias: random(hidden, 1, 0.3).column(0).into_owned(),
            output: random(m, hidden, 1.0 / (hidden as f64).sqrt()),
            noise: MeasurementNoise::new(DMatrix::identity(m, m) / sigma, degrees_of_freedom).unwrap(),
        }
    }

    /// The same of objects that look alike from all around.
    pub fn blind_to_azimuth(dims: [usize; 3], sigma: f64, degrees_of_freedom: f64, seed: Seed) -> Self {
        let mut model = Self::new(dims, sigma, degrees_of_freedom, seed);
        model.conditioning.columns_mut(0, 2 * HARMONICS).fill(0.0);
        model
    }

    fn activation(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> DVector<f64> {
        let x = DVector::from_column_slice(&viewpoint.conditioning());
        (&self.latent * latent + &self.conditioning * x + &self.bias).map(f64::tanh)
    }

    /// The same with another last layer.
    pub fn with_output(&self, change: &DMatrix<f64>) -> Self {
        let output = &self.output + change.columns(0, self.output.ncols());
        Self { output, ..self.clone() }
    }

    /// A crop that measures as the given numbers.
    pub fn crop(measurement: &DVector<f64>) -> Crop {
        let mut crop = Crop::black();
        for (bytes, value) in crop.0.chunks_exact_mut(8).zip(measurement.iter()) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
        crop
    }
}

impl ObservationModel for TanhModel {
    fn latent_dim(&self) -> usize {
        self.latent.ncols()
    }

    fn measurement_dim(&self) -> usize {
        self.output.nrows()
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        let numbers = crop.0.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap()));
        Ok(DVector::from_iterator(self.measurement_dim(), numbers.take(self.measurement_dim())))
    }

    /// The posterior of the model linearised at `e = 0`.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        let d = self.latent_dim();
        let near = self.linearize(&DVector::zeros(d), viewpoint)?;
        let w = self.noise.sqrt_information();
        let j = w * near.d_latent;
        let precision = DMatrix::identity(d, d) + j.tr_mul(&j);
        let covariance = precision.cholesky().unwrap().inverse();
        let mean = &covariance * j.tr_mul(&(w * (self.measure(crop)? - near.mean)));
        Ok(LatentGaussian { mean, variance: covariance.diagonal() })
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(&self.output * self.activation(latent, viewpoint))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let activation = self.activation(latent, viewpoint);
        let mut slope = self.output.clone();
        for (mut column, a) in slope.column_iter_mut().zip(activation.iter()) {
            column *= 1.0 - a * a;
        }
        Ok(Linearization {
            mean: &self.output * activation,
            d_latent: &slope * &self.latent,
            d_viewpoint: ViewpointDerivative::new(slope * &self.conditioning),
        })
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }
}

/// Its output's weights are the layer, and there is no bias.
impl LastLayer for TanhModel {
    fn model(&self) -> &dyn ObservationModel {
        self
    }

    fn features(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(self.activation(latent, viewpoint).push(1.0))
    }

    fn changed(&self, change: &DMatrix<f64>) -> Result<Box<dyn ObservationModel + '_>, AnswerError> {
        Ok(Box::new(self.with_output(change)))
    }
}
