//! Trajectories of somebody else's estimator, beside ours.

use super::pairs::{MAX_TIME_DIFFERENCE, nearest};
use crate::exit::Ends;
use crate::progress::Progress;
use crate::result::trajectory::{Trajectory, TumError};
use crate::scene_file::row_name::folder_name;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use thiserror::Error;
use vantage_dataset::store::read_regular;
use vantage_dataset::{Pose, Seed};

/// Trajectories of another estimator that cannot be scored.
#[derive(Debug, Error)]
#[error("--trajectories {}: {reason}", path.display())]
pub struct EntryError {
    /// The folder, or the file in it.
    pub path: PathBuf,
    /// What is wrong.
    pub reason: String,
}

impl Ends for EntryError {}

/// Largest file, bytes: some 400 000 poses.
const LARGEST_FILE: u64 = 64 << 20;
/// Largest magnitude of a coordinate, metres.
const FARTHEST: f64 = 1e6;

/// An estimator by what it answered: a folder of `<seed>.tum`.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The folder's name, which its row has.
    pub name: String,
    /// BLAKE3 of the files that were read, by seed.
    pub hash: String,
    /// Each seed's trajectory, or why it counts as failed.
    answers: BTreeMap<Seed, Result<Trajectory, String>>,
}

impl Entry {
    /// Reads the files of `seeds` in each folder. Folders' names must differ from each other and from `taken`.
    pub fn open(
        folders: &[PathBuf],
        taken: &[String],
        seeds: &[Seed],
        progress: &Progress,
    ) -> Result<Vec<Self>, EntryError> {
        let mut names: BTreeSet<String> = taken.iter().cloned().collect();
        let read = |folder: &PathBuf| {
            let name = named(folder)?;
            if !names.insert(name.clone()) {
                return Err(wrong(
                    folder,
                    "another row, or the truth, has this folder's name; rename the folder",
                ));
            }
            let others = others(folder, seeds)?;
            if let Some(first) = others.first() {
                let of = folder.display();
                progress.note(&format!(
                    "note: {} files in {of} are of no seed that is run, {first} first",
                    others.len()
                ));
            }
            Self::read(name, folder, seeds)
        };
        folders.iter().map(read).collect()
    }

    fn read(name: String, folder: &Path, seeds: &[Seed]) -> Result<Self, EntryError> {
        let (mut answers, mut hasher, mut found) = (BTreeMap::new(), blake3::Hasher::new(), false);
        for &seed in seeds {
            let file = file(seed);
            let path = folder.join(&file);
            let text = match text(&path) {
                Ok(text) => text,
                Err(error) if error.kind() == ErrorKind::NotFound => {
                    answers.insert(seed, Err(format!("there is no {file}")));
                    continue;
                }
                Err(error) => return Err(wrong(&path, &error.to_string())),
            };
            found = true;
            hasher
                .update(&seed.0.to_le_bytes())
                .update(&(text.len() as u64).to_le_bytes())
                .update(text.as_bytes());
            let answer = match Trajectory::from_tum(&text) {
                Err(error) if lost(&error) => Err(format!("{file}: {error}")),
                Err(error) => return Err(wrong(&path, &error.to_string())),
                Ok(trajectory) => near(trajectory).map_err(|reason| format!("{file}: {reason}")),
            };
            answers.insert(seed, answer);
        }
        if !found {
            let first = seeds.first().map_or_else(|| file(Seed(0)), |&seed| file(seed));
            return Err(wrong(
                folder,
                &format!("no trajectory of the seeds that are run; expected {first} and so on"),
            ));
        }
        Ok(Self { name, hash: hasher.finalize().to_hex().to_string(), answers })
    }

    /// `world_from_robot`, in the entry's own world frame, at the times of an episode's steps (seconds), or why the run counts as failed.
    ///
    /// Every step needs one, so that all rows are scored on the same steps: within [`MAX_TIME_DIFFERENCE`], and nearer than half a
    /// step, so that none serves twice.
    pub fn run(&self, seed: Seed, timestamps: &[f64]) -> Result<Vec<Pose>, String> {
        let answer = match self.answers.get(&seed) {
            Some(Ok(answer)) => answer,
            Some(Err(reason)) => return Err(reason.clone()),
            None => return Err(format!("there is no {}", file(seed))),
        };
        let shortest = timestamps.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let bound = MAX_TIME_DIFFERENCE.min(0.49 * shortest);
        let near = |&time: &f64| nearest(answer.timestamps(), time, bound);
        let found: Vec<Pose> =
            timestamps.iter().filter_map(near).map(|index| answer.world_from_robot()[index]).collect();
        if found.len() < timestamps.len() {
            let (found, steps) = (found.len(), timestamps.len());
            let [theirs, ours] = [answer.timestamps(), timestamps].map(range);
            return Err(format!(
                "{}: {found} of {steps} steps have a pose within {bound} s; its times are {theirs} s, the steps' {ours} s",
                file(seed)
            ));
        }
        Ok(found)
    }

