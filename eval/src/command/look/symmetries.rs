//! The symmetries of a scene's meshes, measured.

use crate::command::error::BenchError;
use crate::result::grid::{Style, UNDEFINED, draw};
use std::io::Write;
use vantage_dataset::Symmetry;
use vantage_sim::error::SimError;
use vantage_sim::object::{MeshLibrary, self_similarity};
use vantage_sim::render::Renderer;

const HEAD: [&str; 6] = ["Mesh", "Stated", "Measured", "Contrast", "Most alike at order", "Left over"];

/// Meshes that are measured: each is drawn 120 times.
const MOST: usize = 100;

/// Prints a row a mesh, of the first hundred; nothing without meshes.
pub fn print(
    meshes: &MeshLibrary,
    renderer: &mut dyn Renderer,
    stdout: &mut impl Write,
) -> Result<(), BenchError> {
    if meshes.is_empty() {
        return Ok(());
    }
    let mut rows = Vec::new();
    for mesh in meshes.iter().take(MOST) {
        let object = mesh.object().map_err(SimError::from)?;
        let turns = self_similarity(&object, renderer).map_err(SimError::from)?;
        let order = turns.most_alike();
        rows.push(vec![
            mesh.name.clone(),
            name(mesh.symmetry),
            name(turns.symmetry()),
            format!("{:.3}", turns.contrast()),
            order.to_string(),
            turns.left_over(order).map_or_else(|| UNDEFINED.to_owned(), |left| format!("{left:.2}")),
        ]);
    }
    let head = HEAD.map(str::to_owned);
    writeln!(stdout, "{}", draw(Style::terminal(), &head, rows))?;
    let all = meshes.iter().count();
    if all > MOST {
        writeln!(stdout, "These are {MOST} of {all} meshes.")?;
    }
    Ok(())
}

/// As in scene files.
fn name(symmetry: Symmetry) -> String {
    match symmetry {
        Symmetry::None => "none".to_owned(),
        Symmetry::Cyclic { order } => format!("cyclic: {order}"),
        Symmetry::Revolution => "revolution".to_owned(),
    }
}
