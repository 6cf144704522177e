//! What is written as BOP is read back, and damaged copies are told of.

use super::bop::json;
use super::*;
use crate::import::{ImportError, ImportReport};
use crate::picture::write_jpeg;
use serde_json::{Value, json};
use std::path::PathBuf;

const ALL: DetectionLimits = DetectionLimits { min_visible_fraction: 0.0, min_mask_pixels: 1 };

/// Fills the outlines of meshes, the nearest first, as [`capture`] does.
pub(super) struct Outlines;

impl Silhouettes for Outlines {
    fn ids(&mut self, camera: &Camera, meshes: &[(&MeshGeometry, Pose)]) -> Result<Vec<u32>, String> {
        let mut ids = vec![0; (camera.width * camera.height) as usize];
        let mut nearest = vec![f64::INFINITY; ids.len()];
        for ((mesh, pose), id) in meshes.iter().zip(1..) {
            let model =
                ObjectModel { positions: mesh.positions.clone(), ..rectangle(1.0, 1.0, Symmetry::None) };
            let [left, right, top, bottom] = outline(camera, pose, &model);
            for (i, found) in ids.iter_mut().enumerate() {
                let (x, y) = ((i as u32 % camera.width) as f64 + 0.5, (i as u32 / camera.width) as f64 + 0.5);
                let depth = pose.translation.z;
                if (left..right).contains(&x) && (top..bottom).contains(&y) && depth < nearest[i] {
                    (*found, nearest[i]) = (id, depth);
                }
            }
        }
        Ok(ids)
    }
}

/// No dataset here needs to be drawn.
pub(super) struct Never;

impl Silhouettes for Never {
    fn ids(&mut self, _: &Camera, _: &[(&MeshGeometry, Pose)]) -> Result<Vec<u32>, String> {
        Err("drawn".to_owned())
    }
}

/// One scene of five images, as files.
pub(super) fn written() -> (tempfile::TempDir, Rectangles) {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes().swap_remove(0);
    write_scenes(folder.path(), BopLayout::Scenes, std::slice::from_ref(&scene));
    (folder, scene)
}

fn read(folder: &Path, draws: &mut dyn Silhouettes) -> (Vec<BopArrangement>, ImportReport) {
    try_read(folder, draws).unwrap()
}

pub(super) fn try_read(
    folder: &Path,
    draws: &mut dyn Silhouettes,
) -> Result<(Vec<BopArrangement>, ImportReport), ImportError> {
    let mut report = ImportReport::default();
    let bop = BopScenes::open(folder, &mut report)?;
    let scene = bop.scenes[0].clone();
    let read = bop.read(&scene, &ALL, draws, &mut report)?;
    Ok((read, report))
}

pub(super) fn change(folder: &Path, file: &str, with: impl FnOnce(&mut Value)) -> PathBuf {
    let path = folder.join("train/000000").join(file);
    let mut value = json(&path);
    with(&mut value);
    fs::write(&path, value.to_string()).unwrap();
    path
}

fn assert_same(arrangement: &BopArrangement, scene: &Rectangles) {
    let Episode { observations, truth, .. } = &arrangement.episode;
    assert_eq!(observations.steps(), scene.captures.len());
    assert_eq!(truth.objects.len(), 3);
    for (step, capture) in scene.captures.iter().enumerate() {
        let world_from_camera = truth.world_from_robot[step] * observations.robot_from_camera;
        assert!((world_from_camera.inv_mul(&capture.world_from_camera)).translation.vector.norm() < 1e-9);
        assert!(world_from_camera.rotation.angle_to(&capture.world_from_camera.rotation) < 1e-7);
        let at_step = || observations.detections.iter().filter(|detection| detection.step == step);
        assert_eq!(at_step().count(), capture.objects.len());
        for (detection, object) in at_step().zip(&capture.objects) {
            assert_eq!((detection.track, detection.mask_pixels), (object.track, object.visible_pixels));
            assert_eq!(detection.bounding_box, object.visible_box);
            let shown = window::Labelled { width: 64, rgb: &capture.rgb, ids: &capture.ids };
            let around = window::Window::around(&object.visible_box);
            let crop = window::cut(&shown, &around, Some(object.track as u32 + 1));
            assert!(detection.masked_crop == crop);
        }
    }
    let up = |pose: &Pose| pose.rotation * Vector3::z();
    assert!((up(&truth.world_from_robot[0]) - Vector3::z()).norm() < 1e-7, "level, as estimators take it");
    for (object, own) in truth.objects.iter().zip(&scene.objects) {
        let moved = object.world_from_object.translation.vector - own.world_from_object.translation.vector;
        assert!(moved.norm() < 1e-6, "{moved}");
    }
    let [standing, lying, _] = &truth.objects[..] else { panic!() };
    assert!(
        standing.world_from_object.rotation.angle() < 1e-6
            && standing.symmetry == Symmetry::Cyclic { order: 2 }
    );
    assert_eq!(lying.world_from_object.rotation.angle(), 0.0, "upright, whatever the model's axes");
    assert!((standing.size - 0.31f64.hypot(0.22)).abs() < 1e-6);
}

