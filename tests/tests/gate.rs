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

#[test]
fn a_verdict_is_written_for_people_and_for_continuous_integration() {
    let scene = SmallScene::new(&[]);
    scene.run().expect(0, &[]);
    let [junit, markdown, json] =
        ["v/junit.xml", "v/verdict.md", "v/verdict.json"].map(|name| scene.path(name));
    let files = ["--junit", "--markdown", "--json"].into_iter().zip([&junit, &markdown, &json]);
    let args: Vec<&str> = files.flat_map(|(option, file)| [option, file.to_str().expect("a path")]).collect();
    check_seeds(&scene, &args).expect(0, &[]);
    let text = fs::read_to_string(&junit).expect("JUnit");
    let cases = text.matches("<testcase ").count();
    assert!(
        cases > 20 && text.contains(&format!("<testsuite name=\"small\" tests=\"{cases}\" failures=\"0\">")),
        "{text}"
    );
    assert!(!text.contains("<failure"));

    let path = scene.path("out/scenes/small/results.json");
    let worse = fs::read_to_string(&path).expect("results").replace("\"ate\": 0.", "\"ate\": 9.");
    fs::write(&path, worse).expect("a worse past");
    check_seeds(&scene, &args).expect(10, &[]);
    let text = fs::read_to_string(&junit).expect("JUnit");
    assert!(
        text.contains("<failure message=\"improved: baseline out of date\">"),
        "too good fails, too: {text}"
    );
    let text = fs::read_to_string(&markdown).expect("Markdown");
    assert!(text.starts_with("## small\n\n") && text.contains("| trajectory "), "{text}");
    let verdict: serde_json::Value = serde_json::from_slice(&fs::read(&json).expect("JSON")).expect("JSON");
    let first = &verdict["comparisons"][0];
    assert_eq!((&first["metric"], &first["movement"]), (&"ate".into(), &"improved".into()), "{first}");
}

/// The end of a check of a changed scene against the baseline of the small one, as if the scene had not changed but the program had.
fn planted(old: &str, new: &str) -> Finished {
    let scene = SmallScene::new(&[]);
    scene.run().expect(0, &[]);
    let text = fs::read_to_string(scene.path("scene.yaml")).expect("a scene");
    assert!(text.contains(old));
    fs::write(scene.path("scene.yaml"), text.replace(old, new)).expect("another scene");
    let hash = |out: &str| {
        let text = fs::read_to_string(scene.path(out).join("scenes/small/results.json")).expect("results");
        let results: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        (text, results["scene_hash"].as_str().expect("a hash").to_owned())
    };
    let mut command = scene.on(&[], "scene.yaml");
    Finished::of(command.arg("--out").arg(scene.path("other"))).expect(0, &[]);
    let ((baseline, own), (_, other)) = (hash("out"), hash("other"));
    fs::write(scene.path("out/scenes/small/results.json"), baseline.replace(&own, &other))
        .expect("a baseline");
    check(&scene)
}

#[test]
fn planted_regressions_are_found() {
    for (old, new) in [
        ("rotation_deg_per_metre: 3.0", "rotation_deg_per_metre: 9.0"),
        ("yaw_deg: 90", "yaw_deg: 84"),
        ("models/objects", "models/predictive"),
        ("families: [mug, duck, carton, teapot]", "families: [teapot, mug, duck, carton]"),
    ] {
        let found = planted(old, new);
        found.expect(10, &[]);
        assert!(
            found.stdout.contains("REGRESSED") || found.stdout.contains("MOVED"),
            "{old}: {}",
            found.stdout
        );
    }
}

#[test]
fn a_baseline_is_renewed_with_its_reason_and_not_from_files_that_nobody_has() {
    let scene = SmallScene::new(&[]);
    let git = |arguments: &[&str]| {
        let identity = ["-c", "user.name=t", "-c", "user.email=t@t", "-c", "commit.gpgsign=false"];
        let mut command = std::process::Command::new("git");
        command
            .current_dir(scene.path(""))
            .args(identity)
            .args(arguments)
            .output()
            .is_ok_and(|out| out.status.success())
    };
    let renew = |why: &str| {
        let mut command = scene.on(&["baseline"], "scene.yaml");
        command.current_dir(scene.path("")).arg("--baseline").arg(scene.path("kept")).args(["--why", why]);
        Finished::of(&mut command)
    };
    renew(" \n").expect(2, &["--why is empty"]);
    renew("the  first\none").expect(0, &[]);
    let reasons = || fs::read_to_string(scene.path("kept/BASELINES.md")).expect("reasons");
    assert!(reasons().ends_with("\n- small: the first one\n"), "{}", reasons());
    if !git(&["init", "-q"]) {
        eprintln!("SKIPPED: git is not installed");
        return;
    }
    assert!(git(&["add", "scene.yaml", "kept"]) && git(&["commit", "-q", "-m", "a scene"]));
    renew("another").expect(0, &[]);
    let lines: Vec<String> = reasons().lines().map(str::to_owned).collect();
    assert!(
        lines[lines.len() - 1].starts_with("- small, commit ")
            && lines[lines.len() - 1].ends_with(": another"),
        "{lines:?}"
    );
    let text = fs::read_to_string(scene.path("scene.yaml")).expect("a scene");
    fs::write(scene.path("scene.yaml"), text + "# changed\n").expect("a changed scene");
    renew("a third").expect(2, &["scene.yaml is changed and not committed"]);
    fs::write(scene.path("kept/BASELINES.md"), [0xff]).expect("no text");
    assert!(git(&["commit", "-q", "-am", "changed"]));
    renew("a third").expect(2, &["BASELINES.md"]);
}
