//! A contact sheet of the procedural objects: `object_sheet OUT.png [TILE [FAMILY...]]`.
//!
//! Rows are instances, four a family; columns are eight azimuths of the camera, from 0 (the front) counter-clockwise, 30 degrees
//! above the table. Tiles are `TILE` (64) pixels wide.

use image::{Rgb, RgbImage};
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;
use vantage_dataset::{Camera, Pose, Seed, Split};
use vantage_sim::object::Object;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Light, Placement, RenderScene, Renderer, Shot};
use vantage_sim::scene::Family;

const INSTANCES: u64 = 4;
const AZIMUTHS: u32 = 8;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().ok_or("usage: object_sheet OUT.png [TILE [FAMILY...]]")?;
    let tile: u32 = arguments.next().map_or(Ok(64), |side| side.parse())?;
    let names: Vec<String> = arguments.collect();
    let families: Vec<Family> = Family::ALL
        .into_iter()
        .filter(|family| names.is_empty() || names.iter().any(|name| name == family.name()))
        .collect();
    if families.is_empty() {
        return Err(format!("no family is called {}; there are {:?}", names.join(", "), Family::ALL).into());
    }

    let mut renderer = ReferenceRenderer::new();
    let mut sheet = RgbImage::new(tile * AZIMUTHS, tile * families.len() as u32 * INSTANCES as u32);
    let mut row = 0;
    for family in families {
        for index in 0..INSTANCES {
            let object = Object::generate(family, Split::Train, Seed(1), index);
            for column in 0..AZIMUTHS {
                let azimuth = 2.0 * PI * f64::from(column) / f64::from(AZIMUTHS);
                let rgb = view(&mut renderer, &object, azimuth, tile)?;
                for (pixel, colour) in rgb.chunks_exact(3).enumerate() {
                    let (x, y) = (pixel as u32 % tile, pixel as u32 / tile);
                    sheet.put_pixel(
                        column * tile + x,
                        row * tile + y,
                        Rgb([colour[0], colour[1], colour[2]]),
                    );
                }
            }
            row += 1;
        }
    }
    sheet.save(&out)?;
    println!("{out}: {row} objects");
    Ok(())
}

/// The object from 30 degrees above, filling the tile.
fn view(
    renderer: &mut ReferenceRenderer,
    object: &Object,
    azimuth: f64,
    side: u32,
) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let (distance, elevation) = (4.0 * object.size, PI / 6.0);
    let eye = distance
        * Vector3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin());
    let world_from_camera = Pose::face_towards(&Point3::from(eye), &Point3::origin(), &-Vector3::z());
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
        background: [128; 3],
    };
    let camera = Camera::with_horizontal_fov(side, side, 2.0 * (0.55 * object.size / distance).atan());
    Ok(renderer.frame(&scene, &Shot { camera, world_from_camera })?.rgb)
}
