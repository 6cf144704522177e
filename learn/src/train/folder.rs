//! The model folder: all files, the manifest last.

use super::canaries::Trainer;
use super::checkpoint::CHECKPOINT;
use super::error::TrainError;
use super::predictions::Predictions;
use super::progress::{Progress, Stage};
use super::run::{Run, training_device};
use super::views::Views;
use super::{Trained, calibration, export, files, sheet};
use crate::architecture::Architecture;
use crate::canary::CANARY;
use crate::manifest::{
    FORMAT, FileRecord, GraphRecord, MANIFEST, Manifest, Role, TrainingRecord, VERSION, conditioning_names,
};
use crate::model::ViewpointModel;
use crate::onnx::OPSET;
use crate::residual::ResidualNoise;
use crate::spec::TrainingSpec;
use burn::module::Module;
use burn::tensor::Device;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::Seed;

/// What a model is trained from.
pub(crate) struct Origin {
    pub(crate) data_hash: String,
    pub(crate) validation_hash: String,
    pub(crate) provenance: BTreeMap<String, String>,
}

impl Origin {
    /// Hash of everything that decides what a training does.
    pub(crate) fn key(&self, spec: &TrainingSpec, architecture: &Architecture, seed: Seed) -> String {
        let trainer = env!("CARGO_PKG_VERSION");
        let decides = (
            VERSION,
            trainer,
            &self.data_hash,
            &self.validation_hash,
            &self.provenance,
            spec,
            architecture,
            seed,
        );
        let json = serde_json::to_vec(&decides).expect("numbers and strings become JSON");
        blake3::hash(&json).to_hex().to_string()
    }
}

/// Stage 3, and everything on disk; the model is loaded back before the checkpoint goes.
pub(crate) fn finish(
    run: &mut Run,
    trained: &Trained,
    views: &Views,
    held_out: &Views,
    origin: Origin,
) -> Result<(), TrainError> {
    let (device, plain) = (training_device(), Device::flex());
    let Trained { frozen, features, network } = trained;
    let architecture = run.architecture.clone();
    let context = run.spec.context as usize;

    let _ = run.tell(&Progress::Calibration);
    let held_features = frozen.features(held_out, &plain);
    let evaluated = network.valid();
    let predictions = Predictions {
        network: &evaluated,
        architecture: &architecture,
        views: held_out,
        features: &held_features,
        device: &plain,
    };
    let residual = calibration::calibrated(&predictions, held_out, context, run.seed)?;

    let _ = run.tell(&Progress::Export);
    run.curve.write_table(run.folder)?;
    run.curve.write_picture(run.folder)?;
    sheet::write(run.folder, &predictions, held_out, &frozen.components, context)?;
    let graphs = write_graphs(run.folder, &architecture, &network.weights(&architecture, frozen))?;
    let trainer = Trainer { network, architecture: &architecture, frozen, features, views, device: &device };
    let canary = serde_json::to_vec(&trainer.canary()).expect("finite numbers become JSON");
    files::write(&run.folder.join(CANARY), &canary)?;
    let manifest = manifest(run, graphs, residual, &canary, origin, views);
    let path = run.folder.join(MANIFEST);
    files::write(&path, &json(&manifest))?;
    if let Err(error) = ViewpointModel::load(run.folder) {
        std::fs::remove_file(&path).map_err(|error| files::unwritable(&path, &error))?;
        return Err(TrainError::Export(error));
    }
    let checkpoint = run.folder.join(CHECKPOINT);
    std::fs::remove_file(&checkpoint).map_err(|error| files::unwritable(&checkpoint, &error))
}

fn write_graphs(
    folder: &Path,
    architecture: &Architecture,
    weights: &super::weights::Weights,
) -> Result<BTreeMap<Role, GraphRecord>, TrainError> {
    let mut graphs = BTreeMap::new();
    for role in Role::ALL {
        let bytes = export::graph(role, weights);
        files::write(&folder.join(role.file()), &bytes)?;
        let record = GraphRecord {
            file: role.file().into(),
            blake3: blake3::hash(&bytes).to_hex().to_string(),
            signature: role.signature(architecture.latent.dimension(), architecture.measurement),
        };
        graphs.insert(role, record);
    }
    Ok(graphs)
}

fn manifest(
    run: &Run,
    graphs: BTreeMap<Role, GraphRecord>,
    residual: ResidualNoise,
    canary: &[u8],
    origin: Origin,
    views: &Views,
) -> Manifest {
    let last = |stage: Stage| run.curve.last(stage).map(|loss| (stage.name().to_owned(), loss));
    Manifest {
        format: FORMAT.into(),
        version: VERSION,
        opset: OPSET,
        architecture: run.architecture.clone(),
        conditioning: conditioning_names(),
        graphs,
        residual,
        canary: FileRecord { file: CANARY.into(), blake3: blake3::hash(canary).to_hex().to_string() },
        training: TrainingRecord {
            data_hash: origin.data_hash,
            validation_hash: origin.validation_hash,
            provenance: origin.provenance,
            seed: run.seed,
            spec: run.spec.clone(),
            instances: views.instances,
            views: views.len(),
            final_loss: [Stage::Trunk, Stage::Autoencoder].into_iter().filter_map(last).collect(),
            trainer: format!("{} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")),
        },
    }
}

fn json(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec_pretty(value).expect("finite numbers and strings become JSON")
}
