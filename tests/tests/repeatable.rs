//! The same scene gives the same bytes, whatever happened before: twice, killed, damaged, with another run beside.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};
use vantage_tests::{Finished, SmallScene};

/// Every file below a folder but the manifest, which holds times, by name.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let of_time = |name: &Path| name.ends_with("manifest.json") || name.ends_with("report.html");
    vantage_tests::files(folder).into_iter().filter(|(name, _)| !of_time(name)).collect()
}

fn results(scene: &SmallScene) -> Vec<(PathBuf, Vec<u8>)> {
    let found = files(&scene.path("out/scenes/small"));
    let pictures =
        ["gains.svg", "trajectory.svg", "nees.svg", "crops.png", "predictions.png", "viewpoints.png"];
    for expected in [&pictures[..], &["results.json", "1/truth.tum", "1/viewpoint_dependent.tum"]].concat() {
        assert!(found.iter().any(|(name, _)| name == Path::new(expected)), "{expected} is missing");
    }
    found
}

#[test]
#[cfg(target_os = "linux")]
fn results_are_written_though_standard_output_takes_nothing() {
    let scene = SmallScene::new(&[]);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a full device");
    Finished::of(scene.command().stdout(full)).expect(6, &["standard output"]);
    results(&scene);
}

#[test]
fn runs_agree_to_the_byte_on_one_thread_and_on_two_and_from_the_cache() {
    let one = SmallScene::new(&[]);
    Finished::of(one.command().env("RAYON_NUM_THREADS", "1")).expect(0, &[]);
    let two = SmallScene::new(&[]);
    Finished::of(two.command().env("RAYON_NUM_THREADS", "2")).expect(0, &[]);
    let first = results(&one);
    assert_eq!(first, results(&two));

    let entries = files(&one.path("cache/entries")).len();
    fs::remove_dir_all(one.path("out")).expect("the first results");
    one.run().expect(0, &[]);
    assert_eq!(first, results(&one));
    assert_eq!(entries, files(&one.path("cache/entries")).len());
}

#[test]
fn a_damaged_cache_entry_is_set_aside_told_of_and_made_anew() {
    let scene = SmallScene::new(&[]);
    scene.run().expect(0, &[]);
    let before = results(&scene);
    let damaged = files(&scene.path("cache/entries"))
        .into_iter()
        .find(|(name, _)| name.ends_with("odometry.csv"))
        .expect("an episode");
    let path = scene.path("cache/entries").join(damaged.0);
    let mut bytes = damaged.1;
    bytes[20] ^= 1;
    fs::write(&path, bytes).expect("a damaged file");
    scene.run().expect(0, &["warning", "episode", "quarantine"]);
    assert_eq!(before, results(&scene));
}

#[test]
fn a_killed_run_is_taken_up() {
    let whole = SmallScene::new(&[]);
    let start = Instant::now();
    whole.run().expect(0, &[]);
    let took = start.elapsed();

    let killed = SmallScene::new(&[]);
    for part in [0.2, 0.5, 0.8] {
        let mut child = killed.command().stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("a run");
        std::thread::sleep(Duration::from_secs_f64(took.as_secs_f64() * part));
        child.kill().expect("a kill");
        child.wait().expect("an end");
    }
    killed.run().expect(0, &[]);
    assert_eq!(results(&whole), results(&killed));
}

#[test]
fn two_runs_at_once_share_a_cache() {
    let scene = SmallScene::new(&[]);
    let mut second = scene.on(&[], "scene.yaml");
    second.arg("--out").arg(scene.path("other")).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = second.spawn().expect("a run");
    scene.run().expect(0, &[]);
    assert_eq!(child.wait().expect("an end").code(), Some(0));
    assert_eq!(results(&scene), files(&scene.path("other/scenes/small")));
}

#[test]
fn a_scene_has_the_same_dataset_beside_another_of_its_world_in_the_cache() {
    let dataset = |scene: &SmallScene, folder: &str| -> String {
        let text = fs::read_to_string(scene.path(folder).join("manifest.json")).expect("a manifest");
        let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        manifest["dataset_hash"].as_str().expect("a hash").to_owned()
    };
    let alone = SmallScene::new(&[("name: small", "name: renamed")]);
    alone.run().expect(0, &[]);
    let first = SmallScene::new(&[]);
    first.run().expect(0, &[]);
    let mut second = vantage_tests::bench();
    second.arg(alone.path("scene.yaml")).args(["--renderer", "reference", "--out"]).arg(first.path("out"));
    Finished::of(second.arg("--cache").arg(first.path("cache"))).expect(0, &[]);
    assert_eq!(dataset(&alone, "out/scenes/renamed"), dataset(&first, "out/scenes/renamed"));
}
