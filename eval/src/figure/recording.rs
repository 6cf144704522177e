//! An episode as a Rerun recording, to be looked at from all sides and step by step.
//!
//! ```text
//! world                                   z up, metres
//! world/room/<n>, world/objects/<n>       meshes; objects with their boxes, named by family, index and instance
//! world/truth, world/odometry             the trajectories
//! world/landmarks                         where the scene has them
//! world/robot                             its true pose at each step
//! world/robot/camera                      the pinhole camera
//! world/robot/camera/image                what it sees; below it detections and sighted landmarks
//! ```

use crate::exit::{Ends, Exit};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rerun::archetypes::{
    Boxes2D, Boxes3D, EncodedImage, Image, LineStrips3D, Mesh3D, Pinhole, Points2D, Points3D, Transform3D,
    ViewCoordinates,
};
use rerun::components::{ClassId, MediaType, MeshFaceRendering};
use rerun::datatypes::Quaternion;
use rerun::{RecordingStream, RecordingStreamBuilder};
use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::store::rename_durably;
use vantage_dataset::{Camera, Pose};
use vantage_sim::checked::CheckedScene;
use vantage_sim::error::SimError;
use vantage_sim::observer::{Look, Observer};
use vantage_sim::render::{NO_OBJECT, Placement, Renderer};
use vantage_sim::rollout::Rollout;
use vantage_slam::initial::dead_reckoning;

const IMAGE: &str = "world/robot/camera/image";
/// Half the width of trajectories, metres.
const LINE: f32 = 0.01;

type Logged = Result<(), Box<dyn Error + Send + Sync>>;

/// Why an episode is not recorded.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file could not be written.
    #[error("cannot write {}: {source}; choose another file with --rerun, or make room", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What Rerun or the system said.
        source: Box<dyn Error + Send + Sync>,
    },
    /// See [`SimError`].
    #[error(transparent)]
    Sim(#[from] SimError),
}

impl Ends for RecordingError {
    fn exit(&self) -> Exit {
        match self {
            Self::Write { .. } => Exit::CannotWrite,
            Self::Sim(error) => error.exit(),
        }
    }
}

/// Writes all of a rollout to a file, which appears when it is whole; its folder has to be there.
pub fn record(
    name: &str,
    scene: &CheckedScene,
    rollout: &Rollout,
    renderer: &mut dyn Renderer,
    path: &Path,
) -> Result<(), RecordingError> {
    let mut partial = path.as_os_str().to_owned();
    partial.push(".tmp");
    let partial = PathBuf::from(partial);
    let cannot =
        |source: Box<dyn Error + Send + Sync>| RecordingError::Write { path: path.to_owned(), source };
    let title = format!("{name}, seed {}", rollout.seed.0);
    let recording = RecordingStreamBuilder::new("vantage")
        .recording_id(title.as_str())
        .enabled(true)
        .save(&partial)
        .map_err(|error| cannot(error.into()))?;
    // One with an id of its own is not named by the builder.
    recording.send_recording_name(title).map_err(|error| cannot(error.into()))?;
    log_world(&recording, scene, rollout).map_err(cannot)?;
    let mut observer = Observer::new(scene, rollout);
    let landmarks = observer.landmarks().iter().map(|point| floats(point.coords.into()));
    let landmarks = Points3D::new(landmarks.collect::<Vec<_>>());
    recording.log_static("world/landmarks", &landmarks).map_err(|error| cannot(error.into()))?;
    for step in 0..rollout.steps() {
        let look = observer.look(step, renderer)?;
        log_step(&recording, rollout, step, &look).map_err(cannot)?;
    }
    recording.flush_blocking().map_err(|error| cannot(error.into()))?;
    drop(recording);
    let synced = File::open(&partial).and_then(|file| file.sync_all());
    synced.and_then(|()| rename_durably(&partial, path)).map_err(|error| cannot(error.into()))
}

