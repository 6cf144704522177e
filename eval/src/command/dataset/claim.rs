//! Folders in the layouts of others: whose they are, and of what scene.

use crate::exit::BenchError;
use crate::output::OutputFolder;
use std::fs;
use std::path::Path;
use vantage_dataset::store::Provenance;

const NAME: &str = "dataset.json";

/// Makes the folder ours, or finds that it is, of the same scene, split and renderer.
pub fn claim(root: &Path, provenance: &Provenance) -> Result<(), BenchError> {
    let path = root.join(NAME);
    if let Ok(text) = fs::read(&path) {
        let found: Option<Provenance> = serde_json::from_slice(&text).ok();
        return match found {
            Some(found) if found == *provenance => Ok(()),
            _ => Err(BenchError::OtherData { folder: root.to_owned() }),
        };
    }
    if fs::read_dir(root).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(BenchError::NotOurs { folder: root.to_owned() });
    }
    Ok(OutputFolder::probe(root)?.write(NAME, &serde_json::to_vec_pretty(provenance)?)?)
}
