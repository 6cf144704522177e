//! Bad scenes, models and folders: a message that names the fault and its place, and the documented exit code.

use sha2::{Digest, Sha256};
use std::fs;
use vantage_dataset::store::read_episode;
use vantage_tests::{Finished, SmallScene, bench, files, root};

fn refused(old: &str, new: &str, code: i32, words: &[&str]) {
    SmallScene::new(&[(old, new)]).run().expect(code, words);
}

#[test]
fn malformed_scenes_are_refused_with_line_and_column() {
    refused("objects: 3", "objects: [3", 2, &["scene.yaml:"]);
    refused("objects: 3", "objcts: 3", 2, &["scene.yaml:9:3", "objcts"]);
    refused("objects: 3", "objects: 3\n  objects: 4", 2, &["scene.yaml:10:3", "objects"]);
    refused("objects: 3", "objects: three", 2, &["scene.yaml:9:12"]);
    refused("speed: 0.3", "speed: .nan", 2, &["scene.yaml:22:10"]);
    refused("height: 0.72", "height: -1", 2, &["scene.yaml:", "height"]);
    refused(", horizontal_fov_deg: 60", "", 2, &["either horizontal_fov_deg or intrinsics"]);
    let both = ", horizontal_fov_deg: 60, intrinsics: { fx: 300, fy: 300, cx: 160, cy: 120 }";
    refused(", horizontal_fov_deg: 60", both, 2, &["either horizontal_fov_deg or intrinsics"]);
    let aside = ", intrinsics: { fx: 300, fy: 300, cx: 321, cy: 120 }";
    refused(", horizontal_fov_deg: 60", aside, 2, &["cx is 321"]);
    let wide = ", intrinsics: { fx: 300, fy: 20, cx: 160, cy: 120 }";
    refused(", horizontal_fov_deg: 60", wide, 2, &["fy gives 161"]);
    refused("objects: 3", "objects: 0", 2, &["scene.yaml:9:12"]);
    refused(
        "speed: 0.3",
        "speed: 20",
        2,
        &["scene.yaml:22:10", "greater than 2 for `robot.speed`, expected 0.01 to 2"],
    );
    refused("families: [mug, duck, carton, teapot]", "families: [mug, dragon]", 2, &["dragon"]);
}

#[test]
fn every_violation_is_reported_at_once() {
    let scene = SmallScene::new(&[("speed: 0.3", "speed: -1"), ("objects: 3", "objects: 0")]);
    scene.run().expect(2, &["scene.yaml:9:12", "scene.yaml:22:10"]);
}

#[test]
fn furniture_and_fixtures_that_cannot_stand_there_are_refused_with_line_and_column() {
    let table = "round_table: { radius: 0.45, height: 0.72 }";
    let pieces = "furniture:\n      - table: { at: [0, 0], size: [0.8, 0.8, 0.7] }\n      - block: { at: [3, 0], \
                  size: [1, 1, 1] }\n      - block: { at: [0.3, 0.4], size: [0.3, 0.3, 0.9] }";
    refused(
        table,
        pieces,
        2,
        &[
            "scene.yaml:9:9: world.surface.furniture[1]",
            "beyond world.room",
            "scene.yaml:10:9: world.surface.furniture[2]: stands in world.surface.furniture[0]",
        ],
    );
    let scene = SmallScene::new(&[(
        "  spacing:",
        "  fixtures:\n    - { path: box.obj, metres_per_unit: 1, up: z, at: [2, 2] }\n    - { path: box.obj, \
         metres_per_unit: 1, up: z, at: [2.5, 2] }\n  spacing:",
    )]);
    scene.write_box();
    scene.run().expect(2, &["scene.yaml:12:7: world.fixtures[1]: stands in world.fixtures[0]"]);
    refused(
        "objects: 3",
        "objects: 600",
        2,
        &["scene.yaml:9:12: world.objects: 600 objects do not fit on the round table"],
    );
}

#[test]
fn scenes_that_no_machine_could_run_are_refused_before_they_start() {
    refused("steps: 12", "steps: 4000000000", 2, &["steps"]);
    refused("{ width: 320, height: 240,", "{ width: 320000, height: 240000,", 2, &["width"]);
    refused("objects: 3", "objects: 40", 2, &["fit"]);
}

#[test]
fn a_path_that_sees_nothing_is_said_and_ends_with_4() {
    let scene = SmallScene::new(&[("yaw_deg: 90", "yaw_deg: -90")]);
    scene.run().expect(4, &["no object was detected"]);
    assert!(scene.path("out/scenes/small/results.json").exists());
}

#[test]
fn settings_of_the_estimator_that_contradict_others_are_refused() {
    let with = |estimator: &str| SmallScene::new(&[("estimator: {}\n", estimator)]);
    with("estimator: { rows: [odometry, geometric, odometry] }\n")
        .run()
        .expect(2, &["estimator.rows", "odometry stands there twice"]);
    let both = "estimator:\n  extents: { half_axis: 0.1, log_sigma: 0.7 }\n  bearing_offset: { horizontal: 0.1, vertical: \
                0.1, length: 1, smoothness: 1.5 }\n";
    with(both).run().expect(2, &["estimator.bearing_offset", "`extents`", "leave one out"]);
    let told = "estimator:\n  odometry_bias: { translation_per_metre: 0.9, rotation_deg_per_metre: 0.1 }\n";
    with(told)
        .run()
        .expect(2, &["the bias leaves nothing of its covariance", "got 0.9 m/m", "lower the larger"]);
    let scene = with("estimator: { unknown_margin: 10 }\n");
    Finished::of(scene.command().arg("--online"))
        .expect(2, &["unknown_margin", "--online", "leave one of them out"]);
}

