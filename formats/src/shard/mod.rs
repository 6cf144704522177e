//! A dataset that is written shard by shard, and taken up again where it was left.
//!
//! ```text
//! manifest.json            written last: the dataset is finished
//! manifest.partial.json    instead, while it is not: the finished shards
//! .partial/                the shard that is being written
//! set_aside/               folders that were written anew, with files in them that are not of the dataset
//! ```

mod archive;
mod inventory;
mod manifest;
mod record;

pub(super) use archive::{TarShard, keys_of_tar};
pub use inventory::Inventory;
use manifest::LayoutManifest as Manifest;
pub use manifest::{FORMAT, LayoutManifest, ObjectRecord, ShardRecord, verify_layout};
use record::record;
use serde_json::Value;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use vantage_dataset::Split;
use vantage_dataset::store::{
    FileRecord, Provenance, StoreError, make_folder, replace, sync_folder, write_atomically,
};

const WORK: &str = ".partial";
/// Where folders go that are written anew and hold what others put there.
pub const SET_ASIDE: &str = "set_aside";
/// The first manifest, before it is put in place.
const BEGINNING: &str = "manifest.partial.json.tmp";
/// By which a folder is found writable.
const PROBE: &str = ".probe.tmp";

/// A dataset folder that was opened for writing.
#[derive(Debug)]
pub enum Opened<Writer> {
    /// It is finished, and every file's hash is right: there is nothing to do.
    Finished(LayoutManifest),
    /// It is to be written, or to be gone on with.
    Unfinished {
        /// Takes the samples.
        writer: Writer,
        /// How many samples are there already: the first that the writer takes is the one after them.
        skip: u64,
        /// What was wrong with files that are now written anew: to be told to the user.
        damage: Option<StoreError>,
    },
}

impl<Writer> Opened<Writer> {
    pub(super) fn map<Other>(self, with: impl FnOnce(Writer) -> Other) -> Opened<Other> {
        match self {
            Self::Finished(manifest) => Opened::Finished(manifest),
            Self::Unfinished { writer, skip, damage } => {
                Opened::Unfinished { writer: with(writer), skip, damage }
            }
        }
    }
}

/// The folder, and its manifest so far.
#[derive(Debug)]
pub(super) struct ShardedFolder {
    root: PathBuf,
    /// Whether a sample was lost, so that none may follow.
    failed: bool,
    /// Folders that were moved to make room, because they hold what others put there.
    pub(super) set_aside: Vec<PathBuf>,
    pub(super) manifest: Manifest,
}

impl ShardedFolder {
    /// Begins a dataset, or goes on with one that was begun with the same options and provenance.
    ///
    /// Damaged shards and all after them are written anew, as are all shards where a mesh is damaged.
    pub(super) fn open(
        root: &Path,
        layout: &str,
        options: Value,
        provenance: Provenance,
    ) -> Result<Opened<Self>, StoreError> {
        let mut asked = Manifest::new(layout, options, provenance);
        let Some((mut manifest, finished)) = Manifest::find(root)? else {
            if holds_foreign(root)? {
                return Err(StoreError::Foreign { folder: root.to_owned() });
            }
            make_folder(&root.join(WORK))?;
            asked.write_partial(root)?;
            let writer =
                Self { root: root.to_owned(), failed: false, set_aside: Vec::new(), manifest: asked };
            return Ok(Opened::Unfinished { writer, skip: 0, damage: None });
        };
        manifest.require_same(root, &asked)?;
        let mut damage = None;
        let mut sound = manifest.shards.len();
        if let Some(mesh) = manifest.damaged_mesh(root)? {
            (sound, damage) = (0, Some(mesh));
            manifest.objects.clear();
        } else if let Some((shard, what)) = manifest.damaged_shard(root)? {
            (sound, damage) = (shard, Some(what));
        } else if finished {
            damage = manifest.damaged_file(root)?;
            if damage.is_none() {
                manifest.clear_partial(root)?;
                return Ok(Opened::Finished(manifest));
            }
        }
        let lost = manifest.shards.split_off(sound);
        manifest.files.clear();
        manifest.samples = manifest.shards.iter().map(|shard| shard.samples).sum();
        manifest.withdraw(root)?;
        // Folders stay until what is written anew takes their place.
        lost.iter()
            .map(|shard| root.join(&shard.name))
            .filter(|path| !path.is_dir())
            .chain([root.join(WORK)])
            .try_for_each(|p| remove(&p))?;
        make_folder(&root.join(WORK))?;
        let skip = manifest.samples;
        let writer = Self { root: root.to_owned(), failed: false, set_aside: Vec::new(), manifest };
        Ok(Opened::Unfinished { writer, skip, damage })
    }

    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// How many shards of a split are finished.
    pub(super) fn shards_of(&self, split: Split) -> usize {
        self.manifest.shards.iter().filter(|shard| shard.split == split).count()
    }

