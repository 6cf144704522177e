//! Fields of a scene set otherwise: one field over several values, and a scene with some fields replaced.

use super::life::drives_follow;
use super::{SceneFile, is_file_name};
use crate::exit::Ends;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::PathBuf;
use thiserror::Error;

/// Fields by their path, such as `robot.path.circle.radius`, with what each is set to; `null` leaves an optional field out.
pub type Fields = Map<String, Value>;

/// One field over several values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// The field, by its path in the scene: `robot.path.circle.radius`.
    #[garde(custom(is_field_of_a_cell))]
    pub field: String,
    /// Its values, in the order of tables and figures; `null` leaves an optional field out.
    #[garde(length(min = 1, max = 50), custom(all_different), custom(drives_follow(&self.field)))]
    pub over: Vec<Value>,
}

impl Axis {
    /// The last part of the field's path.
    pub fn label(&self) -> &str {
        self.field.rsplit('.').next().unwrap_or(&self.field)
    }

    /// The field at one of its values.
    pub fn at(&self, value: &Value) -> Fields {
        Fields::from_iter([(self.field.clone(), value.clone())])
    }
}

/// A value as tables and figures print it.
pub fn told(value: &Value) -> String {
    match value {
        Value::Null => "none".to_owned(),
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}

/// Fields that a scene cannot have.
#[derive(Debug, Error)]
#[error("{}: {what}: {reason}", path.display())]
pub struct VaryError {
    /// The file that sets them.
    pub path: PathBuf,
    /// Where in it: a panel, or a value of a field.
    pub what: String,
    /// Why not.
    pub reason: String,
}

impl Ends for VaryError {}

/// The scene with fields replaced, checked as a whole; or why there is no such scene.
///
/// It keeps its name, so that cells with one world, robot and sensors share their episodes.
pub fn varied(scene: &SceneFile, fields: &Fields) -> Result<SceneFile, String> {
    let single = SceneFile { vary: Vec::new(), ..scene.clone() };
    let mut whole = serde_json::to_value(&single).map_err(|error| error.to_string())?;
    for (path, value) in fields {
        set(&mut whole, path, value)?;
    }
    let varied: SceneFile = serde_json::from_value(whole).map_err(|error| error.to_string())?;
    varied.validate().map_err(|report| report.to_string().trim().replace('\n', "; "))?;
    Ok(varied)
}

fn set(whole: &mut Value, path: &str, value: &Value) -> Result<(), String> {
    let mut place = whole;
    let mut parts = path.split('.').peekable();
    while let Some(part) = parts.next() {
        let Value::Object(fields) = place else {
            return Err(format!("{path}: `{part}` is no field of a single value"));
        };
        // What is not there need not be left out; a name that no scene has is refused with the whole.
        if value.is_null() && !fields.contains_key(part) {
            fields.insert(part.to_owned(), Value::Null);
            return Ok(());
        }
        place = fields.entry(part).or_insert_with(|| match parts.peek() {
            Some(_) => Value::Object(Map::new()),
            None => Value::Null,
        });
    }
    *place = value.clone();
    Ok(())
}

/// Fields that all cells have in common, or that are said elsewhere.
const COMMON: [&str; 5] = ["name", "version", "vary", "evaluation", "estimator.rows"];

/// Refuses paths that are none, and fields that no cell has of its own.
pub fn of_a_cell(fields: &Fields, _: &()) -> garde::Result {
    fields.keys().try_for_each(|field| is_field_of_a_cell(field, &()))
}

fn is_field_of_a_cell(field: &str, _: &()) -> garde::Result {
    if !field.split('.').all(|part| is_file_name(part, &()).is_ok()) {
        return Err(garde::Error::new(format!(
            "{field:?} is no path of a field: expected names of fields, with dots between, such as robot.path.circle.radius"
        )));
    }
    let below = |common: &str| {
        field.strip_prefix(common).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    match COMMON.into_iter().find(|common| below(common)) {
        Some(common) => Err(garde::Error::new(format!("{field:?}: `{common}` is the same in all cells"))),
        None => Ok(()),
    }
}

fn all_different(values: &[Value], _: &()) -> garde::Result {
    let before = |(i, value): &(usize, &Value)| values[..*i].iter().any(|other| told(other) == told(value));
    match values.iter().enumerate().find(before) {
        Some((_, twice)) => Err(garde::Error::new(format!("{} is there twice", told(twice)))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;
    use serde_json::json;
    use std::path::Path;

    fn scene() -> SceneFile {
        let text = include_str!("../../../scenes/tabletop.yaml");
        parse(text, Path::new("scenes/tabletop.yaml")).unwrap()
    }

    fn fields(value: Value) -> Fields {
        value.as_object().unwrap().clone()
    }

    #[test]
    fn fields_are_set_added_and_left_out_and_all_else_stays() {
        let base = scene();
        assert_eq!(varied(&base, &Fields::new()).unwrap(), base);
        let set = fields(json!({
            "robot.path.circle.radius": 1.7,
            "sensors.landmarks": { "count": 20, "pixel_sigma": 0.5, "max_range": 8.0 },
        }));
        let other = varied(&base, &set).unwrap();
        assert_eq!(other.robot.path, vantage_sim::scene::PathSpec::Circle { radius: 1.7 });
        assert_eq!(other.sensors.landmarks.as_ref().map(|landmarks| landmarks.count), Some(20));
        assert_eq!((&other.world, &other.name), (&base.world, &base.name));
        let back = fields(json!({ "sensors.landmarks": null, "robot.path.circle.radius": 1.6 }));
        assert_eq!(varied(&other, &back).unwrap(), base);
    }

    #[test]
    fn what_no_scene_has_is_told_by_its_path() {
        for (set, said) in [
            (json!({ "robot.path.circle.radios": 1.7 }), "radios"),
            (json!({ "robot.speed.fast": 1 }), "robot.speed.fast"),
            (json!({ "robot.path.circle.radius": 0.3 }), "bump"),
            (json!({ "world.objects": "many" }), "many"),
            (json!({ "robot.camera.height": null }), "null"),
            (json!({ "world.relit_att": null }), "relit_att"),
        ] {
            let reason = varied(&scene(), &fields(set)).unwrap_err();
            assert!(reason.contains(said), "{said} not in: {reason}");
        }
    }

    #[test]
    fn an_axis_names_a_field_and_no_value_twice() {
        let axis = |field: &str, over: Value| {
            Axis { field: field.to_owned(), over: over.as_array().unwrap().clone() }.validate()
        };
        assert!(axis("robot.laps", json!([0.5, 1, null])).is_ok());
        for (field, over) in [
            ("robot..laps", json!([1])),
            ("", json!([1])),
            ("name", json!(["x"])),
            ("evaluation.seeds", json!([3])),
            ("robot.laps", json!([])),
        ] {
            assert!(axis(field, over).is_err(), "{field}");
        }
        let twice = axis("robot.laps", json!([1, 2, 1])).unwrap_err().to_string();
        assert!(twice.contains("1 is there twice"), "{twice}");
        assert_eq!([json!(null), json!("a"), json!(0.5)].map(|value| told(&value)), ["none", "a", "0.5"]);
    }
}
