//! Which placements a window can show.

use super::{NEAR, Placement, Shot};
use crate::model::Model;
use nalgebra::Point3;
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use vantage_dataset::{Camera, Pose};

/// A sphere around a mesh, in the model's frame.
#[derive(Clone, Copy, Debug)]
struct Sphere {
    center: Point3<f64>,
    radius: f64,
}

impl Sphere {
    fn around(positions: &[[f32; 3]]) -> Self {
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
        Self { center, radius }
    }

    fn meets(&self, camera_from_model: &Pose, camera: &Camera) -> bool {
        let p = camera_from_model * self.center;
        let (right, bottom) = (f64::from(camera.width), f64::from(camera.height));
        let sides = [
            (camera.fx, 0.0, camera.cx),
            (-camera.fx, 0.0, right - camera.cx),
            (0.0, camera.fy, camera.cy),
            (0.0, -camera.fy, bottom - camera.cy),
        ];
        p.z + self.radius >= NEAR
            && sides.iter().all(|&(a, b, c)| {
                a * p.x + b * p.y + c * p.z >= -self.radius * (a * a + b * b + c * c).sqrt()
            })
    }
}

/// Spheres around the models met so far.
///
/// Keys are addresses; each entry's [`Weak`] keeps its address from being given to another model.
#[derive(Debug, Default)]
pub(super) struct Bounds {
    spheres: HashMap<usize, (Weak<Model>, Sphere)>,
    prune_at: usize,
}

impl Bounds {
    /// Measures the models of `placements` that are new.
    pub fn learn(&mut self, placements: &[Placement]) {
        for Placement { model, .. } in placements {
            self.spheres
                .entry(address(model))
                .or_insert_with(|| (Arc::downgrade(model), Sphere::around(&model.mesh.positions)));
        }
        if self.spheres.len() > self.prune_at {
            self.spheres.retain(|_, (model, _)| model.strong_count() > 0);
            self.prune_at = 2 * self.spheres.len() + 1024;
        }
    }

    /// Whether any of a placement, whose model was learnt, can appear in a shot's image.
    pub fn meets(&self, placement: &Placement, shot: &Shot) -> bool {
        let camera_from_model = shot.world_from_camera.inv_mul(&placement.world_from_model);
        self.spheres
            .get(&address(&placement.model))
            .is_none_or(|(_, sphere)| sphere.meets(&camera_from_model, &shot.camera))
    }
}

fn address(model: &Arc<Model>) -> usize {
    Arc::as_ptr(model).addr()
}
