//! Folders in the layouts of others: whose they are, of what scene, and what they hold.

use super::Source;
use super::images::licences;
use crate::exit::BenchError;
use crate::output::OutputFolder;
use std::fs;
use std::path::Path;
use vantage_dataset::layout::Inventory;
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

/// The manifest to be of such a folder, with the licences of the scene's meshes.
pub fn inventory(root: &Path, layout: &str, source: &Source<'_>) -> Result<Inventory, BenchError> {
    let mut inventory = Inventory::begin(root, layout, source.provenance.clone())?;
    for (instance, licence) in licences(source.scene) {
        inventory.add_licence(instance, &licence);
    }
    Ok(inventory)
}