#[test]
fn what_was_written_is_read_with_the_same_poses_and_detections() {
    let (folder, scene) = written();
    for place in ["", "train", "train/000000"] {
        let (arrangements, report) = read(&folder.path().join(place), &mut Never);
        assert_eq!((arrangements.len(), report.skipped.len()), (1, 0));
        assert_eq!(arrangements[0].name, "000000_00");
        assert_same(&arrangements[0], &scene);
    }
}

#[test]
fn models_are_drawn_where_there_are_no_masks() {
    let (folder, scene) = written();
    for masks in ["mask", "mask_visib"] {
        fs::remove_dir_all(folder.path().join("train/000000").join(masks)).unwrap();
    }
    assert_same(&read(folder.path(), &mut Outlines).0[0], &scene);
    let shares = |arrangement: &BopArrangement| -> Vec<f64> {
        arrangement.episode.truth.detections.iter().map(|truth| truth.visible_fraction).collect()
    };
    let told = shares(&read(folder.path(), &mut Outlines).0[0]);
    fs::remove_file(folder.path().join("train/000000/scene_gt_info.json")).unwrap();
    let drawn = shares(&read(folder.path(), &mut Outlines).0[0]);
    assert_eq!(told.len(), drawn.len());
    assert!(drawn.iter().any(|share| *share < 0.9) && drawn.contains(&1.0));
    let (none, report) = read(folder.path(), &mut Never);
    assert!(none.is_empty() && report.skipped.iter().any(|skipped| skipped.reason.contains("drawn")));
}

#[test]
fn boxes_are_those_of_the_first_camera() {
    let (folder, _) = written();
    let first = read(folder.path(), &mut Never).0.remove(0).episode.observations;
    change(folder.path(), "scene_camera.json", |cameras| {
        for image in 1..5 {
            let k = &mut cameras[image.to_string()]["cam_K"];
            k[2] = json!(k[2].as_f64().unwrap() + 7.0);
        }
    });
    let moved = read(folder.path(), &mut Never).0.remove(0).episode.observations;
    for (a, b) in first.detections.iter().zip(&moved.detections) {
        let shift = if a.step == 0 { 0.0 } else { -7.0 };
        assert!((b.bounding_box.min.x - a.bounding_box.min.x - shift).abs() < 1e-9);
    }
}

#[test]
fn what_is_missing_or_wrong_is_left_out_and_told() {
    let (folder, scene) = written();
    let at = |name: &str| folder.path().join("train/000000").join(name);
    fs::remove_file(at("rgb/000001.png")).unwrap();
    change(folder.path(), "scene_gt.json", |gt| {
        let rotation = &mut gt["2"][0]["cam_R_m2c"];
        for i in 0..3 {
            rotation[i] = json!(-rotation[i].as_f64().unwrap());
        }
    });
    let (arrangements, report) = read(folder.path(), &mut Never);
    let told: Vec<String> = report.skipped.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|line| line.contains("000001.png") && line.contains("no image")), "{told:?}");
    assert!(told.iter().any(|line| line.contains("image 2: object 1 has no rigid pose")), "{told:?}");
    let seen = &arrangements[0].episode.observations;
    let of_first = |step: usize| seen.detections.iter().any(|d| (d.step, d.track) == (step, 0));
    assert_eq!(seen.steps(), scene.captures.len() - 1);
    assert!(of_first(0) && !of_first(1), "the second step is the third image, which lost its first object");

    change(folder.path(), "scene_camera.json", |cameras| {
        cameras["0"]["cam_K"][0] = json!(0.0);
        cameras.as_object_mut().unwrap().remove("3");
    });
    let (none, report) = read(folder.path(), &mut Never);
    let told: Vec<String> = report.skipped.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|line| line.contains("image 0: cam_K")), "{told:?}");
    assert!(told.iter().any(|line| line.contains("image 3: no camera")), "{told:?}");
    assert!(none.is_empty() && told.iter().any(|line| line.contains("fewer than 3")), "{told:?}");
}

