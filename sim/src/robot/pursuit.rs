//! Pure pursuit: the robot steers towards a point ahead on its track.

use super::Drive;
use crate::error::{Progress, SimError, Stage};
use crate::physics::{Body, Physics, RATE};
use crate::plan::body;
use crate::plan::track::Track;
use crate::scene::RobotSpec;
use nalgebra::{Translation3, Vector2, Vector3};
use vantage_dataset::Pose;

/// Distance along the path of the point it steers to, metres.
const LOOKAHEAD: f64 = 0.25;
/// A robot this far from where it should be has failed, metres.
const TOLERANCE: f64 = 0.3;

/// That the robot is lifted, and set down elsewhere on its track.
#[derive(Clone, Copy)]
pub(super) struct Carried {
    /// Distance driven before, metres.
    pub after: f64,
    /// How far along the track, metres.
    pub by: f64,
}

/// Drives along the track of an episode.
pub(super) fn pursue(
    physics: &mut Physics,
    spec: &RobotSpec,
    track: &Track,
    carried: Option<Carried>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Drive, SimError> {
    let steps = spec.steps.unwrap_or(2);
    let spacing = track.driven(spec.laps) / f64::from(steps - 1);
    let ticks = (spacing / spec.speed * f64::from(RATE)).round().max(1.0);
    let speed = spacing * f64::from(RATE) / ticks;

    let start = track.waypoint(0.0);
    let heading = libm::atan2(start.tangent.y, start.tangent.x);
    let mut pursuit = Pursuit { track, body: physics.add_robot(&start.position, heading), travelled: 0.0 };
    let mut drive = Drive {
        timestamps: Vec::new(),
        world_from_robot: Vec::new(),
        middle: track.middle(spec.laps),
        carried: None,
    };
    for step in 0..steps {
        let driven = f64::from(step) * spacing;
        let carried = carried.filter(|carried| driven > carried.after);
        let place = driven + carried.map_or(0.0, |carried| carried.by);
        if carried.is_some() && drive.carried.is_none() {
            drive.carried = Some(step as usize);
            pursuit.set_down(physics, place);
        } else if step > 0 {
            for _ in 0..ticks as u64 {
                pursuit.steer(physics, speed);
                physics.step()?;
            }
        }
        let pose = pursuit.pose(physics);
        let due = track.waypoint(place).position;
        let distance = (pose.translation.vector.xy() - due).norm();
        if distance > TOLERANCE {
            return Err(SimError::LeftThePath { step: step as usize, distance });
        }
        drive.timestamps.push(f64::from(step) * ticks / f64::from(RATE));
        drive.world_from_robot.push(pose);
        progress(Progress { stage: Stage::Drive, done: u64::from(step) + 1, total: steps.into() });
    }
    Ok(drive)
}

struct Pursuit<'a> {
    track: &'a Track,
    body: Body,
    /// Arc length of the path's point abeam, metres.
    travelled: f64,
}

impl Pursuit<'_> {
    fn pose(&self, physics: &Physics) -> Pose {
        physics.pose(self.body) * Translation3::new(0.0, 0.0, -body::HEIGHT / 2.0)
    }

    fn set_down(&mut self, physics: &mut Physics, place: f64) {
        self.travelled = place;
        let waypoint = self.track.waypoint(place);
        let heading = libm::atan2(waypoint.tangent.y, waypoint.tangent.x);
        physics.set_down(self.body, &waypoint.position, heading);
    }

    fn steer(&mut self, physics: &mut Physics, speed: f64) {
        let pose = self.pose(physics);
        let position = pose.translation.vector.xy();
        let abeam = self.track.waypoint(self.travelled);
        self.travelled += (position - abeam.position).dot(&abeam.tangent);

        let ahead = self.track.waypoint(self.travelled + LOOKAHEAD).position - position;
        let forward: Vector2<f64> = (pose.rotation * Vector3::x()).xy();
        let curvature = 2.0 * forward.perp(&ahead) / ahead.norm_squared();
        physics.push(self.body, &(forward * speed), speed * curvature);
    }
}
