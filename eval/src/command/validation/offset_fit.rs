//! The noise of boxes, and how they lie off their objects, by maximum marginal likelihood.
//!
//! Either coordinate of an object's offsets is `y ~ N(0, N + F F^T)`: `N` the white noise, and `F` the features of the azimuths times deviation and
//! angular size. The true poses are known, so that nothing else is unknown.

use super::boxes::SeenBox;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::fmt;
use vantage_slam::bearing_offset::BearingOffset;
use vantage_slam::noise::BearingNoise;

/// First and last step of the search, of logarithms.
const FIRST_STEP: f64 = 0.5;
const LAST_STEP: f64 = 0.01;
/// Deviations below it are none, box sides or over the focal length.
const LEAST_DEVIATION: f64 = 1e-5;
/// Length scales, radians.
const LENGTHS: [f64; 2] = [0.05, 20.0];
/// Smoothnesses.
const SMOOTHNESSES: [f64; 2] = [0.1, 10.0];

/// What fits some boxes best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetFit {
    /// What is white.
    pub noise: BearingNoise,
    /// What is smooth; none where all was taken for white.
    pub offset: Option<BearingOffset>,
    /// Log marginal likelihood, nats.
    pub log_likelihood: f64,
}

impl OffsetFit {
    /// All of the offset as white noise.
    pub fn white(by_object: &[Vec<SeenBox>]) -> Self {
        Self::best(by_object, vec![libm::log(0.001), libm::log(0.02)])
    }

    /// With a smooth part.
    pub fn smooth(by_object: &[Vec<SeenBox>]) -> Self {
        Self::best(by_object, [0.001, 0.01, 0.02, 0.02, 1.0, 1.5].map(libm::log).to_vec())
    }

    /// Compass search over the logarithms of deviations, length and smoothness.
    fn best(by_object: &[Vec<SeenBox>], mut at: Vec<f64>) -> Self {
        let mut best = Self::at(by_object, &at);
        let mut step = FIRST_STEP;
        while step > LAST_STEP {
            let before = best.log_likelihood;
            for number in 0..at.len() {
                for way in [step, -step] {
                    let mut moved = at.clone();
                    moved[number] += way;
                    let fit = Self::at(by_object, &moved);
                    if fit.log_likelihood > best.log_likelihood {
                        (best, at) = (fit, moved);
                        break;
                    }
                }
            }
            if best.log_likelihood <= before {
                step /= 2.0;
            }
        }
        best
    }

    fn at(by_object: &[Vec<SeenBox>], logarithms: &[f64]) -> Self {
        let deviation = |i: usize| libm::exp(logarithms[i]).clamp(LEAST_DEVIATION, 1.0);
        let noise = BearingNoise { fixed: deviation(0), proportional: deviation(1) };
        let offset = logarithms.get(4..6).map(|shape| BearingOffset {
            horizontal: deviation(2),
            vertical: deviation(3),
            length: libm::exp(shape[0]).clamp(LENGTHS[0], LENGTHS[1]),
            smoothness: libm::exp(shape[1]).clamp(SMOOTHNESSES[0], SMOOTHNESSES[1]),
        });
        let of_objects: Vec<f64> = by_object.par_iter().map(|seen| likelihood(seen, noise, offset)).collect();
        Self { noise, offset, log_likelihood: of_objects.iter().sum() }
    }
}

impl fmt::Display for OffsetFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let BearingNoise { fixed, proportional } = self.noise;
        write!(f, "bearing_noise: {{ fixed: {fixed:.5}, proportional: {proportional:.4} }}")?;
        if let Some(offset) = &self.offset {
            write!(f, ", {}", described(offset))?;
        }
        write!(f, ": log-likelihood {:.1}", self.log_likelihood)
    }
}

/// As a scene has it.
pub fn described(offset: &BearingOffset) -> String {
    let BearingOffset { horizontal, vertical, length, smoothness } = offset;
    format!(
        "bearing_offset: {{ horizontal: {horizontal:.4}, vertical: {vertical:.4}, length: {length:.2}, smoothness: {smoothness:.2} }}"
    )
}

