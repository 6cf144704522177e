//! The on-disk store: episodes, view sets, and the cache of stages.
//!
//! One folder holds one [`Episode`](crate::Episode) or one [`ViewSet`](crate::ViewSet), in the layout of
//! `docs/dataset.md`. Every float is written with the fewest digits that read back to the same bits. The
//! manifest names and hashes every other file and is written last, so that a folder without one was never
//! finished. Ground truth has files of its own: [`read_observations`] works where `truth/` is absent.
//!
//! Reading trusts nothing: hashes, shapes, ranges and counts are checked before a value leaves this module,
//! and nothing is allocated by a declared size before that size agrees with the file's.

mod cache;
mod check;
mod episode;
mod error;
mod file_record;
mod folder_lock;
mod hashed_file;
mod instance_fields;
mod lock;
mod manifest;
mod npy;
mod pose_fields;
mod replaced;
mod table;
mod tables;
mod tum;
mod views;
mod whole_file;

#[cfg(test)]
mod tests;

pub use cache::{Cache, Entry, Key, Origin};
pub use episode::{read_episode, read_observations, read_truth, write_episode, write_observations};
pub use error::{Fault, StoreError, StoreErrorKind};
pub use file_record::FileRecord;
pub use folder_lock::FolderLock;
pub use hashed_file::{hash_and_sync, inside, make_folder, remove_if_there, sync_folder, verify_files};
pub use lock::Waiting;
pub use manifest::{Content, Manifest, Provenance, read_json, read_manifest, verify, write_json};
pub use npy::npy_header;
pub use pose_fields::pose_fields;
pub use replaced::replace;
pub use tum::write_tum;
pub use views::{read_views, write_views};
pub use whole_file::{file_kind, open_regular, read_regular, rename_durably, write_atomically};

/// The format this version writes, and the newest it reads; every manifest and every cache key holds it.
pub const FORMAT: u32 = 1;
