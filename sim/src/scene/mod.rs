//! The parts of a scene file that the simulator reads.
//!
//! The structs here are what a file says, and the rules of each part. Angles in files are in degrees and their names
//! end in `_deg`; lengths are metres.

pub mod family;
pub mod furniture;
pub mod inside_and_outside;
pub mod meshes;
pub mod path;
pub mod random_loop;
pub mod revisit;
pub mod robot;
pub mod rule;
pub mod sensors;
pub mod views;
pub mod world;

pub use family::Family;
pub use furniture::{PieceSpec, Side};
pub use inside_and_outside::InsideAndOutsideSpec;
pub use meshes::{FixtureSpec, MeshSpec, SymmetrySpec, UpAxis};
pub use path::PathSpec;
pub use random_loop::{Direction, RandomLoopSpec};
pub use revisit::RevisitSpec;
pub use robot::{HandheldSpec, MountSpec, RobotSpec, StartSpec};
pub use sensors::{
    CameraSpec, DetectorFaultsSpec, DetectorSpec, ImageSpec, LandmarkSpec, MAX_SIDE, OdometrySpec,
    SensorSpec, SlipSpec,
};
pub use views::ViewsSpec;
pub use world::{LightingSpec, RoomSpec, SurfaceSpec, WorldSpec};
