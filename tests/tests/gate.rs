//! `bench check`: passes on what was just written, and exits with 10 where accuracy got worse.

use std::fs;
use vantage_tests::{Finished, SmallScene};

fn check(scene: &SmallScene) -> Finished {
    check_seeds(scene, &[])
}

fn check_seeds(scene: &SmallScene, seeds: &[&str]) -> Finished {
    Finished::of(scene.on(&["check"], "scene.yaml").arg("--baseline").arg(scene.path("out")).args(seeds))
}

#[test]
fn a_regression_ends_with_10_and_a_table() {
    let scene = SmallScene::new(&[]);
    check(&scene).expect(2, &["results.json"]);
    scene.run().expect(0, &[]);
    let passed = check(&scene);
    passed.expect(0, &[]);
    assert!(passed.stdout.starts_with("of the means over seeds 0 regressed"), "{}", passed.stdout);
    let first = check_seeds(&scene, &["--seeds", "1"]);
    first.expect(0, &[]);
    assert!(first.stdout.starts_with("of the means over seeds 0 regressed"), "{}", first.stdout);
    check_seeds(&scene, &["--seeds", "3"]).expect(2, &["no run on seed 2"]);
    check_seeds(&scene, &["--seeds", "-1"]).expect(2, &["invalid value '-1'", "--seeds"]);

    let path = scene.path("out/scenes/small/results.json");
    let mut results: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&path).expect("results")).expect("JSON");
    let runs = results["tables"][0]["runs"].as_array_mut().expect("runs");
    for run in runs {
        let ate = run["scores"]["ate"].as_f64().expect("an ATE");
        run["scores"]["ate"] = (ate - 0.02).into();
    }
    fs::write(&path, results.to_string()).expect("a better past");
    let moved = check(&scene);
    moved.expect(10, &[]);
    assert!(moved.stdout.contains("REGRESSED"), "{}", moved.stdout);
}

#[test]
fn a_baseline_from_before_a_table_was_there_is_read_and_what_is_new_is_said() {
    let scene = SmallScene::new(&[]);
    scene.run().expect(0, &[]);
    let path = scene.path("out/scenes/small/results.json");
    let mut results: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&path).expect("results")).expect("JSON");
    let tables = results["tables"].as_array_mut().expect("tables");
    tables.retain(|table| table["name"] == "trajectory" || table["name"] == "latents");
    assert_eq!(tables.len(), 2);
    fs::write(&path, results.to_string()).expect("an old baseline");
    let checked = check(&scene);
    checked.expect(10, &[]);
    assert!(
        checked.stdout.starts_with("of the means over seeds 0 regressed, 0 improved, "),
        "{}",
        checked.stdout
    );
    let told = checked.stdout.contains("new: not in") && checked.stdout.contains("instances");
    assert!(told, "{}", checked.stdout);
}
