//! `poses/`: the cameras about the table, and its axis.

use super::calibration::{rows, transform};
use super::name;
use crate::hdf5::{Hdf5, write_floats};
use crate::import::ImportError;
use nalgebra::{UnitQuaternion, Vector3};
use std::path::Path;
use vantage_dataset::Pose;
use vantage_dataset::store::StoreError;

const POSE: &str = "H_table_from_reference_camera";
/// Cosine of the largest angle between the table's axis and the z axis of its frame: 10 degrees.
const UPRIGHT: f64 = 0.984_807_753;

/// `table_from_NP5` at an angle.
pub(super) fn read_pose(object: &Path, angle: u32) -> Result<Pose, ImportError> {
    let file = Hdf5::open(&object.join(name::pose(angle)))?;
    transform(file.path(), POSE, &file.required(POSE, &[4, 4])?)
}

/// The least turn that takes z to the table's normal; none where `turntable.h5` is absent, and an error where it
/// cannot be the axis of these poses.
pub(super) fn read_upright(object: &Path) -> Result<Option<UnitQuaternion<f64>>, ImportError> {
    let path = object.join("poses/turntable.h5");
    let file = match Hdf5::open(&path) {
        Ok(file) => file,
        Err(error) if error.is_absence() => return Ok(None),
        Err(error) => return Err(error),
    };
    let normal = Vector3::from_row_slice(&file.required("normal", &[3])?);
    let unit = normal.normalize() * if normal.z < 0.0 { -1.0 } else { 1.0 };
    if !(UPRIGHT..=1.0 + f64::EPSILON).contains(&unit.z) {
        let got = format!("{:?}", normal.as_slice());
        let expected = "within 10 degrees of the z axis of the table's frame";
        return Err(ImportError::invalid(&path, "/normal", got, expected, "remove the file: z is used then"));
    }
    Ok(UnitQuaternion::rotation_between(&Vector3::z(), &unit))
}

/// Writes `table_from_NP5` of an angle.
pub(super) fn write_pose(object: &Path, angle: u32, table_from_reference: &Pose) -> Result<(), StoreError> {
    let datasets = [
        (POSE.to_owned(), rows(table_from_reference), vec![4, 4]),
        ("board_frame_offset".to_owned(), vec![0.0; 3], vec![3]),
    ];
    write_floats(&object.join(name::pose(angle)), &datasets)
}

/// Writes the axis: through the origin of the table's frame, along z.
pub(super) fn write_axis(object: &Path) -> Result<(), StoreError> {
    let datasets =
        [("center".to_owned(), vec![0.0; 3], vec![3]), ("normal".to_owned(), vec![0.0, 0.0, 1.0], vec![3])];
    write_floats(&object.join("poses/turntable.h5"), &datasets)
}
