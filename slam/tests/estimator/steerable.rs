//! Objects whose measurements are linear in a latent that turns with the azimuth, and in a second one that is known or integrated out.
//!
//! ```text
//! z = C T(-a) e + N T(-a) s + U u + n,   e, s ~ N(0, I),   n ~ N(0, S)
//! ```
//!
//! with `a` the azimuth and `u` the upright numbers of the viewpoint, `N` and `S` alike for both numbers of a pair. Where `s` is known,
//! views are independent given `[e; s]`. Where it is not, they are not given `e`: with `K = N^2 (N^2 + S)^-1`,
//!
//! ```text
//! z | e ~ N(C T(-a) e + U u, N^2 + S)
//! z' | z, e ~ N(C T(-a') e + U u' + K T(a - a') (z - C T(-a) e - U u), S + N^2 - N^2 K)
//! ```

use nalgebra::{DMatrix, DVector};
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};
use vantage_dataset::{Crop, Seed, Viewpoint};
use vantage_model::{
    AnswerError, FirstView, LatentGaussian, Linearization, MeasurementNoise, ObservationModel,
    PairLinearization, PairModel, ViewpointDerivative,
};

/// Harmonics of `e`: one number that does not turn, then pairs.
const SEEN: [usize; 3] = [0, 1, 2];
/// Harmonics of `s`, and of the measurement.
const HIDDEN: [usize; 2] = [1, 3];
const UPRIGHT: usize = CONDITIONING - 2 * HARMONICS;
/// Deviations by pair: of `N s` and of `n`.
const STRUCTURE: [f64; 2] = [0.5, 0.3];
const WHITE: [f64; 2] = [0.05, 0.03];

/// The model, and what of the object it has in its latent.
pub struct Steerable {
    seen: DMatrix<f64>,
    upright: DMatrix<f64>,
    knows_all: bool,
    noise: MeasurementNoise,
    pair_noise: MeasurementNoise,
}

impl Steerable {
    /// With the latent `[e; s]`.
    pub fn of_all(seed: Seed) -> Self {
        Self::new(seed, true)
    }

    /// With the latent `e`.
    pub fn of_pairs(seed: Seed) -> Self {
        Self::new(seed, false)
    }

    fn new(seed: Seed, knows_all: bool) -> Self {
        let mut stream = seed.stream("steerable", 0);
        let variance = |pair: usize| (STRUCTURE[pair].powi(2), WHITE[pair].powi(2));
        let deviation = |pair: usize| {
            let (structure, white) = variance(pair);
            (if knows_all { white } else { structure + white }).sqrt()
        };
        let given_first = |pair: usize| {
            let (structure, white) = variance(pair);
            (white + structure - structure * Self::share(pair)).sqrt()
        };
        Self {
            seen: DMatrix::from_fn(4, size(&SEEN), |_, _| stream.normal()),
            upright: DMatrix::from_fn(4, UPRIGHT, |_, _| 0.3 * stream.normal()),
            knows_all,
            noise: MeasurementNoise::new(by_pair(|pair| deviation(pair).recip()), f64::INFINITY).unwrap(),
            pair_noise: MeasurementNoise::new(by_pair(|pair| given_first(pair).recip()), f64::INFINITY)
                .unwrap(),
        }
    }

    /// With noise of a second view that does not fit its measurement.
    pub fn with_noise_of_a_pair_too_many(self) -> Self {
        let pair_noise = MeasurementNoise::new(DMatrix::identity(6, 6), f64::INFINITY).unwrap();
        Self { pair_noise, ..self }
    }

    /// `K` of a pair.
    fn share(pair: usize) -> f64 {
        let (structure, white) = (STRUCTURE[pair].powi(2), WHITE[pair].powi(2));
        structure / (structure + white)
    }

    /// The matrix that a measurement is of its latent, and its derivative by the azimuth.
    fn look(&self, azimuth: f64) -> [DMatrix<f64>; 2] {
        let turned = |left: &DMatrix<f64>, harmonics: &[usize]| {
            let [turn, slope] = turn(harmonics, -azimuth);
            [left * turn, -(left * slope)]
        };
        let seen = turned(&self.seen, &SEEN);
        if !self.knows_all {
            return seen;
        }
        let hidden = turned(&by_pair(|pair| STRUCTURE[pair]), &HIDDEN);
        [0, 1].map(|i| {
            let columns: Vec<_> = seen[i].column_iter().chain(hidden[i].column_iter()).collect();
            DMatrix::from_columns(&columns)
        })
    }
}

fn size(harmonics: &[usize]) -> usize {
    harmonics.iter().map(|&m| if m == 0 { 1 } else { 2 }).sum()
}

