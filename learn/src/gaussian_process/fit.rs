//! Hyper-parameters of most marginal likelihood.

use super::hyperparameters::Hyperparameters;
use super::reduced::{COMPONENTS, measurement};
use nalgebra::{DMatrix, DVector};
use vantage_dataset::Crop;
use vantage_model::Periodic;
use vantage_model::periodic::FEATURES;

const KAPPAS: [f64; 9] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
/// Deviations tried are a power of this, beside a component's root mean square.
const RATIO: f64 = 1.15;

impl Hyperparameters {
    /// The best of a grid for `objects`, each the crops of one object and the azimuths that they were seen from, and their
    /// log marginal likelihood under Gaussian noise, nats. Each component has deviations of its own, all share the kernel; black crops are left out.
    pub fn fit(objects: &[Vec<(&Crop, f64)>]) -> (Self, f64) {
        let fits = KAPPAS.map(|kappa| of_kappa(kappa, objects));
        fits.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("there are several")
    }
}

fn of_kappa(kappa: f64, objects: &[Vec<(&Crop, f64)>]) -> (Hyperparameters, f64) {
    let rotated: Vec<(DVector<f64>, DMatrix<f64>)> =
        objects.iter().filter_map(|views| diagonalised(kappa, views)).collect();
    let mut fitted = Hyperparameters {
        kappa,
        signal: [1.0; COMPONENTS],
        noise: [1.0; COMPONENTS],
        degrees_of_freedom: f64::INFINITY,
    };
    let mut sum = 0.0;
    for j in 0..COMPONENTS {
        let numbers = || {
            rotated.iter().flat_map(|(_, measured)| measured.column(j).iter().copied().collect::<Vec<_>>())
        };
        let root_mean_square = (numbers().map(|x| x * x).sum::<f64>() / numbers().count() as f64).sqrt();
        let deviation = |power: i32| root_mean_square * RATIO.powi(power);
        let tried = (-4..8).flat_map(|s| (-24..2).map(move |n| (deviation(s), deviation(n))));
        let likelihood = |signal: f64, noise: f64| -> f64 {
            let of_object = |(shares, measured): &(DVector<f64>, DMatrix<f64>)| -> f64 {
                let of_number = |(share, x): (&f64, &f64)| {
                    let variance = signal * signal * share + noise * noise;
                    -0.5 * (libm::log(2.0 * std::f64::consts::PI * variance) + x * x / variance)
                };
                shares.iter().zip(measured.column(j).iter()).map(of_number).sum()
            };
            rotated.iter().map(of_object).sum()
        };
        let scored = tried.map(|(signal, noise)| (likelihood(signal, noise), signal, noise));
        if let Some((best, signal, noise)) = scored.max_by(|a, b| a.0.total_cmp(&b.0)) {
            (fitted.signal[j], fitted.noise[j]) = (signal, noise);
            sum += best;
        }
    }
    (fitted, sum)
}

/// Eigenvalues of the kernel between an object's views, `[n]`, and the measurements along its eigenvectors, `[n x M]`.
fn diagonalised(kappa: f64, views: &[(&Crop, f64)]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let usable: Vec<_> =
        views.iter().filter_map(|&(crop, azimuth)| Some((measurement(crop)?, azimuth))).collect();
    if usable.is_empty() {
        return None;
    }
    let functions = Periodic::new(kappa);
    let phi = DMatrix::from_fn(usable.len(), FEATURES, |i, k| functions.features(usable[i].1)[k]);
    let measured = DMatrix::from_fn(usable.len(), COMPONENTS, |i, j| usable[i].0[j]);
    let eigen = (&phi * phi.transpose()).symmetric_eigen();
    Some((eigen.eigenvalues.map(|x| x.max(0.0)), eigen.eigenvectors.tr_mul(&measured)))
}
