//! `bench map`, and a scene that varies: every cell is run, scored and drawn, and what cannot be is refused before anything runs.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use std::fs;
use std::path::PathBuf;
use std::process::Stdio;
use std::thread;
use std::time::Duration;
use vantage_eval::command::MAP_FILE;
use vantage_eval::result::metric::Metric;
use vantage_eval::result::results_file::Results;
use vantage_tests::{Finished, SmallScene, bench, files};

const MAP: &str = "\
version: 1
name: little
purpose: To see.
scene: scene.yaml
seeds: [5, 6]
across: { field: robot.path.circle.radius, over: [1.5, 1.6] }
estimates:
  - { rows: [odometry, geometric] }
  - { rows: [viewpoint_dependent], set: { estimator.semantic_noise_scale: 2 } }
panels:
  - { name: three, title: Three objects }
  - { name: two, title: Two objects, set: { world.objects: 2 } }
summary: { panels: [two], rows: [viewpoint_dependent] }
hypotheses:
  - { says: It helps., panel: three, at: [1.5, 1.6], row: viewpoint_dependent, than: geometric, expects: less }
";

fn run(scene: &SmallScene, map: &str, args: &[&str]) -> Finished {
    fs::write(scene.path("map.yaml"), map).unwrap();
    let mut command = scene.on(&["map"], "map.yaml");
    command.args(args).arg("--out").arg(scene.path("out"));
    Finished::of(&mut command)
}

#[test]
fn a_map_has_every_cell_on_its_seeds_and_runs_again_to_the_same_bytes() {
    let scene = SmallScene::new(&[]);
    run(&scene, MAP, &[]).expect(0, &["cells: 4 of 4"]);
    let place = scene.path("out/maps/little");
    let results = Results::read(&place).unwrap();
    let names: Vec<&str> = results.tables.iter().map(|table| table.name()).collect();
    assert_eq!(names, ["three, radius 1.5", "three, radius 1.6", "two, radius 1.5", "two, radius 1.6"]);
    let mut scores = Vec::new();
    for table in &results.tables {
        assert_eq!(table.methods(), ["odometry", "geometric", "viewpoint_dependent"]);
        assert_eq!(table.seeds().iter().map(|seed| seed.0).collect::<Vec<_>>(), [5, 6]);
        scores.extend(table.runs().map(|run| run.scores[&Metric::Ate].to_bits()));
    }
    // Cells differ, but for odometry, which sees no objects.
    scores.sort_unstable();
    scores.dedup();
    assert!(scores.len() >= 4 * 2 * 2, "{scores:?}");
    let pages = ["tables.md", "map.svg", "map.png", "summary.svg", "summary.png", MAP_FILE];
    pages.iter().for_each(|page| assert!(place.join(page).exists(), "{page}"));
    let tables = fs::read_to_string(place.join("tables.md")).unwrap();
    assert!(tables.contains("| It helps.") && tables.contains("## two: Two objects"), "{tables}");
    assert!(tables.contains("\nviewpoint_dependent: `estimator.semantic_noise_scale: 2`\n"), "{tables}");

    let before = files(&place);
    run(&scene, MAP, &["--seeds", "1"]).expect(2, &["holds a result of 2 seeds", "--replace"]);
    run(&scene, MAP, &[]).expect(0, &[]);
    let after = files(&place);
    for page in before.keys().filter(|page| !page.ends_with("manifest.json")) {
        assert!(before[page] == after[page], "{} differs", page.display());
    }

    fs::write(place.join("tables.md"), "of another version").unwrap();
    fs::write(place.join("map.svg"), "of another version").unwrap();
    Finished::of(bench().arg("index").arg(scene.path("out"))).expect(0, &[]);
    let renewed = files(&place);
    assert!(renewed.iter().all(|(page, bytes)| *bytes == after[page]), "`bench index` renews all pages");

    fs::remove_file(place.join(MAP_FILE)).unwrap();
    Finished::of(bench().arg("index").arg(scene.path("out"))).expect(0, &["little has no map.json"]);
}

#[test]
fn a_scene_that_varies_is_a_map_and_what_is_of_one_cell_is_refused() {
    let vary = "\nvary:\n  - { field: world.objects, over: [2, 3] }\n";
    let scene = SmallScene::new(&[("\nevaluation:", &format!("{vary}\nevaluation:"))]);
    scene.run().expect(0, &["cells: 2 of 2"]);
    let results = Results::read(&scene.path("out/maps/small")).unwrap();
    assert_eq!(results.tables.len(), 2);
    for option in ["--online", "--dump"] {
        Finished::of(scene.command().arg(option)).expect(2, &["varies fields of its own", option]);
    }
    let mut look = scene.on(&["look"], "scene.yaml");
    look.arg("--out").arg(scene.path("look.png"));
    Finished::of(&mut look).expect(0, &["varies world.objects"]);
}

