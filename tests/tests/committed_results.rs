//! The committed results are of the committed scenes and studies: whoever changes one makes its results again.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use vantage_eval::result::report::{TABLES as TABLES_FILE, markdown};
use vantage_eval::result::results_file::{FILE_NAME, Results};
use vantage_eval::result::table_text::csv;
use vantage_eval::scene_file::study::StudyFile;
use vantage_eval::scene_file::{self, SceneFile};
use vantage_eval::score::unseen_table::TABLES;
use vantage_tests::root;

fn files(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|extension| extension == "yaml")).collect()
}

fn results(name: &str) -> Option<Results> {
    let folder = root().join("results").join(name);
    folder.join(FILE_NAME).exists().then(|| Results::read(&folder).unwrap())
}

fn scene(path: &Path) -> (SceneFile, String) {
    let file: SceneFile = scene_file::read(path).unwrap();
    let hash = scene_file::hash(&file).unwrap();
    (file, hash)
}

#[test]
fn every_scene_with_a_path_has_results_that_are_of_it() {
    assert!(files("scenes").len() >= 9 && files("studies").len() >= 4);
    for path in files("scenes") {
        let (file, hash) = scene(&path);
        match results(&file.name) {
            Some(results) => {
                assert_eq!(results.scene_hash, hash, "{}: run `bench SCENE --out results`", path.display())
            }
            None => {
                assert!(file.robot.path.stations(), "{}: run `bench SCENE --out results`", path.display())
            }
        }
    }
}

#[test]
fn results_have_all_scores_that_a_run_has_today() {
    let mut seen = 0;
    for entry in std::fs::read_dir(root().join("results")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Some(results) = results(&name) else { continue };
        seen += 1;
        for table in &TABLES {
            let found = results.tables.iter().find(|stored| stored.name() == table.name);
            let metrics = found.map(|stored| stored.metrics());
            assert_eq!(metrics, Some(table.metrics()), "{name}, {}: make its results again", table.name);
        }
    }
    assert!(seen >= 9, "{seen} results");
}

#[test]
fn manifests_of_results_name_no_folder_of_a_machine() {
    for entry in std::fs::read_dir(root().join("results")).unwrap() {
        let path = entry.unwrap().path().join("manifest.json");
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        let manifest: Value = serde_json::from_str(&text).unwrap();
        let words = manifest["command"].as_array().unwrap().iter();
        let words = words.chain([&manifest["options"]["cache"]]).map(|word| word.as_str().unwrap());
        let absolute: Vec<&str> = words.filter(|word| Path::new(word).is_absolute()).collect();
        assert!(absolute.is_empty(), "{}: {absolute:?}", path.display());
    }
}

#[test]
fn results_of_studies_are_of_the_studies_as_they_are() {
    for path in files("studies") {
        // The scene that studies share lies beside them.
        let Ok(study) = scene_file::read::<StudyFile>(&path) else {
            scene(&path);
            continue;
        };
        let of_scene = scene(&path.with_file_name(&study.scene)).1;
        let Some(results) = results(&study.name) else { continue };
        let hash = scene_file::hash(&(&study, &of_scene)).unwrap();
        assert_eq!(results.scene_hash, hash, "{}: run `bench study STUDY --out results`", path.display());
    }
}

#[test]
fn tables_and_rows_are_those_of_the_results_beside_them() {
    let folders = std::fs::read_dir(root().join("results")).unwrap().map(|entry| entry.unwrap().path());
    for folder in folders.filter(|folder| folder.is_dir()) {
        let results = Results::read(&folder).unwrap();
        let manifest: Value =
            serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap();
        let shown = std::fs::read_to_string(folder.join(TABLES_FILE)).unwrap();
        assert!(
            shown == markdown(&results, manifest["model_hash"].as_str(), manifest["caveat"].as_str()),
            "{}",
            folder.display()
        );
        for table in &results.tables {
            let rows = std::fs::read(folder.join(format!("{}.csv", table.name()))).unwrap();
            assert!(rows == csv(table).unwrap(), "{}, {}", folder.display(), table.name());
        }
    }
}
