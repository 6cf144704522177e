//! `bench calibrate` and `bench headroom`: settings tried on validation objects.

use vantage_eval::result::results_file::Results;
use vantage_tests::{Finished, SmallScene, bench, root};

fn on(scene: &SmallScene, command: &str, more: &[&str]) -> Finished {
    Finished::of(scene.on(&[command], "scene.yaml").args(more))
}

/// The cells of each row of the table whose first column has this head.
fn rows<'t>(printed: &'t str, head: &str) -> Vec<Vec<&'t str>> {
    let cells = |table: &'t str| -> Vec<Vec<&'t str>> {
        let lines = table.lines().filter(|line| line.starts_with('│'));
        lines.map(|line| line.trim_matches('│').split(['│', '┆']).map(str::trim).collect()).collect()
    };
    let mut tables = printed.split('┌').map(cells);
    let table = tables.find(|rows| rows.first().is_some_and(|first| first[0] == head));
    table.unwrap_or_default().into_iter().skip(1).collect()
}

#[test]
fn the_worth_of_a_crop_is_told_by_its_scale() {
    let scene = SmallScene::new(&[]);
    let first = on(&scene, "calibrate", &["2"]);
    first.expect(0, &[]);
    let told = [
        "size over box side: 1.",
        "bearing_noise: {",
        "bearing_offset: {",
        "alike from all sides: bearing_offset: {",
    ];
    assert!(told.iter().all(|told| first.stdout.contains(told)), "{}", first.stdout);
    let boxes = rows(&first.stdout, "Row");
    let kernels = boxes.iter().filter(|row| row[0].starts_with("Huber") || row[0].starts_with("Student t"));
    assert_eq!(kernels.count(), 5, "{boxes:?}");
    let of = |name: &str| boxes.iter().find(|row| row[0] == name).map(|row| &row[1..]);
    let moves = |name: &str| of(name).is_some_and(|row| Some(row) != of("geometric"));
    let tried = ["noise fitted", "offset fitted", "offset constant", "no bias"];
    assert!(tried.iter().all(|name| of(name).is_some()) && moves("offset constant"), "{boxes:?}");
    assert!(of("geometric") == of("Huber, 2") && of("Huber, 2") != of("Student t, 1"), "{boxes:?}");
    let losses = rows(&first.stdout, "Exponents");
    assert_eq!(losses.len(), 12, "{}", first.stdout);
    let differ = |a: usize, b: usize| losses[a][1..] != losses[b][1..];
    assert!(differ(0, 3) && differ(4, 6) && differ(7, 11), "exponents change nothing: {losses:?}");
    let reliability = rows(&first.stdout, "Probability of one object");
    let pairs: usize = reliability.iter().map(|row| row[1].parse::<usize>().unwrap_or_default()).sum();
    assert!(reliability.len() == 6 && pairs > 0, "{reliability:?}");
    let rows = rows(&first.stdout, "Scale");
    let names: Vec<&str> = rows.iter().map(|row| row[0]).collect();
    let discrepant = ["1, every view", "1, with a discrepancy"];
    let margins = [100, 50, 20, 0].map(|nats| format!("{nats} nats: 0 of 6 unknown"));
    let margins: Vec<&str> = margins.iter().map(String::as_str).collect();
    assert_eq!(
        names,
        [&["geometric", "1", "0.5", "0.25", "0.1", "0.05"], &discrepant[..], &margins].concat()
    );
    assert!(rows[6][1] != rows[7][1], "the discrepancy changes nothing: {rows:?}");
    assert_eq!(rows[0][2], "0.0000");
    assert!(rows.iter().all(|row| row[1..].iter().all(|cell| cell.parse::<f64>().is_ok_and(f64::is_finite))));
    assert!(rows[1][1] != rows[5][1], "the scale changes nothing: {rows:?}");
    assert_eq!(on(&scene, "calibrate", &["2"]).stdout, first.stdout);
}

#[test]
fn a_sharp_sensor_of_azimuths_moves_the_estimate_more_than_a_blunt_one() {
    let scene = SmallScene::new(&[]);
    let told = on(&scene, "headroom", &["2"]);
    told.expect(0, &[]);
    let rows = rows(&told.stdout, "Sensor's noise [deg]");
    let names: Vec<&str> = rows.iter().map(|row| row[0]).collect();
    assert_eq!(names, ["geometric", "2", "5", "10", "20"]);
    let measured = told.stdout.lines().find(|line| line.contains("│ as measured")).unwrap_or_default();
    assert!(measured.contains(rows[0][1]) && measured.contains("of 2"), "{measured}");
    let assumed = told.stdout.lines().find(|line| line.contains("│ as assumed")).unwrap_or_default();
    assert!(!assumed.is_empty() && !assumed.contains(rows[0][1]), "{assumed}");
    let moved = |row: usize| rows[row][2].parse::<f64>().unwrap_or(f64::NAN).abs();
    assert!(moved(0) == 0.0 && moved(1) > moved(4), "{rows:?}");
}

#[test]
fn what_gives_no_trajectory_is_refused_with_a_remedy() {
    let scene = SmallScene::new(&[("yaw_deg: 90", "yaw_deg: -90")]);
    for command in ["calibrate", "headroom"] {
        on(&scene, command, &["1"]).expect(4, &["no object was detected", "robot.camera"]);
        on(&scene, command, &["0"]).expect(2, &["0 is not in 1..=1000"]);
        let mut bench = bench();
        bench.arg(command).arg(root().join("scenes/turntable.yaml")).args(["1", "--cache"]);
        Finished::of(bench.arg(scene.path("cache"))).expect(2, &["no robot drives", "turntable.yaml"]);
    }
    on(&scene, "calibrate", &["1", "--model", "nowhere"]).expect(2, &["nowhere", "--model"]);
}

const RIVALS: &str =
    "estimator: { rows: [geometric, gaussian_process, azimuth_head, discrete_class, ideal_azimuth] }";

#[test]
fn rivals_run_and_are_calibrated_where_a_scene_names_them() {
    let scene = SmallScene::new(&[("estimator: {}", RIVALS)]);
    let ran = scene.run();
    ran.expect(0, &[]);
    let names = ["gaussian_process", "azimuth_head", "discrete_class"];
    assert!(names.iter().all(|name| ran.stdout.contains(name)), "{}", ran.stdout);
    let results = Results::read(&scene.path("out/scenes/small")).unwrap();
    assert_eq!(results.table("trajectory").unwrap().runs_of("ideal_azimuth").len(), 2);
    let beliefs = results.table("semantics").map(|table| table.methods().to_vec());
    assert_eq!(beliefs, Some(vec![names[2].to_owned()]), "an ideal sensor's latent is of no model");
    let told = on(&scene, "calibrate", &["2"]);
    told.expect(0, &[]);
    let classes = rows(&told.stdout, "Exponents");
    assert_eq!(classes.iter().filter(|row| row[0].starts_with("class")).count(), 4, "{classes:?}");
    let rows = rows(&told.stdout, "Scale");
    for name in names {
        let of_row: Vec<_> = rows.iter().filter(|row| row[0].starts_with(name)).collect();
        assert_eq!(of_row.len(), 5, "{name}: {rows:?}");
        assert!(of_row[0][1] != of_row[4][1], "the scale changes nothing: {of_row:?}");
    }
}

#[test]
fn too_few_views_for_read_outs_are_refused_with_a_remedy() {
    let few = ("validation_instances: 32", "validation_instances: 1");
    let scene = SmallScene::new(&[("estimator: {}", RIVALS), few]);
    scene.run().expect(2, &["8 validation views are too few", "views.validation_instances"]);
}
