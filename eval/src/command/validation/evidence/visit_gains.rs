//! A discrepancy of an object and one of each visit to it, with covariances by expectation maximization.
//!
//! ```text
//! off(azimuth) = phi(azimuth)^T (b + c_visit),   b_h ~ N(0, v_h I),   c_h ~ N(0, w_h I)   of the harmonics h
//! ```
//!
//! A visit is a run of whole views without a longer gap: what light or place make of an object is alike in it, and differs between visits.
//! `b` is taken at the azimuth that `c` has turned, a difference of second order.
//! The M-step sets each variance to the mean square of its coefficients under the E-step's Gaussians (Dempster, Laird and Rubin 1977).

use super::{Alone, Evidence, Predicted, TrueViews, ViewNoise};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use vantage_model::periodic::{FEATURES, HARMONICS};
use vantage_model::{Linearization, MeasurementNoise, ObservationModel, Periodic};
use vantage_slam::AzimuthDiscrepancy;
use vantage_slam::discrepancy::Discrepant;

/// Steps without a whole view between two visits, at least.
const AWAY: usize = 10;
/// Rounds of expectation maximization.
const ROUNDS: usize = 30;

/// What a fit of covariances gains.
pub struct VisitGains {
    /// Nats a view more probable than without a discrepancy of azimuths.
    pub gain: f64,
    /// Deviations of each harmonic, from the constant on, under any azimuth, degrees: of an object, and of a visit to it.
    pub deviations_deg: [[f64; HARMONICS + 1]; 2],
    /// Visits an object, mean.
    pub visits: f64,
}

/// A variance a harmonic, of an object's coefficients and of a visit's.
#[derive(Clone, Copy)]
struct Variances {
    object: [f64; HARMONICS + 1],
    /// `None`: there is no discrepancy of visits.
    visit: Option<[f64; HARMONICS + 1]>,
}

impl Variances {
    fn of(&self, is_visit: bool) -> [f64; HARMONICS + 1] {
        if is_visit { self.visit.unwrap_or(self.object) } else { self.object }
    }
}

/// A model with the discrepancies of an object and of its visits. The latent is the model's, then `b`, then `c` of each visit.
struct Visited<'m> {
    /// Its latent is the model's, then `b`, then, where there is one of visits, `c` of one visit.
    model: &'m dyn ObservationModel,
    /// Length of what all views share.
    shared: usize,
    variances: Variances,
}

impl Visited<'_> {
    fn visits(&self, object: &TrueViews) -> usize {
        self.variances.visit.map_or(0, |_| visits(object))
    }
}

/// The visit that a view belongs to.
fn visit(object: &TrueViews, index: usize) -> usize {
    object.views[..=index].windows(2).filter(|pair| pair[1].step - pair[0].step > AWAY).count()
}

fn visits(object: &TrueViews) -> usize {
    visit(object, object.len() - 1) + 1
}

/// The harmonic that a feature is of.
fn harmonic(feature: usize) -> usize {
    feature.div_ceil(2)
}

impl Predicted for Visited<'_> {
    fn prior_precision(&self, object: &TrueViews) -> DVector<f64> {
        let mut precision = DVector::from_element(self.shared + FEATURES * self.visits(object), 1.0);
        let first = self.shared - FEATURES;
        for (feature, value) in precision.rows_range_mut(first..).iter_mut().enumerate() {
            *value = 1.0 / self.variances.of(feature >= FEATURES)[harmonic(feature % FEATURES)];
        }
        precision
    }

    fn at(
        &self,
        object: &TrueViews,
        index: usize,
        latent: &DVector<f64>,
    ) -> Option<(Linearization, &MeasurementNoise)> {
        let viewpoint = &object.views[index].viewpoint;
        if self.variances.visit.is_none() {
            return Some((self.model.linearize(latent, viewpoint).ok()?, self.model.noise()));
        }
        let of_visit = self.shared + FEATURES * visit(object, index);
        let mut own = latent.rows(0, self.shared + FEATURES).into_owned();
        own.rows_mut(self.shared, FEATURES).copy_from(&latent.rows(of_visit, FEATURES));
        let near = self.model.linearize(&own, viewpoint).ok()?;
        let mut d_latent = DMatrix::zeros(near.mean.len(), latent.len());
        d_latent.columns_mut(0, self.shared).copy_from(&near.d_latent.columns(0, self.shared));
        d_latent.columns_mut(of_visit, FEATURES).copy_from(&near.d_latent.columns(self.shared, FEATURES));
        Some((Linearization { d_latent, ..near }, self.model.noise()))
    }
}