fn by_pair(of: impl Fn(usize) -> f64) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_fn(4, |i, _| of(i / 2)))
}

/// `T(angle)` and its derivative.
fn turn(harmonics: &[usize], angle: f64) -> [DMatrix<f64>; 2] {
    let size = size(harmonics);
    let [mut turn, mut slope] = [0; 2].map(|_| DMatrix::zeros(size, size));
    let mut at = 0;
    for &harmonic in harmonics {
        if harmonic == 0 {
            turn[(at, at)] = 1.0;
            at += 1;
            continue;
        }
        let m = harmonic as f64;
        let (s, c) = (m * angle).sin_cos();
        for (i, j, value, derivative) in [(0, 0, c, -s), (0, 1, -s, -c), (1, 0, s, c), (1, 1, c, -s)] {
            turn[(at + i, at + j)] = value;
            slope[(at + i, at + j)] = m * derivative;
        }
        at += 2;
    }
    [turn, slope]
}

fn upright(viewpoint: &Viewpoint) -> DVector<f64> {
    DVector::from_column_slice(&viewpoint.conditioning()[2 * HARMONICS..])
}

impl ObservationModel for Steerable {
    fn latent_dim(&self) -> usize {
        size(&SEEN) + if self.knows_all { size(&HIDDEN) } else { 0 }
    }

    fn noise(&self) -> &MeasurementNoise {
        &self.noise
    }

    fn measure(&self, crop: &Crop) -> Result<DVector<f64>, AnswerError> {
        let numbers = crop.0.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap()));
        Ok(DVector::from_iterator(4, numbers.take(4)))
    }

    /// The posterior, but for what its numbers share.
    fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
        let [look, _] = self.look(viewpoint.azimuth());
        let whiten = self.noise.sqrt_information();
        let jacobian = whiten * look;
        let precision = DMatrix::identity(self.latent_dim(), self.latent_dim()) + jacobian.tr_mul(&jacobian);
        let covariance = precision.cholesky().unwrap().inverse();
        let seen = whiten * (self.measure(crop)? - &self.upright * upright(viewpoint));
        Ok(LatentGaussian { mean: &covariance * jacobian.tr_mul(&seen), variance: covariance.diagonal() })
    }

    fn predict(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
        Ok(&self.look(viewpoint.azimuth())[0] * latent + &self.upright * upright(viewpoint))
    }

    fn linearize(&self, latent: &DVector<f64>, viewpoint: &Viewpoint) -> Result<Linearization, AnswerError> {
        let [look, slope] = self.look(viewpoint.azimuth());
        let by_azimuth = slope * latent;
        Ok(Linearization {
            mean: self.predict(latent, viewpoint)?,
            d_latent: look,
            d_viewpoint: ViewpointDerivative::by_azimuth_and_upright(viewpoint, &by_azimuth, &self.upright),
        })
    }
}

impl PairModel for Steerable {
    fn pair_noise(&self) -> &MeasurementNoise {
        &self.pair_noise
    }

    fn predict_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<DVector<f64>, AnswerError> {
        Ok(self.linearize_pair(latent, first, second)?.mean)
    }

    fn linearize_pair(
        &self,
        latent: &DVector<f64>,
        first: FirstView<'_>,
        second: &Viewpoint,
    ) -> Result<PairLinearization, AnswerError> {
        let FirstView { measurement, viewpoint } = first;
        let [turn, slope] = turn(&HIDDEN, viewpoint.azimuth() - second.azimuth());
        let [carried, carried_slope] = [turn, slope].map(|turn| by_pair(Self::share) * turn);
        let [of_first, of_second] = [self.linearize(latent, viewpoint)?, self.linearize(latent, second)?];
        let off = measurement - &of_first.mean;
        let by_turn = carried_slope * &off;
        let by = |at: &Linearization, viewpoint: &Viewpoint| at.d_viewpoint.by_azimuth(viewpoint);
        let by_first = &by_turn - &carried * by(&of_first, viewpoint);
        let by_second = by(&of_second, second) - &by_turn;
        let through = |viewpoint: &Viewpoint, by_azimuth: &DVector<f64>, by_upright: &DMatrix<f64>| {
            ViewpointDerivative::by_azimuth_and_upright(viewpoint, by_azimuth, by_upright)
        };
        Ok(PairLinearization {
            mean: &of_second.mean + &carried * off,
            d_latent: &of_second.d_latent - &carried * &of_first.d_latent,
            d_first_viewpoint: through(viewpoint, &by_first, &-(&carried * &self.upright)),
            d_second_viewpoint: through(second, &by_second, &self.upright),
            d_first_measurement: carried,
        })
    }
}
