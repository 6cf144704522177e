//! The null hypothesis of an object, that its model does not know the thing, and how probable its views are under either.
//!
//! ```text
//! y_k = W m(z_k) = mean + sum_h [cos h a_k, sin h a_k] c_h + eps_k,   y_1 .. y_n together a Student t of the model's degrees of freedom
//! ```
//!
//! The object looks different from different sides, and that is all. `a_k` is the azimuth in the world: there is neither orientation nor
//! latent. Mean, spectrum over the harmonics `h`, and what is white are the moments of the model's own predictions of random objects, seen
//! as high and as far off as this one: the null expects what the model expects, but for the shapes that it knows.

use crate::graph::Graph;
use crate::laplace::log_evidence_of_all;
use crate::noise::Kernel;
use crate::semantics::{SemanticObject, SemanticView, Semantics};
use crate::settings::SemanticSettings;
use crate::variable::{Key, Values};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::f64::consts::PI;
use vantage_dataset::{Seed, Viewpoint};
use vantage_model::periodic::{FEATURES, HARMONICS};
use vantage_model::{ObservationModel, student_t};

/// Objects drawn from the prior of the latent.
const OBJECTS: usize = 48;
/// Azimuths at which each is predicted, evenly spaced.
const AZIMUTHS: usize = 24;

/// The second moments of the whitened measurements of an object that a model does not know.
pub struct UnknownObject {
    /// Along each principal axis of the whitened measurement.
    mean: DVector<f64>,
    /// From a measurement to the axes.
    axes_by_whitening: DMatrix<f64>,
    /// Along each axis, the deviation of the coefficients of each harmonic.
    spectrum: Vec<[f64; HARMONICS + 1]>,
    /// Along each axis, the variance of what is white.
    white: Vec<f64>,
    degrees_of_freedom: f64,
}

impl UnknownObject {
    /// By the predictions of `model`, its spread multiplied by `noise_scale`, from such viewpoints under all azimuths; `None` where one
    /// is not finite, and of no viewpoints.
    pub fn of(model: &dyn ObservationModel, viewpoints: &[Viewpoint], noise_scale: f64) -> Option<Self> {
        let whiten = model.noise().sqrt_information() / noise_scale;
        let objects = 0..OBJECTS as u64;
        let curves: Vec<_> = objects.map(|i| curve(model, &whiten, viewpoints, i)).collect::<Option<_>>()?;
        let columns = || curves.iter().flat_map(|curve| curve.column_iter());
        let (m, count) = (whiten.nrows(), (OBJECTS * AZIMUTHS) as f64);
        let mean = columns().fold(DVector::zeros(m), |sum, y| sum + y) / count;
        let mut covariance = DMatrix::zeros(m, m);
        columns().for_each(|y| covariance.ger(1.0 / count, &(y - &mean), &(y - &mean), 1.0));
        if !covariance.iter().all(|x: &f64| x.is_finite()) {
            return None;
        }
        let axes = SymmetricEigen::new(covariance).eigenvectors;
        let mean = axes.tr_mul(&mean);
        let mut spectrum = vec![[0.0; HARMONICS + 1]; m];
        let mut white = vec![1.0; m];
        for curve in &curves {
            let mut along = axes.tr_mul(curve);
            along.column_iter_mut().for_each(|mut y| y -= &mean);
            for (axis, deviations) in spectrum.iter_mut().enumerate() {
                let powers = powers(along.row(axis).iter());
                let rest = along.row(axis).norm_squared() / AZIMUTHS as f64 - powers.iter().sum::<f64>();
                white[axis] += rest.max(0.0) / OBJECTS as f64;
                deviations.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power / OBJECTS as f64);
            }
        }
        spectrum.iter_mut().flatten().for_each(|power| *power = power.sqrt());
        let degrees_of_freedom = model.noise().degrees_of_freedom();
        Some(Self { mean, axes_by_whitening: axes.tr_mul(&whiten), spectrum, white, degrees_of_freedom })
    }

    /// `log p(y_1 .. y_n)`, nats, of measurements `m(z)` and the azimuths, radians, from which they were taken.
    pub fn log_likelihood(&self, views: &[(&DVector<f64>, f64)]) -> Option<f64> {
        let (n, m) = (views.len(), self.mean.len());
        let along = |(measured, _): &(&DVector<f64>, f64)| &self.axes_by_whitening * *measured - &self.mean;
        let along: Vec<DVector<f64>> = views.iter().map(along).collect();
        let (mut s, mut log_det) = (0.0, 0.0);
        for (axis, (spectrum, white)) in self.spectrum.iter().zip(&self.white).enumerate() {
            let root = white.sqrt();
            let y = DVector::from_fn(n, |k, _| along[k][axis] / root);
            let mut features = DMatrix::zeros(n, FEATURES);
            for (k, (_, azimuth)) in views.iter().enumerate() {
                features[(k, 0)] = spectrum[0] / root;
                for h in 1..=HARMONICS {
                    let (sin, cos) = libm::sincos(h as f64 * azimuth);
                    features[(k, 2 * h - 1)] = spectrum[h] * cos / root;
                    features[(k, 2 * h)] = spectrum[h] * sin / root;
                }
            }
            let information = DMatrix::identity(FEATURES, FEATURES) + features.tr_mul(&features);
            let factor = information.cholesky()?;
            let projected = features.tr_mul(&y);
            s += y.norm_squared() - projected.dot(&factor.solve(&projected));
            log_det += 2.0 * factor.l_dirty().diagonal().iter().map(|x| libm::log(*x)).sum::<f64>()
                + 2.0 * n as f64 * libm::log(root);
        }
        let dim = n * m;
        let likelihood = student_t::log_normalizer(dim, self.degrees_of_freedom)
            - log_det / 2.0
            - Kernel::of_degrees_of_freedom(self.degrees_of_freedom).loss(s, dim);
        likelihood.is_finite().then_some(likelihood)
    }
}

