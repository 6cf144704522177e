//! Single faults of a dataset of BOP: what is left out and what is refused, each told with its place.

use super::bop::json;
use super::bop_import::{Never, change, try_read, written};
use super::*;
use crate::picture::write_jpeg;
use serde_json::{Value, json};

/// What is told of a dataset that still reads, line by line, and how many steps are left.
fn told(folder: &Path) -> (Vec<String>, usize) {
    let (arrangements, report) = try_read(folder, &mut Never).unwrap();
    let steps = arrangements.iter().map(|arrangement| arrangement.episode.observations.steps()).sum();
    (report.skipped.iter().map(ToString::to_string).collect(), steps)
}

/// One line is told, with all of `parts`, and so many steps are left.
fn assert_told(folder: &Path, steps: usize, parts: [&str; 2]) {
    let (told, left) = told(folder);
    assert!(told.len() == 1 && parts.iter().all(|part| told[0].contains(part)), "{told:?}");
    assert_eq!(left, steps);
}

fn change_models(folder: &Path, with: impl FnOnce(&mut Value)) {
    let path = folder.join("models/models_info.json");
    let mut infos = json(&path);
    with(&mut infos);
    fs::write(&path, infos.to_string()).unwrap();
}

#[test]
fn intrinsics_of_no_pinhole_are_told() {
    for (place, number) in [(1, 4.0), (0, -500.0), (4, 0.5), (6, 0.01), (8, 2.0)] {
        let (folder, scene) = written();
        change(folder.path(), "scene_camera.json", |cameras| cameras["2"]["cam_K"][place] = json!(number));
        let parts = ["scene_camera.json", "image 2: cam_K is no"];
        assert_told(folder.path(), scene.captures.len() - 1, parts);
    }
}

#[test]
fn a_pose_farther_than_ten_kilometres_is_told() {
    let (folder, scene) = written();
    change(folder.path(), "scene_gt.json", |gt| gt["1"][0]["cam_t_m2c"][2] = json!(2e7));
    assert_told(folder.path(), scene.captures.len(), ["scene_gt.json", "image 1: object 1 has no rigid"]);
}

#[test]
fn an_object_without_a_model_is_told() {
    let (folder, scene) = written();
    change_models(folder.path(), |infos| {
        infos.as_object_mut().unwrap().remove("2");
    });
    let (arrangements, report) = try_read(folder.path(), &mut Never).unwrap();
    assert_eq!(arrangements[0].episode.truth.objects.len(), scene.objects.len() - 1);
    let told = report.skipped[0].to_string();
    assert!(told.contains("models_info.json") && told.contains("object 2: no entry"), "{told}");
}

#[test]
fn a_model_larger_than_a_kilometre_is_refused() {
    for field in ["diameter", "size_x", "min_z"] {
        let (folder, _) = written();
        change_models(folder.path(), |infos| infos["2"][field] = json!(3e6));
        let error = try_read(folder.path(), &mut Never).unwrap_err().to_string();
        assert!(error.contains("models_info.json, 2: got") && error.contains("up to a kilometre"), "{error}");
    }
}

#[test]
fn an_image_with_another_number_of_notes_than_objects_is_told() {
    let (folder, scene) = written();
    change(folder.path(), "scene_gt_info.json", |infos| {
        infos["3"].as_array_mut().unwrap().pop();
    });
    let parts = ["scene_gt_info.json", "image 3: not one entry"];
    assert_told(folder.path(), scene.captures.len() - 1, parts);
}

#[test]
fn an_image_that_lacks_a_mask_or_has_one_of_another_size_is_told() {
    let (folder, scene) = written();
    let mask = |image: u32| folder.path().join(format!("train/000000/mask_visib/{image:06}_000001.png"));
    fs::remove_file(mask(1)).unwrap();
    image::GrayImage::new(3, 3).save(mask(3)).unwrap();
    let (told, steps) = told(folder.path());
    assert!(told.iter().any(|line| line.contains("000001_000001.png")), "{told:?}");
    assert!(told.iter().any(|line| line.contains("000003_000001.png, size: got (3, 3)")), "{told:?}");
    assert_eq!(steps, scene.captures.len() - 2);
}

