//! A trained viewpoint-dependent model, loaded from its folder and run by tract.

use crate::canary::{CANARY, Canary, TOLERANCE, deviation};
use crate::error::ModelError;
use crate::latent::{LatentGaussian, LatentLayout};
use crate::manifest::{FORMAT, GraphRecord, MANIFEST, Manifest, Role, VERSION, conditioning_names};
use crate::onnx::OPSET;
use crate::onnx::graph::Graph;
use crate::residual::ResidualNoise;
use nalgebra::{DMatrix, DVector};
use serde::de::DeserializeOwned;
use std::io::Read;
use std::path::{Path, PathBuf};
use vantage_dataset::crop::{CROP_BYTES, CROP_SIDE};
use vantage_dataset::viewpoint::CONDITIONING;
use vantage_dataset::{Crop, Viewpoint};

/// Bytes of the largest file read from a model folder.
pub const LARGEST_FILE: u64 = 256 << 20;

/// `q(e | z, x_rel)` and `p(z | e, x_rel)` of Eq. 10-12, and the reduced measurement `m(z)` of IV-C.
pub struct ViewpointModel {
    manifest: Manifest,
    hash: String,
    encoder: Graph,
    measurement: Graph,
    decoder: Graph,
    decoder_jacobian: Graph,
    image: Graph,
}

/// A predicted measurement and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// `m(e, x)`, `[d_m]`.
    pub measurement: DVector<f64>,
    /// `d m / d e`, `[d_m, latent]`.
    pub d_latent: DMatrix<f64>,
    /// `d m / d x`, `[d_m, CONDITIONING]`, by the conditioning's numbers as if they were independent;
    /// multiply by [`Conditioning::jacobian`](vantage_dataset::viewpoint::Conditioning::jacobian).
    pub d_conditioning: DMatrix<f64>,
}

impl ViewpointModel {
    /// Loads a folder as [`train`](crate::train) wrote it.
    ///
    /// Nothing in the folder is trusted: versions, sizes, names, shapes, operators, finite weights and hashes
    /// are checked, external data is refused, and the canary must come out as it did in training.
    pub fn load(folder: &Path) -> Result<Self, ModelError> {
        let path = folder.join(MANIFEST);
        let bytes = read(&path)?;
        let hash = blake3::hash(&bytes).to_hex().to_string();
        check_version(&path, &bytes)?;
        let manifest: Manifest = parse(&path, &bytes)?;
        check_manifest(&path, &manifest)?;
        let graph = |role: Role| load_graph(folder, role, &manifest.graphs[&role]);
        let model = Self {
            encoder: graph(Role::Encoder)?,
            measurement: graph(Role::Measurement)?,
            decoder: graph(Role::Decoder)?,
            decoder_jacobian: graph(Role::DecoderJacobian)?,
            image: graph(Role::Image)?,
            manifest,
            hash,
        };
        model.replay_canary(folder)?;
        Ok(model)
    }

    /// `m(z)`, `[d_m]`.
    pub fn measure(&self, crop: &Crop) -> Result<DVector<f64>, ModelError> {
        let [m] = self.run(Role::Measurement, [&crop.to_chw()])?;
        Ok(widened(&m))
    }

    /// The factor `q` of one view on the latent, to be combined by [`LatentGaussian::posterior`].
    pub fn encode(&self, crop: &Crop, viewpoint: &Viewpoint) -> Result<LatentGaussian, ModelError> {
        let x = narrowed(&viewpoint.conditioning());
        let [mean, log_variance] = self.run(Role::Encoder, [&crop.to_chw(), &x])?;
        Ok(LatentGaussian { mean: widened(&mean), variance: widened(&log_variance).map(f64::exp) })
    }

    /// `m(e, x)`, `[d_m]`, of a latent and a viewpoint's conditioning.
    pub fn predict(
        &self,
        latent: &DVector<f64>,
        x: &[f64; CONDITIONING],
    ) -> Result<DVector<f64>, ModelError> {
        let [m] = self.run(Role::Decoder, [&narrowed(latent.as_slice()), &narrowed(x)])?;
        Ok(widened(&m))
    }