/// What geometry alone makes of an episode.
pub struct Geometry {
    /// Its maximum.
    pub values: Values,
    /// [`log_evidence_of_all`], nats.
    pub log_evidence: f64,
}

/// `log p(all | the model knows the object) - log p(all | it does not)`, nats, where `graph` holds the factors of geometry and those of
/// this object's crops, and `values` its maximum; `None` where either is not defined, as by a model whose predictions are not finite.
///
/// Both integrate over all variables by Laplace's method, the robot's too, about the values that the solver came to. Azimuths of the null
/// hypothesis are held where geometry alone has them, which favours the model where geometry is loose.
pub fn log_odds(
    semantics: &Semantics<'_, '_>,
    object: &SemanticObject,
    (graph, values): (&Graph<'_>, &Values),
    geometry: &Geometry,
) -> Option<f64> {
    let SemanticSettings { information_scale, .. } = semantics.settings;
    let known = log_evidence_of_all(graph, values)? + log_normalizers(semantics, object, values)?;
    let null = log_null(semantics, object, &geometry.values)?;
    Some(known - geometry.log_evidence - information_scale * null)
}

/// What the cost leaves out of the densities of views, and of the priors of the variables that come with them.
fn log_normalizers(semantics: &Semantics<'_, '_>, object: &SemanticObject, values: &Values) -> Option<f64> {
    let SemanticSettings { tilt_sigma, information_scale, .. } = semantics.settings;
    let noise = semantics.model.noise();
    let of_view = student_t::log_normalizer(noise.dimension(), noise.degrees_of_freedom());
    let latent = values.vector(Key::Latent(object.track))?.len() as f64;
    let of_latent = -latent / 2.0 * libm::log(2.0 * PI);
    // Of the tilt, and of a yaw that may be any.
    let of_orientation = -libm::log(2.0 * PI * tilt_sigma * tilt_sigma) - libm::log(2.0 * PI);
    Some(of_latent + of_orientation + information_scale * object.views.len() as f64 * of_view)
}

/// `log p(y_1 .. y_n)` of an object's views under the null hypothesis, the robot and the object where `values` have them.
fn log_null(semantics: &Semantics<'_, '_>, object: &SemanticObject, values: &Values) -> Option<f64> {
    let position = values.get(Key::Object(object.track))?.position()?;
    let azimuth = |view: &SemanticView| {
        let world_from_camera = semantics.problem.world_from_camera(values, view.sighting.step)?;
        let direction = world_from_camera.translation.vector - position;
        Some(libm::atan2(direction.y, direction.x))
    };
    let views = object.views.iter().map(|view| Some((&view.measurement, azimuth(view)?)));
    let views: Vec<_> = views.collect::<Option<_>>()?;
    let viewpoints: Vec<Viewpoint> = object.views.iter().map(|view| view.viewpoint).collect();
    UnknownObject::of(semantics.model, &viewpoints, semantics.settings.noise_scale)?.log_likelihood(&views)
}

/// The whitened predictions of the random object `index` at evenly spaced azimuths, `[M x AZIMUTHS]`.
fn curve(
    model: &dyn ObservationModel,
    whiten: &DMatrix<f64>,
    viewpoints: &[Viewpoint],
    index: u64,
) -> Option<DMatrix<f64>> {
    let mut stream = Seed(0).stream("unknown object", index);
    let latent = DVector::from_fn(model.latent_dim(), |_, _| stream.normal());
    let mut curve = DMatrix::zeros(whiten.nrows(), AZIMUTHS);
    for (j, mut column) in curve.column_iter_mut().enumerate() {
        let view = viewpoints.get(stream.below(viewpoints.len().max(1)))?;
        let azimuth = 2.0 * PI * j as f64 / AZIMUTHS as f64;
        let predicted = model.predict(&latent, &view.turned(azimuth - view.azimuth())).ok()?;
        column.copy_from(&(whiten * Some(predicted).filter(|p| p.len() == whiten.ncols())?));
    }
    Some(curve)
}

/// The variance that each harmonic of a curve at evenly spaced azimuths has at any of them.
fn powers<'a>(curve: impl Iterator<Item = &'a f64> + Clone) -> [f64; HARMONICS + 1] {
    std::array::from_fn(|h| {
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (j, y) in curve.clone().enumerate() {
            let (sin, cos) = libm::sincos(2.0 * PI * (h * j) as f64 / AZIMUTHS as f64);
            cosine += cos * y;
            sine += sin * y;
        }
        let square = (cosine * cosine + sine * sine) / (AZIMUTHS * AZIMUTHS) as f64;
        if h == 0 { square } else { 2.0 * square }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_likelihood_is_that_of_the_whole_covariance() {
        let spectrum = vec![[0.5, 1.0, 0.3, 0.0, 0.2, 0.1, 0.4], [1.5, 0.2, 0.9, 0.3, 0.0, 0.0, 0.1]];
        let white = vec![1.0, 1.7];
        for nu in [5.0, f64::INFINITY] {
            let null = UnknownObject {
                mean: DVector::from_vec(vec![0.3, -0.2]),
                axes_by_whitening: DMatrix::from_row_slice(2, 2, &[0.8, 0.6, -0.6, 0.8]),
                spectrum: spectrum.clone(),
                white: white.clone(),
                degrees_of_freedom: nu,
            };
            let views: Vec<(DVector<f64>, f64)> = (0..5)
                .map(|k| (DVector::from_fn(2, |i, _| libm::sin((k * 3 + i) as f64)), 0.4 * k as f64))
                .collect();
            let (mut s, mut log_det) = (0.0, 0.0);
            for (axis, (deviations, own)) in spectrum.iter().zip(&white).enumerate() {
                let y =
                    DVector::from_fn(5, |k, _| (&null.axes_by_whitening * &views[k].0 - &null.mean)[axis]);
                let covariance = DMatrix::from_fn(5, 5, |k, l| {
                    let apart = views[k].1 - views[l].1;
                    let smooth =
                        |(h, deviation): (usize, &f64)| deviation * deviation * libm::cos(h as f64 * apart);
                    let smooth: f64 = deviations.iter().enumerate().map(smooth).sum();
                    smooth + if k == l { *own } else { 0.0 }
                });
                log_det += libm::log(covariance.determinant());
                s += y.dot(&covariance.cholesky().unwrap().solve(&y));
            }
            let expected = match nu.is_finite() {
                true => student_t::log_density(s, 10, nu, -log_det / 2.0),
                false => -(10.0 * libm::log(2.0 * PI) + log_det + s) / 2.0,
            };
            let lent: Vec<_> = views.iter().map(|(m, azimuth)| (m, *azimuth)).collect();
            assert_relative_eq!(null.log_likelihood(&lent).unwrap(), expected, max_relative = 1e-12);
        }
    }

    #[test]
    fn powers_are_the_variances_of_harmonics() {
        let at = |j: usize| 2.0 * PI * j as f64 / AZIMUTHS as f64;
        let curve: Vec<f64> =
            (0..AZIMUTHS).map(|j| 0.5 + 2.0 * libm::cos(at(j)) - 3.0 * libm::sin(4.0 * at(j))).collect();
        let expected = [0.25, 2.0, 0.0, 0.0, 4.5, 0.0, 0.0];
        for (got, expected) in powers(curve.iter()).into_iter().zip(expected) {
            assert_relative_eq!(got, expected, epsilon = 1e-12);
        }
    }
}
