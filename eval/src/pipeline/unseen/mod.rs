//! Stage `unseen`: what the latents and the decoder are worth on instances that no training saw.

mod decoder;
mod latents;
mod likelihood;
mod tables;

pub use likelihood::Likelihood;
pub use tables::{LATENTS, MEAN_VIEW, OF_LATENTS, PIXELS, TABLES, UnseenTable};

use super::{Pipeline, code, views};
use crate::error::BenchError;
use crate::output::OutputError;
use crate::score::embedding::{Labels, Scores, score_embeddings};
use crate::score::viewpoint::ViewpointTrial;
use crate::table::Run;
use decoder::Decoded;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::store::{Key, read_manifest, read_views};
use vantage_dataset::{Seed, Split, Symmetry, View, ViewSet};
use vantage_learn::{LatentGaussian, Model, Viewing};

const FILE: &str = "unseen.json";

/// Scores on the unseen instances of one seed.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unseen {
    /// Rows of each of [`TABLES`], by its name.
    pub runs: BTreeMap<String, Vec<Run>>,
    /// Viewpoints found by the decoder.
    pub trials: Vec<UnseenTrial>,
    /// Offset from the true azimuth, radians, and the mean over the asymmetric queries of the log-likelihood there,
    /// nats relative to that at the true azimuth.
    pub likelihood: Vec<(f64, f64)>,
}

/// One viewpoint query.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnseenTrial {
    family: String,
    symmetry: Symmetry,
    azimuth: f64,
    found: Option<f64>,
}

impl From<UnseenTrial> for ViewpointTrial {
    fn from(trial: UnseenTrial) -> Self {
        let UnseenTrial { family, symmetry, azimuth, found } = trial;
        Self { family, symmetry, azimuth, found }
    }
}

/// What is scored: a model as one of looks from viewpoints, or one that only embeds crops.
#[derive(Clone, Copy)]
pub enum Subject<'a> {
    /// All scores.
    Viewing(&'a dyn Viewing),
    /// Those of embeddings.
    Embedding(&'a Model),
}

/// Views of instances that models are scored on.
pub struct ScoredViews {
    /// Their seed.
    pub seed: Seed,
    /// The views.
    pub set: ViewSet,
    /// What identifies them.
    pub seal: String,
}

/// The test views of all seeds. Each seed has instances of its own.
pub fn test_views(pipeline: &Pipeline, seeds: &[Seed]) -> Result<Vec<ScoredViews>, BenchError> {
    let rendered = pipeline.progress.stage("test views", seeds.len() as u64);
    let of_seed = |&seed: &Seed| {
        let (set, seal) = views(pipeline, Split::Test, seed, &mut |_| ())?;
        rendered.advance(1);
        Ok(ScoredViews { seed, set, seal })
    };
    seeds.iter().map(of_seed).collect()
}

/// A stored view set, to be scored.
pub fn imported_views(folder: &Path) -> Result<ScoredViews, BenchError> {
    if !folder.is_dir() {
        return Err(BenchError::NoFolder { folder: folder.to_owned() });
    }
    Ok(ScoredViews { seed: Seed(0), set: read_views(folder)?, seal: read_manifest(folder)?.seal })
}

/// The scores on each set, of instances none of which the model has seen, as the caller has made sure; `hash` identifies the model.
pub fn unseen(
    pipeline: &Pipeline,
    sets: &[ScoredViews],
    subject: Subject<'_>,
    hash: &str,
) -> Result<Vec<Unseen>, BenchError> {
    let stage = pipeline.progress.stage("unseen instances", sets.len() as u64);
    let (cache, note) = (&pipeline.cache, &pipeline.progress);
    sets.par_iter()
        .map(|ScoredViews { seed, set, seal }| {
            let key = Key::new("unseen", &(code::ANSWERED, seal, hash))?;
            let entry = super::stored(cache, note, &key, |work| {
                let json = serde_json::to_vec(&score(*seed, set, subject)?)?;
                let path = work.join(FILE);
                std::fs::write(&path, json).map_err(|source| OutputError { path, source })?;
                Ok(())
            })?;
            let path = entry.folder.join(FILE);
            let invalid = |reason: String| BenchError::StoredAnswers { path: path.clone(), reason };
            let json = std::fs::read(&path).map_err(|error| invalid(error.to_string()))?;
            stage.advance(1);
            serde_json::from_slice(&json).map_err(|error| invalid(error.to_string()))
        })
        .collect()
}

fn score(seed: Seed, set: &ViewSet, subject: Subject<'_>) -> Result<Unseen, BenchError> {
    let labels = Labels::of(set);
    let (embeddings, decoded) = match subject {
        Subject::Viewing(model) => {
            let encode = |view: &View| model.encode_view(&view.crop, &view.viewpoint);
            let factors: Vec<LatentGaussian> = set.views.iter().map(encode).collect::<Result<_, _>>()?;
            (latents::steady_latents(&factors, model.latent()), decoder::decode(set, &factors, model)?)
        }
        Subject::Embedding(model) => {
            let embed = |view: &View| {
                let numbers = model.embed(&view.crop, None)?;
                Ok(numbers.into_iter().map(|number| number as f32).collect())
            };
            let embeddings = set.views.iter().map(embed).collect::<Result<Vec<Vec<f32>>, BenchError>>()?;
            (embeddings, Decoded::default())
        }
    };
    let latents = score_embeddings(&embeddings, &labels, seed);
    let pixels = score_embeddings(&latents::pixels(set), &labels, seed);

    let mut given = latents.given;
    given.extend(&decoded.model);
    let rows: [(&UnseenTable, &[(&str, &Scores)]); 6] = [
        (&tables::OF_LATENTS, &[(LATENTS, &given), (PIXELS, &pixels.given)]),
        (&tables::OF_INSTANCES, &[(LATENTS, &given), (PIXELS, &pixels.given)]),
        (&tables::OF_DENSITY, &[(LATENTS, &latents.density), (PIXELS, &pixels.density)]),
        (&tables::OF_GROUNDING, &[(LATENTS, &latents.grounding), (PIXELS, &pixels.grounding)]),
        (&tables::OF_DECODER, &[(LATENTS, &decoded.model), (MEAN_VIEW, &decoded.mean_view)]),
        (&tables::OF_CALIBRATION, &[(LATENTS, &decoded.model)]),
    ];
    let runs = rows.iter().map(|(table, methods)| (table.name.to_owned(), table.rows(seed, methods)));
    Ok(Unseen { runs: runs.collect(), trials: decoded.trials, likelihood: decoded.likelihood })
}