#[test]
fn camera_poses_that_are_none_are_told() {
    let (folder, _) = written();
    change(folder.path(), "scene_camera.json", |cameras| {
        for i in 0..3 {
            let number = cameras["1"]["cam_R_w2c"][i].as_f64().unwrap();
            cameras["1"]["cam_R_w2c"][i] = json!(-number);
        }
        cameras["2"].as_object_mut().unwrap().remove("cam_t_w2c");
        for key in ["cam_R_w2c", "cam_t_w2c"] {
            cameras["3"].as_object_mut().unwrap().remove(key);
        }
    });
    let mut report = ImportReport::default();
    let bop = BopScenes::open(folder.path(), &mut report).unwrap();
    let error = bop.read(&bop.scenes[0], &ALL, &mut Never, &mut report).unwrap_err().to_string();
    assert!(
        error.contains("cam_R_w2c of every image"),
        "these models lie, so nothing else tells what is up: {error}"
    );
    let told: Vec<String> = report.skipped.iter().map(ToString::to_string).collect();
    let why = "3 of 5 images, image 1 the first, have no rigid cam_R_w2c";
    assert!(told.iter().any(|line| line.contains("scene_camera.json") && line.contains(why)), "{told:?}");
}

#[test]
fn where_no_image_is_left_the_error_says_what_was_wrong_with_the_first() {
    let (folder, _) = written();
    for focal in [1e300, 1e-308] {
        change(folder.path(), "scene_camera.json", |cameras| {
            for camera in cameras.as_object_mut().unwrap().values_mut() {
                camera["cam_K"][0] = json!(focal);
            }
        });
        let error = try_read(folder.path(), &mut Never).unwrap_err().to_string();
        let is_told = error.contains("scene_camera.json") && error.contains("image 0: cam_K is no pinhole");
        assert!(is_told, "{error}");
    }
}

#[test]
fn translations_in_metres_are_refused() {
    let (folder, _) = written();
    change(folder.path(), "scene_gt.json", |gt| {
        for object in gt.as_object_mut().unwrap().values_mut().flat_map(|image| image.as_array_mut().unwrap())
        {
            for number in object["cam_t_m2c"].as_array_mut().unwrap() {
                *number = json!(number.as_f64().unwrap() / 1000.0);
            }
        }
    });
    let error = try_read(folder.path(), &mut Never).unwrap_err().to_string();
    assert!(error.contains("cam_t_m2c") && error.contains("expected millimetres"), "{error}");
}

#[test]
fn an_image_whose_principal_point_lies_outside_of_it_is_left_out() {
    let (folder, scene) = written();
    change(folder.path(), "scene_camera.json", |cameras| {
        cameras["1"]["cam_K"][2] = json!(-1.0);
        cameras["2"]["cam_K"][5] = json!(f64::from(scene.captures[2].camera.height) + 1.0);
    });
    let (arrangements, report) = read(folder.path(), &mut Never);
    let told: Vec<String> = report.skipped.iter().map(ToString::to_string).collect();
    for image in [1, 2] {
        let why = format!("image {image}: cam_K has its principal point at");
        assert!(
            told.iter().any(|line| line.contains("scene_camera.json") && line.contains(&why)),
            "{told:?}"
        );
    }
    assert_eq!(told.len(), 2, "{told:?}");
    assert_eq!(arrangements[0].episode.observations.steps(), scene.captures.len() - 2);
}

#[test]
fn files_that_are_no_annotations_stop_the_reading() {
    let (folder, _) = written();
    let path = folder.path().join("train/000000/scene_gt.json");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let error = try_read(folder.path(), &mut Never).unwrap_err().to_string();
    assert!(error.contains("scene_gt.json") && error.contains("by the number of the image"), "{error}");
    fs::remove_file(&path).unwrap();
    let error = try_read(folder.path(), &mut Never).unwrap_err().to_string();
    assert!(error.contains("a folder with a scene_gt.json"), "{error}");
}

#[test]
fn splits_are_not_mixed() {
    let folder = tempfile::tempdir().unwrap();
    write_scenes(folder.path(), BopLayout::Scenes, &scenes());
    let error = try_read(folder.path(), &mut Never).unwrap_err().to_string();
    assert!(error.contains("several: train, val"), "{error}");
    let of_split = BopScenes::open(&folder.path().join("val"), &mut ImportReport::default()).unwrap();
    assert_eq!(of_split.scenes.len(), 2);
}

