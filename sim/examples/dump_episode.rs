//! Writes pictures of an episode of a scene, for a look at it:
//!
//! `cargo run --release -p vantage-sim --example dump_episode -- scenes/tabletop.yaml 7 out/episode`
//!
//! - `frame_NNN.png`: every tenth image, with the boxes of its detections
//! - `crops.png`: detections, a row for each object, masked crop above boxed crop

use image::{Rgb, RgbImage, imageops};
use serde::Deserialize;
use std::path::Path;
use std::{env, error::Error, fs};
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::{BoundingBox, Crop, Episode, Seed, Split};
use vantage_sim::episode::{roll_out, simulate};
use vantage_sim::render::Renderer;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::scene::{CheckedScene, RobotSpec, SceneSpec, SensorSpec, ViewsSpec, WorldSpec};

#[derive(Deserialize)]
struct SceneFile {
    world: WorldSpec,
    robot: RobotSpec,
    sensors: SensorSpec,
    views: ViewsSpec,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [scene, seed, out] = arguments.as_slice() else {
        return Err("usage: dump_episode SCENE SEED FOLDER".into());
    };
    let file: SceneFile = serde_saphyr::from_str(&fs::read_to_string(scene)?)?;
    let scene = CheckedScene::new(SceneSpec {
        world: file.world,
        robot: file.robot,
        sensors: file.sensors,
        views: file.views,
    })?;
    let (seed, out) = (Seed(seed.parse()?), Path::new(out));
    fs::create_dir_all(out)?;
    let mut renderer = ReferenceRenderer::default();
    let episode = simulate(&scene, seed, Split::Test, &mut renderer, &mut |_| ())?;
    crops(&episode)?.save(out.join("crops.png"))?;

    let rollout = roll_out(&scene, seed, Split::Test, &mut |_| ())?;
    let render_scene = rollout.render_scene(&scene);
    for step in (0..episode.observations.steps()).step_by(10) {
        let frame = renderer.frame(&render_scene, &rollout.shot(step))?;
        let mut image =
            RgbImage::from_raw(frame.width, frame.height, frame.rgb).ok_or("a frame of this size")?;
        for detection in episode.observations.detections.iter().filter(|d| d.step == step) {
            outline(&mut image, &detection.bounding_box);
        }
        image.save(out.join(format!("frame_{step:03}.png")))?;
    }
    for step in 0..episode.observations.steps() {
        let tracks: Vec<usize> =
            episode.observations.detections.iter().filter(|d| d.step == step).map(|d| d.track).collect();
        println!("{step}: {tracks:?}");
    }
    Ok(())
}

fn outline(image: &mut RgbImage, bounds: &BoundingBox) {
    let edge = |at: nalgebra::Vector2<f64>| (at.x as u32, at.y as u32);
    let ((left, top), (right, bottom)) = (edge(bounds.min), edge(bounds.max));
    for x in left..right {
        image.put_pixel(x, top, Rgb([255, 255, 0]));
        image.put_pixel(x, bottom - 1, Rgb([255, 255, 0]));
    }
    for y in top..bottom {
        image.put_pixel(left, y, Rgb([255, 255, 0]));
        image.put_pixel(right - 1, y, Rgb([255, 255, 0]));
    }
}

fn crops(episode: &Episode) -> Result<RgbImage, Box<dyn Error>> {
    let (columns, side) = (30, CROP_SIDE as i64);
    let tracks = episode.truth.objects.len();
    let mut sheet = RgbImage::new((columns * side) as u32, (2 * tracks as i64 * side) as u32);
    let mut paste = |crop: &Crop, row: i64, column: i64| -> Result<(), Box<dyn Error>> {
        let crop = RgbImage::from_raw(CROP_SIDE as u32, CROP_SIDE as u32, crop.0.to_vec()).ok_or("32x32")?;
        imageops::replace(&mut sheet, &crop, column * side, row * side);
        Ok(())
    };
    for track in 0..tracks {
        let seen: Vec<_> = episode.observations.detections.iter().filter(|d| d.track == track).collect();
        for column in 0..(columns as usize).min(seen.len()) {
            let detection = seen[column * seen.len() / (columns as usize).min(seen.len())];
            paste(&detection.masked_crop, 2 * track as i64, column as i64)?;
            paste(&detection.boxed_crop, 2 * track as i64 + 1, column as i64)?;
        }
    }
    Ok(sheet)
}
