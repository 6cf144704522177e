//! The committed results are of the committed scenes and studies: whoever changes one makes its results again.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use vantage_eval::command::{
    INDEX, MAP_FILE, STUDY_FILE, folders, index, map_pages, pages, scene_table, scenes, study_pages,
};
use vantage_eval::figure::gains::gains_svg;
use vantage_eval::result::kind::ResultKind;
use vantage_eval::result::metric::Metric;
use vantage_eval::result::paired::Paired;
use vantage_eval::result::report::{TABLES as TABLES_FILE, markdown};
use vantage_eval::result::results_file::{FILE_NAME, Results};
use vantage_eval::result::step_errors::STEP_ERRORS;
use vantage_eval::result::summary_text::answer;
use vantage_eval::scene_file::map::MapFile;
use vantage_eval::scene_file::row_name::is_learned;
use vantage_eval::scene_file::study::StudyFile;
use vantage_eval::scene_file::{self, SceneFile};
use vantage_eval::score::consistency::{COLUMNS, CONSISTENCY, COVERAGE, INSIDE};
use vantage_eval::score::online::{self, ONLINE};
use vantage_eval::score::semantics::{self, SEMANTICS};
use vantage_eval::score::trajectory_scores::TRAJECTORIES;
use vantage_eval::score::unseen_table::TABLES;
use vantage_tests::root;

fn files(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|extension| extension == "yaml")).collect()
}

fn results(of: ResultKind, name: &str) -> Option<Results> {
    let folder = of.place(&root().join("results"), name);
    folder.join(FILE_NAME).exists().then(|| Results::read(&folder).unwrap())
}

