use crate::balls::{Ball, capture, looking};
use crate::{files, pipe, truncate};
use nalgebra::{Point3, Vector3};
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Provenance, StoreError, read_views, write_views};
use vantage_dataset::window::{Labelled, Window, cut};
use vantage_dataset::{Camera, Capture, InstanceId, Mask, Pose, Seed, Split, ViewSet, Viewpoint};
use vantage_formats::bigbird::{BigBirdWriter, object_folders, read_objects, uncalibrated_folders};
use vantage_formats::{ImportError, ImportReport};

const RADIUS: f64 = 0.08;
const ANGLES: [u32; 8] = [0, 45, 90, 135, 180, 225, 270, 315];

fn camera() -> Camera {
    Camera { width: 320, height: 256, fx: 266.5, fy: 267.0, cx: 161.0, cy: 126.0 }
}

fn world_from_table() -> Pose {
    Pose::new(Vector3::new(1.0, -2.0, 0.8), Vector3::new(0.0, 0.0, 0.7))
}

fn center_in_table() -> Point3<f64> {
    Point3::new(0.01, -0.02, 0.1)
}

/// What camera 1 to 5 sees after the table has turned.
fn shot(camera_number: usize, angle: u32) -> Capture {
    let elevation: f64 = [0.05, 0.4, 0.8, 1.1, 1.35][camera_number - 1];
    let azimuth = f64::from(angle).to_radians() + 0.01 * camera_number as f64;
    let eye = Point3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin());
    let table_from_camera = looking(Point3::from(eye.coords * 0.9), Point3::new(0.0, 0.0, 0.08));
    let balls = [Ball { center: world_from_table() * center_in_table(), radius: RADIUS }];
    capture(&balls, camera(), world_from_table() * table_from_camera)
}

fn export(root: &Path) -> PathBuf {
    let ball = Ball { center: world_from_table() * center_in_table(), radius: RADIUS };
    let mut writer = BigBirdWriter::create(root, &ball.truth(7), 0, world_from_table()).unwrap();
    for angle in ANGLES {
        for number in 1..=5 {
            writer.push(number, angle, &shot(number, angle)).unwrap();
        }
    }
    writer.finish().unwrap();
    root.join("ball_0000000000000007")
}

fn read(folder: &Path) -> Result<(ViewSet, ImportReport), ImportError> {
    read_objects(&[folder.to_owned()], Split::Train, &|_| true)
}

fn problem(folder: &Path) -> (String, String) {
    match read(folder) {
        Err(ImportError::Invalid(problem)) => (problem.field.clone(), problem.to_string()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_export_reads_back_with_the_true_viewpoints() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    assert_eq!(object_folders(root.path()).unwrap(), std::slice::from_ref(&folder));
    let (set, report) = read(&folder).unwrap();
    assert_eq!(report, ImportReport { views: 40, skipped: vec![] });
    assert_eq!(set.instances.len(), 1);
    assert_eq!(set.instances[0].id, InstanceId(7));

    let table_from_object = Pose::translation(0.01, -0.02, 0.1);
    let names = ANGLES.iter().flat_map(|angle| (1..=5).map(move |number| (number, *angle)));
    for (view, (number, angle)) in set.views.iter().zip(names) {
        let truth = shot(number, angle);
        let object_from_camera = (world_from_table() * table_from_object).inv_mul(&truth.world_from_camera);
        let expected = Viewpoint::new(&object_from_camera, 2.0 * RADIUS).unwrap();
        assert!((view.viewpoint.direction - expected.direction).norm() < 0.005, "{view:?} {expected:?}");
        assert!((view.viewpoint.roll - expected.roll).abs() < 0.02, "{view:?} {expected:?}");
        let half_a_pixel = 0.5 / (RADIUS * 266.5 / 0.9);
        assert!(
            (view.viewpoint.log_distance - expected.log_distance).abs() < 1.2 * half_a_pixel,
            "{view:?} {expected:?}"
        );
        assert!(view.box_center_error.iter().all(|error| error.abs() < 0.02), "{view:?}");

        let mask = Mask::of(&truth.ids, 320, 1).unwrap();
        let labelled = Labelled { width: 320, rgb: &truth.rgb, ids: &truth.ids };
        let crop = cut(&labelled, &Window::around(&mask.bounding_box), Some(1));
        let difference: i32 =
            crop.0.iter().zip(view.crop.0.iter()).map(|(a, b)| (i32::from(*a) - i32::from(*b)).abs()).sum();
        assert!(difference < 3 * 3072, "JPEG changes little: {difference}");
    }

    let stored = tempfile::tempdir().unwrap();
    write_views(stored.path(), &set, Provenance::default()).unwrap();
    assert_eq!(read_views(stored.path()).unwrap().views.len(), 40);
}

#[test]
fn angles_can_be_chosen() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let (set, report) = read_objects(&[folder], Split::Test, &|angle| angle % 90 == 0).unwrap();
    assert_eq!((set.views.len(), report.views, report.skipped.len()), (20, 20, 0));
    assert_eq!(set.split, Split::Test);
}

#[test]
fn equal_captures_make_equal_bytes() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (one, two) = (files(&export(one.path())), files(&export(two.path())));
    assert_eq!(one.len(), 3 * 40 + 8 + 2);
    assert!(one == two);
}

