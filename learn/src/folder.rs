//! A model folder at the door: nothing in it is trusted.

use crate::canary::Canary;
use crate::derivatives::check_derivatives;
use crate::error::ModelError;
use crate::file::read;
use crate::manifest::{FileRecord, MANIFEST, Manifest, sha256};
use crate::onnx::graph::Graph;
use crate::residual::ResidualNoise;
use crate::role::Role;
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZero;
use std::path::Path;
use std::thread::available_parallelism;
use vantage_dataset::InstanceId;
use vantage_model::LatentGaussian;

/// Bytes of the largest file read from a model folder.
pub const LARGEST_FILE: u64 = 256 << 20;
/// Crops of which the encoder keeps what depends on them alone, for each thread: a search for an orientation asks for so many in turn.
const ENCODINGS_KEPT: usize = 16;
/// The same, for all threads.
const MOST_ENCODINGS_KEPT: usize = 256;

/// What every kind of model is made of: its manifest, and its graphs, checked and ready to run.
pub(crate) struct ModelFolder {
    pub(crate) manifest: Manifest,
    /// BLAKE3 of the manifest, which holds the hashes of all other files.
    pub(crate) hash: String,
    pub(crate) training_instances: BTreeSet<InstanceId>,
    graphs: BTreeMap<Role, Graph>,
    canary: Canary,
}

impl ModelFolder {
    /// Versions, sizes, names, shapes, operators, finite weights and hashes are checked, external data is refused, and
    /// the canary must come out as it did where the model was made, and a Jacobian has to be one.
    pub(crate) fn load(folder: &Path) -> Result<Self, ModelError> {
        let path = folder.join(MANIFEST);
        let bytes = read(&path, LARGEST_FILE)?;
        let hash = blake3::hash(&bytes).to_hex().to_string();
        let manifest = Manifest::parse(&path, &bytes)?;
        let threads = available_parallelism().map_or(1, NonZero::get);
        let mut graphs = BTreeMap::new();
        for (&role, record) in &manifest.graphs {
            let path = folder.join(&record.file);
            let bytes = read(&path, LARGEST_FILE)?;
            let signature = manifest.kind.signature(role, manifest.sizes());
            let signature = signature.ok_or(ModelError::Absent { role })?;
            let graph = Graph::from_bytes(&bytes, &signature).map(|graph| match role {
                Role::Encoder => graph.keeping((ENCODINGS_KEPT * threads).min(MOST_ENCODINGS_KEPT)),
                _ => graph,
            });
            // The hash is checked last, so that a damaged file is named by its damage where that can be told.
            graphs.insert(role, graph.map_err(|source| ModelError::Graph { path: path.clone(), source })?);
            check_hash(&path, &bytes, &record.sha256)?;
        }
        let canary =
            Canary::parse(&folder.join(&manifest.canary.file), &read_recorded(folder, &manifest.canary)?)?;
        let training_instances = training_instances(folder, &manifest.training.instances)?;
        let model = Self { manifest, hash, training_instances, graphs, canary };
        model.replay_canary(folder)?;
        Ok(model)
    }

    /// The noise of the measurement, of a kind that has one.
    pub(crate) fn noise(&self) -> &ResidualNoise {
        self.manifest.residual.as_ref().expect("a checked manifest of this kind has it")
    }

    /// Whether there is such a graph.
    pub(crate) fn has(&self, role: Role) -> bool {
        self.graphs.contains_key(&role)
    }

    /// Runs a graph: one slice an input, one vector an output.
    pub(crate) fn run<const IN: usize, const OUT: usize>(
        &self,
        role: Role,
        inputs: [&[f32]; IN],
    ) -> Result<[Vec<f32>; OUT], ModelError> {
        let graph = self.graphs.get(&role).ok_or(ModelError::Absent { role })?;
        let outputs = graph.run(&inputs).map_err(|source| ModelError::Run { role, source })?;
        Ok(outputs.try_into().expect("a checked graph has the outputs of its role"))
    }

    /// [`ModelFolder::run`] without a copy of the outputs.
    pub(crate) fn read<const IN: usize, const OUT: usize, T>(
        &self,
        role: Role,
        inputs: [&[f32]; IN],
        read: impl FnOnce([&[f32]; OUT]) -> T,
    ) -> Result<T, ModelError> {
        let graph = self.graphs.get(&role).ok_or(ModelError::Absent { role })?;
        let read = |outputs: &[&[f32]]| {
            read(outputs.try_into().expect("a checked graph has the outputs of its role"))
        };
        graph.read(&inputs, read).map_err(|source| ModelError::Run { role, source })
    }

