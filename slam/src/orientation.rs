//! First orientations: a grid of viewpoints scored by the decoder over an object's views, best modes refined.

use crate::graph::Graph;
use crate::semantics::{SemanticObject, SemanticView, Semantics, unless_non_finite};
use crate::settings::OrientationSettings;
use crate::sighting::Sighting;
use crate::solve::{Limits, Solution, solve};
use crate::variable::{Key, Value, Values};
use nalgebra::{DVector, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use vantage_dataset::Pose;
use vantage_model::{AnswerError, Information};

/// A few steps of the latent alone: the encoder reads a wrong latent from far views, and a good yaw would be
/// judged by it.
const RECONSIDERATION: Limits = Limits { iterations: 3, tolerance: 1e-3 };
/// Minima of the grid that are reconsidered, per mode that is refined.
const RECONSIDERED: usize = 3;
/// Enough to tell modes apart; the joint problem does the rest.
pub(crate) const REFINEMENT: Limits = Limits { iterations: 10, tolerance: 1e-4 };
/// Modes nearer than this many grid steps are one.
pub(crate) const DISTINCT_STEPS: f64 = 2.0;

/// One mode of an object's orientation.
#[derive(Clone, Debug)]
pub struct Mode {
    /// The object, refined with the robot held.
    pub world_from_object: Pose,
    /// Its latent.
    pub latent: DVector<f64>,
    /// Negative log-posterior given the robot's poses, nats up to a constant shared by an object's modes.
    pub cost: f64,
}

/// What may still be spent, in crops that are encoded: other work counts as what takes about as long.
#[derive(Clone, Copy, Debug)]
pub struct Budget(f64);

impl Budget {
    /// Of so many crops.
    pub fn new(crops: f64) -> Self {
        Self(crops)
    }

    /// Spends on something, unless all is spent already: the last thing may cost more than is left.
    pub fn spend(&mut self, crops: f64) -> bool {
        let is_left = self.0 > 0.0;
        self.0 -= crops;
        is_left
    }
}

/// Of an iteration of a solution, for each view, in crops that are encoded.
const ITERATION: f64 = 0.5;

/// The search for an object's distinct modes, which can be left and gone on with.
///
/// Each yaw of the grid gets the latent that the encoder reads from the views under it (the product of their
/// posteriors with the prior), and is scored by the graph's own cost of the object: bearings, priors and the
/// Student-t of every view. The best local minima over the circle are judged again after a few steps of the
/// latent, and the best of those are refined, object and latent together.
pub struct Search<'m> {
    settings: OrientationSettings,
    track: usize,
    views: Vec<SemanticView>,
    graph: Graph<'m>,
    /// The object's place, and what is held.
    known: Values,
    position: Vector3<f64>,
    grid: Vec<Option<(f64, Values)>>,
    /// Minima of the grid, once that is full, the best last.
    minima: Option<Vec<Values>>,
    reconsidered: Vec<Solution>,
    /// The best of these that are not refined yet, the best last.
    starts: Option<Vec<Values>>,
    modes: Vec<Mode>,
}

impl<'m> Search<'m> {
    /// Of an object that `values` have a place for, as they have the robot; `None` of one without.
    pub fn new(
        semantics: &Semantics<'_, 'm>,
        settings: &OrientationSettings,
        object: &SemanticObject,
        sightings: &[Sighting],
        values: &Values,
    ) -> Option<Self> {
        let track = object.track;
        let position = values.get(Key::Object(track))?.position()?;
        let views = spread(&object.views, settings.views);
        let mut graph = Graph::default();
        semantics.problem.add_bearings(&mut graph, track, sightings);
        semantics.add_factors(&mut graph, object, &views, UnitQuaternion::identity());
        let mut known = Values::default();
        for key in sightings.iter().map(|s| Key::Robot(s.step)).chain([Key::Offset(track), Key::Domain]) {
            if let Some(value) = values.get(key) {
                known.insert(key, value.clone());
            }
        }
        Some(Self {
            settings: *settings,
            track,
            views,
            graph,
            known,
            position,
            grid: Vec::new(),
            minima: None,
            reconsidered: Vec::new(),
            starts: None,
            modes: Vec::new(),
        })
    }

    /// Goes on within a budget; true once all is done.
    pub fn advance(
        &mut self,
        semantics: &Semantics<'_, 'm>,
        budget: &mut Budget,
    ) -> Result<bool, AnswerError> {
        let views = self.views.len() as f64;
        while self.grid.len() < self.settings.yaw_candidates {
            if !budget.spend(views) {
                return Ok(false);
            }
            let point = self.point(semantics, self.grid.len() as f64 * self.step())?;
            self.grid.push(point);
        }
        let refined_modes = self.settings.refined_modes;
        let minima = self.minima.get_or_insert_with(|| {
            let mut minima = local_minima(&self.grid);
            minima.truncate(RECONSIDERED * refined_modes);
            minima.reverse();
            minima
        });
        while let Some(start) = minima.pop() {
            if !budget.spend(RECONSIDERATION.iterations as f64 * ITERATION * views) {
                minima.push(start);
                return Ok(false);
            }
            let of_latent = |key| matches!(key, Key::Latent(_));
            self.reconsidered.push(solve(&self.graph, start, of_latent, RECONSIDERATION));
        }
        let starts = self.starts.get_or_insert_with(|| {
            self.reconsidered.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            let mut starts: Vec<Values> =
                self.reconsidered.drain(..).take(refined_modes).map(|solution| solution.values).collect();
            starts.reverse();
            starts
        });
        while let Some(start) = starts.pop() {
            if !budget.spend(REFINEMENT.iterations as f64 * ITERATION * views) {
                starts.push(start);
                return Ok(false);
            }
            let refined =
                solve(&self.graph, start, |key| !matches!(key, Key::Robot(_) | Key::Domain), REFINEMENT);
            let (object, latent) = (Key::Object(self.track), Key::Latent(self.track));
            if let (Some(pose), Some(latent)) = (refined.values.pose(object), refined.values.vector(latent)) {
                let (world_from_object, latent) = (*pose, latent.clone());
                self.modes.push(Mode { world_from_object, latent, cost: refined.cost });
            }
        }
        Ok(true)
    }

