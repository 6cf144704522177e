//! What a model is worth on instances that no training saw: its latents, and its predictions.

use super::decoder::{Decoded, decode};
use super::embedded_views::{pixels, steady_latents};
use super::embedding::{Labels, Scores, score_embeddings};
use super::unseen_table::{
    OF_CALIBRATION, OF_DECODER, OF_DENSITY, OF_GROUNDING, OF_INSTANCES, OF_LATENTS, UnseenTable,
};
use super::viewpoint::ViewpointTrial;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::{Seed, View, ViewSet};
use vantage_learn::{Model, Viewing};
use vantage_model::{AnswerError, LatentGaussian};

/// Scores on the unseen instances of one seed.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unseen {
    /// The model's scores in each of [`TABLES`](super::unseen_table::TABLES), by its name.
    pub model: BTreeMap<String, Scores>,
    /// Those of the floors, by the name of their table.
    pub floor: BTreeMap<String, Scores>,
    /// Viewpoints found by the decoder.
    pub trials: Vec<ViewpointTrial>,
    /// Offset from the true azimuth, radians, and the mean over the asymmetric queries of the log-likelihood there,
    /// nats relative to that at the true azimuth.
    pub likelihood: Vec<(f64, f64)>,
}

/// What is scored: a model as one of looks from viewpoints, or one that only embeds crops.
#[derive(Clone, Copy)]
pub enum Subject<'a> {
    /// All scores.
    Viewing(&'a dyn Viewing),
    /// Those of embeddings.
    Embedding(&'a Model),
}

/// What of each view is clustered and searched.
pub fn embed(set: &ViewSet, subject: Subject<'_>) -> Result<Vec<Vec<f32>>, AnswerError> {
    match subject {
        Subject::Viewing(model) => Ok(steady_latents(&factors(set, model)?, model.latent())),
        Subject::Embedding(model) => {
            let embed = |view: &View| {
                let numbers = model.embed(&view.crop, None)?;
                Ok(numbers.into_iter().map(|number| number as f32).collect())
            };
            set.views.iter().map(embed).collect()
        }
    }
}

fn factors(set: &ViewSet, model: &dyn Viewing) -> Result<Vec<LatentGaussian>, AnswerError> {
    set.views.iter().map(|view| model.encode(&view.crop, &view.viewpoint)).collect()
}

/// The scores of a set of views, of instances that the model has not seen.
pub fn score(seed: Seed, set: &ViewSet, subject: Subject<'_>) -> Result<Unseen, AnswerError> {
    let labels = Labels::of(set);
    let (embeddings, decoded) = match subject {
        Subject::Viewing(model) => {
            let factors = factors(set, model)?;
            (steady_latents(&factors, model.latent()), decode(set, &factors, model)?)
        }
        Subject::Embedding(_) => (embed(set, subject)?, Decoded::default()),
    };
    let latents = score_embeddings(&embeddings, &labels, seed);
    let pixels = score_embeddings(&pixels(set), &labels, seed);

    let mut given = latents.given;
    given.extend(&decoded.model);
    let rows: [(&UnseenTable, &Scores, Option<&Scores>); 6] = [
        (&OF_LATENTS, &given, Some(&pixels.given)),
        (&OF_INSTANCES, &given, Some(&pixels.given)),
        (&OF_DENSITY, &latents.density, Some(&pixels.density)),
        (&OF_GROUNDING, &latents.grounding, Some(&pixels.grounding)),
        (&OF_DECODER, &decoded.model, Some(&decoded.mean_view)),
        (&OF_CALIBRATION, &decoded.model, None),
    ];
    let of_model = rows.iter().map(|(table, scores, _)| (table.name.to_owned(), table.shown(scores)));
    let of_floor =
        rows.iter().filter_map(|(table, _, floor)| Some((table.name.to_owned(), table.shown((*floor)?))));
    Ok(Unseen {
        model: of_model.collect(),
        floor: of_floor.collect(),
        trials: decoded.trials,
        likelihood: decoded.likelihood,
    })
}
