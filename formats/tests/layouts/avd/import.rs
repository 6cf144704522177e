//! Scans that others made: what is odd is left out and told, what is damaged is refused.

use super::*;

#[test]
fn unregistered_images_are_left_out_and_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    restructure(&folder, 3, "R", Value::empty());
    restructure(&folder, 4, "t", Value::empty());
    restructure(&folder, 5, "R", Value::matrix(3, 3, vec![f64::NAN; 9]));
    restructure(&folder, 6, "t", Value::matrix(3, 1, vec![0.0, f64::INFINITY, 0.0]));
    std::fs::remove_file(folder.join("jpg_rgb/010110000080101.jpg")).unwrap();
    let scan = read_scan(&folder).unwrap();
    assert_eq!(scan.episode.observations.steps(), 43);
    assert_eq!(told(&scan, "not registered").len(), 2);
    assert_eq!(told(&scan, "expected a rotation").len(), 1);
    assert_eq!(told(&scan, "expected finite numbers").len(), 1);
    assert_eq!(told(&scan, "no image"), ["010110000080101.jpg"]);
    assert_eq!(scan.movements.after(2, Movement::RotateCcw), None);
    let stored = tempfile::tempdir().unwrap();
    write_episode(stored.path(), &scan.episode, Provenance::default()).unwrap();
}

#[test]
fn cameras_and_scales_of_no_home_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    restructure(&folder, 3, "t", Value::matrix(3, 1, vec![0.0, 1e30, 0.0]));
    restructure(&folder, 4, "t", Value::matrix(3, 1, vec![0.0, 2e4, 0.0]));
    let scan = read_scan(&folder).unwrap();
    assert_eq!(told(&scan, "within 10000 m of the origin").len(), 2);
    assert_eq!(scan.episode.observations.steps(), 46);
    let path = folder.join("image_structs.mat");
    let structs = mat5::read(&path).unwrap().remove("image_structs").unwrap();
    for scale in [1e300, 1e-300, 0.0, -1000.0] {
        let scale = Value::scalar(scale);
        std::fs::write(&path, mat5::encode(&[("image_structs", &structs), ("scale", &scale)])).unwrap();
        let problem = problem(&folder);
        assert_eq!(
            (problem.field.as_str(), problem.expected.as_str()),
            ("scale", "one number from 1e-3 to 1e7")
        );
    }
}

#[test]
fn views_without_a_viewpoint_are_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let whole = read_scan(&folder).unwrap();
    let all = |_: &ObjectTruth| true;
    let (views, report) = whole.views(Split::Train, &all);
    assert_eq!((views.views.len(), report.views), (whole.report.views, whole.report.views));
    assert_eq!(report.skipped, []);
    // A camera that is turned about by mistake has the object behind it.
    let first = &whole.episode.observations.detections[0];
    let variables = mat5::read(&folder.join("image_structs.mat")).unwrap();
    let Value::Structs(structs) = &variables["image_structs"] else { panic!() };
    let r = structs.elements[first.step][structs.field("R").unwrap()].as_numbers().unwrap();
    let turned = r.iter().enumerate().map(|(i, x)| if i % 3 == 1 { *x } else { -x }).collect();
    restructure(&folder, first.step, "R", Value::matrix(3, 3, turned));
    let (views, report) = read_scan(&folder).unwrap().views(Split::Train, &all);
    assert!(views.views.len() < whole.report.views && report.views == views.views.len());
    let reasons: Vec<_> = report.skipped.iter().map(|skipped| skipped.reason.as_str()).collect();
    assert!(reasons.iter().any(|reason| reason.contains("1 of ")), "{reasons:?}");
    assert!(reasons.iter().all(|reason| reason.contains("views have no viewpoint")), "{reasons:?}");
}

#[test]
fn depth_of_another_size_than_the_image_is_left_out_and_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let whole = read_scan(&folder).unwrap();
    let image = &whole.images[whole.episode.observations.detections[0].step];
    let depth =
        folder.join("high_res_depth").join(format!("{}03.png", image.strip_suffix("01.jpg").unwrap()));
    image::ImageBuffer::<image::Luma<u16>, _>::from_pixel(10, 10, image::Luma([900])).save(&depth).unwrap();
    let scan = read_scan(&folder).unwrap();
    assert_eq!(
        told(&scan, "10 x 10 pixels, and the image has 192 x 108"),
        [depth.file_name().unwrap().to_str().unwrap()]
    );
    assert_eq!(scan.report.views, whole.report.views, "its boxes are still views");
}

