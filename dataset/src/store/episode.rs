//! Episodes on disk.

use super::check;
use super::error::{Fault, StoreError};
use super::file_record::FileRecord;
use super::hashed_file::{Sink, make_folder, read_verified, sync_folder, write_hashed};
use super::instance_fields::{INSTANCE_ID, SYMMETRY, parse_symmetry, show_symmetry};
use super::manifest::{Content, Manifest, Provenance, read_manifest, withdraw};
use super::npy::{read_crops, write_crops};
use super::pose_fields::{from_fields, pose_fields};
use super::tables::{
    BOXED_CROPS, CAMERA, DEPTHS, DETECTION_TRUTHS, DETECTIONS, EXTENTS, LANDMARK_SIGHTINGS, LANDMARKS,
    MASKED_CROPS, OBJECTS, ODOMETRY, ROBOT, TIMESTAMPS,
};
use super::tum::{read_robot, write_tum};
use crate::{
    BoundingBox, Camera, CenterDepth, Crop, Detection, DetectionTruth, Episode, Extents, InstanceId,
    LandmarkSighting, ObjectTruth, Observations, Odometry, Pose, Seed, Truth,
};
use nalgebra::{Matrix6, Point3, Vector2, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

/// `camera.json`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraFile {
    intrinsics: Camera,
    /// `tx, ty, tz, qx, qy, qz, qw`.
    robot_from_camera: [f64; 7],
}

/// Writes an episode into `folder`, which is made if need be; what it held of an episode is replaced.
pub fn write_episode(
    folder: &Path,
    episode: &Episode,
    provenance: Provenance,
) -> Result<Manifest, StoreError> {
    check::episode(episode).map_err(StoreError::unfit(folder))?;
    let Episode { seed, observations, truth: t } = episode;
    make_folder(&folder.join("truth"))?;
    withdraw(folder)?;
    let mut files = observed(folder, observations, !t.landmarks.is_empty())?;
    let mut write = |name: &str, fill: &dyn Fn(&mut Sink) -> io::Result<()>| {
        let record = write_hashed(&folder.join(name), fill)?;
        files.insert(name.to_owned(), record);
        Ok::<_, StoreError>(())
    };
    write(OBJECTS.file, &|sink| {
        OBJECTS.write(sink, t.objects.iter().enumerate(), |row, (track, object)| {
            row.put(track)?;
            row.put(object.instance)?;
            row.put(&object.family)?;
            row.put(show_symmetry(object.symmetry))?;
            row.put_floats([&object.size])?;
            row.put_floats(&pose_fields(&object.world_from_object))
        })
    })?;
    write(DETECTION_TRUTHS.file, &|sink| {
        DETECTION_TRUTHS.write(sink, t.detections.iter().enumerate(), |row, (i, detection)| {
            row.put(i)?;
            row.put_floats([&detection.visible_fraction])
        })
    })?;
    let extents: Option<Vec<Extents>> = t.objects.iter().map(|object| object.extents).collect();
    if let Some(extents) = &extents {
        write(EXTENTS.file, &|sink| {
            EXTENTS.write(sink, extents.iter().enumerate(), |row, (track, extents)| {
                row.put(track)?;
                row.put_floats(extents.half_sides.iter().chain(&extents.semi_axes))
            })
        })?;
    }
    if !t.landmarks.is_empty() {
        write(LANDMARKS.file, &|sink| {
            LANDMARKS.write(sink, t.landmarks.iter().enumerate(), |row, (landmark, point)| {
                row.put(landmark)?;
                row.put_floats(point.iter())
            })
        })?;
    }
    let robot = write_tum(&folder.join(ROBOT.file), &observations.timestamps, &t.world_from_robot)?;
    files.insert(ROBOT.file.to_owned(), robot);
    sync_folder(&folder.join("truth"))?;

    let (steps, detections) = (observations.steps(), observations.detections.len());
    let counts = [("steps", steps), ("detections", detections), ("objects", t.objects.len())];
    Manifest::new(Content::Episode { seed: *seed }, counts, files, provenance).commit(folder)
}

