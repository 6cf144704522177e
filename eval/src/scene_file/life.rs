//! Lives: several drives of a robot, one after the other, of which each goes on from what those before it taught.

use super::map::MapFile;
use super::panel::Panel;
use super::vary::{Axis, Fields, of_a_cell};
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
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
    let wrong =
        |Panel { name, life, .. }: &Panel| Some(format!("panel {name}: {}", wrong_stretch(life, last)?));
    if let Some(reason) = map.panels.iter().find_map(wrong) {
        return Some(reason);
    }
    let seed = seeds.iter().find(|seed| seed.0 >= LIVES)?;
    Some(format!(
        "seed {}: lives have seeds below {LIVES}, as those of their drives are made of them",
        seed.0
    ))
}

/// What is wrong with the stretches of a life of so many drives.
fn wrong_stretch(life: &[Stretch], drives: u64) -> Option<String> {
    let Some(first) = life.first() else {
        return Some("it has no `life`: expected stretches, the first of them `from: 1`".to_owned());
    };
    if first.from != 1 {
        return Some(format!(
            "the first stretch is from drive {}: expected it to begin at drive 1",
            first.from
        ));
    }
    if let Some(Stretch { from, .. }) = life.iter().find(|stretch| stretch.from > drives) {
        return Some(format!("a stretch is from drive {from}: expected drives up to {drives}"));
    }
    let late = life.windows(2).find(|pair| pair[0].from >= pair[1].from)?;
    let [before, after] = [late[0].from, late[1].from];
    Some(format!("a stretch from drive {after} follows one from drive {before}: expected a later one"))
}

/// Refuses drives that do not follow each other.
pub fn drives_follow(field: &str) -> impl FnOnce(&Vec<Value>, &()) -> garde::Result {
    move |over, ()| {
        let follow = over.iter().map(Value::as_u64).eq((1..=over.len() as u64).map(Some));
        match follow || field != DRIVE {
            true => Ok(()),
            false => {
                Err(garde::Error::new("expected the numbers 1, 2, 3 and so on of drives, without a gap"))
            }
        }
    }
}
