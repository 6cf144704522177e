//! Trajectories of somebody else's estimator, beside ours.

use crate::error::BenchError;
use crate::score::pairs::{MAX_TIME_DIFFERENCE, Pairs};
use crate::table::Outcome;
use crate::trajectory::Trajectory;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use vantage_dataset::{Pose, Seed};

/// An estimator by what it answered: a folder of `<seed>.tum`.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The folder's name, which its row has.
    pub name: String,
    folder: PathBuf,
}

/// What an entry is worth on one seed.
#[derive(Debug)]
pub struct Entered {
    /// Done; flagged where steps have no pose; failed where there is no file.
    pub outcome: Outcome,
    /// The steps that have a pose, as the scores compare them.
    pub pairs: Option<Pairs>,
}

impl Entry {
    /// The folders' entries; their names must differ from each other and from `taken`, and each must have one of the seeds.
    pub fn open(folders: &[PathBuf], taken: &[&str], seeds: &[Seed]) -> Result<Vec<Self>, BenchError> {
        let mut names: BTreeSet<String> = taken.iter().map(|&name| name.to_owned()).collect();
        let mut entries = Vec::new();
        for folder in folders {
            if !folder.is_dir() {
                return Err(BenchError::NoFolder { folder: folder.clone() });
            }
            let name =
                folder.canonicalize().ok().and_then(|path| Some(path.file_name()?.to_str()?.to_owned()));
            let name =
                name.ok_or_else(|| wrong(folder, "it has no name that a row could have; rename it"))?;
            if !names.insert(name.clone()) {
                return Err(wrong(folder, "another row has this folder's name; rename the folder"));
            }
            let entry = Self { name, folder: folder.clone() };
            if !seeds.iter().any(|&seed| entry.path(seed).is_file()) {
                let first = seeds.first().map_or(0, |seed| seed.0);
                let reason =
                    format!("no trajectory of the seeds that are run; expected {first}.tum and so on");
                return Err(wrong(folder, &reason));
            }
            entries.push(entry);
        }
        Ok(entries)
    }

    /// The poses of a seed beside the truth, by the time of its steps.
    pub fn run(&self, seed: Seed, truth: &Trajectory) -> Result<Entered, BenchError> {
        let path = self.path(seed);
        if !path.is_file() {
            let outcome = Outcome::Failed(format!("no {}.tum", seed.0));
            return Ok(Entered { outcome, pairs: None });
        }
        let text = std::fs::read_to_string(&path).map_err(|error| wrong(&path, &error.to_string()))?;
        let estimate = Trajectory::from_tum(&text).map_err(|error| wrong(&path, &error.to_string()))?;
        let pairs = Pairs::by_time(truth, &estimate, MAX_TIME_DIFFERENCE)
            .map_err(|error| wrong(&path, &error.to_string()))?;
        let (steps, posed) = (truth.len(), pairs.truth().len());
        let outcome = if posed < steps {
            Outcome::Flagged(format!("poses for {posed} of {steps} steps"))
        } else {
            Outcome::Done
        };
        Ok(Entered { outcome, pairs: Some(pairs) })
    }

    fn path(&self, seed: Seed) -> PathBuf {
        self.folder.join(format!("{}.tum", seed.0))
    }
}

impl Entered {
    /// The poses in the true world's frame, their first laid on the true one.
    pub fn aligned(&self) -> Vec<Pose> {
        let Some(pairs) = &self.pairs else { return Vec::new() };
        let alignment = pairs.true_world_from_estimate_world();
        pairs.estimate().iter().map(|pose| alignment * pose).collect()
    }
}

fn wrong(path: &Path, reason: &str) -> BenchError {
    BenchError::Entry { path: path.to_owned(), reason: reason.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vantage_dataset::store::write_tum;

    fn line(steps: &[usize]) -> Trajectory {
        let poses = steps.iter().map(|&i| Pose::translation(i as f64, 0.0, 0.0)).collect();
        Trajectory::new(steps.iter().map(|&i| i as f64 / 10.0).collect(), poses).unwrap()
    }

    #[test]
    fn files_are_found_by_seed_and_missing_ones_and_steps_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine");
        std::fs::create_dir(&mine).unwrap();
        for (seed, steps) in [(0, &[0, 1, 2, 3][..]), (2, &[1, 3])] {
            let poses = line(steps);
            write_tum(&mine.join(format!("{seed}.tum")), poses.timestamps(), poses.world_from_robot())
                .unwrap();
        }
        let seeds = [Seed(0), Seed(1), Seed(2)];
        let entries = Entry::open(std::slice::from_ref(&mine), &["geometric"], &seeds).unwrap();
        assert_eq!(entries[0].name, "mine");
        let truth = line(&[0, 1, 2, 3]);
        let outcomes = seeds.map(|seed| entries[0].run(seed, &truth).unwrap().outcome);
        let flagged = Outcome::Flagged("poses for 2 of 4 steps".into());
        assert_eq!(outcomes, [Outcome::Done, Outcome::Failed("no 1.tum".into()), flagged]);
    }

    #[test]
    fn folders_and_files_that_say_nothing_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine");
        let open = |taken: &[&str]| Entry::open(std::slice::from_ref(&mine), taken, &[Seed(7)]);
        let told = |taken: &[&str]| open(taken).unwrap_err().to_string();
        assert!(told(&[]).contains("no folder"), "{}", told(&[]));
        std::fs::create_dir(&mine).unwrap();
        assert!(told(&[]).contains("expected 7.tum"), "{}", told(&[]));
        let file = mine.join("7.tum");
        std::fs::write(&file, "9 0 0 0 0 0 0 1\n0 x 0 0 0 0 0 1\n").unwrap();
        assert!(told(&["mine"]).contains("another row"), "{}", told(&["mine"]));
        let entry = open(&[]).unwrap().remove(0);
        let refused = || entry.run(Seed(7), &line(&[0, 1])).unwrap_err().to_string();
        assert!(refused().contains("7.tum: line 2, column 2"), "{}", refused());
        std::fs::write(&file, "9 0 0 0 0 0 0 1\n").unwrap();
        assert!(refused().contains("of one clock"), "{}", refused());
    }
}
