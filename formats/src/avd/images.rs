//! `image_structs.mat`: where each image was taken.

use crate::import::{FETCH_AGAIN, ImportError};
use crate::mat5::{self, StructArray, Value};
use crate::rigid::rigid;
use nalgebra::{Matrix3, Vector3};
use std::ops::RangeInclusive;
use std::path::Path;
use vantage_dataset::Pose;

pub(super) const FILE: &str = "image_structs.mat";
/// Fields of a struct, in the file's order.
pub(super) const FIELDS: [&str; 16] = [
    "image_name",
    "t",
    "R",
    "world_pos",
    "direction",
    "quat",
    "scaled_world_pos",
    "image_id",
    "camera_id",
    "cluster_id",
    "rotate_cw",
    "rotate_ccw",
    "translate_forward",
    "translate_backward",
    "translate_right",
    "translate_left",
];
/// Millimetres that a unit of a reconstruction may be.
const SCALES: RangeInclusive<f64> = 1e-3..=1e7;
const SCALE: &str = "one number from 1e-3 to 1e7";
/// How far from the reconstruction's origin a camera may be, metres.
const FARTHEST: f64 = 1e4;

/// One image.
#[derive(Clone, Debug)]
pub(super) struct ScanImage {
    pub(super) name: String,
    /// `camera_from_world`, metres, or why there is none.
    pub(super) pose: Result<Pose, String>,
}

/// Reads the images of a scan, sorted by name.
pub(super) fn read(scan: &Path) -> Result<Vec<ScanImage>, ImportError> {
    let path = scan.join(FILE);
    let variables = mat5::read(&path)?;
    let variable = |name: &str, expected: &str| {
        let value = variables.get(name);
        let got = value.map_or("no such variable".to_owned(), Value::describe);
        (value, ImportError::invalid(&path, name, got, expected, FETCH_AGAIN))
    };
    let (value, error) = variable("scale", SCALE);
    let scale = match value.and_then(Value::as_numbers) {
        Some(&[scale]) if SCALES.contains(&scale) => scale,
        Some(other) => {
            return Err(ImportError::invalid(&path, "scale", format!("{other:?}"), SCALE, FETCH_AGAIN));
        }
        None => return Err(error),
    };
    let (value, error) = variable("image_structs", "a struct array");
    let Some(Value::Structs(structs)) = value else { return Err(error) };
    let column = |name: &str| {
        structs.field(name).ok_or_else(|| {
            let got = format!("{:?}", structs.fields);
            ImportError::invalid(&path, "image_structs", got, format!("a field {name}"), FETCH_AGAIN)
        })
    };
    let (name, t, r) = (column("image_name")?, column("t")?, column("R")?);
    let mut images = Vec::with_capacity(structs.elements.len());
    for (index, element) in structs.elements.iter().enumerate() {
        let Some(image_name) = element[name].as_text() else {
            let field = format!("image_structs({}).image_name", index + 1);
            return Err(ImportError::invalid(&path, field, element[name].describe(), "text", FETCH_AGAIN));
        };
        images.push(ScanImage {
            name: image_name.to_owned(),
            pose: pose(&element[r], &element[t], scale / 1000.0),
        });
    }
    images.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(pair) = images.windows(2).find(|pair| pair[0].name == pair[1].name) {
        let got = format!("{} twice", pair[0].name);
        return Err(ImportError::invalid(&path, "image_name", got, "each image once", FETCH_AGAIN));
    }
    Ok(images)
}

fn pose(r: &Value, t: &Value, metres: f64) -> Result<Pose, String> {
    let (Some(r), Some(t)) = (r.as_numbers(), t.as_numbers()) else {
        return Err(format!("R and t are {} and {}, expected numbers", r.describe(), t.describe()));
    };
    if r.is_empty() || t.is_empty() {
        return Err("not registered: R or t is empty".to_owned());
    }
    if r.len() != 9 || t.len() != 3 {
        return Err(format!("R and t have {} and {} numbers, expected 9 and 3", r.len(), t.len()));
    }
    let translation = Vector3::from_column_slice(t) * metres;
    let pose = rigid(Matrix3::from_column_slice(r), translation);
    let pose = pose.ok_or_else(|| format!("R is {r:?}, expected a rotation"))?;
    if !(0.0..=FARTHEST).contains(&translation.norm()) {
        return Err(format!(
            "t is {t:?}, expected finite numbers and a camera within {FARTHEST} m of the origin"
        ));
    }
    Ok(pose)
}

/// What is written of one image. Units of the reconstruction are metres.
#[derive(Clone, Debug)]
pub(super) struct WrittenImage {
    pub(super) name: String,
    pub(super) camera_from_world: Pose,
    pub(super) image_id: u32,
    pub(super) cluster_id: u32,
    /// Names of the images that `rotate_cw` and the fields behind it lead to.
    pub(super) moves: [Option<String>; 6],
}

/// The bytes of the file.
pub(super) fn encode(images: &[WrittenImage]) -> Vec<u8> {
    const MILLIMETRES: f64 = 1000.0;
    let structs = StructArray {
        fields: FIELDS.map(str::to_owned).to_vec(),
        elements: images.iter().map(|image| element(image, MILLIMETRES)).collect(),
    };
    let (structs, scale) = (Value::Structs(structs), Value::scalar(MILLIMETRES));
    mat5::encode(&[("image_structs", &structs), ("scale", &scale)])
}

fn element(image: &WrittenImage, scale: f64) -> Vec<Value> {
    let column = |vector: Vector3<f64>| Value::matrix(3, 1, vector.as_slice().to_vec());
    let pose = &image.camera_from_world;
    let rotation = pose.rotation.to_rotation_matrix().into_inner();
    let q = pose.rotation.quaternion();
    let world_pos = pose.inverse().translation.vector;
    let mut values = vec![
        Value::Text(image.name.clone()),
        column(pose.translation.vector),
        Value::matrix(3, 3, rotation.as_slice().to_vec()),
        column(world_pos),
        column(rotation.row(2).transpose()),
        Value::matrix(4, 1, vec![q.w, q.i, q.j, q.k]),
        column(world_pos * scale),
        Value::scalar(image.image_id.into()),
        Value::scalar(1.0),
        Value::scalar(image.cluster_id.into()),
    ];
    values.extend(image.moves.iter().map(|name| name.clone().map_or(Value::scalar(-1.0), Value::Text)));
    values
}
