//! All of an episode that needs no renderer: physics, odometry and labels.

use crate::budget;
use crate::checked::CheckedScene;
use crate::error::{Progress, SimError};
use crate::render::{Light, NO_OBJECT, Placement, RenderScene, Shot};
use crate::robot::{Drive, drive};
use crate::scene::{PathSpec, WorldSpec};
use crate::sensor::detector::Target;
use crate::sensor::odometry;
use crate::world::{World, lighting, surroundings};
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use vantage_dataset::{Camera, Odometry, Pose, Seed, Split};

/// A world, and a robot's way through it.
pub struct Rollout {
    /// The seed that made it.
    pub seed: Seed,
    /// The world, at rest but for the robot.
    pub world: World,
    /// Where the robot was.
    pub drive: Drive,
    /// What its wheels said.
    pub odometry: Vec<Odometry>,
    /// Intrinsics of the camera.
    pub camera: Camera,
    /// Where the camera sits.
    pub robot_from_camera: Pose,
    /// How far a turntable has turned at each step, radians; empty where none turns.
    table_angles: Vec<f64>,
    /// The first step under another light, and that light.
    relit: Option<(usize, Light)>,
}

/// Makes the world and drives the robot through it. Streams of randomness are named by what they decide, so that, for
/// example, other odometry noise leaves the poses as they were.
pub fn roll_out(
    scene: &CheckedScene,
    seed: Seed,
    split: Split,
    progress: &mut dyn FnMut(Progress),
) -> Result<Rollout, SimError> {
    budget::check_episode(scene)?;
    let mut world = World::settled(scene, split, seed, progress)?;
    let ground = world.ground(&scene.world().room);
    let drive = drive(&mut world.physics, scene.robot(), &ground, seed, progress)?;
    let odometry = odometry::measure(&scene.sensors().odometry, &drive.world_from_robot, drive.carried, seed);
    Ok(Rollout {
        seed,
        relit: relit(scene.world(), &drive, seed),
        world,
        drive,
        odometry,
        camera: scene.sensors().camera.intrinsics(),
        robot_from_camera: scene.robot().camera.robot_from_camera(),
        table_angles: table_angles(&scene.robot().path),
    })
}

fn table_angles(path: &PathSpec) -> Vec<f64> {
    let PathSpec::Turntable { elevations_deg, angles, .. } = path else { return Vec::new() };
    (0..*angles)
        .flat_map(|angle| {
            elevations_deg.iter().map(move |_| 2.0 * PI * f64::from(angle) / f64::from(*angles))
        })
        .collect()
}

fn relit(spec: &WorldSpec, drive: &Drive, seed: Seed) -> Option<(usize, Light)> {
    let (at, middle) = (spec.relit_at?, drive.middle);
    // Each half of the drive counts as a half, however long it is.
    let share_of_the_drive =
        if at < 0.5 { 2.0 * at * middle } else { middle + 2.0 * (at - 0.5) * (1.0 - middle) };
    let steps = drive.world_from_robot.len();
    let last = steps.saturating_sub(1) as f64;
    let first = (0..steps).find(|&step| step as f64 > share_of_the_drive * last)?;
    Some((first, lighting::draw(&spec.lighting, &mut seed.stream("light", 1))))
}

impl Rollout {
    /// How many images there are.
    pub fn steps(&self) -> usize {
        self.drive.world_from_robot.len()
    }

    /// Whether one object is turned before cameras that it fills.
    pub fn is_turntable(&self) -> bool {
        !self.table_angles.is_empty()
    }

    /// Everything that is drawn, under the light at the start; object `i` has the id `i + 1`.
    pub fn render_scene(&self, scene: &CheckedScene) -> RenderScene {
        let spec = scene.world();
        let objects = self.world.objects.iter().zip(&self.world.world_from_object);
        let mut placements: Vec<Placement> = objects
            .enumerate()
            .map(|(i, (object, world_from_object))| Placement {
                model: Arc::clone(&object.model),
                world_from_model: *world_from_object,
                id: NO_OBJECT + 1 + i as u32,
            })
            .collect();
        let World { furnishing, fixtures, .. } = &self.world;
        placements.extend(surroundings::placements(&spec.room, furnishing, fixtures, self.seed));
        let ceiling = (150.0 + 90.0 * self.seed.stream("ceiling", 0).unit()) as u8;
        RenderScene {
            placements,
            light: lighting::draw(&spec.lighting, &mut self.seed.stream("light", 0)),
            background: [ceiling; 3],
        }
    }

    /// What the camera sees at a step.
    pub fn shot(&self, step: usize) -> Shot {
        Shot {
            camera: self.camera,
            world_from_camera: self.drive.world_from_robot[step] * self.robot_from_camera,
        }
    }

    /// The light at a step: another one from a share of the drive on, if the scene says so. In a world that a turntable turns
    /// with its object, it stays where the cameras are.
    pub fn light(&self, step: usize, at_start: &Light) -> Light {
        if let Some((first, relit)) = &self.relit
            && step >= *first
        {
            return *relit;
        }
        let Some(&angle) = self.table_angles.get(step) else { return *at_start };
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        Light { direction: turn * at_start.direction, ..*at_start }
    }

    /// What the detector looks for, alone under the light at the start: of it only pixels are counted.
    pub fn targets(&self, render_scene: &RenderScene) -> Vec<Target> {
        self.world
            .objects
            .iter()
            .zip(&render_scene.placements)
            .map(|(object, placement)| Target {
                world_from_object: placement.world_from_model,
                half_extents: object.half_extents,
                alone: RenderScene {
                    placements: vec![placement.clone()],
                    light: render_scene.light,
                    background: render_scene.background,
                },
            })
            .collect()
    }
}
