//! The name of an entry: a hash of everything that can change it.

use super::super::{FORMAT, StoreError};
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt;

/// Names what a stage makes from given inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    stage: String,
    inputs: Value,
    hash: String,
}

impl Key {
    /// The key of `stage` (lower-case letters, digits and `_`) on `inputs`: everything that can change its result,
    /// such as checked scene, options, seeds, keys of earlier stages, and a version of the stage's own code.
    ///
    /// Equal inputs give equal keys whatever the order of their fields. A float that is not finite counts as absent.
    pub fn new(stage: &str, inputs: &impl Serialize) -> Result<Self, StoreError> {
        let refused = |reason: String| StoreError::Key { stage: stage.to_owned(), reason };
        let plain = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_';
        if stage.is_empty() || stage.len() > 64 || !stage.bytes().all(plain) {
            return Err(refused("the name must be 1 to 64 lower-case letters, digits or '_'".to_owned()));
        }
        let mut inputs = serde_json::to_value(inputs).map_err(|e| refused(e.to_string()))?;
        inputs.sort_all_objects();
        let mut canonical = json!({ "format": FORMAT, "inputs": inputs, "stage": stage });
        canonical.sort_all_objects();
        let hash = blake3::hash(canonical.to_string().as_bytes()).to_hex().to_string();
        Ok(Self { stage: stage.to_owned(), inputs, hash })
    }

    /// The stage.
    pub fn stage(&self) -> &str {
        &self.stage
    }

    /// The inputs, as hashed.
    pub fn inputs(&self) -> &Value {
        &self.inputs
    }

    /// BLAKE3 of the canonical description, 64 hexadecimal digits.
    pub fn hash(&self) -> &str {
        &self.hash
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.stage, self.hash)
    }
}
