//! The search for one object's orientation, in pieces: a step does no more of it than it has time for.

use super::crops::Reading;
use crate::estimate::Dropped;
use crate::orientation::{Budget, Mode, Search};
use crate::problem::Problem;
use crate::semantics::{SemanticObject, Semantics};
use crate::sighting::Sighting;
use crate::variable::{Key, Values};
use nalgebra::UnitQuaternion;
use vantage_dataset::Pose;
use vantage_model::AnswerError;

/// Of measuring a crop, in crops that are encoded.
const MEASUREMENT: f64 = 2.0;

/// One object, as geometry had it when the search began.
pub(super) struct Orienting<'m> {
    pub track: usize,
    sightings: Vec<Sighting>,
    held: Values,
    object: SemanticObject,
    /// Sightings whose crops were measured.
    measured: usize,
    search: Option<Search<'m>>,
}

/// What a search found.
pub(super) struct Oriented {
    pub object: SemanticObject,
    pub best: Mode,
    pub second: Option<Mode>,
}

impl<'m> Orienting<'m> {
    /// Of an object with all that was seen of it so far; `None` where its size is not known.
    pub fn new(problem: &Problem<'_>, track: usize, sightings: &[Sighting], values: &Values) -> Option<Self> {
        let size = problem.object_size(values, track, sightings)?;
        let mut held = Values::default();
        let keys = [Key::Object(track), Key::Offset(track)];
        for key in sightings.iter().map(|sighting| Key::Robot(sighting.step)).chain(keys) {
            if let Some(value) = values.get(key) {
                held.insert(key, value.clone());
            }
        }
        let object = SemanticObject { track, size, views: Vec::new() };
        Some(Self { track, sightings: sightings.to_vec(), held, object, measured: 0, search: None })
    }

    /// Sightings that it searches by.
    pub fn sightings(&self) -> usize {
        self.sightings.len()
    }

    /// Goes on within a budget; true once all is done.
    pub fn advance(
        &mut self,
        problem: &Problem<'_>,
        Reading { model, semantics: settings, orientation }: Reading<'m>,
        budget: &mut Budget,
    ) -> Result<bool, AnswerError> {
        let semantics = Semantics { problem: *problem, model, settings, domain: None };
        while let Some(sighting) = self.sightings.get(self.measured) {
            if !budget.spend(MEASUREMENT) {
                return Ok(false);
            }
            self.measured += 1;
            let view = semantics.view(&self.held, &self.object, sighting, &mut Dropped::default())?;
            self.object.views.extend(view);
        }
        if self.object.views.is_empty() {
            return Ok(true);
        }
        if self.search.is_none() {
            self.search = Search::new(&semantics, &orientation, &self.object, &self.sightings, &self.held);
        }
        match &mut self.search {
            Some(search) => search.advance(&semantics, budget),
            None => Ok(true),
        }
    }

    /// The best modes, carried along with the robot's pose at the last sighting since the search began; `None` where there is none.
    pub fn found(self, values: &Values) -> Option<Oriented> {
        let robot = Key::Robot(self.sightings.last()?.step);
        let moved = match (self.held.pose(robot), values.pose(robot)) {
            (Some(then), Some(now)) => now * then.inverse(),
            _ => Pose::identity(),
        };
        let carry = |mode: Mode| {
            let Pose { rotation, translation } = moved * mode.world_from_object;
            let rotation = UnitQuaternion::new_normalize(rotation.into_inner());
            Mode { world_from_object: Pose::from_parts(translation, rotation), ..mode }
        };
        let mut modes = self.search?.modes().into_iter().map(carry);
        Some(Oriented { object: self.object, best: modes.next()?, second: modes.next() })
    }
}