    /// The distinct modes, the best first; empty where the model answers none with finite numbers.
    pub fn modes(mut self) -> Vec<Mode> {
        self.modes.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let step = self.step();
        let mut distinct: Vec<Mode> = Vec::new();
        for mode in self.modes {
            let turn =
                |other: &Mode| other.world_from_object.rotation.angle_to(&mode.world_from_object.rotation);
            if distinct.iter().all(|other| turn(other) > DISTINCT_STEPS * step) {
                distinct.push(mode);
            }
        }
        distinct
    }

    /// Radians between the yaws of the grid.
    fn step(&self) -> f64 {
        2.0 * PI / self.settings.yaw_candidates as f64
    }

    /// Values and cost at a yaw; `None` where the model's answers are not finite.
    fn point(&self, semantics: &Semantics<'_, 'm>, yaw: f64) -> Result<Option<(f64, Values)>, AnswerError> {
        let Some(latent) = encode(semantics, &self.views, yaw)? else { return Ok(None) };
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        let mut start = self.known.clone();
        start.insert(Key::Object(self.track), Value::Pose(Pose::from_parts(self.position.into(), rotation)));
        start.insert(Key::Latent(self.track), Value::Vector(latent));
        Ok(self.graph.cost(&start).map(|cost| (cost, start)))
    }
}

/// An object's distinct modes by a whole [`Search`].
pub fn modes<'m>(
    semantics: &Semantics<'_, 'm>,
    settings: &OrientationSettings,
    object: &SemanticObject,
    sightings: &[Sighting],
    values: &Values,
) -> Result<Vec<Mode>, AnswerError> {
    let Some(mut search) = Search::new(semantics, settings, object, sightings, values) else {
        return Ok(Vec::new());
    };
    search.advance(semantics, &mut Budget::new(f64::INFINITY))?;
    Ok(search.modes())
}

/// The mean latent of the views if the object's yaw is `yaw`.
pub(crate) fn encode(
    semantics: &Semantics<'_, '_>,
    views: &[SemanticView],
    yaw: f64,
) -> Result<Option<DVector<f64>>, AnswerError> {
    let dim = semantics.model.latent_dim();
    let mut posteriors = Vec::with_capacity(views.len());
    for view in views {
        let crop = semantics.crop(&view.sighting);
        match unless_non_finite(semantics.model.encode(crop, &view.viewpoint.turned(-yaw)))? {
            Some(posterior) if posterior.is_valid(dim) => posteriors.push(posterior),
            _ => return Ok(None),
        }
    }
    let Information { precision, weighted_mean } = Information::of(dim, &posteriors);
    Ok(Some(precision.map(f64::recip).component_mul(&weighted_mean)))
}

/// At most `most` views, evenly spread over their order.
pub(crate) fn spread(views: &[SemanticView], most: usize) -> Vec<SemanticView> {
    if views.len() <= most {
        return views.to_vec();
    }
    (0..most).map(|i| views[(2 * i + 1) * views.len() / (2 * most)].clone()).collect()
}

/// The points of a circular grid that are lower than the one before and not higher than the one after, the
/// lowest first.
pub(crate) fn local_minima<T: Clone>(grid: &[Option<(f64, T)>]) -> Vec<T> {
    let cost = |index: usize| match &grid[index % grid.len()] {
        Some((cost, _)) => *cost,
        None => f64::INFINITY,
    };
    let mut minima: Vec<(f64, T)> = (0..grid.len())
        .filter(|&i| cost(i) < cost(i + grid.len() - 1) && cost(i) <= cost(i + 1))
        .filter_map(|i| grid[i].clone())
        .collect();
    if minima.is_empty() {
        minima.extend(grid.iter().flatten().next().cloned());
    }
    minima.sort_by(|a, b| a.0.total_cmp(&b.0));
    minima.into_iter().map(|(_, point)| point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minima_are_found_across_the_seam_and_sorted() {
        let grid = |costs: &[f64]| {
            let points = costs.iter().enumerate();
            points.map(|(i, &c)| c.is_finite().then_some((c, i))).collect::<Vec<_>>()
        };
        assert_eq!(local_minima(&grid(&[1.0, 2.0, 5.0, 0.5, 4.0, 3.0])), [3, 0]);
        assert_eq!(local_minima(&grid(&[2.0, 2.0, 2.0])), [0]);
        assert_eq!(local_minima(&grid(&[f64::NAN, 3.0, f64::NAN, 2.0])), [3, 1]);
        assert!(local_minima(&grid(&[f64::NAN; 4])).is_empty());
    }
}
