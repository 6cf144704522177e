use super::*;
use nalgebra::Vector3;
use std::f64::consts::PI;

fn process() -> GaussianProcess {
    let signal = std::array::from_fn(|j| 0.1 + 0.01 * j as f64);
    GaussianProcess::new(Hyperparameters {
        kappa: 3.0,
        signal,
        noise: [0.01; COMPONENTS],
        degrees_of_freedom: 8.0,
    })
    .unwrap()
}

fn seen_from(azimuth: f64) -> Viewpoint {
    Viewpoint {
        direction: Vector3::new(azimuth.cos(), azimuth.sin(), 0.3).normalize(),
        roll: 0.0,
        log_distance: 1.0,
    }
}

/// An object of smooth looks: bright and dark patches that move, grow and shrink with the azimuth.
fn look(azimuth: f64) -> Crop {
    let mut crop = Crop::black();
    for (i, pixel) in crop.0.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        let (x, y) = ((i % 32) as f64 / 31.0 - 0.5, (i / 32) as f64 / 31.0 - 0.5);
        if x.hypot(y) > 0.45 + 0.05 * azimuth.sin() {
            continue;
        }
        let grey =
            120.0 + 60.0 * (4.0 * x - 2.0 * azimuth.cos()).sin() + 50.0 * (5.0 * y + azimuth.sin()).cos();
        *pixel = [grey, 0.7 * grey + 40.0 * (3.0 * x + azimuth).sin() + 45.0, 0.9 * grey]
            .map(|v| v.clamp(1.0, 255.0) as u8);
    }
    crop
}

/// The posterior mean of the coefficients given crops and azimuths.
fn posterior(process: &GaussianProcess, views: &[(Crop, f64)]) -> DVector<f64> {
    let d = process.latent_dim();
    let (mut precision, mut right) = (DMatrix::identity(d, d), DVector::zeros(d));
    for (crop, azimuth) in views {
        let at = process.linearize(&DVector::zeros(d), &seen_from(*azimuth)).unwrap();
        let whitening = process.noise().sqrt_information();
        let rows = whitening * at.d_latent;
        precision += rows.tr_mul(&rows);
        right += rows.tr_mul(&(whitening * process.measure(crop).unwrap()));
    }
    precision.cholesky().unwrap().solve(&right)
}

#[test]
fn derivatives_are_those_of_steps() {
    let process = process();
    let latent = DVector::from_fn(process.latent_dim(), |i, _| (1.7 * i as f64).sin());
    let (azimuth, step) = (0.8, 1e-6);
    let at = process.linearize(&latent, &seen_from(azimuth)).unwrap();
    assert!(at.is_valid(COMPONENTS, process.latent_dim()));
    assert!((&at.d_latent * &latent - &at.mean).amax() < 1e-12, "it is linear in the latent");
    let predicted = |azimuth| process.predict(&latent, &seen_from(azimuth)).unwrap();
    let difference = (predicted(azimuth + step) - predicted(azimuth - step)) / (2.0 * step);
    let analytic = at.d_viewpoint.by_azimuth(&seen_from(azimuth));
    assert!((difference - analytic).amax() < 1e-7);
}

#[test]
fn it_predicts_a_view_that_it_has_not_seen_and_finds_where_a_view_was_taken() {
    let process = process();
    let views: Vec<_> = (0..24).map(|i| f64::from(i) * PI / 12.0).map(|a| (look(a), a)).collect();
    let latent = posterior(&process, &views);
    for held_out in [0.2, 1.2, 2.5, 4.4] {
        let measured = process.measure(&look(held_out)).unwrap();
        let miss = |azimuth: f64| (process.predict(&latent, &seen_from(azimuth)).unwrap() - &measured).norm();
        assert!(
            miss(held_out) < 0.3 * measured.norm(),
            "{held_out}: {} of {}",
            miss(held_out),
            measured.norm()
        );
        let grid = (0..720).map(|i| f64::from(i) * PI / 360.0);
        let found = grid.min_by(|a, b| miss(*a).total_cmp(&miss(*b))).unwrap();
        assert!((found - held_out).abs() < 4f64.to_radians(), "{held_out}: {found}");
    }
}

#[test]
fn one_view_is_read_as_the_exact_posterior_reads_it() {
    let process = process();
    let (crop, azimuth) = (look(0.7), 2.0);
    let read = process.encode(&crop, &seen_from(azimuth)).unwrap();
    assert!(read.is_valid(process.latent_dim()));
    assert!((read.mean - posterior(&process, &[(crop, azimuth)])).amax() < 1e-9);
}

#[test]
fn a_black_crop_is_refused_and_so_is_noise_of_zero() {
    assert!(process().measure(&Crop::black()).is_err());
    let told = Hyperparameters {
        kappa: 1.0,
        signal: [1.0; COMPONENTS],
        noise: [0.0; COMPONENTS],
        degrees_of_freedom: 8.0,
    };
    assert!(GaussianProcess::new(told).is_err());
}

#[test]
fn the_fit_finds_the_noise_and_prefers_a_kernel_that_explains() {
    let azimuths: Vec<f64> = (0..30).map(|i| f64::from(i) * PI / 15.0).collect();
    let crops: Vec<Crop> = azimuths.iter().map(|&a| look(a)).collect();
    let object: Vec<_> = crops.iter().zip(azimuths.iter().copied()).collect();
    let shuffled: Vec<_> = crops.iter().zip(azimuths.iter().map(|a| a * 11.0)).collect();
    let (smooth, rough) = (Hyperparameters::fit(&[object]), Hyperparameters::fit(&[shuffled]));
    assert!(smooth.1 > rough.1, "{} {}", smooth.1, rough.1);
    // Grey across and grey down, which move with the azimuth; the silhouette of this object hardly does.
    for j in [0, 3] {
        let (noise, signal) = (smooth.0.noise[j], smooth.0.signal[j]);
        assert!(noise < 0.5 * signal, "component {j}: {noise} of {signal}");
    }
}