    /// That no robot drives in the scene.
    pub fn undriven(folder: &Path) -> EntryError {
        wrong(folder, "no robot drives in this scene; leave the option out")
    }
}

fn file(seed: Seed) -> String {
    format!("{}.tum", seed.0)
}

fn range(timestamps: &[f64]) -> String {
    match timestamps {
        [first, .., last] => format!("{first} to {last}"),
        [only] => only.to_string(),
        [] => "none".to_owned(),
    }
}

/// The name of a row, of a folder that is there.
fn named(folder: &Path) -> Result<String, EntryError> {
    if !folder.is_dir() {
        return Err(wrong(folder, "it is no folder; expected one of <seed>.tum"));
    }
    folder_name(folder).ok_or_else(|| {
        wrong(folder, "a row takes letters, digits, '-', '_' and '.' alone; rename the folder")
    })
}

/// Trajectories in the folder that no seed asks for.
fn others(folder: &Path, seeds: &[Seed]) -> Result<Vec<String>, EntryError> {
    let asked: BTreeSet<String> = seeds.iter().copied().map(file).collect();
    let entries = std::fs::read_dir(folder).map_err(|error| wrong(folder, &error.to_string()))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut others: Vec<String> =
        names.filter(|name| name.ends_with(".tum") && !asked.contains(name)).collect();
    others.sort();
    Ok(others)
}

/// A trajectory that has not left for where errors are no numbers.
fn near(trajectory: Trajectory) -> Result<Trajectory, String> {
    let far = |pose: &Pose| pose.translation.vector.amax() > FARTHEST;
    match trajectory.world_from_robot().iter().position(far) {
        Some(index) => Err(format!("pose {index} is more than {FARTHEST} m away")),
        None => Ok(trajectory),
    }
}

/// Whether an estimator that has lost its way writes such a file.
fn lost(error: &TumError) -> bool {
    match error {
        TumError::Empty | TumError::NotFinite { .. } => true,
        TumError::Quaternion { norm, .. } => !norm.is_finite(),
        _ => false,
    }
}

/// The text of a regular file.
pub(crate) fn text(path: &Path) -> io::Result<String> {
    let bytes = read_regular(path, LARGEST_FILE)?;
    String::from_utf8(bytes).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is not UTF-8 text"))
}

