//! `bench look SCENE`: a scene at a glance.

pub mod error;
mod symmetries;

use super::placed;
use crate::command::cli::LookArgs;
use crate::command::error::BenchError;
use crate::exit::Exit;
use crate::figure::canvas::Canvas;
use crate::figure::scene_sheet::{BOX, BOX_OF_NOTHING, Panel};
use crate::progress::Progress;
use crate::result::output_folder::OutputFolder;
use crate::scene_file::{self, SceneFile};
use error::LookError;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;
use std::io::Write;
use std::path::{Path, PathBuf};
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::{Camera, DetectionTruth, Pose, Seed, Split, View};
use vantage_sim::checked::CheckedScene;
use vantage_sim::object::Catalog;
use vantage_sim::observer::{Look, Observer};
use vantage_sim::render::choice::open;
use vantage_sim::render::{Renderer, Shot};
use vantage_sim::rollout::{Rollout, roll_out};
use vantage_sim::scene::RoomSpec;
use vantage_sim::views::training_views;

/// Longer side of the picture of the world and of each image of the camera, pixels.
const PICTURE: u32 = 640;
/// Images of the camera: of each third of the path the fullest of so many.
const FRAMES: usize = 3;
const CANDIDATES: usize = 8;
/// Instances, a column each, and their views.
const INSTANCES: usize = 10;
const VIEWS: usize = 8;
const CROP: u32 = 128;
/// Height of a caption's line.
const CAPTION: u32 = 24;
/// Of a caption from the corner of its line.
const MARGIN: u32 = 4;
/// Horizontal field of view from above: narrow, so that walls hide little.
const FROM_ABOVE_FOV: f64 = 0.3;

/// Writes the sheet of the scene's first seed: the world from above with the robot's path, three images with the boxes of
/// their detections, and crops of ten instances, each column ordered by azimuth. With `--rerun` also the whole episode. Prints
/// the symmetries of the scene's meshes.
pub fn look(args: &LookArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let file: SceneFile = scene_file::read(&args.scene)?;
    file.check_simulated(&args.scene)?;
    let scene = file.checked(&args.scene, &args.making.cache, &Progress::detect())?;
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("out/{}.png", file.name)));
    if path.extension().is_none_or(|extension| extension != "png") || path.exists() && !path.is_file() {
        return Err(LookError::NoPicture { path }.into());
    }
    let out = OutputFolder::probe(path.parent().unwrap_or(Path::new(".")))?;
    #[cfg(not(feature = "rerun"))]
    if args.rerun.is_some() {
        return Err(crate::left_out::LeftOut::Rerun.into());
    }
    let opened = open(args.making.renderer.into())?;
    if let Some(notice) = &opened.notice {
        Progress::detect().note(notice);
    }
    let mut renderer = opened.renderer;
    let seed = file.evaluation.seeds.as_slice().first().copied().unwrap_or(Seed(0));

    let rollout = roll_out(&scene, seed, Split::Test, &mut |_| {});
    let rollout = rollout.map_err(|error| placed(error, &args.scene))?;
    let Camera { width, height, .. } = rollout.camera;
    let pitch = CAPTION + PICTURE * height / width.max(height);
    let mut sheet = Canvas::new(2 * PICTURE, 2 * pitch + CAPTION + VIEWS as u32 * CROP);
    let pictures = pictures(&scene, &rollout, renderer.as_mut())?;
    for (index, (caption, picture)) in pictures.iter().enumerate() {
        let (left, top) = (index as u32 % 2 * PICTURE, index as u32 / 2 * pitch);
        sheet.text(caption, ((left + MARGIN) as i32, (top + MARGIN) as i32));
        picture.place_on(&mut sheet, left, top + CAPTION, PICTURE);
    }
    let conditions = scene.view_conditions();
    let shown = instances(&scene);
    let caption = format!(
        "test instances, a column each ({shown}), from azimuths all round as the scene's sensors see them"
    );
    sheet.text(&caption, (MARGIN as i32, (2 * pitch + MARGIN) as i32));
    let set = training_views(&conditions, Split::Test, shown, seed, renderer.as_mut(), &mut |_| {})?;
    for instance in 0..shown {
        let mut views: Vec<&View> = set.views.iter().filter(|view| view.instance == instance).collect();
        views.sort_by(|a, b| a.viewpoint.azimuth().total_cmp(&b.viewpoint.azimuth()));
        let rows = VIEWS.min(views.len());
        for row in 0..rows {
            let crop = &views[row * views.len() / rows].crop;
            let panel = Panel::new(CROP_SIDE as u32, CROP_SIDE as u32, crop.0.to_vec())?;
            let top = 2 * pitch + CAPTION + row as u32 * CROP;
            panel.place_on(&mut sheet, instance as u32 * CROP, top, CROP);
        }
    }
    let name = path.file_name().map(Path::new).unwrap_or(Path::new("look.png"));
    out.write(name, &sheet.png()?)?;
    writeln!(stdout, "{}", path.display())?;
    symmetries::print(scene.meshes(), renderer.as_mut(), stdout)?;
    #[cfg(feature = "rerun")]
    if let Some(path) = &args.rerun {
        let _folder = OutputFolder::probe(path.parent().unwrap_or(Path::new(".")))?;
        crate::figure::recording::record(&file.name, &scene, &rollout, renderer.as_mut(), path)?;
        writeln!(stdout, "{}", path.display())?;
    }
    Ok(Exit::Success)
}

