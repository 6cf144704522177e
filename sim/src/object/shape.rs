//! What physics asks of a mesh.

use super::hull;
use crate::model::Model;
use nalgebra::Vector3;
use rapier3d::prelude::{SharedShape, Vector};

/// Mass of a mesh from a file over the volume of its convex hull, kg/m^3: of things that are partly hollow.
const MESH_DENSITY: f64 = 400.0;

/// The least share of its bounding box that a convex hull fills.
const LEAST_FILLING: f64 = 1e-3;

/// What follows from the surface of an [`super::Object`]: see its fields.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shape {
    pub size: f64,
    pub half_extents: Vector3<f64>,
    pub hull: Vec<[f32; 3]>,
    pub mass: f64,
}

impl Shape {
    /// That of a mesh from a file; `None` if its hull has no volume.
    pub fn of(model: &Model) -> Option<Self> {
        let hull = hull::hull(&model.mesh.positions);
        let points: Vec<Vector> = hull.iter().map(|&p| Vector::from(p)).collect();
        let volume = f64::from(SharedShape::convex_hull(&points)?.mass_properties(1.0).mass());
        let (size, half_extents) = (model.mesh.diameter(), model.hull().half_extents);
        let box_volume = 8.0 * half_extents.product();
        let mass = MESH_DENSITY * volume;
        (volume > LEAST_FILLING * box_volume).then_some(Self { size, half_extents, hull, mass })
    }
}
