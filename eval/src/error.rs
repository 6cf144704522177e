//! Everything that ends a run of `bench` early.

use crate::command::source::SourceError;
use crate::gate::GateError;
use crate::result::output_folder::OutputError;
use crate::result::results_file::ResultsError;
use crate::result::standing::FullerResult;
use crate::result::table::TableError;
use crate::result::trajectory::TrajectoryError;
use crate::scene_file::SceneFileError;
use crate::scene_file::study::VariantError;
use crate::score::entry::EntryError;
use crate::score::pairs::PairsError;
use std::path::PathBuf;
use thiserror::Error;
use vantage_dataset::InstanceId;
use vantage_dataset::store::StoreError;
use vantage_formats::ImportError;
use vantage_learn::Kind;
use vantage_model::AnswerError;
use vantage_sim::error::SimError;
use vantage_sim::render::RenderError;
use vantage_slam::EstimateError;

/// Everything that ends a run early.
#[derive(Debug, Error)]
pub enum BenchError {
    /// See [`SceneFileError`].
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// See [`SourceError`].
    #[error(transparent)]
    Source(#[from] SourceError),
    /// See [`VariantError`].
    #[error(transparent)]
    Variant(#[from] VariantError),
    /// See [`OutputError`].
    #[error(transparent)]
    Output(#[from] OutputError),
    /// See [`StoreError`].
    #[error(transparent)]
    Store(#[from] StoreError),
    /// See [`SimError`].
    #[error(transparent)]
    Sim(#[from] SimError),
    /// See [`ImportError`].
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A folder to import from lacks an object that was asked for.
    #[error("{} holds no object {name}: look what --objects names (of BigBIRD, a folder with a calibration.h5)", folder.display())]
    NoObject {
        /// Its name.
        name: String,
        /// Where it was looked for.
        folder: PathBuf,
    },
    /// A folder to import from holds no object.
    #[error(
        "{} holds no object, that is, no folder with a calibration.h5: name the folder of the objects' folders",
        folder.display()
    )]
    NoObjects {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder to import from is that of an object, in place of that of all.
    #[error("{} holds the files of one object: name the folder above it", folder.display())]
    OneObject {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder holds a dataset of another scene, split, renderer or program.
    #[error("{} holds a dataset of another {differs}; choose another folder with --out", folder.display())]
    OtherData {
        /// The folder.
        folder: PathBuf,
        /// In what it is another.
        differs: String,
    },
    /// A picture that would not be one.
    #[error("--out {}: expected the name of a PNG file, such as out/look.png, and no folder", path.display())]
    NoPicture {
        /// What was asked for.
        path: PathBuf,
    },
    /// A format that this scene's images cannot be written in.
    #[error("--format {format}: {reason}; choose another format or scene")]
    Unsuitable {
        /// The format.
        format: &'static str,
        /// Why not.
        reason: String,
    },
    /// See [`RenderError`].
    #[error(transparent)]
    Render(#[from] RenderError),
    /// See [`vantage_learn::ModelError`].
    #[error(transparent)]
    Model(#[from] vantage_learn::ModelError),
    /// Model folders that are refused, of those to be told of.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Refused(Vec<vantage_learn::ModelError>),
    /// Scores that are no numbers, which are not cached.
    #[error(
        "the model's scores on unseen instances of seed {seed} are not all finite numbers: check its outputs and its residual"
    )]
    NotFinite {
        /// The seed of the instances.
        seed: u64,
    },
    /// See [`AnswerError`].
    #[error("observation model: {0}")]
    Answer(#[from] AnswerError),
    /// A folder that is to be read is not there.
    #[error("there is no folder {}", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// Objects or a split are chosen of an episode, which has all objects and no split.
    #[error("{option} is for a view set: add --views")]
    ForViewSets {
        /// The option.
        option: &'static str,
    },
    /// A model's folder is not there.
    #[error(
        "there is no folder {}, which --model or the scene's training.reference names (relative to the scene file: put it beside \
         the others, into scenes/): name one that is there or that `bench train` wrote by --model DIR, or train one with --train",
        folder.display()
    )]
    NoModel {
        /// The folder.
        folder: PathBuf,
    },
    /// A model whose folder gives its row no name.
    #[error(
        "--model {}: the folder's name is that of the model's row, which takes letters, digits, '-', '_' and '.' alone; rename \
         the folder", folder.display()
    )]
    Unnamed {
        /// The folder.
        folder: PathBuf,
    },
    /// A model whose row would have the name of another.
    #[error("--model {}: another row, or the truth, is named {name}; rename the folder", folder.display())]
    Named {
        /// The folder.
        folder: PathBuf,
        /// The name.
        name: String,
    },
    /// See [`vantage_learn::TrainError`].
    #[cfg(feature = "train")]
    #[error(transparent)]
    Train(#[from] vantage_learn::TrainError),
    /// See [`EstimateError`].
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// A scene without a model, in a program that cannot train one.
    #[cfg(not(feature = "train"))]
    #[error(
        "this program was built without training: build it with `--features train`, or name a model with --model"
    )]
    CannotTrain,
    /// A recording is asked for, of a program that cannot write one.
    #[cfg(not(feature = "rerun"))]
    #[error(
        "this program was built without Rerun: build it with `cargo build --release -p vantage-eval --features rerun`, or \
         leave --rerun out"
    )]
    CannotRecord,
    /// A GPU was asked of a program that was built without.
    #[cfg(not(feature = "gpu"))]
    #[error(
        "this program was built without GPUs: build it with `cargo build --release -p vantage-eval --features gpu`, or leave \
         --gpu out"
    )]
    NoGpuBuild,
    /// A recording could not be written.
    #[cfg(feature = "rerun")]
    #[error("cannot write {}: {source}; choose another file with --rerun, or make room", path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// What Rerun said.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// See [`EntryError`].
    #[error(transparent)]
    Entry(#[from] EntryError),
    /// An instance that would be scored is among those that the model has seen.
    #[error(
        "instance {:016x} is scored, and yet the model in {} was trained on it: no score of this model would be of \
         unseen instances", instance.0, folder.display()
    )]
    Leak {
        /// The instance.
        instance: InstanceId,
        /// The model's folder.
        folder: PathBuf,
    },
    /// A model that the estimator can do nothing with.
    #[error(
        "the model in {} is of kind {kind} and does not tell what an object looks like from a viewpoint; the estimator needs a \
         viewpoint_dependent one, or a viewpoint_predictive one whose latent turns. `bench figures` takes any, and so does a study by `folder`", folder.display()
    )]
    NotViewing {
        /// The model's folder.
        folder: PathBuf,
        /// Its kind.
        kind: Kind,
    },
    /// A scene whose own model would be one that the estimator can do nothing with.
    #[error(
        "scene {scene}: training.model makes a model that does not tell what an object looks like from a viewpoint, as the estimator \
         needs it. Set its objective to viewpoint_dependent or discrete_class, or to viewpoint_predictive with predictive.motion \
         object_centred and pairs_per_harmonic above 0, or name another model by --model. `bench figures` takes any, and so does a study by `folder`"
    )]
    ObjectiveNotViewing {
        /// Its name.
        scene: String,
    },
    /// A study of known instances whose sessions are too short.
    #[error(
        "scored: known holds out every fourth view of a session, but of instance {instance} no session has four: raise \
         views.views_per_instance of the study's scene, or lower views.sessions"
    )]
    NothingHeldOut {
        /// Its place among the training instances.
        instance: usize,
    },
    /// A cached answer is not what was written.
    #[error("{}: {reason}; remove the cache entry and run again", path.display())]
    StoredAnswers {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A row panicked.
    #[error("an estimator panicked on {}: its runs count as failed, all others were written", scene.display())]
    Panicked {
        /// The scene.
        scene: PathBuf,
    },
    /// Every row failed on every seed.
    #[error(
        "every estimator failed on every seed of {}: the tables that were written say why", scene.display()
    )]
    NothingAnswered {
        /// The scene.
        scene: PathBuf,
    },
    /// A folder that a dataset was to be written to holds something else.
    #[error(
        "{} already holds something else: nothing was changed; choose a new or empty folder with --out",
        folder.display()
    )]
    NotOurs {
        /// The folder.
        folder: PathBuf,
    },
    /// See [`FullerResult`].
    #[error(transparent)]
    FullerResult(#[from] FullerResult),
    /// A row of which no run succeeded.
    #[error("no run of {method} succeeded on {}: {reason}; all else was written", scene.display())]
    NothingOf {
        /// The row.
        method: String,
        /// The scene.
        scene: PathBuf,
        /// Why the first failed.
        reason: String,
    },
    /// No object was detected in any episode.
    #[error(
        "no object was detected in any episode of {}: tables were written, but only dead reckoning was scored; turn \
         the camera (`robot.camera`), move the path, or lower `sensors.detector`", scene.display()
    )]
    NothingSeen {
        /// The scene.
        scene: PathBuf,
    },
    /// See [`ResultsError`].
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// See [`GateError`].
    #[error(transparent)]
    Gate(#[from] GateError),
    /// Standard output is closed or full.
    #[error("cannot write to standard output: {0}")]
    Stdout(#[from] std::io::Error),
    /// An estimator answered with poses that cannot be scored.
    #[error("an estimate cannot be scored: {0}")]
    Pairs(#[from] PairsError),
    /// An estimator answered with poses that are no trajectory.
    #[error("an estimate is no trajectory: {0}")]
    Trajectory(#[from] TrajectoryError),
    /// The pipeline handed over runs that make no table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A value of ours that JSON cannot hold.
    #[error("cannot write as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A table that CSV cannot hold.
    #[error("cannot write as CSV: {0}")]
    Csv(#[from] csv::Error),
    /// A figure could not be drawn.
    #[error(transparent)]
    Figure(#[from] crate::figure::FigureError),
}