#[test]
fn what_is_missing_is_left_out_and_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    std::fs::remove_file(folder.join("NP2_45.jpg")).unwrap();
    std::fs::remove_file(folder.join("NP3_45.h5")).unwrap();
    std::fs::remove_file(folder.join("masks/NP1_0_mask.pbm")).unwrap();
    std::fs::write(
        folder.join("masks/NP1_90_mask.pbm"),
        b"P4\n320 256\n".iter().copied().chain([0; 10240]).collect::<Vec<u8>>(),
    )
    .unwrap();
    std::fs::write(
        folder.join("masks/NP4_90_mask.pbm"),
        b"P4\n320 256\n".iter().copied().chain([255; 10240]).collect::<Vec<u8>>(),
    )
    .unwrap();
    truncate(&folder.join("masks/NP5_90_mask.pbm"), 0.5);
    truncate(&folder.join("poses/NP5_180_pose.h5"), 0.5);
    truncate(&folder.join("NP4_270.jpg"), 0.5);
    truncate(&folder.join("NP5_270.jpg"), 0.01);
    let (set, report) = read(&folder).unwrap();
    let told: Vec<(String, &str)> = report
        .skipped
        .iter()
        .map(|skipped| {
            (skipped.file.strip_prefix(&folder).unwrap().display().to_string(), skipped.reason.as_str())
        })
        .collect();
    let files: Vec<&str> = told.iter().map(|(file, _)| file.as_str()).collect();
    let expected = [
        "masks/NP1_0_mask.pbm",
        "NP2_45.jpg",
        "masks/NP1_90_mask.pbm",
        "masks/NP4_90_mask.pbm",
        "masks/NP5_90_mask.pbm",
        "poses/NP5_180_pose.h5",
        "NP4_270.jpg",
        "NP5_270.jpg",
    ];
    assert_eq!(files, expected, "{told:?}");
    assert_eq!(told[1].1, "no image");
    assert_eq!(told[2].1, "the mask is empty");
    assert_eq!(told[3].1, "the mask is that of the background, or the object is too near");
    assert!(told[6].1.contains("cut short"), "{}", told[6].1);
    assert_eq!(set.views.len(), 40 - 7 - 5);
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_left_out_and_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    pipe(&folder.join("NP2_45.jpg"));
    pipe(&folder.join("masks/NP1_0_mask.pbm"));
    let pose = folder.join("poses/NP5_180_pose.h5");
    std::fs::remove_file(&pose).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &pose).unwrap();
    let (set, report) = read(&folder).unwrap();
    let told = |skipped: &vantage_formats::Skipped| skipped.reason.contains("not a regular file");
    assert!(report.skipped.iter().all(told), "{report:?}");
    assert_eq!((report.skipped.len(), set.views.len()), (3, 40 - 2 - 5));
    pipe(&folder.join("calibration.h5"));
    assert!(matches!(read(&folder), Err(ImportError::Read { .. })));
    assert_eq!(object_folders(root.path()).unwrap(), [] as [PathBuf; 0]);
}

