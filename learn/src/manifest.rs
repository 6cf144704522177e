//! `model.yaml`: what a model folder holds, and where it came from.

use crate::architecture::Architecture;
use crate::error::ModelError;
use crate::latent::Latent;
use crate::onnx::{Signature, TensorSpec};
use crate::residual::ResidualNoise;
use crate::role::{Convention, Kind, Role, Sizes};
use crate::spec::TrainingSpec;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize, Serializer};
use serde_saphyr::FlowMap;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::{Component, Path};
use vantage_dataset::Seed;

/// The manifest's file; written last, so that a folder without it is not a model.
pub const MANIFEST: &str = "model.yaml";
/// Format written and read.
pub const FORMAT: &str = "vantage model";
/// Version of the format written and read.
pub const VERSION: u32 = 2;
/// Largest size of a latent and of a measurement.
const LARGEST_SIZE: usize = 65_536;

/// `model.yaml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// `vantage model`.
    pub format: String,
    /// 2, the version written and read.
    pub version: u32,
    /// What the model is.
    pub kind: Kind,
    /// Numbers in a latent, and how they are laid out.
    pub latent: Latent,
    /// Numbers in the reduced measurement; an embedding has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measurement: Option<usize>,
    /// What the networks are told of the viewpoint; an embedding is told nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conditioning: Option<Convention>,
    /// The graphs.
    pub graphs: BTreeMap<Role, GraphRecord>,
    /// Noise of the reduced measurement; an embedding has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual: Option<ResidualNoise>,
    /// Where the model came from.
    pub training: TrainingRecord,
    /// Inputs with their maker's outputs, which a loader replays. Written last: a manifest that was cut short lacks it, or some of its hash.
    pub canary: FileRecord,
}

/// A file of the folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// Its name.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

/// A graph of the folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraphRecord {
    /// Its name.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Shapes of its inputs, by name.
    #[serde(serialize_with = "on_one_line")]
    pub inputs: BTreeMap<String, Vec<usize>>,
    /// Shapes of its outputs, by name.
    #[serde(serialize_with = "on_one_line")]
    pub outputs: BTreeMap<String, Vec<usize>>,
}

/// The birth certificate of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingRecord {
    /// Who or what made the model: a program and its version, a paper, an address.
    pub origin: String,
    /// Hash of the data it was trained on.
    pub data_hash: String,
    /// The instances it was trained or calibrated on, a line of 16 hexadecimal digits each: none of them is scored.
    pub instances: FileRecord,
    /// What else its maker says of the data: scene, renderer and so on.
    #[serde(default)]
    pub provenance: BTreeMap<String, String>,
    /// How it was trained, where this project's trainer did it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub details: Option<TrainingDetails>,
}

/// What this project's trainer records.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingDetails {
    /// Hash of the validation views.
    pub validation_hash: String,
    /// Seed of the training.
    pub seed: Seed,
    /// How it was trained.
    pub spec: TrainingSpec,
    /// Sizes of the networks.
    pub architecture: Architecture,
    /// Training instances.
    pub instances: usize,
    /// Training views.
    pub views: usize,
    /// Last loss of each stage.
    pub final_loss: BTreeMap<String, f64>,
}

impl FileRecord {
    /// The record of a file of these bytes.
    pub fn new(file: &str, bytes: &[u8]) -> Self {
        Self { file: file.into(), sha256: sha256(bytes) }
    }
}

impl GraphRecord {
    /// The record of a graph in a file of these bytes.
    pub fn new(file: &str, bytes: &[u8], signature: &Signature) -> Self {
        let shapes = |side: &[TensorSpec]| side.iter().map(|t| (t.name.clone(), t.shape.clone())).collect();
        let (inputs, outputs) = (shapes(&signature.inputs), shapes(&signature.outputs));
        Self { file: file.into(), sha256: sha256(bytes), inputs, outputs }
    }
}

impl Manifest {
    /// The manifest in the bytes of `path`: of this version, whole, and without contradiction.
    pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, ModelError> {
        check_version(path, bytes)?;
        let manifest: Self = yaml(path, bytes)?;
        manifest.check(path)?;
        Ok(manifest)
    }

    /// As YAML.
    #[cfg(feature = "train")]
    pub(crate) fn to_yaml(&self) -> Result<String, String> {
        let options = serde_saphyr::ser_options! { prefer_block_scalars: false };
        serde_saphyr::to_string_with_options(self, options).map_err(|error| error.to_string())
    }

    /// The sizes that decide the shapes of the graphs.
    pub fn sizes(&self) -> Sizes {
        Sizes {
            latent: self.latent.dimension,
            measurement: self.measurement.unwrap_or(0),
            conditioning: self.conditioning.map_or(0, Convention::numbers),
        }
    }

