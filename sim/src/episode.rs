//! Episodes: one robot goes through one world and observes it.

use crate::error::{Progress, SimError, Stage};
use crate::observer::Observer;
use crate::render::Renderer;
use crate::rollout::roll_out;
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
    let mut observer = Observer::new(scene, &rollout);
    let (mut detections, mut detection_truths) = (Vec::new(), Vec::new());
    let mut landmarks = Vec::new();
    for step in 0..rollout.steps() {
        let look = observer.look(step, renderer)?;
        for (detection, truth) in look.detections {
            detections.push(detection);
            detection_truths.push(truth);
        }
        landmarks.extend(look.landmarks);
        let total = rollout.steps() as u64;
        progress(Progress { stage: Stage::Observe, done: step as u64 + 1, total });
    }
    let landmarks_in_world = observer.landmarks().to_vec();
    Ok(Episode {
        truth: Truth {
            objects: rollout.world.truth(),
            world_from_robot: rollout.drive.world_from_robot,
            landmarks: landmarks_in_world,
            detections: detection_truths,
        },
        observations: Observations {
            seed,
            timestamps: rollout.drive.timestamps,
            camera: rollout.camera,
            robot_from_camera: rollout.robot_from_camera,
            odometry: rollout.odometry,
            detections,
            landmarks,
        },
    })
}