#[test]
fn folders_of_objects_without_a_calibration_are_found_and_others_are_not() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    for other in ["papers", "masked/masks", "shown", "thumbnails"] {
        std::fs::create_dir_all(root.path().join(other)).unwrap();
    }
    std::fs::copy(folder.join("NP1_0.jpg"), root.path().join("shown/NP1_0.jpg")).unwrap();
    std::fs::copy(folder.join("NP1_0.jpg"), root.path().join("thumbnails/one.jpg")).unwrap();
    let found = uncalibrated_folders(root.path()).unwrap();
    assert_eq!(found, ["masked", "shown"].map(|name| root.path().join(name)));
    std::fs::remove_file(folder.join("calibration.h5")).unwrap();
    assert!(uncalibrated_folders(root.path()).unwrap().contains(&folder));
}

#[test]
fn inverted_masks_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    for entry in std::fs::read_dir(folder.join("masks")).unwrap() {
        let path = entry.unwrap().path();
        let mut bytes = std::fs::read(&path).unwrap();
        let header = bytes.len() - 320 * 256 / 8;
        bytes[header..].iter_mut().for_each(|byte| *byte = !*byte);
        std::fs::write(&path, bytes).unwrap();
    }
    let (field, message) = problem(&folder);
    assert_eq!(field, "polarity");
    for words in ["in 40 of 40", "invert the masks", "too near"] {
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn damaged_calibrations_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let path = folder.join("calibration.h5");
    let whole = std::fs::read(&path).unwrap();
    for share in [0.0, 0.01, 0.3, 0.6] {
        truncate(&path, share);
        let (field, message) = problem(&folder);
        assert!(message.contains("calibration.h5") && message.contains("fetch the file again"), "{message}");
        assert!(field == "file" || field.starts_with('/'), "{field}");
        std::fs::write(&path, &whole).unwrap();
    }
    let focal = 266.5_f64.to_le_bytes();
    let at = whole.windows(8).position(|eight| eight == focal).unwrap();
    let mut poisoned = whole.clone();
    poisoned[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    std::fs::write(&path, &poisoned).unwrap();
    let (field, message) = problem(&folder);
    assert!(field.ends_with("_rgb_K") && message.contains("got NaN, expected finite"), "{message}");
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(read(&folder), Err(ImportError::Read { .. })));
}

#[test]
fn images_of_another_size_than_the_calibration_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "jpg") {
            image::open(&path).unwrap().crop_imm(0, 0, 80, 64).save(&path).unwrap();
        }
    }
    for entry in std::fs::read_dir(folder.join("masks")).unwrap() {
        let mut bytes = b"P4\n80 64\n".to_vec();
        bytes.extend(
            (0..64)
                .flat_map(|row| [0, 0, 0, if (20..40).contains(&row) { 255 } else { 0 }, 0, 0, 0, 0, 0, 0]),
        );
        std::fs::write(entry.unwrap().path(), bytes).unwrap();
    }
    let (field, message) = problem(&folder);
    assert!(field == "size" && message.contains("principal point"), "{message}");
}

#[test]
fn one_viewpoint_does_not_place_an_object() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if name.ends_with(".jpg") && name != "NP1_0.jpg" {
            std::fs::remove_file(path).unwrap();
        }
    }
    let (set, report) = read_objects(&[folder], Split::Train, &|angle| angle == 0).unwrap();
    assert!(set.views.is_empty() && set.instances.is_empty());
    assert_eq!(report.skipped[0].reason, "1 views do not tell where the object is");
}