impl VisitGains {
    /// Fits of the object's discrepancy alone, and of both, from one of such a deviation and smoothness and, of visits, half of it.
    /// `None` where the model has no finite answer.
    pub fn of(
        objects: &[TrueViews],
        model: &dyn ObservationModel,
        start: &AzimuthDiscrepancy,
    ) -> Option<[Self; 2]> {
        let unit = AzimuthDiscrepancy { sigma: 1.0, ..*start };
        let of_object = Discrepant::new(model, &unit);
        let of_visit = Discrepant::new(&of_object, &unit);
        let shared = of_object.latent_dim();
        let none: f64 = objects
            .par_iter()
            .map(|object| Some(object.evidence(&Alone(model), ViewNoise::NONE)?.value))
            .sum::<Option<f64>>()?;
        let variance = start.sigma.powi(2);
        let object = [variance; HARMONICS + 1];
        let alone = Visited { model: &of_object, shared, variances: Variances { object, visit: None } };
        let visit = Some([variance / 4.0; HARMONICS + 1]);
        let both = Visited { model: &of_visit, shared, variances: Variances { object, visit } };
        let amplitudes = Periodic::new(start.concentration).features(0.0);
        let deviations_deg = |variances: [f64; HARMONICS + 1]| -> [f64; HARMONICS + 1] {
            let of = |h: usize| variances[h].sqrt() * amplitudes[(2 * h).saturating_sub(1)];
            std::array::from_fn(|h| of(h).to_degrees())
        };
        let views: usize = objects.iter().map(TrueViews::len).sum();
        let all: usize = objects.iter().map(visits).sum();
        let fit = |start: Visited<'_>| -> Option<Self> {
            let (variances, evidence) = fitted(objects, start)?;
            Some(Self {
                gain: (evidence - none) / views as f64,
                deviations_deg: [
                    deviations_deg(variances.object),
                    variances.visit.map_or([0.0; HARMONICS + 1], deviations_deg),
                ],
                visits: all as f64 / objects.len() as f64,
            })
        };
        Some([fit(alone)?, fit(both)?])
    }
}

/// Expectation maximization; the variances, and the log-evidence under them.
fn fitted(objects: &[TrueViews], mut of: Visited<'_>) -> Option<(Variances, f64)> {
    let mut latents: Vec<Option<DVector<f64>>> = vec![None; objects.len()];
    let mut expect = |of: &Visited<'_>| -> Option<(Vec<Evidence>, f64)> {
        let one = |(object, latent): (&TrueViews, &Option<DVector<f64>>)| {
            let precision = of.prior_precision(object);
            let start = match latent {
                Some(latent) => latent.clone(),
                None => object.encoded.clone().resize_vertically(precision.len(), 0.0),
            };
            object.evidence_from(start, &precision, of, ViewNoise::NONE)
        };
        let all: Vec<Evidence> = objects.par_iter().zip(&latents).map(one).collect::<Option<_>>()?;
        latents = all.iter().map(|evidence| Some(evidence.latent.clone())).collect();
        let sum = all.iter().map(|evidence| evidence.value).sum();
        Some((all, sum))
    };
    for _ in 0..ROUNDS {
        let (all, _) = expect(&of)?;
        let mut squares = [[(0.0, 0.0); HARMONICS + 1]; 2];
        for Evidence { latent, hessian, .. } in &all {
            let covariance = hessian.inverse();
            for at in of.shared - FEATURES..latent.len() {
                let feature = at + FEATURES - of.shared;
                let (sum, count) =
                    &mut squares[usize::from(feature >= FEATURES)][harmonic(feature % FEATURES)];
                *sum += latent[at].powi(2) + covariance[(at, at)];
                *count += 1.0;
            }
        }
        let [object, visit] = squares.map(|of_harmonics| of_harmonics.map(|(sum, count)| sum / count));
        of.variances = Variances { object, visit: of.variances.visit.map(|_| visit) };
    }
    let (_, evidence) = expect(&of)?;
    Some((of.variances, evidence))
}

