//! The posterior with the crops of objects: when their orientations are looked for, and how crops join.

use super::growing_posterior::GrowingPosterior;
use super::orienting::{Oriented, Orienting};
use super::sighted::Sighted;
use crate::estimate::Dropped;
use crate::factor::Factor;
use crate::graph::Graph;
use crate::incremental::Indefinite;
use crate::mapping::robots;
use crate::orientation::{Budget, Mode};
use crate::problem::Problem;
use crate::semantics::{SemanticObject, SemanticView, Semantics};
use crate::settings::{OrientationSettings, SemanticSettings};
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use std::collections::{BTreeMap, VecDeque};
use vantage_dataset::Pose;
use vantage_model::{AnswerError, ObservationModel};

/// How crops are read.
#[derive(Clone, Copy)]
pub struct Reading<'m> {
    /// By what.
    pub model: &'m dyn ObservationModel,
    /// How far it is trusted.
    pub semantics: SemanticSettings,
    /// How first orientations are looked for.
    pub orientation: OrientationSettings,
}

impl<'m> Reading<'m> {
    fn semantics<'a>(&self, problem: &Problem<'a>) -> Semantics<'a, 'm> {
        Semantics { problem: *problem, model: self.model, settings: self.semantics, domain: None }
    }
}

/// What is known of an object's crops.
#[derive(Default)]
struct Track {
    semantic: Option<SemanticObject>,
    /// The second mode of its orientation, and by how many nats it is worse.
    second: Option<(f64, Mode)>,
    /// Sightings when its orientation was last looked for.
    searched_at: usize,
    /// Whether its orientation is to be looked for.
    is_due: bool,
}

/// The posterior of geometry and crops.
///
/// Orientations are looked for where geometry alone has the robot, and by the sizes that it tells, as those of a whole episode are.
pub(super) struct Crops<'m> {
    reading: Reading<'m>,
    pub posterior: GrowingPosterior<'m>,
    tracks: BTreeMap<usize, Track>,
    /// Objects whose orientation is to be looked for, in the order that they asked.
    due: VecDeque<usize>,
    orienting: Option<Orienting<'m>>,
}

impl<'m> Crops<'m> {
    /// None yet, of a robot that reads them.
    pub fn new(reading: Reading<'m>) -> Self {
        let (tracks, due) = Default::default();
        Self { reading, posterior: GrowingPosterior::new(), tracks, due, orienting: None }
    }

    /// Takes in the last of an object's sightings; its orientation is looked for once `geometry` has a place for it too.
    pub fn see(
        &mut self,
        problem: &Problem<'_>,
        number: usize,
        sightings: &[Sighting],
        geometry: &GrowingPosterior<'_>,
    ) -> Result<(), AnswerError> {
        self.posterior.see(problem, number, sightings);
        let track = self.tracks.entry(number).or_default();
        if let (Some(object), Some(sighting)) = (&mut track.semantic, sightings.last()) {
            let semantics = self.reading.semantics(problem);
            if let Some(view) =
                semantics.view(self.posterior.values(), object, sighting, &mut Dropped::default())?
            {
                let mut graph = Graph::default();
                graph.push(semantics.factor(object, &view));
                if self.posterior.smoother.add(graph, &Values::default()) == 0 {
                    object.views.push(view);
                }
            }
        }
        let is_placed = self.posterior.has(number) && geometry.has(number);
        if is_placed && !track.is_due && sightings.len() >= 2 * track.searched_at {
            track.is_due = true;
            self.due.push_back(number);
        }
        Ok(())
    }

    /// Goes on to look for orientations where `geometry` has the robot, of one object at a time among all that was seen of it, those first
    /// that have waited longest; false where nothing is to be done.
    pub fn orient(
        &mut self,
        problem: &Problem<'_>,
        sightings: &BTreeMap<usize, Vec<Sighting>>,
        geometry: &GrowingPosterior<'_>,
        mut budget: Budget,
    ) -> Result<bool, AnswerError> {
        let mut orienting = match self.orienting.take() {
            Some(orienting) => orienting,
            None => {
                let Some(number) = self.due.pop_front() else { return Ok(false) };
                let Some(seen) = sightings.get(&number) else { return Ok(true) };
                let track = self.tracks.entry(number).or_default();
                (track.searched_at, track.is_due) = (seen.len(), false);
                let Some(orienting) = Orienting::new(problem, number, seen, geometry.values()) else {
                    self.leave(problem, number, seen);
                    return Ok(true);
                };
                orienting
            }
        };
        if !orienting.advance(problem, self.reading, &mut budget)? {
            self.orienting = Some(orienting);
            return Ok(true);
        }
        let (number, searched) = (orienting.track, orienting.sightings());
        let Some(seen) = sightings.get(&number) else { return Ok(true) };
        match orienting.found(self.posterior.values()) {
            Some(found) => self.join(problem, found, (seen, searched))?,
            None => self.leave(problem, number, seen),
        }
        Ok(true)
    }

