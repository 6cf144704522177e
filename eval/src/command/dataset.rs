//! `bench dataset SCENE --out DIR`: episodes as files, one at a time in memory.

use crate::cli::{DatasetArgs, DatasetFormat};
use crate::exit::{BenchError, Exit};
use crate::output::{OutputError, OutputFolder};
use crate::pipeline::{SIMULATED, concerns_one_seed};
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use crate::trajectory::Trajectory;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use vantage_dataset::store::{Provenance, StoreError, verify, write_episode, write_g2o};
use vantage_dataset::{Seed, Split};
use vantage_sim::render::Renderer;
use vantage_sim::render::choice::open;
use vantage_sim::rollout::roll_out;
use vantage_sim::scene::CheckedScene;
use vantage_sim::simulate;
use vantage_slam::initial::dead_reckoning;

/// Writes every format of every seed below `args.out`; episode folders that are there, whole and of this scene are kept. A
/// seed without a world is told of and left out; if none has one, that is the error.
pub fn dataset(args: &DatasetArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let file: SceneFile = scene_file::read(&args.scene)?;
    let scene = file.checked(&args.scene)?;
    let progress = Progress::detect();
    let opened = open(args.renderer.into())?;
    if let Some(notice) = &opened.notice {
        progress.note(notice);
    }
    let mut provenance: Provenance = BTreeMap::from([
        ("scene".to_owned(), file.name.clone().into()),
        ("scene_hash".to_owned(), scene_file::hash(&(scene.world(), scene.robot(), scene.sensors()))?.into()),
        ("renderer".to_owned(), serde_json::to_value(opened.renderer.info())?),
        ("code".to_owned(), SIMULATED.into()),
    ]);
    if !scene.meshes().is_empty() {
        provenance.insert("meshes".to_owned(), serde_json::to_value(scene.meshes())?);
    }
    let mut writer = Writer { scene: &scene, out: &out, provenance, renderer: opened.renderer };
    let seeds = match args.seeds {
        Some(count) => (0..count).map(Seed).collect(),
        None => file.evaluation.seeds.as_slice().to_vec(),
    };
    let stage = progress.stage("episodes", seeds.len() as u64);
    let (mut written, mut kept, mut failure) = (0, 0, None);
    for seed in seeds {
        match writer.write(seed, &args.format) {
            Ok(true) => written += 1,
            Ok(false) => kept += 1,
            Err(BenchError::Sim(error)) if concerns_one_seed(&error) => {
                progress.note(&format!("seed {} is left out: {error}", seed.0));
                failure = Some(error);
            }
            Err(error) => return Err(error),
        }
        stage.advance(1);
    }
    drop(stage);
    writeln!(stdout, "{written} episodes written to {}, {kept} already there", out.path().display())?;
    match failure {
        Some(error) if written + kept == 0 => Err(error.into()),
        _ => Ok(Exit::Success),
    }
}

struct Writer<'a> {
    scene: &'a CheckedScene,
    out: &'a OutputFolder,
    provenance: Provenance,
    renderer: Box<dyn Renderer>,
}

impl Writer<'_> {
    /// Writes a seed; whether there was anything to write.
    fn write(&mut self, seed: Seed, formats: &[DatasetFormat]) -> Result<bool, BenchError> {
        let mut written = false;
        for format in formats {
            written |= match format {
                DatasetFormat::Vantage => self.write_episode(seed)?,
                DatasetFormat::Tum => self.write_trajectories(seed)?,
                DatasetFormat::G2o => self.write_graph(seed)?,
            };
        }
        Ok(written)
    }

    fn write_episode(&mut self, seed: Seed) -> Result<bool, BenchError> {
        let folder = self.out.path().join(seed.0.to_string());
        match verify(&folder) {
            Ok(manifest) if manifest.provenance == self.provenance => return Ok(false),
            Err(error @ StoreError::Newer { .. }) => return Err(error.into()),
            _ if is_foreign(&folder) => return Err(BenchError::NotOurs { folder }),
            _ => {}
        }
        let episode = simulate(self.scene, seed, Split::Test, self.renderer.as_mut(), &mut |_| {})?;
        let partial = self.out.path().join(format!("{}.partial", seed.0));
        let cannot = |source| OutputError { path: folder.clone(), source };
        remove(&partial).map_err(cannot)?;
        write_episode(&partial, &episode, self.provenance.clone())?;
        remove(&folder).map_err(cannot)?;
        fs::rename(&partial, &folder).map_err(cannot)?;
        Ok(true)
    }

    fn write_trajectories(&self, seed: Seed) -> Result<bool, BenchError> {
        let rollout = roll_out(self.scene, seed, Split::Test, &mut |_| {})?;
        let by_odometry = dead_reckoning(rollout.drive.timestamps.len(), &rollout.odometry);
        for (name, poses) in [("truth", rollout.drive.world_from_robot), ("odometry", by_odometry)] {
            let trajectory = Trajectory::new(rollout.drive.timestamps.clone(), poses)?;
            self.out.write_trajectory(format!("tum/{}/{name}.tum", seed.0), &trajectory)?;
        }
        Ok(true)
    }

    fn write_graph(&self, seed: Seed) -> Result<bool, BenchError> {
        let rollout = roll_out(self.scene, seed, Split::Test, &mut |_| {})?;
        let initial = dead_reckoning(rollout.drive.timestamps.len(), &rollout.odometry);
        self.out.write_with(format!("g2o/{}.g2o", seed.0), |path| {
            write_g2o(path, &initial, &rollout.odometry).map(drop)
        })?;
        Ok(true)
    }
}

/// Whether a folder has something in it, and not what every episode has.
fn is_foreign(folder: &Path) -> bool {
    let holds_any = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    holds_any && !folder.join("odometry.csv").exists() || folder.is_file()
}

fn remove(folder: &Path) -> std::io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