#[test]
fn images_may_be_gray_or_jpeg() {
    let (folder, _) = written();
    let at = |name: &str| folder.path().join("train/000000").join(name);
    let coloured = read(folder.path(), &mut Never).0.remove(0).episode.observations.detections;
    fs::rename(at("rgb"), at("gray")).unwrap();
    for image in 0..5 {
        let png = at(&format!("gray/{image:06}.png"));
        let pixels = image::open(&png).unwrap();
        if image == 0 {
            pixels.to_luma8().save(&png).unwrap();
        } else {
            let rgb = pixels.into_rgb8();
            write_jpeg(&png.with_extension("jpg"), rgb.as_raw(), rgb.width(), rgb.height()).unwrap();
            fs::remove_file(png).unwrap();
        }
    }
    let seen = read(folder.path(), &mut Never).0.remove(0).episode.observations.detections;
    assert_eq!(seen.len(), coloured.len());
    for (own, other) in seen.iter().zip(&coloured) {
        assert_eq!((own.step, own.track, own.bounding_box), (other.step, other.track, other.bounding_box));
        let (own_bytes, other_bytes) = (&own.masked_crop.0, &other.masked_crop.0);
        if own.step == 0 {
            assert!(own_bytes.chunks(3).all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2]));
        }
        let off = own_bytes.iter().zip(other_bytes.iter()).map(|(a, b)| a.abs_diff(*b) as u32).sum::<u32>();
        assert!(own.step == 0 || off / CROP_BYTES as u32 <= 12, "{off}");
    }
}

#[test]
fn huge_images_are_left_out_and_told() {
    let (folder, scene) = written();
    let image = folder.path().join("train/000000/rgb/000001.png");
    image::RgbImage::new(20_000, 1).save(&image).unwrap();
    let (arrangements, report) = read(folder.path(), &mut Never);
    assert_eq!(arrangements[0].episode.observations.steps(), scene.captures.len() - 1);
    assert!(report.skipped.iter().any(|skipped| skipped.file == image), "{report:?}");
}

/// LM-O has no masks in the copy that is looked for, so that its models are drawn.
#[test]
fn photographs_of_lmo_are_episodes() {
    let root = std::env::var_os("VANTAGE_SHARED").map(PathBuf::from);
    let root = root.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"));
    let folder = root.join("data/photos/lmo");
    if !folder.is_dir() {
        let told = "SKIPPED: no photographs; set VANTAGE_SHARED to a folder that holds data/photos/lmo";
        let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{told}\n").as_bytes());
        return;
    }
    let (arrangements, report) = read(&folder, &mut Outlines);
    assert_eq!(arrangements.len(), 20, "{report:?}");
    for arrangement in &arrangements {
        let Episode { observations, truth, .. } = &arrangement.episode;
        assert!(observations.steps() >= 3 && truth.objects.len() <= 8, "{}", arrangement.name);
        assert_eq!(truth.detections.len(), observations.detections.len());
        assert!(observations.detections.iter().any(|detection| detection.step == 0));
        for pose in &truth.world_from_robot {
            let eye = (pose * observations.robot_from_camera).translation.vector;
            let from_objects =
                truth.objects.iter().map(|o| (o.world_from_object.translation.vector - eye).norm());
            assert!(from_objects.clone().all(|distance| (0.2..3.0).contains(&distance)), "metres: {eye}");
        }
    }
}

#[test]
fn hostile_meshes_are_models_without_a_surface() {
    let (folder, _) = written();
    let mesh = folder.path().join("models/obj_000002.ply");
    let whole = fs::read_to_string(&mesh).unwrap();
    let negative = whole.replace("3 0 1 2", "3 0 -1 2");
    let beyond = whole.replace("3 0 1 2", "3 0 1 9");
    let hostile = [
        "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n",
        "ply\nformat binary_little_endian 1.0\nelement face 2\nproperty list uint int vertex_indices\nend_header\n\u{7f}\u{7f}\u{7f}\u{7f}",
        "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nelement face 18446744073709551615\nend_header\n",
        "not a mesh",
        "",
        &whole[..whole.len() - 9],
        &negative,
        &beyond,
    ];
    for text in hostile {
        fs::write(&mesh, text).unwrap();
        let (arrangements, report) = read(folder.path(), &mut Never);
        assert_eq!(arrangements[0].episode.truth.objects.len(), 3, "its size is in models_info.json");
        let told = report.skipped.iter().any(|skipped| skipped.file.ends_with("obj_000002.ply"));
        assert!(told, "{text:?}: {report:?}");
    }
}