#[test]
fn maps_that_cannot_be_are_refused_before_anything_runs() {
    let scene = SmallScene::new(&[]);
    for (from, to, words) in [
        ("over: [1.5, 1.6]", "over: [1.5, 1.6, .nan]", ["map.yaml:6:", "nan"]),
        (
            "over: [1.5, 1.6]",
            "over: [1.5, 1.6, 0.2]",
            ["panel three, robot.path.circle.radius 0.2", "radius"],
        ),
        ("scene: scene.yaml", "scene: none.yaml", ["map.yaml: scene", "none.yaml"]),
        ("world.objects: 2", "world.objcts: 2", ["panel two", "objcts"]),
        ("seeds: [5, 6]", "seeds: [5, 5]", ["map.yaml:5:", "seed"]),
        ("row: viewpoint_dependent", "row: magic", ["hypotheses[0]", "magic"]),
    ] {
        run(&scene, &MAP.replacen(from, to, 1), &[]).expect(2, &words);
    }
    let twice =
        MAP.replace("set: { estimator.semantic_noise_scale: 2 } }", "}\n  - { rows: [viewpoint_dependent] }");
    let told = run(&scene, &twice, &[]);
    told.expect(2, &["viewpoint_dependent", "two models"]);
    assert!(!told.stderr.contains("cells"), "{}", told.stderr);
    assert!(!scene.path("out").exists());
}

#[test]
fn drives_of_a_life_go_on_from_what_those_before_taught() {
    let scene = SmallScene::new(&[]);
    let lives = MAP
        .replace("{ field: robot.path.circle.radius, over: [1.5, 1.6] }", "{ field: drive, over: [1, 2] }")
        .replace(
            "[odometry, geometric] }",
            "[geometric, noise_refitted, process_refitted, domain_adapted, decoder_adapted, decoder_taught, decoder_checked] }",
        )
        .replace("Three objects", "A life, life: [{ from: 1 }, { from: 2, set: { world.objects: 2 } }]")
        .replace(
            "Two objects, set: { world.objects: 2 }",
            "Alone, alone: true, life: [{ from: 1 }, { from: 2, set: { world.objects: 2 } }]",
        )
        .replace(", set: { estimator.semantic_noise_scale: 2 }", "")
        .replace("at: [1.5, 1.6]", "at: [1, 2]");
    run(&scene, &lives, &[]).expect(0, &["cells: 4 of 4"]);
    let place = scene.path("out/maps/little");
    let results = Results::read(&place).unwrap();
    let ate = |cell: &str, row: &str| -> Vec<f64> {
        let table = results.table(cell).unwrap();
        table.runs().filter(|run| run.method == row).map(|run| run.scores[&Metric::Ate]).collect()
    };
    for row in [
        "geometric",
        "viewpoint_dependent",
        "noise_refitted",
        "process_refitted",
        "domain_adapted",
        "decoder_adapted",
        "decoder_checked",
        "decoder_taught",
    ] {
        assert_eq!(ate("three, drive 1", row), ate("two, drive 1", row), "{row}: a first drive is alone");
        assert_eq!(ate("three, drive 1", row).len(), 2);
    }
    for row in ["geometric", "viewpoint_dependent", "decoder_checked"] {
        assert_eq!(ate("three, drive 2", row), ate("two, drive 2", row), "{row} keeps nothing");
    }
    let checked =
        results.table("three, drive 2").unwrap().runs().filter(|run| run.method == "decoder_checked");
    let gains: Vec<f64> = checked.map(|run| run.scores[&Metric::PrequentialGain]).collect();
    assert_eq!(gains, [0.0, 0.0], "of these drives every round is rolled back, and so nothing is known");
    for row in ["domain_adapted", "decoder_adapted", "decoder_taught"] {
        assert_ne!(ate("three, drive 2", row), ate("two, drive 2", row), "{row} goes on");
    }
    assert_ne!(ate("three, drive 1", "geometric"), ate("three, drive 2", "geometric"), "another drive");
    assert_eq!(
        ate("two, drive 2", "decoder_taught"),
        ate("two, drive 2", "viewpoint_dependent"),
        "not on the drive itself"
    );
    assert!(fs::read_to_string(place.join("tables.md")).unwrap().contains("\nPrequential gain [nat]"));
    let before = fs::read(place.join("results.json")).unwrap();
    run(&scene, &lives, &[]).expect(0, &[]);
    assert_eq!(fs::read(place.join("results.json")).unwrap(), before);

    let path = |name: &str| scene.path(name).to_string_lossy().into_owned();
    let (plan, map, cache, merged) = (path("plan"), path("map.yaml"), path("shared"), path("merged"));
    let sweep = |args: &[&str]| Finished::of(bench().arg("sweep").args(args));
    let command = ["map", &map, "--renderer", "reference", "--cache", &cache, "--out", &merged];
    sweep(&[&["plan", "--tasks", "3", "--out", &plan, "--"], &command[..]].concat()).expect(0, &[]);
    let drives = || fs::read_dir(scene.path("shared/entries/drive")).unwrap().count();
    sweep(&["run", &plan, "--index", "0"]).expect(0, &[]);
    let of_one_life = drives();
    sweep(&["run", &plan, "--index", "1"]).expect(0, &[]);
    assert_eq!(drives(), 2 * of_one_life, "a task has a life");
    sweep(&["run", &plan, "--index", "2"]).expect(0, &[]);
    sweep(&["merge", &plan]).expect(0, &[]);
    assert_eq!(drives(), 2 * of_one_life, "nothing is estimated again");
    assert_eq!(fs::read(scene.path("merged/maps/little/results.json")).unwrap(), before);

    let fewer = lives.replace("over: [1, 2] }", "over: [1] }").replace("at: [1, 2]", "at: [1]");
    let fewer = fewer.replace(", { from: 2, set: { world.objects: 2 } }", "");
    run(&scene, &fewer, &[]).expect(2, &["of 4 cells", "lacks 2 of them", "three, drive 2", "--replace"]);
    assert_eq!(fs::read(place.join("results.json")).unwrap(), before);

    for (from, to, said) in [
        ("over: [1, 2]", "over: [1, 2, 4]", "map.yaml:6:"),
        ("over: [1, 2]", "over: [2, 1]", "1, 2, 3 and so on"),
        (
            ", life: [{ from: 1 }, { from: 2, set: { world.objects: 2 } }] }\n  - { name: two",
            " }\n  - { name: two",
            "no `life`",
        ),
        ("{ from: 2, set: { world.objects: 2 } }", "{ from: 3 }", "up to 2"),
        ("{ from: 1 }", "{ from: 1, set: { estimator.tolerance: 1e-5 } }", "world, robot and sensors"),
        ("life: [{ from: 1 }, { from: 2,", "life: [{ from: 2,", "begin at drive 1"),
        ("field: drive, over: [1, 2]", "field: robot.laps, over: [1, 2]", "has a life"),
        ("seeds: [5, 6]", "seeds: [5, 1000]", "seed 1000"),
    ] {
        run(&scene, &lives.replacen(from, to, 1), &["--replace"]).expect(2, &["map.yaml", said]);
    }
}