#[test]
fn without_a_vulkan_driver_wgpu_is_refused_and_auto_falls_back() {
    let scene = SmallScene::new(&[]);
    let run = |renderer: &str| {
        let mut command = bench();
        command.arg(scene.path("scene.yaml")).args(["--renderer", renderer, "--seeds", "1", "--out"]);
        command.arg(scene.path("out")).arg("--cache").arg(scene.path("cache"));
        for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(name, "/nonexistent/driver.json");
        }
        Finished::of(&mut command)
    };
    run("wgpu").expect(3, &["mesa-vulkan-drivers", "--renderer reference"]);
    run("auto").expect(0, &["mesa-vulkan-drivers"]);
}

#[test]
fn models_that_cannot_be_used_are_refused() {
    let scene = SmallScene::new(&[]);
    let with_model = |name: &str| {
        let mut command = scene.command();
        Finished::of(command.arg("--model").arg(scene.path(name)))
    };
    with_model("missing").expect(2, &["missing", "bench train"]);

    let copy = |name: &str| {
        let folder = scene.path(name);
        fs::create_dir(&folder).expect("a folder");
        for entry in fs::read_dir(root().join("models/objects")).expect("the committed model") {
            let entry = entry.expect("an entry");
            fs::copy(entry.path(), folder.join(entry.file_name())).expect("a copy");
        }
        folder
    };
    let truncated = copy("truncated").join("decoder.onnx");
    let bytes = fs::read(&truncated).expect("a graph");
    fs::write(&truncated, &bytes[..bytes.len() / 2]).expect("half a graph");
    with_model("truncated").expect(5, &["decoder.onnx"]);

    fs::remove_file(copy("unlisted").join("training_instances.txt")).expect("a list");
    with_model("unlisted").expect(5, &["training_instances.txt"]);

    Finished::of(&mut scene.dataset("d", &["--seeds", "1"])).expect(0, &[]);
    let episode = read_episode(&scene.path("d/0")).expect("an episode");
    let instance = format!("{:016x}", episode.truth.objects[0].instance.0);
    let leaking = |name: &str, instance: &str| {
        let list = copy(name).join("training_instances.txt");
        let seen = fs::read_to_string(&list).expect("a list");
        let sha256 = |text: &str| -> String {
            Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
        };
        let more = format!("{seen}{instance}\n");
        let manifest = fs::read_to_string(scene.path(name).join("model.yaml")).expect("a manifest");
        assert!(manifest.contains(&sha256(&seen)));
        fs::write(scene.path(name).join("model.yaml"), manifest.replace(&sha256(&seen), &sha256(&more)))
            .expect("a manifest");
        fs::write(&list, more).expect("a longer list");
    };
    leaking("leaking", &instance);
    with_model("leaking").expect(2, &[&instance, "leaking"]);

    let views = files(&scene.path("cache/entries/views"));
    let (_, table) = views.iter().find(|(name, _)| name.ends_with("instances.csv")).expect("instances");
    let table = String::from_utf8_lossy(table);
    let viewed = table.lines().nth(1).and_then(|row| row.split(',').nth(1)).expect("an instance");
    leaking("leaking_views", viewed);
    let fresh = SmallScene::new(&[]);
    let mut command = fresh.command();
    let refused = Finished::of(command.arg("--model").arg(scene.path("leaking_views")));
    refused.expect(2, &[viewed, "leaking_views"]);
    assert!(fresh.path("cache/entries/views").exists() && !fresh.path("cache/entries/episode").exists());
    assert!(scene.path("cache/entries/episode").exists());
}

#[test]
fn an_output_that_cannot_be_written_is_found_before_any_work() {
    let scene = SmallScene::new(&[]);
    fs::write(scene.path("out"), "a file").expect("a file");
    scene.run().expect(6, &["out", "--out"]);
    assert!(!scene.path("cache").exists());
}

#[test]
fn detections_of_nothing_alone_are_not_something_seen() {
    let faults = "detector:\n    faults: { false_per_image: 0.2 }\n    min_visible_fraction: 0.35\n    min_mask_pixels: 100";
    let detector = "detector: { min_visible_fraction: 0.35, min_mask_pixels: 100 }";
    let scene = SmallScene::new(&[("yaw_deg: 90", "yaw_deg: -90"), (detector, faults)]);
    scene.run().expect(4, &["no object was detected"]);
    Finished::of(&mut scene.dataset("d", &["--seeds", "1"])).expect(4, &["no detection of an object"]);
    let detections = std::fs::read_to_string(scene.path("d/0/detections.csv")).expect("detections");
    assert!(detections.lines().count() > 1, "there are some, of nothing");
}

#[test]
fn wrong_arguments_and_missing_files_end_with_2() {
    Finished::of(bench().args(["models", "missing"])).expect(2, &["no folder missing"]);
    let import = |more: &[&str]| Finished::of(bench().args(["import", "avd"]).args(more));
    import(&["missing", "--out", "out"]).expect(2, &["no folder missing"]);
    import(&["scenes", "--out", "out", "--objects", "a"]).expect(2, &["--objects", "--views"]);
    import(&["scenes", "--out", "out", "--split", "test"]).expect(2, &["--split", "--views"]);
    Finished::of(bench().arg("--nonsense")).expect(2, &["--nonsense"]);
    Finished::of(&mut bench()).expect(2, &[]);
    Finished::of(bench().arg("scenes/missing.yaml")).expect(2, &["scenes/missing.yaml"]);
}