#[test]
fn odd_annotations_are_left_out_and_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let whole = read_scan(&folder).unwrap();
    annotate(&folder, |json| {
        let json = json.as_object_mut().unwrap();
        let first = json.values_mut().next().unwrap();
        first["bounding_boxes"] = serde_json::json!([
            [10, 10, 50, 50, 77, 1],
            [10, 10, 50, 50, 4, 1],
            [500, 500, 600, 600, 1, 1],
            [20, 30, 20, 40, 1, 1],
            [150, 20, 250, 90, 1, 1],
            [10, 10, 60, 60, 1, 1]
        ]);
        first["forward"] = serde_json::json!("nowhere.jpg");
        json.insert("000000000000001.jpg".to_owned(), serde_json::json!({"bounding_boxes": []}));
    });
    let scan = read_scan(&folder).unwrap();
    assert_eq!(told(&scan, "annotated, but not in image_structs.mat"), ["000000000000001.jpg"]);
    assert_eq!(told(&scan, "instance 77, which has no name").len(), 1);
    assert_eq!(told(&scan, "which is not in present_instance_names.txt").len(), 1);
    assert_eq!(told(&scan, "without a pixel of the image").len(), 2);
    assert_eq!(told(&scan, "instance 1 twice in one image").len(), 1);
    assert_eq!(scan.report.skipped.len(), 6, "{:?}", scan.report);
    let clipped = &scan.episode.observations.detections[0];
    assert_eq!((clipped.bounding_box.max.x, clipped.bounding_box.min.x), (192.0, 150.0));
    assert_eq!(scan.movements.after(0, Movement::Forward), None);
    assert!(whole.movements.after(0, Movement::Forward).is_some());
}

#[test]
fn images_that_are_cut_short_are_left_out_and_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let whole = read_scan(&folder).unwrap();
    let first = whole.episode.observations.detections[0].step;
    truncate(&folder.join("jpg_rgb").join(&whole.images[first]), 0.5);
    let scan = read_scan(&folder).unwrap();
    assert_eq!(told(&scan, "cut short").len(), 1);
    assert!(scan.report.views < whole.report.views);
}

#[test]
fn without_depth_objects_are_placed_by_rays() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    std::fs::remove_dir_all(folder.join("high_res_depth")).unwrap();
    let scan = read_scan(&folder).unwrap();
    assert!(!told(&scan, "cannot read").is_empty());
    assert_eq!(scan.episode.truth.objects.len(), 3);
    for (read, truth) in scan.episode.truth.objects.iter().zip(truths()) {
        let off =
            (read.world_from_object.translation.vector - truth.world_from_object.translation.vector).norm();
        assert!(off < 0.1, "{off}");
    }
}

#[test]
fn smaller_images_keep_the_boxes_of_the_camera() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let whole = read_scan(&folder).unwrap();
    for entry in std::fs::read_dir(folder.join("jpg_rgb")).unwrap() {
        let path = entry.unwrap().path();
        image::open(&path)
            .unwrap()
            .resize_exact(96, 54, image::imageops::FilterType::Triangle)
            .save(&path)
            .unwrap();
    }
    let small = read_scan(&folder).unwrap();
    let [whole, small] = [whole, small].map(|scan| scan.episode.observations.detections);
    assert_eq!(whole.len(), small.len());
    for (one, two) in whole.iter().zip(&small) {
        assert_eq!(one.bounding_box, two.bounding_box);
        let difference: i32 = one
            .boxed_crop
            .0
            .iter()
            .zip(two.boxed_crop.0.iter())
            .map(|(a, b)| (i32::from(*a) - i32::from(*b)).abs())
            .sum();
        assert!(difference < 20 * 3072, "{difference}");
    }
    let path = folder.join("jpg_rgb").join(&read_scan(&folder).unwrap().images[0]);
    image::open(&path).unwrap().crop_imm(0, 0, 50, 50).save(&path).unwrap();
    assert_eq!(told(&read_scan(&folder).unwrap(), "and the camera has").len(), 1);
}

