//! Pure pursuit: the robot steers towards a point ahead on its path.

use crate::error::{Progress, SimError, Stage};
use crate::robot::body;
use crate::scene::{PathSpec, RobotSpec};
use crate::world::physics::{Body, Physics, RATE};
use nalgebra::{Translation3, Vector2, Vector3};
use vantage_dataset::Pose;

/// Distance along the path of the point it steers to, metres.
const LOOKAHEAD: f64 = 0.25;
/// A robot this far from where it should be has failed, metres.
const TOLERANCE: f64 = 0.3;

/// Where a robot was.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Seconds since the start, one a step.
    pub timestamps: Vec<f64>,
    /// True poses; the robot's origin is on the floor under its centre, x forward, y left, z up.
    pub world_from_robot: Vec<Pose>,
}

/// Drives the path of the spec; its speed is kept to within half a physics step between two images.
pub fn drive(
    physics: &mut Physics,
    spec: &RobotSpec,
    progress: &mut dyn FnMut(Progress),
) -> Result<Drive, SimError> {
    let spacing = spec.laps * spec.path.length() / f64::from(spec.steps - 1);
    let ticks = (spacing / spec.speed * f64::from(RATE)).round().max(1.0);
    let speed = spacing * f64::from(RATE) / ticks;

    let start = spec.path.waypoint(0.0);
    let heading = libm::atan2(start.tangent.y, start.tangent.x);
    let mut pursuit =
        Pursuit { path: &spec.path, body: physics.add_robot(&start.position, heading), travelled: 0.0 };
    let mut drive = Drive { timestamps: Vec::new(), world_from_robot: Vec::new() };
    for step in 0..spec.steps {
        if step > 0 {
            for _ in 0..ticks as u64 {
                pursuit.steer(physics, speed);
                physics.step()?;
            }
        }
        let pose = pursuit.pose(physics);
        let due = spec.path.waypoint(f64::from(step) * spacing).position;
        let distance = (pose.translation.vector.xy() - due).norm();
        if distance > TOLERANCE {
            return Err(SimError::LeftThePath { step: step as usize, distance });
        }
        drive.timestamps.push(f64::from(step) * ticks / f64::from(RATE));
        drive.world_from_robot.push(pose);
        progress(Progress { stage: Stage::Drive, done: u64::from(step) + 1, total: spec.steps.into() });
    }
    Ok(drive)
}

struct Pursuit<'a> {
    path: &'a PathSpec,
    body: Body,
    /// Arc length of the path's point abeam, metres.
    travelled: f64,
}

impl Pursuit<'_> {
    fn pose(&self, physics: &Physics) -> Pose {
        physics.pose(self.body) * Translation3::new(0.0, 0.0, -body::HEIGHT / 2.0)
    }

    fn steer(&mut self, physics: &mut Physics, speed: f64) {
        let pose = self.pose(physics);
        let position = pose.translation.vector.xy();
        let abeam = self.path.waypoint(self.travelled);
        self.travelled += (position - abeam.position).dot(&abeam.tangent);

        let ahead = self.path.waypoint(self.travelled + LOOKAHEAD).position - position;
        let forward: Vector2<f64> = (pose.rotation * Vector3::x()).xy();
        let curvature = 2.0 * forward.perp(&ahead) / ahead.norm_squared();
        physics.push(self.body, &(forward * speed), speed * curvature);
    }
}