    /// [`ViewpointModel::predict`] with its derivatives.
    pub fn linearize(
        &self,
        latent: &DVector<f64>,
        x: &[f64; CONDITIONING],
    ) -> Result<Linearization, ModelError> {
        let inputs = [&narrowed(latent.as_slice())[..], &narrowed(x)];
        let [m, d_latent, d_conditioning] = self.run(Role::DecoderJacobian, inputs)?;
        let rows = m.len();
        let matrix = |data: &[f32]| {
            DMatrix::from_row_iterator(rows, data.len() / rows, data.iter().map(|&v| f64::from(v)))
        };
        Ok(Linearization {
            measurement: widened(&m),
            d_latent: matrix(&d_latent),
            d_conditioning: matrix(&d_conditioning),
        })
    }

    /// The crop expected of a latent from a viewpoint.
    pub fn reconstruct(&self, latent: &DVector<f64>, x: &[f64; CONDITIONING]) -> Result<Crop, ModelError> {
        let [planes] = self.run(Role::Image, [&narrowed(latent.as_slice()), &narrowed(x)])?;
        Ok(crop_of(&planes))
    }

    /// Noise of `m(z) - m(e, x)`.
    pub fn noise(&self) -> &ResidualNoise {
        &self.manifest.residual
    }

    /// How the latent is laid out.
    pub fn latent(&self) -> LatentLayout {
        self.manifest.architecture.latent
    }

    /// Numbers in the reduced measurement.
    pub fn measurement_dim(&self) -> usize {
        self.manifest.architecture.measurement
    }

    /// BLAKE3 of the manifest, which holds the hashes of all other files: the model's identity.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Where the model came from, and what it holds.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn graph(&self, role: Role) -> &Graph {
        match role {
            Role::Encoder => &self.encoder,
            Role::Measurement => &self.measurement,
            Role::Decoder => &self.decoder,
            Role::DecoderJacobian => &self.decoder_jacobian,
            Role::Image => &self.image,
        }
    }

    fn run<const IN: usize, const OUT: usize>(
        &self,
        role: Role,
        inputs: [&[f32]; IN],
    ) -> Result<[Vec<f32>; OUT], ModelError> {
        let outputs = self.graph(role).run(&inputs).map_err(|source| ModelError::Run { role, source })?;
        Ok(outputs.try_into().expect("a checked graph has the outputs of its role"))
    }

    fn replay_canary(&self, folder: &Path) -> Result<(), ModelError> {
        let path = folder.join(CANARY);
        let bytes = read(&path)?;
        let canary: Canary = parse(&path, &bytes)?;
        check_hash(&path, &bytes, &self.manifest.canary.blake3)?;
        if !(0.0..=TOLERANCE).contains(&canary.tolerance) {
            let got = canary.tolerance.to_string();
            return Err(contradiction(&path, "tolerance", got, &format!("0 to {TOLERANCE}")));
        }
        let covered = |role| canary.cases.iter().any(|case| case.role == role);
        if let Some(missing) = Role::ALL.into_iter().find(|&role| !covered(role)) {
            return Err(contradiction(&path, "cases", format!("none of {missing:?}"), "one of each graph"));
        }
        for case in &canary.cases {
            let graph = self.graph(case.role);
            let path = || folder.join(case.role.file());
            let inputs: Vec<_> = case.inputs.iter().map(Vec::as_slice).collect();
            let outputs = graph.run(&inputs).map_err(|source| ModelError::Graph { path: path(), source })?;
            for (index, spec) in graph.signature().outputs.iter().enumerate() {
                let got =
                    case.outputs.get(index).map_or(f32::INFINITY, |out| deviation(&outputs[index], out));
                if got > canary.tolerance {
                    let (output, tolerance) = (spec.name.clone(), canary.tolerance);
                    return Err(ModelError::Canary { path: path(), output, got, tolerance });
                }
            }
        }
        Ok(())
    }
}

impl std::fmt::Debug for ViewpointModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ViewpointModel({})", self.hash)
    }
}

fn read(path: &Path) -> Result<Vec<u8>, ModelError> {
    let failed = |source| ModelError::Read { path: path.to_owned(), source };
    let file = std::fs::File::open(path).map_err(failed)?;
    let bytes = file.metadata().map_err(failed)?.len();
    if bytes > LARGEST_FILE {
        return Err(ModelError::TooLarge { path: path.to_owned(), bytes, limit: LARGEST_FILE });
    }
    let mut content = Vec::new();
    file.take(LARGEST_FILE).read_to_end(&mut content).map_err(failed)?;
    Ok(content)
}

