//! Stage `unseen`: what the latents and the decoder are worth on instances that no training saw.

use super::{LoadedModel, Pipeline, code, views};
use crate::exit::BenchError;
use crate::metric::Metric;
use crate::output::OutputError;
use crate::score::clustering::cluster_scores;
use crate::score::pca::Pca;
use crate::score::retrieval::{Gallery, recall_at};
use crate::score::viewpoint::{ViewpointTrial, most_likely_azimuth, summarize};
use crate::score::ward::ward_clusters;
use crate::table::{Outcome, Run};
use nalgebra::DVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vantage_dataset::store::Key;
use vantage_dataset::{Seed, Split, Symmetry, View, ViewSet};
use vantage_learn::{LatentGaussian, ViewpointModel};

const FILE: &str = "unseen.json";
/// Name of the latents' row.
pub const LATENTS: &str = "viewpoint_dependent";
/// Name of the floor's row.
pub const PIXELS: &str = "pixels_pca64";
const COMPONENTS: usize = 64;
/// Crops that the floor's basis is fitted on, at most.
const FITTED_ON: usize = 512;

/// Scores on the unseen instances of one seed.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unseen {
    /// Rows of the latents' table.
    pub runs: Vec<Run>,
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

/// The scores of all seeds. Each seed has instances of its own, all of the test split.
pub fn unseen(pipeline: &Pipeline, seeds: &[Seed], model: &LoadedModel) -> Result<Vec<Unseen>, BenchError> {
    let rendered = pipeline.progress.stage("test views", seeds.len() as u64);
    let sets = seeds
        .iter()
        .map(|&seed| {
            let (set, seal) = views(pipeline, Split::Test, seed, &mut |_| ())?;
            rendered.advance(1);
            model.check_unseen(set.instances.iter().map(|instance| instance.id))?;
            Ok((seed, set, seal))
        })
        .collect::<Result<Vec<_>, BenchError>>()?;
    drop(rendered);
    let stage = pipeline.progress.stage("unseen instances", seeds.len() as u64);
    let (cache, note) = (&pipeline.cache, &pipeline.progress);
    sets.par_iter()
        .map(|(seed, set, seal)| {
            let key = Key::new("unseen", &(code::ANSWERED, seal, &model.hash))?;
            let entry = super::stored(cache, note, &key, |work| {
                let json = serde_json::to_vec(&score(*seed, set, model.model.inner())?)?;
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

fn score(seed: Seed, set: &ViewSet, model: &ViewpointModel) -> Result<Unseen, BenchError> {
    let factors: Vec<LatentGaussian> =
        set.views.iter().map(|view| model.encode(&view.crop, &view.viewpoint)).collect::<Result<_, _>>()?;
    let (trials, likelihood) = viewpoints(set, &factors, model)?;

    let embeddings: Vec<Vec<f32>> =
        factors.iter().map(|factor| steady(&single(factor, model).mean, model)).collect();
    let mut latents = partition(set, &embeddings);
    let summary = summarize(&trials.iter().cloned().map(ViewpointTrial::from).collect::<Vec<_>>());
    if let Some(shape) = summary.model {
        latents.insert(Metric::ViewpointMedian, shape.median);
        latents.insert(Metric::ViewpointRight, shape.right);
    }

    let pixels: Vec<Vec<f32>> = set.views.iter().map(|view| view.crop.to_chw()).collect();
    let fitted_on: Vec<Vec<f32>> =
        pixels.iter().step_by(pixels.len().div_ceil(FITTED_ON).max(1)).cloned().collect();
    let floor = match Pca::fit(&fitted_on, COMPONENTS) {
        Some(pca) => {
            let projected: Vec<Vec<f32>> = pixels.iter().map(|sample| pca.project(sample)).collect();
            partition(set, &projected)
        }
        None => BTreeMap::new(),
    };
    let run = |method: &str, scores| Run { method: method.to_owned(), seed, outcome: Outcome::Done, scores };
    Ok(Unseen { runs: vec![run(LATENTS, latents), run(PIXELS, floor)], trials, likelihood })
}

/// The posterior of a latent after one view.
fn single(factor: &LatentGaussian, model: &ViewpointModel) -> LatentGaussian {
    LatentGaussian::posterior(model.latent().dimension, std::slice::from_ref(factor))
}

/// What of a latent does not turn with the object's unknown heading.
fn steady(latent: &DVector<f64>, model: &ViewpointModel) -> Vec<f32> {
    model.latent().steady(latent).into_iter().map(|number| number as f32).collect()
}

/// Clustering with the number of instances given, and retrieval across light.
fn partition(set: &ViewSet, embeddings: &[Vec<f32>]) -> BTreeMap<Metric, f64> {
    let truth: Vec<usize> = set.views.iter().map(|view| view.instance).collect();
    let sessions: Vec<usize> = set.views.iter().map(|view| view.session).collect();
    let mut scores = BTreeMap::new();
    let clusters = ward_clusters(embeddings, set.instances.len());
    if let Some(found) = clusters.and_then(|found| cluster_scores(&truth, &found)) {
        scores.insert(Metric::Ari, found.ari);
        scores.insert(Metric::Nmi, found.nmi);
        scores.insert(Metric::VMeasure, found.v_measure);
    }
    for (metric, gallery) in
        [(Metric::RecallAt1, Gallery::Any), (Metric::RecallAt1AcrossLight, Gallery::OtherSession(&sessions))]
    {
        if let Some(recall) = recall_at(1, embeddings, &truth, gallery).and_then(|found| found.recall) {
            scores.insert(metric, recall);
        }
    }
    scores
}

type Viewpoints = (Vec<UnseenTrial>, Vec<(f64, f64)>);

/// The latent of each instance from the views of its even sessions, and the azimuth of every view of its odd
/// sessions (other light) by the likelihood of Eq. 10 alone; elevation, roll and distance are given.
fn viewpoints(
    set: &ViewSet,
    factors: &[LatentGaussian],
    model: &ViewpointModel,
) -> Result<Viewpoints, BenchError> {
    const OFFSETS: usize = 72;
    let offset = |i: usize| (i as f64 / OFFSETS as f64 * 2.0 - 1.0) * std::f64::consts::PI;
    let (mut trials, mut curve, mut curves) = (Vec::new(), vec![0.0; OFFSETS + 1], 0usize);
    for (index, instance) in set.instances.iter().enumerate() {
        let own = || set.views.iter().zip(factors).filter(move |(view, _)| view.instance == index);
        let known: Vec<LatentGaussian> =
            own().filter(|(view, _)| view.session % 2 == 0).map(|(_, factor)| factor.clone()).collect();
        let latent = LatentGaussian::posterior(model.latent().dimension, &known).mean;
        for (view, _) in own().filter(|(view, _)| view.session % 2 == 1) {
            let likelihood = Likelihood::new(model, &latent, view)?;
            let azimuth = view.viewpoint.azimuth();
            let found =
                most_likely_azimuth(|candidate| likelihood.at(candidate - azimuth).unwrap_or(f64::NAN));
            if instance.symmetry == Symmetry::None
                && let Some(at_truth) = likelihood.at(0.0)
                && let Some(own) = (0..=OFFSETS).map(|i| likelihood.at(offset(i))).collect::<Option<Vec<_>>>()
            {
                for (sum, own) in curve.iter_mut().zip(own) {
                    *sum += own - at_truth;
                }
                curves += 1;
            }
            let (family, symmetry) = (instance.family.clone(), instance.symmetry);
            trials.push(UnseenTrial { family, symmetry, azimuth, found });
        }
    }
    let mean = |(i, sum): (usize, f64)| (offset(i), sum / curves as f64);
    let curve = if curves == 0 { Vec::new() } else { curve.into_iter().enumerate().map(mean).collect() };
    Ok((trials, curve))
}

/// `log p(m(z) | e, x_rel)` of one crop as a function of the azimuth.
struct Likelihood<'a> {
    model: &'a ViewpointModel,
    latent: &'a DVector<f64>,
    view: &'a View,
    measured: DVector<f64>,
    sqrt_information: nalgebra::DMatrix<f64>,
}

impl<'a> Likelihood<'a> {
    fn new(model: &'a ViewpointModel, latent: &'a DVector<f64>, view: &'a View) -> Result<Self, BenchError> {
        let measured = model.measure(&view.crop)?;
        Ok(Self { model, latent, view, measured, sqrt_information: model.noise().sqrt_information() })
    }

    /// Of the azimuth that is `turn` more than the true one; `None` where the model has no answer.
    fn at(&self, turn: f64) -> Option<f64> {
        let x = self.view.viewpoint.turned(turn).conditioning();
        let predicted = self.model.predict(self.latent, &x).ok()?;
        let squared = (&self.sqrt_information * (&self.measured - predicted)).norm_squared();
        let nu = self.model.noise().degrees_of_freedom;
        Some(-0.5 * (nu + self.measured.len() as f64) * libm::log1p(squared / nu))
    }
}
