//! Stage `unseen`: what the latents and the decoder are worth on instances that no training saw.

use super::{LoadedModel, Pipeline, StageError, code, views};
use crate::scene_file::row_name::PIXELS;
use crate::score::embedded_set::EmbeddedSet;
use crate::score::embedded_views::pixels;
use crate::score::embedding::Labels;
use crate::score::unseen::{Subject, Unseen, embed, score};
use rayon::prelude::*;
use std::path::Path;
use vantage_dataset::store::{Key, read_manifest, read_views};
use vantage_dataset::{Seed, Split, ViewSet};

const FILE: &str = "unseen.json";

/// Views of instances that models are scored on.
#[derive(Clone, Debug)]
pub struct ScoredViews {
    /// Their seed.
    pub seed: Seed,
    /// The views.
    pub set: ViewSet,
    /// What identifies them.
    pub seal: String,
}

/// The test views of all seeds. Each seed has instances of its own.
pub fn test_views(pipeline: &Pipeline, seeds: &[Seed]) -> Result<Vec<ScoredViews>, StageError> {
    let rendered = pipeline.progress.stage("test views", seeds.len() as u64);
    let of_seed = |&seed: &Seed| {
        let (set, seal) = views(pipeline, Split::Test, seed, &mut |_| ())?;
        rendered.advance(1);
        Ok(ScoredViews { seed, set, seal })
    };
    seeds.iter().map(of_seed).collect()
}

/// A stored view set; `named_by` is the setting or the option that names its folder.
pub fn imported_views(folder: &Path, named_by: &str) -> Result<ScoredViews, StageError> {
    if !folder.is_dir() {
        return Err(StageError::NoViews { named_by: named_by.to_owned(), folder: folder.to_owned() });
    }
    Ok(ScoredViews { seed: Seed(0), set: read_views(folder)?, seal: read_manifest(folder)?.seal })
}

/// The scores on each set, of instances none of which the model has seen, as the caller has made sure; `hash` identifies the model.
pub fn unseen(
    pipeline: &Pipeline,
    sets: &[ScoredViews],
    subject: Subject<'_>,
    hash: &str,
) -> Result<Vec<Unseen>, StageError> {
    let stage = pipeline.progress.stage("unseen instances", sets.len() as u64);
    let cache = &pipeline.cache;
    sets.par_iter()
        .map(|ScoredViews { seed, set, seal }| {
            let key = Key::new("unseen", &(code::SCORED, seal, hash))?;
            let found = cache.json(&key, FILE, || finite(*seed, score(*seed, set, subject)?))?;
            stage.advance(1);
            Ok(found)
        })
        .collect()
}

/// The embeddings of a set by each model, and those of the floor.
pub fn embedded(models: &[LoadedModel], set: &ViewSet) -> Result<Vec<EmbeddedSet>, StageError> {
    let labels = Labels::of(set);
    let of_model = |model: &LoadedModel| {
        let embeddings = embed(set, Subject::Viewing(model.viewing()))?;
        Ok(EmbeddedSet::new(model.name.clone(), embeddings, labels.clone()))
    };
    let floor = EmbeddedSet::new(PIXELS.to_owned(), pixels(set), labels.clone());
    models.iter().map(of_model).chain([Ok(floor)]).collect()
}

/// What is no number is written as null, and could not be read again.
fn finite(seed: Seed, scores: Unseen) -> Result<Unseen, StageError> {
    let json = serde_json::to_vec(&scores)?;
    serde_json::from_slice::<Unseen>(&json).map_err(|_| StageError::NotFinite { seed: seed.0 })?;
    Ok(scores)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn scores_that_are_no_numbers_are_not_cached() {
        let scores = |at_truth: f64| Unseen {
            model: BTreeMap::new(),
            floor: BTreeMap::new(),
            trials: Vec::new(),
            likelihood: vec![(0.0, at_truth)],
        };
        assert!(finite(Seed(3), scores(-1.5)).is_ok());
        for broken in [f64::NAN, f64::INFINITY] {
            assert!(matches!(finite(Seed(3), scores(broken)), Err(StageError::NotFinite { seed: 3 })));
        }
    }
}
