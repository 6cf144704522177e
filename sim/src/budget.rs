//! What a simulation would cost, before it starts.

use crate::checked::{CheckedScene, ViewConditions};
use crate::error::SimError;
use crate::object::Draw;
use crate::plan::track::{TURN, Track};
use crate::plan::{inside_and_outside, random_loop};
use crate::scene::{PathSpec, SensorSpec};
use crate::texture::TEXTURE_SIDE;
use vantage_dataset::crop::CROP_BYTES;

/// Most memory that one episode or one set of views may take, bytes.
pub const MEMORY_LIMIT: u64 = 3_000_000_000;

/// Most memory that the meshes of one world, or of instances that are made together, may take, bytes.
pub const MESHES_LIMIT: u64 = 1_500_000_000;

/// Longest drive that is simulated, seconds.
pub const TIME_LIMIT: f64 = 7200.0;

/// Mipmapped texture, mesh and hull of one object, bytes; meshes of up to about 2000 triangles.
const OBJECT_BYTES: u64 = (TEXTURE_SIDE * TEXTURE_SIDE * 4) as u64 * 4 / 3 + 120_000;
/// Colour, depth and id of one pixel, once in the renderer and once in the frame, bytes.
const PIXEL_BYTES: u64 = 2 * (3 + 4 + 4);
/// A detection with its two crops and its truth, bytes.
const DETECTION_BYTES: u64 = 2 * CROP_BYTES as u64 + 200;
/// A sighting of a landmark, bytes.
const SIGHTING_BYTES: u64 = 48;
/// A pose, an odometry measurement and a timestamp, bytes.
const STEP_BYTES: u64 = 500;
/// A training view, bytes.
const VIEW_BYTES: u64 = CROP_BYTES as u64 + 100;

/// Refuses an episode that would play too long, or not fit into memory with every object seen at every step.
pub fn check_episode(scene: &CheckedScene) -> Result<(), SimError> {
    let robot = scene.robot();
    let turn = if robot.reverse_after.is_some() { TURN } else { 0.0 };
    let seconds = (robot.laps * longest(&robot.path) + turn) / robot.speed;
    if seconds > TIME_LIMIT {
        return Err(SimError::TooLong { seconds, limit: TIME_LIMIT });
    }
    let camera = &scene.sensors().camera;
    let (objects, steps) = (u64::from(scene.world().objects), images(scene));
    let pixels = u64::from(camera.width).saturating_mul(u64::from(camera.height));
    let bytes = objects
        .saturating_mul(OBJECT_BYTES)
        .saturating_add(pixels.saturating_mul(PIXEL_BYTES))
        .saturating_add(steps.saturating_mul(STEP_BYTES))
        .saturating_add(objects.saturating_mul(steps).saturating_mul(DETECTION_BYTES))
        .saturating_add(steps.saturating_mul(extras(scene.sensors())));
    refuse_above_limit(
        bytes,
        MEMORY_LIMIT,
        "the episode",
        "robot.steps",
        "`world.objects`, `robot.steps`, landmarks, false detections or the camera's `width` and `height`",
    )
}

/// Bytes of landmarks and of detections of nothing in an image.
fn extras(sensors: &SensorSpec) -> u64 {
    let landmarks = sensors.landmarks.as_ref().map_or(0, |spec| u64::from(spec.count));
    let nothing = sensors.detector.faults.as_ref().map_or(0.0, |faults| faults.false_per_image.ceil());
    landmarks * SIGHTING_BYTES + nothing as u64 * DETECTION_BYTES
}

/// No track of a path is longer, metres; 0 where nothing drives.
fn longest(path: &PathSpec) -> f64 {
    match path {
        PathSpec::RandomWalk { legs, leg_length, .. } => f64::from(*legs) * leg_length.high(),
        PathSpec::RandomLoop(spec) => random_loop::longest(spec),
        PathSpec::InsideAndOutside(spec) => inside_and_outside::track(spec, true, 0.0).length(),
        PathSpec::Revisit(spec) => 2.0 * spec.pass + spec.detour,
        _ => Track::fixed(path).map_or(0.0, |track| track.length()),
    }
}

/// No episode has more images.
fn images(scene: &CheckedScene) -> u64 {
    let robot = scene.robot();
    match &robot.path {
        PathSpec::Turntable { elevations_deg, angles, .. } => {
            elevations_deg.len() as u64 * u64::from(*angles)
        }
        PathSpec::Grid { spacing, headings, .. } => {
            let room = &scene.world().room;
            let points = (room.length / spacing + 1.0) * (room.width / spacing + 1.0);
            points as u64 * u64::from(*headings)
        }
        _ => robot.steps.unwrap_or(0).into(),
    }
}

/// Refuses meshes that would not fit into memory together: those of a world, or those whose views are made together.
pub fn check_meshes(draws: &[Draw<'_>]) -> Result<(), SimError> {
    let bytes = draws.iter().map(|draw| match draw {
        Draw::Family(_) => OBJECT_BYTES,
        Draw::Mesh(mesh) => mesh.bytes,
    });
    refuse_above_limit(
        bytes.fold(0, u64::saturating_add),
        MESHES_LIMIT,
        "the meshes that are drawn together",
        "world.meshes",
        "`world.objects`, or the triangles of `world.meshes`",
    )
}

/// Refuses a set of views that would not fit into memory.
pub fn check_views(conditions: &ViewConditions, instances: usize) -> Result<(), SimError> {
    let views = (instances as u64).saturating_mul(u64::from(conditions.views.views_per_instance));
    refuse_above_limit(
        views.saturating_mul(VIEW_BYTES),
        MEMORY_LIMIT,
        "the set of views",
        "views.views_per_instance",
        "the instances or `views.views_per_instance`",
    )
}

fn refuse_above_limit(
    bytes: u64,
    limit: u64,
    what: &'static str,
    field: &'static str,
    remedy: &'static str,
) -> Result<(), SimError> {
    if bytes > limit {
        return Err(SimError::TooLarge { what, bytes, limit, field, remedy });
    }
    Ok(())
}
