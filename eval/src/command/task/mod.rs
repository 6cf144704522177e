//! `bench task SCENE --out DIR --truth DIR --secret TEXT`: what a robot would have, for others to work on, and the truth kept back.

pub mod error;
pub mod sealed;

use crate::command::cli::TaskArgs;
use crate::command::error::BenchError;
use crate::command::placed;
use crate::exit::Exit;
use crate::pipeline::{SIMULATED, concerns_one_seed};
use crate::progress::Progress;
use crate::result::output_folder::OutputFolder;
use crate::scene_file::{self, SceneFile};
use error::TaskError;
use sealed::{FORMAT, SEALED, Sealed, SealedEpisode, TASK, Task, drawn, published};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{
    Content, Manifest, Provenance, read_observations, replace, verify, write_episode, write_observations,
};
use vantage_dataset::{Seed, Split};
use vantage_formats::SET_ASIDE;
use vantage_sim::checked::CheckedScene;
use vantage_sim::episode::simulate;
use vantage_sim::render::Renderer;
use vantage_sim::render::choice::open;

/// Shortest secret, characters.
const SECRET: usize = 12;
/// Seeds without a world that are passed over, as many for each episode at most.
const PASSED_OVER: u64 = 20;

/// Writes both. A killed run is taken up.
pub fn task(args: &TaskArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    if args.secret.chars().count() < SECRET {
        return Err(TaskError::Secret { found: args.secret.chars().count() }.into());
    }
    let (out, kept) = (OutputFolder::probe(&args.out)?, OutputFolder::probe(&args.truth)?);
    apart(out.path(), kept.path())?;
    let file: SceneFile = scene_file::read(&args.scene)?;
    if file.evaluation.episodes.is_some() || file.robot.path.stations() {
        let what = "no robot drives in it, or its episodes were recorded";
        return Err(TaskError::Unsuitable { scene: args.scene.clone(), what }.into());
    }
    let progress = Progress::detect();
    let (_out_lock, _kept_lock) = (out.lock(&progress)?, kept.lock(&progress)?);
    let scene = file.checked(&args.scene, &progress)?;
    let opened = open(args.making.renderer.into())?;
    if let Some(notice) = &opened.notice {
        progress.note(notice);
    }
    if let Ok(there) = Task::read(out.path())
        && (&there.scene, there.association, there.episodes) != (&file.name, args.association, args.episodes)
    {
        return Err(TaskError::Taken { path: args.out.clone() }.into());
    }
    let scene_hash = scene_file::hash(&(scene.world(), scene.robot(), scene.sensors()))?;
    let provenance: Provenance = BTreeMap::from([
        ("scene".to_owned(), file.name.clone().into()),
        ("scene_hash".to_owned(), scene_hash.clone().into()),
        ("code".to_owned(), SIMULATED.into()),
    ]);
    let mut maker = Maker { scene: &scene, kept: &kept, renderer: opened.renderer, provenance };
    let stage = progress.stage("episodes", args.episodes);
    let (mut episodes, mut draw) = (Vec::new(), 0);
    while (episodes.len() as u64) < args.episodes {
        let last = draw >= PASSED_OVER * args.episodes;
        let seed = drawn(&args.secret, draw);
        draw += 1;
        let number = episodes.len();
        match maker.whole(number, seed) {
            Ok(manifest) => {
                let order = maker.public(number, args, &out)?;
                episodes.push(SealedEpisode { seed, seal: manifest.seal, order });
                stage.advance(1);
            }
            Err(BenchError::Sim(error)) if concerns_one_seed(&error) && !last => {}
            Err(BenchError::Sim(error)) => return Err(placed(error, &args.scene)),
            Err(error) => return Err(error),
        }
    }
    drop(stage);
    let sealed = Sealed {
        format: FORMAT,
        scene: file.name.clone(),
        scene_hash,
        association: args.association,
        secret: args.secret.clone(),
        episodes,
    };
    let bytes = serde_json::to_vec_pretty(&sealed)?;
    kept.write(SEALED, &bytes)?;
    let task = Task {
        format: FORMAT,
        scene: file.name,
        association: args.association,
        episodes: args.episodes,
        truth: blake3::hash(&bytes).to_hex().to_string(),
    };
    out.write(TASK, &serde_json::to_vec_pretty(&task)?)?;
    writeln!(
        stdout,
        "{} episodes to publish in {}\nthe truth, to keep back, in {}\nhash of the truth: {}",
        args.episodes,
        out.path().display(),
        kept.path().display(),
        task.truth
    )?;
    Ok(Exit::Success)
}

/// Refuses to publish the truth.
fn apart(out: &Path, kept: &Path) -> Result<(), TaskError> {
    let absolute = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let (a, b) = (absolute(out), absolute(kept));
    match a.starts_with(&b) || b.starts_with(&a) {
        true => Err(TaskError::Inside { path: kept.to_owned() }),
        false => Ok(()),
    }
}

struct Maker<'a> {
    scene: &'a CheckedScene,
    kept: &'a OutputFolder,
    renderer: Box<dyn Renderer>,
    provenance: Provenance,
}

impl Maker<'_> {
    /// The whole episode, made where it is not there.
    fn whole(&mut self, number: usize, seed: Seed) -> Result<Manifest, BenchError> {
        let folder = self.kept.path().join(number.to_string());
        let is_made = |manifest: &Manifest| {
            manifest.provenance == self.provenance && manifest.content == Content::Episode { seed }
        };
        match verify(&folder) {
            Ok(manifest) if is_made(&manifest) => return Ok(manifest),
            Ok(_) => return Err(TaskError::Taken { path: folder }.into()),
            Err(_) => {}
        }
        let episode = simulate(self.scene, seed, Split::Test, self.renderer.as_mut(), &mut |_| {})?;
        let partial = partial(self.kept.path(), number);
        let manifest = write_episode(&partial, &episode, self.provenance.clone())?;
        replace(&partial, &folder, &self.kept.path().join(SET_ASIDE))?;
        Ok(manifest)
    }

    /// What is published of it, and of each detection its number in the whole episode.
    fn public(&self, number: usize, args: &TaskArgs, out: &OutputFolder) -> Result<Vec<usize>, BenchError> {
        let given = read_observations(&self.kept.path().join(number.to_string()))?;
        let (observations, order) = published(&given, args.association);
        let partial = partial(out.path(), number);
        let of = BTreeMap::from([("task_of".to_owned(), self.provenance["scene"].clone())]);
        write_observations(&partial, Seed(number as u64), &observations, of)?;
        replace(&partial, &out.path().join(number.to_string()), &out.path().join(SET_ASIDE))?;
        Ok(order)
    }
}

fn partial(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("{number}.partial"))
}
