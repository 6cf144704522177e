//! Pictures per CPU second of both renderers, on a table set with objects.
//!
//! `cargo run --release -p vantage-sim --example render_rate` prints the rates;
//! `... -- hash` prints digests of the pictures; `... -- export FOLDER` writes the scene for other renderers (`sim/benches/peers.sh`), with our picture of it.
//! After `--models FOLDER [TRIANGLES]`, YCB models (in metres, z up), simplified to so many triangles at most, take the place of
//! the objects of our families.

#[path = "../tests/render_furnished/mod.rs"]
mod render_furnished;

use render_furnished::{Window, scene, set_with, shots, windows};
use serde_json::json;
use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use std::{env, fs};
use vantage_sim::model::Model;
use vantage_sim::object::{MeshLibrary, Object};
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::wgpu::WgpuRenderer;
use vantage_sim::render::{RenderError, RenderScene, Renderer, Shot, Tile};
use vantage_sim::scene::UpAxis;
use vantage_sim::scene::{MeshSpec, SymmetrySpec};

const SHOTS: usize = 48;
const TILE_SIDE: u32 = 32;
/// Least CPU time of a measurement.
const SECONDS: f64 = 1.5;

const USAGE: &str = "usage: render_rate [hash | export FOLDER] [--models FOLDER [TRIANGLES]]";

/// What is rendered.
struct Task {
    scene: RenderScene,
    shots: Vec<Shot>,
    windows: Vec<Window>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments: Vec<String> = env::args().skip(1).collect();
    let scene = match arguments.iter().position(|argument| argument == "--models") {
        Some(at) => set_with_models(&arguments.split_off(at)[1..])?,
        None => scene(),
    };
    let task = Task::new(scene)?;
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => task.on_both(|task, renderer| task.measure(renderer)),
        ["hash"] => task.on_both(|task, renderer| task.hash(renderer)),
        ["export", folder] => task.export(Path::new(folder)),
        _ => Err(USAGE.into()),
    }
}

/// The table with each of the models of a folder as often as it fits; of as many triangles at most.
fn set_with_models(arguments: &[String]) -> Result<RenderScene, Box<dyn Error>> {
    let (folder, most) = match arguments {
        [folder] => (folder, usize::MAX),
        [folder, most] => (folder, most.parse()?),
        _ => return Err(USAGE.into()),
    };
    let spec = MeshSpec {
        path: folder.into(),
        metres_per_unit: 1.0,
        up: UpAxis::Z,
        category: None,
        symmetry: SymmetrySpec::None,
        split: None,
    };
    let library = MeshLibrary::load(&[spec], Path::new(""), None, &mut |_| ())?;
    let mut objects = Vec::new();
    for entry in library.iter() {
        let object = entry.object()?;
        let model = &object.model;
        model.simplify();
        let level = (0..=model.simpler_levels()).find(|&level| model.mesh_at(level).triangles.len() <= most);
        let mesh = model.mesh_at(level.ok_or("a model has no level of so few triangles")?).clone();
        let model = Arc::new(Model::new(mesh, model.texture.clone()));
        objects.push(Object { model, ..object.clone() });
    }
    Ok(set_with(|i| objects[i % objects.len()].clone()))
}

impl Task {
    fn new(scene: RenderScene) -> Result<Self, RenderError> {
        let shots = shots(SHOTS);
        let mut renderer = ReferenceRenderer::new();
        let mut all = Vec::new();
        for (index, shot) in shots.iter().enumerate() {
            all.extend(windows(index, &renderer.frame(&scene, shot)?));
        }
        Ok(Self { scene, shots, windows: all })
    }

