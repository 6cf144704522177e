//! Episodes to calibrate on: validation objects, and seeds far from those of any scene's evaluation.

use rayon::prelude::*;
use std::error::Error;
use std::path::Path;
use vantage_dataset::store::{read_observations, read_truth};
use vantage_dataset::{Observations, Seed, Split, Truth};
use vantage_eval::pipeline::{Pipeline, RendererChoice, episodes};
use vantage_eval::result::statistics::Mean;
use vantage_eval::score::ate::ate;
use vantage_eval::score::pairs::Pairs;
use vantage_slam::{Estimate, EstimateError};

const FIRST_SEED: u64 = 1_000_000;

/// An episode with its truth.
pub struct Episode {
    pub observations: Observations,
    pub truth: Truth,
}

/// The scene and number of seeds on the command line.
pub fn arguments() -> Result<(Pipeline, u64), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, count] = arguments.as_slice() else { return Err("usage: SCENE SEEDS".into()) };
    Ok((Pipeline::open(Path::new(scene), Path::new("cache"), RendererChoice::Auto)?, count.parse()?))
}

/// Simulates, or takes from the cache.
pub fn validation_episodes(pipeline: &Pipeline, count: u64) -> Result<Vec<Episode>, Box<dyn Error>> {
    let seeds: Vec<Seed> = (0..count).map(|i| Seed(FIRST_SEED + i)).collect();
    let mut read = Vec::new();
    for (_, episode) in episodes(pipeline, &seeds, Split::Validation)? {
        let folder = episode?.folder;
        read.push(Episode { observations: read_observations(&folder)?, truth: read_truth(&folder)? });
    }
    Ok(read)
}

/// Each episode's estimate and its ATE in metres, episodes in parallel.
pub fn scored(
    episodes: &[Episode],
    estimate: impl Fn(&Episode) -> Result<Estimate, EstimateError> + Sync,
) -> Result<Vec<(Estimate, f64)>, String> {
    let one = |episode: &Episode| -> Result<(Estimate, f64), Box<dyn Error>> {
        let answer = estimate(episode)?;
        let pairs = Pairs::by_step(&episode.truth.world_from_robot, &answer.world_from_robot)?;
        let error = ate(&pairs).ok_or("no ATE")?;
        Ok((answer, error))
    };
    episodes.par_iter().map(|episode| one(episode).map_err(|error| error.to_string())).collect()
}

/// `mean`, `difference to reference`, `half width of its 95% interval`, in fixed columns.
pub fn columns(errors: &[f64], reference: &[f64]) -> String {
    let differences: Vec<f64> = errors.iter().zip(reference).map(|(a, b)| a - b).collect();
    let mean = |values: &[f64]| Mean::of(values).map_or(f64::NAN, |mean| mean.mean);
    let half = Mean::of(&differences).and_then(|mean| mean.half_width).unwrap_or(f64::NAN);
    format!("{:8.4}  {:+10.4}  {half:10.4}", mean(errors), mean(&differences))
}
