//! A contact sheet of meshes from files: `mesh_sheet LIST.yaml OUT.png [TILE]`.
//!
//! The list is what a scene has as `world.meshes`. Rows are meshes; columns are six azimuths of the camera, from 0 (the
//! front) counter-clockwise, 30 degrees above the horizon, then two from 30 degrees below. Tiles are `TILE` (96) pixels wide.

use image::{Rgb, RgbImage};
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;
use vantage_dataset::{Camera, Pose};
use vantage_sim::object::{MeshLibrary, Object};
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Light, Placement, RenderScene, Renderer, Shot};
use vantage_sim::scene::MeshSpec;

/// Azimuth and elevation of the camera, degrees.
const VIEWS: [[f64; 2]; 8] = [
    [0.0, 30.0],
    [60.0, 30.0],
    [120.0, 30.0],
    [180.0, 30.0],
    [240.0, 30.0],
    [300.0, 30.0],
    [30.0, -30.0],
    [210.0, -30.0],
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(list), Some(out)) = (arguments.next(), arguments.next()) else {
        return Err("usage: mesh_sheet LIST.yaml OUT.png [TILE]".into());
    };
    let tile: u32 = arguments.next().map_or(Ok(96), |side| side.parse())?;
    let specs: Vec<MeshSpec> = serde_saphyr::from_str(&std::fs::read_to_string(&list)?)?;
    let base = Path::new(&list).parent().unwrap_or(Path::new("."));
    let start = Instant::now();
    let library = MeshLibrary::load(&specs, base, &mut |_| ())?;
    println!("read in {:.2} s", start.elapsed().as_secs_f64());

    let mut renderer = ReferenceRenderer::new();
    let rows = library.iter().count() as u32;
    let mut sheet = RgbImage::new(tile * VIEWS.len() as u32, tile * rows);
    for (row, mesh) in library.iter().enumerate() {
        let Object { half_extents, mass, model, .. } = &mesh.object;
        let [x, y, z] = (2.0 * half_extents).into();
        println!(
            "{row:3} {:30} {:30} {:10} {x:.3} x {y:.3} x {z:.3} m, {mass:7.3} kg, {} triangles",
            mesh.name,
            mesh.category,
            mesh.split.name(),
            model.mesh.triangles.len()
        );
        for (column, [azimuth, elevation]) in VIEWS.into_iter().enumerate() {
            let rgb = view(&mut renderer, &mesh.object, azimuth * PI / 180.0, elevation * PI / 180.0, tile)?;
            for (pixel, colour) in rgb.as_chunks().0.iter().enumerate() {
                let (x, y) = (pixel as u32 % tile, pixel as u32 / tile);
                sheet.put_pixel(column as u32 * tile + x, row as u32 * tile + y, Rgb(*colour));
            }
        }
    }
    sheet.save(&out)?;
    Ok(())
}

/// The object, filling the tile.
fn view(
    renderer: &mut ReferenceRenderer,
    object: &Object,
    azimuth: f64,
    elevation: f64,
    side: u32,
) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let distance = 4.0 * object.size;
    let eye = distance
        * Vector3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin());
    let scene = RenderScene {
        placements: vec![Placement {
            model: object.model.clone(),
            world_from_model: Pose::identity(),
            id: 1,
        }],
        light: Light {
            direction: Vector3::new(0.3, 0.5, 0.8).normalize(),
            ambient: [0.5; 3],
            diffuse: [0.6; 3],
        },
        background: [90, 110, 170],
    };
    let shot = Shot {
        camera: Camera::with_horizontal_fov(side, side, 2.0 * (0.55 * object.size / distance).atan()),
        world_from_camera: Pose::face_towards(&Point3::from(eye), &Point3::origin(), &-Vector3::z()),
    };
    Ok(renderer.frame(&scene, &shot)?.rgb)
}
