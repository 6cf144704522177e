//! `bench score TRUTH ESTIMATE`: two trajectories of anybody's.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use vantage_dataset::Pose;
use vantage_dataset::store::write_tum;
use vantage_tests::{Finished, bench};

/// A loop of 40 poses ten a second, and the same seen from another frame, with the third pose off by 0.4 m.
fn written(folder: &Path) -> [PathBuf; 2] {
    let times: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    let truth: Vec<Pose> =
        times.iter().map(|t| Pose::new([t.cos(), t.sin(), 0.1 * t].into(), [0.0, 0.0, *t].into())).collect();
    let frame = Pose::new([5.0, -3.0, 0.5].into(), [0.0, 0.0, 2.0].into());
    let mut estimate: Vec<Pose> = truth.iter().map(|pose| frame * pose).collect();
    estimate[2].translation.z += 0.4;
    let paths = ["truth.tum", "estimate.tum"].map(|name| folder.join(name));
    write_tum(&paths[0], &times, &truth).unwrap();
    write_tum(&paths[1], &times, &estimate).unwrap();
    paths
}

fn score(paths: &[PathBuf; 2], options: &[&str]) -> Finished {
    Finished::of(bench().arg("score").args(paths).args(options))
}

#[test]
fn errors_are_told_as_a_table_and_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let paths = written(folder.path());
    let table = score(&paths, &[]);
    table.expect(0, &[]);
    for said in ["40 pairs of 40 true and 40 estimated poses", "APE translation [m]", "0.400000"] {
        assert!(table.stdout.contains(said), "{said:?} is not in {}", table.stdout);
    }
    let told = score(&paths, &["--json", "--align", "origin", "--unit", "metres", "--delta", "0.5"]);
    told.expect(0, &[]);
    let told: Value = serde_json::from_str(&told.stdout).unwrap();
    let rmse = told["errors"][0]["rmse"].as_f64().unwrap();
    assert!((rmse - 0.4 / 40f64.sqrt()).abs() < 1e-9, "{rmse}");
    assert_eq!(
        (told["alignment"].as_str(), told["spacing"]["unit"].as_str()),
        (Some("origin"), Some("metres"))
    );
    score(&paths, &["--align", "none"]).expect(0, &[]);
}

#[test]
fn files_of_kitti_and_euroc_are_known_by_their_lines() {
    let folder = tempfile::tempdir().unwrap();
    let [truth, estimate] = written(folder.path());
    let poses = |path: &Path| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(path).unwrap();
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        lines.map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect()
    };
    let matrix = |pose: &Vec<f64>| {
        let [_, tx, ty, tz, x, y, z, w] = pose[..] else { panic!() };
        let rows = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y), tx],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x), ty],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y), tz],
        ];
        rows.as_flattened().iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
    };
    let euroc = |pose: &Vec<f64>| {
        let [t, x, y, z, qx, qy, qz, qw] = pose[..] else { panic!() };
        format!("{:.0},{x},{y},{z},{qw},{qx},{qy},{qz},0.1,0.2", 1e9 * t)
    };
    let as_text = |path: &Path, name: &str, line: &dyn Fn(&Vec<f64>) -> String| {
        let other = folder.path().join(name);
        fs::write(&other, poses(path).iter().map(|pose| line(pose) + "\n").collect::<String>()).unwrap();
        other
    };
    let rmse = |paths: [&Path; 2]| {
        let told = score(&paths.map(Path::to_owned), &["--json", "--align", "se3"]);
        told.expect(0, &[]);
        let told: Value = serde_json::from_str(&told.stdout).unwrap();
        [0, 1, 2, 3].map(|error| told["errors"][error]["rmse"].as_f64().unwrap())
    };
    let kitti = [as_text(&truth, "t.txt", &matrix), as_text(&estimate, "e.txt", &matrix)];
    let table = as_text(&truth, "t.csv", &euroc);
    let expected = rmse([&truth, &estimate]);
    for told in [rmse([&kitti[0], &kitti[1]]), rmse([&table, &estimate])] {
        assert!(told.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{told:?} {expected:?}");
    }
    score(&kitti, &["--max-difference", "0.1"]).expect(2, &["--max-difference says nothing", "leave it out"]);
    score(&[kitti[0].clone(), estimate], &[]).expect(2, &["no times"]);
    fs::write(&kitti[1], "1 0 0 0 0 1 0 0 0 0 1 0\n").unwrap();
    score(&kitti, &[]).expect(2, &["40 true and 1 estimated"]);
    fs::write(&kitti[1], "1 0 0 0 0 1 0 0 0 0 1 0\n1 2\n").unwrap();
    score(&kitti, &[]).expect(2, &["line 2: 2 numbers, expected 12"]);
}

#[test]
fn what_cannot_be_compared_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let [truth, estimate] = written(folder.path());
    let late = folder.path().join("late.tum");
    let text = fs::read_to_string(&estimate).unwrap();
    let moved: String = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split_once(' ').unwrap())
        .map(|(time, rest)| format!("{} {rest}\n", time.parse::<f64>().unwrap() + 100.0))
        .collect();
    fs::write(&late, moved).unwrap();
    score(&[truth.clone(), late], &[]).expect(2, &["runs from 0 to 3.9", "--max-difference"]);
    let bad = folder.path().join("bad.tum");
    fs::write(&bad, "0 1 2 3\n").unwrap();
    score(&[truth.clone(), bad], &[]).expect(2, &["bad.tum", "line 1", "expected 8"]);
    score(&[truth.clone(), folder.path().join("none.tum")], &[]).expect(2, &["none.tum"]);
    score(&[truth.clone(), folder.path().to_owned()], &[]).expect(2, &["regular file"]);
    let straight = folder.path().join("straight.tum");
    // Nearly straight: off by a millimetre on eight metres.
    let pose = |i: i32| Pose::translation(f64::from(i), 1e-3 * f64::from(i % 2), 0.0);
    let line: Vec<Pose> = (0..9).map(pose).collect();
    write_tum(&straight, &(0..9).map(|i| 0.1 * f64::from(i)).collect::<Vec<_>>(), &line).unwrap();
    let twice = [straight.clone(), straight];
    score(&twice, &["--align", "sim3"]).expect(2, &["on a line", "--align yaw or --align origin"]);
    for determined in ["yaw", "scale", "origin"] {
        score(&twice, &["--align", determined]).expect(0, &[]);
    }
    score(&[truth, estimate], &["--delta", "0"]).expect(2, &["above 0"]);
}

