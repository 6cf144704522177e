//! Point landmarks on the surroundings, `L` and their part of `Z^g`.

use crate::render::{Frame, NO_OBJECT, Placement, Shot};
use crate::scene::LandmarkSpec;
use nalgebra::{Point3, Vector2, Vector3};
use vantage_dataset::{LandmarkSighting, Seed, Stream};

/// A landmark is seen where the depth at its pixel is its own to within this share.
const DEPTH_TOLERANCE: f64 = 0.02;

/// Draws landmarks evenly over the area of everything that is no object, world frame, metres.
///
/// Stream: `landmarks`, once.
pub fn draw(spec: &LandmarkSpec, placements: &[Placement], seed: Seed) -> Vec<Point3<f64>> {
    let triangles: Vec<[Point3<f64>; 3]> =
        placements.iter().filter(|placement| placement.id == NO_OBJECT).flat_map(triangles).collect();
    let ends: Vec<f64> = triangles
        .iter()
        .scan(0.0, |sum, [a, b, c]| {
            *sum += (b - a).cross(&(c - a)).norm();
            Some(*sum)
        })
        .collect();
    let Some(&total) = ends.last() else { return Vec::new() };
    let mut stream = seed.stream("landmarks", 0);
    (0..spec.count)
        .map(|_| {
            let at = total * stream.unit();
            let index = ends.partition_point(|end| *end <= at).min(triangles.len() - 1);
            point_in(&triangles[index], &mut stream)
        })
        .collect()
}

fn triangles(placement: &Placement) -> impl Iterator<Item = [Point3<f64>; 3]> + '_ {
    let mesh = &placement.model.mesh;
    mesh.triangles.iter().map(move |corners| {
        corners.map(|i| {
            let p = mesh.positions[i as usize].map(f64::from);
            placement.world_from_model * Point3::from(Vector3::from(p))
        })
    })
}

fn point_in([a, b, c]: &[Point3<f64>; 3], stream: &mut Stream) -> Point3<f64> {
    let (u, v) = (stream.unit(), stream.unit());
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    a + (b - a) * u + (c - a) * v
}

/// The landmarks that a frame shows, with noise; visible by the frame's depth. What noise takes out of the image is lost.
///
/// Stream: `landmark pixel`, by step.
pub fn sight(
    spec: &LandmarkSpec,
    landmarks: &[Point3<f64>],
    step: usize,
    shot: &Shot,
    frame: &Frame,
    seed: Seed,
) -> Vec<LandmarkSighting> {
    let camera_from_world = shot.world_from_camera.inverse();
    let mut stream = seed.stream("landmark pixel", step as u64);
    let mut sightings = Vec::new();
    for (landmark, point) in landmarks.iter().enumerate() {
        let noise = Vector2::new(stream.normal(), stream.normal()) * spec.pixel_sigma;
        let in_camera = camera_from_world * point;
        let Some(pixel) = shot.camera.project(&in_camera) else { continue };
        let inside = pixel.min() >= 0.0
            && pixel.x < f64::from(frame.width)
            && pixel.y < f64::from(frame.height)
            && in_camera.z <= spec.max_range;
        if !inside {
            continue;
        }
        let index = pixel.y as usize * frame.width as usize + pixel.x as usize;
        let seen = f64::from(frame.depth[index]);
        if frame.ids[index] == NO_OBJECT && (seen - in_camera.z).abs() <= in_camera.z * DEPTH_TOLERANCE {
            let measured = pixel + noise;
            let size = Vector2::new(f64::from(frame.width), f64::from(frame.height));
            if measured.min() >= 0.0 && (size - measured).min() > 0.0 {
                sightings.push(LandmarkSighting { step, landmark, pixel: measured, sigma: spec.pixel_sigma });
            }
        }
    }
    sightings
}
