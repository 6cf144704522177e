//! The manifest of a run, written while it runs: what it was asked, how long each stage took, what it was made of.

use crate::command::cli::StageArgs;
use crate::command::error::BenchError;
use crate::pipeline::{LoadedModel, Pipeline, ScoredViews, SeedEpisode, caveat, recorded_caveat};
use crate::result::manifest::{Manifest, Renderer};
use crate::score::association_entry::AssociationEntry;
use crate::score::entry::Entry;
use std::time::Instant;
use vantage_dataset::Seed;

/// A manifest under way.
pub struct Record(Manifest);

impl Record {
    /// Of a scene, under some seeds and options.
    pub fn begin(pipeline: &Pipeline, seeds: &[Seed], stages: &StageArgs) -> Result<Self, BenchError> {
        Ok(Self(Manifest {
            renderer: Renderer::from(&pipeline.renderer_info),
            options: serde_json::to_value(stages)?,
            ..Manifest::new(&pipeline.scene_hash, seeds)
        }))
    }

    /// Runs a stage, and notes how long it took.
    pub fn timed<T, E>(&mut self, stage: &str, run: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let start = Instant::now();
        let made = run()?;
        self.0.took(stage, start.elapsed());
        Ok(made)
    }

    /// The manifest of what came out; the dataset is the episodes or, where no robot drives, the views.
    pub fn finish(
        self,
        pipeline: &Pipeline,
        models: &[LoadedModel],
        (entries, associated): (&[Entry], &[AssociationEntry]),
        episodes: &[SeedEpisode],
        views: &[ScoredViews],
    ) -> Result<Manifest, BenchError> {
        let made =
            episodes.iter().map(|(seed, made)| (*seed, made.as_ref().map_or("none", |made| &made.seal)));
        let looked = views.iter().filter(|_| episodes.is_empty()).map(|views| (views.seed, &*views.seal));
        // One model needs no name.
        let (single, several) = match models {
            [single] => (Some(single), &[][..]),
            several => (None, several),
        };
        let mut caveats = Vec::new();
        for model in models {
            let name = if single.is_some() { String::new() } else { format!(" {}", model.name) };
            caveats.extend(caveat(pipeline, &model.model)?.map(|what| format!("The model{name} {what}.")));
        }
        if pipeline.recorded().is_some() {
            let caveat = recorded_caveat(episodes)?;
            pipeline.progress.note(&format!("note: {caveat}"));
            caveats.push(caveat);
        }
        Ok(Manifest {
            model_hash: single.map(|model| model.model.hash().to_owned()),
            model_hashes: several
                .iter()
                .map(|model| (model.name.clone(), model.model.hash().to_owned()))
                .collect(),
            trajectories: entries.iter().map(|entry| (entry.name.clone(), entry.hash.clone())).collect(),
            associations: associated.iter().map(|entry| (entry.name.clone(), entry.hash.clone())).collect(),
            caveat: (!caveats.is_empty()).then(|| caveats.join(" ")),
            dataset_hash: Some(dataset_hash(made.chain(looked))),
            ..self.0
        })
    }
}

fn dataset_hash<'a>(seals: impl Iterator<Item = (Seed, &'a str)>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (seed, seal) in seals {
        hasher.update(&seed.0.to_le_bytes());
        hasher.update(seal.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}