/// Folders of all committed results.
fn all() -> Vec<PathBuf> {
    let of = |kind| folders(&root().join("results"), kind);
    [of(ResultKind::Scene), of(ResultKind::Study)].concat()
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
        match results(ResultKind::Scene, &file.name) {
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
    assert!(all().len() >= 21, "{:?}", all());
    let of_views = files("studies/views").into_iter().map(|path| scene(&path).0);
    let recorded: Vec<String> =
        of_views.filter(|scene| scene.evaluation.episodes.is_some()).map(|scene| scene.name).collect();
    for folder in all() {
        let (name, results) = (folder.display(), Results::read(&folder).unwrap());
        for table in &TABLES {
            let found = results.table(table.name);
            let metrics = found.map(|stored| stored.metrics());
            // Of recorded episodes there are no single views of unseen instances.
            let expected = (!recorded.contains(&results.scene)).then(|| table.metrics());
            assert_eq!(metrics, expected, "{name}, {}: make its results again", table.name);
        }
        let drives = results.table(TRAJECTORIES).is_some();
        let of_posteriors =
            [(CONSISTENCY, &COLUMNS[..]), (COVERAGE, &INSIDE), (SEMANTICS, &semantics::COLUMNS)];
        for (table, columns) in of_posteriors {
            let metrics = results.table(table).map(|stored| stored.metrics());
            assert_eq!(metrics, drives.then_some(columns), "{name}, {table}: make its results again");
        }
    }
    for results in scenes(&root().join("results")).unwrap() {
        let drives = results.table(TRAJECTORIES).is_some();
        let of_steps = results.table(ONLINE).map(|stored| stored.metrics());
        let remedy = "make its results again with `--online`";
        assert_eq!(of_steps, drives.then_some(&online::COLUMNS[..]), "{}: {remedy}", results.scene);
        let folder = ResultKind::Scene.place(&root().join("results"), &results.scene);
        assert_eq!(folder.join(STEP_ERRORS).exists(), drives, "{}: {remedy}", results.scene);
    }
}

/// Means over seeds, and the most of any, metres.
const SETTLED: (f64, f64) = (0.005, 0.05);

#[test]
fn estimates_after_every_step_settle_where_whole_episodes_have_them() {
    for results in scenes(&root().join("results")).unwrap() {
        let Some(table) = results.table(ONLINE) else { continue };
        for row in table.methods() {
            let runs = table.runs_of(row);
            let apart: Vec<f64> =
                runs.iter().filter_map(|run| run.scores.get(&Metric::ApartSettled).copied()).collect();
            let mean = apart.iter().sum::<f64>() / apart.len() as f64;
            let most = apart.iter().copied().fold(0.0, f64::max);
            let done = runs.iter().filter(|run| run.failure().is_none()).count();
            let told = format!(
                "{}, {row}, {} of {done}: {mean} m, and {most} m at most",
                results.scene,
                apart.len()
            );
            assert!(apart.len() * 50 >= done * 49 && mean <= SETTLED.0 && most <= SETTLED.1, "{told}");
        }
    }
}

#[test]
fn manifests_of_results_name_no_folder_of_a_machine() {
    let maps = folders(&root().join("results"), ResultKind::Map);
    for path in all().into_iter().chain(maps).map(|folder| folder.join("manifest.json")) {
        let text = std::fs::read_to_string(&path).unwrap();
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
        let study: StudyFile = scene_file::read(&path).unwrap();
        let of_scene = scene(&path.with_file_name(&study.scene)).1;
        let Some(results) = results(ResultKind::Study, &study.name) else { continue };
        let scored = study.scored_scene.as_ref().map(|other| scene(&path.with_file_name(other)).1);
        let hash = study
            .hash(&[Some(of_scene), scored].into_iter().flatten().collect::<Vec<_>>().join(" "))
            .unwrap();
        let remedy = format!("{}: run `bench study STUDY --out results`", path.display());
        assert_eq!(results.scene_hash, hash, "{remedy}");
        let folder = ResultKind::Study.place(&root().join("results"), &study.name);
        for (name, bytes) in study_pages(&study, &results).unwrap() {
            assert!(std::fs::read(folder.join(name)).unwrap() == bytes, "{name}: {remedy}");
        }
        if folder.join(STUDY_FILE).exists() {
            let run: StudyFile = scene_file::read(&folder.join(STUDY_FILE)).unwrap();
            assert_eq!(run, study, "{remedy}");
        }
    }
}

#[test]
fn results_of_maps_are_of_the_maps_as_they_are_and_are_drawn_so() {
    assert!(!files("maps").is_empty());
    for path in files("maps") {
        let map: MapFile = scene_file::read(&path).unwrap();
        let of_scene = scene(&path.with_file_name("").join(&map.scene)).1;
        let Some(results) = results(ResultKind::Map, &map.name) else { continue };
        let remedy = format!("{}: run `bench map MAP --out results`", path.display());
        assert_eq!(results.scene_hash, map.hash(&of_scene).unwrap(), "{remedy}");
        let folder = ResultKind::Map.place(&root().join("results"), &map.name);
        let run: MapFile = scene_file::read(&folder.join(MAP_FILE)).unwrap();
        assert_eq!(run, map, "{remedy}");
        for (name, bytes) in map_pages(&map, &results).unwrap() {
            let today = std::fs::read(folder.join(name)).unwrap() == bytes;
            assert!(today, "{}, {name}: run `bench index results`", folder.display());
        }
    }
}

#[test]
fn scenes_that_serve_studies_and_maps_alone_are_scenes() {
    let views = files("studies/views");
    for path in &views {
        let (file, hash) = scene(path);
        let Some(results) = results(ResultKind::Scene, &file.name)
            .filter(|_| !files("scenes").iter().any(|other| other.file_name() == path.file_name()))
        else {
            continue;
        };
        assert_eq!(results.scene_hash, hash, "{}: run `bench SCENE --out results`", path.display());
    }
    assert_eq!(views.len(), 20);
}

#[test]
fn tables_are_those_of_the_raw_scores_beside_them_and_nothing_else_is_a_table() {
    for folder in all() {
        let results = Results::read(&folder).unwrap();
        let manifest: Value =
            serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap();
        let shown = std::fs::read_to_string(folder.join(TABLES_FILE)).unwrap();
        let (model, caveat) = (manifest["model_hash"].as_str(), manifest["caveat"].as_str());
        let of_today = shown == markdown(&results, model, caveat);
        assert!(of_today, "{}: run `bench index results`", folder.display());
        let known =
            [TABLES_FILE, "README.md", "variants.md", STUDY_FILE, FILE_NAME, "manifest.json", STEP_ERRORS];
        for entry in std::fs::read_dir(&folder).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let picture = name.ends_with(".svg") || name.ends_with(".png");
            // The trajectories of a run here, and how long its steps took, and its page, which are not committed.
            let of_seed = name.bytes().all(|byte| byte.is_ascii_digit())
                || ["association_times.md", "step_times.md", "report.html"].contains(&name.as_str());
            assert!(picture || of_seed || known.contains(&name.as_str()), "{}: {name}", folder.display());
        }
    }
}

