//! `bench models`: what a model folder is, or why it is none.

use std::fs;
use std::path::Path;
use vantage_tests::{Finished, SmallScene, bench, root};

#[test]
fn the_committed_model_is_described() {
    let told = Finished::of(bench().args(["models", "models/objects"]));
    told.expect(0, &[]);
    for words in [
        "viewpoint_dependent",
        "68 numbers: 48 that do not turn, 10 pairs that do",
        "azimuth_harmonics",
        "decoder_jacobian",
        "d_conditioning [16, 14]",
        "127984 views of 8000 instances",
    ] {
        assert!(told.stdout.contains(words), "{words:?} is not in {}", told.stdout);
    }
}

#[test]
fn faults_are_told_with_their_place_and_end_with_5() {
    let scene = SmallScene::new(&[]);
    let models = |name: &str| Finished::of(bench().arg("models").arg(scene.path(name)));
    models("missing").expect(2, &["no folder"]);
    Finished::of(bench().arg("models")).expect(2, &["DIR"]);

    let manifest = fs::read_to_string(root().join("models/objects/model.yaml")).expect("the committed model");
    for (name, old, new, words) in [
        ("key", "measurement: 16", "mesurement: 16", ["model.yaml:", "mesurement"]),
        ("type", "dimension: 68", "dimension: many", ["model.yaml:", "dimension"]),
        (
            "convention",
            "azimuth_harmonics",
            "camera_motion",
            ["conditioning is camera_motion", "azimuth_harmonics"],
        ),
        ("escape", "file: encoder.onnx", "file: ../encoder.onnx", ["graphs.encoder.file", "../encoder.onnx"]),
        ("version", "version: 2", "version: 1", ["version 1", "version 2"]),
    ] {
        assert!(manifest.contains(old), "{old}");
        fs::create_dir(scene.path(name)).expect("a folder");
        fs::write(scene.path(name).join("model.yaml"), manifest.replacen(old, new, 1)).expect("a manifest");
        models(name).expect(5, &words);
    }
    let folders = [scene.path("key"), root().join("models/objects"), scene.path("version")];
    let all = Finished::of(bench().arg("models").args(folders));
    all.expect(5, &["mesurement", "version 1"]);
    assert!(all.stdout.contains("azimuth_harmonics") && all.stdout.matches("refused:").count() == 2);
    assert!(!all.stdout.contains("mesurement"), "a reason is told once: {}", all.stdout);
}

/// The small scene with a model of its own, hardly trained.
fn with_objective(objective: &str) -> SmallScene {
    with_objective_and(objective, &[])
}

/// Likewise, with other changes.
fn with_objective_and(objective: &str, others: &[(&str, &str)]) -> SmallScene {
    let model = format!(
        "training:\n  seed: 1\n  model: {{ objective: {objective}, trunk_steps: 2, steps: 2, batch: 4, \
         trunk_batch: 16, measurement_dim: 8, latent_dim: 30, pairs_per_harmonic: 2 }}"
    );
    let odometry = "occluder_probability: 0.5\n  odometry: { translation_per_metre: 0.03, rotation_deg_per_metre: 3, \
                    rotation_per_radian: 0.02, out_of_plane: 0.1, bias_translation_per_metre: 0, \
                    bias_rotation_deg_per_metre: 0 }";
    let changes = [
        ("training:\n  seed: 1", &model[..]),
        ("  reference:", "  # reference:"),
        ("occluder_probability: 0.5", odometry),
    ];
    SmallScene::new(&[&changes, others].concat())
}

#[test]
fn a_predictive_model_makes_the_semantic_rows_under_its_own_name() {
    let scene = with_objective("viewpoint_predictive");
    scene.run().expect(0, &[]);
    let tables = fs::read_to_string(scene.path("out/scenes/small/tables.md")).expect("tables");
    assert!(tables.matches("| viewpoint_predictive").count() > 5, "{tables}");
    assert!(!tables.contains("viewpoint_dependent"), "{tables}");
    assert!(scene.path("out/scenes/small/0/viewpoint_predictive.tum").exists());
}

const PAIRS: (&str, &str) = ("estimator: {}", "estimator: { rows: [geometric, viewpoint_pairs] }");

