//! What `bench` carries in itself: the text of a constant that holds the scenes, the studies, the maps and the reference models.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// From the workspace's root.
const FOLDERS: [&str; 4] = ["scenes", "studies", "maps", "models"];

/// What a run reads, by its extension: pictures of a training are left out.
const READ: [&str; 4] = ["yaml", "json", "onnx", "txt"];

/// Writes `FILES`, the path from the workspace's root and the bytes of each, to `place`.
pub fn write(place: &Path) -> io::Result<()> {
    let root = std::path::absolute("..")?;
    let mut files = Vec::new();
    for folder in FOLDERS {
        println!("cargo::rerun-if-changed=../{folder}");
        collect(&root.join(folder), &mut files)?;
    }
    files.sort();
    let mut text =
        "/// Each file, by its path from the workspace's root.\nconst FILES: &[(&str, &[u8])] = &[\n"
            .to_owned();
    for file in files {
        let name = file.strip_prefix(&root).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        writeln!(text, "({name:?}, include_bytes!({file:?})),").map_err(io::Error::other)?;
    }
    fs::write(place, text + "];\n")
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|extension| READ.iter().any(|read| extension == *read)) {
            files.push(path);
        }
    }
    Ok(())
}
