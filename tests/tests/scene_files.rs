//! The shipped scenes: the schema beside them is current, holds for each, and each names it.

use std::fs;
use std::path::Path;
use vantage_eval::progress::Progress;
use vantage_eval::scene_file::{SceneFile, hash, parse, read};
use vantage_tests::{Finished, bench, root};

const SCHEMA: &str = "scenes/scene.schema.json";

#[test]
fn the_committed_schema_is_current() {
    let printed = Finished::of(bench().arg("schema"));
    let committed = fs::read_to_string(root().join(SCHEMA)).unwrap();
    assert!(printed.stdout == committed, "run `cargo run --release --bin bench schema > {SCHEMA}`");
}

#[test]
fn the_scene_of_the_docs_is_one() {
    let docs = fs::read_to_string(root().join("docs/scenes.md")).unwrap();
    let start = docs.find("```yaml\n# yaml-language-server").unwrap() + "```yaml\n".len();
    let scene = docs[start..].split("```").next().unwrap();
    let file: SceneFile = parse(scene, &root().join("scenes/mine.yaml")).unwrap();
    let tabletop: SceneFile = read(&root().join("scenes/tabletop.yaml")).unwrap();
    let conditions = |file: &SceneFile| {
        let path = root().join("scenes/mine.yaml");
        file.checked(&path, Path::new(""), &Progress::detect()).unwrap().view_conditions()
    };
    assert_eq!(
        hash(&conditions(&file)).unwrap(),
        hash(&conditions(&tabletop)).unwrap(),
        "it shares the model"
    );
}

#[test]
fn each_path_and_surface_of_the_docs_fits_the_schema() {
    let schema = serde_json::from_str(&fs::read_to_string(root().join(SCHEMA)).unwrap()).unwrap();
    let validator = jsonschema::draft7::new(&schema).unwrap();
    let docs = fs::read_to_string(root().join("docs/scenes.md")).unwrap();
    let scene: serde_json::Value =
        serde_saphyr::from_str(&fs::read_to_string(root().join("scenes/tabletop.yaml")).unwrap()).unwrap();
    for (title, part, field, count) in
        [("| surface |", "world", "surface", 4), ("| path |", "robot", "path", 10)]
    {
        let rows = docs[docs.find(title).unwrap()..].lines().skip(2);
        let examples: Vec<&str> = rows.map_while(|row| row.strip_prefix("| `")?.split('`').next()).collect();
        assert_eq!(examples.len(), count, "{title} {examples:?}");
        for example in examples {
            let mut scene = scene.clone();
            scene[part][field] = serde_saphyr::from_str(example).unwrap();
            let errors: Vec<String> = validator.iter_errors(&scene).map(|error| error.to_string()).collect();
            assert!(errors.is_empty(), "{example}: {errors:?}");
        }
    }
}

#[test]
fn every_scene_names_the_schema_and_fits_it() {
    let schema = serde_json::from_str(&fs::read_to_string(root().join(SCHEMA)).unwrap()).unwrap();
    let validator = jsonschema::draft7::new(&schema).unwrap();
    let mut scenes = 0;
    for entry in fs::read_dir(root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "yaml") {
            continue;
        }
        scenes += 1;
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("# yaml-language-server: $schema=scene.schema.json"), "{}", path.display());
        let scene: serde_json::Value = serde_saphyr::from_str(&text).unwrap();
        let errors: Vec<String> = validator.iter_errors(&scene).map(|error| error.to_string()).collect();
        assert!(errors.is_empty(), "{}: {errors:?}", path.display());
        let mut broken = scene.clone();
        broken["world"]["objects"] = "many".into();
        assert!(!validator.is_valid(&broken));
    }
    assert!(scenes >= 2);
}