#[test]
fn gains_are_those_of_the_raw_scores_beside_them() {
    for folder in folders(&root().join("results"), ResultKind::Scene) {
        let results = Results::read(&folder).unwrap();
        let Some(table) = results.table("trajectory") else { continue };
        let learned = table.methods().iter().filter(|method| is_learned(method));
        let gains: Vec<(&str, Paired)> =
            learned.map(|method| (method.as_str(), table.paired(method, Metric::Ate).unwrap())).collect();
        let drawn = gains_svg(&results.scene, table.reference().unwrap(), &gains).unwrap();
        let committed = std::fs::read_to_string(folder.join("gains.svg")).unwrap();
        assert!(drawn == committed, "{}: run `bench SCENE --out results`", folder.display());
    }
}

#[test]
fn the_index_and_the_table_of_the_readme_are_those_of_the_results() {
    let results = root().join("results");
    let committed = std::fs::read_to_string(results.join(INDEX)).unwrap();
    assert!(committed == index(&results).unwrap(), "run `bench index results`");
    let scenes = scenes(&results).unwrap();
    for (name, today) in pages(&scenes) {
        let committed = std::fs::read_to_string(results.join(name)).ok();
        assert!(committed.is_some() && committed == today, "{name}: run `bench index results`");
    }
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let (_, after) = readme.split_once("<!-- results: begin -->\n").unwrap();
    let (block, _) = after.split_once("<!-- results: end -->").unwrap();
    let table = scene_table(&results, "results/").unwrap();
    assert!(
        block == table,
        "put what `bench index results` prints between the markers of README.md:\n{table}"
    );
}

#[test]
fn only_the_gains_on_which_seeds_agree_are_told() {
    let said = |name: &str| {
        let results = results(ResultKind::Scene, name).unwrap();
        let table = results.tables.iter().find(|table| table.name() == TRAJECTORIES).unwrap();
        let learned = table.methods().iter().find(|method| is_learned(method)).unwrap();
        answer(table, learned).unwrap()
    };
    for (scene, expected) in [
        ("sparse_loop", "lowers the mean ATE of geometric by 0.0891 m"),
        ("sparse_loop_predictive", "lowers the mean ATE of geometric by 0.0807 m"),
        ("sparse_loop_noisy", "the seeds disagree"),
        ("corridor", "holds 0"),
    ] {
        assert!(said(scene).contains(expected), "{scene}: {}", said(scene));
    }
}

/// Where objects are ellipsoids, the control has headings that bend their outlines, and differs.
#[test]
fn controls_equal_geometry_on_every_seed() {
    let mut compared = 0;
    for results in scenes(&root().join("results")).unwrap() {
        let Some(table) = results.table(TRAJECTORIES) else { continue };
        if !table.methods().iter().any(|method| method == "uninformative")
            || table.metrics().contains(&Metric::Extents)
        {
            continue;
        }
        for (control, geometric) in table.runs_of("uninformative").iter().zip(table.runs_of("geometric")) {
            let [control, other] = [control, geometric].map(|run| run.scores.get(&Metric::Ate).copied());
            let apart = control.zip(other).map(|(control, other)| (control - other).abs());
            assert!(apart.is_none_or(|apart| apart < 1e-3), "{}, seed {}", results.scene, geometric.seed.0);
            compared += usize::from(apart.is_some());
        }
    }
    assert!(compared > 400, "{compared} seeds compared");
}
