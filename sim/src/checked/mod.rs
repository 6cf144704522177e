//! A scene that can be simulated: what its file says, with the meshes it names, held to the rules between parts.

mod path;
mod placement;
mod view_conditions;

pub use path::fits_into;
pub use placement::{Misplaced, Part};
pub use view_conditions::ViewConditions;

use crate::error::{Progress, Stage};
use crate::mesh_file::MeshFileError;
use crate::object::{Fixture, MeshLibrary};
use crate::scene::{DetectorFaultsSpec, DetectorSpec, RobotSpec, SensorSpec, ViewsSpec, WorldSpec};
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
    /// Checks every rule, those between parts included; the report lists all violations. Then looks at the meshes, whose
    /// paths are relative to `base`, the scene file's folder, and which are prepared in the folder `shelf` as
    /// [`MeshLibrary::load`] says; and finds out whether all that is put into the room can stand there.
    pub fn new(
        spec: SceneSpec,
        base: &Path,
        shelf: Option<&Path>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Self, SceneError> {
        spec.validate()?;
        let meshes = MeshLibrary::load(&spec.world.meshes, base, shelf, progress)?;
        let total = spec.world.fixtures.len() as u64;
        let mut fixtures = Vec::new();
        for fixture in &spec.world.fixtures {
            fixtures.push(Fixture::load(fixture, base).map_err(SceneError::Fixture)?);
            progress(Progress { stage: Stage::Fixtures, done: fixtures.len() as u64, total });
        }
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
        let detector = &self.spec.sensors.detector;
        ViewConditions {
            families: self.spec.world.families.clone(),
            meshes: self.meshes.clone(),
            spacing: self.spec.world.spacing,
            lighting: self.spec.world.lighting.clone(),
            camera: self.spec.sensors.camera.clone(),
            // Views have no depth, and no tracks.
            detector: DetectorSpec {
                depth_sigma: None,
                faults: detector
                    .faults
                    .clone()
                    .map(|faults| DetectorFaultsSpec { misassigned: 0.0, ..faults }),
                ..detector.clone()
            },
            views: self.spec.views.clone(),
        }
    }
}
