//! Folders in the layouts of others: whose they are, of what scene, and what they hold.

use super::error::DatasetError;
use crate::command::error::BenchError;
use crate::result::output_folder::OutputFolder;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use vantage_dataset::InstanceId;
use vantage_dataset::layout::Inventory;
use vantage_dataset::store::Provenance;
use vantage_sim::rollout::Rollout;

/// File that says whose a folder is.
pub const CLAIM: &str = "dataset.json";

/// Makes the folder ours, or finds that it is, of the same scene, split and renderer.
pub fn claim(root: &Path, provenance: &Provenance) -> Result<(), BenchError> {
    let path = root.join(CLAIM);
    if let Ok(text) = fs::read(&path) {
        return match serde_json::from_slice::<Provenance>(&text) {
            Ok(found) if found == *provenance => Ok(()),
            Ok(found) => Err(other_data(root, &found, provenance)),
            Err(_) => Err(BenchError::NotOurs { folder: root.to_owned() }),
        };
    }
    if fs::read_dir(root).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(BenchError::NotOurs { folder: root.to_owned() });
    }
    Ok(OutputFolder::probe(root)?.write(CLAIM, &serde_json::to_vec_pretty(provenance)?)?)
}

/// That a folder holds data which are not those asked for, and in what they differ.
pub fn other_data(folder: &Path, found: &Provenance, asked: &Provenance) -> BenchError {
    let parts: [(&str, &[&str]); 4] = [
        ("scene", &["scene", "scene_hash", "meshes", "fixtures"]),
        ("split", &["split"]),
        ("renderer", &["renderer"]),
        ("program", &["code"]),
    ];
    let differs = |what: &&str| found.get(*what) != asked.get(*what);
    let differing = parts.iter().filter(|(_, entries)| entries.iter().any(differs));
    let mut names: Vec<&str> = differing.map(|(name, _)| *name).collect();
    if names.is_empty() {
        names.push("program");
    }
    DatasetError::OtherData { folder: folder.to_owned(), differs: names.join(" and ") }.into()
}

/// Enters the licence of each mesh that is in a world, by the object that it is of.
pub fn add_licences(inventory: &mut Inventory, licences: &BTreeMap<InstanceId, String>, rollout: &Rollout) {
    for object in &rollout.world.objects {
        if let Some(licence) = licences.get(&object.original) {
            inventory.add_licence(object.id, licence);
        }
    }
}