/// Its header alone says so.
#[test]
fn an_image_of_more_pixels_than_fit_is_told() {
    let (folder, scene) = written();
    let at = |ending: &str| folder.path().join(format!("train/000000/rgb/000002.{ending}"));
    fs::remove_file(at("png")).unwrap();
    write_jpeg(&at("jpg"), &[90; 192], 8, 8).unwrap();
    let mut bytes = fs::read(at("jpg")).unwrap();
    let frame = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    let side = 16_000_u16.to_be_bytes();
    bytes[frame + 5..frame + 9].copy_from_slice(&[side, side].concat());
    fs::write(at("jpg"), bytes).unwrap();
    assert_told(folder.path(), scene.captures.len() - 1, ["000002.jpg", "256 MiB decoded"]);
}

/// Views of an object that turns before the camera, as splits for training have.
#[test]
fn a_lone_object_tells_the_camera_where_it_is_taken_to_stand() {
    let (folder, scene) = written();
    for file in ["scene_gt.json", "scene_gt_info.json"] {
        change(folder.path(), file, |images| {
            images
                .as_object_mut()
                .unwrap()
                .values_mut()
                .for_each(|of| of.as_array_mut().unwrap().truncate(1));
        });
    }
    change(folder.path(), "scene_camera.json", |cameras| {
        for camera in cameras.as_object_mut().unwrap().values_mut().filter_map(Value::as_object_mut) {
            camera.retain(|key, _| key == "cam_K");
        }
    });
    let (none, report) = try_read(folder.path(), &mut Never).unwrap();
    assert!(none.is_empty() && report.skipped[0].reason.contains("1 images, fewer than 3"), "{report:?}");

    let mut bop = BopScenes::open(folder.path(), &mut ImportReport::default()).unwrap();
    bop.lone_object_stands = true;
    let mut report = ImportReport::default();
    let limits = DetectionLimits { min_visible_fraction: 0.0, min_mask_pixels: 1 };
    let read = bop.read(&bop.scenes[0], &limits, &mut Never, &mut report).unwrap();
    assert_eq!((read.len(), report.skipped.len()), (1, 0), "{report:?}");
    let Episode { observations, truth, .. } = &read[0].episode;
    let [object] = &truth.objects[..] else { panic!("{:?}", truth.objects) };
    let own = scene.objects[0].world_from_object;
    for (world_from_robot, capture) in truth.world_from_robot.iter().zip(&scene.captures) {
        let seen = object.world_from_object.inv_mul(&(world_from_robot * observations.robot_from_camera));
        let expected = own.inv_mul(&capture.world_from_camera);
        assert!((seen.translation.vector - expected.translation.vector).norm() < 1e-6, "{seen} {expected}");
        assert!(seen.rotation.angle_to(&expected.rotation) < 1e-6, "{seen} {expected}");
    }
    assert_eq!(observations.steps(), scene.captures.len());
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_not_opened() {
    for (file, is_refused) in [
        ("train/000000/scene_camera.json", true),
        ("train/000000/scene_gt.json", true),
        ("train/000000/scene_gt_info.json", true),
        ("models/models_info.json", true),
        ("models/obj_000002.ply", false),
        ("train/000000/rgb/000001.png", false),
        ("train/000000/mask_visib/000001_000000.png", false),
    ] {
        let (folder, _) = written();
        let path = folder.path().join(file);
        fs::remove_file(&path).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&path).status().unwrap();
        assert!(made.success());
        let named = match try_read(folder.path(), &mut Never) {
            Err(error) if is_refused => error.to_string(),
            Ok((_, report)) if !is_refused => format!("{:?}", report.skipped),
            other => panic!("{file}: {other:?}"),
        };
        assert!(named.contains(path.file_name().unwrap().to_str().unwrap()), "{file}: {named}");
    }
}
