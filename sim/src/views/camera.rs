//! From where, and how, a robot's camera may look at an object.

use crate::robot::mount::looking;
use crate::scene::ViewsSpec;
use nalgebra::{Translation3, UnitQuaternion, Vector2, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{Camera, Pose, Stream};

/// A robot's camera is tilted towards what it drives past: objects keep to this share of the image's height.
const MIDDLE: f64 = 0.5;

/// Draws `object_from_camera` for an upright object whose bounding sphere has diameter `size`: any azimuth,
/// elevation, distance and roll by the spec, and the object wholly in the image.
pub fn draw(spec: &ViewsSpec, camera: &Camera, size: f64, stream: &mut Stream) -> Pose {
    let azimuth = stream.uniform(-PI, PI);
    let elevation = stream.uniform(spec.elevation_deg.low(), spec.elevation_deg.high()).to_radians();
    let log_distance = stream.uniform(libm::log(spec.distance.low()), libm::log(spec.distance.high()));
    let distance = libm::exp(log_distance).max(size);
    let roll = spec.roll_sigma_deg.to_radians() * stream.normal();

    let horizontal = libm::cos(elevation);
    let towards_camera =
        Vector3::new(horizontal * libm::cos(azimuth), horizontal * libm::sin(azimuth), libm::sin(elevation));
    let radius = |focal_length: f64| focal_length * size / 2.0 / distance;
    let center = Vector2::new(camera.cx, camera.cy);
    let [width, height] = [camera.width, camera.height].map(f64::from);
    let free = Vector2::new(
        (camera.cx.min(width - camera.cx) - radius(camera.fx)).max(0.0),
        (height * MIDDLE / 2.0).min(camera.cy.min(height - camera.cy) - radius(camera.fy)).max(0.0),
    );
    let off = Vector2::new(free.x * stream.uniform(-1.0, 1.0), free.y * stream.uniform(-1.0, 1.0));
    let rotation = aim(&camera.ray_in_camera(&(center + off)), &-towards_camera)
        .unwrap_or_else(|| looking(azimuth + PI, -elevation));
    Pose::from_parts(
        Translation3::from(towards_camera * distance),
        rotation * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll),
    )
}

/// Rotation of a camera with a level x axis whose `ray` points along the unit vector `direction` of a z-up frame, or
/// `None` where no such camera can see it there.
fn aim(ray: &Vector3<f64>, direction: &Vector3<f64>) -> Option<UnitQuaternion<f64>> {
    let ray = ray.normalize();
    let upright = libm::hypot(ray.y, ray.z);
    if direction.z.abs() > upright {
        return None;
    }
    let pitch = libm::asin(direction.z / upright) + libm::atan2(ray.y, ray.z);
    let forward_part = looking(0.0, pitch) * ray;
    let yaw = libm::atan2(direction.y, direction.x) - libm::atan2(forward_part.y, forward_part.x);
    Some(looking(yaw, pitch))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn aiming_puts_the_direction_on_the_ray_without_roll() {
        for ray in [Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.5, -0.3, 1.0), Vector3::new(-0.6, 0.4, 1.0)] {
            for (azimuth, elevation) in [(0.0, -0.1), (2.5, -0.6), (-1.2, 0.3)] {
                let direction = looking(azimuth, elevation) * Vector3::z();
                let rotation = aim(&ray, &direction).unwrap();
                assert_relative_eq!(rotation * ray.normalize(), direction, epsilon = 1e-12);
                assert_relative_eq!((rotation * Vector3::x()).z, 0.0, epsilon = 1e-12);
                assert!((rotation * Vector3::y()).z < 0.0);
            }
        }
        assert!(aim(&Vector3::new(3.0, 0.0, 1.0), &-Vector3::z()).is_none());
    }
}