    fn check(&self, path: &Path) -> Result<(), ModelError> {
        let fault = |field: &str, got: String, expected: &str| {
            Err(ModelError::Manifest {
                path: path.into(),
                field: field.into(),
                got,
                expected: expected.into(),
            })
        };
        let in_range = |size: usize| (1..=LARGEST_SIZE).contains(&size);
        if !in_range(self.latent.dimension) {
            return fault("latent.dimension", self.latent.dimension.to_string(), "1 to 65536");
        }
        if let Some(layout) = self.latent.steerable {
            let sizes = [layout.invariant, layout.pairs_per_harmonic];
            if !sizes.into_iter().all(in_range) || layout.dimension() != self.latent.dimension {
                let expected =
                    format!("invariant + 10 pairs_per_harmonic = {}, both at least 1", self.latent.dimension);
                let got = format!("invariant {} and pairs_per_harmonic {}", sizes[0], sizes[1]);
                return fault("latent.steerable", got, &expected);
            }
        }
        if self.kind == Kind::Embedding {
            if let Some(size) = self.measurement {
                return fault("measurement", size.to_string(), "none in an embedding");
            }
            if self.residual.is_some() {
                return fault("residual", "there".into(), "none in an embedding");
            }
        } else {
            let size = self.measurement.filter(|&size| in_range(size));
            let Some(size) = size else {
                let got = self.measurement.map_or("missing".into(), |size| size.to_string());
                return fault("measurement", got, "1 to 65536");
            };
            let Some(residual) = &self.residual else {
                return fault("residual", "missing".to_owned(), "the noise of the measurement");
            };
            if let Some([field, got, expected]) = residual.fault(size) {
                return fault(&format!("residual.{field}"), got, &expected);
            }
        }
        self.check_convention(path)?;
        self.check_graphs(path)?;
        check_record(path, "canary", &self.canary.file, &self.canary.sha256)?;
        let FileRecord { file, sha256 } = &self.training.instances;
        check_record(path, "training.instances", file, sha256)
    }

    fn check_convention(&self, path: &Path) -> Result<(), ModelError> {
        let expected = self.kind.conventions();
        let fits = match self.conditioning {
            Some(convention) => expected.contains(&convention),
            None => expected.is_empty(),
        };
        if fits {
            return Ok(());
        }
        let names: Vec<_> = expected.iter().map(Convention::to_string).collect();
        let expected = if names.is_empty() { "none".to_owned() } else { names.join(" or ") };
        Err(ModelError::Manifest {
            path: path.into(),
            field: "conditioning".into(),
            got: self.conditioning.map_or("missing".into(), |convention| convention.to_string()),
            expected: format!("{expected} in a model of kind {}", self.kind),
        })
    }

    fn check_graphs(&self, path: &Path) -> Result<(), ModelError> {
        let fault = |role: Role, what: &str, got: String, expected: String| {
            let field = format!("graphs.{role}{what}");
            Err(ModelError::Manifest { path: path.into(), field, got, expected })
        };
        let required = |&&(role, required): &&(Role, bool)| required && !self.graphs.contains_key(&role);
        if let Some(&(role, _)) = self.kind.roles().iter().find(required) {
            return fault(role, "", "missing".into(), format!("a graph, in a model of kind {}", self.kind));
        }
        for (&role, record) in &self.graphs {
            let Some(signature) = self.kind.signature(role, self.sizes()) else {
                let roles: Vec<_> = self.kind.roles().iter().map(|(role, _)| role.name()).collect();
                let expected = format!("only {} in a model of kind {}", roles.join(", "), self.kind);
                return fault(role, "", "there".into(), expected);
            };
            check_record(path, &format!("graphs.{role}"), &record.file, &record.sha256)?;
            let expected = GraphRecord::new(&record.file, &[], &signature);
            for (what, got, expected) in [
                (".inputs", &record.inputs, expected.inputs),
                (".outputs", &record.outputs, expected.outputs),
            ] {
                if *got != expected {
                    return fault(role, what, format!("{got:?}"), format!("{expected:?}"));
                }
            }
        }
        Ok(())
    }
}

/// SHA-256 in hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A file must lie in the folder itself.
fn check_record(path: &Path, field: &str, file: &str, sha256: &str) -> Result<(), ModelError> {
    let fault = |part: &str, got: &str, expected: &str| {
        let (field, got) = (format!("{field}.{part}"), format!("{got:?}"));
        Err(ModelError::Manifest { path: path.into(), field, got, expected: expected.into() })
    };
    let mut components = Path::new(file).components();
    let plain = matches!(components.next(), Some(Component::Normal(name)) if name == file);
    if !plain || components.next().is_some() {
        return fault("file", file, "the name of a file in the model's folder");
    }
    let digit = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
    if sha256.len() != 64 || !sha256.bytes().all(digit) {
        return fault("sha256", sha256, "64 hexadecimal digits in lower case, in quotes");
    }
    Ok(())
}

/// Before the fields of another version are misread as faults of this one.
fn check_version(path: &Path, bytes: &[u8]) -> Result<(), ModelError> {
    let value: serde_json::Value = yaml(path, bytes)?;
    let (format, version) = (&value["format"], &value["version"]);
    if format.as_str() == Some(FORMAT) && version.as_u64() == Some(u64::from(VERSION)) {
        return Ok(());
    }
    let expected = format!("{FORMAT:?} version {VERSION}");
    Err(ModelError::Version { path: path.to_owned(), got: format!("{format} version {version}"), expected })
}

/// YAML without aliases that explode, doubled keys or numbers that are not finite; JSON is YAML, too.
fn yaml<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, ModelError> {
    let invalid = |message| ModelError::Yaml { path: path.to_owned(), message };
    let text = std::str::from_utf8(bytes).map_err(|error| invalid(error.to_string()))?;
    let options = serde_saphyr::options! {
        budget: serde_saphyr::budget! { max_nodes: 200_000, max_depth: 16, max_aliases: 0 },
        duplicate_keys: serde_saphyr::options::DuplicateKeyPolicy::Error,
        non_finite_float_policy: serde_saphyr::options::NonFiniteFloatPolicy::Reject,
        reject_unsupported_tags: true,
        strict_booleans: true,
    };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let name = path.to_string_lossy();
        let render = serde_saphyr::render_options! {
            formatter: &serde_saphyr::UserMessageFormatter,
            source_name: Some(name.as_ref()),
        };
        invalid(error.render_with_options(render))
    })
}

fn on_one_line<S: Serializer>(
    shapes: &BTreeMap<String, Vec<usize>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    FlowMap(shapes).serialize(serializer)
}
