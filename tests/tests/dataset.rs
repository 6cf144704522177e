//! `bench dataset`: episodes as files, taken up after an interruption, the same bytes as without one.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;
use std::time::Duration;
use vantage_dataset::Camera;
use vantage_dataset::store::read_episode;
use vantage_formats::verify_layout;
use vantage_tests::{Finished, SmallScene, assert_resumes, files};

#[test]
fn a_dataset_is_resumed_to_the_same_bytes() {
    let scene = SmallScene::new(&[]);
    let write = |name: &str| Finished::of(&mut scene.dataset(name, &[]));
    let first = write("a");
    first.expect(0, &[]);
    assert!(first.stdout.contains("2 episodes written"), "{}", first.stdout);
    let again = write("a");
    assert!(
        again.stdout.contains("0 episodes written") && again.stdout.contains("2 already"),
        "{}",
        again.stdout
    );

    write("b").expect(0, &[]);
    fs::remove_file(scene.path("b/1/manifest.json")).unwrap();
    let resumed = write("b");
    assert!(
        resumed.stdout.contains("1 episodes written") && resumed.stdout.contains("1 already"),
        "{}",
        resumed.stdout
    );
    fs::remove_file(scene.path("b/0/odometry.csv")).unwrap();
    let mended = write("b");
    mended.expect(0, &["warning", "odometry.csv", "anew"]);
    for seed in ["0", "1"] {
        let manifest = |name: &str| fs::read(scene.path(name).join(seed).join("manifest.json")).unwrap();
        assert_eq!(manifest("a"), manifest("b"));
    }
}

#[test]
fn more_seeds_are_counted_with_those_that_were_there() {
    let scene = SmallScene::new(&[]);
    for seeds in ["1", "2"] {
        Finished::of(&mut scene.dataset("d", &["--seeds", seeds])).expect(0, &[]);
    }
    let counted: serde_json::Value =
        serde_json::from_slice(&fs::read(scene.path("d/episodes.json")).unwrap()).unwrap();
    let seeds: Vec<&String> = counted["episodes"].as_object().unwrap().keys().collect();
    assert_eq!(seeds, ["0", "1"]);
}

#[test]
fn trajectories_and_pose_graphs_are_those_of_the_episodes() {
    let scene = SmallScene::new(&[]);
    Finished::of(&mut scene.dataset("d", &["--format", "vantage,tum,g2o", "--seeds", "1"])).expect(0, &[]);
    let read = |name: &str| fs::read_to_string(scene.path("d").join(name)).unwrap();
    assert_eq!(read("tum/0/truth.tum"), read("0/truth/robot.tum"));
    for (layout, part) in [("tum", "0"), ("g2o", "0.g2o")] {
        let manifest = verify_layout(&scene.path("d").join(layout)).unwrap();
        assert_eq!((manifest.layout.as_str(), manifest.shards[0].name.as_str()), (layout, part));
    }
    let steps = read("tum/0/odometry.tum").lines().filter(|line| !line.starts_with('#')).count();
    let graph = read("g2o/0.g2o");
    let lines_of = |tag: &str| graph.lines().filter(|line| line.starts_with(tag)).count();
    assert_eq!((lines_of("VERTEX_SE3:QUAT "), lines_of("EDGE_SE3:QUAT ")), (steps, steps - 1));
    assert!(graph.lines().filter(|line| line.starts_with("EDGE")).all(|line| line.split(' ').count() == 31));
}

#[test]
fn a_killed_run_is_gone_on_with_to_the_same_bytes_in_every_format() {
    let scene = SmallScene::new(&[]);
    let kept = "vantage,webdataset,parquet,bop,bop-webdataset";
    let all = format!("{kept},tum,g2o");
    assert_resumes(&scene, &["--seeds", "8", "--format", &all], |killed| {
        killed.join("1/manifest.json").exists()
    });
    let again = Finished::of(&mut scene.dataset("whole", &["--seeds", "8", "--format", kept]));
    assert!(
        again.stdout.contains("0 episodes written") && again.stdout.contains("8 already"),
        "{}",
        again.stdout
    );
}

#[test]
fn of_two_runs_into_one_folder_the_second_waits_and_finds_all_done() {
    let scene = SmallScene::new(&[]);
    let command = || scene.dataset("d", &["--seeds", "8"]);
    let mut first = command().stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while !scene.path("d/.bench.lock").exists() {
        assert!(first.try_wait().unwrap().is_none(), "the first run ended before it held the folder");
        thread::sleep(Duration::from_millis(1));
    }
    let second = Finished::of(&mut command());
    second.expect(0, &["waiting for", ".bench.lock"]);
    assert!(
        second.stdout.contains("0 episodes written") && second.stdout.contains("8 already"),
        "{second:#?}"
    );
    assert!(first.wait().unwrap().success());
    assert!(!scene.path("d/.bench.lock").exists(), "a lock is left");
}

#[test]
fn look_alikes_of_a_mesh_keep_its_licence() {
    let scene = SmallScene::new(&[
        (
            "families: [mug, duck, carton, teapot]",
            "look_alike: 0.1\n  meshes: [{ path: box.obj, metres_per_unit: 0.15, up: z, category: box, split: test }]",
        ),
        ("steps: 12", "steps: 4"),
    ]);
    scene.write_box();
    fs::write(scene.path("LICENSE"), "source: https://example.org/box\nLicence: CC BY 4.0, by nobody\n")
        .unwrap();
    Finished::of(&mut scene.dataset("d", &["--seeds", "1", "--format", "webdataset,bop"])).expect(0, &[]);
    for format in ["webdataset", "bop"] {
        let manifest = fs::read(scene.path("d").join(format).join("manifest.json")).unwrap();
        let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
        let objects = manifest["objects"].as_object().unwrap();
        assert!(objects.len() >= 2, "{format}: {} objects", objects.len());
        assert!(objects.values().all(|object| object["licence"] == "CC BY 4.0, by nobody"), "{objects:#?}");
    }
}

