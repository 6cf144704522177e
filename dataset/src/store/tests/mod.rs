//! What is written reads back to the bit, and what was damaged or made up is refused.

mod cache;
mod damage;
mod folder_lock;
mod hostile;
mod round_trip;
mod whole_file;

use super::file_record::FileRecord;
use super::manifest::Manifest;
use crate::crop::CROP_BYTES;
use crate::views::InstanceRecord;
use crate::*;
use nalgebra::{Matrix6, Quaternion, UnitQuaternion, Vector2, Vector3};
use std::fs;
use std::path::Path;

fn pose(stream: &mut Stream) -> Pose {
    let mut normal = || stream.normal();
    let q = Quaternion::new(normal(), normal(), normal(), normal());
    let t = Vector3::new(normal(), 1e-9 * normal(), 1e9 * normal());
    Pose::from_parts(t.into(), UnitQuaternion::new_normalize(q))
}

fn crop(stream: &mut Stream) -> Crop {
    Crop(Box::new([0; CROP_BYTES].map(|_| stream.below(256) as u8)))
}

fn instance(stream: &mut Stream) -> InstanceRecord {
    let symmetry = match stream.below(3) {
        0 => Symmetry::None,
        1 => Symmetry::Revolution,
        _ => Symmetry::Cyclic { order: 2 + stream.below(254) as u8 },
    };
    let id = InstanceId(stream.below(usize::MAX) as u64);
    InstanceRecord {
        id,
        family: ["mug", "a \"toy\", of sorts", "# Tasse grün"][stream.below(3)].to_owned(),
        symmetry,
    }
}

/// An episode of `steps` steps, at each of which every one of `objects` objects is seen or not.
fn episode(seed: Seed, steps: usize, objects: usize) -> Episode {
    let mut s = seed.stream("episode", 0);
    let timestamps = (0..steps).map(|k| k as f64 / 3.0 + 0.2 * s.unit()).collect();
    let odometry = (1..steps)
        .map(|to| {
            let root = Matrix6::from_fn(|_, _| s.normal());
            let square = root * root.transpose() * 1e-8 + Matrix6::identity() * 1e-10;
            let covariance = square.symmetric_part();
            Odometry { from: to - 1, to, robot_from_robot: pose(&mut s), covariance }
        })
        .collect();
    let mut detections = Vec::new();
    for step in 0..steps {
        for track in 0..objects {
            if s.chance(0.5) {
                let min = Vector2::new(-s.unit(), 100.0 * s.unit());
                detections.push(Detection {
                    step,
                    track,
                    bounding_box: BoundingBox { min, max: min + Vector2::new(s.unit() + 1e-3, 12.0) },
                    mask_pixels: 1 + s.below(900) as u32,
                    masked_crop: crop(&mut s),
                    boxed_crop: crop(&mut s),
                });
            }
        }
    }
    let truth = Truth {
        world_from_robot: (0..steps).map(|_| pose(&mut s)).collect(),
        objects: (0..objects)
            .map(|_| {
                let InstanceRecord { id, family, symmetry } = instance(&mut s);
                let size = 0.01 + s.unit();
                let half_sides = Vector3::new(0.1, 0.02, 1e-3) + Vector3::repeat(s.unit());
                let extents = Some(Extents { half_sides, semi_axes: half_sides * 1.3 });
                let world_from_object = pose(&mut s);
                ObjectTruth { instance: id, family, world_from_object, size, symmetry, extents }
            })
            .collect(),
        landmarks: (0..objects).map(|_| pose(&mut s).translation.vector.into()).collect(),
        detections: detections.iter().map(|_| DetectionTruth { visible_fraction: s.unit() }).collect(),
    };
    let observations = Observations {
        timestamps,
        camera: Camera::with_horizontal_fov(320, 240, 1.1),
        robot_from_camera: pose(&mut s),
        odometry,
        detections,
        landmarks: (0..objects.min(steps))
            .map(|i| LandmarkSighting {
                step: i,
                landmark: i,
                pixel: Vector2::new(100.0 * s.unit(), -0.5),
                sigma: 0.1 + s.unit(),
            })
            .collect(),
    };
    Episode { seed, observations, truth }
}

fn sighting(s: &mut Stream, step: usize) -> Sighting {
    let session_from_camera = pose(s);
    Sighting { step, session_from_camera, ray: [s.normal(), s.normal()], angular_size: s.unit() }
}

fn view_set(seed: Seed, instances: usize) -> ViewSet {
    let mut s = seed.stream("views", 0);
    let records: Vec<_> = (0..instances).map(|_| instance(&mut s)).collect();
    let mut views = Vec::new();
    for instance in 0..instances {
        for session in 0..s.below(4) {
            let direction = Vector3::new(s.normal(), s.normal(), s.normal()).normalize();
            views.push(View {
                instance,
                session,
                viewpoint: Viewpoint { direction, roll: s.normal(), log_distance: s.normal() },
                crop: crop(&mut s),
                visible_fraction: s.unit(),
                box_center_error: [s.normal() * 1e-3, -0.0],
                sighting: s.chance(0.5).then(|| sighting(&mut s, session)),
            });
        }
    }
    ViewSet { split: Split::Validation, instances: records, views }
}

/// Replaces a file as a careless or hostile writer would: with a manifest that vouches for it.
fn forge(folder: &Path, name: &str, change: impl FnOnce(Vec<u8>) -> Vec<u8>) {
    let bytes = change(fs::read(folder.join(name)).unwrap());
    let record = FileRecord { bytes: bytes.len() as u64, blake3: blake3::hash(&bytes).to_hex().to_string() };
    fs::write(folder.join(name), bytes).unwrap();
    forge_manifest(folder, |manifest| {
        manifest.files.insert(name.to_owned(), record);
    });
}

fn forge_manifest(folder: &Path, change: impl FnOnce(&mut Manifest)) {
    let path = folder.join("manifest.json");
    let mut manifest: Manifest = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    change(&mut manifest);
    manifest.seal = manifest.computed_seal();
    fs::write(path, serde_json::to_vec(&manifest).unwrap()).unwrap();
}
