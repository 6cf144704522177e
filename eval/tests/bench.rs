//! The `bench` program from outside.

use std::process::{Command, Output, Stdio};

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bench")).args(arguments).output().expect("bench starts")
}

#[test]
fn schema_prints_json_and_nothing_else() {
    let output = bench(&["schema"]);
    assert_eq!(output.status.code(), Some(0));
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(schema["title"], "SceneFile");
    assert!(output.stderr.is_empty());
}

#[test]
fn wrong_arguments_end_with_2_and_help() {
    for arguments in [&[][..], &["--nonsense"], &["schema", "extra"]] {
        let output = bench(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("Usage"), "{arguments:?}");
    }
}

#[test]
fn a_misspelt_command_before_a_scene_is_hinted_at() {
    let output = bench(&["datset", "scenes/tabletop.yaml", "--out", "nowhere"]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("`bench --help` lists the commands"), "{message}");
}

#[test]
fn numbers_of_seeds_out_of_range_are_told_the_range() {
    for (number, command) in [("0", "check"), ("-1", "check"), ("-1", "dataset")] {
        let output = bench(&[command, "scenes/tabletop.yaml", "--seeds", number]);
        assert_eq!(output.status.code(), Some(2));
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(message.contains(&format!("{number} is not in 1..=")), "{message}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_ends_with_6() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_bench"))
        .arg("schema")
        .stdout(full)
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert_eq!(child.status.code(), Some(6));
    assert!(String::from_utf8_lossy(&child.stderr).contains("standard output"));
}
