//! Training of a model, from views to a model folder.
//!
//! 1. The trunk `t(z)` and the reduced measurement `m(z)` (IV-C), by a task that tells the viewpoint; then frozen.
//! 2. Encoder and decoder on the frozen features, by the bound of Eq. 12-14 or of Eq. 20 over several views.
//! 3. The noise of the measurement, on validation instances.

mod autoencoder;
mod data;
mod error;
mod export;
mod folder;
mod network;
mod run;
#[cfg(test)]
#[path = "../../tests/support/synthetic.rs"]
mod synthetic;
mod trunk;

pub use data::views::view_set_hash;
pub use error::TrainError;
pub use folder::{INSTANCE_LIST, SHEET};
pub use run::checkpoint::CHECKPOINT;
pub use run::curve::{CURVE_PICTURE, CURVE_TABLE};
pub use run::device::TrainingDevice;
pub use run::progress::{Progress, Stage};

use crate::architecture::Architecture;
use crate::manifest::MANIFEST;
use crate::role::Kind;
use crate::spec::{Loss, Task, TrainingSpec};
use autoencoder::features::{Features, Frozen};
use autoencoder::network::Autoencoder;
use autoencoder::{Bound, contrastive, discrete_class};
use burn::module::Module;
use burn::tensor::Device;
use data::components::Components;
use data::views::Views;
use garde::Validate;
use network::half::rounded_module;
use run::checkpoint::{self, Checkpoint, module_bytes};
use run::curve::Curve;
use run::origin::Origin;
use run::{Run, Started, files};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use trunk::TrunkData;
use trunk::network::TrunkWithHead;
use trunk::store::TrunkStore;
use vantage_dataset::{Seed, Split, ViewSet};

/// Least instances to train on.
const TRAINING_INSTANCES: usize = 2;

/// What a model is trained on, how, and where it goes.
#[derive(Clone, Copy, Debug)]
pub struct Training<'a> {
    /// Views of the split [`Split::Train`].
    pub training: &'a ViewSet,
    /// Views of the split [`Split::Validation`], which calibrate the noise of the measurement.
    pub validation: &'a ViewSet,
    /// What is trained, and how.
    pub spec: &'a TrainingSpec,
    /// Seed of the weights and batches.
    pub seed: Seed,
    /// Recorded in the manifest.
    pub provenance: &'a BTreeMap<String, String>,
    /// The model's folder.
    pub folder: &'a Path,
    /// A folder of trained trunks, which trainings on one device that differ in stage 2 alone share.
    pub trunks: Option<&'a Path>,
    /// What computes both stages; the noise is fitted on the CPU.
    pub device: &'a TrainingDevice,
}

/// Trains a model and writes its folder: see [`Model::load`](crate::Model::load).
///
/// Same views, spec, seed and machine give the same loss curve on the CPU, whatever the number of threads and whether or not the
/// training was killed between: it goes on from the folder's last checkpoint. `progress` is told of every step, and may ask
/// to stop. Beside the model, the folder gets the loss curve ([`CURVE_TABLE`], [`CURVE_PICTURE`]) and, of models that
/// predict crops, reconstructions of validation instances ([`SHEET`]).
pub fn train(
    Training { training, validation, spec, seed, provenance, folder, trunks, device }: Training<'_>,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(), TrainError> {
    spec.validate().map_err(TrainError::Spec)?;
    let shared = training.shared_instances(validation);
    if !shared.is_empty() {
        return Err(TrainError::SharedInstances { shared });
    }
    let odometry = spec.reads_odometry();
    let views = Views::new(training, Split::Train, TRAINING_INSTANCES, spec, seed, odometry)?;
    let held_out = Views::new(validation, Split::Validation, 1, spec, seed, odometry)?;
    let architecture = Architecture::new(spec).expect("a valid spec has a large enough latent");
    if architecture.kind() != Kind::Embedding {
        folder::are_enough(&held_out, spec.context as usize, architecture.measurement)?;
    }
    std::fs::create_dir_all(folder).map_err(|error| files::unwritable(folder, &error))?;
    let manifest = folder.join(MANIFEST);
    if manifest.exists() {
        return Err(TrainError::AlreadyTrained { path: manifest });
    }
    let origin = Origin {
        data_hash: view_set_hash(training),
        validation_hash: view_set_hash(validation),
        provenance: provenance.clone(),
    };
    let key = origin.key(spec, &architecture, &views.tags, seed);
    let store = trunks.map(|folder| TrunkStore::new(folder, &origin, spec, &architecture, seed));
    let device = device.clone();
    let mut run = Run { spec, architecture, seed, folder, key, curve: Curve::default(), device, progress };
    let trained = descend(&mut run, &views, store.as_ref())?;
    folder::finish(&mut run, &trained, &views, &held_out, origin)
}

/// Both stages' networks, and the training views as stage 2 sees them.
struct Trained {
    frozen: Frozen,
    features: Features,
    /// With derivatives.
    network: Autoencoder,
}

