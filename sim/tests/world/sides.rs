//! From which side objects are seen.

use crate::scene::checked;
use std::f64::consts::PI;
use vantage_dataset::{Episode, Seed, Split};
use vantage_sim::checked::SceneSpec;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::simulate;

/// Mean direction to the camera, about each object that is detected in both parts of the drive, before and from a share of its steps on:
/// by how much it turns, degrees, on average over objects.
pub fn turned(spec: &SceneSpec, seed: u64, share: f64) -> f64 {
    let scene = checked(spec.clone());
    let episode =
        simulate(&scene, Seed(seed), Split::Test, &mut ReferenceRenderer::default(), &mut |_| ()).unwrap();
    let first = (share * episode.observations.steps() as f64) as usize;
    let turns: Vec<f64> = (0..episode.truth.objects.len())
        .filter_map(|track| {
            let turn = azimuth(&episode, track, first..usize::MAX)? - azimuth(&episode, track, 0..first)?;
            Some(((turn + PI).rem_euclid(2.0 * PI) - PI).abs().to_degrees())
        })
        .collect();
    assert!(!turns.is_empty(), "no object is seen twice");
    turns.iter().sum::<f64>() / turns.len() as f64
}

/// Circular mean of the azimuths at which an object is detected in some steps, radians.
fn azimuth(episode: &Episode, track: usize, steps: std::ops::Range<usize>) -> Option<f64> {
    let seen = episode.observations.detections.iter().filter(|d| d.track == track && steps.contains(&d.step));
    let (mut x, mut y, mut count) = (0.0, 0.0, 0);
    for detection in seen {
        let camera = episode.truth.world_from_robot[detection.step] * episode.observations.robot_from_camera;
        let to_camera =
            camera.translation.vector - episode.truth.objects[track].world_from_object.translation.vector;
        (x, y, count) =
            (x + to_camera.x / to_camera.xy().norm(), y + to_camera.y / to_camera.xy().norm(), count + 1);
    }
    (count > 0).then(|| libm::atan2(y, x))
}