#[test]
fn a_writer_refuses_what_the_rig_cannot_do() {
    let root = tempfile::tempdir().unwrap();
    let ball = Ball { center: world_from_table() * center_in_table(), radius: RADIUS };
    let create =
        |number: u64| BigBirdWriter::create(root.path(), &ball.truth(number), 0, world_from_table()).unwrap();
    let field = |result: Result<(), StoreError>| match result {
        Err(StoreError::Unfit { fault, .. }) => fault.field,
        other => panic!("{other:?}"),
    };
    let mut writer = create(1);
    assert_eq!(field(writer.push(6, 0, &shot(5, 0))), "camera");
    writer.push(5, 0, &shot(5, 0)).unwrap();
    assert_eq!(field(writer.push(5, 0, &shot(5, 0))), "image");
    writer.push(1, 0, &shot(1, 0)).unwrap();
    writer.push(5, 45, &shot(5, 45)).unwrap();
    writer.push(1, 45, &shot(1, 48)).unwrap();
    assert_eq!(field(writer.finish()), "pose");
    assert!(matches!(
        BigBirdWriter::create(root.path(), &ball.truth(1), 0, world_from_table()),
        Err(StoreError::Foreign { .. })
    ));
    let mut writer = create(2);
    writer.push(1, 0, &shot(1, 0)).unwrap();
    assert_eq!(field(writer.finish()), "image");
}

#[test]
fn a_turntable_that_leans_is_followed_and_one_that_lies_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let upright = read(&folder).unwrap().0;
    let path = folder.join("poses/turntable.h5");
    let write = |normal: [f64; 3]| {
        let mut builder = hdf5_pure::FileBuilder::new();
        builder.create_dataset("normal").with_f64_data(&normal);
        builder.write(&path).unwrap();
    };
    let lean = 0.1_f64;
    write([-3.0 * lean.sin(), 0.0, -3.0 * lean.cos()]);
    let leaning = read(&folder).unwrap().0;
    for (one, two) in upright.views.iter().zip(&leaning.views) {
        let along = one.viewpoint.direction.dot(&Vector3::new(lean.sin(), 0.0, lean.cos()));
        assert!((two.viewpoint.direction.z - along).abs() < 1e-9);
    }
    write([1.0, 0.0, 0.1]);
    let (field, message) = problem(&folder);
    assert!(field == "/normal" && message.contains("remove the file"), "{message}");
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read(&folder).unwrap().0.views[3].viewpoint, upright.views[3].viewpoint);
}

#[test]
fn changed_bytes_of_hdf5_never_panic() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    for name in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()) {
        let name = name.to_str().unwrap();
        if name.ends_with(".jpg") && !matches!(name, "NP5_0.jpg" | "NP1_0.jpg") {
            std::fs::remove_file(folder.join(name)).unwrap();
        }
    }
    let mut stream = Seed(5).stream("damage", 0);
    for file in ["calibration.h5", "poses/NP5_0_pose.h5"] {
        let path = folder.join(file);
        let whole = std::fs::read(&path).unwrap();
        for _ in 0..200 {
            let mut damaged = whole.clone();
            for _ in 0..4 {
                let at = (stream.unit() * damaged.len() as f64) as usize;
                damaged[at] = (stream.unit() * 256.0) as u8;
            }
            damaged.truncate((damaged.len() as f64 * stream.uniform(0.5, 1.5).min(1.0)) as usize);
            std::fs::write(&path, damaged).unwrap();
            let _ = read_objects(std::slice::from_ref(&folder), Split::Train, &|angle| angle == 0);
        }
        std::fs::write(&path, whole).unwrap();
    }
    assert_eq!(read_objects(&[folder], Split::Train, &|angle| angle == 0).unwrap().0.views.len(), 2);
}
