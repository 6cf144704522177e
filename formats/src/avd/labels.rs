//! Names of instances: which number means what, and which are present in a scan.

use crate::import::{FETCH_AGAIN, ImportError, read_file};
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::store::StoreError;

pub(super) const PRESENT: &str = "present_instance_names.txt";
pub(super) const ID_MAP: &str = "instance_id_map.txt";
/// Files of a dataset that number its objects.
pub const ID_MAPS: [&str; 2] = [ID_MAP, "all_instance_id_map.txt"];
pub(super) const JSON_MAP: &str = "avd_label_map.json";
const LARGEST: u64 = 1 << 20;

/// The name of each instance, from the first map that is found in the folder above the scan or in the scan.
pub(super) fn read(scan: &Path) -> Result<BTreeMap<u32, String>, ImportError> {
    let root = scan.parent().unwrap_or(scan);
    for folder in [root, scan] {
        for file in ID_MAPS {
            if let Some(names) = optional(read_text_map(&folder.join(file)))? {
                return Ok(names);
            }
        }
        if let Some(names) = optional(read_json_map(&folder.join(JSON_MAP)))? {
            return Ok(names);
        }
    }
    let expected = format!("{ID_MAP} or {JSON_MAP}");
    let remedy = "put the map of instances that the dataset comes with beside the scans";
    Err(ImportError::invalid(root, "map of instances", "none", expected, remedy))
}

/// The names of the instances in a scan, in the file's order; none where there is no file.
pub(super) fn read_present(scan: &Path) -> Result<Option<Vec<String>>, ImportError> {
    let bytes = optional(read_file(&scan.join(PRESENT), LARGEST))?;
    Ok(bytes.map(|bytes| {
        let text = String::from_utf8_lossy(&bytes);
        text.lines().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect()
    }))
}

/// Lines of a name and a number.
pub(super) fn read_text_map(path: &Path) -> Result<BTreeMap<u32, String>, ImportError> {
    let bytes = read_file(path, LARGEST)?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(index, line)| {
            let mut words = line.split_whitespace();
            match (words.next(), words.next().and_then(|id| id.parse().ok()), words.next()) {
                (Some(name), Some(id), None) => Ok((id, name.to_owned())),
                _ => {
                    let field = format!("line {}", index + 1);
                    Err(ImportError::invalid(path, field, line, "a name and a number", FETCH_AGAIN))
                }
            }
        })
        .collect()
}

fn read_json_map(path: &Path) -> Result<BTreeMap<u32, String>, ImportError> {
    let bytes = read_file(path, LARGEST)?;
    serde_json::from_slice(&bytes)
        .map_err(|error| ImportError::invalid(path, "map", error, "names by number", FETCH_AGAIN))
}

fn optional<T>(read: Result<T, ImportError>) -> Result<Option<T>, ImportError> {
    match read {
        Ok(value) => Ok(Some(value)),
        Err(error) if error.is_absence() => Ok(None),
        Err(error) => Err(error),
    }
}

/// Writes both maps into the folder above the scans.
pub(super) fn write(root: &Path, names: &BTreeMap<u32, String>) -> Result<(), StoreError> {
    let lines: String = names.iter().map(|(id, name)| format!("{name} {id}\n")).collect();
    put(&root.join(ID_MAP), lines.into_bytes())?;
    let real: BTreeMap<u32, &String> =
        names.iter().filter(|(id, _)| **id > 0).map(|(id, name)| (*id, name)).collect();
    let path = root.join(JSON_MAP);
    let bytes = serde_json::to_vec(&real).map_err(|error| StoreError::write(&path)(error.into()))?;
    put(&path, bytes)
}

/// Writes the names of the instances in a scan.
pub(super) fn write_present<'a>(scan: &Path, names: impl Iterator<Item = &'a str>) -> Result<(), StoreError> {
    put(&scan.join(PRESENT), names.flat_map(|name| [name, "\n"]).collect::<String>().into_bytes())
}

fn put(path: &Path, bytes: Vec<u8>) -> Result<(), StoreError> {
    std::fs::write(path, bytes).map_err(StoreError::write(path))
}
