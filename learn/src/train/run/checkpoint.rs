//! Where a killed training goes on.

use super::curve::Curve;
use super::files;
use super::progress::Stage;
use crate::error::ModelError;
use crate::file::read;
use crate::train::error::TrainError;
use burn::module::Module;
use burn::store::ModuleRecord;
use burn::tensor::Bytes;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The checkpoint's file; removed when the model is complete.
pub const CHECKPOINT: &str = "training.checkpoint";

/// Bytes of the largest checkpoint that is read: ten million steps of a loss curve, and far more weights than any spec has.
const LARGEST: u64 = 4 << 30;
const MAGIC: &[u8] = b"vantage checkpoint 2\n";
const HASH: usize = blake3::OUT_LEN;

/// The state of a training after some step.
pub(crate) struct Checkpoint {
    pub(crate) state: State,
    /// The trunk with its head.
    pub(crate) trunk: Vec<u8>,
    /// Encoder and decoder, once their stage has begun.
    pub(crate) autoencoder: Vec<u8>,
    /// The optimiser of the current stage.
    pub(crate) optimizer: Vec<u8>,
}

/// The part of a checkpoint that is not tensors.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct State {
    /// Hash of everything that decides what the training does.
    pub(crate) key: String,
    pub(crate) stage: Stage,
    /// Steps of the stage that are done.
    pub(crate) step: usize,
    pub(crate) curve: Curve,
}

#[derive(Serialize, Deserialize)]
struct Header {
    state: State,
    trunk: usize,
    autoencoder: usize,
    optimizer: usize,
}

impl Checkpoint {
    /// Writes the checkpoint in place of the last one: magic, header length, header, tensors, BLAKE3 of all.
    pub(crate) fn write(&self, folder: &Path) -> Result<(), TrainError> {
        let path = folder.join(CHECKPOINT);
        let header = Header {
            state: self.state.clone(),
            trunk: self.trunk.len(),
            autoencoder: self.autoencoder.len(),
            optimizer: self.optimizer.len(),
        };
        let header = serde_json::to_vec(&header).map_err(|error| files::unwritable(&path, &error))?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend((header.len() as u64).to_le_bytes());
        for part in [&header, &self.trunk, &self.autoencoder, &self.optimizer] {
            bytes.extend_from_slice(part);
        }
        let hash = blake3::hash(&bytes);
        bytes.extend(hash.as_bytes());
        files::write(&path, &bytes)
    }

    /// The folder's checkpoint of a training of this key: none, or why it is of no use.
    pub(crate) fn read(folder: &Path, key: &str) -> Result<Option<Self>, String> {
        let bytes = match read(&folder.join(CHECKPOINT), LARGEST) {
            Ok(bytes) => bytes,
            Err(ModelError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error.to_string()),
        };
        let checkpoint = Self::parse(&bytes)?;
        if checkpoint.state.key != key {
            return Err("it is of other data, another spec or another seed".into());
        }
        Ok(Some(checkpoint))
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let damaged = || "it is cut short or damaged".to_owned();
        let (content, hash) = bytes.split_at_checked(bytes.len().saturating_sub(HASH)).ok_or_else(damaged)?;
        if blake3::hash(content).as_bytes() != hash {
            return Err(damaged());
        }
        let rest = content.strip_prefix(MAGIC).ok_or("it is of another format")?;
        let (length, rest) = rest.split_first_chunk::<8>().ok_or_else(damaged)?;
        let length = u64::from_le_bytes(*length) as usize;
        let (header, mut rest) = rest.split_at_checked(length).ok_or_else(damaged)?;
        let header: Header = serde_json::from_slice(header).map_err(|error| error.to_string())?;
        let mut part = |length: usize| {
            let (part, after) = rest.split_at_checked(length).ok_or_else(damaged)?;
            rest = after;
            Ok::<_, String>(part.to_vec())
        };
        let (trunk, autoencoder) = (part(header.trunk)?, part(header.autoencoder)?);
        let optimizer = part(header.optimizer)?;
        Ok(Self { state: header.state, trunk, autoencoder, optimizer })
    }
}

/// Moves a useless checkpoint out of the way, and says where to.
pub(crate) fn set_aside(folder: &Path) -> Result<PathBuf, TrainError> {
    let path = folder.join(CHECKPOINT);
    let aside = folder.join(format!("{CHECKPOINT}.unusable"));
    std::fs::rename(&path, &aside).map_err(|error| files::unwritable(&aside, &error))?;
    Ok(aside)
}

/// A module's parameters as bytes.
pub(crate) fn module_bytes<M: Module>(module: &M) -> Result<Vec<u8>, String> {
    let bytes = module.clone().into_record().into_bytes().map_err(|error| error.to_string())?;
    Ok(bytes.to_vec())
}

/// A module with the parameters of [`module_bytes`].
pub(crate) fn module_from<M: Module>(module: M, bytes: &[u8]) -> Result<M, String> {
    let record = ModuleRecord::from_bytes(Bytes::from_bytes_vec(bytes.to_vec()));
    let record = record.map_err(|error| error.to_string())?;
    module.try_load_record(record).map_err(|error| error.to_string())
}