/// What does not change.
fn log_world(recording: &RecordingStream, scene: &CheckedScene, rollout: &Rollout) -> Logged {
    recording.log_static("world", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    for (n, placement) in rollout.render_scene(scene).placements.iter().enumerate() {
        let object =
            placement.id.checked_sub(NO_OBJECT + 1).and_then(|i| rollout.world.objects.get(i as usize));
        let Some(object) = object else {
            let entity = format!("world/room/{n}");
            recording.log_static(entity.as_str(), &transform(&placement.world_from_model))?;
            // From outside one looks through the walls.
            recording.log_static(entity, &mesh(placement).with_face_rendering(MeshFaceRendering::Front))?;
            continue;
        };
        let entity = format!("world/objects/{n}");
        let bounds = Boxes3D::from_half_sizes([floats(object.half_extents.into())])
            .with_labels([format!("{} {n} ({:016x})", object.family, object.id.0)])
            .with_class_ids([class(n)]);
        recording.log_static(entity.as_str(), &transform(&placement.world_from_model))?;
        recording.log_static(entity.as_str(), &bounds)?;
        recording.log_static(format!("{entity}/mesh"), &mesh(placement))?;
    }
    let truth = &rollout.drive.world_from_robot;
    let odometry = dead_reckoning(rollout.steps(), &rollout.odometry);
    let odometry: Vec<Pose> =
        odometry.iter().filter_map(|start_from_robot| Some(truth.first()? * start_from_robot)).collect();
    for (entity, poses, color) in
        [("world/truth", truth, [0, 160, 0]), ("world/odometry", &odometry, [220, 120, 0])]
    {
        let points: Vec<[f32; 3]> = poses.iter().map(|pose| floats(pose.translation.vector.into())).collect();
        let strip = LineStrips3D::new([points]).with_radii([LINE]).with_colors([color]);
        recording.log_static(entity, &strip)?;
    }
    recording.log_static("world/robot/camera", &transform(&rollout.robot_from_camera))?;
    recording.log_static("world/robot/camera", &pinhole(&rollout.camera))?;
    Ok(())
}

/// What is there at one step.
fn log_step(recording: &RecordingStream, rollout: &Rollout, step: usize, look: &Look) -> Logged {
    recording.set_time_sequence("step", step as i64);
    recording.set_duration_secs("time", rollout.drive.timestamps[step]);
    recording.log("world/robot", &transform(&rollout.drive.world_from_robot[step]))?;
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Adaptive).write_image(
        &look.frame.rgb,
        look.frame.width,
        look.frame.height,
        ExtendedColorType::Rgb8,
    )?;
    recording.log(IMAGE, &EncodedImage::new(png).with_media_type(MediaType::from(MediaType::PNG)))?;

    let detections = || look.detections.iter().map(|(detection, _)| detection);
    let pixels = |point: nalgebra::Vector2<f64>| [point.x as f32, point.y as f32];
    // What shows nothing may have the track of an object.
    let shown = || {
        look.detections.iter().map(|(detection, truth)| {
            let object = rollout.world.objects.get(detection.track).filter(|_| truth.visible_fraction > 0.0);
            object.map(|object| (detection.track, object))
        })
    };
    let labels = shown().map(|shown| match shown {
        Some((track, object)) => format!("{} {track}", object.family),
        None => "nothing".to_owned(),
    });
    let classes = shown().map(|shown| shown.map_or(ClassId::from(0), |(track, _)| class(track)));
    let boxes = Boxes2D::from_mins_and_sizes(
        detections().map(|detection| pixels(detection.bounding_box.min)),
        detections().map(|detection| pixels(detection.bounding_box.max - detection.bounding_box.min)),
    )
    .with_labels(labels)
    .with_class_ids(classes);
    recording.log(format!("{IMAGE}/detections"), &boxes)?;
    let sighted = Points2D::new(look.landmarks.iter().map(|sighting| pixels(sighting.pixel)));
    recording.log(format!("{IMAGE}/landmarks"), &sighted)?;
    Ok(())
}

/// One colour an object; 0 is the colour of nothing.
fn class(object: usize) -> ClassId {
    ClassId::from(u16::try_from(object + 1).unwrap_or(u16::MAX))
}

fn mesh(placement: &Placement) -> Mesh3D {
    let mesh = &placement.model.mesh;
    let texels = placement.model.texture.level(0);
    let side = texels.len().isqrt() as u32;
    let rgba: Vec<u8> = texels.iter().flatten().copied().collect();
    Mesh3D::new(mesh.positions.iter().copied())
        .with_vertex_normals(mesh.normals.iter().copied())
        .with_vertex_texcoords(mesh.uvs.iter().copied())
        .with_triangle_indices(mesh.triangles.iter().copied())
        .with_albedo_texture_image(Image::from_rgba32(rgba, [side, side]))
}

fn transform(pose: &Pose) -> Transform3D {
    let rotation = pose.rotation.coords.map(|x| x as f32);
    Transform3D::from_translation_rotation(
        floats(pose.translation.vector.into()),
        Quaternion::from_xyzw(rotation.into()),
    )
}

fn pinhole(camera: &Camera) -> Pinhole {
    let size = [camera.width as f32, camera.height as f32];
    Pinhole::from_focal_length_and_resolution([camera.fx as f32, camera.fy as f32], size)
        .with_principal_point([camera.cx as f32, camera.cy as f32])
        .with_image_plane_distance(0.3)
}

fn floats(point: [f64; 3]) -> [f32; 3] {
    point.map(|x| x as f32)
}
