//! Where each movement leads, and the pairs of crops that it links: `(z, z', Delta X)` of III-B.

use super::annotations::Annotations;
use super::movement::Movement;
use std::collections::BTreeMap;
use vantage_dataset::{Episode, Pose};

/// The steps that each step's movements lead to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MovementGraph {
    /// By step, then in the order of [`Movement::ALL`].
    moves: Vec<[Option<usize>; 6]>,
}

/// Two detections of one object that a movement links.
#[derive(Clone, Debug, PartialEq)]
pub struct MovementPair {
    /// What the robot does.
    pub movement: Movement,
    /// Index, among the episode's detections, of the one before it.
    pub before: usize,
    /// Index of the one after it.
    pub after: usize,
    /// `Delta X`: the robot after the movement, in its frame before it.
    pub robot_from_robot: Pose,
}

impl MovementGraph {
    /// The graph of these images, in the order of steps. Movements to other images are left out.
    pub(super) fn new(names: &[String], annotations: &Annotations) -> Self {
        let steps: BTreeMap<&str, usize> =
            names.iter().enumerate().map(|(i, name)| (name.as_str(), i)).collect();
        let moves = names.iter().map(|name| {
            let annotation = annotations.get(name);
            Movement::ALL.map(|movement| {
                annotation.and_then(|a| a.target(movement)).and_then(|target| steps.get(target).copied())
            })
        });
        Self { moves: moves.collect() }
    }

    /// The step that a movement leads to.
    pub fn after(&self, step: usize, movement: Movement) -> Option<usize> {
        self.moves.get(step)?[movement as usize]
    }

    /// Pairs of detections of one track that a movement links, by the step before it, then movement.
    pub fn pairs<'a>(
        &'a self,
        episode: &'a Episode,
        track: usize,
    ) -> impl Iterator<Item = MovementPair> + 'a {
        let detections = &episode.observations.detections;
        let at_step: BTreeMap<usize, usize> = detections
            .iter()
            .enumerate()
            .filter(|(_, detection)| detection.track == track)
            .map(|(index, detection)| (detection.step, index))
            .collect();
        let robots = &episode.truth.world_from_robot;
        let before: Vec<(usize, usize)> = at_step.iter().map(|(step, index)| (*step, *index)).collect();
        before.into_iter().flat_map(move |(step, index)| {
            let links = Movement::ALL.map(|movement| {
                let later = self.after(step, movement)?;
                let after = *at_step.get(&later)?;
                let robot_from_robot = robots[step].inv_mul(&robots[later]);
                Some(MovementPair { movement, before: index, after, robot_from_robot })
            });
            links.into_iter().flatten()
        })
    }
}
