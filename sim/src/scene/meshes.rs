//! `world.meshes`: objects from files.

use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use vantage_dataset::rule::not_nan;
use vantage_dataset::{Split, Symmetry};

/// A mesh, or a folder of meshes, each of which is one object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    /// An OBJ, glTF or GLB file, the folder of a model (YCB's and Google Scanned Objects' layouts are known), or a
    /// folder of such folders; relative to the scene file.
    #[garde(skip)]
    pub path: PathBuf,
    /// Length of the file's unit, metres: 1 for metres, 0.001 for millimetres.
    #[garde(range(min = 1e-6, max = 1e6), custom(not_nan))]
    pub metres_per_unit: f64,
    /// The axis of the file that points up.
    #[garde(skip)]
    pub up: UpAxis,
    /// Category of the objects; the name of each model's folder, or of its file, unless stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(custom(is_name))]
    pub category: Option<String>,
    /// Turns about the vertical that leave the look of the objects unchanged.
    #[serde(default)]
    #[garde(dive)]
    pub symmetry: SymmetrySpec,
    /// The split of the objects; drawn by the hash of each model's name, three in five for training, unless stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<SplitName>")]
    #[garde(skip)]
    pub split: Option<Split>,
}

/// Furniture from a file, fixed where it stands, its surface solid; objects are not put on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct FixtureSpec {
    /// An OBJ, glTF or GLB file, or the folder of one model; relative to the scene file.
    #[garde(skip)]
    pub path: PathBuf,
    /// Length of the file's unit, metres: 1 for metres, 0.001 for millimetres.
    #[garde(range(min = 1e-6, max = 1e6), custom(not_nan))]
    pub metres_per_unit: f64,
    /// The axis of the file that points up.
    #[garde(skip)]
    pub up: UpAxis,
    /// Where the middle of its bounding box stands `[x, y]`, metres.
    #[garde(inner(range(min = -250.0, max = 250.0), custom(not_nan)))]
    pub at: [f64; 2],
    /// Turn about the vertical, degrees.
    #[serde(default)]
    #[garde(range(min = -360.0, max = 360.0), custom(not_nan))]
    pub yaw_deg: f64,
}

/// The axis of a file that points up; the front of the object is then the axis that becomes +x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UpAxis {
    /// z; the front is +x.
    Z,
    /// y, as in glTF; the front is +z.
    Y,
}

/// Turns about the vertical that leave the look of an object unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(rename_all = "snake_case")]
pub enum SymmetrySpec {
    /// No turn does.
    #[default]
    None,
    /// Every turn does.
    Revolution,
    /// As many turns as stated make a full one, and each of them does.
    Cyclic(#[garde(range(min = 2))] u8),
}

impl From<SymmetrySpec> for Symmetry {
    fn from(spec: SymmetrySpec) -> Self {
        match spec {
            SymmetrySpec::None => Symmetry::None,
            SymmetrySpec::Revolution => Symmetry::Revolution,
            SymmetrySpec::Cyclic(order) => Symmetry::Cyclic { order },
        }
    }
}

/// The names of the splits, for the schema.
#[derive(JsonSchema)]
#[schemars(rename = "Split", rename_all = "snake_case")]
#[expect(dead_code, reason = "stands in the schema only")]
enum SplitName {
    Train,
    Validation,
    Test,
}

fn is_name(name: &Option<String>, _: &()) -> garde::Result {
    match name {
        Some(name) if name.is_empty() || name.len() > 100 || name.contains(char::is_control) => {
            Err(garde::Error::new(format!("got {name:?}, expected a name of one line")))
        }
        _ => Ok(()),
    }
}
