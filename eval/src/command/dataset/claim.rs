//! Folders in the layouts of others: whose they are, of what scene, and what they hold.

use super::error::DatasetError;
use crate::command::error::BenchError;
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::InstanceId;
use vantage_dataset::store::Provenance;
use vantage_formats::Inventory;
use vantage_sim::rollout::Rollout;

/// The dataset of parts in a folder, begun or gone on with: of a provenance that is the same in the entries that are `reaching` its files.
pub fn claimed(
    root: &Path,
    layout: &str,
    provenance: &Provenance,
    reaching: impl Fn(&str) -> bool,
) -> Result<Inventory, BenchError> {
    let mut inventory = Inventory::begin(root, layout, provenance.clone())?;
    let of = |provenance: &Provenance| -> Provenance {
        provenance.clone().into_iter().filter(|(what, _)| reaching(what)).collect()
    };
    let (asked, before) = (of(provenance), inventory.before().map(of));
    if let Some(before) = before.filter(|before| *before != asked) {
        return Err(other_data(root, &before, &asked));
    }
    inventory.claim()?;
    Ok(inventory)
}

/// Whether an entry of a provenance reaches the files of each seed.
pub fn of_each_seed(what: &str) -> bool {
    what != "seeds"
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
