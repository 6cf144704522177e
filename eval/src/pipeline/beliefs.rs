//! What answers leave of objects, P(e | H) or P(c | H), and the table that it is scored in.

use super::{Answer, StoredObject};
use crate::result::run::Run;
use crate::result::table::{Table, TableError};
use crate::score::semantics::{Belief, COLUMNS, Named, SEMANTICS, semantic_scores};
use nalgebra::DVector;
use vantage_dataset::{ObjectTruth, Seed};
use vantage_learn::Latent;

/// The latents or classes of an answer's objects, with their true classes; none of an estimator without either. `names` are those of the
/// classes that it tells apart.
pub(super) fn of(answer: &Answer, truth: &[ObjectTruth], latent: Latent, names: &[String]) -> Vec<Belief> {
    let belief = |(object, stored): (&ObjectTruth, &Option<StoredObject>)| {
        let stored = stored.as_ref()?;
        let steady = |[means, _]: &[Vec<f64>; 2]| -> Vec<f32> {
            let steady = latent.steady(&DVector::from_column_slice(means));
            steady.into_iter().map(|number| number as f32).collect()
        };
        let latent = stored.latent.as_ref().map(steady);
        let named = stored.classes.as_ref().map(|classes| Named::new(classes, names, &object.family));
        (latent.is_some() || named.is_some()).then(|| Belief { class: object.family.clone(), latent, named })
    };
    truth.iter().zip(&answer.objects).filter_map(belief).collect()
}

/// The table of the methods that have latents or classes, from runs without scores; `None` where there is no such method.
///
/// The gallery of a seed are the objects of all lower seeds, so that a run on fewer seeds gives them the same scores.
pub(super) fn table(
    methods: &[&str],
    seeds: &[Seed],
    left: Vec<(Run, Vec<Belief>)>,
) -> Result<Option<Table>, TableError> {
    let has_beliefs = |method: &&str| left.iter().any(|(run, own)| run.method == *method && !own.is_empty());
    let methods: Vec<&str> = methods.iter().copied().filter(has_beliefs).collect();
    if methods.is_empty() {
        return Ok(None);
    }
    let scored = |(run, own): &(Run, Vec<Belief>)| {
        let earlier = left.iter().filter(|(other, _)| other.method == run.method && other.seed < run.seed);
        let mut earlier: Vec<(Seed, &[Belief])> =
            earlier.map(|(other, own)| (other.seed, &own[..])).collect();
        earlier.sort_by_key(|(seed, _)| *seed);
        let gallery: Vec<Belief> = earlier.into_iter().flat_map(|(_, own)| own.iter().cloned()).collect();
        Run { scores: semantic_scores(own, &gallery, run.seed), ..run.clone() }
    };
    let runs = left.iter().filter(|(run, _)| methods.contains(&&*run.method)).map(scored).collect();
    Table::new(SEMANTICS, &methods, None, &COLUMNS, seeds, runs).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::metric::Metric;
    use crate::result::run::Outcome;
    use std::collections::BTreeMap;

    fn left(method: &str, seed: u64, believed: &[(&str, f32)]) -> (Run, Vec<Belief>) {
        let (outcome, scores) = (Outcome::Done, BTreeMap::new());
        let run = Run { method: method.to_owned(), seed: Seed(seed), outcome, scores };
        let belief = |(class, x): &(&str, f32)| Belief {
            class: (*class).to_owned(),
            latent: Some(vec![*x]),
            named: None,
        };
        (run, believed.iter().map(belief).collect())
    }

    fn recalls(table: &Table, method: &str) -> Vec<Option<f64>> {
        let runs = table.runs_of(method).iter();
        runs.map(|run| run.scores.get(&Metric::ClassRecallAt1).copied()).collect()
    }

    #[test]
    fn a_seed_is_answered_by_lower_ones_alone_however_many_are_run() {
        let all = |seeds: u64| {
            let mut all: Vec<_> = (0..seeds)
                .flat_map(|seed| {
                    let mine = left("mine", seed, &[("mug", 0.1 * seed as f32), ("book", 5.0)]);
                    [mine, left("geometric", seed, &[])]
                })
                .collect();
            all.reverse();
            let seeds: Vec<Seed> = (0..seeds).map(Seed).collect();
            table(&["geometric", "mine"], &seeds, all).unwrap().unwrap()
        };
        assert_eq!(all(3).methods(), ["mine"]);
        assert_eq!(recalls(&all(3), "mine"), [None, Some(1.0), Some(1.0)]);
        assert_eq!(recalls(&all(3), "mine")[..2], recalls(&all(2), "mine"));
    }

    #[test]
    fn without_latents_there_is_no_table() {
        assert_eq!(table(&["geometric"], &[Seed(0)], vec![left("geometric", 0, &[])]).unwrap(), None);
    }
}
