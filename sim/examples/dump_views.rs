//! Writes training views of a scene as raw files, for a look at them or for a trial outside of this workspace:
//!
//! `cargo run --release -p vantage-sim --example dump_views -- scenes/tabletop.yaml train 512 24 7 out/views`
//!
//! - `crops.u8`: `[N, 32, 32, 3]` masked sRGB crops
//! - `views.f32`: `[N, 14]` conditioning, little-endian
//! - `meta.csv`: instance, session, family, symmetry, visible fraction of each view
//! - `sheet.png`: views of the first instances, a row each

use serde::Deserialize;
use std::io::Write;
use std::path::Path;
use std::{env, error::Error, fs, io};
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::{Seed, Split, ViewSet};
use vantage_sim::checked::{CheckedScene, SceneSpec};
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::scene::{RobotSpec, SensorSpec, ViewsSpec, WorldSpec};
use vantage_sim::views::training_views;

#[derive(Deserialize)]
struct SceneFile {
    world: WorldSpec,
    robot: RobotSpec,
    sensors: SensorSpec,
    views: ViewsSpec,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [scene, split, instances, views, seed, out] = arguments.as_slice() else {
        return Err("usage: dump_views SCENE train|validation|test INSTANCES VIEWS SEED FOLDER".into());
    };
    let split = match split.as_str() {
        "train" => Split::Train,
        "validation" => Split::Validation,
        "test" => Split::Test,
        other => return Err(format!("unknown split `{other}`").into()),
    };
    let file: SceneFile = serde_saphyr::from_str(&fs::read_to_string(scene)?)?;
    let mut spec =
        SceneSpec { world: file.world, robot: file.robot, sensors: file.sensors, views: file.views };
    spec.views.views_per_instance = views.parse()?;
    let conditions =
        CheckedScene::new(spec, Path::new(scene).parent().unwrap_or(Path::new(".")), &mut |_| ())?
            .view_conditions();
    let mut renderer = ReferenceRenderer::default();
    let start = std::time::Instant::now();
    let set = training_views(
        &conditions,
        split,
        instances.parse()?,
        Seed(seed.parse()?),
        &mut renderer,
        &mut |progress| eprintln!("{} of {} instances", progress.done, progress.total),
    )?;
    let rate = set.views.len() as f64 / start.elapsed().as_secs_f64();
    eprintln!("{} views, {rate:.0} a second", set.views.len());
    write(&set, Path::new(out))
}

fn write(set: &ViewSet, folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let create = |name: &str| fs::File::create(folder.join(name)).map(io::BufWriter::new);
    let (mut crops, mut viewpoints, mut meta) =
        (create("crops.u8")?, create("views.f32")?, create("meta.csv")?);
    writeln!(meta, "instance,session,family,symmetry,visible_fraction")?;
    for view in &set.views {
        let record = &set.instances[view.instance];
        crops.write_all(&*view.crop.0)?;
        for x in view.viewpoint.conditioning() {
            viewpoints.write_all(&(x as f32).to_le_bytes())?;
        }
        writeln!(
            meta,
            "{},{},{},{:?},{:.4}",
            view.instance, view.session, record.family, record.symmetry, view.visible_fraction
        )?;
    }
    sheet(set)?.save(folder.join("sheet.png"))?;
    Ok(())
}

fn sheet(set: &ViewSet) -> Result<image::RgbImage, Box<dyn Error>> {
    let (rows, columns, side) = (set.instances.len().min(40), 24, CROP_SIDE);
    let mut sheet = image::RgbImage::new((columns * side) as u32, (rows * side) as u32);
    for row in 0..rows {
        let views = set.views.iter().filter(|view| view.instance == row).take(columns);
        for (column, view) in views.enumerate() {
            let crop = image::RgbImage::from_raw(side as u32, side as u32, view.crop.0.to_vec())
                .ok_or("a crop has 32x32 pixels")?;
            image::imageops::replace(&mut sheet, &crop, (column * side) as i64, (row * side) as i64);
        }
    }
    Ok(sheet)
}
