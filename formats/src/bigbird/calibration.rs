//! `calibration.h5`: the cameras of the rig.

use super::{CAMERAS, PIXEL_CENTER, REFERENCE};
use crate::Lens;
use crate::hdf5::{Hdf5, write_floats};
use crate::import::{FETCH_AGAIN, ImportError};
use crate::rigid::{RIGID, rigid};
use nalgebra::Matrix4;
use std::path::Path;
use vantage_dataset::store::StoreError;
use vantage_dataset::{Camera, Pose};

/// One camera for colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigCamera {
    pub(super) camera_from_reference: Pose,
    pub(super) fx: f64,
    pub(super) fy: f64,
    pub(super) cx: f64,
    pub(super) cy: f64,
    pub(super) lens: Lens,
}

impl RigCamera {
    /// The camera, for images of this size.
    pub(super) fn camera(&self, width: u32, height: u32) -> Camera {
        Camera { width, height, fx: self.fx, fy: self.fy, cx: self.cx, cy: self.cy }
    }
}

/// Reads the camera `NP{camera}`.
pub(super) fn read_camera(file: &Hdf5, camera: usize) -> Result<RigCamera, ImportError> {
    let name = format!("H_NP{camera}_from_NP5");
    let camera_from_reference = match file.floats(&name, &[4, 4])? {
        Some(rows) => transform(file.path(), &name, &rows)?,
        None if camera == REFERENCE => Pose::identity(),
        None => transform(file.path(), &name, &file.required(&name, &[4, 4])?)?,
    };
    let name = format!("NP{camera}_rgb_K");
    let k = file.required(&name, &[3, 3])?;
    if !(k[0] > 0.0 && k[4] > 0.0 && k[1].abs() < 1e-9) {
        let expected = "positive focal lengths and no skew";
        return Err(ImportError::invalid(file.path(), name, format!("{k:?}"), expected, FETCH_AGAIN));
    }
    let d = file.floats(&format!("NP{camera}_rgb_d"), &[5])?.unwrap_or(vec![0.0; 5]);
    let lens = Lens { k1: d[0], k2: d[1], p1: d[2], p2: d[3], k3: d[4] };
    let (cx, cy) = (k[2] + PIXEL_CENTER, k[5] + PIXEL_CENTER);
    Ok(RigCamera { camera_from_reference, fx: k[0], fy: k[4], cx, cy, lens })
}

/// A rigid transform from the 16 numbers of a row-major matrix.
pub(super) fn transform(file: &Path, field: &str, rows: &[f64]) -> Result<Pose, ImportError> {
    let matrix = Matrix4::from_row_slice(rows);
    let last = (matrix.row(3) - Matrix4::<f64>::identity().row(3)).norm();
    let pose =
        rigid(matrix.fixed_view::<3, 3>(0, 0).into_owned(), matrix.fixed_view::<3, 1>(0, 3).into_owned());
    pose.filter(|_| last < RIGID).ok_or_else(|| {
        ImportError::invalid(file, field, format!("{rows:?}"), "a rigid transform", FETCH_AGAIN)
    })
}

/// The 16 numbers of a transform, row-major.
pub(super) fn rows(pose: &Pose) -> Vec<f64> {
    pose.to_homogeneous().transpose().as_slice().to_vec()
}

/// What is written of one camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Calibrated {
    pub(super) camera_from_reference: Pose,
    pub(super) color: Camera,
    pub(super) depth: Camera,
}

/// Writes `calibration.h5`. The depth camera stands where the colour camera does; there is no distortion.
pub(super) fn write(path: &Path, cameras: &[Option<Calibrated>; CAMERAS]) -> Result<(), StoreError> {
    let mut datasets = Vec::new();
    for (index, camera) in cameras.iter().enumerate() {
        let Some(camera) = camera else { continue };
        let np = format!("NP{}", index + 1);
        let transform = rows(&camera.camera_from_reference);
        datasets.push((format!("H_{np}_from_NP5"), transform.clone(), vec![4, 4]));
        datasets.push((format!("H_{np}_ir_from_NP5"), transform, vec![4, 4]));
        datasets.push((format!("{np}_rgb_K"), intrinsics(&camera.color), vec![3, 3]));
        datasets.push((format!("{np}_rgb_d"), vec![0.0; 5], vec![5]));
        for name in ["depth_K", "ir_K"] {
            datasets.push((format!("{np}_{name}"), intrinsics(&camera.depth), vec![3, 3]));
        }
        datasets.push((format!("{np}_ir_d"), vec![0.0; 5], vec![5]));
        for (name, value) in
            [("depth_scale", 1.0), ("depth_bias", 0.0), ("ir_depth_scale", 1.0), ("ir_depth_bias", 0.0)]
        {
            datasets.push((format!("{np}_{name}"), vec![value], vec![1]));
        }
    }
    write_floats(path, &datasets)
}

fn intrinsics(camera: &Camera) -> Vec<f64> {
    let Camera { fx, fy, cx, cy, .. } = *camera;
    vec![fx, 0.0, cx - PIXEL_CENTER, 0.0, fy, cy - PIXEL_CENTER, 0.0, 0.0, 1.0]
}
