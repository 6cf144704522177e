//! `model.json`: what a model folder holds, and where it came from.

use crate::architecture::Architecture;
use crate::onnx::{Signature, TensorSpec};
use crate::residual::ResidualNoise;
use crate::spec::TrainingSpec;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::Seed;
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::viewpoint::{CONDITIONING, HARMONICS};

/// The manifest's file; written last, so that a folder without it is not a model.
pub const MANIFEST: &str = "model.json";
/// Format written and read.
pub const FORMAT: &str = "vantage viewpoint-dependent model";
/// Version of the format written and read.
pub const VERSION: u32 = 1;

/// A graph of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// `q(e | z, x_rel)`: crop and conditioning to mean and log variance of a view's factor on the latent.
    Encoder,
    /// `m(z)`: crop to reduced measurement.
    Measurement,
    /// `p(m | e, x_rel)`: latent and conditioning to reduced measurement.
    Decoder,
    /// The decoder with its derivatives to the latent and to the conditioning.
    DecoderJacobian,
    /// `p(z | e, x_rel)`: latent and conditioning to crop.
    Image,
}

impl Role {
    /// All roles.
    pub const ALL: [Role; 5] =
        [Role::Encoder, Role::Measurement, Role::Decoder, Role::DecoderJacobian, Role::Image];

    /// Its file in the folder.
    pub fn file(self) -> &'static str {
        match self {
            Role::Encoder => "encoder.onnx",
            Role::Measurement => "measurement.onnx",
            Role::Decoder => "decoder.onnx",
            Role::DecoderJacobian => "decoder_jacobian.onnx",
            Role::Image => "image.onnx",
        }
    }

    /// Its tensors: batch of 1, crops `[1, 3, 32, 32]` in `[0, 1]` (channel, row, column).
    pub fn signature(self, latent: usize, measurement: usize) -> Signature {
        let crop = TensorSpec::new("crop", &[1, 3, CROP_SIDE, CROP_SIDE]);
        let conditioning = TensorSpec::new("conditioning", &[1, CONDITIONING]);
        let latent_vector = |name| TensorSpec::new(name, &[1, latent]);
        let m = TensorSpec::new("measurement", &[1, measurement]);
        let from_latent = vec![latent_vector("latent"), conditioning.clone()];
        let (inputs, outputs) = match self {
            Role::Encoder => {
                (vec![crop, conditioning], vec![latent_vector("mean"), latent_vector("log_variance")])
            }
            Role::Measurement => (vec![crop], vec![m]),
            Role::Decoder => (from_latent, vec![m]),
            Role::DecoderJacobian => {
                let d_latent = TensorSpec::new("d_latent", &[measurement, latent]);
                let d_conditioning = TensorSpec::new("d_conditioning", &[measurement, CONDITIONING]);
                (from_latent, vec![m, d_latent, d_conditioning])
            }
            Role::Image => (from_latent, vec![crop]),
        };
        Signature { inputs, outputs }
    }
}

/// The names of the conditioning's numbers, in order: see
/// [`Viewpoint::conditioning`](vantage_dataset::Viewpoint::conditioning).
pub fn conditioning_names() -> Vec<String> {
    let azimuth = (1..=HARMONICS).flat_map(|m| [format!("cos {m} azimuth"), format!("sin {m} azimuth")]);
    let upright = ["sin elevation", "cos roll", "sin roll", "log(distance / size)"];
    azimuth.chain(upright.map(String::from)).collect()
}

/// `model.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// `vantage viewpoint-dependent model`.
    pub format: String,
    /// 1, the version written and read.
    pub version: u32,
    /// ONNX operator set of the graphs.
    pub opset: i64,
    /// Sizes of the networks and layout of the latent.
    pub architecture: Architecture,
    /// What the conditioning's numbers are, in order.
    pub conditioning: Vec<String>,
    /// The graphs.
    pub graphs: BTreeMap<Role, GraphRecord>,
    /// Noise of the reduced measurement.
    pub residual: ResidualNoise,
    /// Inputs with the trainer's outputs, which a loader replays.
    pub canary: FileRecord,
    /// Where the model came from.
    pub training: TrainingRecord,
}

/// A file of the folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// Its name.
    pub file: String,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

/// A graph of the folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraphRecord {
    /// Its name.
    pub file: String,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
    /// Its tensors.
    pub signature: Signature,
}

/// The birth certificate of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingRecord {
    /// Hash of the training views.
    pub data_hash: String,
    /// Hash of the validation views.
    pub validation_hash: String,
    /// What the maker of the views says of them: scene, renderer and so on.
    pub provenance: BTreeMap<String, String>,
    /// Seed of the training.
    pub seed: Seed,
    /// How it was trained.
    pub spec: TrainingSpec,
    /// Training instances.
    pub instances: usize,
    /// Training views.
    pub views: usize,
    /// Last loss of each stage.
    pub final_loss: BTreeMap<String, f64>,
    /// Version of this crate.
    pub trainer: String,
}