#[test]
fn results_for_evo_hold_what_evo_reads() {
    let folder = tempfile::tempdir().unwrap();
    let paths = written(folder.path());
    let out = folder.path().join("evo");
    score(&paths, &["--evo", out.to_str().unwrap()]).expect(0, &[]);
    for name in ["ape_translation", "ape_rotation", "rpe_translation", "rpe_rotation"] {
        let bytes = fs::read(out.join(format!("{name}.zip"))).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        for member in
            ["info.json", "stats.json", "error_array.npy", "timestamps.npy", "-truth.tum", "-estimate.tum"]
        {
            assert!(text.contains(member), "{name} lacks {member}");
        }
        assert!(text.contains("\"est_name\":\"") && text.contains("-estimate\""), "{name}");
    }
}

#[test]
fn a_map_is_laid_on_the_truth_as_its_trajectory_is() {
    let folder = tempfile::tempdir().unwrap();
    let paths = written(folder.path());
    let [truth, own] = ["true.csv", "own.csv"].map(|name| folder.path().join(name));
    fs::write(&truth, "x,y,z,label\n1,2,0,mug\n-1,0,1,book\n").unwrap();
    let frame = Pose::new([5.0, -3.0, 0.5].into(), [0.0, 0.0, 2.0].into());
    let moved = |[x, y, z]: [f64; 3]| (frame * Pose::translation(x, y, z)).translation.vector;
    let rows = [[1.0, 2.0, 0.1], [-1.0, 0.0, 1.0], [7.0, 7.0, 7.0]]
        .map(moved)
        .map(|at| format!("{},{},{}\n", at.x, at.y, at.z));
    fs::write(&own, format!("x,y,z\n{}", rows.concat())).unwrap();
    let options = ["--map", own.to_str().unwrap(), "--true-map", truth.to_str().unwrap()];
    let told = score(&paths, &[&options[..], &["--json"]].concat());
    told.expect(0, &[]);
    let told: Value = serde_json::from_str(&told.stdout).unwrap();
    let of = |name: &str| told["object_map"][name].as_f64().unwrap();
    assert_eq!((of("map_recall"), of("map_precision")), (1.0, 2.0 / 3.0));
    assert!((of("map_center") - 0.1 / 2f64.sqrt()).abs() < 1e-9, "{told}");
    let table = score(&paths, &options);
    assert!(table.stdout.contains("Recall") && table.stdout.contains("0.666667"), "{}", table.stdout);
    fs::write(&own, "x,y,z,label\n1,2,0,cup\n1,2,0,mug\n").unwrap();
    score(&paths, &options).expect(0, &["1 of 2 objects with a label", "cup; it has book, mug"]);
    score(&paths, &options[..2]).expect(2, &["--true-map"]);
    fs::write(&own, "x,y,z\n1,2,zero\n").unwrap();
    score(&paths, &options).expect(2, &["own.csv", "line 2, z", "zero"]);
    fs::remove_file(&own).unwrap();
    score(&paths, &options).expect(2, &["own.csv", "no such file"]);
}

#[test]
fn another_unit_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let paths = written(folder.path());
    let score_of = |unit: f64| {
        let text = fs::read_to_string(&paths[0]).unwrap();
        let scaled = text.lines().filter(|line| !line.starts_with('#')).map(|line| {
            let words = line.split(' ').enumerate().map(|(i, word)| match i {
                1..4 => (unit * word.parse::<f64>().unwrap()).to_string(),
                _ => word.to_owned(),
            });
            words.collect::<Vec<_>>().join(" ") + "\n"
        });
        fs::write(&paths[1], scaled.collect::<String>()).unwrap();
        score(&paths, &[])
    };
    score_of(1000.0).expect(0, &["1000.000 times as long", "are both in metres?"]);
    score_of(0.001).expect(0, &["0.001 times as long"]);
    assert!(!score(&paths, &["--align", "sim3"]).stderr.contains("times as long"));
    assert!(!score_of(2.0).stderr.contains("times as long"));
}

#[test]
fn what_options_cannot_mean_and_few_pairs_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let paths = written(folder.path());
    score(&paths, &["--delta", "1.5"]).expect(2, &["--delta 1.5", "--unit metres"]);
    score(&paths, &["--task", "task"]).expect(2, &["--task says nothing of two trajectories"]);
    score(&[paths[0].with_extension("none"), paths[1].clone()], &["--task", "task"])
        .expect(2, &["there is no folder"]);
    let text = fs::read_to_string(&paths[1]).unwrap();
    let some: String = text.lines().take(15).map(|line| format!("{line}\n")).collect();
    fs::write(&paths[1], some).unwrap();
    score(&paths, &[]).expect(0, &["pairs alone, of 40 true and"]);
}
