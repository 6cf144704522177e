//! What a model is trained from, and the hash that tells one training from another.

use crate::architecture::Architecture;
use crate::manifest::VERSION;
use crate::spec::TrainingSpec;
use std::collections::BTreeMap;
use vantage_dataset::Seed;

/// What a model is trained from.
pub(crate) struct Origin {
    pub(crate) data_hash: String,
    pub(crate) validation_hash: String,
    pub(crate) provenance: BTreeMap<String, String>,
}

impl Origin {
    /// Hash of everything that decides what a training does.
    pub(crate) fn key(
        &self,
        spec: &TrainingSpec,
        architecture: &Architecture,
        tags: &[Option<usize>],
        seed: Seed,
    ) -> String {
        let trainer = env!("CARGO_PKG_VERSION");
        let decides = (
            VERSION,
            trainer,
            &self.data_hash,
            &self.validation_hash,
            &self.provenance,
            spec,
            architecture,
            tags,
            seed,
        );
        let json = serde_json::to_vec(&decides).expect("numbers and strings become JSON");
        blake3::hash(&json).to_hex().to_string()
    }
}
