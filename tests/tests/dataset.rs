//! `bench dataset`: episodes as files, taken up after an interruption, the same bytes as without one.

use std::fs;
use vantage_tests::{Finished, SmallScene, bench};

#[test]
fn a_dataset_is_resumed_to_the_same_bytes() {
    let scene = SmallScene::new(&[]);
    let write = |name: &str| {
        let mut command = bench();
        command.arg("dataset").arg(scene.path("scene.yaml")).args(["--renderer", "reference", "--out"]);
        Finished::of(command.arg(scene.path(name)))
    };
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
    for seed in ["0", "1"] {
        let manifest = |name: &str| fs::read(scene.path(name).join(seed).join("manifest.json")).unwrap();
        assert_eq!(manifest("a"), manifest("b"));
    }
}

#[test]
fn trajectories_and_pose_graphs_are_those_of_the_episodes() {
    let scene = SmallScene::new(&[]);
    let mut command = bench();
    command.arg("dataset").arg(scene.path("scene.yaml")).args(["--renderer", "reference"]);
    command.args(["--format", "vantage,tum,g2o", "--seeds", "1", "--out"]).arg(scene.path("d"));
    Finished::of(&mut command).expect(0, &[]);
    let read = |name: &str| fs::read_to_string(scene.path("d").join(name)).unwrap();
    assert_eq!(read("tum/0/truth.tum"), read("0/truth/robot.tum"));
    let steps = read("tum/0/odometry.tum").lines().filter(|line| !line.starts_with('#')).count();
    let graph = read("g2o/0.g2o");
    let lines_of = |tag: &str| graph.lines().filter(|line| line.starts_with(tag)).count();
    assert_eq!((lines_of("VERTEX_SE3:QUAT "), lines_of("EDGE_SE3:QUAT ")), (steps, steps - 1));
    assert!(graph.lines().filter(|line| line.starts_with("EDGE")).all(|line| line.split(' ').count() == 31));
}
