//! Lives: several drives of a robot, one after the other, of which each goes on from what those before it taught.

use super::map::MapFile;
use super::panel::Panel;
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
    /// Fields of the world, the robot and the sensors that are replaced, in place of those of the stretch before.
    #[serde(default)]
    #[garde(custom(of_a_cell), custom(of_the_world))]
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
    /// The fields that a drive has otherwise than the panel.
    pub fn world_of(&self, drive: u64) -> Fields {
        let stretch = self.life.iter().rfind(|stretch| stretch.from <= drive);
        stretch.map(|stretch| stretch.set.clone()).unwrap_or_default()
    }
}

/// What a model is and how it learns is the same all life long.
fn of_the_world(set: &Fields, _: &()) -> garde::Result {
    let parts = ["world.", "robot.", "sensors."];
    match set.keys().find(|field| !parts.iter().any(|part| field.starts_with(part))) {
        Some(field) => {
            Err(garde::Error::new(format!("{field}: expected fields of world, robot and sensors alone")))
        }
        None => Ok(()),
    }
}

/// Why there are no such lives; `None` of a map whose lives are good, or that has none.
pub fn what_is_wrong(map: &MapFile, seeds: &[Seed]) -> Option<String> {
    let last = map.across.over.len() as u64;
    if !map.across.is_of_drives() {
        let Panel { name, .. } = map.panels.iter().find(|panel| !panel.life.is_empty() || panel.alone)?;
        return Some(format!(
            "panel {name} has a life, or is alone: drives follow each other across {{ field: {DRIVE}, over: [1, 2, ..] }}"
        ));
    }
    if !map.across.over.iter().map(serde_json::Value::as_u64).eq((1..=last).map(Some)) {
        return Some(format!("across {DRIVE}: expected the numbers 1, 2, 3 and so on"));
    }
    for Panel { name, life, .. } in &map.panels {
        let starts = life.iter().map(|stretch| stretch.from);
        if life.first().is_none_or(|first| first.from != 1)
            || !starts.clone().is_sorted_by(|a, b| a < b)
            || starts.clone().any(|from| from > last)
        {
            return Some(format!(
                "panel {name}: expected the `life` of a map, whose stretches begin at drive 1 and at later ones up to {last}"
            ));
        }
    }
    let seed = seeds.iter().find(|seed| seed.0 >= LIVES)?;
    Some(format!(
        "seed {}: lives have seeds below {LIVES}, as those of their drives are made of them",
        seed.0
    ))
}
