//! Few points that span nearly the same convex hull.

use std::f64::consts::PI;

/// Rings of directions: elevation in degrees, how many.
const RINGS: [(f64, usize); 4] = [(-60.0, 12), (-20.0, 17), (20.0, 17), (60.0, 12)];

/// The vertices that reach farthest in 64 directions, each once: at most 64 points of the convex hull, the extents
/// along the axes exact.
pub(crate) fn hull(positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let rings = RINGS.iter().flat_map(|&(elevation, count)| {
        let (sin, cos) = (libm::sin(elevation * PI / 180.0), libm::cos(elevation * PI / 180.0));
        (0..count).map(move |k| {
            let azimuth = 2.0 * PI * (k as f64 + 0.5) / count as f64;
            [cos * libm::cos(azimuth), cos * libm::sin(azimuth), sin]
        })
    });
    let axes = [0, 1, 2]
        .into_iter()
        .flat_map(|axis| [-1.0, 1.0].map(|sign| std::array::from_fn(|i| if i == axis { sign } else { 0.0 })));
    let mut chosen: Vec<usize> = axes.chain(rings).filter_map(|d: [f64; 3]| farthest(positions, d)).collect();
    chosen.sort_unstable();
    chosen.dedup();
    let mut points: Vec<[f32; 3]> = Vec::new();
    for i in chosen {
        if !points.contains(&positions[i]) {
            points.push(positions[i]);
        }
    }
    points
}

/// The vertex farthest along `direction`; of equally far ones the farthest from the centre, which is a corner.
fn farthest(positions: &[[f32; 3]], direction: [f64; 3]) -> Option<usize> {
    let key = |p: &[f32; 3]| {
        let p = p.map(f64::from);
        let along = p[0] * direction[0] + p[1] * direction[1] + p[2] * direction[2];
        (along, p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    };
    let keys = positions.iter().map(key).enumerate();
    keys.max_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(i, _)| i)
}
