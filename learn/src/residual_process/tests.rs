use super::*;
use crate::gaussian_process::{COMPONENTS, GaussianProcess};
use nalgebra::Vector3;
use vantage_dataset::Seed;

fn fitted() -> ResidualHyperparameters {
    let deviation = |j: usize| 0.5 + 0.1 * j as f64;
    ResidualHyperparameters {
        kappa: 2.0,
        signal: (0..COMPONENTS).map(deviation).collect(),
        noise: vec![0.8; COMPONENTS],
        degrees_of_freedom: 8.0,
    }
}

fn seen_from(azimuth: f64) -> Viewpoint {
    let direction = Vector3::new(azimuth.cos(), azimuth.sin(), 0.3).normalize();
    Viewpoint { direction, roll: 0.0, log_distance: 1.0 }
}

#[test]
fn derivatives_are_those_of_steps() {
    let process = ResidualProcess::new(GaussianProcess::fitted(), &fitted()).unwrap();
    let latent = DVector::from_fn(process.latent_dim(), |i, _| (1.3 * i as f64).sin());
    let (azimuth, step) = (0.8, 1e-6);
    let at = process.linearize(&latent, &seen_from(azimuth)).unwrap();
    assert!((&at.mean - process.predict(&latent, &seen_from(azimuth)).unwrap()).amax() < 1e-12);
    let ahead = process.predict(&latent, &seen_from(azimuth + step)).unwrap();
    let behind = process.predict(&latent, &seen_from(azimuth - step)).unwrap();
    let difference = (ahead - behind) / (2.0 * step);
    assert!((at.d_viewpoint.by_azimuth(&seen_from(azimuth)) - difference).amax() < 1e-6);
    for i in [0, 3, process.latent_dim() - 40, process.latent_dim() - 1] {
        let mut moved = latent.clone();
        moved[i] += 1e-3;
        let difference = (process.predict(&moved, &seen_from(azimuth)).unwrap() - &at.mean) / 1e-3;
        assert!((at.d_latent.column(i) - difference).amax() < 1e-9, "number {i}");
    }
}

#[test]
fn without_a_process_the_mean_is_the_model_s() {
    let process = ResidualProcess::new(GaussianProcess::fitted(), &fitted()).unwrap();
    let d = GaussianProcess::fitted().latent_dim();
    let latent = DVector::from_fn(process.latent_dim(), |i, _| if i < d { (i as f64).sin() } else { 0.0 });
    let alone = GaussianProcess::fitted().predict(&latent.rows(0, d).into_owned(), &seen_from(2.0)).unwrap();
    assert!((process.predict(&latent, &seen_from(2.0)).unwrap() - alone).amax() < 1e-12);
}

#[test]
fn the_fit_tells_what_an_object_keeps_from_what_each_view_has() {
    let mut stream = Seed(5).stream("residuals", 0);
    let functions = Periodic::new(2.0);
    let objects: Vec<Vec<(f64, DVector<f64>)>> = (0..40)
        .map(|_| {
            let b: Vec<f64> = (0..2 * FEATURES).map(|_| stream.normal()).collect();
            (0..12)
                .map(|_| {
                    let azimuth = stream.uniform(-3.0, 3.0);
                    let phi = functions.features(azimuth);
                    let kept = |j: usize| (0..FEATURES).map(|k| phi[k] * b[j * FEATURES + k]).sum::<f64>();
                    let residual = [0.9 * kept(0) + 0.3 * stream.normal(), 0.2 * kept(1) + stream.normal()];
                    (azimuth, DVector::from_column_slice(&residual))
                })
                .collect()
        })
        .collect();
    let found = ResidualHyperparameters::fit(&objects, 8.0).unwrap();
    assert!((1.0..=4.0).contains(&found.kappa), "{found:?}");
    assert!((found.signal[0] - 0.9).abs() < 0.2 && (found.noise[0] - 0.3).abs() < 0.05, "{found:?}");
    assert!(found.signal[1] < 0.6 && (found.noise[1] - 1.0).abs() < 0.15, "{found:?}");
    assert_eq!(ResidualHyperparameters::fit(&[Vec::new()], 8.0), None);
}

#[test]
fn corrections_of_a_size_are_so_many_deviations_of_the_model_s_noise() {
    let model = GaussianProcess::fitted();
    let process = ResidualProcess::new(model, &ResidualHyperparameters::of_size(2.0, model)).unwrap();
    let noise = model.noise().sqrt_information();
    assert!((process.noise().sqrt_information() - noise).amax() < 1e-12 * noise.amax());
    let (d, m) = (model.latent_dim(), model.measurement_dim());
    let at = process.linearize(&DVector::zeros(process.latent_dim()), &seen_from(0.8)).unwrap();
    let by_process = noise * at.d_latent.columns(d, process.latent_dim() - d);
    let covariance = &by_process * by_process.transpose();
    assert!((covariance - DMatrix::identity(m, m) * 4.0).amax() < 1e-9);
}

#[test]
fn deviations_of_another_number_are_refused() {
    let short = ResidualHyperparameters { signal: vec![1.0; 3], ..fitted() };
    assert!(ResidualProcess::new(GaussianProcess::fitted(), &short).is_err());
}
