//! The model folder: all files, the manifest last.

mod calibration;
pub(crate) mod canaries;
mod predictions;
mod sheet;

pub(crate) use calibration::are_enough;
pub use sheet::SHEET;

use crate::canary::CANARY;
use crate::latent::Latent;
use crate::manifest::{
    FORMAT, FileRecord, GraphRecord, MANIFEST, Manifest, TrainingDetails, TrainingRecord, VERSION,
};
use crate::model::Model;
use crate::role::{Kind, Role};
use crate::spec::Loss;
use crate::train::data::views::Views;
use crate::train::error::TrainError;
use crate::train::network::weights::Weights;
use crate::train::run::Run;
use crate::train::run::checkpoint::CHECKPOINT;
use crate::train::run::device::cpu;
use crate::train::run::files;
use crate::train::run::origin::Origin;
use crate::train::run::progress::{Progress, Stage};
use crate::train::{Trained, export};
use burn::module::Module;
use burn::tensor::Device;
use canaries::Trainer;
use predictions::Predictions;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// File of a trained model's folder that lists the instances it was trained or calibrated on.
pub const INSTANCE_LIST: &str = "training_instances.txt";

/// Stage 3, and everything on disk; the model is loaded back before the checkpoint goes.
pub(crate) fn finish(
    run: &mut Run,
    trained: &Trained,
    views: &Views,
    held_out: &Views,
    origin: Origin,
) -> Result<(), TrainError> {
    let (device, plain) = (cpu(), Device::flex());
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
    let kind = architecture.kind();
    let measures = kind != Kind::Embedding;
    let residual = match measures {
        true => Some(calibration::calibrated(&predictions, held_out, context, run.seed)?),
        false => None,
    };

    let _ = run.tell(&Progress::Export);
    run.curve.write_table(run.folder)?;
    run.curve.write_picture(run.folder)?;
    if measures {
        sheet::write(run.folder, &predictions, held_out, &frozen.components, context)?;
    }
    let unit_embedding = run.spec.traits().loss == Loss::Contrast;
    let weights = network.weights(&architecture, frozen, unit_embedding);
    let graphs = write_graphs(run.folder, &weights)?;
    let trainer = Trainer {
        network,
        architecture: &architecture,
        unit_embedding,
        frozen,
        features,
        views,
        device: &device,
    };
    let canary = serde_json::to_vec(&trainer.canary()).expect("finite numbers become JSON");
    files::write(&run.folder.join(CANARY), &canary)?;
    let instances = instance_list(views, held_out);
    files::write(&run.folder.join(INSTANCE_LIST), instances.as_bytes())?;
    let manifest = Manifest {
        format: FORMAT.into(),
        version: VERSION,
        kind,
        latent: Latent {
            dimension: architecture.latent.dimension(),
            steerable: Some(architecture.latent).filter(|latent| latent.pairs() > 0),
        },
        measurement: measures.then_some(architecture.measurement),
        conditioning: architecture.convention,
        graphs,
        residual,
        training: training_record(run, origin, views, &instances),
        canary: FileRecord::new(CANARY, &canary),
    };
    let path = run.folder.join(MANIFEST);
    let yaml = manifest.to_yaml().map_err(|error| files::unwritable(&path, &error))?;
    files::write(&path, yaml.as_bytes())?;
    if let Err(error) = Model::load(run.folder) {
        std::fs::remove_file(&path).map_err(|error| files::unwritable(&path, &error))?;
        return Err(TrainError::Export(error));
    }
    let checkpoint = run.folder.join(CHECKPOINT);
    std::fs::remove_file(&checkpoint).map_err(|error| files::unwritable(&checkpoint, &error))
}

fn write_graphs(folder: &Path, weights: &Weights) -> Result<BTreeMap<Role, GraphRecord>, TrainError> {
    let mut graphs = BTreeMap::new();
    for role in export::roles(&weights.architecture) {
        let (bytes, file) = (export::graph(role, weights), role.file());
        files::write(&folder.join(&file), &bytes)?;
        graphs.insert(role, GraphRecord::new(&file, &bytes, &export::signature(role, &weights.architecture)));
    }
    Ok(graphs)
}

fn training_record(run: &Run, origin: Origin, views: &Views, instances: &str) -> TrainingRecord {
    let last = |stage: Stage| run.curve.last(stage).map(|loss| (stage.name().to_owned(), loss));
    TrainingRecord {
        origin: format!("{} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")),
        data_hash: origin.data_hash,
        instances: FileRecord::new(INSTANCE_LIST, instances.as_bytes()),
        provenance: origin.provenance,
        details: Some(TrainingDetails {
            validation_hash: origin.validation_hash,
            seed: run.seed,
            spec: run.spec.clone(),
            architecture: run.architecture.clone(),
            instances: views.instances,
            views: views.len(),
            final_loss: [Stage::Trunk, Stage::Autoencoder].into_iter().filter_map(last).collect(),
        }),
    }
}

/// Every instance of both view sets, a line of 16 hexadecimal digits each.
fn instance_list(views: &Views, held_out: &Views) -> String {
    let all = views.set.instances.iter().chain(&held_out.set.instances);
    let ids: BTreeSet<_> = all.map(|instance| instance.id).collect();
    ids.iter().map(|id| format!("{:016x}\n", id.0)).collect()
}
