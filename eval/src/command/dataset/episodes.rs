//! `vantage`: whole episodes in our own layout, one folder a seed.

use super::claim::other_data;
use super::{Format, Index, Need, tell};
use crate::command::error::BenchError;
use crate::command::folder::FolderError;
use crate::progress::Progress;
use crate::result::output_folder::{OutputError, OutputFolder};
use std::fs;
use std::path::Path;
use vantage_dataset::store::{Provenance, StoreError, read_manifest, replace, verify, write_episode};
use vantage_dataset::{Episode, Seed};
use vantage_formats::SET_ASIDE;

/// Folders of episodes.
pub struct Episodes<'a> {
    out: &'a OutputFolder,
    provenance: Provenance,
    progress: &'a Progress,
}

impl<'a> Episodes<'a> {
    /// Below `out`.
    pub fn new(out: &'a OutputFolder, provenance: Provenance, progress: &'a Progress) -> Self {
        Self { out, provenance, progress }
    }
}

impl Episodes<'_> {
    /// Whether it tells of the same data, made by other code: which is made anew.
    fn is_older(&self, found: &Provenance) -> bool {
        let but_code = |provenance: &Provenance| -> Provenance {
            provenance.clone().into_iter().filter(|(what, _)| what != "code").collect()
        };
        but_code(found) == but_code(&self.provenance)
    }
}

impl Format for Episodes<'_> {
    fn need(&mut self, seed: Seed, _: &Index) -> Result<Need, BenchError> {
        let folder = self.out.path().join(seed.0.to_string());
        match verify(&folder) {
            Ok(manifest) if manifest.provenance == self.provenance => Ok(Need::Nothing),
            Ok(manifest) if !self.is_older(&manifest.provenance) => {
                Err(other_data(&folder, &manifest.provenance, &self.provenance))
            }
            Err(error @ StoreError::Newer { .. }) => Err(error.into()),
            Ok(_) => Ok(Need::Episode),
            Err(_) if is_foreign(&folder) => Err(FolderError::NotOurs { folder }.into()),
            Err(damage) => {
                if folder.exists() {
                    self.progress.note(&format!("warning: {}; it is written anew", damage.finding()));
                }
                Ok(Need::Episode)
            }
        }
    }

    fn episode(&mut self, episode: &Episode) -> Result<(), BenchError> {
        let seed = episode.seed.0;
        let folder = self.out.path().join(seed.to_string());
        let partial = self.out.path().join(format!("{seed}.partial"));
        remove(&partial).map_err(|source| OutputError { path: partial.clone(), source })?;
        write_episode(&partial, episode, self.provenance.clone())?;
        let set_aside = replace(&partial, &folder, &self.out.path().join(SET_ASIDE))?;
        tell(self.progress, set_aside.as_slice());
        Ok(())
    }
}

/// Whether a folder has something in it, and nothing of what every episode has.
fn is_foreign(folder: &Path) -> bool {
    let holds_any = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    let ours = folder.join("odometry.csv").exists() || read_manifest(folder).is_ok();
    holds_any && !ours || folder.is_file()
}

fn remove(folder: &Path) -> std::io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
