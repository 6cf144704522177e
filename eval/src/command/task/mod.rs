//! `bench task SCENE --out DIR --truth DIR --secret FILE`: what a robot would have, for others to work on, and the truth kept back.

pub mod error;
pub mod sealed;

use crate::code::SIMULATED;
use crate::command::cli::TaskArgs;
use crate::command::error::BenchError;
use crate::command::placed;
use crate::exit::Exit;
use crate::pipeline::concerns_one_seed;
use crate::progress::Progress;
use crate::result::output_folder::OutputFolder;
use crate::scene_file::{self, SceneFile};
use error::TaskError;
use sealed::{FORMAT, SEALED, Sealed, SealedEpisode, TASK, Task, drawn, published};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{
    Content, FolderLock, Manifest, Provenance, read_observations, read_regular, read_truth, replace, verify,
    write_episode, write_observations,
};
use vantage_dataset::{Pose, Seed, Split};
use vantage_formats::SET_ASIDE;
use vantage_sim::checked::CheckedScene;
use vantage_sim::episode::simulate;
use vantage_sim::render::Renderer;
use vantage_sim::render::choice::open;

/// Shortest secret, characters, and how many of them differ at least.
const SECRET: (usize, usize) = (16, 8);
/// Largest file of one, bytes.
const LARGEST_SECRET: u64 = 1 << 16;
/// Paths that are nowhere farther apart are one, metres.
const SAME_PATH: f64 = 1e-3;
/// Seeds without a world that are passed over, as many for each episode at most.
const PASSED_OVER: u64 = 20;

/// Writes both. A killed run is taken up.
pub fn task(args: &TaskArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let secret = secret(&args.secret)?;
    let (out, kept) = (OutputFolder::probe(&args.out)?, OutputFolder::probe(&args.truth)?);
    apart(out.path(), kept.path())?;
    let file: SceneFile = scene_file::read(&args.scene)?;
    file.check_simulated(&args.scene)?;
    if file.robot.path.stations() {
        return Err(TaskError::Undriven { scene: args.scene.clone() }.into());
    }
    let progress = Progress::detect();
    let (_out_lock, _kept_lock) = (out.lock(&progress)?, kept.lock(&progress)?);
    let scene = file.checked(&args.scene, &args.making.cache, &progress)?;
    let opened = open(args.making.renderer.into())?;
    if let Some(notice) = &opened.notice {
        progress.note(notice);
    }
    let scene_hash = scene_file::hash(&(scene.world(), scene.robot(), scene.sensors()))?;
    is_free(out.path(), TASK, args.episodes)?;
    is_free(kept.path(), SEALED, args.episodes)?;
    if let Ok((there, _)) = Sealed::read(kept.path()) {
        let own = (&*file.name, &*scene_hash, args.association, &*secret, args.episodes);
        let Sealed { scene, scene_hash, association, secret, episodes, .. } = &there;
        if (&**scene, &**scene_hash, *association, &**secret, episodes.len() as u64) != own {
            return Err(TaskError::Taken { path: kept.path().join(SEALED) }.into());
        }
    }
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
        let seed = drawn(&secret, &scene_hash, args.association, draw);
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
    if is_one_path(&kept, episodes.len())? {
        progress.note(
            "warning: the robot drives the same path in all episodes, and whoever runs the scene knows it; choose a scene whose path varies \
             with the seed (docs/tasks.md)",
        );
    }
    let sealed = Sealed {
        format: FORMAT,
        scene: file.name.clone(),
        scene_hash,
        association: args.association,
        secret,
        episodes,
    };
    let classes = classes(&scene);
    let bytes = serde_json::to_vec_pretty(&sealed)?;
    kept.write(SEALED, &bytes)?;
    let task = Task {
        format: FORMAT,
        scene: file.name,
        association: args.association,
        episodes: args.episodes,
        classes,
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

/// What seeds are drawn from.
fn secret(path: &Path) -> Result<String, TaskError> {
    let read = read_regular(path, LARGEST_SECRET);
    let bytes = read.map_err(|source| TaskError::Read { path: path.to_owned(), source })?;
    let secret = String::from_utf8_lossy(&bytes).trim().to_owned();
    let (length, found) = (secret.chars().count(), secret.chars().collect::<BTreeSet<char>>().len());
    match length >= SECRET.0 && found >= SECRET.1 {
        true => Ok(secret),
        false => Err(TaskError::Secret { path: path.to_owned(), length, found }),
    }
}

/// Refuses a folder that holds anything but this task: a file of the name `own`, and episodes, whole or under way.
fn is_free(folder: &Path, own: &str, episodes: u64) -> Result<(), TaskError> {
    let entries =
        std::fs::read_dir(folder).map_err(|source| TaskError::Read { path: folder.to_owned(), source })?;
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let number = name.strip_suffix(".partial").unwrap_or(&name).parse::<u64>().ok();
        let is_published = own == TASK;
        let is_ours = name == own
            || (!is_published && name == SET_ASIDE)
            || FolderLock::is_named(path.file_name().unwrap_or_default())
            || number
                .is_some_and(|number| number < episodes && !(is_published && path.join("truth").exists()));
        if !is_ours {
            return Err(TaskError::Taken { path });
        }
    }
    Ok(())
}

/// Whether the first two episodes drive one path.
fn is_one_path(kept: &OutputFolder, episodes: usize) -> Result<bool, BenchError> {
    if episodes < 2 {
        return Ok(false);
    }
    let path = |number: usize| read_truth(&kept.path().join(number.to_string()));
    let (a, b) = (path(0)?.world_from_robot, path(1)?.world_from_robot);
    let apart = |(a, b): (&Pose, &Pose)| (a.translation.vector - b.translation.vector).norm();
    Ok(a.len() == b.len() && a.iter().zip(&b).map(apart).all(|apart| apart < SAME_PATH))
}

/// Families, and categories of meshes.
fn classes(scene: &CheckedScene) -> Vec<String> {
    let families = scene.world().families.iter().map(|family| family.name().to_owned());
    let categories = scene.meshes().iter().map(|mesh| mesh.category.clone());
    let classes: BTreeSet<String> = families.chain(categories).collect();
    classes.into_iter().collect()
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
