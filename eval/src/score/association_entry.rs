//! Associations of somebody else, beside ours.

use crate::exit::Ends;
use crate::scene_file::row_name::folder_name;
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::Seed;
use vantage_dataset::store::read_regular;

/// Associations that cannot be scored.
#[derive(Debug, Error)]
#[error("--associations {}: {reason}", path.display())]
pub struct AssociationEntryError {
    /// The folder, or the file in it.
    pub path: PathBuf,
    /// What is wrong.
    pub reason: String,
}

impl Ends for AssociationEntryError {}

/// Largest file, bytes: some millions of detections.
const LARGEST_FILE: u64 = 64 << 20;
/// The head of a file.
pub const HEAD: &str = "detection,object";

/// An associator by what it answered: a folder of `<seed>.csv`.
///
/// A line `detection,object` says that a detection, by its place among the episode's (the row of `detections.csv` in an exported data set, from
/// 0), is of an object, by any number. A detection without a line, or without an object, is of nothing.
#[derive(Clone, Debug)]
pub struct AssociationEntry {
    /// The folder's name, which its row has.
    pub name: String,
    folder: PathBuf,
    /// BLAKE3 of the files that were read, by seed.
    pub hash: String,
    answers: BTreeMap<Seed, Result<BTreeMap<usize, Option<usize>>, String>>,
}

impl AssociationEntry {
    /// Reads the files of `seeds` in each folder. Folders' names must differ from each other and from `taken`.
    pub fn open(
        folders: &[PathBuf],
        taken: &[String],
        seeds: &[Seed],
    ) -> Result<Vec<Self>, AssociationEntryError> {
        let mut names: BTreeSet<String> = taken.iter().cloned().collect();
        let read = |folder: &PathBuf| {
            if !folder.is_dir() {
                return Err(wrong(folder, "it is no folder; expected one of <seed>.csv"));
            }
            let told = "a row takes letters, digits, '-', '_' and '.' alone; rename the folder";
            let name = folder_name(folder).ok_or_else(|| wrong(folder, told))?;
            if !names.insert(name.clone()) {
                return Err(wrong(folder, "another row has this folder's name; rename the folder"));
            }
            Self::read(name, folder, seeds)
        };
        folders.iter().map(read).collect()
    }

    fn read(name: String, folder: &Path, seeds: &[Seed]) -> Result<Self, AssociationEntryError> {
        let (mut answers, mut hasher, mut found) = (BTreeMap::new(), blake3::Hasher::new(), false);
        for &seed in seeds {
            let path = folder.join(format!("{}.csv", seed.0));
            let bytes = match read_regular(&path, LARGEST_FILE) {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == ErrorKind::NotFound => {
                    answers.insert(seed, Err(format!("there is no {}.csv", seed.0)));
                    continue;
                }
                Err(error) => return Err(wrong(&path, &error.to_string())),
            };
            found = true;
            hasher.update(&seed.0.to_le_bytes()).update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
            answers.insert(seed, Ok(parsed(&bytes).map_err(|reason| wrong(&path, &reason))?));
        }
        if !found {
            let first = seeds.first().map_or(0, |seed| seed.0);
            let reason = format!("no association of the seeds that are run; expected {first}.csv and so on");
            return Err(wrong(folder, &reason));
        }
        Ok(Self { name, folder: folder.to_owned(), hash: hasher.finalize().to_hex().to_string(), answers })
    }

    /// Refuses an answer to other detections than those of a seed.
    pub fn fits(&self, seed: Seed, detections: usize) -> Result<(), AssociationEntryError> {
        let Some(Ok(answer)) = self.answers.get(&seed) else { return Ok(()) };
        match answer.last_key_value().filter(|(last, _)| **last >= detections) {
            Some((last, _)) => Err(wrong(
                &self.folder.join(format!("{}.csv", seed.0)),
                &format!(
                    "detection {last}, but seed {} has {detections} detections, counted from 0; answer to what `bench dataset` writes of this scene",
                    seed.0
                ),
            )),
            None => Ok(()),
        }
    }

