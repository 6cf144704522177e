//! The posterior with the crops of objects: when their orientations are looked for, and how crops join.

use super::geometry::Geometry;
use super::orienting::{Oriented, Orienting};
use crate::estimate::Dropped;
use crate::graph::Graph;
use crate::incremental::Indefinite;
use crate::input::EstimateError;
use crate::mapping::robots;
use crate::orientation::{Budget, Mode};
use crate::problem::Problem;
use crate::semantics::{SemanticObject, Semantics};
use crate::settings::{OrientationSettings, SemanticSettings};
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use std::collections::{BTreeMap, VecDeque};
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
    pub posterior: Geometry<'m>,
    tracks: BTreeMap<usize, Track>,
    /// Objects whose orientation is to be looked for, in the order that they asked.
    due: VecDeque<usize>,
    orienting: Option<Orienting<'m>>,
    /// Second modes of the orientations found last, and by how many nats they are worse.
    second: BTreeMap<usize, (f64, Mode)>,
}

impl<'m> Crops<'m> {
    /// None yet, of a robot that reads them.
    pub fn new(reading: Reading<'m>) -> Self {
        let (tracks, due, second) = Default::default();
        Self { reading, posterior: Geometry::new(), tracks, due, orienting: None, second }
    }

    /// Takes in the last of an object's sightings.
    pub fn see(
        &mut self,
        problem: &Problem<'_>,
        number: usize,
        sightings: &[Sighting],
        dropped: &mut Dropped,
    ) -> Result<(), AnswerError> {
        self.posterior.see(problem, number, sightings);
        let track = self.tracks.entry(number).or_default();
        if let (Some(object), Some(sighting)) = (&mut track.semantic, sightings.last()) {
            let semantics = self.reading.semantics(problem);
            if let Some(view) = semantics.view(self.posterior.values(), object, sighting, dropped)? {
                let mut graph = Graph::default();
                graph.push(semantics.factor(object, &view));
                object.views.push(view);
                dropped.non_finite += self.posterior.smoother.add(graph, &Values::default());
            }
        }
        if self.posterior.has(number) && !track.is_due && sightings.len() >= 2 * track.searched_at {
            track.is_due = true;
            self.due.push_back(number);
        }
        Ok(())
    }

    /// Has the orientations of all objects looked for again.
    pub fn look_again(&mut self) {
        self.orienting = None;
        self.due = self.tracks.keys().copied().filter(|&track| self.posterior.has(track)).collect();
        self.tracks.values_mut().for_each(|track| track.is_due = true);
    }

    /// Goes on to look for orientations where `geometry` has the robot, of one object at a time among all that was seen of it, those first
    /// that have waited longest; false where nothing is to be done.
    pub fn orient(
        &mut self,
        problem: &Problem<'_>,
        sightings: &BTreeMap<usize, Vec<Sighting>>,
        geometry: &Values,
        dropped: &mut Dropped,
        mut budget: Budget,
    ) -> Result<bool, EstimateError> {
        let mut orienting = match self.orienting.take() {
            Some(orienting) => orienting,
            None => {
                let Some(number) = self.due.pop_front() else { return Ok(false) };
                let (Some(track), Some(seen)) = (self.tracks.get_mut(&number), sightings.get(&number)) else {
                    return Ok(true);
                };
                track.searched_at = seen.len();
                match Orienting::new(problem, number, seen, geometry) {
                    Some(orienting) => orienting,
                    None => {
                        track.is_due = false;
                        dropped.undefined_viewpoint += seen.len();
                        return Ok(true);
                    }
                }
            }
        };
        if !orienting.advance(problem, self.reading, dropped, &mut budget)? {
            self.orienting = Some(orienting);
            return Ok(true);
        }
        let number = orienting.track;
        let Some(seen) = sightings.get(&number) else { return Ok(true) };
        let searched = orienting.sightings();
        let found = orienting.found(self.posterior.values());
        self.tracks.entry(number).or_default().is_due = false;
        self.second.remove(&number);
        let Some(Oriented { mut object, best, second }) = found else { return Ok(true) };
        let semantics = self.reading.semantics(problem);
        let later = &seen[searched..];
        let mut values = robots(self.posterior.values(), later.iter().map(|sighting| sighting.step));
        values.insert(Key::Object(number), Value::Pose(best.world_from_object));
        for sighting in later {
            object.views.extend(semantics.view(&values, &object, sighting, dropped)?);
        }
        if let Some(second) = second {
            self.second.insert(number, (second.cost - best.cost, second));
        }
        dropped.non_finite += self.add(problem, &object, seen, best);
        self.tracks.entry(number).or_default().semantic = Some(object);
        Ok(true)
    }

    fn add(
        &mut self,
        problem: &Problem<'_>,
        object: &SemanticObject,
        seen: &[Sighting],
        mode: Mode,
    ) -> usize {
        let Mode { world_from_object, latent, .. } = mode;
        let (mut graph, mut first) = (Graph::default(), Values::default());
        let semantics = self.reading.semantics(problem);
        semantics.add_factors(&mut graph, object, &object.views, world_from_object.rotation);
        first.insert(Key::Latent(object.track), Value::Vector(latent));
        self.posterior.place(problem, object.track, seen, Value::Pose(world_from_object), (graph, first))
    }

    /// Settles, and tries the second modes of the most ambiguous objects, one at a time: what is lower is kept.
    pub fn settle(
        &mut self,
        problem: &Problem<'_>,
        sightings: &BTreeMap<usize, Vec<Sighting>>,
        (promise, steps): (f64, usize),
    ) -> Result<bool, Indefinite> {
        let mut is_settled = self.posterior.smoother.settle(promise, steps)?;
        let OrientationSettings { ambiguous_margin, alternatives, .. } = self.reading.orientation;
        let mut ambiguous: Vec<(usize, (f64, Mode))> = std::mem::take(&mut self.second).into_iter().collect();
        ambiguous.retain(|(_, (margin, _))| *margin < ambiguous_margin);
        ambiguous.sort_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
        for (number, (_, mut other)) in ambiguous.into_iter().take(alternatives) {
            let object = self.tracks.get(&number).and_then(|track| track.semantic.clone());
            let (Some(object), Some(seen), Some(first)) = (object, sightings.get(&number), self.mode(number))
            else {
                continue;
            };
            other.world_from_object.translation = first.world_from_object.translation;
            let before = self.posterior.smoother.cost();
            self.add(problem, &object, seen, other);
            is_settled = self.posterior.smoother.settle(promise, steps)?;
            let is_lower =
                self.posterior.smoother.cost().zip(before).is_some_and(|(now, before)| now < before);
            if !is_lower {
                self.add(problem, &object, seen, first);
                is_settled = self.posterior.smoother.settle(promise, steps)?;
            }
        }
        Ok(is_settled)
    }

    /// Where an object and its latent are.
    fn mode(&self, track: usize) -> Option<Mode> {
        let values = self.posterior.values();
        let world_from_object = *values.pose(Key::Object(track))?;
        Some(Mode { world_from_object, latent: values.vector(Key::Latent(track))?.clone(), cost: f64::NAN })
    }
}