#[test]
fn distorted_boxes_are_made_ideal() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let straight = read_scan(&folder).unwrap();
    std::fs::write(folder.join("cameras.txt"), "1 OPENCV 192 108 105 106 95 55 0.3 0.1 0.001 -0.001\n")
        .unwrap();
    let scan = read_scan(&folder).unwrap();
    assert_eq!((scan.lens.k1, scan.lens.p2), (0.3, -0.001));
    let pairs = straight.episode.observations.detections.iter().zip(&scan.episode.observations.detections);
    for (seen, ideal) in pairs {
        let center = nalgebra::Vector2::new(95.0, 55.0);
        let [seen_off, ideal_off] = [seen, ideal].map(|d| (d.bounding_box.center() - center).norm());
        let inside = seen.bounding_box.min.x > 0.0 && seen.bounding_box.max.x < 192.0;
        assert!(!inside || ideal_off < seen_off + 0.5, "the lens magnified: {seen_off} {ideal_off}");
        assert_eq!(seen.boxed_crop, ideal.boxed_crop);
    }
}

#[test]
fn a_world_with_y_up_is_turned_the_right_way() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let path = folder.join("image_structs.mat");
    let mut variables = mat5::read(&path).unwrap();
    let Some(Value::Structs(structs)) = variables.get_mut("image_structs") else { panic!() };
    let r = structs.field("R").unwrap();
    for element in &mut structs.elements {
        let Value::Numbers { data, .. } = &mut element[r] else { panic!() };
        data[3..].iter_mut().for_each(|number| *number = -*number);
    }
    let variables: Vec<(&str, &Value)> =
        variables.iter().map(|(name, value)| (name.as_str(), value)).collect();
    std::fs::write(&path, mat5::encode(&variables)).unwrap();
    let scan = read_scan(&folder).unwrap();
    for robot in &scan.episode.truth.world_from_robot {
        assert!((robot.rotation * Vector3::z() - Vector3::z()).norm() < 1e-6);
        assert!((robot.translation.z - 0.8).abs() < 1e-9);
    }
}

#[test]
fn damaged_files_are_refused_by_name() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let keep = |file: &str| (folder.join(file), std::fs::read(folder.join(file)).unwrap());

    let (path, whole) = keep("image_structs.mat");
    for share in [0.0, 0.001, 0.3, 0.999] {
        truncate(&path, share);
        let problem = problem(&folder);
        assert!(problem.file == path && problem.remedy == "fetch the file again", "{problem}");
    }
    let mut v73 = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".to_vec();
    v73.resize(512, 0);
    v73.extend(b"\x89HDF\r\n\x1a\n");
    std::fs::write(&path, v73).unwrap();
    assert!(
        problem(&folder)
            .to_string()
            .contains("got 7.3 (HDF5), expected version 5, 6 or 7; save it in MATLAB")
    );
    std::fs::write(&path, mat5::encode(&[("scale", &Value::scalar(f64::NAN))])).unwrap();
    assert_eq!(problem(&folder).field, "scale");
    std::fs::write(&path, mat5::encode(&[("scale", &Value::scalar(1000.0))])).unwrap();
    assert_eq!(
        (problem(&folder).field.as_str(), problem(&folder).got.as_str()),
        ("image_structs", "no such variable")
    );
    std::fs::write(&path, whole).unwrap();

    let (path, whole) = keep("annotations.json");
    truncate(&path, 0.5);
    assert_eq!(problem(&folder).field, "line 1");
    std::fs::write(&path, whole).unwrap();
    assert!(problem(root.path()).expected.contains("folder of one scan"));

    let (path, whole) = keep("cameras.txt");
    std::fs::write(&path, "1 OPENCV 1920 1080 oops").unwrap();
    assert_eq!(problem(&folder).field, "camera");
    std::fs::create_dir_all(root.path().join("camera_params").join(SCAN)).unwrap();
    std::fs::write(root.path().join("camera_params").join(SCAN).join("cameras.txt"), whole).unwrap();
    std::fs::remove_file(&path).unwrap();
    read_scan(&folder).unwrap();

    let map = root.path().join("instance_id_map.txt");
    std::fs::write(&map, "ball one\n").unwrap();
    assert_eq!(problem(&folder).field, "line 1");
    std::fs::remove_file(&map).unwrap();
    read_scan(&folder).unwrap();
    std::fs::remove_file(root.path().join("avd_label_map.json")).unwrap();
    assert_eq!(problem(&folder).field, "map of instances");
}
