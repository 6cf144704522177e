//! The committed models are those that the shipped scenes describe.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

use std::io::Write;
use std::path::{Path, PathBuf};
use vantage_dataset::Split;
use vantage_eval::pipeline::{Pipeline, RendererChoice, VIEW_CONDITIONS, views};
use vantage_eval::progress::Progress;
use vantage_eval::result::manifest::Host;
use vantage_eval::scene_file::{self, SceneFile};
use vantage_learn::{Manifest, Model, view_set_hash};
use vantage_tests::root;

fn scenes() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("scenes")).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|extension| extension == "yaml")).collect()
}

fn manifest(scene: &Path, file: &SceneFile) -> Option<Manifest> {
    let folder = scene.parent()?.join(file.training.reference.as_ref()?);
    Some(Model::load(&folder).unwrap().manifest().clone())
}

#[test]
fn they_were_trained_as_every_scene_says() {
    let mut compared = 0;
    for path in scenes() {
        let file: SceneFile = scene_file::read(&path).unwrap();
        let Some(Manifest { training, .. }) = manifest(&path, &file) else { continue };
        let mut conditions =
            file.checked(&path, Path::new(""), &Progress::detect()).unwrap().view_conditions();
        if file.name == "sparse_loop_noisy" {
            assert!(conditions.camera.image.take().is_some() && conditions.detector.faults.take().is_some());
        }
        let conditions = scene_file::hash(&conditions).unwrap();
        assert_eq!(training.provenance[VIEW_CONDITIONS], conditions, "{}: train it again", path.display());
        let details = training.details.unwrap();
        assert_eq!((&details.spec, details.seed), (&file.training.model, file.training.seed));
        compared += 1;
    }
    assert!(compared > 0);
}

#[test]
fn their_validation_views_are_those_rendered_here() {
    assert_rendered_alike(Split::Validation);
}

#[test]
#[ignore = "renders all views of the trainings: minutes"]
fn their_training_views_are_those_rendered_here() {
    assert_rendered_alike(Split::Train);
}

/// One scene for each reference model: views are the same to the bit on one processor, adapter and driver only.
fn assert_rendered_alike(split: Split) {
    for scene in ["scenes/tabletop.yaml", "scenes/sparse_loop_predictive.yaml"] {
        let path = root().join(scene);
        let cache = tempfile::tempdir().unwrap();
        let pipeline = Pipeline::open(&path, cache.path(), RendererChoice::Auto).unwrap();
        let training = manifest(&path, &pipeline.file).unwrap().training;
        let (renderer, there) = (pipeline.renderer_info.clone(), &training.provenance);
        let cpu = Host::this().cpu.unwrap_or_default();
        let facts = [("adapter", renderer.adapter), ("driver", renderer.driver), ("cpu", cpu)];
        if let Some((what, here)) = facts.iter().find(|(what, here)| there[*what] != *here) {
            let told = format!("SKIPPED: {scene} was rendered on {what} {:?}, not {here:?}\n", there[*what]);
            // Not through the harness, which would hide it.
            std::io::stderr().write_all(told.as_bytes()).unwrap();
            continue;
        }
        let details = training.details.unwrap();
        let hash = if split == Split::Train { &training.data_hash } else { &details.validation_hash };
        let (set, _) = views(&pipeline, split, details.seed, &mut |_| ()).unwrap();
        assert_eq!(view_set_hash(&set), *hash, "{scene}, {}: train the model again", split.name());
    }
}