#[test]
fn pairs_of_views_are_a_row_of_predictive_models_alone() {
    let scene = SmallScene::new(&[PAIRS, ("models/objects", "models/predictive")]);
    scene.run().expect(0, &[]);
    let tables = fs::read_to_string(scene.path("out/scenes/small/tables.md")).expect("tables");
    assert!(tables.matches("| viewpoint_pairs").count() > 2, "{tables}");
    let calibrated = Finished::of(scene.on(&["calibrate"], "scene.yaml").arg("2"));
    calibrated.expect(0, &[]);
    assert!(calibrated.stdout.contains("pairs, chain"), "{}", calibrated.stdout);
    SmallScene::new(&[PAIRS]).run().expect(2, &["row viewpoint_pairs", "--model", "leave the row out"]);
    let of = |models: [&str; 2]| {
        let mut command = scene.command();
        let models = models.map(|name| root().join("models").join(name));
        Finished::of(models.iter().fold(&mut command, |command, folder| command.arg("--model").arg(folder)))
    };
    of(["predictive", "objects"]).expect(0, &[]);
    let tables = fs::read_to_string(scene.path("out/scenes/small/tables.md")).expect("tables");
    assert!(tables.contains("| viewpoint_pairs") && tables.contains("| objects "), "{tables}");
    of(["objects", "predictive"]).expect(2, &["row viewpoint_pairs"]);
}

#[test]
fn yaws_are_scored_of_a_model_that_shares_the_frames_of_truth_alone() {
    for (frames, shares) in [("canonical", true), ("random", false), ("none", false)] {
        let objective = format!("viewpoint_dependent, frames: {frames}");
        let scene = with_objective(&objective);
        scene.run().expect(0, &[]);
        let results = fs::read_to_string(scene.path("out/scenes/small/results.json")).expect("results");
        let results: serde_json::Value = serde_json::from_str(&results).expect("JSON");
        let tables = results["tables"].as_array().expect("tables");
        let runs = tables.iter().flat_map(|table| table["runs"].as_array().expect("runs"));
        let scores: Vec<_> = runs.filter(|run| run["method"] == "viewpoint_dependent").collect();
        assert!(scores.iter().any(|run| run["scores"]["ate"].is_number()), "{frames}: {scores:?}");
        for score in ["object_orientation", "nees_object_yaw"] {
            let has = scores.iter().any(|run| run["scores"][score].is_number());
            assert_eq!(has, shares, "{score} of {frames}: {scores:?}");
        }
    }
}

#[test]
fn a_scene_that_would_train_a_model_of_single_views_is_refused_before_it_does_where_a_row_reads_pairs() {
    let told = ["row viewpoint_pairs", "objective to viewpoint_predictive", "estimator.rows"];
    with_objective_and("viewpoint_dependent", &[PAIRS]).run().expect(2, &told);
}

#[test]
fn a_model_that_is_named_bears_its_folders_name_which_no_other_row_has() {
    let scene = with_objective("viewpoint_dependent");
    scene.run().expect(0, &[]);
    let mut trained = fs::read_dir(scene.path("cache/entries/model")).expect("the trained model");
    let trained = trained.next().expect("a model").expect("a folder").path();
    let named = |name: &str| {
        let folder = scene.path(name);
        fs::create_dir(&folder).expect("a folder");
        for file in fs::read_dir(&trained).expect("the model").map(|file| file.expect("a file")) {
            if file.path().is_file() {
                fs::copy(file.path(), folder.join(file.file_name())).expect("a copy");
            }
        }
        Finished::of(scene.command().arg("--model").arg(&folder))
    };
    named("mine").expect(0, &[]);
    let tables = fs::read_to_string(scene.path("out/scenes/small/tables.md")).expect("tables");
    assert!(tables.matches("| mine").count() > 5, "{tables}");
    assert!(!tables.contains("viewpoint_dependent"), "{tables}");
    assert!(scene.path("out/scenes/small/0/mine.tum").exists());
    for taken in ["geometric", "pixels_pca64", "truth"] {
        named(taken).expect(2, &["--model", taken, "rename the folder"]);
    }
    let mut both = scene.command();
    both.arg("--model").arg(scene.path("mine")).arg("--model").arg(scene.path("my_other"));
    fs::rename(scene.path("truth"), scene.path("my_other")).expect("another name");
    Finished::of(&mut both).expect(0, &[]);
    for name in ["mine", "my_other"] {
        let tables = fs::read_to_string(scene.path("out/scenes/small/tables.md")).expect("tables");
        assert!(tables.matches(&format!("| {name} ")).count() > 5, "{tables}");
        assert!(scene.path(&format!("out/scenes/small/1/{name}.tum")).exists());
    }
    named("my model").expect(2, &["--model", "letters, digits", "rename the folder"]);
}

