//! Episodes: one robot goes through one world and observes it.

use crate::checked::CheckedScene;
use crate::error::{Progress, SimError, Stage};
use crate::observer::{Look, Observer};
use crate::render::Renderer;
use crate::rollout::{Rollout, roll_out};
use crate::sensor::close_up;
use vantage_dataset::{Episode, Observations, Seed, Split, Truth};

/// What may be done with a look.
pub type OnLook<'a, E> = dyn FnMut(&Observer<'_>, usize, &Look, &mut dyn Renderer) -> Result<(), E> + 'a;

/// Makes an episode with objects of the given split.
pub fn simulate(
    scene: &CheckedScene,
    seed: Seed,
    split: Split,
    renderer: &mut dyn Renderer,
    progress: &mut dyn FnMut(Progress),
) -> Result<Episode, SimError> {
    let rollout = roll_out(scene, seed, split, progress)?;
    observe::<SimError>(scene, &rollout, renderer, progress, None)
}

/// Observes a rollout, and hands every look on with its step before it is forgotten.
///
/// On a turntable, detections come from tiles that the object fills, whatever is done with the looks.
pub fn observe<E: From<SimError>>(
    scene: &CheckedScene,
    rollout: &Rollout,
    renderer: &mut dyn Renderer,
    progress: &mut dyn FnMut(Progress),
    mut each: Option<&mut OnLook<'_, E>>,
) -> Result<Episode, E> {
    let mut observer = Observer::new(scene, rollout);
    let mut seen = if rollout.is_turntable() {
        let target = &observer.targets()[0];
        let setting = |step: usize| observer.setting(step);
        close_up::detect(scene.sensors(), target, rollout.steps(), setting, renderer, rollout.seed)?
    } else {
        Vec::new()
    };
    let whole_images = !rollout.is_turntable() || each.is_some() || scene.sensors().landmarks.is_some();
    let mut landmarks = Vec::new();
    for step in 0..if whole_images { rollout.steps() } else { 0 } {
        let look = observer.look(step, renderer)?;
        if let Some(each) = &mut each {
            each(&observer, step, &look, renderer)?;
        }
        if !rollout.is_turntable() {
            seen.extend(look.detections);
        }
        landmarks.extend(look.landmarks);
        let total = rollout.steps() as u64;
        progress(Progress { stage: Stage::Observe, done: step as u64 + 1, total });
    }
    let (detections, detection_truths) = seen.into_iter().unzip();
    Ok(Episode {
        seed: rollout.seed,
        truth: Truth {
            objects: rollout.world.truth(),
            world_from_robot: rollout.drive.world_from_robot.clone(),
            landmarks: observer.landmarks().to_vec(),
            detections: detection_truths,
        },
        observations: Observations {
            timestamps: rollout.drive.timestamps.clone(),
            camera: rollout.camera,
            robot_from_camera: rollout.robot_from_camera,
            odometry: rollout.odometry.clone(),
            detections,
            landmarks,
        },
    })
}
