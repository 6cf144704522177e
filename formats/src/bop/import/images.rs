//! The files of a scene's images.

use std::collections::BTreeSet;
use std::path::Path;

/// Where BOP has images, and how they end.
pub(super) const FOLDERS: [&str; 2] = ["rgb", "gray"];
pub(super) const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

/// The numbers of the images that are there.
pub(super) fn numbers(scene: &Path) -> BTreeSet<u32> {
    let listed = FOLDERS.iter().filter_map(|folder| std::fs::read_dir(scene.join(folder)).ok());
    listed.flatten().flatten().filter_map(|entry| number(&entry.path())).collect()
}

/// None of a file that is not named as BOP names images.
fn number(path: &Path) -> Option<u32> {
    let (stem, ending) = (path.file_stem()?.to_str()?, path.extension()?.to_str()?);
    let number: u32 = stem.parse().ok()?;
    let is_named = ENDINGS.contains(&ending) && format!("{number:06}") == stem;
    is_named.then_some(number)
}
