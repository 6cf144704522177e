//! Training: it learns, it survives a kill, and it refuses what it must.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod support;

use support::{
    synthetic, tiny_model, tiny_spec, tiny_training, trained, training_views, validation_views,
    viewpoint_model,
};
use vantage_dataset::{Crop, Split, ViewSet};
use vantage_learn::{
    CHECKPOINT, CURVE_PICTURE, CURVE_TABLE, MANIFEST, Progress, SHEET, Stage, TrainError, TrainingSpec,
};
use vantage_model::ObservationModel;

fn refused(training: &ViewSet, validation: &ViewSet, spec: &TrainingSpec) -> TrainError {
    let folder = tempfile::tempdir().unwrap();
    let result = trained([training, validation], spec, folder.path(), None, |_| false);
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 0, "what is refused leaves nothing, and so trained nothing");
    result.unwrap_err()
}

/// `stage,step,loss,...` of `loss.csv`.
fn losses(table: &str, stage: &str) -> Vec<f64> {
    let rows = table.lines().filter(|line| line.split(',').next() == Some(stage));
    rows.map(|line| line.split(',').nth(2).unwrap().parse().unwrap()).collect()
}

#[test]
fn a_short_training_lowers_both_losses_and_leaves_all_its_files() {
    let folder = tiny_model();
    let table = std::fs::read_to_string(folder.join(CURVE_TABLE)).unwrap();
    // Divergence and instance term come in over the first 36 steps of stage 2.
    for (stage, steps, warm) in [("trunk", 40, 0), ("autoencoder", 120, 36)] {
        let losses = losses(&table, stage);
        assert_eq!(losses.len(), steps);
        let mean = |losses: &[f64]| losses.iter().sum::<f64>() / losses.len() as f64;
        let (first, last) = (mean(&losses[warm..warm + 8]), mean(&losses[steps - 8..]));
        assert!(last < 0.9 * first, "{stage}: {first} to {last}");
    }
    assert!(std::fs::read_to_string(folder.join(CURVE_PICTURE)).unwrap().contains("loss of the trunk"));
    let sheet = image::open(folder.join(SHEET)).unwrap().to_rgb8();
    assert!(sheet.width() > 300 && sheet.height() > 300);
    assert!(!folder.join(CHECKPOINT).exists());
}

#[test]
fn a_killed_training_goes_on_to_the_same_curve_and_model() {
    let folder = tempfile::tempdir().unwrap();
    let at = |stage: Stage, step: usize| move |progress: &Progress| matches!(progress, Progress::Step { stage: s, step: n, .. } if (*s, *n) == (stage, step));
    let stopped = tiny_training(folder.path(), &tiny_spec(), at(Stage::Trunk, 22)).unwrap_err();
    assert!(matches!(stopped, TrainError::Stopped { stage: Stage::Trunk, step: 22 }));
    let stopped = tiny_training(folder.path(), &tiny_spec(), at(Stage::Autoencoder, 50)).unwrap_err();
    assert!(matches!(stopped, TrainError::Stopped { stage: Stage::Autoencoder, step: 50 }));
    let told = tiny_training(folder.path(), &tiny_spec(), |_| false).unwrap();
    assert_eq!(told[0], Progress::Resumed { stage: Stage::Autoencoder, step: 45 });
    for file in [CURVE_TABLE, MANIFEST] {
        let read = |folder: &std::path::Path| std::fs::read_to_string(folder.join(file)).unwrap();
        assert!(read(folder.path()) == read(&tiny_model()), "{file} differs");
    }
}

#[test]
fn useless_checkpoints_are_set_aside() {
    let spec = TrainingSpec { trunk_steps: 4, steps: 3, checkpoint_every: 2, ..tiny_spec() };
    let folder = tempfile::tempdir().unwrap();
    let third = |progress: &Progress| matches!(progress, Progress::Step { step: 3, .. });
    let checkpoint = folder.path().join(CHECKPOINT);

    tiny_training(folder.path(), &spec, third).unwrap_err();
    let mut bytes = std::fs::read(&checkpoint).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&checkpoint, &bytes).unwrap();
    let reason_told = |told: &[Progress]| match &told[0] {
        Progress::SetAside { path, reason } => {
            assert!(path.exists());
            reason.clone()
        }
        other => panic!("{other:?}"),
    };
    let told = tiny_training(folder.path(), &spec, |_| false).unwrap();
    assert!(reason_told(&told).contains("damaged"));

    let folder = tempfile::tempdir().unwrap();
    tiny_training(folder.path(), &spec, third).unwrap_err();
    let other = TrainingSpec { learning_rate: 2e-3, ..spec };
    let told = tiny_training(folder.path(), &other, |_| false).unwrap();
    assert!(reason_told(&told).contains("another spec"));
}

