//! The scores of a study as they come, and the tables of them.

use crate::command::study_pages::known_views_table;
use crate::result::run::{Outcome, Run};
use crate::result::table::{Table, TableError};
use crate::scene_file::row_name::{GAUSSIAN_PROCESS, with_process};
use crate::scene_file::study::StudyFile;
use crate::score::embedding::Scores;
use crate::score::known_views::METRICS;
use crate::score::unseen::Unseen;
use crate::score::unseen_table::{TABLES, UnseenTable};
use std::collections::BTreeMap;
use vantage_dataset::Seed;

/// Runs, and the scores of floors, which know no model, by table.
#[derive(Default)]
pub struct StudyScores {
    runs: [Vec<Run>; TABLES.len()],
    floors: [Scores; TABLES.len()],
    known_views: BTreeMap<usize, Vec<Run>>,
}

impl StudyScores {
    /// Takes a model's scores on each set of test instances.
    pub fn scored(&mut self, variant: &str, seed: Seed, sets: &[Unseen]) {
        for ((table, runs), floor) in TABLES.iter().zip(&mut self.runs).zip(&mut self.floors) {
            if floor.is_empty() {
                *floor = mean_scores(table, sets.iter().filter_map(|on| on.floor.get(table.name)));
            }
            let scores = mean_scores(table, sets.iter().filter_map(|on| on.model.get(table.name)));
            runs.push(Run { method: variant.to_owned(), seed, outcome: Outcome::Done, scores });
        }
    }

    /// Takes what a row tells of azimuths from `known` known views.
    pub fn told(&mut self, known: usize, method: &str, seed: Seed, scores: Scores) {
        let run = Run { method: method.to_owned(), seed, outcome: Outcome::Done, scores };
        self.known_views.entry(known).or_default().push(run);
    }

    /// Takes a training that gave no model.
    pub fn failed(&mut self, variant: &str, seed: Seed, reason: &str) {
        let outcome = Outcome::Failed(reason.to_owned());
        let run = Run { method: variant.to_owned(), seed, outcome, scores: Scores::new() };
        self.runs.iter_mut().for_each(|runs| runs.push(run.clone()));
        for runs in self.known_views.values_mut() {
            runs.extend([run.clone(), Run { method: with_process(variant), ..run.clone() }]);
        }
    }

    /// Whether any model has a score.
    pub fn any(&self) -> bool {
        self.runs.iter().flatten().any(|run| !run.scores.is_empty())
    }

    /// The tables of all variants, compared with the first, and of floors.
    pub fn tables(self, study: &StudyFile, seeds: &[Seed]) -> Result<Vec<Table>, TableError> {
        let names = study.variants.iter().map(|variant| variant.name.clone());
        let names: Vec<String> = names
            .flat_map(|name| [name.clone(), with_process(&name)])
            .chain([GAUSSIAN_PROCESS.to_owned()])
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let of_known = self.known_views.into_iter().map(|(known, runs)| {
            Table::new(&known_views_table(known), &names, Some(GAUSSIAN_PROCESS), &METRICS, seeds, runs)
        });
        let of_known: Vec<Result<Table, TableError>> = of_known.collect();
        let runs = TABLES.iter().zip(self.runs).zip(self.floors);
        let table = |((table, mut runs), floor): ((&UnseenTable, Vec<Run>), Scores)| {
            let of_floor = |name: &str, &seed: &Seed| Run {
                method: name.to_owned(),
                seed,
                outcome: Outcome::Done,
                scores: floor.clone(),
            };
            runs.extend(table.floor().iter().flat_map(|name| seeds.iter().map(|seed| of_floor(name, seed))));
            let variants = study.variants.iter().map(|variant| variant.name.as_str());
            let names: Vec<&str> = variants.chain(table.floor()).collect();
            Table::new(table.name, &names, Some(names[0]), table.metrics(), seeds, runs)
        };
        runs.map(table).chain(of_known).collect()
    }
}

/// The mean of each score over the sets of test instances; undefined where it is in any of them.
fn mean_scores<'a>(table: &UnseenTable, sets: impl Iterator<Item = &'a Scores>) -> Scores {
    let sets: Vec<&Scores> = sets.collect();
    let mean = |metric| {
        let scores: Option<Vec<f64>> = sets.iter().map(|scores| scores.get(&metric).copied()).collect();
        let scores = scores.filter(|scores| !scores.is_empty())?;
        Some((metric, scores.iter().sum::<f64>() / sets.len() as f64))
    };
    table.metrics().iter().copied().filter_map(mean).collect()
}