/// As many instances as are shown: fewer only where the scene has no family and fewer meshes.
fn instances(scene: &CheckedScene) -> usize {
    let catalog = Catalog::new(&scene.world().families, scene.meshes(), Split::Test);
    catalog.in_turn(INSTANCES).len()
}

/// The world from above, then the camera's images, with their captions.
fn pictures(
    scene: &CheckedScene,
    rollout: &Rollout,
    renderer: &mut dyn Renderer,
) -> Result<Vec<(String, Panel)>, BenchError> {
    let rendered = rollout.render_scene(scene);
    let above = from_above(&scene.world().room, &rollout.camera);
    let frame = renderer.frame(&rendered, &above)?;
    let mut world = Panel::new(frame.width, frame.height, frame.rgb)?;
    let way = path_in(&above, rollout);
    let caption = if scene.robot().path.stations() {
        world.points(&way);
        "from above; red: where the camera stood"
    } else {
        world.path(&way);
        "from above; red: the camera's way"
    };
    let mut panels = vec![(caption.to_owned(), world)];
    let mut observer = Observer::new(scene, rollout);
    let is_something = |truth: &DetectionTruth| truth.visible_fraction > 0.0;
    let of_objects = |look: &Look| look.detections.iter().filter(|(_, truth)| is_something(truth)).count();
    let fullness = |look: &Look| (of_objects(look), look.detections.len());
    for third in 0..FRAMES {
        let mut step = candidate(third, 0, rollout.steps());
        let mut look = observer.look(step, renderer)?;
        for number in 1..CANDIDATES {
            let at = candidate(third, number, rollout.steps());
            let other = observer.look(at, renderer)?;
            if fullness(&other) > fullness(&look) {
                (step, look) = (at, other);
            }
        }
        let (last, found) = (rollout.steps() - 1, of_objects(&look));
        let nothing = look.detections.len() - found;
        let mut caption = format!("step {step}, 0 to {last}; detections, yellow: {found}");
        if nothing > 0 {
            caption += &format!("; of nothing, cyan: {nothing}");
        }
        let mut panel = Panel::new(look.frame.width, look.frame.height, look.frame.rgb)?;
        for (detection, truth) in &look.detections {
            let hue = if is_something(truth) { BOX } else { BOX_OF_NOTHING };
            panel.outline(&detection.bounding_box, hue);
        }
        panels.push((caption, panel));
    }
    Ok(panels)
}

/// A step of a third of the path.
fn candidate(third: usize, number: usize, steps: usize) -> usize {
    (third * CANDIDATES + number) * steps / (FRAMES * CANDIDATES)
}

/// A camera high above the middle of the room that holds all of it, x to the right and y up.
fn from_above(room: &RoomSpec, camera: &Camera) -> Shot {
    let camera = Camera::with_horizontal_fov(camera.width, camera.height, FROM_ABOVE_FOV);
    let half_width = (FROM_ABOVE_FOV / 2.0).tan();
    let half_height = half_width * f64::from(camera.height) / f64::from(camera.width);
    let height = room.height + (room.length / 2.0 / half_width).max(room.width / 2.0 / half_height);
    Shot { camera, world_from_camera: Pose::new(Vector3::z() * height, Vector3::x() * PI) }
}

/// Where the camera was at each step, in the picture from above.
fn path_in(above: &Shot, rollout: &Rollout) -> Vec<[f64; 2]> {
    let camera_from_world = above.world_from_camera.inverse();
    let cameras = (0..rollout.steps()).map(|step| rollout.shot(step).world_from_camera);
    let positions = cameras.map(|pose| Point3::from(pose.translation.vector));
    positions.filter_map(|p| Some(above.camera.project(&(camera_from_world * p))?.into())).collect()
}
