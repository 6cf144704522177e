//! Captures of coloured balls, drawn by intersecting rays with spheres.

use nalgebra::{Point3, Vector2};
use vantage_dataset::{
    BoundingBox, Camera, Capture, CapturedObject, InstanceId, Mask, ObjectTruth, Pose, Symmetry,
};

pub struct Ball {
    pub center: Point3<f64>,
    pub radius: f64,
}

impl Ball {
    pub fn truth(&self, number: u64) -> ObjectTruth {
        ObjectTruth {
            instance: InstanceId(number),
            family: "ball".to_owned(),
            world_from_object: Pose::translation(self.center.x, self.center.y, self.center.z),
            size: 2.0 * self.radius,
            symmetry: Symmetry::None,
            extents: None,
        }
    }
}

pub fn capture(balls: &[Ball], camera: Camera, world_from_camera: Pose) -> Capture {
    let (mut rgb, mut depth, mut ids) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..camera.height {
        for column in 0..camera.width {
            let pixel = Vector2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let ray = camera.ray_in_camera(&pixel);
            let hit = balls
                .iter()
                .enumerate()
                .filter_map(|(track, ball)| {
                    let center = world_from_camera.inverse() * ball.center;
                    let along = ray.dot(&center.coords) / ray.norm_squared();
                    let off = (ray * along - center.coords).norm_squared();
                    let inside = ball.radius * ball.radius - off;
                    let z = along - (inside.max(0.0) / ray.norm_squared()).sqrt();
                    (inside >= 0.0 && z > 0.0).then(|| (z, track, (ray * z - center.coords) / ball.radius))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match hit {
                Some((z, track, normal)) => {
                    let normal = world_from_camera.rotation * normal;
                    rgb.extend(normal.iter().map(|x| (127.5 + 100.0 * x) as u8));
                    depth.push(z as f32);
                    ids.push(track as u32 + 1);
                }
                None => {
                    rgb.extend([(column * 255 / camera.width) as u8, 90, (row * 255 / camera.height) as u8]);
                    depth.push(f32::INFINITY);
                    ids.push(0);
                }
            }
        }
    }
    let width = camera.width as usize;
    let objects = Mask::of_all(&ids, width, balls.len())
        .into_iter()
        .enumerate()
        .filter_map(|(track, mask)| Some((track, mask?)))
        .map(|(track, mask)| CapturedObject {
            track,
            visible_box: mask.bounding_box,
            visible_pixels: mask.pixels,
            silhouette_box: BoundingBox { ..mask.bounding_box },
            silhouette_pixels: f64::from(mask.pixels),
            silhouette: ids.iter().map(|id| *id == track as u32 + 1).collect(),
        })
        .collect();
    Capture { timestamp: 0.0, camera, world_from_camera, rgb, depth, ids, objects }
}

/// A camera at `eye` that looks at `target`, upright.
pub fn looking(eye: Point3<f64>, target: Point3<f64>) -> Pose {
    Pose::face_towards(&eye, &target, &-nalgebra::Vector3::z())
}
