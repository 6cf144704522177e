//! Small scenes that the renderers' tests draw.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::sync::Arc;
use vantage_dataset::{Camera, Pose};
use vantage_sim::mesh::Mesh;
use vantage_sim::model::Model;
use vantage_sim::render::{Light, Placement, RenderScene, Shot};
use vantage_sim::texture::{TEXTURE_SIDE, Texture};

/// A box around the origin; each face shows the whole texture.
pub fn block(half: [f32; 3], texture: Texture) -> Arc<Model> {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [-1.0_f32, 1.0] {
            let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = mesh.positions.len() as u32;
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let mut position = [0.0; 3];
                position[axis] = sign * half[axis];
                position[right] = sign * (2.0 * u - 1.0) * half[right];
                position[up] = (2.0 * v - 1.0) * half[up];
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                mesh.positions.push(position);
                mesh.normals.push(normal);
                mesh.uvs.push([u, 1.0 - v]);
            }
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first, first + 2, first + 3]);
        }
    }
    Arc::new(Model::new(mesh, texture))
}

/// A ball of `2 * segments * segments` triangles.
pub fn ball(radius: f32, segments: u32, texture: Texture) -> Arc<Model> {
    let mut mesh = Mesh::default();
    for ring in 0..=segments {
        for step in 0..=2 * segments {
            let (u, v) = (step as f32 / (2 * segments) as f32, ring as f32 / segments as f32);
            let (azimuth, polar) =
                (libm::sincosf(u * std::f32::consts::TAU), libm::sincosf(v * std::f32::consts::PI));
            let normal = [polar.0 * azimuth.1, polar.0 * azimuth.0, polar.1];
            mesh.positions.push(normal.map(|n| n * radius));
            mesh.normals.push(normal);
            mesh.uvs.push([u, v]);
        }
    }
    for ring in 0..segments {
        for step in 0..2 * segments {
            let upper = ring * (2 * segments + 1) + step;
            let lower = upper + 2 * segments + 1;
            if ring > 0 {
                mesh.triangles.push([upper, lower, upper + 1]);
            }
            if ring + 1 < segments {
                mesh.triangles.push([upper + 1, lower, lower + 1]);
            }
        }
    }
    Arc::new(Model::new(mesh, texture))
}

/// Cells of `size` texels, in two colours and with a gradient, so that neither half nor axis looks like the other.
pub fn checks(size: usize, dark: [u8; 3], bright: [u8; 3]) -> Texture {
    let texel = |i: usize| {
        let (row, column) = (i / TEXTURE_SIDE, i % TEXTURE_SIDE);
        let [r, g, b] = if (row / size + column / size).is_multiple_of(2) { dark } else { bright };
        [r, g.saturating_sub((row / 2) as u8), b.saturating_sub((column / 2) as u8), 255]
    };
    Texture::new((0..TEXTURE_SIDE * TEXTURE_SIDE).map(texel).collect())
}

/// 320x240 pixels, 60 degrees wide.
pub fn camera() -> Camera {
    Camera::with_horizontal_fov(320, 240, std::f64::consts::FRAC_PI_3)
}

/// A shot from `eye` at `target`, the world's z up in the image.
pub fn look_at(eye: [f64; 3], target: [f64; 3]) -> Shot {
    let (eye, target) = (Point3::from(eye), Point3::from(target));
    let camera_from_world = Pose::look_at_rh(&eye, &target, &Vector3::z());
    let flip = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let mut world_from_camera = camera_from_world.inverse();
    world_from_camera.rotation *= flip;
    Shot { camera: camera(), world_from_camera }
}

/// Ambient and sun, neither grey.
pub fn light() -> Light {
    Light { direction: Vector3::new(0.36, -0.48, 0.8), ambient: [0.25, 0.27, 0.3], diffuse: [0.8, 0.75, 0.7] }
}

/// Placements under [`light`].
pub fn scene_of(placements: Vec<Placement>) -> RenderScene {
    RenderScene { placements, light: light(), background: [90, 120, 160] }
}

/// A model at a position, turned about z.
pub fn placed(model: &Arc<Model>, at: [f64; 3], yaw: f64, id: u32) -> Placement {
    Placement { model: Arc::clone(model), world_from_model: Pose::new(at.into(), Vector3::z() * yaw), id }
}

/// A table with boxes and balls on it, some behind others, ids 1 to 5; the table's is 6.
pub fn cluttered() -> RenderScene {
    let table = block([0.8, 0.8, 0.02], checks(16, [70, 60, 50], [200, 190, 170]));
    let tall = block([0.06, 0.09, 0.15], checks(8, [30, 60, 160], [230, 220, 90]));
    let flat = block([0.15, 0.1, 0.04], checks(32, [150, 30, 30], [240, 240, 240]));
    let round = ball(0.11, 12, checks(4, [20, 110, 60], [250, 160, 200]));
    scene_of(vec![
        placed(&table, [0.0, 0.0, -0.02], 0.0, 6),
        placed(&tall, [0.0, 0.0, 0.15], 0.7, 1),
        placed(&flat, [0.25, -0.2, 0.04], -0.4, 2),
        placed(&round, [0.2, 0.25, 0.11], 0.3, 3),
        placed(&round, [-0.35, 0.1, 0.11], 2.0, 4),
        placed(&tall, [-0.2, -0.45, 0.15], 2.1, 5),
    ])
}
