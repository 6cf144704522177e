//! How well an azimuth is told of an object that was seen from a few known viewpoints, under another light.
//!
//! The known views are the first of the object's even sessions, the queries the first of its odd
//! sessions; of an object with one session both are drawn at random. The object's frame is free:
//! a model that has a frame of its own for objects is given the yaw whose known views it finds most likely.

mod azimuth_posterior;
mod object_posterior;
mod residuals;

pub use azimuth_posterior::AzimuthPosterior;
pub use object_posterior::ObjectPosterior;
pub use residuals::{FITTED_TO, residuals};

use super::embedding::Scores;
use super::viewpoint::{ViewpointTrial, summarize};
use crate::result::metric::Metric;
use crate::result::statistics::quantile;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use vantage_dataset::views::InstanceRecord;
use vantage_dataset::{Crop, Seed, Symmetry, View, ViewSet, Viewpoint};
use vantage_model::{AnswerError, ObservationModel};

/// Yaws that are tried where a model has a frame of its own, and how many of them are followed to their most probable latent.
const YAWS: usize = 24;
const FOLLOWED: usize = 3;
/// Most queries of an object.
const QUERIES: usize = 4;
/// What likelihoods may count by.
const SCALES: [f64; 10] = [0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0];
/// Most objects that decide by what likelihoods count.
pub const CALIBRATING: usize = 64;
/// The share of the probability that a region promises.
const PROMISED: f64 = 0.95;
/// Bounds of the angle to the nearest known view, degrees.
const NEAR: [f64; 3] = [15.0, 30.0, 60.0];

/// The metrics of a table.
pub const METRICS: [Metric; 9] = [
    Metric::ViewpointMedian,
    Metric::ViewpointP90,
    Metric::ViewpointRight,
    Metric::ViewpointWithin60,
    Metric::AzimuthInside95,
    Metric::ViewpointMedianNear15,
    Metric::ViewpointMedianNear30,
    Metric::ViewpointMedianNear60,
    Metric::ViewpointMedianFar,
];

/// One query.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownViewTrial {
    /// The azimuth that was found, in the frame of the view set.
    pub viewpoint: ViewpointTrial,
    /// Whether the region of 95% holds the true azimuth.
    pub inside: bool,
    /// Angle between the query's azimuth and the nearest of the known views, radians.
    pub nearest: f64,
}

/// A view whose azimuth is asked, and the object's known views.
pub struct Asked<'a> {
    /// The view.
    pub view: &'a View,
    seen: Vec<&'a View>,
}

impl<'a> Asked<'a> {
    /// The known view nearest to an azimuth.
    pub fn nearest(&self, azimuth: f64) -> Option<&'a View> {
        let off = |view: &View| angle(view.viewpoint.azimuth(), azimuth);
        self.seen.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

/// The queries of all objects, in the order of their [trials](known_view_trials).
pub fn asked(set: &ViewSet, known: usize) -> Vec<Asked<'_>> {
    let of_instance = |instance: usize| {
        let (seen, asked) = known_and_asked(set, instance, known);
        let asked = if seen.len() < known { Vec::new() } else { asked };
        asked.into_iter().take(QUERIES).map(move |view| Asked { view, seen: seen.clone() })
    };
    (0..set.instances.len()).flat_map(of_instance).collect()
}

/// A query and what was told of it.
struct Query {
    instance: usize,
    azimuth: f64,
    nearest: f64,
    told: Option<AzimuthPosterior>,
}

/// All queries of objects with `known` known views or more, by a model. `free_yaw` says that the model has a frame of its own; its
/// likelihoods count by `scale`; `done` is told of each object.
pub fn known_view_trials(
    set: &ViewSet,
    known: usize,
    model: &dyn ObservationModel,
    free_yaw: bool,
    scale: f64,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<KnownViewTrial>, AnswerError> {
    let trial = |Query { instance, azimuth, nearest, told }| {
        let InstanceRecord { family, symmetry, .. } = &set.instances[instance];
        KnownViewTrial {
            inside: told.as_ref().is_some_and(|told| told.holds(azimuth, *symmetry, PROMISED, scale)),
            viewpoint: ViewpointTrial {
                family: family.clone(),
                symmetry: *symmetry,
                azimuth,
                found: told.map(|told| told.most_likely()),
            },
            nearest,
        }
    };
    Ok(queries(set, known, model, free_yaw, done)?.into_iter().map(trial).collect())
}

/// By what likelihoods should count for the true azimuths of these objects to be most probable: the best of a
/// grid; the first [`CALIBRATING`] objects are asked, and `done` is told of each.
pub fn information_scale(
    set: &ViewSet,
    known: usize,
    model: &dyn ObservationModel,
    free_yaw: bool,
    done: &(dyn Fn() + Sync),
) -> Result<f64, AnswerError> {
    let mut first = set.clone();
    first.instances.truncate(CALIBRATING);
    first.views.retain(|view| view.instance < CALIBRATING);
    let queries = queries(&first, known, model, free_yaw, done)?;
    let told = |scale: f64| -> f64 {
        let of_query = |query: &Query| {
            let symmetry = first.instances[query.instance].symmetry;
            if symmetry == Symmetry::Revolution {
                return None;
            }
            Some(query.told.as_ref()?.log_probability(query.azimuth, symmetry, scale))
        };
        queries.iter().filter_map(of_query).sum()
    };
    let best = SCALES.into_iter().map(|scale| (told(scale), scale)).max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map_or(1.0, |(_, scale)| scale))
}

