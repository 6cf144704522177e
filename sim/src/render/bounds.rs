//! Which placements a window can show.

use super::projection::pixels_from_model;
use super::{NEAR, Placement, Shot};
use crate::model::Model;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use vantage_dataset::{Camera, Pose};

/// How far a level of detail may be off, pixels.
const DEVIATION: f64 = 0.25;

/// A box around a mesh, along the axes of the model's frame, and a sphere with the same centre.
#[derive(Clone, Copy, Debug)]
struct Hull {
    center: Point3<f64>,
    half_extents: Vector3<f64>,
    radius: f64,
}

impl Hull {
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
        let half_extents = Vector3::from_fn(|axis, _| (high[axis] - low[axis]) / 2.0);
        Self { center, half_extents, radius }
    }

    fn meets(&self, placement: &Placement, shot: &Shot) -> bool {
        let camera_from_model = shot.world_from_camera.inv_mul(&placement.world_from_model);
        self.sphere_meets(&camera_from_model, &shot.camera) && self.box_meets(placement, shot)
    }

    /// What spans [`DEVIATION`] at the hull's nearest point, metres.
    fn deviation(&self, placement: &Placement, shot: &Shot) -> f64 {
        let camera_from_model = shot.world_from_camera.inv_mul(&placement.world_from_model);
        let nearest = ((camera_from_model * self.center).z - self.radius).max(NEAR);
        DEVIATION * nearest / shot.camera.fx.max(shot.camera.fy)
    }

    fn box_meets(&self, placement: &Placement, shot: &Shot) -> bool {
        let pixels_from_model = pixels_from_model(shot, placement);
        let (x, y, z) = (pixels_from_model.row(0), pixels_from_model.row(1), pixels_from_model.row(2));
        let (right, bottom) = (f64::from(shot.camera.width), f64::from(shot.camera.height));
        let reaches = |a: f64, b: f64, c: f64, least: f64| {
            let side = x * a + y * b + z * c;
            let most: f64 =
                (0..3).map(|i| side[i] * self.center[i] + side[i].abs() * self.half_extents[i]).sum();
            most + side[3] >= least
        };
        reaches(0.0, 0.0, 1.0, NEAR)
            && reaches(1.0, 0.0, 0.0, 0.0)
            && reaches(-1.0, 0.0, right, 0.0)
            && reaches(0.0, 1.0, 0.0, 0.0)
            && reaches(0.0, -1.0, bottom, 0.0)
    }

    fn sphere_meets(&self, camera_from_model: &Pose, camera: &Camera) -> bool {
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

/// Hulls of the models met so far.
///
/// Keys are addresses; each entry's [`Weak`] keeps its address from being given to another model.
#[derive(Debug, Default)]
pub(super) struct Bounds {
    hulls: HashMap<usize, (Weak<Model>, Hull)>,
    prune_at: usize,
}

impl Bounds {
    /// Measures the models of `placements` that are new.
    pub fn learn(&mut self, placements: &[Placement]) {
        for Placement { model, .. } in placements {
            self.hulls
                .entry(address(model))
                .or_insert_with(|| (Arc::downgrade(model), Hull::around(&model.mesh.positions)));
        }
        if self.hulls.len() > self.prune_at {
            self.hulls.retain(|_, (model, _)| model.strong_count() > 0);
            self.prune_at = 2 * self.hulls.len() + 1024;
        }
    }

    /// The level of detail at which a placement, whose model was learnt, appears in a shot's image; `None` if it cannot.
    pub fn level(&self, placement: &Placement, shot: &Shot) -> Option<usize> {
        self.hulls.get(&address(&placement.model)).map_or(Some(0), |(_, hull)| {
            hull.meets(placement, shot).then(|| placement.model.level(hull.deviation(placement, shot)))
        })
    }
}

fn address(model: &Arc<Model>) -> usize {
    Arc::as_ptr(model).addr()
}