#[test]
fn what_is_not_ours_or_of_other_seeds_is_refused() {
    let scene = SmallScene::new(&[]);
    let write =
        |seeds: &str| Finished::of(&mut scene.dataset("d", &["--seeds", seeds, "--format", "webdataset"]));
    fs::create_dir_all(scene.path("d/webdataset")).unwrap();
    fs::write(scene.path("d/webdataset/thesis.tex"), "years of work").unwrap();
    write("1").expect(2, &["webdataset"]);
    assert_eq!(fs::read_to_string(scene.path("d/webdataset/thesis.tex")).unwrap(), "years of work");
    fs::remove_file(scene.path("d/webdataset/thesis.tex")).unwrap();
    write("1").expect(0, &[]);
    write("2").expect(2, &["seeds"]);
}

#[test]
fn files_of_others_are_neither_lost_nor_written_over() {
    let scene = SmallScene::new(&[]);
    let write = |formats: &str| Finished::of(&mut scene.dataset("d", &["--seeds", "1", "--format", formats]));
    write("vantage").expect(0, &[]);
    fs::write(scene.path("d/0/annotations.csv"), "mine").unwrap();
    fs::write(scene.path("d/0/detections.csv"), "damaged").unwrap();
    write("vantage").expect(0, &["detections.csv", "anew", "set_aside/0"]);
    assert_eq!(fs::read_to_string(scene.path("d/set_aside/0/annotations.csv")).unwrap(), "mine");
    assert!(read_episode(&scene.path("d/0")).is_ok() && !scene.path("d/0/annotations.csv").exists());

    for (format, file) in [("tum", "tum/0/truth.tum"), ("g2o", "g2o/0.g2o")] {
        let path = scene.path("d").join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "mine").unwrap();
        write(format).expect(2, &["holds other files"]);
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        fs::remove_dir_all(scene.path("d").join(format)).unwrap();
        write(format).expect(0, &[]);
        write(format).expect(0, &[]);
    }
    let text = fs::read_to_string(scene.path("scene.yaml")).unwrap();
    fs::write(scene.path("scene.yaml"), text.replace("objects: 3", "objects: 2")).unwrap();
    let before = files(&scene.path("d/tum"));
    write("tum").expect(2, &["another scene"]);
    assert!(files(&scene.path("d/tum")) == before);
}

#[test]
fn episodes_of_another_scene_are_left_as_they_are() {
    let scene = SmallScene::new(&[]);
    let write = || Finished::of(&mut scene.dataset("d", &["--seeds", "1"]));
    write().expect(0, &[]);
    let before = files(&scene.path("d/0"));
    let text = fs::read_to_string(scene.path("scene.yaml")).unwrap();
    fs::write(scene.path("scene.yaml"), text.replace("objects: 3", "objects: 2")).unwrap();
    write().expect(2, &["holds a dataset of another scene;"]);
    let of_training = || Finished::of(&mut scene.dataset("d", &["--seeds", "1", "--split", "train"]));
    of_training().expect(2, &["holds a dataset of another scene and split;"]);
    fs::write(scene.path("scene.yaml"), text).unwrap();
    of_training().expect(2, &["holds a dataset of another split;"]);
    assert!(files(&scene.path("d/0")) == before);
}

#[test]
fn a_format_that_cannot_hold_the_scene_is_refused_before_another_begins() {
    let scene = SmallScene::new(&[]);
    for format in ["tum,g2o,avd", "tum,bigbird"] {
        Finished::of(&mut scene.dataset("d", &["--format", format])).expect(2, &["robot.path is not"]);
        assert!(!scene.path("d/tum").exists());
    }
}

#[test]
fn a_camera_may_be_given_by_its_intrinsics() {
    let Camera { fx, .. } = Camera::with_horizontal_fov(320, 240, 60f64.to_radians());
    let episode = |camera: &str| {
        let scene = SmallScene::new(&[("horizontal_fov_deg: 60", camera)]);
        Finished::of(&mut scene.dataset("d", &["--seeds", "1"])).expect(0, &[]);
        let mut files = files(&scene.path("d/0"));
        files.retain(|path, _| !path.ends_with("manifest.json"));
        (read_episode(&scene.path("d/0")).unwrap().observations.camera, files)
    };
    let plain = episode("horizontal_fov_deg: 60");
    let same = episode(&format!("intrinsics: {{ fx: {fx}, fy: {fx}, cx: 160, cy: 120 }}"));
    assert!(plain == same);
    let other = episode("intrinsics: { fx: 250, fy: 300, cx: 150, cy: 130 }");
    assert_eq!(other.0, Camera { width: 320, height: 240, fx: 250.0, fy: 300.0, cx: 150.0, cy: 130.0 });
    let detections = |files: &BTreeMap<PathBuf, Vec<u8>>| files[Path::new("detections.csv")].clone();
    assert!(detections(&other.1) != detections(&plain.1), "boxes are elsewhere");
}

#[test]
fn seeds_without_a_world_are_counted() {
    let crowded = SmallScene::new(&[("objects: 3", "objects: 13")]);
    let got = Finished::of(&mut crowded.dataset("out", &["--seeds", "6", "--format", "tum"]));
    got.expect(0, &["is left out: only ", " of 13 objects fit"]);
    assert!(
        got.stdout.ends_with(", 0 already there, 1 of 6 seeds left out for want of a world\n"),
        "{}",
        got.stdout
    );
}