fn wrong(path: &Path, reason: &str) -> EntryError {
    EntryError { path: path.to_owned(), reason: reason.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: [f64; 4] = [0.0, 0.1, 0.2, 0.3];

    struct Folder(tempfile::TempDir);

    impl Folder {
        fn new() -> Self {
            let folder = Self(tempfile::tempdir().unwrap());
            std::fs::create_dir(folder.path()).unwrap();
            folder
        }

        fn path(&self) -> PathBuf {
            self.0.path().join("mine")
        }

        /// Poses along x, at the given times.
        fn write(&self, name: &str, times: &[f64]) {
            let lines = times.iter().enumerate().map(|(i, time)| format!("{time} {i} 0 0 0 0 0 1\n"));
            std::fs::write(self.path().join(name), lines.collect::<String>()).unwrap();
        }

        fn open(&self, taken: &[&str], seeds: &[Seed]) -> Result<Entry, EntryError> {
            let taken: Vec<String> = taken.iter().map(|&name| name.to_owned()).collect();
            let entries = Entry::open(&[self.path()], &taken, seeds, &Progress::detect());
            entries.map(|mut entries| entries.remove(0))
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_or_a_device_in_place_of_a_file_is_told_and_not_read() {
        for kind in ["pipe", "endless"] {
            let folder = Folder::new();
            let path = folder.path().join("7.tum");
            if kind == "pipe" {
                assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
            } else {
                std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
            }
            let told = Entry::read("mine".to_owned(), &folder.path(), &[Seed(7)]).unwrap_err().to_string();
            assert!(told.contains("7.tum: it is not a regular file"), "{told}");
        }
    }

    #[test]
    fn every_step_takes_the_nearest_pose_and_none_serves_twice() {
        let folder = Folder::new();
        folder.write("0.tum", &STEPS);
        folder.write("1.tum", &[-1.0, 0.004, 0.05, 0.099, 0.103, 0.2, 0.26, 0.301, 9.0]);
        folder.write("2.tum", &[0.0, 0.01, 0.1, 0.3]);
        folder.write("3.tum", &[0.0, 0.1, 0.2, 0.32]);
        folder.write("4.tum", &[0.0, 0.01, 0.02, 0.03]);
        let seeds = [0, 1, 2, 3, 4, 5].map(Seed);
        let entry = folder.open(&["geometric"], &seeds).unwrap();
        assert_eq!(entry.name, "mine");
        let run = |seed: u64, steps: &[f64]| -> Result<Vec<f64>, String> {
            let poses = entry.run(Seed(seed), steps)?;
            Ok(poses.iter().map(|pose| pose.translation.x).collect())
        };
        assert_eq!(run(0, &STEPS), Ok(vec![0.0, 1.0, 2.0, 3.0]));
        assert_eq!(run(1, &STEPS), Ok(vec![1.0, 3.0, 5.0, 7.0]));
        let told = |seed: u64, steps: &[f64]| run(seed, steps).unwrap_err();
        assert!(told(2, &STEPS).contains("3 of 4 steps"), "{}", told(2, &STEPS));
        assert!(told(3, &STEPS).contains("3 of 4 steps"), "{}", told(3, &STEPS));
        assert!(told(4, &STEPS).contains("1 of 4 steps"), "{}", told(4, &STEPS));
        assert!(
            told(4, &STEPS).contains("times are 0 to 0.03 s, the steps' 0 to 0.3 s"),
            "{}",
            told(4, &STEPS)
        );
        assert!(told(4, &[0.0, 0.005, 0.01]).contains("2 of 3 steps"), "{}", told(4, &[0.0, 0.005, 0.01]));
        assert_eq!(told(5, &STEPS), "there is no 5.tum");
    }

    #[test]
    fn an_estimator_that_got_lost_has_failed() {
        let folder = Folder::new();
        let written =
            ["# lost\n", "0 inf 0 0 0 0 0 1\n", "0 1e200 0 0 0 0 0 1\n", "0 0 0 0 NaN NaN NaN NaN\n"];
        for (seed, text) in written.iter().enumerate() {
            std::fs::write(folder.path().join(format!("{seed}.tum")), text).unwrap();
        }
        let entry = folder.open(&[], &[0, 1, 2, 3].map(Seed)).unwrap();
        for (seed, words) in [(0, "no pose"), (1, "not finite"), (2, "pose 0 is more than"), (3, "norm NaN")]
        {
            let told = entry.run(Seed(seed), &STEPS).unwrap_err();
            assert!(told.contains(words), "{told}");
        }
    }

    #[test]
    fn folders_and_files_that_are_none_are_refused_with_their_place() {
        let folder = Folder::new();
        let told = |taken: &[&str]| folder.open(taken, &[Seed(7)]).unwrap_err().to_string();
        assert!(told(&[]).contains("expected 7.tum"), "{}", told(&[]));
        folder.write("7.tum", &STEPS);
        assert!(told(&["mine"]).contains("another row"), "{}", told(&["mine"]));
        let before = folder.open(&[], &[Seed(7)]).unwrap().hash;
        folder.write("7.tum", &STEPS[..3]);
        assert_ne!(folder.open(&[], &[Seed(7)]).unwrap().hash, before);
        std::fs::write(folder.path().join("7.tum"), "9 0 0 0 0 0 0 1\n0 x 0 0 0 0 0 1\n").unwrap();
        assert!(told(&[]).contains("7.tum: line 2, column 2"), "{}", told(&[]));
        std::fs::remove_file(folder.path().join("7.tum")).unwrap();
        std::fs::create_dir(folder.path().join("7.tum")).unwrap();
        assert!(told(&[]).contains("7.tum: it is not a regular file"), "{}", told(&[]));
        std::fs::remove_dir(folder.path().join("7.tum")).unwrap();
        std::fs::write(folder.path().join("7.tum"), [b'#', 0xff]).unwrap();
        assert!(told(&[]).contains("7.tum: it is not UTF-8 text"), "{}", told(&[]));
        std::fs::write(folder.path().join("7.tum"), "0 0 0 0 0 0 0 1\n0 1 0 0 0 0 0 1\n").unwrap();
        assert!(told(&[]).contains("7.tum: line 2: another pose"), "{}", told(&[]));
        let open =
            |name: &str| Entry::open(&[folder.0.path().join(name)], &[], &[Seed(7)], &Progress::detect());
        assert!(open("none").unwrap_err().to_string().contains("it is no folder"));
        std::fs::create_dir(folder.0.path().join("a|b")).unwrap();
        assert!(open("a|b").unwrap_err().to_string().contains("letters, digits"));
    }
}
