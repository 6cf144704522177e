//! Levels of detail: meshes with fewer triangles, for where an object is small.

use crate::mesh::Mesh;
use meshoptimizer_rs::{Attributes, Limits, Positions, SimplifyOptions, SimplifySettings, Workspace};
use meshoptimizer_rs::{simplify_scale, simplify_with_attributes};
use std::collections::HashMap;

/// A mesh with a point at which more triangles meet is not made simpler: it would take time by the square of their number.
const MOST_AT_A_POINT: u32 = 1000;
/// A mesh with fewer triangles is not made simpler.
const FEW_TRIANGLES: usize = 64;
/// Each level has this share of the triangles of the one before, or the levels end.
const SHARE: f64 = 0.6;
/// A level that could not be brought below this share is not kept.
const WORTHWHILE: f64 = 0.8;
const MOST_LEVELS: usize = 8;
/// Greatest deviation, parts of the mesh's largest extent.
const MOST_DEVIATION: f32 = 0.1;
/// What the components of a normal, and the texture coordinates, count beside positions in parts of the largest extent.
const WEIGHTS: [f32; 5] = [0.05, 0.05, 0.05, 0.5, 0.5];

/// A level of detail.
#[derive(Clone, Debug)]
pub(crate) struct Simpler {
    pub mesh: Mesh,
    /// From the mesh itself, metres.
    pub deviation: f64,
}

/// The levels of a mesh, coarser from one to the next.
pub(super) fn all(mesh: &Mesh) -> Vec<Simpler> {
    let mut levels: Vec<Simpler> = Vec::new();
    let mut triangles = mesh.triangles.len();
    if most_at_a_point(mesh) > MOST_AT_A_POINT {
        return levels;
    }
    while triangles >= FEW_TRIANGLES && levels.len() < MOST_LEVELS {
        let wanted = (triangles as f64 * SHARE) as usize;
        // A mesh that the simplifier refuses, such as one that is not finite, stays as it is.
        let Some(simpler) = simplified(mesh, wanted) else { break };
        if simpler.mesh.triangles.len() as f64 > triangles as f64 * WORTHWHILE {
            break;
        }
        triangles = simpler.mesh.triangles.len();
        levels.push(simpler);
    }
    levels
}

/// How many corners of triangles there are at the point that has most.
fn most_at_a_point(mesh: &Mesh) -> u32 {
    let mut corners: HashMap<[u32; 3], u32> = HashMap::new();
    for &corner in mesh.triangles.as_flattened() {
        *corners.entry(mesh.positions[corner as usize].map(f32::to_bits)).or_default() += 1;
    }
    corners.into_values().max().unwrap_or_default()
}

fn simplified(mesh: &Mesh, triangles: usize) -> Option<Simpler> {
    let positions = Positions::from_packed(&mesh.positions);
    let attributes: Vec<f32> =
        mesh.normals.iter().zip(&mesh.uvs).flat_map(|(&[x, y, z], &[u, v])| [x, y, z, u, v]).collect();
    let attributes =
        Attributes::from_interleaved(&attributes, mesh.positions.len(), WEIGHTS.len(), WEIGHTS.len(), 0);
    let settings = SimplifySettings {
        target_index_count: 3 * triangles,
        target_error: MOST_DEVIATION,
        options: SimplifyOptions::EMPTY,
    };
    let simplified = simplify_with_attributes(
        mesh.triangles.as_flattened(),
        positions,
        attributes.ok()?,
        &WEIGHTS,
        None,
        settings,
        &mut Workspace::new(Limits::default()),
    );
    let simplified = simplified.ok()?;
    let deviation = f64::from(simplified.error) * f64::from(simplify_scale(positions).ok()?);
    Some(Simpler { mesh: compact(mesh, &simplified.indices), deviation })
}

/// The triangles with the vertices that they use, in the order of their first use.
fn compact(mesh: &Mesh, indices: &[u32]) -> Mesh {
    const UNUSED: u32 = u32::MAX;
    let mut numbers = vec![UNUSED; mesh.positions.len()];
    let mut compact = Mesh::default();
    for corners in indices.as_chunks::<3>().0 {
        compact.triangles.push(corners.map(|corner| {
            let number = &mut numbers[corner as usize];
            if *number == UNUSED {
                *number = compact.positions.len() as u32;
                compact.positions.push(mesh.positions[corner as usize]);
                compact.normals.push(mesh.normals[corner as usize]);
                compact.uvs.push(mesh.uvs[corner as usize]);
            }
            *number
        }));
    }
    compact
}
