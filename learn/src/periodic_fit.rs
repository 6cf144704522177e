//! Deviations of most marginal likelihood, of processes over the azimuth.

use nalgebra::{DMatrix, DVector};
use vantage_model::Periodic;
use vantage_model::periodic::FEATURES;

const KAPPAS: [f64; 9] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
/// Deviations tried are a power of this, beside a component's root mean square.
const RATIO: f64 = 1.15;

/// What was measured of one object: azimuths, radians, and a row of numbers for each.
pub(crate) type Measured = (Vec<f64>, DMatrix<f64>);

/// Each component has deviations of its own, all share the kernel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PeriodicFit {
    /// Concentration of the kernel.
    pub(crate) kappa: f64,
    /// Standard deviation of each component over objects and azimuths.
    pub(crate) signal: Vec<f64>,
    /// Standard deviation of each component's noise.
    pub(crate) noise: Vec<f64>,
    /// Log marginal likelihood under Gaussian noise, nats.
    pub(crate) log_likelihood: f64,
}

/// The best of a grid for these objects, all with as many `components`; those without a view are left out.
pub(crate) fn fit(objects: &[Measured], components: usize) -> PeriodicFit {
    let fits = KAPPAS.map(|kappa| of_kappa(kappa, objects, components));
    fits.into_iter().max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood)).expect("there are several")
}

fn of_kappa(kappa: f64, objects: &[Measured], components: usize) -> PeriodicFit {
    let rotated: Vec<(DVector<f64>, DMatrix<f64>)> =
        objects.iter().filter_map(|object| diagonalised(kappa, object)).collect();
    let mut fitted = PeriodicFit {
        kappa,
        signal: vec![1.0; components],
        noise: vec![1.0; components],
        log_likelihood: 0.0,
    };
    for j in 0..components {
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
            fitted.log_likelihood += best;
        }
    }
    fitted
}

/// Eigenvalues of the kernel between an object's views, `[n]`, and the measurements along its eigenvectors, `[n x M]`.
fn diagonalised(kappa: f64, (azimuths, measured): &Measured) -> Option<(DVector<f64>, DMatrix<f64>)> {
    if azimuths.is_empty() {
        return None;
    }
    let functions = Periodic::new(kappa);
    let phi = DMatrix::from_fn(azimuths.len(), FEATURES, |i, k| functions.features(azimuths[i])[k]);
    let eigen = (&phi * phi.transpose()).symmetric_eigen();
    Some((eigen.eigenvalues.map(|x| x.max(0.0)), eigen.eigenvectors.tr_mul(measured)))
}