#[cfg(test)]
mod tests {
    use super::super::TrueView;
    use super::*;
    use nalgebra::Vector3;
    use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS as VIEWPOINT_HARMONICS};
    use vantage_dataset::{Crop, Seed, Stream, Viewpoint};
    use vantage_model::{AnswerError, LatentGaussian, ViewpointDerivative};

    /// Measures where it stands, off by a thousandth.
    struct Compass(MeasurementNoise);

    impl ObservationModel for Compass {
        fn latent_dim(&self) -> usize {
            1
        }

        fn noise(&self) -> &MeasurementNoise {
            &self.0
        }

        fn measure(&self, _: &Crop) -> Result<DVector<f64>, AnswerError> {
            unreachable!("views are measured already")
        }

        fn encode(&self, _: &Crop, _: &Viewpoint) -> Result<LatentGaussian, AnswerError> {
            unreachable!("views are measured already")
        }

        fn predict(&self, _: &DVector<f64>, viewpoint: &Viewpoint) -> Result<DVector<f64>, AnswerError> {
            let (sin, cos) = viewpoint.azimuth().sin_cos();
            Ok(DVector::from_vec(vec![cos, sin]))
        }

        fn linearize(
            &self,
            latent: &DVector<f64>,
            viewpoint: &Viewpoint,
        ) -> Result<Linearization, AnswerError> {
            let mean = self.predict(latent, viewpoint)?;
            let by_azimuth = DVector::from_vec(vec![-mean[1], mean[0]]);
            let upright = DMatrix::zeros(2, CONDITIONING - 2 * VIEWPOINT_HARMONICS);
            let d_viewpoint = ViewpointDerivative::by_azimuth_and_upright(viewpoint, &by_azimuth, &upright);
            Ok(Linearization { mean, d_latent: DMatrix::zeros(2, 1), d_viewpoint })
        }
    }

    const SMOOTH: AzimuthDiscrepancy = AzimuthDiscrepancy { sigma: 1.0, concentration: 4.0 };

    /// Objects that are visited three times, with a discrepancy of the object and one of each visit of so many degrees.
    fn objects(model: &Compass, [of_object, of_visit]: [f64; 2], stream: &mut Stream) -> Vec<TrueViews> {
        let discrepant = Discrepant::new(model, &SMOOTH);
        let mut noise = Seed(7).stream("compass", 0);
        let mut object = || {
            let mut draw = |degrees: f64| -> [f64; FEATURES] {
                std::array::from_fn(|_| degrees.to_radians() * stream.normal())
            };
            let shared = draw(of_object);
            let mut views = Vec::new();
            for visit in 0..3usize {
                let own = draw(of_visit);
                let off = std::iter::once(0.0).chain(shared.iter().zip(own).map(|(b, c)| b + c));
                let latent = DVector::from_iterator(1 + FEATURES, off);
                for view in 0..16usize {
                    let azimuth = 0.39 * view as f64;
                    let direction = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
                    let viewpoint = Viewpoint { direction, roll: 0.0, log_distance: 1.0 };
                    let mean = discrepant.predict(&latent, &viewpoint).unwrap();
                    let measurement = mean.map(|x| x + 0.001 * noise.normal());
                    let step = 100 * visit + view;
                    views.push(TrueView { step, measurement, viewpoint });
                }
            }
            TrueViews { views, encoded: DVector::zeros(1) }
        };
        (0..60).map(|_| object()).collect()
    }

    #[test]
    fn expectation_maximization_finds_what_is_of_the_object_and_what_of_its_visits() {
        let noise = MeasurementNoise::new(DMatrix::identity(2, 2) * 1000.0, 1e6).unwrap();
        let model = Compass(noise);
        let mut stream = Seed(1).stream("discrepancies", 0);
        let total = |deviations: [f64; HARMONICS + 1]| deviations.iter().map(|x| x * x).sum::<f64>().sqrt();
        let start = AzimuthDiscrepancy { sigma: 4f64.to_radians(), ..SMOOTH };
        let [alone, both] =
            VisitGains::of(&objects(&model, [3.0, 1.5], &mut stream), &model, &start).unwrap();
        let [object, visit] = both.deviations_deg.map(total);
        assert!((object - 3.0).abs() < 0.5 && (visit - 1.5).abs() < 0.2, "{object}, {visit}");
        assert_eq!(both.visits, 3.0);
        assert!(both.gain > alone.gain + 1.0, "{} and {}", both.gain, alone.gain);
        let [alone, both] =
            VisitGains::of(&objects(&model, [3.0, 0.0], &mut stream), &model, &start).unwrap();
        let visit = total(both.deviations_deg[1]);
        assert!(visit < 0.2 && (total(alone.deviations_deg[0]) - 3.0).abs() < 0.4, "{visit}");
    }
}