    /// Where the shard that is under way is written to.
    pub(super) fn work(&self) -> PathBuf {
        self.root.join(WORK).join("shard")
    }

    /// Tells the outcome of writing at [`ShardedFolder::work`]. After a failure there is no next shard.
    pub(super) fn written<T>(&mut self, outcome: io::Result<T>) -> Result<T, StoreError> {
        self.failed |= outcome.is_err();
        outcome.map_err(StoreError::write(&self.work()))
    }

    fn require_whole(&self) -> Result<(), StoreError> {
        let lost = || StoreError::write(&self.root)(io::Error::other("an earlier sample was not written"));
        if self.failed { Err(lost()) } else { Ok(()) }
    }

    /// Makes what is at [`ShardedFolder::work`] the next shard.
    pub(super) fn commit(&mut self, name: &str, split: Split, samples: u64) -> Result<(), StoreError> {
        self.require_whole()?;
        self.failed = true;
        let (work, place) = (self.work(), self.root.join(name));
        let content = record(&work)?;
        place.parent().map_or(Ok(()), make_folder)?;
        let aside = self.root.join(SET_ASIDE).join(Path::new(name).parent().unwrap_or(Path::new("")));
        self.set_aside.extend(replace(&work, &place, &aside)?);
        place.parent().map_or(Ok(()), sync_folder)?;
        let first = self.manifest.samples;
        self.manifest.shards.push(ShardRecord { name: name.to_owned(), split, first, samples, content });
        self.manifest.samples += samples;
        self.manifest.write_partial(&self.root)?;
        self.failed = false;
        Ok(())
    }

    /// Writes a file other than a shard, whole or not at all.
    pub(super) fn write_file(&self, name: &str, bytes: &[u8]) -> Result<FileRecord, StoreError> {
        let path = self.root.join(name);
        path.parent().map_or(Ok(()), make_folder)?;
        write_atomically(&path, bytes).map_err(StoreError::write(&path))?;
        Ok(FileRecord::of(bytes))
    }

    /// Writes the files that tell of all shards, and marks the dataset as finished.
    pub(super) fn finish(mut self, files: &[(String, Vec<u8>)]) -> Result<LayoutManifest, StoreError> {
        self.require_whole()?;
        for (name, bytes) in files {
            let record = self.write_file(name, bytes)?;
            self.manifest.files.insert(name.clone(), record);
        }
        remove(&self.root.join(WORK))?;
        self.manifest.write_finished(&self.root)?;
        Ok(self.manifest)
    }
}

/// Whether a folder without a manifest holds more than a run leaves that was killed as it began.
fn holds_foreign(folder: &Path) -> Result<bool, StoreError> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        Err(error) if error.kind() == ErrorKind::NotADirectory => return Ok(true),
        Err(error) => return Err(StoreError::read(folder)(error)),
    };
    for entry in entries {
        let name = entry.map_err(StoreError::read(folder))?.file_name();
        if ![WORK, BEGINNING, PROBE].iter().any(|ours| name == *ours) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Removes a file or a folder, if it is there.
fn remove(path: &Path) -> Result<(), StoreError> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(StoreError::write(path)(error)),
        _ => Ok(()),
    }
}
