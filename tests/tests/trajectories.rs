//! `bench SCENE --trajectories DIR`: somebody else's estimator, beside ours.

use std::fs;
use vantage_eval::metric::Metric;
use vantage_eval::results::Results;
use vantage_eval::table::{Outcome, Run};
use vantage_tests::{Finished, SmallScene};

const OF_POSES: [Metric; 5] =
    [Metric::Ate, Metric::AteUmeyama, Metric::Heading, Metric::RpeTranslation, Metric::RpeRotation];

#[test]
fn trajectories_of_another_are_scored_as_ours_are_and_missing_ones_are_told() {
    let scene = SmallScene::new(&[]);
    scene.run().expect(0, &[]);
    let mine = scene.path("mine");
    fs::create_dir(&mine).unwrap();
    let entered = || Finished::of(scene.command().arg("--trajectories").arg(&mine));
    entered().expect(2, &["mine", "expected 0.tum"]);
    fs::copy(scene.path("out/small/1/odometry.tum"), mine.join("1.tum")).unwrap();
    entered().expect(0, &[]);

    let results = Results::read(&scene.path("out/small")).unwrap();
    let table = results.tables.iter().find(|table| table.name() == "trajectory").unwrap();
    let runs = |method: &str| -> Vec<&Run> { table.runs().filter(|run| run.method == method).collect() };
    let (theirs, ours) = (runs("mine"), runs("odometry"));
    assert_eq!(theirs.len(), 2);
    assert_eq!(theirs[0].outcome, Outcome::Failed("no 0.tum".into()));
    assert_eq!(theirs[1].outcome, Outcome::Done);
    for metric in OF_POSES {
        assert!(theirs[1].scores[&metric] > 0.0, "{metric:?}");
        assert_eq!(theirs[1].scores[&metric], ours[1].scores[&metric], "{metric:?}");
    }
    let tables = fs::read_to_string(scene.path("out/small/tables.md")).unwrap();
    assert!(tables.contains("| mine "), "{tables}");
}

#[test]
fn where_no_robot_drives_no_trajectory_is_scored() {
    let scene = vantage_tests::root().join("scenes/turntable.yaml");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("0.tum"), "0 0 0 0 0 0 0 1\n").unwrap();
    let mut command = vantage_tests::bench();
    command.arg(scene).args(["--renderer", "reference", "--trajectories"]).arg(folder.path());
    command.arg("--cache").arg(folder.path().join("cache")).arg("--out").arg(folder.path().join("out"));
    Finished::of(&mut command).expect(2, &["no robot drives"]);
}
