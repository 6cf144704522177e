//! Hash of the source files of all crates, byte by byte: whether a checkout holds what a program was built from.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Folders of sources, from the workspace's root.
pub const FOLDERS: [&str; 6] = ["dataset/src", "model/src", "sim/src", "learn/src", "slam/src", "eval/src"];

/// Hash of all files in the folders of a workspace, with their names.
pub fn hash(root: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    for folder in FOLDERS {
        add(&mut hasher, root, Path::new(folder))?;
    }
    Ok(hasher.finalize().to_hex().to_string())
}

fn add(hasher: &mut blake3::Hasher, root: &Path, path: &Path) -> io::Result<()> {
    if root.join(path).is_dir() {
        let entries = fs::read_dir(root.join(path))?.map(|entry| Ok(path.join(entry?.file_name())));
        let mut entries: Vec<PathBuf> = entries.collect::<io::Result<_>>()?;
        entries.sort();
        return entries.iter().try_for_each(|entry| add(hasher, root, entry));
    }
    for part in [path.to_string_lossy().as_bytes(), &fs::read(root.join(path))?] {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
    }
    Ok(())
}
