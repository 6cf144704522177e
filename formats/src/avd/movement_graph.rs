//! Where each movement leads.

use super::annotations::Annotations;
use super::movement::Movement;
use std::collections::BTreeMap;

/// The steps that each step's movements lead to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MovementGraph {
    /// By step, then in the order of [`Movement::ALL`].
    moves: Vec<[Option<usize>; 6]>,
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
}
