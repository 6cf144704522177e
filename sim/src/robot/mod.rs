//! The robot: its way and its camera, `x_{k+1} = f(x_k, u_k)`.

mod hand;
mod inside_and_outside;
pub mod mount;
mod pursuit;
mod random_loop;
mod revisit;
mod stations;
mod walk;

use crate::error::{Progress, SimError};
use crate::physics::Physics;
use crate::plan::body;
use crate::plan::ground::Ground;
use crate::plan::track::Track;
use crate::robot::pursuit::Carried;
use crate::scene::{PathSpec, RobotSpec, StartSpec};
use vantage_dataset::{Pose, Seed};

/// Distance between the places of a track that are looked at, metres.
const STRIDE: f64 = 0.05;

/// Where a robot was.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Seconds since the start, one a step.
    pub timestamps: Vec<f64>,
    /// True poses; the robot's origin is on the floor under its centre, x forward, y left, z up.
    pub world_from_robot: Vec<Pose>,
    /// Share of the way at which its second half begins: where the ring is crossed, of one with a lap outside and one inside.
    pub middle: f64,
    /// The step before which it was carried somewhere.
    pub carried: Option<usize>,
}

/// Goes where the spec says. A robot drives, its speed kept to within half a physics step between two images; a hand sways
/// about what it would have driven; a camera at stations is put there.
pub fn drive(
    physics: &mut Physics,
    spec: &RobotSpec,
    ground: &Ground,
    seed: Seed,
    progress: &mut dyn FnMut(Progress),
) -> Result<Drive, SimError> {
    let mut drive = if spec.path.stations() {
        stations::visit(spec, ground)?
    } else {
        let track = track(spec, ground, seed)?;
        let carried = spec.carried_after.map(|laps| Carried {
            after: laps * track.length(),
            by: track.length() * seed.stream("carried", 0).unit(),
        });
        pursuit::pursue(physics, spec, &track, carried, progress)?
    };
    if let Some(hand) = &spec.handheld {
        hand::sway(hand, &spec.camera.robot_from_camera(), &mut drive, seed);
    }
    Ok(drive)
}

/// The track of an episode.
fn track(robot: &RobotSpec, ground: &Ground, seed: Seed) -> Result<Track, SimError> {
    let mut track = match (&robot.path, Track::fixed(&robot.path)) {
        (_, Some(track)) => track,
        (PathSpec::RandomWalk { legs, leg_length, clearance }, None) => {
            let mut stream = seed.stream("walk", 0);
            Track::along(walk::draw(*legs, *leg_length, *clearance, ground, &mut stream)?)
        }
        (PathSpec::RandomLoop(spec), None) => {
            random_loop::draw(spec, ground, &mut seed.stream("random loop", 0))?
        }
        (PathSpec::InsideAndOutside(spec), None) => {
            inside_and_outside::draw(spec, ground, &mut seed.stream("inside and outside", 0))?
        }
        (PathSpec::Revisit(spec), None) => {
            let track = Track::along(revisit::draw(spec, &mut seed.stream("revisit", 0))?);
            keeps_clear(&track, ground)?;
            track
        }
        (_, None) => return Err(SimError::NoTrack),
    };
    if robot.start == StartSpec::Anywhere && robot.path.is_closed() {
        let start = track.length() * seed.stream("start", 0).unit();
        track = track.begun_at(start);
    }
    let Some(laps) = robot.reverse_after else { return Ok(track) };
    let after = laps * track.length();
    let track = track.turned_back(after);
    keeps_clear(&track, ground)?;
    Ok(track)
}

/// Whether a drawn track keeps the robot's body clear of everything.
fn keeps_clear(track: &Track, ground: &Ground) -> Result<(), SimError> {
    match ground.narrowest(track.samples(STRIDE).map(|waypoint| waypoint.position)) {
        Some((gap, at)) if gap < body::RADIUS => Err(SimError::BlockedPath { at: at.into(), gap }),
        _ => Ok(()),
    }
}
