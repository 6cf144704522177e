//! Likeness by class alone: what a discrete class model makes of crops, from whatever side they are.
//!
//! ```text
//! p(c | crops of a tracklet)  is proportional to  1/K sum_yaw  prod_i p(m(z_i) | c, x_i)^b      each of C classes as likely beforehand
//! p(crops | one object) / p(crops | each of another)  =  sum_c  1/C prod_t  C p(c | crops of t)
//! ```

use super::likeness::{Heading, Likeness};
use super::view::{log_mean, measured, views, yaws};
use crate::noise::Kernel;
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::Values;
use vantage_model::{AnswerError, ClassModel};

/// How far a class model is trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassedSettings {
    /// Most views of a tracklet that are read, spread over it.
    pub views: usize,
    /// Of what a view tells: `b`. Views of one tracklet err alike.
    pub exponent: f64,
}

impl Default for ClassedSettings {
    /// Fitted on pairs of tracklets of validation objects, in `sparse_loop`: see `docs/association.md`.
    fn default() -> Self {
        Self { views: 8, exponent: 0.2 }
    }
}

/// Likeness by a model of classes.
#[derive(Clone)]
pub struct Classed<M> {
    model: M,
    settings: ClassedSettings,
}

impl<M: ClassModel> Classed<M> {
    /// By this model.
    pub fn new(model: M, settings: ClassedSettings) -> Self {
        Self { model, settings }
    }
}

impl<M: ClassModel> Likeness for Classed<M> {
    /// `log C p(c | crops)` by class; none where no crop is read.
    type Reading = Option<Vec<f64>>;
    /// The same of all, and how many there are.
    type Sum = (Vec<f64>, usize);

    fn read(
        &self,
        problem: &Problem<'_>,
        values: &Values,
        sightings: &[Sighting],
    ) -> Result<Self::Reading, AnswerError> {
        let views = views(problem, values, sightings, self.settings.views);
        let measured = measured(views, |crop| self.model.measure(crop))?;
        if measured.is_empty() {
            return Ok(None);
        }
        let of_class = |class: usize| {
            let noise = self.model.noise(class);
            let kernel = Kernel::of_degrees_of_freedom(noise.degrees_of_freedom());
            let constant = noise.log_normalizer();
            let under = |yaw: f64| -> f64 {
                let each = measured.iter().map(|(view, measurement)| {
                    let (expected, _) = self.model.linearize(class, &view.viewpoint.turned(-yaw));
                    let off = noise.sqrt_information() * (measurement - expected);
                    constant - kernel.loss(off.norm_squared(), off.len())
                });
                self.settings.exponent * each.sum::<f64>()
            };
            log_mean(yaws().map(under))
        };
        let logs: Vec<f64> = (0..self.model.classes()).map(of_class).collect();
        let all = log_mean(logs.iter().copied());
        Ok(all.is_finite().then(|| logs.into_iter().map(|log| log - all).collect()))
    }

    fn add(&self, (sum, count): &mut Self::Sum, reading: &Self::Reading, _: Heading) {
        let Some(logs) = reading else { return };
        sum.resize(logs.len(), 0.0);
        sum.iter_mut().zip(logs).for_each(|(sum, log)| *sum += log);
        *count += 1;
    }

    fn log_ratio(&self, (sum, count): &Self::Sum) -> f64 {
        if *count < 2 { 0.0 } else { log_mean(sum.iter().copied()) }
    }
}
