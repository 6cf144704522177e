//! Whether the robot's path and camera fit into the world.

use crate::plan::body::RADIUS as ROBOT_RADIUS;
use crate::plan::ground::Ground;
use crate::plan::revisit::Revisit;
use crate::plan::track::Track;
use crate::plan::{inside_and_outside, random_loop};
use crate::scene::{
    InsideAndOutsideSpec, PathSpec, RandomLoopSpec, RevisitSpec, RobotSpec, SurfaceSpec, WorldSpec,
};
use garde::Validate;
use std::f64::consts::PI;

/// Distance between the points of a path that are checked, metres.
pub(super) const STRIDE: f64 = 0.02;

/// Most points of a path that are checked.
const SAMPLES: f64 = 20_000.0;

/// No path is longer, metres: at full speed, as long as an episode may take.
const LONGEST: f64 = 14_400.0;

/// Places that are looked at for one to cross a ring at.
const CROSSINGS: u32 = 360;

/// Of so many pedestals, all are as far from the path.
pub(super) const MANY: u32 = 1000;

/// The rules between parts: the path stays in the room and clear of what the objects stand on, and fits to it. Random walks,
/// random loops and grids keep clear by themselves; where furniture is in the way of a drawn path, its seed is refused.
pub fn fits_into(world: &WorldSpec) -> impl Fn(&RobotSpec, &()) -> garde::Result {
    move |robot, ()| {
        // Rules between parts are for parts that keep their own.
        let sound = robot.path.validate().is_ok() && world.surface.validate().is_ok();
        if !sound || world.room.validate().is_err() {
            return Ok(());
        }
        if robot.camera.height >= world.room.height {
            return Err(garde::Error::new(format!(
                "robot.camera.height, {} m, is above the walls, {} m",
                robot.camera.height, world.room.height
            )));
        }
        if world.relit_at.is_some() && robot.path.stations() {
            return Err(garde::Error::new(
                "world.relit_at changes the light during a drive, and nothing drives from station to station; leave it out",
            ));
        }
        let Some(track) = Track::fixed(&robot.path) else { return fits_without_track(world, robot) };
        let after = robot.reverse_after.filter(|_| robot.path.is_closed()).map(|laps| laps * track.length());
        let track = match after {
            Some(after) if after.is_finite() => track.turned_back(after),
            _ => track,
        };
        track_fits(&track, ROBOT_RADIUS, world, robot)
    }
}

/// Holds a track to the room, and its clearance to a margin.
fn track_fits(track: &Track, margin: f64, world: &WorldSpec, robot: &RobotSpec) -> garde::Result {
    if track.length() > LONGEST {
        return Err(garde::Error::new(format!(
            "the path is {:.0} m long, expected at most {LONGEST} m",
            track.length()
        )));
    }
    let [room_x, room_y] = [world.room.length / 2.0, world.room.width / 2.0];
    let stride = STRIDE.max(track.length() / SAMPLES);
    let reach = |axis: usize| {
        let positions = track.samples(stride).map(|waypoint| waypoint.position[axis].abs());
        positions.fold(0.0, f64::max) + margin
    };
    let [reach_x, reach_y] = [reach(0), reach(1)];
    if reach_x > room_x || reach_y > room_y {
        return Err(garde::Error::new(format!(
            "the path needs a room of at least {:.2} x {:.2} m, got {} x {} m; enlarge world.room or shrink robot.path",
            2.0 * reach_x,
            2.0 * reach_y,
            world.room.length,
            world.room.width
        )));
    }
    let points = track.samples(stride).map(|waypoint| waypoint.position);
    match ground(world, robot).narrowest(points) {
        Some((gap, at)) if gap < margin => Err(garde::Error::new(format!(
            "the robot would bump into world.surface: at ({:.2}, {:.2}) the path passes at {gap:.2} m, expected at least \
             {margin:.2} m; widen the path or the offset, or shrink the surface",
            at.x, at.y
        ))),
        _ => Ok(()),
    }
}

/// The plan of the room without furniture from files.
fn ground(world: &WorldSpec, robot: &RobotSpec) -> Ground {
    let furnishing = world.surface.furnish(robot, world.objects.min(MANY) as usize);
    Ground::new(&world.room, furnishing.obstacles())
}

