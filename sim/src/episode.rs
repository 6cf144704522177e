//! Episodes: one robot goes through one world and observes it.

use crate::error::{Progress, SimError, Stage};
use crate::observer::{Look, Observer};
use crate::render::Renderer;
use crate::rollout::{Rollout, roll_out};
use crate::scene::CheckedScene;
use vantage_dataset::{Episode, Observations, Seed, Split, Truth};

/// Makes an episode with objects of the given split.
pub fn simulate(
    scene: &CheckedScene,
    seed: Seed,
    split: Split,
    renderer: &mut dyn Renderer,
    progress: &mut dyn FnMut(Progress),
) -> Result<Episode, SimError> {
    let rollout = roll_out(scene, seed, split, progress)?;
    observe(scene, &rollout, renderer, progress, |_, _, _, _| Ok(()))
}

/// Observes a rollout, and hands every look on with its step before it is forgotten.
pub fn observe<E: From<SimError>>(
    scene: &CheckedScene,
    rollout: &Rollout,
    renderer: &mut dyn Renderer,
    progress: &mut dyn FnMut(Progress),
    mut each: impl FnMut(&Observer<'_>, usize, &Look, &mut dyn Renderer) -> Result<(), E>,
) -> Result<Episode, E> {
    let mut observer = Observer::new(scene, rollout);
    let (mut detections, mut detection_truths) = (Vec::new(), Vec::new());
    let mut landmarks = Vec::new();
    for step in 0..rollout.steps() {
        let look = observer.look(step, renderer)?;
        each(&observer, step, &look, renderer)?;
        for (detection, truth) in look.detections {
            detections.push(detection);
            detection_truths.push(truth);
        }
        landmarks.extend(look.landmarks);
        let total = rollout.steps() as u64;
        progress(Progress { stage: Stage::Observe, done: step as u64 + 1, total });
    }
    Ok(Episode {
        truth: Truth {
            objects: rollout.world.truth(),
            world_from_robot: rollout.drive.world_from_robot.clone(),
            landmarks: observer.landmarks().to_vec(),
            detections: detection_truths,
        },
        observations: Observations {
            seed: rollout.seed,
            timestamps: rollout.drive.timestamps.clone(),
            camera: rollout.camera,
            robot_from_camera: rollout.robot_from_camera,
            odometry: rollout.odometry.clone(),
            detections,
            landmarks,
        },
    })
}