#[test]
fn an_embedding_is_of_no_use_to_the_estimator_but_its_latents_are_drawn() {
    let scene = with_objective("contrastive");
    scene.run().expect(2, &["training.model", "viewpoint_dependent"]);
    assert!(!scene.path("cache/entries/model").exists(), "it is refused before it is trained");
    let mut figures = scene.on(&["figures"], "scene.yaml");
    Finished::of(figures.arg("--out").arg(scene.path("pictures"))).expect(
        0,
        &[
            "one is trained first",
            "--model",
            "training a model of small, in 2 and 2 steps",
            "no predictions.png",
        ],
    );
    assert!(scene.path("pictures/latents.png").exists());
    assert!(!scene.path("pictures/viewpoints.png").exists());
    let mut trained = fs::read_dir(scene.path("cache/entries/model")).expect("the trained model");
    let trained = trained.next().expect("a model").expect("a folder").path();
    let mut command = scene.command();
    Finished::of(command.arg("--model").arg(&trained)).expect(2, &["kind embedding", "bench figures"]);

    let scored_study = |scored: &str, folder: &Path, more: &str| {
        let mine = format!("{{ name: mine, note: trained elsewhere, folder: {folder:?}{more} }}");
        scene.study("others", &format!("scored: {scored}\nseeds: 2\nvariants:\n  - {mine}\n"))
    };
    let study = |folder: &Path, more: &str| scored_study("test", folder, more);
    for scored in ["validation", "known"] {
        scored_study(scored, &trained, "")
            .expect(2, &["variant mine", "test instances alone", "leave out `scored`"]);
    }
    study(&trained, ", instances: 3").expect(2, &["variant mine", "folder"]);
    study(Path::new("nowhere"), "").expect(2, &["no folder", "nowhere"]);
    study(&trained, "").expect(0, &[]);
    let tables = fs::read_to_string(scene.path("out/studies/others/tables.md")).expect("the tables");
    assert!(tables.contains("| mine ") && tables.contains("| pixels_pca64"), "{tables}");
    let manifest = fs::read_to_string(scene.path("out/studies/others/manifest.json")).expect("the manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    let hash = vantage_learn::Model::load(&trained).expect("the model").hash().to_owned();
    assert_eq!(manifest["model_hashes"], serde_json::json!({ "mine": hash }));
}

#[test]
fn a_training_overwrites_no_files_of_others() {
    let scene = with_objective("viewpoint_dependent");
    let train =
        |out: &str| Finished::of(scene.on(&["train"], "scene.yaml").arg("--out").arg(scene.path(out)));
    let write = |name: &str, text: &str| fs::write(scene.path(name), text).expect("a file");
    fs::create_dir(scene.path("d")).expect("a folder");
    write("d/loss.csv", "mine");
    write("d/train.log", "begun");
    train("d").expect(2, &["already holds something else", "--out"]);
    assert_eq!(fs::read_to_string(scene.path("d/loss.csv")).expect("the file"), "mine");
    write("d/loss.csv", "stage,step,loss,azimuth\ntrunk,1,NaN,NaN\n");
    train("d").expect(0, &[]);
    assert_eq!(fs::read_to_string(scene.path("d/train.log")).expect("the file"), "begun");
    let again = train("d");
    again.expect(2, &["model.yaml", "exists"]);
    assert!(!again.stderr.contains("train views"), "it is refused before views are made: {}", again.stderr);
}

#[test]
fn a_training_that_diverges_is_a_failed_run_of_its_study() {
    let scene = with_objective("viewpoint_dependent");
    let study = |variants: &str| scene.study("failing", &format!("seeds: 1\nvariants:\n{variants}"));
    let bad = "  - { name: bad, note: diverges, model: { learning_rate: 1, trunk_steps: 60, steps: 60 } }\n";
    let finished = study(&format!("{bad}  - {{ name: good, note: does not }}\n"));
    finished.expect(0, &["bad with seed 1 failed", "lower the learning rate"]);
    let tables = fs::read_to_string(scene.path("out/studies/failing/tables.md")).expect("the tables");
    assert!(tables.contains("| good ") && tables.contains("1 (1 failed)"), "{tables}");
    study(bad).expect(4, &["failed"]);
}

#[test]
fn a_study_of_known_instances_scores_views_that_it_holds_out() {
    let scene = with_objective("viewpoint_dependent");
    let study = |variant: &str| {
        let all = "scored: known\nseeds: 1\nvariants:\n  - { name: all, note: all instances }\n";
        scene.study("known", &(all.to_owned() + variant))
    };
    study("  - { name: three, note: fewer, instances: 3 }\n").expect(2, &["variant three", "first 4"]);
    study("").expect(0, &[]);
    let told = fs::read_to_string(scene.path("out/studies/known/variants.md")).expect("the variants");
    assert!(told.contains("held-out views of training instances"), "{told}");
    let tables = fs::read_to_string(scene.path("out/studies/known/tables.md")).expect("the tables");
    assert!(tables.contains("| all "), "{tables}");

    let text = fs::read_to_string(scene.path("scene.yaml")).expect("the scene");
    let short = text.replace("views_per_instance: 8", "views_per_instance: 6");
    fs::write(scene.path("scene.yaml"), short).expect("the scene");
    study("").expect(2, &["views_per_instance", "instance 0"]);
}
