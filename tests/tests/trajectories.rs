//! `bench SCENE --trajectories DIR`: somebody else's estimator, beside ours.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use std::fs;
use std::path::Path;
use vantage_dataset::Pose;
use vantage_dataset::store::write_tum;
use vantage_eval::result::metric::Metric;
use vantage_eval::result::results_file::Results;
use vantage_eval::result::run::{Outcome, Run};
use vantage_eval::result::trajectory::Trajectory;
use vantage_tests::{Finished, SmallScene};

const OF_POSES: [Metric; 5] =
    [Metric::Ate, Metric::AteUmeyama, Metric::Heading, Metric::RpeTranslation, Metric::RpeRotation];

/// Copies a trajectory into another world frame.
fn moved(from: &Path, to: &Path) {
    let read = Trajectory::from_tum(&fs::read_to_string(from).unwrap()).unwrap();
    let frame = Pose::new([5.0, -3.0, 0.5].into(), [0.1, 0.2, 2.0].into());
    let poses: Vec<Pose> = read.world_from_robot().iter().map(|pose| frame * pose).collect();
    write_tum(to, read.timestamps(), &poses).unwrap();
}

#[test]
fn trajectories_of_another_are_scored_as_ours_are_whatever_their_frame() {
    let scene = SmallScene::new(&[]);
    scene.run().expect(0, &[]);
    let (mine, lost) = (scene.path("mine"), scene.path("lost"));
    fs::create_dir(&mine).unwrap();
    fs::create_dir(&lost).unwrap();
    let mut command = scene.command();
    command.arg("--trajectories").arg(&mine).arg("--trajectories").arg(&lost);
    Finished::of(&mut command).expect(2, &["mine", "expected 0.tum"]);
    for seed in [0, 1] {
        moved(
            &scene.path(&format!("out/scenes/small/{seed}/odometry.tum")),
            &mine.join(format!("{seed}.tum")),
        );
    }
    fs::copy(mine.join("1.tum"), mine.join("01.tum")).unwrap();
    let text = fs::read_to_string(mine.join("1.tum")).unwrap();
    let most = text.lines().count() - 1;
    fs::write(
        lost.join("1.tum"),
        text.lines().take(most).map(|line| format!("{line}\n")).collect::<String>(),
    )
    .unwrap();
    Finished::of(&mut command).expect(
        4,
        &[
            "no seed that is run, 01.tum first",
            "2 of 2 runs of lost failed, that of seed 0 first: there is no",
            "no run of lost succeeded",
            "all else was written",
        ],
    );

    let results = Results::read(&scene.path("out/scenes/small")).unwrap();
    let table = results.table("trajectory").unwrap();
    let runs = |method: &str| -> Vec<&Run> { table.runs().filter(|run| run.method == method).collect() };
    let pairs = runs("mine").into_iter().zip(runs("odometry"));
    assert_eq!(pairs.clone().count(), 2);
    for (theirs, ours) in pairs {
        assert_eq!(theirs.outcome, Outcome::Done);
        for metric in OF_POSES {
            let (theirs, ours) = (theirs.scores[&metric], ours.scores[&metric]);
            assert!(ours > 1e-4 && (theirs - ours).abs() < 1e-9, "{metric:?}: {theirs} {ours}");
        }
    }
    let told: Vec<String> = runs("lost").into_iter().map(|run| format!("{:?}", run.outcome)).collect();
    assert!(told[0].contains("there is no 0.tum") && told[1].contains("steps have a pose"), "{told:?}");

    let read = |name: &str| fs::read_to_string(scene.path("out/scenes/small").join(name)).unwrap();
    assert_eq!(read("tables.md").matches("| mine ").count(), 5, "scores, differences and three gains");
    assert!(read("trajectory.svg").contains("mine") && !read("trajectory.svg").contains("lost"));
    assert!(scene.path("out/scenes/small/0/mine.tum").exists());
    let manifest: serde_json::Value = serde_json::from_str(&read("manifest.json")).unwrap();
    assert!(manifest["trajectories"]["mine"].as_str().is_some_and(|hash| hash.len() == 64));

    let check = || {
        let mut command = scene.on(&["check"], "scene.yaml");
        command.arg("--baseline").arg(scene.path("out"));
        command
    };
    Finished::of(check().arg("--trajectories").arg(&mine).arg("--trajectories").arg(&lost)).expect(0, &[]);
    Finished::of(&mut check()).expect(10, &[]);
}

#[test]
fn where_no_robot_drives_no_trajectory_is_scored() {
    let scene = vantage_tests::root().join("scenes/turntable.yaml");
    let folder = tempfile::tempdir().unwrap();
    let command = || {
        let mut command = vantage_tests::bench();
        command.arg(&scene).args(["--renderer", "reference"]);
        command.arg("--cache").arg(folder.path().join("cache")).arg("--out").arg(folder.path().join("out"));
        command
    };
    Finished::of(command().arg("--trajectories").arg(folder.path())).expect(2, &["no robot drives"]);
    for option in ["--associate", "--online"] {
        Finished::of(command().arg(option)).expect(2, &["no robot drives", option]);
    }
}