    fn on_both(
        &self,
        work: impl Fn(&Self, &mut dyn Renderer) -> Result<(), Box<dyn Error>>,
    ) -> Result<(), Box<dyn Error>> {
        work(self, &mut ReferenceRenderer::new())?;
        match WgpuRenderer::new() {
            Ok(mut renderer) => work(self, &mut renderer),
            Err(error @ RenderError::NoAdapter { .. }) => {
                eprintln!("wgpu: skipped, {error}");
                Ok(())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// One line a kind of picture: renderer, kind, pictures per core-second, pictures per second.
    fn measure(&self, renderer: &mut dyn Renderer) -> Result<(), Box<dyn Error>> {
        let name = renderer.info().renderer;
        rate(&format!("{name} frames"), || {
            self.shots.iter().try_for_each(|shot| renderer.frame(&self.scene, shot).map(drop))?;
            Ok(self.shots.len())
        })?;
        rate(&format!("{name} crops"), || Ok(self.tiles(renderer)?.len()))
    }

    fn hash(&self, renderer: &mut dyn Renderer) -> Result<(), Box<dyn Error>> {
        let (mut frames, mut crops) = (blake3::Hasher::new(), blake3::Hasher::new());
        for shot in &self.shots {
            let frame = renderer.frame(&self.scene, shot)?;
            frames.update(&frame.rgb);
            frames.update(bytemuck::cast_slice(&frame.depth));
            frames.update(bytemuck::cast_slice(&frame.ids));
        }
        for tile in self.tiles(renderer)? {
            crops.update(&tile.rgb);
            crops.update(bytemuck::cast_slice(&tile.ids));
            crops.update(&tile.amodal_pixels.to_le_bytes());
        }
        let name = renderer.info().renderer;
        println!("{name} frames {}\n{name} crops {}", frames.finalize(), crops.finalize());
        Ok(())
    }

    fn tiles(&self, renderer: &mut dyn Renderer) -> Result<Vec<Tile>, RenderError> {
        let tiles: Vec<_> = self.windows.iter().map(|window| window.tile(&self.scene, &self.shots)).collect();
        renderer.tiles(&tiles, TILE_SIDE)
    }

    fn export(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        fs::create_dir_all(folder)?;
        let mut placements = Vec::new();
        for (index, placement) in self.scene.placements.iter().enumerate() {
            let model = &placement.model;
            fs::write(folder.join(format!("{index}.obj")), wavefront(model)?)?;
            let side = model.texture.side() as u32;
            image::RgbaImage::from_raw(side, side, model.texture.level(0).as_flattened().to_vec())
                .ok_or("a texture is square")?
                .save(folder.join(format!("{index}.png")))?;
            let pose = &placement.world_from_model;
            let [x, y, z, w]: [f64; 4] = pose.rotation.coords.into();
            placements.push(json!({
                "id": placement.id,
                "position": <[f64; 3]>::from(pose.translation.vector),
                "quaternion_wxyz": [w, x, y, z],
                "triangles": model.mesh.triangles.len(),
            }));
        }
        let tiles = self.tiles(&mut ReferenceRenderer::new())?;
        let windows: Vec<_> = self.windows.iter().zip(&tiles).map(|(window, tile)| {
            let seen: BTreeSet<u32> = tile.ids.iter().copied().collect();
            json!({
                "shot": window.shot, "center": window.center, "side": window.side, "target": window.target, "seen": seen,
            })
        }).collect();
        let camera = &self.shots[0].camera;
        let shots: Vec<_> = self
            .shots
            .iter()
            .map(|shot| {
                let axes = shot.world_from_camera.rotation.to_rotation_matrix();
                json!({
                    "position": <[f64; 3]>::from(shot.world_from_camera.translation.vector),
                    "forward": <[f64; 3]>::from(axes.matrix().column(2).into_owned()),
                    "up": <[f64; 3]>::from(-axes.matrix().column(1).into_owned()),
                })
            })
            .collect();
        let light = &self.scene.light;
        let exported = json!({
            "width": camera.width, "height": camera.height,
            "fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy,
            "tile_side": TILE_SIDE,
            "light": {
                "towards": <[f64; 3]>::from(light.direction), "ambient": light.ambient, "diffuse": light.diffuse,
            },
            "placements": placements, "shots": shots, "windows": windows,
        });
        fs::write(folder.join("scene.json"), serde_json::to_string(&exported)?)?;
        let frame = ReferenceRenderer::new().frame(&self.scene, &self.shots[0])?;
        image::save_buffer(
            folder.join("ours.png"),
            &frame.rgb,
            frame.width,
            frame.height,
            image::ColorType::Rgb8,
        )?;
        Ok(())
    }
}

/// A mesh as an OBJ file.
fn wavefront(model: &Model) -> Result<String, std::fmt::Error> {
    let mesh = &model.mesh;
    let mut text = String::new();
    for [x, y, z] in &mesh.positions {
        writeln!(text, "v {x} {y} {z}")?;
    }
    for [u, v] in &mesh.uvs {
        writeln!(text, "vt {u} {}", 1.0 - v)?;
    }
    for [x, y, z] in &mesh.normals {
        writeln!(text, "vn {x} {y} {z}")?;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|index| index + 1);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
    }
    Ok(text)
}

/// Repeats work, which says how many pictures it made, and prints its rates.
fn rate(what: &str, mut work: impl FnMut() -> Result<usize, RenderError>) -> Result<(), Box<dyn Error>> {
    work()?;
    let (start, begun) = (cpu_seconds()?, Instant::now());
    let mut pictures = 0;
    let cpu = loop {
        pictures += work()?;
        let cpu = cpu_seconds()? - start;
        if cpu >= SECONDS {
            break cpu;
        }
    };
    let wall = begun.elapsed().as_secs_f64();
    println!("{what} {:.1} {:.1}", pictures as f64 / cpu, pictures as f64 / wall);
    Ok(())
}

/// User and system time of all threads of this process so far, to 10 ms (Linux only).
fn cpu_seconds() -> Result<f64, Box<dyn Error>> {
    let stat = fs::read_to_string("/proc/self/stat")?;
    let (_, after_name) = stat.rsplit_once(')').ok_or("no process name in /proc/self/stat")?;
    let ticks: Result<Vec<u64>, _> = after_name.split_whitespace().skip(11).take(2).map(str::parse).collect();
    Ok(ticks?.iter().sum::<u64>() as f64 / 100.0)
}