/// Stages 1 and 2, from wherever the folder's checkpoint left them.
fn descend(run: &mut Run, views: &Views, store: Option<&TrunkStore>) -> Result<Trained, TrainError> {
    let (device, plain) = (run.device.tensors(), Device::flex());
    let on_gpu = run.device.name().is_some();
    let (spec, seed, architecture) = (run.spec, run.seed, run.architecture.clone());
    let (trunk, network) = start(run, views, store, &device)?;

    let components = Components::fit(views.set, architecture.components, seed);
    let task = spec.traits().task;
    // Of a viewpoint-predictive model the trunk alone may be told true viewpoints.
    let told = task == Task::Viewpoint && spec.reads_odometry();
    let known = told
        .then(|| Views::new(views.set, Split::Train, TRAINING_INSTANCES, spec, seed, false))
        .transpose()?;
    let of_trunk = known.as_ref().unwrap_or(views);
    let data = TrunkData {
        task,
        views: of_trunk,
        components: Some(&components),
        spec,
        seed,
        device: &device,
        on_gpu,
    };
    let trunk = run.descend(
        Stage::Trunk,
        spec.trunk_steps as usize,
        trunk,
        |network, index| trunk::step(network, &data, index),
        |network| Ok([module_bytes(network)?, Vec::new()]),
    )?;
    if let Some(store) = store {
        let bytes = module_bytes(&trunk).map_err(|error| files::unwritable(run.folder, &error))?;
        store.keep(bytes, &run.curve)?;
    }

    let _ = run.tell(&Progress::Features);
    let measurement = trunk.trunk.measurement_layer();
    let rounded = rounded_module(trunk.trunk.valid());
    let frozen = Frozen::fit(rounded, measurement, views, &architecture, components, &plain);
    let features = frozen.features(views, &plain);

    let bound =
        Bound { views, features: &features, spec, architecture: &architecture, seed, device: &device };
    let network = run.descend(
        Stage::Autoencoder,
        spec.steps as usize,
        network,
        |network, index| match spec.traits().loss {
            Loss::Bound | Loss::BoundOfSingles => autoencoder::step(network, &bound, index),
            Loss::Class => discrete_class::step(network, &bound, index),
            Loss::Contrast => contrastive::step(network, &bound, index),
        },
        |network| Ok([module_bytes(&trunk)?, module_bytes(network)?]),
    )?;
    Ok(Trained { frozen, features, network: rounded_module(network) })
}

type Starts = (Started<TrunkWithHead>, Started<Autoencoder>);

/// Fresh networks, or those of the folder's checkpoint, or a trunk that another training left; a useless checkpoint is set
/// aside.
fn start(
    run: &mut Run,
    views: &Views,
    store: Option<&TrunkStore>,
    device: &Device,
) -> Result<Starts, TrainError> {
    let sizes = [views.instances, views.classes];
    let head = run.spec.traits().task.head(&run.architecture);
    let embedding = trunk::embedding_size(run.spec);
    let trunk = || TrunkWithHead::new(&run.architecture, &head, embedding, run.seed, device);
    let autoencoder = || Autoencoder::new(&run.architecture, sizes, run.seed, device);
    let whole = |bytes: &[u8]| {
        let module = checkpoint::module_from(trunk(), bytes)?;
        Ok::<_, String>(Started { done: run.spec.trunk_steps as usize, ..Started::fresh(module) })
    };
    let restored = |checkpoint: &Checkpoint| -> Result<Starts, String> {
        if checkpoint.state.stage == Stage::Trunk {
            let trunk = Started::resumed(trunk(), &checkpoint.trunk, checkpoint)?;
            return Ok((trunk, Started::fresh(autoencoder())));
        }
        Ok((whole(&checkpoint.trunk)?, Started::resumed(autoencoder(), &checkpoint.autoencoder, checkpoint)?))
    };
    let found = Checkpoint::read(run.folder, &run.key);
    let found = found.and_then(|found| found.map(|c| Ok((restored(&c)?, c.state))).transpose());
    let set_aside = match found {
        Ok(Some((starts, state))) => {
            run.curve = state.curve;
            let _ = run.tell(&Progress::Resumed { stage: state.stage, step: state.step });
            return Ok(starts);
        }
        Ok(None) => None,
        Err(reason) => Some(Progress::SetAside { path: checkpoint::set_aside(run.folder)?, reason }),
    };
    let kept =
        store.and_then(TrunkStore::find).and_then(|kept| Some((whole(&kept.trunk).ok()?, kept.state.curve)));
    let (trunk, curve) = kept.unwrap_or_else(|| (Started::fresh(trunk()), Curve::default()));
    let starts = (trunk, Started::fresh(autoencoder()));
    run.curve = curve;
    if let Some(told) = set_aside {
        let _ = run.tell(&told);
    }
    Ok(starts)
}