fn fits_without_track(world: &WorldSpec, robot: &RobotSpec) -> garde::Result {
    match (&robot.path, &world.surface) {
        (PathSpec::InsideAndOutside(spec), _) => ring_fits(spec, world, robot),
        (_, SurfaceSpec::Pedestals { .. }) => Err(garde::Error::new(
            "world.surface.pedestals stand beside a path that is the same for every seed; choose another path, or \
             furniture",
        )),
        (PathSpec::Turntable { distance, .. }, SurfaceSpec::RoundTable { height, .. })
            if world.objects == 1 =>
        {
            let walls = world.room.length.min(world.room.width) / 2.0;
            if *distance >= walls || distance + robot.camera.height >= world.room.height {
                return Err(garde::Error::new(format!(
                    "cameras {distance} m from the object would stand in the walls or the ceiling; enlarge world.room"
                )));
            }
            if robot.camera.height < *height {
                return Err(garde::Error::new(format!(
                    "the cameras look at robot.camera.height, {} m, which is below the table's top at {height} m",
                    robot.camera.height
                )));
            }
            Ok(())
        }
        (PathSpec::Turntable { .. }, _) => Err(garde::Error::new(
            "the turntable path looks at one object: world.objects must be 1, and world.surface a round_table",
        )),
        (PathSpec::Revisit(spec), _) => revisit_fits(spec, world),
        (PathSpec::RandomLoop(spec), _) => loop_fits(spec, world),
        _ => Ok(()),
    }
}

/// Holds both laps to the room and what stands in it, and looks for a place where every seed could cross.
fn ring_fits(spec: &InsideAndOutsideSpec, world: &WorldSpec, robot: &RobotSpec) -> garde::Result {
    let margin = ROBOT_RADIUS + spec.clearance;
    for radius in [spec.outer_radius, spec.inner_radius] {
        track_fits(&Track::circle(radius), margin, world, robot)?;
    }
    let ground = ground(world, robot);
    let free = |i: u32| {
        let track = inside_and_outside::track(spec, true, 2.0 * PI * f64::from(i) / f64::from(CROSSINGS));
        let [from, to] = [2.0 * PI * spec.outer_radius, track.length() - 2.0 * PI * spec.inner_radius];
        let places = (0..=((to - from) / STRIDE) as u32).map(|k| from + STRIDE * f64::from(k));
        let crossing = places.map(|along| track.waypoint(along).position);
        ground.narrowest(crossing).is_some_and(|(gap, _)| gap >= margin)
    };
    if (0..CROSSINGS).any(free) {
        return Ok(());
    }
    Err(garde::Error::new(format!(
        "nowhere is a gap in world.surface wide enough to cross between the laps, {:.2} m and more; use fewer or smaller stands, \
         or a smaller path.inside_and_outside.clearance",
        2.0 * margin
    )))
}

/// Holds every seed's loop to the room and to a table in its middle.
fn loop_fits(spec: &RandomLoopSpec, world: &WorldSpec) -> garde::Result {
    let margin = ROBOT_RADIUS + spec.clearance;
    let [nearest, farthest] = random_loop::reach(spec);
    let needed = 2.0 * (farthest + margin);
    if needed > world.room.length.min(world.room.width) {
        return Err(garde::Error::new(format!(
            "the path of some seeds needs a room of {needed:.2} x {needed:.2} m, got {} x {} m; enlarge world.room, or lower \
             path.random_loop.radius or its amplitude",
            world.room.length, world.room.width
        )));
    }
    let least = half_table(&world.surface) + margin;
    if nearest < least {
        return Err(garde::Error::new(format!(
            "the robot would bump into world.surface: some seeds come as near as {nearest:.2} m to its middle, expected at least \
             {least:.2} m; raise path.random_loop.radius, or lower its amplitude or clearance"
        )));
    }
    Ok(())
}

/// Distance from its middle that a table reaches to, metres; 0 without one.
fn half_table(surface: &SurfaceSpec) -> f64 {
    match surface {
        SurfaceSpec::RoundTable { radius, .. } => *radius,
        SurfaceSpec::RectangularTable { length, width, .. } => libm::hypot(*length, *width) / 2.0,
        SurfaceSpec::Pedestals { .. } | SurfaceSpec::Furniture(_) => 0.0,
    }
}

/// Holds every seed's path to the room and to a table in its middle.
fn revisit_fits(spec: &RevisitSpec, world: &WorldSpec) -> garde::Result {
    let revisit = Revisit::new(spec);
    let least = revisit.least_detour();
    let Some(reach) = revisit.reach().filter(|_| spec.detour >= least) else {
        return Err(garde::Error::new(format!(
            "path.revisit.detour, {} m, is too short to come round between such passes, expected at least {least:.2} m",
            spec.detour
        )));
    };
    let needed = 2.0 * (reach + ROBOT_RADIUS);
    if needed > world.room.length.min(world.room.width) {
        return Err(garde::Error::new(format!(
            "the path of some seeds needs a room of {needed:.2} x {needed:.2} m, got {} x {} m; enlarge world.room or \
             shorten path.revisit.detour",
            world.room.length, world.room.width
        )));
    }
    let table = half_table(&world.surface);
    if spec.distance < table + ROBOT_RADIUS {
        return Err(garde::Error::new(format!(
            "the robot would bump into world.surface: the passes are {} m from its middle, expected at least {:.2} m; \
             raise path.revisit.distance or shrink the table",
            spec.distance,
            table + ROBOT_RADIUS
        )));
    }
    Ok(())
}