#[test]
fn a_decoder_learns_in_as_many_rounds_as_are_asked_for() {
    let scene = SmallScene::new(&[]);
    let rounds = MAP
        .replace("robot.path.circle.radius, over: [1.5, 1.6]", "estimator.decoder_rounds, over: [1, 2]")
        .replace("[odometry, geometric] }", "[geometric, decoder_adapted] }")
        .replace("at: [1.5, 1.6]", "at: [1, 2]");
    run(&scene, &rounds, &[]).expect(0, &["cells: 4 of 4"]);
    let results = Results::read(&scene.path("out/maps/little")).unwrap();
    let ate = |rounds: u32, row: &str| -> Vec<f64> {
        let table = results.table(&format!("three, decoder_rounds {rounds}")).unwrap();
        table.runs().filter(|run| run.method == row).map(|run| run.scores[&Metric::Ate]).collect()
    };
    assert_eq!(ate(1, "geometric"), ate(2, "geometric"));
    assert_ne!(ate(1, "decoder_adapted"), ate(2, "decoder_adapted"));
    for (from, to) in [("over: [1, 2]", "over: [0, 2]"), ("over: [1, 2]", "over: [1, 101]")] {
        run(&scene, &rounds.replace(from, to), &["--replace"]).expect(2, &["decoder_rounds"]);
    }
}