    /// Runs a graph on its canary's input, as often as anyone likes, and each time as if for the first.
    pub(crate) fn replay(&self, role: Role) -> Result<(), ModelError> {
        let graph = self.graphs.get(&role).ok_or(ModelError::Absent { role })?;
        let case = self.canary.cases.iter().find(|case| case.role == role);
        let inputs: Vec<_> = case.iter().flat_map(|case| &case.inputs).map(Vec::as_slice).collect();
        graph.forget();
        graph.run(&inputs).map_err(|source| ModelError::Run { role, source })?;
        Ok(())
    }

    fn replay_canary(&self, folder: &Path) -> Result<(), ModelError> {
        let covered = |role: &&Role| self.canary.cases.iter().any(|case| case.role == **role);
        if let Some(missing) = self.graphs.keys().find(|role| !covered(role)) {
            return Err(ModelError::Manifest {
                path: folder.join(&self.manifest.canary.file),
                field: "cases".into(),
                got: format!("none of {missing}"),
                expected: "one of each graph".into(),
            });
        }
        for case in &self.canary.cases {
            let graph = self.graphs.get(&case.role).ok_or_else(|| ModelError::Manifest {
                path: folder.join(&self.manifest.canary.file),
                field: "cases".into(),
                got: format!("one of {}", case.role),
                expected: format!("only of the graphs that {MANIFEST} lists"),
            })?;
            let path = || folder.join(&self.manifest.graphs[&case.role].file);
            let failed = |source| ModelError::Graph { path: path(), source };
            if let Some((output, got)) = case.worst(graph).map_err(failed)? {
                let tolerance = self.canary.tolerance;
                if got > tolerance {
                    return Err(ModelError::Canary { path: path(), output, got, tolerance });
                }
            }
            check_derivatives(&self.graphs, case, &path())?;
        }
        Ok(())
    }
}

impl std::fmt::Debug for ModelFolder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.hash)
    }
}

/// The instances of a list, a line each.
fn training_instances(folder: &Path, record: &FileRecord) -> Result<BTreeSet<InstanceId>, ModelError> {
    let path = folder.join(&record.file);
    let bytes = read_recorded(folder, record)?;
    let text = String::from_utf8_lossy(&bytes);
    let id = |(index, line): (usize, &str)| {
        let id = u64::from_str_radix(line, 16).ok().filter(|_| line.len() == 16);
        id.map(InstanceId).ok_or_else(|| ModelError::Manifest {
            path: path.clone(),
            field: format!("line {}", index + 1),
            got: format!("{line:?}"),
            expected: "16 hexadecimal digits".into(),
        })
    };
    text.lines().enumerate().map(id).collect()
}

/// Bytes of a file whose hash is right.
fn read_recorded(folder: &Path, record: &FileRecord) -> Result<Vec<u8>, ModelError> {
    let path = folder.join(&record.file);
    let bytes = read(&path, LARGEST_FILE)?;
    check_hash(&path, &bytes, &record.sha256)?;
    Ok(bytes)
}

fn check_hash(path: &Path, bytes: &[u8], expected: &str) -> Result<(), ModelError> {
    let got = sha256(bytes);
    if got == expected {
        return Ok(());
    }
    Err(ModelError::Hash { path: path.to_owned(), got, expected: expected.to_owned() })
}

/// Numbers as a graph takes them.
pub(crate) fn narrowed(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|&number| number as f32).collect()
}

/// Numbers as a graph gives them.
pub(crate) fn widened(numbers: &[f32]) -> DVector<f64> {
    DVector::from_iterator(numbers.len(), numbers.iter().map(|&number| f64::from(number)))
}

/// A matrix `[rows, ..]`, row-major. Filled column by column, which takes a fifth of the time of `from_row_iterator`.
pub(crate) fn matrix(rows: usize, numbers: &[f32]) -> DMatrix<f64> {
    let columns = numbers.len() / rows;
    let mut by_column = Vec::with_capacity(numbers.len());
    for column in 0..columns {
        by_column.extend(numbers.chunks_exact(columns).map(|row| f64::from(row[column])));
    }
    DMatrix::from_vec(rows, columns, by_column)
}

/// A view's factor from its mean and log variance.
pub(crate) fn factor(mean: &[f32], log_variance: &[f32]) -> LatentGaussian {
    LatentGaussian { mean: widened(mean), variance: widened(log_variance).map(f64::exp) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoders_of_the_reference_models_keep_what_they_make_of_crops() {
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
        for name in ["objects", "predictive", "any"] {
            let folder = ModelFolder::load(&models.join(name)).unwrap();
            let keeping = folder.graphs.iter().filter(|(_, graph)| graph.keeps()).map(|(role, _)| *role);
            assert_eq!(keeping.collect::<Vec<_>>(), [Role::Encoder], "{name}");
        }
    }
}