#[test]
fn a_finished_folder_is_not_trained_over() {
    let again = tiny_training(&tiny_model(), &tiny_spec(), |_| false).unwrap_err();
    assert!(matches!(again, TrainError::AlreadyTrained { .. }));
}

#[test]
fn a_non_finite_loss_stops_the_training_and_keeps_the_log() {
    let mut training = training_views();
    for view in &mut training.views[40..] {
        view.viewpoint.log_distance = 1e30;
    }
    let folder = tempfile::tempdir().unwrap();
    let result = trained([&training, &validation_views()], &tiny_spec(), folder.path(), None, |_| false);
    let Err(TrainError::NonFiniteLoss { stage: Stage::Trunk, step, loss, log }) = result else {
        panic!("{result:?}");
    };
    assert!(!loss.is_finite());
    let table = std::fs::read_to_string(log).unwrap();
    assert_eq!(table.lines().count(), step + 1);
    assert!(!folder.path().join(MANIFEST).exists());
}

#[test]
fn a_training_with_a_share_of_black_crops_ends_with_a_model_that_answers_to_black() {
    let mut training = training_views();
    training.views.iter_mut().step_by(3).for_each(|view| view.crop = Crop::black());
    let folder = tempfile::tempdir().unwrap();
    trained([&training, &validation_views()], &tiny_spec(), folder.path(), None, |_| false).unwrap();
    let model = viewpoint_model(folder.path());
    model.measure(&Crop::black()).unwrap();
}

#[test]
fn views_that_cannot_train_are_refused() {
    let (training, validation) = (training_views(), validation_views());
    let spec = tiny_spec();

    let mut leaking = validation.clone();
    leaking.instances[3].id = training.instances[5].id;
    let error = refused(&training, &leaking, &spec);
    assert!(matches!(&error, TrainError::SharedInstances { shared } if shared.len() == 1), "{error}");

    let test = synthetic::views(Split::Test, 4, 4, 9);
    assert!(matches!(refused(&test, &validation, &spec), TrainError::Split { got: Split::Test, .. }));
    assert!(matches!(
        refused(&training, &test, &spec),
        TrainError::Split { expected: Split::Validation, .. }
    ));

    let single = synthetic::views(Split::Train, 5, 1, 1);
    assert!(matches!(refused(&single, &validation, &spec), TrainError::TooFewInstances { got: 0, .. }));

    let alone = synthetic::views(Split::Train, 1, 8, 1);
    assert!(matches!(refused(&alone, &validation, &spec), TrainError::TooFewInstances { got: 1, .. }));
    let mut black = training.clone();
    black.views.iter_mut().for_each(|view| view.crop = Crop::black());
    let error = refused(&black, &validation, &spec);
    assert!(matches!(error, TrainError::SameCrops { split: Split::Train }), "{error}");

    let few = synthetic::views(Split::Validation, 2, 4, 3);
    assert!(matches!(
        refused(&training, &few, &TrainingSpec { trunk_steps: 1, steps: 1, ..spec.clone() }),
        TrainError::Calibration { .. }
    ));

    let mut broken = training.clone();
    broken.views[7].viewpoint.log_distance = f64::NAN;
    assert!(matches!(refused(&broken, &validation, &spec), TrainError::Viewpoint { view: 7, .. }));
    let mut broken = training;
    broken.views[7].instance = 12;
    assert!(matches!(refused(&broken, &validation, &spec), TrainError::Instance { view: 7, got: 12, .. }));

    let wrong = TrainingSpec { learning_rate: -1.0, ..spec };
    let error = refused(&training_views(), &validation, &wrong).to_string();
    assert!(error.contains("learning_rate"), "{error}");
}