/// Of one object's boxes, both coordinates.
fn likelihood(seen: &[SeenBox], noise: BearingNoise, offset: Option<BearingOffset>) -> f64 {
    let roots: Vec<f64> = seen.iter().map(|one| noise.sigma(one.angular_size)).collect();
    let white = roots.iter().map(|sigma| libm::log(2.0 * PI * sigma * sigma)).sum::<f64>();
    let whitened = |axis: usize| DVector::from_fn(seen.len(), |i, _| seen[i].offset[axis] / roots[i]);
    let Some(offset) = offset else {
        return -white - (0..2).map(|axis| whitened(axis).norm_squared()).sum::<f64>() / 2.0;
    };
    let harmonics = offset.harmonics();
    let mut features = DMatrix::zeros(seen.len(), harmonics.count());
    for (i, one) in seen.iter().enumerate() {
        let scaled = harmonics.at(one.direction).0 * (one.angular_size / roots[i]);
        features.row_mut(i).copy_from(&scaled.transpose());
    }
    let gram = features.tr_mul(&features);
    let of_axis = |(axis, deviation): (usize, f64)| {
        let y = whitened(axis);
        let information = DMatrix::identity(gram.nrows(), gram.nrows()) + &gram * (deviation * deviation);
        let Some(root) = information.cholesky() else { return f64::NEG_INFINITY };
        let projected = features.tr_mul(&y) * deviation;
        let explained = projected.dot(&root.solve(&projected));
        let log_determinant = 2.0 * root.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum::<f64>();
        -(white + log_determinant + y.norm_squared() - explained) / 2.0
    };
    [(0, offset.horizontal), (1, offset.vertical)].into_iter().map(of_axis).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector2;
    use vantage_dataset::Seed;

    fn drawn(noise: BearingNoise, offset: BearingOffset, objects: u64) -> Vec<Vec<SeenBox>> {
        let harmonics = offset.harmonics();
        let object = |index: u64| {
            let mut stream = Seed(index).stream("boxes", 0);
            let coefficients = [0; 2].map(|_| DVector::from_fn(harmonics.count(), |_, _| stream.normal()));
            let view = |i: usize| {
                let (angular_size, azimuth) = (stream.uniform(0.02, 0.2), 0.1 * i as f64);
                let direction = [libm::cos(azimuth), libm::sin(azimuth)];
                let phi = harmonics.at(direction).0;
                let smooth = [offset.horizontal, offset.vertical];
                let along = |axis: usize| angular_size * smooth[axis] * phi.dot(&coefficients[axis]);
                let white = Vector2::from_fn(|_, _| noise.sigma(angular_size) * stream.normal());
                SeenBox { direction, angular_size, offset: Vector2::new(along(0), along(1)) + white }
            };
            (0..40).map(view).collect()
        };
        (0..objects).map(object).collect()
    }

    #[test]
    fn what_boxes_were_drawn_from_is_found() {
        let noise = BearingNoise { fixed: 0.001, proportional: 0.01 };
        let offset = BearingOffset { horizontal: 0.02, vertical: 0.05, length: 0.6, smoothness: 2.0 };
        let boxes = drawn(noise, offset, 100);
        let fit = OffsetFit::smooth(&boxes);
        let found = fit.offset.unwrap();
        assert_relative_eq!(fit.noise.fixed, noise.fixed, max_relative = 0.1);
        assert_relative_eq!(fit.noise.proportional, noise.proportional, max_relative = 0.1);
        assert_relative_eq!(found.horizontal, offset.horizontal, max_relative = 0.1);
        assert_relative_eq!(found.vertical, offset.vertical, max_relative = 0.1);
        // Length and smoothness do for each other: it is the kernel that is told.
        let kernel = |offset: BearingOffset| {
            let harmonics = offset.harmonics();
            harmonics.at([1.0, 0.0]).0.dot(&harmonics.at([libm::cos(0.4), libm::sin(0.4)]).0)
        };
        assert_relative_eq!(kernel(found), kernel(offset), epsilon = 0.03);
        let white = OffsetFit::white(&boxes);
        assert_eq!(white.offset, None);
        assert!(white.log_likelihood < fit.log_likelihood - 1000.0);
        assert!((0.02..0.05).contains(&white.noise.proportional), "{white:?}");
    }

    #[test]
    fn the_likelihood_is_that_of_the_whole_covariance() {
        let noise = BearingNoise { fixed: 0.001, proportional: 0.01 };
        let offset = BearingOffset { horizontal: 0.02, vertical: 0.05, length: 0.6, smoothness: 2.0 };
        let seen = &drawn(noise, offset, 1)[0][..12];
        let kernel = |a: [f64; 2], b: [f64; 2]| offset.harmonics().at(a).0.dot(&offset.harmonics().at(b).0);
        let mut expected = 0.0;
        for (axis, deviation) in [(0, offset.horizontal), (1, offset.vertical)] {
            let covariance = DMatrix::from_fn(12, 12, |i, j| {
                let sizes = seen[i].angular_size * seen[j].angular_size;
                let smooth = deviation * deviation * sizes * kernel(seen[i].direction, seen[j].direction);
                smooth + if i == j { noise.sigma(seen[i].angular_size).powi(2) } else { 0.0 }
            });
            let y = DVector::from_fn(12, |i, _| seen[i].offset[axis]);
            let log_determinant = libm::log((covariance.clone() * 1e6).determinant()) - 12.0 * libm::log(1e6);
            let squared = y.dot(&covariance.cholesky().unwrap().solve(&y));
            expected -= (squared + log_determinant + 12.0 * libm::log(2.0 * PI)) / 2.0;
        }
        assert_relative_eq!(likelihood(seen, noise, Some(offset)), expected, max_relative = 1e-9);
    }
}