/// Writes what a robot has of an episode into `folder`, as [`write_episode`] does, and nothing of what was true; `number` stands for the
/// seed.
pub fn write_observations(
    folder: &Path,
    number: Seed,
    observations: &Observations,
    provenance: Provenance,
) -> Result<Manifest, StoreError> {
    check::observations(observations).map_err(StoreError::unfit(folder))?;
    make_folder(folder)?;
    withdraw(folder)?;
    let files = observed(folder, observations, !observations.landmarks.is_empty())?;
    let counts = [("steps", observations.steps()), ("detections", observations.detections.len())];
    Manifest::new(Content::Episode { seed: number }, counts, files, provenance).commit(folder)
}

/// The files of what a robot has; a table of landmarks where they are measured.
fn observed(
    folder: &Path,
    o: &Observations,
    with_landmarks: bool,
) -> Result<BTreeMap<String, FileRecord>, StoreError> {
    let mut files = BTreeMap::new();
    let mut write = |name: &str, fill: &dyn Fn(&mut Sink) -> io::Result<()>| {
        let record = write_hashed(&folder.join(name), fill)?;
        files.insert(name.to_owned(), record);
        Ok::<_, StoreError>(())
    };
    write(MASKED_CROPS, &|sink| write_crops(sink, o.detections.iter().map(|d| &d.masked_crop)))?;
    write(BOXED_CROPS, &|sink| write_crops(sink, o.detections.iter().map(|d| &d.boxed_crop)))?;
    write(CAMERA, &|sink| write_camera(sink, &o.camera, &o.robot_from_camera))?;
    write(TIMESTAMPS.file, &|sink| {
        TIMESTAMPS.write(sink, o.timestamps.iter().enumerate(), |row, (step, seconds)| {
            row.put(step)?;
            row.put_floats([seconds])
        })
    })?;
    write(DETECTIONS.file, &|sink| {
        DETECTIONS.write(sink, &o.detections, |row, d| {
            row.put(d.step)?;
            row.put(d.track)?;
            row.put_floats(d.bounding_box.min.iter().chain(&d.bounding_box.max))?;
            row.put(d.mask_pixels)
        })
    })?;
    let depths = || o.detections.iter().enumerate().filter_map(|(i, d)| Some((i, d.center_depth?)));
    if depths().next().is_some() {
        write(DEPTHS.file, &|sink| {
            DEPTHS.write(sink, depths(), |row, (detection, depth)| {
                row.put(detection)?;
                row.put_floats([&depth.meters, &depth.sigma])
            })
        })?;
    }
    write(ODOMETRY.file, &|sink| {
        ODOMETRY.write(sink, &o.odometry, |row, measured| {
            row.put(measured.from)?;
            row.put(measured.to)?;
            row.put_floats(&pose_fields(&measured.robot_from_robot))?;
            row.put_floats(&upper_triangle(&measured.covariance))
        })
    })?;
    if with_landmarks {
        write(LANDMARK_SIGHTINGS.file, &|sink| {
            LANDMARK_SIGHTINGS.write(sink, &o.landmarks, |row, sighting| {
                row.put(sighting.step)?;
                row.put(sighting.landmark)?;
                row.put_floats(sighting.pixel.iter().chain([&sighting.sigma]))
            })
        })?;
    }
    Ok(files)
}

/// Reads an episode, bit for bit as it was written.
pub fn read_episode(folder: &Path) -> Result<Episode, StoreError> {
    let manifest = read_manifest(folder)?;
    let (seed, observations) = observations(folder, &manifest)?;
    let (timestamps, truth) = truth(folder, &manifest)?;
    let episode = Episode { seed, observations, truth };
    check::episode(&episode).map_err(StoreError::invalid(folder))?;
    if timestamps != episode.observations.timestamps {
        let fault =
            Fault::new(ROBOT.file, None, "timestamp", "others", format!("those of {}", TIMESTAMPS.file));
        return Err(StoreError::invalid(folder)(fault));
    }
    Ok(episode)
}