    /// The object of each of an episode's detections, or why the run counts as failed.
    pub fn run(&self, seed: Seed, detections: usize) -> Result<Vec<Option<usize>>, String> {
        match self.answers.get(&seed) {
            Some(Ok(answer)) => {
                Ok((0..detections).map(|detection| answer.get(&detection).copied().flatten()).collect())
            }
            Some(Err(reason)) => Err(reason.clone()),
            None => Err(format!("there is no {}.csv", seed.0)),
        }
    }

    /// That no robot drives in the scene.
    pub fn undriven(folder: &Path) -> AssociationEntryError {
        wrong(folder, "no robot drives in this scene; leave the option out")
    }
}

fn parsed(bytes: &[u8]) -> Result<BTreeMap<usize, Option<usize>>, String> {
    let text =
        std::str::from_utf8(bytes).map_err(|_| "got bytes that are no UTF-8; save it as UTF-8".to_owned())?;
    if text.trim().is_empty() {
        return Err(format!(
            "the file is empty; expected the head {HEAD:?}, and a line for each detection of an object"
        ));
    }
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(bytes);
    let head = reader.headers().map_err(|error| error.to_string())?.iter().collect::<Vec<_>>().join(",");
    if head != HEAD {
        return Err(format!("line 1: got the head {head:?}, expected {HEAD:?}"));
    }
    let mut objects = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() > 2 {
            return Err(format!("line {line}: got {} fields, expected {HEAD:?}", record.len()));
        }
        let number = |field: usize, what: &str, remedy: &str| {
            let got = record.get(field).unwrap_or_default();
            let told = format!("line {line}: got {what} {got:?}, expected a whole number from 0{remedy}");
            got.parse::<usize>().map_err(|_| told)
        };
        let detection = number(0, "detection", "")?;
        let is_nothing = record.get(1).is_none_or(str::is_empty);
        let remedy = ", or nothing; in pandas, let the column be of type Int64";
        let object = if is_nothing { None } else { Some(number(1, "object", remedy)?) };
        if objects.insert(detection, object).is_some() {
            return Err(format!("line {line}: detection {detection} stands there twice; leave one line"));
        }
    }
    Ok(objects)
}

fn wrong(path: &Path, reason: &str) -> AssociationEntryError {
    AssociationEntryError { path: path.to_owned(), reason: reason.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<AssociationEntry, AssociationEntryError> {
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine");
        std::fs::create_dir(&mine).unwrap();
        std::fs::write(mine.join("3.csv"), text).unwrap();
        AssociationEntry::open(&[mine], &[], &[Seed(3), Seed(4)]).map(|mut entries| entries.remove(0))
    }

    #[test]
    fn detections_without_a_line_or_an_object_are_of_nothing() {
        let entry = read("detection,object\n2, 7\n0,\n1\n").unwrap();
        assert_eq!(entry.name, "mine");
        assert_eq!(entry.run(Seed(3), 4).unwrap(), [None, None, Some(7), None]);
        assert!(entry.fits(Seed(3), 3).is_ok() && entry.fits(Seed(4), 0).is_ok());
        let error = entry.fits(Seed(3), 2).unwrap_err().to_string();
        assert!(error.contains("3.csv: detection 2, but seed 3 has 2 detections"), "{error}");
        assert!(entry.run(Seed(4), 2).unwrap_err().contains("no 4.csv"));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, told) in [
            ("step,object\n", "line 1: got the head"),
            ("detection,object\n1,2\nx,2\n", "line 3: got detection \"x\""),
            ("detection,object\n1,-2\n", "line 2: got object \"-2\""),
            ("detection,object\n1,2.0\n", "in pandas, let the column be of type Int64"),
            ("detection,object\n1,2,3\n", "line 2: got 3 fields"),
            ("\n", "the file is empty"),
            ("detection,object\n1,2\n1,3\n", "line 3: detection 1 stands there twice"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(told) && error.contains("3.csv"), "{error}");
        }
        let folder = tempfile::tempdir().unwrap();
        let error = AssociationEntry::open(&[folder.path().join("none")], &[], &[Seed(0)]).unwrap_err();
        assert!(error.to_string().contains("it is no folder"), "{error}");
    }
}
