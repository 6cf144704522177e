//! Stage `episode`: what a robot observes under each seed.

use super::{Pipeline, StageError, code};
use nalgebra::Vector3;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Content, Key, read_manifest, read_truth, verify, write_episode};
use vantage_dataset::{Seed, Split};
use vantage_sim::error::SimError;
use vantage_sim::object::{Fixture, MeshLibrary};
use vantage_sim::render::RendererInfo;
use vantage_sim::scene::{RobotSpec, SensorSpec, WorldSpec};
use vantage_sim::simulate;

/// The most degrees by which a recorded robot may tilt at the first step: three and a half times the default `tilt_sigma` of objects.
const MOST_TILT_DEG: f64 = 10.0;

#[derive(Serialize)]
struct Inputs<'a> {
    code: &'static str,
    /// As the episode's provenance has it, which its seal covers: a scene of the same world has a seal of its own.
    scene: &'a str,
    world: &'a WorldSpec,
    #[serde(skip_serializing_if = "MeshLibrary::is_empty")]
    meshes: &'a MeshLibrary,
    #[serde(skip_serializing_if = "<[Fixture]>::is_empty")]
    fixtures: &'a [Fixture],
    robot: &'a RobotSpec,
    sensors: &'a SensorSpec,
    seed: Seed,
    split: Split,
    renderer: &'a RendererInfo,
}

/// A stored episode.
#[derive(Clone, Debug)]
pub struct EpisodeFolder {
    /// Its seed.
    pub seed: Seed,
    /// Where it is.
    pub folder: PathBuf,
    /// What identifies it.
    pub seal: String,
}

/// A seed and its episode, or why there is none.
pub type SeedEpisode = (Seed, Result<EpisodeFolder, String>);

/// The episodes of all seeds, with objects of a split, in the order of the seeds.
///
/// A world that does not stand (an object that will not settle, say) is the answer for its seed and stays in every
/// denominator; only where no seed has a world at all is it an error.
pub fn episodes(pipeline: &Pipeline, seeds: &[Seed], split: Split) -> Result<Vec<SeedEpisode>, StageError> {
    if let Some(folder) = pipeline.recorded().filter(|_| split == Split::Test) {
        return recorded(&folder, seeds);
    }
    let stage = pipeline.progress.stage("episodes", seeds.len() as u64);
    let mut made = Vec::with_capacity(seeds.len());
    let mut failure = None;
    for &seed in seeds {
        let episode = match episode(pipeline, seed, split) {
            Ok(episode) => Ok(episode),
            Err(StageError::Sim(error)) if concerns_one_seed(&error) => {
                let reason = error.to_string();
                failure = Some(error);
                Err(reason)
            }
            Err(error) => return Err(error),
        };
        made.push((seed, episode));
        stage.advance(1);
    }
    match failure {
        Some(error) if made.iter().all(|(_, episode)| episode.is_err()) => Err(error.into()),
        _ => Ok(made),
    }
}

/// What the provenance of an episode says of its odometry where no noise was added.
pub const TRUE_MOTION: &str = "true motion";

/// What a reader of scores on recorded episodes has to know of them.
pub fn recorded_caveat(episodes: &[SeedEpisode]) -> Result<String, StageError> {
    let (mut parts, mut true_motion, mut all) = (BTreeSet::new(), false, 0);
    for episode in episodes.iter().filter_map(|(_, episode)| episode.as_ref().ok()) {
        let provenance = read_manifest(&episode.folder)?.provenance;
        parts.extend(provenance.get("part").map(ToString::to_string));
        true_motion |= provenance.get("odometry").is_some_and(|odometry| odometry == TRUE_MOTION);
        all += 1;
    }
    let mut text = "The episodes were recorded.".to_owned();
    if true_motion {
        text += " Their odometry is the true motion, which no robot has.";
    }
    if !parts.is_empty() && parts.len() < all {
        text += &format!(
            " They are {} ways, each with several draws of noise: intervals take them for independent.",
            parts.len()
        );
    }
    Ok(text)
}

/// Episodes that were recorded, each checked as far as its hashes go. The robot has to be level at the first step, as its pose there is the
/// estimators' world.
fn recorded(folder: &Path, seeds: &[Seed]) -> Result<Vec<SeedEpisode>, StageError> {
    if !folder.is_dir() {
        return Err(StageError::NoEpisodes { folder: folder.to_owned() });
    }
    let read = |seed: Seed| {
        let folder = folder.join(seed.0.to_string());
        if !folder.is_dir() {
            return Err(StageError::NoEpisode { folder });
        }
        let manifest = verify(&folder)?;
        if manifest.content != (Content::Episode { seed }) {
            return Err(StageError::OtherEpisode { folder });
        }
        if let Some(first) = read_truth(&folder)?.world_from_robot.first() {
            let degrees = (first.rotation * Vector3::z()).angle(&Vector3::z()).to_degrees();
            if degrees > MOST_TILT_DEG {
                return Err(StageError::TiltedRobot { folder, degrees, limit: MOST_TILT_DEG });
            }
        }
        Ok((seed, Ok(EpisodeFolder { seed, folder, seal: manifest.seal })))
    };
    seeds.iter().map(|seed| read(*seed)).collect()
}

fn episode(pipeline: &Pipeline, seed: Seed, split: Split) -> Result<EpisodeFolder, StageError> {
    let scene = &pipeline.scene;
    let inputs = Inputs {
        code: code::SIMULATED,
        scene: &pipeline.file.name,
        world: scene.world(),
        meshes: scene.meshes(),
        fixtures: scene.fixtures(),
        robot: scene.robot(),
        sensors: scene.sensors(),
        seed,
        split,
        renderer: &pipeline.renderer_info,
    };
    let entry = pipeline.cache.entry(&Key::new("episode", &inputs)?, |folder| {
        let mut renderer = pipeline.renderer.borrow_mut();
        let episode = simulate(scene, seed, split, renderer.as_mut(), &mut |_| {})?;
        let provenance = BTreeMap::from([
            ("scene".to_owned(), pipeline.file.name.clone().into()),
            ("renderer".to_owned(), serde_json::to_value(&pipeline.renderer_info)?),
        ]);
        write_episode(folder, &episode, provenance)?;
        Ok(())
    })?;
    let seal = read_manifest(&entry.folder)?.seal;
    Ok(EpisodeFolder { seed, folder: entry.folder, seal })
}

/// Whether another seed may do better.
pub fn concerns_one_seed(error: &SimError) -> bool {
    matches!(
        error,
        SimError::NothingFits { .. }
            | SimError::DidNotSettle { .. }
            | SimError::LeftTheWorld { .. }
            | SimError::LeftThePath { .. }
            | SimError::NoWalk { .. }
            | SimError::BlockedPath { .. }
            | SimError::NonFinite { .. }
    )
}
