//! Stage `found`: which object each detection of an episode is of, by an associator, where rows are not told it by the episode.

use super::associating::{Associating, Identity};
use super::{LoadedModel, Pipeline, SeedEpisode, StageError, code};
use crate::scene_file::associator::AssociatedBy;
use crate::scene_file::estimator::EstimatorSpec;
use crate::score::association::canonical;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::store::{Key, read_observations};
use vantage_slam::Association;

const FILE: &str = "found.json";

/// Probability below which a way to tell who is who is left out.
const LEAST_WEIGHT: f64 = 0.01;
/// Ways that are kept at most.
const WAYS: usize = 8;

/// Ways to tell who is who on an episode, the likeliest first; at least one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Found {
    /// Each with its probability; they add up to 1.
    pub ways: Vec<Way>,
}

/// What is found on an episode, or why nothing is.
pub type Finding = Result<Found, String>;

/// One of the ways.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Way {
    /// Its probability.
    pub weight: f64,
    /// Of each detection its object, numbered as they come; none of one that is of nothing.
    pub objects: Vec<Option<usize>>,
}

/// What an associator finds on each episode; why not, where it fails.
pub fn found(
    pipeline: &Pipeline,
    episodes: &[SeedEpisode],
    by: AssociatedBy,
    (associating, model): (&Associating<'_>, &LoadedModel),
) -> Result<Vec<Finding>, StageError> {
    let stage = pipeline.progress.stage("who is who", episodes.len() as u64);
    // Whatever rows there are, their settings alone count, and no layer is learnt.
    let spec = EstimatorSpec { rows: Vec::new(), decoder_rounds: None, ..pipeline.file.estimator.clone() };
    let cache = &pipeline.cache;
    let of_episode = |(_, episode): &SeedEpisode| {
        stage.advance(1);
        let episode = match episode {
            Ok(episode) => episode,
            Err(reason) => return Ok(Err(reason.clone())),
        };
        let identity = Identity { spec: &spec, ..associating.identity(vec![model.model.hash()]) };
        let key = Key::new("found", &(code::FOUND, &episode.seal, by, identity))?;
        cache.json(&key, FILE, || {
            let observations = read_observations(&episode.folder)?;
            let answered = associating.ask(by, &observations)?;
            let found = |association: &Association| {
                Found::of(association, observations.detections.len(), |objects| {
                    answered.of_detections(objects)
                })
            };
            Ok(answered.answer.as_ref().map(found).map_err(String::clone))
        })
    };
    episodes.par_iter().map(of_episode).collect()
}

impl Found {
    /// Several estimates of one way are one. Objects are numbered as their tracklets come, which tells nothing of them.
    fn of(
        association: &Association,
        detections: usize,
        of_detections: impl Fn(&[Option<usize>]) -> Vec<Option<usize>>,
    ) -> Self {
        let mut weights: BTreeMap<Vec<Option<usize>>, f64> = BTreeMap::new();
        for hypothesis in association.hypotheses.iter().filter(|hypothesis| hypothesis.weight > 0.0) {
            *weights.entry(canonical(hypothesis.objects.iter().copied())).or_default() += hypothesis.weight;
        }
        let mut ways: Vec<(f64, Vec<Option<usize>>)> =
            weights.into_iter().map(|(objects, weight)| (weight, of_detections(&objects))).collect();
        if ways.is_empty() {
            ways.push((1.0, vec![None; detections]));
        }
        ways.sort_by(|a, b| b.0.total_cmp(&a.0));
        ways.truncate(WAYS);
        let least = ways[0].0.min(LEAST_WEIGHT);
        ways.retain(|(weight, _)| *weight >= least);
        let total: f64 = ways.iter().map(|(weight, _)| weight).sum();
        let way = |(weight, objects)| Way { weight: weight / total, objects };
        Self { ways: ways.into_iter().map(way).collect() }
    }

    /// The likeliest way.
    pub fn likeliest(&self) -> &[Option<usize>] {
        &self.ways[0].objects
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use vantage_slam::WeightedPartition;

    fn of(hypotheses: &[(f64, &[Option<usize>])]) -> Found {
        let partition = |(weight, objects): &(f64, &[Option<usize>])| WeightedPartition {
            weight: *weight,
            objects: objects.to_vec(),
        };
        let hypotheses = hypotheses.iter().map(partition).collect();
        let association = Association { hypotheses, ..Association::default() };
        Found::of(&association, 3, <[_]>::to_vec)
    }

    #[test]
    fn estimates_of_one_way_are_one_and_what_is_hardly_likely_is_left_out() {
        let found = of(&[
            (0.495, &[Some(0), Some(1), Some(1)]),
            (0.4, &[Some(4), Some(7), Some(7)]),
            (0.1, &[Some(0), Some(1), None]),
            (0.005, &[Some(0), Some(1), Some(2)]),
        ]);
        assert_eq!(found.ways.len(), 2);
        assert_eq!(found.likeliest(), [Some(0), Some(1), Some(1)]);
        assert_relative_eq!(found.ways[0].weight, 0.895 / 0.995, epsilon = 1e-12);
        assert_relative_eq!(found.ways[1].weight, 0.1 / 0.995, epsilon = 1e-12);
    }

    #[test]
    fn where_nothing_is_said_nothing_is_seen() {
        let found = of(&[]);
        assert_eq!(found.ways, [Way { weight: 1.0, objects: vec![None; 3] }]);
    }
}
