//! Whether the robot's path and camera fit into the world.

use crate::plan::body::RADIUS as ROBOT_RADIUS;
use crate::plan::ground::Ground;
use crate::plan::revisit::Revisit;
use crate::plan::track::Track;
use crate::scene::{PathSpec, RevisitSpec, RobotSpec, SurfaceSpec, WorldSpec};
use garde::Validate;

/// Distance between the points of a path that are checked, metres.
pub(super) const STRIDE: f64 = 0.02;

/// Most points of a path that are checked.
const SAMPLES: f64 = 20_000.0;

/// No path is longer, metres: at full speed, as long as an episode may take.
const LONGEST: f64 = 14_400.0;

/// Of so many pedestals, all are as far from the path.
pub(super) const MANY: u32 = 1000;

/// The rules between parts: the path stays in the room and clear of what the objects stand on, and fits to it. Random walks
/// and grids keep clear by themselves; where furniture is in the way of a drawn path, its seed is refused.
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
            positions.fold(0.0, f64::max) + ROBOT_RADIUS
        };
        let [reach_x, reach_y] = [reach(0), reach(1)];
        if reach_x > room_x || reach_y > room_y {
            return Err(garde::Error::new(format!(
                "the path needs a room of at least {:.2} x {:.2} m, got {} x {} m; enlarge world.room or shrink \
                 robot.path",
                2.0 * reach_x,
                2.0 * reach_y,
                world.room.length,
                world.room.width
            )));
        }
        let furnishing = world.surface.furnish(robot, world.objects.min(MANY) as usize);
        let ground = Ground::new(&world.room, furnishing.obstacles());
        let clearances =
            track.samples(stride).map(|waypoint| (ground.clearance(&waypoint.position), waypoint));
        let Some((gap, nearest)) = clearances.min_by(|(a, _), (b, _)| a.total_cmp(b)) else { return Ok(()) };
        if gap < ROBOT_RADIUS {
            return Err(garde::Error::new(format!(
                "the robot would bump into world.surface: at ({:.2}, {:.2}) the path passes at {gap:.2} m, expected \
                 at least the robot's {ROBOT_RADIUS} m; widen the path or the offset, or shrink the surface",
                nearest.position.x, nearest.position.y
            )));
        }
        Ok(())
    }
}

fn fits_without_track(world: &WorldSpec, robot: &RobotSpec) -> garde::Result {
    match (&robot.path, &world.surface) {
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
        _ => Ok(()),
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
    let table = match &world.surface {
        SurfaceSpec::RoundTable { radius, .. } => *radius,
        SurfaceSpec::RectangularTable { length, width, .. } => libm::hypot(*length, *width) / 2.0,
        SurfaceSpec::Pedestals { .. } | SurfaceSpec::Furniture(_) => 0.0,
    };
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
