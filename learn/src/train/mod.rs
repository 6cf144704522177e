//! Training of the viewpoint-dependent model, from views to a model folder.
//!
//! 1. The trunk `t(z)` and the reduced measurement `m(z)`, by predicting `x_rel` (IV-C); then frozen.
//! 2. Encoder and decoder on the frozen features, by the bound of Eq. 12-14 over several views.
//! 3. The noise of the measurement, on validation instances.

mod autoencoder;
mod calibration;
mod canaries;
mod checkpoint;
mod components;
mod convolution;
mod curve;
mod error;
mod export;
mod features;
mod files;
mod folder;
mod network;
mod predictions;
mod progress;
mod run;
mod sheet;
#[cfg(test)]
#[path = "../../tests/support/synthetic.rs"]
mod synthetic;
mod trunk;
mod views;
mod weights;

pub use checkpoint::CHECKPOINT;
pub use curve::{CURVE_PICTURE, CURVE_TABLE};
pub use error::TrainError;
pub use folder::INSTANCE_LIST;
pub use progress::{Progress, Stage};
pub use sheet::SHEET;
pub use views::view_set_hash;

use crate::architecture::Architecture;
use crate::latent::LatentLayout;
use crate::manifest::MANIFEST;
use crate::spec::TrainingSpec;
use autoencoder::Bound;
use burn::module::Module;
use burn::tensor::Device;
use checkpoint::{Checkpoint, module_bytes};
use curve::Curve;
use features::{Features, Frozen};
use folder::Origin;
use garde::Validate;
use network::{Autoencoder, TrunkWithHead};
use run::{Run, Started, training_device};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use vantage_dataset::{Seed, Split, ViewSet};
use views::Views;

/// Least instances to train on.
const TRAINING_INSTANCES: usize = 2;

/// Trains a model and writes its folder: see [`ViewpointModel::load`](crate::ViewpointModel::load).
///
/// Same views, spec, seed, machine and thread count give the same loss curve, whether or not the training was
/// killed between: it goes on from the folder's last checkpoint. `provenance` is recorded in the
/// manifest.
/// `progress` is told of every step, and may ask to stop. Beside the model, the folder gets the loss curve
/// ([`CURVE_TABLE`], [`CURVE_PICTURE`]) and reconstructions of validation instances ([`SHEET`]).
pub fn train(
    training: &ViewSet,
    validation: &ViewSet,
    spec: &TrainingSpec,
    seed: Seed,
    provenance: &BTreeMap<String, String>,
    folder: &Path,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(), TrainError> {
    spec.validate().map_err(TrainError::Spec)?;
    let shared = training.shared_instances(validation);
    if !shared.is_empty() {
        return Err(TrainError::SharedInstances { shared });
    }
    let views = Views::new(training, Split::Train, TRAINING_INSTANCES)?;
    let held_out = Views::new(validation, Split::Validation, 1)?;
    std::fs::create_dir_all(folder).map_err(|error| files::unwritable(folder, &error))?;
    let manifest = folder.join(MANIFEST);
    if manifest.exists() {
        return Err(TrainError::AlreadyTrained { path: manifest });
    }
    let latent =
        LatentLayout::with_dimension(spec.latent_dim).expect("a valid spec has a large enough latent");
    let architecture = Architecture::new(latent, spec.measurement_dim);
    let origin = Origin {
        data_hash: view_set_hash(training),
        validation_hash: view_set_hash(validation),
        provenance: provenance.clone(),
    };
    let key = origin.key(spec, &architecture, seed);
    let mut run = Run { spec, architecture, seed, folder, key, curve: Curve::default(), progress };
    let trained = descend(&mut run, &views)?;
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
fn descend(run: &mut Run, views: &Views) -> Result<Trained, TrainError> {
    let (device, plain) = (training_device(), Device::flex());
    let (spec, seed, architecture) = (run.spec, run.seed, run.architecture.clone());
    let (trunk, network) = start(run, views, &device)?;

    let trunk = run.descend(
        Stage::Trunk,
        spec.trunk_steps as usize,
        trunk,
        |network, index| trunk::step(network, views, spec, seed, index, &device),
        |network| Ok([module_bytes(network)?, Vec::new()]),
    )?;

    let _ = run.tell(&Progress::Features);
    let measurement = trunk.trunk.measurement_layer();
    let frozen = Frozen::fit(trunk.trunk.valid(), measurement, views, &architecture, seed, &plain);
    let features = frozen.features(views, &plain);

    let bound =
        Bound { views, features: &features, spec, architecture: &architecture, seed, device: &device };
    let network = run.descend(
        Stage::Autoencoder,
        spec.steps as usize,
        network,
        |network, index| autoencoder::step(network, &bound, index),
        |network| Ok([module_bytes(&trunk)?, module_bytes(network)?]),
    )?;
    Ok(Trained { frozen, features, network })
}

type Starts = (Started<TrunkWithHead>, Started<Autoencoder>);

/// Fresh networks, or those of the folder's checkpoint; a useless one is set aside.
fn start(run: &mut Run, views: &Views, device: &Device) -> Result<Starts, TrainError> {
    let instances = views.by_instance.len();
    let trunk = || TrunkWithHead::new(&run.architecture, run.seed, device);
    let autoencoder = || Autoencoder::new(&run.architecture, instances, run.seed, device);
    let restored = |checkpoint: &Checkpoint| -> Result<Starts, String> {
        if checkpoint.state.stage == Stage::Trunk {
            let trunk = Started::resumed(trunk(), &checkpoint.trunk, checkpoint)?;
            return Ok((trunk, Started::fresh(autoencoder())));
        }
        let module = checkpoint::module_from(trunk(), &checkpoint.trunk)?;
        let trunk = Started { done: run.spec.trunk_steps as usize, ..Started::fresh(module) };
        Ok((trunk, Started::resumed(autoencoder(), &checkpoint.autoencoder, checkpoint)?))
    };
    let found = Checkpoint::read(run.folder, &run.key);
    let found = found.and_then(|found| found.map(|c| Ok((restored(&c)?, c.state))).transpose());
    match found {
        Ok(Some((starts, state))) => {
            run.curve = state.curve;
            let _ = run.tell(&Progress::Resumed { stage: state.stage, step: state.step });
            Ok(starts)
        }
        Ok(None) => Ok((Started::fresh(trunk()), Started::fresh(autoencoder()))),
        Err(reason) => {
            let starts = (Started::fresh(trunk()), Started::fresh(autoencoder()));
            let path = checkpoint::set_aside(run.folder)?;
            let _ = run.tell(&Progress::SetAside { path, reason });
            Ok(starts)
        }
    }
}
