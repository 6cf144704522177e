//! Where variables are, by their keys.

use crate::variable::Key;

const NONE: u32 = u32::MAX;

/// Numbers of variables by key, in tables that are copied at the speed of memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    tables: [Vec<u32>; 7],
}

impl Places {
    pub fn insert(&mut self, key: Key, variable: usize) {
        let (table, number) = row(key);
        let table = &mut self.tables[table];
        if table.len() <= number {
            table.resize(number + 1, NONE);
        }
        table[number] = u32::try_from(variable).unwrap_or(NONE);
    }

    pub fn get(&self, key: Key) -> Option<usize> {
        let (table, number) = row(key);
        self.tables[table]
            .get(number)
            .filter(|variable| **variable != NONE)
            .map(|variable| *variable as usize)
    }
}

fn row(key: Key) -> (usize, usize) {
    match key {
        Key::Robot(step) => (0, step),
        Key::Object(track) => (1, track),
        Key::Latent(track) => (2, track),
        Key::Landmark(landmark) => (3, landmark),
        Key::Extents(track) => (4, track),
        Key::Offset(track) => (5, track),
        Key::OdometryBias => (6, 0),
        Key::Domain => (7, 0),
    }
}