fn queries(
    set: &ViewSet,
    known: usize,
    model: &dyn ObservationModel,
    free_yaw: bool,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Query>, AnswerError> {
    let of_instance = |instance: usize| -> Result<Vec<Query>, AnswerError> {
        let (seen, asked) = known_and_asked(set, instance, known);
        if seen.len() < known {
            return Ok(Vec::new());
        }
        let (object, yaw) = posterior(model, &seen, free_yaw)?;
        let of_view = |view: &View| {
            let measurement = finite(model.measure(&view.crop))?;
            let azimuth = view.viewpoint.azimuth();
            let likelihood = |candidate: f64| {
                let turned = view.viewpoint.turned(candidate - azimuth + yaw);
                object.as_ref()?.log_density(measurement.as_ref()?, &turned)
            };
            let nearest =
                seen.iter().map(|other| angle(azimuth, other.viewpoint.azimuth())).fold(PI, f64::min);
            Ok(Query { instance, azimuth, nearest, told: AzimuthPosterior::new(likelihood) })
        };
        asked.into_iter().take(QUERIES).map(of_view).collect()
    };
    let all: Result<Vec<Vec<Query>>, AnswerError> = (0..set.instances.len())
        .into_par_iter()
        .map(|instance| of_instance(instance).inspect(|_| done()))
        .collect();
    Ok(all?.into_iter().flatten().collect())
}

/// The known views of an instance and the others: those of even sessions and of odd ones; where it has one session alone, in random order.
fn known_and_asked(set: &ViewSet, instance: usize, known: usize) -> (Vec<&View>, Vec<&View>) {
    let mut own: Vec<&View> = set.views.iter().filter(|view| view.instance == instance).collect();
    if own.windows(2).all(|two| two[0].session == two[1].session) {
        Seed(0).stream("known views", instance as u64).shuffle(&mut own);
        let asked = own.split_off(known.min(own.len()));
        return (own, asked);
    }
    let (even, odd): (Vec<&View>, Vec<&View>) = own.into_iter().partition(|view| view.session % 2 == 0);
    (even.into_iter().take(known).collect(), odd)
}

/// The object's posterior, and by how much its views are turned for it.
fn posterior<'m>(
    model: &'m dyn ObservationModel,
    seen: &[&View],
    free_yaw: bool,
) -> Result<(Option<ObjectPosterior<'m>>, f64), AnswerError> {
    let turned = |yaw: f64| -> Vec<(&Crop, Viewpoint)> {
        seen.iter().map(|view| (&view.crop, view.viewpoint.turned(yaw))).collect()
    };
    if !free_yaw {
        return Ok((ObjectPosterior::new(model, &turned(0.0))?, 0.0));
    }
    let mut yaws = Vec::with_capacity(YAWS);
    for i in 0..YAWS {
        let yaw = 2.0 * PI * i as f64 / YAWS as f64;
        yaws.extend(ObjectPosterior::first_cost(model, &turned(yaw))?.map(|cost| (cost, yaw)));
    }
    yaws.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<(ObjectPosterior<'m>, f64)> = None;
    for &(_, yaw) in yaws.iter().take(FOLLOWED) {
        let Some(found) = ObjectPosterior::new(model, &turned(yaw))? else { continue };
        if best.as_ref().is_none_or(|(best, _)| found.cost() < best.cost()) {
            best = Some((found, yaw));
        }
    }
    Ok(best.map_or((None, 0.0), |(found, yaw)| (Some(found), yaw)))
}

/// `None` where the answer is not finite, which costs a view and not the run.
fn finite<T>(answer: Result<T, AnswerError>) -> Result<Option<T>, AnswerError> {
    match answer {
        Err(AnswerError::NonFinite { .. }) => Ok(None),
        answer => answer.map(Some),
    }
}

fn angle(a: f64, b: f64) -> f64 {
    libm::atan2(libm::sin(a - b), libm::cos(a - b)).abs()
}

/// The scores of trials; surfaces of revolution, which have no azimuth, are left out.
pub fn known_view_scores(trials: &[KnownViewTrial]) -> Scores {
    let trials: Vec<(&KnownViewTrial, f64)> =
        trials.iter().filter_map(|trial| Some((trial, trial.viewpoint.error()?))).collect();
    let mut scores = Scores::new();
    let Some(shape) = summarize(trials.iter().map(|(trial, _)| &trial.viewpoint)).model else {
        return scores;
    };
    let share = |held: &dyn Fn(&KnownViewTrial, f64) -> bool| {
        trials.iter().filter(|(trial, error)| held(trial, *error)).count() as f64 / trials.len() as f64
    };
    scores.insert(Metric::ViewpointMedian, shape.median);
    scores.insert(Metric::ViewpointP90, shape.p90);
    scores.insert(Metric::ViewpointRight, shape.right);
    scores.insert(Metric::ViewpointWithin60, share(&|_, error| error < PI / 3.0));
    scores.insert(Metric::AzimuthInside95, share(&|trial, _| trial.inside));
    let [near, less, little] = NEAR.map(f64::to_radians);
    let median = |low: f64, high: f64| {
        let mut errors: Vec<f64> = trials
            .iter()
            .filter(|(trial, _)| (low..high).contains(&trial.nearest))
            .map(|(_, error)| *error)
            .collect();
        errors.sort_by(f64::total_cmp);
        quantile(&errors, 0.5)
    };
    let medians = [
        (Metric::ViewpointMedianNear15, median(0.0, near)),
        (Metric::ViewpointMedianNear30, median(near, less)),
        (Metric::ViewpointMedianNear60, median(less, little)),
        (Metric::ViewpointMedianFar, median(little, f64::INFINITY)),
    ];
    scores.extend(medians.into_iter().filter_map(|(metric, value)| Some((metric, value?))));
    scores
}

#[cfg(test)]
mod tests;
