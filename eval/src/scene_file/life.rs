//! Lives: several drives of a robot, one after the other, of which each goes on from what those before it taught.

use super::map::{MapFile, Panel};
use super::vary::{Axis, Fields, of_a_cell};
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vantage_dataset::Seed;

/// The field of an axis along which drives follow each other; no scene has it.
pub const DRIVE: &str = "drive";
/// Lives have seeds below this one, and their drives those above.
const LIVES: u64 = 1000;

/// Drives in one world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// The first of them, from 1 on.
    #[garde(range(min = 1))]
    pub from: u64,
    /// Fields of the scene that are replaced from then on.
    #[serde(default)]
    #[garde(custom(of_a_cell))]
    pub set: Fields,
}

/// The seed of a drive of the life with a seed.
pub fn drive_seed(life: Seed, drive: u64) -> Seed {
    Seed(LIVES * drive + life.0)
}

impl Axis {
    /// Whether its values are the drives of lives.
    pub fn is_of_drives(&self) -> bool {
        self.field == DRIVE
    }
}

impl Panel {
    /// The fields of the world of a drive, in place of those of the panel.
    pub fn world_of(&self, drive: u64) -> Fields {
        let stretch = self.life.iter().rfind(|stretch| stretch.from <= drive);
        stretch.map(|stretch| stretch.set.clone()).unwrap_or_default()
    }
}

/// Why a map's lives are none; nothing of a map without lives, or with good ones.
pub fn what_is_wrong(map: &MapFile, seeds: &[Seed]) -> Option<String> {
    let lives = || map.panels.iter().filter(|panel| !panel.life.is_empty());
    if !map.across.is_of_drives() {
        let lived = lives().next()?;
        let name = &lived.name;
        return Some(format!(
            "panel {name} has a life: drives follow each other across {{ field: {DRIVE}, over: [1, 2, ..] }}"
        ));
    }
    let drives = map.across.over.iter().map(serde_json::Value::as_u64);
    if !drives.eq((1..=map.across.over.len() as u64).map(Some)) {
        return Some(format!("across {DRIVE}: expected the numbers 1, 2, 3 and so on"));
    }
    for Panel { name, life, .. } in &map.panels {
        let starts = life.iter().map(|stretch| stretch.from);
        if life.first().is_none_or(|first| first.from != 1) || !starts.is_sorted_by(|a, b| a < b) {
            return Some(format!(
                "panel {name}: expected a life whose stretches begin at drive 1 and at later ones"
            ));
        }
    }
    let seed = seeds.iter().find(|seed| seed.0 >= LIVES)?;
    Some(format!(
        "seed {}: lives have seeds below {LIVES}, as those of their drives are made of them",
        seed.0
    ))
}
