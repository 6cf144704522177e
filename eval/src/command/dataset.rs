//! `bench dataset SCENE --out DIR`: episodes as files, one at a time in memory.

use crate::cli::{DatasetArgs, DatasetFormat};
use crate::exit::{BenchError, Exit};
use crate::output::{OutputError, OutputFolder};
use crate::progress::Progress;
use crate::scene_file::{self, SceneFile};
use crate::trajectory::Trajectory;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use vantage_dataset::store::{Provenance, verify, write_episode, write_g2o};
use vantage_dataset::{Seed, Split};
use vantage_sim::episode::roll_out;
use vantage_sim::render::choice::open;
use vantage_sim::scene::CheckedScene;
use vantage_sim::simulate;
use vantage_slam::initial::dead_reckoning;

/// Writes every format of every seed below `args.out`; episode folders that are there, whole and of this scene are kept.
pub fn dataset(args: &DatasetArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let out = OutputFolder::probe(&args.out)?;
    let file: SceneFile = scene_file::read(&args.scene)?;
    let scene = file.checked()?;
    let progress = Progress::detect();
    let opened = open(args.renderer.into())?;
    if let Some(notice) = &opened.notice {
        progress.note(notice);
    }
    let mut renderer = opened.renderer;
    let provenance: Provenance = BTreeMap::from([
        ("scene".to_owned(), file.name.clone().into()),
        ("scene_hash".to_owned(), scene_file::hash(&(scene.world(), scene.robot(), scene.sensors()))?.into()),
        ("renderer".to_owned(), serde_json::to_value(renderer.info())?),
    ]);
    let seeds = match args.seeds {
        Some(count) => (0..count).map(Seed).collect(),
        None => file.evaluation.seeds.as_slice().to_vec(),
    };
    let stage = progress.stage("episodes", seeds.len() as u64);
    let (mut written, mut kept) = (0, 0);
    let wants = |format| args.format.contains(&format);
    for seed in seeds {
        write_graphs(&scene, seed, &out, wants(DatasetFormat::Tum), wants(DatasetFormat::G2o))?;
        let folder = out.path().join(seed.0.to_string());
        if !wants(DatasetFormat::Vantage) {
            written += 1;
        } else if is_whole(&folder, &provenance) {
            kept += 1;
        } else {
            let episode = simulate(&scene, seed, Split::Test, renderer.as_mut(), &mut |_| {})?;
            let partial = out.path().join(format!("{}.partial", seed.0));
            let cannot = |source| OutputError { path: folder.clone(), source };
            remove(&partial).map_err(cannot)?;
            write_episode(&partial, &episode, provenance.clone())?;
            remove(&folder).map_err(cannot)?;
            fs::rename(&partial, &folder).map_err(cannot)?;
            written += 1;
        }
        stage.advance(1);
    }
    drop(stage);
    writeln!(stdout, "{written} episodes written to {}, {kept} already there", out.path().display())?;
    Ok(Exit::Success)
}

/// What needs no renderer: trajectories and the pose graph of odometry.
fn write_graphs(
    scene: &CheckedScene,
    seed: Seed,
    out: &OutputFolder,
    tum: bool,
    g2o: bool,
) -> Result<(), BenchError> {
    if !tum && !g2o {
        return Ok(());
    }
    let rollout = roll_out(scene, seed, Split::Test, &mut |_| {})?;
    let drive = &rollout.drive;
    let by_odometry = dead_reckoning(drive.timestamps.len(), &rollout.odometry);
    if tum {
        for (name, poses) in [("truth", &drive.world_from_robot), ("odometry", &by_odometry)] {
            let trajectory = Trajectory::new(drive.timestamps.clone(), poses.clone())?;
            out.write_trajectory(format!("tum/{}/{name}.tum", seed.0), &trajectory)?;
        }
    }
    if g2o {
        out.write_with(format!("g2o/{}.g2o", seed.0), |path| {
            write_g2o(path, &by_odometry, &rollout.odometry).map(drop)
        })?;
    }
    Ok(())
}

fn is_whole(folder: &Path, provenance: &Provenance) -> bool {
    verify(folder).is_ok_and(|manifest| manifest.provenance == *provenance)
}

fn remove(folder: &Path) -> std::io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
