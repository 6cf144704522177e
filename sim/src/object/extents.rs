//! How far an object reaches.

use super::Object;
use nalgebra::Vector3;
use vantage_dataset::Extents;

impl Object {
    /// Its bounding box, and the ellipsoid of the box's proportions that just holds it.
    pub fn extents(&self) -> Extents {
        let half_sides = self.half_extents;
        let positions = self.model.mesh.positions.iter();
        let farthest = positions
            .map(|p| Vector3::from(p.map(f64::from)).component_div(&half_sides).norm_squared())
            .fold(0.0, f64::max);
        Extents { half_sides, semi_axes: half_sides * farthest.sqrt() }
    }
}
