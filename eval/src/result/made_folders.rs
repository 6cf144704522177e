//! Folders that a command made.

use std::fs;
use std::path::{Path, PathBuf};

/// Folders that were made for a command's output: those that are empty when this is dropped are removed.
#[derive(Debug)]
pub struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes a folder and its parents.
    pub fn make(folder: &Path) -> std::io::Result<Self> {
        let missing = folder.ancestors().take_while(|part| !part.as_os_str().is_empty() && !part.exists());
        let made = Self(missing.map(Path::to_owned).collect());
        fs::create_dir_all(folder)?;
        Ok(made)
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        // From the innermost outward, until one holds something.
        let _ = self.0.iter().try_for_each(fs::remove_dir);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_made_and_stays_empty_goes_again() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("a/b/c");
        drop(MadeFolders::make(&folder).unwrap());
        assert!(!root.path().join("a").exists());

        let made = MadeFolders::make(&folder).unwrap();
        fs::write(root.path().join("a/note"), "").unwrap();
        drop(made);
        assert!(!root.path().join("a/b").exists() && root.path().join("a/note").exists());

        fs::create_dir_all(&folder).unwrap();
        drop(MadeFolders::make(&folder).unwrap());
        assert!(folder.exists(), "it was there before");
    }
}