    /// Has an object be a centre, without crops.
    fn leave(&mut self, problem: &Problem<'_>, number: usize, seen: &[Sighting]) {
        let track = self.tracks.entry(number).or_default();
        track.second = None;
        if track.semantic.take().is_none() {
            return;
        }
        if let Some(center) = self.posterior.values().get(Key::Object(number)).and_then(Value::position) {
            let no_more = (Graph::default(), Values::default());
            self.posterior.place(problem, number, seen, Value::Point(center), no_more);
        }
    }

    /// Has the crops of an object join, those also that were seen since it was `searched`, where their factors are defined.
    fn join(
        &mut self,
        problem: &Problem<'_>,
        Oriented { mut object, best, second }: Oriented,
        (seen, searched): (&[Sighting], usize),
    ) -> Result<(), AnswerError> {
        let number = object.track;
        let semantics = self.reading.semantics(problem);
        let mut values = robots(self.posterior.values(), seen.iter().map(|sighting| sighting.step));
        values.insert(Key::Object(number), Value::Pose(best.world_from_object));
        values.insert(Key::Latent(number), Value::Vector(best.latent.clone()));
        for sighting in &seen[searched..] {
            object.views.extend(semantics.view(&values, &object, sighting, &mut Dropped::default())?);
        }
        let views = std::mem::take(&mut object.views);
        let is_defined = |view: &SemanticView| semantics.factor(&object, view).linearize(&values).is_some();
        let views: Vec<SemanticView> = views.into_iter().filter(is_defined).collect();
        object.views = views;
        if object.views.is_empty() {
            self.leave(problem, number, seen);
            return Ok(());
        }
        let (mut graph, mut first) = (Graph::default(), Values::default());
        semantics.add_factors(&mut graph, &object, &object.views, best.world_from_object.rotation);
        first.insert(Key::Latent(number), Value::Vector(best.latent));
        self.posterior.place(problem, number, seen, Value::Pose(best.world_from_object), (graph, first));
        let track = self.tracks.entry(number).or_default();
        track.second = second.map(|second| (second.cost - best.cost, second));
        track.semantic = Some(object);
        Ok(())
    }

    /// From where `geometry` has all: looks for all orientations among all that was seen, goes to the maximum, and tries the second modes of
    /// the most ambiguous objects there, one at a time. What is lower is kept.
    pub fn settle(
        &mut self,
        problem: &Problem<'_>,
        sighted: &Sighted,
        geometry: &GrowingPosterior<'_>,
        (promise, iterations): (f64, usize),
    ) -> Result<Result<bool, Indefinite>, AnswerError> {
        let there = |(key, value): (Key, &Value)| match (self.posterior.values().pose(key), value) {
            (Some(own), Value::Point(center)) => {
                (key, Value::Pose(Pose::from_parts((*center).into(), own.rotation)))
            }
            _ => (key, value.clone()),
        };
        let there: Vec<(Key, Value)> = geometry.values().iter().map(there).collect();
        self.posterior.smoother.move_to(there);
        self.orienting = None;
        let sightings = &sighted.objects;
        self.due = sightings.keys().copied().filter(|&track| geometry.has(track)).collect();
        for (&number, seen) in sightings.iter().filter(|(track, _)| geometry.has(**track)) {
            let center = geometry.values().get(Key::Object(number)).and_then(Value::position);
            if let (false, Some(center)) = (self.posterior.has(number), center) {
                let no_more = (Graph::default(), Values::default());
                self.posterior.place(problem, number, seen, Value::Point(center), no_more);
            }
        }
        self.posterior.place_more(problem, sighted);
        while self.orient(problem, sightings, geometry, Budget::new(f64::INFINITY))? {}
        Ok(self.settle_modes(promise, iterations))
    }

    fn settle_modes(&mut self, promise: f64, iterations: usize) -> Result<bool, Indefinite> {
        let smoother = &mut self.posterior.smoother;
        let mut is_settled = smoother.settle(promise, iterations)?;
        let OrientationSettings { ambiguous_margin, alternatives, .. } = self.reading.orientation;
        let second = |(&number, track): (&usize, &mut Track)| Some((number, track.second.take()?));
        let mut ambiguous: Vec<(usize, (f64, Mode))> = self.tracks.iter_mut().filter_map(second).collect();
        ambiguous.retain(|(_, (margin, _))| *margin < ambiguous_margin);
        ambiguous.sort_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
        for (number, (_, mode)) in ambiguous.into_iter().take(alternatives) {
            let Some(object) = smoother.values().pose(Key::Object(number)) else { continue };
            let other = Pose::from_parts(object.translation, mode.world_from_object.rotation);
            let values = [
                (Key::Object(number), Value::Pose(other)),
                (Key::Latent(number), Value::Vector(mode.latent)),
            ];
            is_settled = smoother.try_settle(values, promise, iterations)?;
        }
        Ok(is_settled)
    }
}
