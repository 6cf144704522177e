//! What training views depend on.

use crate::object::MeshLibrary;
use crate::scene::{CameraSpec, DetectorSpec, Family, LightingSpec, ViewsSpec};
use serde::Serialize;

/// Everything that decides how training views look: scenes that agree in it can share a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewConditions {
    /// Families, in turn.
    pub families: Vec<Family>,
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