/// Reads what the robot has; no file under `truth/` is touched, nor needs to be there.
pub fn read_observations(folder: &Path) -> Result<Observations, StoreError> {
    let (_, observations) = observations(folder, &read_manifest(folder)?)?;
    check::observations(&observations).map_err(StoreError::invalid(folder))?;
    Ok(observations)
}

/// Reads what was true; no file outside `truth/` but the manifest is touched.
pub fn read_truth(folder: &Path) -> Result<Truth, StoreError> {
    let (_, truth) = truth(folder, &read_manifest(folder)?)?;
    check::truth(&truth).map_err(StoreError::invalid(folder))?;
    Ok(truth)
}

fn observations(folder: &Path, manifest: &Manifest) -> Result<(Seed, Observations), StoreError> {
    let Content::Episode { seed } = manifest.content else {
        return Err(manifest.not_the_kind(folder, "an episode"));
    };
    let CameraFile { intrinsics, robot_from_camera } =
        read_verified(folder, CAMERA, manifest.file(folder, CAMERA)?, |source| {
            serde_json::from_reader(source).map_err(|e| {
                let fault = Fault::new(CAMERA, Some(e.line() as u64), "JSON", e, "the fields of the format");
                StoreError::invalid(folder)(fault)
            })
        })?;
    let timestamps = manifest.read_table(folder, &TIMESTAMPS, |row| {
        row.take_index()?;
        let [seconds] = row.take_floats()?;
        Ok(seconds)
    })?;
    let odometry = manifest.read_table(folder, &ODOMETRY, |row| {
        Ok(Odometry {
            from: row.take("a step")?,
            to: row.take("a step")?,
            robot_from_robot: from_fields(row.take_floats()?),
            covariance: symmetric(row.take_floats()?),
        })
    })?;
    let rows = manifest.read_table(folder, &DETECTIONS, |row| {
        let (step, track) = (row.take("a step")?, row.take("a track")?);
        let [min_x, min_y, max_x, max_y] = row.take_floats()?;
        let bounding_box = BoundingBox { min: Vector2::new(min_x, min_y), max: Vector2::new(max_x, max_y) };
        Ok((step, track, bounding_box, row.take("a number of pixels")?))
    })?;
    manifest.check_count(folder, "steps", timestamps.len())?;
    manifest.check_count(folder, "detections", rows.len())?;
    let crops = |name| -> Result<Vec<Crop>, StoreError> {
        let record = manifest.file(folder, name)?;
        read_verified(folder, name, record, |source| {
            read_crops(source, folder, name, record.bytes, rows.len())
        })
    };
    let (masked, boxed) = (crops(MASKED_CROPS)?, crops(BOXED_CROPS)?);
    let mut depths = vec![None; rows.len()];
    let listed = manifest.read_table_if_listed(folder, &DEPTHS, |row| {
        let number = |text: &str| text.parse().ok().filter(|i| *i < rows.len());
        let detection: usize = row.take_with("the number of a detection", number)?;
        let [meters, sigma] = row.take_floats()?;
        Ok((detection, CenterDepth { meters, sigma }))
    })?;
    for (detection, depth) in listed.into_iter().flatten() {
        depths[detection] = Some(depth);
    }
    let detections = rows
        .into_iter()
        .zip(depths)
        .zip(masked.into_iter().zip(boxed))
        .map(|(((step, track, bounding_box, mask_pixels), center_depth), (masked_crop, boxed_crop))| {
            Detection { step, track, bounding_box, mask_pixels, center_depth, masked_crop, boxed_crop }
        })
        .collect();
    let landmarks = manifest.read_table_if_listed(folder, &LANDMARK_SIGHTINGS, |row| {
        let (step, landmark) = (row.take("a step")?, row.take("a landmark")?);
        let [x, y, sigma] = row.take_floats()?;
        Ok(LandmarkSighting { step, landmark, pixel: Vector2::new(x, y), sigma })
    })?;
    let observations = Observations {
        timestamps,
        camera: intrinsics,
        robot_from_camera: from_fields(robot_from_camera),
        odometry,
        detections,
        landmarks: landmarks.unwrap_or_default(),
    };
    Ok((seed, observations))
}

