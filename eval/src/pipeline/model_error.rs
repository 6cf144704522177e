//! Why a model is not scored.

use crate::exit::Ends;
use std::path::PathBuf;
use thiserror::Error;
use vantage_dataset::InstanceId;
use vantage_learn::Kind;

/// Why a model is not scored.
#[derive(Debug, Error)]
pub enum ModelRefusal {
    /// A model that the user names is not there.
    #[error(
        "model {}: there is no such folder; name one that `bench train` wrote, or by --model one that comes with the program \
         (`bench list`)",
        folder.display()
    )]
    NotThere {
        /// The folder.
        folder: PathBuf,
    },
    /// The scene's own model is not there.
    #[error(
        "there is no folder {}, which the scene's training.reference names (relative to the scene file), and no model of its name \
         comes with the program (`bench list`): name a model by --model, or train one with --train",
        folder.display()
    )]
    NoReference {
        /// The folder.
        folder: PathBuf,
    },
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
    /// A row reads pairs of views, and the model tells single ones alone.
    #[error(
        "the model in {} is of kind {kind} and tells no view from another, as the row viewpoint_pairs needs it of the first \
         model; name a viewpoint_predictive one first (--model, or `model` in a map), or leave the row out", folder.display()
    )]
    NotOfPairs {
        /// The model's folder.
        folder: PathBuf,
        /// Its kind.
        kind: Kind,
    },
    /// Likewise of a scene whose own model would tell single views alone.
    #[error(
        "scene {scene}: training.model makes a model that tells no view from another, as the row viewpoint_pairs needs it. Set its \
         objective to viewpoint_predictive, name such a model by --model, or leave the row out of estimator.rows"
    )]
    ObjectiveNotOfPairs {
        /// Its name.
        scene: String,
    },
    /// A row learns the last layer of a decoder, and the model has none.
    #[error(
        "the model in {} is {kind}: rows decoder_adapted, decoder_checked and decoder_taught learn the decoder of the first model, a \
         viewpoint_dependent one; name another first (--model, or `model` in a map), or leave the rows out", folder.display()
    )]
    NotViewpointDependent {
        /// Its folder.
        folder: PathBuf,
        /// Its kind.
        kind: Kind,
    },
    /// A row learns the last layer of a decoder, and that of the model is none that can be told from its graphs.
    #[error(
        "the model in {} has no last layer for rows decoder_adapted, decoder_checked and decoder_taught, as decoders have that bench train writes: {source}; \
         leave the rows out", folder.display()
    )]
    NoLastLayer {
        /// Its folder.
        folder: PathBuf,
        /// What is otherwise.
        source: Box<vantage_learn::ModelError>,
    },
    /// A row needs read-outs, and there are too few views to fit them on.
    #[error(
        "scene {scene}: {views} validation views are too few to fit the read-outs of rows azimuth_head and discrete_class on; raise \
         views.validation_instances, or leave the rows out"
    )]
    NoReadouts {
        /// Its name.
        scene: String,
        /// Validation views.
        views: usize,
    },
    /// A model that fails on a view that read-outs are fitted on.
    #[error("read-outs: {0}")]
    Answer(#[source] vantage_model::AnswerError),
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
}

impl Ends for ModelRefusal {}
