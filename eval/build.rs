//! Hashes of the source code behind the stages of the cache: a result made by other code is not taken for this one's.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Each stage's name, and the folders and files, from the workspace's root, whose code can change its result.
const STAGES: [(&str, &[&str]); 3] = [
    ("SIMULATED", &["dataset/src", "sim/src", "eval/src/pipeline"]),
    ("TRAINED", &["dataset/src", "model/src", "sim/src", "learn/src", "eval/src/pipeline"]),
    ("ANSWERED", &["dataset/src", "model/src", "learn/src", "slam/src", "eval/src"]),
];

/// What decides how all of it is built.
const SETTINGS: [&str; 8] = [
    "Cargo.lock",
    "Cargo.toml",
    "dataset/Cargo.toml",
    "model/Cargo.toml",
    "sim/Cargo.toml",
    "learn/Cargo.toml",
    "slam/Cargo.toml",
    "eval/Cargo.toml",
];

fn main() -> io::Result<()> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let compiler = Command::new(rustc).arg("-vV").output()?.stdout;
    for (stage, sources) in STAGES {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&compiler);
        for source in sources.iter().chain(&SETTINGS) {
            let path = Path::new("..").join(source);
            println!("cargo::rerun-if-changed={}", path.display());
            add(&mut hasher, &path)?;
        }
        println!("cargo::rustc-env=VANTAGE_CODE_{stage}={}", hasher.finalize().to_hex());
    }
    Ok(())
}

fn add(hasher: &mut blake3::Hasher, path: &Path) -> io::Result<()> {
    if path.is_dir() {
        let mut entries: Vec<PathBuf> =
            fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
        entries.sort();
        return entries.iter().try_for_each(|entry| add(hasher, entry));
    }
    let bytes = fs::read(path)?;
    for part in [path.to_string_lossy().as_bytes(), &bytes] {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
    }
    Ok(())
}