fn parse<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, ModelError> {
    serde_json::from_slice(bytes).map_err(|source| ModelError::Json { path: path.to_owned(), source })
}

/// Before the fields of another version are misread as faults of this one.
fn check_version(path: &Path, bytes: &[u8]) -> Result<(), ModelError> {
    let value: serde_json::Value = parse(path, bytes)?;
    let (format, version) = (&value["format"], &value["version"]);
    if format.as_str() == Some(FORMAT) && version.as_u64() == Some(u64::from(VERSION)) {
        return Ok(());
    }
    let expected = format!("{FORMAT:?} version {VERSION}");
    Err(ModelError::Version { path: path.to_owned(), got: format!("{format} version {version}"), expected })
}

fn contradiction(path: &Path, field: &str, got: String, expected: &str) -> ModelError {
    ModelError::Manifest { path: path.to_owned(), field: field.into(), got, expected: expected.into() }
}

fn check_manifest(path: &Path, manifest: &Manifest) -> Result<(), ModelError> {
    if manifest.opset != OPSET {
        return Err(contradiction(path, "opset", manifest.opset.to_string(), &OPSET.to_string()));
    }
    if manifest.conditioning != conditioning_names() {
        let got = format!("{:?}", manifest.conditioning);
        return Err(contradiction(path, "conditioning", got, &format!("{:?}", conditioning_names())));
    }
    if manifest.canary.file != CANARY {
        return Err(contradiction(path, "canary.file", manifest.canary.file.clone(), CANARY));
    }
    let architecture = &manifest.architecture;
    let (latent, m) = (architecture.latent, architecture.measurement);
    let sizes = [m, latent.invariant, latent.pairs_per_harmonic];
    if sizes.iter().any(|&size| size == 0 || size > 65_536) {
        return Err(contradiction(path, "architecture", format!("{sizes:?}"), "sizes of 1 to 65536"));
    }
    for role in Role::ALL {
        let field = || format!("graphs.{role:?}");
        let record = manifest.graphs.get(&role);
        let record = record.ok_or_else(|| contradiction(path, &field(), "missing".into(), "a graph"))?;
        if record.file != role.file() {
            return Err(contradiction(path, &field(), record.file.clone(), role.file()));
        }
        let expected = role.signature(latent.dimension(), m);
        if record.signature != expected {
            let got = format!("{:?}", record.signature);
            return Err(contradiction(path, &field(), got, &format!("{expected:?}")));
        }
    }
    match manifest.residual.fault(m) {
        Some(fault) => Err(contradiction(path, "residual", fault, "the noise of the measurement")),
        None => Ok(()),
    }
}

fn check_hash(path: &Path, bytes: &[u8], expected: &str) -> Result<(), ModelError> {
    let got = blake3::hash(bytes).to_hex().to_string();
    if got == expected {
        return Ok(());
    }
    Err(ModelError::Hash { path: path.to_owned(), got, expected: expected.to_owned() })
}

/// The hash is checked last, so that a damaged file is named by its damage where that can be told.
fn load_graph(folder: &Path, role: Role, record: &GraphRecord) -> Result<Graph, ModelError> {
    let path: PathBuf = folder.join(role.file());
    let bytes = read(&path)?;
    let graph = Graph::from_bytes(&bytes, &record.signature);
    let graph = graph.map_err(|source| ModelError::Graph { path: path.clone(), source })?;
    check_hash(&path, &bytes, &record.blake3)?;
    Ok(graph)
}

fn narrowed(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|&number| number as f32).collect()
}

fn widened(numbers: &[f32]) -> DVector<f64> {
    DVector::from_iterator(numbers.len(), numbers.iter().map(|&number| f64::from(number)))
}

/// A crop of planes `[3, 32, 32]` in `[0, 1]`.
pub(crate) fn crop_of(planes: &[f32]) -> Crop {
    let pixels = CROP_SIDE * CROP_SIDE;
    let mut crop = Crop::black();
    for index in 0..CROP_BYTES {
        let value = planes[(index % 3) * pixels + index / 3];
        crop.0[index] = (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    }
    crop
}