/// The clock of the true trajectory, and the truth.
fn truth(folder: &Path, manifest: &Manifest) -> Result<(Vec<f64>, Truth), StoreError> {
    let (timestamps, world_from_robot) =
        read_verified(folder, ROBOT.file, manifest.file(folder, ROBOT.file)?, |source| {
            read_robot(folder, source)
        })?;
    check::timestamps(&ROBOT, &timestamps).map_err(StoreError::invalid(folder))?;
    let mut objects = manifest.read_table(folder, &OBJECTS, |row| {
        row.take_index()?;
        let instance = row.take_with(INSTANCE_ID, InstanceId::parse)?;
        let family = row.take("a name")?;
        let symmetry = row.take_with(SYMMETRY, parse_symmetry)?;
        let [size] = row.take_floats()?;
        Ok(ObjectTruth {
            instance,
            family,
            symmetry,
            size,
            world_from_object: from_fields(row.take_floats()?),
            extents: None,
        })
    })?;
    manifest.check_count(folder, "objects", objects.len())?;
    let extents = manifest.read_table_if_listed(folder, &EXTENTS, |row| {
        row.take_index()?;
        let [half_sides, semi_axes] = [row.take_floats::<3>()?, row.take_floats::<3>()?].map(Vector3::from);
        Ok(Extents { half_sides, semi_axes })
    })?;
    if let Some(extents) = extents {
        check::one_each(&EXTENTS, extents.len(), objects.len(), "object")
            .map_err(StoreError::invalid(folder))?;
        for (object, extents) in objects.iter_mut().zip(extents) {
            object.extents = Some(extents);
        }
    }
    let landmarks = manifest.read_table_if_listed(folder, &LANDMARKS, |row| {
        row.take_index()?;
        Ok(Point3::from(row.take_floats::<3>()?))
    })?;
    let detections = manifest.read_table(folder, &DETECTION_TRUTHS, |row| {
        row.take_index()?;
        let [visible_fraction] = row.take_floats()?;
        Ok(DetectionTruth { visible_fraction })
    })?;
    manifest.check_count(folder, "steps", world_from_robot.len())?;
    manifest.check_count(folder, "detections", detections.len())?;
    let landmarks = landmarks.unwrap_or_default();
    Ok((timestamps, Truth { world_from_robot, objects, landmarks, detections }))
}

fn write_camera(sink: &mut Sink, camera: &Camera, robot_from_camera: &Pose) -> io::Result<()> {
    let file = CameraFile { intrinsics: *camera, robot_from_camera: pose_fields(robot_from_camera) };
    serde_json::to_writer_pretty(&mut *sink, &file)?;
    sink.write_all(b"\n")
}

/// The 21 numbers on and above the diagonal, row by row.
fn upper_triangle(matrix: &Matrix6<f64>) -> [f64; 21] {
    let mut values = [0.0; 21];
    let places = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
    values.iter_mut().zip(places).for_each(|(value, place)| *value = matrix[place]);
    values
}

/// The inverse of [`upper_triangle`].
fn symmetric(values: [f64; 21]) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    let places = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
    for ((i, j), value) in places.zip(values) {
        matrix[(i, j)] = value;
        matrix[(j, i)] = value;
    }
    matrix
}
