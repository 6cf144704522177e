//! What `bench SCENE` says, and what it leaves alone.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use std::fs;
use std::path::Path;
use vantage_tests::{Finished, SmallScene};

fn run(scene: &SmallScene, args: &[&str]) -> Finished {
    Finished::of(scene.command().args(args))
}

fn widest(text: &str) -> usize {
    text.lines().filter(|line| line.contains('│')).map(|line| line.chars().count()).max().unwrap()
}

#[test]
fn two_tables_are_printed_that_fit_and_then_where_files_lie() {
    let scene = SmallScene::new(&[]);
    let finished = run(&scene, &[]);
    finished.expect(0, &["episodes: 2 of 2"]);
    let said = &finished.stdout;
    assert_eq!(said.matches("│ Method").count(), 2, "{said}");
    assert!(widest(said) <= 100, "{said}");
    for word in ["Difference to", "Seeds", "ATE [m] ↓", "ARI ↑", "viewpoint_dependent", "pixels_pca64"] {
        assert!(said.contains(word), "{word} is missing: {said}");
    }
    let folder = scene.path("out/scenes/small");
    let paths: Vec<&str> =
        said.split_whitespace().filter(|word| word.starts_with(folder.to_str().unwrap())).collect();
    let (of_seeds, files): (Vec<&str>, Vec<&str>) = paths.iter().partition(|path| path.contains("<seed>"));
    assert_eq!((of_seeds.len(), files.len()), (1, 10), "{said}");
    assert!(files.iter().all(|path| Path::new(path).exists()), "{files:?}");
    assert!(said.contains("95% interval"), "{said}");
    let answer = "2 seeds are too few to tell viewpoint_dependent from geometric.";
    assert_eq!(said.lines().last(), Some(answer), "{said}");
    let svg = fs::read_to_string(folder.join("trajectory.svg")).unwrap();
    assert!(svg.contains("the median of the differences on 2 seeds"));
}

#[test]
fn all_tables_json_quiet_and_verbose_are_to_be_had() {
    let scene = SmallScene::new(&[]);
    let json = run(&scene, &["--json"]);
    json.expect(0, &[]);
    assert_eq!(json.stdout, fs::read_to_string(scene.path("out/scenes/small/results.json")).unwrap());
    let all = run(&scene, &["--tables", "all"]);
    assert!(
        all.stdout.matches("│ Method").count() >= 15 && all.stdout.contains("│ Family"),
        "{}",
        all.stdout
    );
    assert!(widest(&all.stdout) <= 120, "{}", all.stdout);
    let quiet = run(&scene, &["-q"]);
    assert!(quiet.code == Some(0) && !quiet.stderr.contains(" of 2 in "), "{}", quiet.stderr);
    let verbose = run(&scene, &["--verbose"]);
    verbose.expect(0, &["note: estimates took ", "episodes: 2 of 2"]);
    assert!(!run(&scene, &[]).stderr.contains("took"));
    run(&scene, &["-q", "-v"]).expect(2, &["--verbose"]);
    run(&scene, &["--json", "--tables", "all"]).expect(2, &["--json"]);
}

#[test]
fn a_fuller_result_is_kept_until_it_is_given_up() {
    let scene = SmallScene::new(&[]);
    run(&scene, &[]).expect(0, &[]);
    let before = fs::read(scene.path("out/scenes/small/results.json")).unwrap();
    let entries = || fs::read_dir(scene.path("cache/entries/views")).unwrap().count();
    let cached = entries();
    let words = ["out/scenes/small", "2 seeds", "lacks 1 of them", "--out DIR", "--replace"];
    run(&scene, &["--seeds", "1"]).expect(2, &words);
    run(&scene, &["--model", "models/predictive"]).expect(2, &["another model"]);
    run(&scene, &["--train"]).expect(2, &["another model"]);
    assert_eq!(fs::read(scene.path("out/scenes/small/results.json")).unwrap(), before);
    assert_eq!(entries(), cached, "nothing was run");
    run(&scene, &["--seeds", "1", "--replace"]).expect(0, &[]);
    assert_ne!(fs::read(scene.path("out/scenes/small/results.json")).unwrap(), before);
    assert!(!scene.path("out/scenes/small/1").exists());
    run(&scene, &[]).expect(0, &[]);
    assert_eq!(fs::read(scene.path("out/scenes/small/results.json")).unwrap(), before);
}

#[test]
fn an_index_tells_of_what_lies_in_a_folder() {
    let scene = SmallScene::new(&[]);
    run(&scene, &[]).expect(0, &[]);
    let out = scene.path("out");
    let index = Finished::of(vantage_tests::bench().arg("index").arg(&out));
    index.expect(0, &[]);
    let link = format!("| [small]({}/scenes/small/tables.md) | 2 |", out.display());
    assert!(index.stdout.contains(&link), "{}", index.stdout);
    let text = fs::read_to_string(out.join("README.md")).unwrap();
    assert!(text.contains("[gains.svg](scenes/small/gains.svg)"), "{text}");
    Finished::of(vantage_tests::bench().args(["index", "missing"])).expect(2, &["no folder missing"]);
}
