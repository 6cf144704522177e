//! The symmetries that `models_info.json` gives a model, of which those about z count.

use crate::import::ImportError;
use crate::rigid::nearly_rigid;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use serde::Deserialize;
use std::path::Path;
use vantage_dataset::Symmetry;

/// How far an axis or a turn may be from one about z.
const ABOUT_Z: f64 = 0.01;
/// The last row of a motion, and how far it may be from that.
const LAST_ROW: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
const OFF: f64 = 1e-6;
const REMEDY: &str = "correct the symmetry, or remove it where the object has none";

/// One that any turn about the axis keeps.
#[derive(Deserialize)]
pub(super) struct Continuous {
    axis: [f64; 3],
}

/// Other than about z, a symmetry says nothing of azimuths.
///
/// # Errors
///
/// Symmetries that are none, with their place in `file`.
pub(super) fn symmetry(
    file: &Path,
    object: u32,
    discrete: &[Vec<f64>],
    continuous: &[Continuous],
) -> Result<Symmetry, ImportError> {
    let unfit = |list: &str, place: usize, got: &[f64], expected: &str| {
        let field = format!("object {object}, {list}[{place}]");
        ImportError::invalid(file, field, format!("{got:?}"), expected, REMEDY)
    };
    let mut is_revolution = false;
    for (place, Continuous { axis }) in continuous.iter().enumerate() {
        let expected = "an axis whose length is finite and not 0";
        let axis = direction(axis).ok_or_else(|| unfit("symmetries_continuous", place, axis, expected))?;
        is_revolution |= axis.xy().norm() < ABOUT_Z;
    }
    let mut order = 1_usize;
    for (place, matrix) in discrete.iter().enumerate() {
        let expected = "the 16 numbers of a rigid motion, row by row, the last row 0, 0, 0, 1";
        let turn = turn(matrix).ok_or_else(|| unfit("symmetries_discrete", place, matrix, expected))?;
        let is_about_z = (turn * Vector3::z() - Vector3::z()).norm() < ABOUT_Z;
        order += usize::from(is_about_z && turn.angle() > ABOUT_Z);
    }
    Ok(match u8::try_from(order) {
        _ if is_revolution => Symmetry::Revolution,
        Ok(order) if order > 1 => Symmetry::Cyclic { order },
        _ => Symmetry::None,
    })
}

fn direction(axis: &[f64; 3]) -> Option<Vector3<f64>> {
    let axis = Vector3::from(*axis);
    let length = axis.norm();
    (length > 0.0 && length.is_finite()).then(|| axis / length)
}

/// The rotation of a rigid motion, 4 x 4, row-major.
fn turn(matrix: &[f64]) -> Option<UnitQuaternion<f64>> {
    let [a, b, c, x, d, e, f, y, g, h, i, z, ref last @ ..] = *<&[f64; 16]>::try_from(matrix).ok()?;
    let is_affine = last.iter().zip(LAST_ROW).all(|(value, own)| (value - own).abs() < OFF);
    let motion = nearly_rigid(Matrix3::new(a, b, c, d, e, f, g, h, i), Vector3::new(x, y, z))?;
    is_affine.then_some(motion.rotation)
}
