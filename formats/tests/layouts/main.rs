//! Layouts of others: read back what was written, read what others wrote, and survive what is damaged.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod avd;
mod balls;
mod bigbird;
mod fixtures;
mod mat5;

use std::path::{Path, PathBuf};

/// Every file below a folder, sorted, with its bytes.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                found.push((path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// Cuts a file to a share of its length.
fn truncate(path: &Path, share: f64) {
    let bytes = std::fs::read(path).unwrap();
    std::fs::write(path, &bytes[..(bytes.len() as f64 * share) as usize]).unwrap();
}

/// Puts a pipe, to which nobody writes, in the place of a file.
#[cfg(unix)]
fn pipe(path: &Path) {
    let _ = std::fs::remove_file(path);
    assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
}
