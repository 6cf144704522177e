//! Which placements a shot can show.

use super::projection::pixels_from_model;
use super::{NEAR, Placement, Shot};
use crate::model::Hull;
use nalgebra::Vector3;
use vantage_dataset::Pose;

/// How far a level of detail may be off, pixels.
const DEVIATION: f64 = 0.25;

/// What a shot can show.
#[derive(Debug)]
pub(super) struct Frustum<'a> {
    shot: &'a Shot,
    camera_from_world: Pose,
    /// Unit normals of the sides, inwards, camera frame.
    sides: [Vector3<f64>; 4],
}

impl<'a> Frustum<'a> {
    pub fn of(shot: &'a Shot) -> Self {
        let camera = &shot.camera;
        let (right, bottom) = (f64::from(camera.width), f64::from(camera.height));
        let sides = [
            Vector3::new(camera.fx, 0.0, camera.cx),
            Vector3::new(-camera.fx, 0.0, right - camera.cx),
            Vector3::new(0.0, camera.fy, camera.cy),
            Vector3::new(0.0, -camera.fy, bottom - camera.cy),
        ];
        let camera_from_world = shot.world_from_camera.inverse();
        Self { shot, camera_from_world, sides: sides.map(|side| side.normalize()) }
    }

    /// The level of detail at which a placement appears in the shot's image; `None` if it cannot.
    pub fn level(&self, placement: &Placement) -> Option<usize> {
        let hull = placement.model.hull();
        let center = self.camera_from_world * (placement.world_from_model * hull.center);
        let in_sphere = center.z + hull.radius >= NEAR
            && self.sides.iter().all(|side| side.dot(&center.coords) >= -hull.radius);
        if !in_sphere || !self.meets_box(hull, placement) {
            return None;
        }
        // What spans so many pixels at the nearest point.
        let nearest = (center.z - hull.radius).max(NEAR);
        let deviation = DEVIATION * nearest / self.shot.camera.fx.max(self.shot.camera.fy);
        Some(placement.model.level(deviation))
    }

    fn meets_box(&self, hull: &Hull, placement: &Placement) -> bool {
        let pixels_from_model = pixels_from_model(self.shot, placement);
        let (x, y, z) = (pixels_from_model.row(0), pixels_from_model.row(1), pixels_from_model.row(2));
        let (right, bottom) = (f64::from(self.shot.camera.width), f64::from(self.shot.camera.height));
        let reaches = |a: f64, b: f64, c: f64, least: f64| {
            let side = x * a + y * b + z * c;
            let most: f64 =
                (0..3).map(|i| side[i] * hull.center[i] + side[i].abs() * hull.half_extents[i]).sum();
            most + side[3] >= least
        };
        reaches(0.0, 0.0, 1.0, NEAR)
            && reaches(1.0, 0.0, 0.0, 0.0)
            && reaches(-1.0, 0.0, right, 0.0)
            && reaches(0.0, 1.0, 0.0, 0.0)
            && reaches(0.0, -1.0, bottom, 0.0)
    }
}
