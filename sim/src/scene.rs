//! The parts of a scene file that the simulator reads.
//!
//! The structs here are what a file says; only a [`CheckedScene`] enters a simulation. Angles in files are in
//! degrees and their names end in `_deg`; lengths are metres.

pub mod furniture;
pub mod meshes;
pub mod path;
pub mod placement;
pub mod robot;
pub mod rule;
pub mod sensors;
pub mod views;
pub mod world;

pub use furniture::{PieceSpec, Side};
pub use meshes::{FixtureSpec, MeshSpec, SymmetrySpec};
pub use path::PathSpec;
pub use placement::{Misplaced, Part};
pub use robot::{HandheldSpec, MountSpec, RobotSpec, StartSpec};
pub use sensors::{
    CameraSpec, DetectorFaultsSpec, DetectorSpec, ImageSpec, LandmarkSpec, OdometrySpec, SensorSpec, SlipSpec,
};
pub use views::ViewsSpec;
pub use world::{LightingSpec, RoomSpec, SurfaceSpec, WorldSpec};

use crate::mesh_file::MeshFileError;
use crate::object::{Fixture, MeshLibrary};
use crate::robot::body::RADIUS as ROBOT_RADIUS;
use crate::robot::track::Track;
use crate::world::ground::Ground;
use garde::Validate;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What the simulator reads of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Validate)]
#[serde(deny_unknown_fields)]
pub struct SceneSpec {
    /// What there is to see.
    #[garde(dive)]
    pub world: WorldSpec,
    /// The robot.
    #[garde(dive, custom(fits_into(&self.world)))]
    pub robot: RobotSpec,
    /// Its sensors.
    #[garde(dive)]
    pub sensors: SensorSpec,
    /// Training views.
    #[garde(dive)]
    pub views: ViewsSpec,
}

/// A scene that passed every rule, with the meshes it names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckedScene {
    #[serde(flatten)]
    spec: SceneSpec,
    #[serde(skip_serializing_if = "MeshLibrary::is_empty")]
    meshes: MeshLibrary,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    fixtures: Vec<Fixture>,
}

/// Why a scene is refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// It breaks rules: all of them are listed.
    #[error(transparent)]
    Rules(#[from] garde::Report),
    /// A mesh that it names cannot be used.
    #[error("world.meshes: {0}")]
    Mesh(#[from] MeshFileError),
    /// Furniture that it names cannot be used.
    #[error("world.fixtures: {0}")]
    Fixture(MeshFileError),
    /// Something cannot stand where it is put: all that cannot is listed.
    #[error("{}", .0.iter().map(Misplaced::to_string).collect::<Vec<_>>().join("\n"))]
    Placement(Vec<Misplaced>),
}

impl CheckedScene {
    /// Checks every rule, those between parts included; the report lists all violations. Then reads the meshes, whose
    /// paths are relative to `base`, the scene file's folder, and finds out whether all that is put into the room can stand
    /// there.
    pub fn new(spec: SceneSpec, base: &Path) -> Result<Self, SceneError> {
        spec.validate()?;
        let meshes = MeshLibrary::load(&spec.world.meshes, base)?;
        let fixtures: Result<Vec<Fixture>, MeshFileError> =
            spec.world.fixtures.iter().map(|fixture| Fixture::load(fixture, base)).collect();
        let fixtures = fixtures.map_err(SceneError::Fixture)?;
        let misplaced = placement::misplaced(&spec, &meshes, &fixtures);
        if !misplaced.is_empty() {
            return Err(SceneError::Placement(misplaced));
        }
        Ok(Self { spec, meshes, fixtures })
    }

    /// The furniture of `world.fixtures`.
    pub fn fixtures(&self) -> &[Fixture] {
        &self.fixtures
    }

    /// The meshes of `world.meshes`.
    pub fn meshes(&self) -> &MeshLibrary {
        &self.meshes
    }

    /// What there is to see.
    pub fn world(&self) -> &WorldSpec {
        &self.spec.world
    }

    /// The robot.
    pub fn robot(&self) -> &RobotSpec {
        &self.spec.robot
    }

    /// Its sensors.
    pub fn sensors(&self) -> &SensorSpec {
        &self.spec.sensors
    }

    /// Everything that decides how training views look, and nothing else.
    pub fn view_conditions(&self) -> ViewConditions {
        ViewConditions {
            families: self.spec.world.families.clone(),
            meshes: self.meshes.clone(),
            spacing: self.spec.world.spacing,
            lighting: self.spec.world.lighting.clone(),
            camera: self.spec.sensors.camera.clone(),
            detector: self.spec.sensors.detector.clone(),
            views: self.spec.views.clone(),
        }
    }
}

/// Everything that decides how training views look: scenes that agree in it can share a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewConditions {
    /// Families, in turn.
    pub families: Vec<crate::object::Family>,
    /// Meshes, by category in turn with the families.
    #[serde(skip_serializing_if = "MeshLibrary::is_empty")]
    pub meshes: MeshLibrary,
    /// Least gap between neighbours, metres.
    pub spacing: f64,
    /// Ranges of the light.
    pub lighting: LightingSpec,
    /// The camera.
    pub camera: CameraSpec,
    /// What counts as seen.
    pub detector: DetectorSpec,
    /// Where from, and how many.
    pub views: ViewsSpec,
}

/// Distance between the points of a path that are checked, metres.
const STRIDE: f64 = 0.02;

/// Most points of a path that are checked.
const SAMPLES: f64 = 20_000.0;

/// No path is longer, metres: at full speed, as long as an episode may take.
const LONGEST: f64 = 14_400.0;

/// Of so many pedestals, all are as far from the path.
const MANY: u32 = 1000;

/// The rules between parts: the path stays in the room and clear of what the objects stand on, and fits to it. Random walks
/// and grids keep clear by themselves.
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
        let ground =
            Ground::new(&world.room, &world.surface.furnish(robot, world.objects.min(MANY) as usize));
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
        _ => Ok(()),
    }
}
