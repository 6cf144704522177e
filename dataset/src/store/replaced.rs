//! Files and folders that are written anew: what somebody else put into their place is not lost.

use super::error::StoreError;
use super::hashed_file::{make_folder, sync_folder};
use std::fs;
use std::path::{Path, PathBuf};

/// Moves the file or folder `new` to `place`. A file that is there, or a folder that holds nothing but what `new` holds, too, is
/// removed; anything else is moved below `aside`, and the answer is where to.
pub fn replace(new: &Path, place: &Path, aside: &Path) -> Result<Option<PathBuf>, StoreError> {
    let mut kept = None;
    if let Ok(there) = fs::symlink_metadata(place) {
        let ours = if there.is_dir() {
            new.is_dir() && !holds_more(place, new).map_err(StoreError::read(place))?
        } else {
            there.is_file() && new.is_file()
        };
        if !ours {
            make_folder(aside)?;
            let free = free_name(aside, place);
            fs::rename(place, &free).map_err(StoreError::write(&free))?;
            sync_folder(aside)?;
            kept = Some(free);
        } else if there.is_dir() {
            fs::remove_dir_all(place).map_err(StoreError::write(place))?;
        }
    }
    fs::rename(new, place).map_err(StoreError::write(place))?;
    Ok(kept)
}

/// Whether anything in `folder` has no counterpart in `other`.
fn holds_more(folder: &Path, other: &Path) -> std::io::Result<bool> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (path, counterpart) = (entry.path(), other.join(entry.file_name()));
        let kind = entry.file_type()?;
        let more = if kind.is_dir() {
            !counterpart.is_dir() || holds_more(&path, &counterpart)?
        } else {
            !kind.is_file() || !counterpart.is_file()
        };
        if more {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The name of `place` below `aside`, with a number where it is taken.
fn free_name(aside: &Path, place: &Path) -> PathBuf {
    let name = place.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let numbered = (2..).map(|number| aside.join(format!("{name}.{number}")));
    let mut names = std::iter::once(aside.join(&name)).chain(numbered);
    names.find(|path| fs::symlink_metadata(path).is_err()).expect("there is always another number")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(root: &Path, name: &str, files: &[&str]) -> PathBuf {
        let folder = root.join(name);
        for file in files {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, name).unwrap();
        }
        folder
    }

    #[test]
    fn what_is_ours_is_replaced_and_what_is_more_is_kept_aside() {
        let root = tempfile::tempdir().unwrap();
        let (place, aside) = (root.path().join("place"), root.path().join("aside"));
        let replace = |files: &[&str]| {
            let new = folder(root.path(), "new", files);
            super::replace(&new, &place, &aside).unwrap()
        };
        assert_eq!(replace(&["a", "truth/b", "truth/c"]), None);
        fs::remove_file(place.join("a")).unwrap();
        assert_eq!(replace(&["a", "truth/b", "truth/c"]), None);
        assert!(place.join("a").exists() && !aside.exists());
        for (number, foreign) in ["note", "truth/note", "mine/note"].iter().enumerate() {
            folder(root.path(), "place", &[foreign]);
            let kept = replace(&["a", "truth/b", "truth/c"]).unwrap();
            let name = if number == 0 { "place".to_owned() } else { format!("place.{}", number + 1) };
            assert_eq!(kept, aside.join(name));
            assert!(kept.join(foreign).exists() && kept.join("a").exists() && !place.join(foreign).exists());
        }
        fs::create_dir(place.join("empty")).unwrap();
        assert!(replace(&["a"]).is_some());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_nothing_of_ours() {
        let root = tempfile::tempdir().unwrap();
        let place = folder(root.path(), "place", &["a"]);
        fs::remove_file(place.join("a")).unwrap();
        std::os::unix::fs::symlink("elsewhere", place.join("a")).unwrap();
        let aside = root.path().join("aside");
        let replaced = || super::replace(&folder(root.path(), "new", &["a"]), &place, &aside).unwrap();
        assert!(replaced().is_some());
        let elsewhere = folder(root.path(), "elsewhere", &["a"]);
        fs::remove_dir_all(&place).unwrap();
        std::os::unix::fs::symlink(&elsewhere, &place).unwrap();
        assert!(replaced().is_some() && elsewhere.join("a").exists());
    }

    #[test]
    fn a_file_takes_the_place_of_a_file_and_no_other() {
        let root = tempfile::tempdir().unwrap();
        let (new, place) = (root.path().join("new"), root.path().join("place"));
        let replaced = || {
            fs::write(&new, "new").unwrap();
            super::replace(&new, &place, &root.path().join("aside")).unwrap()
        };
        assert_eq!((replaced(), replaced()), (None, None));
        fs::remove_file(&place).unwrap();
        folder(root.path(), "place", &["mine"]);
        assert!(replaced().unwrap().join("mine").exists() && place.is_file());
    }
}