#[test]
fn a_life_that_was_killed_goes_on_to_the_same_bytes() {
    let lives = MAP
        .replace(
            "{ field: robot.path.circle.radius, over: [1.5, 1.6] }",
            "{ field: drive, over: [1, 2, 3, 4] }",
        )
        .replace(
            "[odometry, geometric] }",
            "[geometric, noise_refitted, process_refitted, domain_adapted, decoder_adapted, decoder_checked] }",
        )
        .replace("Three objects", "A life, life: [{ from: 1 }]")
        .replace("  - { name: two, title: Two objects, set: { world.objects: 2 } }\n", "")
        .replace("summary: { panels: [two], rows: [viewpoint_dependent] }\n", "")
        .replace(", set: { estimator.semantic_noise_scale: 2 }", "")
        .replace("at: [1.5, 1.6]", "at: [1, 2, 3, 4]");
    let whole = SmallScene::new(&[]);
    run(&whole, &lives, &[]).expect(0, &["cells: 4 of 4"]);
    let learnt = 5 * 4 * 2;
    let drives = |scene: &SmallScene| {
        let entries = fs::read_dir(scene.path("cache/entries/drive")).into_iter().flatten();
        entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()).collect::<Vec<PathBuf>>()
    };
    assert_eq!(drives(&whole).len(), learnt);

    let killed = SmallScene::new(&[]);
    fs::write(killed.path("map.yaml"), &lives).unwrap();
    for least in [5, 17] {
        let mut command = killed.on(&["map"], "map.yaml");
        command.arg("--out").arg(killed.path("out")).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        while drives(&killed).len() < least {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it could be killed");
            thread::sleep(Duration::from_millis(2));
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let before = drives(&killed);
    assert!(before.len() < learnt, "there is something left to do");
    let written = |path: &PathBuf| fs::metadata(path).unwrap().modified().unwrap();
    let times: Vec<_> = before.iter().map(written).collect();
    run(&killed, &lives, &[]).expect(0, &["cells: 4 of 4"]);
    assert_eq!(before.iter().map(written).collect::<Vec<_>>(), times, "what was learnt is not learnt again");
    assert_eq!(drives(&killed).len(), learnt);
    let results = |scene: &SmallScene| fs::read(scene.path("out/maps/little/results.json")).unwrap();
    assert_eq!(results(&killed), results(&whole));
}

#[test]
fn rows_that_are_not_told_who_is_who_ask_an_associator() {
    let scene = SmallScene::new(&[]);
    let map = "\
version: 1
name: found
purpose: To see.
scene: scene.yaml
seeds: [5, 6]
across: { field: drive, over: [1, 2] }
estimates:
  - { rows: [geometric, viewpoint_dependent, decoder_adapted] }
panels:
  - { name: told, title: Told, life: [{ from: 1 }] }
  - name: found
    title: Found
    life: [{ from: 1 }]
    estimates:
      - { rows: [geometric, viewpoint_dependent, decoder_adapted], association: { told: none, by: hypotheses_latents } }
  - name: once
    title: None is seen again
    life: [{ from: 1 }]
    estimates:
      - { rows: [geometric, viewpoint_dependent, decoder_adapted], association: { told: none, by: separate } }
";
    run(&scene, map, &[]).expect(0, &["cells: 6 of 6"]);
    let place = scene.path("out/maps/found");
    let results = Results::read(&place).unwrap();
    let scores = |cell: &str, row: &str, metric| -> Vec<Option<f64>> {
        let table = results.table(cell).unwrap();
        table.runs().filter(|run| run.method == row).map(|run| run.scores.get(&metric).copied()).collect()
    };
    for row in ["geometric", "viewpoint_dependent", "decoder_adapted"] {
        let ate = |panel: &str, drive| scores(&format!("{panel}, drive {drive}"), row, Metric::Ate);
        for drive in [1, 2] {
            assert!(ate("found", drive).iter().all(Option::is_some), "{row}");
            assert_ne!(ate("once", drive), ate("told", drive), "{row}");
        }
    }
    // Of objects that are cut by the image's edge nothing is told, and their views count as lost.
    let azimuths = |panel: &str, row: &str| scores(&format!("{panel}, drive 1"), row, Metric::Azimuth);
    for row in ["geometric", "viewpoint_dependent"] {
        let (told, once) = (azimuths("told", row), azimuths("once", row));
        assert!(
            told.iter().zip(&once).all(|(told, once)| told.unwrap() < once.unwrap()),
            "{told:?} {once:?}"
        );
    }
    for drive in [1, 2] {
        let ari = |panel: &str| scores(&format!("{panel}, drive {drive}"), "geometric", Metric::Ari);
        assert!(ari("told").iter().all(Option::is_none), "the episode tells it");
        let (found, once) = (ari("found"), ari("once"));
        let better = found.iter().zip(&once).map(|(found, once)| found.unwrap() - once.unwrap());
        assert!(better.into_iter().all(|by| by >= 0.0) && found != once, "{found:?} {once:?}");
    }
    let tables = fs::read_to_string(place.join("tables.md")).unwrap();
    assert_eq!(tables.matches("\nARI, mean").count(), 2, "{tables}");
    assert!(tables.contains("decoder_adapted: who is who by `none-hypotheses_latents`\n"), "{tables}");
    assert!(tables.contains("\nAzimuth [deg]"), "{tables}");

    let told = map.replacen("decoder_adapted] }", "decoder_taught] }", 1);
    run(&scene, &told, &["--replace"]).expect(0, &[]);
    let taught = map.replacen("decoder_adapted], association", "decoder_taught], association", 1);
    run(&scene, &taught, &["--replace"]).expect(2, &["panel found: decoder_taught reads the truth"]);
    let nobody = map.replacen("by: separate", "by: chance", 1);
    run(&scene, &nobody, &["--replace"]).expect(2, &["map.yaml", "chance"]);
}
