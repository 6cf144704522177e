//! `bench look --rerun`: an episode as a Rerun file, where the program was built for it.

use std::path::Path;
use std::process::{Command, Output};

fn look(folder: &Path, recording: &Path) -> Output {
    let scene = folder.join("scene.yaml");
    std::fs::write(&scene, include_str!("../../tests/cases/small.yaml")).expect("a scene file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_bench"));
    command.arg("look").arg(scene).args(["--renderer", "reference", "--out"]).arg(folder.join("look.png"));
    command.arg("--rerun").arg(recording).output().expect("bench starts")
}

#[test]
#[cfg(feature = "rerun")]
fn an_episode_becomes_a_rerun_file() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("deep/small.rrd");
    let output = look(folder.path(), &recording);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let bytes = std::fs::read(&recording).unwrap();
    assert!(bytes.starts_with(b"RRF"), "{:?}", &bytes[..8]);
    // Twelve images alone have as much.
    assert!(bytes.len() > 200_000, "{} bytes", bytes.len());
    let names: Vec<_> = std::fs::read_dir(folder.path().join("deep"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(names, ["small.rrd"]);
    let output = look(folder.path(), &folder.path().join("scene.yaml/small.rrd"));
    assert_eq!(output.status.code(), Some(6), "{output:?}");
}

#[test]
#[cfg(not(feature = "rerun"))]
fn without_the_feature_it_is_said_how_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let output = look(folder.path(), &folder.path().join("small.rrd"));
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("--features rerun"), "{output:?}");
    assert!(!folder.path().join("look.png").exists());
}
