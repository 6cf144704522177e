//! Around a mesh.

use nalgebra::{Point3, Vector3};

/// A box around a mesh, along the axes of the model's frame, and a sphere with the same centre; metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hull {
    pub center: Point3<f64>,
    pub half_extents: Vector3<f64>,
    pub radius: f64,
}

impl Hull {
    pub fn around(positions: &[[f32; 3]]) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for position in positions {
            for axis in 0..3 {
                low[axis] = low[axis].min(f64::from(position[axis]));
                high[axis] = high[axis].max(f64::from(position[axis]));
            }
        }
        let center = Point3::from(std::array::from_fn::<f64, 3, _>(|axis| (low[axis] + high[axis]) / 2.0));
        let radius = positions
            .iter()
            .map(|position| (Point3::from(position.map(f64::from)) - center).norm_squared())
            .fold(0.0, f64::max)
            .sqrt();
        let half_extents = Vector3::from_fn(|axis, _| (high[axis] - low[axis]) / 2.0);
        Self { center, half_extents, radius }
    }
}
