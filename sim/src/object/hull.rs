//! Few points that span nearly the same convex hull.

use std::f64::consts::PI;

/// Greatest number of points.
const POINTS: usize = 64;
/// Directions in which the corners of the foot are sought, so that what stands keeps standing.
const FOOT: usize = 16;
/// Directions, spread evenly over the sphere, in which the hull is compared with the mesh.
const DIRECTIONS: usize = 256;
/// The hull is refined until it falls short of the mesh by less than this share of the largest reach.
const TOLERANCE: f64 = 2e-3;

/// At most 64 vertices of the convex hull of `positions`: those that span the bounding box and the foot, and then,
/// one by one, the farthest in the direction in which the hull of those chosen so far falls short the most.
pub(crate) fn hull(positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let axes = (0..6).map(|face| {
        let sign = if face % 2 == 0 { -1.0 } else { 1.0 };
        std::array::from_fn(|axis| if axis == face / 2 { sign } else { 0.0 })
    });
    let steeply_down = (0..FOOT).map(|k| {
        let azimuth = 2.0 * PI * k as f64 / FOOT as f64;
        [libm::cos(azimuth), libm::sin(azimuth), -20.0]
    });
    let mut chosen = Vec::with_capacity(POINTS);
    for direction in axes.chain(steeply_down) {
        let point = farthest(positions, direction);
        if !chosen.contains(&point) {
            chosen.push(point);
        }
    }

    let directions: Vec<[f64; 3]> = spread().collect();
    let targets: Vec<[f32; 3]> = directions.iter().map(|&d| farthest(positions, d)).collect();
    let wanted: Vec<f64> = targets.iter().zip(&directions).map(|(point, &d)| reach(point, d)).collect();
    let largest = wanted.iter().fold(0.0, |a: f64, &b| a.max(b));
    let mut reached: Vec<f64> = directions
        .iter()
        .map(|&d| chosen.iter().map(|point| reach(point, d)).fold(f64::NEG_INFINITY, f64::max))
        .collect();
    while chosen.len() < POINTS {
        let short = |i: &usize| wanted[*i] - reached[*i];
        let Some(worst) = (0..DIRECTIONS).max_by(|a, b| short(a).total_cmp(&short(b))) else { break };
        if short(&worst) <= TOLERANCE * largest {
            break;
        }
        let point = targets[worst];
        for (so_far, &d) in reached.iter_mut().zip(&directions) {
            *so_far = so_far.max(reach(&point, d));
        }
        chosen.push(point);
    }
    chosen
}

fn reach(point: &[f32; 3], direction: [f64; 3]) -> f64 {
    let p = point.map(f64::from);
    p[0] * direction[0] + p[1] * direction[1] + p[2] * direction[2]
}

/// The vertex farthest along `direction`; of equally far ones the farthest from the centre, which is a corner.
fn farthest(positions: &[[f32; 3]], direction: [f64; 3]) -> [f32; 3] {
    let key = |point: &[f32; 3]| (reach(point, direction), reach(point, point.map(f64::from)));
    let mut best = positions[0];
    let mut best_key = key(&best);
    for point in &positions[1..] {
        let key = key(point);
        if key.0 > best_key.0 || (key.0 >= best_key.0 && key.1 > best_key.1) {
            (best, best_key) = (*point, key);
        }
    }
    best
}

/// A Fibonacci lattice of unit vectors.
fn spread() -> impl Iterator<Item = [f64; 3]> {
    let golden_angle = PI * (3.0 - 5f64.sqrt());
    (0..DIRECTIONS).map(move |i| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
        let radius = (1.0 - z * z).sqrt();
        let azimuth = golden_angle * i as f64;
        [radius * libm::cos(azimuth), radius * libm::sin(azimuth), z]
    })
}
