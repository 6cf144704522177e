//! What a simulation would cost, before it starts.

use crate::error::SimError;
use crate::scene::{CheckedScene, ViewConditions};
use crate::texture::TEXTURE_SIDE;
use vantage_dataset::crop::CROP_BYTES;

/// Most memory that one episode or one set of views may take, bytes.
pub const MEMORY_LIMIT: u64 = 3_000_000_000;

/// Longest drive that is simulated, seconds.
pub const TIME_LIMIT: f64 = 7200.0;

/// Mipmapped texture, mesh and hull of one object, bytes; meshes of up to about 2000 triangles.
const OBJECT_BYTES: u64 = (TEXTURE_SIDE * TEXTURE_SIDE * 4) as u64 * 4 / 3 + 120_000;
/// Colour, depth and id of one pixel, once in the renderer and once in the frame, bytes.
const PIXEL_BYTES: u64 = 2 * (3 + 4 + 4);
/// A detection with its two crops and its truth, bytes.
const DETECTION_BYTES: u64 = 2 * CROP_BYTES as u64 + 200;
/// A pose, an odometry measurement and a timestamp, bytes.
const STEP_BYTES: u64 = 500;
/// A training view, bytes.
const VIEW_BYTES: u64 = CROP_BYTES as u64 + 100;

/// Refuses an episode that would play too long, or not fit into memory with every object seen at every step.
pub fn check_episode(scene: &CheckedScene) -> Result<(), SimError> {
    let robot = scene.robot();
    let seconds = robot.laps * robot.path.length() / robot.speed;
    if seconds > TIME_LIMIT {
        return Err(SimError::TooLong { seconds, limit: TIME_LIMIT });
    }
    let camera = &scene.sensors().camera;
    let (objects, steps) = (u64::from(scene.world().objects), u64::from(robot.steps));
    let pixels = u64::from(camera.width).saturating_mul(u64::from(camera.height));
    let bytes = objects
        .saturating_mul(OBJECT_BYTES)
        .saturating_add(pixels.saturating_mul(PIXEL_BYTES))
        .saturating_add(steps.saturating_mul(STEP_BYTES))
        .saturating_add(objects.saturating_mul(steps).saturating_mul(DETECTION_BYTES));
    refuse_above_limit(
        bytes,
        "the episode",
        "`world.objects`, `robot.steps` or the camera's `width` and `height`",
    )
}

/// Refuses a set of views that would not fit into memory.
pub fn check_views(conditions: &ViewConditions, instances: usize) -> Result<(), SimError> {
    let views = (instances as u64).saturating_mul(u64::from(conditions.views.views_per_instance));
    refuse_above_limit(
        views.saturating_mul(VIEW_BYTES),
        "the set of views",
        "the instances or `views.views_per_instance`",
    )
}

fn refuse_above_limit(bytes: u64, what: &'static str, remedy: &'static str) -> Result<(), SimError> {
    if bytes > MEMORY_LIMIT {
        return Err(SimError::TooLarge { what, bytes, limit: MEMORY_LIMIT, remedy });
    }
    Ok(())
}
